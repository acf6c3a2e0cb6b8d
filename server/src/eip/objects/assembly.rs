//! Assembly, class 0x04 (CIP Vol. 1, 5A-5; docs/IO.md): the bytes of I/O connections, for clients without one.
//!
//! The output can be set as long as no connection owns it, and commands then as an owner in run would.

use arcline_proto::cip::{CipStatus, class};
use arcline_proto::io::Ownership;
use bytes::Bytes;

use super::object::{Extent, Object, ObjectContext};
use super::values::{no_attribute, u16_value};
use crate::eip::device::Device;
use crate::eip::status::unknown;
use crate::plant::Right;

/// Attribute 3: the data.
const DATA: u16 = 3;
/// Attribute 4: its size, bytes.
const SIZE: u16 = 4;

#[derive(Debug)]
pub(super) struct Assemblies;

/// Bytes of an instance; `None` if there is no such.
fn size(device: &Device, instance: u32) -> Option<u16> {
    let all = device.assembly_data().assemblies();
    let sizes = [
        (all.input.instance, all.input.size),
        (all.output.instance, all.output.size),
        (all.configuration, 0),
        (all.input_only, 0),
        (all.listen_only, 0),
    ];
    sizes.iter().find(|(id, _)| *id == instance).map(|(_, size)| *size)
}

fn is_output(device: &Device, instance: u32) -> bool {
    instance == device.assembly_data().assemblies().output.instance
}

fn ownership(device: &Device) -> Ownership {
    device.io().map_or(Ownership::Free, |io| io.ownership())
}

impl Object for Assemblies {
    fn class(&self) -> u16 {
        class::ASSEMBLY
    }

    fn name(&self) -> &'static str {
        "Assembly"
    }

    fn is_late(&self) -> bool {
        true
    }

    fn extent(&self, cx: &ObjectContext<'_, '_>) -> Result<Extent, CipStatus> {
        let all = cx.device().assembly_data().assemblies();
        Ok(Extent {
            highest: all.listen_only,
            count: 5,
            last_attribute: SIZE,
        })
    }

    fn check(&self, cx: &ObjectContext<'_, '_>, instance: u32) -> Result<(), CipStatus> {
        size(cx.device(), instance).map(drop).ok_or_else(unknown)
    }

    fn attribute(&self, cx: &ObjectContext<'_, '_>, instance: u32, id: u16) -> Result<Bytes, CipStatus> {
        let device = cx.device();
        let size = size(device, instance).ok_or_else(unknown)?;
        match id {
            DATA if size == 0 => Ok(Bytes::new()),
            DATA if is_output(device, instance) => Ok(device.assembly_data().output()),
            DATA => Ok(device.assembly_data().input(&device.plant, ownership(device))),
            SIZE => u16_value(size),
            _ => no_attribute(),
        }
    }

    fn settable(&self, cx: &ObjectContext<'_, '_>, instance: u32, id: u16) -> Option<usize> {
        let device = cx.device();
        (id == DATA && is_output(device, instance)).then(|| size(device, instance).unwrap_or_default().into())
    }

    fn right_to_set(&self) -> Right {
        Right::OwnOutputs
    }

    fn set(&self, cx: &mut ObjectContext<'_, '_>, _instance: u32, _id: u16, value: &[u8]) -> Result<(), CipStatus> {
        let device = cx.device();
        if ownership(device) != Ownership::Free {
            return Err(CipStatus::OBJECT_STATE_CONFLICT);
        }
        device
            .plant
            .roles()
            .set_io(device.plant.roles().of(cx.context.principal));
        device.assembly_data().apply(value, &device.plant);
        Ok(())
    }
}
