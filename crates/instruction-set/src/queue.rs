//! Which calls take a place in the queue of a coordinate system.

use crate::enumerations::{MERGE, Merge};
use crate::{Instruction, Mnemonic, Object, UnboundOperand};

impl Instruction {
    /// Whether a call with these operands can be one of a series (docs/spec/contract.md §4): a line or an arc that takes a place in the queue.
    pub fn joins_series(&self, operands: &[UnboundOperand]) -> bool {
        matches!(self.mnemonic, Mnemonic::Mclm | Mnemonic::Mccm) && self.takes_place(operands)
    }

    /// Whether a call with these operands behind target and motion control takes a place in the queue; one that merges
    /// takes none.
    pub fn takes_place(&self, operands: &[UnboundOperand]) -> bool {
        let place = self
            .operand("Merge")
            .filter(|_| self.object == Object::CoordinateSystem);
        let Some(place) = place else { return false };
        let merge = self
            .operands_behind_control()
            .position(|behind| behind == place)
            .and_then(|index| operands.get(index));
        match merge {
            None | Some(UnboundOperand::Missing) => true,
            Some(UnboundOperand::Number(number)) => *number == 0.0,
            Some(UnboundOperand::Integer(number)) => *number == 0,
            Some(UnboundOperand::Word(word) | UnboundOperand::Name(word)) => {
                MERGE.parse_word(word) == Some(Merge::Disabled as i32)
            }
            Some(UnboundOperand::Array(_)) => false,
        }
    }
}
