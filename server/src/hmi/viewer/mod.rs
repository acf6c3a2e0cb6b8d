//! One viewer. The thread of stops (`guard`) reads its requests and answers `stop`, `keep` and `jog_end` at once, independent of other work
//! of the server ([`hearing`]). All other requests wait in a bounded queue; one task answers them in order ([`driving`], [`programs`],
//! [`mod@tags`], [`logic`], [`records`], [`sessions`]), and another one sends answers and pushes. Long computations run on threads of their own.
//! Simulations are answered when they are done. A viewer that does not read loses its connection, and delays no other one.

mod driving;
mod hearing;
mod logic;
mod programs;
mod records;
mod requests;
mod sending;
mod sessions;
mod tags;
mod watched;

use std::io;
use std::net::IpAddr;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use arcline_proto::arcline::machine::Identification;
use bytes::Bytes;
use serde_json::Value;
use tokio::sync::{Semaphore, mpsc};
use tokio::task::JoinSet;
use tokio_tungstenite::WebSocketStream;
use tokio_tungstenite::tungstenite::protocol::Role;
use tokio_util::sync::CancellationToken;
use tracing::debug;

use self::hearing::{Heard, Hearing};
use self::requests::{audited, moves, right};
use self::sending::{Outgoing, Sight, send};
use super::protocol::{self, Answer, Asks as _, Done, Push, Refusal, Request, text_of};
use super::sessions::Joined;
use super::socket::Socket;
use super::{Shared, controller, drive};
use crate::guard::VIEWERS;
use crate::plant::control::{MotionObject, ViewerId};
use crate::plant::{ClientIdentity, Command, Plant, Principal, Right};
use crate::trace::history;

/// The page of a viewer, or the script.
#[derive(Clone, Debug)]
pub(super) struct Page {
    /// Its IP address.
    pub(super) peer: IpAddr,
    /// The browser that shows it, as its product.
    pub(super) identification: Identification,
    /// The role of its address.
    pub(super) role: arcline_config::Role,
    /// The session that it showed.
    pub(super) session: Option<Joined>,
    /// Whether a user could log in on this connection.
    pub(super) can_log_in: bool,
    /// Is cancelled when the viewer is to be closed.
    pub(super) close: CancellationToken,
}

