//! A trace in a file, as CSV or MCAP, of all signals of axes or chosen ones.

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::Path;
use std::time::Duration;

use arcline_controller::Controller;
use arcline_controller::machine::Machine;
use arcline_mcap::Mcap;
use arcline_simulation::{AXIS_SIGNALS, Columns, Record, Signal};

use crate::case::Invalid;

/// A trace that is being written.
#[derive(Debug)]
pub struct TraceFile {
    sink: Sink,
    /// The chosen ones; `None`: all.
    chosen: Option<Columns>,
    row: Vec<f64>,
    every: u64,
    failed: Option<io::Error>,
}

#[derive(Debug)]
enum Sink {
    Csv(Record),
    Mcap(Mcap<BufWriter<File>>),
}

impl TraceFile {
    /// Creates the file: `.mcap` is MCAP, anything else CSV, and `-` CSV to standard output. No signals are all of all axes; every nth tick.
    ///
    /// # Errors
    /// The file cannot be created, or a name is no signal of an axis.
    pub fn create(path: &Path, machine: &Machine, signals: &[String], every: u64) -> Result<Self, Invalid> {
        let chosen = columns(machine, signals)?;
        let cannot = |error: io::Error| Invalid(format!("{}: cannot be written: {error}", path.display()));
        let is_mcap = path
            .extension()
            .is_some_and(|ending| ending.eq_ignore_ascii_case("mcap"));
        let sink = if is_mcap {
            let all = || {
                let axes = machine.axes.iter();
                let of_axis = |name: &str| AXIS_SIGNALS.map(|signal| format!("{name}.{signal}"));
                axes.flat_map(|axis| of_axis(&axis.name)).collect()
            };
            let names: Vec<String> = if chosen.is_some() { signals.to_vec() } else { all() };
            let file = BufWriter::new(File::create(path).map_err(cannot)?);
            Sink::Mcap(Mcap::new(file, &names, Duration::from_nanos(machine.period_ns)).map_err(cannot)?)
        } else {
            let file: Box<dyn Write + Send> = if path == Path::new("-") {
                Box::new(io::stdout())
            } else {
                Box::new(File::create(path).map_err(cannot)?)
            };
            let mut record = Record::new(file);
            if chosen.is_some() {
                record.header_of(signals);
            } else {
                record.header(machine);
            }
            Sink::Csv(record)
        };
        Ok(TraceFile {
            sink,
            row: vec![0.0; signals.len()],
            chosen,
            every: every.max(1),
            failed: None,
        })
    }

    /// The end of a tick.
    pub fn tick(&mut self, tick: u64, machine: &Machine, controller: &Controller) {
        if !tick.is_multiple_of(self.every) || self.failed.is_some() {
            return;
        }
        let time = (tick as f64 * machine.period_ns as f64) / 1e9;
        if let Some(columns) = &self.chosen {
            columns.read(controller, &mut self.row);
        }
        match (&mut self.sink, &self.chosen) {
            (Sink::Csv(record), None) => record.row(tick, time, controller.trace()),
            (Sink::Csv(record), Some(_)) => record.row_of(tick, time, self.row.iter().copied()),
            (Sink::Mcap(mcap), chosen) => {
                if chosen.is_none() {
                    self.row.clear();
                    self.row.extend(controller.trace().flatten());
                }
                self.failed = mcap.row(tick, &self.row).err();
            }
        }
    }

    /// Writes what is left.
    ///
    /// # Errors
    /// The file could not be written.
    pub fn finish(self) -> io::Result<()> {
        match (self.failed, self.sink) {
            (Some(failed), _) => Err(failed),
            (None, Sink::Csv(record)) => record.finish(),
            (None, Sink::Mcap(mcap)) => mcap.finish(),
        }
    }
}

/// The columns of the signals; `None`: of all.
fn columns(machine: &Machine, signals: &[String]) -> Result<Option<Columns>, Invalid> {
    if signals.is_empty() {
        return Ok(None);
    }
    let mut known = Vec::with_capacity(signals.len());
    for name in signals {
        let signal = Signal::of_axis(machine, name).ok_or_else(|| {
            let axes: Vec<&str> = machine.axes.iter().map(|axis| axis.name.as_str()).collect();
            let (axes, signals) = (axes.join(", "), AXIS_SIGNALS.join(", "));
            Invalid(format!("{name:?} is no signal of an axis, expected AXIS.SIGNAL with an axis of {axes} and a signal of {signals}"))
        })?;
        known.push(signal);
    }
    Ok(Some(Columns::new(&known)))
}
