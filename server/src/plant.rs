//! The asynchronous face of the controller: tag memory that is refreshed on read, calls that are awaited, and the
//! newest executions by instance.
//!
//! One task drains the real-time thread's rings, faster while calls are outstanding; every read refreshes too, so
//! that it shows the newest tick, and of that tick positions and bits alike. The lock is held for microseconds and
//! never across an await; the real-time thread knows nothing of it.
//!
//! Reads wait for no lock: they see the tag memory as it was published when the lock was last let go. The first read of a
//! tick refreshes it; one that comes while somebody else does that, or writes, sees the memory before.

mod io;
mod log;
mod moves;
mod owned;
mod records;
mod reload;
mod state;

use std::ops::{Deref, DerefMut};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, TryLockError, Weak};
use std::time::{Duration, SystemTime};

use arc_swap::ArcSwap;
use arcline_config::{ConnectionLoss, Project, ServerConfig};
use arcline_controller::image::{ControlError, Edge, Health, Image};
use arcline_controller::machine::Machine;
use arcline_controller::{Cause, Ticket, UNNAMED};
use arcline_instruction_set::predefined::motion_status;
use arcline_instruction_set::{BindError, Ending, Given, Mnemonic, MotionControl, bind};
use arcline_realtime::{Handle, Link, Meter, Options, SpawnError, Stops};
use tokio::sync::Notify;

use crate::guard::Guard;
use crate::retained::{NotKept, Watch, WhenKept};
use crate::trace::Trace;
pub use log::{Change, Logged};
pub use moves::{LiveMove, LiveMoves};
pub use owned::{Lost, Owner};
use records::instance_of;
pub use reload::ReloadError;
use state::{OUTSTANDING, Published, State, may_run};

/// The running machine. Clones are the same one.
#[derive(Clone, Debug)]
pub struct Plant(Arc<Shared>);

/// An instruction that was executed.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Executed {
    /// Its instance of class 0x0303.
    pub instance: u32,
    /// What its motion control tag showed when DN or ER was set.
    pub control: MotionControl,
}

/// The end of an instruction that did not come to its end.
#[derive(Clone, PartialEq, Debug)]
pub struct Ended {
    /// What ended it.
    pub ending: Ending,
    /// When, seconds of machine time.
    pub time: f64,
    /// When, by the system's clock.
    pub at: SystemTime,
}

/// What a write brought about, for [`Plant::fire`].
#[derive(Debug, Default)]
#[must_use = "what was written has no effect on the controller yet, and may not be kept"]
pub struct Written {
    /// What the controller is to know of, in order.
    edges: Vec<Edge>,
    /// Tells when it is kept; `None`: nothing of it is kept over a restart.
    kept: Option<WhenKept>,
}

