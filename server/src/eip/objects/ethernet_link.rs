//! Ethernet Link, class 0xF6 (CIP Vol. 2, 5-5): one interface that is up. What the host's adapter really does is not
//! looked at: speed and physical address read as 0, "not known".

use arcline_proto::cip::CipStatus;
use bytes::Bytes;

use super::{Class, Extent, no_attribute, short_string, u8_value, u32_value};

/// Link active, full duplex, negotiation done.
const FLAGS: u32 = 0x0F;

pub(super) struct EthernetLink;

impl Class for EthernetLink {
    fn extent(&self) -> Extent {
        Extent::dense(1, 10)
    }

    fn attribute(&self, _instance: u32, id: u16) -> Result<Bytes, CipStatus> {
        match id {
            1 => u32_value(0),
            2 => u32_value(FLAGS),
            3 => Ok(Bytes::from_static(&[0; 6])),
            // Type "unknown", state "enabled", administratively enabled.
            7 => u8_value(0),
            8 | 9 => u8_value(1),
            10 => Ok(short_string("host")),
            _ => no_attribute(),
        }
    }

    fn all(&self) -> &'static [u16] {
        &[1, 2, 3]
    }
}
