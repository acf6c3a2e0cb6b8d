//! Limits and settings of a session (spec/ethernet-ip.md §18).
//!
//! Not here: the server's own limits (sockets, connections of all sessions). Sizes are in bytes.

use std::time::Duration;

use super::Slots;
use crate::encap::{DEFAULT_LIMIT, Service};

/// The treatment of a class 3 message for a connection that this socket does not have.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum UnknownConnection {
    /// Close the socket, so that the client notices at once.
    Close,
    /// Ignore it, as the specification has it; the client waits for its timeout.
    Ignore,
}

/// Limits and settings of a session (spec/ethernet-ip.md §18).
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Settings {
    /// Bytes accepted behind an encapsulation header.
    pub frame_limit: usize,
    /// Class 3 connections of one session.
    pub max_connections: usize,
    /// Largest connection size granted, bytes with the sequence count.
    pub max_connection_size: u16,
    /// Longest router reply to an unconnected message, bytes.
    pub unconnected_reply_limit: usize,
    /// Requests that may be unanswered before no more input is taken.
    pub max_pending: usize,
    /// Time for the first RegisterSession.
    pub register_timeout: Duration,
    /// Silence after which the socket is closed (TCP/IP object, attribute 13); `None`: never.
    pub inactivity: Option<Duration>,
    /// Routes to this controller.
    pub slots: Slots,
    /// Messages for connections that are not there.
    pub unknown_connection: UnknownConnection,
    /// Capability word of ListServices.
    pub capability: u16,
    /// Whether only the List commands are answered; all others get encapsulation status 0x006A.
    pub discovery_only: bool,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            frame_limit: DEFAULT_LIMIT,
            max_connections: 32,
            max_connection_size: 4002,
            unconnected_reply_limit: 504,
            max_pending: 64,
            register_timeout: Duration::from_secs(30),
            inactivity: Some(Duration::from_secs(120)),
            slots: Slots::Only(vec![0]),
            unknown_connection: UnknownConnection::Close,
            capability: Service::TCP,
            discovery_only: false,
        }
    }
}
