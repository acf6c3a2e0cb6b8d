//! Values of elementary types and their conversion (spec/axis-and-data-types.md §13).
//!
//! Numbers convert as on a Logix controller: a real becomes an integer by rounding to nearest, ties to even;
//! an integer that is too large loses its upper bits. Nothing here fails for a number of any size.

use crate::Elementary;

/// A value of an elementary type.
#[derive(Clone, Copy, PartialEq, Debug)]
#[allow(missing_docs)] // the variants are those of `Elementary`
pub enum Value {
    Bool(bool),
    Sint(i8),
    Int(i16),
    Dint(i32),
    Lint(i64),
    Usint(u8),
    Uint(u16),
    Udint(u32),
    Ulint(u64),
    Real(f32),
    Lreal(f64),
    Byte(u8),
    Word(u16),
    Dword(u32),
    Lword(u64),
}

impl Value {
    /// The type of the value.
    pub fn elementary(self) -> Elementary {
        match self {
            Self::Bool(_) => Elementary::Bool,
            Self::Sint(_) => Elementary::Sint,
            Self::Int(_) => Elementary::Int,
            Self::Dint(_) => Elementary::Dint,
            Self::Lint(_) => Elementary::Lint,
            Self::Usint(_) => Elementary::Usint,
            Self::Uint(_) => Elementary::Uint,
            Self::Udint(_) => Elementary::Udint,
            Self::Ulint(_) => Elementary::Ulint,
            Self::Real(_) => Elementary::Real,
            Self::Lreal(_) => Elementary::Lreal,
            Self::Byte(_) => Elementary::Byte,
            Self::Word(_) => Elementary::Word,
            Self::Dword(_) => Elementary::Dword,
            Self::Lword(_) => Elementary::Lword,
        }
    }

    /// Reads a value from the front of little-endian `bytes`; `None` when there are too few.
    /// A BOOL is true when its byte is not 0.
    pub fn read(elementary: Elementary, bytes: &[u8]) -> Option<Value> {
        Some(match elementary {
            Elementary::Bool => Self::Bool(*bytes.first()? != 0),
            Elementary::Sint => Self::Sint(i8::from_le_bytes(*bytes.first_chunk()?)),
            Elementary::Int => Self::Int(i16::from_le_bytes(*bytes.first_chunk()?)),
            Elementary::Dint => Self::Dint(i32::from_le_bytes(*bytes.first_chunk()?)),
            Elementary::Lint => Self::Lint(i64::from_le_bytes(*bytes.first_chunk()?)),
            Elementary::Usint => Self::Usint(*bytes.first()?),
            Elementary::Uint => Self::Uint(u16::from_le_bytes(*bytes.first_chunk()?)),
            Elementary::Udint => Self::Udint(u32::from_le_bytes(*bytes.first_chunk()?)),
            Elementary::Ulint => Self::Ulint(u64::from_le_bytes(*bytes.first_chunk()?)),
            Elementary::Real => Self::Real(f32::from_le_bytes(*bytes.first_chunk()?)),
            Elementary::Lreal => Self::Lreal(f64::from_le_bytes(*bytes.first_chunk()?)),
            Elementary::Byte => Self::Byte(*bytes.first()?),
            Elementary::Word => Self::Word(u16::from_le_bytes(*bytes.first_chunk()?)),
            Elementary::Dword => Self::Dword(u32::from_le_bytes(*bytes.first_chunk()?)),
            Elementary::Lword => Self::Lword(u64::from_le_bytes(*bytes.first_chunk()?)),
        })
    }

