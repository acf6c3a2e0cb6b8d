//! The result of a run, as one line of JSON.

use std::collections::BTreeMap;

use arcline_controller::machine::Machine;
use arcline_simulation::End;
use serde::Serialize;
use sha2::{Digest as _, Sha256};

use crate::case::{Case, Invalid};
use crate::measures::{Measures, hex};

/// A result. What does not apply is left out.
#[derive(Clone, PartialEq, Debug, Default, Serialize)]
pub struct Outcome {
    /// Number of the case, from 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub case: Option<u64>,
    /// Its `id`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub id: Option<serde_json::Value>,
    /// How it ended: `finished`; `erred`, by an instruction; `failed`, the program could not go on; `timeout`; `fault`, of a task of a project;
    /// [`INVALID`], it was not run; [`DEFECT`], this program has one.
    pub end: &'static str,
    /// The error.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub error: Option<String>,
    /// Why its trace is not whole.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub trace_error: Option<String>,
    /// Simulated time, s.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub time_s: Option<f64>,
    /// The last tick.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ticks: Option<u64>,
    /// ERR of the instruction that erred; 0: none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub err: Option<i16>,
    /// EXERR of it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub exerr: Option<i8>,
    /// Instructions that were executed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub instructions: Option<u64>,
    /// Command positions at the end, in position units.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub positions: BTreeMap<String, f64>,
    /// Of the axes that moved.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub peaks: BTreeMap<String, Peak>,
    /// The first 20 faults.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub faults: Vec<Raised>,
    /// The seed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub seed: Option<u64>,
    /// SHA-256 of the trace ([`Measures::tick`]).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub hash: Option<String>,
    /// SHA-256 of the program's text, its first 16 digits.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub program: Option<String>,
    /// SHA-256 of the configuration's text, its first 16 digits.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub config: Option<String>,
    /// Version of the program.
    pub version: &'static str,
    /// Seconds of real time that it took.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub wall_s: Option<f64>,
}

/// The largest magnitudes that an axis came to.
#[derive(Clone, Copy, PartialEq, Debug, Default, Serialize)]
pub struct Peak {
    /// Of the command velocity, position units per second.
    pub velocity: f64,
    /// Of the command acceleration, position units per second squared.
    pub acceleration: f64,
    /// Of command position less actual position, position units.
    pub position_error: f64,
}

impl Peak {
    pub(crate) fn take(&mut self, velocity: f64, acceleration: f64, error: f64) {
        self.velocity = self.velocity.max(velocity.abs());
        self.acceleration = self.acceleration.max(acceleration.abs());
        self.position_error = self.position_error.max(error.abs());
    }
}

/// Faults that an axis came to have.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct Raised {
    /// s after the beginning.
    pub time_s: f64,
    /// The axis.
    pub axis: String,
    /// Their words.
    pub faults: Vec<String>,
}

impl Outcome {
    /// The result of a case that was not run; its line in the file of cases.
    pub fn invalid(case: u64, line: u64, why: &Invalid) -> Self {
        Outcome {
            case: Some(case),
            end: INVALID,
            error: Some(format!("line {line}: {why}")),
            version: VERSION,
            ..Outcome::default()
        }
    }

    /// The result of a case in which this program has a defect; the line of the case and its number in the file.
    pub fn panicked(case: u64, number: u64, line: &str, why: &str) -> Self {
        Outcome {
            case: Some(case),
            id: Case::parse(line).ok().and_then(|case| case.id),
            end: DEFECT,
            error: Some(format!("line {number}: a defect of Arcline: {why}")),
            version: VERSION,
            ..Outcome::default()
        }
    }

    /// The result of a run.
    pub fn of(end: &End, measures: &Measures, machine: &Machine) -> Self {
        let (word, err, exerr, error) = match end {
            End::Finished | End::Left => ("finished", 0, 0, None),
            End::Erred(erred) => ("erred", erred.err, erred.exerr, Some(erred.to_string())),
            End::Wrong(wrong) => ("failed", 0, 0, Some(wrong.to_string())),
            End::TooLong(seconds) => {
                let text = format!("not at its end after {seconds} s of simulated time");
                ("timeout", 0, 0, Some(text))
            }
        };
        Outcome {
            err: Some(err),
            exerr: Some(exerr),
            ..Self::ended(word, error, measures, machine)
        }
    }

    /// The result of a run that ended so.
    pub fn ended(end: &'static str, error: Option<String>, measures: &Measures, machine: &Machine) -> Self {
        let names = || machine.axes.iter().map(|axis| axis.name.clone());
        let moved = names()
            .zip(&measures.peaks)
            .filter(|(_, peak)| **peak != Peak::default());
        Outcome {
            end,
            error,
            time_s: Some((measures.ticks as f64 * machine.period_ns as f64) / 1e9),
            ticks: Some(measures.ticks),
            positions: names().zip(measures.positions()).collect(),
            peaks: moved.map(|(name, peak)| (name, *peak)).collect(),
            faults: measures.faults.clone(),
            hash: Some(measures.hash()),
            version: VERSION,
            ..Outcome::default()
        }
    }

    /// The line, without its end.
    pub fn line(&self) -> String {
        serde_json::to_string(self).expect("numbers and texts serialise")
    }
}

/// The end of a case that was not run.
pub const INVALID: &str = "invalid";

/// The end of a case in which this program panicked.
pub const DEFECT: &str = "defect";

/// The version of Arcline.
pub(crate) const VERSION: &str = env!("CARGO_PKG_VERSION");

/// By what the text of a program or a configuration is known: the first 16 digits of its SHA-256.
pub fn text_hash(text: &str) -> String {
    hex(&Sha256::digest(text.as_bytes())[..8])
}
