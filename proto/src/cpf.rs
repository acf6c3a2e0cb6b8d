//! The common packet format: the items inside SendRRData, SendUnitData, the List replies and class 0/1 datagrams
//! (CIP Vol. 2, 2-6; spec/ethernet-ip.md §3).
//!
//! Strict about an item that runs past the packet, lenient about further and unknown items. Socket addresses are
//! big-endian, everything else little-endian.

use bytes::{BufMut, Bytes, BytesMut};
use std::net::{Ipv4Addr, SocketAddrV4};

use crate::wire::Reader;

/// Items kept of one packet; more are checked and skipped.
pub const MAX_ITEMS: usize = 16;

/// Type codes of items (CIP Vol. 2, table 2-6.3).
pub mod item_type {
    /// Null address, in front of an unconnected message.
    pub const NULL_ADDRESS: u16 = 0x0000;
    /// Identity, in a ListIdentity reply.
    pub const IDENTITY: u16 = 0x000C;
    /// Connected address: a connection id.
    pub const CONNECTED_ADDRESS: u16 = 0x00A1;
    /// Connected data.
    pub const CONNECTED_DATA: u16 = 0x00B1;
    /// Unconnected data.
    pub const UNCONNECTED_DATA: u16 = 0x00B2;
    /// Services, in a ListServices reply.
    pub const SERVICES: u16 = 0x0100;
    /// Socket address, originator to target.
    pub const SOCKADDR_O_TO_T: u16 = 0x8000;
    /// Socket address, target to originator.
    pub const SOCKADDR_T_TO_O: u16 = 0x8001;
    /// Sequenced address of a class 0/1 datagram.
    pub const SEQUENCED_ADDRESS: u16 = 0x8002;
}

/// Names one direction of a CIP connection; chosen by its consumer.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug, Default)]
pub struct ConnectionId(pub u32);

/// A packet that cannot be understood; the encapsulation status is 0x0003.
#[derive(Clone, Copy, PartialEq, Eq, Debug, thiserror::Error)]
pub enum CpfError {
    /// The packet ends inside its own head or inside an item's head.
    #[error("packet ends after {present} bytes, inside {inside}")]
    Truncated {
        /// What was being read.
        inside: &'static str,
        /// Bytes that were there.
        present: usize,
    },
    /// An item claims more bytes than the packet has.
    #[error("item 0x{item:04X} claims {claimed} bytes, {present} are left")]
    Overrun {
        /// Item type.
        item: u16,
        /// Bytes claimed.
        claimed: usize,
        /// Bytes left.
        present: usize,
    },
    /// An item of fixed size has another one.
    #[error("item 0x{item:04X} has {present} bytes, expected {expected}")]
    ItemLength {
        /// Item type.
        item: u16,
        /// Bytes there.
        present: usize,
        /// Bytes there should be.
        expected: usize,
    },
    /// An item that the command needs is not there, or not in its place.
    #[error("{0} is missing")]
    Missing(&'static str),
}

/// One item.
#[derive(Clone, PartialEq, Eq, Debug)]
pub enum Item {
    /// 0x0000: no address, the message is unconnected.
    NullAddress,
    /// 0x000C: data of an identity, see [`crate::identity`].
    Identity(Bytes),
    /// 0x0100: data of a service entry, see [`crate::encap::Service`].
    Services(Bytes),
    /// 0x00A1: the connection the data belongs to.
    ConnectedAddress(ConnectionId),
    /// 0x00B1: data of a connection, beginning with the 16-bit sequence count in class 1 and 3.
    ConnectedData(Bytes),
    /// 0x00B2: a message router request or reply.
    UnconnectedData(Bytes),
    /// 0x8000: where the target listens.
    SockaddrOToT(SocketAddrV4),
    /// 0x8001: where the originator listens.
    SockaddrTToO(SocketAddrV4),
    /// 0x8002: connection and 32-bit sequence of a class 0/1 datagram.
    SequencedAddress {
        /// The connection.
        id: ConnectionId,
        /// Counts datagrams.
        sequence: u32,
    },
    /// Any other type, kept as it came.
    Other {
        /// Item type.
        item: u16,
        /// Its data.
        data: Bytes,
    },
}

impl Item {
    /// The type code.
    pub const fn type_code(&self) -> u16 {
        match self {
            Self::NullAddress => item_type::NULL_ADDRESS,
            Self::Identity(_) => item_type::IDENTITY,
            Self::Services(_) => item_type::SERVICES,
            Self::ConnectedAddress(_) => item_type::CONNECTED_ADDRESS,
            Self::ConnectedData(_) => item_type::CONNECTED_DATA,
            Self::UnconnectedData(_) => item_type::UNCONNECTED_DATA,
            Self::SockaddrOToT(_) => item_type::SOCKADDR_O_TO_T,
            Self::SockaddrTToO(_) => item_type::SOCKADDR_T_TO_O,
            Self::SequencedAddress { .. } => item_type::SEQUENCED_ADDRESS,
            Self::Other { item, .. } => *item,
        }
    }

