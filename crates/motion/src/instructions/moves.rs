//! What MCLM and MCCM share: dynamics, termination, and the way into the queue.
//!
//! Not here: where moves begin and end ([`super::points`]), and what they are merged with or follow ([`super::merging`]).

use arcline_instruction_set::enumerations::{Merge, MergeSpeed, TerminationType};
use arcline_instruction_set::operands::EventOperands;
use arcline_instruction_set::{Call, Flag, MotionError, SystemId};
use arcline_planner::geometry::{Path, Point, Turn};
use arcline_planner::{Ending, InitialMotion, Move, Parameter, TurnResidual};

use super::merging::{on_the_way, parameter, terminate, terminated, verify_lead};
use super::points::{command, queue_shift, start_point};
use super::programmed::{self, Programmed};
use crate::accepted::AcceptedMove;
use crate::control::Execution;
use crate::dynamics::Maxima;
use crate::dynamics::PathLimits;
use crate::events::{Events, Fit};
use crate::machine::{AxisLimits, CoordinateSystem, Corner};
use crate::motion::Motion;
use crate::system::{Activity, Planned, System, Termination};
use crate::verify;

/// The operands that every coordinated move has beside its path.
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
    /// How the move completes, and what happens there if it has a successor.
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
        if superposed && axes == AxisLimits::Enforce || blended && joints == AxisLimits::Enforce {
            return Err(MotionError::FeatureNotSupported);
        }
        let settles = match self.termination_type {
            ActualTolerance if system.actual_tolerance <= 0.0 => return Err(MotionError::InvalidActualTolerance),
            ActualTolerance => Termination::ActualTolerance,
            _ => Termination::Command,
        };
        Ok((settles, ending))
    }
}

/// Verifies what every coordinated move has in common, lets `path` find the geometry between the start point
/// and the operands, and starts or queues the move.
pub(super) fn execute(
    motion: &mut Motion,
    execution: Execution,
    call: &Call,
    operands: &MoveOperands,
    path: impl FnOnce(&Motion, &System, Point) -> Result<Path, MotionError>,
) -> Result<(), MotionError> {
    let index = motion.target_system(call)?;
    motion.verify_operands(call)?;
    let programmed = &operands.programmed;
    programmed.verify_units()?;
    let link = motion.systems[index].links.newest().copied();
    programmed.verify_link(link.as_ref())?;
    let lead = programmed.lead(motion, link.as_ref())?;
    let events = Events::of(&operands.events, Fit::AtLeast)?;
    let system = &motion.systems[index];
    // What an axis does by time is its master's to decide.
    if system.description.axis_limits == AxisLimits::Enforce && lead.is_some() {
        return Err(MotionError::FeatureNotSupported);
    }
    verify::axes_ready(system, &motion.axes)?;
    verify::not_homing(system, &motion.axes)?;
    let mut dynamics = programmed.dynamics(&Maxima::from(&system.description))?;
    verify::stoppable(system, &motion.axes, dynamics.is_s_curve())?;
    let (termination, ending) = operands.termination(&system.description)?;
    let merge = operands.merge;
    let start = if merge == Merge::Disabled {
        start_point(motion, index)
    } else {
        command(motion, index, |axis| axis.command.position)
    };
    // The queue goes on in the frame in which it began, the operands are of the positions as they are now.
    let shift = match merge {
        Merge::Disabled => queue_shift(motion, index),
        _ => Point::zeros(),
    };
    let in_positions = path(motion, system, start + shift)?;
    let path = in_positions.shifted(&-shift);
    verify_conflicts(motion, index, merge)?;
    verify::no_overtravel(system, &motion.axes, &path.end())?;
    // What queues begins with the orientation at the end of the queue, and keeps it.
    let still = (merge == Merge::Disabled).then(|| motion.still(index)).flatten();
    let mut heading = (merge == Merge::Disabled)
        .then(|| motion.queued_heading(index))
        .flatten();
    let mut pace =
        motion
            .present()
            .verify_reach(index, &path.shifted(&shift), still.as_ref(), motion.heading(index))?;
    if system.description.joint_limits == AxisLimits::Ignore {
        pace = PathLimits::UNLIMITED;
    }

    let mut corner = f64::INFINITY;
    if merge == Merge::Disabled && system.description.joint_limits == AxisLimits::Enforce {
        corner = motion.present().corner_speed(index, &path, &shift);
    }
    let mut initial = terminated(motion, index, merge);
    let mut turning = match merge {
        Merge::Disabled => None,
        _ => motion.turning(index),
    };
    let mut current = command(motion, index, |axis| axis.command.velocity).norm();
    let mut driven = false;
    if let (Some(lead), Some(link)) = (lead, &link) {
        let turns = turning.is_some_and(|turning| turning.rate != Point::zeros());
        let moves = initial.velocity != Point::zeros() || turns;
        let by_master = programmed::pace(link, lead.lock, moves)?;
        let idle = merge != Merge::Disabled && !moves && link.master.velocity() == 0.0;
        verify_lead(motion, index, merge, lead, idle)?;
        initial = on_the_way(&by_master, &initial);
        turning = turning.map(|turning| turning.on_the_way(&by_master, link.nominal));
        current = if by_master.speed > 0.0 {
            current / by_master.speed
        } else {
            0.0
        };
        driven = true;
        pace = pace.by_master(link.nominal);
        corner /= link.nominal;
    }
    if merge != Merge::Disabled && operands.merge_speed == MergeSpeed::Current && current > 0.0 {
        dynamics.keep_speed(current);
    }
    dynamics.keep_to(&pace);
    if driven {
        programmed::verify_reduction(initial.velocity.norm(), &dynamics.limits(), path.length())?;
    }
    let parameter = match (lead, &link) {
        (Some(lead), Some(link)) => parameter(motion, index, merge, lead, link),
        _ => Parameter::TIME,
    };
    let residual = turning.and_then(|turning| turning.ramped_out());
    heading = residual.map(|residual| residual.end()).or(heading);
    let planned = Move {
        path,
        turn: heading.map(|heading| Turn::keeping(&heading)),
        corner,
        limits: dynamics.limits(),
        ending,
        parameter,
        data: Planned {
            execution,
            dynamics,
            termination,
            lead,
            events,
            pace,
            heading,
            only_turns: false,
        },
    };
    let taken = TakenOver {
        initial,
        residual,
        merge,
    };
    launch(motion, index, planned, in_positions, taken)
}

