//! Implicit I/O: connections of transport class 0 and 1 over UDP, the target's side without sockets and clocks
//! (CIP Vol. 1, 3-4 to 3-6; CIP Vol. 2, 3-3; spec/ethernet-ip.md §14).
//!
//! [`IoConnections`] opens, closes and expires connections, takes datagrams in and gives datagrams out; [`Datagram`] is
//! their codec; [`Assemblies`] lists the assemblies that a connection can name. Not here: the content of an assembly. `now` is the
//! time since any fixed moment; it never runs backwards. Sizes are in bytes, intervals in microseconds on the wire.

mod application;
mod connection;
mod connections;
mod datagram;
mod production;

pub use application::{Application, Assemblies, Assembly};
pub use connections::{Ended, IoConnections, IoEvent, IoSettings, Originator, Ownership};
pub use datagram::{DATAGRAM_HEAD, Datagram};

/// The UDP port of class 0 and 1 connections (spec/ethernet-ip.md §1).
pub const IO_PORT: u16 = 2222;
