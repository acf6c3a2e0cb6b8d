//! A program on a simulation: it runs within a tick until it has to wait, and continues in a later tick in which it has work.
//!
//! A program is a future that waits only in its pauses. It owns its interpreter and shares the simulation with the
//! [`Runner`](crate::Runner), which executes the ticks, decides the end of the pause, and then polls the program.

use std::collections::BTreeMap;
use std::fmt;
use std::future::poll_fn;
use std::pin::Pin;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::task::{Context, Poll, Waker};

use arcline_controller::image::TagKind;
use arcline_controller::{Ticket, UNNAMED};
use arcline_instruction_set::{Call, ControlSlot, Directory as _, Flag, MotionControl, Object, bind};
use arcline_structured_text::{
    Called, Calls, Driver, EvaluatedCall, ObjectAttribute, OnError, Outcome, Pause, Policy, ProgramRun, Progress,
    Reading, RunError, Stopped, unmade_control,
};
use arcline_tag::{TagPath, Value};

use crate::calls::Origin;
use crate::end::{Refused, STILL_SECONDS};
use crate::simulation::Simulation;

/// Identifies a program of a [`Runner`](crate::Runner).
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub struct ProgramId(pub(crate) u32);

/// A simulation and the pauses of its programs.
#[derive(Debug)]
pub(crate) struct SimulationWithWaits {
    pub(crate) simulation: Simulation,
    pub(crate) waits: BTreeMap<ProgramId, Wait>,
}

/// A [`SimulationWithWaits`] that the runner and the programs share. Only one of them works at a time, so the lock is always free.
#[derive(Clone, Debug)]
pub(crate) struct SharedSimulation(Arc<Mutex<SimulationWithWaits>>);

impl SharedSimulation {
    pub(crate) fn new(simulation: Simulation) -> Self {
        SharedSimulation(Arc::new(Mutex::new(SimulationWithWaits {
            simulation,
            waits: BTreeMap::new(),
        })))
    }

    pub(crate) fn lock(&self) -> MutexGuard<'_, SimulationWithWaits> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// The pause of a program, and its actions since the last tick.
#[derive(Debug)]
pub(crate) struct Wait {
    policy: Policy,
    wake: Wake,
    /// The pause is over.
    over: Option<Result<(), Refused>>,
    /// The slots that the WAIT has read so far, with their status.
    watched: Vec<(ControlSlot, MotionControl)>,
    /// The WAIT has read another value, which may change in any tick.
    reads_motion: bool,
    /// The first tick since which the program has waited for a condition with the machine at rest.
    still_since: Option<u64>,
}

/// The condition for a program to continue.
#[derive(Debug)]
enum Wake {
    /// In the next tick.
    Next,
    /// In the next tick, in which the condition of a WAIT may have changed.
    Condition,
    /// A change of a motion control tag that it has read.
    Change,
    /// Room for the move.
    Room(Box<Call>),
    /// The tick has come.
    At(u64),
}

impl Wait {
    pub(crate) fn new(policy: Policy) -> Self {
        Wait {
            policy,
            wake: Wake::Next,
            over: None,
            watched: Vec::new(),
            reads_motion: false,
            still_since: None,
        }
    }

    /// Ends the pause.
    pub(crate) fn end(&mut self, result: Result<(), Refused>) {
        self.over = Some(result);
    }

    /// The program may have work in this tick.
    pub(crate) fn is_due(&self, simulation: &Simulation) -> bool {
        let controller = simulation.controller();
        match &self.wake {
            Wake::Next | Wake::Condition => true,
            Wake::Change => self
                .watched
                .iter()
                .any(|(slot, shown)| controller.control(*slot) != *shown),
            Wake::Room(call) => controller.has_room(call),
            Wake::At(tick) => simulation.tick() >= *tick,
        }
    }

    /// The number of uneventful ticks that the program need not see: it has no work before the tick after them.
    pub(crate) fn idle_ticks(&self, simulation: &Simulation) -> u64 {
        match &self.wake {
            Wake::Next | Wake::Condition => 0,
            // A WAIT ends if the machine stands for long.
            Wake::Change if simulation.controller().is_still() => 0,
            Wake::Change | Wake::Room(_) => u64::MAX,
            Wake::At(tick) => tick.saturating_sub(simulation.tick() + 1),
        }
    }

    /// The error that ends the program.
    pub(crate) fn error(&self, program: ProgramId, simulation: &Simulation) -> Option<Refused> {
        let erred = simulation.calls().erred(program)?;
        (self.policy.on_error == OnError::Stop).then_some(Refused::Erred { err: erred.err })
    }

