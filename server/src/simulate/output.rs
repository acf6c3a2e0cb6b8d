//! Trace (CSV) and events (JSON lines), as text in one big buffer that is written out when it is full.

use std::fs::File;
use std::io::{self, Write};
use std::path::Path;

use arcline_controller::image::Image;
use arcline_controller::machine::Machine;
use arcline_controller::{Controller, Event, FaultChange};
use arcline_instruction_set::{Ending, Flag};

use super::{Observer, Summary, cannot_write};
use crate::cli::{Failure, SimulateArgs};

/// What a simulation writes down.
pub(super) struct Files {
    pub(super) trace: Option<Output>,
    pub(super) events: Option<Output>,
    pub(super) faults: Option<Output>,
    pub(super) summary: Summary,
}

impl Files {
    /// Creates the files of the command line.
    ///
    /// # Errors
    /// A file that cannot be created, or more than one to standard output.
    pub(super) fn create(args: &SimulateArgs) -> Result<Self, Failure> {
        let create = |path: &Path| Output::create(path).map_err(|error| cannot_write(path, &error));
        let outputs = [&args.trace, &args.events, &args.faults, &args.tags];
        let to_output = outputs.into_iter().flatten().filter(|path| is_standard_output(path));
        if to_output.count() > 1 {
            return Err(Failure::usage(
                "only one of --trace, --events, --faults and --tags can be written to standard output",
            ));
        }
        Ok(Files {
            trace: args.trace.as_deref().map(create).transpose()?,
            events: args.events.as_deref().map(create).transpose()?,
            faults: args.faults.as_deref().map(create).transpose()?,
            summary: Summary::default(),
        })
    }

    /// Ends the files; the summary of the run.
    ///
    /// # Errors
    /// A file that could not be written.
    pub(super) fn finish(self, args: &SimulateArgs) -> Result<Summary, Failure> {
        let outputs = [
            (self.trace, &args.trace),
            (self.events, &args.events),
            (self.faults, &args.faults),
        ];
        for (output, path) in outputs {
            if let (Some(output), Some(path)) = (output, path) {
                output.finish().map_err(|error| cannot_write(path, &error))?;
            }
        }
        Ok(self.summary)
    }
}

impl Observer for Files {
    fn begin(&mut self, machine: &Machine) {
        if let Some(trace) = &mut self.trace {
            trace.header(machine);
        }
    }

    fn tick(&mut self, tick: u64, machine: &Machine, controller: &mut Controller) -> bool {
        if let Some(trace) = &mut self.trace {
            let time = (tick as f64 * machine.period_ns as f64) / 1e9;
            trace.row(tick, time, controller.trace());
        }
        self.summary.tick(tick, machine, controller);
        true
    }

    fn fault(&mut self, change: &FaultChange, time: f64, machine: &Machine) {
        let axis = machine.axes.get(usize::from(change.axis));
        let axis = axis.map_or("", |axis| axis.name.as_str());
        self.summary.fault(change, time, axis);
        if let Some(faults) = &mut self.faults {
            faults.fault(change, time, axis);
        }
    }

    fn event(&mut self, event: &Event, time: f64, image: &Image) {
        if let Some(events) = &mut self.events {
            events.event(event, time, image.control_name(event.control));
        }
    }
}

/// A file that is written in large pieces. A failed write is reported at the end.
pub(super) struct Output {
    file: Box<dyn Write>,
    text: Vec<u8>,
    failed: Option<io::Error>,
}

impl Output {
    pub(super) fn create(path: &Path) -> io::Result<Self> {
        Ok(Output {
            file: if is_standard_output(path) {
                Box::new(io::stdout())
            } else {
                Box::new(File::create(path)?)
            },
            text: Vec::with_capacity(BUFFER + MARGIN),
            failed: None,
        })
    }

    /// Writes what is left.
    pub(super) fn finish(mut self) -> io::Result<()> {
        self.flush();
        match self.failed {
            None => self.file.flush(),
            Some(failed) => Err(failed),
        }
    }