    /// Writes the value to the front of `bytes`, little-endian; `None`, and nothing written, when it does not fit.
    /// A true BOOL is written as 1.
    pub fn write(self, bytes: &mut [u8]) -> Option<()> {
        fn put<const N: usize>(bytes: &mut [u8], value: [u8; N]) -> Option<()> {
            *bytes.first_chunk_mut()? = value;
            Some(())
        }
        match self {
            Self::Bool(v) => put(bytes, [u8::from(v)]),
            Self::Sint(v) => put(bytes, v.to_le_bytes()),
            Self::Int(v) => put(bytes, v.to_le_bytes()),
            Self::Dint(v) => put(bytes, v.to_le_bytes()),
            Self::Lint(v) => put(bytes, v.to_le_bytes()),
            Self::Usint(v) | Self::Byte(v) => put(bytes, [v]),
            Self::Uint(v) | Self::Word(v) => put(bytes, v.to_le_bytes()),
            Self::Udint(v) | Self::Dword(v) => put(bytes, v.to_le_bytes()),
            Self::Ulint(v) | Self::Lword(v) => put(bytes, v.to_le_bytes()),
            Self::Real(v) => put(bytes, v.to_le_bytes()),
            Self::Lreal(v) => put(bytes, v.to_le_bytes()),
        }
    }

    /// The value as a 64-bit float. A BOOL is 0 or 1; integers beyond 2^53 lose their low digits.
    pub fn as_f64(self) -> f64 {
        match self {
            Self::Bool(v) => f64::from(u8::from(v)),
            Self::Sint(v) => f64::from(v),
            Self::Int(v) => f64::from(v),
            Self::Dint(v) => f64::from(v),
            Self::Lint(v) => v as f64,
            Self::Usint(v) | Self::Byte(v) => f64::from(v),
            Self::Uint(v) | Self::Word(v) => f64::from(v),
            Self::Udint(v) | Self::Dword(v) => f64::from(v),
            Self::Ulint(v) | Self::Lword(v) => v as f64,
            Self::Real(v) => f64::from(v),
            Self::Lreal(v) => v,
        }
    }

    /// The value as an integer, reals rounded half to even; `None` if it is not a number or beyond an `i64`.
    pub fn to_integer(self) -> Option<i64> {
        match self {
            Self::Real(_) | Self::Lreal(_) => {
                let rounded = self.as_f64().round_ties_even();
                // -2^63 is exact in an f64; 2^63 is the first value that no longer fits.
                (-TWO_TO_63..TWO_TO_63).contains(&rounded).then_some(rounded as i64)
            }
            Self::Ulint(v) | Self::Lword(v) => i64::try_from(v).ok(),
            Self::Lint(v) => Some(v),
            other => Some(other.as_f64() as i64), // 32 bits or fewer: exact
        }
    }

    /// Converts a number to a type: reals take the nearest value (or infinity), integers are rounded half to
    /// even and cut to their size, NaN and infinities become integer 0, and a BOOL is true unless 0.
    pub fn from_f64(elementary: Elementary, number: f64) -> Value {
        match elementary {
            Elementary::Bool => Self::Bool(number != 0.0),
            Elementary::Real => Self::Real(number as f32),
            Elementary::Lreal => Self::Lreal(number),
            integer => Self::from_wide(integer, low_bits(number)),
        }
    }

    /// Converts an integer to a type; upper bits that do not fit are cut.
    pub fn from_i64(elementary: Elementary, number: i64) -> Value {
        match elementary {
            Elementary::Bool => Self::Bool(number != 0),
            Elementary::Real => Self::Real(number as f32),
            Elementary::Lreal => Self::Lreal(number as f64),
            integer => Self::from_wide(integer, number),
        }
    }

    /// A whole number as a type, nothing cut; `None` when it does not fit. A BOOL is true unless it is 0, and reals take the nearest
    /// value.
    pub fn from_whole(elementary: Elementary, number: i128) -> Option<Value> {
        match (elementary, i64::try_from(number), u64::try_from(number)) {
            (Elementary::Bool, ..) => Some(Self::Bool(number != 0)),
            (Elementary::Real | Elementary::Lreal, ..) => Some(Self::from_f64(elementary, number as f64)),
            (Elementary::Ulint, _, Ok(number)) => Some(Self::Ulint(number)),
            (Elementary::Lword, _, Ok(number)) => Some(Self::Lword(number)),
            (_, Ok(number), _) => {
                Some(Self::from_i64(elementary, number)).filter(|value| value.to_integer() == Some(number))
            }
            _ => None,
        }
    }

