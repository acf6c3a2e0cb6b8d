//! A look over the text before it is parsed: how large, how deep, how wide. It bounds the work that a file can cause
//! in the parser (whose check for double attributes is quadratic in their number). The parser checks that the XML is well-formed.

use crate::Problem;

/// Most bytes of a file.
pub const MAX_TEXT: usize = 64 << 20;
/// Most elements within one another.
pub const MAX_DEPTH: usize = 64;
/// Most attributes of one element; an AXIS_CIP_DRIVE has some 200.
pub const MAX_ATTRIBUTES: usize = 1024;

/// The offset at which a limit is exceeded.
pub(crate) fn check(text: &str) -> Result<(), (usize, Problem)> {
    let too_much = |what, found, limit| Problem::TooMuch { what, found, limit };
    if text.len() > MAX_TEXT {
        return Err((0, too_much("bytes", text.len(), MAX_TEXT)));
    }
    let bytes = text.as_bytes();
    let mut depth = 0usize;
    let mut at = 0;
    while let Some(open) = find(bytes, at, b"<") {
        let rest = bytes.get(open + 1..).unwrap_or_default();
        let end = match rest {
            [b'!', b'-', b'-', ..] => find(bytes, open + 4, b"-->").map(|end| end + 3),
            [b'!', b'[', ..] => find(bytes, open + 3, b"]]>").map(|end| end + 3),
            [b'?', ..] => find(bytes, open + 2, b"?>").map(|end| end + 2),
            [b'/', ..] => {
                depth = depth.saturating_sub(1);
                find(bytes, open, b">").map(|end| end + 1)
            }
            _ => {
                let (end, attributes, empty) = tag(bytes, open + 1);
                if attributes > MAX_ATTRIBUTES {
                    return Err((open, too_much("attributes of one element", attributes, MAX_ATTRIBUTES)));
                }
                if !empty {
                    depth += 1;
                    if depth > MAX_DEPTH {
                        return Err((open, too_much("levels of elements", depth, MAX_DEPTH)));
                    }
                }
                Some(end)
            }
        };
        let Some(end) = end else { break };
        at = end;
    }
    Ok(())
}

/// Scans a tag from behind `<`: returns the offset behind `>`, the number of quoted values, and whether the tag closes itself.
fn tag(bytes: &[u8], from: usize) -> (usize, usize, bool) {
    let mut attributes = 0;
    let mut quote = None;
    let mut last = b'<';
    for (place, byte) in bytes.iter().enumerate().skip(from) {
        match (quote, *byte) {
            (None, b'>') => return (place + 1, attributes, last == b'/'),
            (None, b'"' | b'\'') => {
                attributes += 1;
                quote = Some(*byte);
            }
            (Some(open), byte) if open == byte => quote = None,
            _ => {}
        }
        last = *byte;
    }
    (bytes.len(), attributes, false)
}

fn find(bytes: &[u8], from: usize, what: &[u8]) -> Option<usize> {
    let rest = bytes.get(from..)?;
    let place = rest.windows(what.len()).position(|window| window == what)?;
    Some(from + place)
}
