//! Output: results on standard output, as text or as one JSON object each; errors of text mode on standard error.

use std::borrow::Cow;
use std::io::{IsTerminal, Write};
use std::path::Path;
use std::time::UNIX_EPOCH;

use indicatif::{ProgressBar, ProgressStyle};
use serde_json::{Map, Value as Json, json};

use arcline_client::{Ended, Execution, Flag, MotionControl};
use arcline_instruction_set::Ending;

use super::Failure;
use super::wait::Completed;

/// Whether the path of an output file is `-`, the standard output.
pub(crate) fn is_standard_output(path: &Path) -> bool {
    path == Path::new("-")
}

/// The output of results.
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

    /// A bar of progress by a constant template, on a terminal only.
    pub(crate) fn bar(&self, length: u64, template: &str) -> ProgressBar {
        if !self.is_watched() {
            return ProgressBar::hidden();
        }
        let bar = ProgressBar::new(length);
        // A constant template is always valid.
        match ProgressStyle::with_template(template) {
            Ok(style) => bar.with_style(style),
            Err(_) => bar,
        }
    }

    /// Prints one result: the text, or the object.
    pub(crate) fn result(&self, text: impl AsRef<str>, object: impl FnOnce() -> Json) {
        let mut out = std::io::stdout().lock();
        // A reader that has gone away (`| head`) is no error of ours.
        let _ = if self.json {
            writeln!(out, "{}", json_text(&object()))
        } else {
            writeln!(out, "{}", printable(text.as_ref()))
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

    /// Text for people only.
    pub(crate) fn note(&self, text: &str) {
        if !self.json {
            let _ = writeln!(std::io::stderr(), "{}", printable(text));
        }
    }

    /// Prints the reason for which a command failed.
    pub(crate) fn failure(&self, failure: &Failure) {
        if matches!(
            failure,
            Failure::Interrupted | Failure::Several { .. } | Failure::Reported { .. }
        ) {
            return;
        }
        if !self.json {
            // Best effort: there is no other output for a failure.
            let _ = writeln!(std::io::stderr(), "{}", printable(&failure.to_string()));
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
        if let Failure::On { target, .. } = failure {
            object.insert("target".to_owned(), Json::from(target.as_str()));
        }
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

/// A text for a terminal: characters that would control it, or turn the direction of writing, as `\u{1b}`. Texts of servers, files and
/// arguments come through here.
pub(crate) fn printable(text: &str) -> Cow<'_, str> {
    if !text.chars().any(controls) {
        return text.into();
    }
    let escaped = text.chars().map(|c| match c {
        c if controls(c) => c.escape_unicode().to_string(),
        c => c.to_string(),
    });
    escaped.collect::<String>().into()
}

/// JSON, likewise: its own rules let controls from U+007F on through.
fn json_text(object: &Json) -> String {
    let text = object.to_string();
    if !text.chars().any(controls) {
        return text;
    }
    let escaped = text.chars().map(|c| match c {
        c if controls(c) => format!("\\u{:04x}", u32::from(c)),
        c => c.to_string(),
    });
    escaped.collect()
}

/// Whether a character controls a terminal, or the direction of writing. The lines and columns of results are no such characters.
fn controls(c: char) -> bool {
    let turns = matches!(c, '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    turns || c.is_control() && !matches!(c, '\n' | '\t')
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
    use serde_json::json;

    use super::{counted, json_text, printable, table};

    #[test]
    fn texts_do_not_control_the_terminal() {
        #[rustfmt::skip]
        let cases = [
            ("the title of the window", "\u{1b}]0;owned\u{7}",   "\\u{1b}]0;owned\\u{7}"),
            ("a control of eight bits", "\u{9b}2J",              "\\u{9b}2J"),
            ("back to the beginning",   "bad\rgood",             "bad\\u{d}good"),
            ("another direction",       "abc\u{202e}txt",        "abc\\u{202e}txt"),
            ("what a table has",        "a\tb\nc äß中",          "a\tb\nc äß中"),
        ];
        for (why, text, expected) in cases {
            assert_eq!(printable(text), expected, "{why}");
            let json = json_text(&json!({ "name": text }));
            assert!(!json.chars().any(char::is_control), "{why}: {json}");
            let back: serde_json::Value = serde_json::from_str(&json).expect("still JSON");
            assert_eq!(back["name"], text, "{why}");
        }
    }

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
