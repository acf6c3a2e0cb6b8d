//! One viewer. The thread of stops (`guard`) reads its requests and answers `stop`, `keep` and `jog_end` at once, whatever else the
//! server does ([`hearing`]). All other requests wait in a bounded queue; one task answers them in order, and another one sends answers
//! and pushes. Long computations run on threads of their own. Simulations are answered when they are done. A viewer that
//! does not read loses its connection, and delays no other one.

mod hearing;
mod requests;
mod sending;
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
use super::protocol::{
    self, Answer, Asks as _, Done, HistoryPiece, Jog, Push, Refusal, Request, Run, Signals, Simulated, text_of,
};
use super::sessions::{Joined, Key};
use super::socket::Socket;
use super::{Shared, controller, drive, events, frames, line, program, tags};
use crate::guard::VIEWERS;
use crate::plant::control::{MotionObject, ViewerId};
use crate::plant::{ClientIdentity, Command, Mode, Plant, Principal};
use crate::trace::history;

/// The page of a viewer, or the script.
#[derive(Clone, Debug)]
pub(super) struct Page {
    /// Its IP address.
    pub(super) peer: IpAddr,
    /// The browser that shows it, as its product.
    pub(super) told: Identification,
    /// The role of its address.
    pub(super) role: arcline_config::Role,
    /// The session that it showed.
    pub(super) session: Option<Joined>,
    /// Whether a user could log in there.
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
        told: page.told,
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
        session: session.as_ref().map(|joined| joined.key.clone()),
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
    /// How often the button of each axis's jog was released.
    releases: Arc<[AtomicU64]>,
    /// Its session.
    session: Option<Key>,
}

impl Shared {
    /// Reads a program from a text beside, and simulates it when those before have ended.
    async fn simulate(
        &self,
        read: impl FnOnce(&Plant) -> Result<arcline_structured_text::Program, Refusal> + Send + 'static,
    ) -> Result<Simulated, Refusal> {
        let plant = self.plant.clone();
        let program = self.workers.compute(move || read(&plant)).await??;
        self.previews.simulate(&self.plant, program).await
    }
}

impl Viewer {
    /// Answers until the viewer goes, or does not read.
    async fn listen(&self, mut asked: mpsc::Receiver<Heard>) {
        // Those that wait end with the viewer.
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
                // It does not read its answers.
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
        if let Err(refused) = self.shared.plant.check(Principal::Viewer(self.id), right(&request)) {
            return Some(Err(refused.into()));
        }
        let audited = audited(&request);
        let answer = self.answer(id, request, heard, simulations).await;
        if let Some((what, object)) = audited {
            let result = if matches!(answer, Some(Err(_))) {
                "refused"
            } else {
                "done"
            };
            let by = Principal::Viewer(self.id);
            self.shared.plant.record(by, what, object, result);
        }
        if moves && stopped() {
            // Its instruction may have been sent after the stop.
            self.shared.plant.stop_all();
        }
        answer
    }

