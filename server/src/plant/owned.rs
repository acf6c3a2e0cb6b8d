//! Motion that a connection began, and the reaction when that connection is lost (docs/CONFIGURATION.md, `connection_loss`).
//!
//! Sessions find that a connection is lost, not this module; the outputs of implicit I/O have a reaction of their own. An
//! instruction that has ended has no owner.

use std::collections::BTreeMap;

use arcline_config::ConnectionLoss;
use arcline_controller::machine::Machine;
use arcline_controller::{Snapshot, Ticket, UNNAMED};
use arcline_instruction_set::predefined::{coordinate_motion_status, motion_status};
use arcline_instruction_set::{AxisId, Call, JogEnd, Mnemonic, SystemId, UnboundOperand, bind};

use super::policy::{COORDINATED_MOVE, stop_of};
use super::principal::Principal;
use super::records::Executions;
use super::state::State;

/// An instruction that began motion.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
struct Begun {
    ticket: Ticket,
    mnemonic: Mnemonic,
    target: u16,
}

/// The instructions of each owner, oldest first.
#[derive(Debug, Default)]
pub(super) struct OwnedInstructions(BTreeMap<Principal, Vec<Begun>>);

impl OwnedInstructions {
    /// Notes a call that may begin motion.
    pub(super) fn begin(&mut self, owner: Principal, ticket: Ticket, call: &Call, records: &Executions) {
        let (Some(target), Some(_)) = (call.target, stop_of(call.mnemonic)) else {
            return;
        };
        let begun = self.0.entry(owner).or_default();
        if begun.len() >= MANY {
            // As many as run at a time stay: a queue is bounded.
            begun.retain(|begun| records.may_run(begun.ticket));
        }
        begun.push(Begun {
            ticket,
            mnemonic: call.mnemonic,
            target,
        });
    }

    /// The instructions of an owner have no owner any more.
    pub(super) fn forget(&mut self, owner: Principal) {
        self.0.remove(&owner);
    }

    /// The owners of a session.
    pub(super) fn of_session(&self, session: u64) -> Vec<Principal> {
        let owner = |connection| Principal::Client { session, connection };
        let all = owner(0)..=owner(u32::MAX);
        self.0.range(all).map(|(owner, _)| *owner).collect()
    }
}

/// The axes and coordinate systems of a lost owner that were stopped or held.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct LossOutcome {
    /// Axes, by their place.
    pub axes: Vec<AxisId>,
    /// Coordinate systems, by their place.
    pub systems: Vec<SystemId>,
}

impl LossOutcome {
    /// Whether no axis and no coordinate system was stopped or held.
    pub fn is_empty(&self) -> bool {
        self.axes.is_empty() && self.systems.is_empty()
    }

    /// The names of all, for people.
    pub fn names(&self, machine: &Machine) -> String {
        let axes = self
            .axes
            .iter()
            .filter_map(|place| machine.axes.get(usize::from(*place)));
        let systems = self
            .systems
            .iter()
            .filter_map(|place| machine.systems.get(usize::from(*place)));
        let names = axes.map(|axis| &axis.name).chain(systems.map(|system| &system.name));
        names.map(String::as_str).collect::<Vec<_>>().join(", ")
    }
}

impl State {
    /// An owner is lost: its instructions that still run are stopped, held or go on. The guard ends jogs.
    pub(super) fn lose(&mut self, owner: Principal, reaction: ConnectionLoss) -> LossOutcome {
        let mut begun = self.owned.0.remove(&owner).unwrap_or_default();
        let snapshot = self.link.snapshots.output_buffer();
        begun.retain(|begun| self.records.may_run(begun.ticket) || is_braking(*begun, snapshot));
        if reaction == ConnectionLoss::Finish {
            self.guard.forget(owner);
            return LossOutcome::default();
        }
        let (mut stops, mut held) = (Vec::new(), Vec::new());
        // A jog has no end of its own: it never goes on without its owner.
        let mut lost = LossOutcome {
            axes: self.guard.end(owner),
            systems: Vec::new(),
        };
        for Begun {
            mnemonic,
            target,
            ticket,
        } in begun
        {
            let Some(stop) = stop_of(mnemonic).filter(|_| mnemonic != Mnemonic::Maj) else {
                continue;
            };
            if reaction == ConnectionLoss::Stop && !stops.iter().any(|(known, at, _)| (*known, *at) == (stop, target)) {
                stops.push((stop, target, ticket));
            }
            if reaction == ConnectionLoss::Hold && stop == COORDINATED_MOVE && !held.contains(&SystemId(target)) {
                held.push(SystemId(target));
            }
        }
        for ((mnemonic, what), target, ticket) in stops {
            self.stop_lost(mnemonic, what, target, ticket);
            if mnemonic == Mnemonic::Mcs {
                lost.systems.push(SystemId(target));
            } else {
                lost.axes.push(AxisId(target));
            }
        }
        for system in &held {
            if let Err(error) = self.image_mut().set_feed_override(*system, 0.0) {
                tracing::error!(%error, "motion of a lost connection could not be held: the server stops all motion");
                self.link.stops.stop_all();
            }
        }
        if !held.is_empty() {
            self.send_overrides();
            lost.systems.extend(held);
        }
        lost
    }

    /// The instructions of an owner go on without it.
    pub(super) fn disown(&mut self, owner: Principal) {
        self.guard.forget(owner);
        self.owned.forget(owner);
    }

    /// Stops motion of a lost owner at the full deceleration of its axis or coordinate system; where that cannot be sent, everything
    /// is stopped.
    fn stop_lost(&mut self, mnemonic: Mnemonic, what: &str, target: u16, ticket: Ticket) {
        let given = [UnboundOperand::Word(what.to_owned())];
        match bind(mnemonic, Some(target), UNNAMED, &given, self.image()) {
            // Its answer is not waited for.
            Ok(call) if self.has_room(mnemonic) => drop(self.send(Principal::Server, None, call, None)),
            Ok(_) => {
                tracing::error!("too many instructions wait for the controller: everything is stopped");
                self.link.stops.stop_all();
            }
            Err(error) => {
                tracing::error!(%error, "motion of a lost connection could not be stopped alone: the server stops all motion");
                self.link.stops.stop_all();
            }
        }
        if mnemonic == Mnemonic::Mas {
            // A weaker stop of the whole axis may be under way.
            self.link.stops.end_jog(AxisId(target), ticket, JogEnd::Lost);
        }
    }
}

/// Whether the object of an instruction is being stopped: the stop may be a weak one, and it ended the instruction.
fn is_braking(begun: Begun, snapshot: &Snapshot) -> bool {
    let place = usize::from(begun.target);
    match stop_of(begun.mnemonic) {
        Some((Mnemonic::Mas, _)) => {
            let axis = snapshot.axes.get(place);
            axis.is_some_and(|axis| axis.motion_status & motion_status::STOPPING_STATUS != 0)
        }
        Some(_) => {
            let system = snapshot.systems.get(place);
            system.is_some_and(|system| system.motion_status & coordinate_motion_status::STOPPING_STATUS != 0)
        }
        None => false,
    }
}

/// Executions of one owner before those that have ended are left out.
const MANY: usize = 64;
