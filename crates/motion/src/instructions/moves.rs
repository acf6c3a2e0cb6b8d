//! What MCLM and MCCM share: dynamics, termination, and the way into the queue.

use arcline_instruction_set::{Call, Flag, Mnemonic, MotionError, OperandIndex};
use arcline_planner::Move;
use arcline_planner::geometry::{Path, Point};

use super::place;
use crate::control::Execution;
use crate::dynamics::{Dynamics, Jerks, Shape, in_units, jerk_in_units, reference_speed};
use crate::machine::CoordinateSystem;
use crate::motion::Motion;
use crate::system::{Activity, Planned, System, Termination, component};
use crate::verify;

/// Places of the operands that every coordinated move has.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MoveLayout {
    pub(super) move_type: usize,
    pub(super) position: usize,
    speed: usize,
    speed_units: usize,
    accel_rate: usize,
    accel_units: usize,
    decel_rate: usize,
    decel_units: usize,
    profile: usize,
    accel_jerk: usize,
    decel_jerk: usize,
    jerk_units: usize,
    termination_type: usize,
    merge: usize,
    lock_direction: usize,
    event_distance: usize,
}

/// Move Type: the position counts from the start of the move.
pub(super) const INCREMENTAL: i32 = 1;
/// Profile: S-curve.
const S_CURVE: i32 = 1;
/// Merge: Disabled.
const MERGE_DISABLED: i32 = 0;

impl MoveLayout {
    pub(super) fn of(mnemonic: Mnemonic) -> Self {
        let place = |name| place(mnemonic, name);
        MoveLayout {
            move_type: place("Move Type"),
            position: place("Position"),
            speed: place("Speed"),
            speed_units: place("Speed Units"),
            accel_rate: place("Accel Rate"),
            accel_units: place("Accel Units"),
            decel_rate: place("Decel Rate"),
            decel_units: place("Decel Units"),
            profile: place("Profile"),
            accel_jerk: place("Accel Jerk"),
            decel_jerk: place("Decel Jerk"),
            jerk_units: place("Jerk Units"),
            termination_type: place("Termination Type"),
            merge: place("Merge"),
            lock_direction: place("Lock Direction"),
            event_distance: place("Event Distance"),
        }
    }

    /// Speed, rates and jerks of a move, in units.
    fn dynamics(&self, call: &Call, system: &CoordinateSystem) -> Result<Dynamics, MotionError> {
        let units = |value, word, maximum| in_units(call.number(value), call.word(word), maximum);
        let jerk = |value, maximum| jerk_in_units(call.number(value), call.word(self.jerk_units), maximum);
        let speed = units(self.speed, self.speed_units, system.max_speed);
        let jerks = Jerks {
            acceleration: jerk(self.accel_jerk, system.max_acceleration_jerk),
            deceleration: jerk(self.decel_jerk, system.max_deceleration_jerk),
        };
        let dynamics = Dynamics {
            speed,
            acceleration: units(self.accel_rate, self.accel_units, system.max_acceleration),
            deceleration: units(self.decel_rate, self.decel_units, system.max_deceleration),
            shape: if call.word(self.profile) == S_CURVE {
                Shape::SCurve(jerks)
            } else {
                Shape::Trapezoidal(jerks)
            },
            last_speed: reference_speed(speed, system),
        };
        positive(dynamics.acceleration, self.accel_rate)?;
        positive(dynamics.deceleration, self.decel_rate)?;
        if let Some(jerk) = dynamics.limits().jerk {
            positive(jerk.acceleration, self.accel_jerk)?;
            positive(jerk.deceleration, self.decel_jerk)?;
        }
        Ok(dynamics)
    }

    /// Step 6: one mode for all units, a lock direction of that mode, a link for a master driven move.
    fn verify_mode(&self, call: &Call) -> Result<(), MotionError> {
        let master = verify::is_master_driven(call.number(self.speed_units));
        let others = [self.accel_units, self.decel_units, self.jerk_units];
        if others.iter().any(|units| verify::is_master_driven(call.number(*units)) != master) {
            return Err(MotionError::MdscUnitsConflict);
        }
        if (call.word(self.lock_direction) != 0) != master {
            return Err(MotionError::MdscLockDirectionConflict);
        }
        if master {
            return Err(MotionError::MdscNotActivated);
        }
        Ok(())
    }
}

