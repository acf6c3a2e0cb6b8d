//! Structure tags that an instruction reads as a whole: the frames of MCTO and MCTPO, what else MCTPO reads, and the path and
//! the dynamics of MCPM, go with the call into the tick as they are when it is made (spec/coordinated-instructions.md §22.8 to
//! §25).
//!
//! Not here: cams, and what an instruction writes to tags (`cams`).

use std::sync::Arc;

use arcline_instruction_set::predefined;
use arcline_instruction_set::{Call, Enumeration, MotionError, OperandIndex};
use arcline_motion::{Answer, Calculation, DynamicsData, Frame, Frames, PathData, PathMove};
use arcline_tag::Template;

use super::cams::operand;
use super::{Image, TagId};

impl Image {
    /// The frames of a call of MCTO or MCTPO.
    ///
    /// # Errors
    /// A tag that is gone since the call was bound: 13 with the operand.
    pub(super) fn frames(&self, call: &Call) -> Result<Frames, MotionError> {
        let [work, tool] = ["Work Frame", "Tool Frame"].map(|name| self.frame(call, name));
        Ok(Frames {
            work: work?,
            tool: tool?,
        })
    }

    /// What MCTPO reads, and a place for what it calculates.
    ///
    /// # Errors
    /// As of [`Image::frames`].
    pub(super) fn calculation(&self, call: &Call) -> Result<Calculation, MotionError> {
        let room = call.written(operand(call.mnemonic, "Transform Position"));
        let configuration = self.structure_of(call, "Robot Configuration")?;
        let turns = self.structure_of(call, "Turns Counter")?;
        Ok(Calculation {
            frames: self.frames(call)?,
            configuration: i32::from_le_bytes(word(configuration, 0)),
            turns: [0, 2, 4, 6].map(|at| i16::from_le_bytes(word(turns, at))),
            answer: Arc::new(Answer::new(room.map_or(0, |array| usize::from(array.elements)))),
        })
    }

    fn frame(&self, call: &Call, name: &str) -> Result<Frame, MotionError> {
        let bytes = self.structure_of(call, name)?;
        Ok(Frame {
            id: i32::from_le_bytes(word(bytes, 0)),
            coordinates: [4, 8, 12, 16, 20, 24].map(|at| real(bytes, at)),
        })
    }

    /// The path and the dynamics of a call of MCPM.
    ///
    /// # Errors
    /// A tag that is gone since the call was bound: 13 with the operand.
    pub(super) fn path_move(&self, call: &Call) -> Result<PathMove, MotionError> {
        let (path, dynamics) = (predefined::path_data(), predefined::dynamics_data());
        let path = Members(&path, self.structure_of(call, "Path")?);
        let dynamics = Members(&dynamics, self.structure_of(call, "Dynamics")?);
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
    pub(super) fn structure_of(&self, call: &Call, name: &str) -> Result<&[u8], MotionError> {
        let place = operand(call.mnemonic, name);
        let bytes = call.tag(place).and_then(|tag| {
            let (id, offset) = (TagId(tag >> 16), (tag & 0xFFFF) as usize * 4);
            self.bytes(id).get(offset..).filter(|bytes| !bytes.is_empty())
        });
        bytes.ok_or(MotionError::ParameterOutOfRange(OperandIndex(place as u8)))
    }
}

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
