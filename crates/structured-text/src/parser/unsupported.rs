//! Constructs of IEC 61131-3 and of Logix that this dialect does not have: the error of a program that uses one names it.

use super::Parser;
use crate::error::{SyntaxError, SyntaxProblem};
use crate::lexer::Token;

impl<'t> Parser<'t> {
    /// The error of a statement that begins with a word of another dialect; `None` where the name is assigned or has members.
    pub(super) fn unsupported_statement(&self, name: &Token<'t>) -> Option<SyntaxError> {
        if [":=", ".", "["].iter().any(|sign| self.peek.is(sign)) {
            return None;
        }
        let (word, instead) = STATEMENTS.iter().find(|(word, _)| name.is_word(word))?;
        Some(self.not_supported(name, format!("{word} statement"), instead))
    }

    /// The error of a call within an expression.
    pub(super) fn unsupported_function(&self, name: &Token<'t>) -> SyntaxError {
        let name_text: String = name.text.chars().take(60).collect();
        let instead = "operators are + - * / MOD, comparisons, AND OR XOR NOT";
        self.not_supported(name, format!("function {name_text}"), instead)
    }

    /// The error of a sign of another dialect where something else must stand.
    pub(super) fn unsupported_sign(&self, token: &Token<'t>) -> Option<SyntaxError> {
        let (_, construct, instead) = SIGNS.iter().find(|(sign, ..)| token.is(sign))?;
        Some(self.not_supported(token, (*construct).to_owned(), instead))
    }

    /// The error of an index that is the sign of a retentive assignment.
    pub(super) fn unsupported_assignment(&self, token: &Token<'t>) -> Option<SyntaxError> {
        let error = || self.not_supported(token, "assignment [:=]".to_owned(), "use :=");
        token.is(":=").then(error)
    }

    fn not_supported(&self, token: &Token<'t>, construct: String, instead: &'static str) -> SyntaxError {
        self.error(token.offset, SyntaxProblem::NotSupported { construct, instead })
    }
}

/// The first word of a statement, and the construct to use instead of it.
const STATEMENTS: &[(&str, &str)] = &[
    ("CASE", "use IF, ELSIF and ELSE"),
    ("RETURN", "a program ends with its last statement"),
    ("CONTINUE", "use IF around the rest of the loop"),
    ("VAR", "a name that a program assigns and that is no tag is a variable"),
    ("JSR", "a program is one text"),
    ("SBR", "a program is one text"),
    ("RET", "a program is one text"),
];

/// A sign in front of a value or a statement, the construct that it begins, and the construct to use instead.
const SIGNS: &[(&str, &str, &str)] = &[
    (".", "number that begins with its point", "write 0.5 for .5"),
    ("*", "operator **", "multiply instead"),
    ("/", "comment /* */", "comments are // and (* *)"),
];
