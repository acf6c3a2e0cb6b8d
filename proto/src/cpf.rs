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
    /// CIP Security Information, in a ListIdentity reply.
    pub const SECURITY_INFORMATION: u16 = 0x0086;
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
        /// The item or field that is cut.
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

    /// The item of a raw one that is a part of `whole`.
    fn decode(raw: RawItem<'_>, whole: &Bytes) -> Result<Self, CpfError> {
        let data = || whole.slice_ref(raw.data);
        Ok(match raw.item {
            item_type::NULL_ADDRESS => {
                raw.fixed::<0>()?;
                Self::NullAddress
            }
            item_type::IDENTITY => Self::Identity(data()),
            item_type::SERVICES => Self::Services(data()),
            item_type::CONNECTED_ADDRESS => Self::ConnectedAddress(raw.connected_address()?),
            item_type::CONNECTED_DATA => Self::ConnectedData(data()),
            item_type::UNCONNECTED_DATA => Self::UnconnectedData(data()),
            item_type::SOCKADDR_O_TO_T => Self::SockaddrOToT(raw.sockaddr()?),
            item_type::SOCKADDR_T_TO_O => Self::SockaddrTToO(raw.sockaddr()?),
            item_type::SEQUENCED_ADDRESS => {
                let (id, sequence) = raw.sequenced_address()?;
                Self::SequencedAddress { id, sequence }
            }
            item => Self::Other { item, data: data() },
        })
    }

    /// Appends the item.
    fn encode(&self, writer: &mut ItemWriter<'_>) {
        match self {
            Self::NullAddress => writer.null_address(),
            Self::Identity(data)
            | Self::Services(data)
            | Self::ConnectedData(data)
            | Self::UnconnectedData(data)
            | Self::Other { data, .. } => {
                let length = u16::try_from(data.len()).unwrap_or(u16::MAX);
                let data = data.get(..usize::from(length)).unwrap_or(data);
                writer.data(self.type_code(), length).put_slice(data);
            }
            Self::ConnectedAddress(id) => writer.connected_address(*id),
            Self::SockaddrOToT(address) | Self::SockaddrTToO(address) => writer.sockaddr(self.type_code(), *address),
            Self::SequencedAddress { id, sequence } => writer.sequenced_address(*id, *sequence),
        }
    }
}

/// An item as it lies in a packet.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) struct RawItem<'a> {
    /// Its type code.
    pub(crate) item: u16,
    /// Its data.
    pub(crate) data: &'a [u8],
}

impl RawItem<'_> {
    /// The data of an item of fixed size.
    fn fixed<const N: usize>(&self) -> Result<[u8; N], CpfError> {
        self.data.try_into().map_err(|_| CpfError::ItemLength {
            item: self.item,
            present: self.data.len(),
            expected: N,
        })
    }

    fn connected_address(&self) -> Result<ConnectionId, CpfError> {
        self.fixed().map(|id| ConnectionId(u32::from_le_bytes(id)))
    }

    /// Connection and sequence of a sequenced address.
    pub(crate) fn sequenced_address(&self) -> Result<(ConnectionId, u32), CpfError> {
        let [a, b, c, d, sequence @ ..] = self.fixed::<8>()?;
        let id = ConnectionId(u32::from_le_bytes([a, b, c, d]));
        Ok((id, u32::from_le_bytes(sequence)))
    }

    fn sockaddr(&self) -> Result<SocketAddrV4, CpfError> {
        let bytes = self.fixed::<SOCKADDR>()?;
        decode_sockaddr(&mut Reader::new(&bytes)).ok_or(CpfError::Missing("the socket address"))
    }
}

/// Reads `count u16` and that many items, one by one and without a copy.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ItemReader<'a> {
    reader: Reader<'a>,
    left: u16,
    /// Bytes of the packet.
    present: usize,
}

impl<'a> ItemReader<'a> {
    /// A reader in front of the first item.
    pub(crate) fn new(data: &'a [u8]) -> Result<Self, CpfError> {
        let mut reader = Reader::new(data);
        let left = reader.u16().ok_or(CpfError::Truncated {
            inside: "the item count",
            present: data.len(),
        })?;
        Ok(Self {
            reader,
            left,
            present: data.len(),
        })
    }

    /// The next item; `None` behind the last one.
    pub(crate) fn next(&mut self) -> Result<Option<RawItem<'a>>, CpfError> {
        let Some(left) = self.left.checked_sub(1) else {
            return Ok(None);
        };
        self.left = left;
        let truncated = |inside| CpfError::Truncated {
            inside,
            present: self.present,
        };
        let item = self.reader.u16().ok_or_else(|| truncated("an item type"))?;
        let claimed = usize::from(self.reader.u16().ok_or_else(|| truncated("an item length"))?);
        let present = self.reader.remaining();
        let data = self
            .reader
            .take(claimed)
            .ok_or(CpfError::Overrun { item, claimed, present })?;
        Ok(Some(RawItem { item, data }))
    }

    /// The next item, which must have this type.
    pub(crate) fn expect(&mut self, item: u16, missing: &'static str) -> Result<RawItem<'a>, CpfError> {
        let next = self.next()?.filter(|next| next.item == item);
        next.ok_or(CpfError::Missing(missing))
    }
}

