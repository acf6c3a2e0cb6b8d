//! The asynchronous interface of the controller: tag memory that is refreshed on read, calls that are awaited, and the
//! newest executions by instance.
//!
//! One task drains the real-time thread's rings, faster while calls are outstanding; every read refreshes too, so
//! that it shows the newest tick, and of that tick positions and bits alike. The lock is held for microseconds and
//! never across an await; the real-time thread knows nothing of it.
//!
//! Reads wait for no lock: they see the tag memory as it was published when the lock was last released. The first read of a
//! tick refreshes it; a read during that refresh, or during a write, sees the memory before. [`Plant::view`] shows one tick, and
//! [`Plant::changes`] is the stream of the tags that change.

mod apply;
mod audited;
mod changes;
mod client;
mod command;
pub(crate) mod control;
mod counters;
mod forces;
mod io;
mod log;
mod looks;
mod monitors;
mod movers;
mod moves;
mod owned;
mod policy;
mod principal;
mod program;
mod records;
mod reload;
mod rights;
#[cfg(test)]
mod role_tests;
pub(crate) mod roles;
mod series;
mod state;
mod steps;
pub(crate) mod wall_clock;

use std::ops::{Deref, DerefMut};
use std::sync::atomic::{AtomicBool, AtomicI64, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError, TryLockError, Weak};
use std::time::{Duration, SystemTime};

use arc_swap::ArcSwap;
use arcline_config::{ConnectionLoss, Project, Role, ServerConfig};
use arcline_controller::Ticket;
use arcline_controller::image::{ControlError, Health, Image};
use arcline_controller::machine::Machine;
use arcline_instruction_set::predefined::motion_status;
use arcline_instruction_set::{AxisId, BindError, Ending, Mnemonic, MotionControl};
use arcline_realtime::{Clock, Handle, Meter, Options, ServerRings, SpawnError, Stepper, Stops};
use tokio::sync::Notify;

use crate::audit::{Audit, EventKind};
use crate::guard::{ClientInterface, Guard, Signs};
use crate::limits::LogLimit;
use crate::retained::ChangeTracker;
use crate::trace::Trace;
pub use apply::{Pending, Transaction};
use changes::ChangeLog;
pub use changes::{Changes, TagChanges};
pub use client::ClientIdentity;
pub use command::{Call, Command, Outcome, Refused, Systems};
use control::Control;
pub(crate) use counters::RequestKind;
pub use counters::{Counter, OutcomeCount};
use counters::{Counters, Requests};
pub use forces::{Force, ForceError};
pub use io::View;
pub use log::{Change, ContourRest, Logged, RestCause};
use looks::Looks;
pub use movers::{Mover, Movers};
pub use moves::{LiveMove, LiveMoves};
pub use owned::LossOutcome;
pub use principal::Principal;
pub(crate) use program::Program;
pub use program::{Mode, ProgramState, ProgramStatus};
pub(crate) use records::Executions;
use records::instance_of;
pub use reload::ReloadError;
pub(crate) use reload::machine_changes;
pub use rights::Right;
#[cfg(test)]
pub(crate) use rights::page as rights_page;
use roles::Roles;
pub use series::{LONGEST_SERIES, SeriesEnd, SeriesOutcome};
use state::{OUTSTANDING, Observers, Published, State, may_run};
use wall_clock::WallClock;

/// The running machine. Clones are the same one.
#[derive(Clone, Debug)]
pub struct Plant(Arc<Shared>);

/// An instruction that was executed.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Executed {
    /// Its instance of class 0x0303.
    pub instance: u32,
    /// The motion control tag at the instant that set DN or ER.
    pub control: MotionControl,
}

/// The end of an instruction that did not come to its end.
#[derive(Clone, PartialEq, Debug)]
pub struct Ended {
    /// The cause of the end.
    pub ending: Ending,
    /// When, seconds of machine time.
    pub time: f64,
    /// When, by the system's clock.
    pub at: SystemTime,
}

