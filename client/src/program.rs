//! Runs Structured Text against a live server: one instruction, or a whole program.
//!
//! The interpreter says what it wants, this module asks the server for it. A tick of the program is about the server's
//! coarse update period; unlike in the simulator the machine goes on meanwhile, so statements of one tick are not
//! simultaneous.

use std::collections::{BTreeMap, VecDeque};
use std::time::Duration;

use arcline_instruction_set::{Ending, Flag, Mnemonic, Object, locate};
use arcline_proto::cip::CipStatus;
use arcline_structured_text::{
    Answer, BoundCall, Hopeless, Interpreter, Names, Program, Request, RuntimeError, SyntaxError, unmade_control,
};
use arcline_tag::{DataType, PathError, PathSegment, TagPath, Value};

use crate::tags::TagTable;
use crate::{Client, ClientError, Ended, Execution, TagValue, WriteValue};

/// A tick of a program on a server that does not tell its coarse update period.
pub const TICK: Duration = Duration::from_millis(1);
/// Where a server tells it, in milliseconds.
const REAL_TIME: &str = "RealTime";
const UPDATE_PERIOD: &str = "UpdatePeriod";
/// Longest coarse update period that is believed.
const LONGEST_TICK: Duration = Duration::from_secs(1);
/// Time between two looks at motion that must end.
const POLL: Duration = Duration::from_millis(5);
/// Longest silence towards the server.
const SILENCE: Duration = Duration::from_secs(30);
/// ERR of a full queue.
const QUEUE_FULL: i16 = 43;
/// Executions that are watched to their end: what the server keeps.
const WATCHED: usize = 4096;

/// What to do with a coordinated move when the queue is full.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum QueueFull {
    /// Call it again in the next tick.
    #[default]
    Wait,
    /// Let it err with 43.
    Error,
}

/// What to do when an instruction errs.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum OnError {
    /// End the program.
    #[default]
    Stop,
    /// Go on with the next statement.
    KeepGoing,
}

/// Why a program did not run to its end.
#[derive(Debug, thiserror::Error)]
pub enum ProgramError {
    /// It cannot be read, or names what is not there.
    #[error(transparent)]
    Syntax(#[from] SyntaxError),
    /// An operation has no result.
    #[error(transparent)]
    Runtime(#[from] RuntimeError),
    /// A WAIT can no longer come true: what it waits for has ended without it.
    #[error(transparent)]
    Hopeless(#[from] Hopeless),
    /// The server refused, or is gone.
    #[error("line {line}: {source}")]
    Client {
        /// Line of the statement, from 1.
        line: usize,
        /// Why.
        source: ClientError,
    },
}

/// Something worth telling while a program runs.
#[derive(Debug)]
pub enum Event<'a> {
    /// An instruction was executed.
    Executed {
        /// Line of the call.
        line: usize,
        /// What was executed.
        execution: &'a Execution,
    },
    /// An instruction erred.
    Erred {
        /// Line of the call.
        line: usize,
        /// The instruction.
        mnemonic: Mnemonic,
        /// Its target.
        target: &'a str,
        /// Why.
        error: &'a ClientError,
    },
    /// The motion of an instruction ended before its end, though no instruction of the program ended it.
    Ended {
        /// Line of the call.
        line: usize,
        /// The execution.
        execution: &'a Execution,
        /// What ended it.
        ended: &'a Ended,
    },
}

/// A program on its way.
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
    interpreter: Interpreter,
    queue_full: QueueFull,
    on_error: OnError,
    /// Time between two looks at a WAIT or a full queue.
    tick: Duration,
    executions: VecDeque<(usize, Execution)>,
    /// The newest execution of each motion control tag, by its name in small letters.
    newest: BTreeMap<String, (usize, Execution)>,
    /// The tags of `newest` that a WAIT has read and that cannot change any more.
    settled: Vec<String>,
}

impl<'c> Runner<'c> {
    /// A whole program.
    ///
    /// # Errors
    /// [`ProgramError::Syntax`] when it cannot be read or a name means nothing; what browsing meets.
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
        let interpreter = Interpreter::new(program);
        let (queue_full, on_error) = (QueueFull::default(), OnError::default());
        Ok(Self {
            client,
            interpreter,
            queue_full,
            on_error,
            tick,
            executions: VecDeque::new(),
            newest: BTreeMap::new(),
            settled: Vec::new(),
        })
    }

    /// With another answer to a full queue than waiting.
    #[must_use]
    pub fn queue_full(self, queue_full: QueueFull) -> Self {
        Self { queue_full, ..self }
    }

    /// With another answer to an error than stopping.
    #[must_use]
    pub fn on_error(self, on_error: OnError) -> Self {
        Self { on_error, ..self }
    }

