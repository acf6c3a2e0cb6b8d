//! One open class 3 connection of a client: the message outstanding on it, and those that wait (spec/ethernet-ip.md §8).
//!
//! Not here: the deadlines of its calls, which are the session's.

use bytes::Bytes;
use std::collections::VecDeque;

use super::Call;
use crate::connection::ForwardOpenReply;
use crate::cpf::{ConnectionId, Packet};
use crate::epath::Epath;

/// An open connection.
#[derive(Debug)]
pub(super) struct Connection {
    o_to_t_id: ConnectionId,
    t_to_o_id: ConnectionId,
    sequence: u16,
    path: Epath,
    outstanding: Option<Call>,
    backlog: VecDeque<(Call, Bytes)>,
}

impl Connection {
    /// As the target has opened it along `path`.
    pub(super) fn new(opened: &ForwardOpenReply, path: Epath) -> Self {
        Self {
            o_to_t_id: opened.o_to_t_id,
            t_to_o_id: opened.t_to_o_id,
            sequence: 0,
            path,
            outstanding: None,
            backlog: VecDeque::new(),
        }
    }

    /// The path it was opened with.
    pub(super) const fn path(&self) -> &Epath {
        &self.path
    }

    /// Lets a message wait behind the others.
    pub(super) fn push(&mut self, call: Call, message: Bytes) {
        self.backlog.push_back((call, message));
    }

    /// The next message to send; `None` while one is outstanding.
    pub(super) fn next(&mut self) -> Option<(Call, Packet)> {
        if self.outstanding.is_some() {
            return None;
        }
        let (call, message) = self.backlog.pop_front()?;
        self.sequence = self.sequence.wrapping_add(1);
        self.outstanding = Some(call);
        Some((call, Packet::connected(self.o_to_t_id, self.sequence, &message)))
    }

    /// Whether the target's messages to `id` are for it.
    pub(super) fn hears(&self, id: ConnectionId) -> bool {
        self.t_to_o_id == id
    }

    /// The call that a reply with this sequence count is for.
    pub(super) fn awaited(&self, sequence: u16) -> Option<Call> {
        self.outstanding.filter(|_| self.sequence == sequence)
    }

    /// The outstanding message has its reply.
    pub(super) fn replied(&mut self) {
        self.outstanding = None;
    }

    /// The call whose message was sent and has no reply.
    pub(super) fn outstanding(&self) -> Option<Call> {
        self.outstanding
    }

    /// The calls whose messages were not sent.
    pub(super) fn into_unsent(self) -> impl Iterator<Item = Call> {
        self.backlog.into_iter().map(|(call, _)| call)
    }
}
