//! Ethernet Link, class 0xF6 (CIP Vol. 2, 5-5): the host's interface through which the client came, as the system shows
//! it. Nothing of it can be set.

use arcline_proto::cip::{CipStatus, class};
use bytes::Bytes;

use super::object::{Extent, Object, ObjectContext};
use super::values::{no_attribute, short_string, u8_value, u32_value};

/// Bits of attribute 2: the link is active.
const ACTIVE: u32 = 0x01;
/// Bit of a full duplex link.
const FULL_DUPLEX: u32 = 0x02;
/// Speed and duplex were negotiated.
const NEGOTIATED: u32 = 3 << 2;
/// Attribute 6: auto-negotiation, no forced speed.
const AUTOMATIC: [u8; 4] = [1, 0, 0, 0];
/// Attribute 11: auto-negotiation only, and no speeds that can be forced.
const CAPABILITY: [u8; 5] = [2, 0, 0, 0, 0];

#[derive(Debug)]
pub(super) struct EthernetLink;

impl Object for EthernetLink {
    fn class(&self) -> u16 {
        class::ETHERNET_LINK
    }

    fn name(&self) -> &'static str {
        "Ethernet Link"
    }

    fn is_late(&self) -> bool {
        true
    }

    fn revision(&self) -> u16 {
        4
    }

    fn extent(&self, _cx: &ObjectContext<'_, '_>) -> Result<Extent, CipStatus> {
        Extent::dense(1, 11)
    }

    fn attribute(&self, cx: &ObjectContext<'_, '_>, _instance: u32, id: u16) -> Result<Bytes, CipStatus> {
        let adapter = cx.context.adapter();
        match id {
            1 => u32_value(adapter.speed),
            2 => {
                let active = if adapter.is_up { ACTIVE } else { 0 };
                let duplex = if adapter.is_half_duplex { 0 } else { FULL_DUPLEX };
                u32_value(active | duplex | NEGOTIATED)
            }
            3 => Ok(Bytes::copy_from_slice(&adapter.hardware_address)),
            4 => Ok(counters(&adapter.interface_counters)),
            5 => Ok(counters(&adapter.media_counters)),
            6 => Ok(Bytes::from_static(&AUTOMATIC)),
            // Internal, or twisted pair.
            7 => u8_value(if adapter.is_internal() { 1 } else { 2 }),
            // Enabled, or disabled.
            8 => u8_value(if adapter.is_up { 1 } else { 2 }),
            9 => u8_value(1),
            10 => Ok(short_string(&adapter.name)),
            11 => Ok(Bytes::from_static(&CAPABILITY)),
            _ => no_attribute(),
        }
    }

    fn all(&self) -> &'static [u16] {
        &[1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11]
    }
}

fn counters(values: &[u32]) -> Bytes {
    values.iter().flat_map(|value| value.to_le_bytes()).collect()
}
