//! Port, class 0xF4 (CIP Vol. 1, 3-7): the one port by which the device is reached, EtherNet/IP. Port 1 of a path is the
//! backplane of a controller; there is nothing behind it but this device, so it has no instance.

use std::net::Ipv4Addr;

use arcline_proto::cip::{CipStatus, class};
use bytes::{BufMut, Bytes, BytesMut};

use super::object::{Extent, Object, ObjectContext};
use super::values::{no_attribute, short_string, u16_value};

/// Port type: TCP/IP.
const TCP_IP: u16 = 4;
/// Port number of the network in a path.
const NUMBER: u16 = 2;
/// Link object: two words, class 0xF5, instance 1.
const LINK: [u8; 6] = [2, 0, 0x20, 0xF5, 0x24, 1];
/// A port segment with an extended link address, port 2.
const NODE: u8 = 0x12;

#[derive(Debug)]
pub(super) struct Port;

impl Object for Port {
    fn class(&self) -> u16 {
        class::PORT
    }

    fn name(&self) -> &'static str {
        "Port"
    }

    fn extent(&self, _cx: &ObjectContext<'_, '_>) -> Result<Extent, CipStatus> {
        Extent::dense(1, 7)
    }

    /// 8: the instance by which the request came; 9: type and number of all, from instance 0, which is none.
    fn class_attribute(&self, _cx: &ObjectContext<'_, '_>, id: u16) -> Result<Bytes, CipStatus> {
        match id {
            8 => u16_value(1),
            9 => Ok([0, 0, TCP_IP, NUMBER]
                .iter()
                .flat_map(|word| word.to_le_bytes())
                .collect()),
            _ => no_attribute(),
        }
    }

    fn last_class_attribute(&self) -> u16 {
        9
    }

    fn class_all(&self) -> &'static [u16] {
        &[1, 2, 3, 8, 9]
    }

    fn attribute(&self, cx: &ObjectContext<'_, '_>, _instance: u32, id: u16) -> Result<Bytes, CipStatus> {
        match id {
            1 => u16_value(TCP_IP),
            2 => u16_value(NUMBER),
            3 => Ok(Bytes::from_static(&LINK)),
            4 => Ok(short_string("EtherNet/IP")),
            7 => Ok(node(*cx.context.local.ip())),
            _ => no_attribute(),
        }
    }

    fn all(&self) -> &'static [u16] {
        &[1, 2, 3, 4, 7]
    }
}

/// The address as text in a port segment, padded to whole words.
fn node(address: Ipv4Addr) -> Bytes {
    let text = address.to_string();
    let mut out = BytesMut::with_capacity(3 + text.len());
    // At most 15 characters.
    out.put_slice(&[NODE, text.len() as u8]);
    out.put_slice(text.as_bytes());
    if out.len() % 2 == 1 {
        out.put_u8(0);
    }
    out.freeze()
}
