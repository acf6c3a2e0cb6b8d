//! MAM, Motion Axis Move (spec/axis-and-data-types.md §3.4).

use arcline_instruction_set::{AxisIndex, Call, Mnemonic, MotionError, OperandIndex};
use arcline_planner::profile::Profile;

use super::axis_moves::{self, AxisMoveLayout, Beginning};
use super::place;
use super::programmed::verify_reduction;
use super::seconds::{self, MASTER_UNITS, SECONDS};
use crate::axis::Axis;
use crate::axis::generator::Goal;
use crate::axis::sum::Slot;
use crate::control::Execution;
use crate::events::{Events, Fit};
use crate::masters::links::Serves;
use crate::motion::Motion;
use crate::range;
use crate::rotary::Turn;

/// Places of MAM's operands.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Layout {
    common: AxisMoveLayout,
    move_type: usize,
    position: usize,
    event_distance: usize,
    calculated_data: usize,
}

/// Move Type: by a distance.
const INCREMENTAL: i32 = 1;
/// Move Type: to a position within one turn, the short way.
const SHORTEST: i32 = 2;
/// Move Type: to a position within one turn, forwards.
const POSITIVE: i32 = 3;
/// Move Type: to a position within one turn, backwards.
const NEGATIVE: i32 = 4;
/// Move Type: the offset of the position cam's master to a value.
const MASTER_OFFSET: i32 = 5;
/// Move Type: that offset by a distance.
const MASTER_OFFSET_BY: i32 = 6;

impl Layout {
    pub(super) fn new() -> Self {
        let place = |name| place(Mnemonic::Mam, name);
        Layout {
            common: AxisMoveLayout::of(Mnemonic::Mam),
            move_type: place("Move Type"),
            position: place("Position"),
            event_distance: place("Event Distance"),
            calculated_data: place("Calculated Data"),
        }
    }

    /// What the move is one of.
    fn slot(&self, call: &Call) -> Slot {
        if call.word(self.move_type) >= MASTER_OFFSET {
            Slot::MasterOffset
        } else {
            Slot::Move
        }
    }

    fn is_rotary(&self, call: &Call) -> bool {
        (SHORTEST..=NEGATIVE).contains(&call.word(self.move_type))
    }

    /// Ranges, in the order of the faceplate: a position of a rotary move type lies within one turn.
    fn verify_ranges(&self, motion: &Motion, axis: &Axis, call: &Call) -> Result<(), MotionError> {
        let position = MotionError::ParameterOutOfRange(OperandIndex(self.position as u8));
        let beyond = |unwind| self.is_rotary(call) && !Turn::contains(unwind, call.number(self.position));
        match (motion.verify_operands(call), axis.unwind.is_some_and(beyond)) {
            (Err(MotionError::ParameterOutOfRange(first)), _) if usize::from(first.0) <= self.position => {
                Err(MotionError::ParameterOutOfRange(first))
            }
            (_, true) => Err(position),
            (result, false) => result,
        }
    }

    /// Units that go together, and what moves of a programmed duration need.
    fn verify_units(&self, axis: &Axis, call: &Call) -> Result<(), MotionError> {
        let dynamics = &self.common.dynamics;
        dynamics.verify_units(call)?;
        for duration in [SECONDS, MASTER_UNITS] {
            seconds::verify_units(&dynamics.rates, call, duration)?;
        }
        if seconds::is_duration(call.word(dynamics.rates.speed_units)) {
            seconds::verify_durations(dynamics, call)?;
            let moved = match self.slot(call) {
                Slot::MasterOffset => axis.master_offset(),
                _ => axis.command,
            };
            if moved.velocity != 0.0 || moved.acceleration != 0.0 {
                return Err(MotionError::AxisNotAtRest(AxisIndex(0)));
            }
            if self.common.keeps_speed(call) {
                return Err(MotionError::MergeToCurrentUsingSeconds);
            }
        }
        dynamics.verify_link(call, axis.links.newest(serves(self.slot(call))))
    }

