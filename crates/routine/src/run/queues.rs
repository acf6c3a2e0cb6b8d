//! Shift registers, queues, stacks and sequencers (spec/programs.md §10.6).

use arcline_tag::DataType;

use super::files::{DN, EM, EN, ER, EU, UL};
use super::value::{Number, Range};
use super::{Run, Scan};
use crate::code::{Area, Argument, LEN, POS};
use crate::table::Op;

impl Scan<'_> {
    /// BSL and BSR.
    pub(crate) fn shift(&mut self, op: Op, arguments: &[Argument], power: bool) -> Run<()> {
        let [Argument::Area(array), Argument::Area(control), source, _] = arguments else {
            return Err(self.unknown());
        };
        let at = self.address(&control.place)?;
        let bits = at + 3;
        if self.s.prescan || !power {
            self.set(bits, EN | DN | ER | UL, false);
            self.put_dint(at + 8, 0);
            return Ok(());
        }
        if self.has(bits, EN) {
            return Ok(());
        }
        let range = self.range(array)?;
        let length = self.dint(at + 4);
        let room = (range.array_end - range.at).saturating_mul(8);
        let count = match u32::try_from(length) {
            Ok(count) if count <= room => count,
            _ => {
                self.set(bits, EN | ER, true);
                return Err(self.fault(4, 20, Some((LEN, length.into()))));
            }
        };
        let mut carry = self.argument_whole(source)? != 0;
        self.spend((count / 32) as usize + 1)?;
        for k in 0..count {
            let bit = if op == Op::Bsl { k } else { count - 1 - k };
            let (byte, mask) = (range.at + bit / 8, 1 << (bit % 8));
            let was = self.has(byte, mask);
            self.set(byte, mask, carry);
            carry = was;
        }
        self.set(bits, UL, carry);
        self.set(bits, EN | DN, true);
        self.put_dint(at + 8, length);
        Ok(())
    }

    /// FFL, FFU, LFL, LFU.
    pub(crate) fn queue(&mut self, op: Op, arguments: &[Argument], power: bool) -> Run<()> {
        let loads = matches!(op, Op::Ffl | Op::Lfl);
        let [first, second, Argument::Area(control), ..] = arguments else {
            return Err(self.unknown());
        };
        let (array, value) = if loads { (second, first) } else { (first, second) };
        let Argument::Area(array) = array else {
            return Err(self.unknown());
        };
        let at = self.address(&control.place)?;
        let bits = at + 3;
        let edge = if loads { EN } else { EU };
        if self.s.prescan {
            self.set(bits, edge, true);
            return Ok(());
        }
        let was = self.has(bits, edge);
        self.set(bits, edge, power);
        let (length, position) = (self.dint(at + 4), self.dint(at + 8));
        if power && !was {
            let range = self.range(array)?;
            let room = i64::from((range.array_end - range.at) / array.size.max(1));
            if length < 0 || position < 0 || i64::from(length) > room || i64::from(position) > room {
                let operand = if length < 0 || i64::from(length) > room {
                    (LEN, length.into())
                } else {
                    (POS, position.into())
                };
                return Err(self.fault(4, 20, Some(operand)));
            }
            if loads {
                if position < length {
                    self.element_from(array, range, position as u32, value)?;
                    self.put_dint(at + 8, position + 1);
                }
            } else if position == 0 {
                self.clear_target(value)?;
            } else {
                let from = if op == Op::Ffu { 0 } else { position as u32 - 1 };
                self.element_to(array, range, from, value)?;
                if op == Op::Ffu {
                    let size = array.size;
                    self.copy_bytes(range.at + size, range.at, (position as u32 - 1) * size)?;
                }
                let last = (range.at + (position as u32 - 1) * array.size) as usize;
                self.s.memory.fill(last..last + array.size as usize, 0);
                self.put_dint(at + 8, position - 1);
            }
        }
        let (length, position) = (self.dint(at + 4), self.dint(at + 8));
        self.set(bits, DN, position >= length);
        self.set(bits, EM, position == 0);
        Ok(())
    }

    /// Writes a value to an element of an array.
    fn element_from(&mut self, array: &Area, range: Range, element: u32, value: &Argument) -> Run<()> {
        let at = range.at + element * array.size;
        match (value, &array.data_type) {
            (Argument::Area(from), DataType::Elementary(kind)) => {
                let source = self.address(&from.place)?;
                let DataType::Elementary(of) = from.data_type else {
                    return Err(self.unknown());
                };
                let value = self.read(source, of);
                self.write(at, *kind, value);
                Ok(())
            }
            (Argument::Area(from), _) => {
                let source = self.address(&from.place)?;
                self.copy_bytes(source, at, array.size.min(from.size))
            }
            (value, DataType::Elementary(kind)) => {
                let value = self.argument(value)?;
                self.write(at, *kind, value);
                Ok(())
            }
            _ => Err(self.unknown()),
        }
    }

    fn element_to(&mut self, array: &Area, range: Range, element: u32, target: &Argument) -> Run<()> {
        let at = range.at + element * array.size;
        match (target, &array.data_type) {
            (Argument::Area(to), DataType::Elementary(kind)) => {
                let address = self.address(&to.place)?;
                let DataType::Elementary(of) = to.data_type else {
                    return Err(self.unknown());
                };
                let value = self.read(at, *kind);
                self.write(address, of, value);
                Ok(())
            }
            (Argument::Area(to), _) => {
                let address = self.address(&to.place)?;
                self.copy_bytes(at, address, array.size.min(to.size))
            }
            _ => Err(self.unknown()),
        }
    }

    fn clear_target(&mut self, target: &Argument) -> Run<()> {
        let Argument::Area(to) = target else {
            return Err(self.unknown());
        };
        let from = self.address(&to.place)? as usize;
        self.s.memory.fill(from..from + to.size as usize, 0);
        Ok(())
    }

    /// SQI
    pub(crate) fn sequencer_input(&mut self, arguments: &[Argument]) -> Run<bool> {
        let [Argument::Area(array), mask, source, Argument::Area(control), ..] = arguments else {
            return Err(self.unknown());
        };
        let at = self.address(&control.place)?;
        let (length, position) = (self.dint(at + 4), self.dint(at + 8));
        let fails = length <= 0 || position < 0 || position > length;
        self.set(at + 3, ER, fails);
        if fails {
            return Ok(false);
        }
        let (mask, source) = (self.argument_whole(mask)?, self.argument_whole(source)?);
        let element = self.element(array, position)?;
        Ok(element & mask == source & mask)
    }

    /// SQO and SQL.
    pub(crate) fn sequencer(&mut self, op: Op, arguments: &[Argument], power: bool) -> Run<()> {
        let (array, mask, value, control) = match (op, arguments) {
            (Op::Sqo, [Argument::Area(array), mask, value, Argument::Area(control), ..]) => {
                (array, Some(mask), value, control)
            }
            (_, [Argument::Area(array), value, Argument::Area(control), ..]) => (array, None, value, control),
            _ => return Err(self.unknown()),
        };
        let at = self.address(&control.place)?;
        let bits = at + 3;
        if self.s.prescan {
            self.set(bits, EN, true);
            return Ok(());
        }
        let was = self.has(bits, EN);
        self.set(bits, EN, power);
        if !power || was {
            return Ok(());
        }
        let (length, position) = (self.dint(at + 4), self.dint(at + 8));
        if length <= 0 || position < 0 {
            self.set(bits, ER, true);
            return Ok(());
        }
        self.set(bits, ER, false);
        let next = if position >= length { 1 } else { position + 1 };
        self.put_dint(at + 8, next);
        self.set(bits, DN, next == length);
        match mask {
            Some(mask) => {
                let mask = self.argument_whole(mask)?;
                let before = self.argument_whole(value)?;
                let element = self.element(array, next)?;
                self.assign(value, Number::Whole((before & !mask) | (element & mask)))
            }
            None => {
                let value = self.argument(value)?;
                let range = self.range(array)?;
                let Some(to) = element_at(array, range, next) else {
                    return Err(self.fault(4, 20, Some((LEN, length.into()))));
                };
                let DataType::Elementary(kind) = array.data_type else {
                    return Err(self.unknown());
                };
                self.write(to, kind, value);
                Ok(())
            }
        }
    }

    fn element(&mut self, array: &Area, position: i32) -> Run<i64> {
        let range = self.range(array)?;
        let Some(at) = element_at(array, range, position) else {
            return Err(self.fault(4, 20, Some((POS, position.into()))));
        };
        match array.data_type {
            DataType::Elementary(kind) => Ok(self.read_whole(at, kind)),
            DataType::Structure(_) => Err(self.unknown()),
        }
    }
}

/// The address of an element; `None`: it is beyond the array.
fn element_at(array: &Area, range: Range, position: i32) -> Option<u32> {
    let skipped = u32::try_from(position).ok()?.checked_mul(array.size)?;
    let at = range.at.checked_add(skipped)?;
    (at.checked_add(array.size)? <= range.array_end).then_some(at)
}
