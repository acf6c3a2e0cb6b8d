//! One viewer: what it asks is answered in order by one task, and another sends answers and pushes. Simulations are
//! answered when they are done, so that nothing waits for one, least of all a stop. A viewer that does not read loses its
//! connection; nobody waits for it.

use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Duration;

use axum::extract::ws::{Message, Utf8Bytes, WebSocket};
use bytes::Bytes;
use futures_util::stream::{SplitSink, SplitStream};
use futures_util::{SinkExt as _, StreamExt as _};
use serde_json::{Value, json};
use tokio::sync::broadcast::error::RecvError;
use tokio::sync::{OwnedSemaphorePermit, Semaphore, broadcast, mpsc, watch};
use tokio::task::JoinSet;
use tokio::time::{MissedTickBehavior, interval, timeout};
use tracing::debug;

use super::Shared;
use super::message::{self, Ask, Refusal};
use super::rights::{Thing, ViewerId};
use super::status::Status;
use crate::trace::history;

/// Serves a viewer until it goes, from `peer`.
pub(super) async fn serve(socket: WebSocket, shared: Arc<Shared>, peer: Option<String>) {
    let number = shared.viewers.fetch_add(1, Ordering::Relaxed) + 1;
    let name = format!("{} #{number}", peer.as_deref().unwrap_or("viewer"));
    debug!(%name, "a viewer of the HMI came");
    let (sink, stream) = socket.split();
    let (outbox, inbox) = mpsc::channel(OUTBOX);
    shared.rights().enter(number, name.clone());
    let hello = json!({
        "push": "hello",
        "viewer": name,
        "trace_signals": history::signals(shared.plant.machine()),
    });
    // It was just made.
    let _ = outbox.try_send(Outgoing::Text(hello.to_string().into()));
    let viewer = Viewer {
        id: number,
        shared: shared.clone(),
        outbox,
        pieces: Arc::new(Semaphore::new(PIECES)),
    };
    tokio::select! {
        () = viewer.listen(stream) => {}
        () = send(sink, inbox, &shared) => {}
    }
    shared.program.end_of(number);
    shared.leave(number).await;
    debug!(%name, "a viewer of the HMI went");
}

/// A viewer, as the task sees it that hears it.
struct Viewer {
    id: ViewerId,
    shared: Arc<Shared>,
    outbox: mpsc::Sender<Outgoing>,
    /// One for each piece of the past that may wait to be sent.
    pieces: Arc<Semaphore>,
}

/// What the task is given that sends.
#[derive(Debug)]
enum Outgoing {
    /// A text.
    Text(Utf8Bytes),
    /// A piece of the past.
    Piece(Bytes, OwnedSemaphorePermit),
    /// Whether frames of samples are wanted.
    Samples(bool),
    /// The tags whose values are wanted.
    Watch(Vec<String>),
}

impl Viewer {
    /// Answers until the viewer goes, or does not read.
    async fn listen(&self, mut stream: SplitStream<WebSocket>) {
        // Those that wait end with the viewer.
        let mut simulations = JoinSet::new();
        while let Some(Ok(received)) = stream.next().await {
            let text = match received {
                Message::Text(text) => text,
                Message::Close(_) => return,
                Message::Binary(_) | Message::Ping(_) | Message::Pong(_) => continue,
            };
            let (id, ask) = message::read(&text);
            while simulations.try_join_next().is_some() {}
            let answer = match ask {
                Ok(ask @ (Ask::Preview { .. } | Ask::DryRun { .. })) if simulations.len() < SIMULATIONS => {
                    simulations.spawn(self.answer_later(id, ask));
                    continue;
                }
                Ok(ask) => self.answer(ask).await,
                Err(refusal) => Err(refusal),
            };
            let answer = Outgoing::Text(message::reply(&id, answer).into());
            if self.outbox.try_send(answer).is_err() {
                // It does not read what it asks for.
                return;
            }
        }
    }

    /// Answers what takes its time.
    fn answer_later(&self, id: Value, ask: Ask) -> impl Future<Output = ()> + Send + use<> {
        let (shared, outbox) = (self.shared.clone(), self.outbox.clone());
        async move {
            let answer = match &ask {
                Ask::Preview { text } => shared.preview(text).await,
                Ask::DryRun { text } => shared.dry_run(text).await,
                _ => return,
            };
            // It may just have gone, or read nothing.
            let _ = outbox.try_send(Outgoing::Text(message::reply(&id, answer).into()));
        }
    }

