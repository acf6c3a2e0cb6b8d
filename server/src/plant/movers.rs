//! The principal that moves each axis and each coordinate system: that of the newest instruction that began motion there and still runs, and
//! behind the end of that instruction as long as the object still moves. Coordinate systems that a transform couples, and their axes, have
//! the mover of the one that is moved.

use std::collections::{BTreeMap, VecDeque};
use std::fmt;
use std::sync::Arc;

use arcline_controller::machine::Machine;
use arcline_controller::{AxisSnapshot, Snapshot, SystemSnapshot, Ticket};
use arcline_instruction_set::predefined::{coordinate_motion_status, coordinate_system_status, motion_status};
use arcline_instruction_set::{Argument, AxisId, Call, Flag, Mnemonic, SystemId};
use arcline_proto::arcline::motion::{self, MoverKind};

use super::client::ClientIdentity;
use super::control::{MotionObject, ViewerId};
use super::policy::stop_of;
use super::principal::Principal;
use super::records::Executions;
use super::state::may_run;

/// The instructions by which objects move, and the movers that follow from them.
#[derive(Debug)]
pub(super) struct MotionTickets {
    /// The instructions that began motion of each object.
    begun: BTreeMap<MotionObject, Instructions>,
    /// The transforms, newest first.
    transforms: Instructions,
    /// The axes of each coordinate system.
    systems: Vec<Vec<AxisId>>,
    /// The movers that the controller has confirmed: each lasts until its object rests.
    confirmed: Movers,
    movers: Arc<Movers>,
    /// Whether an execution has changed since the last search for the movers.
    is_stale: bool,
    /// Whether an object still moves behind the end of its instruction, so that the movers change with the next snapshot too.
    outlasts: bool,
}

/// Instructions of one object, newest first. Those that have ended are dropped when they are half of all, so that their number is bounded
/// by twice the number that runs at a time.
#[derive(Debug, Default)]
struct Instructions {
    all: VecDeque<Instruction>,
    /// The number at which those that have ended are dropped.
    full: usize,
}

/// An instruction that may move an object.
#[derive(Clone, Debug)]
struct Instruction {
    ticket: Ticket,
    mover: Mover,
    /// The coordinate systems that it couples: source and target.
    coupled: Option<[SystemId; 2]>,
}

impl Instructions {
    fn push(&mut self, instruction: Instruction, records: &Executions) {
        if self.all.len() >= self.full {
            self.all.retain(|earlier| is_running(earlier.ticket, records));
            self.full = FEW.max(2 * self.all.len());
        }
        self.all.push_front(instruction);
    }

    /// Those that the controller has taken and that run.
    fn in_process<'s>(&'s self, records: &Executions) -> impl Iterator<Item = &'s Instruction> {
        let is_in_process = move |ticket| records.get(ticket).is_some_and(|control| control.has(Flag::Ip));
        self.all
            .iter()
            .filter(move |instruction| is_in_process(instruction.ticket))
    }

    /// Those that run or wait for their answer.
    fn running<'s>(&'s self, records: &Executions) -> impl Iterator<Item = &'s Instruction> {
        self.all
            .iter()
            .filter(move |instruction| is_running(instruction.ticket, records))
    }
}

/// Whether an execution runs or waits for its answer, as far as its record shows.
fn is_running(ticket: Ticket, records: &Executions) -> bool {
    records.get(ticket).is_some_and(may_run)
}

impl MotionTickets {
    /// The movers of a machine at rest.
    pub(super) fn new(machine: &Machine) -> Self {
        let none = Movers {
            axes: vec![None; machine.axes.len()],
            systems: vec![None; machine.systems.len()],
        };
        MotionTickets {
            begun: BTreeMap::new(),
            transforms: Instructions::default(),
            systems: machine.systems.iter().map(|system| system.axes.clone()).collect(),
            confirmed: none.clone(),
            movers: Arc::new(none),
            is_stale: false,
            outlasts: false,
        }
    }

    /// An execution has changed.
    pub(super) fn executions_changed(&mut self) {
        self.is_stale = true;
    }

    /// There is a new snapshot.
    pub(super) fn snapshot_changed(&mut self) {
        self.is_stale |= self.outlasts;
    }

    /// Notes a call that may begin motion.
    pub(super) fn note(&mut self, ticket: Ticket, call: &Call, records: &Executions) {
        let Some((target, mover)) = moved(call.mnemonic, call.target, ticket, records) else {
            return;
        };
        let coupled = call.arguments.iter().find_map(|argument| match argument {
            Argument::Object(other) => Some([SystemId(target), SystemId(*other)]),
            _ => None,
        });
        let coupled = coupled.filter(|_| matches!(call.mnemonic, Mnemonic::Mct | Mnemonic::Mcto));
        let object = MotionObject::of(call.mnemonic.instruction().object, target);
        let instructions = match coupled {
            Some(_) => &mut self.transforms,
            None => self.begun.entry(object).or_default(),
        };
        instructions.push(Instruction { ticket, mover, coupled }, records);
        self.is_stale = true;
    }

