//! The task that writes to a viewer: answers, and the pushes of changes.

use std::sync::Arc;
use std::time::Duration;

use axum::extract::ws::Utf8Bytes;
use bytes::Bytes;
use futures_util::SinkExt as _;
use tokio::sync::broadcast::error::RecvError;
use tokio::sync::{OwnedSemaphorePermit, broadcast, mpsc};
use tokio::time::{interval, timeout};
use tokio_tungstenite::WebSocketStream;
use tokio_tungstenite::tungstenite::Message;
use tokio_tungstenite::tungstenite::protocol::CloseFrame;
use tokio_tungstenite::tungstenite::protocol::frame::coding::CloseCode;

use super::watched::Watched;
use crate::hmi::protocol::{Push, Refusal, text_of};
use crate::hmi::sessions::{End, State};
use crate::hmi::socket::Writing;
use crate::hmi::status::Status;
use crate::hmi::{Shared, controller, tags};
use crate::plant::control::ViewerId;
use crate::plant::{Plant, Principal};
use crate::watch;

/// The session as its viewer sees it.
pub(super) struct Sight {
    pub(super) viewer: ViewerId,
    pub(super) user: Option<String>,
    /// `None`: it has no session.
    pub(super) state: Option<watch::Receiver<State>>,
    pub(super) can_log_in: bool,
}

impl Sight {
    /// The push of the session's state.
    pub(super) fn push(&self, plant: &Plant) -> String {
        let state = self.state.as_ref().map(|state| *state.borrow());
        text_of(&Push::Session {
            role: plant.roles().of(Principal::Viewer(self.viewer)).word(),
            user: self.user.as_deref(),
            locked: state == Some(State::Locked),
            can_log_in: self.can_log_in,
        })
    }

    /// Waits for a change.
    async fn changed(&mut self) -> State {
        match &mut self.state {
            None => std::future::pending().await,
            Some(state) => match state.changed().await {
                Ok(()) => *state.borrow_and_update(),
                // A session says that it ends before it goes.
                Err(_) => State::Ended(End::LoggedOut),
            },
        }
    }
}

/// A message for the task that sends.
pub(super) enum Outgoing {
    /// A text.
    Text(Utf8Bytes),
    /// The answer to a ping or a close.
    Control(Message),
    /// A piece of the past.
    Piece(Bytes, OwnedSemaphorePermit),
    /// `true` begins the frames of samples, `false` ends them.
    Samples(bool),
    /// The tags whose values are wanted.
    Watch(Vec<String>),
    /// The rungs or lines of the controller's own program that the viewer watches.
    Monitor(Option<controller::MonitorUpdates>),
}

