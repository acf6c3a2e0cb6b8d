//! The end of the motion of one axis together with its instructions: at once, or by a stop.
//!
//! Not here: the profiles of stops ([`super::braking`]), and the transforms and coordinate systems that move the axis too
//! (`crate::motion`). Real-time: nothing allocates.

use arcline_planner::Clock;
use arcline_planner::profile::Limits;
use arcline_profile::KinematicState;

use super::generator_kind::GeneratorKind;
use super::state::AxisState;
use super::{AfterStop, Axis};
use crate::control::Controls;
use crate::execution::Execution;

impl Axis {
    /// Ends one generator without PC.
    pub(crate) fn end_generator(&mut self, kind: GeneratorKind, controls: &mut Controls) {
        if let Some(ended) = self.end(kind)
            && let Some(execution) = ended.execution
        {
            controls.end_move(execution, 0);
        }
    }

    /// Ends every generator without PC. The caller has cancelled the transforms that the axis is part of.
    pub(crate) fn end_generators(&mut self, controls: &mut Controls) {
        self.end_pending_cams(None, controls);
        for kind in GeneratorKind::ALL {
            self.end_generator(kind, controls);
        }
    }

    /// Ends the pending cams of one kind, or of both kinds, without PC.
    pub(crate) fn end_pending_cams(&mut self, only: Option<GeneratorKind>, controls: &mut Controls) {
        for kind in Axis::CAMS {
            if only.is_none_or(|only| only == kind)
                && let Some(pending) = self.cams_mut(kind).pending.take()
            {
                controls.end_move(pending.execution, 0);
            }
        }
    }

    /// Ends the motion of all single-axis instructions, except of one kind.
    pub(crate) fn end_single_axis(&mut self, but: Option<GeneratorKind>, controls: &mut Controls) {
        self.end_pending_cams(None, controls);
        for kind in GeneratorKind::ALL {
            if kind.is_single_axis() && but != Some(kind) {
                self.end_generator(kind, controls);
            }
        }
    }

    /// Ends homing that does not move the axis, without PC.
    pub(crate) fn end_passive_homing(&mut self, controls: &mut Controls) {
        if let Some(execution) = self.take_passive_homing() {
            controls.end_move(execution, 0);
        }
    }

    /// Ends the instructions of some kinds of generators without PC; the caller ends the generators.
    pub(crate) fn end_instructions(&self, of: impl Fn(GeneratorKind) -> bool, controls: &mut Controls) {
        for kind in GeneratorKind::ALL.into_iter().filter(|kind| of(*kind)) {
            if let Some(execution) = self.sum.get(kind).and_then(|generator| generator.execution) {
                controls.end_move(execution, 0);
            }
        }
    }

    /// Ends all motion of the axis without PC; the axis stands at a position.
    pub(crate) fn end_all_motion(&mut self, position: f64, controls: &mut Controls) {
        self.end_passive_homing(controls);
        self.end_pending_cams(None, controls);
        self.end_instructions(|_| true, controls);
        self.sum.set_position(position);
        self.command = KinematicState::at_rest(position);
    }

    /// Stops all motion of the axis by one deceleration; `execution` completes when the axis stands. The caller has ended
    /// coordinated motion and transforms.
    pub(crate) fn stop_all(
        &mut self,
        limits: &Limits,
        execution: Option<Execution>,
        controls: &mut Controls,
        clock: &Clock,
    ) {
        self.end_instructions(|_| true, controls);
        self.brake_all(limits, execution, clock.now());
        self.stale = true;
    }

    /// As [`Axis::stop_all`] at the axis's own maxima, but without coordinated motion and the remaining motion of cancelled transforms,
    /// which have stops of their own. The end of this stop is not reported. Returns true if a generator brakes.
    pub(crate) fn stop_own(&mut self, controls: &mut Controls, clock: &Clock) -> bool {
        self.end_passive_homing(controls);
        self.end_pending_cams(None, controls);
        let own = || self.sum.active().filter(|(kind, _)| kind.is_own());
        if own().next().is_none() {
            return false;
        }
        let s_curve = own().any(|(_, generator)| generator.s_curve);
        let limits = self.dynamics.stop(s_curve);
        self.end_instructions(GeneratorKind::is_own, controls);
        self.brake_own(&limits, clock.now());
        self.stale = true;
        true
    }

