//! A machine without axes, coordinate systems and motion: for projects that only compute.

use arcline_instruction_set::{Call, ControlSlot, MotionControl, Object};
use arcline_tag::TagType;

use crate::{Directory, Host, Memory};

/// A machine without motion: it knows no name, executes no instruction, and it is always the same instant there.
#[derive(Clone, Copy, Debug, Default)]
pub struct NoMachine;

impl Directory for NoMachine {
    fn object_type(&self, _: &str) -> Option<TagType> {
        None
    }
    fn object(&self, _: Object, _: &str) -> Option<u16> {
        None
    }
    fn has_motion(&self) -> bool {
        false
    }
    fn control(&mut self, _: &str) -> Option<ControlSlot> {
        None
    }
    fn tag(&mut self, _: &str, _: &TagType) -> Option<u32> {
        None
    }
    fn attribute(&mut self, _: Object, _: u16, _: &str) -> Option<(u32, usize)> {
        None
    }
}

impl Host for NoMachine {
    fn execute(&mut self, _: &Call, _: &mut Memory) -> MotionControl {
        MotionControl::default()
    }
    fn rung_false(&mut self, _: ControlSlot) {}
    fn attribute(&mut self, _: u32) -> f64 {
        0.0
    }
    fn set_attribute(&mut self, _: u32, _: f64) -> bool {
        false
    }
    fn date(&self, _: u64) -> [i32; 7] {
        [2026, 1, 2, 3, 4, 5, 6]
    }
}