    /// The header of a trace.
    pub(super) fn header(&mut self, machine: &Machine) {
        self.text.extend_from_slice(b"tick,time_s");
        for axis in &machine.axes {
            for column in [
                "CommandPosition",
                "CommandVelocity",
                "CommandAcceleration",
                "ActualPosition",
            ] {
                self.text.push(b',');
                self.text.extend_from_slice(axis.name.as_bytes());
                self.text.push(b'.');
                self.text.extend_from_slice(column.as_bytes());
            }
        }
        self.text.push(b'\n');
    }

    /// One row of a trace.
    pub(super) fn row(&mut self, tick: u64, time: f64, axes: impl Iterator<Item = [f64; 4]>) {
        let mut integer = itoa::Buffer::new();
        self.text.extend_from_slice(integer.format(tick).as_bytes());
        self.text.push(b',');
        number(&mut self.text, time);
        for value in axes.flatten() {
            self.text.push(b',');
            number(&mut self.text, value);
        }
        self.text.push(b'\n');
        self.flush_if_full();
    }

    /// One change of an instruction's status.
    pub(super) fn event(&mut self, event: &Event, time: f64, tag: &str) {
        if event.set | event.clear == 0 {
            // A cam has come to another segment.
            return;
        }
        let text = &mut self.text;
        text.extend_from_slice(b"{\"time_s\":");
        number(text, time);
        // Names of tags and flags need no escapes.
        let line = (|| {
            write!(
                text,
                ",\"tick\":{},\"tag\":\"{tag}\",\"instruction\":\"{}\"",
                event.tick, event.mnemonic
            )?;
            for (key, flags) in [("set", event.set), ("clear", event.clear)] {
                write!(text, ",\"{key}\":[")?;
                for (place, flag) in Flag::in_word(flags).enumerate() {
                    write!(text, "{}\"{flag}\"", if place == 0 { "" } else { "," })?;
                }
                text.push(b']');
            }
            writeln!(text, ",\"ERR\":{},\"EXERR\":{}}}", event.err, event.exerr)
        })();
        line.expect("a Vec takes everything");
        self.flush_if_full();
    }

    /// One change of the faults of an axis.
    pub(super) fn fault(&mut self, change: &FaultChange, time: f64, axis: &str) {
        let text = &mut self.text;
        text.extend_from_slice(b"{\"time_s\":");
        number(text, time);
        let words = |faults| {
            let words: Vec<String> = Ending::words(faults).iter().map(|word| format!("\"{word}\"")).collect();
            words.join(",")
        };
        let (set, again, clear) = (words(change.set), words(change.again), words(change.clear));
        let tick = change.tick;
        let refused = change
            .refused
            .map_or_else(String::new, |command| format!(",\"refused\":\"{command}\""));
        writeln!(
            text,
            ",\"tick\":{tick},\"axis\":\"{axis}\",\"set\":[{set}],\"again\":[{again}],\"clear\":[{clear}]{refused}}}"
        )
        .expect("a Vec takes everything");
        self.flush_if_full();
    }

    fn flush_if_full(&mut self) {
        if self.text.len() >= BUFFER {
            self.flush();
        }
    }

    fn flush(&mut self) {
        if self.failed.is_none() {
            self.failed = self.file.write_all(&self.text).err();
        }
        self.text.clear();
    }
}

/// Whether a file is standard output.
pub(super) fn is_standard_output(path: &Path) -> bool {
    path == Path::new("-")
}

/// The shortest decimal that reads back to the same number; whole numbers without point.
pub(super) fn number(text: &mut Vec<u8>, value: f64) {
    if value == 0.0 {
        // A negative zero reads back as one.
        text.extend_from_slice(if value.is_sign_negative() { b"-0" } else { b"0" });
        return;
    }
    let mut buffer = zmij::Buffer::new();
    let digits = buffer.format(value);
    text.extend_from_slice(digits.strip_suffix(".0").unwrap_or(digits).as_bytes());
}

const BUFFER: usize = 1 << 20;
const MARGIN: usize = 1 << 16;
