//! MCCD, Motion Coordinated Change Dynamics (spec/coordinated-instructions.md §14, the MCCD seed).

use arcline_instruction_set::{Call, Mnemonic, MotionError};

use super::{moves, place};
use crate::control::Execution;
use crate::dynamics::{Dynamics, in_units, jerk_in_units};
use crate::machine::CoordinateSystem;
use crate::motion::Motion;
use crate::system::Activity;
use crate::verify;

/// Places of MCCD's operands.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Layout {
    change_speed: usize,
    speed: usize,
    speed_units: usize,
    change_accel: usize,
    accel_rate: usize,
    accel_units: usize,
    change_decel: usize,
    decel_rate: usize,
    decel_units: usize,
    change_accel_jerk: usize,
    accel_jerk: usize,
    change_decel_jerk: usize,
    decel_jerk: usize,
    jerk_units: usize,
    scope: usize,
}

/// Scope: Active and Pending Motion.
const ACTIVE_AND_PENDING: i32 = 1;

impl Layout {
    pub(super) fn new() -> Self {
        let place = |name| place(Mnemonic::Mccd, name);
        Layout {
            change_speed: place("Change Speed"),
            speed: place("Speed"),
            speed_units: place("Speed Units"),
            change_accel: place("Change Accel"),
            accel_rate: place("Accel Rate"),
            accel_units: place("Accel Units"),
            change_decel: place("Change Decel"),
            decel_rate: place("Decel Rate"),
            decel_units: place("Decel Units"),
            change_accel_jerk: place("Change Accel Jerk"),
            accel_jerk: place("Accel Jerk"),
            change_decel_jerk: place("Change Decel Jerk"),
            decel_jerk: place("Decel Jerk"),
            jerk_units: place("Jerk Units"),
            scope: place("Scope"),
        }
    }

    /// Moves are time driven, so every unit of a change must be.
    fn verify_mode(&self, call: &Call) -> Result<(), MotionError> {
        let changes = |flag: usize| call.word(flag) == 1;
        let master = |units: usize| verify::is_master_driven(call.number(units));
        let rates = [
            (changes(self.change_accel), self.accel_units),
            (changes(self.change_decel), self.decel_units),
            (
                changes(self.change_accel_jerk) || changes(self.change_decel_jerk),
                self.jerk_units,
            ),
        ];
        let mixed = |mode: bool| rates.iter().any(|(changed, units)| *changed && master(*units) != mode);
        if changes(self.change_speed) {
            let mode = master(self.speed_units);
            if mixed(mode) {
                return Err(MotionError::MdscUnitsConflict);
            }
            if mode {
                return Err(MotionError::MdscInvalidModeOrMasterChange);
            }
        } else if mixed(false) {
            return Err(MotionError::MdscUnitsConflict);
        }
        Ok(())
    }

    fn change(&self, call: &Call, system: &CoordinateSystem, mut dynamics: Dynamics) -> Result<Dynamics, MotionError> {
        let changes = |flag: usize| call.word(flag) == 1;
        let units = |value, word, maximum| in_units(call.number(value), call.word(word), maximum);
        let jerk = |value, maximum| jerk_in_units(call.number(value), call.word(self.jerk_units), maximum);
        if changes(self.change_speed) {
            dynamics.set_speed(units(self.speed, self.speed_units, system.max_speed));
        }
        if changes(self.change_accel) {
            dynamics.acceleration = units(self.accel_rate, self.accel_units, system.max_acceleration);
            moves::positive(dynamics.acceleration, self.accel_rate)?;
        }
        if changes(self.change_decel) {
            dynamics.deceleration = units(self.decel_rate, self.decel_units, system.max_deceleration);
            moves::positive(dynamics.deceleration, self.decel_rate)?;
        }
        if changes(self.change_accel_jerk) {
            dynamics.jerks_mut().acceleration = jerk(self.accel_jerk, system.max_acceleration_jerk);
        }
        if changes(self.change_decel_jerk) {
            dynamics.jerks_mut().deceleration = jerk(self.decel_jerk, system.max_deceleration_jerk);
        }
        if let Some(limit) = dynamics.limits().jerk {
            moves::positive(limit.acceleration, self.accel_jerk)?;
            moves::positive(limit.deceleration, self.decel_jerk)?;
        }
        Ok(dynamics)
    }
}

pub(super) fn execute(motion: &mut Motion, execution: Execution, call: &Call) -> Result<(), MotionError> {
    let layout = motion.layouts.mccd;
    let index = motion.target_system(call)?;
    motion.verify_operands(call)?;
    layout.verify_mode(call)?;
    verify::axes_ready(&motion.systems[index], &motion.axes)?;
    let system = &mut motion.systems[index];
    let active = match (system.activity, system.active()) {
        (Activity::Moving, Some(active)) => active,
        (Activity::Stopping, _) => return verify::not_stopping(system, &motion.axes),
        _ => return Err(MotionError::IllegalDynamicChange),
    };
    verify::stoppable(system, &motion.axes, active.dynamics.is_s_curve())?;
    let dynamics = layout.change(call, &system.description, active.dynamics)?;
    if system.contour.is_some() {
        change_contour(motion, index, call, active.dynamics.speed, dynamics.speed)?;
        motion.done(execution);
        return Ok(());
    }
    if call.word(layout.scope) == ACTIVE_AND_PENDING {
        for waiting in system.planner.pending() {
            layout.change(call, &system.description, waiting.data.dynamics)?;
        }
        let description = &system.description;
        for waiting in system.planner.pending_mut() {
            waiting.data.dynamics = layout.change(call, description, waiting.data.dynamics)?;
            waiting.limits = waiting.data.dynamics.limits();
        }
    }
    if let Some(active) = system.planner.active_data() {
        active.dynamics = dynamics;
    }
    system.planner.change_limits(dynamics.limits(), &motion.clock);
    system.stale = true;
    motion.done(execution);
    Ok(())
}

/// On a planned contour a new speed is a pace, at most the planned one; everything else is for the moves that have not
/// been planned yet.
fn change_contour(
    motion: &mut Motion,
    index: usize,
    call: &Call,
    programmed: f64,
    speed: f64,
) -> Result<(), MotionError> {
    let layout = motion.layouts.mccd;
    let system = &mut motion.systems[index];
    let Some(contour) = &mut system.contour else {
        return Ok(());
    };
    if call.word(layout.scope) == ACTIVE_AND_PENDING {
        for waiting in contour.unplanned_mut() {
            layout.change(call, &system.description, waiting.data.dynamics)?;
        }
        for waiting in contour.unplanned_mut() {
            waiting.data.dynamics = layout.change(call, &system.description, waiting.data.dynamics)?;
            waiting.limits = waiting.data.dynamics.limits();
        }
    }
    if call.word(layout.change_speed) == 1 && programmed > 0.0 {
        contour.set_share(speed / programmed, &motion.clock);
        system.stale = true;
    }
    Ok(())
}
