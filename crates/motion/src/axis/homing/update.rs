//! One update of an axis that homing moves: its legs, corners and events at their instants within the update.
//!
//! Not here: which leg comes next ([`super`]). Units: position units, seconds. Nothing allocates; the work of an update is
//! bounded.

use arcline_drive::Drive;
use arcline_planner::Clock;
use arcline_planner::profile::Profile;
use arcline_profile::KinematicState;

use super::{Sought, Stage};
use crate::axis::Axis;
use crate::axis::generator::Law;
use crate::axis::sum::Slot;

/// Legs and corners of their profiles within one update; what is left then is done in the next one.
const MOST_STEPS: usize = 64;
/// A step shorter than this, seconds, is made together with the next one.
const SHORTEST_STEP: f64 = 1e-9;
/// Bisections of the instant of an event: to the last bit of an update.
const BISECTIONS: usize = 60;

impl Axis {
    /// One update of an axis that homing moves: command and drive at the present tick.
    pub(crate) fn advance_homing(&mut self, clock: &Clock) {
        if !self.is_driven_home() {
            return;
        }
        let began = Clock::at(clock.tick.saturating_sub(1), clock.period_ns);
        let period = clock.period();
        // Seconds of this update that the command and the drive have behind them.
        let (mut at, mut driven_to) = (0.0, 0.0);
        let mut ended = false;
        for _ in 0..MOST_STEPS {
            let Some(leg) = self.present_leg(&began) else {
                break;
            };
            let stage = self.homing.map(|homing| homing.stage);
            let seeks = matches!(stage, Some(Stage::Seeking { .. }));
            if !seeks && leg.end() <= at + SHORTEST_STEP {
                at = leg.end().clamp(at, period);
                self.pose(leg.last());
                if self.leg_is_over(began.now().after(at, clock)) {
                    ended = true;
                    break;
                }
                continue;
            }
            if at >= period {
                break;
            }
            let until = leg.next_corner(at + SHORTEST_STEP).min(period);
            let cycled = |mut drive: Drive, until: f64| {
                if until - driven_to >= SHORTEST_STEP {
                    drive.cycle(leg.at(until), until - driven_to);
                }
                drive
            };
            // A step too short for the drive is a straight one.
            let actual = |until: f64| {
                let now = self.drive.actual();
                match until - driven_to {
                    short if short < SHORTEST_STEP => now.position + short * now.velocity,
                    _ => cycled(self.drive, until).actual().position,
                }
            };
            let mut next = cycled(self.drive, until);
            let mut reached = until;
            let mut event = None;
            if let Some(Stage::Seeking { place, direction, .. }) = stage {
                let place = place + self.redefined;
                let passed = |position: f64| direction * (position - place) >= 0.0;
                if passed(actual(at)) {
                    (next, reached, event) = (self.drive, at, Some(at));
                } else if passed(next.actual().position) {
                    let (mut before, mut behind) = (at, until);
                    for _ in 0..BISECTIONS {
                        let middle = 0.5 * (before + behind);
                        if passed(actual(middle)) {
                            behind = middle;
                        } else {
                            before = middle;
                        }
                    }
                    reached = behind.max(at);
                    next = cycled(self.drive, reached);
                    event = Some(reached);
                }
            }
            if reached - driven_to >= SHORTEST_STEP {
                driven_to = reached;
            }
            at = reached;
            let command = leg.at(at);
            self.drive = next;
            self.actual = self.drive.actual();
            self.pose(command);
            if event.is_some()
                && matches!(
                    stage,
                    Some(Stage::Seeking {
                        sought: Sought::Stop,
                        ..
                    })
                )
            {
                // The mechanical stop: nothing moves on, and the command goes back to where the axis is held.
                self.drive.halt();
                self.actual = self.drive.actual();
                self.pose(KinematicState {
                    position: self.drive.actual().position,
                    ..KinematicState::default()
                });
            }
            if let Some(at) = event {
                self.place_is_reached(began.now().after(at, clock));
            }
        }
        if ended {
            self.end(Slot::Home);
        }
        if period - driven_to >= SHORTEST_STEP {
            self.drive.cycle(self.command, period - driven_to);
        }
        self.followed = true;
        self.home_reached = ended;
    }

    fn present_leg(&self, began: &Clock) -> Option<Leg> {
        let generator = self.sum.get(Slot::Home)?;
        let Law::Planned { profile, start } = &generator.law else {
            return None;
        };
        Some(Leg {
            profile: *profile,
            elapsed: start.elapsed(began),
            frame: self.sum.seen_from(Slot::Home, Some(0.0))?,
        })
    }

    /// The command is that of a leg, in positions of the axis.
    fn pose(&mut self, mut command: KinematicState) {
        let frame = self.sum.seen_from(Slot::Home, Some(0.0)).unwrap_or_default();
        command.position -= frame;
        self.sum.set(Slot::Home, command);
        self.command = self.sum.command();
    }
}

/// A leg as an update sees it: times are seconds since the update began.
struct Leg {
    profile: Profile,
    /// How long the leg had been under way when the update began; negative when it began within it.
    elapsed: f64,
    /// Added to positions of the profile.
    frame: f64,
}

impl Leg {
    fn at(&self, seconds: f64) -> KinematicState {
        self.profile.at(self.elapsed + seconds) + self.frame
    }

    /// Its end, to the last bit.
    fn last(&self) -> KinematicState {
        self.at(f64::INFINITY)
    }

    fn end(&self) -> f64 {
        self.profile.duration() - self.elapsed
    }

    /// The first corner of the profile behind an instant: between two, the command is a parabola.
    fn next_corner(&self, from: f64) -> f64 {
        let corners = self.profile.segment_times().iter().map(|time| time - self.elapsed);
        let next = corners.chain([self.end()]).find(|corner| *corner > from);
        next.unwrap_or(f64::INFINITY)
    }
}
