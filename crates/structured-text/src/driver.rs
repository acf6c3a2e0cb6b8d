//! Runs a program on a machine: the one loop over the [`Interpreter`]. A [`Driver`] answers its requests; the simulator, the
//! page and the network client have one each.
//!
//! Everything that must be the same on all of them is here: the order of the requests, the wait for room in a queue, the
//! reaction to errors, the end of a WAIT that cannot come true, the wait for all motion at the end. Times are in seconds.

use std::pin::pin;
use std::task::{Context, Poll, Waker};

use arcline_instruction_set::{Ending, Flag, Mnemonic, MotionControl, MotionError};
use arcline_tag::{TagPath, Value};

use crate::calls::{Called, Calls, State};
use crate::{Answer, BoundCall, Hopeless, Interpreter, ObjectAttribute, Request, RuntimeError};

/// The reaction of a coordinated move to a full queue.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum QueueFull {
    /// The program calls it again as soon as there is room.
    #[default]
    Wait,
    /// It errs with 43.
    Error,
}

/// The reaction of a program to an instruction that errs.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum OnError {
    /// The program ends.
    #[default]
    Stop,
    /// The program goes on with its next statement.
    KeepGoing,
}

/// How a program runs.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Policy {
    /// The reaction to a full queue.
    pub queue_full: QueueFull,
    /// The reaction to an error.
    pub on_error: OnError,
}

/// Why a program did not run to its end.
#[derive(Clone, PartialEq, Debug, thiserror::Error)]
pub enum RunError<E> {
    /// An operation has no result.
    #[error(transparent)]
    Runtime(#[from] RuntimeError),
    /// A WAIT can no longer come true.
    #[error(transparent)]
    Hopeless(#[from] Hopeless),
    /// The driver refused a statement, or an instruction erred.
    #[error("line {line}: {error}")]
    Driver {
        /// Line of the statement, from 1.
        line: usize,
        /// Why.
        error: E,
    },
}

/// The value of a tag.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Reading {
    /// The value at this moment.
    Value(Value),
    /// The value of a member of a motion control tag whose instruction has ended: it cannot change any more.
    Settled(Value),
}

/// The time that passes before the program continues.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Pause<'p> {
    /// The next tick.
    Tick,
    /// The next tick in which the condition of a WAIT may have changed.
    Condition,
    /// The next tick in which there may be room for a move.
    Room(&'p BoundCall),
    /// So many seconds, 0 or more.
    Seconds(f64),
    /// A while: all statements have run, and motion of the program is still under way.
    Motion,
}

/// The progress of an executed instruction.
#[derive(Clone, PartialEq, Debug)]
pub enum Progress<E> {
    /// It is in process, and will end.
    Running,
    /// It has ended as programmed, or has no end.
    Ended,
    /// It has ended without PC.
    Incomplete,
    /// It has erred since it was accepted.
    Erred(E),
}

impl<E> Progress<E> {
    /// The progress that the bits of a motion control tag show.
    pub fn of(mnemonic: Mnemonic, control: &MotionControl, error: impl FnOnce() -> E) -> Self {
        if control.has(Flag::Er) {
            Progress::Erred(error())
        } else if !mnemonic.instruction().bits.contains(&Flag::Pc) || control.has(Flag::Pc) {
            Progress::Ended
        } else if control.has(Flag::Ip) {
            Progress::Running
        } else {
            Progress::Incomplete
        }
    }
}

/// The end of an instruction that did not come to its programmed end.
#[derive(Clone, PartialEq, Debug)]
pub struct Stopped<E> {
    /// Its cause.
    pub ending: Ending,
    /// The same as the error of its statement.
    pub error: E,
}

/// The state of the motion control tag that a WAIT has read.
#[derive(Clone, PartialEq, Debug)]
pub struct Outcome {
    /// The instruction that the tag shows, and the line of its call.
    pub call: Option<(Mnemonic, usize)>,
    /// Its status.
    pub control: MotionControl,
    /// The cause that ended it before its end.
    pub ending: Option<Ending>,
}

/// A machine on which programs run. Each method answers one [`Request`]; a driver that cannot be interrupted returns futures that
/// are ready at once ([`immediately`]).
// Whether the futures can go to another thread follows from the driver.
#[allow(async_fn_in_trait)]
pub trait Driver {
    /// Why it refuses a statement.
    type Error;
    /// Identifies an execution of an instruction.
    type Execution: Clone;