/// Sends answers, and the pushes to every viewer.
pub(super) async fn send(mut sink: Sink, mut inbox: mpsc::Receiver<Outgoing>, shared: &Arc<Shared>, mut sight: Sight) {
    let mut statuses = shared.status.subscribe();
    let mut events = shared.events.subscribe();
    let mut programs = shared.program.watch();
    let mut frames = None;
    let mut watched = Watched::new(&shared.plant);
    let mut monitored = None;
    let (mut paths, mut program) = (0, None);
    let mut pings = interval(PING);
    loop {
        let message = tokio::select! {
            biased;
            outgoing = inbox.recv() => match outgoing {
                Some(Outgoing::Text(text)) => told(text),
                Some(Outgoing::Control(message)) => message,
                Some(Outgoing::Piece(frame, _place)) => Message::Binary(frame),
                Some(Outgoing::Samples(on)) => {
                    frames = on.then(|| shared.frames.subscribe());
                    continue;
                }
                Some(Outgoing::Watch(names)) => {
                    watched.watch(&shared.plant, names);
                    continue;
                }
                Some(Outgoing::Monitor(at)) => {
                    monitored = at;
                    continue;
                }
                None => return,
            },
            state = sight.changed() => match state {
                State::Open(_) | State::Locked => Message::Text(sight.push(&shared.plant).into()),
                State::Ended(why) => {
                    let close = CloseFrame {
                        code: CloseCode::Library(SESSION_ENDED),
                        reason: why.text().into(),
                    };
                    send_one(&mut sink, Message::Close(Some(close))).await;
                    // Its answer ends the viewer sooner; a socket that is closed before it has come loses the frame.
                    tokio::time::sleep(GOODBYE).await;
                    return;
                }
            },
            changed = statuses.changed() => {
                if changed.is_err() {
                    return;
                }
                // The status of the program comes as often as that of the machine.
                if programs.has_changed() {
                    let push = programs.borrow_and_update().push(&mut program);
                    if !send_one(&mut sink, Message::Text(push.into())).await {
                        return;
                    }
                }
                told(newest(&mut statuses, &mut paths))
            }
            event = events.recv() => match event {
                Ok(text) => told(text),
                // The page sees the gap in the numbers, and asks for the missed events.
                Err(RecvError::Lagged(_)) => continue,
                Err(RecvError::Closed) => return,
            },
            frame = next_frame(&mut frames) => Message::Binary(frame),
            push = next_monitor_push(&mut monitored) => Message::Text(push.into()),
            changes = watched.changes() => {
                let Some(changes) = changes else { return };
                let names = watched.take(&shared.plant, &changes);
                if names.is_empty() {
                    continue;
                }
                let is_long = tags::are_many(&shared.plant, &names);
                let plant = shared.plant.clone();
                let push = move || {
                    let values = tags::values(&plant, &names)?.values;
                    Ok::<_, Refusal>(text_of(&Push::Values { values }))
                };
                let Ok(Ok(text)) = shared.workers.compute_if(is_long, push).await else { continue };
                Message::Text(text.into())
            }
            _ = pings.tick() => Message::Ping(Bytes::new()),
        };
        if !send_one(&mut sink, message).await {
            return;
        }
    }
}

/// The near end of a viewer, as far as it is written.
type Sink = WebSocketStream<Writing>;

fn told(text: Utf8Bytes) -> Message {
    Message::text(text.as_str())
}

/// False: the viewer has gone, or does not read.
async fn send_one(sink: &mut Sink, message: Message) -> bool {
    matches!(timeout(READ_WITHIN, sink.send(message)).await, Ok(Ok(())))
}

/// The next frame of samples that was not missed; never, where none are wanted.
async fn next_frame(frames: &mut Option<broadcast::Receiver<Bytes>>) -> Bytes {
    while let Some(receiver) = frames {
        match receiver.recv().await {
            Ok(frame) => return frame,
            // The first tick of the next frame shows the gap.
            Err(RecvError::Lagged(_)) => {}
            Err(RecvError::Closed) => *frames = None,
        }
    }
    std::future::pending().await
}

/// The next push of the watched rungs or lines; it never comes if the viewer watches none.
async fn next_monitor_push(monitored: &mut Option<controller::MonitorUpdates>) -> String {
    match monitored {
        Some(monitored) => monitored.changed().await,
        None => std::future::pending().await,
    }
}

/// The newest status, with the paths if they are others than those the viewer has.
fn newest(statuses: &mut watch::Receiver<Status>, paths: &mut u64) -> Utf8Bytes {
    let status = statuses.borrow_and_update();
    if std::mem::replace(paths, status.paths) == status.paths {
        status.light.clone()
    } else {
        status.whole.clone()
    }
}

/// The code by which a WebSocket is closed whose session has ended; a page connects again without it.
const SESSION_ENDED: u16 = 4401;
/// The time that a page has to answer that close.
const GOODBYE: Duration = Duration::from_secs(1);
/// The time that a viewer has to read a message.
const READ_WITHIN: Duration = Duration::from_secs(10);
/// Time between two pings: the answers are the signs of life of a silent page.
const PING: Duration = Duration::from_millis(500);
