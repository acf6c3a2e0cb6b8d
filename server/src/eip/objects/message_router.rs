//! Message Router, class 0x02 (CIP Vol. 1, 5A-3): which classes there are, and how many connections.
//!
//! Its service, the Multiple Service Packet, is the router's own.

use arcline_proto::cip::CipStatus;
use bytes::{BufMut, Bytes, BytesMut};

use super::{CLASSES, Class, Extent, no_attribute, u16_value};
use crate::eip::device::Device;

pub(super) struct MessageRouter<'a>(pub(super) &'a Device);

/// Attribute 4, the ids of open connections, is not told: nobody but their owners is to know them.
impl Class for MessageRouter<'_> {
    fn extent(&self) -> Extent {
        Extent::dense(1, 3)
    }

    fn attribute(&self, _instance: u32, id: u16) -> Result<Bytes, CipStatus> {
        let narrow = |wide: usize| u16::try_from(wide).unwrap_or(u16::MAX);
        match id {
            1 => {
                let mut out = BytesMut::with_capacity(2 + 2 * CLASSES.len());
                out.put_u16_le(narrow(CLASSES.len()));
                CLASSES.iter().for_each(|class| out.put_u16_le(*class));
                Ok(out.freeze())
            }
            2 => u16_value(narrow(self.0.settings.max_connections)),
            3 => u16_value(narrow(self.0.open_connections())),
            _ => no_attribute(),
        }
    }

    fn all(&self) -> &'static [u16] {
        &[1, 2, 3]
    }
}
