//! Output: results on standard output, as text or as one JSON object each; errors of text mode on standard error.

use std::io::{IsTerminal, Write};
use std::time::UNIX_EPOCH;

use serde_json::{Map, Value as Json, json};

use arcline_client::{Ended, Execution, Flag, MotionControl};
use arcline_instruction_set::Ending;

use super::Failure;
use super::wait::Completed;

/// Where results go.
#[derive(Debug)]
pub(crate) struct Output {
    json: bool,
}

impl Output {
    pub(crate) fn new(json: bool) -> Self {
        Self { json }
    }

    /// Whether results are JSON objects.
    pub(crate) fn is_json(&self) -> bool {
        self.json
    }

    /// Whether the output is a terminal, which shows progress.
    pub(crate) fn is_watched(&self) -> bool {
        !self.json && std::io::stderr().is_terminal() && std::io::stdout().is_terminal()
    }

    /// Prints one result: the text, or the object.
    pub(crate) fn result(&self, text: impl AsRef<str>, object: impl FnOnce() -> Json) {
        let mut out = std::io::stdout().lock();
        // A reader that has gone away (`| head`) is no error of ours.
        let _ = if self.json {
            writeln!(out, "{}", object())
        } else {
            writeln!(out, "{}", text.as_ref())
        };
    }

    /// Prints how an instruction stands.
    pub(crate) fn execution(&self, execution: &Execution, control: &MotionControl) {
        self.completed(execution, &Completed::from(*control));
    }

    /// Prints how an instruction has ended: `MAJ S: stopped by MAS`.
    pub(crate) fn completed(&self, execution: &Execution, completed: &Completed) {
        let Completed { control, ended } = completed;
        let bits: Vec<&str> = Flag::in_word(control.flags).map(Flag::name).collect();
        let how = ended.as_ref().map_or_else(|| bits.join(" "), ToString::to_string);
        let text = format!("{} {}: {how}", execution.mnemonic, execution.target);
        self.result(text, || {
            let mut object = json!({
                "instruction": execution.mnemonic.name(), "target": execution.target, "tag": execution.tag,
                "instance": execution.instance, "status": bits, "ERR": control.err, "EXERR": control.exerr,
            });
            if let Some(ended) = ended {
                object["ended"] = ending(ended);
            }
            object
        });
    }

    /// Something for people only.
    pub(crate) fn note(&self, text: &str) {
        if !self.json {
            let _ = writeln!(std::io::stderr(), "{text}");
        }
    }

    /// Tells why a command failed.
    pub(crate) fn failure(&self, failure: &Failure) {
        if matches!(
            failure,
            Failure::Interrupted | Failure::Several { .. } | Failure::Reported { .. }
        ) {
            return;
        }
        if !self.json {
            // Best effort: there is no other output for a failure.
            let _ = writeln!(std::io::stderr(), "{failure}");
            if self.is_watched()
                && let Some((error, (err, exerr))) = failure.client().and_then(|error| Some((error, error.motion()?)))
            {
                let instruction = error
                    .instruction()
                    .map(|mnemonic| format!(" {mnemonic}"))
                    .unwrap_or_default();
                self.note(&format!(
                    "`arcline explain {err}/{exerr}{instruction}` shows cause and remedy"
                ));
            }
            return;
        }
        let mut object = Map::new();
        object.insert("error".to_owned(), Json::from(failure.to_string()));
        if let Some((error, (err, exerr))) = failure.client().and_then(|error| Some((error, error.motion()?))) {
            object.insert(
                "instruction".to_owned(),
                Json::from(error.instruction().map(|mnemonic| mnemonic.name())),
            );
            object.insert("ERR".to_owned(), Json::from(err));
            object.insert("EXERR".to_owned(), Json::from(exerr));
        }
        if let Some(ended) = failure.ended() {
            object.insert("ended".to_owned(), ending(ended));
        }
        self.result("", || Json::Object(object));
    }
}

/// The cause that ended an instruction, as JSON.
fn ending(ended: &Ended) -> Json {
    let at = ended.at.duration_since(UNIX_EPOCH).unwrap_or_default().as_secs_f64();
    let mut object = match &ended.ending {
        Ending::Instruction { mnemonic, tag } => {
            json!({"by": "instruction", "instruction": mnemonic.name(), "tag": tag})
        }
        Ending::Fault { axis, faults } => json!({"by": "fault", "axis": axis, "faults": Ending::words(*faults)}),
        Ending::StopAll => json!({"by": "stop"}),
        Ending::Jog(why) => json!({"by": "dead-man", "reason": why.word()}),
    };
    object["time_s"] = ended.time.into();
    object["unix_s"] = at.into();
    object
}

/// `1 move`, `2 moves`.
pub(crate) fn counted(count: impl TryInto<u64>, noun: &str) -> String {
    let count = count.try_into().unwrap_or(u64::MAX);
    match noun {
        "axis" if count != 1 => format!("{count} axes"),
        _ => format!("{count} {noun}{}", if count == 1 { "" } else { "s" }),
    }
}

/// Columns as wide as their widest cell; numbers to the right.
pub(crate) fn table(header: &[&str], rows: &[Vec<String>]) -> String {
    let width = |column: usize| {
        let cells = rows
            .iter()
            .filter_map(|row| row.get(column))
            .map(|cell| cell.chars().count());
        cells
            .chain(header.get(column).map(|title| title.chars().count()))
            .max()
            .unwrap_or_default()
    };
    let numeric = |column: usize| {
        let mut cells = rows.iter().filter_map(|row| row.get(column)).peekable();
        cells.peek().is_some() && cells.all(|cell| cell.parse::<f64>().is_ok())
    };
    let columns: Vec<(usize, bool)> = (0..header.len())
        .map(|column| (width(column), numeric(column)))
        .collect();
    let line = |cells: &mut dyn Iterator<Item = &str>| {
        let padded = cells.zip(&columns).map(|(cell, (width, right))| {
            if *right {
                format!("{cell:>width$}")
            } else {
                format!("{cell:<width$}")
            }
        });
        padded.collect::<Vec<_>>().join("  ").trim_end().to_owned()
    };
    let mut lines = vec![line(&mut header.iter().copied())];
    lines.extend(rows.iter().map(|row| line(&mut row.iter().map(String::as_str))));
    lines.join("\n")
}

#[cfg(test)]
mod tests {
    use super::{counted, table};

    #[test]
    fn nouns_follow_their_number() {
        let counts = [0_usize, 1, 24].map(|count| counted(count, "instruction"));
        assert_eq!(counts, ["0 instructions", "1 instruction", "24 instructions"]);
    }

    #[test]
    fn tables_are_aligned() {
        let rows = [["X", "1.500", "on"], ["Long", "-20.000", "off"]];
        let rows: Vec<Vec<String>> = rows
            .iter()
            .map(|row| row.iter().map(|c| (*c).to_owned()).collect())
            .collect();
        let expected = "axis  position  servo\nX        1.500  on\nLong   -20.000  off";
        assert_eq!(table(&["axis", "position", "servo"], &rows), expected);
    }
}