    /// How many running executions [`Driver::progress`] is asked for in one pause, in turn.
    const LOOKS: usize;

    /// A statement of that line is about to make a request.
    async fn turn(&mut self, line: usize) -> Result<(), Self::Error>;

    /// The value of a tag. A motion control tag that has not been made yet reads as zeros.
    async fn read(&mut self, path: &TagPath, calls: &Calls<Self::Execution>) -> Result<Reading, Self::Error>;

    /// The numbers of an array from that element on; a tag that is no array is an array of one.
    async fn read_array(&mut self, path: &TagPath) -> Result<Vec<f64>, Self::Error>;

    /// Writes a BOOL or an LREAL; the tag converts it to its own type.
    async fn write(&mut self, path: &TagPath, value: Value) -> Result<(), Self::Error>;

    /// The value of an attribute.
    async fn attribute(&mut self, of: &ObjectAttribute) -> Result<f64, Self::Error>;

    /// Sets an attribute.
    async fn set_attribute(&mut self, of: &ObjectAttribute, value: f64) -> Result<(), Self::Error>;

    /// Whether the queue of the coordinate system has room for a move that takes a place in it.
    async fn has_room(&mut self, call: &BoundCall) -> Result<bool, Self::Error>;

    /// Executes an instruction.
    async fn call(&mut self, call: &BoundCall) -> Result<Self::Execution, Self::Error>;

    /// Lets time pass.
    async fn pause(&mut self, pause: Pause<'_>) -> Result<(), Self::Error>;

    /// The progress of an execution.
    async fn progress(&mut self, called: &Called<Self::Execution>) -> Result<Progress<Self::Error>, Self::Error>;

    /// Why an execution ended without PC; `None`: the machine does not know.
    async fn stopped(&mut self, called: &Called<Self::Execution>) -> Result<Option<Stopped<Self::Error>>, Self::Error>;

    /// The state of a motion control tag that a WAIT has read as settled; `called` is the program's newest call of it.
    async fn outcome(&mut self, tag: &str, called: Option<&Called<Self::Execution>>) -> Result<Outcome, Self::Error>;

    /// ERR, if the error is that of a motion instruction.
    fn err(error: &Self::Error) -> Option<i16>;

    /// An instruction erred, or was stopped by another cause than the program.
    fn report(&mut self, called: &Called<Self::Execution>, error: &Self::Error) {
        let _ = (called, error);
    }
}

/// A program under way.
#[derive(Debug)]
pub struct ProgramRun<X> {
    interpreter: Interpreter,
    policy: Policy,
    calls: Calls<X>,
    /// The motion control tags that were read as settled since time last passed.
    settled: Vec<String>,
    /// Whether a WAIT was without hope a tick ago.
    was_hopeless: bool,
    /// Lines of the pieces that ran before this one.
    lines_before: usize,
}

impl<X: Clone> ProgramRun<X> {
    /// The program in front of its first statement.
    pub fn new(interpreter: Interpreter, policy: Policy) -> Self {
        Self {
            interpreter,
            policy,
            calls: Calls::default(),
            settled: Vec::new(),
            was_hopeless: false,
            lines_before: 0,
        }
    }

    /// Continues with the next piece of a program that is read in pieces: its first line counts as the line behind `lines_before`
    /// others. The piece before must have run to its end; its variables are gone, its executions are not.
    pub fn load(&mut self, piece: Interpreter, lines_before: usize) {
        self.interpreter = piece;
        self.lines_before = lines_before;
    }

    /// The policy.
    pub fn policy_mut(&mut self) -> &mut Policy {
        &mut self.policy
    }

    /// The calls that have been executed.
    pub fn calls(&self) -> &Calls<X> {
        &self.calls
    }

