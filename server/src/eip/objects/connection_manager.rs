//! Connection Manager, class 0x06 (CIP Vol. 1, 3-5): its counters, and the reaction of motion that a client began when the client's
//! connection is lost.
//!
//! Forward Open, Forward Close and Unconnected Send are the session's and never come here.

use arcline_config::ConnectionLoss;
use arcline_proto::cip::{CipStatus, class};
use bytes::Bytes;

use super::object::{Extent, Object, ObjectContext};
use super::values::{u8_value, u16_value};
use crate::plant::Right;

/// A vendor's attribute, USINT: the index of the reaction in [`ConnectionLoss::WORDS`], for the connection (or the
/// session without one) over which it is asked and set.
const LOSS: u16 = 100;

#[derive(Debug)]
pub(super) struct ConnectionManager;

impl Object for ConnectionManager {
    fn class(&self) -> u16 {
        class::CONNECTION_MANAGER
    }

    fn name(&self) -> &'static str {
        "Connection Manager"
    }

    fn extent(&self, _cx: &ObjectContext<'_, '_>) -> Result<Extent, CipStatus> {
        Extent::dense(1, LOSS)
    }

    /// As in CIP Vol. 1, 3-5: without the number of instances.
    fn class_all(&self) -> &'static [u16] {
        &[1, 2, 6, 7]
    }

    fn attribute(&self, cx: &ObjectContext<'_, '_>, _instance: u32, id: u16) -> Result<Bytes, CipStatus> {
        if id == LOSS {
            let loss = cx.device().loss(cx.context.principal);
            let index = ConnectionLoss::WORDS.iter().position(|(_, known)| *known == loss);
            return u8_value(index.and_then(|index| u8::try_from(index).ok()).unwrap_or_default());
        }
        cx.device()
            .counters()
            .attribute(id)
            .map_or(Err(CipStatus::ATTRIBUTE_NOT_SUPPORTED), u16_value)
    }

    fn all(&self) -> &'static [u16] {
        &[1, 2, 3, 4, 5, 6, 7, 8]
    }

    fn settable(&self, _cx: &ObjectContext<'_, '_>, _instance: u32, id: u16) -> Option<usize> {
        (id == LOSS).then_some(1)
    }

    fn right_to_set(&self) -> Right {
        Right::SetLoss
    }

    fn set(&self, cx: &mut ObjectContext<'_, '_>, _instance: u32, _id: u16, value: &[u8]) -> Result<(), CipStatus> {
        let index = value.first().ok_or(CipStatus::NOT_ENOUGH_DATA)?;
        let (_, loss) = ConnectionLoss::WORDS
            .get(usize::from(*index))
            .ok_or(CipStatus::INVALID_ATTRIBUTE_VALUE)?;
        cx.device().set_loss(cx.context.principal, Some(*loss));
        Ok(())
    }
}
