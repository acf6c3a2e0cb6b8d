//! The common part of MCLM and MCCM: dynamics, termination, and the entry into the queue.
//!
//! Not here: the end points of moves ([`super::points`]), and the motion that they merge or their master ([`super::merging`]).

use arcline_instruction_set::enumerations::{Merge, MergeSpeed, TerminationType};
use arcline_instruction_set::operands::EventOperands;
use arcline_instruction_set::{Call, Flag, MotionError, SystemId};
use arcline_planner::geometry::{Path, Point, Rotation};
use arcline_planner::{Ending, InitialMotion, Move, Parameter, RotationResidual};

use super::merging::{Master, StartMotion, terminate};
use super::points::{command, queue_shift, start_point};
use super::programmed::{self, Programmed};
use crate::dynamics::{Dynamics, Maxima, PathLimits};
use crate::events::{Events, LengthRule};
use crate::execution::Execution;
use crate::machine::{CoordinateSystem, Corner, LimitPolicy};
use crate::masters::links::MasterLink;
use crate::motion::AcceptedMove;
use crate::motion::Motion;
use crate::system::{Activity, Planned, System, Termination};
use crate::verify::{self, members};

/// The operands that every coordinated move has besides its path.
#[derive(Clone, Copy, Debug)]
pub(super) struct MoveOperands {
    pub(super) programmed: Programmed,
    pub(super) termination_type: TerminationType,
    pub(super) merge: Merge,
    pub(super) merge_speed: MergeSpeed,
    pub(super) command_tolerance: f64,
    pub(super) events: EventOperands,
}

impl MoveOperands {
    /// The termination of the move, and its junction to a successor.
    fn termination(&self, system: &CoordinateSystem) -> Result<(Termination, Ending), MotionError> {
        use TerminationType::{
            ActualTolerance, CommandTolerance, CommandToleranceProgrammed, ContourVelocityConstrained,
            ContourVelocityUnconstrained, NoDecel, NoSettle,
        };
        let ending = match self.termination_type {
            ActualTolerance | NoSettle => Ending::Stop,
            CommandTolerance => Ending::Blend {
                tolerance: system.command_tolerance,
            },
            NoDecel => Ending::Blend {
                tolerance: f64::INFINITY,
            },
            ContourVelocityConstrained => Ending::Contour { constrained: true },
            ContourVelocityUnconstrained => Ending::Contour { constrained: false },
            CommandToleranceProgrammed => Ending::Blend {
                tolerance: self.command_tolerance,
            },
        };
        let blended = matches!(ending, Ending::Blend { .. });
        let superposed = blended && system.corner == Corner::Logix;
        let (axes, joints) = (system.axis_limits, system.joint_limits);
        if superposed && axes == LimitPolicy::Enforce || blended && joints == LimitPolicy::Enforce {
            return Err(MotionError::FeatureNotSupported);
        }
        let settles = match self.termination_type {
            ActualTolerance if system.actual_tolerance <= 0.0 => return Err(MotionError::InvalidActualTolerance),
            ActualTolerance => Termination::ActualTolerance(system.actual_tolerance),
            _ => Termination::Command,
        };
        Ok((settles, ending))
    }

    /// The dynamics with which the move is executed: at the speed of the merged motion if Merge Speed asks for it, and within the limits of the
    /// robots' joints.
    fn travelled(&self, mut dynamics: Dynamics, taken: &StartMotion, limits: &PathLimits) -> Dynamics {
        if self.merge != Merge::Disabled && self.merge_speed == MergeSpeed::Current && taken.speed > 0.0 {
            dynamics.keep_speed(taken.speed);
        }
        dynamics.keep_to(limits);
        dynamics
    }
}

