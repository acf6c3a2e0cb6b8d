//! MCTPO, Motion Calculate Transform Position with Orientation (spec/coordinated-instructions.md §22.8, §25): moves no axis.

use arcline_instruction_set::enumerations::TransformDirection;
use arcline_instruction_set::operands::Mctpo;
use arcline_instruction_set::{Call, MotionError, OperandIndex};
use arcline_kinematics::{Configuration, Pose, Turns, Wrist, end_of_arm, tool_centre};

use super::mct::verify_linear;
use super::mcto;
use crate::call_data::{Calculation, ReceivedData};
use crate::execution::Execution;
use crate::machine::MAX_SYSTEM_AXES;
use crate::motion::Motion;
use crate::transforms::robot::refused;

/// The configuration and the turns, if the robot has them; otherwise 13 with their operand.
fn solution(
    wrist: Wrist,
    calculation: &Calculation,
    [configuration_operand, turns_operand]: [OperandIndex; 2],
) -> Result<(Configuration, Turns), MotionError> {
    let bits = calculation.configuration;
    let configuration = Configuration::from_bits(bits);
    if configuration.bits() != bits || !wrist.has(configuration) {
        return Err(MotionError::ParameterOutOfRange(configuration_operand));
    }
    let [j1, j4, j6, reserved] = calculation.turns;
    if reserved != 0 || !wrist.counts([j1, j4, j6]) {
        return Err(MotionError::ParameterOutOfRange(turns_operand));
    }
    Ok((configuration, [j1, j4, j6]))
}

pub(super) fn execute(
    motion: &mut Motion,
    execution: Execution,
    call: &Call,
    data: &ReceivedData,
) -> Result<(), MotionError> {
    motion.target_system(call)?;
    let Mctpo {
        robot_system,
        work_frame,
        tool_frame,
        transform_direction,
        reference_position,
        transform_position,
        robot_configuration,
        turns_counter,
    } = motion.operands(call)?;
    let calculation = data.calculation()?;
    let (source, target, robot) = mcto::pair(motion, call, &robot_system)?;
    let forward = match *transform_direction {
        TransformDirection::Forward => true,
        TransformDirection::Inverse => false,
        _ => return Err(MotionError::TransformDirectionNotSupported),
    };
    mcto::verify_frames([work_frame.index, tool_frame.index], &calculation.frames)?;
    for index in [source, target] {
        verify_linear(motion, &motion.systems[index].description.axes)?;
    }
    let results = &calculation.results;
    if results.elements() < MAX_SYSTEM_AXES {
        return Err(transform_position.out_of_range());
    }
    let mut reference = [0.0; MAX_SYSTEM_AXES];
    for (number, given) in reference.iter_mut().zip(reference_position.as_slice()) {
        *number = *given;
    }
    let [work, tool] = [calculation.frames.work, calculation.frames.tool].map(|frame| Pose::new(frame.coordinates));
    if forward {
        let taken = robot.forward(&reference).map_err(refused)?;
        let [x, y, z, rx, ry, rz] = tool_centre(&work, &taken.pose, &tool).coordinates();
        let [j1, j4, j6] = taken.turns.map(f64::from);
        let bits = f64::from(taken.configuration.bits());
        results.set(&[x, y, z, rx, ry, rz, bits, j1, j4, j6, 0.0]);
    } else {
        let (configuration, turns) = solution(
            robot.wrist(),
            calculation,
            [robot_configuration.index, turns_counter.index],
        )?;
        let end = end_of_arm(&work, &Pose::new(reference), &tool);
        let joints = robot.inverse(&end, configuration, turns).map_err(refused)?;
        results.set(&joints);
    }
    motion.done(execution);
    Ok(())
}
