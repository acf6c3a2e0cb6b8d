//! One shots, limits, and results of routines.

use super::Number;
use super::counters::member_bit;
use super::{Run, Scan};
use crate::code::Argument;
use crate::table::Op;

impl Scan<'_> {
    /// ONS, OSR, OSF, OSRI, OSFI.
    pub(crate) fn one_shot(&mut self, op: Op, arguments: &[Argument], power: bool) -> Run<bool> {
        let prescan = self.s.prescan;
        match (op, arguments) {
            (Op::Ons, [Argument::Bit(storage)]) => {
                let (at, mask) = self.bit_at(storage)?;
                Ok(self.one_shot_rising(at, mask, power))
            }
            (Op::Osr | Op::Osf, [Argument::Bit(storage), Argument::Bit(output)]) => {
                let (at, mask) = self.bit_at(storage)?;
                let (out, out_mask) = self.bit_at(output)?;
                let was = self.has(at, mask);
                let rising = op == Op::Osr;
                self.set(at, mask, if prescan { rising } else { power });
                let edge = !prescan && if rising { power && !was } else { !power && was };
                self.set(out, out_mask, edge);
                Ok(power)
            }
            (Op::Osri | Op::Osfi, [Argument::Area(area)]) => {
                let base = self.address(&area.place)?;
                let bits = ["InputBit", "OutputBit", "(Last)"].map(|name| member_bit(area, base, name));
                let [Some(input), Some(output), Some(last)] = bits else {
                    return Ok(power);
                };
                let now = self.has(input.0, input.1);
                let was = self.has(last.0, last.1);
                let rising = op == Op::Osri;
                let edge = !prescan && if rising { now && !was } else { !now && was };
                self.set(output.0, output.1, edge);
                self.set(last.0, last.1, if prescan { rising } else { now });
                Ok(power)
            }
            _ => Err(self.unknown()),
        }
    }

    /// ONS with its storage bit.
    pub(crate) fn one_shot_rising(&mut self, at: u32, mask: u8, power: bool) -> bool {
        let prescan = self.s.prescan;
        let was = self.has(at, mask);
        self.set(at, mask, power || prescan);
        power && !was && !prescan
    }

    /// LIM and MEQ.
    pub(crate) fn limit(&mut self, op: Op, arguments: &[Argument]) -> Run<bool> {
        let [a, b, c] = arguments else {
            return Err(self.unknown());
        };
        if op == Op::Meq {
            let (source, mask, compare) = (
                self.argument_whole(a)?,
                self.argument_whole(b)?,
                self.argument_whole(c)?,
            );
            return Ok(source & mask == compare & mask);
        }
        let values = [self.argument(a)?, self.argument(b)?, self.argument(c)?];
        if let [Number::Whole(low), Number::Whole(test), Number::Whole(high)] = values {
            return Ok(if low <= high {
                low <= test && test <= high
            } else {
                test >= low || test <= high
            });
        }
        let [low, test, high] = values.map(Number::real);
        Ok(if low <= high {
            low <= test && test <= high
        } else {
            test >= low || test <= high
        })
    }

    /// RET: gives values to the tags of the call.
    pub(crate) fn give(&mut self, values: &[Argument]) -> Run<()> {
        let Some(caller) = self.caller else { return Ok(()) };
        if caller.returns.len() > values.len() {
            return Err(self.fault(4, 31, None));
        }
        for (from, to) in values.iter().zip(&caller.returns) {
            self.copy_value(from, to)?;
        }
        Ok(())
    }
}

impl Number {
    /// As a number with a point.
    pub(crate) fn real(self) -> f64 {
        match self {
            Number::Whole(value) => value as f64,
            Number::Real(value) => value,
        }
    }
}
