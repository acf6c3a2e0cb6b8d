//! The one program that viewers may run: it goes on from statement to statement as a client's would, on a thread of its own,
//! with the rights of the viewer who started it.

use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use arcline_controller::image::{Image, TagKind};
use arcline_instruction_set::predefined::coordinate_motion_status;
use arcline_instruction_set::{Mnemonic, MotionControl};
use arcline_structured_text::{
    Called, Calls, Driver, EvaluatedCall, Interpreter, Moves, MovesEnd, ObjectAttribute, Outcome, Pause, Policy,
    Program, ProgramRun, Progress, Reading, RunError, Stopped, is_status, pause_of_queue,
};
use arcline_tag::{TagPath, Value};

use super::drive::{self, Accepted, attribute, read_numbers, read_value, set_attribute};
use super::protocol::{self, Checked, Done, ProgramState as State, ProgramStatus, Push, Refusal, text_of};
use super::tags;
use crate::plant::control::ViewerId;
use crate::plant::{LONGEST_SERIES, Plant, Principal, SeriesEnd, SeriesOutcome};
use crate::watch;
use crate::work_threads::WorkThreads;
use arcline_simulation::ImageNames;

/// Time between two checks of motion that must end.
const POLL: Duration = Duration::from_millis(5);
/// Shortest pause of a program that waits.
const LEAST_TICK: Duration = Duration::from_millis(1);

/// The program, and where its viewers see it.
#[derive(Debug)]
pub(super) struct Programs {
    shown: watch::Sender<Shown>,
    mode: Mutex<Option<Running>>,
    threads: WorkThreads,
}

#[derive(Debug)]
struct Running {
    viewer: ViewerId,
    mode: watch::Sender<Mode>,
}

/// The mode of a running program.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Mode {
    Run,
    Pause,
    Step,
    End,
}

/// The state of the program that viewers see.
#[derive(Clone, Debug)]
pub(super) struct Shown {
    state: State,
    /// The statement that runs, or comes next.
    line: Option<usize>,
    viewer: Option<String>,
    error: Option<Refusal>,
    /// Another number for every program.
    run: u64,
    text: Arc<str>,
}

/// The reason for the end of a program.
enum Break {
    /// A client ended it.
    Ended,
    Failed(Refusal),
}

impl From<Refusal> for Break {
    fn from(refusal: Refusal) -> Self {
        Self::Failed(refusal)
    }
}

impl From<RunError<Break>> for Break {
    fn from(error: RunError<Break>) -> Self {
        match error {
            RunError::Runtime(error) => Refusal::new(error.problem.to_string()).at(error.line).into(),
            RunError::Hopeless(hopeless) => Refusal::new(hopeless.problem()).at(hopeless.line).into(),
            RunError::Driver { line, error } => match error {
                Break::Failed(refusal) => refusal.at(line).into(),
                Break::Ended => Break::Ended,
            },
        }
    }
}

impl Shown {
    /// The push; with the program's text for a viewer that has seen another program last.
    pub(super) fn push(&self, last: &mut Option<u64>) -> String {
        let is_new = last.replace(self.run) != Some(self.run);
        text_of(&Push::Program(ProgramStatus {
            state: self.state,
            line: self.line,
            viewer: self.viewer.as_deref(),
            error: self.error.as_ref(),
            run: self.run,
            text: is_new.then_some(&*self.text),
        }))
    }
}

impl Programs {
    /// No program has run yet; programs will run on `threads`.
    pub(super) fn new(threads: WorkThreads) -> Self {
        Self {
            shown: watch::Sender::new(Shown {
                state: State::Idle,
                line: None,
                viewer: None,
                error: None,
                run: 0,
                text: Arc::default(),
            }),
            mode: Mutex::default(),
            threads,
        }
    }

    pub(super) fn watch(&self) -> watch::Receiver<Shown> {
        let mut watch = self.shown.subscribe();
        watch.mark_changed();
        watch
    }

    /// No further statement is executed.
    pub(super) fn end(&self) {
        // Without a program there is none to end.
        if let Some(running) = &*self.running() {
            running.mode.send_replace(Mode::End);
        }
    }

    /// Ends the program of a viewer that goes.
    pub(super) fn end_of(&self, viewer: ViewerId) {
        let own = self.running().as_ref().is_some_and(|running| running.viewer == viewer);
        if own {
            self.end();
        }
    }