/// The reason for which an instruction was not executed. Motion errors are in [`Executed`] instead.
#[derive(Clone, PartialEq, Debug, thiserror::Error)]
pub enum CallRefused {
    /// Its operands do not fit.
    #[error(transparent)]
    Bind(#[from] BindError),
    /// The name cannot be its motion control tag, or no more such tags can be made.
    #[error(transparent)]
    Control(#[from] ControlError),
    /// The instruction cannot be part of a series.
    #[error("{mnemonic} with these operands cannot be one of a series: a series has lines and arcs that do not merge")]
    NotOfSeries {
        /// The instruction.
        mnemonic: Mnemonic,
    },
    /// Too many calls wait for the controller.
    #[error("{OUTSTANDING} calls wait for the controller already, try again")]
    Busy,
    /// The controller did not answer in time.
    #[error("the controller did not answer within {} s", ANSWER_WITHIN.as_secs())]
    NoAnswer,
}

#[derive(Debug)]
pub(crate) struct Shared {
    state: Mutex<State>,
    published: Published,
    meter: Arc<Meter>,
    machine: Machine,
    server: ServerConfig,
    trace: Trace,
    /// Lets ticks pass, on the step clock.
    stepper: Option<Stepper>,
    /// The turn of the client that steps the clock.
    step_turn: tokio::sync::Mutex<()>,
    /// Stops that wait for no lock and no command.
    stops: Stops,
    guard: Guard,
    /// The objects that viewers of the page have control of.
    control: Mutex<Control>,
    counters: Counters,
    requests: Requests,
    log_limit: LogLimit,
    /// The role of each client.
    roles: Roles,
    audit: OnceLock<Audit>,
    wall: WallClock,
    /// When the server's own certificate of TLS ends, Unix time in s; 0: there is none.
    certificate_ends: AtomicI64,
    /// The controller's own program, where it has one.
    program: OnceLock<Arc<Program>>,
    /// A command was sent: the pump looks sooner.
    sent: Notify,
}

impl Plant {
    /// Starts the machine of a project on its real-time thread, and the task that drains its rings.
    ///
    /// # Errors
    /// When the system has no thread left.
    ///
    /// # Panics
    /// Outside of a tokio runtime.
    pub fn start(project: &Project) -> Result<(Plant, Handle), SpawnError> {
        Plant::start_with(project, project.image(), None, Clock::Real)
    }

    /// As [`Plant::start`] with the tags of `image`; `watch` sees their changes.
    pub(crate) fn start_with(
        project: &Project,
        image: Image,
        watch: Option<ChangeTracker>,
        clock: Clock,
    ) -> Result<(Plant, Handle), SpawnError> {
        let options = Options {
            clock,
            ..Options::default()
        };
        let (link, handle) = arcline_realtime::spawn(&project.machine, options)?;
        let plant = Plant::with(project, link, image, watch);
        if let Err(error) = plant.trace().spawn() {
            tracing::warn!(%error, "no thread for traces: rows are kept only while a client reads them");
        }
        if let Err(error) = plant.guard().spawn(Arc::downgrade(&plant.0)) {
            tracing::error!(%error, "no thread for stops: jogs of lost clients stop late");
        }
        tokio::spawn(pump(Arc::downgrade(&plant.0), Looks::OnTime));
        Ok((plant, handle))
    }

    /// A plant on rings whose other ends the caller serves; the tasks beside it run on the caller's runtime, not on threads of their own.
    pub(crate) fn start_stepped(
        project: &Project,
        link: ServerRings,
        image: Image,
        watch: Option<ChangeTracker>,
        wall: WallClock,
    ) -> Plant {
        let plant = Plant::beside(project, link, image, watch, wall);
        let (guard, shared) = (plant.guard().clone(), Arc::downgrade(&plant.0));
        tokio::spawn(async move { guard.run(&shared).await });
        tokio::spawn(pump(Arc::downgrade(&plant.0), Looks::OnRuntime));
        plant
    }

    /// A plant on rings whose other ends the caller serves. Only reads drain them.
    pub fn new(project: &Project, link: ServerRings) -> Plant {
        Plant::with(project, link, project.image(), None)
    }

    pub(crate) fn with(project: &Project, link: ServerRings, image: Image, watch: Option<ChangeTracker>) -> Plant {
        Plant::beside(project, link, image, watch, WallClock::default())
    }

    fn beside(
        project: &Project,
        mut link: ServerRings,
        image: Image,
        watch: Option<ChangeTracker>,
        wall: WallClock,
    ) -> Plant {
        let published = Published {
            image: ArcSwap::from_pointee(image.clone()),
            snapshots: AtomicU64::new(0),
            movers: ArcSwap::default(),
            changes: ChangeLog::default(),
            foreign_changes: AtomicBool::new(false),
        };
        let meter = link.meter.clone();
        let trace = Trace::new(&project.machine, link.samples.take());
        let stops = link.stops.clone();
        let stepper = link.stepper.take();
        let guard = Guard::new(stops.clone(), &project.machine, project.server.jog_silence);
        let observers = Observers {
            watch,
            trace: trace.clone(),
            guard: guard.clone(),
            wall,
        };
        let state = State::new(&project.machine, image, link, observers);
        Plant(Arc::new(Shared {
            state: Mutex::new(state),
            published,
            meter,
            machine: project.machine.clone(),
            server: project.server.clone(),
            trace,
            stepper,
            step_turn: tokio::sync::Mutex::default(),
            stops,
            guard,
            control: Mutex::default(),
            counters: Counters::default(),
            requests: Requests::default(),
            log_limit: LogLimit::default(),
            roles: Roles::default(),
            audit: OnceLock::new(),
            wall,
            certificate_ends: AtomicI64::new(0),
            program: OnceLock::new(),
            sent: Notify::new(),
        }))
    }

    /// The plant, as long as there is another handle of it.
    pub(crate) fn upgrade(shared: &Weak<Shared>) -> Option<Plant> {
        shared.upgrade().map(Plant)
    }

    /// The clock on the wall.
    pub(crate) fn wall(&self) -> WallClock {
        self.0.wall
    }

    /// The machine as configured.
    pub fn machine(&self) -> &Machine {
        &self.0.machine
    }

    /// The network side as configured.
    pub fn server(&self) -> &ServerConfig {
        &self.0.server
    }

    /// The samples of every tick, and traces of them.
    pub fn trace(&self) -> &Trace {
        &self.0.trace
    }

    /// The guard of jogs, which stops those of clients that are lost.
    pub(crate) fn guard(&self) -> &Guard {
        &self.0.guard
    }

    /// Whether the machine is on the step clock.
    pub fn is_stepped(&self) -> bool {
        self.0.stepper.is_some()
    }

    /// The real-time thread's measurements.
    pub fn health(&self) -> Health {
        self.0.meter.health()
    }

    /// Reads tags, refreshed to the newest tick.
    pub fn with_image<R>(&self, read: impl FnOnce(&Image) -> R) -> R {
        let published = &self.0.published;
        if published.snapshots.load(Ordering::Acquire) != self.0.meter.snapshots()
            && let Some(mut state) = self.0.try_lock()
        {
            state.refresh();
        }
        read(&published.image.load())
    }

    /// Reads the published tags, for data that do not change: names, types, kinds.
    pub(crate) fn with_published<R>(&self, read: impl FnOnce(&Image) -> R) -> R {
        read(&self.0.published.image.load())
    }

    /// Sends the axes, after the real-time thread has stopped them, and the last results of instructions to the writer of the retained state.
    pub(crate) fn retain_at_the_end(&self) {
        let mut state = self.0.lock();
        state.refresh();
        // No client waits for the answer: before it ends, the writer writes all records that it was sent.
        drop(state.send_writes());
        let State { watch, link, .. } = &mut *state;
        if let Some(watch) = watch {
            watch.axes_at_the_end(link.snapshots.output_buffer());
        }
    }

    /// A principal is lost: the motion that it began and that still runs is stopped, held or goes on.
    pub fn lose(&self, lost: Principal, reaction: ConnectionLoss) -> LossOutcome {
        let command = Command::Lose { lost, reaction };
        // The stops are sent; this call does not wait until they are executed.
        match self
            .transact(Principal::Server, |transaction| transaction.apply(command))
            .0
        {
            Ok(Outcome::Lost(lost)) => lost,
            Ok(_) | Err(_) => LossOutcome::default(),
        }
    }

    /// A principal has closed its connection in order: its motion goes on without an owner.
    pub fn disown(&self, principal: Principal) {
        // It cannot be refused, and has no answer to wait for.
        drop(self.transact(Principal::Server, |transaction| {
            transaction.apply(Command::Disown(principal))
        }));
    }

    /// The objects that viewers of the page have control of.
    pub(crate) fn control(&self) -> MutexGuard<'_, Control> {
        self.0.control()
    }

    /// The limit of log lines that peers cause.
    pub(crate) fn log_limit(&self) -> &LogLimit {
        &self.0.log_limit
    }

    /// The role of each client.
    pub(crate) fn roles(&self) -> &Roles {
        &self.0.roles
    }

    /// A client has come in with a role; the guard knows it from now on.
    pub(crate) fn enter(
        &self,
        session: u64,
        identity: ClientIdentity,
        role: Role,
        interface: Weak<dyn ClientInterface>,
    ) -> Signs {
        self.0.roles.set(session, role);
        let signs = self.0.guard.enter(session, identity, interface);
        self.0.record_client(EventKind::Connect, session);
        signs
    }

    /// A client has gone.
    pub(crate) fn leave(&self, session: u64) {
        self.0.record_client(EventKind::Disconnect, session);
        self.0.guard.leave(session);
        self.0.roles.forget(session);
    }

    /// Checks that a principal has a right; a refusal is logged.
    ///
    /// # Errors
    /// [`Refused::Role`].
    pub(crate) fn check(&self, principal: Principal, right: Right) -> Result<(), Refused> {
        let role = self.0.roles.of(principal);
        if right.is_of(role) {
            return Ok(());
        }
        self.log_denied(principal, right, role);
        self.record(principal, EventKind::Denied, right.may().to_owned(), right.name());
        Err(Refused::Role { right, role })
    }

    fn log_denied(&self, principal: Principal, right: Right, role: Role) {
        let session = principal.session();
        let client = session
            .map(|session| self.0.guard.identity_of(session))
            .unwrap_or_default();
        let text = || {
            let (least, right) = (right.least().word(), right.name());
            format!("{principal} ({client}) is {} and needs {least} to {right}", role.word())
        };
        self.0.log_limit.warn("denied", client.ip, text);
    }

    /// The number of commands of a kind.
    pub fn count(&self, counter: Counter) -> OutcomeCount {
        self.0.counters.of(counter)
    }

    /// Counts a request of an EtherNet/IP client.
    pub(crate) fn count_request(&self, kind: RequestKind, is_done: bool) {
        self.0.requests.count(kind, is_done);
    }

    /// The number of requests of a kind from EtherNet/IP clients.
    pub(crate) fn requests(&self, kind: RequestKind) -> OutcomeCount {
        self.0.requests.of(kind)
    }

    /// Reads executions, but does not wait for the lock. The argument of `read` returns whether a jog of
    /// an axis runs, may yet run, or is being stopped.
    pub(crate) fn try_with_executions<R>(&self, read: impl FnOnce(&dyn Fn(AxisId, Ticket) -> bool) -> R) -> Option<R> {
        let mut state = self.0.try_lock()?;
        state.refresh();
        let State { records, link, .. } = &mut *state;
        let snapshot = link.snapshots.output_buffer();
        let runs = |axis: AxisId, ticket: Ticket| {
            let axis = snapshot.axes.get(usize::from(axis));
            let status = axis.map_or(0, |axis| axis.motion_status);
            // A stop ends the instruction, not the motion.
            let brakes = status & motion_status::STOPPING_STATUS != 0;
            brakes
                || match records.get(ticket) {
                    Some(control) => may_run(control),
                    // The execution was dropped when changes were lost: only the state of the axis is known.
                    None => status & motion_status::JOG_STATUS != 0,
                }
        };
        Some(read(&runs))
    }

    /// The certificate of the server ends then, Unix time in s.
    pub(crate) fn set_certificate_end(&self, seconds: i64) {
        self.0.certificate_ends.store(seconds, Ordering::Relaxed);
    }

    /// When the certificate of the server ends, Unix time in s; `None`: it has none.
    pub(crate) fn certificate_end(&self) -> Option<i64> {
        let ends = self.0.certificate_ends.load(Ordering::Relaxed);
        (ends != 0).then_some(ends)
    }

    /// The principals of a session that have begun motion.
    pub fn owners(&self, session: u64) -> Vec<Principal> {
        self.0.lock().owned.of_session(session)
    }

    /// An execution by its instance of class 0x0303; `None` when there never was one, or it has been dropped.
    pub fn instruction_instance(&self, instance: u32) -> Option<MotionControl> {
        let mut state = self.0.lock();
        state.refresh();
        state.records.by_instance(instance)
    }

    /// The cause that ended an execution before its end; `None` for all others.
    pub fn instruction_ending(&self, instance: u32) -> Option<Ended> {
        let mut state = self.0.lock();
        state.refresh();
        let ended = state.records.end_of(instance)?;
        Some(Ended {
            ending: state.image().ending(&self.0.machine, ended.cause)?,
            time: ended.tick as f64 * self.0.machine.period(),
            at: ended.at,
        })
    }

    /// The newest instance of class 0x0303; `None`: nothing has been executed.
    pub fn newest_instance(&self) -> Option<u32> {
        self.0.lock().records.newest().map(instance_of)
    }

    /// The number of instances in the records.
    pub fn instances(&self) -> usize {
        self.0.lock().records.count()
    }
}

impl Drop for Shared {
    fn drop(&mut self) {
        self.guard.close();
    }
}

impl Shared {
    fn lock(&self) -> Held<'_> {
        Held {
            state: self.state.lock().unwrap_or_else(PoisonError::into_inner),
            published: &self.published,
        }
    }

