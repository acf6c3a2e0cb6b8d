//! MAG, Motion Axis Gear (spec/axis-and-data-types.md §3.5).

use arcline_instruction_set::{Call, Flag, Mnemonic, MotionError, OperandIndex};
use arcline_profile::KinematicState;

use super::programmed::positive;
use super::{axis_moves, place};
use crate::axis::generator::{Generator, Law};
use crate::axis::sum::Slot;
use crate::control::Execution;
use crate::dynamics::in_units;
use crate::masters::Reference;
use crate::masters::gear::Gear;
use crate::motion::Motion;

/// Places of MAG's operands.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Layout {
    master: usize,
    direction: usize,
    ratio: usize,
    slave_counts: usize,
    master_counts: usize,
    master_reference: usize,
    ratio_format: usize,
    clutch: usize,
    accel_rate: usize,
    accel_units: usize,
}

/// Direction: along with the master.
const SAME: i32 = 0;
/// Direction: against the master.
const OPPOSITE: i32 = 1;
/// Direction: the other way than the present gearing.
const REVERSE: i32 = 2;
/// Master Reference: actual position.
const ACTUAL: i32 = 0;
/// Ratio Format: slave counts to master counts.
const FRACTION: i32 = 1;
/// Clutch: the slave ramps to its speed. The words are the reverse of those of Merge.
const CLUTCH_ENABLED: i32 = 0;

impl Layout {
    pub(super) fn new() -> Self {
        let place = |name| place(Mnemonic::Mag, name);
        Layout {
            master: place("Master Axis"),
            direction: place("Direction"),
            ratio: place("Ratio"),
            slave_counts: place("Slave Counts"),
            master_counts: place("Master Counts"),
            master_reference: place("Master Reference"),
            ratio_format: place("Ratio Format"),
            clutch: place("Clutch"),
            accel_rate: place("Accel Rate"),
            accel_units: place("Accel Units"),
        }
    }

    /// Slave units per master unit. A count of a simulated axis is a position unit: its conversion constant is 1.
    fn ratio(&self, call: &Call) -> f64 {
        if call.word(self.ratio_format) == FRACTION {
            f64::from(call.word(self.slave_counts)) / f64::from(call.word(self.master_counts))
        } else {
            call.number(self.ratio)
        }
    }
}

pub(super) fn execute(motion: &mut Motion, execution: Execution, call: &Call) -> Result<(), MotionError> {
    let layout = motion.layouts.mag;
    let axis = motion.target_axis(call)?;
    let at = usize::from(axis);
    motion.verify_operands(call)?;
    let master = call
        .object(layout.master)
        .filter(|master| usize::from(*master) < motion.axes.len())
        .ok_or(MotionError::ParameterOutOfRange(OperandIndex(layout.master as u8)))?;
    let clutch = if call.word(layout.clutch) == CLUTCH_ENABLED {
        let own = motion.axes[at].dynamics.acceleration;
        let rate = in_units(call.number(layout.accel_rate), call.word(layout.accel_units), own);
        positive(rate, layout.accel_rate)?;
        Some(rate)
    } else {
        None
    };
    axis_moves::verify_axis(&motion.axes[at], false)?;
    axis_moves::not_stopping(&motion.axes[at])?;
    if motion.plan_master(axis, master).is_err() {
        return Err(MotionError::MasterAxisConflict);
    }
    let running = motion.axes[at].gear().map(|gear| gear.ratio);
    let ratio = match (call.word(layout.direction), running) {
        (SAME, _) => layout.ratio(call),
        (OPPOSITE, _) => -layout.ratio(call),
        (REVERSE, Some(running)) => -layout.ratio(call).copysign(running),
        (_, Some(running)) => layout.ratio(call).copysign(running),
        (_, None) => return Err(MotionError::IllegalDynamicChange),
    };

    let reference = if call.word(layout.master_reference) == ACTUAL {
        Reference::Actual
    } else {
        Reference::Command
    };
    let now = motion.clock.now();
    // A gearing before this one, or what is left of it, gives the speed to clutch from.
    let slave = KinematicState {
        position: motion.axes[at].command.position,
        velocity: motion.axes[at]
            .sum
            .get(Slot::Gear)
            .map_or(0.0, |generator| generator.now.velocity),
        acceleration: 0.0,
    };
    motion.end_generator(axis, Slot::Gear);
    let met = motion.axes.master_at(master, reference, &motion.clock);
    let mut gear = Gear::new(master, reference, ratio, &met, slave, clutch, now);
    let mut generator = Generator::followed(false);
    generator.execution = Some(execution);
    // What is executed next at this tick finds the slave in motion.
    generator.now = gear.follow(&met, slave.position, &motion.clock);
    generator.law = Law::Geared(gear);
    let state = &mut motion.axes[at];
    state.begin(Slot::Gear, generator);
    state.stale = true;
    motion.order.take();
    let accepted = Flag::Dn.mask() | Flag::Ip.mask();
    motion.controls.write(execution, accepted, 0, motion.clock.tick);
    Ok(())
}
