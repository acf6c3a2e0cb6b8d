//! A simulation as text: the trace as CSV, events and faults as JSON lines, each in a large buffer that is written out when it is full.

use std::fmt;
use std::io::{self, Write};

use arcline_controller::machine::Machine;
use arcline_controller::{Event, FaultChange};
use arcline_instruction_set::{Ending, Flag};

use crate::signals::AXIS_SIGNALS;

/// A text that is written in large pieces. A failed write is reported at the end.
pub struct Record {
    file: Box<dyn Write + Send>,
    text: Vec<u8>,
    failed: Option<io::Error>,
}

impl fmt::Debug for Record {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Record")
            .field("failed", &self.failed)
            .finish_non_exhaustive()
    }
}

impl Record {
    /// A record into a file or another writer.
    pub fn new(file: Box<dyn Write + Send>) -> Self {
        Record {
            file,
            text: Vec::with_capacity(BUFFER + MARGIN),
            failed: None,
        }
    }

    /// Writes the rest of the text.
    ///
    /// # Errors
    /// The text could not be written.
    pub fn finish(mut self) -> io::Result<()> {
        self.flush();
        match self.failed {
            None => self.file.flush(),
            Some(failed) => Err(failed),
        }
    }

    /// The header of a trace.
    pub fn header(&mut self, machine: &Machine) {
        self.text.extend_from_slice(b"tick,time_s");
        for axis in &machine.axes {
            for column in AXIS_SIGNALS {
                self.text.push(b',');
                self.text.extend_from_slice(axis.name.as_bytes());
                self.text.push(b'.');
                self.text.extend_from_slice(column.as_bytes());
            }
        }
        self.text.push(b'\n');
    }

    /// The header of a trace of chosen signals.
    pub fn header_of(&mut self, signals: &[String]) {
        self.text.extend_from_slice(b"tick,time_s");
        for signal in signals {
            self.text.push(b',');
            self.text.extend_from_slice(signal.as_bytes());
        }
        self.text.push(b'\n');
    }

    /// One row of a trace.
    pub fn row(&mut self, tick: u64, time: f64, axes: impl Iterator<Item = [f64; 4]>) {
        self.row_of(tick, time, axes.flatten());
    }

    /// One row of a trace of chosen signals.
    pub fn row_of(&mut self, tick: u64, time: f64, values: impl Iterator<Item = f64>) {
        let mut integer = itoa::Buffer::new();
        self.text.extend_from_slice(integer.format(tick).as_bytes());
        self.text.push(b',');
        number(&mut self.text, time);
        for value in values {
            self.text.push(b',');
            number(&mut self.text, value);
        }
        self.text.push(b'\n');
        self.flush_if_full();
    }

    /// One change of an instruction's status.
    pub fn event(&mut self, event: &Event, time: f64, tag: &str) {
        if event.set | event.clear == 0 {
            // A cam has reached another segment.
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
    pub fn fault(&mut self, change: &FaultChange, time: f64, axis: &str) {
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

/// The shortest decimal that reads back to the same number; whole numbers without point.
pub(crate) fn number(text: &mut Vec<u8>, value: f64) {
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
