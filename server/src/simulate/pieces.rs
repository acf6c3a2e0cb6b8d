//! The text of a simulation: a file as a whole, or line by line in pieces, so that the use of memory does not depend on its length.

use std::fs::File;
use std::io::{self, BufRead, BufReader, Read as _};
use std::path::{Path, PathBuf};

use arcline_cases::text_hash;
use arcline_controller::image::Image;
use arcline_simulation::{ImageNames, Piece};
use arcline_structured_text::{Interpreter, Program, SyntaxError};

use super::output::is_standard_output;
use crate::cli::Failure;

/// Lines of a piece.
const LINES: usize = 1000;
/// Longest line, bytes.
const LONGEST: u64 = 1 << 16;

/// The pieces of a program.
pub(super) struct Pieces {
    file: PathBuf,
    rest: Rest,
    lines: usize,
}

enum Rest {
    /// The whole text is one piece.
    Whole(String),
    Lines(Box<dyn BufRead>),
    Ended,
}

impl Pieces {
    /// A file as one piece.
    pub(super) fn whole(file: &Path) -> Result<Self, Failure> {
        let text = std::fs::read_to_string(file).map_err(|error| cannot_read(file, &error))?;
        Ok(Self::with(file, Rest::Whole(text)))
    }

    /// A file, or standard input, line by line.
    pub(super) fn of_lines(file: &Path) -> Result<Self, Failure> {
        let input: Box<dyn BufRead> = if is_standard_output(file) {
            Box::new(BufReader::new(io::stdin()))
        } else {
            Box::new(BufReader::new(
                File::open(file).map_err(|error| cannot_read(file, &error))?,
            ))
        };
        Ok(Self::with(file, Rest::Lines(input)))
    }

    fn with(file: &Path, rest: Rest) -> Self {
        Self {
            file: file.to_owned(),
            rest,
            lines: 0,
        }
    }

    /// By what a program is known that is one piece, as long as it has not been taken.
    pub(super) fn hash(&self) -> Option<String> {
        match &self.rest {
            Rest::Whole(text) => Some(text_hash(text)),
            Rest::Lines(_) | Rest::Ended => None,
        }
    }

    /// The next piece, its names checked; `None` behind the last one.
    pub(super) fn next(&mut self, image: &Image) -> Result<Option<Piece>, Failure> {
        let lines_before = self.lines;
        let text = match &mut self.rest {
            Rest::Ended => return Ok(None),
            Rest::Whole(text) => {
                let text = std::mem::take(text);
                self.rest = Rest::Ended;
                text
            }
            Rest::Lines(input) => {
                let (text, lines) = read_lines(input).map_err(|error| cannot_read(&self.file, &error))?;
                self.lines += lines;
                if lines == 0 {
                    return Ok(None);
                }
                text
            }
        };
        let checked = check(&text, image).map_err(|mut error| {
            error.line += lines_before;
            Failure::usage(format!("{}: {error}", self.file.display()))
        });
        Ok(Some(Piece {
            interpreter: Interpreter::new(checked?),
            lines_before,
        }))
    }
}

/// The next lines, and how many.
fn read_lines(input: &mut dyn BufRead) -> io::Result<(String, usize)> {
    let (mut text, mut lines) = (String::new(), 0);
    while lines < LINES {
        let read = input.take(LONGEST).read_line(&mut text)?;
        if read as u64 == LONGEST && !text.ends_with('\n') {
            return Err(io::Error::other(format!("a line is longer than {LONGEST} bytes")));
        }
        if read == 0 {
            break;
        }
        lines += 1;
    }
    Ok((text, lines))
}

/// Reads a program and checks that its names exist.
fn check(text: &str, image: &Image) -> Result<Program, SyntaxError> {
    let mut program = Program::parse(text)?;
    program.check(&ImageNames(image))?;
    Ok(program)
}

fn cannot_read(file: &Path, error: &io::Error) -> Failure {
    Failure::usage(format!("{}: cannot be read: {error}", file.display()))
}
