//! The motion that a coordinated move takes over by a merge, and the master that drives it
//! (spec/coordinated-instructions.md §6.2, §8.7).
//!
//! Not here: the path and the dynamics of the move ([`super::moves`]).

use arcline_instruction_set::enumerations::Merge;
use arcline_instruction_set::{MotionError, SystemId};
use arcline_planner::geometry::Point;
use arcline_planner::profile::{KinematicState, Limits};
use arcline_planner::{AngularState, Ending, InitialMotion, MasterRate, Move, Parameter, RotationResidual};

use super::points::command;
use super::programmed;
use crate::axis::Axis;
use crate::axis::generator_kind::GeneratorKind;
use crate::axis::sum::together;
use crate::masters::follower::DrivenBy;
use crate::masters::links::MasterLink;
use crate::motion::Motion;
use crate::system::{Activity, Planned};

/// The motion of the axes that a merge takes over: coordinated motion, or all motion.
fn terminated(motion: &Motion, index: SystemId, merge: Merge) -> InitialMotion {
    let quantity = |axis: &Axis| match merge {
        Merge::Disabled => Default::default(),
        // The motion that a transform gives an axis continues.
        Merge::AllMotion => axis.sum.motion_of(|kind| !kind.is_of_transforms()),
        _ => axis
            .sum
            .get(GeneratorKind::System)
            .map(|generator| generator.now)
            .unwrap_or_default(),
    };
    InitialMotion {
        velocity: command(motion, index, |axis| quantity(axis).velocity),
        acceleration: command(motion, index, |axis| quantity(axis).acceleration) - centripetal(motion, index, merge),
        before: in_force(motion, index, merge),
    }
}

/// The acceleration from the curvature of a terminated path: it ends with the path.
fn centripetal(motion: &Motion, index: SystemId, merge: Merge) -> Point {
    let system = &motion.systems[index];
    if merge == Merge::Disabled || !system.is_busy() {
        return Point::zeros();
    }
    system.travel.centripetal(&system.time_base(&motion.clock))
}

/// The limits by time of the terminated motion, if they are known. The speed is the sum of all programmed speeds, each in the direction of
/// its motion.
fn in_force(motion: &Motion, index: SystemId, merge: Merge) -> Option<Limits> {
    let system = &motion.systems[index];
    if merge == Merge::Disabled || system.follower.is_some() {
        return None;
    }
    let own = system.travel.limits_in_force(&system.time_base(&motion.clock));
    if merge != Merge::AllMotion {
        return own;
    }
    let mut all = own;
    let mut programmed = own.map_or(Point::zeros(), |own| path_direction(motion, index) * own.speed);
    for (axis, programmed) in system.description.linear().iter().zip(programmed.iter_mut()) {
        let sum = &motion.axes.get(*axis)?.sum;
        let single = |kind: GeneratorKind| kind.is_single_axis() || kind == GeneratorKind::System && own.is_none();
        let moves = sum.motion_of(single);
        let Some(limits) = sum.in_force(single) else {
            if moves.velocity != 0.0 || moves.acceleration != 0.0 {
                return None;
            }
            continue;
        };
        let direction = if moves.velocity == 0.0 {
            moves.acceleration
        } else {
            moves.velocity
        };
        *programmed += limits.speed.copysign(direction);
        all = Some(all.map_or(limits, |all| together(&all, &limits)));
    }
    all.map(|all| Limits {
        speed: programmed.norm(),
        ..all
    })
}

/// The direction of the coordinated motion of a system; zeros at rest.
fn path_direction(motion: &Motion, index: SystemId) -> Point {
    let now = |axis: &Axis| axis.sum.motion_of(|kind| kind == GeneratorKind::System);
    let velocity = command(motion, index, |axis| now(axis).velocity);
    let acceleration = command(motion, index, |axis| now(axis).acceleration);
    let direction = velocity.try_normalize(0.0).or_else(|| acceleration.try_normalize(0.0));
    direction.unwrap_or_default()
}

/// Ends the motion that a merge takes over: the coordinated motion of this system and, for All Motion, every other motion of its axes,
/// including coordinated motion of other systems. Axes that the new move does not use brake separately.
pub(super) fn terminate(motion: &mut Motion, index: SystemId, merge: Merge) {
    motion.systems.end_travel(index, &mut motion.controls);
    motion.systems[index].release_axes_in_motion(&mut motion.axes);
    if merge != Merge::AllMotion {
        return;
    }
    for member in 0..motion.systems[index].description.linear().len() {
        let axis = motion.systems[index].description.linear()[member];
        motion.axes[axis].end_single_axis(None, &mut motion.controls);
    }
    for other in motion.systems.ids() {
        if other != index && motion.systems[index].shared_axis(&motion.systems[other]).is_some() {
            motion
                .systems
                .abort_but(other, index, &mut motion.axes, &mut motion.controls, &motion.clock);
        }
    }
}