    /// Steps and continues only for the viewer that started the program: they move the machine with the rights of that viewer.
    fn set(&self, plant: &Plant, viewer: ViewerId, mode: Mode) -> Result<Done, Refusal> {
        match &*self.running() {
            Some(running) if running.viewer != viewer && matches!(mode, Mode::Run | Mode::Step) => {
                let by = plant.control().name(running.viewer).to_owned();
                let text =
                    format!("the program is that of {by}, who alone steps and continues it; every viewer can end it");
                Err(Refusal::new(text))
            }
            Some(running) => {
                running.mode.send_replace(mode);
                Ok(Done {})
            }
            None => Err(Refusal::new("no program runs")),
        }
    }

    fn running(&self) -> std::sync::MutexGuard<'_, Option<Running>> {
        self.mode.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn show(&self, state: State, line: Option<usize>) {
        self.shown.send_if_modified(|shown| {
            let changed = (shown.state, shown.line) != (state, line);
            (shown.state, shown.line) = (state, line);
            changed
        });
    }
}

/// Checks a program and lists its errors.
pub(super) fn check(plant: &Plant, text: &str) -> Checked {
    let errors: Vec<Refusal> = checked(plant, text).err().into_iter().collect();
    Checked { errors }
}

/// A program that can run.
pub(super) fn checked(plant: &Plant, text: &str) -> Result<Program, Refusal> {
    let mut program = Program::parse(text).map_err(|error| Refusal::syntax(&error))?;
    plant
        .with_image(|image| program.check(&ImageNames(image)))
        .map_err(|error| Refusal::syntax(&error))?;
    Ok(program)
}

impl Programs {
    /// Starts a program that was read from a text.
    pub(super) fn run(
        self: &Arc<Self>,
        plant: &Plant,
        viewer: ViewerId,
        program: Program,
        request: &protocol::Run,
    ) -> Result<Done, Refusal> {
        let first = if request.step { Mode::Pause } else { Mode::Run };
        let mode = {
            let mut running = self.running();
            if let Some(other) = &*running {
                let by = plant.control().name(other.viewer).to_owned();
                return Err(Refusal::new(format!("a program of {by} runs already: end it first")));
            }
            let (sender, mode) = watch::channel(first);
            *running = Some(Running { viewer, mode: sender });
            mode
        };
        let name = plant.control().name(viewer).to_owned();
        self.shown.send_modify(|shown| {
            *shown = Shown {
                state: State::Running,
                line: None,
                viewer: Some(name),
                error: None,
                run: shown.run + 1,
                text: request.text.as_str().into(),
            };
        });
        let (programs, plant) = (self.clone(), plant.clone());
        // A thread of its own: a program that computes without end delays no other work.
        self.threads.run(async move {
            let mut live = Live {
                programs: &programs,
                plant: &plant,
                viewer,
                mode,
                granted: None,
                line: 1,
            };
            let mut run = ProgramRun::new(Interpreter::new(program), Policy::default());
            let end = match run.run(&mut live).await {
                Ok(()) => run.finish(&mut live).await,
                failed => failed,
            };
            let end = end.map_err(Break::from);
            *programs.running() = None;
            programs.shown.send_modify(|shown| match end {
                Ok(()) | Err(Break::Ended) => shown.state = State::Ended,
                Err(Break::Failed(error)) => {
                    shown.state = State::Failed;
                    shown.line = error.line.map(|line| line as usize).or(shown.line);
                    shown.error = Some(error);
                }
            });
        });
        Ok(Done {})
    }

    pub(super) fn step(&self, plant: &Plant, viewer: ViewerId) -> Result<Done, Refusal> {
        self.set(plant, viewer, Mode::Step)
    }

    pub(super) fn pause(&self, plant: &Plant, viewer: ViewerId) -> Result<Done, Refusal> {
        self.set(plant, viewer, Mode::Pause)
    }

    pub(super) fn go_on(&self, plant: &Plant, viewer: ViewerId) -> Result<Done, Refusal> {
        self.set(plant, viewer, Mode::Run)
    }
}

/// The machine on which a program runs.
struct Live<'s> {
    programs: &'s Programs,
    plant: &'s Plant,
    viewer: ViewerId,
    mode: watch::Receiver<Mode>,
    /// The line that may run while it is paused.
    granted: Option<usize>,
    /// Line of the statement that runs.
    line: usize,
}

