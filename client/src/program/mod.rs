//! Runs Structured Text against a live server: one instruction, or a whole program.
//!
//! The loop is [`ProgramRun`]'s, its answers are `live`'s. A tick of the program is about the server's
//! coarse update period; unlike in the simulator the machine goes on meanwhile, so statements of one tick are not
//! simultaneous.

mod live;

use std::time::Duration;

use arcline_instruction_set::{Mnemonic, Object, locate};
use arcline_structured_text::{
    Hopeless, Interpreter, Names, Policy, Program, ProgramRun, RunError, RuntimeError, SyntaxError,
};
pub use arcline_structured_text::{OnError, QueueFull};
use arcline_tag::{DataType, PathError, TagPath};

use crate::tags::TagTable;
use crate::{Client, ClientError, Ended, Execution};
use live::Live;

/// A tick of a program on a server that does not report its coarse update period.
pub const TICK: Duration = Duration::from_millis(1);
/// The tag and the member in which a server reports its coarse update period, in milliseconds.
const REAL_TIME: &str = "RealTime";
const UPDATE_PERIOD: &str = "UpdatePeriod";
/// Longest coarse update period that the client accepts.
const LONGEST_TICK: Duration = Duration::from_secs(1);

/// The reason for which a program did not run to its end.
#[derive(Debug, thiserror::Error)]
pub enum ProgramError {
    /// The text cannot be parsed, or it names a tag, an instruction or an operand that does not exist.
    #[error(transparent)]
    Syntax(#[from] SyntaxError),
    /// An operation has no result.
    #[error(transparent)]
    Runtime(#[from] RuntimeError),
    /// A WAIT can no longer come true: the motion that it waits for has ended without it.
    #[error(transparent)]
    Hopeless(#[from] Hopeless),
    /// The server refused, or is gone.
    #[error("line {line}: {source}")]
    Client {
        /// Line of the statement, from 1.
        line: usize,
        /// The error of the client.
        source: ClientError,
    },
}

impl From<RunError<ClientError>> for ProgramError {
    fn from(error: RunError<ClientError>) -> Self {
        match error {
            RunError::Runtime(error) => Self::Runtime(error),
            RunError::Hopeless(error) => Self::Hopeless(error),
            RunError::Driver { line, error } => Self::Client { line, source: error },
        }
    }
}

/// An event of a program that runs.
#[derive(Debug)]
pub enum Event<'a> {
    /// An instruction was executed.
    Executed {
        /// Line of the call.
        line: usize,
        /// The execution.
        execution: &'a Execution,
    },
    /// An instruction that was executed has ended, as [`Event::Ended`] and [`Event::Erred`] may tell too.
    Completed {
        /// Line of the call.
        line: usize,
    },
    /// An instruction erred.
    Erred {
        /// Line of the call.
        line: usize,
        /// The instruction.
        mnemonic: Mnemonic,
        /// Its target.
        target: &'a str,
        /// The error.
        error: &'a ClientError,
    },
    /// The motion of an instruction ended before its end, though no instruction of the program ended it.
    Ended {
        /// Line of the call.
        line: usize,
        /// The execution.
        execution: &'a Execution,
        /// The cause of the end.
        ended: &'a Ended,
    },
}

/// A program under way.
///
/// ```no_run
/// # async fn example(client: arcline_client::Client) -> Result<(), Box<dyn std::error::Error>> {
/// use arcline_client::Runner;
///
/// let mut runner = Runner::program(&client, "MSO(X, M1); WAIT(M1.DN);").await?;
/// runner.run(&mut |_| {}).await?;
/// # Ok(())
/// # }
/// ```
#[derive(Debug)]
pub struct Runner<'c> {
    client: &'c Client,
    run: ProgramRun<Execution>,
    /// Time between two evaluations of a WAIT or of a full queue.
    tick: Duration,
    /// Whether the server executes series of moves, as far as the client knows.
    has_series: bool,
}

impl<'c> Runner<'c> {
    /// A whole program.
    ///
    /// # Errors
    /// [`ProgramError::Syntax`] when it cannot be read or a name does not exist; the errors of browsing.
    pub async fn program(client: &'c Client, text: &str) -> Result<Self, ProgramError> {
        Self::new(client, Program::parse(text)?).await
    }

    /// One instruction call.
    ///
    /// # Errors
    /// As [`Runner::program`].
    pub async fn call(client: &'c Client, text: &str) -> Result<Self, ProgramError> {
        Self::new(client, Program::parse_call(text)?).await
    }

    async fn new(client: &'c Client, mut program: Program) -> Result<Self, ProgramError> {
        let fail = |source| ProgramError::Client { line: 1, source };
        client.browse().await.map_err(fail)?;
        let tick = update_period(client).await.map_err(fail)?.unwrap_or(TICK);
        program.check(&Known(&client.table()))?;
        let run = ProgramRun::new(Interpreter::new(program), Policy::default());
        Ok(Self {
            client,
            run,
            tick,
            has_series: true,
        })
    }

