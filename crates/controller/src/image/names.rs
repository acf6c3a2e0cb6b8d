//! Tags by name: case is ignored, and a look-up copies no name.
//!
//! For look-ups only: [`Image::tags`](super::Image::tags) is the list.

use std::borrow::Borrow;
use std::collections::HashMap;
use std::hash::{Hash, Hasher};

use arcline_tag::program_name;

use super::TagId;

/// Tags by program and name.
#[derive(Clone, Debug, Default)]
pub(super) struct Names(HashMap<Name, TagId>);

impl Names {
    /// The tag of a name in a program's scope; without a program, in the controller's.
    pub(super) fn get(&self, program: Option<&str>, name: &str) -> Option<TagId> {
        self.0.get(&Asked { program, name } as &dyn Scoped).copied()
    }

    /// The tag of a full name: `X`, `Program:Main.X`.
    pub(super) fn find(&self, full: &str) -> Option<TagId> {
        let scoped = full
            .split_once('.')
            .and_then(|(scope, name)| Some((program_name(scope)?, name)));
        match scoped {
            Some((program, name)) => self.get(Some(program), name),
            None => self.get(None, full),
        }
    }

    /// Assigns a name to a tag, unless another tag has it.
    pub(super) fn insert(&mut self, program: Option<&str>, name: &str, id: TagId) {
        let name = Name {
            program: program.map(Box::from),
            name: name.into(),
        };
        self.0.entry(name).or_insert(id);
    }

    /// Removes a name, if this tag has it.
    pub(super) fn remove(&mut self, program: Option<&str>, name: &str, id: TagId) {
        if self.get(program, name) == Some(id) {
            self.0.remove(&Asked { program, name } as &dyn Scoped);
        }
    }
}

/// A name in its scope.
#[derive(Clone, Debug)]
struct Name {
    program: Option<Box<str>>,
    name: Box<str>,
}

/// A name to look up.
struct Asked<'a> {
    program: Option<&'a str>,
    name: &'a str,
}

/// The common form of both, for one comparison.
trait Scoped {
    fn parts(&self) -> (Option<&str>, &str);
}

impl Scoped for Name {
    fn parts(&self) -> (Option<&str>, &str) {
        (self.program.as_deref(), &self.name)
    }
}

impl Scoped for Asked<'_> {
    fn parts(&self) -> (Option<&str>, &str) {
        (self.program, self.name)
    }
}

impl<'a> Borrow<dyn Scoped + 'a> for Name {
    fn borrow(&self) -> &(dyn Scoped + 'a) {
        self
    }
}

impl Hash for dyn Scoped + '_ {
    fn hash<H: Hasher>(&self, state: &mut H) {
        let (program, name) = self.parts();
        if let Some(program) = program {
            hash_folded(program, state);
        }
        hash_folded(name, state);
    }
}

impl PartialEq for dyn Scoped + '_ {
    fn eq(&self, other: &Self) -> bool {
        let ((program, name), (of, other)) = (self.parts(), other.parts());
        name.eq_ignore_ascii_case(other)
            && match (program, of) {
                (Some(program), Some(of)) => program.eq_ignore_ascii_case(of),
                (program, of) => program.is_none() && of.is_none(),
            }
    }
}

impl Eq for dyn Scoped + '_ {}

impl Hash for Name {
    fn hash<H: Hasher>(&self, state: &mut H) {
        (self as &dyn Scoped).hash(state);
    }
}

impl PartialEq for Name {
    fn eq(&self, other: &Self) -> bool {
        (self as &dyn Scoped) == (other as &dyn Scoped)
    }
}

impl Eq for Name {}

/// Hashes the name in lower case, piece by piece, without memory.
fn hash_folded<H: Hasher>(name: &str, state: &mut H) {
    for piece in name.as_bytes().chunks(PIECE) {
        let mut folded = [0; PIECE];
        let folded = &mut folded[..piece.len()];
        folded.copy_from_slice(piece);
        folded.make_ascii_lowercase();
        state.write(folded);
    }
    state.write_u8(END);
}

const PIECE: usize = 48;
/// A byte that no name contains.
const END: u8 = 0xFF;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_found_in_their_scope_whatever_their_case() {
        let mut names = Names::default();
        let long = "Long".repeat(30);
        names.insert(None, "Speed", TagId(1));
        names.insert(Some("Main"), "Speed", TagId(2));
        names.insert(None, "Program:Main", TagId(3));
        names.insert(None, &long, TagId(4));
        names.insert(None, "SPEED", TagId(9));
        #[rustfmt::skip]
        let cases = [
            ("sPEED",              Some(1)),
            ("program:MAIN.speed", Some(2)),
            ("PROGRAM:main",       Some(3)),
            (&long.to_uppercase(), Some(4)),
            ("Main.Speed",         None),
            ("Program:Mai.nSpeed", None),
            ("Program:Main.",      None),
            ("Spee",               None),
            ("",                   None),
        ];
        for (full, id) in cases {
            assert_eq!(names.find(full), id.map(TagId), "{full}");
        }
        names.remove(None, "Speed", TagId(2));
        assert_eq!(names.find("Speed"), Some(TagId(1)), "it is another tag's");
        names.remove(None, "speed", TagId(1));
        assert_eq!(names.find("Speed"), None);
        assert_eq!(names.get(Some("MAIN"), "speed"), Some(TagId(2)));
    }
}
