//! MCS, Motion Coordinated Stop (spec/coordinated-instructions.md §15, the reference page MCS).

use arcline_instruction_set::enumerations::{JerkUnits, McsStopType, NoYes, RateUnits};
use arcline_instruction_set::operands::{Mcs, StopOperands};
use arcline_instruction_set::{Call, Flag, MotionError, SystemId};
use arcline_planner::profile::{Jerk, Limits};

use super::programmed::{positive, stop_change};
use crate::dynamics::{Maxima, resolve, speed_for_jerk};
use crate::execution::Execution;
use crate::motion::Motion;
use crate::stop::{AxisSet, Stop};
use crate::transforms::cancel::Release;
use crate::transforms::transform::Transform;
use crate::verify::{self, members};

pub(super) fn execute(motion: &mut Motion, execution: Execution, call: &Call) -> Result<(), MotionError> {
    let index = motion.target_system(call)?;
    let Mcs {
        stop_type,
        rates: operands,
    } = motion.operands(call)?;
    verify_units(motion, index, &operands)?;
    verify::switched_on(members(&motion.systems[index], &motion.axes))?;
    verify::system_stoppable(&motion.systems[index], &motion.axes, motion.systems[index].is_s_curve())?;
    let rates = rates(motion, index, &operands)?;
    if *stop_type == McsStopType::All {
        verify_sharing(motion, index, &operands)?;
    }

    // A weaker stop during a stop of all takes over only the bits of that stop.
    let running = motion.systems[index].stop;
    motion.systems[index].end_stop(&mut motion.controls);
    let mut braking = running.map(|stop| stop.braking).unwrap_or_default();
    let of_moves = *stop_type != McsStopType::CoordinatedTransform || running.is_some_and(|stop| stop.of_moves);
    if *stop_type != McsStopType::CoordinatedTransform {
        motion.systems[index].keep_stopping_link();
    }
    match *stop_type {
        McsStopType::All => {
            for member in 0..motion.systems[index].description.axes.len() {
                let axis = motion.systems[index].description.axes[member];
                braking.extend(cancel(motion, &rates.release, |transform, _| transform.has(axis)));
            }
            braking.extend(stop_all(motion, index, &operands)?);
            for member in 0..motion.systems[index].description.axes.len() {
                motion.unlink_slave(motion.systems[index].description.axes[member]);
            }
        }
        // A stop of all that is under way continues unchanged.
        McsStopType::CoordinatedMove if !is_ending(motion, index) => {
            let limits = rates.along_path(motion, index);
            stop_move(motion, index, &limits);
        }
        McsStopType::CoordinatedTransform => {
            let own = |transform: &Transform, target: SystemId| target == index || transform.source_system == index;
            braking.extend(cancel(motion, &rates.release, own));
        }
        McsStopType::CoordinatedMove => {}
    }
    motion.systems[index].stop = Some(Stop {
        execution,
        of_moves,
        braking,
    });
    let initiated = Flag::Dn.mask() | Flag::Ip.mask();
    motion.controls.write(execution, initiated, 0);
    Ok(())
}

/// With orientation, one rate cannot apply to both X, Y, Z and Rx, Ry, Rz: only percentages of the maxima are possible
/// (spec/coordinated-instructions.md §4.4, §15).
fn verify_units(motion: &Motion, index: SystemId, operands: &StopOperands) -> Result<(), MotionError> {
    if motion.systems[index].description.orientation.is_none() {
        return Ok(());
    }
    if *operands.change_decel == NoYes::Yes && *operands.decel_units != RateUnits::PercentOfMaximum {
        return Err(operands.decel_units.out_of_range());
    }
    if *operands.change_decel_jerk == NoYes::Yes && *operands.jerk_units != JerkUnits::PercentOfTime {
        return Err(operands.jerk_units.out_of_range());
    }
    Ok(())
}

/// Deceleration and jerk of a stop.
struct StopRates {
    deceleration: f64,
    jerk: f64,
    /// The rates among them that the operands give; cancelled transforms otherwise use their own maxima.
    release: Release,
}

impl StopRates {
    /// The limits of a stop along the path of the active move.
    fn along_path(&self, motion: &Motion, index: SystemId) -> Limits {
        let system = &motion.systems[index];
        // The limits of a master driven move are per master unit.
        let active = system
            .active()
            .filter(|_| system.follower.is_none())
            .map(|active| active.dynamics.limits());
        let deceleration = motion.systems[index].kept_by_turn(self.deceleration);
        Limits {
            speed: active.map_or(system.description.max_speed, |limits| limits.speed),
            // A remaining acceleration ramps down at the move's own jerk or, if larger, the stop's.
            acceleration: active.map_or(deceleration, |limits| limits.acceleration),
            deceleration,
            jerk: motion.systems[index].is_s_curve().then(|| Jerk {
                acceleration: active
                    .and_then(|limits| limits.jerk)
                    .map_or(self.jerk, |own| own.acceleration.max(self.jerk)),
                deceleration: self.jerk,
            }),
        }
    }
}

