//! The events of a trace that are marked: when an instruction became active, and when one erred.

use serde::Deserialize;

use crate::PlotError;

/// A moment worth a mark.
#[derive(Clone, PartialEq, Debug)]
pub struct Mark {
    /// Seconds.
    pub time: f64,
    /// Such as `MCLM Move1`, or `MCLM Move1: ERR 13`.
    pub text: String,
    /// Whether the instruction erred.
    pub erred: bool,
}

#[derive(Deserialize)]
struct Event {
    time_s: f64,
    #[serde(default)]
    tag: String,
    instruction: String,
    #[serde(default)]
    set: Vec<String>,
    #[serde(default, rename = "ERR")]
    err: i64,
}

impl Mark {
    /// Reads the JSON lines of `simulate --events`. Moves are marked when they become active (AC), other motion when it
    /// is in process, errors when they come.
    ///
    /// # Errors
    /// [`PlotError::Line`].
    pub fn parse(text: &str) -> Result<Vec<Self>, PlotError> {
        let mut marks = Vec::new();
        for (place, line) in text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty()) {
            let event: Event = serde_json::from_str(line).map_err(|error| PlotError::Line {
                line: place + 1,
                problem: error.to_string(),
            })?;
            let sets = |bit: &str| event.set.iter().any(|set| set == bit);
            let name = format!("{} {}", event.instruction, event.tag);
            let name = name.trim();
            // Coordinated moves begin with AC, other instructions with IP.
            let is_move = matches!(event.instruction.as_str(), "MCLM" | "MCCM" | "MCPM");
            if sets("ER") {
                marks.push(Self {
                    time: event.time_s,
                    text: format!("{name}: ERR {}", event.err),
                    erred: true,
                });
            } else if sets("AC") || sets("IP") && !is_move {
                marks.push(Self {
                    time: event.time_s,
                    text: name.to_owned(),
                    erred: false,
                });
            }
        }
        Ok(marks)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn beginnings_and_errors_are_marked() {
        let text = r#"{"time_s":0,"tick":0,"tag":"M1","instruction":"MCLM","set":["EN","DN","IP","AC"],"clear":[],"ERR":0,"EXERR":0}
{"time_s":0,"tick":0,"tag":"M2","instruction":"MCLM","set":["EN","DN","IP"],"clear":[],"ERR":0,"EXERR":0}
{"time_s":1.5,"tick":1500,"tag":"M2","instruction":"MCLM","set":["AC"],"clear":[],"ERR":0,"EXERR":0}
{"time_s":2,"tick":2000,"tag":"J","instruction":"MAJ","set":["EN","DN","IP"],"clear":[],"ERR":0,"EXERR":0}
{"time_s":3,"tick":3000,"tag":"M3","instruction":"MCLM","set":["EN","ER"],"clear":[],"ERR":13,"EXERR":4}
"#;
        let marks = Mark::parse(text).expect("events");
        let told: Vec<String> = marks
            .iter()
            .map(|mark| format!("{} {} {}", mark.time, mark.text, mark.erred))
            .collect();
        assert_eq!(
            told,
            [
                "0 MCLM M1 false",
                "1.5 MCLM M2 false",
                "2 MAJ J false",
                "3 MCLM M3: ERR 13 true"
            ]
        );
        let error = Mark::parse("\n{\"time_s\":").expect_err("cut");
        assert!(error.to_string().starts_with("line 2: "), "{error}");
    }
}
