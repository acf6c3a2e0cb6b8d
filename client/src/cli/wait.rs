//! Waiting for motion: progress on a terminal, and Ctrl-C, which stops the motion.

use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};
use tokio::signal::unix::{SignalKind, signal};

use arcline_client::{
    Client, ClientError, Ended, Execution, Flag, Mnemonic, MotionControl, Object, Operands, UnboundOperand,
};
use arcline_instruction_set::Ending;

use super::{Failure, Output};

/// No deadline of our own: the user has Ctrl-C.
pub(crate) const FOREVER: Duration = Duration::from_secs(365 * 24 * 3600);
/// Time for a stop to come to its end.
const STOPPING: Duration = Duration::from_secs(60);
/// Time between two updates of the progress.
const REFRESH: Duration = Duration::from_millis(100);
/// MCS, Stop Type: Coordinated Move.
const COORDINATED_MOVE: i64 = 2;
/// MAS, Stop Type: everything on the axis.
const ALL: i64 = 0;
/// MAS, Stop Type: Jog.
const JOG: i64 = 1;
/// MAS, Stop Type: Move.
const MOVE: i64 = 2;

/// The end of an instruction.
#[derive(Clone, Debug)]
pub(crate) struct Completed {
    /// The status of its motion control tag.
    pub(crate) control: MotionControl,
    /// The cause of the end, of an instruction without an end of its own.
    pub(crate) ended: Option<Box<Ended>>,
}

impl From<MotionControl> for Completed {
    fn from(control: MotionControl) -> Self {
        Completed { control, ended: None }
    }
}

/// Waits for PC, or for the end of an instruction that has none. Ctrl-C stops the motion and fails with [`Failure::Interrupted`].
///
/// A jog, which has no PC, ends as it should when another instruction ends it. A fault, a stop of the whole machine and the loss of
/// its client end it with [`Failure::Ended`].
pub(crate) async fn complete(
    client: &Client,
    execution: &Execution,
    length: Option<f64>,
    output: &Output,
) -> Result<Completed, Failure> {
    let stopping = StopCommand::of(execution);
    tokio::select! {
        result = watched(client, execution, length, output) => match result {
            Err(ClientError::Ended { control, ended, .. }) if !execution.completes() => match ended {
                Some(ended) if !matches!(ended.ending, Ending::Instruction { .. }) => Err(Failure::Ended {
                    mnemonic: execution.mnemonic,
                    target: execution.target.clone(),
                    ended,
                }),
                ended => Ok(Completed { control, ended }),
            },
            Err(error @ ClientError::Forgotten { .. }) => Err(at_rest(client, execution, error, output).await),
            result => Ok(result?.into()),
        },
        () = interrupted() => Err(interrupt(client, stopping, output).await),
    }
}

/// Waits until the object of an instruction that the server no longer knows is at rest: until then Ctrl-C still stops it. The failure of
/// the wait, since the end of the instruction is not known.
async fn at_rest(client: &Client, execution: &Execution, error: ClientError, output: &Output) -> Failure {
    let target = &execution.target;
    output.note(&format!("{error}: waiting until {target} is at rest, Ctrl-C stops it"));
    loop {
        match client.is_moving(target).await {
            Ok(true) => tokio::time::sleep(REFRESH).await,
            Ok(false) => return error.into(),
            Err(error) => return error.into(),
        }
    }
}

/// The stop that Ctrl-C executes: an instruction, its Stop Type and its target.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct StopCommand {
    mnemonic: Mnemonic,
    kind: i64,
    target: String,
}

impl StopCommand {
    /// The stop of one execution.
    fn of(execution: &Execution) -> Option<Self> {
        let stopping = Self::all(execution.mnemonic.instruction().object, execution.target.clone())?;
        let kind = match execution.mnemonic {
            Mnemonic::Maj => JOG,
            Mnemonic::Mam => MOVE,
            _ => stopping.kind,
        };
        Some(StopCommand { kind, ..stopping })
    }

    /// The stop of all motion that instructions on an object can have begun.
    pub(crate) fn all(object: Object, target: String) -> Option<Self> {
        let (mnemonic, kind) = match object {
            Object::CoordinateSystem => (Mnemonic::Mcs, COORDINATED_MOVE),
            Object::Axis => (Mnemonic::Mas, ALL),
            Object::MotionGroup => return None,
        };
        Some(StopCommand { mnemonic, kind, target })
    }

    /// Executes the stop; the motion ends later.
    pub(crate) async fn begin(&self, client: &Client) -> Result<Execution, ClientError> {
        let StopCommand { mnemonic, kind, target } = self;
        let operands = Operands::full_speed(*mnemonic).with("Stop Type", UnboundOperand::Integer(*kind))?;
        client.execute(*mnemonic, target, "", operands.as_slice()).await
    }
}

/// Waits for Ctrl-C, the end of the terminal or SIGTERM; forever if these signals are not available.
pub(crate) async fn interrupted() {
    let hangs_up = async {
        // The program was started to survive its terminal.
        if !is_hangup_ignored() {
            signalled(SignalKind::hangup()).await;
        } else {
            std::future::pending::<()>().await;
        }
    };
    tokio::select! {
        () = signalled(SignalKind::interrupt()) => {}
        () = signalled(SignalKind::terminate()) => {}
        () = hangs_up => {}
    }
}

async fn signalled(kind: SignalKind) {
    match signal(kind) {
        Ok(mut signals) => drop(signals.recv().await),
        Err(_) => std::future::pending().await,
    }
}

