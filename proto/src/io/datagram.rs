//! The datagram of a class 0 or 1 connection: sequenced address, then connected data (CIP Vol. 2, 3-3;
//! spec/ethernet-ip.md §14.2). All little-endian.
//!
//! Not here: the content of the data. Sequence count and run/idle header belong to the connection.

use bytes::{BufMut, BytesMut};

use crate::cpf::{ConnectionId, CpfError, ItemReader, ItemWriter, item_type};

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

impl<'a> Datagram<'a> {
    /// Reads a datagram. Items behind the first two, and bytes behind them, are ignored.
    ///
    /// # Errors
    /// It is cut, has fewer than two items, or others than a sequenced address of 8 bytes and connected data.
    pub fn decode(bytes: &'a [u8]) -> Result<Self, CpfError> {
        let mut items = ItemReader::new(bytes)?;
        let address = items.expect(item_type::SEQUENCED_ADDRESS, "the sequenced address item")?;
        let data = items.expect(item_type::CONNECTED_DATA, "the connected data item")?.data;
        let (id, sequence) = address.sequenced_address()?;
        Ok(Self { id, sequence, data })
    }

    /// Appends the datagram; data beyond 65,535 bytes is cut.
    pub fn encode(&self, out: &mut BytesMut) {
        let length = u16::try_from(self.data.len()).unwrap_or(u16::MAX);
        Self::encode_head(self.id, self.sequence, length, out);
        out.put_slice(self.data.get(..usize::from(length)).unwrap_or(self.data));
    }

    /// Appends the header of `length` bytes of connected data.
    pub(super) fn encode_head(id: ConnectionId, sequence: u32, length: u16, out: &mut BytesMut) {
        let mut items = ItemWriter::new(2, out);
        items.sequenced_address(id, sequence);
        items.data(item_type::CONNECTED_DATA, length);
    }
}
