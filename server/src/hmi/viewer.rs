//! One viewer. It is read on the thread of stops (`guard`), where `stop`, `keep` and `jog_end` are done at once, whatever else the server
//! does ([`hearing`]). Everything else that it asks waits in a bounded queue, is answered in order by one task, and another sends answers
//! and pushes. What computes for long does so on threads of its own. Simulations are answered when they are done. A viewer that
//! does not read loses its connection; nobody waits for it.

mod hearing;

use std::io;
use std::pin::Pin;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::task::{Context, Poll};
use std::time::Duration;

use axum::extract::ws::Utf8Bytes;
use bytes::Bytes;
use futures_util::SinkExt as _;
use serde_json::{Value, json};
use tokio::io::{AsyncRead, AsyncWrite, ReadBuf};
use tokio::net::TcpStream;
use tokio::sync::broadcast::error::RecvError;
use tokio::sync::{OwnedSemaphorePermit, Semaphore, broadcast, mpsc, watch};
use tokio::task::JoinSet;
use tokio::time::{MissedTickBehavior, interval, timeout};
use tokio_tungstenite::WebSocketStream;
use tokio_tungstenite::tungstenite::Message;
use tokio_tungstenite::tungstenite::protocol::Role;
use tokio_util::sync::CancellationToken;
use tracing::debug;

use self::hearing::{Heard, Hearing};
use super::Shared;
use super::message::{self, Answer, Ask, Refusal};
use super::rights::{Thing, ViewerId};
use super::status::Status;
use crate::guard::VIEWERS;
use crate::trace::history;

/// Serves a viewer until it goes, from `peer`; `begun` has come on its socket already.
///
/// # Errors
/// The system has no descriptor left.
pub(super) async fn serve(
    socket: TcpStream,
    begun: Bytes,
    shared: Arc<Shared>,
    peer: Option<String>,
) -> io::Result<()> {
    let number = shared.viewers.fetch_add(1, Ordering::Relaxed) + 1;
    let name = format!("{} #{number}", peer.as_deref().unwrap_or("viewer"));
    // One descriptor is read on the thread of stops, the other is written here.
    let reading = socket.into_std()?;
    let writing = TcpStream::from_std(reading.try_clone()?)?;
    debug!(%name, "a viewer of the HMI came");
    let (outbox, inbox) = mpsc::channel(OUTBOX);
    let (asks, asked) = mpsc::channel(ASKS);
    shared.rights().enter(number, name.clone());
    let weak = Arc::downgrade(&shared);
    let signs = shared.plant.guard().enter(VIEWERS | number, &name, weak);
    let hello = json!({
        "push": "hello",
        "viewer": name,
        "trace_signals": history::signals(shared.plant.machine()),
    });
    // It was just made.
    let _ = outbox.try_send(Outgoing::Text(hello.to_string().into()));
    let releases: Arc<[AtomicU64]> = shared.plant.machine().axes.iter().map(|_| AtomicU64::new(0)).collect();
    let viewer = Viewer {
        id: number,
        shared: shared.clone(),
        outbox: outbox.clone(),
        pieces: Arc::new(Semaphore::new(PIECES)),
        releases: releases.clone(),
    };
    let over = CancellationToken::new();
    let hearing = Hearing {
        id: number,
        shared: shared.clone(),
        outbox,
        asks,
        room: Arc::new(Semaphore::new(ASKED_BYTES)),
        releases,
        signs,
    };
    let heard = over.clone().run_until_cancelled_owned(hearing.listen(reading, begun));
    match shared.plant.guard().runtime() {
        Some(runtime) => drop(runtime.spawn(heard)),
        None => drop(tokio::spawn(heard)),
    }
    let over = over.drop_guard();
    let sink = WebSocketStream::from_raw_socket(WriteOnly(writing), Role::Server, None).await;
    tokio::select! {
        () = viewer.listen(asked) => {}
        () = send(sink, inbox, &shared) => {}
    }
    drop(over);
    shared.program.end_of(number);
    shared.leave(number);
    debug!(%name, "a viewer of the HMI went");
    Ok(())
}

/// A socket that somebody else reads.
struct WriteOnly(TcpStream);

impl AsyncRead for WriteOnly {
    fn poll_read(self: Pin<&mut Self>, _: &mut Context<'_>, _: &mut ReadBuf<'_>) -> Poll<io::Result<()>> {
        Poll::Pending
    }
}