/// Whether the program was started with SIGHUP ignored, as `nohup` does it.
fn is_hangup_ignored() -> bool {
    let Ok(status) = std::fs::read_to_string("/proc/self/status") else {
        return false;
    };
    let ignored = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let ignored = ignored.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok());
    // The first bit is that of signal 1.
    ignored.is_some_and(|mask| mask & 1 != 0)
}

/// Stops the motion and reports it.
pub(crate) async fn interrupt(
    client: &Client,
    stops: impl IntoIterator<Item = StopCommand>,
    output: &Output,
) -> Failure {
    for stopping in stops {
        let target = &stopping.target;
        match stop(client, &stopping).await {
            Ok(()) => output.result(format!("interrupted: {target} is stopped"), || {
                serde_json::json!({"interrupted": true, "stopped": target})
            }),
            Err(error) => output.result(format!("interrupted: {target} could not be stopped: {error}"), || {
                serde_json::json!({"interrupted": true, "stopped": null, "target": target, "error": error.to_string()})
            }),
        }
    }
    Failure::Interrupted
}

async fn stop(client: &Client, stopping: &StopCommand) -> Result<(), ClientError> {
    let execution = stopping.begin(client).await?;
    client.wait_for(&execution, Flag::Pc, STOPPING).await.map(drop)
}

async fn watched(
    client: &Client,
    execution: &Execution,
    length: Option<f64>,
    output: &Output,
) -> Result<MotionControl, ClientError> {
    let waiting = client.wait_for(execution, Flag::Pc, FOREVER);
    if !output.is_watched() || execution.mnemonic.instruction().object == Object::MotionGroup {
        return waiting.await;
    }
    tokio::select! {
        result = waiting => result,
        error = show(client, execution, length) => Err(error),
    }
}

/// Shows the progress until it is dropped; returns only when the server does not answer.
async fn show(client: &Client, execution: &Execution, length: Option<f64>) -> ClientError {
    let bar = match length {
        Some(_) => ProgressBar::new(1000).with_style(style("{prefix} [{bar:30}] {msg}")),
        None => ProgressBar::new_spinner().with_style(style("{prefix} {spinner} {msg}")),
    };
    let _cleared = Cleared(bar.clone());
    bar.set_prefix(format!("{} {}", execution.mnemonic, execution.target));
    // The position of a rotary axis jumps at the unwind; its velocity does not.
    let single = execution.mnemonic.instruction().object == Object::Axis;
    let member = if single { "ActualVelocity" } else { "ActualPosition" };
    let path = format!("{}.{member}", execution.target);
    let mut odometer = Odometer::default();
    loop {
        match client.read_numbers(&path).await {
            Ok(velocity) if single => odometer.moving(velocity.first().map_or(0.0, |v| v.abs()), Instant::now()),
            Ok(position) => odometer.at(position, Instant::now()),
            Err(error) => return error,
        }
        if let Some(length) = length.filter(|length| *length > 0.0) {
            bar.set_position((1000.0 * (odometer.distance / length).clamp(0.0, 1.0)) as u64);
        }
        bar.set_message(odometer.message(length));
        bar.tick();
        tokio::time::sleep(REFRESH).await;
    }
}

/// Takes the progress off the terminal, however the waiting ends.
struct Cleared(ProgressBar);

impl Drop for Cleared {
    fn drop(&mut self) {
        self.0.finish_and_clear();
    }
}

fn style(template: &str) -> ProgressStyle {
    ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar())
}

/// Distance and speed out of positions.
#[derive(Debug, Default)]
struct Odometer {
    last: Option<(Vec<f64>, Instant)>,
    /// Position units.
    distance: f64,
    /// Position units per second.
    speed: f64,
}

impl Odometer {
    fn at(&mut self, position: Vec<f64>, now: Instant) {
        if let Some((last, then)) = &self.last {
            let step = last
                .iter()
                .zip(&position)
                .map(|(a, b)| (b - a).powi(2))
                .sum::<f64>()
                .sqrt();
            let time = now.duration_since(*then).as_secs_f64();
            self.distance += step;
            self.speed = if time > 0.0 { step / time } else { 0.0 };
        }
        self.last = Some((position, now));
    }

    /// Follows the motion by its speed.
    fn moving(&mut self, speed: f64, now: Instant) {
        if let Some((_, then)) = &self.last {
            self.distance += 0.5 * (self.speed + speed) * now.duration_since(*then).as_secs_f64();
        }
        self.speed = speed;
        self.last = Some((Vec::new(), now));
    }

    fn message(&self, length: Option<f64>) -> String {
        let (distance, speed) = (self.distance, self.speed);
        match length {
            Some(length) if speed > 0.0 => {
                let left = (length - distance).max(0.0) / speed;
                format!("{distance:.1} of {length:.1}, {speed:.1}/s, about {left:.1} s left")
            }
            Some(length) => format!("{distance:.1} of {length:.1}"),
            None => format!("{distance:.1} done, {speed:.1}/s"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distance_and_speed_come_from_positions() {
        let start = Instant::now();
        let mut odometer = Odometer::default();
        odometer.at(vec![0.0, 0.0], start);
        assert_eq!(odometer.message(Some(10.0)), "0.0 of 10.0");
        odometer.at(vec![3.0, 4.0], start + Duration::from_secs(2));
        assert_eq!(odometer.message(Some(10.0)), "5.0 of 10.0, 2.5/s, about 2.0 s left");
        assert_eq!(odometer.message(None), "5.0 done, 2.5/s");
        let mut odometer = Odometer::default();
        odometer.moving(0.0, start);
        odometer.moving(10.0, start + Duration::from_secs(1));
        odometer.moving(10.0, start + Duration::from_secs(2));
        assert_eq!(odometer.message(None), "15.0 done, 10.0/s");
    }
}
