//! Any text as an L5X file, and any text as what stands in the controller of one. What is read can be written and read
//! again as the same project.
#![no_main]

use arcline_fuzz::timed;
use arcline_l5x::{export, import};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| timed(|| run(data)));

fn run(data: &[u8]) {
    let Ok(text) = std::str::from_utf8(data) else { return };
    let inside = format!("<RSLogix5000Content><Controller Name=\"C\">{text}</Controller></RSLogix5000Content>");
    for file in [text, &inside] {
        let Ok(first) = import(file, "fuzz.L5X") else { continue };
        let again = import(&export(&first.project), "exported.L5X").expect("an export can be imported");
        // NaN is not equal to itself; the bytes of tags are compared as they are.
        assert_eq!(again.project, first.project);
    }
}
