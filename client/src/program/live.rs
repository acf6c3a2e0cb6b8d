//! The answers of a live server to a program.

use std::time::Duration;

use arcline_instruction_set::{Flag, Mnemonic, MotionControl};
use arcline_proto::cip::CipStatus;
use arcline_structured_text::{
    Called, Calls, Driver, EvaluatedCall, Moves, ObjectAttribute, Outcome, Pause, Progress, Reading, Stopped,
    is_status, pause_of_queue, unmade_control,
};
use arcline_tag::{PathSegment, TagPath, Value};

use super::Event;
use crate::{Client, ClientError, Execution, TagValue, WriteValue};

/// Time between two reads of motion that must end.
const POLL: Duration = Duration::from_millis(5);
/// Moves of a program that are executed together.
const LONGEST_SERIES: usize = 64;
/// Longest silence towards the server.
const SILENCE: Duration = Duration::from_secs(30);

/// A server on which a program runs.
pub(super) struct Live<'r> {
    client: &'r Client,
    /// Time between two evaluations of a WAIT or of a full queue.
    tick: Duration,
    /// Whether the server executes series of moves, as far as the client knows.
    has_series: &'r mut bool,
    on_event: &'r mut (dyn FnMut(Event<'_>) + Send),
}

impl<'r> Live<'r> {
    pub(super) fn new(
        client: &'r Client,
        tick: Duration,
        has_series: &'r mut bool,
        on_event: &'r mut (dyn FnMut(Event<'_>) + Send),
    ) -> Self {
        Self {
            client,
            tick,
            has_series,
            on_event,
        }
    }
}

impl Driver for Live<'_> {
    type Error = ClientError;
    type Execution = Execution;

    // A look is a request.
    const MOST_READS: usize = 1;

    async fn turn(&mut self, _line: usize) -> Result<(), ClientError> {
        Ok(())
    }

    async fn read(&mut self, path: &TagPath, calls: &Calls<Execution>) -> Result<Reading, ClientError> {
        if let Some(reading) = read_control(self.client, path, calls).await? {
            return Ok(reading);
        }
        let value = match self.client.read(&path.to_string()).await {
            Ok(reading) => reading.value().ok_or_else(|| ClientError::NoNumber {
                path: path.to_string(),
                type_name: reading.type_name(),
            }),
            Err(error @ ClientError::UnknownTag { .. }) => unmade_control(path).ok_or(error),
            Err(error) => Err(error),
        };
        value.map(Reading::Value)
    }

    async fn read_array(&mut self, path: &TagPath) -> Result<Vec<f64>, ClientError> {
        self.client.read_numbers(&path.to_string()).await
    }

    async fn write(&mut self, path: &TagPath, value: Value) -> Result<(), ClientError> {
        self.client.write(&path.to_string(), WriteValue::from(value)).await
    }

    async fn enable(
        &mut self,
        path: &TagPath,
        value: Value,
    ) -> Result<Option<(Mnemonic, Progress<ClientError>)>, ClientError> {
        let tag = path.tag().unwrap_or_default();
        let mnemonic = match self.client.tag(tag).await {
            Ok(known) => known.type_name().parse::<Mnemonic>().ok(),
            Err(_) => None,
        };
        let path = path.to_string();
        let executes = match mnemonic {
            Some(_) => self.client.read(&path).await?.as_bool() == Some(false),
            None => false,
        };
        self.client.write(&path, WriteValue::from(value)).await?;
        let Some(mnemonic) = mnemonic.filter(|_| executes) else {
            return Ok(None);
        };
        let control = status_of(&self.client.read(tag).await?);
        Ok(Some((mnemonic, progress(mnemonic, &control))))
    }

    async fn attribute(&mut self, of: &ObjectAttribute) -> Result<f64, ClientError> {
        self.client.attribute(of.attribute, &of.name).await
    }

    async fn set_attribute(&mut self, of: &ObjectAttribute, value: f64) -> Result<(), ClientError> {
        self.client.set_attribute(of.attribute, &of.name, value).await
    }

    async fn has_room(&mut self, call: &EvaluatedCall) -> Result<bool, ClientError> {
        let full = format!("{}.MovePendingQueueFullStatus", call.target);
        match self.client.read(&full).await {
            Ok(reading) => Ok(!reading.as_bool().unwrap_or_default()),
            Err(error) if error.is_connection() => Err(error),
            // The object is not a coordinate system: the call itself reports that better.
            Err(_) => Ok(true),
        }
    }

    fn longest_series(&self) -> usize {
        if *self.has_series { LONGEST_SERIES } else { 1 }
    }

    async fn moves(&mut self, series: &[EvaluatedCall]) -> Result<Moves<Execution, ClientError>, ClientError> {
        if *self.has_series
            && let Some(moves) = self.client.execute_series(series).await?
        {
            for (call, execution) in series.iter().zip(&moves.executed) {
                (self.on_event)(Event::Executed {
                    line: call.line,
                    execution,
                });
            }
            return Ok(moves);
        }
        *self.has_series = false;
        self.first_move(series).await
    }

    async fn call(&mut self, call: &EvaluatedCall) -> Result<Execution, ClientError> {
        let control = call.control.as_deref().unwrap_or_default();
        let executed = self
            .client
            .execute(call.mnemonic, &call.target, control, &call.operands);
        let execution = executed.await?;
        (self.on_event)(Event::Executed {
            line: call.line,
            execution: &execution,
        });
        Ok(execution)
    }

    async fn pause(&mut self, pause: Pause<'_>) -> Result<(), ClientError> {
        match pause {
            Pause::Tick | Pause::Condition | Pause::Room(_) => tokio::time::sleep(self.tick).await,
            Pause::Queue { depth } => tokio::time::sleep(pause_of_queue(self.tick, depth)).await,
            Pause::Motion => tokio::time::sleep(POLL).await,
            Pause::Seconds(seconds) => delay(self.client, seconds).await?,
        }
        Ok(())
    }

    async fn progress(&mut self, called: &Called<Execution>) -> Result<Progress<ClientError>, ClientError> {
        let Some(execution) = &called.execution else {
            let control = status_of(&self.client.read(&called.tag).await?);
            return Ok(progress(called.mnemonic, &control));
        };
        let control = match self.client.instruction(execution.instance).await {
            // The execution is so old that the server has dropped it: it has ended.
            Err(ClientError::Refused { status, .. }) if status.is(CipStatus::OBJECT_DOES_NOT_EXIST) => None,
            Err(error) => return Err(error),
            Ok(control) => Some(control),
        };
        let progress = control.map_or(Progress::Ended, |control| progress(execution.mnemonic, &control));
        if !matches!(progress, Progress::Running) {
            (self.on_event)(Event::Completed { line: called.line });
        }
        Ok(progress)
    }

    async fn stopped(&mut self, called: &Called<Execution>) -> Result<Option<Stopped<ClientError>>, ClientError> {
        let Some(execution) = &called.execution else {
            return Ok(None);
        };
        let Some(ended) = self.client.ending(execution.instance).await? else {
            return Ok(None);
        };
        let control = self.client.instruction(execution.instance).await?;
        Ok(Some(Stopped {
            ending: ended.ending.clone(),
            error: ClientError::Ended {
                flag: Flag::Pc,
                control,
                ended: Some(Box::new(ended)),
            },
        }))
    }

    async fn outcome(&mut self, tag: &str, called: Option<&Called<Execution>>) -> Result<Outcome, ClientError> {
        let (control, ending) = match called.and_then(|called| called.execution.as_ref()) {
            Some(execution) => {
                let control = self.client.instruction(execution.instance).await?;
                (control, self.client.ending(execution.instance).await?)
            }
            None => (status_of(&self.client.read(tag).await?), None),
        };
        Ok(Outcome {
            call: called.map(|called| (called.mnemonic, called.line)),
            control,
            ending: ending.map(|ended| ended.ending),
        })
    }

    fn err(error: &ClientError) -> Option<i16> {
        error.motion().map(|(err, _)| err)
    }

    fn report(&mut self, called: &Called<Execution>, error: &ClientError) {
        let line = called.line;
        let event = match (error, &called.execution) {
            (ClientError::Ended { ended: Some(ended), .. }, Some(execution)) => Event::Ended { line, execution, ended },
            _ => Event::Erred {
                line,
                mnemonic: called.mnemonic,
                target: &called.target,
                error,
            },
        };
        (self.on_event)(event);
    }
}

