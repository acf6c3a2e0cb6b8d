//! Arithmetic, moves and copies (spec/programs.md §10.4).

use arcline_tag::{DataType, Elementary};

use super::Number;
use super::counters::member;
use super::value::Range;
use super::{Run, Scan};
use crate::code::{Area, Argument, Cellular, Ex, TextPart};
use crate::table::Op;

impl Scan<'_> {
    /// Stores a value, with its flags; `rest` has the operands whose carry the project reads.
    pub(crate) fn compute(&mut self, value: &Argument, target: &Argument, rest: &[Argument]) -> Run<()> {
        self.begin_arithmetic();
        if let [a, b, Argument::Word(is_subtraction)] = rest {
            let (a, b) = (self.argument_whole(a)? as u32, self.argument_whole(b)? as u32);
            self.set_carry(if *is_subtraction != 0 {
                a < b
            } else {
                a.checked_add(b).is_none()
            });
        }
        let value = self.argument(value)?;
        self.assign(target, value)?;
        if let [Argument::Word(_)] = rest {
            self.begin_arithmetic();
        }
        let stored = match target {
            Argument::Target(cell) => {
                let at = self.address(&cell.place)?;
                self.read(at, cell.kind)
            }
            _ => value,
        };
        self.flags(stored);
        Ok(())
    }

    pub(crate) fn move_data(&mut self, op: Op, arguments: &[Argument]) -> Run<()> {
        match (op, arguments) {
            (Op::Mov, [Argument::Text(from), Argument::Text(to)]) => self.copy_text(from, to),
            (Op::Mov, [value, target]) => self.compute(value, target, &[]),
            (Op::Clr, [target]) => {
                self.begin_arithmetic();
                self.assign(target, Number::Whole(0))?;
                self.flags(Number::Whole(0));
                Ok(())
            }
            (Op::Mvm, [source, mask, target]) => {
                let (source, mask) = (self.argument_whole(source)?, self.argument_whole(mask)?);
                let before = self.argument_whole(target)?;
                let value = Number::Whole((source & mask) | (before & !mask));
                self.put_bits(target, value)?;
                self.begin_arithmetic();
                self.flags(value);
                Ok(())
            }
            (Op::Btd, [source, from, target, to, length]) => {
                let source = self.argument_whole(source)?;
                let [from, to, length] = [from, to, length].map(|one| self.argument_whole(one));
                let before = self.argument_whole(target)?;
                let value = field(source, from?, before, to?, length?);
                self.put_bits(target, Number::Whole(value))
            }
            (Op::Swpb, [source, Argument::Word(mode), target]) => self.swap(source, *mode, target),
            (Op::Cop, [from, to, length]) => {
                let length = self.argument_whole(length)?;
                self.copy_file(from, to, length)
            }
            (Op::Fll, [value, Argument::Area(to), length]) => {
                let length = self.argument_whole(length)?;
                self.fill(value, to, length)
            }
            (Op::Size, [Argument::Area(area), dimension, target]) => {
                let dimension = self.argument_whole(dimension)?;
                let (_, dimensions) = self.shape(area);
                let size = match crate::types::text_layout(&area.data_type) {
                    Some((_, capacity)) if dimensions[0] == 0 => capacity,
                    _ => usize::try_from(dimension)
                        .ok()
                        .and_then(|at| dimensions.get(at))
                        .copied()
                        .unwrap_or(0),
                };
                // Words of BOOLs count as bits.
                let is_bits = area.data_type == DataType::Elementary(Elementary::Dword);
                let size = if is_bits { size * 32 } else { size };
                self.assign(target, Number::Whole(i64::from(size)))
            }
            (Op::Mvmt | Op::Btdt, [Argument::Area(area)]) => self.move_with_target(op, area),
            _ => Err(self.unknown()),
        }
    }

    /// Writes bits: no overflow, whatever the sign.
    fn put_bits(&mut self, target: &Argument, value: Number) -> Run<()> {
        self.assign(target, value)?;
        self.begin_arithmetic();
        Ok(())
    }

    fn move_with_target(&mut self, op: Op, area: &Area) -> Run<()> {
        let at = self.address(&area.place)?;
        let read = |scan: &Self, name: &str| member(area, at, name).map_or(0, |at| i64::from(scan.dint(at)));
        let (source, target) = (read(self, "Source"), read(self, "Target"));
        let value = if op == Op::Mvmt {
            let mask = read(self, "Mask");
            (source & mask) | (target & !mask)
        } else {
            field(
                source,
                read(self, "SourceBit"),
                target,
                read(self, "DestBit"),
                read(self, "Length"),
            )
        };
        if let Some(dest) = member(area, at, "Dest") {
            self.put_dint(dest, value as i32);
        }
        Ok(())
    }

    fn swap(&mut self, source: &Argument, mode: i32, target: &Argument) -> Run<()> {
        let value = self.argument_whole(source)?;
        let Argument::Target(Cellular { kind, .. }) = target else {
            return Err(self.unknown());
        };
        let swapped = if kind.size() == 2 {
            i64::from((value as i16).swap_bytes())
        } else {
            let value = value as u32;
            let swapped = match mode {
                0 => value.swap_bytes(),
                1 => value.rotate_left(16),
                _ => (value & 0xFF00_FF00) >> 8 | (value & 0x00FF_00FF) << 8,
            };
            i64::from(swapped as i32)
        };
        self.begin_arithmetic();
        self.assign(target, Number::Whole(swapped))?;
        self.flags(Number::Whole(swapped));
        Ok(())
    }

    /// COP: elements of the destination, straight from the bytes of the source.
    fn copy_file(&mut self, from: &Argument, to: &Argument, length: i64) -> Run<()> {
        let Argument::Area(area) = to else {
            return Err(self.unknown());
        };
        let Range { at, array_end, end } = self.range(area)?;
        // A structure in a structure is written on into the members behind it.
        let end = if self.shape(area).0 > 1 { array_end } else { end };
        let wanted = u32::try_from(length)
            .unwrap_or(0)
            .saturating_mul(area.size)
            .min(end - at);
        match from {
            Argument::Area(area) => {
                let source = self.range(area)?;
                self.copy_bytes(source.at, at, wanted.min(source.end - source.at))
            }
            Argument::Text(TextPart::Literal(bytes)) => {
                for (place, byte) in (at..at + wanted).zip(bytes.iter()) {
                    self.put(place, [*byte]);
                }
                Ok(())
            }
            other => {
                // A number that is written out has the bytes of its type.
                let bytes = match self.argument(other)? {
                    Number::Whole(value) => (value as i32).to_le_bytes(),
                    Number::Real(value) => (value as f32).to_le_bytes(),
                };
                for (place, byte) in (at..at + wanted).zip(bytes) {
                    self.put(place, [byte]);
                }
                Ok(())
            }
        }
    }

    fn fill(&mut self, value: &Argument, to: &Area, length: i64) -> Run<()> {
        let range = self.range(to)?;
        let end = if self.shape(to).0 > 1 {
            range.array_end
        } else {
            range.end
        };
        let size = to.size.max(1);
        let count = u32::try_from(length).unwrap_or(0).min((end - range.at) / size);
        match (&to.data_type, value) {
            (DataType::Elementary(kind), value) if !matches!(value, Argument::Area(_) | Argument::Text(_)) => {
                let value = self.argument(value)?;
                for element in 0..count {
                    self.write(range.at + element * size, *kind, value);
                }
                self.begin_arithmetic();
                Ok(())
            }
            (DataType::Elementary(kind), Argument::Area(from)) => {
                let source = self.range(from)?;
                let DataType::Elementary(of) = from.data_type else {
                    return Err(self.unknown());
                };
                let value = self.read(source.at, of);
                for element in 0..count {
                    self.write(range.at + element * size, *kind, value);
                }
                self.begin_arithmetic();
                Ok(())
            }
            (_, Argument::Area(from)) => {
                let source = self.range(from)?;
                let bytes = size.min(from.size);
                for element in 0..count {
                    self.copy_bytes(source.at, range.at + element * size, bytes)?;
                }
                Ok(())
            }
            (DataType::Structure(_), value) => {
                // The bytes of a number, in its type, again and again.
                let width = match value {
                    Argument::Integer(Ex::Load(cell)) | Argument::Real(Ex::Load(cell)) => cell.kind.size(),
                    _ => 4,
                };
                let bytes = match self.argument(value)? {
                    Number::Whole(value) => value.to_le_bytes(),
                    Number::Real(value) if width == 8 => value.to_le_bytes(),
                    Number::Real(value) => u64::from((value as f32).to_bits()).to_le_bytes(),
                };
                let to = (range.at + count * size) as usize;
                for (at, byte) in (range.at as usize..to).zip(bytes.iter().take(width).cycle()) {
                    self.s.memory.put(at, [*byte]);
                }
                Ok(())
            }
            _ => Err(self.unknown()),
        }
    }
}

/// A value with a field of another one put into it; bits beyond the end are lost.
fn field(source: i64, from: i64, target: i64, to: i64, length: i64) -> i64 {
    let shift = |value: i64| u32::try_from(value).unwrap_or(64).min(64);
    let mask = if length >= 64 {
        u64::MAX
    } else {
        (1_u64 << length.max(0)) - 1
    };
    let bits = (source as u64).checked_shr(shift(from)).unwrap_or(0) & mask;
    let place = mask.checked_shl(shift(to)).unwrap_or(0);
    let bits = bits.checked_shl(shift(to)).unwrap_or(0);
    (target as u64 & !place | bits) as i64
}
