//! MCTPO, Motion Calculate Transform Position with Orientation (spec/coordinated-instructions.md §22.8, §25): nothing moves.

use arcline_instruction_set::{Call, Mnemonic, MotionError, OperandIndex};
use arcline_kinematics::{Configuration, Pose, Turns, Wrist, end_of_arm, tool_centre};

use super::mct::verify_linear;
use super::{mcto, place};
use crate::control::Execution;
use crate::machine::MAX_SYSTEM_AXES;
use crate::material::Sent;
use crate::motion::Motion;
use crate::transforms::robot::refused;

/// Places of MCTPO's operands.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Layout {
    transform: mcto::Layout,
    direction: usize,
    reference: usize,
    result: usize,
    configuration: usize,
    turns: usize,
}

/// Transform Direction: from joints to the tool centre.
const FORWARD: i32 = 0;
/// Transform Direction: from the tool centre to joints.
const INVERSE: i32 = 1;

impl Layout {
    pub(super) fn new() -> Self {
        let place = |name| place(Mnemonic::Mctpo, name);
        Layout {
            transform: mcto::Layout::of(Mnemonic::Mctpo),
            direction: place("Transform Direction"),
            reference: place("Reference Position"),
            result: place("Transform Position"),
            configuration: place("Robot Configuration"),
            turns: place("Turns Counter"),
        }
    }

    /// What the robot can be asked for: its own configurations, turns of joints that it has.
    fn solution(&self, wrist: Wrist, bits: i32, turns: [i16; 4]) -> Result<(Configuration, Turns), MotionError> {
        let configuration = Configuration::from_bits(bits);
        if configuration.bits() != bits || !wrist.has(configuration) {
            return Err(MotionError::ParameterOutOfRange(OperandIndex(self.configuration as u8)));
        }
        let [j1, j4, j6, reserved] = turns;
        if reserved != 0 || !wrist.counts([j1, j4, j6]) {
            return Err(MotionError::ParameterOutOfRange(OperandIndex(self.turns as u8)));
        }
        Ok((configuration, [j1, j4, j6]))
    }
}

pub(super) fn execute(motion: &mut Motion, execution: Execution, call: &Call, sent: &Sent) -> Result<(), MotionError> {
    let layout = motion.layouts.mctpo;
    motion.target_system(call)?;
    motion.verify_operands(call)?;
    let calculation = sent.calculation()?;
    let (source, target, robot) = layout.transform.pair(motion, call)?;
    let direction = call.word(layout.direction);
    if direction != FORWARD && direction != INVERSE {
        return Err(MotionError::TransformDirectionNotSupported);
    }
    layout.transform.verify_frames(&calculation.frames)?;
    for index in [source, target] {
        verify_linear(motion, &motion.systems[index].description.axes)?;
    }
    let answer = &calculation.answer;
    if answer.room() < MAX_SYSTEM_AXES {
        return Err(MotionError::ParameterOutOfRange(OperandIndex(layout.result as u8)));
    }
    let mut reference = [0.0; MAX_SYSTEM_AXES];
    for (number, given) in reference.iter_mut().zip(call.array(layout.reference)) {
        *number = *given;
    }
    let [work, tool] = [calculation.frames.work, calculation.frames.tool].map(|frame| Pose::new(frame.coordinates));
    if direction == FORWARD {
        let taken = robot.forward(&reference).map_err(refused)?;
        let [x, y, z, rx, ry, rz] = tool_centre(&work, &taken.pose, &tool).coordinates();
        let [j1, j4, j6] = taken.turns.map(f64::from);
        let bits = f64::from(taken.configuration.bits());
        answer.give(&[x, y, z, rx, ry, rz, bits, j1, j4, j6, 0.0]);
    } else {
        let (configuration, turns) = layout.solution(robot.wrist(), calculation.configuration, calculation.turns)?;
        let end = end_of_arm(&work, &Pose::new(reference), &tool);
        let joints = robot.inverse(&end, configuration, turns).map_err(refused)?;
        answer.give(&joints);
    }
    motion.done(execution);
    Ok(())
}
