//! The jogs that clients have begun, and which of them are to be stopped: a value without clock, thread and lock.
//!
//! Times are since any fixed moment.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Duration;

use arcline_controller::Ticket;
use arcline_instruction_set::{AxisId, JogEnd};

use crate::plant::{ClientIdentity, Principal};

/// The jogs of all clients, and the stops that are looked after until the axis stands.
#[derive(Debug, Default)]
pub(super) struct Table {
    clients: BTreeMap<u64, Jogs>,
    ending: Vec<Ending>,
}

/// The jogs of one client.
#[derive(Debug, Default)]
struct Jogs {
    identity: Arc<ClientIdentity>,
    jogs: Vec<Jog>,
}

/// A MAJ that was sent.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct Jog {
    pub(super) owner: Principal,
    pub(super) axis: AxisId,
    pub(super) ticket: Ticket,
    pub(super) since: Duration,
    /// The end of the jog unless its viewer confirms it; `None`: the jog needs no confirmation.
    pub(super) until: Option<Duration>,
}

/// A jog that is to be stopped.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(super) struct Ending {
    pub(super) axis: AxisId,
    pub(super) ticket: Ticket,
    pub(super) why: JogEnd,
    /// The time from which on its stop is one at full deceleration.
    from: Duration,
}

/// The observed state of a jog that is to be stopped.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum JogState {
    /// The axis stands, or another motion moves it.
    Over,
    /// The jog moves or brakes, or its state is unknown.
    Moves,
}

impl Table {
    /// A client has connected, or has sent its identification.
    pub(super) fn identify(&mut self, session: u64, change: impl FnOnce(&mut ClientIdentity)) {
        change(Arc::make_mut(&mut self.clients.entry(session).or_default().identity));
    }

    /// The identity of a client.
    pub(super) fn identity_of(&self, session: u64) -> Arc<ClientIdentity> {
        let client = self.clients.get(&session);
        client.map(|client| client.identity.clone()).unwrap_or_default()
    }

    /// A client has gone; its jogs must have been ended before.
    pub(super) fn leave(&mut self, session: u64) {
        self.clients.remove(&session);
    }

    /// A client has sent a MAJ. `runs`: whether a ticket may still run; the table forgets the others when it has many.
    pub(super) fn begin(&mut self, session: u64, jog: Jog, runs: impl Fn(Ticket) -> bool) {
        let jogs = &mut self.clients.entry(session).or_default().jogs;
        if jogs.len() >= MANY {
            jogs.retain(|jog| runs(jog.ticket));
        }
        jogs.push(jog);
    }

    /// Extends a jog that its client has confirmed. `false`: there is no such jog, or it has ended.
    pub(super) fn keep(&mut self, session: u64, axis: AxisId, now: Duration, until: Duration) -> bool {
        let Some(client) = self.clients.get_mut(&session) else {
            return false;
        };
        let kept = client.jogs.iter_mut().filter(|jog| jog.axis == axis);
        let mut any = false;
        for until_now in kept.filter_map(|jog| jog.until.as_mut()).filter(|until| **until > now) {
            *until_now = until;
            any = true;
        }
        any
    }

    /// The clients with a jog that needs confirmation, with its axis.
    pub(super) fn held(&self) -> Vec<(u64, AxisId)> {
        let jogs = self.clients.values().flat_map(|client| &client.jogs);
        let held = jogs.filter(|jog| jog.until.is_some());
        held.filter_map(|jog| Some((jog.owner.session()?, jog.axis))).collect()
    }

    /// Takes out jogs that are to be stopped, at full deceleration from `from` on.
    pub(super) fn end(&mut self, from: Duration, why: JogEnd, which: impl Fn(&Jog) -> bool) -> Vec<Jog> {
        let mut ended = Vec::new();
        for client in self.clients.values_mut() {
            client.jogs.retain(|jog| {
                let ends = which(jog);
                if ends {
                    ended.push(*jog);
                }
                !ends
            });
        }
        self.ending.extend(ended.iter().map(|jog| Ending {
            axis: jog.axis,
            ticket: jog.ticket,
            why,
            from,
        }));
        ended
    }

    /// Takes out the jogs whose confirmation is overdue.
    pub(super) fn overdue(&mut self, now: Duration) -> Vec<Jog> {
        self.end(now, JogEnd::Released, |jog| jog.until.is_some_and(|until| until <= now))
    }

    /// The jogs of an owner that closes in order: they go on without an owner.
    pub(super) fn forget(&mut self, owner: Principal) {
        let client = owner.session().and_then(|session| self.clients.get_mut(&session));
        if let Some(client) = client {
            client.jogs.retain(|jog| jog.owner != owner);
        }
    }

