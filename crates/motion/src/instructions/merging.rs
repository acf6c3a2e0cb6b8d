//! What a coordinated move takes over when it is merged, and what a master driven one follows
//! (spec/coordinated-instructions.md §6.2, §8.7).
//!
//! Not here: the path and the dynamics of the move ([`super::moves`]).

use arcline_instruction_set::enumerations::Merge;
use arcline_instruction_set::{MotionError, SystemId};
use arcline_planner::geometry::Point;
use arcline_planner::profile::{KinematicState, Limits};
use arcline_planner::{Ending, InitialMotion, Move, Pace, Parameter};

use super::points::command;
use crate::axis::Axis;
use crate::axis::generator_kind::GeneratorKind;
use crate::axis::sum::together;
use crate::masters::links::MasterLink;
use crate::motion::Motion;
use crate::system::{Activity, Lead, Planned};

/// What the axes do of which a merge makes the start of its move: of coordinated motion, or of all motion.
pub(super) fn terminated(motion: &Motion, index: SystemId, merge: Merge) -> InitialMotion {
    let quantity = |axis: &Axis| match merge {
        Merge::Disabled => Default::default(),
        // What a transform gives goes on.
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

/// The acceleration that the curvature of a terminated path gives: it ends with the path.
fn centripetal(motion: &Motion, index: SystemId, merge: Merge) -> Point {
    let system = &motion.systems[index];
    if merge == Merge::Disabled || !system.is_busy() {
        return Point::zeros();
    }
    system.travel.centripetal(&system.time_base(&motion.clock))
}

/// The limits that the terminated motion keeps by time, as far as they are known. The speed is that of all programmed speeds
/// together, each in the direction of its motion.
fn in_force(motion: &Motion, index: SystemId, merge: Merge) -> Option<Limits> {
    let system = &motion.systems[index];
    if merge == Merge::Disabled || system.guide.is_some() {
        return None;
    }
    let own = system.travel.limits_in_force(&system.time_base(&motion.clock));
    if merge != Merge::AllMotion {
        return own;
    }
    let mut all = own;
    let mut programmed = own.map_or(Point::zeros(), |own| way_of_path(motion, index) * own.speed);
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
        let way = if moves.velocity == 0.0 {
            moves.acceleration
        } else {
            moves.velocity
        };
        *programmed += limits.speed.copysign(way);
        all = Some(all.map_or(limits, |all| together(&all, &limits)));
    }
    all.map(|all| Limits {
        speed: programmed.norm(),
        ..all
    })
}

/// The direction of what a coordinate system does; zeros where it stands.
fn way_of_path(motion: &Motion, index: SystemId) -> Point {
    let now = |axis: &Axis| axis.sum.motion_of(|kind| kind == GeneratorKind::System);
    let velocity = command(motion, index, |axis| now(axis).velocity);
    let acceleration = command(motion, index, |axis| now(axis).acceleration);
    let way = velocity.try_normalize(0.0).or_else(|| acceleration.try_normalize(0.0));
    way.unwrap_or_default()
}

/// Ends what a merge takes over: the coordinated motion of this system and, for All Motion, what else moves its axes,
/// the coordinated motion of other systems too. Axes that the new move does not take brake by themselves.
pub(super) fn terminate(motion: &mut Motion, index: SystemId, merge: Merge) {
    motion.end_travel(index);
    motion.part_axes(index);
    if merge != Merge::AllMotion {
        return;
    }
    for place in 0..motion.systems[index].description.linear().len() {
        let axis = motion.systems[index].description.linear()[place];
        motion.end_single_axis(axis, None);
    }
    for other in motion.systems.ids() {
        if other != index && motion.systems[index].shared_axis(&motion.systems[other]).is_some() {
            motion.abort_system_but(other, index);
        }
    }
}

/// What is under way by time, by the way of a master.
pub(super) fn on_the_way(pace: &Pace, initial: &InitialMotion) -> InitialMotion {
    let mut taken = InitialMotion {
        velocity: Point::zeros(),
        acceleration: Point::zeros(),
        before: None,
    };
    for place in 0..taken.velocity.len() {
        let state = pace.on_the_way(KinematicState {
            position: 0.0,
            velocity: initial.velocity[place],
            acceleration: initial.acceleration[place],
        });
        taken.velocity[place] = state.velocity;
        taken.acceleration[place] = state.acceleration;
    }
    taken
}

/// Master driven moves that the new one would go on from, or wait with (98, 102). `idle`: it takes over what stands, and so does the
/// master; then it may have another direction.
pub(super) fn verify_lead(
    motion: &Motion,
    index: SystemId,
    merge: Merge,
    lead: Lead,
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
    let led = before.and_then(|before| before.data.lead);
    if !idle && led.is_some_and(|led| led.lock.sense != lead.lock.sense) {
        return Err(MotionError::MdscDirectionMismatch);
    }
    let waits = |other: &Move<Planned>| other.data.lead.is_some_and(|lead| lead.lock.position.is_some());
    if lead.lock.position.is_some() && system.travel.moves().any(waits) {
        return Err(MotionError::MdscLockWhileMoving);
    }
    Ok(())
}

/// What a master driven move is a function of: the way of the move before it, or one that begins with it.
pub(super) fn parameter(
    motion: &mut Motion,
    index: SystemId,
    merge: Merge,
    lead: Lead,
    link: &MasterLink,
) -> Parameter {
    let system = &motion.systems[index];
    if merge == Merge::Disabled && system.activity == Activity::Moving && lead.lock.position.is_none() {
        let led = |last: &&Move<Planned>| {
            let before = last.data.lead;
            before.is_some_and(|before| before.link == lead.link && before.lock.sense == lead.lock.sense)
        };
        if let Some(last) = system.travel.moves().last().filter(led) {
            return last.parameter;
        }
    }
    motion.new_parameter(link)
}