    /// The number as a whole one, nothing lost; `None` for reals.
    pub fn to_whole(self) -> Option<i128> {
        match self {
            Self::Real(_) | Self::Lreal(_) => None,
            Self::Ulint(v) | Self::Lword(v) => Some(v.into()),
            other => other.to_integer().map(i128::from),
        }
    }

    /// Converts a value to another type by the same rules, integers without a detour over a float.
    pub fn convert(self, to: Elementary) -> Value {
        match self {
            _ if self.elementary() == to => self,
            Self::Real(_) | Self::Lreal(_) => Self::from_f64(to, self.as_f64()),
            Self::Ulint(v) | Self::Lword(v) if to.is_real() => Self::from_f64(to, v as f64),
            Self::Ulint(v) | Self::Lword(v) => Self::from_i64(to, v as i64),
            Self::Lint(v) => Self::from_i64(to, v),
            other => Self::from_i64(to, other.as_f64() as i64),
        }
    }

    /// Whether the value is not 0 (NaN counts as not 0).
    pub fn as_bool(self) -> bool {
        match self {
            Self::Bool(v) => v,
            Self::Lint(v) => v != 0,
            Self::Ulint(v) | Self::Lword(v) => v != 0,
            other => other.as_f64() != 0.0,
        }
    }

    /// Cuts to the size of an integer type: the `as` conversions drop upper bits, which is the rule.
    fn from_wide(elementary: Elementary, v: i64) -> Value {
        match elementary {
            Elementary::Bool => Self::Bool(v != 0),
            Elementary::Sint => Self::Sint(v as i8),
            Elementary::Int => Self::Int(v as i16),
            Elementary::Dint => Self::Dint(v as i32),
            Elementary::Lint => Self::Lint(v),
            Elementary::Usint => Self::Usint(v as u8),
            Elementary::Uint => Self::Uint(v as u16),
            Elementary::Udint => Self::Udint(v as u32),
            Elementary::Ulint => Self::Ulint(v as u64),
            Elementary::Byte => Self::Byte(v as u8),
            Elementary::Word => Self::Word(v as u16),
            Elementary::Dword => Self::Dword(v as u32),
            Elementary::Lword => Self::Lword(v as u64),
            Elementary::Real => Self::Real(v as f32),
            Elementary::Lreal => Self::Lreal(v as f64),
        }
    }
}

impl std::fmt::Display for Value {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Bool(v) => write!(f, "{v}"),
            Self::Sint(v) => write!(f, "{v}"),
            Self::Int(v) => write!(f, "{v}"),
            Self::Dint(v) => write!(f, "{v}"),
            Self::Lint(v) => write!(f, "{v}"),
            Self::Usint(v) | Self::Byte(v) => write!(f, "{v}"),
            Self::Uint(v) | Self::Word(v) => write!(f, "{v}"),
            Self::Udint(v) | Self::Dword(v) => write!(f, "{v}"),
            Self::Ulint(v) | Self::Lword(v) => write!(f, "{v}"),
            Self::Real(v) => write!(f, "{v}"),
            Self::Lreal(v) => write!(f, "{v}"),
        }
    }
}

/// The low 64 bits of a number rounded half to even; 0 for NaN and infinities.
fn low_bits(number: f64) -> i64 {
    let rounded = number.round_ties_even();
    // A float of 2^117 or more is a multiple of 2^64; below that an i128 holds it exactly.
    if rounded.abs() < TWO_TO_117 {
        rounded as i128 as i64
    } else {
        0
    }
}