    async fn answer(
        &self,
        id: &Value,
        request: Request,
        heard: &Heard,
        simulations: &mut JoinSet<()>,
    ) -> Option<Result<Answer, Refusal>> {
        let (shared, viewer) = (&self.shared, self.id);
        let answer = match request {
            Request::Preview(request) => {
                let text = request.text.clone();
                let work = async move |shared: Arc<Shared>| {
                    request.answer(shared.simulate(move |plant| drive::checked_call(plant, &text)).await)
                };
                return self.simulate(id, simulations, work);
            }
            Request::DryRun(request) => {
                let text = request.text.clone();
                let work = async move |shared: Arc<Shared>| {
                    request.answer(shared.simulate(move |plant| program::checked(plant, &text)).await)
                };
                return self.simulate(id, simulations, work);
            }
            Request::Ping(request) => request.answer(Ok(Done {})),
            Request::Active(request) => {
                if let Some(session) = &self.session {
                    shared.sessions.active(session);
                }
                request.answer(Ok(Done {}))
            }
            Request::Take(request) => request.answer(self.take(&request.object, request.force)),
            Request::Release(request) => request.answer(self.release(&request.object)),
            Request::Execute(request) => {
                let executed = drive::execute(&shared.plant, &shared.workers, viewer, &request.text);
                request.answer(executed.await)
            }
            Request::Line(request) => {
                self.computed(heard.is_long(), move |plant| {
                    request.answer(line::line(plant, &request.instruction, &request.operands))
                })
                .await
            }
            Request::Jog(request) => request.answer(self.jog(&request, heard).await),
            Request::Keep(request) => request.answer(shared.jogs.keep(&shared.plant, viewer, &request.axis)),
            Request::JogEnd(request) => request.answer(shared.jogs.end(&shared.plant, viewer, &request.axis).await),
            Request::Stop(request) => request.answer(shared.stop(viewer, request.object.as_deref()).await),
            Request::ReleaseStop(request) => {
                request.answer(shared.apply(Principal::Viewer(viewer), Command::Release).await)
            }
            Request::Override(request) => {
                let done = shared.set_override(viewer, &request.coordinate_system, request.percent);
                request.answer(done.await)
            }
            Request::Hold(request) => request.answer(shared.hold(viewer, &request.coordinate_system).await),
            Request::Resume(request) => request.answer(shared.resume(viewer, &request.coordinate_system).await),
            Request::Check(request) => {
                self.computed(heard.is_long(), move |plant| {
                    request.answer(Ok(program::check(plant, &request.text)))
                })
                .await
            }
            Request::Run(request) => request.answer(self.run(&request, heard).await),
            Request::Step(request) => request.answer(shared.program.step(&shared.plant, viewer)),
            Request::Pause(request) => request.answer(shared.program.pause(&shared.plant, viewer)),
            Request::Continue(request) => request.answer(shared.program.go_on(&shared.plant, viewer)),
            Request::End(request) => {
                shared.program.end();
                request.answer(Ok(Done {}))
            }
            Request::Tags(request) => {
                self.computed(true, move |plant| {
                    request.answer(tags::list(plant, &request.pattern, request.after.as_deref()))
                })
                .await
            }
            Request::Read(request) => {
                self.computed(tags::are_many(&shared.plant, &request.names), move |plant| {
                    request.answer(tags::values(plant, &request.names))
                })
                .await
            }
            Request::Watch(request) => {
                let names = request.names.clone();
                let values = self.computed(tags::are_many(&shared.plant, &names), move |plant| {
                    request.answer(tags::values(plant, &request.names))
                });
                match values.await {
                    Ok(values) => self.send(Outgoing::Watch(names)).map(|()| values),
                    refused => refused,
                }
            }
            Request::Write(request) => {
                let by = Principal::Viewer(viewer);
                request.answer(tags::write(&shared.plant, by, &request.tag, &request.value).await)
            }
            Request::Routines(request) => {
                self.computed(true, move |plant| request.answer(controller::routines(plant)))
                    .await
            }
            Request::Rungs(request) => {
                self.computed(true, move |plant| {
                    request.answer(controller::rungs(plant, request.routine, request.from, request.count))
                })
                .await
            }
            Request::Look(request) => {
                let (outbox, viewer) = (self.outbox.clone(), self.id);
                self.computed(true, move |plant| {
                    let looking = controller::look(plant, viewer, &request);
                    let sent = looking.and_then(|looking| {
                        let full = |_| Refusal::new("the page does not read the messages of the server");
                        outbox.try_send(Outgoing::Look(looking)).map_err(full)
                    });
                    request.answer(sent.map(|()| Done {}))
                })
                .await
            }
            Request::Uses(request) => {
                self.computed(true, move |plant| {
                    request.answer(controller::uses(plant, &request.tag, request.program.as_deref()))
                })
                .await
            }
            Request::Mode(request) => {
                let mode = if request.run { Mode::Run } else { Mode::Program };
                request.answer(shared.apply(Principal::Viewer(viewer), Command::SetMode(mode)).await)
            }
            Request::Force(request) => {
                let by = Principal::Viewer(viewer);
                let forced = controller::force(&shared.plant, by, &request.tag, &request.value).await;
                request.answer(forced.map(|()| Done {}))
            }
            Request::RemoveForces(request) => {
                let by = Principal::Viewer(viewer);
                request.answer(shared.apply(by, Command::RemoveForce(None)).await)
            }
            Request::Trace(request) => request.answer(self.trace(request.on)),
            Request::History(request) => request.answer(self.history(request.before)),
            Request::Events(request) => {
                self.computed(true, move |plant| {
                    request.answer(Ok(events::since(plant, request.since)))
                })
                .await
            }
        };
        Some(answer)
    }

