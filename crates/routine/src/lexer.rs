//! Tokens of expressions and of Structured Text. Places are byte offsets in the text.
//!
//! Names take the colons of status words and module tags with them: `S:FS`, `Local:1:I`.

use crate::SyntaxError;

/// A token and where it stands.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct Token<'t> {
    pub(crate) kind: TokenKind<'t>,
    pub(crate) at: usize,
    /// Behind its last byte.
    pub(crate) end: usize,
}

/// The kind of a token.
#[derive(Clone, PartialEq, Debug)]
pub(crate) enum TokenKind<'t> {
    Name(&'t str),
    Integer(i64),
    Real(f64),
    /// A text in single quotes, its escapes resolved.
    Text(Vec<u8>),
    Symbol(&'static str),
    End,
}

/// Operators and signs, longer ones first.
const SYMBOLS: [&str; 34] = [
    "[:=]", ":=", "<=", ">=", "<>", "**", "..", "&&", "||", "^^", "+", "-", "*", "/", "=", "<", ">", "&", "(", ")",
    "[", "]", ",", ";", ":", ".", "!", "^", "\\", "?", "{", "}", "|", "%",
];

/// All tokens of a text, `End` last.
///
/// # Errors
/// A character that begins no token, or a text or comment without end.
pub(crate) fn tokens(text: &str) -> Result<Vec<Token<'_>>, SyntaxError> {
    let mut lexer = Lexer {
        text,
        at: 0,
        after_dot: false,
        after_operand: false,
    };
    let mut tokens = Vec::new();
    loop {
        let token = lexer.next()?;
        lexer.after_dot = token.kind == TokenKind::Symbol(".");
        lexer.after_operand = matches!(
            token.kind,
            TokenKind::Name(_) | TokenKind::Integer(_) | TokenKind::Symbol("]" | ")")
        );
        let is_end = token.kind == TokenKind::End;
        tokens.push(token);
        if is_end {
            return Ok(tokens);
        }
    }
}

struct Lexer<'t> {
    text: &'t str,
    at: usize,
    /// Digits behind a dot are the number of a bit.
    after_dot: bool,
    /// A dot behind a name or bracket begins a member or a bit, elsewhere a number such as `.5`.
    after_operand: bool,
}