    /// Taken behind the lock of the state, never before it.
    fn control(&self) -> MutexGuard<'_, Control> {
        self.control.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// `None`: another thread has it.
    fn try_lock(&self) -> Option<Held<'_>> {
        let state = match self.state.try_lock() {
            Ok(state) => state,
            Err(TryLockError::Poisoned(error)) => error.into_inner(),
            Err(TryLockError::WouldBlock) => return None,
        };
        Some(Held {
            state,
            published: &self.published,
        })
    }
}

/// The lock. Changes are published before it is released.
struct Held<'p> {
    state: MutexGuard<'p, State>,
    published: &'p Published,
}

impl Deref for Held<'_> {
    type Target = State;

    fn deref(&self) -> &State {
        &self.state
    }
}

impl DerefMut for Held<'_> {
    fn deref_mut(&mut self) -> &mut State {
        &mut self.state
    }
}

impl Drop for Held<'_> {
    fn drop(&mut self) {
        self.state.publish(self.published);
    }
}

/// Drains the rings as long as there is a handle of the plant.
async fn pump(plant: Weak<Shared>, looks: Looks) {
    loop {
        let Some(plant) = plant.upgrade() else { return };
        let busy = {
            let mut state = plant.lock();
            state.refresh();
            state.flush();
            state.is_busy()
        };
        looks.pause(busy, plant.machine.period_ns, &plant.sent).await;
    }
}

/// Longest wait for DN, ER or IP.
pub const ANSWER_WITHIN: Duration = Duration::from_secs(5);

#[cfg(test)]
mod tests;
