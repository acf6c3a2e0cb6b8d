//! MAJ, Motion Axis Jog (spec/axis-and-data-types.md §3.3, §10.3).

use arcline_instruction_set::enumerations::{JogDirection, MdacMotionType};
use arcline_instruction_set::operands::Maj;
use arcline_instruction_set::{Call, MotionError};
use arcline_planner::profile::Profile;

use super::axis_moves::{self, AxisMove, MoveStart};
use super::programmed::Programmed;
use crate::axis::generator::Goal;
use crate::axis::generator_kind::GeneratorKind;
use crate::execution::Execution;
use crate::motion::Motion;
use crate::verify::{self, alone};

pub(super) fn execute(motion: &mut Motion, execution: Execution, call: &Call) -> Result<(), MotionError> {
    let axis = motion.target_axis(call)?;
    let Maj {
        direction,
        dynamics,
        merge,
        merge_speed,
        lock,
    } = motion.operands(call)?;
    let programmed = Programmed::new(dynamics, lock);
    let operands = AxisMove {
        programmed,
        merge: *merge,
        merge_speed: *merge_speed,
    };
    programmed.verify_units()?;
    let state = &motion.axes[axis];
    let link = state.links.newest(MdacMotionType::Jog);
    programmed.verify_link(link)?;
    let driven_by = programmed.driven_by(motion, link)?;
    axis_moves::verify_axis(state, programmed.is_s_curve())?;
    verify::not_stopping(alone(state))?;
    let mut dynamics = programmed.dynamics(&state.dynamics)?;
    let driven = operands.driven(motion, axis, GeneratorKind::Jog, driven_by)?;
    if operands.keeps_speed() {
        dynamics.keep_speed(operands.present_speed(state, GeneratorKind::Jog, driven));
    }
    let velocity = match *direction {
        JogDirection::Forward => dynamics.speed,
        JogDirection::Reverse => -dynamics.speed,
    };
    verify::no_overtravel(alone(state), |_, _| velocity)?;
    let beginning = MoveStart {
        execution,
        dynamics,
        goal: Goal::Velocity(velocity),
        driven,
        events: None,
    };
    operands.begin(motion, axis, GeneratorKind::Jog, beginning, |from| {
        Profile::to_velocity(from, velocity, &dynamics.jog_limits(from.velocity, velocity))
    });
    Ok(())
}