impl Driver for Live<'_> {
    type Error = Break;
    type Execution = Accepted;

    const MOST_READS: usize = usize::MAX;

    /// Waits until the statement of a line may run.
    async fn turn(&mut self, line: usize) -> Result<(), Break> {
        self.line = line;
        loop {
            let mode = *self.mode.borrow_and_update();
            match mode {
                Mode::End => return Err(Break::Ended),
                Mode::Run => {
                    self.granted = None;
                    break;
                }
                Mode::Pause if self.granted == Some(line) => break,
                Mode::Pause => {
                    self.programs.show(State::Paused, Some(line));
                    self.mode.changed().await.map_err(|_| Break::Ended)?;
                }
                Mode::Step => {
                    self.granted = Some(line);
                    self.stepped();
                    break;
                }
            }
        }
        self.programs.show(State::Running, Some(line));
        Ok(())
    }

    fn try_turn(&mut self, line: usize) -> bool {
        if *self.mode.borrow_and_update() != Mode::Run {
            return false;
        }
        self.line = line;
        self.programs.show(State::Running, Some(line));
        true
    }

    /// Each statement by itself while it is paused.
    fn longest_series(&self) -> usize {
        match *self.mode.borrow() {
            Mode::Run => LONGEST_SERIES,
            Mode::Pause | Mode::Step | Mode::End => 1,
        }
    }

    async fn moves(&mut self, series: &[EvaluatedCall]) -> Result<Moves<Accepted, Break>, Break> {
        let principal = |call: &EvaluatedCall| self.principal_of(call.line);
        let calls: Vec<_> = series
            .iter()
            .map(|call| (principal(call), drive::command_of(self.plant, call, None)))
            .collect();
        let SeriesOutcome { executed, end } = self.plant.execute_series(&calls).await;
        let accepted = executed.iter().zip(series).map(|(executed, call)| Accepted {
            mnemonic: call.mnemonic,
            instance: executed.instance,
        });
        let executed: Vec<Accepted> = accepted.collect();
        let next = series.get(executed.len()).map(|call| call.mnemonic);
        let end = match (end, next) {
            (SeriesEnd::Erred(control), Some(mnemonic)) => {
                MovesEnd::Failed(Refusal::motion(control.err, control.exerr, mnemonic).into())
            }
            (SeriesEnd::Refused(refused), Some(mnemonic)) => MovesEnd::Failed(drive::refusal(refused, mnemonic).into()),
            (SeriesEnd::NoRoom { system }, _) => {
                let depth = self
                    .plant
                    .machine()
                    .systems
                    .get(usize::from(system))
                    .map_or(0, |system| system.queue_depth);
                MovesEnd::NoRoom {
                    depth: u32::try_from(depth).unwrap_or(u32::MAX),
                }
            }
            (_, _) => MovesEnd::Sent,
        };
        Ok(Moves { executed, end })
    }

    /// The value of a tag; of a motion control tag that the program has used, whether it can still change.
    async fn read(&mut self, path: &TagPath, calls: &Calls<Accepted>) -> Result<Reading, Break> {
        if let Some(called) = path.tag().and_then(|tag| calls.newest(tag)) {
            let read = self.plant.with_image(|image| {
                let control = control_of(image, &called.tag)?;
                Some((control.has_ended() && is_status(path), image.read(path).ok()?))
            });
            if let Some((true, value)) = read {
                return Ok(Reading::Settled(value));
            }
        }
        Ok(Reading::Value(read_value(self.plant, path)?))
    }

    async fn read_array(&mut self, path: &TagPath) -> Result<Vec<f64>, Break> {
        Ok(read_numbers(self.plant, path)?)
    }

    async fn write(&mut self, path: &TagPath, value: Value) -> Result<(), Break> {
        let value = match value {
            Value::Bool(on) => on.into(),
            number => number.as_f64().into(),
        };
        tags::write(self.plant, self.principal(), &path.to_string(), &value).await?;
        Ok(())
    }

    async fn enable(&mut self, path: &TagPath, value: Value) -> Result<Option<(Mnemonic, Progress<Break>)>, Break> {
        let tag = path.tag().unwrap_or_default();
        let mnemonic = self.plant.with_image(|image| match image.find(tag)?.kind {
            TagKind::Instruction(kind) => Some(kind.mnemonic),
            _ => None,
        });
        let executes = mnemonic.is_some() && !read_value(self.plant, path)?.as_bool();
        self.write(path, value).await?;
        let Some(mnemonic) = mnemonic.filter(|_| executes) else {
            return Ok(None);
        };
        let control = self.plant.with_image(|image| control_of(image, tag));
        Ok(Some((mnemonic, progress(mnemonic, &control.unwrap_or_default()))))
    }

    async fn attribute(&mut self, of: &ObjectAttribute) -> Result<f64, Break> {
        Ok(attribute(self.plant, of)?)
    }

    async fn set_attribute(&mut self, of: &ObjectAttribute, value: f64) -> Result<(), Break> {
        Ok(set_attribute(self.plant, self.principal(), of, value).await?)
    }

    async fn has_room(&mut self, call: &EvaluatedCall) -> Result<bool, Break> {
        let Some(index) = self.plant.machine().system(&call.target).map(usize::from) else {
            return Ok(true);
        };
        let is_full = self.plant.with_snapshot(|snapshot| {
            let system = snapshot.systems.get(index);
            let full = coordinate_motion_status::MOVE_PENDING_QUEUE_FULL_STATUS;
            system.is_some_and(|system| system.motion_status & full != 0)
        });
        Ok(!is_full)
    }

    async fn call(&mut self, call: &EvaluatedCall) -> Result<Accepted, Break> {
        Ok(drive::call(self.plant, self.principal(), call, None).await?)
    }

    /// Waits, unless it is ended.
    async fn pause(&mut self, pause: Pause<'_>) -> Result<(), Break> {
        let tick = Duration::from_nanos(self.plant.machine().period_ns).max(LEAST_TICK);
        let time = match pause {
            Pause::Tick | Pause::Condition | Pause::Room(_) => tick,
            Pause::Queue { depth } => pause_of_queue(tick, depth),
            Pause::Seconds(seconds) => Duration::try_from_secs_f64(seconds).unwrap_or(Duration::MAX),
            Pause::Motion => POLL,
        };
        let over = tokio::time::sleep(time);
        tokio::pin!(over);
        loop {
            tokio::select! {
                // In order, so that a run can be repeated.
                biased;
                () = &mut over => return Ok(()),
                changed = self.mode.changed() => {
                    changed.map_err(|_| Break::Ended)?;
                    if *self.mode.borrow_and_update() == Mode::End {
                        return Err(Break::Ended);
                    }
                }
            }
        }
    }

    async fn progress(&mut self, called: &Called<Accepted>) -> Result<Progress<Break>, Break> {
        let control = match called.execution {
            Some(accepted) => self.plant.instruction_instance(accepted.instance),
            None => self.plant.with_image(|image| control_of(image, &called.tag)),
        };
        Ok(control.map_or(Progress::Ended, |control| progress(called.mnemonic, &control)))
    }

    async fn stopped(&mut self, called: &Called<Accepted>) -> Result<Option<Stopped<Break>>, Break> {
        let ended = called
            .execution
            .and_then(|accepted| self.plant.instruction_ending(accepted.instance));
        Ok(ended.map(|ended| {
            let text = format!("{} {} was {}", called.mnemonic, called.target, ended.ending);
            Stopped {
                ending: ended.ending,
                error: Refusal::new(text).into(),
            }
        }))
    }

    async fn outcome(&mut self, tag: &str, called: Option<&Called<Accepted>>) -> Result<Outcome, Break> {
        let accepted = called.and_then(|called| called.execution);
        let control = match accepted {
            Some(accepted) => self.plant.instruction_instance(accepted.instance),
            None => self.plant.with_image(|image| control_of(image, tag)),
        };
        let ended = accepted.and_then(|accepted| self.plant.instruction_ending(accepted.instance));
        Ok(Outcome {
            call: called.map(|called| (called.mnemonic, called.line)),
            control: control.unwrap_or_default(),
            ending: ended.map(|ended| ended.ending),
        })
    }

    fn err(error: &Break) -> Option<i16> {
        match error {
            Break::Failed(refusal) => refusal.err,
            Break::Ended => None,
        }
    }
}

