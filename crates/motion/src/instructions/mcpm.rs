//! MCPM, Motion Coordinated Path Move (spec/coordinated-instructions.md §23): X, Y, Z on a straight line, while Rx, Ry, Rz rotate about
//! one fixed axis.
//!
//! The rotation is a function of the position on the line, so an override, a change of dynamics and a stop leave the tool on its path.
//! The limits of both parts hold: if one of them is stricter in every respect, it determines the time. The path length of a rotation alone
//! is its angle. Units: position units, degrees.

use arcline_instruction_set::enumerations::{
    InterpolationType, Merge, MoveType, TerminationType, TimeUnits, UnitsMode, VelocityProfile,
};
use arcline_instruction_set::operands::Mcpm;
use arcline_instruction_set::{Call, MotionError, OperandIndex, Range};
use arcline_planner::Ending;
use arcline_planner::geometry::{Path, Point, Rotation};

use super::merging::{Master, StartMotion};
use super::moves::{self, JointLimits, Verified};
use super::{points, programmed};
use crate::call_data::ReceivedData;
use crate::dynamics::PathLimits;
use crate::dynamics::{self, Dynamics, JerkRate, Jerks, Maxima, ProgrammedProfile, speed_for_jerk};
use crate::execution::Execution;
use crate::machine::{CoordinateSystem, LimitPolicy, Orientation};
use crate::masters::links::MasterLink;
use crate::motion::Motion;
use crate::motion::operands::no_target;
use crate::path_data::{DynamicsData, PathData};
use crate::range;
use crate::system::Termination;
use crate::system::heading;
use crate::verify::{self, members};

/// Checks that the members of the path are in their ranges (13), and that reserved ones are 0 (99).
fn verify_path(path: &PathData, operand: OperandIndex) -> Result<(), MotionError> {
    let finite = path.position.iter().all(|number| Range::Any.holds(*number));
    let [base, fourth, sixth, reserved] = path.turns_counters;
    // Only one of the joints J4 and J6 turns the tool about X3.
    let counted = base == 0 && reserved == 0 && (fourth == 0 || sixth == 0);
    let terminated = match path.termination_type {
        Some(TerminationType::ActualTolerance | TerminationType::NoSettle) => true,
        Some(TerminationType::CommandToleranceProgrammed) => Range::NotNegative.holds(path.command_tolerance_linear),
        _ => false,
    };
    let fits = finite && path.robot_configuration == 0 && counted && path.move_type.is_some() && terminated;
    match path.interpolation_type.filter(|_| fits) {
        None => Err(MotionError::ParameterOutOfRange(operand)),
        Some(InterpolationType::PointToPoint) => Err(MotionError::FeatureNotSupported),
        Some(InterpolationType::Linear) => Ok(()),
    }
}

/// The members of the dynamics are in their ranges.
fn are_in_range(dynamics: &DynamicsData) -> bool {
    let rates = |[speed, acceleration, deceleration]: [f64; 3]| {
        let above = |number: f64| Range::Positive.holds(number);
        Range::NotNegative.holds(speed) && above(acceleration) && above(deceleration)
    };
    let mut jerks = dynamics.jerks.iter();
    let shaped = match dynamics.profile {
        None => false,
        Some(VelocityProfile::Trapezoidal) => true,
        Some(VelocityProfile::SCurve) => jerks.all(|jerk| Range::Positive.holds(*jerk) && *jerk <= 100.0),
    };
    let modes = dynamics.units_mode.is_some() && dynamics.time_units.is_some();
    modes && shaped && rates(dynamics.linear) && rates(dynamics.orientation)
}

