//! Tag paths as users type them: `Move1.Position[2]`, `Word.5`, `Grid[1,2]`, `Program:Main.X`.
//!
//! Not the wire form (that is `arcline-proto`'s EPATH) and not the memory. A path is bounded, so that a peer
//! cannot make it expensive.

use std::fmt;
use std::str::FromStr;
use std::sync::Arc;

use crate::{Template, nearest};

/// One step of a tag path. Names are `&str` in a path that is only followed.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Hash)]
pub enum PathSegment<S = String> {
    /// A tag or member name; `Program:Main` is one name.
    Symbol(S),
    /// An array index; several in a row index several dimensions.
    Element(u32),
    /// A bit of an integer, 0 to 63.
    Bit(u8),
}

impl<S: AsRef<str>> PathSegment<S> {
    /// The segment with a borrowed name.
    pub fn borrowed(&self) -> PathSegment<&str> {
        match self {
            Self::Symbol(name) => PathSegment::Symbol(name.as_ref()),
            Self::Element(index) => PathSegment::Element(*index),
            Self::Bit(bit) => PathSegment::Bit(*bit),
        }
    }
}

impl PathSegment<&str> {
    /// The segment with a name of its own.
    pub fn into_owned(self) -> PathSegment {
        match self {
            Self::Symbol(name) => PathSegment::Symbol(name.to_owned()),
            Self::Element(index) => PathSegment::Element(index),
            Self::Bit(bit) => PathSegment::Bit(bit),
        }
    }
}

/// A path from a tag to a part of it.
#[derive(Clone, PartialEq, Eq, Debug, Hash, Default)]
pub struct TagPath(pub Vec<PathSegment>);

impl TagPath {
    /// Longest path that is read, in bytes.
    pub const MAX_LENGTH: usize = 255;
    /// Most segments of a path.
    pub const MAX_SEGMENTS: usize = 32;

    /// The tag's name, in front of the first segment that is no part of it.
    pub fn tag(&self) -> Option<&str> {
        match self.0.first() {
            Some(PathSegment::Symbol(name)) => Some(name),
            _ => None,
        }
    }

    /// The program in whose scope the tag is, its name, and the segments behind it: `Program:Main.X[3]` is Main, X, 3.
    pub fn scope(&self) -> (Option<&str>, Option<&str>, &[PathSegment]) {
        scope(&self.0)
    }

    /// The tag's name with its program: `X`, `Program:Main.X`.
    pub fn full_name(&self) -> Option<String> {
        match self.scope() {
            (Some(program), Some(name), _) => Some(format!("Program:{program}.{name}")),
            (Some(program), None, _) => Some(format!("Program:{program}")),
            (None, name, _) => name.map(str::to_owned),
        }
    }

    /// The segments behind the first name.
    pub fn rest(&self) -> &[PathSegment] {
        self.0.get(1..).unwrap_or_default()
    }
}

/// See [`TagPath::scope`].
pub fn scope<S: AsRef<str>>(segments: &[PathSegment<S>]) -> (Option<&str>, Option<&str>, &[PathSegment<S>]) {
    let (first, rest) = match segments {
        [PathSegment::Symbol(first), rest @ ..] => (first.as_ref(), rest),
        _ => return (None, None, segments),
    };
    match (program_name(first), rest) {
        (Some(program), [PathSegment::Symbol(name), rest @ ..]) => (Some(program), Some(name.as_ref()), rest),
        (Some(program), rest) => (Some(program), None, rest),
        (None, rest) => (None, Some(first), rest),
    }
}

/// The program that a name such as `Program:Main` means.
pub fn program_name(name: &str) -> Option<&str> {
    let (prefix, program) = name.split_once(':')?;
    prefix.eq_ignore_ascii_case("Program").then_some(program)
}