    /// Where the move begins, of its kind.
    fn present(&self, axis: &Axis, call: &Call) -> f64 {
        match self.slot(call) {
            Slot::MasterOffset => axis.master_offset().position,
            _ => axis.command.position,
        }
    }

    /// Where the move ends, as a position that is not unwound. Offsets of a master need a position cam.
    fn target(&self, axis: &Axis, call: &Call) -> Result<f64, MotionError> {
        let present = self.present(axis, call);
        let position = call.number(self.position);
        let turn = axis.unwind.map(|unwind| Turn::at(present, unwind));
        match (call.word(self.move_type), turn) {
            (INCREMENTAL, _) => Ok(present + position),
            (SHORTEST, Some(turn)) => Ok(turn.shortest(position)),
            (POSITIVE, Some(turn)) => Ok(turn.forward(position)),
            (NEGATIVE, Some(turn)) => Ok(turn.backward(position)),
            (0, Some(turn)) => Ok(turn.absolute(position)),
            (0, None) => Ok(position),
            (MASTER_OFFSET, _) if axis.cam(Slot::PositionCam).is_some() => Ok(position),
            (MASTER_OFFSET_BY, _) if axis.cam(Slot::PositionCam).is_some() => Ok(present + position),
            _ => Err(MotionError::PositionCamNotEnabled),
        }
    }
}

pub(super) fn execute(motion: &mut Motion, execution: Execution, call: &Call) -> Result<(), MotionError> {
    let layout = motion.layouts.mam;
    let axis = motion.target_axis(call)?;
    let state = &motion.axes[usize::from(axis)];
    layout.verify_ranges(motion, state, call)?;
    layout.verify_units(state, call)?;
    let dynamics = &layout.common.dynamics;
    let slot = layout.slot(call);
    let lead = dynamics.lead(motion, call, state.links.newest(serves(slot)))?;
    let events = Events::of(call, layout.event_distance, layout.calculated_data, Fit::Exactly)?;
    axis_moves::verify_axis(state, layout.common.dynamics.is_s_curve(call))?;
    if layout.is_rotary(call) && state.unwind.is_none() {
        return Err(MotionError::AxisModeNotRotary);
    }
    axis_moves::not_stopping(state)?;
    let target = layout.target(state, call)?;
    let moved = match state.cam_master(Slot::PositionCam) {
        Some(master) if slot == Slot::MasterOffset => &motion.axes[usize::from(master)],
        _ => state,
    };
    range::verify(moved, target, layout.position)?;
    let way = target - layout.present(state, call);
    // An offset is in units of the master, and so are its maxima.
    let maxima = match state.cam_master(Slot::PositionCam) {
        Some(master) if slot == Slot::MasterOffset => &motion.axes[usize::from(master)].dynamics,
        _ => {
            axis_moves::no_overtravel(state, way)?;
            &state.dynamics
        }
    };
    let led = layout.common.led(motion, axis, slot, call, lead)?;
    let mut dynamics = if seconds::is_duration(call.word(dynamics.rates.speed_units)) {
        seconds::dynamics(&layout.common.dynamics, call, way.abs(), maxima)
    } else {
        layout.common.dynamics.read(call, maxima)?
    };
    if layout.common.keeps_speed(call) {
        let present = layout.common.present_speed(state, slot, call, led);
        if present != 0.0 {
            dynamics.keep_speed(present);
        }
    }
    if led.is_some() {
        let present = layout.common.present_speed(state, slot, call, led);
        verify_reduction(present, &dynamics.limits(), way.abs())?;
    }
    let beginning = Beginning {
        execution,
        dynamics,
        goal: Goal::Position(target),
        led,
        events,
    };
    layout.common.begin(motion, axis, slot, call, beginning, |from| {
        Profile::to_position(from, target, 0.0, &dynamics.limits())
    });
    Ok(())
}

/// The Motion Type of MDAC that serves a kind of move.
fn serves(slot: Slot) -> Serves {
    match slot {
        Slot::MasterOffset => Serves::MasterOffsetMove,
        _ => Serves::Move,
    }
}