pub(super) fn execute(
    motion: &mut Motion,
    execution: Execution,
    call: &Call,
    data: &ReceivedData,
) -> Result<(), MotionError> {
    let index = motion.target_system(call)?;
    let orientation = motion.systems[index].description.orientation.ok_or_else(no_target)?;
    let Mcpm {
        path: path_operand,
        // Always 1.
        length: _,
        dynamics: dynamics_operand,
        lock,
    } = motion.operands(call)?;
    let tags = data.path()?;
    verify_path(&tags.path, path_operand.index)?;
    if !are_in_range(&tags.dynamics) {
        return Err(dynamics_operand.out_of_range());
    }
    let driven = tags.dynamics.time_units == Some(TimeUnits::MasterUnits);
    let link = motion.systems[index].links.newest().copied();
    programmed::verify_lock(&lock, driven, link.as_ref())?;
    let link = link.filter(|_| driven);
    // Percentages by a master refer to the maxima at its nominal speed (spec/coordinated-instructions.md §18.1).
    if link.is_some_and(|link| !link.has_nominal) && tags.dynamics.units_mode == Some(UnitsMode::Percent) {
        return Err(dynamics_operand.out_of_range());
    }
    let driven_by = link.as_ref().map(|link| programmed::driven_by(motion, &lock, link));
    let driven_by = driven_by.transpose()?;
    let master = Master::of(driven_by, link);
    let system = &motion.systems[index];
    if !system.travel.can_turn() {
        return Err(MotionError::FeatureNotSupported);
    }
    verify::ready(members(system, &motion.axes))?;
    verify::not_homing(members(system, &motion.axes))?;
    verify::system_stoppable(
        system,
        &motion.axes,
        tags.dynamics.profile == Some(VelocityProfile::SCurve),
    )?;
    let (start, shift) = (points::start_point(motion, index), points::queue_shift(motion, index));
    let headings = [
        motion.systems[index].heading(&motion.axes),
        motion.systems[index].heading_shift(&motion.axes),
    ];
    let path_move = PathMove::of(&tags.path, &(start + shift), headings);
    range::verify_point(
        &motion.systems[index],
        &motion.axes,
        &path_move.path.end(),
        path_operand.index,
    )?;
    let (termination, ending) = termination(&tags.path, &system.description, &path_move)?;
    let maxima = Maxima::from(&system.description);
    let [moves_by, turns_by] = rates(&tags.dynamics, &maxima, &orientation, link.as_ref());
    let (mut dynamics, own) = path_move.dynamics(moves_by, turns_by);
    if !(dynamics.acceleration > 0.0 && dynamics.deceleration > 0.0) {
        return Err(dynamics_operand.out_of_range());
    }
    let path = path_move.path.shifted(&-shift);
    moves::verify_conflicts(motion, index, Merge::Disabled)?;
    verify::no_overtravel_to(&motion.systems[index], &motion.axes, &path.end())?;
    let joints = JointLimits {
        path: moves::path_limits(motion, index, &path_move.path, path_move.rotation.as_ref(), headings[0])?,
        corner: f64::INFINITY,
    };
    let rest = StartMotion::rest();
    let (taken, joints) = match &master {
        Some(master) => (rest.by_master(motion, index, master)?, joints.by_master(&master.link)),
        None => (rest, joints),
    };
    let joints = JointLimits {
        path: own.and(&joints.path),
        ..joints
    };
    dynamics.keep_to(&joints.path);
    let verified = Verified {
        execution,
        path,
        in_positions: path_move.path,
        rotation: path_move.rotation,
        heading: Some(path_move.heading),
        dynamics,
        joints,
        termination,
        ending,
        events: None,
        master,
        residual: None,
    };
    verified.launch(motion, index, &taken)
}

/// The path, the rotation and the final orientation of a move.
struct PathMove {
    path: Path,
    rotation: Option<Rotation>,
    /// Rx, Ry, Rz at its end.
    heading: Point,
}

impl PathMove {
    /// The move from a point and an orientation in the queue's frame; `shift` is the displacement from that frame to the present one. The turns counter of J6
    /// counts whole turns of Rz; that of J4, which turns the opposite way, counts them negatively. The counters of an absolute move are those at
    /// its end; those of an incremental move add turns to its path.
    fn of(data: &PathData, start: &Point, [heading, shift]: [Point; 2]) -> PathMove {
        let [x, y, z, rx, ry, rz] = data.position;
        let [_, fourth, sixth, _] = data.turns_counters;
        let turns = f64::from(i32::from(sixth) - i32::from(fourth));
        let (mut end, angles) = (Point::new(x, y, z), Point::new(rx, ry, rz));
        let rotation = if data.move_type == Some(MoveType::Incremental) {
            end += start;
            heading::rotation_by(&heading, &(heading + angles), turns)
        } else {
            let counted = Point::z() * (360.0 * turns);
            heading::rotation_between(&heading, &(heading::normal(&angles) + counted - shift))
        };
        let mut path = Path::line(*start, end);
        if path.length() == 0.0 {
            path = Path::stationary(*start, rotation.angle());
        }
        PathMove {
            path,
            rotation: Some(rotation),
            heading: rotation.ended().near,
        }
    }

