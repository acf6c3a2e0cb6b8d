//! Structured Text: reads programs, checks their names, and runs them one request at a time.
//!
//! The language is the small sequential subset of IEC 61131-3 that spec/contract.md §1 describes, with the
//! motion instructions of `arcline-instruction-set`. Here is no tag, no tick, no socket and no motion: the
//! [`Interpreter`] makes requests ([`Request`]) and takes their answers ([`Answer`]). [`ProgramRun`] is the loop between it and a
//! machine; the simulator, the page and the network client each are a [`Driver`]. Times are in seconds.
//!
//! ```
//! use arcline_structured_text::{Answer, Interpreter, Program, Request};
//!
//! let program = Program::parse("MSO(X, M1); WAIT(M1.DN);")?;
//! let mut interpreter = Interpreter::new(program);
//! assert!(matches!(interpreter.resume(Answer::Start)?, Request::Call(_)));
//! assert!(matches!(interpreter.resume(Answer::Done)?, Request::Read(path) if path.to_string() == "M1.DN"));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
#![forbid(unsafe_code)]

mod calls;
mod code;
mod driver;
mod error;
mod hopeless;
mod interpreter;
mod lexer;
mod parser;
mod program;
mod run;

pub use calls::{Called, Calls};
pub use driver::{
    Driver, Moves, MovesEnd, OnError, Outcome, Pause, Policy, Progress, QueueFull, Reading, RunError, Stopped,
    immediately, pause_of_queue,
};
pub use error::{RuntimeError, RuntimeProblem, SyntaxError, SyntaxProblem};
pub use hopeless::Hopeless;
pub use interpreter::{Answer, EvaluatedCall, Interpreter, OPERATIONS_PER_TICK, Request, STATEMENTS_PER_TICK};
pub use program::{CallStatement, Names, ObjectAttribute, Program, unmade_control};
pub use run::{ProgramRun, is_status};

#[cfg(test)]
mod series_tests;
#[cfg(test)]
mod tests;
