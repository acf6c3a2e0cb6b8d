//! The datagrams to one connection, or to several that share a multicast group: their times, destination and numbers.
//!
//! Not here: its consumers. A point-to-point connection has a production of its own; of a multicast one there is one for each
//! interval, class and trigger (spec/ethernet-ip.md §14.2).

use bytes::{BufMut, BytesMut};
use std::net::{IpAddr, SocketAddr};
use std::time::Duration;

use super::application::{OpenRequest, SEQUENCE_COUNT};
use super::datagram::Datagram;
use crate::cpf::ConnectionId;

/// The trigger of a production.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Trigger {
    /// The interval alone.
    Cyclic,
    /// A change of the data, and the interval when nothing changes.
    ChangeOfState {
        /// From one datagram to the next at least.
        inhibit: Duration,
    },
}

/// Data on its way from the target.
#[derive(Debug)]
pub(super) struct Production {
    /// Where it goes.
    pub(super) to: SocketAddr,
    pub(super) id: ConnectionId,
    /// From one datagram to the next, of a change of state at most.
    pub(super) interval: Duration,
    class_1: bool,
    trigger: Trigger,
    /// Connections that consume it.
    pub(super) consumers: usize,
    /// When the next datagram leaves; `None` before a Forward Open's reply has left.
    next: Option<Duration>,
    /// When it is looked at next whether data has changed.
    look: Duration,
    /// The data that was sent last, of a change of state.
    last: BytesMut,
    sent: u32,
    count: u16,
}

impl Production {
    /// Not begun; `interval` is not 0.
    pub(super) fn new(to: SocketAddr, id: ConnectionId, interval: Duration, request: OpenRequest) -> Self {
        Self {
            to,
            id,
            interval,
            class_1: request.class_1,
            trigger: request.trigger,
            consumers: 1,
            next: None,
            look: Duration::ZERO,
            last: BytesMut::new(),
            sent: 0,
            count: 0,
        }
    }

    /// Whether a multicast connection that wants `request` at an interval in a group can consume it.
    pub(super) fn serves(&self, group: IpAddr, interval: Duration, request: OpenRequest) -> bool {
        self.to.ip() == group
            && self.interval == interval
            && self.class_1 == request.class_1
            && self.trigger == request.trigger
    }

    /// From now on it produces, unless it does already.
    pub(super) fn start(&mut self, now: Duration) {
        self.next.get_or_insert(now);
    }

    /// When it has to be looked at.
    pub(super) fn due(&self) -> Option<Duration> {
        let next = self.next?;
        Some(match self.trigger {
            Trigger::Cyclic => next,
            Trigger::ChangeOfState { .. } => next.min(self.look),
        })
    }

    /// Appends the next datagram with `input`, if it is due. The first `volatile` bytes of it change always, and do not count
    /// as a change; one is looked for every `pace`.
    ///
    /// The schedule of a cyclic one is absolute: a late datagram does not move the next one, and those that were missed
    /// altogether are left out.
    pub(super) fn produce(
        &mut self,
        now: Duration,
        input: &[u8],
        volatile: usize,
        pace: Duration,
        out: &mut BytesMut,
    ) -> bool {
        let Some(due) = self.next.filter(|_| self.due().is_some_and(|due| due <= now)) else {
            return false;
        };
        match self.trigger {
            Trigger::Cyclic => {
                let missed = (now - due).as_nanos() / self.interval.as_nanos().max(1);
                let missed = u32::try_from(missed).unwrap_or(u32::MAX);
                self.next = Some(due + self.interval * missed.saturating_add(1));
                self.count = self.count.wrapping_add(1);
            }
            Trigger::ChangeOfState { inhibit } => {
                let changed = self.sent == 0 || self.last.get(volatile..) != input.get(volatile..);
                if !changed && now < due {
                    self.look = now + pace;
                    return false;
                }
                if changed {
                    self.count = self.count.wrapping_add(1);
                    self.last.clear();
                    self.last.extend_from_slice(input);
                }
                self.look = now + inhibit.max(pace);
                self.next = Some(now + self.interval);
            }
        }
        self.sent = self.sent.wrapping_add(1);
        let count = if self.class_1 { SEQUENCE_COUNT } else { 0 };
        let length = u16::try_from(input.len()).unwrap_or(u16::MAX).saturating_add(count);
        Datagram::encode_head(self.id, self.sent, length, out);
        if self.class_1 {
            out.put_u16_le(self.count);
        }
        out.put_slice(input);
        true
    }
}
