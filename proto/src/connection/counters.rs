//! The counters of the Connection Manager, attributes 1 to 8 of class 6 (CIP Vol. 1, 3-5; spec/ethernet-ip.md §7).
//!
//! Not here: the events that are counted, which come through [`crate::session::Host::count`].

use bytes::Bytes;

/// A counter of the Connection Manager; the number is the attribute.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
#[repr(u8)]
pub enum Count {
    /// Forward Opens received.
    OpenRequests = 1,
    /// Refused because they could not be read.
    OpenFormatRejects = 2,
    /// Refused because a limit was reached.
    OpenResourceRejects = 3,
    /// Refused for another reason.
    OpenOtherRejects = 4,
    /// Forward Closes received.
    CloseRequests = 5,
    /// Refused because they could not be read.
    CloseFormatRejects = 6,
    /// Refused for another reason.
    CloseOtherRejects = 7,
    /// Connections whose watchdog expired.
    ConnectionTimeouts = 8,
}

/// Attributes 1 to 8 of the Connection Manager, instance 1. They wrap.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Counters([u16; 8]);

impl Counters {
    /// Counts one.
    pub fn add(&mut self, count: Count) {
        if let Some(counter) = self.0.get_mut(count as usize - 1) {
            *counter = counter.wrapping_add(1);
        }
    }

    /// How often.
    pub fn of(&self, count: Count) -> u16 {
        self.attribute(count as u16).unwrap_or_default()
    }

    /// The value of attribute 1 to 8.
    pub fn attribute(&self, id: u16) -> Option<u16> {
        self.0.get(usize::from(id).checked_sub(1)?).copied()
    }

    /// Get Attributes All: attributes 1 to 8.
    pub fn attributes_all(&self) -> Bytes {
        self.0.iter().flat_map(|counter| counter.to_le_bytes()).collect()
    }
}
