//! Connection Manager, class 0x06 (CIP Vol. 1, 3-5): its counters.
//!
//! Forward Open, Forward Close and Unconnected Send are the session's and never come here.

use arcline_proto::cip::CipStatus;
use arcline_proto::connection::Counters;
use bytes::Bytes;

use super::{Class, Extent, u16_value};

pub(super) struct ConnectionManager(pub(super) Counters);

impl Class for ConnectionManager {
    fn extent(&self) -> Extent {
        Extent::dense(1, 8)
    }

    fn attribute(&self, _instance: u32, id: u16) -> Result<Bytes, CipStatus> {
        self.0
            .attribute(id)
            .map_or(Err(CipStatus::ATTRIBUTE_NOT_SUPPORTED), u16_value)
    }

    fn all(&self) -> &'static [u16] {
        &[1, 2, 3, 4, 5, 6, 7, 8]
    }
}
