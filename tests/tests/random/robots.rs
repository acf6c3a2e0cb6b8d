//! Random programs of robots of every geometry: continuous, within their limits, and nothing is left behind
//! ([`arcline_tests::robot_programs`]).
#![allow(missing_docs)]

use arcline_tests::robot_programs::{Scope, run};

#[test]
fn random_programs_well_inside_the_reach() {
    run(&Scope::INSIDE, 2000);
}
