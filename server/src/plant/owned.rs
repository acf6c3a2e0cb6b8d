//! Motion that a connection began, and what becomes of it when the connection is lost (docs/CONFIGURATION.md,
//! `connection_loss`).
//!
//! Not when a connection is lost, which its session knows; nor the outputs of implicit I/O, whose owner commands everything
//! that moves. What has ended is nobody's.

use std::collections::BTreeMap;

use arcline_config::ConnectionLoss;
use arcline_controller::{Ticket, UNNAMED};
use arcline_instruction_set::{Call, Flag, Given, Mnemonic, bind};

use super::records::Records;
use super::state::State;

/// Who begins motion: a class 3 connection, or a session without one.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub struct Owner {
    /// The session's number; never used again.
    pub session: u64,
    /// The O→T id of the connection; 0: none.
    pub connection: u32,
}

/// An instruction that began something.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
struct Begun {
    ticket: Ticket,
    mnemonic: Mnemonic,
    target: u16,
}

/// What owners have begun, oldest first.
#[derive(Debug, Default)]
pub(super) struct Owned(BTreeMap<Owner, Vec<Begun>>);

impl Owned {
    /// Notes a call that may begin motion.
    pub(super) fn begin(&mut self, owner: Owner, ticket: Ticket, call: &Call, records: &Records) {
        let (Some(target), Some(_)) = (call.target, stop_of(call.mnemonic)) else {
            return;
        };
        let begun = self.0.entry(owner).or_default();
        if begun.len() >= MANY {
            // As many as run at a time stay: a queue is bounded.
            begun.retain(|begun| is_running(*begun, records));
        }
        begun.push(Begun {
            ticket,
            mnemonic: call.mnemonic,
            target,
        });
    }

    /// Whatever an owner has begun is nobody's any more.
    pub(super) fn forget(&mut self, owner: Owner) {
        self.0.remove(&owner);
    }

    /// The owners of a session.
    pub(super) fn of_session(&self, session: u64) -> Vec<Owner> {
        let all = Owner { session, connection: 0 }..=Owner {
            session,
            connection: u32::MAX,
        };
        self.0.range(all).map(|(owner, _)| *owner).collect()
    }
}

impl State {
    /// An owner is lost: does with what it began, and what still runs of that, as the reaction says. Whether something was
    /// stopped or held.
    pub(super) fn lose(&mut self, owner: Owner, reaction: ConnectionLoss) -> bool {
        let mut begun = self.owned.0.remove(&owner).unwrap_or_default();
        begun.retain(|begun| is_running(*begun, &self.records));
        let (mut stops, mut held) = (Vec::new(), Vec::new());
        for Begun { mnemonic, target, .. } in begun {
            let Some(stop) = stop_of(mnemonic) else { continue };
            let stopped = match reaction {
                ConnectionLoss::Finish => false,
                ConnectionLoss::Stop => true,
                // What has no end of its own does not go on alone.
                ConnectionLoss::Jogs | ConnectionLoss::Hold => mnemonic == Mnemonic::Maj,
            };
            if stopped && !stops.contains(&(stop, target)) {
                stops.push((stop, target));
            }
            if reaction == ConnectionLoss::Hold && stop == COORDINATED_MOVE && !held.contains(&target) {
                held.push(target);
            }
        }
        let any = !stops.is_empty() || !held.is_empty();
        for ((mnemonic, what), target) in stops {
            let given = [Given::Word(what.to_owned())];
            match bind(mnemonic, Some(target), UNNAMED, &given, self.image()) {
                // Nobody waits for it.
                Ok(call) => drop(self.send(call)),
                Err(error) => tracing::error!(%error, "motion of a lost connection was not stopped"),
            }
        }
        if !held.is_empty() {
            for system in held {
                if let Err(error) = self.image_mut().set_feed_override(system, 0.0) {
                    tracing::error!(%error, "motion of a lost connection was not held");
                }
            }
            self.send_overrides();
        }
        any
    }
}

/// Of an execution that is not kept any more nothing tells that it has ended.
fn is_running(begun: Begun, records: &Records) -> bool {
    records.get(begun.ticket).is_none_or(|control| control.has(Flag::Ip))
}

/// What stops the motion that an instruction begins: an instruction and its Stop Type. `None`: it begins none.
fn stop_of(mnemonic: Mnemonic) -> Option<(Mnemonic, &'static str)> {
    Some(match mnemonic {
        Mnemonic::Maj => (Mnemonic::Mas, "Jog"),
        Mnemonic::Mam => (Mnemonic::Mas, "Move"),
        Mnemonic::Mag => (Mnemonic::Mas, "Gear"),
        Mnemonic::Mah => (Mnemonic::Mas, "Home"),
        Mnemonic::Mapc => (Mnemonic::Mas, "Position Cam"),
        Mnemonic::Matc => (Mnemonic::Mas, "Time Cam"),
        Mnemonic::Mclm | Mnemonic::Mccm | Mnemonic::Mcpm => COORDINATED_MOVE,
        Mnemonic::Mct | Mnemonic::Mcto => (Mnemonic::Mcs, "Coordinated Transform"),
        _ => return None,
    })
}

/// What stops coordinated moves; they alone can be held.
const COORDINATED_MOVE: (Mnemonic, &str) = (Mnemonic::Mcs, "Coordinated Move");

/// Executions of one owner before those that have ended are left out.
const MANY: usize = 64;
