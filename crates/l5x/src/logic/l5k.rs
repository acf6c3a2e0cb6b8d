//! Values of the format L5K: numbers, texts in quotes, and lists of them between brackets, `[1,[2,'ab$00'],16#ff]`.

use arcline_routine::source::Datum;

use crate::document::shortened;
use crate::text;

/// The value of a text.
pub(super) fn value(text: &str) -> Datum {
    let mut reader = Reader { text, at: 0 };
    match reader.value(0).filter(|_| reader.rest().is_empty()) {
        Some(value) => value,
        None => Datum::Unread(shortened(text.trim())),
    }
}

struct Reader<'t> {
    text: &'t str,
    at: usize,
}

impl<'t> Reader<'t> {
    /// The text behind blanks.
    fn rest(&mut self) -> &'t str {
        let rest = self.text.get(self.at..).unwrap_or_default();
        let trimmed = rest.trim_start();
        self.at += rest.len() - trimmed.len();
        trimmed
    }

    fn take(&mut self, token: char) -> bool {
        let is_there = self.rest().starts_with(token);
        self.at += if is_there { token.len_utf8() } else { 0 };
        is_there
    }

    fn value(&mut self, depth: usize) -> Option<Datum> {
        if self.take('[') {
            return if depth < MAX_DEPTH { self.list(depth + 1) } else { None };
        }
        let rest = self.rest();
        if rest.starts_with('\'') {
            let end = quoted(rest)?;
            self.at += end;
            return text::string(rest.get(..end)?).map(Datum::Text);
        }
        let end = rest.find([',', ']', '[', '\'']).unwrap_or(rest.len());
        let number = rest.get(..end)?.trim_end();
        self.at += end;
        (!number.is_empty()).then(|| Datum::Number(number.to_owned()))
    }

    fn list(&mut self, depth: usize) -> Option<Datum> {
        let mut items = Vec::new();
        if self.take(']') {
            return Some(Datum::Array(items));
        }
        loop {
            items.push(self.value(depth)?);
            if self.take(']') {
                return Some(Datum::Array(items));
            }
            if !self.take(',') {
                return None;
            }
        }
    }
}

/// Bytes of a text in quotes at the beginning, both quotes among them.
fn quoted(text: &str) -> Option<usize> {
    let mut bytes = text.bytes().enumerate().skip(1);
    while let Some((at, byte)) = bytes.next() {
        match byte {
            b'\'' => return Some(at + 1),
            b'$' => {
                bytes.next()?;
            }
            _ => {}
        }
    }
    None
}

/// Lists within one another.
const MAX_DEPTH: usize = 64;
