//! `trace`: every tick of some signals into a file, as they come, by the trace of `arcline_client`.

mod csv;

use std::collections::BTreeSet;
use std::fs::File;
use std::io::{self, BufWriter, ErrorKind};
use std::time::Duration;

use serde_json::json;

use arcline_client::{Client, ClientError, Object, TraceRequest, TraceState, Trigger, nearest};

use arcline_mcap::Mcap;

use super::args::Trace;
use super::output::{counted, is_standard_output};
use super::{Failure, Output, wait};
use csv::Csv;

/// Time between two looks when there is nothing new.
const POLL: Duration = Duration::from_millis(20);
/// The signals of an axis, as those of a trace of `simulate` (spec/contract.md §1).
const OF_AXIS: [&str; 4] = [
    "CommandPosition",
    "CommandVelocity",
    "CommandAcceleration",
    "ActualPosition",
];
/// The signals of a coordinate system.
const OF_SYSTEM: [&str; 2] = ["PathSpeed", "PathPosition"];
/// The further signals of a robot.
const OF_ROBOT: [&str; 3] = ["ToolX", "ToolY", "ToolZ"];

/// The output file of the rows.
enum Sink {
    Csv(Csv),
    Mcap(Mcap<BufWriter<File>>),
}

/// `trace`.
pub(crate) async fn trace(client: &Client, command: &Trace, output: &Output) -> Result<(), Failure> {
    let period = client.trace_period().await?.max(Duration::from_nanos(1));
    let signals = signals(client, &command.names).await?;
    let ticks = |seconds: f64| (seconds / period.as_secs_f64()).round().clamp(1.0, f64::from(u32::MAX)) as u32;
    let request = TraceRequest {
        signals,
        before: command.before.map_or(0, ticks),
        length: command.duration.map_or(0, ticks),
        every: command.every,
        trigger: command.trigger.as_ref().map(|text| text.0.clone()).unwrap_or_default(),
    };
    let at = |source| Failure::at(&command.output, source);
    let is_standard = is_standard_output(&command.output);
    if is_standard && output.is_json() {
        return Err(Failure::Usage(
            "the standard output takes a trace as CSV: leave out --json".to_owned(),
        ));
    }
    let is_mcap = !is_standard
        && match command.output.extension().and_then(|ending| ending.to_str()) {
            Some(ending) if ending.eq_ignore_ascii_case("csv") => false,
            Some(ending) if ending.eq_ignore_ascii_case("mcap") => true,
            _ => {
                let shown = command.output.display();
                return Err(Failure::Usage(format!(
                    "{shown} ends neither in .csv nor in .mcap, and is not -, the standard output"
                )));
            }
        };
    let mut sink = if is_mcap {
        let file = BufWriter::new(File::create(&command.output).map_err(at)?);
        Sink::Mcap(Mcap::new(file, &request.signals, period).map_err(at)?)
    } else {
        Sink::Csv(Csv::create(&command.output, &request.signals, period).map_err(at)?)
    };
    tell_unmade(client, &request.trigger, output).await?;
    let instance = client.start_trace(&request).await?;
    let result = follow(client, instance, &mut sink, command, output).await;
    // The server would forget it in a minute anyway.
    let _ = client.delete_trace(instance).await;
    let finished = match sink {
        Sink::Csv(mut csv) => csv.flush(),
        Sink::Mcap(mcap) => mcap.finish(),
    };
    is_wanted(finished, command)?;
    let Taken { rows, missing } = result?;
    let (shown, width) = (command.output.display().to_string(), request.signals.len());
    let gap = if missing == 0 {
        "no gap".to_owned()
    } else {
        format!("{} missing", counted(missing, "tick"))
    };
    let text = format!("{} of {}, {gap}", counted(rows, "row"), counted(width, "signal"));
    if is_standard {
        output.note(&text);
        return Ok(());
    }
    output.result(
        format!("{shown}: {text}"),
        || json!({"trace": shown, "rows": rows, "signals": request.signals, "missing": missing}),
    );
    Ok(())
}

/// Says so when a trigger waits for a motion control tag that nothing has made yet: it may be a slip.
async fn tell_unmade(client: &Client, trigger: &Trigger, output: &Output) -> Result<(), Failure> {
    let Trigger::Instruction { name, .. } = trigger else {
        return Ok(());
    };
    let known = client.instruction_names().await?;
    if !known.iter().any(|known| known.eq_ignore_ascii_case(name)) {
        let near = nearest(name, &known).map(|near| format!(", did you mean {near:?}?"));
        output.note(&format!(
            "no instruction has made {name:?} yet{}",
            near.unwrap_or_default()
        ));
    }
    Ok(())
}

