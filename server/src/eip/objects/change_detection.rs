//! Change detection, class 0xAC (spec/ethernet-ip.md §10): clients browse again when a value changes.
//!
//! Tags are never removed or retyped, so their number tells every change.

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
        let tags = u32::try_from(self.0.tags().len()).unwrap_or(u32::MAX);
        match id {
            1 | 2 => u16_value(1),
            3 => u32_value(tags),
            4 | 10 => u32_value(1),
            _ => no_attribute(),
        }
    }

    fn all(&self) -> &'static [u16] {
        &[1, 2, 3, 4, 10]
    }
}