fn rates(motion: &Motion, index: SystemId, operands: &StopOperands) -> Result<StopRates, MotionError> {
    let system = &motion.systems[index];
    let description = &system.description;
    let changed = stop_change(operands, &Maxima::from(description));
    let mut release = Release {
        deceleration: changed.deceleration,
        ..Release::default()
    };
    let deceleration = release.deceleration.unwrap_or(description.max_deceleration);
    positive(deceleration, operands.decel_rate.index)?;
    if let Some(programmed) = changed.jerk {
        let sample = system.travel.sample(&system.time_base(&motion.clock));
        let speed = sample.map_or(0.0, |(sample, _)| sample.along.velocity.abs());
        release.jerk = Some(resolve(
            programmed,
            speed_for_jerk(speed, description.max_speed),
            deceleration,
        ));
    }
    let jerk = release.jerk.unwrap_or(description.max_deceleration_jerk);
    if motion.systems[index].is_s_curve() {
        positive(jerk, operands.decel_jerk.index)?;
    }
    Ok(StopRates {
        deceleration,
        jerk,
        release,
    })
}

/// Cancels the transforms that `which` chooses by the transform and its target system. Returns the axes that brake.
fn cancel(motion: &mut Motion, release: &Release, which: impl Fn(&Transform, SystemId) -> bool) -> AxisSet {
    let mut braking = AxisSet::default();
    for id in motion.transforms.ids() {
        if motion
            .transforms
            .get(id)
            .is_some_and(|transform| which(transform, id.target_system()))
        {
            braking.extend(motion.cancel_transform(id, release));
        }
    }
    braking
}

/// Stops the coordinated move on its path and empties the queue.
pub(crate) fn stop_move(motion: &mut Motion, index: SystemId, limits: &Limits) {
    motion.systems.cancel_pending(index, &mut motion.controls);
    motion.systems[index].end_active(&mut motion.controls);
    motion.systems[index].stop_on_path(limits, &motion.clock);
}

/// Stops the coordinated moves of the system, and those of systems that share an axis with it, on their paths. Each axis of the system stops
/// its single-axis motion separately (spec/coordinated-instructions.md §15.1). Returns the axes that brake.
fn stop_all(motion: &mut Motion, index: SystemId, operands: &StopOperands) -> Result<AxisSet, MotionError> {
    let mut braking = AxisSet::default();
    for other in motion.systems.ids() {
        if !motion.systems[other].is_busy() || !shares(motion, index, other) {
            continue;
        }
        let limits = rates(motion, other, operands)?.along_path(motion, other);
        stop_move(motion, other, &limits);
        for member in 0..motion.systems[other].taken().len() {
            let axis = motion.systems[other].taken()[member];
            motion.axes[axis].end_on_path();
            braking.insert(axis);
        }
    }
    for member in 0..motion.systems[index].description.axes.len() {
        let axis = motion.systems[index].description.axes[member];
        motion.axes[axis].stop_own(&mut motion.controls, &motion.clock);
        braking.insert(axis);
    }
    Ok(braking)
}

/// A stop of all brakes the coordinated move of a system on its path.
fn is_ending(motion: &Motion, index: SystemId) -> bool {
    let mut axes = motion.systems[index].taken().iter();
    axes.any(|axis| motion.axes[*axis].is_ending_on_path())
}

/// A stop of all of one system also stops the coordinated moves of the other: they are the same, or share an axis.
fn shares(motion: &Motion, index: SystemId, other: SystemId) -> bool {
    other == index || motion.systems[index].shared_axis(&motion.systems[other]).is_some()
}

/// A stop of all also stops moves of other systems, at their own maxima if the operands give no rates: checks that these exist.
fn verify_sharing(motion: &Motion, index: SystemId, operands: &StopOperands) -> Result<(), MotionError> {
    for other in motion.systems.ids() {
        if other == index || !motion.systems[other].is_busy() || !shares(motion, index, other) {
            continue;
        }
        verify::system_stoppable(&motion.systems[other], &motion.axes, motion.systems[other].is_s_curve())?;
        rates(motion, other, operands)?;
    }
    Ok(())
}
