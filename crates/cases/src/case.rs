//! A case: what one line of a file of cases says.

use std::fmt;

use arcline_controller::machine::Machine;
use arcline_instruction_set::{AxisId, FAULTS, FaultSet};
use arcline_structured_text::QueueFull;
use arcline_tag::{WriteValue, nearest};
use serde::Deserialize;
use serde::de::{Deserializer, MapAccess, Visitor};

/// Why a case cannot be run.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
#[error("{0}")]
pub struct Invalid(pub String);

/// One run. Its missing keys have the values of the [`Defaults`](crate::Defaults).
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Case {
    /// The value by which its result is found again.
    #[serde(default)]
    pub id: Option<serde_json::Value>,
    /// The file of the program, in Structured Text.
    #[serde(default)]
    pub program: Option<String>,
    /// The program itself.
    #[serde(default)]
    pub text: Option<String>,
    /// The file of the configuration.
    #[serde(default)]
    pub config: Option<String>,
    /// Tags and keys of the configuration with their values, in this order, behind those of the defaults.
    #[serde(default)]
    pub set: Pairs,
    /// Decides what is left to chance: the times of faults that are given as a range.
    #[serde(default)]
    pub seed: Option<u64>,
    /// Longest simulated time, s.
    #[serde(default)]
    pub until: Option<f64>,
    /// Continue after an instruction has erred.
    #[serde(default)]
    pub keep_going: Option<bool>,
    /// Reaction of a coordinated move to a full queue.
    #[serde(default)]
    pub queue_full: Option<QueueFullWord>,
    /// Faults that are put on axes on the way.
    #[serde(default)]
    pub faults: Vec<FaultAt>,
    /// The file of its trace, `.csv` or `.mcap`; `{case}` in it is the number of the case.
    #[serde(default)]
    pub trace: Option<String>,
}

/// The behaviour of a coordinated move that finds the queue full.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum QueueFullWord {
    /// It waits for room.
    Wait,
    /// It errs, as on a controller.
    Error,
}

impl From<QueueFullWord> for QueueFull {
    fn from(word: QueueFullWord) -> Self {
        match word {
            QueueFullWord::Wait => Self::Wait,
            QueueFullWord::Error => Self::Error,
        }
    }
}

/// A fault on the way.
#[derive(Clone, PartialEq, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FaultAt {
    /// Name of the axis.
    pub axis: String,
    /// The word of the fault, such as `overcurrent` (docs/FAULTS.md).
    pub fault: String,
    /// When.
    pub at: FaultTime,
}

/// A time, s after the beginning.
#[derive(Clone, Copy, PartialEq, Debug, Deserialize)]
#[serde(untagged)]
pub enum FaultTime {
    /// At that time.
    At(f64),
    /// At a time between these two, by the seed.
    Between([f64; 2]),
}

/// Names with values, in the order in which they are written.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Pairs(pub Vec<(String, WriteValue)>);

impl<'de> Deserialize<'de> for Pairs {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_map(PairsVisitor)
    }
}

struct PairsVisitor;

impl<'de> Visitor<'de> for PairsVisitor {
    type Value = Pairs;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("an object of names and values")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Pairs, A::Error> {
        let mut pairs = Vec::new();
        while let Some(pair) = map.next_entry()? {
            pairs.push(pair);
        }
        Ok(Pairs(pairs))
    }
}

impl Case {
    /// The case of a line.
    ///
    /// # Errors
    /// It is no JSON object, or has members that no case has.
    pub fn parse(line: &str) -> Result<Self, Invalid> {
        if !line.trim_start().starts_with('{') {
            return Err(Invalid("expected a JSON object, such as {}".to_owned()));
        }
        let case: Case = serde_json::from_str(line).map_err(|error| {
            // Of the line itself; in which line of the file it stands, the caller says.
            Invalid(error.to_string().replace(" at line 1 column ", ", column "))
        })?;
        if case.program.is_some() && case.text.is_some() {
            return Err(Invalid(
                "program is a file and text is the program itself: expected one of them".to_owned(),
            ));
        }
        Ok(case)
    }

    /// Its faults: tick, axis and cause.
    ///
    /// # Errors
    /// There is no such axis or fault, or the time is none.
    pub fn faults(&self, machine: &Machine, seed: u64) -> Result<Vec<(u64, AxisId, FaultSet)>, Invalid> {
        let mut faults = Vec::with_capacity(self.faults.len());
        for (number, fault) in (0_u64..).zip(&self.faults) {
            let (axis, kind) = fault.cause(machine)?;
            let [from, to] = match fault.at {
                FaultTime::At(at) => [at, at],
                FaultTime::Between(range) => range,
            };
            if !(0.0..1e9).contains(&from) || !(from..1e9).contains(&to) {
                return Err(Invalid(format!(
                    "faults[{number}].at: expected a time from 0 to 1e9 s, or two of them in order"
                )));
            }
            let at = from + (to - from) * share(seed, number);
            let tick = (at * 1e9 / machine.period_ns as f64).round() as u64;
            faults.push((tick, axis, kind));
        }
        faults.sort_by_key(|(tick, ..)| *tick);
        Ok(faults)
    }
}

impl FaultAt {
    fn cause(&self, machine: &Machine) -> Result<(AxisId, FaultSet), Invalid> {
        let names = machine.axes.iter().map(|axis| axis.name.as_str());
        let place = names.clone().position(|name| name.eq_ignore_ascii_case(&self.axis));
        let Some(place) = place else {
            return Err(unknown("axis", &self.axis, names.collect()));
        };
        let spaced = self.fault.replace('_', " ");
        let fault = FAULTS
            .iter()
            .find(|fault| fault.word.replace('_', " ").eq_ignore_ascii_case(&spaced));
        let Some(fault) = fault else {
            let words = FAULTS.iter().map(|fault| fault.word).collect();
            return Err(unknown("fault", &self.fault, words));
        };
        let cause = FaultSet::default().with(fault.kind);
        if cause.bits() & !FaultSet::possible(!machine.axes[place].is_virtual()).bits() != 0 {
            let axis = &self.axis;
            return Err(Invalid(format!("{axis} is a virtual axis and cannot have that fault")));
        }
        Ok((AxisId::from_index(place), cause))
    }
}

fn unknown(what: &str, name: &str, known: Vec<&str>) -> Invalid {
    Invalid(match nearest(name, known.iter().copied()) {
        Some(near) => format!("there is no {what} {name:?}, did you mean {near:?}?"),
        None => format!("there is no {what} {name:?}, expected one of {}", known.join(", ")),
    })
}

/// A number from 0 to 1 of a seed and a place: SplitMix64.
fn share(seed: u64, place: u64) -> f64 {
    let mut state = seed.wrapping_add(place.wrapping_add(1).wrapping_mul(0x9E37_79B9_7F4A_7C15));
    state = (state ^ (state >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    state = (state ^ (state >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    state ^= state >> 31;
    (state >> 11) as f64 / (1_u64 << 53) as f64
}