/// What a move goes on from.
#[derive(Clone, Copy, Debug)]
pub(super) struct TakenOver {
    pub(super) initial: InitialMotion,
    /// A turn that ramps out beside the move.
    pub(super) residual: Option<TurnResidual>,
    pub(super) merge: Merge,
}

/// Starts or queues a move that was verified. `programmed`: its path in positions as they are now.
pub(super) fn launch(
    motion: &mut Motion,
    index: SystemId,
    planned: Move<Planned>,
    programmed: Path,
    taken: TakenOver,
) -> Result<(), MotionError> {
    let Planned { execution, lead, .. } = planned.data;
    let TakenOver {
        initial,
        residual,
        merge,
    } = taken;
    let accepted = Flag::Dn.mask() | Flag::Ip.mask();
    let tick = motion.clock.tick;
    let accepted_move = AcceptedMove {
        tick,
        ticket: execution.ticket,
        control: execution.control,
        mnemonic: execution.mnemonic,
        system: index,
        path: programmed,
        tolerance: match planned.ending {
            Ending::Blend { tolerance } if !planned.data.only_turns => tolerance,
            Ending::Blend { .. } | Ending::Stop | Ending::Contour { .. } => 0.0,
        },
    };
    if merge != Merge::Disabled {
        terminate(motion, index, merge);
    }
    let at_once = motion.systems[index].travel.begins_at_once(&initial);
    if at_once {
        motion.lead_system(index, lead, motion.clock.now())?;
        let system = &mut motion.systems[index];
        let base = system.time_base(&motion.clock);
        let enforced = system.description.axis_limits == AxisLimits::Enforce;
        let kept = enforced.then_some(&system.axis_limits);
        system.travel.merge(planned, initial, residual, kept, &base);
        system.activity = Activity::Moving;
        system.shown.has_moved = system.guide.is_none() && !system.travel.is_paused() && planned.path.length() > 0.0;
        system.stale = true;
        motion.activate(index);
        motion.set_axis_commands(index);
    } else {
        let queued = motion.systems[index].push(planned, &motion.clock);
        queued.map_err(|_| MotionError::CoordinateSystemQueueFull)?;
        if planned.data.heading.is_some() {
            motion.join_turned_axes(index, planned.data.dynamics.is_s_curve());
        }
    }
    motion.accept(accepted_move);
    motion.controls.write(execution, accepted, 0, tick);
    Ok(())
}

/// Step 11: the queue, a stop under way, another coordinate system that holds one of the axes.
pub(super) fn verify_conflicts(motion: &Motion, index: SystemId, merge: Merge) -> Result<(), MotionError> {
    let system = &motion.systems[index];
    if merge == Merge::Disabled && system.activity == Activity::Moving && system.travel.is_full() {
        return Err(MotionError::CoordinateSystemQueueFull);
    }
    verify::not_stopping(system, &motion.axes)?;
    if merge == Merge::AllMotion {
        return Ok(());
    }
    for (other_index, other) in motion.systems.ids().zip(motion.systems.iter()) {
        if other_index != index
            && other.is_busy()
            && let Some(place) = system.shared_axis(other)
        {
            return Err(MotionError::CoordinatedMotionInProcess(place));
        }
    }
    Ok(())
}
