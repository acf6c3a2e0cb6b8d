//! Draws a trace: the path coloured by its speed, and position, velocity, acceleration and jerk over time, with the
//! instructions marked. SVG, or PNG made of it.
//!
//! Pure: texts go in (the CSV and the JSON lines of spec/contract.md §1), a picture comes out, the same bytes for the same
//! trace. No file, no clock, no font of the machine: PNG takes an embedded one. Positions are in position units, times in
//! seconds; the picture is in pixels.
//!
//! ```
//! use arcline_plot::{Options, Trace, svg};
//!
//! let text = "tick,time_s,X.CommandPosition,X.CommandVelocity,X.CommandAcceleration\n0,0,0,0,10\n1,0.001,0.01,0.01,10\n";
//! let picture = svg(&Trace::parse(text)?, &Options::default())?;
//! assert!(picture.starts_with("<svg "));
//! # Ok::<(), arcline_plot::PlotError>(())
//! ```
#![forbid(unsafe_code)]

mod events;
mod page;
mod panel;
mod path;
mod png;
mod scale;
mod trace;

pub use events::Mark;
pub use page::{Options, svg};
pub use png::png;
pub use trace::{Axis, Trace};

/// Why there is no picture.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PlotError {
    /// A line of the trace or of the events that cannot be read.
    #[error("line {line}: {problem}")]
    Line {
        /// From 1.
        line: usize,
        /// The problem.
        problem: String,
    },
    /// The header has no position of any axis.
    #[error("no column `NAME.CommandPosition` or `NAME.ActualPosition`")]
    NoAxis,
    /// An axis that is not in the trace.
    #[error("the trace has no axis {name:?}, only {known}")]
    UnknownAxis {
        /// The name.
        name: String,
        /// Those there are.
        known: String,
    },
    /// Fewer than two rows.
    #[error("the trace has fewer than two rows")]
    Empty,
    /// The picture cannot be drawn as pixels.
    #[error("the picture cannot be drawn: {0}")]
    Pixels(String),
}
