//! Program name, class 0x64 (spec/ethernet-ip.md §13): a stock client asks for it while it opens, and gives up on an
//! error.

use arcline_proto::cip::{CipStatus, class};
use bytes::Bytes;

use super::object::{Extent, Object, ObjectContext};
use super::values::{long_string, no_attribute};

#[derive(Debug)]
pub(super) struct ProgramName;

impl Object for ProgramName {
    fn class(&self) -> u16 {
        class::PROGRAM_NAME
    }

    fn name(&self) -> &'static str {
        "Program Name"
    }

    fn extent(&self, _cx: &ObjectContext<'_, '_>) -> Result<Extent, CipStatus> {
        Extent::dense(1, 1)
    }

    /// Attribute 1: `length u16, bytes`.
    fn attribute(&self, cx: &ObjectContext<'_, '_>, _instance: u32, id: u16) -> Result<Bytes, CipStatus> {
        if id == 1 {
            Ok(long_string(cx.device().settings.identity.name()))
        } else {
            no_attribute()
        }
    }

    fn all(&self) -> &'static [u16] {
        &[1]
    }
}