    /// The newest executions with their lines, oldest first; at most 4,096.
    pub fn executions(&self) -> impl Iterator<Item = (usize, &Execution)> {
        self.executions.iter().map(|(line, execution)| (*line, execution))
    }

    /// Objects on which instructions have been executed, each once.
    pub fn targets(&self) -> Vec<(Object, String)> {
        let mut targets = Vec::new();
        for (_, execution) in &self.executions {
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
        let mut answer = Answer::Start;
        loop {
            let request = self.interpreter.resume(answer)?;
            let line = self.interpreter.line();
            let answered = match request {
                Request::End => return Ok(()),
                Request::Read(path) => self.read(&path).await,
                Request::ReadArray(path) => self.client.read_numbers(&path.to_string()).await.map(Answer::Array),
                Request::Write(path, value) => self
                    .client
                    .write(&path.to_string(), WriteValue::from(value))
                    .await
                    .map(|()| Answer::Done),
                Request::GetAttribute(of) => {
                    let value = self.client.attribute(of.attribute, &of.name).await;
                    value.map(|value| Answer::Value(Value::Lreal(value)))
                }
                Request::SetAttribute(of, value) => {
                    let done = self.client.set_attribute(of.attribute, &of.name, value).await;
                    done.map(|()| Answer::Done)
                }
                Request::Call(call) => self.execute(call, on_event).await,
                Request::NextTick => {
                    if self.interpreter.is_hopeless()
                        && let Some(hopeless) = self.hopeless(line).await?
                    {
                        return Err(hopeless.into());
                    }
                    self.settled.clear();
                    tokio::time::sleep(self.tick).await;
                    Ok(Answer::Done)
                }
                Request::Delay(seconds) => self.delay(seconds).await.map(|()| Answer::Done),
            };
            answer = answered.map_err(|source| ProgramError::Client { line, source })?;
        }
    }

    /// Waits until all motion that the program began and that has an end has come to it.
    ///
    /// # Errors
    /// [`ProgramError::Client`] when an instruction errs while it runs, or the server is gone.
    pub async fn finish(&mut self, on_event: &mut (dyn FnMut(Event<'_>) + Send)) -> Result<(), ProgramError> {
        while let Some((line, execution)) = self.executions.front() {
            let fail = |source| ProgramError::Client { line: *line, source };
            match self.client.instruction(execution.instance).await {
                Ok(control) if control.has(Flag::Er) => {
                    let (err, exerr) = (control.err, control.exerr);
                    let error = ClientError::Motion {
                        mnemonic: Some(execution.mnemonic),
                        err,
                        exerr,
                    };
                    let (mnemonic, target) = (execution.mnemonic, execution.target.as_str());
                    on_event(Event::Erred {
                        line: *line,
                        mnemonic,
                        target,
                        error: &error,
                    });
                    if self.on_error == OnError::Stop {
                        return Err(fail(error));
                    }
                }
                Ok(control) if control.has(Flag::Ip) && execution.completes() => {
                    tokio::time::sleep(POLL).await;
                    continue;
                }
                Ok(control) if execution.completes() && !control.has(Flag::Pc) => {
                    let ended = self.client.ending(execution.instance).await.map_err(fail)?;
                    if let Some(ended) = ended.filter(|ended| !self.is_own(&ended.ending)) {
                        on_event(Event::Ended {
                            line: *line,
                            execution,
                            ended: &ended,
                        });
                        if self.on_error == OnError::Stop && matches!(ended.ending, Ending::Fault { .. }) {
                            let (flag, ended) = (Flag::Pc, Some(Box::new(ended)));
                            return Err(fail(ClientError::Ended { flag, control, ended }));
                        }
                    }
                }
                Ok(_) => {}
                // So old that the server has dropped it: it has ended.
                Err(ClientError::Refused { status, .. }) if status.is(CipStatus::OBJECT_DOES_NOT_EXIST) => {}
                Err(error) => return Err(fail(error)),
            }
            self.executions.pop_front();
        }
        Ok(())
    }

    /// Whether an instruction of the program ended another one.
    fn is_own(&self, ending: &Ending) -> bool {
        matches!(ending, Ending::Instruction { tag, .. } if self.newest.contains_key(&tag.to_ascii_lowercase()))
    }

    async fn execute(
        &mut self,
        call: BoundCall,
        on_event: &mut (dyn FnMut(Event<'_>) + Send),
    ) -> Result<Answer, ClientError> {
        let BoundCall {
            mnemonic,
            target,
            control,
            given,
            line,
        } = call;
        if self.queue_full == QueueFull::Wait
            && mnemonic.instruction().takes_place(&given)
            && self.is_full(&target).await?
        {
            return Ok(Answer::QueueFull);
        }
        let control = control.unwrap_or_default();
        match self.client.execute(mnemonic, &target, &control, &given).await {
            Ok(execution) => {
                on_event(Event::Executed {
                    line,
                    execution: &execution,
                });
                if self.executions.len() == WATCHED {
                    self.executions.pop_front();
                }
                if !execution.tag.is_empty() {
                    self.newest
                        .insert(execution.tag.to_ascii_lowercase(), (line, execution.clone()));
                }
                self.executions.push_back((line, execution));
                Ok(Answer::Done)
            }
            Err(ClientError::Motion { err: QUEUE_FULL, .. }) if self.queue_full == QueueFull::Wait => {
                Ok(Answer::QueueFull)
            }
            Err(error) => {
                if error.motion().is_some() {
                    on_event(Event::Erred {
                        line,
                        mnemonic,
                        target: &target,
                        error: &error,
                    });
                    if self.on_error == OnError::KeepGoing {
                        return Ok(Answer::Done);
                    }
                }
                Err(error)
            }
        }
    }

    /// Looked at first, so that a call that waits leaves no error in its tag and takes no instance on the server.
    async fn is_full(&self, system: &str) -> Result<bool, ClientError> {
        match self.client.read(&format!("{system}.MovePendingQueueFullStatus")).await {
            Ok(reading) => Ok(reading.as_bool().unwrap_or_default()),
            Err(error) if error.is_connection() => Err(error),
            // Not a coordinate system: the call says so better.
            Err(_) => Ok(false),
        }
    }

    /// Asks now and then, so that the server does not take the silence for a lost client.
    async fn delay(&self, seconds: f64) -> Result<(), ClientError> {
        let mut left = Duration::try_from_secs_f64(seconds).unwrap_or(Duration::MAX);
        while left > SILENCE {
            tokio::time::sleep(SILENCE).await;
            left -= SILENCE;
            self.client.identify().await?;
        }
        tokio::time::sleep(left).await;
        Ok(())
    }

    /// The value of a tag; a member of a motion control tag that has not been made yet is 0.
    async fn read(&mut self, path: &TagPath) -> Result<Answer, ClientError> {
        if let Some(answer) = self.read_control(path).await? {
            return Ok(answer);
        }
        let value = match self.client.read(&path.to_string()).await {
            Ok(reading) => reading.value().ok_or_else(|| ClientError::NoNumber {
                path: path.to_string(),
                type_name: reading.type_name(),
            }),
            Err(error @ ClientError::UnknownTag { .. }) => unmade_control(path).ok_or(error),
            Err(error) => Err(error),
        };
        value.map(Answer::Value)
    }

    /// The value of a member of a motion control tag that the program has used: the whole tag is read, since its bits tell
    /// whether it can still change. `None`: it is something else.
    async fn read_control(&mut self, path: &TagPath) -> Result<Option<Answer>, ClientError> {
        let [PathSegment::Symbol(tag), PathSegment::Symbol(member)] = path.0.as_slice() else {
            return Ok(None);
        };
        let key = tag.to_ascii_lowercase();
        if !self.newest.contains_key(&key) {
            return Ok(None);
        }
        let control = self.client.read(tag).await?;
        let Some(value) = control.member(member).and_then(TagValue::value) else {
            return Ok(None);
        };
        let has = |flag: Flag| control.flag(flag.name());
        if (has(Flag::Dn) || has(Flag::Er)) && !has(Flag::Ip) && !has(Flag::Ac) {
            self.settled.push(key);
            return Ok(Some(Answer::Settled(value)));
        }
        Ok(Some(Answer::Value(value)))
    }

    /// Why a WAIT cannot come true any more; `None` when an instruction has begun again since the tags were read.
    async fn hopeless(&self, line: usize) -> Result<Option<Hopeless>, ProgramError> {
        let mut found = None;
        for key in &self.settled {
            let Some((called, execution)) = self.newest.get(key) else {
                continue;
            };
            let fail = |source| ProgramError::Client { line, source };
            let control = self.client.instruction(execution.instance).await.map_err(fail)?;
            if !control.has_ended() {
                return Ok(None);
            }
            let ended = self.client.ending(execution.instance).await.map_err(fail)?;
            let call = Some((execution.mnemonic, *called));
            let ending = ended.as_ref().map(|ended| &ended.ending);
            let hopeless = Hopeless::new(line, &execution.tag, call, &control, ending);
            if !control.has(Flag::Pc) {
                return Ok(Some(hopeless));
            }
            found.get_or_insert(hopeless);
        }
        Ok(found)
    }
}

/// The coarse update period; `None` when the server, perhaps another make, does not tell it.
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
