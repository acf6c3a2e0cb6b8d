//! Structured Text of a routine (spec/programs.md §12): statements with the lines that they stand in.
//!
//! The text is scanned from top to end each scan. It is not the sequential language of motion programs
//! (`arcline-structured-text`), whose statements wait. A [`Text`] prints as it was read, comments included.

use std::fmt;

use crate::SyntaxError;
use crate::expression::{Expression, MAX_DEPTH, Parser, TagReference};
use crate::lexer::{TokenKind, tokens};

/// The statements of a routine.
#[derive(Clone, PartialEq, Debug)]
pub struct Text {
    /// The text as it was read.
    pub source: String,
    /// The statements.
    pub statements: Vec<Statement>,
}

/// A statement and where it begins.
#[derive(Clone, PartialEq, Debug)]
pub struct Statement {
    /// Byte in the text.
    pub at: usize,
    /// The kind of the statement, with its parts.
    pub kind: StatementKind,
}

/// The kind of a statement.
#[derive(Clone, PartialEq, Debug)]
pub enum StatementKind {
    /// `a := b;`, or `a [:=] b;`, which is not retentive.
    Assign {
        /// The tag.
        target: TagReference,
        /// Its value.
        value: Expression,
        /// Whether entering Run sets the tag to 0.
        is_retentive: bool,
    },
    /// Conditions with their statements, and the statements of ELSE.
    If(Vec<(Expression, Vec<Statement>)>, Vec<Statement>),
    /// A selector, the ranges and statements of its cases, and the statements of ELSE.
    Case(Expression, Vec<CaseArm>, Vec<Statement>),
    /// FOR with its variable, first and last value, step, and body.
    For {
        /// The variable.
        variable: TagReference,
        /// Its first value.
        from: Expression,
        /// Its last value.
        to: Expression,
        /// The step; 1 if there is none.
        by: Option<Expression>,
        /// The statements.
        body: Vec<Statement>,
    },
    /// WHILE with its condition.
    While(Expression, Vec<Statement>),
    /// REPEAT with the condition that ends it.
    Repeat(Vec<Statement>, Expression),
    /// EXIT
    Exit,
    /// RETURN without values, as it is written without brackets.
    Return,
    /// An instruction with its operands.
    Call(String, Vec<CallOperand>),
    /// A semicolon alone.
    Empty,
}

/// The cases of one list of values.
#[derive(Clone, PartialEq, Debug)]
pub struct CaseArm {
    /// First and last value of each range.
    pub ranges: Vec<(Expression, Expression)>,
    /// The statements.
    pub body: Vec<Statement>,
}

/// An operand of an instruction.
#[derive(Clone, PartialEq, Debug)]
pub struct CallOperand {
    /// The text of the operand.
    pub text: String,
    /// Its first byte.
    pub at: usize,
}

impl Text {
    /// Reads the text of a routine.
    ///
    /// # Errors
    /// The error, with its byte in the text.
    pub fn parse(text: &str) -> Result<Self, SyntaxError> {
        if text.len() > MAX_ROUTINE {
            return Err(SyntaxError::TooLong { limit: MAX_ROUTINE });
        }
        let tokens = tokens(text)?;
        let mut reader = StReader {
            text,
            parser: Parser {
                tokens: &tokens,
                next: 0,
                depth: 0,
                operators: 0,
            },
        };
        let statements = reader.statements(&[])?;
        if *reader.parser.peek() != TokenKind::End {
            return Err(reader.parser.unexpected("a statement"));
        }
        Ok(Text {
            source: text.to_owned(),
            statements,
        })
    }
}

impl fmt::Display for Text {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.source)
    }
}

struct StReader<'p, 't> {
    text: &'t str,
    parser: Parser<'p, 't>,
}

