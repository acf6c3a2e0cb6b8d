//! The cross-reference: where a tag is used.

use super::{Listing, is_in_force, joined, line_of, references, visit};
use crate::cell::program_scopes;
use crate::compile::{Known, Owner};
use crate::error::{Line, SyntaxError};
use crate::expression::{Expression, Step, TagReference};
use crate::memory::Symbol;
use crate::rll::Rung;
use crate::source::Content;
use crate::st::Text;

/// A use of a tag.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Use {
    /// The number of the routine.
    pub routine: u32,
    /// The rung or line by its number in the file.
    pub line: Line,
    /// The index of the rung or line in the routine, from 0.
    pub index: usize,
    /// The instruction; empty: a statement of Structured Text.
    pub instruction: String,
    /// The tag as it is written there.
    pub operand: String,
    /// Whether the instruction writes the tag.
    pub is_written: bool,
}

/// A tag by its scope and steps, through all aliases.
struct Named {
    /// As the file writes it.
    shown: String,
    /// The program in lower case; `None`: the controller.
    program: Option<String>,
    name: String,
    steps: Vec<Step>,
}

impl Listing {
    /// The full name of a tag that is named in the scope of a program or of the controller, through aliases, and the uses of it, of its parts,
    /// and of the whole that it is a part of, in the order of the routines; at most `limit`. Routines of add-on instructions have names of
    /// their own and are left out.
    ///
    /// # Errors
    /// The text is no tag.
    pub fn uses(&self, tag: &str, program: Option<&str>, limit: usize) -> Result<(String, Vec<Use>), SyntaxError> {
        let wanted = Expression::parse_reference(&program_scopes(tag))?;
        let programs = &self.project.programs;
        let scope = program.and_then(|name| programs.iter().position(|one| one.name.eq_ignore_ascii_case(name)));
        let mut uses = Vec::new();
        let shown = self.with_compiler(|compiler| {
            let known = Known {
                types: std::mem::take(&mut compiler.types),
                tags: std::mem::take(&mut compiler.tags),
            };
            let wanted = self.named(&known, scope, &wanted);
            for number in 0..u32::try_from(self.routines.len()).unwrap_or(u32::MAX) {
                if uses.len() >= limit {
                    break;
                }
                if let Some((Owner::Program(program), _)) = self.routines.get(number as usize) {
                    self.uses_in(&known, number, *program, &wanted, &mut uses);
                }
            }
            (compiler.types, compiler.tags) = (known.types, known.tags);
            wanted.shown
        });
        uses.truncate(limit);
        Ok((shown, uses))
    }

    fn uses_in(&self, known: &Known, routine: u32, program: usize, wanted: &Named, uses: &mut Vec<Use>) {
        let is_wanted = |one: &TagReference| wanted.overlaps(&self.named(known, Some(program), one));
        match self.source(routine).map(|source| &source.content) {
            Some(Content::Ladder(rungs)) => {
                for (index, source) in rungs.iter().filter(|rung| is_in_force(rung)).enumerate() {
                    let Ok(rung) = Rung::parse(&source.text) else { continue };
                    rung.visit(&mut |instruction| {
                        let (_, operands) = self.described(instruction);
                        for operand in operands {
                            let text = operand.value.as_deref().unwrap_or_default();
                            let Ok(expression) = Expression::parse(text) else {
                                continue;
                            };
                            let is_tag = matches!(expression, Expression::Reference(_));
                            let mut is_first = true;
                            references(&expression, &mut |one| {
                                if is_wanted(one) {
                                    uses.push(Use {
                                        routine,
                                        line: line_of(false, source.number),
                                        index,
                                        instruction: instruction.name.clone(),
                                        operand: one.to_string(),
                                        // A tag in a subscript is read.
                                        is_written: operand.is_written && is_tag && is_first,
                                    });
                                }
                                is_first = false;
                            });
                        }
                    });
                }
            }
            Some(Content::Text(lines)) => {
                let (text, starts) = joined(lines);
                let Ok(text) = Text::parse(&text) else { return };
                visit(&text.statements, &mut |one, at, is_written| {
                    if is_wanted(one) {
                        let index = starts.partition_point(|start| *start <= at).saturating_sub(1);
                        let number = lines.get(index).map_or(0, |(number, _)| *number);
                        uses.push(Use {
                            routine,
                            line: line_of(true, number),
                            index,
                            instruction: String::new(),
                            operand: one.to_string(),
                            is_written,
                        });
                    }
                });
            }
            _ => {}
        }
    }

    /// The tag that a reference names in a program, through aliases.
    fn named(&self, known: &Known, program: Option<usize>, reference: &TagReference) -> Named {
        let number = |name: &str| {
            let programs = self.project.programs.iter();
            programs
                .map(|one| &one.name)
                .position(|one| one.eq_ignore_ascii_case(name))
        };
        let (mut scope, mut reference) = (program, reference.clone());
        let mut tag = None;
        for _ in 0..MAX_ALIASES {
            if let Some(of) = &reference.program {
                scope = number(of);
            }
            let name = reference.name.to_ascii_lowercase();
            let local = scope.and_then(|program| known.tags.programs.get(program)?.get(&name));
            let symbol = match local {
                Some(symbol) => Some(symbol),
                None => {
                    scope = None;
                    known.tags.controller.get(&name)
                }
            };
            if let Some(Symbol::Tag(number)) = symbol {
                tag = known.tags.list.get(*number);
            }
            let Some(Symbol::Alias(text)) = symbol else { break };
            let Ok(mut of) = Expression::parse_reference(&program_scopes(text)) else {
                break;
            };
            of.steps.extend(reference.steps);
            reference = of;
        }
        let program = scope.and_then(|program| self.project.programs.get(program));
        let whole = TagReference {
            program: None,
            name: tag.map_or_else(|| reference.name.clone(), crate::Tag::full_name),
            ..reference.clone()
        };
        Named {
            shown: whole.to_string(),
            program: program.map(|program| program.name.to_ascii_lowercase()),
            name: reference.name.to_ascii_lowercase(),
            steps: reference.steps,
        }
    }
}

impl Named {
    /// Whether two names may share data: one is the same as the other, a part of it, or the whole.
    fn overlaps(&self, other: &Named) -> bool {
        let mut steps = self.steps.iter().zip(&other.steps);
        self.program == other.program && self.name == other.name && steps.all(|(a, b)| may_be_same(a, b))
    }
}

fn may_be_same(a: &Step, b: &Step) -> bool {
    match (a, b) {
        (Step::Member(a), Step::Member(b)) => a.eq_ignore_ascii_case(b),
        (Step::Bit(a), Step::Bit(b)) => a == b,
        (Step::Index(a), Step::Index(b)) => a.iter().zip(b).all(|(a, b)| match (a, b) {
            (Expression::Integer(a), Expression::Integer(b)) => a == b,
            // A calculated subscript may be any.
            _ => true,
        }),
        (Step::Bit(_) | Step::BitAt(_), Step::Bit(_) | Step::BitAt(_)) => true,
        _ => false,
    }
}

/// Aliases of aliases.
const MAX_ALIASES: usize = 16;