    /// Brakes one generator and ends its instruction; `execution` completes when the generator stands.
    pub(crate) fn stop_generator(
        &mut self,
        kind: GeneratorKind,
        limits: &Limits,
        execution: Option<Execution>,
        controls: &mut Controls,
        clock: &Clock,
    ) {
        let Some(generator) = self.sum.get(kind) else {
            return;
        };
        if let Some(ended) = generator.execution {
            controls.end_move(ended, 0);
        }
        self.brake(kind, limits, execution, clock.now());
        self.stale = true;
    }

    /// As [`Axis::stop_generator`] for a generator that is not stopping yet. If its own profile comes to rest sooner, the generator
    /// continues on that profile; a stop that is under way keeps its report.
    pub(crate) fn stop_generator_soonest(
        &mut self,
        kind: GeneratorKind,
        limits: &Limits,
        controls: &mut Controls,
        clock: &Clock,
    ) {
        let Some(generator) = self.sum.get(kind) else {
            return;
        };
        let reports = generator.execution.filter(|_| generator.stopping);
        let ended = generator.execution.filter(|_| !generator.stopping);
        let own = generator.timed(clock);
        let sooner = own.is_some()
            && generator
                .soonest(own, generator.now, limits, self.dynamics_bits)
                .is_none();
        if let Some(ended) = ended {
            controls.end_move(ended, 0);
        }
        if sooner {
            self.let_rest(kind, reports);
        } else {
            self.brake(kind, limits, reports, clock.now());
        }
        self.stale = true;
    }

    /// Stops the jog that an instruction began, at full deceleration, and makes the stops that are under way as hard. The
    /// instruction of the jog ends. A jog of another instruction goes on.
    pub(crate) fn end_jog(&mut self, began: impl Fn(Execution) -> bool, controls: &mut Controls, clock: &Clock) {
        for kind in [GeneratorKind::Jog, GeneratorKind::Stop] {
            let Some(generator) = self.sum.get(kind) else {
                continue;
            };
            let own = generator.execution.is_some_and(&began);
            let (stopping, execution) = (generator.stopping, generator.execution);
            let limits = self.dynamics.stop(generator.s_curve);
            if stopping {
                self.brake(kind, &limits, execution, clock.now());
                self.stale = true;
            } else if own {
                self.stop_generator(kind, &limits, None, controls, clock);
            }
        }
    }

    /// Switches the axis off, or shuts it down, when it stands after a stop that asks for it.
    pub(crate) fn act_after_stop(&mut self, after: AfterStop) {
        match after {
            AfterStop::Hold => {}
            AfterStop::Disable if self.is_virtual => {}
            AfterStop::Disable => {
                if matches!(self.state, AxisState::Running | AxisState::Starting) {
                    self.disable(AxisState::Stopped);
                }
            }
            AfterStop::Shutdown => self.disable(AxisState::Shutdown),
        }
    }

    /// Disarms registrations, the watch position and output cams; their instructions end without PC.
    pub(crate) fn disarm(&mut self, controls: &mut Controls) {
        let [first, second] = &mut self.registrations;
        for execution in [self.watch.disarm(), first.disarm(), second.disarm()]
            .into_iter()
            .flatten()
        {
            controls.end_move(execution, 0);
        }
        for target in 0..self.outputs.len() {
            self.disarm_output(target, controls);
        }
    }

    /// Disarms all output cams of an execution target; its bits keep their values.
    pub(crate) fn disarm_output(&mut self, target: usize, controls: &mut Controls) {
        for execution in self.outputs.disarm(target).into_iter().flatten() {
            controls.end_move(execution, 0);
        }
    }
}
