//! The common part of MAM, MAJ and MCD: verification, the motion that a merge takes over, and the start of a generator.

use arcline_instruction_set::enumerations::{AxisMerge, MergeSpeed};
use arcline_instruction_set::{AxisId, AxisIndex, Flag, MotionError};
use arcline_planner::MasterRate;
use arcline_planner::profile::{AccelerationRemovalPhase, DynamicsBits, Limits, MOST_OVERSHOOT, Profile};
use arcline_profile::KinematicState;

use super::programmed::{self, Programmed};
use crate::axis::Axis;
use crate::axis::generator::{Generator, Goal, ProgrammedMotion};
use crate::axis::generator_kind::GeneratorKind;
use crate::dynamics::Dynamics;
use crate::events::{Events, MoveEvents};
use crate::execution::Execution;
use crate::masters::follower::DrivenBy;
use crate::motion::Motion;
use crate::verify::{self, alone};

/// The operands that MAM and MAJ share.
#[derive(Clone, Copy, Debug)]
pub(super) struct AxisMove {
    pub(super) programmed: Programmed,
    pub(super) merge: AxisMerge,
    pub(super) merge_speed: MergeSpeed,
}

impl AxisMove {
    /// The move continues at the present speed of the axis.
    pub(super) fn keeps_speed(&self) -> bool {
        self.merges() && self.merge_speed == MergeSpeed::Current
    }

    /// The instruction ends the motion of other single-axis instructions.
    fn merges(&self) -> bool {
        self.merge == AxisMerge::Enabled
    }

    /// The same for a kind of generator; an offset of a master never ends motion of the axis.
    fn merges_into(&self, kind: GeneratorKind) -> bool {
        kind != GeneratorKind::MasterOffset && self.merges()
    }

    /// Velocity and acceleration of the motion that the instruction takes over: that of its own kind, or of all single-axis instructions. The
    /// position is the command position of the axis.
    pub(super) fn taken_over(&self, axis: &Axis, kind: GeneratorKind) -> KinematicState {
        match kind {
            GeneratorKind::MasterOffset => axis.master_offset(),
            _ => KinematicState {
                position: axis.command.position,
                ..axis
                    .sum
                    .motion_of(|other| other == kind || (self.merges() && other.is_single_axis()))
            },
        }
    }

    /// The limits of the motion that the instruction takes over, by time or by a master's displacement as the instruction itself.
    fn in_force(&self, axis: &Axis, kind: GeneratorKind, driven: bool) -> Option<Limits> {
        let own = axis.sum.get(kind);
        if driven || kind == GeneratorKind::MasterOffset {
            return own.filter(|own| own.follower.is_some() == driven)?.in_force;
        }
        axis.sum
            .in_force(|other| other == kind || (self.merges() && other.is_single_axis()))
    }

    /// The limits whose speed is a programmed one: the present speed, at which Merge Speed Current continues, may exceed the speed of the motion
    /// before by half, and must not count as programmed at the next merge.
    fn without_present_speed(&self, limits: Limits, before: Option<&Limits>) -> Limits {
        let programmed = before.filter(|_| self.keeps_speed());
        Limits {
            speed: programmed.map_or(limits.speed, |before| limits.speed.min(before.speed)),
            ..limits
        }
    }

    /// Begins a move or a jog from the motion that it takes over, along the profile that `plan` makes from it.
    pub(super) fn begin(
        &self,
        motion: &mut Motion,
        axis: AxisId,
        kind: GeneratorKind,
        beginning: MoveStart,
        plan: impl FnOnce(KinematicState) -> Profile,
    ) {
        let MoveStart {
            execution,
            dynamics,
            goal,
            driven,
            events,
        } = beginning;
        let taken = self.taken_over(&motion.axes[axis], kind);
        let taken = driven.map_or(taken, |(_, rate)| rate.by_displacement(taken));
        let from = steady(taken, &dynamics.limits());
        let before = self.in_force(&motion.axes[axis], kind, driven.is_some());
        if self.merges_into(kind) {
            motion.axes[axis].end_single_axis(Some(kind), &mut motion.controls);
        }
        motion.axes[axis].end_generator(kind, &mut motion.controls);
        let follower = driven.and_then(|(driven_by, _)| {
            motion
                .axes
                .begin_follower(axis, driven_by, &mut motion.controls, &motion.clock)
        });
        let limits = match goal {
            Goal::Position(_) => dynamics.limits(),
            Goal::Velocity(velocity) => dynamics.jog_limits(from.velocity, velocity),
        };
        let limits = self.without_present_speed(limits, before.as_ref());
        let removal_phase = removal_phase(motion.axes[axis].dynamics_bits, from, &limits, before.as_ref());
        let profile = Profile::after_removal(removal_phase, from, plan);
        let start = follower.map_or(motion.clock, |follower| follower.clock()).now();
        let mut generator = Generator::planned(profile, start);
        generator.follower = follower;
        generator.set_limits_in_force(&limits);
        generator.execution = Some(execution);
        generator.s_curve = dynamics.is_s_curve();
        generator.program = Some(ProgrammedMotion { dynamics, goal });
        if let (Some(events), Goal::Position(to)) = (events, goal) {
            generator.events = Some(MoveEvents {
                events,
                begun: start,
                from: from.position,
                to,
                due: Some(motion.clock.tick),
            });
        }
        motion.axes[axis].begin(kind, generator);
        motion.axes[axis].stale = true;
        let mut accepted = Flag::Dn.mask() | Flag::Ip.mask();
        if follower.is_some() {
            accepted |= Flag::Ac.mask();
        }
        motion.controls.write(execution, accepted, 0);
        motion.axes[axis].calculate_move(kind, &mut motion.controls, &motion.clock);
    }

