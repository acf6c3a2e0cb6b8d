//! MCT, Motion Coordinated Transform (spec/coordinated-instructions.md §19, §20), and the checks that it shares with MCTP.

use arcline_instruction_set::operands::{Mct, OperandValue};
use arcline_instruction_set::{AxisId, AxisIndex, Call, Detail, Flag, MotionError, RealArray, SystemId};
use arcline_kinematics::{GeometryError, Robot};
use arcline_planner::geometry::{Frame, Point};

use crate::axes::share;
use crate::axis::generator_kind::GeneratorKind;
use crate::execution::Execution;
use crate::motion::Motion;
use crate::order::{DependencyCycle, Follower, PlannedOrder};
use crate::range;
use crate::tolerance::CONSISTENT_UNITS;
use crate::transforms::TransformId;
use crate::transforms::robot::{Joints, RobotMap};
use crate::transforms::sides::Positions;
use crate::transforms::transform::{Map, Transform};
use crate::verify::{self, members};

/// Largest angle of an orientation, degrees.
const LARGEST_ANGLE: f64 = 360.0;

/// EXERR of error 61 (spec/coordinated-instructions.md §19.6): source and target are the same system.
pub(super) const SAME_SYSTEM: Detail = Detail(2);
/// EXERR of error 61: neither system is Cartesian, or the source has the wrong geometry.
pub(super) const WRONG_SOURCE: Detail = Detail(5);
/// EXERR of error 61: the target has the wrong geometry.
pub(super) const WRONG_TARGET: Detail = Detail(6);
/// EXERR of error 61: an axis belongs to both systems.
pub(super) const AXIS_IN_BOTH: Detail = Detail(7);
/// EXERR of error 61: another coordinated motion uses axes of the target.
const TARGET_IN_USE: Detail = Detail(8);
/// EXERR of error 61: the link lengths are invalid.
pub(super) const LINK_LENGTHS: Detail = Detail(9);
/// EXERR of error 61: the offsets are invalid.
pub(super) const OFFSETS: Detail = Detail(10);
/// EXERR of error 61: the dimensions differ.
const DIMENSIONS_DIFFER: Detail = Detail(17);

/// The frame of the target in the source: MCT, MCTP.
pub(super) fn frame(
    orientation: &RealArray,
    translation: &OperandValue<RealArray>,
    dimension: usize,
) -> Result<Frame, MotionError> {
    let angles = vector(orientation.as_slice());
    let shifts = vector(translation.as_slice());
    for (member, angle) in angles.iter().enumerate() {
        // Rotations that would turn the axes out of the dimensions of the system (spec/coordinated-instructions.md §19.3).
        let turns_out = match dimension {
            3 => false,
            2 => member != 2,
            _ => true,
        };
        if angle.abs() > LARGEST_ANGLE || (turns_out && *angle != 0.0) {
            return Err(MotionError::InvalidOrientationAngle(Detail(member as i8)));
        }
    }
    if shifts.iter().skip(dimension).any(|shift| *shift != 0.0) {
        return Err(translation.out_of_range());
    }
    Ok(Frame::new(angles, shifts))
}

pub(super) fn execute(motion: &mut Motion, execution: Execution, call: &Call) -> Result<(), MotionError> {
    let source = motion.target_system(call)?;
    let Mct {
        target_system,
        orientation,
        translation,
    } = motion.operands(call)?;
    let target = motion.system_of(&target_system)?;
    let robot = verify_pair(motion, source, target)?;
    verify_free(motion, target)?;
    let [from, to] = [source, target].map(|index| &motion.systems[index].description.axes);
    let frame = frame(&orientation, &translation, from.len())?;
    let shift = vector(translation.as_slice());
    for index in [source, target] {
        range::verify_point(&motion.systems[index], &motion.axes, &shift, translation.index)?;
    }
    let map = match robot {
        None => Map::Frames(frame),
        Some((robot, side)) => {
            let joints = match side {
                Joints::Target => positions(motion, to),
                Joints::Source => positions(motion, from),
            };
            Map::Robot(RobotMap::new(frame, robot, side, joints))
        }
    };
    let transform = Transform::new(Some(execution), source, map, from, to);
    begin(motion, execution, target, transform)
}

/// The error of two systems that cannot be linked.
pub(super) fn refused(detail: Detail) -> MotionError {
    MotionError::ConnectionConflict(detail)
}

/// Begins a transform between two systems that can be linked, from their present states.
pub(super) fn begin(
    motion: &mut Motion,
    execution: Execution,
    target: SystemId,
    transform: Transform,
) -> Result<(), MotionError> {
    verify_linear(motion, &transform.source)?;
    verify_linear(motion, &transform.target)?;
    for index in [transform.source_system, target] {
        let system = &motion.systems[index];
        verify::ready(members(system, &motion.axes))?;
        verify::not_homing(members(system, &motion.axes))?;
        verify::system_stoppable(system, &motion.axes, true)?;
    }
    let order = verify_chain(motion, target, &transform)?;
    verify_at_rest(motion, &transform)?;
    meet(motion, &transform)?;

    motion
        .transforms
        .begin(TransformId::of_target(target), transform, &mut motion.axes);
    motion.order.take(order);
    let started = Flag::Dn.mask() | Flag::Ip.mask();
    motion.controls.write(execution, started, 0);
    Ok(())
}

