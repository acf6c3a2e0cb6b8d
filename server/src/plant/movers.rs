//! The principal that moves each axis and each coordinate system, by the newest instruction that began motion there and still runs.

use std::collections::{BTreeMap, VecDeque};
use std::fmt;
use std::sync::Arc;

use arcline_controller::Ticket;
use arcline_controller::machine::Machine;
use arcline_instruction_set::{AxisId, Call, SystemId};

use super::control::MotionObject;
use super::policy::stop_of;
use super::principal::Principal;
use super::records::Executions;
use super::state::may_run;
use super::{Plant, records::Origin};

/// The newest instructions that began motion of each object, newest first.
#[derive(Debug, Default)]
pub(super) struct MotionTickets(BTreeMap<MotionObject, VecDeque<Ticket>>);

impl MotionTickets {
    /// Notes a call that may begin motion.
    pub(super) fn note(&mut self, ticket: Ticket, call: &Call) {
        let (Some(target), Some(_)) = (call.target, stop_of(call.mnemonic)) else {
            return;
        };
        let object = MotionObject::of(call.mnemonic.instruction().object, target);
        let tickets = self.0.entry(object).or_default();
        tickets.truncate(NEWEST - 1);
        tickets.push_front(ticket);
    }

    /// The origin of the newest one that runs.
    fn running<'r>(&self, object: MotionObject, records: &'r Executions) -> Option<&'r Origin> {
        let mut tickets = self.0.get(&object)?.iter();
        let running = tickets.find(|ticket| records.get(**ticket).is_some_and(may_run))?;
        records.origin(*running)
    }
}

/// A principal that moves an object.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(crate) struct Mover {
    pub(crate) principal: Principal,
    /// The name of its client as it was when it began; empty: it is no client.
    name: Arc<str>,
}

impl fmt::Display for Mover {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (self.principal, self.principal.line()) {
            (Principal::Io, _) => f.write_str("the outputs of implicit I/O"),
            (Principal::Server, _) => f.write_str("the server"),
            (_, Some(line)) => write!(f, "the program of {}, line {line}", self.name),
            (_, None) => f.write_str(&self.name),
        }
    }
}

/// The mover of each object; `None`: nothing moves it.
#[derive(Clone, Debug)]
pub(crate) struct Movers {
    /// Of each axis: of itself, or of the coordinate system that moves it.
    pub(crate) axes: Vec<Option<Mover>>,
    /// Of each coordinate system.
    pub(crate) systems: Vec<Option<Mover>>,
}

impl Plant {
    /// The mover of every axis and coordinate system.
    pub(crate) fn movers(&self) -> Movers {
        let mut state = self.0.lock();
        state.refresh();
        let mover = |object| {
            let origin = state.motion_tickets.running(object, &state.records)?;
            Some(Mover {
                principal: origin.principal,
                name: origin.name.clone(),
            })
        };
        of_machine(self.machine(), mover)
    }
}

fn of_machine(machine: &Machine, mover: impl Fn(MotionObject) -> Option<Mover>) -> Movers {
    let systems: Vec<Option<Mover>> = SystemId::first(machine.systems.len())
        .map(|system| mover(MotionObject::System(system)))
        .collect();
    let axes = (0..machine.axes.len()).map(|index| {
        let axis = AxisId::from_index(index);
        let of_system = || {
            let mut all = machine.systems.iter().zip(&systems);
            let (_, mover) = all.find(|(system, mover)| mover.is_some() && system.axes.contains(&axis))?;
            mover.clone()
        };
        mover(MotionObject::Axis(axis)).or_else(of_system)
    });
    Movers {
        axes: axes.collect(),
        systems,
    }
}

/// Instructions of one object that are remembered: the newest ones may have ended with an error.
const NEWEST: usize = 8;