    /// The lock of a master driven move or jog, and the rate of its master, which converts the motion that it takes over; `None`: by time.
    ///
    /// # Errors
    /// 93 to 98 and 102 if its link, its lock or its master forbids it.
    pub(super) fn driven(
        &self,
        motion: &Motion,
        axis: AxisId,
        kind: GeneratorKind,
        driven_by: Option<DrivenBy>,
    ) -> Result<Option<(DrivenBy, MasterRate)>, MotionError> {
        let state = &motion.axes[axis];
        let link = driven_by.and_then(|driven_by| state.links.iter().find(|link| link.id == driven_by.link));
        let (Some(driven_by), Some(link)) = (driven_by, link) else {
            return Ok(None);
        };
        let moves = self.taken_over(state, kind).velocity != 0.0;
        let rate = programmed::master_rate(link, driven_by.lock, moves)?;
        if let Some(running) = state.sum.get(kind).and_then(|generator| generator.follower) {
            if running.sense != driven_by.lock.sense {
                return Err(MotionError::MdscDirectionMismatch);
            }
            if running.has_position_lock() && driven_by.lock.position.is_some() {
                return Err(MotionError::MdscLockWhileMoving);
            }
        }
        Ok(Some((driven_by, rate)))
    }

    /// The present speed of the motion that the instruction takes over, by time or by the master's displacement; Merge Speed Current continues
    /// at it.
    pub(super) fn present_speed(
        &self,
        axis: &Axis,
        kind: GeneratorKind,
        driven: Option<(DrivenBy, MasterRate)>,
    ) -> f64 {
        let taken = self.taken_over(axis, kind);
        driven
            .map_or(taken, |(_, rate)| rate.by_displacement(taken))
            .velocity
            .abs()
    }
}

/// The parameters of a move or a jog that begins.
pub(super) struct MoveStart {
    pub(super) execution: Execution,
    pub(super) dynamics: Dynamics,
    pub(super) goal: Goal,
    /// The link, lock and rate of the master of a master driven motion.
    pub(super) driven: Option<(DrivenBy, MasterRate)>,
    pub(super) events: Option<Events>,
}

/// The phase that first reduces a present acceleration, such that new limits overshoot the programmed speeds, new and old, by no more than half
/// (spec/coordinated-instructions.md §5.4).
pub(super) fn removal_phase(
    dynamics_bits: DynamicsBits,
    from: KinematicState,
    limits: &Limits,
    before: Option<&Limits>,
) -> Option<AccelerationRemovalPhase> {
    if !dynamics_bits.overshoot {
        return None;
    }
    let known = before.map_or(from.velocity.abs(), |before| before.speed);
    AccelerationRemovalPhase::below(from, limits, MOST_OVERSHOOT * known.max(limits.speed))
}

/// The start state of a profile: a trapezoid begins without an acceleration.
pub(super) fn steady(from: KinematicState, limits: &Limits) -> KinematicState {
    KinematicState {
        acceleration: if limits.jerk.is_some() { from.acceleration } else { 0.0 },
        ..from
    }
}

/// Checks that the axis can be moved: it is no encoder, not shut down, servo on, not homed, and its stops have a rate.
pub(super) fn verify_axis(axis: &Axis, s_curve: bool) -> Result<(), MotionError> {
    if axis.feeding.is_some() {
        return Err(MotionError::WrongAxisType(AxisIndex(0)));
    }
    verify::ready(alone(axis))?;
    verify::not_homing(alone(axis))?;
    verify::stoppable(alone(axis))?;
    if s_curve {
        verify::stoppable_by_jerk(alone(axis))?;
    }
    Ok(())
}
