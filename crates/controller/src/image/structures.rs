//! Structure tags that an instruction reads as a whole: the frames of MCTO and MCTPO, the other tags of MCTPO, and the path and the dynamics of
//! MCPM. Their values at the time of the call enter the tick with it (spec/coordinated-instructions.md §22.8 to
//! §25).
//!
//! Not here: cams, and the writes of an instruction to tags (`cams`).

use std::sync::Arc;

use arcline_instruction_set::operands::{Mcpm, Mctpo, OperandValue};
use arcline_instruction_set::predefined::{dynamics_data_offset, path_data_offset};
use arcline_instruction_set::{Enumeration, MotionError, TagAddress};
use arcline_motion::{Calculation, DynamicsData, Frame, Frames, PathData, PathMove, Results};

use super::Image;
use super::calls::tag_and_offset;

impl Image {
    /// The frames of a work and a tool.
    ///
    /// # Errors
    /// A tag removed since the call was bound: 13 with the operand.
    pub(super) fn frames(&self, work: &TagOperand, tool: &TagOperand) -> Result<Frames, MotionError> {
        let [work, tool] = [work, tool].map(|frame| self.frame(frame));
        Ok(Frames {
            work: work?,
            tool: tool?,
        })
    }

    /// The tags that MCTPO reads, and its results.
    ///
    /// # Errors
    /// As [`Image::frames`].
    pub(super) fn calculation(&self, operands: &Mctpo) -> Result<Calculation, MotionError> {
        let configuration = self.structure_of(&operands.robot_configuration)?;
        let turns = self.structure_of(&operands.turns_counter)?;
        let elements = operands
            .transform_position
            .map_or(0, |array| usize::from(array.elements));
        Ok(Calculation {
            frames: self.frames(&operands.work_frame, &operands.tool_frame)?,
            configuration: dint(configuration, 0),
            turns: [0, 2, 4, 6].map(|at| i16::from_le_bytes(word(turns, at))),
            results: Arc::new(Results::new(elements)),
        })
    }

    /// A frame; without a tag, the one of zeros.
    fn frame(&self, operand: &TagOperand) -> Result<Frame, MotionError> {
        if operand.is_none() {
            return Ok(Frame::default());
        }
        let bytes = self.structure_of(operand)?;
        Ok(Frame {
            id: dint(bytes, 0),
            coordinates: [4, 8, 12, 16, 20, 24].map(|at| real(bytes, at)),
        })
    }

    /// The path and the dynamics of a call of MCPM.
    ///
    /// # Errors
    /// A tag removed since the call was bound: 13 with the operand.
    pub(super) fn path_move(&self, operands: &Mcpm) -> Result<PathMove, MotionError> {
        let path = self.structure_of(&operands.path)?;
        let dynamics = self.structure_of(&operands.dynamics)?;
        Ok(PathMove {
            path: path_data(path),
            dynamics: dynamics_data(dynamics),
        })
    }

    /// The bytes of an operand's structure, and of the rest of its tag behind it.
    ///
    /// # Errors
    /// The tag no longer exists: 13 with the operand.
    pub(super) fn structure_of(&self, operand: &TagOperand) -> Result<&[u8], MotionError> {
        let bytes = operand.and_then(|tag| {
            let (id, offset) = tag_and_offset(tag);
            self.bytes(id).get(offset..).filter(|bytes| !bytes.is_empty())
        });
        bytes.ok_or(operand.out_of_range())
    }
}

/// An operand that refers to a tag.
type TagOperand = OperandValue<Option<TagAddress>>;

fn path_data(bytes: &[u8]) -> PathData {
    use path_data_offset::*;
    PathData {
        interpolation_type: value_of(bytes, INTERPOLATION_TYPE),
        position: [0, 1, 2, 3, 4, 5].map(|index| real(bytes, POSITION + 4 * index)),
        robot_configuration: dint(bytes, ROBOT_CONFIGURATION),
        turns_counters: [0, 1, 2, 3].map(|index| i16::from_le_bytes(word(bytes, TURNS_COUNTERS + 2 * index))),
        move_type: value_of(bytes, MOVE_TYPE),
        termination_type: value_of(bytes, TERMINATION_TYPE),
        command_tolerance_linear: real(bytes, COMMAND_TOLERANCE_LINEAR),
    }
}

fn dynamics_data(bytes: &[u8]) -> DynamicsData {
    use dynamics_data_offset::*;
    let reals = |offsets: [usize; 3]| offsets.map(|offset| real(bytes, offset));
    DynamicsData {
        units_mode: value_of(bytes, UNITS_MODE),
        time_units: value_of(bytes, TIME_UNITS),
        profile: value_of(bytes, PROFILE),
        linear: reals([SPEED, ACCELERATION, DECELERATION]),
        jerks: [ACCELERATION_JERK, DECELERATION_JERK].map(|offset| real(bytes, offset)),
        orientation: reals([ORIENTATION_SPEED, ORIENTATION_ACCELERATION, ORIENTATION_DECELERATION]),
    }
}

/// The value of an enumeration at a byte; `None` if the number is not one of its values.
fn value_of<E: Enumeration>(bytes: &[u8], at: usize) -> Option<E> {
    E::from_number(dint(bytes, at))
}

/// The DINT at a byte.
pub(super) fn dint(bytes: &[u8], at: usize) -> i32 {
    i32::from_le_bytes(word(bytes, at))
}

/// The REAL at a byte.
pub(super) fn real(bytes: &[u8], at: usize) -> f64 {
    f64::from(f32::from_le_bytes(word(bytes, at)))
}

/// Bytes at an offset; zeros behind the end.
pub(super) fn word<const N: usize>(bytes: &[u8], at: usize) -> [u8; N] {
    bytes.get(at..).and_then(<[u8]>::first_chunk).copied().unwrap_or([0; N])
}
