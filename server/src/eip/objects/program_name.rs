//! Program name, class 0x64 (spec/ethernet-ip.md §13): a stock client asks for it while it opens, and gives up on an
//! error.

use arcline_proto::cip::CipStatus;
use bytes::Bytes;

use super::{Class, Extent, long_string, no_attribute};

pub(super) struct ProgramName<'a>(pub(super) &'a str);

impl Class for ProgramName<'_> {
    fn extent(&self) -> Extent {
        Extent::dense(1, 1)
    }

    /// Attribute 1: `length u16, bytes`.
    fn attribute(&self, _instance: u32, id: u16) -> Result<Bytes, CipStatus> {
        if id == 1 {
            Ok(long_string(self.0))
        } else {
            no_attribute()
        }
    }

    fn all(&self) -> &'static [u16] {
        &[1]
    }
}