/// The progress that the status of an instruction shows.
fn progress(mnemonic: Mnemonic, control: &MotionControl) -> Progress<ClientError> {
    Progress::of(mnemonic, control, || ClientError::Motion {
        mnemonic: Some(mnemonic),
        err: control.err,
        exerr: control.exerr,
    })
}

/// The member of a motion control tag that the program has used, or the status of an instruction tag whose EnableIn it has set. The client
/// reads the whole tag, since its bits show whether it can still change. `None`: the path is not that of such a member.
async fn read_control(
    client: &Client,
    path: &TagPath,
    calls: &Calls<Execution>,
) -> Result<Option<Reading>, ClientError> {
    let Some(tag) = path.tag().filter(|tag| calls.newest(tag).is_some() && is_status(path)) else {
        return Ok(None);
    };
    let reading = client.read(tag).await?;
    // The path of a status bit of an instruction tag may omit `MotionControl`.
    let control = reading.member(MOTION_CONTROL);
    let status = control.unwrap_or(&reading);
    let value = match &path.0[1..] {
        [PathSegment::Symbol(member)] => status.member(member),
        [PathSegment::Symbol(_), PathSegment::Symbol(member)] if control.is_some() => status.member(member),
        _ => None,
    };
    let value = value.and_then(TagValue::value);
    Ok(value.map(|value| match control_of(status).has_ended() {
        true => Reading::Settled(value),
        false => Reading::Value(value),
    }))
}

/// Asks now and then, so that the server does not take the silence for a lost client.
async fn delay(client: &Client, seconds: f64) -> Result<(), ClientError> {
    let mut left = Duration::try_from_secs_f64(seconds).unwrap_or(Duration::MAX);
    while left > SILENCE {
        tokio::time::sleep(SILENCE).await;
        left -= SILENCE;
        client.identify().await?;
    }
    tokio::time::sleep(left).await;
    Ok(())
}

/// The status that a motion control tag or an instruction tag shows.
fn status_of(reading: &TagValue) -> MotionControl {
    control_of(reading.member(MOTION_CONTROL).unwrap_or(reading))
}

/// The member of an instruction tag that is its MOTION_INSTRUCTION.
const MOTION_CONTROL: &str = "MotionControl";

/// The bits, ERR and EXERR of a motion control tag that was read.
fn control_of(reading: &TagValue) -> MotionControl {
    let mut control = MotionControl::default();
    Flag::ALL
        .into_iter()
        .filter(|flag| reading.flag(flag.name()))
        .for_each(|flag| control.set(flag));
    let number = |name| reading.member(name).and_then(TagValue::as_f64).unwrap_or_default();
    control.err = number("ERR") as i16;
    control.exerr = number("EXERR") as i8;
    control
}
