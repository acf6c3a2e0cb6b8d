//! Random programs of robots of every geometry: continuous, within their limits, and nothing is left behind
//! ([`arcline_tests::robot_programs`]).
#![allow(missing_docs)]

use arcline_tests::robot_programs::{Scope, run, run_one};

#[test]
fn random_programs_well_inside_the_reach() {
    run(&Scope::INSIDE, 2000);
}

#[test]
fn random_programs_on_planned_contours() {
    run(&Scope::PRECISE, 400);
}

/// A move that an MCCD let overshoot its end, with others behind it: the stop that the robot's guard checked led over to their paths.
#[test]
fn a_robot_follows_a_move_beyond_its_end() {
    run_one(&Scope::INSIDE, 2_080_015_515);
}

/// A merge onto a planned contour that speeds up hard: its residual led out of the reach.
#[test]
fn a_merge_onto_a_contour_stays_inside_the_reach() {
    run_one(&Scope::PRECISE, 143);
}
