//! MAOC, Motion Arm Output Cam (spec/axis-and-data-types.md §5).

use arcline_instruction_set::{Call, Flag, Mnemonic, MotionError, OperandIndex};

use super::axis_moves::not_shut_down;
use super::camming::on_turn;
use super::mapc::crossing;
use super::place;
use crate::control::Execution;
use crate::masters::Reference;
use crate::masters::cam::{Lock, Mode};
use crate::material::Sent;
use crate::motion::Motion;
use crate::output::{Arming, Program, Word};

/// Places of MAOC's operands.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Layout {
    target: usize,
    output: usize,
    input: usize,
    start: usize,
    end: usize,
    mode: usize,
    schedule: usize,
    axis_arm: usize,
    cam_arm: usize,
    reference: usize,
}

/// Execution Schedule: when the output cam that is armed ends.
const PENDING: i32 = 1;

impl Layout {
    pub(super) fn new() -> Self {
        let place = |name| place(Mnemonic::Maoc, name);
        Layout {
            target: place("Execution Target"),
            output: place("Output"),
            input: place("Input"),
            start: place("Cam Start Position"),
            end: place("Cam End Position"),
            mode: place("Execution Mode"),
            schedule: place("Execution Schedule"),
            axis_arm: place("Axis Arm Position"),
            cam_arm: place("Cam Arm Position"),
            reference: place("Position Reference"),
        }
    }

    /// Ranges in the order of the faceplate.
    fn verify(&self, motion: &Motion, axis: usize, call: &Call) -> Result<(), MotionError> {
        let [start, end, arm] = [self.start, self.end, self.cam_arm].map(|operand| call.number(operand));
        let beyond = |operand: usize| MotionError::ParameterOutOfRange(OperandIndex(operand as u8));
        let axis_arm = match crossing(call.word(self.schedule)) {
            Some(_) => on_turn(&motion.axes[axis], call.number(self.axis_arm), self.axis_arm),
            None => Ok(()),
        };
        let cam_arm = call.word(self.schedule) != PENDING && !(start..=end).contains(&arm);
        let own = [
            (self.end, if start < end { Ok(()) } else { Err(beyond(self.end)) }),
            (self.axis_arm, axis_arm),
            (self.cam_arm, if cam_arm { Err(beyond(self.cam_arm)) } else { Ok(()) }),
        ];
        let own = own
            .into_iter()
            .find_map(|(place, checked)| checked.err().map(|error| (place, error)));
        match (motion.verify_operands(call), own) {
            (Err(MotionError::ParameterOutOfRange(first)), Some((place, error))) => {
                Err(if usize::from(first.0) <= place {
                    MotionError::ParameterOutOfRange(first)
                } else {
                    error
                })
            }
            (Ok(()), Some((_, error))) => Err(error),
            (verified, _) => verified,
        }
    }
}

/// The execution target that an operand names.
///
/// # Errors
/// `IllegalExecutionTarget` (35) where the axis has none of that number.
pub(super) fn target(motion: &Motion, axis: u16, call: &Call, operand: usize) -> Result<usize, MotionError> {
    let targets = motion.axes[usize::from(axis)].outputs.len();
    let target = usize::try_from(call.word(operand)).ok();
    target
        .filter(|target| *target < targets)
        .ok_or(MotionError::IllegalExecutionTarget)
}

pub(super) fn execute(motion: &mut Motion, execution: Execution, call: &Call, sent: &Sent) -> Result<(), MotionError> {
    let layout = motion.layouts.maoc;
    let axis = motion.target_axis(call)?;
    let at = usize::from(axis);
    layout.verify(motion, at, call)?;
    not_shut_down(&motion.axes[at])?;
    let target = target(motion, axis, call, layout.target)?;
    let (cam, [output, input]) = sent.output_cam()?;
    let program = Program {
        cam,
        mode: match call.word(layout.mode) {
            1 => Mode::Continuous,
            2 => Mode::Persistent,
            _ => Mode::Once,
        },
        execution,
    };
    let schedule = call.word(layout.schedule);
    let clock = motion.clock;
    let reference = if call.word(layout.reference) == 0 {
        Reference::Actual
    } else {
        Reference::Command
    };
    let point = motion.axes.master_at(axis, reference, &motion.clock).point;
    let state = &mut motion.axes[at];
    let word = |operand: usize, bits: u32| {
        call.tag(operand).map(|tag| Word {
            tag,
            mask: u32::MAX,
            bits,
        })
    };
    let lock = crossing(schedule).map(|way| Lock {
        position: call.number(layout.axis_arm) - state.redefined,
        way,
        unwind: state.unwind,
    });
    let Some(place) = state.outputs.target_mut(target) else {
        return Err(MotionError::IllegalExecutionTarget);
    };
    let ended = if schedule == PENDING {
        place.wait(program, &clock)
    } else {
        let arming = Arming {
            lock,
            entry: call.number(layout.cam_arm),
            reference,
            output: word(layout.output, output).unwrap_or_default(),
            input: word(layout.input, input),
        };
        place.begin(program, &arming, point, &clock)
    };
    let written = place.write(&clock);
    if let Some(ended) = ended {
        motion.end_move(ended, 0);
    }
    motion.write_word(written);
    motion.controls.write(execution, Flag::Ip.mask(), 0, clock.tick);
    motion.done_next_update(execution, axis, None);
    Ok(())
}
