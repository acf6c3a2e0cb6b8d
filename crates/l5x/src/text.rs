//! The text of values in Logix: radices, reals, and strings with `$` escapes. Bytes of strings are taken as they are.

use arcline_tag::Elementary;

/// A whole number as an attribute `Value` has it: `-1`, `16#ffff_ffff`, `2#0000_0001`, `8#377`, `'$00A'`. Other radices than
/// ten are the bits of the type.
pub(crate) fn integer(kind: Elementary, text: &str) -> Option<i128> {
    let text = text.trim();
    let bits = 8 * kind.size() as u32;
    let signed = matches!(
        kind,
        Elementary::Sint | Elementary::Int | Elementary::Dint | Elementary::Lint
    );
    let of_bits = |raw: u64| {
        if bits < 64 && raw >> bits != 0 {
            return None;
        }
        let shift = 64 - bits;
        if signed {
            Some(i128::from(((raw << shift) as i64) >> shift))
        } else {
            Some(i128::from(raw))
        }
    };
    if text.starts_with('\'') {
        let bytes = string(text)?;
        let raw = bytes.iter().fold(0u64, |raw, byte| raw << 8 | u64::from(*byte));
        return (bytes.len() <= kind.size()).then(|| of_bits(raw))?;
    }
    if let Some((radix, digits)) = text.split_once('#') {
        let radix: u32 = radix.parse().ok().filter(|radix| [2, 8, 16].contains(radix))?;
        return of_bits(u64::from_str_radix(&digits.replace('_', ""), radix).ok()?);
    }
    let number: i128 = text.parse().ok()?;
    let range = if signed {
        -(1i128 << (bits - 1))..1 << (bits - 1)
    } else {
        0..1i128 << bits
    };
    range.contains(&number).then_some(number)
}

/// A real: `1.5`, `1.0e-003`, and `1.#INF`, `-1.#INF`, `1.#QNAN` and `1.$`, which is any of them in older files.
pub(crate) fn real(text: &str) -> Option<f64> {
    let text = text.trim();
    match text.to_ascii_uppercase().as_str() {
        "1.#INF" => Some(f64::INFINITY),
        "-1.#INF" => Some(f64::NEG_INFINITY),
        "1.#QNAN" | "-1.#QNAN" | "1.#NAN" | "-1.#IND" | "1.#IND" | "1.$" | "-1.$" => Some(f64::NAN),
        _ => text.parse().ok().filter(|number: &f64| number.is_finite()),
    }
}

/// Writes a real as [`real`] reads it.
pub(crate) fn write_real(number: f64) -> String {
    if number.is_nan() {
        "1.#QNAN".to_owned()
    } else if number.is_infinite() {
        if number > 0.0 { "1.#INF" } else { "-1.#INF" }.to_owned()
    } else {
        format!("{number:?}")
    }
}

/// The bytes of a text in single quotes: `'It$'s$N'`.
pub(crate) fn string(text: &str) -> Option<Vec<u8>> {
    let inner = text.trim().strip_prefix('\'')?.strip_suffix('\'')?;
    let mut bytes = Vec::new();
    let mut rest = inner.bytes();
    while let Some(byte) = rest.next() {
        if byte != b'$' {
            bytes.push(byte);
            continue;
        }
        let escape = rest.next()?;
        bytes.push(match escape.to_ascii_uppercase() {
            b'$' => b'$',
            b'\'' => b'\'',
            b'"' => b'"',
            b'L' | b'N' => b'\n',
            b'P' => 0x0C,
            b'R' => b'\r',
            b'T' => b'\t',
            high => {
                let digit = |byte: u8| char::from(byte).to_digit(16);
                (digit(high)? * 16 + digit(rest.next()?)?) as u8
            }
        });
    }
    Some(bytes)
}

/// Writes bytes as [`string`] reads them: printable ASCII as it is, all else as `$` and two digits.
pub(crate) fn write_string(bytes: &[u8]) -> String {
    let mut text = String::from("'");
    for byte in bytes {
        match byte {
            b'$' | b'\'' => text.extend(['$', char::from(*byte)]),
            0x20..=0x7E => text.push(char::from(*byte)),
            _ => text.push_str(&format!("${byte:02X}")),
        }
    }
    text.push('\'');
    text
}
