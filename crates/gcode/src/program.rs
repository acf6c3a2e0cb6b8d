//! A program as steps: paths, speeds, and the ends of motions.

use crate::modal::Modes;
use crate::words::words;
use crate::{GcodeError, MAX_BYTES, MAX_STEPS, Problem};

/// Conditions that a program does not contain.
#[derive(Clone, PartialEq, Debug)]
pub struct Options {
    /// Axes of the coordinate system: 1 (X), 2 (X, Y) or 3 (X, Y, Z).
    pub axes: usize,
    /// Where it stands before the first line, in its own units.
    pub start: [f64; 3],
    /// Whether its unit is the inch; otherwise the millimetre.
    pub inches: bool,
    /// Words that are passed over although they mean nothing here: `M3`, or `S` for every word with the letter.
    pub skip: Vec<String>,
}

impl Default for Options {
    /// Three axes at 0, in millimetres.
    fn default() -> Self {
        Self {
            axes: 3,
            start: [0.0; 3],
            inches: false,
            skip: Vec::new(),
        }
    }
}

/// How fast.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Speed {
    /// As fast as the coordinate system goes.
    Rapid,
    /// Units of the machine per second.
    Feed(f64),
}

/// The end of a motion with a successor.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Corner {
    /// The path is followed exactly, as fast as its corner can be passed (G61).
    Exact,
    /// The motion stops (G61.1, and whenever no motion follows at once).
    Stop,
    /// Rounded within the tolerance of the coordinate system (G64).
    Rounded,
    /// Rounded within a tolerance in units of the machine (G64 P).
    Within(f64),
}

/// Motions and dwells.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Motion {
    /// A line to a point.
    Line {
        /// Its end, absolute, units of the machine.
        end: [f64; 3],
        /// How fast.
        speed: Speed,
        /// Its end.
        corner: Corner,
    },
    /// An arc of at most 270° through a point to a point.
    Arc {
        /// The point in its middle.
        via: [f64; 3],
        /// Its end.
        end: [f64; 3],
        /// How fast.
        speed: Speed,
        /// Its end.
        corner: Corner,
    },
    /// Rest.
    Dwell {
        /// How long.
        seconds: f64,
    },
}

/// A motion and where it was written.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Step {
    /// Line of the program, from 1.
    pub line: usize,
    /// The motion or dwell.
    pub motion: Motion,
}

/// A program that has been read.
#[derive(Clone, PartialEq, Debug)]
pub struct Program {
    /// How many axes the positions have.
    pub axes: usize,
    /// The steps, in order.
    pub steps: Vec<Step>,
}

impl Program {
    /// Reads a program. A line that moves nothing leaves no step.
    ///
    /// # Errors
    /// [`GcodeError`] for the first word that cannot be read, is unknown, or has no meaning on its line.
    pub fn parse(text: &str, options: &Options) -> Result<Self, GcodeError> {
        let too_large = |line, limit, unit| GcodeError {
            line,
            column: 1,
            problem: Problem::TooLarge { limit, unit },
        };
        if text.len() > MAX_BYTES {
            return Err(too_large(1, MAX_BYTES, "bytes"));
        }
        let mut reader = ProgramReader::new(options);
        let mut steps: Vec<Step> = Vec::new();
        for (index, text) in text.lines().enumerate() {
            let goes_on = reader.line(text, &mut |step| steps.push(step))?;
            if steps.len() >= MAX_STEPS {
                return Err(too_large(index + 1, MAX_STEPS, "motions"));
            }
            if !goes_on {
                break;
            }
        }
        reader.end(&mut |step| steps.push(step));
        Ok(Self {
            axes: options.axes,
            steps,
        })
    }
}

/// Reads a program line by line: what it holds does not grow with the program.
#[derive(Debug)]
pub struct ProgramReader {
    modes: Modes,
    /// Lines that were read.
    line: usize,
    /// Whether a `%` has opened the program.
    framed: bool,
    ended: bool,
    /// The newest step, until its successor is known: a motion with none, and one before a dwell, ends at rest.
    held: Option<Step>,
}

impl ProgramReader {
    /// In front of the first line.
    pub fn new(options: &Options) -> Self {
        Self {
            modes: Modes::new(options),
            line: 0,
            framed: false,
            ended: false,
            held: None,
        }
    }

    /// Reads the next line, and passes on the steps whose successors are known. Returns whether the program continues behind it.
    ///
    /// # Errors
    /// [`GcodeError`] for the first word that cannot be read, is unknown, or has no meaning on its line.
    pub fn line(&mut self, text: &str, then: &mut dyn FnMut(Step)) -> Result<bool, GcodeError> {
        if self.ended {
            return Ok(false);
        }
        self.line += 1;
        let line = self.line;
        if text.trim() == "%" {
            // The first one opens the program, the second one is its end.
            self.ended = self.framed || self.held.is_some();
            self.framed = true;
            return Ok(!self.ended);
        }
        let words = words(text, line)?;
        let held = &mut self.held;
        let goes_on = self.modes.line(&words, line, &mut |motion| {
            let step = Step { line, motion };
            if let Some(before) = held.replace(step) {
                let rests = matches!(motion, Motion::Dwell { .. });
                then(if rests { before.to_rest() } else { before });
            }
        })?;
        self.ended = !goes_on;
        Ok(goes_on)
    }

    /// Passes on the last step.
    pub fn end(self, then: &mut dyn FnMut(Step)) {
        if let Some(last) = self.held {
            then(last.to_rest());
        }
    }
}

impl Step {
    /// The step with its end at rest, with any path control.
    fn to_rest(mut self) -> Self {
        match &mut self.motion {
            Motion::Line { corner, .. } | Motion::Arc { corner, .. } => *corner = Corner::Stop,
            Motion::Dwell { .. } => {}
        }
        self
    }
}