    /// The controller has begun an instruction: should it end within the same look at the controller, its object may still move.
    pub(super) fn began(&mut self, mnemonic: Mnemonic, target: Option<u16>, ticket: Ticket, records: &Executions) {
        let Some((target, mover)) = moved(mnemonic, target, ticket, records) else {
            return;
        };
        let object = MotionObject::of(mnemonic.instruction().object, target);
        let axes: &[AxisId] = match &object {
            MotionObject::Axis(axis) => std::slice::from_ref(axis),
            MotionObject::System(system) => self.systems.get(system.index()).map_or(&[], Vec::as_slice),
            MotionObject::Group => &[],
        };
        for axis in axes {
            if let Some(place) = self.confirmed.axes.get_mut(axis.index()) {
                *place = Some(mover.clone());
            }
        }
        if let MotionObject::System(system) = object
            && let Some(place) = self.confirmed.systems.get_mut(system.index())
        {
            *place = Some(mover);
        }
        self.is_stale = true;
    }

    /// The movers as the executions and the snapshot are now.
    pub(super) fn movers(&mut self, records: &Executions, snapshot: &Snapshot) -> Arc<Movers> {
        if std::mem::take(&mut self.is_stale) {
            self.search(records, snapshot);
        }
        self.movers.clone()
    }

    fn search(&mut self, records: &Executions, snapshot: &Snapshot) {
        let before = std::mem::take(&mut self.confirmed);
        let mut outlasts = false;
        let mut lasting = |mover: Option<Mover>, moves: bool| {
            let mover = mover.filter(|_| moves);
            outlasts |= mover.is_some();
            mover
        };
        let mut confirmed = Movers::default();
        let pairs: Vec<&Instruction> = self.transforms.in_process(records).collect();
        for (system, before) in SystemId::first(before.systems.len()).zip(before.systems) {
            let mover = self
                .in_process(MotionObject::System(system), records)
                .or_else(|| self.mover_of_coupled(system, &pairs, records))
                .cloned()
                .or_else(|| lasting(before, is_system_moving(snapshot, system)));
            confirmed.systems.push(mover);
        }
        for (axis, before) in AxisId::first(before.axes.len()).zip(before.axes) {
            let mover = self
                .in_process(MotionObject::Axis(axis), records)
                .or_else(|| self.systems_of(axis).find_map(|system| confirmed.of_system(system)))
                .cloned()
                .or_else(|| lasting(before, is_axis_moving(snapshot, axis)));
            confirmed.axes.push(mover);
        }
        self.outlasts = outlasts;
        let mut movers = confirmed.clone();
        for (system, mover) in SystemId::first(movers.systems.len()).zip(&mut movers.systems) {
            if mover.is_none() {
                *mover = self.waiting(MotionObject::System(system), records).cloned();
            }
        }
        for (axis, mover) in AxisId::first(movers.axes.len()).zip(&mut movers.axes) {
            if mover.is_none() {
                let mut its_own = self.systems_of(axis).map(MotionObject::System);
                *mover = self
                    .waiting(MotionObject::Axis(axis), records)
                    .or_else(|| its_own.find_map(|system| self.waiting(system, records)))
                    .cloned();
            }
        }
        self.confirmed = confirmed;
        self.movers = Arc::new(movers);
    }

    /// A mover of an axis, or of a coordinate system that has it, that is not of a viewer's own.
    pub(super) fn another_mover(
        &mut self,
        axis: AxisId,
        viewer: Option<ViewerId>,
        records: &Executions,
        snapshot: &Snapshot,
    ) -> Option<Mover> {
        let movers = self.movers(records, snapshot);
        let objects = self.systems_of(axis).map(MotionObject::System);
        let begun = std::iter::once(MotionObject::Axis(axis))
            .chain(objects)
            .filter_map(|object| self.begun.get(&object));
        let running = begun.flat_map(|begun| begun.running(records));
        let mut all = movers
            .of_axis(axis)
            .into_iter()
            .chain(running.map(|begun| &begun.mover));
        all.find(|mover| mover.principal.viewer() != viewer).cloned()
    }

    /// The mover of an object by an instruction of its own that the controller has taken.
    fn in_process(&self, object: MotionObject, records: &Executions) -> Option<&Mover> {
        let newest = self.begun.get(&object)?.in_process(records).next();
        newest.map(|instruction| &instruction.mover)
    }

