//! Identity, class 0x01 (CIP Vol. 1, 5A-2): who the device is. It cannot be reset from outside.

use arcline_proto::cip::CipStatus;
use arcline_proto::identity;
use bytes::Bytes;

use super::{Class, Extent};

pub(super) struct Identity<'a>(pub(super) &'a identity::Identity);

impl Class for Identity<'_> {
    fn extent(&self) -> Extent {
        Extent::dense(1, 10)
    }

    fn attribute(&self, _instance: u32, id: u16) -> Result<Bytes, CipStatus> {
        self.0.attribute(id)
    }

    fn all(&self) -> &'static [u16] {
        &[1, 2, 3, 4, 5, 6, 7]
    }
}
