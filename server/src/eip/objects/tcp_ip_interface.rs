//! TCP/IP Interface, class 0xF5 (CIP Vol. 2, 5-4): where the device is reached, as the host's system has it. Only the
//! inactivity time-out can be set: the host's network is not ours.

use std::time::Duration;

use arcline_proto::cip::{CipStatus, class};
use bytes::{BufMut, Bytes, BytesMut};

use super::object::{Extent, Object, ObjectContext};
use super::values::{long_string, no_attribute, u8_value, u16_value, u32_value};
use crate::eip::adapter::Adapter;
use crate::plant::Right;

/// Status: the configuration is valid, by other means than this object.
const CONFIGURED: u32 = 2;
/// Encapsulation inactivity time-out, s, can be set.
const INACTIVITY: u16 = 13;
/// The longest of it, s.
const MAX_INACTIVITY: u16 = 3600;
/// Attribute 11: no address conflict has been seen.
const NO_CONFLICT: [u8; 35] = [0; 35];
/// Addresses from the first one on (CIP Vol. 2, 3-5.3).
const MULTICAST_COUNT: u16 = 32;

#[derive(Debug)]
pub(super) struct TcpIpInterface;

impl Object for TcpIpInterface {
    fn class(&self) -> u16 {
        class::TCP_IP
    }

    fn name(&self) -> &'static str {
        "TCP/IP Interface"
    }

    fn is_late(&self) -> bool {
        true
    }

    fn revision(&self) -> u16 {
        4
    }

    fn extent(&self, _cx: &ObjectContext<'_, '_>) -> Result<Extent, CipStatus> {
        Extent::dense(1, INACTIVITY)
    }

    fn attribute(&self, cx: &ObjectContext<'_, '_>, _instance: u32, id: u16) -> Result<Bytes, CipStatus> {
        match id {
            1 => u32_value(CONFIGURED),
            // Nothing can be configured here; the addresses are the system's.
            2 | 3 => u32_value(0),
            // The Ethernet Link object: two words, class 0xF6, instance 1.
            4 => Ok(Bytes::from_static(&[2, 0, 0x20, 0xF6, 0x24, 1])),
            5 => Ok(configuration(&cx.context.adapter())),
            6 => Ok(padded_string(&cx.context.adapter().host_name)),
            8 => u8_value(1),
            9 => Ok(multicast(&cx.context.adapter())),
            10 => u8_value(0),
            11 => Ok(Bytes::from_static(&NO_CONFLICT)),
            INACTIVITY => {
                let seconds = cx.device().inactivity().map_or(0, |time| time.as_secs());
                u16_value(u16::try_from(seconds).unwrap_or(u16::MAX))
            }
            _ => no_attribute(),
        }
    }

    fn all(&self) -> &'static [u16] {
        &[1, 2, 3, 4, 5, 6]
    }

    fn settable(&self, _cx: &ObjectContext<'_, '_>, _instance: u32, id: u16) -> Option<usize> {
        (id == INACTIVITY).then_some(2)
    }

    fn right_to_set(&self) -> Right {
        Right::SetInactivity
    }

    /// Seconds, 0: never.
    fn set(&self, cx: &mut ObjectContext<'_, '_>, _instance: u32, _id: u16, value: &[u8]) -> Result<(), CipStatus> {
        let seconds = value.first_chunk().ok_or(CipStatus::NOT_ENOUGH_DATA)?;
        let seconds = u16::from_le_bytes(*seconds);
        if seconds > MAX_INACTIVITY {
            return Err(CipStatus::INVALID_ATTRIBUTE_VALUE);
        }
        cx.device().set_inactivity(Duration::from_secs(seconds.into()));
        Ok(())
    }
}

/// Address, mask, gateway and name servers as little-endian numbers; no domain.
fn configuration(adapter: &Adapter) -> Bytes {
    let mut out = BytesMut::with_capacity(22);
    let [first, second] = adapter.name_servers;
    for address in [adapter.address, adapter.mask, adapter.gateway, first, second] {
        out.put_u32_le(address.to_bits());
    }
    out.put_u16_le(0);
    out.freeze()
}

/// By the default algorithm: `alloc u8, 0, count u16, first address u32`.
fn multicast(adapter: &Adapter) -> Bytes {
    let mut out = BytesMut::with_capacity(8);
    out.put_slice(&[0, 0]);
    out.put_u16_le(MULTICAST_COUNT);
    out.put_u32_le(adapter.first_multicast().to_bits());
    out.freeze()
}

/// `length u16, bytes`, a zero behind an odd number of them.
fn padded_string(text: &str) -> Bytes {
    let mut out = BytesMut::from(long_string(text).as_ref());
    if out.len() % 2 == 1 {
        out.put_u8(0);
    }
    out.freeze()
}