/// The rows and missing ticks of the file.
#[derive(Clone, Copy, Debug, Default)]
struct Taken {
    rows: u64,
    /// Ticks that were not there any more, or never.
    missing: u64,
}

/// Writes rows until the trace has ended, or Ctrl-C ends it.
async fn follow(
    client: &Client,
    instance: u32,
    sink: &mut Sink,
    command: &Trace,
    output: &Output,
) -> Result<Taken, Failure> {
    let mut taken = Taken::default();
    let mut from = 0;
    let mut interrupted = std::pin::pin!(wait::interrupted());
    let (mut waited, mut told) = (false, false);
    loop {
        let read = client.read_trace(instance, from).await?;
        if read.rows.is_empty() {
            if read.state == TraceState::Ended {
                return Ok(taken);
            }
            // From the second read on: then the program handles Ctrl-C.
            if read.state == TraceState::Armed && waited && !told {
                told = true;
                output.note("waiting for the trigger");
            }
            waited = true;
            tokio::select! {
                () = tokio::time::sleep(POLL) => {}
                // Rows that the server recorded until then still go into the file.
                () = &mut interrupted => {
                    client.stop_trace(instance).await?;
                    interrupted.set(wait::interrupted());
                }
            }
            continue;
        }
        if taken.rows > 0 {
            taken.missing += read.first.saturating_sub(from);
        }
        let every = u64::from(read.every.max(1));
        for (index, row) in read.rows.iter().enumerate() {
            let tick = read.first + index as u64 * every;
            let written = match sink {
                Sink::Csv(csv) => csv.row(tick, row),
                Sink::Mcap(mcap) => mcap.row(tick, row),
            };
            if !is_wanted(written, command)? {
                return Ok(taken);
            }
        }
        if let Sink::Csv(csv) = sink
            && is_standard_output(&command.output)
            && !is_wanted(csv.flush(), command)?
        {
            return Ok(taken);
        }
        taken.rows += read.rows.len() as u64;
        from = read.next();
    }
}

/// Whether the output takes further rows, by the result of a write: a reader of the standard output that has gone away (`| head`) ends the trace.
fn is_wanted(written: io::Result<()>, command: &Trace) -> Result<bool, Failure> {
    match written {
        Ok(()) => Ok(true),
        Err(error) if is_standard_output(&command.output) && error.kind() == ErrorKind::BrokenPipe => Ok(false),
        Err(error) => Err(Failure::at(&command.output, error)),
    }
}

/// The signals of names: those of an axis or a coordinate system, or a single one.
async fn signals(client: &Client, names: &[String]) -> Result<Vec<String>, Failure> {
    let axes = client.objects(Object::Axis).await?;
    let systems = client.objects(Object::CoordinateSystem).await?;
    let of = |object: &str, members: &[&str]| {
        members
            .iter()
            .map(|member| format!("{object}.{member}"))
            .collect::<Vec<_>>()
    };
    if names.is_empty() {
        return Ok(axes.iter().flat_map(|axis| of(axis, &OF_AXIS)).collect());
    }
    let mut signals: Vec<String> = Vec::new();
    for name in names {
        let is = |known: &&String| known.eq_ignore_ascii_case(name);
        if name.contains('.') {
            signals.push(name.clone());
        } else if let Some(axis) = axes.iter().find(is) {
            signals.extend(of(axis, &OF_AXIS));
        } else if let Some(system) = systems.iter().find(is) {
            signals.extend(of(system, &OF_SYSTEM));
            let known = client.trace_signals().await?;
            signals.extend(
                of(system, &OF_ROBOT)
                    .into_iter()
                    .filter(|signal| known.contains(signal)),
            );
        } else {
            return Err(match client.tag(name).await {
                Ok(tag) => Failure::WrongType {
                    type_name: tag.type_name(),
                    name: tag.name,
                    expected: "an axis, a coordinate system, or a signal of one such as X.ActualPosition",
                },
                Err(error) if error.is_connection() => error.into(),
                Err(_) => ClientError::unknown_tag(name, axes.iter().chain(&systems)).into(),
            });
        }
    }
    // An axis and a signal of it: one column is enough.
    let mut seen = BTreeSet::new();
    signals.retain(|signal| seen.insert(signal.to_ascii_lowercase()));
    Ok(signals)
}
