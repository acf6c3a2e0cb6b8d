//! Requests about the program of the controller: its routines and rungs, its mode, forced tags.

use super::Viewer;
use super::sending::Outgoing;
use crate::hmi::controller;
use crate::hmi::protocol::{self, Answer, Asks as _, Done, Force, Look, Refusal, Routines, Rungs, Uses};
use crate::plant::{Command, Mode, Principal};

impl Viewer {
    pub(super) async fn routines(&self, request: Routines) -> Result<Answer, Refusal> {
        self.computed(true, move |plant| request.answer(controller::routines(plant)))
            .await
    }

    pub(super) async fn rungs(&self, request: Rungs) -> Result<Answer, Refusal> {
        self.computed(true, move |plant| {
            request.answer(controller::rungs(plant, request.routine, request.from, request.count))
        })
        .await
    }

    pub(super) async fn look(&self, request: Look) -> Result<Answer, Refusal> {
        let (outbox, viewer) = (self.outbox.clone(), self.id);
        self.computed(true, move |plant| {
            let updates = controller::monitor(plant, viewer, &request);
            let sent = updates.and_then(|updates| {
                let full = |_| Refusal::new("the page does not read the messages of the server");
                outbox.try_send(Outgoing::Monitor(updates)).map_err(full)
            });
            request.answer(sent.map(|()| Done {}))
        })
        .await
    }

    pub(super) async fn uses(&self, request: Uses) -> Result<Answer, Refusal> {
        self.computed(true, move |plant| {
            request.answer(controller::uses(plant, &request.tag, request.program.as_deref()))
        })
        .await
    }

    pub(super) async fn set_mode(&self, request: &protocol::Mode) -> Result<Done, Refusal> {
        let mode = if request.run { Mode::Run } else { Mode::Program };
        self.apply(Command::SetMode(mode)).await
    }

    pub(super) async fn force(&self, request: &Force) -> Result<Done, Refusal> {
        let by = Principal::Viewer(self.id);
        controller::force(&self.shared.plant, by, &request.tag, &request.value).await?;
        Ok(Done {})
    }
}
