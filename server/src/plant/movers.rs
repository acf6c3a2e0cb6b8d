//! The principal that moves each axis and each coordinate system, by the newest instruction that began motion there and still runs.

use std::collections::{BTreeMap, VecDeque};
use std::fmt;
use std::sync::Arc;

use arcline_controller::Ticket;
use arcline_controller::machine::Machine;
use arcline_instruction_set::{AxisId, Call, SystemId};
use arcline_proto::arcline::motion::{self, MoverKind};

use super::client::ClientIdentity;
use super::control::MotionObject;
use super::policy::stop_of;
use super::principal::Principal;
use super::records::{Executions, Origin};
use super::state::may_run;

/// The instructions by which objects move, and the movers that follow from them.
#[derive(Debug)]
pub(super) struct MotionTickets {
    /// The newest instructions that began motion of each object, newest first.
    newest: BTreeMap<MotionObject, VecDeque<Ticket>>,
    /// The axes of each coordinate system.
    systems: Vec<Vec<AxisId>>,
    movers: Arc<Movers>,
    /// Whether an execution has changed since the last search for the movers.
    is_stale: bool,
}

impl MotionTickets {
    /// The movers of a machine at rest.
    pub(super) fn new(machine: &Machine) -> Self {
        MotionTickets {
            newest: BTreeMap::new(),
            systems: machine.systems.iter().map(|system| system.axes.clone()).collect(),
            movers: Arc::new(Movers {
                axes: vec![None; machine.axes.len()],
                systems: vec![None; machine.systems.len()],
            }),
            is_stale: false,
        }
    }

    /// An execution has changed.
    pub(super) fn executions_changed(&mut self) {
        self.is_stale = true;
    }

    /// The movers as the executions are now.
    pub(super) fn movers(&mut self, records: &Executions) -> Arc<Movers> {
        if std::mem::take(&mut self.is_stale) {
            let movers = Movers {
                axes: AxisId::first(self.movers.axes.len())
                    .map(|axis| self.mover_of_axis(records, axis))
                    .collect(),
                systems: SystemId::first(self.systems.len())
                    .map(|system| self.mover(records, MotionObject::System(system)))
                    .collect(),
            };
            self.movers = Arc::new(movers);
        }
        self.movers.clone()
    }

    /// The mover of an axis: of itself, or else of a coordinate system that has it.
    pub(super) fn mover_of_axis(&self, records: &Executions, axis: AxisId) -> Option<Mover> {
        let systems = SystemId::first(self.systems.len()).zip(&self.systems);
        let mut its_own = systems.filter(|(_, axes)| axes.contains(&axis));
        self.mover(records, MotionObject::Axis(axis))
            .or_else(|| its_own.find_map(|(system, _)| self.mover(records, MotionObject::System(system))))
    }

    fn mover(&self, records: &Executions, object: MotionObject) -> Option<Mover> {
        let origin = self.running(object, records)?;
        Some(Mover {
            principal: origin.principal,
            client: origin.client.clone(),
        })
    }

    /// Notes a call that may begin motion.
    pub(super) fn note(&mut self, ticket: Ticket, call: &Call) {
        let (Some(target), Some(_)) = (call.target, stop_of(call.mnemonic)) else {
            return;
        };
        let object = MotionObject::of(call.mnemonic.instruction().object, target);
        let tickets = self.newest.entry(object).or_default();
        tickets.truncate(NEWEST - 1);
        tickets.push_front(ticket);
        self.is_stale = true;
    }

    /// The origin of the newest one that runs.
    fn running<'r>(&self, object: MotionObject, records: &'r Executions) -> Option<&'r Origin> {
        let mut tickets = self.newest.get(&object)?.iter();
        let running = tickets.find(|ticket| records.get(**ticket).is_some_and(may_run))?;
        records.origin(*running)
    }
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

/// Instructions of one object that are remembered: the newest ones may have ended with an error.
const NEWEST: usize = 8;
