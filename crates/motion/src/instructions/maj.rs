//! MAJ, Motion Axis Jog (spec/axis-and-data-types.md §3.3, §10.3).

use arcline_instruction_set::{Call, Mnemonic, MotionError};
use arcline_planner::profile::Profile;

use super::axis_moves::{self, AxisMoveLayout, Beginning};
use super::place;
use crate::axis::generator::Goal;
use crate::axis::sum::Slot;
use crate::control::Execution;
use crate::masters::links::Serves;
use crate::motion::Motion;

/// Places of MAJ's operands.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Layout {
    common: AxisMoveLayout,
    direction: usize,
}

/// Direction: towards lower positions.
const REVERSE: i32 = 1;

impl Layout {
    pub(super) fn new() -> Self {
        Layout {
            common: AxisMoveLayout::of(Mnemonic::Maj),
            direction: place(Mnemonic::Maj, "Direction"),
        }
    }
}

pub(super) fn execute(motion: &mut Motion, execution: Execution, call: &Call) -> Result<(), MotionError> {
    let layout = motion.layouts.maj;
    let axis = motion.target_axis(call)?;
    motion.verify_operands(call)?;
    layout.common.dynamics.verify_units(call)?;
    let state = &motion.axes[usize::from(axis)];
    let link = state.links.newest(Serves::Jog);
    layout.common.dynamics.verify_link(call, link)?;
    let lead = layout.common.dynamics.lead(motion, call, link)?;
    axis_moves::verify_axis(state, layout.common.dynamics.is_s_curve(call))?;
    axis_moves::not_stopping(state)?;
    let mut dynamics = layout.common.dynamics.read(call, &state.dynamics)?;
    let led = layout.common.led(motion, axis, Slot::Jog, call, lead)?;
    if layout.common.keeps_speed(call) {
        dynamics.keep_speed(layout.common.present_speed(state, Slot::Jog, call, led));
    }
    let velocity = if call.word(layout.direction) == REVERSE {
        -dynamics.speed
    } else {
        dynamics.speed
    };
    axis_moves::no_overtravel(state, velocity)?;
    let beginning = Beginning {
        execution,
        dynamics,
        goal: Goal::Velocity(velocity),
        led,
        events: None,
    };
    layout.common.begin(motion, axis, Slot::Jog, call, beginning, |from| {
        Profile::to_velocity(from, velocity, &dynamics.jog_limits(from.velocity, velocity))
    });
    Ok(())
}
