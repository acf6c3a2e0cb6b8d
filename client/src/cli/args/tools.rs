//! Arguments of `explain`, `doctor`, `completions` and `man`, which need no machine.

use std::path::PathBuf;
use std::str::FromStr;

use clap::Args;

use arcline_client::{FaultKind, Mnemonic, nearest};
use arcline_instruction_set::FAULTS;

#[derive(Args, Debug)]
pub(crate) struct Explain {
    /// ERR or ERR/EXERR, a fault of an axis, or a tag of an instruction, for its newest error
    #[arg(value_name = "ERR[/EXERR]|FAULT|TAG")]
    pub(crate) what: Subject,
    /// The instruction that erred, which gives EXERR its meaning
    #[arg(value_name = "INSTRUCTION", value_parser = mnemonic)]
    pub(crate) instruction: Option<Mnemonic>,
}

/// The subject of an explanation.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(crate) enum Subject {
    /// ERR, and EXERR if it is there.
    Codes(i16, Option<i8>),
    /// A fault of an axis.
    Fault(FaultKind),
    /// A MOTION_INSTRUCTION tag or an instruction tag.
    Tag(String),
}

impl FromStr for Subject {
    type Err = String;

    /// `13`, `13/4`, `overcurrent`, `Move1`.
    fn from_str(text: &str) -> Result<Self, String> {
        let text = text.trim();
        let (err, exerr) = match text.split_once(['/', ':']) {
            Some((err, exerr)) => (err, Some(exerr)),
            None => (text, None),
        };
        if let Ok(err) = err.parse() {
            let number = |exerr: &str| {
                let wrong = |_| format!("{exerr:?} is no EXERR, expected -128 to 127");
                exerr.parse().map_err(wrong)
            };
            let exerr = exerr.map(number).transpose()?;
            return Ok(Self::Codes(err, exerr));
        }
        if let Some(kind) = FaultKind::from_word(text) {
            return Ok(Self::Fault(kind));
        }
        if text.starts_with(|first: char| first.is_ascii_alphabetic() || first == '_') {
            return Ok(Self::Tag(text.to_owned()));
        }
        Err(format!(
            "{text:?} is no error, expected such as 13/4, a tag, or one of {}",
            fault_words()
        ))
    }
}

fn fault_words() -> String {
    let words: Vec<&str> = FAULTS.iter().map(|fault| fault.word).collect();
    words.join(", ")
}

/// An instruction by its mnemonic; the error of an unknown one suggests the nearest.
pub(super) fn mnemonic(text: &str) -> Result<Mnemonic, String> {
    text.parse().map_err(|error| {
        let near = nearest(text, Mnemonic::ALL.iter().map(|mnemonic| mnemonic.name()));
        match near {
            Some(near) => format!("{error}, did you mean {near}?"),
            None => format!("{error}; `arcline exec --help` lists them"),
        }
    })
}

#[derive(Args, Debug)]
pub(crate) struct Doctor {
    /// The configuration of the server; without it the embedded default
    #[arg(long, value_name = "FILE")]
    pub(crate) config: Option<PathBuf>,
    /// The file that the server is to keep its state in
    #[arg(long, value_name = "FILE")]
    pub(crate) state: Option<PathBuf>,
    /// Seconds for which ticks are measured; by default 2
    #[arg(long, value_name = "SECONDS")]
    pub(crate) measure: Option<f64>,
}

#[derive(Args, Debug)]
pub(crate) struct Completions {
    /// The shell
    #[arg(value_enum)]
    pub(crate) shell: clap_complete::Shell,
}

#[derive(Args, Debug)]
pub(crate) struct Man {
    /// Write a page for each command into this folder and create it; by default print the first page
    #[arg(short, long, value_name = "FOLDER")]
    pub(crate) output: Option<PathBuf>,
}
