//! Network connection parameters: how the packets of one direction are addressed and how large they are (CIP Vol. 1,
//! 3-5; spec/ethernet-ip.md §7).
//!
//! Codecs of the 16-bit and the 32-bit form; which values are granted is [`crate::session`]'s business. Sizes are in bytes.

/// How packets of one direction are addressed.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum ConnectionType {
    /// No connection in this direction; both null: reconfigure.
    Null,
    /// To a group.
    Multicast,
    /// To one consumer.
    PointToPoint,
    /// The reserved code 3.
    Reserved,
}

/// Network connection parameters of one direction; the 16-bit and 32-bit forms differ in the size's width only.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct NetworkParameters {
    /// Several owners may have the connection.
    pub redundant_owner: bool,
    /// Addressing.
    pub connection_type: ConnectionType,
    /// 0 low, 1 high, 2 scheduled, 3 urgent.
    pub priority: u8,
    /// Sizes up to `size` rather than exactly `size`.
    pub variable: bool,
    /// Bytes, including the 2-byte sequence count of class 1 and 3.
    pub size: u16,
}

impl NetworkParameters {
    /// Largest size of the 16-bit form.
    pub const MAX_SMALL: u16 = 0x01FF;

    /// The parameters of class 3: point-to-point, low priority, variable.
    pub const fn explicit(size: u16) -> Self {
        Self {
            redundant_owner: false,
            connection_type: ConnectionType::PointToPoint,
            priority: 0,
            variable: true,
            size,
        }
    }

    /// From the 16-bit form.
    pub const fn from_small(word: u16) -> Self {
        Self::from_flags((word >> 8) as u8, word & Self::MAX_SMALL)
    }

    /// From the 32-bit form.
    pub const fn from_large(word: u32) -> Self {
        Self::from_flags((word >> 24) as u8, (word & 0xFFFF) as u16)
    }

    /// To the 16-bit form; a larger size is cut to [`Self::MAX_SMALL`].
    pub const fn to_small(self) -> u16 {
        let size = if self.size > Self::MAX_SMALL {
            Self::MAX_SMALL
        } else {
            self.size
        };
        ((self.flags() as u16) << 8) | size
    }

    /// To the 32-bit form.
    pub const fn to_large(self) -> u32 {
        ((self.flags() as u32) << 24) | self.size as u32
    }

    const fn from_flags(flags: u8, size: u16) -> Self {
        let connection_type = match (flags >> 5) & 3 {
            0 => ConnectionType::Null,
            1 => ConnectionType::Multicast,
            2 => ConnectionType::PointToPoint,
            _ => ConnectionType::Reserved,
        };
        let (priority, variable) = ((flags >> 2) & 3, flags & 2 != 0);
        Self {
            redundant_owner: flags & 0x80 != 0,
            connection_type,
            priority,
            variable,
            size,
        }
    }

    const fn flags(self) -> u8 {
        let connection_type = match self.connection_type {
            ConnectionType::Null => 0,
            ConnectionType::Multicast => 1,
            ConnectionType::PointToPoint => 2,
            ConnectionType::Reserved => 3,
        };
        (self.redundant_owner as u8) << 7 | connection_type << 5 | (self.priority & 3) << 2 | (self.variable as u8) << 1
    }
}
