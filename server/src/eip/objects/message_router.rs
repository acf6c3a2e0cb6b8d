//! Message Router, class 0x02 (CIP Vol. 1, 5A-3): which classes there are, and how many connections.
//!
//! Its service, the Multiple Service Packet, is the router's own.

use arcline_proto::cip::{CipStatus, class};
use bytes::{BufMut, Bytes, BytesMut};

use super::object::{Extent, Object, ObjectContext};
use super::values::{no_attribute, u16_value};

#[derive(Debug)]
pub(super) struct MessageRouter;

/// Attribute 4, the ids of open connections, is not there: only their owners know them.
impl Object for MessageRouter {
    fn class(&self) -> u16 {
        class::MESSAGE_ROUTER
    }

    fn name(&self) -> &'static str {
        "Message Router"
    }

    fn extent(&self, _cx: &ObjectContext<'_, '_>) -> Result<Extent, CipStatus> {
        Extent::dense(1, 3)
    }

    fn attribute(&self, cx: &ObjectContext<'_, '_>, _instance: u32, id: u16) -> Result<Bytes, CipStatus> {
        let narrow = |wide: usize| u16::try_from(wide).unwrap_or(u16::MAX);
        match id {
            1 => {
                let objects = cx.device().objects.0;
                let mut out = BytesMut::with_capacity(2 + 2 * objects.len());
                out.put_u16_le(narrow(objects.len()));
                objects.iter().for_each(|object| out.put_u16_le(object.class()));
                Ok(out.freeze())
            }
            2 => u16_value(narrow(cx.device().settings.config.max_connections)),
            3 => u16_value(narrow(cx.device().open_connections())),
            _ => no_attribute(),
        }
    }

    fn all(&self) -> &'static [u16] {
        &[1, 2, 3]
    }
}
