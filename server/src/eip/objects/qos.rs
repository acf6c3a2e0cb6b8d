//! QoS, class 0x48 (CIP Vol. 2, 5-7): the marks of packets by their priority, which are the standard's.

use arcline_proto::cip::CipStatus;
use bytes::Bytes;

use super::{Class, Extent, no_attribute, u8_value};

/// Attributes 1 to 8: no 802.1Q tags; DSCP of PTP events and general messages, of urgent, scheduled, high and low
/// priority, and of explicit messages.
const VALUES: [u8; 8] = [0, 59, 47, 55, 47, 43, 31, 27];

pub(super) struct Qos;

impl Class for Qos {
    fn extent(&self) -> Extent {
        Extent::dense(1, 8)
    }

    fn attribute(&self, _instance: u32, id: u16) -> Result<Bytes, CipStatus> {
        let place = usize::from(id).checked_sub(1);
        match place.and_then(|place| VALUES.get(place)) {
            Some(value) => u8_value(*value),
            None => no_attribute(),
        }
    }
}
