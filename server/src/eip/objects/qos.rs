//! QoS, class 0x48 (CIP Vol. 2, 5-7): the marks of packets by their priority, which are the standard's.

use arcline_proto::cip::{CipStatus, class};
use bytes::Bytes;

use super::object::{Extent, Object, ObjectContext};
use super::values::{no_attribute, u8_value};

/// Attributes 1 to 8: no 802.1Q tags; DSCP of PTP events and general messages, of urgent, scheduled, high and low
/// priority, and of explicit messages.
const VALUES: [u8; 8] = [0, 59, 47, 55, 47, 43, 31, 27];

#[derive(Debug)]
pub(super) struct Qos;

impl Object for Qos {
    fn class(&self) -> u16 {
        class::QOS
    }

    fn name(&self) -> &'static str {
        "QoS"
    }

    fn extent(&self, _cx: &ObjectContext<'_, '_>) -> Result<Extent, CipStatus> {
        Extent::dense(1, 8)
    }

    fn attribute(&self, _cx: &ObjectContext<'_, '_>, _instance: u32, id: u16) -> Result<Bytes, CipStatus> {
        let index = usize::from(id).checked_sub(1);
        match index.and_then(|index| VALUES.get(index)) {
            Some(value) => u8_value(*value),
            None => no_attribute(),
        }
    }
}