impl AsyncWrite for WriteOnly {
    fn poll_write(mut self: Pin<&mut Self>, cx: &mut Context<'_>, bytes: &[u8]) -> Poll<io::Result<usize>> {
        Pin::new(&mut self.0).poll_write(cx, bytes)
    }

    fn poll_flush(mut self: Pin<&mut Self>, cx: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.0).poll_flush(cx)
    }

    fn poll_shutdown(mut self: Pin<&mut Self>, cx: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.0).poll_shutdown(cx)
    }
}

/// A viewer, as the task sees it that answers it.
struct Viewer {
    id: ViewerId,
    shared: Arc<Shared>,
    outbox: mpsc::Sender<Outgoing>,
    /// One for each piece of the past that may wait to be sent.
    pieces: Arc<Semaphore>,
    /// How often the buttons of each axis's jog were let go.
    releases: Arc<[AtomicU64]>,
}

/// What the task is given that sends.
#[derive(Debug)]
enum Outgoing {
    /// A text.
    Text(Utf8Bytes),
    /// What answers a ping or a close.
    Control(Message),
    /// A piece of the past.
    Piece(Bytes, OwnedSemaphorePermit),
    /// Whether frames of samples are wanted.
    Samples(bool),
    /// The tags whose values are wanted.
    Watch(Vec<String>),
}

impl Viewer {
    /// Answers until the viewer goes, or does not read.
    async fn listen(&self, mut asked: mpsc::Receiver<Heard>) {
        // Those that wait end with the viewer.
        let mut simulations = JoinSet::new();
        while let Some(heard) = asked.recv().await {
            let text = heard.text.clone();
            let (id, ask) = if text.len() <= SHORT {
                message::read(&text)
            } else {
                match self.shared.compute(move |_| message::read(&text)).await {
                    Ok(read) => read,
                    Err(refusal) => (Value::Null, Err(refusal)),
                }
            };
            while simulations.try_join_next().is_some() {}
            let answer = match ask {
                Ok(ask @ (Ask::Preview { .. } | Ask::DryRun { .. })) if simulations.len() < SIMULATIONS => {
                    simulations.spawn(self.answer_later(id, ask));
                    continue;
                }
                Ok(ask) if moves(&ask) => self.answer_unless_stopped(ask, &heard).await,
                Ok(ask) => self.answer(ask, &heard).await,
                Err(refusal) => Err(refusal),
            };
            let answer = Outgoing::Text(message::reply(&id, answer).into());
            if self.outbox.try_send(answer).is_err() {
                // It does not read what it asks for.
                return;
            }
        }
    }