    fn decode(item: u16, data: Bytes) -> Result<Self, CpfError> {
        let length = |expected| CpfError::ItemLength {
            item,
            present: data.len(),
            expected,
        };
        let mut reader = Reader::new(&data);
        let fixed = |expected: usize| {
            if data.len() == expected {
                Ok(())
            } else {
                Err(length(expected))
            }
        };
        Ok(match item {
            item_type::NULL_ADDRESS => {
                fixed(0)?;
                Self::NullAddress
            }
            item_type::IDENTITY => Self::Identity(data),
            item_type::SERVICES => Self::Services(data),
            item_type::CONNECTED_ADDRESS => {
                fixed(4)?;
                Self::ConnectedAddress(ConnectionId(reader.u32().ok_or_else(|| length(4))?))
            }
            item_type::CONNECTED_DATA => Self::ConnectedData(data),
            item_type::UNCONNECTED_DATA => Self::UnconnectedData(data),
            item_type::SOCKADDR_O_TO_T => {
                fixed(16)?;
                Self::SockaddrOToT(decode_sockaddr(&mut reader).ok_or_else(|| length(16))?)
            }
            item_type::SOCKADDR_T_TO_O => {
                fixed(16)?;
                Self::SockaddrTToO(decode_sockaddr(&mut reader).ok_or_else(|| length(16))?)
            }
            item_type::SEQUENCED_ADDRESS => {
                fixed(8)?;
                let id = ConnectionId(reader.u32().ok_or_else(|| length(8))?);
                Self::SequencedAddress {
                    id,
                    sequence: reader.u32().ok_or_else(|| length(8))?,
                }
            }
            _ => Self::Other { item, data },
        })
    }

    /// Appends the item with its type and length.
    pub(crate) fn encode(&self, out: &mut BytesMut) {
        out.put_u16_le(self.type_code());
        match self {
            Self::NullAddress => out.put_u16_le(0),
            Self::Identity(data)
            | Self::Services(data)
            | Self::ConnectedData(data)
            | Self::UnconnectedData(data)
            | Self::Other { data, .. } => {
                let length = u16::try_from(data.len()).unwrap_or(u16::MAX);
                out.put_u16_le(length);
                out.put_slice(data.get(..usize::from(length)).unwrap_or(data));
            }
            Self::ConnectedAddress(id) => {
                out.put_u16_le(4);
                out.put_u32_le(id.0);
            }
            Self::SockaddrOToT(address) | Self::SockaddrTToO(address) => {
                out.put_u16_le(16);
                encode_sockaddr(*address, out);
            }
            Self::SequencedAddress { id, sequence } => {
                out.put_u16_le(8);
                out.put_u32_le(id.0);
                out.put_u32_le(*sequence);
            }
        }
    }
}

/// Reads `count u16` and that many items. At most [`MAX_ITEMS`] are kept, the others are only checked; bytes behind the
/// last item are ignored.
///
/// # Errors
/// An item runs past the packet or a fixed item has the wrong size.
pub fn decode_items(data: &Bytes) -> Result<Vec<Item>, CpfError> {
    let mut reader = Reader::new(data);
    let truncated = |inside| CpfError::Truncated {
        inside,
        present: data.len(),
    };
    let count = reader.u16().ok_or_else(|| truncated("the item count"))?;
    let mut items = Vec::with_capacity(2);
    for _ in 0..count {
        let item = reader.u16().ok_or_else(|| truncated("an item type"))?;
        let claimed = usize::from(reader.u16().ok_or_else(|| truncated("an item length"))?);
        let present = reader.remaining();
        let body = reader
            .take(claimed)
            .ok_or(CpfError::Overrun { item, claimed, present })?;
        let item = Item::decode(item, data.slice_ref(body))?;
        if items.len() < MAX_ITEMS {
            items.push(item);
        }
    }
    Ok(items)
}

/// Appends `count u16` and the items (at most 65,535 of them).
pub fn encode_items(items: &[Item], out: &mut BytesMut) {
    let count = u16::try_from(items.len()).unwrap_or(u16::MAX);
    out.put_u16_le(count);
    for item in items.iter().take(usize::from(count)) {
        item.encode(out);
    }
}

/// The data of SendRRData and SendUnitData: interface handle, timeout, items.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Packet {
    /// 0: CIP.
    pub interface: u32,
    /// Seconds; ignored.
    pub timeout: u16,
    /// Address first, data second.
    pub items: Vec<Item>,
}

