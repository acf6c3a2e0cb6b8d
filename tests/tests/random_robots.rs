//! Random programs of robots of every geometry: continuous, within their limits, and nothing is left behind
//! ([`arcline_tests::robot_programs`]).
//!
//! `ARCLINE_CASES` sets how many are run (2,000 unless set), `ARCLINE_SEED` the first (0).
#![allow(missing_docs)]

use arcline_tests::robot_programs::{Scope, run};

#[test]
fn random_programs_well_inside_the_reach() {
    run(&Scope::INSIDE, 2000);
}
