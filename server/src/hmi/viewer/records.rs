//! Requests for the past: the trace, its history, events.

use super::Viewer;
use super::sending::Outgoing;
use crate::hmi::protocol::{Answer, Asks as _, Events, HistoryPiece, Refusal, Signals};
use crate::hmi::{events, frames};
use crate::trace::history;

impl Viewer {
    pub(super) fn trace(&self, on: bool) -> Result<Signals, Refusal> {
        self.send(Outgoing::Samples(on))?;
        let machine = self.shared.plant.machine();
        Ok(Signals {
            signals: history::signals(machine),
            period_s: machine.period(),
        })
    }

    pub(super) fn history(&self, before: u64) -> Result<HistoryPiece, Refusal> {
        let permit = self.pieces.clone().try_acquire_owned();
        let permit = permit.map_err(|_| Refusal::new("the page must read earlier frames of the history first"))?;
        let (frame, piece) = frames::history_before(&self.shared.plant, before);
        self.send(Outgoing::Piece(frame, permit))?;
        Ok(piece)
    }

    pub(super) async fn events(&self, request: Events) -> Result<Answer, Refusal> {
        self.computed(true, move |plant| {
            request.answer(Ok(events::since(plant, request.since)))
        })
        .await
    }
}