impl Packet {
    /// An unconnected message: null address and data.
    pub fn unconnected(message: Bytes) -> Self {
        Self {
            interface: 0,
            timeout: 0,
            items: vec![Item::NullAddress, Item::UnconnectedData(message)],
        }
    }

    /// A class 3 message: address, sequence count, message.
    pub fn connected(id: ConnectionId, sequence: u16, message: &[u8]) -> Self {
        let mut data = BytesMut::with_capacity(2 + message.len());
        data.put_u16_le(sequence);
        data.put_slice(message);
        let items = vec![Item::ConnectedAddress(id), Item::ConnectedData(data.freeze())];
        Self {
            interface: 0,
            timeout: 0,
            items,
        }
    }

    /// Reads the data of a frame.
    ///
    /// # Errors
    /// As [`decode_items`].
    pub fn decode(data: &Bytes) -> Result<Self, CpfError> {
        let mut reader = Reader::new(data);
        let truncated = CpfError::Truncated {
            inside: "interface handle and timeout",
            present: data.len(),
        };
        let interface = reader.u32().ok_or(truncated)?;
        let timeout = reader.u16().ok_or(truncated)?;
        let items = decode_items(&data.slice_ref(reader.rest()))?;
        Ok(Self {
            interface,
            timeout,
            items,
        })
    }

    /// Reads the data of a frame that must be a class 3 message: as [`Self::decode`] and [`Self::connected_message`].
    ///
    /// # Errors
    /// As both.
    pub fn decode_connected(data: &Bytes) -> Result<(ConnectionId, u16, Bytes), CpfError> {
        match two_items(data) {
            Some((id, sequence, message)) => Ok((id, sequence, data.slice_ref(message))),
            // Unusual items, or what is wrong.
            None => Self::decode(data)?.connected_message(),
        }
    }

    /// The data of a frame.
    pub fn to_bytes(&self) -> Bytes {
        let mut out = BytesMut::with_capacity(64);
        out.put_u32_le(self.interface);
        out.put_u16_le(self.timeout);
        encode_items(&self.items, &mut out);
        out.freeze()
    }

    /// The message of an unconnected packet: null address first, unconnected data second.
    ///
    /// # Errors
    /// [`CpfError::Missing`].
    pub fn unconnected_message(&self) -> Result<&Bytes, CpfError> {
        match self.items.as_slice() {
            [Item::NullAddress, Item::UnconnectedData(message), ..] => Ok(message),
            [Item::NullAddress, ..] => Err(CpfError::Missing("the unconnected data item")),
            _ => Err(CpfError::Missing("the null address item")),
        }
    }

    /// Connection, sequence count and message of a class 3 packet.
    ///
    /// # Errors
    /// [`CpfError::Missing`], also for data shorter than its sequence count.
    pub fn connected_message(&self) -> Result<(ConnectionId, u16, Bytes), CpfError> {
        match self.items.as_slice() {
            [Item::ConnectedAddress(id), Item::ConnectedData(data), ..] => {
                let mut reader = Reader::new(data);
                let sequence = reader.u16().ok_or(CpfError::Missing("the sequence count"))?;
                Ok((*id, sequence, data.slice_ref(reader.rest())))
            }
            [Item::ConnectedAddress(_), ..] => Err(CpfError::Missing("the connected data item")),
            _ => Err(CpfError::Missing("the connected address item")),
        }
    }
}

/// A class 3 message as every client sends it: two items and nothing else.
fn two_items(data: &[u8]) -> Option<(ConnectionId, u16, &[u8])> {
    let mut reader = Reader::new(data);
    reader.take(6)?;
    let head = (reader.u16()?, reader.u16()?, reader.u16()?);
    let id = ConnectionId(reader.u32()?);
    let (kind, length) = (reader.u16()?, reader.u16()?);
    if head != (2, item_type::CONNECTED_ADDRESS, 4) || kind != item_type::CONNECTED_DATA {
        return None;
    }
    let mut reader = Reader::new(reader.take(length.into())?);
    let sequence = reader.u16()?;
    Some((id, sequence, reader.rest()))
}

/// Reads 16 bytes: family, port, address, eight ignored; big-endian.
pub(crate) fn decode_sockaddr(reader: &mut Reader<'_>) -> Option<SocketAddrV4> {
    let _family = reader.u16_be()?;
    let port = reader.u16_be()?;
    let address = Ipv4Addr::from(reader.array::<4>()?);
    reader.take(8)?;
    Some(SocketAddrV4::new(address, port))
}

/// Appends 16 bytes: family 2, port, address, eight zeros; big-endian.
pub(crate) fn encode_sockaddr(address: SocketAddrV4, out: &mut BytesMut) {
    out.put_u16(2);
    out.put_u16(address.port());
    out.put_slice(&address.ip().octets());
    out.put_bytes(0, 8);
}
