//! The owner of an axis's motion: coordinated moves take their axes, and aborted ones release them.
//!
//! Real-time: no allocation; bounded by the axes, the coordinate systems and the depth of their queues.

use arcline_instruction_set::{AxisId, Flag, SystemId};
use arcline_planner::profile::Limits;

use super::Motion;
use crate::axis::generator_kind::GeneratorKind;
use crate::stop::AxisSet;
use crate::system::Activity;

impl Motion {
    /// Cancels every pending move of a coordinate system; where none is active yet, it is at rest.
    pub(crate) fn cancel_pending(&mut self, index: SystemId) {
        while let Some(cancelled) = self.systems[index].travel.cancel_waiting() {
            self.end_move(cancelled.execution, 0);
        }
        let system = &mut self.systems[index];
        if system.activity != Activity::Stopping && system.travel.active().is_none() {
            self.retired.extend(system.travel.clear());
            self.rest_system(index);
        }
    }

    /// Ends the active move's instruction; the path is left to the caller.
    pub(crate) fn end_active(&mut self, index: SystemId) {
        if self.systems[index].activity == Activity::Moving
            && let Some(active) = self.systems[index].travel.detach_active()
        {
            self.end_move(active.execution, 0);
        }
    }

    /// Brakes the coordinated move of a system on its path, in time: a master leads it no more. Its instructions have ended.
    pub(crate) fn stop_on_path(&mut self, index: SystemId, limits: &Limits) {
        let tail = self.of_tail(index, limits);
        let system = &mut self.systems[index];
        if !system.is_busy() {
            return;
        }
        let base = system.time_base(&self.clock);
        system.travel.stop(limits, &base);
        if let Some(tail) = tail {
            system.travel.stop_tail(&tail, &self.clock);
        }
        system.follower = None;
        system.activity = Activity::Stopping;
        system.stale = true;
    }

    /// As [`Motion::stop_on_path`], for what a robot must not go on with: a contour brakes without waiting for room within the limits
    /// of the axes, a stop that is under way brakes no later than it would, and what comes to rest sooner by its own profile goes
    /// on with that.
    pub(crate) fn stop_on_path_at_once(&mut self, index: SystemId, limits: &Limits) {
        let system = &mut self.systems[index];
        if system.follower.is_some() {
            self.stop_on_path(index, limits);
            return;
        }
        if !system.is_busy() {
            return;
        }
        system.travel.stop_soonest(limits, &self.clock);
        system.activity = Activity::Stopping;
        system.stale = true;
    }

    /// Ends a running stop's instruction without PC.
    pub(crate) fn end_stop(&mut self, index: SystemId) {
        if let Some(stop) = self.systems[index].stop.take() {
            self.controls.write(stop.execution, 0, Flag::Ip.mask(), self.clock.tick);
        }
    }

    /// Ends all coordinated motion of a system at once. Its axes brake by themselves, but for those that
    /// `hold` says stand or are without torque. Returns the axes that brake.
    pub(crate) fn abort_system(&mut self, index: SystemId, hold: impl Fn(AxisId) -> bool) -> AxisSet {
        let mut braking = AxisSet::default();
        if !self.systems[index].is_busy() {
            return braking;
        }
        let system = &self.systems[index];
        let s_curve = system.is_s_curve();
        let before = system.travel.limits_in_force(&system.time_base(&self.clock));
        self.end_travel(index);
        for member in 0..self.systems[index].taken().len() {
            let axis = self.systems[index].taken()[member];
            let Some(state) = self.axes.get_mut(axis) else {
                continue;
            };
            if hold(axis) {
                state.release();
            } else {
                let limits = state.dynamics.stop(s_curve);
                if let Some(part) = state.sum.get_mut(GeneratorKind::System) {
                    part.in_force = before;
                }
                state.brake(GeneratorKind::System, &limits, None, self.clock.now());
                braking.insert(axis);
            }
        }
        self.systems[index].braking = braking;
        braking
    }

    /// Ends all moves of a system and their motion at once; the axes are left to the caller.
    pub(crate) fn end_travel(&mut self, index: SystemId) {
        self.cancel_pending(index);
        self.end_active(index);
        self.retired.extend(self.systems[index].travel.clear());
        self.rest_system(index);
    }

    /// Ends all coordinated motion of a system at once for another one that takes the axes they share; the
    /// rest of its axes brake.
    pub(crate) fn abort_system_but(&mut self, index: SystemId, taker: SystemId) {
        let mut taken = AxisSet::default();
        for axis in self.systems[taker].description.linear() {
            taken.insert(*axis);
        }
        self.abort_system(index, |axis| taken.contains(axis));
    }

    /// Takes an axis out of every motion: the systems that move it are aborted, their other axes brake.
    pub(crate) fn leave(&mut self, axis: AxisId) {
        for index in self.systems.ids() {
            if self.systems[index].has(axis) {
                self.end_stop(index);
                self.abort_system(index, |other| other == axis);
            }
        }
        self.end_generators(axis);
        self.end_passive_homing(axis);
    }

    /// Takes the axes of a system into its coordinated move, or on into the next one.
    pub(crate) fn join_axes(&mut self, index: SystemId) {
        let s_curve = self.systems[index].is_s_curve();
        let active = self.systems[index].active();
        let turns = active.is_some_and(|active| active.heading.is_some());
        let description = &self.systems[index].description;
        let taken = if turns {
            description.axes.len()
        } else {
            description.linear().len()
        };
        for member in 0..taken {
            let axis = self.systems[index].description.axes[member];
            let Some(axis) = self.axes.get_mut(axis) else {
                continue;
            };
            match axis.sum.get_mut(GeneratorKind::System) {
                Some(generator) if !generator.stopping => {
                    generator.s_curve = s_curve;
                    axis.mark_start();
                }
                _ => axis.join(s_curve),
            }
        }
    }

    /// Takes Rx, Ry, Rz of a system into the moves that wait: from now on what else turns them is added to where these lead.
    pub(crate) fn join_turned_axes(&mut self, index: SystemId, s_curve: bool) {
        for member in 0..self.systems[index].description.oriented().len() {
            let axis = self.systems[index].description.oriented()[member];
            if let Some(axis) = self.axes.get_mut(axis)
                && !axis.is_coordinated()
            {
                axis.join(s_curve);
            }
        }
    }

    /// Takes the axes of a system out of its coordinated move as they are.
    pub(crate) fn part_axes(&mut self, index: SystemId) {
        for member in 0..self.systems[index].taken().len() {
            let axis = self.systems[index].taken()[member];
            if let Some(axis) = self.axes.get_mut(axis) {
                axis.release();
            }
        }
    }

    /// Everything the system moved stands; nothing is active any more.
    pub(crate) fn release_axes(&mut self, index: SystemId) {
        self.rest_system(index);
        for member in 0..self.systems[index].taken().len() {
            let axis = self.systems[index].taken()[member];
            if let Some(axis) = self.axes.get_mut(axis)
                && axis.is_coordinated()
            {
                axis.release();
            }
        }
    }

    pub(crate) fn rest_system(&mut self, index: SystemId) {
        let system = &mut self.systems[index];
        system.activity = Activity::Idle;
        system.shown = system.shown.at_rest();
        system.follower = None;
        system.ended = None;
        system.stale = false;
    }
}
