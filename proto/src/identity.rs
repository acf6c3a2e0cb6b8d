//! The Identity object's data and the ListIdentity item (CIP Vol. 1, 5A-2; spec/ethernet-ip.md §2, §13).
//!
//! Values only; the server decides whether a reset is allowed.

use bytes::{BufMut, Bytes, BytesMut};
use std::net::SocketAddrV4;

use crate::cip::CipStatus;
use crate::cpf::{Item, decode_items, decode_sockaddr, encode_items, encode_sockaddr, item_type};
use crate::encap::PROTOCOL_VERSION;
use crate::epath::ElectronicKey;
use crate::security::SecurityInformation;
use crate::status::connection;
use crate::wire::Reader;

/// Assigned to no vendor: far beyond the vendor ids in use.
pub const VENDOR_ID: u16 = 0xA2C1;
/// Device type 0x0E: programmable logic controller.
pub const DEVICE_TYPE: u16 = 0x000E;
/// The longest product name.
pub const MAX_NAME: usize = 32;
/// Status word of a controller in remote run (spec/ethernet-ip.md §13).
pub const STATUS_RUNNING: u16 = 0x3060;
/// Status word of a controller in remote program.
pub const STATUS_NOT_RUNNING: u16 = 0x3070;
/// State: operational.
pub const STATE_OPERATIONAL: u8 = 3;

/// The identity of a device.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Identity {
    /// Attribute 1.
    pub vendor: u16,
    /// Attribute 2.
    pub device_type: u16,
    /// Attribute 3.
    pub product_code: u16,
    /// Attribute 4, first byte.
    pub major: u8,
    /// Attribute 4, second byte.
    pub minor: u8,
    /// Attribute 5.
    pub status: u16,
    /// Attribute 6.
    pub serial: u32,
    /// Attribute 7, at most [`MAX_NAME`] bytes.
    name: String,
    /// Attribute 8.
    pub state: u8,
    /// Attribute 9.
    pub consistency: u16,
    /// Attribute 10, seconds; 0: none.
    pub heartbeat: u8,
    /// The security in a ListIdentity reply, in an item behind the identity's; `None`: no such item.
    pub security: Option<SecurityInformation>,
}

impl Identity {
    /// This program under a product name (cut at [`MAX_NAME`] bytes) and a serial number. The revision is 33.11, which
    /// lets stock clients address tags by instance.
    pub fn new(name: &str, serial: u32) -> Self {
        Self {
            vendor: VENDOR_ID,
            device_type: DEVICE_TYPE,
            product_code: 1,
            major: 33,
            minor: 11,
            status: STATUS_RUNNING,
            serial,
            name: cut(name).to_owned(),
            state: STATE_OPERATIONAL,
            consistency: 0,
            heartbeat: 0,
            security: None,
        }
    }

    /// The product name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The value of an instance attribute, 1 to 10.
    ///
    /// # Errors
    /// 0x14.
    pub fn attribute(&self, id: u16) -> Result<Bytes, CipStatus> {
        let mut out = BytesMut::new();
        match id {
            1 => out.put_u16_le(self.vendor),
            2 => out.put_u16_le(self.device_type),
            3 => out.put_u16_le(self.product_code),
            4 => out.put_slice(&[self.major, self.minor]),
            5 => out.put_u16_le(self.status),
            6 => out.put_u32_le(self.serial),
            7 => {
                out.put_u8(u8::try_from(self.name.len()).unwrap_or(u8::MAX));
                out.put_slice(self.name.as_bytes());
            }
            8 => out.put_u8(self.state),
            9 => out.put_u16_le(self.consistency),
            10 => out.put_u8(self.heartbeat),
            _ => return Err(CipStatus::ATTRIBUTE_NOT_SUPPORTED),
        }
        Ok(out.freeze())
    }

    /// Get Attributes All: attributes 1 to 7.
    pub fn attributes_all(&self) -> Bytes {
        let mut out = BytesMut::new();
        for id in 1..=7 {
            out.put_slice(&self.attribute(id).unwrap_or_default());
        }
        out.freeze()
    }

