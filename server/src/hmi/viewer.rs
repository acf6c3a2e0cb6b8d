//! One viewer: what it asks is answered in order by one task, and another sends answers and pushes. A viewer that does
//! not read loses its connection; nobody waits for it.

use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Duration;

use axum::extract::ws::{Message, Utf8Bytes, WebSocket};
use futures_util::stream::{SplitSink, SplitStream};
use futures_util::{SinkExt as _, StreamExt as _};
use serde_json::{Value, json};
use tokio::sync::mpsc;
use tokio::time::{interval, timeout};
use tracing::debug;

use super::message::{self, Ask, Refusal};
use super::{Shared, status};

/// Answers that may wait for a viewer to read.
const OUTBOX: usize = 256;
/// How long a viewer may take to read what is sent to it.
const READ_WITHIN: Duration = Duration::from_secs(10);
/// Time between two pings, which tell that the network still carries.
const PING: Duration = Duration::from_secs(5);

/// Serves a viewer until it goes, from `peer`.
pub(super) async fn serve(socket: WebSocket, shared: Arc<Shared>, peer: Option<String>) {
    let number = shared.viewers.fetch_add(1, Ordering::Relaxed) + 1;
    let name = format!("{} #{number}", peer.as_deref().unwrap_or("viewer"));
    debug!(%name, "a viewer of the HMI came");
    let (sink, stream) = socket.split();
    let (outbox, inbox) = mpsc::channel(OUTBOX);
    let hello = json!({
        "push": "hello",
        "viewer": name,
        "trace_signals": status::signals(shared.plant.machine()),
    });
    // It was just made.
    let _ = outbox.try_send(Message::Text(hello.to_string().into()));
    let viewer = Viewer { outbox };
    tokio::select! {
        () = viewer.listen(stream) => {}
        () = send(sink, inbox, &shared) => {}
    }
    debug!(%name, "a viewer of the HMI went");
}

/// A viewer, as the task sees it that hears it.
struct Viewer {
    outbox: mpsc::Sender<Message>,
}

impl Viewer {
    /// Answers until the viewer goes, or does not read.
    async fn listen(&self, mut stream: SplitStream<WebSocket>) {
        while let Some(Ok(received)) = stream.next().await {
            let text = match received {
                Message::Text(text) => text,
                Message::Close(_) => return,
                Message::Binary(_) | Message::Ping(_) | Message::Pong(_) => continue,
            };
            let (id, ask) = message::read(&text);
            let answer = match ask {
                Ok(ask) => self.answer(ask).await,
                Err(refusal) => Err(refusal),
            };
            if self.tell(message::reply(&id, answer)).is_err() {
                return;
            }
        }
    }

    async fn answer(&self, ask: Ask) -> Result<Value, Refusal> {
        match ask {
            Ask::Ping => Ok(json!({})),
        }
    }

    /// Queues a text.
    ///
    /// # Errors
    /// The viewer has not read for too long.
    fn tell(&self, text: String) -> Result<(), Deaf> {
        self.outbox.try_send(Message::Text(text.into())).map_err(|_| Deaf)
    }
}

/// A viewer that does not read.
#[derive(Debug)]
struct Deaf;

/// Sends answers, and the newest status whenever there is one.
async fn send(mut sink: SplitSink<WebSocket, Message>, mut inbox: mpsc::Receiver<Message>, shared: &Shared) {
    let mut statuses = shared.status.subscribe();
    let mut pings = interval(PING);
    loop {
        let message = tokio::select! {
            biased;
            message = inbox.recv() => match message {
                Some(message) => message,
                None => return,
            },
            changed = statuses.changed() => match changed {
                Ok(()) => Message::Text(newest(&mut statuses)),
                Err(_) => return,
            },
            _ = pings.tick() => Message::Ping(bytes::Bytes::new()),
        };
        match timeout(READ_WITHIN, sink.send(message)).await {
            Ok(Ok(())) => {}
            Ok(Err(_)) | Err(_) => return,
        }
    }
}

fn newest(statuses: &mut tokio::sync::watch::Receiver<status::Status>) -> Utf8Bytes {
    statuses.borrow_and_update().text.clone()
}