/// The reason for which a path cannot be read, or does not lead to a tag.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
pub enum PathError {
    /// No name at all.
    #[error("the tag path is empty")]
    Empty,
    /// Longer than [`TagPath::MAX_LENGTH`].
    #[error("the tag path has {length} characters, at most {} are read", TagPath::MAX_LENGTH)]
    TooLong {
        /// Length in bytes.
        length: usize,
    },
    /// More than [`TagPath::MAX_SEGMENTS`] segments.
    #[error("the tag path has more than {} parts", TagPath::MAX_SEGMENTS)]
    TooManySegments,
    /// A character that cannot stand there.
    #[error("unexpected {found:?} at character {position} of the tag path")]
    Unexpected {
        /// The character.
        found: char,
        /// Byte position, from 0.
        position: usize,
    },
    /// The text ends where something must follow.
    #[error("the tag path ends too early")]
    Incomplete,
    /// An index or bit number that is too large to be one.
    #[error("the number at character {position} of the tag path is too large")]
    NumberTooLarge {
        /// Byte position, from 0.
        position: usize,
    },
    /// A structure has no member of that name.
    #[error("{} has no member {member:?}{}", .structure.name, did_you_mean(.member, .structure))]
    NoSuchMember {
        /// Name that was looked for.
        member: String,
        /// Type that was looked in.
        structure: Arc<Template>,
    },
    /// A member name behind something that is no structure, or behind an array without index.
    #[error("{member:?} cannot be a member of {of}")]
    NotAStructure {
        /// The name of the member.
        member: String,
        /// The name of the tag or member in front of it.
        of: String,
    },
    /// An index behind something that is no array.
    #[error("{of} is not an array")]
    NotAnArray {
        /// The type.
        of: String,
    },
    /// Fewer or more indices than the array has dimensions.
    #[error("{given} indices given for an array of {expected} dimensions")]
    WrongDimensions {
        /// Number of indices.
        given: usize,
        /// Number of dimensions.
        expected: usize,
    },
    /// An index beyond the array.
    #[error("index {index} is out of range, the array has {size} elements")]
    IndexOutOfRange {
        /// The index.
        index: u32,
        /// Elements of that dimension.
        size: u32,
    },
    /// A bit of a type that has none, or beyond its width.
    #[error("{of} has no bit {bit}")]
    NoSuchBit {
        /// The bit.
        bit: u8,
        /// The type.
        of: String,
    },
}

impl PathError {
    /// The member that was probably meant by one that is not there. Looked for when it is asked for, since a path that
    /// leads nowhere may be one of many tries.
    pub fn suggestion(&self) -> Option<String> {
        match self {
            Self::NoSuchMember { member, structure } => nearest_member(member, structure),
            _ => None,
        }
    }
}

fn nearest_member(member: &str, structure: &Template) -> Option<String> {
    let shown = structure.members.iter().filter(|member| !member.hidden);
    nearest(member, shown.map(|member| member.name.as_str()))
}

fn did_you_mean(member: &str, structure: &Template) -> String {
    nearest_member(member, structure)
        .map(|near| format!(", did you mean {near:?}?"))
        .unwrap_or_default()
}

impl FromStr for TagPath {
    type Err = PathError;

    fn from_str(text: &str) -> Result<Self, PathError> {
        let segments = split(text)?;
        Ok(Self(segments.into_iter().map(PathSegment::into_owned).collect()))
    }
}

/// Reads a path; its names stay where they are.
///
/// # Errors
/// [`PathError::Empty`], [`PathError::TooLong`], [`PathError::TooManySegments`], and the errors of a character or number.
pub fn split(text: &str) -> Result<Vec<PathSegment<&str>>, PathError> {
    if text.is_empty() {
        return Err(PathError::Empty);
    }
    if text.len() > TagPath::MAX_LENGTH {
        return Err(PathError::TooLong { length: text.len() });
    }
    let mut scanner = Scanner { text, at: 0 };
    let mut segments = vec![PathSegment::Symbol(scanner.name()?)];
    while let Some(next) = scanner.peek() {
        scanner.at += next.len_utf8();
        match next {
            '.' if scanner.peek().is_some_and(|c| c.is_ascii_digit()) => {
                let position = scanner.at;
                let bit = scanner.number()?;
                let bit = u8::try_from(bit).ok().filter(|bit| *bit < 64);
                segments.push(PathSegment::Bit(bit.ok_or(PathError::NumberTooLarge { position })?));
            }
            '.' => segments.push(PathSegment::Symbol(scanner.name()?)),
            '[' => loop {
                segments.push(PathSegment::Element(scanner.number()?));
                match scanner.peek() {
                    Some(',') => scanner.at += 1,
                    Some(']') => {
                        scanner.at += 1;
                        break;
                    }
                    _ => return Err(scanner.unexpected()),
                }
            },
            found => {
                return Err(PathError::Unexpected {
                    found,
                    position: scanner.at - found.len_utf8(),
                });
            }
        }
        if segments.len() > TagPath::MAX_SEGMENTS {
            return Err(PathError::TooManySegments);
        }
    }
    Ok(segments)
}

impl fmt::Display for TagPath {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut in_index = false;
        for (k, segment) in self.0.iter().enumerate() {
            if let PathSegment::Element(index) = segment {
                write!(f, "{}{index}", if in_index { "," } else { "[" })?;
                in_index = true;
                continue;
            }
            if std::mem::take(&mut in_index) {
                f.write_str("]")?;
            }
            if k > 0 {
                f.write_str(".")?;
            }
            match segment {
                PathSegment::Symbol(name) => f.write_str(name)?,
                PathSegment::Bit(bit) => write!(f, "{bit}")?,
                PathSegment::Element(_) => {}
            }
        }
        if in_index {
            f.write_str("]")?;
        }
        Ok(())
    }
}

struct Scanner<'a> {
    text: &'a str,
    at: usize,
}

