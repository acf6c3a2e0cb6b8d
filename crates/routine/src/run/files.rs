//! FAL, FSC, AVE, STD, SRT (spec/programs.md §10.6).

use arcline_tag::{DataType, Elementary, elements_of};

use super::Number;
use super::{Run, Scan};
use crate::code::{Area, Argument, LEN, POS};
use crate::table::Op;

/// Bits of the top byte of a CONTROL.
pub(crate) const EN: u8 = 0x80;
pub(crate) const EU: u8 = 0x40;
pub(crate) const DN: u8 = 0x20;
pub(crate) const EM: u8 = 0x10;
pub(crate) const ER: u8 = 0x08;
pub(crate) const UL: u8 = 0x04;
pub(crate) const IN: u8 = 0x02;
pub(crate) const FD: u8 = 0x01;

impl Scan<'_> {
    /// FAL and FSC.
    pub(crate) fn file(&mut self, op: Op, arguments: &[Argument], power: bool) -> Run<()> {
        let [Argument::Area(control), _, _, mode, rest @ ..] = arguments else {
            return Err(self.unknown());
        };
        let at = self.address(&control.place)?;
        let bits = at + 3;
        if self.s.prescan {
            self.set(bits, EN, false);
            return Ok(());
        }
        let mode = self.argument_whole(mode)?;
        let was = self.has(bits, EN);
        let (length, position) = (self.dint(at + 4), self.dint(at + 8));
        let is_done = self.has(bits, DN | ER);
        if !power {
            // A number of elements each scan goes on to its end, and shows DN in one scan at least.
            if mode > 0 && was && !is_done {
                return self.elements(op, at, rest, mode);
            }
            if was {
                self.set(bits, EN, false);
                if is_done {
                    self.set(bits, DN | ER | FD, false);
                    self.put_dint(at + 8, 0);
                }
            }
            return Ok(());
        }
        if length <= 0 || position < 0 {
            let operand = if length <= 0 {
                (LEN, length.into())
            } else {
                (POS, position.into())
            };
            return Err(self.fault(4, 21, Some(operand)));
        }
        self.set(bits, EN, true);
        // A search goes on, behind its hit, when the program has cleared IN.
        let is_found = op == Op::Fsc && self.has(bits, FD);
        if is_done || is_found && self.has(bits, IN) {
            return Ok(());
        }
        if is_found {
            self.set(bits, FD, false);
            self.put_dint(at + 8, position.wrapping_add(1));
        } else if was && mode <= 0 {
            return Ok(());
        }
        self.elements(op, at, rest, mode)
    }

    /// Works on elements from POS on.
    fn elements(&mut self, op: Op, at: u32, rest: &[Argument], mode: i64) -> Run<()> {
        let bits = at + 3;
        let length = self.dint(at + 4);
        let mut left = match mode {
            0 => i64::from(length),
            mode if mode < 0 => 1,
            mode => mode,
        };
        while left > 0 && self.dint(at + 8) < length {
            self.spend(1)?;
            left -= 1;
            match (op, rest) {
                (Op::Fal, [target, value]) => {
                    self.begin_arithmetic();
                    let value = self.argument(value)?;
                    self.assign(target, value)?;
                    self.flags(value);
                    if self.status(crate::code::Status::Overflow) {
                        self.set(bits, ER, true);
                        return Ok(());
                    }
                }
                (Op::Fsc, [value]) => {
                    let found = match self.argument(value)? {
                        Number::Whole(value) => value != 0,
                        Number::Real(value) => value != 0.0,
                    };
                    if found {
                        self.set(bits, FD | IN, true);
                        let done = self.dint(at + 8).wrapping_add(1) >= length;
                        self.set(bits, DN, done);
                        return Ok(());
                    }
                }
                _ => return Err(self.unknown()),
            }
            let next = self.dint(at + 8).wrapping_add(1);
            self.put_dint(at + 8, next);
        }
        if self.dint(at + 8) >= length {
            self.set(bits, DN, true);
            if op == Op::Fsc {
                self.set(bits, FD, false);
            }
        }
        Ok(())
    }

    /// AVE, STD, SRT.
    pub(crate) fn statistics(&mut self, op: Op, arguments: &[Argument], power: bool) -> Run<()> {
        let (array, dimension, target, control) = match arguments {
            [Argument::Area(array), dimension, Argument::Area(control), _, _] => (array, dimension, None, control),
            [Argument::Area(array), dimension, target, Argument::Area(control), _, _] => {
                (array, dimension, Some(target), control)
            }
            _ => return Err(self.unknown()),
        };
        let at = self.address(&control.place)?;
        let bits = at + 3;
        if self.s.prescan || !power {
            self.set(bits, EN | DN | ER, false);
            return Ok(());
        }
        if self.has(bits, EN) {
            return Ok(());
        }
        let (length, position) = (self.dint(at + 4), self.dint(at + 8));
        if length < 0 || position < 0 {
            let operand = if length < 0 {
                (LEN, length.into())
            } else {
                (POS, position.into())
            };
            return Err(self.fault(4, 21, Some(operand)));
        }
        self.set(bits, EN, true);
        let range = self.range(array)?;
        let DataType::Elementary(kind) = array.data_type else {
            return Err(self.unknown());
        };
        let dimension = usize::try_from(self.argument_whole(dimension)?).unwrap_or(0);
        let stride = self.stride_of(array, dimension);
        let count = (length as u32).min((range.array_end - range.at).div_ceil(stride.max(1)));
        if count < length as u32 {
            return Err(self.fault(4, 20, Some((LEN, length.into()))));
        }
        self.spend(count as usize)?;
        let value = |scan: &Self, k: u32| scan.read_real(range.at + k * stride, kind);
        match (op, target) {
            (Op::Srt, _) => self.sort(range.at, stride, count, kind)?,
            (_, Some(target)) => {
                let sum: f64 = (0..count).map(|k| value(self, k)).sum();
                let average = if count == 0 { 0.0 } else { sum / f64::from(count) };
                let result = if op == Op::Ave {
                    average
                } else {
                    let squares: f64 = (0..count)
                        .map(|k| (value(self, k) - average) * (value(self, k) - average))
                        .sum();
                    if count < 2 {
                        0.0
                    } else {
                        libm::sqrt(squares / f64::from(count - 1))
                    }
                };
                self.begin_arithmetic();
                self.assign(target, Number::Real(result))?;
                self.flags(Number::Real(result));
            }
            _ => return Err(self.unknown()),
        }
        self.put_dint(at + 8, length);
        self.set(bits, DN, true);
        Ok(())
    }

    /// Heap sort in place.
    fn sort(&mut self, at: u32, stride: u32, count: u32, kind: Elementary) -> Run<()> {
        let less = |scan: &Self, a: u32, b: u32| {
            scan.read(at + a * stride, kind).real() < scan.read(at + b * stride, kind).real()
        };
        let mut end = count;
        let mut start = count / 2;
        while end > 1 {
            self.spend(1)?;
            if start > 0 {
                start -= 1;
            } else {
                end -= 1;
                self.exchange(at, at + end * stride, kind);
            }
            let mut root = start;
            loop {
                let mut child = 2 * root + 1;
                if child >= end {
                    break;
                }
                if child + 1 < end && less(self, child, child + 1) {
                    child += 1;
                }
                if !less(self, root, child) {
                    break;
                }
                self.exchange(at + root * stride, at + child * stride, kind);
                root = child;
            }
        }
        Ok(())
    }

    /// Bytes from one element to the next along a dimension.
    fn stride_of(&self, area: &Area, dimension: usize) -> u32 {
        let (_, dimensions) = self.shape(area);
        area.size * elements_of(dimensions.get(dimension + 1..).unwrap_or_default())
    }

    fn exchange(&mut self, a: u32, b: u32, kind: Elementary) {
        for (a, b) in (a..).zip(b..).take(kind.size()) {
            let ([left], [right]) = (self.bytes(a), self.bytes(b));
            self.put(a, [right]);
            self.put(b, [left]);
        }
    }
}