    /// The dynamics along the path as programmed, and the limits that the rotation puts on the speed along the path.
    fn dynamics(&self, moves: Dynamics, turns: Dynamics) -> (Dynamics, PathLimits) {
        let (length, angle) = (
            self.path.length(),
            self.rotation.map_or(0.0, |rotation| rotation.angle()),
        );
        if self.path.stands() {
            return (turns, PathLimits::UNLIMITED);
        }
        if angle <= 0.0 || length <= 0.0 {
            return (moves, PathLimits::UNLIMITED);
        }
        let ratio = length / angle;
        let pace = PathLimits {
            speed: turns.speed * ratio,
            acceleration: turns.acceleration * ratio,
            deceleration: turns.deceleration * ratio,
        };
        (moves, pace)
    }
}

/// The termination of the move, and its junction to a successor. A rotation alone has no tolerance: its blends may take its whole path, or
/// half of it with a blend at both ends.
fn termination(
    data: &PathData,
    system: &CoordinateSystem,
    path_move: &PathMove,
) -> Result<(Termination, Ending), MotionError> {
    match data.termination_type {
        Some(TerminationType::ActualTolerance) if system.actual_tolerance <= 0.0 => {
            Err(MotionError::InvalidActualTolerance)
        }
        Some(TerminationType::ActualTolerance) => {
            Ok((Termination::ActualTolerance(system.actual_tolerance), Ending::Stop))
        }
        Some(TerminationType::CommandToleranceProgrammed) if system.joint_limits == LimitPolicy::Enforce => {
            Err(MotionError::FeatureNotSupported)
        }
        Some(TerminationType::CommandToleranceProgrammed) => {
            let tolerance = if path_move.path.stands() {
                f64::MAX
            } else {
                data.command_tolerance_linear
            };
            Ok((Termination::Command, Ending::Blend { tolerance }))
        }
        _ => Ok((Termination::Command, Ending::Stop)),
    }
}

/// The programmed dynamics of both parts, in units; percentages by a master refer to the maxima at its nominal speed
/// (spec/coordinated-instructions.md §18.1).
fn rates(data: &DynamicsData, linear: &Maxima, orientation: &Orientation, link: Option<&MasterLink>) -> [Dynamics; 2] {
    let percent = data.units_mode == Some(UnitsMode::Percent);
    let nominal = link.filter(|_| percent).map_or(1.0, |link| link.nominal);
    let [acceleration, deceleration] = data.jerks.map(JerkRate::PercentOfTime);
    let jerks = Jerks {
        acceleration,
        deceleration,
    };
    let shape = if data.profile == Some(VelocityProfile::SCurve) {
        ProgrammedProfile::SCurve(jerks)
    } else {
        ProgrammedProfile::Trapezoidal(jerks)
    };
    let in_units = |number: f64, maximum: f64| {
        if percent {
            dynamics::percent(number, maximum)
        } else {
            number
        }
    };
    let part = |[speed, acceleration, deceleration]: [f64; 3], maxima: [f64; 3]| {
        let speed = in_units(speed, maxima[0]) / nominal;
        Dynamics {
            speed,
            acceleration: in_units(acceleration, maxima[1]) / (nominal * nominal),
            deceleration: in_units(deceleration, maxima[2]) / (nominal * nominal),
            shape,
            last_speed: speed_for_jerk(speed, maxima[0] / nominal),
        }
    };
    [
        part(data.linear, [linear.speed, linear.acceleration, linear.deceleration]),
        part(
            data.orientation,
            [
                orientation.max_speed,
                orientation.max_acceleration,
                orientation.max_deceleration,
            ],
        ),
    ]
}
