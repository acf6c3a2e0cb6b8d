//! The one program that viewers may run: it goes on from statement to statement as a client's would, on a thread of its own,
//! with the rights of the viewer who started it.

use std::collections::{BTreeMap, VecDeque};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use arcline_controller::image::TagKind;
use arcline_instruction_set::Flag;
use arcline_instruction_set::predefined::coordinate_motion_status;
use arcline_structured_text::{Answer, BoundCall, Hopeless, Interpreter, Program, Request};
use arcline_tag::TagPath;
use tokio::sync::watch;

use super::drive::{self, Accepted, attribute, read_numbers, read_value, set_attribute};
use super::protocol::{self, Checked, Done, ProgramState as State, ProgramStatus, Push, Refusal, text_of};
use super::tags;
use crate::names::ImageNames;
use crate::plant::control::ViewerId;
use crate::plant::{Plant, Principal};

/// Time between two looks at motion that must end.
const POLL: Duration = Duration::from_millis(5);
/// Shortest pause of a program that waits.
const LEAST_TICK: Duration = Duration::from_millis(1);
/// Executions that are watched: as many as have instances.
const WATCHED: usize = 4096;
/// ERR of a full queue.
const QUEUE_FULL: i16 = 43;

/// The program, and where its viewers see it.
#[derive(Debug)]
pub(super) struct Programs {
    shown: watch::Sender<Shown>,
    mode: Mutex<Option<Running>>,
}

#[derive(Debug)]
struct Running {
    viewer: ViewerId,
    mode: watch::Sender<Mode>,
}

/// How it goes on.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Mode {
    Run,
    Pause,
    Step,
    End,
}

/// What viewers see of it.
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

/// Why it does not go on.
enum Stopped {
    /// Somebody ended it.
    Ended,
    Failed(Refusal),
}

impl From<Refusal> for Stopped {
    fn from(refusal: Refusal) -> Self {
        Self::Failed(refusal)
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

impl Default for Programs {
    fn default() -> Self {
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
        }
    }
}

impl Programs {
    pub(super) fn watch(&self) -> watch::Receiver<Shown> {
        let mut watch = self.shown.subscribe();
        watch.mark_changed();
        watch
    }

    /// No further statement is executed.
    pub(super) fn end(&self) {
        // Without a program there is nothing to end.
        let _ = self.set(Mode::End);
    }

    /// Ends the program of a viewer who goes.
    pub(super) fn end_of(&self, viewer: ViewerId) {
        let own = self.running().as_ref().is_some_and(|running| running.viewer == viewer);
        if own {
            self.end();
        }
    }

