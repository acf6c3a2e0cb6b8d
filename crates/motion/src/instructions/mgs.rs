//! MGS, Motion Group Stop (spec/axis-and-data-types.md §4): every axis stops separately, not along a path.

use arcline_instruction_set::enumerations::StopMode;
use arcline_instruction_set::operands::Mgs;
use arcline_instruction_set::{Call, Flag, MotionError};

use crate::axis::AfterStop;
use crate::axis::state::AxisState;
use crate::execution::Execution;
use crate::machine::ProgrammedStopMode;
use crate::motion::Motion;
use crate::stop::{AxisSet, Stop};
use crate::transforms::cancel::Release;

pub(super) fn execute(motion: &mut Motion, execution: Execution, call: &Call) -> Result<(), MotionError> {
    motion.target_group(call)?;
    let Mgs { stop_mode } = motion.operands(call)?;
    let mode = match *stop_mode {
        StopMode::Programmed => None,
        StopMode::FastStop => Some(ProgrammedStopMode::FastStop),
        StopMode::FastDisable => Some(ProgrammedStopMode::FastDisable),
    };
    if let Some(stop) = motion.group_stop.take() {
        motion.controls.end_move(stop.execution, 0);
    }
    let braking = stop_group(motion, mode);
    motion.group_stop = Some(Stop {
        execution,
        of_moves: true,
        braking,
    });
    let initiated = Flag::Dn.mask() | Flag::Ip.mask();
    motion.controls.write(execution, initiated, 0);
    Ok(())
}

/// Stops all motion of all axes, in one mode or each axis in its configured one. Returns the axes that are not at rest yet.
fn stop_group(motion: &mut Motion, mode: Option<ProgrammedStopMode>) -> AxisSet {
    for index in motion.systems.ids() {
        motion.systems[index].end_stop(&mut motion.controls);
        motion.abort_system(index, |_| false);
    }
    motion.unlink_all();
    let mut braking = AxisSet::default();
    for id in motion.transforms.ids() {
        motion.cancel_transform(id, &Release::default());
    }
    for axis in motion.axes.ids() {
        motion.axes[axis].end_passive_homing(&mut motion.controls);
        motion.axes[axis].end_pending_cams(None, &mut motion.controls);
        let state = &motion.axes[axis];
        let mode = mode.unwrap_or(state.stop_mode);
        let after = match mode {
            ProgrammedStopMode::FastStop => AfterStop::Hold,
            ProgrammedStopMode::FastDisable => AfterStop::Disable,
            ProgrammedStopMode::FastShutdown => AfterStop::Shutdown,
            ProgrammedStopMode::HardDisable => {
                motion.end_generators(axis);
                if motion.axes[axis].state == AxisState::Running && !motion.axes[axis].is_virtual {
                    motion.axes[axis].disable(AxisState::Stopped);
                    braking.insert(axis);
                }
                continue;
            }
            ProgrammedStopMode::HardShutdown => {
                motion.shut_down(axis);
                continue;
            }
        };
        if motion.axes[axis].in_motion() {
            motion.stop_axis(axis, None);
            motion.axes[axis].after_stop = after;
            braking.insert(axis);
        } else {
            motion.axes[axis].act_after_stop(after);
        }
    }
    braking
}
