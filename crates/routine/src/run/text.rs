//! Instructions of texts (spec/programs.md §10.7). Positions count from 1.

use super::Number;
use super::{Run, Scan};
use crate::code::{Argument, TextPart};
use crate::table::Op;

/// Longest text of a result that is put together; longer types of texts keep their first characters.
const BUFFER: usize = 1024;

/// A text that is put together without allocation.
struct Buffer {
    bytes: [u8; BUFFER],
    length: usize,
    is_cut: bool,
}

impl Buffer {
    fn new() -> Self {
        Buffer {
            bytes: [0; BUFFER],
            length: 0,
            is_cut: false,
        }
    }

    fn push(&mut self, text: &[u8]) {
        for byte in text {
            match self.bytes.get_mut(self.length) {
                Some(place) => {
                    *place = *byte;
                    self.length += 1;
                }
                None => self.is_cut = true,
            }
        }
    }
}

impl std::fmt::Write for Buffer {
    fn write_str(&mut self, text: &str) -> std::fmt::Result {
        self.push(text.as_bytes());
        Ok(())
    }
}

impl Scan<'_> {
    pub(crate) fn text(&mut self, op: Op, arguments: &[Argument]) -> Run<()> {
        let mut buffer = Buffer::new();
        match (op, arguments) {
            (Op::Concat, [Argument::Text(a), Argument::Text(b), Argument::Text(to)]) => {
                self.append(a, &mut buffer, |_| true)?;
                self.append(b, &mut buffer, |_| true)?;
                self.put_text(to, &buffer)
            }
            (Op::Mid, [Argument::Text(from), count, start, Argument::Text(to)]) => {
                let Some((start, count)) = self.part(from, count, start)? else {
                    return Ok(());
                };
                self.append(from, &mut buffer, |at| at >= start && at < start + count)?;
                self.put_text(to, &buffer)
            }
            (Op::Delete, [Argument::Text(from), count, start, Argument::Text(to)]) => {
                let Some((start, count)) = self.part(from, count, start)? else {
                    return Ok(());
                };
                self.append(from, &mut buffer, |at| at < start || at >= start + count)?;
                self.put_text(to, &buffer)
            }
            (Op::Insert, [Argument::Text(a), Argument::Text(b), start, Argument::Text(to)]) => {
                let start = self.argument_whole(start)?;
                let (from, end) = self.text_range(a)?;
                let length = (end - from) as i64;
                if start < 1 || start > length + 1 {
                    self.text_fault();
                    return Ok(());
                }
                let start = start as usize;
                self.append(a, &mut buffer, |at| at < start)?;
                self.append(b, &mut buffer, |_| true)?;
                self.append(a, &mut buffer, |at| at >= start)?;
                self.put_text(to, &buffer)
            }
            (Op::Find, [Argument::Text(from), Argument::Text(search), start, result]) => {
                let start = usize::try_from(self.argument_whole(start)?).unwrap_or(0).max(1);
                let (a, a_end) = self.text_range(from)?;
                let (b, b_end) = self.text_range(search)?;
                let text = self.text_slice(from, a, a_end);
                let wanted = self.text_slice(search, b, b_end);
                let found =
                    (start - 1..text.len()).find(|at| text.get(*at..).is_some_and(|rest| rest.starts_with(wanted)));
                let found = found.filter(|_| !wanted.is_empty()).map_or(0, |at| at as i64 + 1);
                self.assign(result, Number::Whole(found))
            }
            (Op::Dtos, [value, Argument::Text(to)]) => {
                use std::fmt::Write as _;
                let value = self.argument_whole(value)?;
                let _ = write!(buffer, "{value}");
                self.put_text(to, &buffer)
            }
            (Op::Rtos, [value, Argument::Text(to)]) => {
                let value = self.argument(value)?.real();
                write_real(value, &mut buffer);
                self.put_text(to, &buffer)
            }
            (Op::Stod, [Argument::Text(from), target]) => {
                let (a, end) = self.text_range(from)?;
                let value = digits(self.text_slice(from, a, end));
                self.begin_arithmetic();
                self.assign(target, Number::Whole(value))?;
                self.flags(Number::Whole(value));
                Ok(())
            }
            (Op::Stor, [Argument::Text(from), target]) => {
                let (a, end) = self.text_range(from)?;
                let value = first_real(self.text_slice(from, a, end));
                self.begin_arithmetic();
                self.assign(target, Number::Real(value))?;
                self.flags(Number::Real(value));
                Ok(())
            }
            (Op::Upper | Op::Lower, [Argument::Text(from), Argument::Text(to)]) => {
                self.append(from, &mut buffer, |_| true)?;
                let bytes = buffer.bytes.iter_mut().take(buffer.length);
                bytes.for_each(|byte| {
                    *byte = if op == Op::Upper {
                        byte.to_ascii_uppercase()
                    } else {
                        byte.to_ascii_lowercase()
                    };
                });
                self.put_text(to, &buffer)
            }
            _ => Err(self.unknown()),
        }
    }

    /// Writes characters to a text; those that it has no room for are left out, with a minor fault.
    pub(crate) fn put_characters(&mut self, to: &TextPart, characters: &[u8]) -> Run<()> {
        let mut buffer = Buffer::new();
        buffer.push(characters);
        self.put_text(to, &buffer)
    }

    /// MOV of a text.
    pub(crate) fn copy_text(&mut self, from: &TextPart, to: &TextPart) -> Run<()> {
        let mut buffer = Buffer::new();
        self.append(from, &mut buffer, |_| true)?;
        self.put_text(to, &buffer)
    }

    /// Start and count of a part of a text; `None`: it is outside.
    fn part(&mut self, from: &TextPart, count: &Argument, start: &Argument) -> Run<Option<(usize, usize)>> {
        let (count, start) = (self.argument_whole(count)?, self.argument_whole(start)?);
        let (begin, end) = self.text_range(from)?;
        let capacity = match from {
            TextPart::Tag { capacity, .. } => *capacity as usize,
            TextPart::Literal(_) => end - begin,
        };
        match (usize::try_from(start), usize::try_from(count)) {
            (Ok(start), Ok(count)) if start >= 1 && start <= capacity && start - 1 + count <= capacity => {
                Ok(Some((start, count)))
            }
            _ => {
                self.text_fault();
                Ok(None)
            }
        }
    }

    fn append(&mut self, from: &TextPart, buffer: &mut Buffer, takes: impl Fn(usize) -> bool) -> Run<()> {
        let (begin, end) = self.text_range(from)?;
        let text = self.text_slice(from, begin, end);
        for (place, byte) in (1..).zip(text) {
            if takes(place) {
                buffer.push(&[*byte]);
            }
        }
        Ok(())
    }

    fn put_text(&mut self, to: &TextPart, buffer: &Buffer) -> Run<()> {
        let TextPart::Tag { place, data, capacity } = to else {
            return Ok(());
        };
        let at = self.address(place)?;
        let length = buffer.length.min(*capacity as usize);
        let from = (at + data) as usize;
        self.s
            .memory
            .write(from, buffer.bytes.get(..length).unwrap_or_default());
        self.put_dint(at, length as i32);
        self.begin_arithmetic();
        if length < buffer.length || buffer.is_cut {
            self.text_fault();
        }
        Ok(())
    }

    /// A minor fault of a text: S:V and S:MINOR.
    fn text_fault(&mut self) {
        self.set_overflow();
        self.minor();
    }
}