    /// Continues with the next piece of a program that is read in pieces, its lines counted on from `lines_before`. The piece
    /// before must have run to its end; [`Runner::executions`] and [`Runner::finish`] are about all of them.
    ///
    /// # Errors
    /// As [`Runner::program`].
    pub async fn load(&mut self, text: &str, lines_before: usize) -> Result<(), ProgramError> {
        let counted_on = |mut error: SyntaxError| {
            error.line += lines_before;
            error
        };
        let program = Program::parse(text).map_err(counted_on)?;
        let mut checked = program.clone();
        if checked.check(&Known(&self.client.table())).is_err() {
            // A tag that a piece before has made is not in the table yet.
            let browsed = self.client.browse().await;
            browsed.map_err(|source| ProgramError::Client {
                line: lines_before + 1,
                source,
            })?;
            checked = program;
            checked.check(&Known(&self.client.table())).map_err(counted_on)?;
        }
        self.run.load(Interpreter::new(checked), lines_before);
        Ok(())
    }

    /// Replaces the reaction to a full queue, which is to wait.
    #[must_use]
    pub fn queue_full(mut self, queue_full: QueueFull) -> Self {
        self.run.policy_mut().queue_full = queue_full;
        self
    }

    /// Replaces the reaction to an error, which is to stop.
    #[must_use]
    pub fn on_error(mut self, on_error: OnError) -> Self {
        self.run.policy_mut().on_error = on_error;
        self
    }

    /// The newest executions with their lines, oldest first; at most 4,096.
    pub fn executions(&self) -> impl Iterator<Item = (usize, &Execution)> {
        let executed = self.run.calls().executed();
        executed.filter_map(|called| Some((called.line, called.execution.as_ref()?)))
    }

    /// Objects on which instructions have been executed, each once.
    pub fn targets(&self) -> Vec<(Object, String)> {
        let mut targets = Vec::new();
        for (_, execution) in self.executions() {
            let target = (execution.mnemonic.instruction().object, execution.target.clone());
            if !targets.contains(&target) {
                targets.push(target);
            }
        }
        targets
    }

    /// Runs the statements up to the last one. May be dropped at any point; motion goes on then.
    ///
    /// # Errors
    /// See [`ProgramError`].
    pub async fn run(&mut self, on_event: &mut (dyn FnMut(Event<'_>) + Send)) -> Result<(), ProgramError> {
        let mut live = Live::new(self.client, self.tick, &mut self.has_series, on_event);
        Ok(self.run.run(&mut live).await?)
    }

    /// Waits until all motion that the program began and that has an end has come to it.
    ///
    /// # Errors
    /// [`ProgramError::Client`] when an instruction errs while it runs, or the server is gone.
    pub async fn finish(&mut self, on_event: &mut (dyn FnMut(Event<'_>) + Send)) -> Result<(), ProgramError> {
        let mut live = Live::new(self.client, self.tick, &mut self.has_series, on_event);
        Ok(self.run.finish(&mut live).await?)
    }
}

/// The coarse update period; `None` if the server, perhaps another make, does not report it.
async fn update_period(client: &Client) -> Result<Option<Duration>, ClientError> {
    let tells = client
        .table()
        .tag(REAL_TIME)
        .is_some_and(|tag| match &tag.tag_type.data_type {
            DataType::Structure(template) => template.member(UPDATE_PERIOD).is_some(),
            DataType::Elementary(_) => false,
        });
    if !tells {
        return Ok(None);
    }
    let reading = client.read(&format!("{REAL_TIME}.{UPDATE_PERIOD}")).await?;
    let period = reading
        .as_f64()
        .and_then(|milliseconds| Duration::try_from_secs_f64(milliseconds / 1e3).ok());
    Ok(period.filter(|period| (Duration::from_nanos(1)..=LONGEST_TICK).contains(period)))
}

/// The server's names, for the check of a program.
struct Known<'t>(&'t TagTable);

impl Names for Known<'_> {
    fn is_object(&self, object: Object, name: &str) -> bool {
        self.0.tag(name).and_then(|tag| tag.object()) == Some(object)
    }

    fn locate(&self, path: &TagPath) -> Option<Result<(), PathError>> {
        let tag = self.0.tag(&path.full_name()?)?;
        Some(locate(&tag.tag_type, path.scope().2).map(drop))
    }

    fn objects(&self, object: Object) -> Vec<String> {
        self.0
            .tags()
            .into_iter()
            .filter(|tag| tag.object() == Some(object))
            .map(|tag| tag.name)
            .collect()
    }

    fn tags(&self) -> Vec<String> {
        self.0.names().map(str::to_owned).collect()
    }
}

/// A program can run on a task of its own: the futures are `Send`.
const _: fn(&mut Runner<'_>) = |runner| {
    fn is_send(_: impl Send) {}
    is_send(runner.run(&mut |_| {}));
    is_send(runner.finish(&mut |_| {}));
};
