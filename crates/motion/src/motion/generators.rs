//! What moves single axes from one tick to the next, and how it ends.
//!
//! Real-time: no allocation; bounded by the axes.

use arcline_instruction_set::{AxisId, Flag};
use arcline_planner::profile::Limits;

use super::Motion;
use crate::axis::generator::Equation;
use crate::axis::generator_kind::GeneratorKind;
use crate::axis::state::AxisState;
use crate::axis::{AfterStop, Axis};
use crate::events::MoveEvents;
use crate::execution::Execution;
use crate::masters::cam::Cam;
use crate::status::phase_flags;

impl Motion {
    /// Commands of all axes at the present tick.
    pub(super) fn advance_axes(&mut self) {
        if !self.order.is_empty() {
            self.advance_followers();
            return;
        }
        for axis in self.axes.awake_mut() {
            axis.advance(&self.clock);
            axis.advance_homing(&self.clock);
        }
    }

    /// What instructions began at this tick shows in the commands of it. `changed`: coordinated motion began or changed.
    pub(super) fn refresh_axes(&mut self, mut changed: bool) {
        for index in self.axes.ids() {
            if self.axes[index].stale {
                self.axes[index].stale = false;
                changed = true;
                self.axes[index].advance(&self.clock);
                self.report_generators(index);
            }
        }
        if changed && !self.order.is_empty() {
            self.refresh_followers();
        }
    }

    /// Ends one generator of an axis without PC.
    pub(crate) fn end_generator(&mut self, axis: AxisId, kind: GeneratorKind) {
        if let Some(ended) = self.axes[axis].end(kind)
            && let Some(execution) = ended.execution
        {
            self.end_move(execution, 0);
        }
    }

    /// Ends the cams of an axis that wait for the end of others, without PC: of one kind, or of both.
    pub(crate) fn end_pending_cams(&mut self, axis: AxisId, only: Option<GeneratorKind>) {
        for kind in Axis::CAMS {
            if only.is_none_or(|only| only == kind)
                && let Some(pending) = self.axes[axis].cams_mut(kind).pending.take()
            {
                self.end_move(pending.execution, 0);
            }
        }
    }

    /// Ends what single-axis instructions began on an axis, but for one kind of it.
    pub(crate) fn end_single_axis(&mut self, axis: AxisId, but: Option<GeneratorKind>) {
        self.end_pending_cams(axis, None);
        for kind in GeneratorKind::ALL {
            if kind.is_single_axis() && but != Some(kind) {
                self.end_generator(axis, kind);
            }
        }
    }

    /// Ends everything on an axis without PC, and the transforms that it is part of.
    pub(crate) fn end_generators(&mut self, axis: AxisId) {
        self.cancel_transforms_of(axis);
        self.end_pending_cams(axis, None);
        for kind in GeneratorKind::ALL {
            self.end_generator(axis, kind);
        }
    }

    /// Stops everything on an axis as one deceleration at the axis's own maxima, and reports to `execution` when it
    /// stands. Coordinated motion must have been ended; transforms that the axis is part of are cancelled.
    pub(crate) fn stop_axis(&mut self, axis: AxisId, execution: Option<Execution>) {
        let state = &self.axes[axis];
        let limits = state.dynamics.stop(state.is_s_curve());
        self.stop_axis_at(axis, &limits, execution);
    }

    /// As [`Motion::stop_axis`], but for coordinated motion and for what cancelled transforms had moved: these brake by themselves.
    /// No instruction reports the end of the stop. Returns whether anything brakes.
    pub(crate) fn stop_own(&mut self, axis: AxisId) -> bool {
        self.end_passive_homing(axis);
        self.end_pending_cams(axis, None);
        let state = &self.axes[axis];
        let own = || state.sum.active().filter(|(kind, _)| kind.is_own());
        if own().next().is_none() {
            return false;
        }
        let s_curve = own().any(|(_, generator)| generator.s_curve);
        let limits = state.dynamics.stop(s_curve);
        for kind in GeneratorKind::ALL {
            if !kind.is_own() {
                continue;
            }
            if let Some(execution) = self.axes[axis].sum.get(kind).and_then(|generator| generator.execution) {
                self.end_move(execution, 0);
            }
        }
        self.axes[axis].brake_own(&limits, self.clock.now());
        self.axes[axis].stale = true;
        true
    }

    /// As [`Motion::stop_axis`], at given rates.
    pub(crate) fn stop_axis_at(&mut self, axis: AxisId, limits: &Limits, execution: Option<Execution>) {
        self.end_passive_homing(axis);
        self.end_pending_cams(axis, None);
        self.cancel_transforms_of(axis);
        if !self.axes[axis].in_motion() {
            // All that was to be stopped was a transform that did not move this axis.
            if let Some(execution) = execution {
                self.end_move(execution, Flag::Pc.mask());
            }
            return;
        }
        for kind in GeneratorKind::ALL {
            if let Some(execution) = self.axes[axis].sum.get(kind).and_then(|generator| generator.execution) {
                self.end_move(execution, 0);
            }
        }
        self.axes[axis].brake_all(limits, execution, self.clock.now());
        self.axes[axis].stale = true;
    }

