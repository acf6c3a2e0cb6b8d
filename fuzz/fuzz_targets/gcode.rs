//! Any text is a G-code program or an error, and a program is Structured Text of finite numbers.
#![no_main]

use arcline_fuzz::timed;
use arcline_gcode::{Options, Program};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| timed(|| run(data)));

fn run(data: &[u8]) {
    let Ok(text) = std::str::from_utf8(data) else { return };
    for axes in 1..=3 {
        let options = Options {
            axes,
            inches: axes == 2,
            ..Options::default()
        };
        if let Ok(program) = Program::parse(text, &options) {
            let made = program.structured_text("CS1", "M");
            assert!(!made.text.contains("NaN") && !made.text.contains("inf"));
            assert_eq!(made.lines.len(), program.steps.len());
        }
    }
}