    /// What was asked before a STOP is not begun after it.
    async fn answer_unless_stopped(&self, ask: Ask, heard: &Heard) -> Result<Answer, Refusal> {
        let stopped = || self.shared.stops.load(Ordering::Acquire) != heard.stops;
        if stopped() {
            return Err(Refusal::new("STOP was pressed before this was begun"));
        }
        let answer = self.answer(ask, heard).await;
        if stopped() {
            // It may have been sent behind the stop.
            self.shared.plant.stop_all();
        }
        answer
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
            let reply = shared.compute(move |_| message::reply(&id, answer)).await;
            // It may just have gone, or read nothing.
            let _ = reply.map(|reply| outbox.try_send(Outgoing::Text(reply.into())));
        }
    }

    async fn answer(&self, ask: Ask, heard: &Heard) -> Result<Answer, Refusal> {
        let shared = &self.shared;
        match ask {
            Ask::Tags { pattern, after } => {
                self.computed(move |shared| shared.tags(&pattern, after.as_deref()))
                    .await
            }
            Ask::Read { names } if shared.are_many(&names) => self.computed(move |shared| shared.values(&names)).await,
            Ask::Read { names } => shared.values(&names).map(Answer::Value),
            Ask::Watch { names } => {
                let asked = names.clone();
                let values = if shared.are_many(&names) {
                    self.computed(move |shared| shared.values(&asked)).await?
                } else {
                    shared.values(&asked).map(Answer::Value)?
                };
                self.tell(Outgoing::Watch(names))?;
                Ok(values)
            }
            Ask::Events { since } => self.computed(move |shared| Ok(shared.events(since))).await,
            ask => self.answer_shortly(ask, heard).await.map(Answer::Value),
        }
    }

    /// An answer that a thread beside makes and writes.
    async fn computed(
        &self,
        work: impl FnOnce(&Shared) -> Result<Value, Refusal> + Send + 'static,
    ) -> Result<Answer, Refusal> {
        let text = move |shared: &Shared| work(shared).map(|answer| Answer::Text(answer.to_string()));
        self.shared.compute(text).await?
    }

    async fn answer_shortly(&self, ask: Ask, heard: &Heard) -> Result<Value, Refusal> {
        let (shared, id) = (&self.shared, self.id);
        match ask {
            Ask::Ping => Ok(json!({})),
            Ask::Take { object, force } => self.take(&object, force),
            Ask::Release { object } => {
                shared.rights().release(id, self.thing(&object)?);
                Ok(json!({}))
            }
            Ask::Execute { text } => shared.execute(id, &text).await,
            Ask::Line { instruction, operands } => {
                shared
                    .compute_if(heard.is_long(), move |shared| shared.line(&instruction, &operands))
                    .await?
            }
            Ask::Jog {
                axis,
                speed,
                accel,
                decel,
            } => {
                let place = usize::from(shared.axis(&axis)?);
                let is_held = || {
                    let now = self
                        .releases
                        .get(place)
                        .map(|releases| releases.load(Ordering::Acquire));
                    now == heard.releases.get(place).copied()
                };
                shared.jog(id, &axis, [Some(speed), accel, decel], is_held).await
            }
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
            Ask::Check { text } => {
                shared
                    .compute_if(heard.is_long(), move |shared| shared.check(&text))
                    .await
            }
            Ask::Run { text, step } => {
                let parsed = text.clone();
                let program = shared
                    .compute_if(heard.is_long(), move |shared| shared.checked(&parsed))
                    .await??;
                shared.run(id, program, &text, step)
            }
            Ask::Step => shared.step(),
            Ask::Pause => shared.pause(),
            Ask::Continue => shared.go_on(),
            Ask::End => {
                shared.program.end();
                Ok(json!({}))
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
            Ask::Tags { .. } | Ask::Read { .. } | Ask::Watch { .. } | Ask::Events { .. } => {
                Err(Refusal::new("such a request is answered by a thread beside"))
            }
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
async fn send(mut sink: Sink, mut inbox: mpsc::Receiver<Outgoing>, shared: &Arc<Shared>) {
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
                Some(Outgoing::Text(text)) => told(text),
                Some(Outgoing::Control(message)) => message,
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
                told(newest(&mut statuses, &mut paths))
            }
            event = events.recv() => match event {
                Ok(text) => told(text),
                // What was missed can be asked for: numbers tell.
                Err(RecvError::Lagged(_)) => continue,
                Err(RecvError::Closed) => return,
            },
            frame = next_frame(&mut frames) => Message::Binary(frame),
            _ = values.tick(), if !watched.is_empty() => {
                let names = watched.clone();
                let push = move |shared: &Shared| {
                    let mut push = shared.values(&names)?;
                    push["push"] = "values".into();
                    Ok::<_, Refusal>(push.to_string())
                };
                let text = shared.compute_if(shared.are_many(&watched), push).await;
                let Ok(Ok(text)) = text else { continue };
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
type Sink = WebSocketStream<WriteOnly>;

fn told(text: Utf8Bytes) -> Message {
    Message::text(text.as_str())
}

/// Whether a request may move something.
fn moves(ask: &Ask) -> bool {
    matches!(
        ask,
        Ask::Execute { .. }
            | Ask::Jog { .. }
            | Ask::Run { .. }
            | Ask::Step
            | Ask::Continue
            | Ask::Override { .. }
            | Ask::Resume { .. }
            | Ask::Write { .. }
    )
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
/// Time between two pings: the answers are the signs of life of a page that says nothing.
const PING: Duration = Duration::from_millis(500);
/// Requests that may wait for their turn.
const ASKS: usize = 256;
/// Bytes of them.
const ASKED_BYTES: usize = 512 * 1024;
/// The longest message that is read and worked on by the threads that others share, bytes.
const SHORT: usize = 1024;
/// Time between two pushes of watched values.
const VALUES: Duration = Duration::from_millis(100);
