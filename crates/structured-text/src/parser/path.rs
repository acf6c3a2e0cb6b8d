//! Tag paths: `Points[i + 1].Word.5`. An index is compiled like any expression.

use arcline_tag::{PathError, PathSegment, TagPath};

use super::{Parser, keyword, place_of};
use crate::code::{Op, Part, Path};
use crate::error::{SyntaxError, SyntaxProblem};
use crate::lexer::{Kind, Token};

impl<'t> Parser<'t> {
    /// The rest of a tag path behind its name; operations of computed indices are emitted.
    pub(super) fn path(&mut self, name: Token<'t>) -> Result<u32, SyntaxError> {
        if keyword(name.text).is_some() {
            return Err(self.unexpected(&name, "a name; this one is a keyword"));
        }
        let mut parts = vec![Part::Fixed(PathSegment::Symbol(name.text.to_owned()))];
        loop {
            if self.peek.is(".") {
                self.advance()?;
                let token = self.peek;
                self.advance()?;
                parts.push(Part::Fixed(match token.kind {
                    Kind::Name => PathSegment::Symbol(token.text.to_owned()),
                    Kind::Number => {
                        let bit = token.text.parse().ok().filter(|bit| *bit < 64);
                        PathSegment::Bit(bit.ok_or_else(|| self.unexpected(&token, "a bit from 0 to 63"))?)
                    }
                    _ => {
                        return Err(self.unexpected(&token, "the name of a member or the number of a bit"));
                    }
                }));
            } else if self.peek.is("[") {
                self.advance()?;
                loop {
                    parts.push(self.index()?);
                    if self.peek.is(",") {
                        self.advance()?;
                    } else {
                        self.expect("]", "`]` behind the index")?;
                        break;
                    }
                }
            } else {
                break;
            }
            if parts.len() > TagPath::MAX_SEGMENTS {
                return Err(self.error(
                    name.offset,
                    SyntaxProblem::Path {
                        error: PathError::TooManySegments,
                    },
                ));
            }
        }
        if self.last_end - name.offset > 4 * TagPath::MAX_LENGTH || name.text.len() > TagPath::MAX_LENGTH {
            let error = PathError::TooLong {
                length: self.last_end - name.offset,
            };
            return Err(self.error(name.offset, SyntaxProblem::Path { error }));
        }
        Ok(self.add_path(parts, name))
    }

    /// An index: a plain number stays in the path, anything else is computed when the program runs.
    fn index(&mut self) -> Result<Part, SyntaxError> {
        let before = self.program.ops.len();
        let token = self.peek;
        if let Some(error) = self.unsupported_assignment(&token) {
            return Err(error);
        }
        // A name in an index is no word, wherever the path stands.
        let word = self.word.take();
        self.expression()?;
        self.word = word;
        match self.program.ops[before..] {
            [Op::Number(value)] => {
                self.program.ops.pop();
                let index = if value.fract() == 0.0 && (0.0..=f64::from(u32::MAX)).contains(&value) {
                    value as u32
                } else {
                    return Err(self.unexpected(&token, "a whole number, 0 or more"));
                };
                Ok(Part::Fixed(PathSegment::Element(index)))
            }
            _ => Ok(Part::Computed),
        }
    }

    pub(super) fn add_path(&mut self, parts: Vec<Part>, name: Token<'t>) -> u32 {
        let place = place_of(self.program.paths.len());
        self.program.paths.push(Path {
            parts,
            offset: name.offset,
            variable: None,
        });
        place
    }
}
