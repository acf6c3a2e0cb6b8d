//! The last check of set-points: no drive receives a command that its axis cannot follow
//! (spec/axis-and-data-types.md §12).
//!
//! The check compares the new set-point of every axis with the last one that went out. A set-point beyond the axis's command limits never
//! goes out: the axis, and every axis that moves with it, brakes from its last good set-point, the axis faults, and the controller reports
//! the refused command. A defect of a planner, a transform or a follower thus causes a stop and not a jump. Not here: limits of programs,
//! which instructions and planners observe. Real-time: no allocation; bounded by the axes; after a refusal by their square.

use arcline_drive::SetPoint;
use arcline_instruction_set::{AxisId, FaultKind, FaultSet};
use arcline_planner::Clock;
use arcline_profile::KinematicState;

use super::Motion;
use crate::axis::Axis;
use crate::axis::generator_kind::GeneratorKind;
use crate::cause::{Cause, RefusedCommand};
use crate::machine::CommandLimits;
use crate::stop::AxisSet;
use crate::tolerance::COMMAND_SHARE;

impl Motion {
    /// Compares the new set-points with the last ones and replaces those that must not go out. To be called once a tick, after all
    /// commands are computed and before the exchange.
    pub(super) fn limit_commands(&mut self) {
        let mut refused = AxisSet::default();
        let mut first = None;
        for id in self.axes.ids() {
            if self.axes[id].dormant {
                continue;
            }
            let command = self.refused_command(id);
            self.axes[id].sum.keep_displacements();
            let Some(command) = command else { continue };
            refused.insert(id);
            first = first.or(Some(id));
            self.axes[id].faults.refuse(command);
        }
        let Some(axis) = first else { return };
        let faults = FaultSet::default().with(FaultKind::CommandLimit);
        self.controls.because(Cause::Fault { axis, faults });
        self.brake_from_last_set_points(&self.moving_with(refused));
        self.controls.because(Cause::Itself);
    }

    /// Reports the command of an axis at the present tick if it must not go out.
    fn refused_command(&mut self, id: AxisId) -> Option<RefusedCommand> {
        let (axis, last) = (&self.axes[id], &self.set_points[id.index()]);
        let next = KinematicState {
            position: axis.command.position - axis.redefined,
            ..axis.command
        };
        let stands = next.position == last.position && next.velocity == last.velocity;
        (!stands && !self.may_go_out(id, &next)).then(|| self.refusal(id, &next))
    }

    /// The limits of an axis allow a set-point, or do not apply to it.
    pub(super) fn may_go_out(&self, id: AxisId, next: &KinematicState) -> bool {
        let (axis, last) = (&self.axes[id], &self.set_points[id.index()]);
        // A virtual axis has no drive that its set-points enable.
        let was_on = last.enable || (axis.is_virtual && self.clock.tick > 1);
        if !was_on || !axis.has_torque() || axis.feeding.is_some() {
            return true;
        }
        let follows = || axis.follows_a_master() || self.systems.iter().any(|system| system.is_driven_by_master(id));
        axis.command_limits
            .allow(last, next, follows, axis, self.clock.period())
    }

    /// The steps that the limits of an axis allow from the present tick on; `None`: its steps are not limited.
    pub(super) fn step(&self, id: AxisId) -> Option<Step> {
        let axis = &self.axes[id];
        let is_limited = axis.command_limits.enabled;
        is_limited.then(|| axis.command_limits.step(axis, self.clock.period()))
    }

    /// The report of a set-point that does not go out.
    fn refusal(&mut self, id: AxisId, next: &KinematicState) -> RefusedCommand {
        let (axis, last) = (&self.axes[id], &self.set_points[id.index()]);
        let (redefined, before) = (axis.redefined, [last.position, last.velocity]);
        let suspect = axis.sum.suspect(self.clock.period());
        let execution = suspect.and_then(|(_, generator)| generator.execution);
        let source = suspect.map(|(kind, _)| kind);
        let execution = match source {
            Some(GeneratorKind::System) => {
                let mut systems = self.systems.iter_mut();
                let moving = systems.find(|system| system.is_busy() && system.has(id));
                moving.and_then(|system| system.active()).map(|active| active.execution)
            }
            _ => execution,
        };
        RefusedCommand {
            by: execution.map_or(Cause::Itself, Cause::from),
            source: source.map_or("no motion", GeneratorKind::name),
            last: [before[0] + redefined, before[1]],
            asked: [next.position + redefined, next.velocity],
        }
    }

