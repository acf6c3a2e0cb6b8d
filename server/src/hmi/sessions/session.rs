//! One session: its user or script, its state, and its viewers.

use std::collections::{BTreeMap, BTreeSet};
use std::net::IpAddr;

use arcline_config::Role;
use tokio::time::Instant;

use crate::audit::EventKind;
use crate::guard::VIEWERS;
use crate::plant::Plant;
use crate::plant::control::ViewerId;
use crate::watch;

/// The state of a session, as its viewer sees it.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(in crate::hmi) enum State {
    /// The session has this role.
    Open(Role),
    /// The page was idle for long, or a person locked it.
    Locked,
    /// The session has ended.
    Ended(End),
}

/// The reason for the end of a session.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(in crate::hmi) enum End {
    /// A person logged out.
    LoggedOut,
    /// A person logged in again on the same page.
    Replaced,
    /// The user or the token no longer holds.
    Revoked,
    /// The longest time of a session is over.
    Expired,
    /// A newer session needed its room.
    TooMany,
    /// An administrator ended it.
    ByAdministrator,
}

impl End {
    /// As the audit names it.
    pub(super) const fn result(self) -> &'static str {
        match self {
            Self::LoggedOut => "done",
            Self::Replaced => "replaced",
            Self::Revoked => "revoked",
            Self::Expired => "expired",
            Self::TooMany => "too many sessions",
            Self::ByAdministrator => "ended by an administrator",
        }
    }

    /// The sentence for its user, at most 123 bytes: the close of a WebSocket has no more.
    pub(in crate::hmi) const fn text(self) -> &'static str {
        match self {
            Self::LoggedOut => "the session has ended: its user logged out",
            Self::Replaced => "the session has ended: its user logged in again",
            Self::Revoked => "the session has ended: its user or token is no longer valid",
            Self::Expired => "the session has ended: its longest time is over",
            Self::TooMany => "the session has ended: its user, or all users together, began too many",
            Self::ByAdministrator => "the session has ended: an administrator ended it",
        }
    }
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
pub(super) struct PageSession {
    /// Its number since the start of the server, which is no secret.
    pub(super) number: u64,
    pub(super) subject: Subject,
    pub(super) role: Role,
    /// The credential that was checked; with another one in the file the session ends.
    pub(super) credential: String,
    /// The address from which it began.
    pub(super) peer: IpAddr,
    /// The address and its secret's first use.
    pub(super) from: String,
    pub(super) began: Instant,
    pub(super) active: Instant,
    pub(super) state: watch::Sender<State>,
    /// Its viewers, with the role of the address of each.
    pub(super) viewers: BTreeMap<ViewerId, Role>,
}

impl PageSession {
    pub(super) fn is_locked(&self) -> bool {
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

    pub(super) fn end(self, plant: &Plant, why: End) {
        for viewer in self.viewers.keys() {
            // Its connection is closed at once, too.
            plant.roles().set(VIEWERS | viewer, Role::Viewer);
        }
        plant.record_session(self.from, self.role, EventKind::Logout, String::new(), why.result());
        self.state.send_replace(State::Ended(why));
    }
}
