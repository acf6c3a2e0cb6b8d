//! The cost of the page in a browser while it shows much. The scripts in `tests/browser` have the expectations.

use arcline_system_tests::browser::{case_of_rungs, case_on};

#[test]
fn frames_leave_time() {
    let _machine = crate::take_machine();
    case_on("frames_leave_time", "eight.toml");
}

#[test]
fn a_thousand_rungs_leave_time() {
    let _machine = crate::take_machine();
    case_of_rungs("a_thousand_rungs_leave_time", 1000);
}
