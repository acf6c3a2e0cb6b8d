//! The datagram of a class 0 or 1 connection: sequenced address, then connected data (CIP Vol. 2, 3-3;
//! spec/ethernet-ip.md §14.2). All little-endian.
//!
//! Not what the data is: sequence count and run/idle header belong to the connection.

use bytes::{BufMut, BytesMut};

use crate::cpf::{ConnectionId, item_type};
use crate::wire::Reader;

/// Bytes in front of the connected data.
pub const DATAGRAM_HEAD: usize = 18;

/// A datagram taken apart.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Datagram<'a> {
    /// The connection; chosen by the receiver.
    pub id: ConnectionId,
    /// Counts datagrams of the connection.
    pub sequence: u32,
    /// The connected data: sequence count (class 1), run/idle header (where there is one), assembly.
    pub data: &'a [u8],
}

/// Bytes that are no such datagram.
#[derive(Clone, Copy, PartialEq, Eq, Debug, thiserror::Error)]
pub enum DatagramError {
    /// It ends too early.
    #[error("datagram of {present} bytes ends inside {inside}")]
    Truncated {
        /// Bytes there.
        present: usize,
        /// What was being read.
        inside: &'static str,
    },
    /// An item that must be there is another one.
    #[error("item 0x{found:04X} where 0x{expected:04X} belongs")]
    Item {
        /// Type found.
        found: u16,
        /// Type expected.
        expected: u16,
    },
}

impl<'a> Datagram<'a> {
    /// Reads a datagram. Items behind the first two, and bytes behind them, are ignored.
    ///
    /// # Errors
    /// It is cut, has fewer than two items, or others than a sequenced address of 8 bytes and connected data.
    pub fn decode(bytes: &'a [u8]) -> Result<Self, DatagramError> {
        let cut = |inside| DatagramError::Truncated {
            present: bytes.len(),
            inside,
        };
        let mut reader = Reader::new(bytes);
        let count = reader.u16().ok_or(cut("the item count"))?;
        if count < 2 {
            return Err(cut("its items"));
        }
        let mut item = |expected: u16| {
            let found = reader.u16().ok_or(cut("an item type"))?;
            if found != expected {
                return Err(DatagramError::Item { found, expected });
            }
            let length = usize::from(reader.u16().ok_or(cut("an item length"))?);
            reader.take(length).ok_or(cut("an item"))
        };
        let mut address = Reader::new(item(item_type::SEQUENCED_ADDRESS)?);
        let data = item(item_type::CONNECTED_DATA)?;
        let id = address.u32().ok_or(cut("the connection id"))?;
        let sequence = address.u32().ok_or(cut("the sequence number"))?;
        if address.remaining() > 0 {
            return Err(cut("a sequenced address of 8 bytes"));
        }
        Ok(Self {
            id: ConnectionId(id),
            sequence,
            data,
        })
    }

    /// Appends the datagram; data beyond 65,535 bytes is cut.
    pub fn encode(&self, out: &mut BytesMut) {
        let length = u16::try_from(self.data.len()).unwrap_or(u16::MAX);
        Self::encode_head(self.id, self.sequence, length, out);
        out.put_slice(self.data.get(..usize::from(length)).unwrap_or(self.data));
    }

    /// Appends what stands in front of `length` bytes of connected data.
    pub(super) fn encode_head(id: ConnectionId, sequence: u32, length: u16, out: &mut BytesMut) {
        out.put_u16_le(2);
        out.put_u16_le(item_type::SEQUENCED_ADDRESS);
        out.put_u16_le(8);
        out.put_u32_le(id.0);
        out.put_u32_le(sequence);
        out.put_u16_le(item_type::CONNECTED_DATA);
        out.put_u16_le(length);
    }
}