    /// Reads Get Attributes All; state, consistency and heartbeat are 0 then. `None` if it is cut.
    pub fn decode_all(data: &[u8]) -> Option<Self> {
        Self::read(&mut Reader::new(data))
    }

    fn read(reader: &mut Reader<'_>) -> Option<Self> {
        let mut this = Self {
            vendor: reader.u16()?,
            device_type: reader.u16()?,
            product_code: reader.u16()?,
            major: reader.u8()?,
            minor: reader.u8()?,
            status: reader.u16()?,
            serial: reader.u32()?,
            name: String::new(),
            state: 0,
            consistency: 0,
            heartbeat: 0,
            security: None,
        };
        let length = usize::from(reader.u8()?);
        this.name = String::from_utf8_lossy(reader.take(length)?).into_owned();
        Some(this)
    }

    /// Whether an originator's key fits; a zero matches every value.
    ///
    /// # Errors
    /// The Connection Manager's additional status: 0x0114, 0x0115 or 0x0116.
    pub fn check_key(&self, key: &ElectronicKey) -> Result<(), u16> {
        let fits = |asked: u16, have: u16| asked == 0 || asked == have;
        if !fits(key.vendor, self.vendor) || !fits(key.product_code, self.product_code) {
            return Err(connection::KEY_VENDOR_OR_PRODUCT);
        }
        if !fits(key.device_type, self.device_type) {
            return Err(connection::KEY_DEVICE_TYPE);
        }
        let (compatible, major) = (key.major & 0x80 != 0, key.major & 0x7F);
        let revision = match (major, key.minor) {
            (0, _) => true,
            (major, 0) => major == self.major || compatible && major < self.major,
            (major, minor) if compatible => (major, minor) <= (self.major, self.minor),
            (major, minor) => (major, minor) == (self.major, self.minor),
        };
        if revision {
            Ok(())
        } else {
            Err(connection::KEY_REVISION)
        }
    }

    /// The data of a ListIdentity reply: an item with the address the request arrived on, and behind it that of the security, since
    /// clients decode the identity at its place.
    pub fn list_identity(&self, local: SocketAddrV4) -> Bytes {
        let mut data = BytesMut::new();
        data.put_u16_le(PROTOCOL_VERSION);
        encode_sockaddr(local, &mut data);
        data.put_slice(&self.attributes_all());
        data.put_u8(self.state);
        let mut out = BytesMut::new();
        let mut items = vec![Item::Identity(data.freeze())];
        items.extend(self.security.map(|security| Item::Other {
            item: item_type::SECURITY_INFORMATION,
            data: Bytes::copy_from_slice(&security.encode()),
        }));
        encode_items(&items, &mut out);
        out.freeze()
    }

    /// Reads the first identity of a ListIdentity reply: address and identity. `None` if there is none, or it is cut.
    pub fn decode_list(data: &Bytes) -> Option<(SocketAddrV4, Self)> {
        decode_items(data).ok()?.iter().find_map(|item| match item {
            Item::Identity(data) => Self::decode_item(data),
            _ => None,
        })
    }

    /// Reads the identity item of a ListIdentity reply: address and identity. `None` if it is cut.
    pub fn decode_item(data: &[u8]) -> Option<(SocketAddrV4, Self)> {
        let mut reader = Reader::new(data);
        let _version = reader.u16()?;
        let address = decode_sockaddr(&mut reader)?;
        let mut this = Self::read(&mut reader)?;
        this.state = reader.u8()?;
        Some((address, this))
    }
}

/// As many whole characters as [`MAX_NAME`] bytes hold.
fn cut(name: &str) -> &str {
    let end = (0..=MAX_NAME)
        .rev()
        .find(|end| name.is_char_boundary(*end))
        .unwrap_or_default();
    name.get(..end.min(name.len())).unwrap_or(name)
}