    /// The pause is a WAIT during which the machine has been at rest for [`STILL_SECONDS`].
    pub(crate) fn is_vain(&mut self, simulation: &Simulation) -> bool {
        if !matches!(self.wake, Wake::Change | Wake::Condition) {
            return false;
        }
        if !simulation.controller().is_still() {
            self.still_since = None;
            return false;
        }
        let tick = simulation.tick();
        let since = *self.still_since.get_or_insert(tick);
        let still_ns = u128::from(tick - since) * u128::from(simulation.machine().period_ns);
        still_ns >= u128::from(STILL_SECONDS) * 1_000_000_000
    }
}

impl SimulationWithWaits {
    /// Records an execution: a machine at rest may move again.
    fn note_execution(&mut self) {
        for wait in self.waits.values_mut() {
            wait.still_since = None;
        }
    }
}

/// The end of a program, and the part of it that can continue with the next piece.
pub(crate) type Ended = (ProgramRun<Ticket>, Result<(), RunError<Refused>>);

/// A program under way.
pub(crate) struct Task(Pin<Box<dyn Future<Output = Ended> + Send>>);

impl fmt::Debug for Task {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Task")
    }
}

impl Task {
    /// A program before its next statement. The shared simulation has its [`Wait`].
    pub(crate) fn new(shared: SharedSimulation, id: ProgramId, mut run: ProgramRun<Ticket>) -> Self {
        Task(Box::pin(async move {
            let mut driver = ProgramDriver { shared, id, line: 1 };
            let end = run.run(&mut driver).await;
            (run, end)
        }))
    }

    /// Runs the program until it waits. `None`: it waits.
    pub(crate) fn poll(&mut self) -> Option<Ended> {
        match self.0.as_mut().poll(&mut Context::from_waker(Waker::noop())) {
            Poll::Ready(ended) => Some(ended),
            Poll::Pending => None,
        }
    }
}

/// The access of the program to the simulation.
struct ProgramDriver {
    shared: SharedSimulation,
    id: ProgramId,
    /// Line of the statement in execution.
    line: usize,
}

impl ProgramDriver {
    fn origin(&self) -> Origin {
        Origin {
            program: Some(self.id),
            line: self.line,
        }
    }

    /// Calls `work` with the simulation.
    fn with<R>(&self, work: impl FnOnce(&mut Simulation) -> R) -> R {
        work(&mut self.shared.lock().simulation)
    }

    /// Calls `work` with the simulation and the pause of this program.
    fn with_wait<R>(&self, work: impl FnOnce(&mut Simulation, &mut Wait) -> R) -> R {
        let mut shared = self.shared.lock();
        let SimulationWithWaits { simulation, waits } = &mut *shared;
        let wait = waits.entry(self.id).or_insert_with(|| Wait::new(Policy::default()));
        work(simulation, wait)
    }

    /// Writes to the tags, unless the write is refused or an instruction has erred.
    fn change(
        &self,
        write: impl FnOnce(&mut Simulation) -> Result<Option<arcline_controller::image::WriteEffect>, Refused>,
    ) -> Result<(), Refused> {
        let mut shared = self.shared.lock();
        let effect = write(&mut shared.simulation)?;
        if let Some(effect) = effect
            && shared.simulation.apply(effect, self.origin())?.is_some()
        {
            shared.note_execution();
        }
        let SimulationWithWaits { simulation, waits } = &*shared;
        match waits.get(&self.id).and_then(|wait| wait.error(self.id, simulation)) {
            Some(error) => Err(error),
            None => Ok(()),
        }
    }
}

/// Reads a tag: a motion control in its present state in the controller, all other tags from the image.
///
/// Only programs execute instructions here: an instruction that has ended, or never began, stays so during a WAIT.
fn read(simulation: &mut Simulation, wait: &mut Wait, path: &TagPath) -> Result<Reading, Refused> {
    let mut settled = false;
    let kind = path
        .tag()
        .and_then(|name| simulation.image().find(name))
        .map(|tag| tag.kind);
    let mut watch = |simulation: &mut Simulation, slot: ControlSlot| {
        let control = simulation.show_control(slot);
        wait.watched.push((slot, control));
        control.has_ended() || control == MotionControl::default()
    };
    match kind {
        Some(TagKind::MotionControl(slot)) => settled = watch(simulation, slot),
        Some(TagKind::Instruction(kind)) => settled = watch(simulation, kind.control),
        Some(TagKind::Plain) => {
            simulation.image_mut().show_uses();
            // Output cams, other programs, and the caller between two ticks can write it.
            wait.reads_motion = true;
        }
        Some(TagKind::FeedOverride | TagKind::FaultInject | TagKind::MotionInhibit) => wait.reads_motion = true,
        Some(_) => {
            wait.reads_motion = true;
            simulation.show();
        }
        // A motion control tag that the program adds later.
        None => {
            if let Some(value) = unmade_control(path) {
                return Ok(Reading::Settled(value));
            }
        }
    }
    let value = simulation.image().read(path)?;
    Ok(if settled {
        Reading::Settled(value)
    } else {
        Reading::Value(value)
    })
}

fn bound(simulation: &mut Simulation, call: &EvaluatedCall) -> Result<Call, Refused> {
    let image = simulation.image_mut();
    let target = image.object(call.mnemonic.instruction().object, &call.target);
    let control = match &call.control {
        Some(name) => image.control_slot(name)?,
        None => UNNAMED,
    };
    Ok(bind(call.mnemonic, target, control, &call.operands, image)?)
}

