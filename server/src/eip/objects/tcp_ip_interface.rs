//! TCP/IP Interface, class 0xF5 (CIP Vol. 2, 5-4): where the device is reached. Nothing of it can be set: the host's
//! network is not ours.

use std::net::SocketAddrV4;

use arcline_proto::cip::CipStatus;
use bytes::{BufMut, Bytes, BytesMut};

use super::{Class, Extent, no_attribute, u8_value, u16_value, u32_value};
use crate::eip::device::Device;

/// Status: the configuration is valid, by other means than this object.
const CONFIGURED: u32 = 2;

pub(super) struct TcpIpInterface<'a> {
    /// The local end of the connection that asks.
    pub(super) local: SocketAddrV4,
    pub(super) device: &'a Device,
}

impl Class for TcpIpInterface<'_> {
    fn extent(&self) -> Extent {
        Extent::dense(1, 13)
    }

    fn attribute(&self, _instance: u32, id: u16) -> Result<Bytes, CipStatus> {
        match id {
            1 => u32_value(CONFIGURED),
            2 | 3 => u32_value(0),
            // The Ethernet Link object: two words, class 0xF6, instance 1.
            4 => Ok(Bytes::from_static(&[2, 0, 0x20, 0xF6, 0x24, 1])),
            5 => Ok(self.configuration()),
            // No host name.
            6 => u16_value(0),
            8 => u8_value(1),
            13 => {
                let seconds = self.device.settings.session.inactivity.map_or(0, |time| time.as_secs());
                u16_value(u16::try_from(seconds).unwrap_or(u16::MAX))
            }
            _ => no_attribute(),
        }
    }

    fn all(&self) -> &'static [u16] {
        &[1, 2, 3, 4, 5, 6]
    }
}

impl TcpIpInterface<'_> {
    /// Address as a little-endian number; mask, gateway and name servers are not known here; no domain.
    fn configuration(&self) -> Bytes {
        let mut out = BytesMut::with_capacity(22);
        out.put_u32_le(u32::from(*self.local.ip()));
        out.put_bytes(0, 16);
        out.put_u16_le(0);
        out.freeze()
    }
}