/// The first group of digits, with the minus before it.
fn digits(text: &[u8]) -> i64 {
    let Some(first) = text.iter().position(u8::is_ascii_digit) else {
        return 0;
    };
    let is_negative = first > 0 && text.get(first - 1) == Some(&b'-');
    let group = text.iter().skip(first).take_while(|byte| byte.is_ascii_digit());
    let value = group.fold(0_i64, |value, byte| {
        value.saturating_mul(10).saturating_add(i64::from(byte - b'0'))
    });
    if is_negative { -value } else { value }
}

fn first_real(text: &[u8]) -> f64 {
    let Some(first) = text.iter().position(u8::is_ascii_digit) else {
        return 0.0;
    };
    let start = if first > 0 && text.get(first - 1) == Some(&b'-') {
        first - 1
    } else {
        first
    };
    let rest = text.get(start..).unwrap_or_default();
    let fits = |byte: &&u8| byte.is_ascii_digit() || matches!(byte, b'-' | b'+' | b'.' | b'e' | b'E');
    let length = rest.iter().take_while(fits).count();
    (1..=length)
        .rev()
        .find_map(|end| std::str::from_utf8(rest.get(..end)?).ok()?.parse().ok())
        .unwrap_or(0.0)
}

/// Nine significant digits at most, as `%.9g` of C.
fn write_real(value: f64, buffer: &mut Buffer) {
    use std::fmt::Write as _;
    if !value.is_finite() {
        buffer.push(if value.is_nan() {
            b"1.#QNAN"
        } else if value > 0.0 {
            b"1.$"
        } else {
            b"-1.$"
        });
        return;
    }
    if value == 0.0 {
        buffer.push(b"0");
        return;
    }
    let mut scientific = Buffer::new();
    let _ = write!(scientific, "{value:.8e}");
    let text = scientific
        .bytes
        .get(..scientific.length)
        .and_then(|bytes| std::str::from_utf8(bytes).ok());
    let Some((mantissa, exponent)) = text.and_then(|text| text.split_once('e')) else {
        return;
    };
    let exponent: i32 = exponent.parse().unwrap_or(0);
    let mut plain = Buffer::new();
    if (-4..9).contains(&exponent) {
        let decimals = (8 - exponent).max(0) as usize;
        let _ = write!(plain, "{value:.decimals$}");
    } else {
        plain.push(mantissa.as_bytes());
    }
    let mut digits = plain.bytes.get(..plain.length).unwrap_or_default();
    if digits.contains(&b'.') {
        while let [rest @ .., b'0'] = digits {
            digits = rest;
        }
        if let [rest @ .., b'.'] = digits {
            digits = rest;
        }
    }
    buffer.push(digits);
    if !(-4..9).contains(&exponent) {
        let _ = write!(buffer, "e{}{:02}", if exponent < 0 { '-' } else { '+' }, exponent.abs());
    }
}
