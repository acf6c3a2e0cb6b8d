//! Expressions of ladder and of Structured Text (spec/programs.md §5, §6) in operands, subscripts and assignments.
//!
//! Both languages have one order of precedence here; comparisons stand below + and −, above AND, XOR and OR.

use std::fmt;

use crate::SyntaxError;
use crate::lexer::{Token, TokenKind, tokens};

/// An expression.
#[derive(Clone, PartialEq, Debug)]
pub enum Expression {
    /// A whole number.
    Integer(i64),
    /// A number with a point or exponent.
    Real(f64),
    /// A text in quotes, its bytes.
    Text(Vec<u8>),
    /// A tag or a part of one.
    Reference(TagReference),
    /// An operator before its operand.
    Unary(Unary, Box<Expression>),
    /// An operator between its operands.
    Binary(Binary, Box<(Expression, Expression)>),
    /// A function of its argument.
    Call(String, Vec<Expression>),
}

/// A tag or a part of one.
#[derive(Clone, PartialEq, Debug)]
pub struct TagReference {
    /// The program, of a parameter of another program (`\Program.Name`).
    pub program: Option<String>,
    /// The tag's name, with the colons of a module's tag.
    pub name: String,
    /// The steps from the tag to its part.
    pub steps: Vec<Step>,
    /// Byte in the text.
    pub at: usize,
}

/// A step from a tag to a part of it.
#[derive(Clone, PartialEq, Debug)]
pub enum Step {
    /// A member of a structure.
    Member(String),
    /// An element of an array, up to three subscripts.
    Index(Vec<Expression>),
    /// A bit of an integer.
    Bit(i64),
    /// A bit whose number is calculated.
    BitAt(Box<Expression>),
}

/// An operator before its operand.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Unary {
    /// `-`
    Negate,
    /// `NOT`
    Not,
}

/// An operator between its operands.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[allow(missing_docs)]
pub enum Binary {
    Power,
    Multiply,
    Divide,
    Modulo,
    Add,
    Subtract,
    Less,
    LessEqual,
    Greater,
    GreaterEqual,
    Equal,
    NotEqual,
    And,
    Xor,
    Or,
}

impl Binary {
    /// Higher binds tighter.
    fn rank(self) -> u8 {
        match self {
            Self::Power => 8,
            Self::Multiply | Self::Divide | Self::Modulo => 7,
            Self::Add | Self::Subtract => 6,
            Self::Less | Self::LessEqual | Self::Greater | Self::GreaterEqual => 5,
            Self::Equal | Self::NotEqual => 4,
            Self::And => 3,
            Self::Xor => 2,
            Self::Or => 1,
        }
    }

    fn of(kind: &TokenKind<'_>) -> Option<Self> {
        Some(match kind {
            TokenKind::Symbol(symbol) => match *symbol {
                "**" => Self::Power,
                "*" => Self::Multiply,
                "/" => Self::Divide,
                "+" => Self::Add,
                "-" => Self::Subtract,
                "<" => Self::Less,
                "<=" => Self::LessEqual,
                ">" => Self::Greater,
                ">=" => Self::GreaterEqual,
                "=" => Self::Equal,
                "<>" => Self::NotEqual,
                "&" | "&&" => Self::And,
                "^" | "^^" => Self::Xor,
                "|" | "||" => Self::Or,
                _ => return None,
            },
            TokenKind::Name(name) => match name.to_ascii_uppercase().as_str() {
                "MOD" => Self::Modulo,
                "AND" => Self::And,
                "XOR" => Self::Xor,
                "OR" => Self::Or,
                _ => return None,
            },
            _ => return None,
        })
    }

    fn symbol(self) -> &'static str {
        match self {
            Self::Power => "**",
            Self::Multiply => "*",
            Self::Divide => "/",
            Self::Modulo => " MOD ",
            Self::Add => "+",
            Self::Subtract => "-",
            Self::Less => "<",
            Self::LessEqual => "<=",
            Self::Greater => ">",
            Self::GreaterEqual => ">=",
            Self::Equal => "=",
            Self::NotEqual => "<>",
            Self::And => " AND ",
            Self::Xor => " XOR ",
            Self::Or => " OR ",
        }
    }
}

impl Expression {
    /// Reads a text that is an expression and nothing else.
    ///
    /// # Errors
    /// The error, with its byte in the text.
    pub fn parse(text: &str) -> Result<Self, SyntaxError> {
        if text.len() > MAX_TEXT {
            return Err(SyntaxError::TooLong { limit: MAX_TEXT });
        }
        let tokens = tokens(text)?;
        let mut parser = Parser {
            tokens: &tokens,
            next: 0,
            depth: 0,
            operators: 0,
        };
        let expression = parser.expression()?;
        parser.expect_end()?;
        Ok(expression)
    }

    /// Reads a text that is a reference and nothing else.
    ///
    /// # Errors
    /// The error, with its byte in the text.
    pub fn parse_reference(text: &str) -> Result<TagReference, SyntaxError> {
        match Self::parse(text)? {
            Self::Reference(reference) => Ok(reference),
            _ => Err(SyntaxError::Unexpected {
                at: 0,
                found: shortened(text),
                expected: "a tag",
            }),
        }
    }
}

