//! A trace as CSV: `tick,time_s` and a column for each signal (spec/contract.md §1).

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::Path;
use std::time::Duration;

use crate::cli::output::is_standard_output;

/// A file that is being written, or the standard output.
pub(super) struct Csv {
    file: BufWriter<Box<dyn Write + Send>>,
    period: Duration,
}

impl Csv {
    pub(super) fn create(path: &Path, signals: &[String], period: Duration) -> io::Result<Self> {
        let file: Box<dyn Write + Send> = if is_standard_output(path) {
            Box::new(io::stdout())
        } else {
            Box::new(File::create(path)?)
        };
        let mut file = BufWriter::new(file);
        writeln!(file, "tick,time_s,{}", signals.join(","))?;
        Ok(Self { file, period })
    }

    pub(super) fn row(&mut self, tick: u64, row: &[f64]) -> io::Result<()> {
        write!(self.file, "{tick},")?;
        // Ticks times nanoseconds: exact for a hundred years of milliseconds.
        let nanoseconds = u128::from(tick) * self.period.as_nanos();
        number(&mut self.file, nanoseconds as f64 / 1e9)?;
        for value in row {
            self.file.write_all(b",")?;
            number(&mut self.file, *value)?;
        }
        self.file.write_all(b"\n")
    }

    /// Writes the buffered rows to the file.
    pub(super) fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

/// The shortest decimal that reads back to the same number; whole numbers without point.
fn number(file: &mut impl Write, value: f64) -> io::Result<()> {
    if value == 0.0 {
        return file.write_all(if value.is_sign_negative() { b"-0" } else { b"0" });
    }
    let mut buffer = zmij::Buffer::new();
    let digits = buffer.format(value);
    file.write_all(digits.strip_suffix(".0").unwrap_or(digits).as_bytes())
}