/// Why an instruction was not executed. Motion errors are not here: they are in [`Executed`].
#[derive(Clone, PartialEq, Debug, thiserror::Error)]
pub enum CallRefused {
    /// Its operands do not fit.
    #[error(transparent)]
    Bind(#[from] BindError),
    /// The name cannot be its motion control tag, or no more such tags can be made.
    #[error(transparent)]
    Control(#[from] ControlError),
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
    /// Stops that no lock and no command is ahead of.
    stops: Stops,
    guard: Guard,
    /// Something was sent: the pump looks sooner.
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
        Plant::start_with(project, image_of(project), None)
    }

    /// The same with tags that hold something already, and with what sees their changes.
    pub(crate) fn start_with(
        project: &Project,
        image: Image,
        watch: Option<Watch>,
    ) -> Result<(Plant, Handle), SpawnError> {
        let (link, handle) = arcline_realtime::spawn(&project.machine, Options::default())?;
        let plant = Plant::with(project, link, image, watch);
        if let Err(error) = plant.trace().spawn() {
            tracing::warn!(%error, "no thread for traces: rows are kept only while a client reads them");
        }
        if let Err(error) = plant.guard().spawn(Arc::downgrade(&plant.0)) {
            tracing::error!(%error, "no thread for stops: jogs of lost clients stop late");
        }
        tokio::spawn(pump(Arc::downgrade(&plant.0)));
        Ok((plant, handle))
    }

    /// A plant on rings whose other ends somebody else serves. Nothing drains them but reads.
    pub fn new(project: &Project, link: Link) -> Plant {
        Plant::with(project, link, image_of(project), None)
    }

    fn with(project: &Project, mut link: Link, image: Image, watch: Option<Watch>) -> Plant {
        let published = Published {
            image: ArcSwap::from_pointee(image.clone()),
            snapshots: AtomicU64::new(0),
        };
        let meter = link.meter.clone();
        let trace = Trace::new(&project.machine, link.samples.take());
        let stops = link.stops.clone();
        let guard = Guard::new(stops.clone(), &project.machine, project.server.jog_silence);
        let period = Duration::from_nanos(project.machine.period_ns);
        let state = State::new(image, link, watch, trace.clone(), guard.clone(), period);
        Plant(Arc::new(Shared {
            state: Mutex::new(state),
            published,
            meter,
            machine: project.machine.clone(),
            server: project.server.clone(),
            trace,
            stops,
            guard,
            sent: Notify::new(),
        }))
    }

    /// The plant, as long as somebody else has it.
    pub(crate) fn upgrade(shared: &Weak<Shared>) -> Option<Plant> {
        shared.upgrade().map(Plant)
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

    /// Writes tags. What the closure gives as edges and what comes of the write besides is for [`Plant::fire`].
    pub fn write<R>(&self, write: impl FnOnce(&mut Image, &mut Vec<Edge>) -> R) -> (R, Written) {
        let mut state = self.0.lock();
        state.refresh();
        let room = state.room();
        state.image_mut().set_call_room(room);
        let mut edges = Vec::new();
        let result = write(state.image_mut(), &mut edges);
        // Sent under the lock: kept in the order in which it was written.
        let kept = state.keep();
        (result, Written { edges, kept })
    }

    /// Sends what writes brought about, and waits until it is kept. Executes the instruction tags whose `EnableIn` rose,
    /// with the operands they hold now, in order, and waits until each shows DN or ER, at most [`ANSWER_WITHIN`]. Those
    /// whose `EnableIn` fell have a false rung.
    ///
    /// # Errors
    /// [`NotKept`]: plain tags have what was written to them, but may not have it after a restart.
    pub async fn fire(&self, written: Written) -> Result<(), NotKept> {
        self.fire_for(None, written).await
    }

    /// The same for an owner, who has begun what comes of it.
    ///
    /// # Errors
    /// As [`Self::fire`].
    pub async fn fire_for(&self, owner: Option<Owner>, written: Written) -> Result<(), NotKept> {
        let Written { edges, kept } = written;
        self.execute(owner, edges).await;
        match kept {
            None => Ok(()),
            Some(kept) => match tokio::time::timeout(ANSWER_WITHIN, kept).await {
                Ok(Ok(kept)) => kept,
                Ok(Err(_)) | Err(_) => Err(NotKept),
            },
        }
    }

    async fn execute(&self, owner: Option<Owner>, edges: Vec<Edge>) {
        if edges.is_empty() {
            return;
        }
        let mut answers = Vec::new();
        {
            let mut state = self.0.lock();
            for edge in edges {
                answers.extend(state.edge(owner, edge));
            }
        }
        self.0.sent.notify_one();
        let all = async {
            for answer in answers {
                // The sender goes only with the plant.
                let _ = answer.await;
            }
        };
        if tokio::time::timeout(ANSWER_WITHIN, all).await.is_err() {
            tracing::warn!("the controller did not answer a written EnableIn in time");
        }
    }

    /// Sends the axes as they are after the real-time thread has stopped them, to be kept.
    pub(crate) fn keep_at_the_end(&self) {
        let mut state = self.0.lock();
        state.refresh();
        let State { watch, link, .. } = &mut *state;
        if let Some(watch) = watch {
            watch.axes_at_the_end(link.snapshots.output_buffer());
        }
    }

    /// Executes an instruction and waits until its tag shows DN, ER, or that it is in process (MAH, whose DN is its end).
    ///
    /// `given` are the operands behind target and motion control. A motion control tag that is not there is made.
    ///
    /// # Errors
    /// See [`CallRefused`]; nothing was executed then, but for [`CallRefused::NoAnswer`].
    pub async fn call(
        &self,
        mnemonic: Mnemonic,
        target: Option<u16>,
        control: Option<&str>,
        given: &[Given],
    ) -> Result<Executed, CallRefused> {
        self.call_with(None, mnemonic, target, control, given, |_| {}).await
    }

    /// The same for an owner, who has begun what comes of it.
    ///
    /// # Errors
    /// As [`Self::call`].
    pub async fn call_for(
        &self,
        owner: Owner,
        mnemonic: Mnemonic,
        target: Option<u16>,
        control: Option<&str>,
        given: &[Given],
    ) -> Result<Executed, CallRefused> {
        self.call_with(Some(owner), mnemonic, target, control, given, |_| {})
            .await
    }

    /// The same as [`Plant::call_for`]; `tell` is told its instance before anything has happened.
    ///
    /// # Errors
    /// As [`Plant::call`].
    pub(crate) async fn call_told(
        &self,
        owner: Owner,
        mnemonic: Mnemonic,
        target: Option<u16>,
        control: Option<&str>,
        given: &[Given],
        tell: impl FnOnce(u32),
    ) -> Result<Executed, CallRefused> {
        self.call_with(Some(owner), mnemonic, target, control, given, tell)
            .await
    }

    async fn call_with(
        &self,
        owner: Option<Owner>,
        mnemonic: Mnemonic,
        target: Option<u16>,
        control: Option<&str>,
        given: &[Given],
        tell: impl FnOnce(u32),
    ) -> Result<Executed, CallRefused> {
        let (ticket, answer) = {
            let mut state = self.0.lock();
            if !state.has_room(mnemonic) {
                return Err(CallRefused::Busy);
            }
            // Bound before the tag is made: what is refused leaves nothing behind.
            let mut call = bind(mnemonic, target, UNNAMED, given, state.image())?;
            if let Some(name) = control {
                call.control = state.image_mut().control_slot(name)?;
            }
            let (ticket, answer) = state.send_for(owner, call);
            tell(instance_of(ticket));
            (ticket, answer)
        };
        self.0.sent.notify_one();
        if tokio::time::timeout(ANSWER_WITHIN, answer).await.is_err() {
            self.0.lock().waiting.remove(&ticket);
            return Err(CallRefused::NoAnswer);
        }
        let instance = instance_of(ticket);
        let control = self.instruction_instance(instance).ok_or(CallRefused::NoAnswer)?;
        Ok(Executed { instance, control })
    }

    /// An owner is lost: what it began and what still runs of that is stopped, held or goes on.
    pub fn lose(&self, owner: Owner, reaction: ConnectionLoss) -> Lost {
        let lost = {
            let mut state = self.0.lock();
            state.refresh();
            state.lose(owner, reaction)
        };
        self.0.sent.notify_one();
        lost
    }

    /// Looks at executions, but does not wait for the lock. The first argument tells whether a jog of
    /// an axis runs, may come to, or is being stopped.
    pub(crate) fn try_with_executions<R>(&self, look: impl FnOnce(&dyn Fn(u16, Ticket) -> bool) -> R) -> Option<R> {
        let mut state = self.0.try_lock()?;
        state.refresh();
        let State { records, link, .. } = &mut *state;
        let snapshot = link.snapshots.output_buffer();
        let runs = |axis: u16, ticket: Ticket| {
            let axis = snapshot.axes.get(usize::from(axis));
            let status = axis.map_or(0, |axis| axis.motion_status);
            // A stop ends the instruction, not the motion.
            let brakes = status & motion_status::STOPPING_STATUS != 0;
            brakes
                || match records.get(ticket) {
                    Some(control) => may_run(control),
                    // Of old executions only the axis tells.
                    None => status & motion_status::JOG_STATUS != 0,
                }
        };
        Some(look(&runs))
    }

    /// An owner has closed its connection in order: what it began goes on as if nobody had.
    pub fn release(&self, owner: Owner) {
        self.0.guard.forget(owner);
        self.0.lock().owned.forget(owner);
    }

    /// Who has begun something in a session.
    pub fn owners(&self, session: u64) -> Vec<Owner> {
        self.0.lock().owned.of_session(session)
    }

    /// An execution by its instance of class 0x0303; `None` when there never was one, or it has been dropped.
    pub fn instruction_instance(&self, instance: u32) -> Option<MotionControl> {
        let mut state = self.0.lock();
        state.refresh();
        state.records.by_instance(instance)
    }

    /// Why an execution ended that did not come to its end; `None` for all others.
    pub fn instruction_ending(&self, instance: u32) -> Option<Ended> {
        let mut state = self.0.lock();
        state.refresh();
        let ended = state.records.end_of(instance)?;
        Some(Ended {
            ending: ending(&self.0.machine, state.image(), ended.cause)?,
            time: ended.tick as f64 * self.0.machine.period(),
            at: ended.at,
        })
    }

    /// The newest instance of class 0x0303; `None`: nothing has been executed.
    pub fn newest_instance(&self) -> Option<u32> {
        self.0.lock().records.newest().map(instance_of)
    }

    /// The oldest instance that is kept.
    pub fn oldest_instance(&self) -> Option<u32> {
        self.0.lock().records.oldest().map(instance_of)
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

    /// `None`: somebody has it.
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

/// The lock. What has changed is published before it is let go.
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

/// Drains the rings as long as somebody has the plant.
async fn pump(plant: Weak<Shared>) {
    loop {
        let Some(plant) = plant.upgrade() else { return };
        let busy = {
            let mut state = plant.lock();
            state.refresh();
            state.flush();
            state.is_busy()
        };
        let sent = plant.sent.notified();
        let pause = if busy { PAUSE_BUSY } else { PAUSE_IDLE };
        // A command does not wait for the end of an idle pause.
        let _ = tokio::time::timeout(pause, sent).await;
    }
}

/// A cause with its names; `None` where there is none.
pub(crate) fn ending(machine: &Machine, image: &Image, cause: Cause) -> Option<Ending> {
    Some(match cause {
        Cause::Itself => return None,
        Cause::Instruction { control, mnemonic, .. } => Ending::Instruction {
            mnemonic,
            tag: image.control_name(control).to_owned(),
        },
        Cause::Fault { axis, faults } => Ending::Fault {
            axis: machine.axes.get(usize::from(axis))?.name.clone(),
            faults,
        },
        Cause::StopAll => Ending::StopAll,
        Cause::Jog(why) => Ending::Jog(why),
    })
}

/// The tags of a project.
pub fn image_of(project: &Project) -> Image {
    let mut image = Image::new(&project.machine, &project.instruction_tags, &project.tags);
    image.declare(&project.types);
    image
}

/// Longest wait for DN, ER or IP.
pub const ANSWER_WITHIN: Duration = Duration::from_secs(5);
const PAUSE_BUSY: Duration = Duration::from_millis(1);
const PAUSE_IDLE: Duration = Duration::from_millis(10);

#[cfg(test)]
mod tests;