impl<'t> StReader<'_, 't> {
    fn word(&self) -> Option<String> {
        match self.parser.peek() {
            TokenKind::Name(name) => Some(name.to_ascii_uppercase()),
            _ => None,
        }
    }

    fn take_word(&mut self, word: &str) -> bool {
        let found = self.word().is_some_and(|found| found == word);
        self.parser.next += usize::from(found);
        found
    }

    fn expect_word(&mut self, word: &'static str) -> Result<(), SyntaxError> {
        if self.take_word(word) {
            Ok(())
        } else {
            Err(self.parser.unexpected(word))
        }
    }

    /// Statements up to one of the words, which stays.
    fn statements(&mut self, ends: &[&str]) -> Result<Vec<Statement>, SyntaxError> {
        let mut statements = Vec::new();
        loop {
            if *self.parser.peek() == TokenKind::End {
                return Ok(statements);
            }
            if self.word().is_some_and(|word| ends.contains(&word.as_str())) {
                return Ok(statements);
            }
            let statement = self.deeper(Self::statement)?;
            statements.push(statement);
        }
    }

    fn deeper<T>(&mut self, parse: impl FnOnce(&mut Self) -> Result<T, SyntaxError>) -> Result<T, SyntaxError> {
        if self.parser.depth >= MAX_DEPTH {
            return Err(SyntaxError::TooDeep {
                at: self.parser.at(),
                limit: MAX_DEPTH,
            });
        }
        self.parser.depth += 1;
        let parsed = parse(self);
        self.parser.depth -= 1;
        parsed
    }

    fn statement(&mut self) -> Result<Statement, SyntaxError> {
        let at = self.parser.at();
        self.parser.operators = 0;
        if self.parser.take(";") {
            return Ok(Statement {
                at,
                kind: StatementKind::Empty,
            });
        }
        let word = self.word().unwrap_or_default();
        let kind = match word.as_str() {
            "IF" => self.if_()?,
            "CASE" => self.case()?,
            "FOR" => self.for_()?,
            "WHILE" => {
                self.parser.next += 1;
                let condition = self.parser.expression()?;
                self.expect_word("DO")?;
                let body = self.statements(&["END_WHILE"])?;
                self.expect_word("END_WHILE")?;
                StatementKind::While(condition, body)
            }
            "REPEAT" => {
                self.parser.next += 1;
                let body = self.statements(&["UNTIL"])?;
                self.expect_word("UNTIL")?;
                let condition = self.parser.expression()?;
                // A semicolon may stand behind the condition.
                self.parser.take(";");
                self.expect_word("END_REPEAT")?;
                StatementKind::Repeat(body, condition)
            }
            "EXIT" => {
                self.parser.next += 1;
                StatementKind::Exit
            }
            "RETURN" => {
                self.parser.next += 1;
                StatementKind::Return
            }
            _ => self.assignment_or_call()?,
        };
        self.parser.expect(";")?;
        Ok(Statement { at, kind })
    }

    fn if_(&mut self) -> Result<StatementKind, SyntaxError> {
        let mut branches = Vec::new();
        let mut otherwise = Vec::new();
        self.parser.next += 1;
        loop {
            let condition = self.parser.expression()?;
            self.expect_word("THEN")?;
            let body = self.statements(&["ELSIF", "ELSE", "END_IF"])?;
            branches.push((condition, body));
            if !self.take_word("ELSIF") {
                break;
            }
        }
        if self.take_word("ELSE") {
            otherwise = self.statements(&["END_IF"])?;
        }
        self.expect_word("END_IF")?;
        Ok(StatementKind::If(branches, otherwise))
    }

    fn case(&mut self) -> Result<StatementKind, SyntaxError> {
        self.parser.next += 1;
        let selector = self.parser.expression()?;
        self.expect_word("OF")?;
        let mut arms = Vec::new();
        let mut otherwise = Vec::new();
        loop {
            if self.take_word("ELSE") {
                self.parser.take(":");
                otherwise = self.statements(&["END_CASE"])?;
            }
            if self.take_word("END_CASE") {
                return Ok(StatementKind::Case(selector, arms, otherwise));
            }
            let mut ranges = Vec::new();
            loop {
                let first = self.parser.expression()?;
                let last = if self.parser.take("..") {
                    self.parser.expression()?
                } else {
                    first.clone()
                };
                ranges.push((first, last));
                if !self.parser.take(",") {
                    break;
                }
            }
            self.parser.expect(":")?;
            let mut body = Vec::new();
            loop {
                let ends = self.word().is_some_and(|word| word == "ELSE" || word == "END_CASE");
                if ends || self.begins_label() || *self.parser.peek() == TokenKind::End {
                    break;
                }
                let statement = self.deeper(Self::statement)?;
                body.push(statement);
            }
            arms.push(CaseArm { ranges, body });
        }
    }

    /// Whether a list of values comes, not a statement: only a list begins with a number, or has a colon.
    fn begins_label(&self) -> bool {
        let kind = |ahead: usize| {
            self.parser
                .tokens
                .get(self.parser.next + ahead)
                .map(|token| &token.kind)
        };
        match kind(0) {
            Some(TokenKind::Integer(_) | TokenKind::Symbol("-")) => true,
            Some(TokenKind::Name(_)) => matches!(kind(1), Some(TokenKind::Symbol(":" | ".." | ","))),
            _ => false,
        }
    }

    fn for_(&mut self) -> Result<StatementKind, SyntaxError> {
        // FOR is an instruction of ladder too, with brackets.
        if matches!(self.parser.tokens.get(self.parser.next + 1), Some(token) if token.kind == TokenKind::Symbol("(")) {
            return self.assignment_or_call();
        }
        self.parser.next += 1;
        let variable = self.parser.reference()?;
        self.parser.expect(":=")?;
        let from = self.parser.expression()?;
        self.expect_word("TO")?;
        let to = self.parser.expression()?;
        let by = if self.take_word("BY") {
            Some(self.parser.expression()?)
        } else {
            None
        };
        self.expect_word("DO")?;
        let body = self.statements(&["END_FOR"])?;
        self.expect_word("END_FOR")?;
        Ok(StatementKind::For {
            variable,
            from,
            to,
            by,
            body,
        })
    }

    fn assignment_or_call(&mut self) -> Result<StatementKind, SyntaxError> {
        let followed = self.parser.tokens.get(self.parser.next + 1).map(|token| &token.kind);
        if followed == Some(&TokenKind::Symbol("(")) {
            let name = self.parser.name("an instruction")?.to_owned();
            self.parser.next += 1;
            return Ok(StatementKind::Call(name, self.operands()?));
        }
        let target = self.parser.reference()?;
        // A call without brackets, as a routine without parameters.
        if self.parser.is(";") && target.steps.is_empty() {
            return Ok(StatementKind::Call(target.name, Vec::new()));
        }
        let is_retentive = if self.parser.take("[:=]") {
            false
        } else {
            self.parser.expect(":=")?;
            true
        };
        let value = self.parser.expression()?;
        Ok(StatementKind::Assign {
            target,
            value,
            is_retentive,
        })
    }

    /// Operands as text, since their meaning depends on the instruction.
    fn operands(&mut self) -> Result<Vec<CallOperand>, SyntaxError> {
        let mut operands = Vec::new();
        let mut depth = 0_usize;
        let mut from = self.parser.at();
        loop {
            // Comments around it do not belong to it.
            let text = self.text.get(from..self.parser.end_before()).unwrap_or_default();
            match self.parser.peek() {
                TokenKind::End => return Err(self.parser.unexpected(") behind the operands")),
                TokenKind::Symbol("(" | "[") => depth += 1,
                TokenKind::Symbol(")") if depth == 0 => {
                    if !(operands.is_empty() && text.trim().is_empty()) {
                        operands.push(CallOperand {
                            text: text.trim().to_owned(),
                            at: from,
                        });
                    }
                    self.parser.next += 1;
                    return Ok(operands);
                }
                TokenKind::Symbol(")" | "]") => {
                    depth = depth
                        .checked_sub(1)
                        .ok_or_else(|| self.parser.unexpected("brackets in pairs"))?;
                }
                TokenKind::Symbol(",") if depth == 0 => {
                    operands.push(CallOperand {
                        text: text.trim().to_owned(),
                        at: from,
                    });
                    self.parser.next += 1;
                    from = self.parser.at();
                    continue;
                }
                _ => {}
            }
            self.parser.next += 1;
        }
    }
}

/// Longest routine, bytes.
pub const MAX_ROUTINE: usize = 8 << 20;
