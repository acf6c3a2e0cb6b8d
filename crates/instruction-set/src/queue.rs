//! Which calls take a place in the queue of a coordinate system.

use crate::enumerations::{MERGE, Merge};
use crate::{Given, Instruction, Mnemonic, Object};

impl Instruction {
    /// Whether a call with these operands can be one of a series (docs/spec/contract.md §4): a line or an arc that takes a place in the queue.
    pub fn joins_series(&self, given: &[Given]) -> bool {
        matches!(self.mnemonic, Mnemonic::Mclm | Mnemonic::Mccm) && self.takes_place(given)
    }

    /// Whether a call with these operands behind target and motion control takes a place in the queue; one that merges
    /// takes none.
    pub fn takes_place(&self, given: &[Given]) -> bool {
        let place = self
            .operand("Merge")
            .filter(|_| self.object == Object::CoordinateSystem);
        let Some(place) = place else { return false };
        let merge = self
            .given_operands()
            .position(|given| given == place)
            .and_then(|index| given.get(index));
        match merge {
            None | Some(Given::Missing) => true,
            Some(Given::Number(number)) => *number == 0.0,
            Some(Given::Integer(number)) => *number == 0,
            Some(Given::Word(word) | Given::Name(word)) => MERGE.parse_word(word) == Some(Merge::Disabled as i32),
            Some(Given::Array(_)) => false,
        }
    }
}
