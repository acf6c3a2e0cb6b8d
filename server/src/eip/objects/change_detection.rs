//! Change detection, class 0xAC (spec/ethernet-ip.md §10): clients browse again when a value changes.
//!
//! Attribute 3 counts every change of the table of tags, 4 and 10 count the configurations that were taken over.

use arcline_controller::image::Image;
use arcline_proto::cip::CipStatus;
use bytes::Bytes;

use super::{Class, Extent, no_attribute, u16_value, u32_value};

pub(super) struct ChangeDetection<'a>(pub(super) &'a Image);

impl Class for ChangeDetection<'_> {
    fn extent(&self) -> Extent {
        Extent::dense(1, 10)
    }

    fn attribute(&self, _instance: u32, id: u16) -> Result<Bytes, CipStatus> {
        match id {
            1 | 2 => u16_value(1),
            3 => u32_value(self.0.table_changes()),
            4 | 10 => u32_value(self.0.reloads().wrapping_add(1)),
            _ => no_attribute(),
        }
    }

    fn all(&self) -> &'static [u16] {
        &[1, 2, 3, 4, 10]
    }
}
