//! The tag `FaultInject`: DINT, an element for each axis in configuration order, a bit for each present cause of a fault ([`FaultSet`]).
//!
//! The tag is the only copy of injected causes outside the controller: every interface that injects one writes it, and the caller sends the
//! controller the change ([`WriteEffect::FaultInject`]).

use arcline_instruction_set::{AxisId, FaultSet};
use arcline_tag::{DataType, Elementary, TagType};

use super::{Image, TagId, TagKind, WriteEffect, WriteError};
use crate::machine::Machine;

/// Name of the tag.
pub const FAULT_INJECT_TAG: &str = "FaultInject";
/// Bytes of an element.
const SIZE: usize = 4;

impl Image {
    /// The injected causes of every axis, in configuration order.
    pub fn injected_faults(&self) -> impl Iterator<Item = FaultSet> {
        let tag = self.tags().iter().find(|tag| tag.kind == TagKind::FaultInject);
        elements(tag.map_or(&[], |tag| self.bytes(tag.id))).map(FaultSet::from_bits)
    }

    /// The causes that can be injected into an axis; `None` if the axis does not exist.
    pub fn possible_faults(&self, axis: AxisId) -> Option<FaultSet> {
        self.possible_faults.get(usize::from(axis)).copied()
    }

    /// Sets the injected causes of an axis.
    ///
    /// # Errors
    /// [`WriteError::NoSuchFault`] for a bit without a meaning for the axis; [`WriteError::NoSuchTag`] if the axis does not exist, or
    /// another tag has the name.
    pub fn inject_faults(&mut self, axis: AxisId, bits: u32) -> Result<Option<WriteEffect>, WriteError> {
        let tag = self.tags().iter().find(|tag| tag.kind == TagKind::FaultInject);
        let id = tag.ok_or(WriteError::NoSuchTag)?.id;
        self.write(id, SIZE * usize::from(axis), &bits.to_le_bytes())
    }

    /// Adds the tag, if there is an axis and the name is free.
    pub(super) fn add_fault_inject(&mut self, machine: &Machine) {
        let axes = machine.axes.len() as u32;
        if axes == 0 || self.find(FAULT_INJECT_TAG).is_some() {
            return;
        }
        let tag_type = TagType::array(DataType::Elementary(Elementary::Dint), axes);
        self.add(FAULT_INJECT_TAG, tag_type, TagKind::FaultInject);
    }

    /// Writes bytes of the tag, if the resulting elements are possible for their axes.
    pub(super) fn write_fault_inject(
        &mut self,
        id: TagId,
        offset: usize,
        data: &[u8],
    ) -> Result<Option<WriteEffect>, WriteError> {
        let mut next = self.bytes(id).to_vec();
        if let Some(bytes) = next.get_mut(offset..offset.saturating_add(data.len())) {
            bytes.copy_from_slice(data);
        }
        for (axis, (bits, possible)) in elements(&next).zip(&self.possible_faults).enumerate() {
            if bits & !possible.bits() != 0 {
                return Err(WriteError::NoSuchFault {
                    name: FAULT_INJECT_TAG.to_owned(),
                    axis,
                    bits,
                    possible: possible.bits(),
                });
            }
        }
        if let Some(bytes) = self.bytes_mut(id) {
            bytes.copy_from_slice(&next);
        }
        Ok(Some(WriteEffect::FaultInject))
    }
}

fn elements(bytes: &[u8]) -> impl Iterator<Item = u32> {
    bytes
        .chunks_exact(SIZE)
        .filter_map(|bytes| bytes.first_chunk().copied().map(u32::from_le_bytes))
}
