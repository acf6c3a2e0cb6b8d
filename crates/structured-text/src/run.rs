//! Runs a program on a machine: the one loop over the [`Interpreter`]. A [`Driver`] answers its requests.
//!
//! Everything that must be the same on all drivers is here: the order of the requests, the wait for room in a queue, the
//! reaction to errors, the end of a WAIT that cannot come true, the wait for all motion at the end. Times are in seconds.
//!
//! Moves between which a program makes no other request are a series: they are executed together, in their order, before the next request of
//! another kind. So no statement can distinguish them from moves that were executed one after the other; only the line that runs is ahead of
//! them.

use arcline_instruction_set::{Ending, Flag, MotionControl, MotionError};

use arcline_tag::{PathSegment, TagPath, Value};

use crate::calls::{CallState, Called, Calls};
use crate::driver::{
    Driver, Moves, MovesEnd, OnError, Outcome, Pause, Policy, Progress, QueueFull, Reading, RunError, Stopped,
};
use crate::{Answer, EvaluatedCall, Hopeless, Interpreter, Request, RuntimeError};

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
    /// Moves that the program has called and that are executed together before its next request.
    series: Vec<EvaluatedCall>,
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
            series: Vec::new(),
        }
    }

    /// Continues with the next piece of a program that is read in pieces: its first line counts as the line behind `lines_before`
    /// others. The piece before must have run to its end; its variables are gone, its executions are not.
    pub fn load(&mut self, piece: Interpreter, lines_before: usize) {
        self.series.clear();
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
            let request = match self.interpreter.resume(answer) {
                Ok(request) => request,
                Err(error) => {
                    self.execute_series(driver, false).await?;
                    let line = error.line + self.lines_before;
                    return Err(RuntimeError { line, ..error }.into());
                }
            };
            let line = self.line();
            let at = |error| RunError::Driver { line, error };
            let is_full = self.series.len() >= driver.longest_series();
            let goes_on = self.joins_series(driver, &request) && driver.try_turn(line);
            if is_full || !goes_on {
                self.execute_series(driver, goes_on).await?;
            }
            if request != Request::End {
                driver.turn(line).await.map_err(at)?;
            }
            let joins = self.joins_series(driver, &request);
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
                    match enabled_tag(&path).filter(|_| value.as_bool()) {
                        Some(tag) => self.enable(driver, &path, value, tag).await.map_err(at)?,
                        None => driver.write(&path, value).await.map_err(at)?,
                    }
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
                    if joins {
                        self.series.push(call);
                        answer = Answer::Done;
                        continue;
                    }
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
            self.read_executions(driver).await?;
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

    /// Whether a request is a move that is executed together with those before and behind it.
    fn joins_series<D: Driver<Execution = X>>(&self, driver: &D, request: &Request) -> bool {
        let Request::Call(call) = request else { return false };
        self.policy.queue_full == QueueFull::Wait
            && driver.longest_series() > 1
            && call.mnemonic.instruction().joins_series(&call.operands)
    }

    /// Executes the moves that the program has called; waits where a queue has no room. `goes_on`: another move follows. Then the last ones wait for it
    /// if they are fewer than the driver takes at once.
    async fn execute_series<D: Driver<Execution = X>>(
        &mut self,
        driver: &mut D,
        goes_on: bool,
    ) -> Result<(), RunError<D::Error>> {
        let mut series = std::mem::take(&mut self.series);
        let (mut left, mut most) = (series.as_slice(), usize::MAX);
        while let Some(first) = left.first() {
            let at = |error| RunError::Driver {
                line: first.line,
                error,
            };
            let together = left.get(..most.min(left.len())).unwrap_or(left);
            let Moves { executed, end } = driver.moves(together).await.map_err(at)?;
            let count = executed.len();
            for (call, execution) in left.iter().zip(executed) {
                self.calls.add(Called::new(call, Some(execution)));
            }
            left = left.get(count..).unwrap_or_default();
            let (failed, next) = match (end, left.split_first()) {
                (MovesEnd::Failed(error), Some((failed, next))) => ((failed, error), next),
                (MovesEnd::NoRoom { depth }, Some((next, _))) => {
                    // More would not find room either.
                    most = usize::try_from(depth).unwrap_or(usize::MAX).saturating_add(1);
                    self.pause(driver, next.line, Pause::Queue { depth }).await?;
                    continue;
                }
                (MovesEnd::Sent, _) if goes_on && left.len() < count => break,
                (_, _) => continue,
            };
            let (call, error) = failed;
            self.erred(driver, call, error)
                .map_err(|error| RunError::Driver { line: call.line, error })?;
            left = next;
        }
        // Its memory is used again.
        let sent = series.len() - left.len();
        series.drain(..sent);
        self.series = series;
        Ok(())
    }

    /// An instruction has failed: the error ends the program, unless the policy is to keep going.
    fn erred<D: Driver<Execution = X>>(
        &mut self,
        driver: &mut D,
        call: &EvaluatedCall,
        error: D::Error,
    ) -> Result<(), D::Error> {
        if D::err(&error).is_none() {
            return Err(error);
        }
        let called = Called::new(call, None);
        driver.report(&called, &error);
        self.calls.add(called);
        match self.policy.on_error {
            OnError::KeepGoing => Ok(()),
            OnError::Stop => Err(error),
        }
    }

    async fn call<D: Driver<Execution = X>>(
        &mut self,
        driver: &mut D,
        call: &EvaluatedCall,
    ) -> Result<Answer, D::Error> {
        let waits = self.policy.queue_full == QueueFull::Wait;
        // The test comes before the call, so that a move that waits leaves no error in its tag.
        let takes_place = call.mnemonic.instruction().takes_place(&call.operands);
        if waits && takes_place && !driver.has_room(call).await? {
            return Ok(Answer::QueueFull);
        }
        match driver.call(call).await {
            Ok(execution) => {
                self.calls.add(Called::new(call, Some(execution)));
                Ok(Answer::Done)
            }
            Err(error) => {
                let full = MotionError::CoordinateSystemQueueFull.err();
                if waits && takes_place && D::err(&error) == Some(full) {
                    return Ok(Answer::QueueFull);
                }
                self.erred(driver, call, error)?;
                Ok(Answer::Done)
            }
        }
    }

    /// Writes true to EnableIn. An error of the instruction ends the program as that of a call.
    async fn enable<D: Driver<Execution = X>>(
        &mut self,
        driver: &mut D,
        path: &TagPath,
        value: Value,
        tag: &str,
    ) -> Result<(), D::Error> {
        let Some((mnemonic, progress)) = driver.enable(path, value).await? else {
            return Ok(());
        };
        self.was_hopeless = false;
        let called = Called::enabled(self.line(), mnemonic, tag);
        self.calls.add(called.clone());
        match progress {
            Progress::Running => self.calls.enable(called),
            Progress::Ended | Progress::Incomplete => {}
            Progress::Erred(error) => {
                driver.report(&called, &error);
                if self.policy.on_error == OnError::Stop {
                    return Err(error);
                }
            }
        }
        Ok(())
    }

    /// The pause until the next tick, or an error if the program waits in vain.
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

    /// The reason for which a WAIT cannot come true any more; `None` when an instruction has begun again since its tag was read.
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
        self.read_executions(driver).await?;
        self.settled.clear();
        let paused = driver.pause(pause).await;
        paused.map_err(|error| RunError::Driver { line, error })
    }

    /// Reads the oldest running execution and, in turn, [`Driver::MOST_READS`] others at most; reports those that have erred.
    async fn read_executions<D: Driver<Execution = X>>(&mut self, driver: &mut D) -> Result<(), RunError<D::Error>> {
        if D::MOST_READS == 0 {
            return Ok(());
        }
        // Most executions end in their order.
        let mut oldest = 0;
        while let Some((index, called)) = self.calls.oldest_running(oldest) {
            oldest = index;
            let state = read_execution(driver, called, self.policy.on_error).await?;
            self.calls.set(index, state);
            if state == CallState::Running {
                break;
            }
        }
        let mut running = 0;
        for _ in 0..self.calls.running() {
            if running == D::MOST_READS {
                break;
            }
            let Some((index, called)) = self.calls.next_running() else {
                break;
            };
            if index == oldest {
                continue;
            }
            let state = read_execution(driver, called, self.policy.on_error).await?;
            self.calls.set(index, state);
            running += usize::from(state == CallState::Running);
        }
        for _ in 0..self.calls.enabled().min(D::MOST_READS) {
            let Some(called) = self.calls.take_enabled() else {
                break;
            };
            if read_execution(driver, &called, self.policy.on_error).await? == CallState::Running {
                self.calls.enable(called);
            }
        }
        Ok(())
    }

    /// Reports the motion that another cause than the program ended.
    async fn explain<D: Driver<Execution = X>>(&mut self, driver: &mut D) -> Result<(), RunError<D::Error>> {
        while let Some((index, called)) = self.calls.first(CallState::Incomplete) {
            let line = called.line;
            let stopped = driver.stopped(called).await;
            let stopped = stopped.map_err(|error| RunError::Driver { line, error })?;
            if let Some(Stopped { ending, error }) = stopped.filter(|stopped| !self.calls.is_own(&stopped.ending)) {
                driver.report(called, &error);
                if self.policy.on_error == OnError::Stop && matches!(ending, Ending::Fault { .. }) {
                    return Err(RunError::Driver { line, error });
                }
            }
            self.calls.set(index, CallState::Over);
        }
        Ok(())
    }
}

