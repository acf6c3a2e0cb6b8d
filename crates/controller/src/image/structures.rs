//! Structure tags that an instruction reads as a whole: the frames of MCTO and MCTPO, what else MCTPO reads, and the path and
//! the dynamics of MCPM, go with the call into the tick as they are when it is made (spec/coordinated-instructions.md §22.8 to
//! §25).
//!
//! Not here: cams, and what an instruction writes to tags (`cams`).

use std::sync::Arc;

use arcline_instruction_set::operands::{Mcpm, Mctpo, OperandValue};
use arcline_instruction_set::predefined;
use arcline_instruction_set::{Enumeration, MotionError, TagAddress};
use arcline_motion::{Calculation, DynamicsData, Frame, Frames, PathData, PathMove, Results};
use arcline_tag::Template;

use super::Image;
use super::calls::place;

impl Image {
    /// The frames of a work and a tool.
    ///
    /// # Errors
    /// A tag that is gone since the call was bound: 13 with the operand.
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
    /// As of [`Image::frames`].
    pub(super) fn calculation(&self, operands: &Mctpo) -> Result<Calculation, MotionError> {
        let configuration = self.structure_of(&operands.robot_configuration)?;
        let turns = self.structure_of(&operands.turns_counter)?;
        let elements = operands
            .transform_position
            .map_or(0, |array| usize::from(array.elements));
        Ok(Calculation {
            frames: self.frames(&operands.work_frame, &operands.tool_frame)?,
            configuration: i32::from_le_bytes(word(configuration, 0)),
            turns: [0, 2, 4, 6].map(|at| i16::from_le_bytes(word(turns, at))),
            results: Arc::new(Results::new(elements)),
        })
    }

    fn frame(&self, operand: &TagOperand) -> Result<Frame, MotionError> {
        let bytes = self.structure_of(operand)?;
        Ok(Frame {
            id: i32::from_le_bytes(word(bytes, 0)),
            coordinates: [4, 8, 12, 16, 20, 24].map(|at| real(bytes, at)),
        })
    }

    /// The path and the dynamics of a call of MCPM.
    ///
    /// # Errors
    /// A tag that is gone since the call was bound: 13 with the operand.
    pub(super) fn path_move(&self, operands: &Mcpm) -> Result<PathMove, MotionError> {
        let (path, dynamics) = (predefined::path_data(), predefined::dynamics_data());
        let path = Members(&path, self.structure_of(&operands.path)?);
        let dynamics = Members(&dynamics, self.structure_of(&operands.dynamics)?);
        Ok(PathMove {
            path: PathData {
                interpolation_type: path.word("InterpolationType"),
                position: [0, 1, 2, 3, 4, 5].map(|place| real(path.1, path.at("Position") + 4 * place)),
                robot_configuration: path.dint("RobotConfiguration"),
                turns_counters: [0, 1, 2, 3]
                    .map(|place| i16::from_le_bytes(word(path.1, path.at("TurnsCounters") + 2 * place))),
                move_type: path.word("MoveType"),
                termination_type: path.word("TerminationType"),
                command_tolerance_linear: path.real("CommandToleranceLinear"),
            },
            dynamics: DynamicsData {
                units_mode: dynamics.word("UnitsMode"),
                time_units: dynamics.word("TimeUnits"),
                profile: dynamics.word("Profile"),
                linear: ["Speed", "Acceleration", "Deceleration"].map(|name| dynamics.real(name)),
                jerks: ["AccelerationJerk", "DecelerationJerk"].map(|name| dynamics.real(name)),
                orientation: ["OrientationSpeed", "OrientationAcceleration", "OrientationDeceleration"]
                    .map(|name| dynamics.real(name)),
            },
        })
    }

    /// The bytes from the structure on that an operand names: that and what follows it in its tag.
    ///
    /// # Errors
    /// There is no such tag any more: 13 with the operand.
    pub(super) fn structure_of(&self, operand: &TagOperand) -> Result<&[u8], MotionError> {
        let bytes = operand.and_then(|tag| {
            let (id, offset) = place(tag);
            self.bytes(id).get(offset..).filter(|bytes| !bytes.is_empty())
        });
        bytes.ok_or(operand.out_of_range())
    }
}

/// An operand that names a tag.
type TagOperand = OperandValue<Option<TagAddress>>;

/// A structure of a predefined type: what it is made of, and its bytes.
struct Members<'a>(&'a Template, &'a [u8]);

impl Members<'_> {
    /// Where a member of the type begins.
    fn at(&self, name: &str) -> usize {
        let member = self.0.members.iter().find(|member| member.name == name);
        member.map_or(usize::MAX / 2, |member| member.offset as usize)
    }

    fn dint(&self, name: &str) -> i32 {
        i32::from_le_bytes(word(self.1, self.at(name)))
    }

    fn word<E: Enumeration>(&self, name: &str) -> Option<E> {
        E::from_number(self.dint(name))
    }

    fn real(&self, name: &str) -> f64 {
        real(self.1, self.at(name))
    }
}

/// The REAL at a byte.
pub(super) fn real(bytes: &[u8], at: usize) -> f64 {
    f64::from(f32::from_le_bytes(word(bytes, at)))
}

/// Bytes at a place; zeros behind the end.
pub(super) fn word<const N: usize>(bytes: &[u8], at: usize) -> [u8; N] {
    bytes.get(at..).and_then(<[u8]>::first_chunk).copied().unwrap_or([0; N])
}