    fn set(&self, mode: Mode) -> Result<Done, Refusal> {
        match &*self.running() {
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

/// What is wrong with a program.
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
        let runtime = tokio::runtime::Handle::current();
        // A thread of its own: a program that computes without end delays no other work.
        tokio::task::spawn_blocking(move || {
            let mut run = Run {
                programs: &programs,
                plant: &plant,
                viewer,
                mode,
                granted: None,
                executed: VecDeque::new(),
                newest: BTreeMap::new(),
                settled: Vec::new(),
            };
            let end = runtime.block_on(run.whole(Interpreter::new(program)));
            *programs.running() = None;
            programs.shown.send_modify(|shown| match end {
                Ok(()) | Err(Stopped::Ended) => shown.state = State::Ended,
                Err(Stopped::Failed(error)) => {
                    shown.state = State::Failed;
                    shown.line = error.line.map(|line| line as usize).or(shown.line);
                    shown.error = Some(error);
                }
            });
        });
        Ok(Done {})
    }

    pub(super) fn step(&self) -> Result<Done, Refusal> {
        self.set(Mode::Step)
    }

    pub(super) fn pause(&self) -> Result<Done, Refusal> {
        self.set(Mode::Pause)
    }

    pub(super) fn go_on(&self) -> Result<Done, Refusal> {
        self.set(Mode::Run)
    }
}

/// A program on its way.
struct Run<'s> {
    programs: &'s Programs,
    plant: &'s Plant,
    viewer: ViewerId,
    mode: watch::Receiver<Mode>,
    /// The line that may run while it is paused.
    granted: Option<usize>,
    executed: VecDeque<(usize, Accepted)>,
    /// The newest execution of each motion control tag, by its name in small letters.
    newest: BTreeMap<String, (usize, Accepted)>,
    /// The tags of `newest` that a WAIT has read and that cannot change any more.
    settled: Vec<String>,
}

impl Run<'_> {
    async fn whole(&mut self, mut interpreter: Interpreter) -> Result<(), Stopped> {
        let mut answer = Answer::Start;
        loop {
            let request = interpreter.resume(answer).map_err(|error| {
                let line = error.line;
                Refusal::new(error.problem.to_string()).at(line)
            })?;
            let line = interpreter.line();
            let at = |refusal: Refusal| Stopped::Failed(refusal.at(line));
            if request != Request::End {
                self.turn(line).await?;
            }
            answer = match request {
                Request::Read(path) => self.read(&path).map_err(at)?,
                Request::ReadArray(path) => Answer::Array(read_numbers(self.plant, &path).map_err(at)?),
                Request::Write(path, value) => {
                    let value = match value {
                        arcline_tag::Value::Bool(on) => on.into(),
                        number => number.as_f64().into(),
                    };
                    let path = path.to_string();
                    tags::write(self.plant, self.principal(line), &path, &value)
                        .await
                        .map_err(at)?;
                    Answer::Done
                }
                Request::GetAttribute(of) => {
                    let value = attribute(self.plant, &of).map_err(at)?;
                    Answer::Value(arcline_tag::Value::Lreal(value))
                }
                Request::SetAttribute(of, value) => {
                    set_attribute(self.plant, self.principal(line), &of, value)
                        .await
                        .map_err(at)?;
                    Answer::Done
                }
                Request::Call(call) => self.call(call).await.map_err(at)?,
                Request::NextTick => {
                    if interpreter.is_hopeless()
                        && let Some(hopeless) = self.hopeless(line)
                    {
                        return Err(at(Refusal::new(hopeless.to_string())));
                    }
                    self.settled.clear();
                    let tick = Duration::from_nanos(self.plant.machine().period_ns);
                    self.pause(tick.max(LEAST_TICK)).await?;
                    Answer::Done
                }
                Request::Delay(seconds) => {
                    self.pause(Duration::try_from_secs_f64(seconds).unwrap_or(Duration::MAX))
                        .await?;
                    Answer::Done
                }
                Request::End => return self.finish().await,
            };
        }
    }

    /// The value of a tag; of a motion control tag that the program has used, whether it can still change.
    fn read(&mut self, path: &TagPath) -> Result<Answer, Refusal> {
        let own = path.tag().map(str::to_ascii_lowercase);
        let own = own.filter(|tag| self.newest.contains_key(tag));
        if let Some(tag) = own {
            let read = self.plant.with_image(|image| {
                let TagKind::MotionControl(slot) = image.find(&tag)?.kind else {
                    return None;
                };
                Some((image.control(slot).has_ended(), image.read(path).ok()?))
            });
            if let Some((true, value)) = read {
                self.settled.push(tag);
                return Ok(Answer::Settled(value));
            }
        }
        read_value(self.plant, path).map(Answer::Value)
    }

    /// Why a WAIT cannot come true any more; `None` when an instruction has begun again since the tags were read.
    fn hopeless(&self, line: usize) -> Option<Hopeless> {
        let plant = self.plant;
        let mut found = None;
        for tag in &self.settled {
            let (called, accepted) = self.newest.get(tag)?;
            let control = plant.instruction_instance(accepted.instance)?;
            if !control.has_ended() {
                return None;
            }
            let name = plant.with_image(|image| image.find(tag).map(|tag| tag.name.clone()));
            let ended = plant.instruction_ending(accepted.instance);
            let call = Some((accepted.mnemonic, *called));
            let ending = ended.as_ref().map(|ended| &ended.ending);
            let hopeless = Hopeless::new(line, name.as_deref().unwrap_or(tag), call, &control, ending);
            if !control.has(Flag::Pc) {
                return Some(hopeless);
            }
            found.get_or_insert(hopeless);
        }
        found
    }

