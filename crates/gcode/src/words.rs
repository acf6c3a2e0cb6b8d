//! A line of a program as words: a letter and a number each, with their columns. Comments, line numbers and blanks are
//! gone.

use crate::{GcodeError, Problem};

/// Largest number that is read; positions beyond are no machine's.
const LARGEST: f64 = 1e9;
/// Characters of a wrong number that are shown.
const SHOWN: usize = 20;

/// A word.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(crate) struct Word {
    /// In capitals.
    pub(crate) letter: char,
    pub(crate) value: f64,
    /// In characters, from 1.
    pub(crate) column: usize,
}

impl Word {
    /// As it is usually written: `G64`, `G91.1`, `X-2.5`.
    pub(crate) fn name(&self) -> String {
        format!("{}{}", self.letter, self.value)
    }
}

/// The words of a line (`line` counts from 1).
pub(crate) fn words(text: &str, line: usize) -> Result<Vec<Word>, GcodeError> {
    let characters: Vec<char> = text.chars().collect();
    let wrong = |at: usize, problem| GcodeError {
        line,
        column: at + 1,
        problem,
    };
    let mut words: Vec<Word> = Vec::new();
    let mut at = 0;
    while let Some(character) = characters.get(at).copied() {
        match character {
            ';' => break,
            '(' => {
                let length = characters.get(at..).unwrap_or_default().iter().position(|c| *c == ')');
                at += length.ok_or_else(|| wrong(at, Problem::OpenComment))? + 1;
            }
            blank if blank.is_whitespace() => at += 1,
            letter if letter.is_ascii_alphabetic() => {
                let letter = letter.to_ascii_uppercase();
                let (value, end) =
                    number(&characters, at + 1).map_err(|found| wrong(at, Problem::Number { letter, found }))?;
                // A line number says nothing.
                let is_first = words.is_empty();
                if letter != 'N' || !is_first {
                    words.push(Word {
                        letter,
                        value,
                        column: at + 1,
                    });
                }
                at = end;
            }
            found => return Err(wrong(at, Problem::Character { found })),
        }
    }
    Ok(words)
}

/// A number and its end, or the text in its position. Plain decimals: no exponent, which would be the letter E.
fn number(characters: &[char], from: usize) -> Result<(f64, usize), String> {
    let rest = || characters.iter().copied().enumerate().skip(from);
    let begin = rest()
        .find(|(_, c)| !c.is_whitespace())
        .map_or(characters.len(), |(at, _)| at);
    let belongs = |(at, c): &(usize, char)| c.is_ascii_digit() || *c == '.' || *at == begin && matches!(c, '+' | '-');
    let text: String = rest().skip(begin - from).take_while(belongs).map(|(_, c)| c).collect();
    let value = text.parse().ok().filter(|value: &f64| value.abs() <= LARGEST);
    match value {
        Some(value) => Ok((value + 0.0, begin + text.chars().count())),
        None => {
            let next = rest().skip(begin - from).take_while(|(_, c)| !c.is_whitespace());
            Err(next
                .map(|(_, c)| if c.is_control() { ' ' } else { c })
                .take(SHOWN)
                .collect())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_come_apart() {
        let word = |letter, value, column| Word { letter, value, column };
        #[rustfmt::skip]
        let cases: &[(&str, &str, &[Word])] = &[
            ("words",               "G1 X10",              &[word('G', 1.0, 1), word('X', 10.0, 4)]),
            ("without blanks",      "g1x-10.5y+.25",       &[word('G', 1.0, 1), word('X', -10.5, 3), word('Y', 0.25, 9)]),
            ("a blank inside",      "X 1",                 &[word('X', 1.0, 1)]),
            ("a line number",       "N0010 G0",            &[word('G', 0.0, 7)]),
            ("comments",            "(a) G4 (b;) P1 ; c(", &[word('G', 4.0, 5), word('P', 1.0, 13)]),
            ("nothing",             "  ",                  &[]),
            ("a negative zero",     "X-0",                 &[word('X', 0.0, 1)]),
        ];
        for (why, text, expected) in cases {
            assert_eq!(words(text, 1).as_deref(), Ok(*expected), "{why}: {text}");
        }
    }

    #[test]
    fn text_that_is_no_word_is_reported_with_its_column() {
        #[rustfmt::skip]
        let cases = [
            ("no number",           "G1 X",       4, "`X` is not followed by a number, found ``"),
            ("two points",          "X1.2.3",     1, "`X` is not followed by a number, found `1.2.3`"),
            ("too large",           "X1e10 Y1",   3, "`E` is not"),
            ("far too large",       "X99999999999", 1, "`X` is not followed by a number"),
            ("a parameter",         "G1 X#1",     4, "found `#1`"),
            ("an expression",       "G1 X[1+2]",  4, "found `[1+2]`"),
            ("block delete",        "/G1 X1",     1, "found '/'"),
            ("an open comment",     "G1 (to X1",  4, "has no `)`"),
        ];
        for (why, text, column, expected) in cases {
            match words(text, 7) {
                Err(error) => {
                    assert!(error.to_string().contains(expected), "{why}: {error}");
                    assert_eq!((error.line, error.column), (7, column), "{why}: {error}");
                }
                // An exponent reads as a word of its own, which the program then refuses.
                Ok(words) => assert!(
                    why == "too large" && words.iter().any(|word| word.letter == 'E'),
                    "{why}: {words:?}"
                ),
            }
        }
    }
}
