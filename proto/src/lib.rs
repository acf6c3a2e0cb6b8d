//! EtherNet/IP and CIP as values: bytes in, typed messages out, and back.
//!
//! Both directions everywhere: a server decodes requests and encodes replies, a client the reverse. No socket, no clock
//! (`now` is an argument), no randomness (the caller brings it), no motion. No input panics, and nothing is allocated
//! that a peer has only claimed. All integers on the wire are little-endian except socket addresses.

#![forbid(unsafe_code)]

pub mod arcline;
pub mod cip;
pub mod client;
pub mod connection;
pub mod cpf;
pub mod discovery;
pub mod encap;
pub mod epath;
pub mod identity;
pub mod io;
pub mod logix;
pub mod security;
pub mod session;
pub mod status;
pub mod wire;