    /// Runs the statements up to the last one. If the future is dropped, motion continues.
    ///
    /// # Errors
    /// [`RunError`]: the first error that ends the program.
    pub async fn run<D: Driver<Execution = X>>(&mut self, driver: &mut D) -> Result<(), RunError<D::Error>> {
        let mut answer = Answer::Start;
        let mut waits_for_room = None;
        loop {
            let request = self.interpreter.resume(answer).map_err(|error| RuntimeError {
                line: error.line + self.lines_before,
                ..error
            })?;
            let line = self.line();
            let at = |error| RunError::Driver { line, error };
            if request != Request::End {
                driver.turn(line).await.map_err(at)?;
            }
            answer = match request {
                Request::Read(path) => match driver.read(&path, &self.calls).await.map_err(at)? {
                    Reading::Value(value) => Answer::Value(value),
                    Reading::Settled(value) => {
                        self.settled.extend(path.tag().map(str::to_owned));
                        Answer::Settled(value)
                    }
                },
                Request::ReadArray(path) => Answer::Array(driver.read_array(&path).await.map_err(at)?),
                Request::Write(path, value) => {
                    driver.write(&path, value).await.map_err(at)?;
                    Answer::Done
                }
                Request::GetAttribute(of) => Answer::Value(Value::Lreal(driver.attribute(&of).await.map_err(at)?)),
                Request::SetAttribute(of, value) => {
                    driver.set_attribute(&of, value).await.map_err(at)?;
                    Answer::Done
                }
                Request::Call(mut call) => {
                    call.line += self.lines_before;
                    self.was_hopeless = false;
                    let answer = self.call(driver, &call).await.map_err(at)?;
                    waits_for_room = (answer == Answer::QueueFull).then_some(call);
                    answer
                }
                Request::NextTick => {
                    let pause = match &waits_for_room {
                        Some(call) => Pause::Room(call),
                        None => self.next_tick(driver).await?,
                    };
                    self.pause(driver, line, pause).await?;
                    Answer::Done
                }
                Request::Delay(seconds) => {
                    self.pause(driver, line, Pause::Seconds(seconds)).await?;
                    Answer::Done
                }
                Request::End => return Ok(()),
            };
        }
    }

    /// Waits until all motion that the program began and that has an end has come to it.
    ///
    /// # Errors
    /// An instruction erred, or, unless the policy is to keep going, a fault ended its motion.
    pub async fn finish<D: Driver<Execution = X>>(&mut self, driver: &mut D) -> Result<(), RunError<D::Error>> {
        loop {
            self.look(driver, Turn::First).await?;
            self.explain(driver).await?;
            if self.calls.running() == 0 {
                return Ok(());
            }
            let line = self.line();
            let paused = driver.pause(Pause::Motion).await;
            paused.map_err(|error| RunError::Driver { line, error })?;
        }
    }

    /// Line of the statement that runs, from 1.
    fn line(&self) -> usize {
        self.interpreter.line() + self.lines_before
    }

    async fn call<D: Driver<Execution = X>>(&mut self, driver: &mut D, call: &BoundCall) -> Result<Answer, D::Error> {
        let waits = self.policy.queue_full == QueueFull::Wait;
        // Before the call, so that a move that waits leaves no error in its tag.
        let takes_place = call.mnemonic.instruction().takes_place(&call.given);
        if waits && takes_place && !driver.has_room(call).await? {
            return Ok(Answer::QueueFull);
        }
        match driver.call(call).await {
            Ok(execution) => {
                self.calls.add(Called::new(call, Some(execution)));
                Ok(Answer::Done)
            }
            Err(error) => {
                let Some(err) = D::err(&error) else { return Err(error) };
                if waits && takes_place && err == MotionError::CoordinateSystemQueueFull.err() {
                    return Ok(Answer::QueueFull);
                }
                let called = Called::new(call, None);
                driver.report(&called, &error);
                self.calls.add(called);
                match self.policy.on_error {
                    OnError::KeepGoing => Ok(Answer::Done),
                    OnError::Stop => Err(error),
                }
            }
        }
    }

    /// How the program waits for the next tick, unless it waits in vain.
    async fn next_tick<D: Driver<Execution = X>>(
        &mut self,
        driver: &mut D,
    ) -> Result<Pause<'static>, RunError<D::Error>> {
        if !self.interpreter.is_hopeless() {
            self.was_hopeless = false;
            return Ok(if self.interpreter.is_waiting() {
                Pause::Condition
            } else {
                Pause::Tick
            });
        }
        // The cause that ended an instruction in this very tick is known one tick later.
        if std::mem::replace(&mut self.was_hopeless, true)
            && let Some(hopeless) = self.hopeless(driver).await?
        {
            return Err(hopeless.into());
        }
        Ok(Pause::Tick)
    }

