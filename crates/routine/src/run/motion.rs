//! Instructions of motion: an edge of EN executes (spec/programs.md §11).

use arcline_instruction_set::{Argument as Bound, Call, Flag, MAX_ELEMENTS, RealArray, TagAddress, WrittenArray};
use arcline_tag::{DataType, Elementary};

use super::{MAX_EXECUTIONS, Run, Scan};
use crate::code::{Area, MotionCall, MotionOperand};

impl Scan<'_> {
    pub(crate) fn motion(&mut self, call: &MotionCall, power: bool) -> Run<()> {
        let at = self.address(&call.control)?;
        if self.s.prescan {
            let bits = Flag::En.mask() | Flag::Dn.mask() | Flag::Er.mask() | Flag::Ip.mask();
            let flags = self.dint(at) as u32 & !bits;
            self.put_dint(at, flags as i32);
            return Ok(());
        }
        if call.is_text {
            // Structured Text runs it with a false rung, then with a true one.
            self.motion_off(at);
        }
        if !power {
            self.motion_off(at);
            return Ok(());
        }
        let flags = self.dint(at) as u32;
        if flags & Flag::En.mask() != 0 {
            return Ok(());
        }
        self.s.is_restless = true;
        self.s.executions += 1;
        if self.s.executions > MAX_EXECUTIONS {
            return Err(self.fault(6, 1, None));
        }
        let Some(slot) = self.slot(at) else { return Ok(()) };
        let mut bound = Call {
            control: slot,
            ..call.call
        };
        if let Some(target) = &call.target {
            let at = self.address(target)?;
            bound.target = self.object(at);
        }
        for (place, operand) in &call.operands {
            let argument = self.motion_operand(operand)?;
            if let Some(slot) = bound.arguments.get_mut(usize::from(*place)) {
                *slot = argument;
            }
        }
        let control = self.host.execute(&bound, &mut self.s.memory);
        self.put(at, control.to_bytes());
        Ok(())
    }

    /// The rung is false: EN goes when the instruction has been answered.
    fn motion_off(&mut self, at: u32) {
        let flags = self.dint(at) as u32;
        if flags & Flag::En.mask() == 0 {
            return;
        }
        if let Some(slot) = self.slot(at) {
            self.s.is_restless = true;
            self.host.rung_false(slot);
        }
        if flags & (Flag::Dn.mask() | Flag::Er.mask()) != 0 {
            self.put_dint(at, (flags & !Flag::En.mask()) as i32);
        }
    }

    fn slot(&self, at: u32) -> Option<arcline_instruction_set::ControlSlot> {
        let controls = &self.s.controls;
        let place = controls.binary_search_by_key(&at, |(at, _)| *at).ok()?;
        controls.get(place).map(|(_, slot)| *slot)
    }

    fn object(&self, at: u32) -> Option<u16> {
        let objects = &self.s.objects;
        let place = objects.binary_search_by_key(&at, |(at, ..)| *at).ok()?;
        objects.get(place).map(|(_, _, index)| *index)
    }

    fn motion_operand(&mut self, operand: &MotionOperand) -> Run<Bound> {
        Ok(match operand {
            MotionOperand::Number(value) => Bound::Number(self.real(value)?),
            MotionOperand::Array(area) => Bound::Array(self.reals(area)?),
            MotionOperand::Object(place) => {
                let at = self.address(place)?;
                self.object(at).map_or(Bound::None, Bound::Object)
            }
            MotionOperand::Tag(area) => {
                let range = self.range(area)?;
                self.shared(range.at).map_or(Bound::None, Bound::Tag)
            }
            MotionOperand::Written(area) => {
                let range = self.range(area)?;
                let elements = ((range.array_end - range.at) / 4).min(u32::from(u16::MAX)) as u16;
                let tag = self.shared(range.at);
                tag.map_or(Bound::None, |tag| Bound::Written(WrittenArray { tag, elements }))
            }
        })
    }

    /// The host's address of a byte of a tag that both have.
    fn shared(&self, at: u32) -> Option<TagAddress> {
        let tag = self
            .s
            .shared
            .iter()
            .find(|(from, end, _)| (*from..*end).contains(&at))?;
        TagAddress::new(tag.2, (at - tag.0) as usize)
    }

    /// Numbers from an element on.
    fn reals(&mut self, area: &Area) -> Run<RealArray> {
        let range = self.range(area)?;
        let mut numbers = [0.0; MAX_ELEMENTS];
        let mut count = 0;
        if let DataType::Elementary(kind) = area.data_type {
            let size = kind.size() as u32;
            let there = if kind == Elementary::Bool {
                0
            } else {
                (range.array_end - range.at) / size
            };
            for (place, number) in numbers.iter_mut().enumerate().take(there as usize) {
                *number = self.read_real(range.at + place as u32 * size, kind);
                count += 1;
            }
        }
        Ok(RealArray::from_slice(numbers.get(..count).unwrap_or_default()))
    }
}