    async fn answer(&self, ask: Ask) -> Result<Value, Refusal> {
        let (shared, id) = (&self.shared, self.id);
        match ask {
            Ask::Ping => Ok(json!({})),
            Ask::Take { object, force } => self.take(&object, force),
            Ask::Release { object } => {
                shared.rights().release(id, self.thing(&object)?);
                Ok(json!({}))
            }
            Ask::Execute { text } => shared.execute(id, &text).await,
            Ask::Line { instruction, operands } => shared.line(&instruction, &operands),
            Ask::Jog {
                axis,
                speed,
                accel,
                decel,
            } => shared.jog(id, &axis, speed, accel, decel).await,
            Ask::Keep { axis } => shared.keep(id, &axis),
            Ask::JogEnd { axis } => shared.jog_end(id, &axis).await,
            Ask::Stop { object } => shared.stop(id, object.as_deref()).await,
            Ask::Override {
                coordinate_system,
                percent,
            } => shared.set_override(id, &coordinate_system, percent).await,
            Ask::Hold { coordinate_system } => shared.hold(&coordinate_system).await,
            Ask::Resume { coordinate_system } => shared.resume(id, &coordinate_system).await,
            Ask::Preview { .. } | Ask::DryRun { .. } => Err(Refusal::new(format!(
                "{SIMULATIONS} simulations wait already: let one of them end"
            ))),
            Ask::Check { text } => Ok(shared.check(&text)),
            Ask::Run { text, step } => shared.run(id, &text, step),
            Ask::Step => shared.step(),
            Ask::Pause => shared.pause(),
            Ask::Continue => shared.go_on(),
            Ask::End => {
                shared.program.end();
                Ok(json!({}))
            }
            Ask::Tags { pattern, after } => Ok(shared.tags(&pattern, after.as_deref())),
            Ask::Read { names } => shared.values(&names),
            Ask::Watch { names } => {
                let values = shared.values(&names)?;
                self.tell(Outgoing::Watch(names))?;
                Ok(values)
            }
            Ask::Write { tag, value } => shared.write(id, &tag, &value).await,
            Ask::Trace { on } => {
                self.tell(Outgoing::Samples(on))?;
                let machine = shared.plant.machine();
                Ok(json!({"signals": history::signals(machine), "period_s": machine.period()}))
            }
            Ask::Past { before } => {
                let place = self.pieces.clone().try_acquire_owned();
                let place = place.map_err(|_| Refusal::new("read first what was sent to you"))?;
                let (frame, told) = shared.past(before);
                self.tell(Outgoing::Piece(frame, place))?;
                Ok(told)
            }
            Ask::Events { since } => Ok(shared.events(since)),
        }
    }

    fn take(&self, object: &str, force: bool) -> Result<Value, Refusal> {
        let thing = self.thing(object)?;
        let machine = self.shared.plant.machine();
        let taken = self.shared.rights().take(machine, self.id, thing, force);
        taken.map_err(|held| Refusal::control(held.thing.name(machine), Some(&held.by)))?;
        Ok(json!({}))
    }

    fn thing(&self, object: &str) -> Result<Thing, Refusal> {
        Thing::find(self.shared.plant.machine(), object).ok_or_else(|| {
            let object: String = object.chars().take(60).collect();
            Refusal::new(format!("there is no axis, coordinate system or group {object:?}"))
        })
    }

    fn tell(&self, what: Outgoing) -> Result<(), Refusal> {
        let full = |_| Refusal::new("you do not read what is sent to you");
        self.outbox.try_send(what).map_err(full)
    }
}

/// Sends answers, and whatever is pushed to every viewer.
async fn send(mut sink: SplitSink<WebSocket, Message>, mut inbox: mpsc::Receiver<Outgoing>, shared: &Shared) {
    let mut statuses = shared.status.subscribe();
    let mut events = shared.events.subscribe();
    let mut programs = shared.program.watch();
    let mut frames = None;
    let mut watched: Vec<String> = Vec::new();
    let (mut paths, mut program) = (0, None);
    let mut pings = interval(PING);
    let mut values = interval(VALUES);
    values.set_missed_tick_behavior(MissedTickBehavior::Delay);
    loop {
        let message = tokio::select! {
            biased;
            outgoing = inbox.recv() => match outgoing {
                Some(Outgoing::Text(text)) => Message::Text(text),
                Some(Outgoing::Piece(frame, _place)) => Message::Binary(frame),
                Some(Outgoing::Samples(on)) => {
                    frames = on.then(|| shared.frames.subscribe());
                    continue;
                }
                Some(Outgoing::Watch(names)) => {
                    watched = names;
                    continue;
                }
                None => return,
            },
            changed = statuses.changed() => {
                if changed.is_err() {
                    return;
                }
                // A program is told as often as the state.
                if programs.has_changed().unwrap_or(false) {
                    let push = programs.borrow_and_update().push(&mut program);
                    if !send_one(&mut sink, Message::Text(push.into())).await {
                        return;
                    }
                }
                Message::Text(newest(&mut statuses, &mut paths))
            }
            event = events.recv() => match event {
                Ok(text) => Message::Text(text),
                // What was missed can be asked for: numbers tell.
                Err(RecvError::Lagged(_)) => continue,
                Err(RecvError::Closed) => return,
            },
            frame = next_frame(&mut frames) => Message::Binary(frame),
            _ = values.tick(), if !watched.is_empty() => {
                let Ok(mut push) = shared.values(&watched) else { continue };
                push["push"] = "values".into();
                Message::Text(push.to_string().into())
            }
            _ = pings.tick() => Message::Ping(Bytes::new()),
        };
        if !send_one(&mut sink, message).await {
            return;
        }
    }
}

/// False: the viewer has gone, or does not read.
async fn send_one(sink: &mut SplitSink<WebSocket, Message>, message: Message) -> bool {
    matches!(timeout(READ_WITHIN, sink.send(message)).await, Ok(Ok(())))
}

/// The next frame of samples that was not missed; never, where none are wanted.
async fn next_frame(frames: &mut Option<broadcast::Receiver<Bytes>>) -> Bytes {
    while let Some(receiver) = frames {
        match receiver.recv().await {
            Ok(frame) => return frame,
            // The next one's first tick tells what is missing.
            Err(RecvError::Lagged(_)) => {}
            Err(RecvError::Closed) => *frames = None,
        }
    }
    std::future::pending().await
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

/// Simulations of a viewer that may wait or run.
pub(super) const SIMULATIONS: usize = 4;
/// Pieces of the past that may wait for a viewer to read.
const PIECES: usize = 2;
/// Answers that may wait for a viewer to read.
const OUTBOX: usize = 256;
/// How long a viewer may take to read what is sent to it.
const READ_WITHIN: Duration = Duration::from_secs(10);
/// Time between two pings, which tell that the network still carries.
const PING: Duration = Duration::from_secs(5);
/// Time between two pushes of watched values.
const VALUES: Duration = Duration::from_millis(100);