impl<'a> Scanner<'a> {
    fn peek(&self) -> Option<char> {
        self.text.get(self.at..)?.chars().next()
    }

    fn unexpected(&self) -> PathError {
        match self.peek() {
            Some(found) => PathError::Unexpected {
                found,
                position: self.at,
            },
            None => PathError::Incomplete,
        }
    }

    /// A letter or underscore, then letters, digits, underscores and colons.
    fn name(&mut self) -> Result<&'a str, PathError> {
        let start = self.at;
        if !self.peek().is_some_and(|c| c.is_ascii_alphabetic() || c == '_') {
            return Err(self.unexpected());
        }
        while self
            .peek()
            .is_some_and(|c| c.is_ascii_alphanumeric() || c == '_' || c == ':')
        {
            self.at += 1;
        }
        Ok(&self.text[start..self.at])
    }

    /// Digits, blanks around them allowed.
    fn number(&mut self) -> Result<u32, PathError> {
        self.blanks();
        let start = self.at;
        while self.peek().is_some_and(|c| c.is_ascii_digit()) {
            self.at += 1;
        }
        if start == self.at {
            return Err(self.unexpected());
        }
        let number = self.text[start..self.at]
            .parse()
            .map_err(|_| PathError::NumberTooLarge { position: start })?;
        self.blanks();
        Ok(number)
    }

    fn blanks(&mut self) {
        while self.peek() == Some(' ') {
            self.at += 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::PathSegment::{Bit, Element};
    use super::*;

    fn symbol(name: &str) -> PathSegment {
        PathSegment::Symbol(name.to_owned())
    }

    #[test]
    fn paths_read_and_print() {
        #[rustfmt::skip]
        let cases = [
            ("A.B[3].C",       vec![symbol("A"), symbol("B"), Element(3), symbol("C")], "A.B[3].C"),
            ("Dint.5",         vec![symbol("Dint"), Bit(5)], "Dint.5"),
            ("M[1,2]",         vec![symbol("M"), Element(1), Element(2)], "M[1,2]"),
            ("M[1][2]",        vec![symbol("M"), Element(1), Element(2)], "M[1,2]"),
            ("M[ 1 , 2 ].0",   vec![symbol("M"), Element(1), Element(2), Bit(0)], "M[1,2].0"),
            ("Program:Main.X", vec![symbol("Program:Main"), symbol("X")], "Program:Main.X"),
        ];
        for (text, segments, printed) in cases {
            let path: TagPath = text.parse().unwrap_or_else(|e| panic!("{text}: {e}"));
            assert_eq!(path.0, segments, "{text}");
            assert_eq!(path.to_string(), printed, "{text}");
        }
    }

    #[test]
    fn errors_of_paths_name_their_cause() {
        #[rustfmt::skip]
        let cases = [
            ("",            PathError::Empty),
            (".A",          PathError::Unexpected { found: '.', position: 0 }),
            ("1A",          PathError::Unexpected { found: '1', position: 0 }),
            ("A.",          PathError::Incomplete),
            ("A[",          PathError::Incomplete),
            ("A[]",         PathError::Unexpected { found: ']', position: 2 }),
            ("A[1",         PathError::Incomplete),
            ("A[-1]",       PathError::Unexpected { found: '-', position: 2 }),
            ("A[1,]",       PathError::Unexpected { found: ']', position: 4 }),
            ("A[99999999999]", PathError::NumberTooLarge { position: 2 }),
            ("A.64",        PathError::NumberTooLarge { position: 2 }),
            ("A B",         PathError::Unexpected { found: ' ', position: 1 }),
            ("Aé",          PathError::Unexpected { found: 'é', position: 1 }),
        ];
        for (text, expected) in cases {
            assert_eq!(text.parse::<TagPath>(), Err(expected), "{text}");
        }
        let deep = format!("A{}", ".B".repeat(40));
        assert_eq!(deep.parse::<TagPath>(), Err(PathError::TooManySegments));
        let many = format!("A[{}1]", "1,".repeat(100));
        assert_eq!(many.parse::<TagPath>(), Err(PathError::TooManySegments));
        assert_eq!(
            "A".repeat(256).parse::<TagPath>(),
            Err(PathError::TooLong { length: 256 })
        );
    }

    proptest! {
        #[test]
        fn any_text_gives_a_path_or_an_error(text in ".{0,300}") {
            if let Ok(path) = text.parse::<TagPath>() {
                let printed = path.to_string();
                prop_assert_eq!(printed.parse::<TagPath>(), Ok(path));
            }
        }

        #[test]
        fn likely_text_too(text in r"[A-C_:\.\[\],0-9 ]{0,40}") {
            if let Ok(path) = text.parse::<TagPath>() {
                let printed = path.to_string();
                prop_assert_eq!(printed.parse::<TagPath>(), Ok(path));
            }
        }
    }
}