/// Writes items. Their layout is known here only.
#[derive(Debug)]
pub(crate) struct ItemWriter<'o>(&'o mut BytesMut);

impl<'o> ItemWriter<'o> {
    /// Writes the head of SendRRData and SendUnitData: interface handle and time-out, both 0, and the number of items.
    pub(crate) fn packet(count: u16, out: &'o mut BytesMut) -> Self {
        out.put_bytes(0, PACKET_HEAD - 2);
        Self::new(count, out)
    }

    /// Writes the number of items that follow.
    pub(crate) fn new(count: u16, out: &'o mut BytesMut) -> Self {
        out.put_u16_le(count);
        Self(out)
    }

    /// A null address, [`ITEM_HEAD`] bytes.
    pub(crate) fn null_address(&mut self) {
        self.data(item_type::NULL_ADDRESS, 0);
    }

    /// A connected address, [`ITEM_HEAD`] + 4 bytes.
    pub(crate) fn connected_address(&mut self, id: ConnectionId) {
        self.data(item_type::CONNECTED_ADDRESS, 4).put_u32_le(id.0);
    }

    /// A sequenced address, [`ITEM_HEAD`] + 8 bytes.
    pub(crate) fn sequenced_address(&mut self, id: ConnectionId, sequence: u32) {
        let out = self.data(item_type::SEQUENCED_ADDRESS, 8);
        out.put_u32_le(id.0);
        out.put_u32_le(sequence);
    }

    /// A socket address, [`ITEM_HEAD`] + [`SOCKADDR`] bytes.
    pub(crate) fn sockaddr(&mut self, item: u16, address: SocketAddrV4) {
        encode_sockaddr(address, self.data(item, SOCKADDR as u16));
    }

    /// Type and length of an item; its `length` bytes are appended to the returned buffer.
    pub(crate) fn data(&mut self, item: u16, length: u16) -> &mut BytesMut {
        self.0.put_u16_le(item);
        self.0.put_u16_le(length);
        self.0
    }
}

/// Bytes of the head of SendRRData and SendUnitData in front of the items: interface handle, time-out and number of items.
pub(crate) const PACKET_HEAD: usize = 4 + 2 + 2;
/// Bytes of type and length of an item.
pub(crate) const ITEM_HEAD: usize = 2 + 2;
/// Bytes of a socket address.
pub(crate) const SOCKADDR: usize = 16;

/// Reads `count u16` and that many items. At most [`MAX_ITEMS`] are kept, the others are only checked; bytes behind the
/// last item are ignored.
///
/// # Errors
/// An item runs past the packet or a fixed item has the wrong size.
pub fn decode_items(data: &Bytes) -> Result<Vec<Item>, CpfError> {
    let mut reader = ItemReader::new(data)?;
    let mut items = Vec::with_capacity(2);
    while let Some(raw) = reader.next()? {
        let item = Item::decode(raw, data)?;
        if items.len() < MAX_ITEMS {
            items.push(item);
        }
    }
    Ok(items)
}

/// Appends `count u16` and the items (at most 65,535 of them).
pub fn encode_items(items: &[Item], out: &mut BytesMut) {
    let count = u16::try_from(items.len()).unwrap_or(u16::MAX);
    let mut writer = ItemWriter::new(count, out);
    for item in items.iter().take(usize::from(count)) {
        item.encode(&mut writer);
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
        let (interface, timeout, items) = packet_head(data)?;
        let items = decode_items(&data.slice_ref(items))?;
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
        let (_, _, items) = packet_head(data)?;
        let mut items = ItemReader::new(items)?;
        let id = items
            .expect(item_type::CONNECTED_ADDRESS, NO_ADDRESS)?
            .connected_address()?;
        let message = items.expect(item_type::CONNECTED_DATA, NO_DATA)?;
        while let Some(other) = items.next()? {
            Item::decode(other, data)?;
        }
        let mut reader = Reader::new(message.data);
        let sequence = reader.u16().ok_or(CpfError::Missing(NO_SEQUENCE))?;
        Ok((id, sequence, data.slice_ref(reader.rest())))
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
                let sequence = reader.u16().ok_or(CpfError::Missing(NO_SEQUENCE))?;
                Ok((*id, sequence, data.slice_ref(reader.rest())))
            }
            [Item::ConnectedAddress(_), ..] => Err(CpfError::Missing(NO_DATA)),
            _ => Err(CpfError::Missing(NO_ADDRESS)),
        }
    }
}

/// Interface handle, time-out and items of a packet.
fn packet_head(data: &[u8]) -> Result<(u32, u16, &[u8]), CpfError> {
    let truncated = CpfError::Truncated {
        inside: "interface handle and timeout",
        present: data.len(),
    };
    let mut reader = Reader::new(data);
    let interface = reader.u32().ok_or(truncated)?;
    let timeout = reader.u16().ok_or(truncated)?;
    Ok((interface, timeout, reader.rest()))
}

const NO_ADDRESS: &str = "the connected address item";
const NO_DATA: &str = "the connected data item";
const NO_SEQUENCE: &str = "the sequence count";

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
