//! Values: places to addresses, expressions to numbers, numbers to the memory.

use arcline_tag::{Elementary, elements_of};

use super::{Exit, Run, Scan};
use crate::code::{
    Area, Argument, Bit, Cellular, Compare, Ex, Float, Function, Place, Select, Sizes, Status, TextPart, Whole, Width,
};

/// An area at run time: its first byte, the end of its array, and the end of its tag.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Range {
    pub(crate) at: u32,
    pub(crate) array_end: u32,
    pub(crate) end: u32,
}

/// A number.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(crate) enum Number {
    Whole(i64),
    Real(f64),
}

impl Scan<'_> {
    pub(crate) fn base(&self, base: u8) -> u32 {
        match usize::from(base).checked_sub(1) {
            None => 0,
            Some(place) => self.s.bases.get(self.s.frame + place).map_or(0, |base| base.at),
        }
    }

    /// The sizes of the operand of a parameter by reference.
    pub(crate) fn sizes(&self, base: u8) -> Sizes {
        let place = self.s.frame + usize::from(base).saturating_sub(1);
        self.s.bases.get(place).map_or_else(Sizes::default, |base| base.sizes)
    }

    /// The elements of an area's array, and its dimensions.
    pub(crate) fn shape(&self, area: &Area) -> (u32, [u32; 3]) {
        if !area.is_of_operand {
            return (area.length, area.dimensions);
        }
        let dimensions = self.sizes(area.place.base).dimensions;
        (elements_of(&dimensions), dimensions)
    }

    /// The address of a place; a subscript out of range is a fault.
    pub(crate) fn address(&mut self, place: &Place) -> Run<u32> {
        self.address_behind(place, 0).map(|(at, _)| at)
    }

    /// The address of a place, and the bytes that its subscripts from the `outer`th on skip. Each subscript is evaluated once.
    fn address_behind(&mut self, place: &Place, outer: usize) -> Run<(u32, u32)> {
        let mut at = self.base(place.base) + place.at;
        let mut inner = 0;
        for (number, index) in place.index.iter().enumerate() {
            let value = self.whole(&index.value)?;
            let (size, stride) = match index.of_operand {
                None => (index.size, index.stride),
                Some(dimension) => {
                    let sizes = self.sizes(place.base).dimensions;
                    let sizes = sizes.get(usize::from(dimension)..).unwrap_or_default();
                    let (size, behind) = sizes.split_first().unwrap_or((&0, &[]));
                    (*size, elements_of(behind) * index.stride)
                }
            };
            let element = match u32::try_from(value) {
                Ok(element) if element < size => element,
                _ => return Err(self.fault(4, 20, Some((index.text, value)))),
            };
            at += element * stride;
            if number >= outer {
                inner += element * stride;
            }
        }
        Ok((at, inner))
    }

    pub(crate) fn range(&mut self, area: &Area) -> Run<Range> {
        let outer = area.place.index.len() - area.inner;
        let (at, inner) = self.address_behind(&area.place, outer)?;
        let skipped = area.skipped + inner;
        let array_end = at - skipped + self.shape(area).0 * area.size;
        let base = area.place.base;
        let end = match base {
            0 | 1 => area.end,
            _ => self.sizes(base).bytes,
        };
        Ok(Range {
            at,
            array_end,
            end: self.base(base) + end,
        })
    }

    pub(crate) fn bytes<const N: usize>(&self, at: u32) -> [u8; N] {
        let bytes = self.s.memory.get(at as usize..).and_then(<[u8]>::first_chunk);
        bytes.copied().unwrap_or([0; N])
    }

    pub(crate) fn put<const N: usize>(&mut self, at: u32, bytes: [u8; N]) {
        self.s.memory.put(at as usize, bytes);
    }

    pub(crate) fn dint(&self, at: u32) -> i32 {
        i32::from_le_bytes(self.bytes(at))
    }

    pub(crate) fn put_dint(&mut self, at: u32, value: i32) {
        self.put(at, value.to_le_bytes());
    }

    pub(crate) fn has(&self, at: u32, mask: u8) -> bool {
        self.s.memory.get(at as usize).is_some_and(|byte| byte & mask != 0)
    }

    pub(crate) fn set(&mut self, at: u32, mask: u8, on: bool) {
        self.s.memory.set(at as usize, mask, on);
    }

    /// Byte and mask of a bit.
    pub(crate) fn bit_at(&mut self, bit: &Bit) -> Run<(u32, u8)> {
        let at = self.address(&bit.place)?;
        self.bit_behind(at, bit.place.base, &bit.select)
    }

    /// Byte and mask of a bit behind an address that was reached from a base.
    pub(crate) fn bit_behind(&mut self, at: u32, base: u8, select: &Select) -> Run<(u32, u8)> {
        match select {
            Select::Mask(mask) => Ok((at, *mask)),
            Select::Referenced => {
                let place = self.s.frame + usize::from(base).saturating_sub(1);
                Ok((at, self.s.bases.get(place).map_or(1, |base| base.mask)))
            }
            Select::Number {
                value,
                bits,
                text,
                fault,
            } => {
                let number = self.whole(value)?;
                let bits = bits.unwrap_or_else(|| self.sizes(base).bits);
                match u32::try_from(number) {
                    Ok(number) if number < bits => Ok((at + number / 8, 1 << (number % 8))),
                    _ => Err(self.fault(4, *fault, Some((*text, number)))),
                }
            }
        }
    }

    pub(crate) fn bit(&mut self, bit: &Bit) -> Run<bool> {
        let (at, mask) = self.bit_at(bit)?;
        Ok(self.has(at, mask))
    }

    pub(crate) fn read_whole(&self, at: u32, kind: Elementary) -> i64 {
        match kind {
            Elementary::Bool => i64::from(self.has(at, 1)),
            Elementary::Sint => i64::from(i8::from_le_bytes(self.bytes(at))),
            Elementary::Int => i64::from(i16::from_le_bytes(self.bytes(at))),
            Elementary::Dint | Elementary::Dword => i64::from(self.dint(at)),
            Elementary::Usint | Elementary::Byte => i64::from(u8::from_le_bytes(self.bytes(at))),
            Elementary::Uint | Elementary::Word => i64::from(u16::from_le_bytes(self.bytes(at))),
            Elementary::Udint => i64::from(u32::from_le_bytes(self.bytes(at))),
            Elementary::Lint | Elementary::Ulint | Elementary::Lword => i64::from_le_bytes(self.bytes(at)),
            Elementary::Real | Elementary::Lreal => self.read_real(at, kind).round_ties_even() as i64,
        }
    }

    pub(crate) fn read_real(&self, at: u32, kind: Elementary) -> f64 {
        match kind {
            Elementary::Real => f64::from(f32::from_le_bytes(self.bytes(at))),
            Elementary::Lreal => f64::from_le_bytes(self.bytes(at)),
            kind => self.read_whole(at, kind) as f64,
        }
    }

    pub(crate) fn read(&self, at: u32, kind: Elementary) -> Number {
        if kind.is_real() {
            Number::Real(self.read_real(at, kind))
        } else {
            Number::Whole(self.read_whole(at, kind))
        }
    }

    /// Writes a number, converted; an overflow sets the flag and keeps the low bits.
    pub(crate) fn write(&mut self, at: u32, kind: Elementary, value: Number) {
        match (value, kind) {
            (Number::Whole(value), Elementary::Real) => self.put(at, (value as f32).to_le_bytes()),
            (Number::Whole(value), Elementary::Lreal) => self.put(at, (value as f64).to_le_bytes()),
            (Number::Real(value), Elementary::Real) => {
                let single = value as f32;
                self.s.overflow |= !single.is_finite();
                self.put(at, single.to_le_bytes());
            }
            (Number::Real(value), Elementary::Lreal) => {
                self.s.overflow |= !value.is_finite();
                self.put(at, value.to_le_bytes());
            }
            (Number::Real(value), kind) => {
                let rounded = value.round_ties_even();
                self.s.overflow |= !(-9.3e18..=9.3e18).contains(&rounded);
                // Beyond 64 bits it stays at the limit, whose low bits are written.
                self.write_whole(at, kind, rounded as i64);
            }
            (Number::Whole(value), kind) => self.write_whole(at, kind, value),
        }
    }

    fn write_whole(&mut self, at: u32, kind: Elementary, value: i64) {
        let fits = match kind {
            Elementary::Bool => true,
            Elementary::Sint => i8::try_from(value).is_ok(),
            Elementary::Int => i16::try_from(value).is_ok(),
            Elementary::Dint => i32::try_from(value).is_ok(),
            Elementary::Usint | Elementary::Byte => u8::try_from(value).is_ok(),
            Elementary::Uint | Elementary::Word => u16::try_from(value).is_ok(),
            Elementary::Udint | Elementary::Dword => u32::try_from(value).is_ok(),
            _ => true,
        };
        self.s.overflow |= !fits;
        match kind.size() {
            1 if kind == Elementary::Bool => self.set(at, 1, value != 0),
            1 => self.put(at, (value as i8).to_le_bytes()),
            2 => self.put(at, (value as i16).to_le_bytes()),
            4 => self.put(at, (value as i32).to_le_bytes()),
            _ => self.put(at, value.to_le_bytes()),
        }
    }

    pub(crate) fn store(&mut self, cell: &Cellular, value: Number) -> Run<()> {
        let at = self.address(&cell.place)?;
        self.write(at, cell.kind, value);
        Ok(())
    }

    /// The number of an operand.
    pub(crate) fn argument(&mut self, argument: &Argument) -> Run<Number> {
        match argument {
            Argument::Integer(value) => Ok(Number::Whole(self.whole(value)?)),
            Argument::Real(value) => Ok(Number::Real(self.real(value)?)),
            Argument::Target(cell) => {
                let at = self.address(&cell.place)?;
                Ok(self.read(at, cell.kind))
            }
            Argument::Bit(bit) => Ok(Number::Whole(i64::from(self.bit(bit)?))),
            Argument::Word(value) => Ok(Number::Whole(i64::from(*value))),
            _ => Err(self.unknown()),
        }
    }

    pub(crate) fn argument_whole(&mut self, argument: &Argument) -> Run<i64> {
        Ok(match self.argument(argument)? {
            Number::Whole(value) => value,
            Number::Real(value) => value.round_ties_even() as i64,
        })
    }

    /// Writes to an operand.
    pub(crate) fn assign(&mut self, argument: &Argument, value: Number) -> Run<()> {
        match argument {
            Argument::Target(cell) => self.store(cell, value),
            Argument::Bit(bit) => {
                let (at, mask) = self.bit_at(bit)?;
                let on = match value {
                    Number::Whole(value) => value != 0,
                    Number::Real(value) => value != 0.0,
                };
                self.set(at, mask, on);
                Ok(())
            }
            Argument::Status(status) => {
                let on = value.real() != 0.0;
                self.set_status(*status, on);
                Ok(())
            }
            _ => Err(self.unknown()),
        }
    }

    /// A whole number or truth value.
    pub(crate) fn whole(&mut self, value: &Ex) -> Run<i64> {
        Ok(match value {
            Ex::Integer(value) => *value,
            Ex::Dint(at) => i64::from(self.dint(*at)),
            Ex::Load(cell) => {
                let at = self.address(&cell.place)?;
                self.read_whole(at, cell.kind)
            }
            Ex::Bit(bit) => i64::from(self.bit(bit)?),
            Ex::Status(status) => i64::from(self.status(*status)),
            Ex::ToInteger(value) => {
                let value = self.real(value)?;
                self.s.overflow |= !(-9.3e18..=9.3e18).contains(&value);
                value.round_ties_even() as i64
            }
            Ex::Negate(value) => self.whole(value)?.wrapping_neg(),
            Ex::Invert(value) => !self.whole(value)?,
            Ex::IsZero(value) => i64::from(self.whole(value)? == 0),
            Ex::Whole(operation, operands) => {
                let a = self.whole(&operands.0)?;
                let b = self.whole(&operands.1)?;
                self.operate(*operation, a, b)
            }
            Ex::Compare(compare, operands) => {
                let a = self.whole(&operands.0)?;
                let b = self.whole(&operands.1)?;
                i64::from(holds(*compare, a.cmp(&b)))
            }
            Ex::CompareReal(compare, operands) => {
                let a = self.real(&operands.0)?;
                let b = self.real(&operands.1)?;
                i64::from(holds_real(*compare, a, b))
            }
            Ex::CompareText(compare, texts) => {
                let (from_a, to_a) = self.text_range(&texts.0)?;
                let (from_b, to_b) = self.text_range(&texts.1)?;
                let a = self.text_slice(&texts.0, from_a, to_a);
                let b = self.text_slice(&texts.1, from_b, to_b);
                i64::from(holds(*compare, a.cmp(b)))
            }
            Ex::Unsigned(value, size) => self.whole(value)? & ((1_i64 << (8 * size)) - 1),
            Ex::Function(Function::AbsoluteWhole, _, value) => self.whole(value)?.wrapping_abs(),
            Ex::Function(Function::ToBcd, _, value) => {
                let value = self.whole(value)?;
                self.bcd_of(value)
            }
            Ex::Function(Function::FromBcd, _, value) => from_bcd(self.whole(value)?),
            Ex::Real(value) => value.round_ties_even() as i64,
            Ex::ToReal(value, _) => self.whole(value)?,
            real @ (Ex::NegateReal(_) | Ex::Float(..) | Ex::Function(..)) => self.real(real)?.round_ties_even() as i64,
        })
    }

    pub(super) fn operate(&mut self, operation: Whole, a: i64, b: i64) -> i64 {
        let checked = match operation {
            Whole::Add => a.checked_add(b),
            Whole::Subtract => a.checked_sub(b),
            Whole::Multiply => a.checked_mul(b),
            Whole::Divide | Whole::Modulo if b == 0 => {
                self.s.overflow = true;
                self.counted_minor();
                return if operation == Whole::Divide { a } else { 0 };
            }
            Whole::Divide => a.checked_div(b),
            Whole::Modulo => a.checked_rem(b),
            Whole::Power => match u32::try_from(b) {
                Ok(exponent) => a.checked_pow(exponent),
                Err(_) => Some(libm::pow(a as f64, b as f64).round_ties_even() as i64),
            },
            Whole::And => Some(a & b),
            Whole::Or => Some(a | b),
            Whole::Xor => Some(a ^ b),
        };
        checked.unwrap_or_else(|| {
            self.s.overflow = true;
            match operation {
                Whole::Add => a.wrapping_add(b),
                Whole::Subtract => a.wrapping_sub(b),
                Whole::Multiply => a.wrapping_mul(b),
                Whole::Power => a.wrapping_pow(u32::try_from(b).unwrap_or(0)),
                _ => a,
            }
        })
    }

    pub(super) fn operate_real(&mut self, operation: Float, a: f64, b: f64) -> f64 {
        match operation {
            Float::Add => a + b,
            Float::Subtract => a - b,
            Float::Multiply => a * b,
            Float::Divide => {
                if b == 0.0 {
                    self.counted_minor();
                }
                a / b
            }
            Float::Modulo if b == 0.0 => {
                self.s.overflow = true;
                self.counted_minor();
                0.0
            }
            Float::Modulo => libm::fmod(a, b),
            Float::Power => libm::pow(a, b),
        }
    }

    /// A number with a point.
    pub(crate) fn real(&mut self, value: &Ex) -> Run<f64> {
        Ok(match value {
            Ex::Real(value) => *value,
            Ex::Load(cell) if cell.kind.is_real() => {
                let at = self.address(&cell.place)?;
                self.read_real(at, cell.kind)
            }
            Ex::ToReal(value, width) => round(self.whole(value)? as f64, *width),
            Ex::NegateReal(value) => -self.real(value)?,
            Ex::Float(operation, width, operands) => {
                let a = self.real(&operands.0)?;
                let b = self.real(&operands.1)?;
                round(self.operate_real(*operation, a, b), *width)
            }
            Ex::Function(function, width, operand) => {
                let x = self.real(operand)?;
                let result = match function {
                    Function::Absolute => x.abs(),
                    Function::Sine => libm::sin(x),
                    Function::Cosine => libm::cos(x),
                    Function::Tangent => libm::tan(x),
                    Function::ArcSine => libm::asin(x),
                    Function::ArcCosine => libm::acos(x),
                    Function::ArcTangent => libm::atan(x),
                    Function::Ln => libm::log(x),
                    Function::Log => libm::log10(x),
                    Function::Degrees => x * 180.0 / std::f64::consts::PI,
                    Function::Radians => x * std::f64::consts::PI / 180.0,
                    Function::Root => libm::sqrt(x.abs()),
                    Function::Truncate => x.trunc(),
                    Function::AbsoluteWhole | Function::ToBcd | Function::FromBcd => self.whole(value)? as f64,
                };
                round(result, *width)
            }
            whole => self.whole(whole)? as f64,
        })
    }

    pub(crate) fn status(&self, status: Status) -> bool {
        match status {
            Status::FirstScan => self.s.first_scan,
            Status::Overflow => self.s.overflow,
            Status::Zero => self.s.zero,
            Status::Negative => self.s.negative,
            Status::Carry => self.s.carry,
            Status::Minor => self.s.minor,
        }
    }

    fn set_status(&mut self, status: Status, on: bool) {
        match status {
            Status::FirstScan => self.s.first_scan = on,
            Status::Overflow => self.s.overflow = on,
            Status::Zero => self.s.zero = on,
            Status::Negative => self.s.negative = on,
            Status::Carry => self.s.carry = on,
            Status::Minor => self.s.minor = on,
        }
    }

    fn bcd_of(&mut self, value: i64) -> i64 {
        if !(0..=99_999_999).contains(&value) {
            self.s.overflow = true;
            self.counted_minor();
        }
        let (mut rest, mut bcd) = (value.unsigned_abs(), 0);
        for place in 0..8 {
            bcd |= ((rest % 10) as i64) << (4 * place);
            rest /= 10;
        }
        bcd
    }

    /// The part of a text that counts: first byte and end, in the memory or in the literal.
    pub(crate) fn text_range(&mut self, text: &TextPart) -> Run<(usize, usize)> {
        match text {
            TextPart::Literal(bytes) => Ok((0, bytes.len())),
            TextPart::Tag { place, data, capacity } => {
                let at = self.address(place)?;
                let length = u32::try_from(self.dint(at)).unwrap_or(0).min(*capacity);
                let from = (at + data) as usize;
                Ok((from, from + length as usize))
            }
        }
    }

    pub(crate) fn text_slice<'a>(&'a self, text: &'a TextPart, from: usize, to: usize) -> &'a [u8] {
        let bytes: &[u8] = match text {
            TextPart::Literal(bytes) => bytes,
            TextPart::Tag { .. } => &self.s.memory,
        };
        bytes.get(from..to).unwrap_or_default()
    }

    /// The flags of a value that an instruction of ladder has stored.
    pub(crate) fn flags(&mut self, value: Number) {
        (self.s.zero, self.s.negative) = match value {
            Number::Whole(value) => (value == 0, value < 0),
            Number::Real(value) => (value == 0.0, value < 0.0),
        };
        if self.s.overflow && !self.s.is_counted {
            self.minor();
        }
    }

    /// A minor fault in arithmetic, after which the overflow of its result is none.
    fn counted_minor(&mut self) {
        self.minor();
        self.s.is_counted = true;
    }

    pub(crate) fn begin_arithmetic(&mut self) {
        (self.s.overflow, self.s.is_counted) = (false, false);
    }

    pub(crate) fn set_carry(&mut self, carry: bool) {
        self.s.carry = carry;
    }

    pub(crate) fn set_overflow(&mut self) {
        self.s.overflow = true;
    }

    /// The fault of an area or address that lies outside of the memory.
    pub(crate) fn outside(&mut self) -> Exit {
        self.fault(4, 20, None)
    }
}

fn round(value: f64, width: Width) -> f64 {
    match width {
        Width::Single => f64::from(value as f32),
        Width::Double => value,
    }
}

pub(super) fn holds(compare: Compare, order: std::cmp::Ordering) -> bool {
    match compare {
        Compare::Less => order.is_lt(),
        Compare::LessEqual => order.is_le(),
        Compare::Greater => order.is_gt(),
        Compare::GreaterEqual => order.is_ge(),
        Compare::Equal => order.is_eq(),
        Compare::NotEqual => order.is_ne(),
    }
}

/// The same of two numbers with a point; one that is none is not equal to any.
pub(super) fn holds_real(compare: Compare, a: f64, b: f64) -> bool {
    match a.partial_cmp(&b) {
        Some(order) => holds(compare, order),
        None => compare == Compare::NotEqual,
    }
}

fn from_bcd(value: i64) -> i64 {
    (0..8)
        .rev()
        .fold(0, |number, place| number * 10 + (value >> (4 * place) & 0xF))
}