impl fmt::Display for Expression {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Integer(value) => write!(f, "{value}"),
            Self::Real(value) => write!(f, "{value:?}"),
            Self::Text(bytes) => {
                f.write_str("'")?;
                for byte in bytes {
                    match byte {
                        b'\'' | b'$' => write!(f, "${}", char::from(*byte))?,
                        0x20..=0x7E => write!(f, "{}", char::from(*byte))?,
                        _ => write!(f, "${byte:02X}")?,
                    }
                }
                f.write_str("'")
            }
            Self::Reference(reference) => write!(f, "{reference}"),
            Self::Unary(Unary::Negate, operand) => write!(f, "(-{operand})"),
            Self::Unary(Unary::Not, operand) => write!(f, "(NOT {operand})"),
            Self::Binary(operator, operands) => write!(f, "({}{}{})", operands.0, operator.symbol(), operands.1),
            Self::Call(name, arguments) => {
                let arguments: Vec<String> = arguments.iter().map(ToString::to_string).collect();
                write!(f, "{name}({})", arguments.join(","))
            }
        }
    }
}

impl fmt::Display for TagReference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(program) = &self.program {
            write!(f, "\\{program}.")?;
        }
        f.write_str(&self.name)?;
        for step in &self.steps {
            match step {
                Step::Member(name) => write!(f, ".{name}")?,
                Step::Index(values) => {
                    let values: Vec<String> = values.iter().map(ToString::to_string).collect();
                    write!(f, "[{}]", values.join(","))?;
                }
                Step::Bit(bit) => write!(f, ".{bit}")?,
                Step::BitAt(value) => write!(f, ".[{value}]")?,
            }
        }
        Ok(())
    }
}

/// Reads tokens; shared with Structured Text.
pub(crate) struct Parser<'p, 't> {
    pub(crate) tokens: &'p [Token<'t>],
    pub(crate) next: usize,
    pub(crate) depth: usize,
    /// Operators of the outermost expression, which bound the depth of its tree.
    pub(crate) operators: usize,
}