/// A percentage of a maximum that is 0 leaves nothing to move with.
pub(super) fn positive(value: f64, operand: usize) -> Result<(), MotionError> {
    if value > 0.0 {
        Ok(())
    } else {
        Err(MotionError::ParameterOutOfRange(OperandIndex(operand as u8)))
    }
}

/// Verifies what every coordinated move has in common, lets `path` find the geometry between the start point
/// and the operands, and starts or queues the move.
pub(super) fn execute(
    motion: &mut Motion,
    execution: Execution,
    call: &Call,
    layout: &MoveLayout,
    least_axes: usize,
    path: impl FnOnce(&Motion, &System, Point) -> Result<Path, MotionError>,
) -> Result<(), MotionError> {
    let index = motion.target_system(call)?;
    if motion.systems[index].description.axes.len() < least_axes {
        return Err(super::no_target());
    }
    motion.verify_operands(call)?;
    layout.verify_mode(call)?;
    if !call.array(layout.event_distance).is_empty() {
        return Err(MotionError::FeatureNotSupported);
    }
    let system = &motion.systems[index];
    verify::axes_ready(system, &motion.axes)?;
    let dynamics = layout.dynamics(call, &system.description)?;
    verify::stoppable(system, &motion.axes, dynamics.is_s_curve())?;
    let termination = termination(call.word(layout.termination_type), &system.description)?;
    let start = start_point(motion, index);
    let path = path(motion, system, start)?;
    verify_conflicts(motion, index)?;
    if call.word(layout.merge) != MERGE_DISABLED && system.is_busy() {
        return Err(MotionError::FeatureNotSupported);
    }

    let planned = Move {
        path,
        limits: dynamics.limits(),
        data: Planned {
            execution,
            dynamics,
            termination,
        },
    };
    let accepted = Flag::Dn.mask() | Flag::Ip.mask();
    let tick = motion.clock.tick;
    let system = &mut motion.systems[index];
    if system.is_busy() {
        system
            .planner
            .enqueue(planned)
            .map_err(|_| MotionError::CoordinateSystemQueueFull)?;
        motion.controls.write(execution, accepted, 0, tick);
    } else {
        system.planner.start(planned, motion.clock.now());
        system.activity = Activity::Moving;
        system.in_actual_tolerance = false;
        system.in_command_tolerance = false;
        system.stale = true;
        motion.join_axes(index);
        motion.controls.write(execution, accepted | Flag::Ac.mask(), 0, tick);
    }
    Ok(())
}

/// The end of the last move in the queue, or where the axes are commanded to be.
fn start_point(motion: &Motion, index: usize) -> Point {
    let system = &motion.systems[index];
    let queued = if system.activity == Activity::Moving {
        system.planner.last_end()
    } else {
        None
    };
    queued.unwrap_or_else(|| {
        let mut point = Point::zeros();
        for (axis, coordinate) in system.description.axes.iter().zip(point.iter_mut()) {
            *coordinate = motion.axes.get(usize::from(*axis)).map_or(0.0, |axis| axis.command.position);
        }
        point
    })
}

/// Step 11: the queue, a stop under way, another coordinate system that holds one of the axes.
fn verify_conflicts(motion: &Motion, index: usize) -> Result<(), MotionError> {
    let system = &motion.systems[index];
    if system.activity == Activity::Moving && system.planner.is_full() {
        return Err(MotionError::CoordinateSystemQueueFull);
    }
    verify::not_stopping(system, &motion.axes)?;
    for (other_index, other) in motion.systems.iter().enumerate() {
        if other_index != index
            && other.is_busy()
            && let Some(place) = system.shared_axis(other)
        {
            return Err(MotionError::CoordinatedMotionInProcess(arcline_instruction_set::AxisIndex(place as u8)));
        }
    }
    Ok(())
}

fn termination(word: i32, system: &CoordinateSystem) -> Result<Termination, MotionError> {
    match word {
        0 if system.actual_tolerance <= 0.0 => Err(MotionError::InvalidActualTolerance),
        0 => Ok(Termination::ActualTolerance),
        1 => Ok(Termination::NoSettle),
        _ => Err(MotionError::FeatureNotSupported),
    }
}

/// The operand's point, absolute or counted from the start; axes beyond the operand keep the start's.
pub(super) fn target_point(values: &[f64], start: &Point, incremental: bool) -> Point {
    let mut target = *start;
    for (place, (coordinate, value)) in target.iter_mut().zip(values).enumerate() {
        *coordinate = if incremental { component(start, place) + value } else { *value };
    }
    target
}