/// The state of a running execution. An error is reported.
async fn read_execution<D: Driver>(
    driver: &mut D,
    called: &Called<D::Execution>,
    on_error: OnError,
) -> Result<CallState, RunError<D::Error>> {
    let line = called.line;
    let at = |error| RunError::Driver { line, error };
    match driver.progress(called).await.map_err(at)? {
        Progress::Running => Ok(CallState::Running),
        Progress::Ended => Ok(CallState::Over),
        Progress::Incomplete => Ok(CallState::Incomplete),
        Progress::Erred(error) => {
            driver.report(called, &error);
            match on_error {
                OnError::Stop => Err(at(error)),
                OnError::KeepGoing => Ok(CallState::Over),
            }
        }
    }
}

/// The tag of a path such as `Move1.EnableIn`.
fn enabled_tag(path: &TagPath) -> Option<&str> {
    match path.0.as_slice() {
        [PathSegment::Symbol(tag), PathSegment::Symbol(member)] if member.eq_ignore_ascii_case("EnableIn") => Some(tag),
        _ => None,
    }
}

/// Whether the part of a motion control tag or an instruction tag at a path is one that only its instruction writes, unlike the operands of
/// an instruction tag.
pub fn is_status(path: &TagPath) -> bool {
    let Some(PathSegment::Symbol(member)) = path.0.get(1) else {
        return false;
    };
    let is = |name: &str| member.eq_ignore_ascii_case(name);
    is("MotionControl") || STATUS.into_iter().any(is) || Flag::ALL.into_iter().any(|flag| is(flag.name()))
}

/// The members of MOTION_INSTRUCTION beside its bits.
const STATUS: [&str; 6] = ["FLAGS", "ERR", "STATUS", "STATE", "SEGMENT", "EXERR"];

impl Outcome {
    /// Whether the instruction has ended, or was never executed.
    fn is_settled(&self) -> bool {
        self.control.has_ended() || self.control == MotionControl::default()
    }

    fn is_complete(&self) -> bool {
        self.control.has(Flag::Pc)
    }
}
