//! Restrictions of a configured tag for writers, besides its access: a least role, and a range of its numbers (spec/security.md §6).

use arcline_tag::{DataType, Elementary, Value};

use super::{Image, TagId, WriteError};

/// The clients that may write a tag.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum Writers {
    /// All clients that may write tags.
    #[default]
    Operators,
    /// Engineers and administrators.
    Engineers,
    /// Administrators only.
    Administrators,
}

/// The rule of a tag.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct WriteRule {
    /// The clients that may write it; the user of the image enforces this.
    pub writers: Writers,
    /// The range of its number, or of the elements of its array; the image refuses other numbers.
    pub range: Option<NumberRange>,
}

/// A range of numbers, both ends included.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct NumberRange {
    /// The least number; −∞: unlimited.
    pub least: f64,
    /// The largest number; ∞: unlimited.
    pub most: f64,
}

impl NumberRange {
    /// The range contains a number. It never contains NaN. Integers are compared as integers.
    pub fn holds(&self, value: Value) -> bool {
        match value.to_whole() {
            // The casts saturate for numbers beyond the type.
            Some(whole) => (self.least.ceil() as i128..=self.most.floor() as i128).contains(&whole),
            None => (self.least..=self.most).contains(&value.as_f64()),
        }
    }

    /// The type is a number and can have a range.
    pub fn is_of(kind: Elementary) -> bool {
        use Elementary::{Bool, Byte, Dword, Lword, Word};
        !matches!(kind, Bool | Byte | Word | Dword | Lword)
    }
}

impl std::fmt::Display for NumberRange {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match (self.least.is_finite(), self.most.is_finite()) {
            (true, false) => write!(f, "at least {}", self.least),
            (false, _) => write!(f, "at most {}", self.most),
            (true, true) => write!(f, "{} to {}", self.least, self.most),
        }
    }
}

impl Image {
    /// Checks that the range of a tag permits new bytes.
    ///
    /// # Errors
    /// [`WriteError::OutsideRange`] with the first element outside of the range.
    pub(super) fn check_range(&self, id: TagId, offset: usize, data: &[u8]) -> Result<(), WriteError> {
        let Some(tag) = self.tag(id) else { return Ok(()) };
        let (Some(range), DataType::Elementary(kind)) = (tag.rule.range, &tag.tag_type.data_type) else {
            return Ok(());
        };
        let size = kind.size();
        for index in offset / size..(offset + data.len()).div_ceil(size) {
            let mut bytes = [0; 8];
            let (element, from) = (&mut bytes[..size], index * size);
            if let Some(before) = self.bytes(id).get(from..from + size) {
                element.copy_from_slice(before);
            }
            for (at, byte) in element.iter_mut().enumerate() {
                if let Some(new) = (from + at).checked_sub(offset).and_then(|index| data.get(index)) {
                    *byte = *new;
                }
            }
            let value = Value::read(*kind, element).filter(|value| !range.holds(*value));
            if let Some(value) = value {
                return Err(WriteError::OutsideRange {
                    name: match tag.tag_type.rank() {
                        0 => tag.name.clone(),
                        _ => format!("{}, element {index}", tag.name),
                    },
                    value: value.as_f64(),
                    range: range.to_string(),
                });
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn integers_are_compared_as_integers() {
        let whole = |least: f64, most: f64| NumberRange { least, most };
        #[rustfmt::skip]
        let cases = [
            ("inside",                 whole(-5.0, 5.0),                 Value::Dint(5),               true),
            ("above",                  whole(-5.0, 5.0),                 Value::Dint(6),               false),
            ("without a least",        whole(f64::NEG_INFINITY, 5.0),    Value::Lint(i64::MIN),        true),
            ("without a most",         whole(0.0, f64::INFINITY),        Value::Ulint(u64::MAX),       true),
            ("one beyond 2^53",        whole(0.0, 9_007_199_254_740_992.0), Value::Lint(9_007_199_254_740_993), false),
            ("a real at the end",      whole(0.0, f64::from(0.1_f32)),   Value::Real(0.1),             true),
            ("no number",              whole(f64::NEG_INFINITY, f64::INFINITY), Value::Real(f32::NAN), false),
            ("an infinite one",        whole(f64::NEG_INFINITY, 1.0),    Value::Lreal(f64::NEG_INFINITY), true),
            ("minus zero",             whole(0.0, 1.0),                  Value::Lreal(-0.0),           true),
        ];
        for (why, range, value, expected) in cases {
            assert_eq!(range.holds(value), expected, "{why}: {value} in {range}");
        }
    }
}
