//! Errors in a program, with their line and column.

/// A program that cannot be run.
#[derive(Clone, PartialEq, Debug, thiserror::Error)]
#[error("line {line}, column {column}: {problem}")]
pub struct GcodeError {
    /// Line, from 1.
    pub line: usize,
    /// Column in characters, from 1.
    pub column: usize,
    /// The problem.
    pub problem: Problem,
}

/// The problem at the line and column of a [`GcodeError`].
#[derive(Clone, PartialEq, Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Problem {
    /// A word that has no meaning here.
    #[error("the word `{word}` is not known")]
    Unknown {
        /// As it is written.
        word: String,
    },
    /// A character that no word has.
    #[error("found {found:?}, expected a letter and a number")]
    Character {
        /// The character.
        found: char,
    },
    /// A letter without a number that can be read, finite and at most 1e9.
    #[error("`{letter}` is not followed by a number, found `{found}`")]
    Number {
        /// The letter.
        letter: char,
        /// The text behind it.
        found: String,
    },
    /// A comment without its end on the line.
    #[error("the comment that begins here has no `)` on its line")]
    OpenComment,
    /// A letter twice on a line.
    #[error("`{letter}` stands twice on the line")]
    Twice {
        /// The letter.
        letter: char,
    },
    /// Two words on a line that exclude each other.
    #[error("`{second}` cannot stand on a line with `{first}`")]
    Exclude {
        /// The first.
        first: String,
        /// The second.
        second: String,
    },
    /// A word without another one that uses it.
    #[error("`{letter}` belongs to nothing on this line: {expected}")]
    Unused {
        /// The letter.
        letter: char,
        /// The words that use it.
        expected: &'static str,
    },
    /// A word is missing.
    #[error("{what} is missing: {expected}")]
    Missing {
        /// The missing word.
        what: &'static str,
        /// How it is written.
        expected: &'static str,
    },
    /// A value that cannot be.
    #[error("`{letter}` is {value}, expected {expected}")]
    Value {
        /// The letter.
        letter: char,
        /// As it was written.
        value: f64,
        /// The possible values.
        expected: &'static str,
    },
    /// An axis that the coordinate system does not have.
    #[error("the coordinate system has {axes} axes and no {letter}")]
    NoAxis {
        /// The letter.
        letter: char,
        /// How many axes there are.
        axes: usize,
    },
    /// An arc whose start and end are not equally far from its centre.
    #[error("the radius is {start} at the start of the arc and {end} at its end")]
    Radii {
        /// At the start, units of the machine.
        start: f64,
        /// At the end.
        end: f64,
    },
    /// An arc whose radius does not reach.
    #[error("a radius of {radius} does not span the {distance} between start and end")]
    TooShort {
        /// The radius, units of the machine.
        radius: f64,
        /// Between start and end.
        distance: f64,
    },
    /// An arc with `R` that ends where it starts, or one without a radius.
    #[error("{what}")]
    NoArc {
        /// Why.
        what: &'static str,
    },
    /// An arc that leaves its plane.
    #[error("the arc leaves its plane along {letter}: a helix is not known")]
    Helix {
        /// The axis.
        letter: char,
    },
    /// A text or a program that is too large.
    #[error("the program is too large, at most {limit} {unit} are read")]
    TooLarge {
        /// The limit.
        limit: usize,
        /// Their unit.
        unit: &'static str,
    },
}
