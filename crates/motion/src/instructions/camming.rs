//! The common part of MAPC and MATC: directions, modes, and the start of a cam or its wait for the end of another.

use arcline_instruction_set::enumerations::GearDirection;
use arcline_instruction_set::operands::OperandValue;
use arcline_instruction_set::{AxisId, AxisIndex, Flag, MotionError, OperandIndex};

use crate::axis::Axis;
use crate::axis::camming::Offset;
use crate::axis::generator::{Equation, Generator};
use crate::axis::generator_kind::GeneratorKind;
use crate::execution::Execution;
use crate::masters::MasterAt;
use crate::masters::cam::{Cam, CamProgram, Pending, Source};
use crate::masters::displacement::Crossing;
use crate::motion::Motion;
use crate::range;
use crate::verify::{self, alone};

/// The sign of the profile: 1 adds it, -1 subtracts it. Without an earlier cam, Reverse means Opposite and Unchanged means Same.
pub(super) fn sign(direction: GearDirection, before: Option<f64>) -> f64 {
    match direction {
        GearDirection::Same => 1.0,
        GearDirection::Opposite => -1.0,
        GearDirection::Reverse => -before.unwrap_or(1.0),
        GearDirection::Unchanged => before.unwrap_or(1.0),
    }
}

/// Checks a position operand that lies on a turn of a master axis.
pub(super) fn on_turn(axis: &Axis, position: &OperandValue<f64>) -> Result<(), MotionError> {
    match axis.unwind {
        Some(unwind) if !(0.0..unwind).contains(&**position) => Err(position.out_of_range()),
        _ => Ok(()),
    }
}

/// Checks that neither a stop of the whole axis nor one of this kind of cam is under way.
pub(super) fn not_stopping(axis: &Axis, kind: GeneratorKind) -> Result<(), MotionError> {
    verify::not_stopping(alone(axis))?;
    if axis.sum.get(kind).is_some_and(|generator| generator.stopping) {
        return Err(MotionError::NotAllowedWhileStopping(AxisIndex(0)));
    }
    Ok(())
}

/// Checks the schedule of a cam: a pending cam needs the same master as the active one; any other needs no active cam of its kind, and no
/// pending one with another master.
///
/// # Errors
/// `IllegalDynamicChange` (23).
pub(super) fn verify_change(
    axis: &Axis,
    kind: GeneratorKind,
    source: Source,
    pending: bool,
) -> Result<(), MotionError> {
    let same = |other: Source| match (other, source) {
        (Source::Time { .. }, Source::Time { .. }) => true,
        (other, source) => other == source,
    };
    let runs = axis.cam(kind).map(Cam::source);
    let waits = axis.cams(kind).pending.as_ref().map(|pending| pending.program.source);
    let fits = if pending {
        runs.is_none_or(same)
    } else {
        waits.is_none_or(same)
    };
    if !fits || (!pending && runs.is_some()) {
        return Err(MotionError::IllegalDynamicChange);
    }
    Ok(())
}

/// A verified cam that is to begin.
pub(super) struct CamStart {
    pub(super) kind: GeneratorKind,
    pub(super) program: CamProgram,
    pub(super) lock: Option<Crossing>,
    /// The state of the master at the present tick.
    pub(super) master: MasterAt,
}

/// Checks that the slave stays within its range over the whole profile.
///
/// # Errors
/// `ParameterOutOfRange` (13) with the scaling of the slave.
pub(super) fn verify_reach(
    motion: &Motion,
    axis: AxisId,
    program: &CamProgram,
    scaling: OperandIndex,
) -> Result<(), MotionError> {
    let state = &motion.axes[axis];
    let reach = program.profile.reach() * program.slave_scale.abs();
    range::verify(state, state.command.position.abs() + reach, scaling)
}

/// Makes the cam wait for the end of the active one.
pub(super) fn wait(motion: &mut Motion, axis: AxisId, kind: GeneratorKind, program: CamProgram, execution: Execution) {
    motion.axes[axis].end_pending_cams(Some(kind), &mut motion.controls);
    let cams = motion.axes[axis].cams_mut(kind);
    cams.direction = Some(program.slave_scale.signum());
    cams.pending = Some(Pending { program, execution });
    accept(motion, execution);
}

/// The cam begins now.
pub(super) fn begin(motion: &mut Motion, axis: AxisId, beginning: CamStart, execution: Execution) {
    let CamStart {
        kind,
        program,
        lock,
        master,
    } = beginning;
    if kind == GeneratorKind::PositionCam {
        motion.axes[axis].end_generator(GeneratorKind::MasterOffset, &mut motion.controls);
        motion.axes[axis].cams_mut(kind).offset = Offset::default();
    }
    let clock = motion.clock;
    let state = &mut motion.axes[axis];
    state.cams_mut(kind).direction = Some(program.slave_scale.signum());
    let slave = state.command.position;
    let cam = Cam::new(program, lock, &master, slave, &clock);
    let segment = cam.segment();
    let mut generator = Generator::followed(false);
    generator.execution = Some(execution);
    generator.shown_segment = segment;
    generator.equation = Equation::Cammed(cam);
    state.begin(kind, generator);
    // An instruction executed later in this tick finds the slave in motion.
    state.follow_cam(kind, &master, &clock);
    state.command = state.sum.command();
    state.stale = true;
    accept(motion, execution);
    motion.controls.set_segment(execution, segment as i32);
}

fn accept(motion: &mut Motion, execution: Execution) {
    let accepted = Flag::Dn.mask() | Flag::Ip.mask();
    motion.controls.write(execution, accepted, 0);
}
