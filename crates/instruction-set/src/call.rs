//! A bound call: the data that cross into the real-time thread. Fixed size, no heap.

use crate::{Instruction, Mnemonic};

/// Most operands of an instruction, target and motion control included.
pub const MAX_OPERANDS: usize = 26;

/// Most elements of an array operand that any instruction uses.
pub const MAX_ELEMENTS: usize = 9;

/// The MOTION_INSTRUCTION tag of an execution, numbered by the tag memory.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub struct ControlSlot(pub u32);

/// Up to [`MAX_ELEMENTS`] numbers.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct RealArray {
    len: u8,
    values: [f64; MAX_ELEMENTS],
}

impl RealArray {
    /// Takes the first [`MAX_ELEMENTS`] numbers; no instruction uses the others.
    pub fn from_slice(numbers: &[f64]) -> Self {
        let mut array = Self::default();
        for (place, number) in array.values.iter_mut().zip(numbers) {
            *place = *number;
            array.len += 1;
        }
        array
    }

    /// The numbers.
    pub fn as_slice(&self) -> &[f64] {
        &self.values[..usize::from(self.len)]
    }
}

/// The tag and the byte in it at which the data of an operand begin.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug, Default)]
pub struct TagAddress(u32);

impl TagAddress {
    /// `None`: the tag's number or the offset is too large, or the offset is no multiple of 4.
    pub fn new(tag: u32, offset: usize) -> Option<Self> {
        let tag = u16::try_from(tag).ok()?;
        let word = u16::try_from(offset / 4).ok().filter(|_| offset.is_multiple_of(4))?;
        Some(TagAddress(u32::from(tag) << 16 | u32::from(word)))
    }

    /// The tag, by its number in the [`crate::Directory`].
    pub const fn tag(self) -> u32 {
        self.0 >> 16
    }

    /// The first byte.
    pub const fn offset(self) -> usize {
        (self.0 & 0xFFFF) as usize * 4
    }

    /// The address of the REAL that is `index` elements behind.
    pub fn element(self, index: usize) -> Option<Self> {
        TagAddress::new(self.tag(), self.offset() + 4 * index)
    }
}

/// One bound operand.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub enum Argument {
    /// Target and motion control (they have members of their own), or "none".
    #[default]
    None,
    /// A number or the value of an enumeration, not yet checked or rounded.
    Number(f64),
    /// An array that is read when the instruction executes.
    Array(RealArray),
    /// Another motion object, by its index.
    Object(u16),
    /// A structure tag that is read.
    Tag(TagAddress),
    /// A REAL array tag that is written.
    Written(WrittenArray),
}

/// A REAL array that an instruction writes.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct WrittenArray {
    /// Its first element.
    pub tag: TagAddress,
    /// Elements from there to its end.
    pub elements: u16,
}

/// An instruction with everything it needs to execute. Real-time: `Copy`, no heap.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Call {
    /// Which instruction.
    pub mnemonic: Mnemonic,
    /// Index of the group, axis or coordinate system; `None`: there is no such object.
    pub target: Option<u16>,
    /// Its motion control tag.
    pub control: ControlSlot,
    /// Operands by faceplate position; those of target and motion control are `None`.
    pub arguments: [Argument; MAX_OPERANDS],
}

impl Call {
    /// The instruction's faceplate.
    pub fn instruction(&self) -> &'static Instruction {
        self.mnemonic.instruction()
    }

    /// The operand at a faceplate position; beyond the last it is none.
    pub fn argument(&self, operand: usize) -> Argument {
        self.arguments.get(operand).copied().unwrap_or_default()
    }

    /// An operand as a number: 0 if none, the first element of an array.
    pub fn number(&self, operand: usize) -> f64 {
        match self.arguments.get(operand) {
            Some(Argument::Number(number)) => *number,
            Some(Argument::Array(array)) => array.as_slice().first().copied().unwrap_or(0.0),
            _ => 0.0,
        }
    }

    /// An operand as the value of an enumeration or a count, rounded half to even. [`Instruction::verify`] refuses a value that is not a number
    /// or beyond a DINT; unverified it is 0 or the nearest DINT.
    pub fn word(&self, operand: usize) -> i32 {
        self.number(operand).round_ties_even() as i32
    }

    /// An operand as an array; empty if none, one element if it is a number.
    pub fn array(&self, operand: usize) -> &[f64] {
        match self.arguments.get(operand) {
            Some(Argument::Array(array)) => array.as_slice(),
            Some(Argument::Number(number)) => std::slice::from_ref(number),
            _ => &[],
        }
    }

    /// An operand as another motion object.
    pub fn object(&self, operand: usize) -> Option<u16> {
        match self.argument(operand) {
            Argument::Object(index) => Some(index),
            _ => None,
        }
    }

    /// An operand as an array that is written.
    pub fn written(&self, operand: usize) -> Option<WrittenArray> {
        match self.argument(operand) {
            Argument::Written(array) => Some(array),
            _ => None,
        }
    }

    /// An operand as a structure tag.
    pub fn tag(&self, operand: usize) -> Option<TagAddress> {
        match self.argument(operand) {
            Argument::Tag(tag) => Some(tag),
            _ => None,
        }
    }
}