    /// Why a WAIT cannot come true any more; `None` when an instruction has begun again since its tag was read.
    async fn hopeless<D: Driver<Execution = X>>(&self, driver: &mut D) -> Result<Option<Hopeless>, RunError<D::Error>> {
        let line = self.line();
        let mut first = None;
        for tag in &self.settled {
            let called = self.calls.newest(tag);
            let outcome = driver.outcome(tag, called).await;
            let outcome = outcome.map_err(|error| RunError::Driver { line, error })?;
            if !outcome.is_settled() {
                return Ok(None);
            }
            let name = called.map_or(tag.as_str(), |called| called.tag.as_str());
            let Outcome { call, control, ending } = &outcome;
            let hopeless = Hopeless::new(line, name, *call, control, ending.as_ref());
            // An instruction that failed explains more than one that came to its end.
            if !outcome.is_complete() {
                return Ok(Some(hopeless));
            }
            first.get_or_insert(hopeless);
        }
        Ok(first)
    }

    async fn pause<D: Driver<Execution = X>>(
        &mut self,
        driver: &mut D,
        line: usize,
        pause: Pause<'_>,
    ) -> Result<(), RunError<D::Error>> {
        self.look(driver, Turn::Next).await?;
        self.settled.clear();
        let paused = driver.pause(pause).await;
        paused.map_err(|error| RunError::Driver { line, error })
    }

    /// Looks at running executions, [`Driver::LOOKS`] at most, and reports those that have erred.
    async fn look<D: Driver<Execution = X>>(&mut self, driver: &mut D, turn: Turn) -> Result<(), RunError<D::Error>> {
        if turn == Turn::First {
            self.calls.look_at_first();
        }
        let mut running = 0;
        for _ in 0..self.calls.running() {
            if running == D::LOOKS {
                break;
            }
            let Some((index, called)) = self.calls.next_running() else {
                break;
            };
            let line = called.line;
            let at = |error| RunError::Driver { line, error };
            let state = match driver.progress(called).await.map_err(at)? {
                Progress::Running => {
                    running += 1;
                    continue;
                }
                Progress::Ended => State::Over,
                Progress::Incomplete => State::Incomplete,
                Progress::Erred(error) => {
                    driver.report(called, &error);
                    if self.policy.on_error == OnError::Stop {
                        return Err(at(error));
                    }
                    State::Over
                }
            };
            self.calls.set(index, state);
        }
        Ok(())
    }

    /// Reports the motion that another cause than the program ended.
    async fn explain<D: Driver<Execution = X>>(&mut self, driver: &mut D) -> Result<(), RunError<D::Error>> {
        while let Some((index, called)) = self.calls.first(State::Incomplete) {
            let line = called.line;
            let stopped = driver.stopped(called).await;
            let stopped = stopped.map_err(|error| RunError::Driver { line, error })?;
            if let Some(Stopped { ending, error }) = stopped.filter(|stopped| !self.calls.is_own(&stopped.ending)) {
                driver.report(called, &error);
                if self.policy.on_error == OnError::Stop && matches!(ending, Ending::Fault { .. }) {
                    return Err(RunError::Driver { line, error });
                }
            }
            self.calls.set(index, State::Over);
        }
        Ok(())
    }
}

/// Where a look at running executions begins.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Turn {
    /// At the oldest one.
    First,
    /// Behind those of the look before.
    Next,
}

impl Outcome {
    /// Whether the instruction has ended, or was never executed.
    fn is_settled(&self) -> bool {
        self.control.has_ended() || self.control == MotionControl::default()
    }

    fn is_complete(&self) -> bool {
        self.control.has(arcline_instruction_set::Flag::Pc)
    }
}

/// The result of a future that never waits, as those of a driver on a virtual clock.
///
/// # Panics
/// The future waits.
pub fn immediately<F: Future>(future: F) -> F::Output {
    match pin!(future).poll(&mut Context::from_waker(Waker::noop())) {
        Poll::Ready(output) => output,
        Poll::Pending => panic!("a future that never waits was pending"),
    }
}
