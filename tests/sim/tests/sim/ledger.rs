//! The changes and attempts of clients, compared with the events of the audit (U1): each change and refusal has its event, and each event its cause.

use std::collections::BTreeMap;
use std::net::IpAddr;
use std::sync::{Arc, Mutex};

use arcline_server::stepped::Audited;

use crate::actors::tags::{PAIR, TAGS};
use crate::record::{Record, lock};

/// The ledger of a scenario. Clones are the same one.
#[derive(Clone, Default)]
pub(crate) struct Ledger(Arc<Mutex<BTreeMap<(String, Kind), Count>>>);

/// The kinds of events in the ledger.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub(crate) enum Kind {
    /// A write of a tag whose values are unique.
    Write(&'static str),
    /// An edge of `StepA.EnableIn`.
    Edge,
    /// An MCLM.
    Line,
    /// A refusal for the client's role.
    Denied,
}

#[derive(Clone, Copy, Default, Debug)]
struct Count {
    asked: u64,
    answered: u64,
    events: u64,
}

impl Ledger {
    /// A client sends a request.
    pub(crate) fn asks(&self, client: IpAddr, kind: Kind) {
        self.count(client.to_string(), kind, |count| count.asked += 1);
    }

    /// The answer says that it was done, or for [`Kind::Denied`] that it was refused.
    pub(crate) fn answered(&self, client: IpAddr, kind: Kind) {
        self.count(client.to_string(), kind, |count| count.answered += 1);
    }

    /// Takes an event of the audit.
    pub(crate) fn event(&self, event: &Audited, record: &Record) {
        let is_done = event.result == "done";
        let kind = match event.kind.as_str() {
            "denied" => Kind::Denied,
            // A write that does not reach the file has changed the tag.
            "write" if is_done || event.result == "not kept" => {
                let of = |name: &&&str| **name == event.object;
                match TAGS.iter().chain(&PAIR).find(of) {
                    Some(tag) => Kind::Write(tag),
                    None => return,
                }
            }
            "motion" if is_done && event.object == "StepA.EnableIn" && event.new == "1" => Kind::Edge,
            "motion" if is_done && event.object.starts_with("MCLM ") => Kind::Line,
            _ => return,
        };
        record.sometimes("a change has its event of the audit");
        let client = event.from.rsplit_once(':').map_or(event.from.as_str(), |(ip, _)| ip);
        self.count(client.to_owned(), kind, |count| count.events += 1);
    }

    /// The differences at the end of a scenario.
    pub(crate) fn check(&self) -> Vec<String> {
        let counts = lock(&self.0);
        let wrong = counts
            .iter()
            .filter(|(_, count)| !(count.answered..=count.asked).contains(&count.events));
        wrong
            .map(|((client, kind), count)| {
                format!(
                    "U1: {kind:?} of {client}: {} events of the audit, though {} were asked for and {} answered",
                    count.events, count.asked, count.answered
                )
            })
            .collect()
    }

    fn count(&self, client: String, kind: Kind, change: impl FnOnce(&mut Count)) {
        change(lock(&self.0).entry((client, kind)).or_default());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn events_are_at_least_those_answered_and_at_most_those_asked_for() {
        let event = Audited {
            kind: "write".to_owned(),
            from: "10.0.1.6:1025".to_owned(),
            object: "D0".to_owned(),
            new: "01".to_owned(),
            result: "done",
        };
        let client: IpAddr = "10.0.1.6".parse().expect("an address");
        #[rustfmt::skip]
        let cases = [
            ("a change with its event",       1, 1, 1, 0),
            ("a change without its event",    1, 1, 0, 1),
            ("an event without a cause",      0, 0, 1, 1),
            ("a change that nobody answered", 1, 0, 1, 0),
            ("a request that was lost",       1, 0, 0, 0),
        ];
        for (why, asked, answered, events, wrong) in cases {
            let ledger = Ledger::default();
            (0..asked).for_each(|_| ledger.asks(client, Kind::Write("D0")));
            (0..answered).for_each(|_| ledger.answered(client, Kind::Write("D0")));
            (0..events).for_each(|_| ledger.event(&event, &Record::default()));
            assert_eq!(ledger.check().len(), wrong, "{why}");
        }
    }
}
