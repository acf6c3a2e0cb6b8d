//! From text to tokens, one at a time. Knows no keyword and no instruction.

use std::borrow::Cow;

use crate::error::{SyntaxError, SyntaxProblem};

/// The kind of a token.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Kind {
    /// A name or keyword; `Program:Main` is one, and superscripts belong to it.
    Name,
    /// A number, unsigned.
    Number,
    /// One of the signs, by its text.
    Sign,
    /// The end of the text.
    End,
}

/// A token and where it stands.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) struct Token<'t> {
    pub(crate) kind: Kind,
    pub(crate) text: &'t str,
    /// Byte offset in the program.
    pub(crate) offset: usize,
    /// Line, from 1.
    pub(crate) line: u32,
}

impl Token<'_> {
    /// Whether the token is this sign.
    pub(crate) fn is(&self, sign: &str) -> bool {
        self.kind == Kind::Sign && self.text == sign
    }

    /// Whether the token is this keyword, case ignored.
    pub(crate) fn is_word(&self, word: &str) -> bool {
        self.kind == Kind::Name && self.text.eq_ignore_ascii_case(word)
    }

    /// The token as an error message quotes it.
    pub(crate) fn quoted(&self) -> String {
        match self.kind {
            Kind::End => "the end of the program".to_owned(),
            _ => format!("`{}`", self.text.chars().take(60).collect::<String>()),
        }
    }
}

/// Reads tokens off a text. A copy of it looks ahead.
#[derive(Clone, Copy)]
pub(crate) struct Lexer<'t> {
    text: &'t str,
    at: usize,
    line: u32,
}

impl<'t> Lexer<'t> {
    pub(crate) fn new(text: &'t str) -> Self {
        Self { text, at: 0, line: 1 }
    }

    /// The next token; behind the last one, [`Kind::End`] for good.
    pub(crate) fn next(&mut self) -> Result<Token<'t>, SyntaxError> {
        self.skip_blanks()?;
        let rest = &self.text[self.at..];
        let Some(first) = rest.chars().next() else {
            return Ok(self.token(Kind::End, 0));
        };
        if first.is_ascii_alphabetic() || first == '_' {
            return Ok(self.token(Kind::Name, name_length(rest)));
        }
        if first.is_ascii_digit() {
            return Ok(self.token(Kind::Number, number_length(rest)));
        }
        let length = sign_length(rest.as_bytes());
        let unknown = || SyntaxError::new(self.text, self.at, SyntaxProblem::Character { found: first });
        Ok(self.token(Kind::Sign, length.ok_or_else(unknown)?))
    }

    fn token(&mut self, kind: Kind, length: usize) -> Token<'t> {
        let offset = self.at;
        self.at += length;
        Token {
            kind,
            text: &self.text[offset..self.at],
            offset,
            line: self.line,
        }
    }

    fn skip_blanks(&mut self) -> Result<(), SyntaxError> {
        loop {
            self.at += run_length(self.text.as_bytes(), self.at, |byte| byte == b' ');
            let rest = &self.text[self.at..];
            if rest.starts_with(|c: char| c.is_ascii_graphic() && !matches!(c, '/' | '(')) {
                return Ok(());
            }
            let blank = rest.len() - rest.trim_start().len();
            let skip = if blank > 0 {
                blank
            } else if rest.starts_with("//") {
                rest.find('\n').unwrap_or(rest.len())
            } else if let Some(comment) = rest.strip_prefix("(*") {
                let problem = SyntaxProblem::OpenComment;
                comment
                    .find("*)")
                    .ok_or_else(|| SyntaxError::new(self.text, self.at, problem))?
                    + 4
            } else if rest.starts_with('\u{feff}') && self.at == 0 {
                '\u{feff}'.len_utf8()
            } else {
                return Ok(());
            };
            self.line += rest.as_bytes()[..skip]
                .iter()
                .map(|byte| u32::from(*byte == b'\n'))
                .sum::<u32>();
            self.at += skip;
        }
    }
}

/// The length of the sign at the start of a text.
fn sign_length(text: &[u8]) -> Option<usize> {
    match text {
        [b':', b'=', ..] | [b'<', b'>' | b'=', ..] | [b'>', b'=', ..] => Some(2),
        [sign, ..] if b"=<>+-*/&()[],;.%".contains(sign) => Some(1),
        _ => None,
    }
}

/// The number of bytes from a place on that are of a kind.
fn run_length(bytes: &[u8], from: usize, is_of_kind: impl Fn(u8) -> bool) -> usize {
    let rest = bytes.get(from..).unwrap_or_default();
    rest.iter().take_while(|byte| is_of_kind(**byte)).count()
}

