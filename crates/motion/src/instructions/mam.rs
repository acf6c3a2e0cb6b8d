//! MAM, Motion Axis Move (spec/axis-and-data-types.md §3.4).

use arcline_instruction_set::enumerations::MamMoveType::{self, *};
use arcline_instruction_set::enumerations::MdacMotionType;
use arcline_instruction_set::operands::{Mam, OperandValue, Operands};
use arcline_instruction_set::{AxisIndex, Call, MotionError};
use arcline_planner::profile::Profile;

use super::axis_moves::{self, AxisMove, MoveStart};
use super::programmed::{Programmed, verify_reduction};
use super::seconds;
use crate::axis::Axis;
use crate::axis::generator::Goal;
use crate::axis::generator_kind::GeneratorKind;
use crate::events::{Events, LengthRule};
use crate::execution::Execution;
use crate::motion::Motion;
use crate::range;
use crate::rotary::RotaryPosition;
use crate::verify::{self, alone};

/// The destination of the move as programmed.
#[derive(Clone, Copy, Debug)]
struct Destination {
    move_type: MamMoveType,
    position: OperandValue<f64>,
}

impl Destination {
    /// The kind of generator that executes the move.
    fn kind(&self) -> GeneratorKind {
        match self.move_type {
            AbsoluteMasterOffset | IncrementalMasterOffset => GeneratorKind::MasterOffset,
            Absolute | Incremental | RotaryShortestPath | RotaryPositive | RotaryNegative => GeneratorKind::Move,
        }
    }

    fn is_rotary(&self) -> bool {
        matches!(self.move_type, RotaryShortestPath | RotaryPositive | RotaryNegative)
    }

    /// Ranges, in the order of the faceplate: a position of a rotary move type lies within one turn.
    fn verify_ranges(&self, motion: &Motion, axis: &Axis, call: &Call) -> Result<(), MotionError> {
        let beyond = |unwind| self.is_rotary() && !RotaryPosition::contains(unwind, *self.position);
        match (motion.verify_operands(call), axis.unwind.is_some_and(beyond)) {
            (Err(MotionError::ParameterOutOfRange(first)), _) if first <= self.position.index => {
                Err(MotionError::ParameterOutOfRange(first))
            }
            (_, true) => Err(self.position.out_of_range()),
            (result, false) => result,
        }
    }

    /// The start position of the move: the offset of the master, or the command position.
    fn present(&self, axis: &Axis) -> f64 {
        match self.kind() {
            GeneratorKind::MasterOffset => axis.master_offset().position,
            _ => axis.command.position,
        }
    }

    /// The end position of the move, not unwound. An offset of a master needs a position cam.
    fn target(&self, axis: &Axis) -> Result<f64, MotionError> {
        let present = self.present(axis);
        let position = *self.position;
        let turn = axis.unwind.map(|unwind| RotaryPosition::at(present, unwind));
        match (self.move_type, turn) {
            (Incremental, _) => Ok(present + position),
            (RotaryShortestPath, Some(turn)) => Ok(turn.shortest(position)),
            (RotaryPositive, Some(turn)) => Ok(turn.forward(position)),
            (RotaryNegative, Some(turn)) => Ok(turn.backward(position)),
            (RotaryShortestPath | RotaryPositive | RotaryNegative, None) => Err(MotionError::AxisModeNotRotary),
            (Absolute, Some(turn)) => Ok(turn.absolute(position)),
            (Absolute, None) => Ok(position),
            (AbsoluteMasterOffset | IncrementalMasterOffset, _) if axis.cam(GeneratorKind::PositionCam).is_none() => {
                Err(MotionError::PositionCamNotEnabled)
            }
            (AbsoluteMasterOffset, _) => Ok(position),
            (IncrementalMasterOffset, _) => Ok(present + position),
        }
    }
}

/// Checks that the units agree, and the requirements of moves with a programmed duration.
fn verify_units(operands: &AxisMove, kind: GeneratorKind, axis: &Axis) -> Result<(), MotionError> {
    let programmed = &operands.programmed;
    programmed.verify_units()?;
    seconds::verify_units(&programmed.rates)?;
    if seconds::is_duration(&programmed.rates) {
        seconds::verify_durations(programmed)?;
        let moved = match kind {
            GeneratorKind::MasterOffset => axis.master_offset(),
            _ => axis.command,
        };
        if moved.velocity != 0.0 || moved.acceleration != 0.0 {
            return Err(MotionError::AxisNotAtRest(AxisIndex(0)));
        }
        if operands.keeps_speed() {
            return Err(MotionError::MergeToCurrentUsingSeconds);
        }
    }
    programmed.verify_link(axis.links.newest(serves(kind)))
}

pub(super) fn execute(motion: &mut Motion, execution: Execution, call: &Call) -> Result<(), MotionError> {
    let Mam {
        move_type,
        position,
        dynamics,
        merge,
        merge_speed,
        lock,
        events,
    } = Mam::of(call);
    let destination = Destination {
        move_type: *move_type,
        position,
    };
    let programmed = Programmed::new(dynamics, lock);
    let operands = AxisMove {
        programmed,
        merge: *merge,
        merge_speed: *merge_speed,
    };
    let axis = motion.target_axis(call)?;
    let state = &motion.axes[axis];
    let kind = destination.kind();
    destination.verify_ranges(motion, state, call)?;
    verify_units(&operands, kind, state)?;
    let driven_by = programmed.driven_by(motion, state.links.newest(serves(kind)))?;
    let events = Events::of(&events, LengthRule::Exactly)?;
    axis_moves::verify_axis(state, programmed.is_s_curve())?;
    if destination.is_rotary() && state.unwind.is_none() {
        return Err(MotionError::AxisModeNotRotary);
    }
    verify::not_stopping(alone(state))?;
    let target = destination.target(state)?;
    let moved = match state.cam_master(GeneratorKind::PositionCam) {
        Some(master) if kind == GeneratorKind::MasterOffset => &motion.axes[master],
        _ => state,
    };
    range::verify(moved, target, position.index)?;
    let displacement = target - destination.present(state);
    // An offset is in units of the master, and so are its maxima.
    let maxima = match state.cam_master(GeneratorKind::PositionCam) {
        Some(master) if kind == GeneratorKind::MasterOffset => &motion.axes[master].dynamics,
        _ => {
            verify::no_overtravel(alone(state), |_, _| displacement)?;
            &state.dynamics
        }
    };
    let driven = operands.driven(motion, axis, kind, driven_by)?;
    let mut dynamics = if seconds::is_duration(&programmed.rates) {
        seconds::dynamics(&programmed, displacement.abs(), maxima)
    } else {
        programmed.dynamics(maxima)?
    };
    if operands.keeps_speed() {
        let present = operands.present_speed(state, kind, driven);
        if present != 0.0 {
            dynamics.keep_speed(present);
        }
    }
    if driven.is_some() {
        let present = operands.present_speed(state, kind, driven);
        verify_reduction(present, &dynamics.limits(), displacement.abs())?;
    }
    let beginning = MoveStart {
        execution,
        dynamics,
        goal: Goal::Position(target),
        driven,
        events,
    };
    operands.begin(motion, axis, kind, beginning, |from| {
        Profile::to_position(from, target, 0.0, &dynamics.limits())
    });
    Ok(())
}

/// The Motion Type of MDAC that applies to a kind of move.
fn serves(kind: GeneratorKind) -> MdacMotionType {
    match kind {
        GeneratorKind::MasterOffset => MdacMotionType::MasterOffsetMove,
        _ => MdacMotionType::Move,
    }
}