/// Checks that the two systems can be linked (spec/coordinated-instructions.md §19.3, §19.4, §19.6). Returns the robot of one of them, if
/// there is one.
pub(super) fn verify_pair(
    motion: &Motion,
    source: SystemId,
    target: SystemId,
) -> Result<Option<(Robot, Joints)>, MotionError> {
    if source == target {
        return Err(refused(SAME_SYSTEM));
    }
    if motion.systems[source].is_oriented() {
        return Err(refused(WRONG_SOURCE));
    }
    if motion.systems[target].is_oriented() {
        return Err(refused(WRONG_TARGET));
    }
    let robot = match [source, target].map(|index| motion.systems[index].robot) {
        [Some(_), Some(_)] => return Err(refused(WRONG_SOURCE)),
        [Some(robot), None] => Some((robot, Joints::Source)),
        [None, Some(robot)] => Some((robot, Joints::Target)),
        [None, None] => None,
    };
    let [from, to] = [source, target].map(|index| &motion.systems[index].description.axes);
    if share(from, to) {
        return Err(refused(AXIS_IN_BOTH));
    }
    let robot = match robot {
        Some((Err(GeometryError::LinkLengths), _)) => return Err(refused(LINK_LENGTHS)),
        Some((Err(GeometryError::Offsets), _)) => return Err(refused(OFFSETS)),
        Some((Ok(robot), side)) => Some((robot, side)),
        None => None,
    };
    if from.len() != to.len() {
        return Err(refused(DIMENSIONS_DIFFER));
    }
    Ok(robot)
}

/// Checks that no other coordinated motion uses axes of the target.
pub(super) fn verify_free(motion: &Motion, target: SystemId) -> Result<(), MotionError> {
    let axes = &motion.systems[target].description.axes;
    let mut others = motion.systems.ids().zip(motion.systems.iter());
    if others.any(|(index, other)| index != target && other.is_busy() && share(&other.description.axes, axes)) {
        return Err(MotionError::ConnectionConflict(TARGET_IN_USE));
    }
    Ok(())
}

/// Command positions of a list of axes.
pub(super) fn positions(motion: &Motion, axes: &[AxisId]) -> Positions {
    let mut positions = Positions::default();
    for (axis, position) in axes.iter().zip(positions.iter_mut()) {
        *position = motion.axes[*axis].command.position;
    }
    positions
}

pub(super) fn verify_linear(motion: &Motion, axes: &[AxisId]) -> Result<(), MotionError> {
    let rotary = axes.iter().position(|axis| motion.axes[*axis].unwind.is_some());
    match rotary {
        Some(member) => Err(MotionError::AxesInTransformMustBeLinear(AxisIndex(member as u8))),
        None => Ok(()),
    }
}

/// Checks that each system is the target of one transform only, that there are no circles, and that no motion of a cancelled transform
/// still brakes.
fn verify_chain(motion: &mut Motion, target: SystemId, transform: &Transform) -> Result<PlannedOrder, MotionError> {
    let id = TransformId::of_target(target);
    let same = motion.transforms.get(id);
    if same.is_some_and(|running| running.source_system == transform.source_system && !running.braking) {
        return Err(MotionError::TransformInProgress);
    }
    let brakes = |axis: AxisId| {
        let mut braking = motion.transforms.iter().filter(|(_, other)| other.braking);
        motion.axes[axis].stops_after_transform() || braking.any(|(_, other)| other.has(axis))
    };
    if transform.axes().any(brakes) {
        return Err(MotionError::TransformIsCanceling);
    }
    let mut others = motion.transforms.iter();
    if others.any(|(_, other)| share(&other.target, &transform.target)) {
        return Err(MotionError::CoordinateSystemChaining);
    }
    drop(others);
    let order = motion.plan_order(Follower::Target(id, transform));
    order.map_err(|DependencyCycle| MotionError::CoordinateSystemChaining)
}

/// Checks that no axis of either side moves; a gear may hold an axis.
fn verify_at_rest(motion: &Motion, transform: &Transform) -> Result<(), MotionError> {
    for side in [&transform.source, &transform.target] {
        let moving = side.iter().position(|axis| {
            let axis = &motion.axes[*axis];
            let held = |kind| matches!(kind, GeneratorKind::Transform | GeneratorKind::Gear);
            axis.transforms.controlled || axis.command.velocity != 0.0 || axis.sum.active().any(|(kind, _)| !held(kind))
        });
        if let Some(member) = moving {
            return Err(MotionError::AxisInMotion(AxisIndex(member as u8)));
        }
    }
    Ok(())
}

/// Brings the source to the position that belongs to the target (spec/coordinated-instructions.md §19.1): axes without a drive are set to it if
/// no generator holds them; all other axes must already be there.
fn meet(motion: &mut Motion, transform: &Transform) -> Result<(), MotionError> {
    let source = transform.source_of(&positions(motion, &transform.target))?;
    transform.verify(&source)?;
    let deviates = |axis: AxisId, position: f64| (motion.axes[axis].command.position - position).abs();
    for (member, (axis, position)) in transform.source.iter().zip(source.iter()).enumerate() {
        let state = &motion.axes[*axis];
        let settable = state.is_virtual && state.sum.is_idle();
        let beyond = position.abs() > state.range;
        if beyond || !settable && deviates(*axis, *position) > CONSISTENT_UNITS {
            return Err(MotionError::InvalidTransformPosition(Detail(member as i8)));
        }
    }
    for (axis, position) in transform.source.iter().zip(source.iter()) {
        let state = &mut motion.axes[*axis];
        if state.is_virtual && state.sum.is_idle() && state.command.position != *position {
            state.set_virtual(*position);
        }
    }
    Ok(())
}

fn vector(numbers: &[f64]) -> Point {
    let mut vector = Point::zeros();
    for (component, number) in vector.iter_mut().zip(numbers) {
        *component = *number;
    }
    vector
}