fn name_length(text: &str) -> usize {
    let part = |from: usize| {
        let mut end = from;
        loop {
            end += run_length(text.as_bytes(), end, |byte| {
                byte.is_ascii_alphanumeric() || byte == b'_'
            });
            match text.get(end..).and_then(|rest| rest.chars().next()) {
                Some(power @ ('²' | '³')) => end += power.len_utf8(),
                _ => return end,
            }
        }
    };
    let length = part(0);
    match text[length..].strip_prefix(':') {
        Some(rest) if rest.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_') => part(length + 1),
        _ => length,
    }
}

/// `12`, `1_000`, `1.5`, `100.`, `2.5e-3`, `16#FF`.
fn number_length(text: &str) -> usize {
    let bytes = text.as_bytes();
    let digits = |from: usize| from + run_length(bytes, from, |byte| byte.is_ascii_digit() || byte == b'_');
    let mut end = digits(0);
    if bytes.get(end) == Some(&b'#') {
        return end + 1 + run_length(bytes, end + 1, |byte| byte.is_ascii_alphanumeric() || byte == b'_');
    }
    if bytes.get(end) == Some(&b'.') {
        end = digits(end + 1);
    }
    if matches!(bytes.get(end), Some(b'e' | b'E')) {
        let sign = usize::from(matches!(bytes.get(end + 1), Some(b'+' | b'-')));
        if bytes.get(end + 1 + sign).is_some_and(u8::is_ascii_digit) {
            end = digits(end + 1 + sign);
        }
    }
    end
}

/// The value of a [`Kind::Number`] token; `None` when it has none.
pub(crate) fn number(text: &str) -> Option<f64> {
    let plain = if text.contains('_') {
        Cow::Owned(text.replace('_', ""))
    } else {
        Cow::Borrowed(text)
    };
    match plain.split_once('#') {
        Some((radix, digits)) => {
            let radix: u32 = radix.parse().ok().filter(|radix| matches!(radix, 2 | 8 | 10 | 16))?;
            // IEC 61131-3 writes bit patterns this way, so 64 bits are the most there can be.
            u64::from_str_radix(digits, radix).ok().map(|whole| whole as f64)
        }
        None => plain.parse().ok().filter(|number: &f64| number.is_finite()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texts(text: &str) -> Vec<String> {
        let mut lexer = Lexer::new(text);
        let mut all = Vec::new();
        loop {
            let token = lexer.next().expect("a text without errors");
            if token.kind == Kind::End {
                return all;
            }
            all.push(token.text.to_owned());
        }
    }

    #[test]
    fn tokens() {
        #[rustfmt::skip]
        let cases = [
            ("an assignment",              "a:=b",                     "a := b"),
            ("a name with its program",    "Program:Main.X := 1",      "Program:Main . X := 1"),
            ("bits are no fractions",      "M.5 A[3].2",               "M . 5 A [ 3 ] . 2"),
            ("numbers",                    "1 1.5 100. 1e3 2.5E-3 1_000 16#fF", "1 1.5 100. 1e3 2.5E-3 1_000 16#fF"),
            ("an exponent needs a digit",  "1e",                       "1 e"),
            ("words of the faceplate",     "% of Time S-curve Unitspersec²", "% of Time S - curve Unitspersec²"),
            ("comments",                   "a // b\n(* c \n d *) e",   "a e"),
            ("signs stick together",       "<=<>>==",                  "<= <> >= ="),
            ("a byte order mark",          "\u{feff}a",                "a"),
        ];
        for (why, text, expected) in cases {
            assert_eq!(texts(text).join(" "), expected, "{why}: {text}");
        }
    }

    #[test]
    fn lines_count_through_comments() {
        let mut lexer = Lexer::new("a\n(* \n *) // x\r\n b");
        assert_eq!(lexer.next().expect("a").line, 1);
        assert_eq!(lexer.next().expect("b").line, 4);
    }

    #[test]
    fn numbers() {
        #[rustfmt::skip]
        let cases = [
            ("whole", "12", Some(12.0)), ("a fraction", "1.5", Some(1.5)), ("a point at the end", "100.", Some(100.0)),
            ("an exponent", "1e3", Some(1000.0)), ("underscores", "1_000", Some(1000.0)),
            ("hexadecimal", "16#FF", Some(255.0)), ("binary", "2#1010", Some(10.0)),
            ("no such radix", "7#1", None), ("not a digit of it", "2#3", None), ("too large", "1e999", None),
        ];
        for (why, text, expected) in cases {
            assert_eq!(number(text), expected, "{why}: {text}");
        }
    }
}
