//! MAG, Motion Axis Gear (spec/axis-and-data-types.md §3.5).

use arcline_instruction_set::enumerations::{Clutch, GearDirection, RatioFormat};
use arcline_instruction_set::operands::Mag;
use arcline_instruction_set::{Call, Flag, MotionError};
use arcline_profile::KinematicState;

use super::axis_moves;
use super::programmed::positive;
use crate::axis::generator::{Equation, Generator};
use crate::axis::generator_kind::GeneratorKind;
use crate::dynamics::in_units;
use crate::execution::Execution;
use crate::masters::gear::Gear;
use crate::masters::master::Master;
use crate::motion::Motion;
use crate::order::{DependencyCycle, Follower};
use crate::verify::{self, alone};

pub(super) fn execute(motion: &mut Motion, execution: Execution, call: &Call) -> Result<(), MotionError> {
    let axis = motion.target_axis(call)?;
    let Mag {
        master_axis,
        direction,
        ratio,
        slave_counts,
        master_counts,
        master_reference,
        ratio_format,
        clutch,
        accel_rate,
        accel_units,
    } = motion.operands(call)?;
    let master = motion.axis_of(&master_axis)?;
    let clutch = match *clutch {
        Clutch::Enabled => {
            let own = motion.axes[axis].dynamics.acceleration;
            let rate = in_units(*accel_rate, *accel_units, own);
            positive(rate, accel_rate.index)?;
            Some(rate)
        }
        Clutch::Disabled => None,
    };
    axis_moves::verify_axis(&motion.axes[axis], false)?;
    verify::not_stopping(alone(&motion.axes[axis]))?;
    let order = motion.plan_order(Follower::Axis(axis, master));
    let order = order.map_err(|DependencyCycle| MotionError::MasterAxisConflict)?;
    let running = motion.axes[axis].gear().map(|gear| gear.ratio);
    // Slave units per master unit. The conversion constant of every axis is 1: a count is a position unit.
    let magnitude = match *ratio_format {
        RatioFormat::Real => *ratio,
        RatioFormat::Fraction => f64::from(*slave_counts) / f64::from(*master_counts),
    };
    let ratio = match (*direction, running) {
        (GearDirection::Same, _) => magnitude,
        (GearDirection::Opposite, _) => -magnitude,
        (GearDirection::Reverse, Some(running)) => -magnitude.copysign(running),
        (GearDirection::Unchanged, Some(running)) => magnitude.copysign(running),
        (GearDirection::Reverse | GearDirection::Unchanged, None) => return Err(MotionError::IllegalDynamicChange),
    };

    let reference = *master_reference;
    let now = motion.clock.now();
    // The slave clutches from the speed of an earlier gearing, or of its stop.
    let slave = KinematicState {
        position: motion.axes[axis].command.position,
        velocity: motion.axes[axis]
            .sum
            .get(GeneratorKind::Gear)
            .map_or(0.0, |generator| generator.now.velocity),
        acceleration: 0.0,
    };
    motion.axes[axis].end_generator(GeneratorKind::Gear, &mut motion.controls);
    let met = motion.axes.master_at(master, reference, &motion.clock);
    let read = Master::new(master, reference, &met, &motion.clock);
    let mut gear = Gear::new(read, ratio, slave, clutch, now);
    let mut generator = Generator::followed(false);
    generator.execution = Some(execution);
    // An instruction executed later in this tick finds the slave in motion.
    generator.now = gear.follow(&met, &motion.clock);
    generator.equation = Equation::Geared(gear);
    let state = &mut motion.axes[axis];
    state.begin(GeneratorKind::Gear, generator);
    state.stale = true;
    motion.order.take(order);
    let accepted = Flag::Dn.mask() | Flag::Ip.mask();
    motion.controls.write(execution, accepted, 0);
    Ok(())
}