    /// The principal of what a statement does.
    fn principal(&self, line: usize) -> Principal {
        Principal::Program {
            viewer: self.viewer,
            line: u32::try_from(line).unwrap_or(u32::MAX),
        }
    }

    /// Waits until the statement of a line may run.
    async fn turn(&mut self, line: usize) -> Result<(), Stopped> {
        loop {
            let mode = *self.mode.borrow_and_update();
            match mode {
                Mode::End => return Err(Stopped::Ended),
                Mode::Run => {
                    self.granted = None;
                    break;
                }
                Mode::Pause if self.granted == Some(line) => break,
                Mode::Pause => {
                    self.programs.show(State::Paused, Some(line));
                    self.changed().await?;
                }
                Mode::Step => {
                    self.granted = Some(line);
                    // Unless somebody has wanted something else since.
                    if let Some(running) = &*self.programs.running() {
                        running.mode.send_if_modified(|now| {
                            let stepped = *now == Mode::Step;
                            if stepped {
                                *now = Mode::Pause;
                            }
                            stepped
                        });
                    }
                    break;
                }
            }
        }
        self.programs.show(State::Running, Some(line));
        Ok(())
    }

    async fn changed(&mut self) -> Result<(), Stopped> {
        self.mode.changed().await.map_err(|_| Stopped::Ended)
    }

    async fn call(&mut self, call: BoundCall) -> Result<Answer, Refusal> {
        if self.is_full(&call) {
            return Ok(Answer::QueueFull);
        }
        match drive::call(self.plant, self.principal(call.line), &call, None).await {
            Ok(accepted) => {
                if self.executed.len() == WATCHED {
                    self.executed.pop_front();
                }
                if let Some(tag) = &call.control {
                    self.newest.insert(tag.to_ascii_lowercase(), (call.line, accepted));
                }
                self.executed.push_back((call.line, accepted));
                Ok(Answer::Done)
            }
            Err(refusal) if refusal.err == Some(QUEUE_FULL) => Ok(Answer::QueueFull),
            Err(refusal) => Err(refusal),
        }
    }

    /// Looked at first, so that a call that waits leaves no error in its tag.
    fn is_full(&self, call: &BoundCall) -> bool {
        let machine = self.plant.machine();
        let place = machine.system(&call.target).map(usize::from);
        let Some(place) = place.filter(|_| call.mnemonic.instruction().takes_place(&call.given)) else {
            return false;
        };
        self.plant.with_snapshot(|snapshot| {
            let system = snapshot.systems.get(place);
            let full = coordinate_motion_status::MOVE_PENDING_QUEUE_FULL_STATUS;
            system.is_some_and(|system| system.motion_status & full != 0)
        })
    }

    /// Waits, unless it is ended; an instruction that errs meanwhile ends it.
    async fn pause(&mut self, time: Duration) -> Result<(), Stopped> {
        self.look()?;
        let over = tokio::time::sleep(time);
        tokio::pin!(over);
        loop {
            tokio::select! {
                () = &mut over => return Ok(()),
                changed = self.mode.changed() => {
                    changed.map_err(|_| Stopped::Ended)?;
                    if *self.mode.borrow_and_update() == Mode::End {
                        return Err(Stopped::Ended);
                    }
                }
            }
        }
    }

    /// Waits until all motion that the program began and that has an end has come to it.
    async fn finish(&mut self) -> Result<(), Stopped> {
        loop {
            self.look()?;
            if self.executed.is_empty() {
                return Ok(());
            }
            self.pause(POLL).await?;
        }
    }

    /// Forgets executions that are over.
    fn look(&mut self) -> Result<(), Refusal> {
        let mut failed = None;
        self.executed.retain(|(line, accepted)| {
            let Some(control) = self.plant.instruction_instance(accepted.instance) else {
                return false;
            };
            if control.has(Flag::Er) {
                failed.get_or_insert(Refusal::motion(control.err, control.exerr, accepted.mnemonic).at(*line));
            }
            control.has(Flag::Ip) && accepted.mnemonic.instruction().bits.contains(&Flag::Pc)
        });
        failed.map_or(Ok(()), Err)
    }
}
