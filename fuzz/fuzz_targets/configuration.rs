//! Any text as a configuration, and any text behind that of a small machine. What is valid has its tags, and written anew it is the
//! same project.
#![no_main]

use arcline_config::{load, table};
use arcline_controller::image::Image;
use arcline_fuzz::timed;
use libfuzzer_sys::fuzz_target;

/// An axis and a coordinate system.
const MACHINE: &str = include_str!("../seeds/configuration/machine");

fuzz_target!(|data: &[u8]| timed(|| run(data)));

fn run(data: &[u8]) {
    let Ok(text) = std::str::from_utf8(data) else { return };
    for text in [text, &format!("{MACHINE}\n{text}")] {
        let project = match load(text, "fuzz.toml") {
            Ok(project) => project,
            Err(error) => {
                let _ = error.to_string();
                continue;
            }
        };
        let mut image = Image::new(&project.machine, &project.instruction_tags, &project.tags);
        image.declare(&project.types);
        assert!(image.tags().len() >= project.tags.len());
        let _ = arcline_config::describe(&project);
        let again =
            load(&arcline_config::format(&table(&project)), "again.toml").expect("what was written can be read");
        assert_eq!(again, project);
    }
}
