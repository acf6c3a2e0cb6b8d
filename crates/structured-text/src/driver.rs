//! The machine on which a program runs, as the program sees it: a [`Driver`] answers the requests of a
//! [`ProgramRun`](crate::ProgramRun). The simulator, the page and the network client have one each. Times are in seconds.

use std::pin::pin;
use std::task::{Context, Poll, Waker};
use std::time::Duration;

use arcline_instruction_set::{Ending, Flag, Mnemonic, MotionControl, MotionError};
use arcline_tag::{TagPath, Value};

use crate::calls::{Called, Calls};
use crate::{EvaluatedCall, Hopeless, ObjectAttribute, RuntimeError};

/// The reaction of a coordinated move to a full queue.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum QueueFull {
    /// The program calls it again as soon as there is room.
    #[default]
    Wait,
    /// The move errs with 43.
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

/// The reactions of a program.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Policy {
    /// The reaction to a full queue.
    pub queue_full: QueueFull,
    /// The reaction to an error.
    pub on_error: OnError,
}

/// The reason for which a program did not run to its end.
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
        /// The error.
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
    Room(&'p EvaluatedCall),
    /// A part of the time in which moves of a full queue end.
    Queue {
        /// Moves that can wait in it.
        depth: u32,
    },
    /// A number of seconds, 0 or more.
    Seconds(f64),
    /// A while: all statements have run, and motion of the program is still under way.
    Motion,
}

/// The pause before a program checks again for room in a full queue of `depth` moves, on a machine with that coarse update period: most of the
/// queue is still full then, though its moves may be as short as a period.
pub fn pause_of_queue(period: Duration, depth: u32) -> Duration {
    (period * (depth / 16)).min(LONGEST_QUEUE_PAUSE).max(period)
}

/// Longest pause before a program looks again for room in a queue.
const LONGEST_QUEUE_PAUSE: Duration = Duration::from_millis(20);

/// The progress of an executed instruction.
#[derive(Clone, PartialEq, Debug)]
pub enum Progress<E> {
    /// The execution is in process, and will end.
    Running,
    /// The execution has ended as programmed, or has no end.
    Ended,
    /// The execution has ended without PC.
    Incomplete,
    /// The execution has erred since it was accepted.
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
    /// The error of its statement for that cause.
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

/// The moves of a series that were executed.
#[derive(Clone, PartialEq, Debug)]
pub struct Moves<X, E> {
    /// The executions of the first moves, in their order.
    pub executed: Vec<X>,
    /// The reason for which the next move was not executed.
    pub end: MovesEnd<E>,
}

/// The reason for the end of a series.
#[derive(Clone, PartialEq, Debug)]
pub enum MovesEnd<E> {
    /// The others were not sent: they are a series of their own.
    Sent,
    /// The queue of the next move has no room.
    NoRoom {
        /// Moves that can wait in it.
        depth: u32,
    },
    /// The next move has failed.
    Failed(E),
}

/// A machine on which programs run. Each method answers one [`Request`](crate::Request); a driver that cannot be interrupted returns futures that
/// are ready at once ([`immediately`]).
// The driver decides whether its futures can go to another thread.
#[allow(async_fn_in_trait)]
pub trait Driver {
    /// The error by which the machine refuses a statement.
    type Error;
    /// Identifies an execution of an instruction.
    type Execution: Clone;

    /// The number of running executions that the program reads in turn with [`Driver::progress`] in one pause, besides the oldest one; 0: none at all.
    const MOST_READS: usize;

    /// A statement of that line is about to make a request.
    async fn turn(&mut self, line: usize) -> Result<(), Self::Error>;

    /// As [`Driver::turn`], but returns `false` where that would wait.
    fn try_turn(&mut self, line: usize) -> bool {
        let _ = line;
        true
    }

    /// The longest series: the number of moves without another request between them that [`Driver::moves`] executes together. With 1,
    /// [`Driver::call`] executes each move before the program continues.
    fn longest_series(&self) -> usize {
        1
    }

    /// The value of a tag. A motion control tag that has not been made yet reads as zeros.
    async fn read(&mut self, path: &TagPath, calls: &Calls<Self::Execution>) -> Result<Reading, Self::Error>;

    /// The numbers of an array from that element on; a tag that is no array is an array of one.
    async fn read_array(&mut self, path: &TagPath) -> Result<Vec<f64>, Self::Error>;

    /// Writes a BOOL or an LREAL; the tag converts it to its own type.
    async fn write(&mut self, path: &TagPath, value: Value) -> Result<(), Self::Error>;

    /// Writes true to the EnableIn of a tag. If it is an instruction tag, and EnableIn was false before: the instruction that it executed, with its
    /// progress; `None` also where the machine reports its errors by itself.
    async fn enable(
        &mut self,
        path: &TagPath,
        value: Value,
    ) -> Result<Option<(Mnemonic, Progress<Self::Error>)>, Self::Error> {
        self.write(path, value).await?;
        Ok(None)
    }

    /// The value of an attribute.
    async fn attribute(&mut self, of: &ObjectAttribute) -> Result<f64, Self::Error>;

    /// Sets an attribute.
    async fn set_attribute(&mut self, of: &ObjectAttribute, value: f64) -> Result<(), Self::Error>;

    /// Whether the queue of the coordinate system has room for a move that takes a place in it.
    async fn has_room(&mut self, call: &EvaluatedCall) -> Result<bool, Self::Error>;

    /// Executes an instruction.
    async fn call(&mut self, call: &EvaluatedCall) -> Result<Self::Execution, Self::Error>;

    /// Executes the first moves of a series in their order, one at least, up to the first that fails or finds no room in its queue. A move
    /// that is not executed leaves no trace.
    async fn moves(&mut self, series: &[EvaluatedCall]) -> Result<Moves<Self::Execution, Self::Error>, Self::Error> {
        self.first_move(series).await
    }

    /// [`Driver::moves`] by [`Driver::has_room`] and [`Driver::call`]: the first move alone.
    async fn first_move(
        &mut self,
        series: &[EvaluatedCall],
    ) -> Result<Moves<Self::Execution, Self::Error>, Self::Error> {
        let mut moves = Moves {
            executed: Vec::new(),
            end: MovesEnd::Sent,
        };
        let Some(call) = series.first() else { return Ok(moves) };
        let full = MovesEnd::NoRoom { depth: 0 };
        if !self.has_room(call).await? {
            moves.end = full;
            return Ok(moves);
        }
        match self.call(call).await {
            Ok(execution) => moves.executed.push(execution),
            Err(error) if Self::err(&error) == Some(MotionError::CoordinateSystemQueueFull.err()) => moves.end = full,
            Err(error) => moves.end = MovesEnd::Failed(error),
        }
        Ok(moves)
    }

    /// Lets time pass.
    async fn pause(&mut self, pause: Pause<'_>) -> Result<(), Self::Error>;

    /// The progress of an execution; of one without an [`Called::execution`], that of its instruction tag.
    async fn progress(&mut self, called: &Called<Self::Execution>) -> Result<Progress<Self::Error>, Self::Error>;

    /// The cause that ended an execution without PC; `None`: the machine does not know it.
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
