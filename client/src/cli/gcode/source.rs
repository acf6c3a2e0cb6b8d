//! The file of a G-code program. It is read line by line as often as it is needed, so that its length does not show in memory.

use std::collections::VecDeque;
use std::fs::File;
use std::io::{self, BufRead as _, BufReader, Read as _, Write};

use arcline_gcode::{GcodeError, Motion, Options, Problem, ProgramReader, Step};

use crate::cli::Failure;
use crate::cli::args::Gcode;

/// Longest line, bytes.
const LONGEST: usize = 1 << 16;

/// A program in its file.
pub(super) struct Source<'c> {
    pub(super) command: &'c Gcode,
    pub(super) options: Options,
}

/// The numbers of lines, arcs and dwells of a program.
#[derive(Clone, Copy, Default, PartialEq, Eq, Debug)]
pub(super) struct Counts {
    pub(super) lines: u64,
    pub(super) arcs: u64,
    dwells: u64,
}

impl Counts {
    pub(super) fn moves(&self) -> u64 {
        self.lines + self.arcs
    }

    /// Statements of Structured Text: one a step, each on a line.
    pub(super) fn statements(&self) -> u64 {
        self.moves() + self.dwells
    }
}

impl Source<'_> {
    /// The file as messages name it.
    pub(super) fn name(&self) -> String {
        self.command.file.display().to_string()
    }

    /// The steps from the first line on.
    pub(super) fn steps(&self) -> Result<Steps<'_>, Failure> {
        let file = File::open(&self.command.file).map_err(|error| Failure::at(&self.command.file, error))?;
        Ok(Steps {
            source: self,
            file: BufReader::new(file),
            reader: Some(ProgramReader::new(&self.options)),
            line: 0,
            ready: VecDeque::new(),
            bytes: Vec::new(),
        })
    }

    /// Reads all of it.
    pub(super) fn counts(&self) -> Result<Counts, Failure> {
        let mut counts = Counts::default();
        for step in self.steps()? {
            match step?.motion {
                Motion::Line { .. } => counts.lines += 1,
                Motion::Arc { .. } => counts.arcs += 1,
                Motion::Dwell { .. } => counts.dwells += 1,
            }
        }
        Ok(counts)
    }

    /// Writes it as Structured Text. The inner result is that of `to`.
    pub(super) fn write(&self, to: &mut dyn Write) -> Result<io::Result<()>, Failure> {
        for step in self.steps()? {
            if let Err(error) = writeln!(to, "{}", self.text_of(&step?)) {
                return Ok(Err(error));
            }
        }
        Ok(to.flush())
    }

    /// Line of the file from which a statement of the Structured Text comes; both from 1. 0: there is no such statement.
    pub(super) fn line_of(&self, statement: usize) -> usize {
        let index = statement.saturating_sub(1);
        let step = self.steps().ok().and_then(|mut steps| steps.nth(index));
        step.and_then(Result::ok).map_or(0, |step| step.line)
    }

    /// A step as a line of Structured Text.
    pub(super) fn text_of(&self, step: &Step) -> String {
        step.structured_text(self.options.axes, &self.command.system, &self.command.tag)
    }
}

/// The steps of a program, read as they are taken.
pub(super) struct Steps<'s> {
    source: &'s Source<'s>,
    file: BufReader<File>,
    /// `None`: the program has ended.
    reader: Option<ProgramReader>,
    line: usize,
    /// Read and not yet taken.
    ready: VecDeque<Step>,
    bytes: Vec<u8>,
}

impl Steps<'_> {
    /// Adds the text of the next steps, at most `most`; returns their number.
    pub(super) fn next_text(&mut self, text: &mut String, most: usize) -> Result<usize, Failure> {
        let mut count = 0;
        while count < most {
            let Some(step) = self.next().transpose()? else { break };
            text.push_str(&self.source.text_of(&step));
            text.push('\n');
            count += 1;
        }
        Ok(count)
    }

    /// Reads a line, if there is another one.
    fn read(&mut self) -> Result<(), Failure> {
        let Some(mut reader) = self.reader.take() else {
            return Ok(());
        };
        let source = self.source;
        let gcode = |error: GcodeError| Failure::Gcode {
            path: source.name(),
            source: error,
        };
        let ready = &mut self.ready;
        let mut then = |step| ready.push_back(step);
        self.bytes.clear();
        self.line += 1;
        let mut line = (&mut self.file).take(LONGEST as u64);
        let read = line.read_until(b'\n', &mut self.bytes);
        let read = read.map_err(|error| Failure::at(&source.command.file, error))?;
        if read == LONGEST && self.bytes.last() != Some(&b'\n') {
            let (limit, unit) = (LONGEST, "bytes a line");
            return Err(gcode(GcodeError {
                line: self.line,
                column: 1,
                problem: Problem::TooLarge { limit, unit },
            }));
        }
        // A comment may be in any code page.
        let text = String::from_utf8_lossy(&self.bytes);
        let text = text.trim_end_matches(['\n', '\r']);
        if read > 0 && reader.line(text, &mut then).map_err(gcode)? {
            self.reader = Some(reader);
        } else {
            reader.end(&mut then);
        }
        Ok(())
    }
}

impl Iterator for Steps<'_> {
    type Item = Result<Step, Failure>;

    fn next(&mut self) -> Option<Self::Item> {
        while self.ready.is_empty() && self.reader.is_some() {
            if let Err(failure) = self.read() {
                return Some(Err(failure));
            }
        }
        self.ready.pop_front().map(Ok)
    }
}