impl<'t> Parser<'_, 't> {
    pub(crate) fn peek(&self) -> &TokenKind<'t> {
        self.tokens.get(self.next).map_or(&TokenKind::End, |token| &token.kind)
    }

    pub(crate) fn at(&self) -> usize {
        let last = || self.tokens.last().map_or(0, |token| token.at);
        self.tokens.get(self.next).map_or_else(last, |token| token.at)
    }

    /// The end of the token before.
    pub(crate) fn end_before(&self) -> usize {
        let before = self.next.checked_sub(1).and_then(|before| self.tokens.get(before));
        before.map_or(0, |token| token.end)
    }

    pub(crate) fn is(&self, symbol: &str) -> bool {
        matches!(self.peek(), TokenKind::Symbol(found) if *found == symbol)
    }

    pub(crate) fn take(&mut self, symbol: &str) -> bool {
        let found = self.is(symbol);
        self.next += usize::from(found);
        found
    }

    pub(crate) fn expect(&mut self, symbol: &'static str) -> Result<(), SyntaxError> {
        if self.take(symbol) {
            Ok(())
        } else {
            Err(self.unexpected(symbol))
        }
    }

    pub(crate) fn unexpected(&self, expected: &'static str) -> SyntaxError {
        let found = match self.peek() {
            TokenKind::End => "the end".to_owned(),
            TokenKind::Name(name) => shortened(name),
            TokenKind::Symbol(symbol) => (*symbol).to_owned(),
            TokenKind::Integer(value) => value.to_string(),
            TokenKind::Real(value) => value.to_string(),
            TokenKind::Text(_) => "a text".to_owned(),
        };
        SyntaxError::Unexpected {
            at: self.at(),
            found,
            expected,
        }
    }

    pub(crate) fn name(&mut self, expected: &'static str) -> Result<&'t str, SyntaxError> {
        match self.tokens.get(self.next).map(|token| &token.kind) {
            Some(TokenKind::Name(name)) => {
                self.next += 1;
                Ok(name)
            }
            _ => Err(self.unexpected(expected)),
        }
    }

    fn expect_end(&self) -> Result<(), SyntaxError> {
        match self.peek() {
            TokenKind::End => Ok(()),
            _ => Err(self.unexpected("the end")),
        }
    }

    pub(crate) fn deeper<T>(
        &mut self,
        parse: impl FnOnce(&mut Self) -> Result<T, SyntaxError>,
    ) -> Result<T, SyntaxError> {
        if self.depth >= MAX_DEPTH {
            return Err(SyntaxError::TooDeep {
                at: self.at(),
                limit: MAX_DEPTH,
            });
        }
        self.depth += 1;
        let parsed = parse(self);
        self.depth -= 1;
        parsed
    }

    pub(crate) fn expression(&mut self) -> Result<Expression, SyntaxError> {
        self.deeper(|parser| parser.binary(1))
    }

    fn binary(&mut self, least: u8) -> Result<Expression, SyntaxError> {
        let mut left = self.unary()?;
        while let Some(operator) = Binary::of(self.peek()).filter(|operator| operator.rank() >= least) {
            self.operators += 1;
            if self.operators > MAX_OPERATORS {
                return Err(SyntaxError::TooDeep {
                    at: self.at(),
                    limit: MAX_OPERATORS,
                });
            }
            self.next += 1;
            let right = self.deeper(|parser| parser.binary(operator.rank() + 1))?;
            left = Expression::Binary(operator, Box::new((left, right)));
        }
        Ok(left)
    }

    fn unary(&mut self) -> Result<Expression, SyntaxError> {
        let is_not = self.is("!") || matches!(self.peek(), TokenKind::Name(name) if name.eq_ignore_ascii_case("NOT"));
        let operator = if self.is("-") {
            Unary::Negate
        } else if is_not {
            Unary::Not
        } else if self.take("+") {
            return self.deeper(Self::unary);
        } else {
            return self.primary();
        };
        self.next += 1;
        // A power binds tighter than the sign before it.
        let mut operand = self.deeper(Self::unary)?;
        while self.is("**") {
            self.operators += 1;
            if self.operators > MAX_OPERATORS {
                return Err(SyntaxError::TooDeep {
                    at: self.at(),
                    limit: MAX_OPERATORS,
                });
            }
            self.next += 1;
            let right = self.deeper(Self::unary)?;
            operand = Expression::Binary(Binary::Power, Box::new((operand, right)));
        }
        Ok(Expression::Unary(operator, Box::new(operand)))
    }

    fn primary(&mut self) -> Result<Expression, SyntaxError> {
        let token = self.tokens.get(self.next).map(|token| token.kind.clone());
        match token {
            Some(TokenKind::Integer(value)) => {
                self.next += 1;
                Ok(Expression::Integer(value))
            }
            Some(TokenKind::Real(value)) => {
                self.next += 1;
                Ok(Expression::Real(value))
            }
            Some(TokenKind::Text(bytes)) => {
                self.next += 1;
                Ok(Expression::Text(bytes))
            }
            Some(TokenKind::Symbol("(")) => {
                self.next += 1;
                let inner = self.expression()?;
                self.expect(")")?;
                Ok(inner)
            }
            Some(TokenKind::Name(name)) => {
                let followed = self.tokens.get(self.next + 1).map(|token| &token.kind);
                if followed == Some(&TokenKind::Symbol("(")) {
                    self.next += 2;
                    let arguments = self.list(")")?;
                    return Ok(Expression::Call(name.to_owned(), arguments));
                }
                self.reference().map(Expression::Reference)
            }
            Some(TokenKind::Symbol("\\")) => self.reference().map(Expression::Reference),
            _ => Err(self.unexpected("a number, a tag or an expression in brackets")),
        }
    }

    /// Expressions between commas up to a closing sign.
    pub(crate) fn list(&mut self, end: &'static str) -> Result<Vec<Expression>, SyntaxError> {
        let mut items = Vec::new();
        if self.take(end) {
            return Ok(items);
        }
        loop {
            items.push(self.expression()?);
            if self.take(end) {
                return Ok(items);
            }
            self.expect(",")?;
        }
    }

    pub(crate) fn reference(&mut self) -> Result<TagReference, SyntaxError> {
        let at = self.at();
        let mut program = None;
        if self.take("\\") {
            program = Some(self.name("a program")?.to_owned());
            self.expect(".")?;
        }
        let name = self.name("a tag")?.to_owned();
        let mut steps = Vec::new();
        loop {
            if steps.len() > MAX_DEPTH {
                return Err(SyntaxError::TooDeep { at, limit: MAX_DEPTH });
            }
            if self.take("[") {
                let values = self.list("]")?;
                if values.is_empty() || values.len() > 3 {
                    return Err(self.unexpected("one to three subscripts"));
                }
                steps.push(Step::Index(values));
            } else if self.take(".") {
                if self.take("[") {
                    let value = self.expression()?;
                    self.expect("]")?;
                    steps.push(Step::BitAt(Box::new(value)));
                } else if let TokenKind::Integer(bit) = *self.peek() {
                    self.next += 1;
                    steps.push(Step::Bit(bit));
                } else {
                    steps.push(Step::Member(self.name("a member or a bit")?.to_owned()));
                }
            } else {
                return Ok(TagReference {
                    program,
                    name,
                    steps,
                    at,
                });
            }
        }
    }
}

/// The beginning of a text for a message.
pub(crate) fn shortened(text: &str) -> String {
    text.chars().take(40).collect()
}

/// Longest expression, bytes.
pub const MAX_TEXT: usize = 1 << 16;
/// Deepest nesting.
pub const MAX_DEPTH: usize = 64;
/// Operators of an expression, those in its brackets and subscripts among them.
const MAX_OPERATORS: usize = 500;
