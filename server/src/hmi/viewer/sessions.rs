//! Requests about sessions: an administrator sees them, and ends one.

use tokio::time::Instant;

use super::Viewer;
use crate::audit::EventKind;
use crate::hmi::protocol::{Done, EndSession, Refusal, SessionList};
use crate::hmi::sessions::{End, State};
use crate::plant::Principal;

impl Viewer {
    /// The reason for the end of its session; `None`: it has none, or it has not ended.
    pub(super) fn ended(&self) -> Option<End> {
        match *self.session.as_ref()?.state.borrow() {
            State::Ended(why) => Some(why),
            State::Open(_) | State::Locked => None,
        }
    }

    pub(super) fn sessions(&self) -> SessionList {
        let own = self.session.as_ref().map(|session| &session.key);
        SessionList {
            sessions: self.shared.sessions.list(own, Instant::now()),
        }
    }

    pub(super) fn end_session(&self, request: &EndSession) -> Result<Done, Refusal> {
        let plant = &self.shared.plant;
        let number = request.session;
        let ended = self.shared.sessions.end_numbered(plant, number);
        let (object, result) = match &ended {
            Some(from) => (format!("session {number}, {from}"), "done"),
            None => (format!("session {number}"), "refused"),
        };
        plant.record(Principal::Viewer(self.id), EventKind::EndSession, object, result);
        match ended {
            Some(_) => Ok(Done {}),
            None => Err(Refusal::new(format!("there is no session {number}: it may have ended"))),
        }
    }
}