/// Does the common verification of coordinated moves, lets `path` calculate the geometry from the start point and the operands, and starts
/// or queues the move.
pub(super) fn execute(
    motion: &mut Motion,
    execution: Execution,
    call: &Call,
    operands: &MoveOperands,
    path: impl FnOnce(&Motion, &System, Point) -> Result<Path, MotionError>,
) -> Result<(), MotionError> {
    let index = motion.target_system(call)?;
    motion.verify_operands(call)?;
    let (programmed, merge) = (&operands.programmed, operands.merge);
    programmed.verify_units()?;
    let link = motion.systems[index].links.newest().copied();
    programmed.verify_link(link.as_ref())?;
    let master = Master::of(programmed.driven_by(motion, link.as_ref())?, link);
    let events = Events::of(&operands.events, LengthRule::AtLeast)?;
    let system = &motion.systems[index];
    // The master determines the motion of an axis over time, so the controller cannot enforce its limits.
    if system.description.axis_limits == LimitPolicy::Enforce && master.is_some() {
        return Err(MotionError::FeatureNotSupported);
    }
    verify::ready(members(system, &motion.axes))?;
    verify::not_homing(members(system, &motion.axes))?;
    let dynamics = programmed.dynamics(&Maxima::from(&system.description))?;
    verify::system_stoppable(system, &motion.axes, dynamics.is_s_curve())?;
    let (termination, ending) = operands.termination(&system.description)?;
    // The queue continues in the frame in which it began; the operands refer to the present positions.
    let (start, shift) = match merge {
        Merge::Disabled => (start_point(motion, index), queue_shift(motion, index)),
        _ => (command(motion, index, |axis| axis.command.position), Point::zeros()),
    };
    let in_positions = path(motion, system, start + shift)?;
    let path = in_positions.shifted(&-shift);
    verify_conflicts(motion, index, merge)?;
    verify::no_overtravel_to(system, &motion.axes, &path.end())?;
    // A queued move starts with the orientation at the end of the queue, and keeps it.
    let (still, queued_heading) = match merge {
        Merge::Disabled => (
            motion.systems[index].keeping_heading(&motion.axes),
            motion.systems[index].queued_heading(),
        ),
        _ => (None, None),
    };
    let joints = JointLimits {
        path: path_limits(
            motion,
            index,
            &in_positions,
            still.as_ref(),
            motion.systems[index].heading(&motion.axes),
        )?,
        corner: corner_speed(motion, index, merge, &path, &shift),
    };
    let taken = StartMotion::of(motion, index, merge);
    let (taken, joints) = match &master {
        Some(master) => (taken.by_master(motion, index, master)?, joints.by_master(&master.link)),
        None => (taken, joints),
    };
    let dynamics = operands.travelled(dynamics, &taken, &joints.path);
    if master.is_some() {
        programmed::verify_reduction(taken.initial.velocity.norm(), &dynamics.limits(), path.length())?;
    }
    let residual = taken.residual();
    let heading = residual.map(|residual| residual.end()).or(queued_heading);
    let verified = Verified {
        execution,
        path,
        in_positions,
        rotation: heading.map(|heading| Rotation::keeping(&heading)),
        heading,
        dynamics,
        joints,
        termination,
        ending,
        events,
        master,
        residual,
    };
    verified.launch(motion, index, &taken)
}

/// The limits that the robots moved by a system put on the motion along a path.
///
/// # Errors
/// 67, 68 or 72: the error with which a transform would fail along the path.
pub(super) fn path_limits(
    motion: &Motion,
    index: SystemId,
    path: &Path,
    rotation: Option<&Rotation>,
    heading: Point,
) -> Result<PathLimits, MotionError> {
    let limits = motion.present().verify_reach(index, path, rotation, heading)?;
    Ok(match motion.systems[index].description.joint_limits {
        LimitPolicy::Enforce => limits,
        LimitPolicy::Ignore => PathLimits::UNLIMITED,
    })
}

/// The limit that these robots put on the speed at the corner before a queued path.
fn corner_speed(motion: &Motion, index: SystemId, merge: Merge, path: &Path, shift: &Point) -> f64 {
    let enforced = motion.systems[index].description.joint_limits == LimitPolicy::Enforce;
    if merge == Merge::Disabled && enforced {
        motion.present().corner_speed(index, path, shift)
    } else {
        f64::INFINITY
    }
}

/// The limits that the joints of robots put on a move.
#[derive(Clone, Copy, Debug)]
pub(super) struct JointLimits {
    pub(super) path: PathLimits,
    /// At the start of the path, units/s.
    pub(super) corner: f64,
}

impl JointLimits {
    /// The limits over the displacement of a master.
    pub(super) fn by_master(&self, link: &MasterLink) -> JointLimits {
        JointLimits {
            path: self.path.by_master(link.nominal),
            corner: self.corner / link.nominal,
        }
    }
}

/// A verified move.
pub(super) struct Verified {
    pub(super) execution: Execution,
    /// In the frame of the queue.
    pub(super) path: Path,
    /// In present positions.
    pub(super) in_positions: Path,
    pub(super) rotation: Option<Rotation>,
    /// Rx, Ry, Rz at its end, degrees, if it rotates.
    pub(super) heading: Option<Point>,
    pub(super) dynamics: Dynamics,
    pub(super) joints: JointLimits,
    pub(super) termination: Termination,
    pub(super) ending: Ending,
    pub(super) events: Option<Events>,
    pub(super) master: Option<Master>,
    /// A rotation that ramps out beside it.
    pub(super) residual: Option<RotationResidual>,
}