    /// Begins a simulation, which is answered when it is done; a refusal if too many of this viewer wait.
    fn simulate<W>(
        &self,
        id: &Value,
        simulations: &mut JoinSet<()>,
        work: impl FnOnce(Arc<Shared>) -> W,
    ) -> Option<Result<Answer, Refusal>>
    where
        W: Future<Output = Result<Answer, Refusal>> + Send + 'static,
    {
        if simulations.len() >= SIMULATIONS {
            return Some(Err(Refusal::new(format!(
                "{SIMULATIONS} simulations wait already: let one of them end"
            ))));
        }
        let (id, outbox, work) = (id.clone(), self.outbox.clone(), work(self.shared.clone()));
        simulations.spawn(async move {
            let reply = protocol::reply(&id, work.await);
            // The viewer may just have gone, or read nothing.
            let _ = outbox.try_send(Outgoing::Text(reply.into()));
        });
        None
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

    fn take(&self, object: &str, force: bool) -> Result<Done, Refusal> {
        let object = self.object(object)?;
        let machine = self.shared.plant.machine();
        let taken = self.shared.plant.control().take(machine, self.id, object, force);
        taken.map_err(|held| Refusal::control(held.object.name(machine), Some(&held.by)))?;
        Ok(Done {})
    }

    fn release(&self, object: &str) -> Result<Done, Refusal> {
        self.shared.plant.control().release(self.id, self.object(object)?);
        Ok(Done {})
    }

    async fn jog(&self, request: &Jog, heard: &Heard) -> Result<Done, Refusal> {
        let index = usize::from(drive::axis_of(&self.shared.plant, &request.axis)?);
        let is_held = || {
            let releases = self.releases.get(index);
            let now = releases.map(|releases| releases.load(Ordering::Acquire));
            now == heard.releases.get(index).copied()
        };
        let shared = &self.shared;
        shared.jogs.begin(&shared.plant, self.id, request, is_held).await
    }

    async fn run(&self, request: &Run, heard: &Heard) -> Result<Done, Refusal> {
        let shared = &self.shared;
        let (text, plant) = (request.text.clone(), shared.plant.clone());
        let checked = shared
            .workers
            .compute_if(heard.is_long(), move || program::checked(&plant, &text));
        let program = checked.await??;
        shared.program.run(&shared.plant, self.id, program, request)
    }

    fn trace(&self, on: bool) -> Result<Signals, Refusal> {
        self.send(Outgoing::Samples(on))?;
        let machine = self.shared.plant.machine();
        Ok(Signals {
            signals: history::signals(machine),
            period_s: machine.period(),
        })
    }

    fn history(&self, before: u64) -> Result<HistoryPiece, Refusal> {
        let permit = self.pieces.clone().try_acquire_owned();
        let permit = permit.map_err(|_| Refusal::new("the page must read earlier frames of the history first"))?;
        let (frame, piece) = frames::history_before(&self.shared.plant, before);
        self.send(Outgoing::Piece(frame, permit))?;
        Ok(piece)
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
