//! Expressions, by how tightly their operators bind (IEC 61131-3, table of operators).

use super::{Parser, keyword};
use crate::code::{Binary, Meaning, Op};
use crate::error::{SyntaxError, SyntaxProblem};
use crate::lexer::{Kind, Token, number};

/// The shape of a parsed expression.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum ExpressionShape {
    /// A path and nothing else: the last operation reads it.
    Path(u32),
    Other,
}

impl Parser<'_> {
    pub(super) fn expression(&mut self) -> Result<ExpressionShape, SyntaxError> {
        self.binary(0)
    }

    /// Operators that bind at least as tightly as `level`.
    fn binary(&mut self, level: u8) -> Result<ExpressionShape, SyntaxError> {
        self.deeper()?;
        let mut shape = self.unary()?;
        while let Some((operator, binds)) = operator(&self.peek)
            && binds >= level
        {
            self.advance()?;
            self.binary(binds + 1)?;
            self.emit(Op::Binary(operator));
            shape = ExpressionShape::Other;
        }
        self.depth -= 1;
        Ok(shape)
    }

    fn unary(&mut self) -> Result<ExpressionShape, SyntaxError> {
        let mut signs = Vec::new();
        loop {
            if self.peek.is("-") {
                signs.push(Op::Negate);
            } else if self.peek.is_word("NOT") {
                signs.push(Op::Not);
            } else if !self.peek.is("+") {
                break;
            }
            self.advance()?;
        }
        let shape = self.primary()?;
        let signed = !signs.is_empty();
        for sign in signs.into_iter().rev() {
            self.emit(sign);
        }
        Ok(if signed { ExpressionShape::Other } else { shape })
    }

    fn primary(&mut self) -> Result<ExpressionShape, SyntaxError> {
        const EXPECTED: &str = "a number, a tag or `(`";
        let token = self.peek;
        match token.kind {
            Kind::Number => {
                self.advance()?;
                let value = self.number(&token)?;
                self.emit(Op::Number(value));
                Ok(ExpressionShape::Other)
            }
            Kind::Name if token.is_word("TRUE") || token.is_word("FALSE") => {
                self.advance()?;
                self.emit(Op::Bool(token.is_word("TRUE")));
                Ok(ExpressionShape::Other)
            }
            Kind::Name if keyword(token.text).is_none() => {
                self.advance()?;
                if self.peek.is("(") {
                    return Err(self.unsupported_function(&token));
                }
                let path = self.path(token)?;
                self.uses(token.offset, Meaning::Read(path));
                self.emit(Op::Read(path));
                Ok(ExpressionShape::Path(path))
            }
            Kind::Sign if token.is("(") => {
                self.advance()?;
                self.expression()?;
                self.expect(")", "`)` or an operator")?;
                Ok(ExpressionShape::Other)
            }
            _ => Err(self
                .unsupported_sign(&token)
                .unwrap_or_else(|| self.unexpected(&token, EXPECTED))),
        }
    }

    fn number(&self, token: &Token<'_>) -> Result<f64, SyntaxError> {
        let found = || token.text.chars().take(60).collect();
        number(token.text).ok_or_else(|| self.error(token.offset, SyntaxProblem::Number { found: found() }))
    }
}

/// The operator and how tightly it binds (IEC 61131-3, table of operators).
fn operator(token: &Token<'_>) -> Option<(Binary, u8)> {
    // Most expressions are an operand and end here.
    if matches!(token.text, "," | ")" | "]" | ";") {
        return None;
    }
    let found = OPERATORS.iter().find(|(text, ..)| match token.kind {
        Kind::Sign => token.text == *text,
        Kind::Name => token.text.eq_ignore_ascii_case(text),
        _ => false,
    });
    found.map(|(_, operator, binds)| (*operator, *binds))
}

const OPERATORS: &[(&str, Binary, u8)] = &[
    ("OR", Binary::Or, 0),
    ("XOR", Binary::Xor, 1),
    ("AND", Binary::And, 2),
    ("&", Binary::And, 2),
    ("=", Binary::Equal, 3),
    ("<>", Binary::NotEqual, 3),
    ("<", Binary::Less, 4),
    (">", Binary::Greater, 4),
    ("<=", Binary::LessEqual, 4),
    (">=", Binary::GreaterEqual, 4),
    ("+", Binary::Add, 5),
    ("-", Binary::Subtract, 5),
    ("*", Binary::Multiply, 6),
    ("/", Binary::Divide, 6),
    ("MOD", Binary::Modulo, 6),
];