impl<'t> Lexer<'t> {
    fn rest(&self) -> &'t str {
        self.text.get(self.at..).unwrap_or_default()
    }

    fn next(&mut self) -> Result<Token<'t>, SyntaxError> {
        self.skip()?;
        let at = self.at;
        let rest = self.rest();
        let Some(first) = rest.bytes().next() else {
            return Ok(Token {
                kind: TokenKind::End,
                at,
                end: at,
            });
        };
        let kind = match first {
            b'0'..=b'9' => self.number()?,
            b'.' if !self.after_operand && rest.as_bytes().get(1).is_some_and(u8::is_ascii_digit) => self.number()?,
            b'\'' => TokenKind::Text(self.quoted()?),
            b'a'..=b'z' | b'A'..=b'Z' | b'_' => TokenKind::Name(self.name()),
            _ => {
                let Some(symbol) = SYMBOLS.iter().find(|symbol| rest.starts_with(**symbol)) else {
                    let found = rest.chars().take(1).collect();
                    return Err(SyntaxError::Unexpected {
                        at,
                        found,
                        expected: "a name, a number or an operator",
                    });
                };
                self.at += symbol.len();
                TokenKind::Symbol(symbol)
            }
        };
        Ok(Token { kind, at, end: self.at })
    }

    /// Skips blanks, comments and the lines of regions.
    fn skip(&mut self) -> Result<(), SyntaxError> {
        loop {
            let rest = self.rest();
            let trimmed = rest.trim_start();
            self.at += rest.len() - trimmed.len();
            let end =
                if trimmed.starts_with("//") || trimmed.starts_with("#region") || trimmed.starts_with("#endregion") {
                    trimmed.find('\n').unwrap_or(trimmed.len())
                } else if let Some(comment) = trimmed.strip_prefix("(*") {
                    comment
                        .find("*)")
                        .map(|end| end + 4)
                        .ok_or(SyntaxError::Unended { at: self.at })?
                } else if let Some(comment) = trimmed.strip_prefix("/*") {
                    comment
                        .find("*/")
                        .map(|end| end + 4)
                        .ok_or(SyntaxError::Unended { at: self.at })?
                } else {
                    return Ok(());
                };
            self.at += end;
        }
    }

    fn name(&mut self) -> &'t str {
        let bytes = self.rest().as_bytes();
        let word = |byte: &u8| byte.is_ascii_alphanumeric() || *byte == b'_';
        let mut end = 0;
        loop {
            end += bytes.iter().skip(end).take_while(|byte| word(byte)).count();
            let colon = bytes.get(end) == Some(&b':');
            if !colon || !bytes.get(end + 1).is_some_and(word) {
                break;
            }
            end += 1;
        }
        let name = self.rest().get(..end).unwrap_or_default();
        self.at += end;
        name
    }

    fn number(&mut self) -> Result<TokenKind<'t>, SyntaxError> {
        let at = self.at;
        let bytes = self.rest().as_bytes();
        let digits = |from: usize| {
            bytes
                .iter()
                .skip(from)
                .take_while(|b| b.is_ascii_digit() || **b == b'_')
                .count()
        };
        let mut end = digits(0);
        let whole = self.rest().get(..end).unwrap_or_default().replace('_', "");
        let too_large = SyntaxError::NumberTooLarge { at };
        if bytes.get(end) == Some(&b'#') {
            let radix = match whole.as_str() {
                "2" => 2,
                "8" => 8,
                "16" => 16,
                _ => {
                    return Err(SyntaxError::Unexpected {
                        at,
                        found: whole,
                        expected: "radix 2, 8 or 16",
                    });
                }
            };
            let count = bytes
                .iter()
                .skip(end + 1)
                .take_while(|b| b.is_ascii_alphanumeric() || **b == b'_')
                .count();
            let text = self
                .rest()
                .get(end + 1..end + 1 + count)
                .unwrap_or_default()
                .replace('_', "");
            self.at += end + 1 + count;
            return u64::from_str_radix(&text, radix)
                .map(|value| TokenKind::Integer(of_width(value, text.len() * radix.ilog2() as usize)))
                .map_err(|_| too_large);
        }
        if self.after_dot {
            self.at += end;
            return whole.parse().map(TokenKind::Integer).map_err(|_| too_large);
        }
        let mut is_real = false;
        if bytes.get(end) == Some(&b'.') {
            match bytes.get(end + 1) {
                Some(b'0'..=b'9') => {
                    end += 1 + digits(end + 1);
                    is_real = true;
                }
                // No digit behind the point: `1.E-3`.
                Some(b'e' | b'E')
                    if bytes
                        .iter()
                        .skip(end + 2)
                        .find(|byte| !matches!(byte, b'+' | b'-'))
                        .is_some_and(u8::is_ascii_digit) =>
                {
                    end += 1;
                    is_real = true;
                }
                Some(b'$') => {
                    self.at += end + 2;
                    return Ok(TokenKind::Real(f64::INFINITY));
                }
                Some(b'#') => {
                    let count = bytes
                        .iter()
                        .skip(end + 2)
                        .take_while(|b| b.is_ascii_alphanumeric())
                        .count();
                    let word = self.rest().get(end + 2..end + 2 + count).unwrap_or_default();
                    let value = if word.eq_ignore_ascii_case("INF") {
                        f64::INFINITY
                    } else {
                        f64::NAN
                    };
                    self.at += end + 2 + count;
                    return Ok(TokenKind::Real(value));
                }
                _ => {}
            }
        }
        if matches!(bytes.get(end), Some(b'e' | b'E')) {
            let sign = usize::from(matches!(bytes.get(end + 1), Some(b'+' | b'-')));
            let count = digits(end + 1 + sign);
            if count > 0 {
                end += 1 + sign + count;
                is_real = true;
            }
        }
        let text = self.rest().get(..end).unwrap_or_default().replace('_', "");
        self.at += end;
        // A suffix names the type: it changes nothing here.
        let suffix = bytes
            .iter()
            .skip(end)
            .take_while(|b| matches!(b, b'U' | b'u' | b'L' | b'l'))
            .count();
        self.at += suffix;
        let value = if is_real {
            text.parse().map(TokenKind::Real).ok()
        } else {
            text.parse().map(TokenKind::Integer).ok()
        };
        value.ok_or(too_large)
    }

    fn quoted(&mut self) -> Result<Vec<u8>, SyntaxError> {
        let (bytes, end) = quoted(self.rest().as_bytes()).ok_or(SyntaxError::Unended { at: self.at })?;
        self.at += end;
        Ok(bytes)
    }
}

/// The text of a literal in single quotes at the beginning of some bytes, and how many bytes the literal has.
pub(crate) fn quoted(bytes: &[u8]) -> Option<(Vec<u8>, usize)> {
    let mut text = Vec::new();
    let mut at = 1;
    loop {
        let byte = *bytes.get(at)?;
        at += 1;
        match byte {
            b'\'' => return Some((text, at)),
            b'$' => {
                let escape = *bytes.get(at)?;
                at += 1;
                text.push(match escape.to_ascii_uppercase() {
                    b'N' | b'L' => b'\n',
                    b'R' => b'\r',
                    b'T' => b'\t',
                    b'P' => 0x0C,
                    high if high.is_ascii_hexdigit() => {
                        let low = *bytes.get(at)?;
                        at += 1;
                        let digit = |byte: u8| char::from(byte).to_digit(16);
                        (digit(high)? * 16 + digit(low)?) as u8
                    }
                    _ => escape,
                });
            }
            _ => text.push(byte),
        }
    }
}

/// A number in another radix than ten: its digits are the bits of a DINT, or of a LINT where there are more of them.
fn of_width(value: u64, bits: usize) -> i64 {
    match u32::try_from(value) {
        Ok(value) if bits < 64 => i64::from(value as i32),
        _ => value as i64,
    }
}
