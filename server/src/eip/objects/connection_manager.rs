//! Connection Manager, class 0x06 (CIP Vol. 1, 3-5): its counters, and what becomes of the motion of whoever asks when its
//! connection is lost.
//!
//! Forward Open, Forward Close and Unconnected Send are the session's and never come here.

use arcline_config::ConnectionLoss;
use arcline_proto::cip::CipStatus;
use bytes::Bytes;

use super::{Class, Extent, u8_value, u16_value};
use crate::eip::device::Device;
use crate::plant::Principal;

/// A vendor's attribute, USINT: the place of the reaction among [`ConnectionLoss::WORDS`], for the connection (or the
/// session without one) over which it is asked and set.
const LOSS: u16 = 100;

pub(super) struct ConnectionManager<'a> {
    pub(super) device: &'a Device,
    /// Whoever asks.
    pub(super) principal: Principal,
}

impl Class for ConnectionManager<'_> {
    fn extent(&self) -> Extent {
        Extent::dense(1, LOSS)
    }

    /// As in CIP Vol. 1, 3-5: without the number of instances.
    fn class_all(&self) -> &'static [u16] {
        &[1, 2, 6, 7]
    }

    fn attribute(&self, _instance: u32, id: u16) -> Result<Bytes, CipStatus> {
        if id == LOSS {
            let loss = self.device.loss(self.principal);
            let place = ConnectionLoss::WORDS.iter().position(|(_, known)| *known == loss);
            return u8_value(place.and_then(|place| u8::try_from(place).ok()).unwrap_or_default());
        }
        self.device
            .counters()
            .attribute(id)
            .map_or(Err(CipStatus::ATTRIBUTE_NOT_SUPPORTED), u16_value)
    }

    fn all(&self) -> &'static [u16] {
        &[1, 2, 3, 4, 5, 6, 7, 8]
    }

    fn settable(&self, _instance: u32, id: u16) -> Option<usize> {
        (id == LOSS).then_some(1)
    }

    fn set(&self, _instance: u32, _id: u16, value: &[u8]) -> Result<(), CipStatus> {
        let place = value.first().ok_or(CipStatus::NOT_ENOUGH_DATA)?;
        let (_, loss) = ConnectionLoss::WORDS
            .get(usize::from(*place))
            .ok_or(CipStatus::INVALID_ATTRIBUTE_VALUE)?;
        self.device.set_loss(self.principal, Some(*loss));
        Ok(())
    }
}