impl Driver for ProgramDriver {
    type Error = Refused;
    type Execution = Ticket;

    // Events report errors.
    const MOST_READS: usize = 0;

    async fn turn(&mut self, line: usize) -> Result<(), Refused> {
        self.line = line;
        Ok(())
    }

    async fn read(&mut self, path: &TagPath, _calls: &Calls<Ticket>) -> Result<Reading, Refused> {
        self.with_wait(|simulation, wait| read(simulation, wait, path))
    }

    async fn read_array(&mut self, path: &TagPath) -> Result<Vec<f64>, Refused> {
        self.with(|simulation| {
            simulation.show();
            Ok(simulation.image().read_numbers(path)?)
        })
    }

    async fn write(&mut self, path: &TagPath, value: Value) -> Result<(), Refused> {
        self.change(|simulation| Ok(simulation.image_mut().write_value(path, value)?))
    }

    async fn attribute(&mut self, of: &ObjectAttribute) -> Result<f64, Refused> {
        self.with(|simulation| {
            let (image, machine) = (simulation.image(), simulation.machine());
            let index = image.object(of.attribute.object, &of.name);
            let value = index.and_then(|index| image.attribute(machine, of.attribute, index));
            value.ok_or_else(|| no_object(of))
        })
    }

    async fn set_attribute(&mut self, of: &ObjectAttribute, value: f64) -> Result<(), Refused> {
        self.change(|simulation| {
            let image = simulation.image_mut();
            let index = image.object(of.attribute.object, &of.name);
            let index = index.ok_or_else(|| no_object(of))?;
            Ok(Some(image.set_attribute(of.attribute, index, value)?))
        })
    }

    async fn has_room(&mut self, call: &EvaluatedCall) -> Result<bool, Refused> {
        self.with(|simulation| {
            let system = simulation.image().object(Object::CoordinateSystem, &call.target);
            if simulation.controller().has_place(system) {
                return Ok(true);
            }
            // One that merges needs none.
            let call = bound(simulation, call)?;
            Ok(simulation.controller().has_room(&call))
        })
    }

    async fn call(&mut self, request: &EvaluatedCall) -> Result<Ticket, Refused> {
        let mut shared = self.shared.lock();
        let simulation = &mut shared.simulation;
        let call = bound(simulation, request)?;
        let (ticket, control) = simulation.execute(&call, self.origin());
        let erred = simulation.calls_mut().erred_mut(self.id);
        if let Some(erred) = erred.filter(|erred| erred.line == request.line) {
            let instruction = request.mnemonic.instruction();
            erred.left_out = instruction.left_out(erred.err, erred.exerr, &request.operands);
        }
        shared.note_execution();
        if control.has(Flag::Er) {
            return Err(Refused::Erred { err: control.err });
        }
        Ok(ticket)
    }

    async fn pause(&mut self, pause: Pause<'_>) -> Result<(), Refused> {
        self.with_wait(|simulation, wait| {
            if pause != Pause::Condition {
                wait.still_since = None;
            }
            wait.wake = match pause {
                Pause::Condition if !wait.reads_motion => Wake::Change,
                Pause::Condition => Wake::Condition,
                Pause::Tick | Pause::Queue { .. } | Pause::Motion => Wake::Next,
                Pause::Room(call) => Wake::Room(Box::new(bound(simulation, call)?)),
                Pause::Seconds(seconds) => {
                    let nanoseconds = (seconds * 1e9).round() as u64;
                    let ticks = nanoseconds.div_ceil(simulation.machine().period_ns).max(1);
                    Wake::At(simulation.tick().saturating_add(ticks))
                }
            };
            wait.over = None;
            Ok::<(), Refused>(())
        })?;
        poll_fn(|_| {
            let over = self.with_wait(|_, wait| wait.over.take());
            over.map_or(Poll::Pending, Poll::Ready)
        })
        .await?;
        self.with_wait(|_, wait| {
            wait.watched.clear();
            wait.reads_motion = false;
        });
        Ok(())
    }

    async fn progress(&mut self, _called: &Called<Ticket>) -> Result<Progress<Refused>, Refused> {
        Ok(Progress::Ended)
    }

    async fn stopped(&mut self, _called: &Called<Ticket>) -> Result<Option<Stopped<Refused>>, Refused> {
        Ok(None)
    }

    async fn outcome(&mut self, tag: &str, _called: Option<&Called<Ticket>>) -> Result<Outcome, Refused> {
        Ok(self.with(|simulation| simulation.outcome(tag)))
    }

    fn err(error: &Refused) -> Option<i16> {
        match error {
            Refused::Erred { err } => Some(*err),
            _ => None,
        }
    }
}

fn no_object(of: &ObjectAttribute) -> Refused {
    Refused::NoObject { name: of.name.clone() }
}
