//! The command line from one end to the other: `arcline` and `arcline-server` as a user starts them.

mod attributes;
mod commands;
mod endings;
mod faults;
mod gcode;
mod lost;
mod tls;
mod tools;
mod trace;
