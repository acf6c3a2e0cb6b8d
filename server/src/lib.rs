//! A coordinated-motion server that looks like a Logix controller on EtherNet/IP.
//!
//! The asynchronous side and the operating system: command line, sockets, signals, files, and the interface of the
//! controller that they share ([`plant`]). Not here: frames and messages as values (`arcline-proto`), motion and tag
//! memory (`arcline-controller`), the thread that ticks (`arcline-realtime`).

#![forbid(unsafe_code)]

mod audit;
mod cli;
mod doctor;
pub mod eip;
mod guard;
mod health;
pub mod hmi;
mod l5x;
mod limits;
mod live;
mod metrics;
#[cfg(test)]
mod pages;
pub mod plant;
mod retained;
mod run;
mod simulate;
pub mod stepped;
mod systemd;
mod tls;
pub mod trace;
mod users;
mod watch;
mod work_threads;

pub use cli::main;
pub use retained::NotPersisted;