const TWO_TO_63: f64 = 9_223_372_036_854_775_808.0;
const TWO_TO_117: f64 = TWO_TO_63 * 18_014_398_509_481_984.0; // 2^63 · 2^54

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn reals_become_integers_as_the_data_conversion_rules_say() {
        #[rustfmt::skip]
        let cases = [
            ("half to even, up",        1.5,          Elementary::Dint,  Value::Dint(2)),
            ("half to even, down",      2.5,          Elementary::Dint,  Value::Dint(2)),
            ("half to even, again up",  3.5,          Elementary::Dint,  Value::Dint(4)),
            ("negative half, up",       -1.5,         Elementary::Dint,  Value::Dint(-2)),
            ("negative half, down",     -2.5,         Elementary::Dint,  Value::Dint(-2)),
            ("negative half, away",     -3.5,         Elementary::Dint,  Value::Dint(-4)),
            ("below half",              1.4,          Elementary::Dint,  Value::Dint(1)),
            ("above half",              1.6,          Elementary::Dint,  Value::Dint(2)),
            ("upper bits cut, INT",     65_665.0,     Elementary::Int,   Value::Int(129)),
            ("upper bits cut, SINT",    129.0,        Elementary::Sint,  Value::Sint(-127)),
            ("upper bits cut, USINT",   -1.0,         Elementary::Usint, Value::Usint(255)),
            ("not a number",            f64::NAN,     Elementary::Dint,  Value::Dint(0)),
            ("infinity",                f64::INFINITY, Elementary::Lint, Value::Lint(0)),
            ("beyond 64 bits",          1e300,        Elementary::Lint,  Value::Lint(0)),
            ("upper half of a ULINT",   1.5 * TWO_TO_63, Elementary::Ulint, Value::Ulint(3 << 62)),
            ("REAL overflows to inf",   1e300,        Elementary::Real,  Value::Real(f32::INFINITY)),
            ("BOOL",                    0.1,          Elementary::Bool,  Value::Bool(true)),
        ];
        for (why, number, to, expected) in cases {
            assert_eq!(Value::from_f64(to, number), expected, "{why}: {number}");
        }
    }

    #[test]
    fn integers_are_taken_only_when_they_fit() {
        #[rustfmt::skip]
        let cases = [
            ("round half to even",   Value::Lreal(2.5),             Some(2)),
            ("not a number",         Value::Real(f32::NAN),         None),
            ("just too large",       Value::Lreal(TWO_TO_63),       None),
            ("smallest",             Value::Lreal(-TWO_TO_63),      Some(i64::MIN)),
            ("unsigned too large",   Value::Ulint(u64::MAX),        None),
            ("LINT keeps low digits", Value::Lint(i64::MAX - 1),    Some(i64::MAX - 1)),
            ("BOOL",                 Value::Bool(true),             Some(1)),
        ];
        for (why, value, expected) in cases {
            assert_eq!(value.to_integer(), expected, "{why}: {value:?}");
        }
    }

    #[test]
    fn too_few_bytes_are_refused() {
        for kind in Elementary::ALL {
            assert_eq!(Value::read(kind, &vec![0; kind.size() - 1]), None, "{kind}");
            let mut short = vec![7; kind.size() - 1];
            assert_eq!(Value::from_i64(kind, 1).write(&mut short), None, "{kind}");
            assert!(short.iter().all(|&b| b == 7), "{kind}: nothing is written");
        }
    }

    proptest! {
        #[test]
        fn bytes_read_back(index in 0usize..15, bytes in any::<[u8; 8]>()) {
            let kind = Elementary::ALL[index];
            let value = Value::read(kind, &bytes).expect("8 bytes are enough");
            let mut out = [0; 8];
            value.write(&mut out).expect("8 bytes are enough");
            if kind != Elementary::Bool {
                prop_assert_eq!(&out[..kind.size()], &bytes[..kind.size()]);
            }
            prop_assert_eq!(value.elementary(), kind);
        }

        #[test]
        fn every_number_converts(index in 0usize..15, number in any::<f64>(), integer in any::<i64>()) {
            let kind = Elementary::ALL[index];
            prop_assert_eq!(Value::from_f64(kind, number).elementary(), kind);
            prop_assert_eq!(Value::from_i64(kind, integer).elementary(), kind);
            prop_assert_eq!(Value::Lint(integer).convert(kind), Value::from_i64(kind, integer));
        }
    }
}