impl Verified {
    /// Starts or queues the move.
    pub(super) fn launch(self, motion: &mut Motion, index: SystemId, taken: &StartMotion) -> Result<(), MotionError> {
        let parameter = match &self.master {
            Some(master) => master.parameter(motion, index, taken.merge),
            None => Parameter::TIME,
        };
        let driven_by = self.master.map(|master| master.driven_by);
        let planned = Move {
            path: self.path,
            rotation: self.rotation,
            corner: self.joints.corner,
            limits: self.dynamics.limits(),
            last_speed: self.dynamics.last_speed,
            ending: self.ending,
            parameter,
            data: Planned {
                execution: self.execution,
                dynamics: self.dynamics,
                termination: self.termination,
                driven_by,
                events: self.events,
                path_limits: self.joints.path,
                heading: self.heading,
                only_turns: self.path.stands(),
            },
        };
        let accepted = self.accepted(index, motion.clock.tick);
        if taken.merge != Merge::Disabled {
            terminate(motion, index, taken.merge);
        }
        if motion.systems[index].travel.begins_at_once(&taken.initial) {
            start(motion, index, planned, &taken.initial, self.residual)?;
        } else {
            let queued = motion.systems[index].push(planned, &motion.clock);
            queued.map_err(|_| MotionError::CoordinateSystemQueueFull)?;
            if self.heading.is_some() {
                motion.systems[index].begin_coordinated_rotation(&mut motion.axes, self.dynamics.is_s_curve());
            }
        }
        motion.accept(accepted);
        let bits = Flag::Dn.mask() | Flag::Ip.mask();
        motion.controls.write(self.execution, bits, 0);
        Ok(())
    }

    fn accepted(&self, system: SystemId, tick: u64) -> AcceptedMove {
        AcceptedMove {
            tick,
            ticket: self.execution.ticket,
            control: self.execution.control,
            mnemonic: self.execution.mnemonic,
            system,
            path: self.in_positions,
            tolerance: match self.ending {
                Ending::Blend { tolerance } if !self.path.stands() => tolerance,
                Ending::Blend { .. } | Ending::Stop | Ending::Contour { .. } => 0.0,
            },
        }
    }
}

/// Starts a move in place of the terminated motion.
fn start(
    motion: &mut Motion,
    index: SystemId,
    planned: Move<Planned>,
    initial: &InitialMotion,
    residual: Option<RotationResidual>,
) -> Result<(), MotionError> {
    motion.systems[index].activate_link(
        planned.data.driven_by,
        motion.clock.now(),
        &motion.axes,
        &mut motion.controls,
        &motion.clock,
    )?;
    let system = &mut motion.systems[index];
    let base = system.time_base(&motion.clock);
    let enforced = system.description.axis_limits == LimitPolicy::Enforce;
    let axis_limits = enforced.then_some(&system.axis_limits);
    system.travel.merge(planned, *initial, residual, axis_limits, &base);
    system.activity = Activity::Moving;
    system.shown.has_moved = system.follower.is_none() && !system.travel.is_paused() && planned.path.length() > 0.0;
    system.stale = true;
    motion.systems[index].activate(&mut motion.axes, &mut motion.controls, &motion.clock);
    motion.systems[index].set_axis_commands(&mut motion.axes, &motion.clock);
    Ok(())
}

/// Step 11: checks the queue, a stop under way, and another coordinate system that holds one of the axes.
pub(super) fn verify_conflicts(motion: &Motion, index: SystemId, merge: Merge) -> Result<(), MotionError> {
    let system = &motion.systems[index];
    if merge == Merge::Disabled && system.activity == Activity::Moving && system.travel.is_full() {
        return Err(MotionError::CoordinateSystemQueueFull);
    }
    verify::system_not_stopping(system, &motion.axes)?;
    if merge == Merge::AllMotion {
        return Ok(());
    }
    for (other_index, other) in motion.systems.ids().zip(motion.systems.iter()) {
        if other_index != index
            && other.is_busy()
            && let Some(member) = system.shared_axis(other)
        {
            return Err(MotionError::CoordinatedMotionInProcess(member));
        }
    }
    Ok(())
}
