//! The errors of a program: before it runs ([`SyntaxError`]) and while it runs ([`RuntimeError`]).

use std::fmt;

use arcline_instruction_set::Object;

/// A program that cannot run: the position, the text found and the text expected.
///
/// Displayed over several lines, the last two of which show the line of the program and a caret.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct SyntaxError {
    /// Line, from 1.
    pub line: usize,
    /// Column in characters, from 1.
    pub column: usize,
    /// The problem.
    pub problem: Box<SyntaxProblem>,
    /// The line of the program, shortened around the place when it is long.
    pub(crate) excerpt: String,
    /// Characters in front of the place in the excerpt.
    pub(crate) caret: usize,
}

impl SyntaxError {
    /// An error at a byte offset of a text.
    pub(crate) fn new(text: &str, offset: usize, problem: SyntaxProblem) -> Self {
        /// Characters shown on either side of the place.
        const AROUND: usize = 60;
        let before = text.get(..offset).unwrap_or(text);
        let line_start = before.rfind('\n').map_or(0, |at| at + 1);
        let line = text[line_start..].lines().next().unwrap_or_default();
        let column = before[line_start..].chars().count();
        let skipped = column.saturating_sub(AROUND);
        let excerpt = line.chars().skip(skipped).take(2 * AROUND);
        Self {
            line: before.bytes().filter(|byte| *byte == b'\n').count() + 1,
            column: column + 1,
            problem: Box::new(problem),
            excerpt: excerpt.map(|c| if c.is_control() { ' ' } else { c }).collect(),
            caret: column - skipped,
        }
    }
}

impl fmt::Display for SyntaxError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "line {}, column {}: {}", self.line, self.column, self.problem)?;
        writeln!(f, "  {}", self.excerpt)?;
        write!(f, "  {:width$}^", "", width = self.caret)
    }
}

impl std::error::Error for SyntaxError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        Some(&self.problem)
    }
}

/// The problem at the position of a [`SyntaxError`].
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SyntaxProblem {
    /// A text where it cannot stand.
    #[error("found {found}, expected {expected}")]
    Unexpected {
        /// The text found, quoted, or `the end of the program`.
        found: String,
        /// The text expected.
        expected: &'static str,
    },
    /// A construct of IEC 61131-3 or of Logix that this dialect does not have.
    #[error("this Structured Text has no {construct}: {instead}")]
    NotSupported {
        /// The construct.
        construct: String,
        /// The construct to use instead.
        instead: &'static str,
    },
    /// A character that no program has.
    #[error("found the character {found:?}, which has no meaning here")]
    Character {
        /// The character.
        found: char,
    },
    /// A comment `(*` without its `*)`.
    #[error("the comment that begins here has no end, expected `*)`")]
    OpenComment,
    /// A number that cannot be read.
    #[error("`{found}` is not a number that can be read")]
    Number {
        /// Its text.
        found: String,
    },
    /// A call of something that is no instruction.
    #[error("there is no instruction `{name}`{}", suggest(.suggestion))]
    UnknownInstruction {
        /// The name.
        name: String,
        /// The nearest mnemonic.
        suggestion: Option<String>,
    },
    /// More operands than the instruction has.
    #[error("{mnemonic} has {limit} operands, this is one too many")]
    TooManyOperands {
        /// The instruction.
        mnemonic: arcline_instruction_set::Mnemonic,
        /// The number of its operands.
        limit: usize,
    },
    /// A word that the operand does not have.
    #[error("operand {place} ({operand}) has no word `{word}`{}", suggest(.suggestion))]
    UnknownWord {
        /// Place of the operand on the faceplate, from 0.
        place: usize,
        /// Its name.
        operand: &'static str,
        /// The word.
        word: String,
        /// The nearest word of the operand, or the nearest tag.
        suggestion: Option<String>,
    },
    /// No axis, coordinate system or group of that name.
    #[error("there is no {what} `{name}`{}", suggest(.suggestion))]
    UnknownObject {
        /// The sort of the name.
        what: &'static str,
        /// The name.
        name: String,
        /// The nearest name.
        suggestion: Option<String>,
    },
    /// An object of another kind than the operand is.
    #[error("`{name}` is {}, and this operand is {}", .is.with_article(), .wanted.with_article())]
    WrongObject {
        /// The name.
        name: String,
        /// The kind that it has.
        is: Object,
        /// The kind of the operand.
        wanted: Object,
    },
    /// No tag or variable of that name.
    #[error("there is no tag `{path}`{}", suggest(.suggestion))]
    UnknownTag {
        /// The path.
        path: String,
        /// The nearest name.
        suggestion: Option<String>,
    },
    /// An attribute that the class does not have.
    #[error("GSV and SSV know no attribute `{name}` of an object of the class {what}{}", suggest(.suggestion))]
    UnknownAttribute {
        /// The class.
        what: &'static str,
        /// The name.
        name: String,
        /// The nearest name.
        suggestion: Option<String>,
    },
    /// SSV of an attribute that only the configuration sets.
    #[error("SSV cannot set {name}, only the configuration can; GSV reads it")]
    ReadOnlyAttribute {
        /// The attribute.
        name: &'static str,
    },
    /// A path that is no path.
    #[error("{error}")]
    Path {
        /// The error of the path.
        error: arcline_tag::PathError,
    },
    /// Statements or parentheses within each other, too deep.
    #[error("nested more than {limit} deep")]
    TooDeep {
        /// The limit.
        limit: usize,
    },
    /// A program that is too large.
    #[error("the program is too large, at most {limit} {unit} are read")]
    TooLarge {
        /// The limit.
        limit: usize,
        /// The unit of the count.
        unit: &'static str,
    },
}

pub(crate) fn suggest(suggestion: &Option<String>) -> String {
    suggestion
        .as_ref()
        .map(|word| format!(", did you mean `{word}`?"))
        .unwrap_or_default()
}

/// A program that cannot go on.
#[derive(Clone, PartialEq, Debug, thiserror::Error)]
#[error("line {line}: {problem}")]
pub struct RuntimeError {
    /// Line of the statement, from 1.
    pub line: usize,
    /// The problem.
    pub problem: RuntimeProblem,
}

/// The problem of a [`RuntimeError`].
#[derive(Clone, PartialEq, Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RuntimeProblem {
    /// A BOOL where a number must stand; BOOL is never converted (spec/axis-and-data-types.md §13).
    #[error("found a BOOL, expected a number")]
    NotANumber,
    /// An array index that is none.
    #[error("the array index is {index}, expected a whole number, 0 or more")]
    Index {
        /// The index.
        index: f64,
    },
    /// AND, OR, XOR or NOT of a number that is no integer.
    #[error("found {value}, expected an integer for the bits of it")]
    NotAnInteger {
        /// The number.
        value: f64,
    },
    /// FOR with step 0.
    #[error("the step of FOR is {step}, expected a number other than 0")]
    Step {
        /// The step.
        step: f64,
    },
    /// DELAY for a time that is none.
    #[error("DELAY is {seconds} s, expected 0 or more")]
    Delay {
        /// The time, seconds.
        seconds: f64,
    },
    /// The driver answered another question. A fault of the caller, not of the program.
    #[error("the interpreter asked for {asked} and was answered something else")]
    Answer {
        /// The expected answer.
        asked: &'static str,
    },
}
