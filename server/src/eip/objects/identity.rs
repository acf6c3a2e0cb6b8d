//! Identity, class 0x01 (CIP Vol. 1, 5A-2): who the device is. It cannot be reset from outside.

use arcline_proto::cip::{CipStatus, Request, service};
use arcline_proto::identity;
use bytes::Bytes;

use super::{Class, Extent};

pub(super) struct Identity<'a>(pub(super) &'a identity::Identity);

impl Class for Identity<'_> {
    fn extent(&self) -> Extent {
        Extent::dense(1, 10)
    }

    /// As in CIP Vol. 1, 5A-2: without the number of instances.
    fn class_all(&self) -> &'static [u16] {
        &[1, 2, 6, 7]
    }

    fn attribute(&self, _instance: u32, id: u16) -> Result<Bytes, CipStatus> {
        self.0.attribute(id)
    }

    /// Reset is nobody's right: 0x0F, or 0x20 for one that there is not.
    fn service(&self, instance: u32, request: &Request) -> Option<CipStatus> {
        let reset = request.service == service::RESET && instance > 0;
        reset.then(|| match request.data.first() {
            None | Some(0 | 1) => CipStatus::PRIVILEGE_VIOLATION,
            Some(_) => CipStatus::INVALID_PARAMETER,
        })
    }

    fn all(&self) -> &'static [u16] {
        &[1, 2, 3, 4, 5, 6, 7]
    }
}
