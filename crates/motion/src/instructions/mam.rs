//! MAM, Motion Axis Move (spec/axis-and-data-types.md §3.4).

use arcline_instruction_set::{Call, Flag, Mnemonic, MotionError};
use arcline_planner::profile::{Profile, State};

use super::axis_moves::{self, AxisMoveLayout};
use super::place;
use crate::axis::generator::{Generator, Goal, Program};
use crate::axis::sum::Slot;
use crate::control::Execution;
use crate::motion::Motion;

/// Places of MAM's operands.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Layout {
    common: AxisMoveLayout,
    move_type: usize,
    position: usize,
}

/// Move Type: by a distance.
const INCREMENTAL: i32 = 1;

impl Layout {
    pub(super) fn new() -> Self {
        Layout {
            common: AxisMoveLayout::of(Mnemonic::Mam),
            move_type: place(Mnemonic::Mam, "Move Type"),
            position: place(Mnemonic::Mam, "Position"),
        }
    }
}

pub(super) fn execute(motion: &mut Motion, execution: Execution, call: &Call) -> Result<(), MotionError> {
    let layout = motion.layouts.mam;
    let axis = motion.target_axis(call)?;
    let at = usize::from(axis);
    motion.verify_operands(call)?;
    layout.common.verify_mode(call)?;
    axis_moves::verify_axis(motion, axis, layout.common.is_s_curve(call))?;
    let state = &motion.axes[at];
    let mut dynamics = layout.common.dynamics(call, &state.dynamics)?;
    if layout.common.keeps_speed(call) && state.command.velocity != 0.0 {
        dynamics.set_speed(state.command.velocity.abs());
    }
    let position = state.command.position;
    let target = match call.word(layout.move_type) {
        0 => call.number(layout.position),
        INCREMENTAL => position + call.number(layout.position),
        _ => return Err(MotionError::FeatureNotSupported),
    };
    // Of what it takes over, the move keeps the speed: of its own kind, or of everything.
    let taken = if layout.common.merges(call) {
        let taken = state
            .sum
            .motion_of(|slot| slot != Slot::System && !slot.is_of_transforms());
        motion.end_single_axis(axis, Some(Slot::Move));
        taken
    } else {
        let own = motion.axes[at].sum.get(Slot::Move);
        own.map(|generator| generator.now).unwrap_or_default()
    };
    motion.end_generator(axis, Slot::Move);
    let limits = dynamics.limits();
    let from = State {
        position,
        velocity: taken.velocity,
        acceleration: if limits.jerk.is_some() { taken.acceleration } else { 0.0 },
    };
    let now = motion.clock.now();
    let mut generator = Generator::planned(Profile::to_position(from, target, 0.0, &limits), now);
    generator.execution = Some(execution);
    generator.s_curve = dynamics.is_s_curve();
    generator.program = Some(Program {
        dynamics,
        goal: Goal::Position(target),
    });
    motion.axes[at].begin(Slot::Move, generator);
    motion.axes[at].stale = true;
    let accepted = Flag::Dn.mask() | Flag::Ip.mask();
    motion.controls.write(execution, accepted, 0, motion.clock.tick);
    Ok(())
}
