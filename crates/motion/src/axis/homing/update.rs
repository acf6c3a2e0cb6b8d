//! One update of an axis that homing moves: its legs and latches at their instants within the update.
//!
//! Not here: the order of the legs ([`super`]). Units: position units, seconds. Nothing allocates; the work of an update is bounded.

use arcline_planner::Clock;
use arcline_planner::profile::Profile;
use arcline_profile::KinematicState;

use super::{HomingStep, Sought};
use crate::axis::Axis;
use crate::axis::generator::Equation;
use crate::axis::generator_kind::GeneratorKind;
use crate::tolerance::SHORTEST_STEP_S;

/// Legs within one update; the next update continues with the rest.
const MOST_LEGS: usize = 64;

impl Axis {
    /// The command at the present tick of an axis that homing moves: executes the legs that end before it, and the active one.
    pub(crate) fn advance_homing(&mut self, clock: &Clock) {
        // Called in every tick for every axis.
        if self.is_driven_home() {
            self.advance_legs(clock);
        }
    }

    fn advance_legs(&mut self, clock: &Clock) {
        let began = began(clock);
        // Seconds of this update that the legs so far have used.
        let mut at = 0.0;
        for _ in 0..MOST_LEGS {
            let Some(leg) = self.present_leg(&began) else {
                return;
            };
            if self.seeks() || leg.end() > clock.period() + SHORTEST_STEP_S {
                self.set_home_command(leg.at(clock.period()));
                return;
            }
            at = leg.end().clamp(at, clock.period());
            self.set_home_command(leg.last());
            if self.leg_is_over(began.now().after(at, clock)) {
                self.end(GeneratorKind::Home);
                self.home_reached = true;
                return;
            }
        }
    }

    /// Begins the leg after a latch that has closed: at the instant of the latch if that lies within the update, otherwise now.
    pub(crate) fn take_home_latch(&mut self, clock: &Clock) {
        if !self.is_driven_home() {
            return;
        }
        let began = began(clock);
        let (Some(latch), Some(leg)) = (self.closed_home_latch(), self.present_leg(&began)) else {
            return;
        };
        let within = clock.period() - latch.before_end_s;
        let at = if within < 0.0 {
            clock.period()
        } else {
            within.max(-leg.elapsed)
        };
        if self.seeks_stop() {
            // No leg follows: the command returns to the position at which the axis is held.
            self.set_home_command(KinematicState::at_rest(self.actual.position));
        } else {
            self.set_home_command(leg.at(at));
        }
        self.sought_is_reached(latch.position, began.now().after(at, clock));
        self.advance_homing(clock);
    }

    fn seeks(&self) -> bool {
        matches!(self.homing.map(|homing| homing.step), Some(HomingStep::Seeking { .. }))
    }

    fn seeks_stop(&self) -> bool {
        let step = self.homing.map(|homing| homing.step);
        matches!(
            step,
            Some(HomingStep::Seeking {
                sought: Sought::Stop,
                ..
            })
        )
    }

    fn present_leg(&self, began: &Clock) -> Option<Leg> {
        let generator = self.sum.get(GeneratorKind::Home)?;
        let Equation::Planned { profile, start } = &generator.equation else {
            return None;
        };
        Some(Leg {
            profile: *profile,
            elapsed: start.elapsed(began),
            frame: self.sum.seen_from(GeneratorKind::Home, Some(0.0))?,
        })
    }

    /// Sets the command from that of a leg, in positions of the axis.
    fn set_home_command(&mut self, mut command: KinematicState) {
        let frame = self.sum.seen_from(GeneratorKind::Home, Some(0.0)).unwrap_or_default();
        command.position -= frame;
        self.sum.set(GeneratorKind::Home, command);
        self.command = self.sum.command();
    }
}

/// The beginning of the update that ends at the present tick.
fn began(clock: &Clock) -> Clock {
    Clock::at(clock.tick.saturating_sub(1), clock.period_ns)
}

/// A leg in the time of an update: seconds since the update began.
struct Leg {
    profile: Profile,
    /// Time for which the leg had run when the update began; negative if it began within the update.
    elapsed: f64,
    /// Added to positions of the profile.
    frame: f64,
}

impl Leg {
    fn at(&self, seconds: f64) -> KinematicState {
        self.profile.at(self.elapsed + seconds) + self.frame
    }

    /// Its end state, exact to the last bit.
    fn last(&self) -> KinematicState {
        self.at(f64::INFINITY)
    }

    fn end(&self) -> f64 {
        self.profile.duration() - self.elapsed
    }
}
