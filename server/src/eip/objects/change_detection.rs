//! Change detection, class 0xAC (spec/ethernet-ip.md §10): clients browse again when a value changes.
//!
//! Attribute 3 counts every change of the table of tags, 4 and 10 count the configurations that were taken over.

use arcline_proto::cip::{CipStatus, class};
use bytes::Bytes;

use super::object::{Extent, Object, ObjectContext};
use super::values::{no_attribute, u16_value, u32_value};

#[derive(Debug)]
pub(super) struct ChangeDetection;

impl Object for ChangeDetection {
    fn class(&self) -> u16 {
        class::CHANGE_DETECTION
    }

    fn name(&self) -> &'static str {
        "Change Detection"
    }

    fn extent(&self, _cx: &ObjectContext<'_, '_>) -> Result<Extent, CipStatus> {
        Extent::dense(1, 10)
    }

    fn attribute(&self, cx: &ObjectContext<'_, '_>, _instance: u32, id: u16) -> Result<Bytes, CipStatus> {
        match id {
            1 | 2 => u16_value(1),
            3 => u32_value(cx.image().table_changes()),
            4 | 10 => u32_value(cx.image().reloads().wrapping_add(1)),
            _ => no_attribute(),
        }
    }

    fn all(&self) -> &'static [u16] {
        &[1, 2, 3, 4, 10]
    }
}