    /// The mover of an object by an instruction that waits for its answer.
    fn waiting(&self, object: MotionObject, records: &Executions) -> Option<&Mover> {
        let newest = self.begun.get(&object)?.running(records).next();
        newest.map(|instruction| &instruction.mover)
    }

    /// The coordinate systems that have an axis.
    fn systems_of(&self, axis: AxisId) -> impl Iterator<Item = SystemId> {
        let systems = SystemId::first(self.systems.len()).zip(&self.systems);
        systems
            .filter(move |(_, axes)| axes.contains(&axis))
            .map(|(system, _)| system)
    }

    /// The mover of a coordinate system that transforms couple to others: that of the nearest one which is moved, by itself or by its axes,
    /// sources first; else that of the transform.
    fn mover_of_coupled<'s>(
        &'s self,
        system: SystemId,
        pairs: &[&'s Instruction],
        records: &Executions,
    ) -> Option<&'s Mover> {
        let coupled = |system| {
            let of = |from: usize| {
                let pairs = pairs.iter().filter_map(move |pair| Some((pair.coupled?, *pair)));
                pairs
                    .filter(move |(pair, _)| pair[from] == system)
                    .map(move |(pair, by)| (pair[1 - from], by))
            };
            of(1).chain(of(0))
        };
        let (_, transform) = coupled(system).next()?;
        let mut seen = vec![system];
        let mut next = 0;
        while let Some(at) = seen.get(next).copied() {
            next += 1;
            for (other, _) in coupled(at) {
                if seen.contains(&other) {
                    continue;
                }
                let axes = self.systems.get(other.index());
                let mut objects = axes.into_iter().flatten().copied().map(MotionObject::Axis);
                let mover = self
                    .in_process(MotionObject::System(other), records)
                    .or_else(|| objects.find_map(|axis| self.in_process(axis, records)));
                if mover.is_some() {
                    return mover;
                }
                seen.push(other);
            }
        }
        Some(&transform.mover)
    }
}

/// The object that an execution may move, and its mover; `None`: the instruction begins no motion.
fn moved(mnemonic: Mnemonic, target: Option<u16>, ticket: Ticket, records: &Executions) -> Option<(u16, Mover)> {
    stop_of(mnemonic)?;
    let origin = records.origin(ticket)?;
    let mover = Mover {
        principal: origin.principal,
        client: origin.client.clone(),
    };
    Some((target?, mover))
}

/// Whether an axis moves, or is being stopped.
fn is_axis_moving(snapshot: &Snapshot, axis: AxisId) -> bool {
    let moves =
        |axis: &AxisSnapshot| axis.command[1] != 0.0 || axis.motion_status & motion_status::STOPPING_STATUS != 0;
    snapshot.axes.get(axis.index()).is_some_and(moves)
}

/// Whether a coordinate system moves, or is being stopped.
fn is_system_moving(snapshot: &Snapshot, system: SystemId) -> bool {
    let moves = |system: &SystemSnapshot| {
        system.status & coordinate_system_status::MOTION_STATUS != 0
            || system.motion_status & coordinate_motion_status::STOPPING_STATUS != 0
    };
    snapshot.systems.get(system.index()).is_some_and(moves)
}

/// A principal that moves an object.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Mover {
    /// The principal.
    pub principal: Principal,
    /// Its client, as it had identified itself when the instruction was sent; empty: it is no client.
    pub client: Arc<ClientIdentity>,
}

impl Mover {
    /// The mover in the layout of its CIP attribute.
    pub(crate) fn encoded(&self) -> motion::Mover {
        motion::Mover {
            kind: match self.principal {
                Principal::Server => MoverKind::SERVER,
                Principal::Io => MoverKind::IO,
                Principal::Controller => MoverKind::CONTROLLER,
                Principal::Client { .. } => MoverKind::CLIENT,
                Principal::Viewer(_) | Principal::Button(_) => MoverKind::VIEWER,
                Principal::Program { .. } => MoverKind::PROGRAM,
            },
            line: self.principal.line().unwrap_or(0),
            address: self.client.address.clone(),
            identification: self.client.identification.clone(),
        }
    }
}

impl fmt::Display for Mover {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.encoded().fmt(f)
    }
}

/// The mover of each object; `None`: nothing moves it.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct Movers {
    axes: Vec<Option<Mover>>,
    systems: Vec<Option<Mover>>,
}

impl Movers {
    /// The mover of an axis: of itself, or else of a coordinate system that has it.
    pub fn of_axis(&self, axis: AxisId) -> Option<&Mover> {
        self.axes.get(usize::from(axis))?.as_ref()
    }

    /// The mover of a coordinate system.
    pub fn of_system(&self, system: SystemId) -> Option<&Mover> {
        self.systems.get(usize::from(system))?.as_ref()
    }
}

/// The number of instructions of one object from which on those that have ended are dropped.
const FEW: usize = 8;
