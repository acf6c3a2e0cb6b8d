//! MAH, Motion Axis Home (spec/axis-and-data-types.md §3.2, §11).

use arcline_instruction_set::{Call, MotionError};

use crate::axis::Axis;
use crate::execution::Execution;
use crate::machine::{HomeInputs, HomeMode, HomeSequence};
use crate::motion::Motion;
use crate::verify::{self, alone};

pub(super) fn execute(motion: &mut Motion, execution: Execution, call: &Call) -> Result<(), MotionError> {
    let axis = motion.target_axis(call)?;
    motion.verify_operands(call)?;
    let state = &motion.axes[axis];
    let active = state.home.mode == HomeMode::Active;
    verify_configuration(state)?;
    if active && state.home.sequence != HomeSequence::Immediate {
        verify::ready(alone(state))?;
    } else {
        verify::not_shut_down(alone(state))?;
        if active {
            verify::not_faulted(alone(state))?;
        }
    }
    verify::not_homing(alone(state))?;
    if active {
        if state.in_motion() || state.home.sequence != HomeSequence::Immediate {
            verify::stoppable(alone(state))?;
        }
        verify::not_stopping(alone(state))?;
    }
    if motion.is_redefining(axis) {
        return Err(MotionError::RedefinePositionInProcess);
    }
    motion.axes[axis].not_in_transform()?;
    motion.begin_homing(axis, execution);
    Ok(())
}

/// Checks that the sequence can run: the axis has its inputs, the switch has the edge that it seeks, and positions are within the axis's range.
fn verify_configuration(axis: &Axis) -> Result<(), MotionError> {
    let home = &axis.next_home;
    let HomeInputs { switch, marker, stops } = home.inputs;
    let assigned = match home.sequence {
        HomeSequence::Immediate => true,
        HomeSequence::Switch => switch.is_some(),
        HomeSequence::Marker => marker,
        HomeSequence::SwitchMarker => switch.is_some() && marker,
        // Torque builds up only at a mechanical stop, and only if MAH itself drives the axis against it.
        HomeSequence::Torque | HomeSequence::TorqueMarker if !stops || home.mode == HomeMode::Passive => {
            return Err(MotionError::IllegalHomingConfig);
        }
        HomeSequence::Torque => true,
        HomeSequence::TorqueMarker => marker,
    };
    if !assigned {
        return Err(MotionError::DriveDigitalInputNotAssigned);
    }
    if let Some(switch) = switch
        && home.mode == HomeMode::Active
        && matches!(home.sequence, HomeSequence::Switch | HomeSequence::SwitchMarker)
        && !switch.becomes_active(home.direction)
    {
        return Err(MotionError::IllegalHomingConfig);
    }
    if home.position.abs().max(home.offset.abs()) > axis.range {
        return Err(MotionError::IllegalHomingConfig);
    }
    Ok(())
}