    /// Clients with jogs that may run.
    pub(super) fn jogging(&self) -> impl Iterator<Item = u64> {
        let jogging = self.clients.iter().filter(|(_, client)| !client.jogs.is_empty());
        jogging.map(|(session, _)| *session)
    }

    /// Leaves out jogs of which it is known that they are over.
    pub(super) fn prune(&mut self, runs: impl Fn(AxisId, Ticket) -> bool) {
        for client in self.clients.values_mut() {
            client.jogs.retain(|jog| runs(jog.axis, jog.ticket));
        }
    }

    /// The stops that are not over, and from now on at full deceleration.
    pub(super) fn due_endings(&mut self, now: Duration, state_of: impl Fn(&Ending) -> JogState) -> Vec<Ending> {
        self.ending.retain(|ending| state_of(ending) == JogState::Moves);
        let due = self.ending.iter().filter(|ending| ending.from <= now);
        due.cloned().collect()
    }

    /// Whether there is no jog to watch.
    pub(super) fn is_idle(&self) -> bool {
        self.ending.is_empty() && self.jogging().next().is_none()
    }
}

/// Jogs of one client before those that are over are left out.
const MANY: usize = 64;

#[cfg(test)]
mod tests {
    use super::*;

    const ONE: Principal = Principal::Client {
        session: 1,
        connection: 0,
    };
    const TWO: Principal = Principal::Client {
        session: 2,
        connection: 7,
    };

    fn ms(time: u64) -> Duration {
        Duration::from_millis(time)
    }

    fn jog(owner: Principal, axis: u16, ticket: u64, until: Option<Duration>) -> Jog {
        Jog {
            owner,
            axis: AxisId(axis),
            ticket: Ticket(ticket),
            since: Duration::ZERO,
            until,
        }
    }

    fn tickets(jogs: &[Jog]) -> Vec<u64> {
        jogs.iter().map(|jog| jog.ticket.0).collect()
    }

    #[test]
    fn a_jog_ends_when_it_is_not_kept() {
        let mut table = Table::default();
        table.begin(1, jog(ONE, 0, 5, Some(ms(150))), |_| true);
        table.begin(2, jog(TWO, 1, 6, None), |_| true);
        assert!(table.keep(1, AxisId(0), ms(100), ms(250)));
        assert!(!table.keep(1, AxisId(1), ms(100), ms(250)), "another axis");
        assert!(!table.keep(2, AxisId(1), ms(100), ms(250)), "it need not be kept");
        assert_eq!(table.held(), [(1, AxisId(0))]);
        assert!(table.overdue(ms(249)).is_empty());
        assert_eq!(tickets(&table.overdue(ms(250))), [5]);
        assert!(!table.keep(1, AxisId(0), ms(251), ms(400)), "it is over");
        assert_eq!(table.jogging().collect::<Vec<_>>(), [2]);
    }

    #[test]
    fn a_stop_is_looked_after_until_the_axis_stands() {
        let mut table = Table::default();
        table.begin(1, jog(ONE, 0, 5, None), |_| true);
        table.begin(1, jog(ONE, 0, 9, None), |_| true);
        table.begin(2, jog(TWO, 1, 6, None), |_| true);
        assert_eq!(
            tickets(&table.end(ms(10), JogEnd::Lost, |jog| jog.owner == ONE)),
            [5, 9]
        );
        assert!(
            table.due_endings(ms(9), |_| JogState::Moves).is_empty(),
            "not at full deceleration yet"
        );
        let again = table.due_endings(ms(20), |ending| match ending.ticket {
            Ticket(9) => JogState::Over,
            _ => JogState::Moves,
        });
        assert_eq!(again.iter().map(|ending| ending.ticket.0).collect::<Vec<_>>(), [5]);
        assert_eq!(table.due_endings(ms(9999), |_| JogState::Moves).len(), 1, "and again");
        assert!(table.due_endings(ms(9999), |_| JogState::Over).is_empty());
        assert!(!table.is_idle(), "the other jogs");
        table.forget(TWO);
        assert!(table.is_idle());
    }

    #[test]
    fn many_jogs_of_one_client_are_bounded_by_those_that_run() {
        let mut table = Table::default();
        for ticket in 1..=100_000 {
            table.begin(1, jog(ONE, 0, ticket, None), |ticket| ticket.0 == 3);
        }
        let jogs = table.end(ms(0), JogEnd::Lost, |_| true);
        assert!(jogs.len() <= MANY + 1, "{}", jogs.len());
        assert!(jogs.iter().any(|jog| jog.ticket == Ticket(3)), "the one that runs");
    }
}