/// Serves the viewer of a page until it goes; `begun` has come on its socket already.
///
/// # Errors
/// The system has no descriptor left.
pub(super) async fn serve(socket: Socket, begun: Bytes, shared: Arc<Shared>, page: Page) -> io::Result<()> {
    let number = shared.viewers.fetch_add(1, Ordering::Relaxed) + 1;
    let mut name = format!("{} #{number}", page.peer);
    if let Some(joined) = &page.session {
        name.push_str(&format!(" {}", joined.subject));
    }
    // One half is read on the thread of stops, the other is written here.
    let (reading, writing) = socket.split()?;
    debug!(%name, "a viewer of the HMI came");
    let (outbox, inbox) = mpsc::channel(OUTBOX);
    let (asks, asked) = mpsc::channel(ASKS);
    shared.plant.control().enter(number, name.clone());
    let weak = Arc::downgrade(&shared);
    let identity = ClientIdentity {
        address: name.clone(),
        ip: Some(page.peer),
        identification: page.identification,
    };
    let signs = shared.plant.enter(VIEWERS | number, identity, page.role, weak);
    let session = page.session.filter(|joined| {
        let join = shared.sessions.join(&shared.plant, &joined.key, number, page.role);
        join.is_some()
    });
    let sight = Sight {
        viewer: number,
        user: session.as_ref().map(|joined| joined.user.clone()),
        state: session.as_ref().map(|joined| joined.state.clone()),
        can_log_in: page.can_log_in,
    };
    let hello = Push::Hello {
        viewer: &name,
        trace_signals: history::signals(shared.plant.machine()),
    };
    // The channel was just made, so it has room.
    let _ = outbox.try_send(Outgoing::Text(text_of(&hello).into()));
    let _ = outbox.try_send(Outgoing::Text(sight.push(&shared.plant).into()));
    let releases: Arc<[AtomicU64]> = shared.plant.machine().axes.iter().map(|_| AtomicU64::new(0)).collect();
    let viewer = Viewer {
        id: number,
        shared: shared.clone(),
        outbox: outbox.clone(),
        pieces: Arc::new(Semaphore::new(PIECES)),
        releases: releases.clone(),
        session: session.clone(),
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
    let sink = WebSocketStream::from_raw_socket(writing, Role::Server, None).await;
    tokio::select! {
        // In order, so that a run can be repeated. Each turn sends before it answers: requests without end delay no message.
        biased;
        () = page.close.cancelled() => debug!(%name, "closed"),
        () = send(sink, inbox, &shared, sight) => {}
        () = viewer.listen(asked) => {}
    }
    drop(over);
    if let Some(joined) = &session {
        shared.sessions.leave(&joined.key, number);
    }
    shared.program.end_of(number);
    shared.jogs.leave(&shared.plant, number);
    controller::leave(&shared.plant, number);
    debug!(%name, "a viewer of the HMI went");
    Ok(())
}

/// A viewer, as the task sees it that answers it.
struct Viewer {
    id: ViewerId,
    shared: Arc<Shared>,
    outbox: mpsc::Sender<Outgoing>,
    /// One for each piece of the past that may wait to be sent.
    pieces: Arc<Semaphore>,
    /// The number of releases of the button of each axis's jog.
    releases: Arc<[AtomicU64]>,
    /// Its session.
    session: Option<Joined>,
}

impl Viewer {
    /// Answers until the viewer goes, or does not read.
    async fn listen(&self, mut asked: mpsc::Receiver<Heard>) {
        // The waiting simulations end with the viewer.
        let mut simulations = JoinSet::new();
        while let Some(heard) = asked.recv().await {
            let text = heard.text.clone();
            let (id, request) = if text.len() <= SHORT {
                protocol::read(&text)
            } else {
                match self.shared.workers.compute(move || protocol::read(&text)).await {
                    Ok(read) => read,
                    Err(refusal) => (Value::Null, Err(refusal)),
                }
            };
            while simulations.try_join_next().is_some() {}
            let answer = match request {
                Ok(request) => self.take_turn(&id, request, &heard, &mut simulations).await,
                Err(refusal) => Some(Err(refusal)),
            };
            let Some(answer) = answer else { continue };
            if self
                .outbox
                .try_send(Outgoing::Text(protocol::reply(&id, answer).into()))
                .is_err()
            {
                // The viewer does not read its answers.
                return;
            }
        }
    }

    /// Answers a request; a request that would move the machine only if STOP was not pressed since. `None`: a simulation, which is
    /// answered when it is done.
    async fn take_turn(
        &self,
        id: &Value,
        request: Request,
        heard: &Heard,
        simulations: &mut JoinSet<()>,
    ) -> Option<Result<Answer, Refusal>> {
        let stopped = || self.shared.stops.load(Ordering::Acquire) != heard.stops;
        let moves = moves(&request);
        if moves && stopped() {
            return Some(Err(Refusal::new("STOP came before this request began")));
        }
        // Its role has gone with its session, and the socket is about to be closed. A stop is a stop.
        if let Some(why) = self.ended()
            && right(&request) != Right::Stop
        {
            return Some(Err(Refusal::new(why.text())));
        }
        if let Err(refused) = self.shared.plant.check(Principal::Viewer(self.id), right(&request)) {
            return Some(Err(refused.into()));
        }
        let audited = audited(&request);
        let answer = self.answer(id, request, heard, simulations).await;
        if let Some((kind, object)) = audited {
            let result = if matches!(answer, Some(Err(_))) {
                "refused"
            } else {
                "done"
            };
            let by = Principal::Viewer(self.id);
            self.shared.plant.record(by, kind, object, result);
        }
        if moves && stopped() {
            // Its instruction may have been sent after the stop.
            self.shared.plant.stop_all();
        }
        answer
    }

    /// Answers a request by its subject. `None`: a simulation, which is answered when it is done.
    async fn answer(
        &self,
        id: &Value,
        request: Request,
        heard: &Heard,
        simulations: &mut JoinSet<()>,
    ) -> Option<Result<Answer, Refusal>> {
        Some(match request {
            Request::Preview(request) => return self.preview(id, request, simulations),
            Request::DryRun(request) => return self.dry_run(id, request, simulations),
            Request::Ping(request) => request.answer(Ok(Done {})),
            Request::Active(request) => request.answer(Ok(self.active())),
            Request::Sessions(request) => request.answer(Ok(self.sessions())),
            Request::EndSession(request) => request.answer(self.end_session(&request)),
            Request::Take(request) => request.answer(self.take(&request)),
            Request::Release(request) => request.answer(self.release(&request)),
            Request::Execute(request) => request.answer(self.execute(&request).await),
            Request::Line(request) => self.line(request, heard).await,
            Request::Jog(request) => request.answer(self.jog(&request, heard).await),
            Request::Keep(request) => request.answer(self.keep(&request)),
            Request::JogEnd(request) => request.answer(self.jog_end(&request).await),
            Request::Stop(request) => request.answer(self.stop(&request).await),
            Request::ReleaseStop(request) => request.answer(self.apply(Command::Release).await),
            Request::Override(request) => request.answer(self.set_override(&request).await),
            Request::Hold(request) => request.answer(self.hold(&request).await),
            Request::Resume(request) => request.answer(self.resume(&request).await),
            Request::Check(request) => self.check(request, heard).await,
            Request::Run(request) => request.answer(self.run(&request, heard).await),
            Request::Step(request) => request.answer(self.step()),
            Request::Pause(request) => request.answer(self.pause()),
            Request::Continue(request) => request.answer(self.go_on()),
            Request::End(request) => request.answer(Ok(self.end())),
            Request::Tags(request) => self.list_tags(request).await,
            Request::Read(request) => self.read_tags(request).await,
            Request::Watch(request) => self.watch_tags(request).await,
            Request::Write(request) => request.answer(self.write_tag(&request).await),
            Request::Routines(request) => self.routines(request).await,
            Request::Rungs(request) => self.rungs(request).await,
            Request::Look(request) => self.look(request).await,
            Request::Uses(request) => self.uses(request).await,
            Request::Mode(request) => request.answer(self.set_mode(&request).await),
            Request::Force(request) => request.answer(self.force(&request).await),
            Request::RemoveForces(request) => request.answer(self.apply(Command::RemoveForce(None)).await),
            Request::Trace(request) => request.answer(self.trace(request.on)),
            Request::History(request) => request.answer(self.history(request.before)),
            Request::Events(request) => self.events(request).await,
        })
    }

    /// An answer that a thread beside makes if it is long.
    async fn computed(
        &self,
        is_long: bool,
        work: impl FnOnce(&Plant) -> Result<Answer, Refusal> + Send + 'static,
    ) -> Result<Answer, Refusal> {
        let plant = self.shared.plant.clone();
        self.shared.workers.compute_if(is_long, move || work(&plant)).await?
    }

    async fn apply(&self, command: Command<'_>) -> Result<Done, Refusal> {
        self.shared.apply(Principal::Viewer(self.id), command).await
    }

    fn object(&self, name: &str) -> Result<MotionObject, Refusal> {
        MotionObject::find(self.shared.plant.machine(), name).ok_or_else(|| drive::no_object(name))
    }

    fn send(&self, what: Outgoing) -> Result<(), Refusal> {
        let full = |_| Refusal::new("the page does not read the messages of the server");
        self.outbox.try_send(what).map_err(full)
    }
}

/// Simulations of a viewer that may wait or run.
pub(super) const SIMULATIONS: usize = 4;
/// Pieces of the past that may wait for a viewer to read.
const PIECES: usize = 2;
/// Answers that may wait for a viewer to read.
const OUTBOX: usize = 256;
/// Requests that may wait for their turn.
const ASKS: usize = 256;
/// Bytes of them.
const ASKED_BYTES: usize = 512 * 1024;
/// The longest message that is read and worked on by the threads that others share, bytes.
const SHORT: usize = 1024;
