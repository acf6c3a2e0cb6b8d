//! From tokens to operations, in one pass: the parser's state and the functions that every rule of the grammar uses. The rules
//! are in the files of this folder, one for each kind.

mod attribute;
mod call;
mod expression;
mod path;
mod statement;
mod unsupported;

use crate::code::{Meaning, Op, Use, WordPlace};
use crate::error::{SyntaxError, SyntaxProblem};
use crate::lexer::{Kind, Lexer, Token};
use crate::program::Program;

pub(crate) use call::unknown_word;

/// Largest program, bytes.
pub(crate) const MAX_TEXT: usize = 8 << 20;
/// Deepest nesting of statements and parentheses, together.
pub(crate) const MAX_DEPTH: usize = 128;

/// Reads a whole program.
pub(crate) fn program(text: &str) -> Result<Program, SyntaxError> {
    let mut parser = Parser::new(text)?;
    parser.statements(&[])?;
    Ok(parser.finish())
}

/// Reads one call, with or without `;`.
pub(crate) fn call(text: &str) -> Result<Program, SyntaxError> {
    let mut parser = Parser::new(text)?;
    let name = parser.expect_kind(Kind::Name, "an instruction call such as MCS(CS1, Stop1, All)")?;
    parser.call(name)?;
    if parser.peek.is(";") {
        parser.advance()?;
    }
    parser.expect_kind(Kind::End, "nothing behind the call")?;
    Ok(parser.finish())
}

struct Parser<'t> {
    text: &'t str,
    lexer: Lexer<'t>,
    peek: Token<'t>,
    /// Byte offset behind the last token taken.
    last_end: usize,
    depth: usize,
    /// For every loop around this place, the EXIT jumps to patch.
    loops: Vec<Vec<usize>>,
    /// The word operand that is being read.
    word: Option<WordPlace>,
    program: Program,
}

impl<'t> Parser<'t> {
    fn new(text: &'t str) -> Result<Self, SyntaxError> {
        if text.len() > MAX_TEXT {
            return Err(SyntaxError::new(
                "",
                0,
                SyntaxProblem::TooLarge {
                    limit: MAX_TEXT,
                    unit: "bytes",
                },
            ));
        }
        let mut lexer = Lexer::new(text);
        let peek = lexer.next()?;
        let program = Program::empty(text);
        Ok(Self {
            text,
            lexer,
            peek,
            last_end: 0,
            depth: 0,
            loops: Vec::new(),
            word: None,
            program,
        })
    }

    fn finish(mut self) -> Program {
        self.emit(Op::End);
        self.program
    }

    fn uses(&mut self, offset: usize, meaning: Meaning) {
        let word = self.word.clone();
        self.program.uses.push(Use { offset, meaning, word });
    }

    fn emit(&mut self, op: Op) -> usize {
        self.program.ops.push(op);
        self.program.ops.len() - 1
    }

    fn here(&self) -> u32 {
        place_of(self.program.ops.len())
    }

    fn deeper(&mut self) -> Result<(), SyntaxError> {
        self.depth += 1;
        if self.depth > MAX_DEPTH {
            return Err(self.error(self.peek.offset, SyntaxProblem::TooDeep { limit: MAX_DEPTH }));
        }
        Ok(())
    }

    fn advance(&mut self) -> Result<(), SyntaxError> {
        self.last_end = self.peek.offset + self.peek.text.len();
        self.peek = self.lexer.next()?;
        Ok(())
    }

    fn expect(&mut self, sign: &str, expected: &'static str) -> Result<(), SyntaxError> {
        if !self.peek.is(sign) {
            return Err(self.unexpected(&self.peek, expected));
        }
        self.advance()
    }

    fn expect_word(&mut self, word: &str, expected: &'static str) -> Result<(), SyntaxError> {
        if !self.peek.is_word(word) {
            return Err(self.unexpected(&self.peek, expected));
        }
        self.advance()
    }

    fn expect_kind(&mut self, kind: Kind, expected: &'static str) -> Result<Token<'t>, SyntaxError> {
        let token = self.peek;
        if token.kind != kind {
            return Err(self.unexpected(&token, expected));
        }
        self.advance()?;
        Ok(token)
    }

    fn unexpected(&self, token: &Token<'_>, expected: &'static str) -> SyntaxError {
        self.error(
            token.offset,
            SyntaxProblem::Unexpected {
                found: token.quoted(),
                expected,
            },
        )
    }

    fn error(&self, offset: usize, problem: SyntaxProblem) -> SyntaxError {
        SyntaxError::new(self.text, offset, problem)
    }
}

/// The keyword in upper case, when the name is one.
fn keyword(text: &str) -> Option<&'static str> {
    KEYWORDS
        .iter()
        .copied()
        .find(|keyword| keyword.eq_ignore_ascii_case(text))
}

/// Places fit: the program has at most [`MAX_TEXT`] bytes, and each makes a few operations at most.
fn place_of(length: usize) -> u32 {
    u32::try_from(length).expect("fewer than 2^32 operations in a bounded text")
}

const KEYWORDS: &[&str] = &[
    "IF",
    "THEN",
    "ELSIF",
    "ELSE",
    "END_IF",
    "FOR",
    "TO",
    "BY",
    "DO",
    "END_FOR",
    "WHILE",
    "END_WHILE",
    "REPEAT",
    "UNTIL",
    "END_REPEAT",
    "EXIT",
    "WAIT",
    "DELAY",
    "AND",
    "OR",
    "XOR",
    "NOT",
    "MOD",
    "TRUE",
    "FALSE",
];
