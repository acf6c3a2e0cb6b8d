//! Any text is a rung, an expression and Structured Text, or an error; what is read prints, and a routine of it compiles or is named.
#![no_main]

use arcline_fuzz::timed;
use arcline_routine::source::{Content, ProgramSource, Project, RoutineSource, RungSource};
use arcline_routine::{Expression, NoMachine, Rung, Text, load};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| timed(|| run(data)));

fn run(data: &[u8]) {
    let Ok(text) = std::str::from_utf8(data) else { return };
    let _ = Expression::parse(text);
    if let Ok(rung) = Rung::parse(text) {
        let printed = rung.to_string();
        let again = Rung::parse(&printed).expect("a printed rung reads");
        assert_eq!(again.to_string(), printed);
    }
    if let Ok(read) = Text::parse(text) {
        assert_eq!(read.to_string(), text);
    }
    let rung = RungSource {
        number: 0,
        kind: "N".to_owned(),
        text: text.to_owned(),
        comment: String::new(),
    };
    let routine = |name: &str, content| RoutineSource {
        name: name.to_owned(),
        content,
    };
    let project = Project {
        programs: vec![ProgramSource {
            name: "Main".to_owned(),
            main: None,
            fault: None,
            is_disabled: false,
            tags: Vec::new(),
            routines: vec![
                routine("Ladder", Content::Ladder(vec![rung])),
                routine("Text", Content::Text(vec![(0, text.to_owned())])),
            ],
        }],
        ..Project::default()
    };
    let _ = load(&project, &mut NoMachine).findings;
}
