//! The reading half of a viewer, on the thread of stops. It answers `stop`, `keep` and `jog_end` at once, before earlier requests of the
//! viewer, and puts all others into the queue, or refuses them when too many wait already. Nothing here computes for long or waits.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use bytes::Bytes;
use futures_util::StreamExt as _;
use serde::Deserialize;
use serde_json::Value;
use tokio::sync::{OwnedSemaphorePermit, Semaphore, mpsc};
use tokio::time::Instant;
use tokio_tungstenite::WebSocketStream;
use tokio_tungstenite::tungstenite::protocol::{Role, WebSocketConfig};
use tokio_tungstenite::tungstenite::{Message, Utf8Bytes};
use tracing::debug;

use super::super::protocol::{self, Answer, Asks as _, Done, JogEnd, Keep, Refusal, Stop};
use super::super::serve::LONGEST_MESSAGE;
use super::super::socket::{Reading, Unread};
use super::{Outgoing, SHORT, Shared};
use crate::guard::{Signs, VIEWERS};
use crate::plant::control::ViewerId;

/// Messages of one viewer that are taken within [`PAUSE`]: a viewer that says more waits, not the others.
const TURN: u32 = 16;
const PAUSE: Duration = Duration::from_millis(1);

/// A request of a viewer that waits for its turn.
#[derive(Debug)]
pub(super) struct Heard {
    /// The message.
    pub(super) text: Utf8Bytes,
    /// The number of presses of STOP by all viewers at that time.
    pub(super) stops: u64,
    /// The number of releases of the button of each axis's jog at that time.
    pub(super) releases: Box<[u64]>,
    /// The room that the message takes in the queue.
    _room: OwnedSemaphorePermit,
}

impl Heard {
    /// Whether the request takes long.
    pub(super) fn is_long(&self) -> bool {
        self.text.len() > SHORT
    }
}

/// A viewer, as the task sees it that reads it.
pub(super) struct Hearing {
    pub(super) id: ViewerId,
    pub(super) shared: Arc<Shared>,
    pub(super) outbox: mpsc::Sender<Outgoing>,
    pub(super) asks: mpsc::Sender<Heard>,
    /// Bytes of requests that may wait.
    pub(super) room: Arc<Semaphore>,
    pub(super) releases: Arc<[AtomicU64]>,
    pub(super) signs: Signs,
}

/// The parts of a message that decide whether it is answered at once.
#[derive(Deserialize)]
struct Head {
    #[serde(default)]
    id: Value,
    #[serde(rename = "do")]
    what: String,
    axis: Option<String>,
    object: Option<String>,
}

impl Hearing {
    /// Reads until the viewer goes; then its jogs are stopped. `begun` has come already.
    pub(super) async fn listen(self, socket: Unread, begun: Bytes) {
        match socket.here() {
            Ok(socket) => self.read(socket, begun).await,
            Err(error) => debug!(%error, "a viewer cannot be read"),
        }
        self.shared.plant.guard().lose(VIEWERS | self.id);
    }

    async fn read(&self, socket: Reading, begun: Bytes) {
        let config = WebSocketConfig::default()
            .max_message_size(Some(LONGEST_MESSAGE))
            .max_frame_size(Some(LONGEST_MESSAGE));
        let mut stream = WebSocketStream::from_partially_read(socket, begun.to_vec(), Role::Server, Some(config)).await;
        let (mut taken, mut since) = (0, Instant::now());
        while let Some(Ok(message)) = stream.next().await {
            self.signs.heard();
            let goes_on = match message {
                Message::Text(text) => self.hear(text),
                Message::Ping(data) => self.answer(Outgoing::Control(Message::Pong(data))),
                Message::Close(_) => {
                    self.answer(Outgoing::Control(Message::Close(None)));
                    false
                }
                Message::Binary(_) | Message::Pong(_) | Message::Frame(_) => true,
            };
            if !goes_on {
                return;
            }
            taken += 1;
            if taken == TURN {
                if since.elapsed() < PAUSE {
                    tokio::time::sleep(PAUSE).await;
                } else {
                    tokio::task::yield_now().await;
                }
                (taken, since) = (0, Instant::now());
            }
        }
    }

    /// Handles a message. Returns whether the viewer reads its answers.
    fn hear(&self, text: Utf8Bytes) -> bool {
        let head = (text.len() <= SHORT).then(|| serde_json::from_str::<Head>(&text));
        let head = head.and_then(Result::ok);
        let Some(head) = head else {
            return self.hand_on(text, None);
        };
        match (head.what.as_str(), head.axis, head.object) {
            ("stop", _, None) => {
                self.shared.stop_everything();
                self.reply(&head.id, Stop { object: None }.answer(Ok(Done {})))
            }
            ("stop", _, Some(object)) => {
                self.shared.program.end();
                self.shared.stops.fetch_add(1, Ordering::AcqRel);
                let (shared, outbox, viewer) = (self.shared.clone(), self.outbox.clone(), self.id);
                tokio::spawn(async move {
                    let stopped = shared.stop(viewer, Some(&object)).await;
                    let answer = Stop { object: Some(object) }.answer(stopped);
                    let _ = outbox.try_send(Outgoing::Text(protocol::reply(&head.id, answer).into()));
                });
                true
            }
            ("keep", Some(axis), _) => {
                let kept = self.shared.jogs.keep(&self.shared.plant, self.id, &axis);
                self.reply(&head.id, Keep { axis }.answer(kept))
            }
            ("jog_end", Some(axis), _) => {
                let index = self.shared.plant.machine().axis(&axis).map(usize::from);
                if let Some(releases) = index.and_then(|index| self.releases.get(index)) {
                    releases.fetch_add(1, Ordering::AcqRel);
                }
                let (shared, outbox, viewer) = (self.shared.clone(), self.outbox.clone(), self.id);
                tokio::spawn(async move {
                    let ended = shared.jogs.end(&shared.plant, viewer, &axis).await;
                    let answer = JogEnd { axis }.answer(ended);
                    let _ = outbox.try_send(Outgoing::Text(protocol::reply(&head.id, answer).into()));
                });
                true
            }
            _ => self.hand_on(text, Some(head.id)),
        }
    }

    /// Gives a request its place among those that wait.
    fn hand_on(&self, text: Utf8Bytes, id: Option<Value>) -> bool {
        let bytes = u32::try_from(text.len()).unwrap_or(u32::MAX).max(1);
        let heard = self.room.clone().try_acquire_many_owned(bytes).ok().map(|room| Heard {
            text,
            stops: self.shared.stops.load(Ordering::Acquire),
            releases: self
                .releases
                .iter()
                .map(|releases| releases.load(Ordering::Acquire))
                .collect(),
            _room: room,
        });
        match heard.map(|heard| self.asks.try_send(heard)) {
            Some(Ok(())) => true,
            Some(Err(mpsc::error::TrySendError::Closed(_))) => false,
            Some(Err(mpsc::error::TrySendError::Full(_))) | None => {
                let full = Refusal::new("too many of your requests wait for their answers already: try again");
                self.reply(&id.unwrap_or_default(), Err(full))
            }
        }
    }

    fn reply(&self, id: &Value, answer: Result<Answer, Refusal>) -> bool {
        self.answer(Outgoing::Text(protocol::reply(id, answer).into()))
    }

    /// Sends an answer. Returns whether the viewer reads its answers.
    fn answer(&self, answer: Outgoing) -> bool {
        self.outbox.try_send(answer).is_ok()
    }
}
