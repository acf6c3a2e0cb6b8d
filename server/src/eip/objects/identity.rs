//! Identity, class 0x01 (CIP Vol. 1, 5A-2): vendor, product, serial number. Clients cannot reset the device.

use arcline_proto::arcline::machine::ControllerMode;
use arcline_proto::cip::{CipStatus, Reply, class, service};
use arcline_proto::identity::STATUS_NOT_RUNNING;
use bytes::Bytes;

use super::machine::mode;
use super::object::{Access, Extent, Object, ObjectContext, On, OwnService};
use super::values::u16_value;
use crate::plant::Right;

/// The status word.
const STATUS: u16 = 5;
/// Bit 10 of it: a major fault from which the controller recovers.
const MAJOR_FAULT: u16 = 0x0400;

#[derive(Debug)]
pub(super) struct Identity;

impl Object for Identity {
    fn class(&self) -> u16 {
        class::IDENTITY
    }

    fn name(&self) -> &'static str {
        "Identity"
    }

    fn extent(&self, _cx: &ObjectContext<'_, '_>) -> Result<Extent, CipStatus> {
        Extent::dense(1, 10)
    }

    /// As in CIP Vol. 1, 5A-2: without the number of instances.
    fn class_all(&self) -> &'static [u16] {
        &[1, 2, 6, 7]
    }

    fn attribute(&self, cx: &ObjectContext<'_, '_>, _instance: u32, id: u16) -> Result<Bytes, CipStatus> {
        let device = cx.device();
        if id == STATUS {
            return u16_value(match mode(&device.plant) {
                // Without a program of its own the controller is always ready.
                ControllerMode::None | ControllerMode::Run => device.settings.identity.status,
                ControllerMode::Program => STATUS_NOT_RUNNING,
                ControllerMode::Faulted => STATUS_NOT_RUNNING | MAJOR_FAULT,
            });
        }
        device.settings.identity.attribute(id)
    }

    fn services(&self) -> &'static [OwnService] {
        &[OwnService {
            code: service::RESET,
            name: "Reset",
            on: On::Instance,
            access: Access::Read,
            // No role may execute it.
            right: Right::Look,
        }]
    }

    /// Reset is refused: 0x0F, or 0x20 for a type that does not exist.
    fn serve(&self, cx: &mut ObjectContext<'_, '_>, _instance: u32) -> Result<Reply, CipStatus> {
        Err(match cx.request.data.first() {
            None | Some(0 | 1) => CipStatus::PRIVILEGE_VIOLATION,
            Some(_) => CipStatus::INVALID_PARAMETER,
        })
    }

    fn all(&self) -> &'static [u16] {
        &[1, 2, 3, 4, 5, 6, 7]
    }
}
