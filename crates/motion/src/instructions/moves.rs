//! What MCLM and MCCM share: dynamics, termination, and the way into the queue.

use arcline_instruction_set::{AxisIndex, Call, Flag, Mnemonic, MotionError, OperandIndex};
use arcline_planner::geometry::{Path, Point};
use arcline_planner::profile::Phase;
use arcline_planner::{Ending, Momentum, Move};

use super::place;
use crate::axis::Axis;
use crate::control::Execution;
use crate::dynamics::{Dynamics, Jerks, Shape, in_units, jerk_in_units, reference_speed};
use crate::machine::{AxisLimits, CoordinateSystem, Corner};
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
    merge_speed: usize,
    command_tolerance: usize,
    lock_direction: usize,
    event_distance: usize,
}

/// Move Type: the position counts from the start of the move.
pub(super) const INCREMENTAL: i32 = 1;
/// Profile: S-curve.
const S_CURVE: i32 = 1;
/// Merge: Disabled.
const MERGE_DISABLED: i32 = 0;
/// Merge: All Motion.
const MERGE_ALL: i32 = 2;
/// Merge Speed: Current.
const CURRENT: i32 = 1;

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
            merge_speed: place("Merge Speed"),
            command_tolerance: place("Command Tolerance"),
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

    /// How the move completes, and what happens there if it has a successor.
    fn termination(&self, call: &Call, system: &CoordinateSystem) -> Result<(Termination, Ending), MotionError> {
        let word = call.word(self.termination_type);
        let superposed = matches!(word, 2 | 3 | 6) && system.corner == Corner::Logix;
        if superposed && system.axis_limits == AxisLimits::Enforce {
            return Err(MotionError::FeatureNotSupported);
        }
        let ending = match word {
            0 if system.actual_tolerance <= 0.0 => return Err(MotionError::InvalidActualTolerance),
            2 => Ending::Blend {
                tolerance: system.command_tolerance,
            },
            3 => Ending::Blend {
                tolerance: f64::INFINITY,
            },
            4 => Ending::Contour { constrained: true },
            5 => Ending::Contour { constrained: false },
            6 => Ending::Blend {
                tolerance: call.number(self.command_tolerance),
            },
            _ => Ending::Stop,
        };
        let settles = if word == 0 {
            Termination::ActualTolerance
        } else {
            Termination::Command
        };
        Ok((settles, ending))
    }

    /// Step 6: one mode for all units, a lock direction of that mode, a link for a master driven move.
    fn verify_mode(&self, call: &Call) -> Result<(), MotionError> {
        let master = verify::is_master_driven(call.number(self.speed_units));
        let others = [self.accel_units, self.decel_units, self.jerk_units];
        if others
            .iter()
            .any(|units| verify::is_master_driven(call.number(*units)) != master)
        {
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
    let mut dynamics = layout.dynamics(call, &system.description)?;
    verify::stoppable(system, &motion.axes, dynamics.is_s_curve())?;
    let (termination, ending) = layout.termination(call, &system.description)?;
    let merge = call.word(layout.merge);
    let start = if merge == MERGE_DISABLED {
        start_point(motion, index)
    } else {
        command(motion, index, |axis| axis.command.position)
    };
    let path = path(motion, system, start)?;
    verify_conflicts(motion, index, merge)?;

    let momentum = Momentum {
        velocity: command(motion, index, |axis| axis.command.velocity),
        acceleration: command(motion, index, |axis| axis.command.acceleration),
    };
    if merge != MERGE_DISABLED && call.word(layout.merge_speed) == CURRENT && momentum.velocity.norm() > 0.0 {
        dynamics.set_speed(momentum.velocity.norm());
    }
    let planned = Move {
        path,
        limits: dynamics.limits(),
        ending,
        data: Planned {
            execution,
            dynamics,
            termination,
        },
    };
    let accepted = Flag::Dn.mask() | Flag::Ip.mask();
    let tick = motion.clock.tick;
    if motion.systems[index].contour.is_some() {
        if merge != MERGE_DISABLED && motion.systems[index].is_busy() {
            return Err(MotionError::FeatureNotSupported);
        }
        motion.queue_contour(index, planned)?;
        motion.controls.write(execution, accepted, 0, tick);
        return Ok(());
    }
    if merge == MERGE_DISABLED && motion.systems[index].is_busy() {
        let system = &mut motion.systems[index];
        system
            .planner
            .enqueue(planned, &motion.clock)
            .map_err(|_| MotionError::CoordinateSystemQueueFull)?;
        motion.controls.write(execution, accepted, 0, tick);
        return Ok(());
    }
    if merge != MERGE_DISABLED {
        terminate(motion, index, merge);
    }
    let system = &mut motion.systems[index];
    system.planner.merge(planned, momentum, &motion.clock);
    system.activity = Activity::Moving;
    system.shown_phase = Phase::Steady;
    system.in_actual_tolerance = false;
    system.in_command_tolerance = false;
    system.stale = true;
    motion.join_axes(index);
    motion.controls.write(execution, accepted | Flag::Ac.mask(), 0, tick);
    Ok(())
}

/// Ends what a merge takes over: the coordinated motion of this system and, for All Motion, of every other one
/// that shares an axis. Axes that the new move does not take brake by themselves.
fn terminate(motion: &mut Motion, index: usize, merge: i32) {
    motion.cancel_pending(index);
    motion.end_active(index);
    motion.systems[index].planner.clear_active();
    if merge != MERGE_ALL {
        return;
    }
    for other in 0..motion.systems.len() {
        if other != index && motion.systems[index].shared_axis(&motion.systems[other]).is_some() {
            motion.abort_system_but(other, index);
        }
    }
}

/// A quantity of each axis of a coordinate system as a point.
fn command(motion: &Motion, index: usize, quantity: impl Fn(&Axis) -> f64) -> Point {
    let mut point = Point::zeros();
    for (axis, coordinate) in motion.systems[index].description.axes.iter().zip(point.iter_mut()) {
        *coordinate = motion.axes.get(usize::from(*axis)).map_or(0.0, &quantity);
    }
    point
}

/// The end of the last move in the queue, or where the axes are commanded to be.
fn start_point(motion: &Motion, index: usize) -> Point {
    let system = &motion.systems[index];
    let queued = if system.activity == Activity::Moving {
        system.last_end()
    } else {
        None
    };
    queued.unwrap_or_else(|| command(motion, index, |axis| axis.command.position))
}

/// Step 11: the queue, a stop under way, another coordinate system that holds one of the axes.
fn verify_conflicts(motion: &Motion, index: usize, merge: i32) -> Result<(), MotionError> {
    let system = &motion.systems[index];
    if merge == MERGE_DISABLED && system.activity == Activity::Moving && system.is_full() {
        return Err(MotionError::CoordinateSystemQueueFull);
    }
    verify::not_stopping(system, &motion.axes)?;
    if merge == MERGE_ALL {
        return Ok(());
    }
    for (other_index, other) in motion.systems.iter().enumerate() {
        if other_index != index
            && other.is_busy()
            && let Some(place) = system.shared_axis(other)
        {
            return Err(MotionError::CoordinatedMotionInProcess(AxisIndex(place as u8)));
        }
    }
    Ok(())
}

/// The operand's point, absolute or counted from the start; axes beyond the operand keep the start's.
pub(super) fn target_point(values: &[f64], start: &Point, incremental: bool) -> Point {
    let mut target = *start;
    for (place, (coordinate, value)) in target.iter_mut().zip(values).enumerate() {
        *coordinate = if incremental {
            component(start, place) + value
        } else {
            *value
        };
    }
    target
}
