//! G-code (RS-274, the part that moves) as lines, arcs and dwells, and these as Structured Text: MCLM and MCCM with the
//! termination types that its path control asks for.
//!
//! A pure function from a text to values and a text. No file, no socket, no machine: [`Options`] has the start position, the number of
//! axes and their unit. An unknown word is an error with its line and column, and never
//! skipped. Positions are in the units of the machine, speeds in those per second.
//!
//! | word | means |
//! |---|---|
//! | `G0` `G1` `G2` `G3` | rapid and feed lines, arcs clockwise and counterclockwise, with `X Y Z`, `I J K` or `R`, `F` |
//! | `G4 P` | dwell, seconds |
//! | `G17` `G18` `G19` | plane of the arcs: XY, ZX, YZ |
//! | `G20` `G21` | inches, millimetres |
//! | `G61` `G61.1` `G64 [P]` | the exact path, the exact path with a stop at each end, corners rounded within `P` |
//! | `G90` `G91`, `G90.1` `G91.1` | end points, and centres, absolute or incremental |
//! | `G40` `G49` `G54` `G80` `G94` | accepted without effect, since it is always so: no compensation, no offset, no cycle, feed per minute |
//! | `M2` `M30` `%` `N` `( )` `;` | the end, the frame, line numbers, comments |
//!
//! ```
//! use arcline_gcode::{Options, Program};
//!
//! let program = Program::parse("G21 G90 G64 P0.1\nG1 X10 Y0 F600\nG3 X20 Y10 J10", &Options::default())?;
//! assert_eq!(program.steps.len(), 2);
//! assert!(program.structured_text("CS1", "Ngc").text.contains("MCCM(CS1, Ngc, Absolute, [20, 10, 0], Via"));
//! # Ok::<(), arcline_gcode::GcodeError>(())
//! ```
#![forbid(unsafe_code)]

mod arc;
mod error;
mod modal;
mod program;
mod text;
mod tolerance;
mod words;

pub use error::{GcodeError, Problem};
pub use program::{Corner, Motion, Options, Program, ProgramReader, Speed, Step};
pub use text::StructuredText;

/// Longest text that is read, bytes.
pub const MAX_BYTES: usize = 32 << 20;
/// Most steps of a program.
pub const MAX_STEPS: usize = 1_000_000;
