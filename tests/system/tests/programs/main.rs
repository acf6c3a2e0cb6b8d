//! The programs as users start them, without anything from outside of the project.

mod batches;
mod cli;
mod client_examples;
mod clocks;
mod commands;
mod controller;
mod doctor;
mod guide;
mod l5x;
mod login_time;
mod masters;
mod outputs;
mod pictures;
mod plants;
mod readme;
mod retained_state;
mod simulate;
mod startup;
mod systemd;
mod tag_table;
mod testing;
mod update_periods;
