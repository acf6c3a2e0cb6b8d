//! Routines on a machine that has no motion: a row a behaviour.

mod aliases;
mod by_reference;
mod effects;
mod events;
mod first_numbers;
mod instructions;
mod mended;
mod messages;
mod monitored;
mod motion;
mod projects;
mod refused;
mod settled;
mod status;
mod texts;
mod unfit;
mod wires;

use crate::source::{
    Content, Datum, ProgramSource, Project, RoutineSource, RungSource, TagSource, TaskSource, Trigger,
};
use crate::{Cell, NoMachine, load};

/// `N DINT 5, B BOOL, A DINT[8], T TIMER 100`: name, type and first value (of structures the preset or length).
pub(crate) fn tags(text: &str) -> Vec<TagSource> {
    let all = text.split(',').map(str::trim).filter(|text| !text.is_empty());
    all.map(|text| {
        let mut words = text.split_whitespace();
        let name = words.next().unwrap_or_default().to_owned();
        let kind = words.next().unwrap_or_default();
        let value = words.next();
        let (data_type, dimensions) = match kind.split_once('[') {
            Some((kind, sizes)) => {
                let sizes = sizes
                    .trim_end_matches(']')
                    .split(';')
                    .filter_map(|size| size.parse().ok());
                (kind.to_owned(), sizes.collect())
            }
            None => (kind.to_owned(), Vec::new()),
        };
        let number = |text: &str| Datum::Number(text.to_owned());
        let value = value.map(|value| match data_type.as_str() {
            "TIMER" | "COUNTER" => Datum::Structure(data_type.clone(), vec![("PRE".to_owned(), number(value))]),
            "CONTROL" => Datum::Structure(data_type.clone(), vec![("LEN".to_owned(), number(value))]),
            "STRING" => Datum::Text(value.as_bytes().to_vec()),
            _ if !dimensions.is_empty() => Datum::Array(value.split(';').map(number).collect()),
            _ => number(value),
        });
        TagSource::new(name, data_type, dimensions, value)
    })
    .collect()
}

/// A routine of rungs, or of Structured Text when no line is a rung.
pub(crate) fn routine(name: &str, text: &str) -> RoutineSource {
    let lines = text.lines().map(str::trim).filter(|line| !line.is_empty());
    let content = match text.trim().strip_prefix("ST") {
        Some(text) => Content::Text((0..).zip(text.lines()).map(|(k, line)| (k, line.to_owned())).collect()),
        None => Content::Ladder(
            (0..)
                .zip(lines)
                .map(|(number, text)| RungSource {
                    number,
                    kind: "N".to_owned(),
                    text: text.to_owned(),
                    comment: String::new(),
                })
                .collect(),
        ),
    };
    RoutineSource {
        name: name.to_owned(),
        content,
    }
}

/// A project of one program on a task of 10 ms. The first routine is its main one.
pub(crate) fn project(tag_text: &str, routines: &[(&str, &str)]) -> Project {
    Project {
        tags: tags(tag_text),
        programs: vec![ProgramSource {
            name: "Main".to_owned(),
            main: routines.first().map(|(name, _)| (*name).to_owned()),
            fault: None,
            is_disabled: false,
            tags: Vec::new(),
            routines: routines.iter().map(|(name, text)| routine(name, text)).collect(),
        }],
        tasks: vec![TaskSource::new("Task", Trigger::Periodic(10.0), &["Main"])],
        ..Project::default()
    }
}

/// A project that loads, after prescan.
pub(crate) fn started(why: &str, project: &Project) -> Cell {
    let loaded = load(project, &mut NoMachine);
    let findings: Vec<String> = loaded.findings.iter().map(ToString::to_string).collect();
    assert!(findings.is_empty(), "{why}: {findings:?}");
    let mut cell = loaded.cell;
    cell.start(0, &mut NoMachine)
        .unwrap_or_else(|fault| panic!("{why}: {fault}"));
    cell
}

pub(crate) fn set(why: &str, cell: &mut Cell, project: &Project, text: &str) {
    let (tag, value) = text.split_once('=').unwrap_or((text, "1"));
    let writes = cell.writes(project, &mut NoMachine, &[(tag.trim(), value.trim())]);
    let writes = writes.unwrap_or_else(|(_, reason)| panic!("{why}: {text}: {reason}"));
    cell.write(&writes, &mut NoMachine)
        .unwrap_or_else(|tag| panic!("{why}: {text}: {tag} is not written"));
}

pub(crate) fn expect(why: &str, cell: &mut Cell, project: &Project, text: &str) {
    let condition = cell.condition(project, &mut NoMachine, text);
    let condition = condition.unwrap_or_else(|reason| panic!("{why}: {text}: {reason}"));
    assert!(cell.holds(&condition, &mut NoMachine), "{why}: {text} does not hold");
}

/// Runs a script. Each line is a scan: `tags to set : conditions after the scan`. The conditions of a line `pre : …` hold after
/// prescan, and `50 x` before a line repeats its scan.
pub(crate) fn script(why: &str, project: &Project, lines: &str) -> Cell {
    let mut cell = started(why, project);
    let mut tick = 0;
    for line in lines.lines().map(str::trim).filter(|line| !line.is_empty()) {
        let line = line.replace("Program:", "\\");
        let (sets, expected) = line.split_once(':').unwrap_or((&line, ""));
        let expectations = expected.split(';').map(str::trim).filter(|text| !text.is_empty());
        let (count, sets) = match sets.split_once(" x") {
            Some((count, sets)) => (count.trim().parse().unwrap_or(1), sets),
            None => (1, sets),
        };
        let why = format!("{why}, {line:?}");
        if sets.trim() != "pre" {
            for text in sets.split(',').map(str::trim).filter(|text| !text.is_empty()) {
                set(&why, &mut cell, project, text);
            }
            for _ in 0..count {
                let ran = cell.tick(tick, 10_000_000, &mut NoMachine);
                ran.unwrap_or_else(|fault| panic!("{why}: {fault}"));
                tick += 1;
            }
        }
        expectations.for_each(|text| expect(&why, &mut cell, project, text));
    }
    cell
}