    /// Some axes and every axis that moves with one of them: in the same coordinate system, on either side of a transform, or as a follower
    /// of a master.
    fn moving_with(&self, mut axes: AxisSet) -> AxisSet {
        for _ in self.axes.ids() {
            let before = axes;
            for system in self.systems.iter().filter(|system| system.is_busy()) {
                axes.join(&system.description.axes);
                if system.masters().any(|master| axes.contains(master)) {
                    system.description.axes.iter().for_each(|axis| axes.insert(*axis));
                }
            }
            for (_, transform) in self.transforms.iter() {
                if transform.axes().any(|axis| axes.contains(axis)) {
                    transform.axes().for_each(|axis| axes.insert(axis));
                }
            }
            for (id, axis) in self.axes.ids().zip(self.axes.iter()) {
                if axis.masters().any(|master| axes.contains(master)) {
                    axes.insert(id);
                }
            }
            if axes == before {
                break;
            }
        }
        axes
    }

    /// Ends all motion of some axes; each axis brakes at its Maximum Deceleration from its last set-point.
    fn brake_from_last_set_points(&mut self, axes: &AxisSet) {
        let began = Clock::at(self.clock.tick.saturating_sub(1), self.clock.period_ns).now();
        for id in self.axes.ids() {
            if axes.contains(id) && self.axes[id].has_torque() {
                let position = self.set_points[id.index()].position + self.axes[id].redefined;
                self.axes[id].end_all_motion(position, &mut self.controls);
            }
        }
        for id in self.systems.ids() {
            if self.systems[id]
                .description
                .axes
                .iter()
                .any(|axis| axes.contains(*axis))
            {
                self.systems[id].end_stop(&mut self.controls);
                self.abort_system(id, |_| true);
                self.systems[id].braking = *axes;
            }
        }
        for id in self.axes.ids() {
            if axes.contains(id) && self.axes[id].has_torque() {
                self.cancel_transforms_of(id);
                self.unlink_slave(id);
                let last = self.set_points[id.index()];
                let axis = &mut self.axes[id];
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
}

/// The changes from one set-point to the next one that [`CommandLimits`] allow to an axis.
#[derive(Clone, Copy, Debug)]
pub(super) struct Step {
    speed: f64,
    /// Of the velocity, in one tick.
    change: f64,
    period: f64,
}

impl Step {
    /// The set-point may follow the last one, whatever moves the axis. False: [`Motion::may_go_out`] must be asked.
    pub(super) fn allows(&self, last: &SetPoint, next: &KinematicState) -> bool {
        let step = next.position - last.position;
        is_finite(step, next) && self.allows_speed(step, last, next) && self.allows_change(step, last, next)
    }

    fn allows_speed(&self, step: f64, last: &SetPoint, next: &KinematicState) -> bool {
        step.abs() <= self.speed * self.period + self.rounding(last) && next.velocity.abs() <= self.speed
    }

    /// Beside the mean of the velocities at both ends, an acceleration of at most a moves an axis by at most a t^2 / 4, and a velocity that
    /// changes at once by half of what it changes.
    fn allows_change(&self, step: f64, last: &SetPoint, next: &KinematicState) -> bool {
        let changed = (next.velocity - last.velocity).abs();
        let jump = (step - 0.5 * (last.velocity + next.velocity) * self.period).abs();
        changed <= self.change && jump <= (0.25 * self.change + 0.5 * changed) * self.period + self.rounding(last)
    }

    /// Rounding of positions far from 0.
    fn rounding(&self, last: &SetPoint) -> f64 {
        COMMAND_SHARE * last.position.abs().max(self.speed * self.period)
    }
}

/// A step to the next set-point is a number.
fn is_finite(step: f64, next: &KinematicState) -> bool {
    step.is_finite() && next.velocity.is_finite() && next.acceleration.is_finite()
}

impl CommandLimits {
    /// A set-point may follow the last one: its speed, its distance and its change of velocity are those of an axis within these limits. The
    /// acceleration of an axis that follows a master or is being homed depends on its master or its drive, so only its speed is limited.
    fn allow(
        &self,
        last: &SetPoint,
        next: &KinematicState,
        follows: impl Fn() -> bool,
        axis: &Axis,
        period: f64,
    ) -> bool {
        let step = next.position - last.position;
        if !is_finite(step, next) {
            return false;
        }
        if !self.enabled {
            return true;
        }
        let allowed = self.step(axis, period);
        allowed.allows_speed(step, last, next)
            && (allowed.allows_change(step, last, next) || axis.is_driven_home() || follows())
    }

    fn step(&self, axis: &Axis, period: f64) -> Step {
        Step {
            speed: self.speed * axis.dynamics.speed,
            change: self.acceleration * axis.dynamics.acceleration.max(axis.dynamics.deceleration) * period,
            period,
        }
    }
}

#[cfg(test)]
mod tests;
