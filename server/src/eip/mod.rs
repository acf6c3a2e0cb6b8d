//! The EtherNet/IP interface: listeners, sessions, the router, CIP objects and tag services.
//!
//! Bytes and session rules are `arcline-proto`'s, which does no I/O; motion and the tag memory are behind
//! [`Plant`](crate::plant::Plant). Here they meet: a socket's bytes become requests, requests become reads and writes of
//! tags or calls of instructions, and replies go back. The meaning of the instructions is not here.
//!
//! Implicit I/O (`io`) has a socket and a thread of its own.
//!
//! One CIP message (a single request, or a whole Multiple Service Packet) is one action: the server applies all its tag writes
//! first, then executes the rising edges of `EnableIn`, and then answers.

mod accept;
mod action;
mod adapter;
mod connection;
mod context;
mod datagram;
mod device;
mod io;
mod limiter;
mod listener;
mod objects;
mod originator;
mod router;
mod session_host;
mod status;
pub(crate) mod stepped;
mod tags;
mod turns;

#[cfg(test)]
pub(crate) mod tests;

pub use device::Settings;
pub use io::Datagrams;
pub use listener::{BindError, Listener};

/// The tables of docs/IO.md and docs/OBJECTS.md.
pub mod pages {
    pub use super::io::page::{connections, input_assembly};
    pub use super::objects::page::objects;
}