/// The status that a motion control tag or an instruction tag shows.
fn control_of(image: &Image, tag: &str) -> Option<MotionControl> {
    match image.find(tag)?.kind {
        TagKind::MotionControl(slot) => Some(image.control(slot)),
        TagKind::Instruction(kind) => Some(image.control(kind.control)),
        _ => None,
    }
}

/// The progress that the status of an instruction shows.
fn progress(mnemonic: Mnemonic, control: &MotionControl) -> Progress<Break> {
    Progress::of(mnemonic, control, || {
        Refusal::motion(control.err, control.exerr, mnemonic).into()
    })
}

impl Live<'_> {
    /// The principal of the commands of the present statement.
    fn principal(&self) -> Principal {
        self.principal_of(self.line)
    }

    /// The principal of the commands of the statement on a line.
    fn principal_of(&self, line: usize) -> Principal {
        Principal::Program {
            viewer: self.viewer,
            line: u32::try_from(line).unwrap_or(u32::MAX),
        }
    }

    /// One statement runs, then the program is paused again, unless a viewer has changed the mode since.
    fn stepped(&self) {
        if let Some(running) = &*self.programs.running() {
            running.mode.send_if_modified(|now| {
                let stepped = *now == Mode::Step;
                if stepped {
                    *now = Mode::Pause;
                }
                stepped
            });
        }
    }
}
