//! One session: its user or script, its state, and its viewers.

use std::collections::{BTreeMap, BTreeSet};

use arcline_config::Role;
use tokio::sync::watch;
use tokio::time::Instant;

use crate::audit::EventKind;
use crate::guard::VIEWERS;
use crate::plant::Plant;
use crate::plant::control::ViewerId;

/// The state of a session, as its viewer sees it.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(in crate::hmi) enum State {
    /// The session has this role.
    Open(Role),
    /// The page was idle for long, or a person locked it.
    Locked,
    /// The session has ended.
    Ended,
}

/// The user or script that began a session.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(super) enum Subject {
    User(String),
    Token(String),
}

impl Subject {
    /// As logs and the audit name it.
    pub(super) fn name(&self) -> String {
        match self {
            Self::User(name) => format!("user:{name}"),
            Self::Token(name) => format!("token:{name}"),
        }
    }
}

/// A session.
#[derive(Debug)]
pub(super) struct Session {
    pub(super) subject: Subject,
    pub(super) role: Role,
    /// The hash that was checked; with another one in the file the session ends.
    pub(super) credential: String,
    /// The address and its secret's first use.
    pub(super) from: String,
    pub(super) began: Instant,
    pub(super) active: Instant,
    pub(super) state: watch::Sender<State>,
    /// Its viewers, with the role of the address of each.
    pub(super) viewers: BTreeMap<ViewerId, Role>,
}

impl Session {
    fn is_locked(&self) -> bool {
        *self.state.borrow() == State::Locked
    }

    /// Gives its viewers their role.
    pub(super) fn apply(&self, plant: &Plant) {
        let is_locked = self.is_locked();
        for (viewer, address) in &self.viewers {
            plant.roles().set(VIEWERS | viewer, (*address).max(self.role));
            plant.roles().set_locked(VIEWERS | viewer, is_locked);
        }
        if !is_locked {
            let open = State::Open(self.role);
            self.state
                .send_if_modified(|state| std::mem::replace(state, open) != open);
        }
    }

    pub(super) fn lock(&mut self, plant: &Plant) {
        if self.is_locked() {
            return;
        }
        self.state.send_replace(State::Locked);
        self.apply(plant);
        let viewers: BTreeSet<ViewerId> = self.viewers.keys().copied().collect();
        for viewer in viewers {
            // A locked page holds no jog button.
            plant.guard().lose(VIEWERS | viewer);
        }
        plant.record_session(self.from.clone(), self.role, EventKind::Locked, String::new(), "done");
    }

    pub(super) fn end(self, plant: &Plant, kind: EventKind, result: &'static str) {
        for viewer in self.viewers.keys() {
            // Its connection is closed at once, too.
            plant.roles().set(VIEWERS | viewer, Role::Viewer);
        }
        plant.record_session(self.from, self.role, kind, String::new(), result);
        self.state.send_replace(State::Ended);
    }
}
