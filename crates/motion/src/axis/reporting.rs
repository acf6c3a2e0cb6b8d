//! The reports of the instructions of one axis: ACCEL, DECEL and PC of its motion, its cams, registrations and watch position.
//!
//! Real-time: nothing allocates; bounded by the kinds of generators.

use arcline_drive::{REGISTRATION_LATCHES, Trigger};
use arcline_instruction_set::Flag;
use arcline_planner::Clock;
use arcline_profile::KinematicState;

use super::Axis;
use super::generator::Equation;
use super::generator_kind::GeneratorKind;
use crate::control::{Controls, phase_flags};
use crate::events::MoveEvents;
use crate::masters::cam::Cam;

impl Axis {
    /// ACCEL and DECEL of generators under way, and PC of those at their end. Homing reports its own end.
    pub(crate) fn report(&mut self, controls: &mut Controls, clock: &Clock) {
        let is_driven_home = self.is_driven_home();
        let mut last = None;
        while let Some(kind) = self.next_to_report(last) {
            last = Some(kind);
            if Axis::CAMS.contains(&kind) {
                self.report_cam(kind, controls);
            }
            if !self.sum.is_active(kind) || kind == GeneratorKind::Home && is_driven_home {
                continue;
            }
            if kind == GeneratorKind::MasterOffset && self.cam(GeneratorKind::PositionCam).is_none() {
                // The cam that the offset acts on has ended.
                self.end_generator(kind, controls);
                continue;
            }
            let Some(generator) = self.sum.get_mut(kind) else {
                continue;
            };
            let phase = generator.phase(clock);
            let tracking = generator.is_tracking(clock) && !generator.stopping;
            let tracks = std::mem::replace(&mut generator.shown_tracking, tracking) != tracking;
            let changed = std::mem::replace(&mut generator.shown_phase, phase) != phase;
            let (execution, stopping, over) = (generator.execution, generator.stopping, generator.over);
            if over {
                self.end(kind);
                if let Some(execution) = execution {
                    controls.end_move(execution, Flag::Pc.mask());
                }
                if kind == GeneratorKind::Stop {
                    let after = std::mem::take(&mut self.after_stop);
                    self.act_after_stop(after);
                }
            } else if let Some(execution) = execution
                && !stopping
            {
                if tracks {
                    controls.flag(execution, Flag::TrackingMaster, tracking);
                }
                self.calculate_move(kind, controls, clock);
                if !changed {
                    continue;
                }
                let (set, clear) = phase_flags(phase);
                controls.write(execution, set, clear);
            }
        }
    }

    /// Writes SEGMENT of a cam, and PC of the cam that it has replaced.
    fn report_cam(&mut self, kind: GeneratorKind, controls: &mut Controls) {
        if let Some(ended) = self.cams_mut(kind).ended.take() {
            controls.end_move(ended, Flag::Pc.mask());
        }
        let Some(segment) = self.cam(kind).map(Cam::segment) else {
            return;
        };
        if let Some(generator) = self.sum.get_mut(kind)
            && std::mem::replace(&mut generator.shown_segment, segment) != segment
            && let Some(execution) = generator.execution
        {
            controls.set_segment(execution, segment as i32);
        }
    }

    /// Calculates the answers to Event Distance of a move, when they are due.
    pub(crate) fn calculate_move(&mut self, kind: GeneratorKind, controls: &mut Controls, clock: &Clock) {
        let Some(generator) = self.sum.get_mut(kind) else {
            return;
        };
        let own = generator.clock(clock);
        let due = |events: &MoveEvents| events.due.is_some_and(|due| due <= clock.tick);
        let (Some(execution), Equation::Planned { profile, start }) = (generator.execution, &generator.equation) else {
            return;
        };
        let Some(events) = generator.events.as_mut().filter(|events| due(events)) else {
            return;
        };
        events.due = None;
        if events.answer(profile, *start, &own) {
            let events = events.events;
            controls.give(execution, &events);
        }
    }

    /// Registration inputs of the drive whose latches have closed.
    pub(crate) fn take_registrations(&mut self, controls: &mut Controls, clock: &Clock) {
        let (period, now) = (clock.period_ns, clock.tick.wrapping_mul(clock.period_ns));
        for (input, latch_index) in REGISTRATION_LATCHES.into_iter().enumerate() {
            let (Some(latch), Some(armed)) = (
                self.link.feedback.latches[latch_index],
                self.registrations[input].latch(),
            ) else {
                continue;
            };
            if latch.number != armed.number {
                continue;
            }
            let before = (latch.before_end_s / clock.period() * period as f64) as u64;
            let time = (now.saturating_sub(before) / 1000) as i32;
            let position = self.shown(self.latched_at(latch.position));
            let positive = armed.trigger == Trigger::RegistrationOn;
            match self.registrations[input].edge(positive, position, time) {
                Some(execution) => controls.end_move(execution, Flag::Pc.mask()),
                None => {
                    let again = self.link.arm(armed.trigger, false);
                    self.registrations[input].arm_again(again);
                }
            }
        }
    }

    /// The actual motion without the offset of redefined positions.
    pub(crate) fn watched_motion(&self) -> KinematicState {
        KinematicState {
            position: self.actual.position - self.redefined,
            ..self.actual
        }
    }

    /// Ends the watch when the actual position passes the watched one.
    pub(crate) fn check_watch(&mut self, controls: &mut Controls, clock: &Clock) {
        // An axis that is fed goes in straight lines.
        let period = if self.feeding.is_some() { 0.0 } else { clock.period() };
        if let Some(execution) = self.watch.check(self.watched_motion(), period) {
            controls.end_move(execution, Flag::Pc.mask());
        }
    }
}
