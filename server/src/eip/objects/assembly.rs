//! Assembly, class 0x04 (CIP Vol. 1, 5A-5; docs/IO.md): the bytes of I/O connections, for who has none.
//!
//! The output can be set as long as no connection owns it, and commands then as an owner in run would.

use arcline_proto::cip::CipStatus;
use arcline_proto::io::Ownership;
use bytes::Bytes;

use super::{Class, Extent, no_attribute, u16_value};
use crate::eip::device::Device;
use crate::eip::tags::unknown;

/// Attribute 3: the data.
const DATA: u16 = 3;
/// Attribute 4: its size, bytes.
const SIZE: u16 = 4;

pub(super) struct Assemblies<'a>(pub(super) &'a Device);

impl Assemblies<'_> {
    /// Bytes of an instance; `None` if there is no such.
    fn size(&self, instance: u32) -> Option<u16> {
        let all = self.0.exchange().assemblies();
        let sizes = [
            (all.input.instance, all.input.size),
            (all.output.instance, all.output.size),
            (all.configuration, 0),
            (all.input_only, 0),
            (all.listen_only, 0),
        ];
        sizes.iter().find(|(id, _)| *id == instance).map(|(_, size)| *size)
    }

    fn is_output(&self, instance: u32) -> bool {
        instance == self.0.exchange().assemblies().output.instance
    }

    fn ownership(&self) -> Ownership {
        self.0.io().map_or(Ownership::Free, |io| io.ownership())
    }
}

impl Class for Assemblies<'_> {
    fn extent(&self) -> Extent {
        let all = self.0.exchange().assemblies();
        Extent {
            highest: all.listen_only,
            count: 5,
            last_attribute: SIZE,
        }
    }

    fn check(&self, instance: u32) -> Result<(), CipStatus> {
        self.size(instance).map(drop).ok_or_else(unknown)
    }

    fn attribute(&self, instance: u32, id: u16) -> Result<Bytes, CipStatus> {
        let device = self.0;
        let size = self.size(instance).ok_or_else(unknown)?;
        match id {
            DATA if size == 0 => Ok(Bytes::new()),
            DATA if self.is_output(instance) => Ok(device.exchange().output()),
            DATA => Ok(device.exchange().input(&device.plant, self.ownership())),
            SIZE => u16_value(size),
            _ => no_attribute(),
        }
    }

    fn settable(&self, instance: u32, id: u16) -> Option<usize> {
        (id == DATA && self.is_output(instance)).then(|| self.size(instance).unwrap_or_default().into())
    }

    fn set(&self, _instance: u32, _id: u16, value: &[u8]) -> Result<(), CipStatus> {
        if self.ownership() != Ownership::Free {
            return Err(CipStatus::OBJECT_STATE_CONFLICT);
        }
        self.0.exchange().apply(value, &self.0.plant);
        Ok(())
    }
}