/// The motion that a move begins with: the motion that a merge terminates, or rest.
#[derive(Clone, Copy, Debug)]
pub(super) struct StartMotion {
    pub(super) merge: Merge,
    pub(super) initial: InitialMotion,
    turning: Option<AngularState>,
    /// Speed of the axes, units/s or units per master unit.
    pub(super) speed: f64,
}

impl StartMotion {
    pub(super) fn rest() -> StartMotion {
        StartMotion {
            merge: Merge::Disabled,
            initial: InitialMotion::default(),
            turning: None,
            speed: 0.0,
        }
    }

    /// The motion at the present tick.
    pub(super) fn of(motion: &Motion, index: SystemId, merge: Merge) -> StartMotion {
        StartMotion {
            merge,
            initial: terminated(motion, index, merge),
            turning: match merge {
                Merge::Disabled => None,
                _ => motion.systems[index].turning(&motion.axes),
            },
            speed: command(motion, index, |axis| axis.command.velocity).norm(),
        }
    }

    fn moves(&self) -> bool {
        let turns = self.turning.is_some_and(|turning| turning.rate != Point::zeros());
        self.initial.velocity != Point::zeros() || turns
    }

    /// The rotation that ramps out beside the move.
    pub(super) fn residual(&self) -> Option<RotationResidual> {
        self.turning.and_then(|turning| turning.ramped_out())
    }

    /// The start motion over the displacement of the master that drives the move.
    ///
    /// # Errors
    /// 97, 98 and 102 if the motion of the master or the motion under way does not permit the merge.
    pub(super) fn by_master(
        &self,
        motion: &Motion,
        index: SystemId,
        master: &Master,
    ) -> Result<StartMotion, MotionError> {
        let Master { driven_by, link } = master;
        let moves = self.moves();
        let rate = programmed::master_rate(link, driven_by.lock, moves)?;
        let idle = self.merge != Merge::Disabled && !moves && link.master.velocity() == 0.0;
        verify_driven(motion, index, self.merge, *driven_by, idle)?;
        Ok(StartMotion {
            merge: self.merge,
            initial: by_displacement(&rate, &self.initial),
            turning: self.turning.map(|turning| turning.by_displacement(&rate, link.nominal)),
            speed: if rate.speed > 0.0 { self.speed / rate.speed } else { 0.0 },
        })
    }
}

/// The master that drives a move.
#[derive(Clone, Copy, Debug)]
pub(super) struct Master {
    pub(super) driven_by: DrivenBy,
    pub(super) link: MasterLink,
}

impl Master {
    /// `None` if time drives the move.
    pub(super) fn of(driven_by: Option<DrivenBy>, link: Option<MasterLink>) -> Option<Master> {
        let (driven_by, link) = driven_by.zip(link)?;
        Some(Master { driven_by, link })
    }

    /// The displacement that the move is a function of: that of the move before it, or a new one that begins with it.
    pub(super) fn parameter(&self, motion: &mut Motion, index: SystemId, merge: Merge) -> Parameter {
        let Master { driven_by, link } = self;
        let system = &motion.systems[index];
        if merge == Merge::Disabled && system.activity == Activity::Moving && driven_by.lock.position.is_none() {
            let same = |last: &&Move<Planned>| {
                let before = last.data.driven_by;
                before.is_some_and(|before| before.link == driven_by.link && before.lock.sense == driven_by.lock.sense)
            };
            if let Some(last) = system.travel.moves().last().filter(same) {
                return last.parameter;
            }
        }
        motion.link_numbers.parameter(link)
    }
}

/// Converts a motion by time to one by the displacement of a master.
fn by_displacement(rate: &MasterRate, initial: &InitialMotion) -> InitialMotion {
    let mut taken = InitialMotion::default();
    for index in 0..taken.velocity.len() {
        let state = rate.by_displacement(KinematicState {
            position: 0.0,
            velocity: initial.velocity[index],
            acceleration: initial.acceleration[index],
        });
        taken.velocity[index] = state.velocity;
        taken.acceleration[index] = state.acceleration;
    }
    taken
}

/// Checks the move against the master driven moves that it would continue or wait behind (98, 102). `idle`: the move starts from rest, and
/// its master stands; then it may have another direction.
fn verify_driven(
    motion: &Motion,
    index: SystemId,
    merge: Merge,
    driven_by: DrivenBy,
    idle: bool,
) -> Result<(), MotionError> {
    let system = &motion.systems[index];
    if system.activity != Activity::Moving {
        return Ok(());
    }
    let before = if merge == Merge::Disabled {
        system.travel.moves().last().filter(|last| last.ending != Ending::Stop)
    } else {
        system.travel.moves().next()
    };
    let other = before.and_then(|before| before.data.driven_by);
    if !idle && other.is_some_and(|other| other.lock.sense != driven_by.lock.sense) {
        return Err(MotionError::MdscDirectionMismatch);
    }
    let waits = |other: &Move<Planned>| other.data.driven_by.is_some_and(|other| other.lock.position.is_some());
    if driven_by.lock.position.is_some() && system.travel.moves().any(waits) {
        return Err(MotionError::MdscLockWhileMoving);
    }
    Ok(())
}
