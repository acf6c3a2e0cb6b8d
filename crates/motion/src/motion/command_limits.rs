//! The last step before set-points go out: no drive gets a command that its axis cannot follow
//! (spec/axis-and-data-types.md §12).
//!
//! The new set-point of every axis is compared with the last one that went out. One that asks for more than the axis's command
//! limits never goes out: the axis, and every axis that moves with it, brakes from its last good set-point, the axis faults, and
//! the refused command is reported. So a defect of a planner, a transform or a follower becomes a stop and not a jump. Not here:
//! limits of programs, which instructions and planners keep. Real-time: no allocation; bounded by the axes; after a refusal by
//! their square.

use arcline_instruction_set::{FaultKind, FaultSet};
use arcline_planner::Clock;
use arcline_profile::KinematicState;

use super::Motion;
use super::follow::masters_of_axis;
use crate::axis::Axis;
use crate::axis::sum::Slot;
use crate::cause::{Cause, RefusedCommand};
use crate::machine::CommandLimits;
use crate::stop::AxisSet;

impl Motion {
    /// Compares the new set-points with the last ones and replaces those that must not go out. To be called once a tick, when all
    /// commands are computed and before the exchange.
    pub(super) fn limit_commands(&mut self) {
        let mut refused = AxisSet::default();
        let mut first = None;
        for index in 0..self.axes.len() {
            let Some(command) = self.refused_command(index) else {
                continue;
            };
            let axis = index as u16;
            refused.insert(axis);
            first = first.or(Some(axis));
            self.axes[index].faults.refuse(command);
        }
        let Some(axis) = first else { return };
        let faults = FaultSet::default().with(FaultKind::CommandLimit);
        self.controls.because(Cause::Fault { axis, faults });
        self.brake_from_last_set_points(&self.moving_with(refused));
        self.controls.because(Cause::Itself);
    }

    /// The command of an axis at the present tick where it must not go out.
    fn refused_command(&mut self, index: usize) -> Option<RefusedCommand> {
        let (axis, last) = (&self.axes[index], &self.set_points[index]);
        let next = KinematicState {
            position: axis.command.position - axis.redefined,
            ..axis.command
        };
        if next.position == last.position && next.velocity == last.velocity {
            return None;
        }
        // A virtual axis has no drive that its set-points enable.
        let was_on = last.enable || (axis.is_virtual && self.clock.tick > 1);
        if !was_on || !axis.has_torque() || axis.feeding.is_some() {
            return None;
        }
        let before = [last.position, last.velocity];
        let limits = &axis.command_limits;
        let follows = || axis.follows_a_master() || self.systems.iter().any(|system| system.guides(index as u16));
        if limits.allow(before, &next, follows, axis, self.clock.period()) {
            return None;
        }
        let redefined = axis.redefined;
        let fastest = axis.sum.fastest();
        let execution = fastest.and_then(|(_, generator)| generator.execution);
        let source = fastest.map(|(slot, _)| slot);
        let execution = match source {
            Some(Slot::System) => {
                let mut systems = self.systems.iter_mut();
                let moving = systems.find(|system| system.is_busy() && system.has(index as u16));
                moving.and_then(|system| system.active()).map(|active| active.execution)
            }
            _ => execution,
        };
        Some(RefusedCommand {
            by: execution.map_or(Cause::Itself, Cause::from),
            source: source.map_or("no motion", Slot::name),
            last: [before[0] + redefined, before[1]],
            asked: [next.position + redefined, next.velocity],
        })
    }

    /// Some axes and every axis that moves with one of them: of a coordinate system that moves it, on either side of a transform,
    /// or after a master.
    fn moving_with(&self, mut axes: AxisSet) -> AxisSet {
        for _ in 0..self.axes.len() {
            let before = axes;
            for system in self.systems.iter().filter(|system| system.is_busy()) {
                axes.join(&system.description.axes);
            }
            for (_, transform) in self.transforms.iter() {
                if transform.axes().any(|axis| axes.contains(axis)) {
                    transform.axes().for_each(|axis| axes.insert(axis));
                }
            }
            for (index, axis) in self.axes.iter().enumerate() {
                if masters_of_axis(axis).any(|master| axes.contains(master)) {
                    axes.insert(index as u16);
                }
            }
            if axes == before {
                break;
            }
        }
        axes
    }

    /// Every motion of some axes ends; each axis brakes at its Maximum Deceleration from its last set-point.
    fn brake_from_last_set_points(&mut self, axes: &AxisSet) {
        let began = Clock::at(self.clock.tick.saturating_sub(1), self.clock.period_ns).now();
        for index in 0..self.axes.len() {
            if axes.contains(index as u16) && self.axes[index].has_torque() {
                self.end_all_motion(index);
            }
        }
        for index in 0..self.systems.len() {
            if self.systems[index]
                .description
                .axes
                .iter()
                .any(|axis| axes.contains(*axis))
            {
                self.end_stop(index);
                self.abort_system(index, |_| true);
                self.systems[index].braking = *axes;
            }
        }
        for index in 0..self.axes.len() {
            if axes.contains(index as u16) && self.axes[index].has_torque() {
                self.cancel_transforms_of(index as u16);
                self.unlink_slave(index as u16);
                let last = self.set_points[index];
                let axis = &mut self.axes[index];
                axis.brake_from(
                    KinematicState {
                        position: last.position + axis.redefined,
                        velocity: last.velocity,
                        acceleration: 0.0,
                    },
                    began,
                );
                axis.advance(&self.clock);
            }
        }
    }

    /// Everything that moves an axis ends without PC; the axis is where its last set-point is.
    fn end_all_motion(&mut self, index: usize) {
        let axis = index as u16;
        self.end_passive_homing(axis);
        self.end_pending_cams(axis, None);
        for slot in Slot::ALL {
            if let Some(execution) = self.axes[index].sum.get(slot).and_then(|generator| generator.execution) {
                self.end_move(execution, 0);
            }
        }
        let position = self.set_points[index].position + self.axes[index].redefined;
        let axis = &mut self.axes[index];
        axis.sum.place(position);
        axis.command = KinematicState::at_rest(position);
    }
}

impl CommandLimits {
    /// Whether a set-point may follow the last one. Of an axis that follows a master or is being homed the change of velocity is its
    /// master's or its drive's, and only speed is limited.
    fn allow(
        &self,
        [position, velocity]: [f64; 2],
        next: &KinematicState,
        follows: impl Fn() -> bool,
        axis: &Axis,
        period: f64,
    ) -> bool {
        let step = next.position - position;
        if !(step.is_finite() && next.velocity.is_finite() && next.acceleration.is_finite()) {
            return false;
        }
        if !self.enabled {
            return true;
        }
        let speed = self.speed * axis.dynamics.speed;
        let rate = axis.dynamics.acceleration.max(axis.dynamics.deceleration);
        // Rounding of positions far from 0.
        let rounding = 1e-12 * position.abs().max(speed * period);
        step.abs() <= speed * period + rounding
            && next.velocity.abs() <= speed
            && ((next.velocity - velocity).abs() <= self.acceleration * rate * period
                || axis.is_driven_home()
                || follows())
    }
}

#[cfg(test)]
mod tests;