    /// One generator of an axis brakes, and reports to `execution` when it stands. Its own instruction ends.
    pub(crate) fn stop_generator(
        &mut self,
        axis: AxisId,
        kind: GeneratorKind,
        limits: &Limits,
        execution: Option<Execution>,
    ) {
        let Some(generator) = self.axes[axis].sum.get(kind) else {
            return;
        };
        if let Some(ended) = generator.execution {
            self.end_move(ended, 0);
        }
        self.axes[axis].brake(kind, limits, execution, self.clock.now());
        self.axes[axis].stale = true;
    }

    /// As [`Motion::stop_generator`] for what is not being stopped; what comes to rest sooner by its own profile goes on with that,
    /// and a stop that is under way reports as before.
    pub(crate) fn stop_generator_soonest(&mut self, axis: AxisId, kind: GeneratorKind, limits: &Limits) {
        let Some(generator) = self.axes[axis].sum.get(kind) else {
            return;
        };
        let reports = generator.execution.filter(|_| generator.stopping);
        let ended = generator.execution.filter(|_| !generator.stopping);
        let own = generator.timed(&self.clock);
        let sooner = own.is_some()
            && generator
                .soonest(own, generator.now, limits, self.axes[axis].bounds)
                .is_none();
        if let Some(ended) = ended {
            self.end_move(ended, 0);
        }
        if sooner {
            self.axes[axis].let_rest(kind, reports);
        } else {
            self.axes[axis].brake(kind, limits, reports, self.clock.now());
        }
        self.axes[axis].stale = true;
    }

    /// What becomes of an axis that stands after a stop.
    pub(crate) fn act_after_stop(&mut self, axis: AxisId, after: AfterStop) {
        let state = &mut self.axes[axis];
        match after {
            AfterStop::Hold => {}
            AfterStop::Disable if state.is_virtual => {}
            AfterStop::Disable => {
                if matches!(state.state, AxisState::Running | AxisState::Starting) {
                    state.disable(AxisState::Stopped);
                }
            }
            AfterStop::Shutdown => state.disable(AxisState::Shutdown),
        }
    }

    /// The group's stop is over when every axis that it stopped is at rest.
    pub(super) fn finish_group_stop(&mut self) {
        let Some(stop) = self.group_stop else { return };
        let moves = |axis: &Axis| axis.is_stopping() || axis.actual.velocity != 0.0 && !axis.has_torque();
        let mut axes = self.axes.ids().zip(self.axes.iter());
        if !axes.any(|(index, axis)| stop.braking.contains(index) && moves(axis)) {
            self.group_stop = None;
            self.end_move(stop.execution, Flag::Pc.mask());
        }
    }

    /// Calculated Data of a move, when it is due.
    pub(crate) fn calculate_move(&mut self, axis: AxisId, kind: GeneratorKind) {
        let clock = self.clock;
        let Some(generator) = self.axes[axis].sum.get_mut(kind) else {
            return;
        };
        let own = generator.clock(&clock);
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
            self.give(execution, &events);
        }
    }

    /// ACCEL and DECEL of what is under way, and PC of what has come to its end. Homing tells its end by itself.
    pub(crate) fn report_generators(&mut self, axis: AxisId) {
        let tick = self.clock.tick;
        let is_driven_home = self.axes[axis].is_driven_home();
        let mut last = None;
        while let Some(kind) = self.axes[axis].next_to_report(last) {
            last = Some(kind);
            if Axis::CAMS.contains(&kind) {
                self.report_cam(axis, kind);
            }
            if !self.axes[axis].sum.is_active(kind) || kind == GeneratorKind::Home && is_driven_home {
                continue;
            }
            if kind == GeneratorKind::MasterOffset && self.axes[axis].cam(GeneratorKind::PositionCam).is_none() {
                // What it is an offset of is over.
                self.end_generator(axis, kind);
                continue;
            }
            let Some(generator) = self.axes[axis].sum.get_mut(kind) else {
                continue;
            };
            let phase = generator.phase(&self.clock);
            let tracking = generator.is_tracking(&self.clock) && !generator.stopping;
            let tracks = std::mem::replace(&mut generator.shown_tracking, tracking) != tracking;
            let changed = std::mem::replace(&mut generator.shown_phase, phase) != phase;
            let (execution, stopping, over) = (generator.execution, generator.stopping, generator.over);
            if over {
                self.axes[axis].end(kind);
                if let Some(execution) = execution {
                    self.end_move(execution, Flag::Pc.mask());
                }
                if kind == GeneratorKind::Stop {
                    let after = std::mem::take(&mut self.axes[axis].after_stop);
                    self.act_after_stop(axis, after);
                }
            } else if let Some(execution) = execution
                && !stopping
            {
                if tracks {
                    self.controls.flag(execution, Flag::TrackingMaster, tracking, tick);
                }
                self.calculate_move(axis, kind);
                if !changed {
                    continue;
                }
                let (set, clear) = phase_flags(phase);
                self.controls.write(execution, set, clear, tick);
            }
        }
    }

    /// PC of a cam that another one has taken over from, and SEGMENT.
    fn report_cam(&mut self, axis: AxisId, kind: GeneratorKind) {
        if let Some(ended) = self.axes[axis].cams_mut(kind).ended.take() {
            self.end_move(ended, Flag::Pc.mask());
        }
        let Some(segment) = self.axes[axis].cam(kind).map(Cam::segment) else {
            return;
        };
        if let Some(generator) = self.axes[axis].sum.get_mut(kind)
            && std::mem::replace(&mut generator.shown_segment, segment) != segment
            && let Some(execution) = generator.execution
        {
            self.controls.set_segment(execution, segment as i32, self.clock.tick);
        }
    }
}
