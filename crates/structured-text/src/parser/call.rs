//! Instruction calls: which operand takes which form is the catalogue's matter, and ranges are that of the
//! instruction when it executes.

use arcline_instruction_set::{Kind as OperandKind, Mnemonic, Object, Words};
use arcline_tag::{PathSegment, nearest};

use super::expression::ExpressionShape;
use super::{Parser, place_of};
use crate::code::{Meaning, Op, Part, WordPlace};
use crate::error::{SyntaxError, SyntaxProblem};
use crate::lexer::{Kind, Token};
use crate::program::CallStatement;

impl<'t> Parser<'t> {
    /// Everything behind the name, which must be a mnemonic.
    pub(super) fn call(&mut self, name: Token<'t>) -> Result<(), SyntaxError> {
        let Ok(mnemonic) = name.text.parse::<Mnemonic>() else {
            let known = Mnemonic::ALL.iter().map(ToString::to_string);
            let suggestion = nearest(name.text, known);
            let name_text = name.text.chars().take(60).collect();
            let problem = SyntaxProblem::UnknownInstruction {
                name: name_text,
                suggestion,
            };
            return Err(self.error(name.offset, problem));
        };
        self.expect("(", "`(` behind the instruction")?;
        let operands = mnemonic.instruction().operands;
        let ignored = mnemonic.instruction().ignored_operand();
        let before = self.text.get(..name.offset).unwrap_or_default();
        let line_start = before.rfind('\n').map_or(0, |at| at + 1);
        let mut statement = CallStatement {
            mnemonic,
            target: String::new(),
            control: None,
            line: name.line as usize,
            column: before[line_start..].chars().count() + 1,
        };
        let mut place = 0;
        let mut ignored = match ignored {
            Some(_) if self.operands_ahead()? <= operands.len() => None,
            ignored => ignored,
        };
        loop {
            let start = self.peek;
            if ignored == Some(place) {
                ignored = None;
                self.ignored_operand()?;
                self.expect(",", "`,` behind the operand")?;
                continue;
            }
            let Some(operand) = operands.get(place) else {
                let problem = SyntaxProblem::TooManyOperands {
                    mnemonic,
                    limit: operands.len(),
                };
                return Err(self.error(start.offset, problem));
            };
            match &operand.kind {
                OperandKind::Target(object) => {
                    let token = self.expect_kind(Kind::Name, object_name(*object))?;
                    self.uses(token.offset, Meaning::Object(*object, token.text.to_owned()));
                    statement.target = token.text.to_owned();
                }
                OperandKind::MotionControl => {
                    let token = self.expect_kind(Kind::Name, "the name of the motion control tag")?;
                    let path = self.path(token)?;
                    if self.program.paths[path as usize].computed() > 0 {
                        return Err(self.unexpected(&token, "a motion control tag without computed index"));
                    }
                    self.uses(token.offset, Meaning::Control(path));
                    statement.control = Some(self.program.paths[path as usize].sample().to_string());
                }
                kind => self.operand(mnemonic, place, kind)?,
            }
            place += 1;
            if self.peek.is(",") {
                self.advance()?;
            } else {
                self.expect(")", "`,` or `)` behind the operand")?;
                break;
            }
        }
        let place = place_of(self.program.calls.len());
        self.program.calls.push(statement);
        self.emit(Op::Call(place));
        Ok(())
    }

    /// The number of operands in front of the end of the call.
    fn operands_ahead(&self) -> Result<usize, SyntaxError> {
        let (mut lexer, mut token) = (self.lexer, self.peek);
        let (mut count, mut depth) = (1, 0_usize);
        while token.kind != Kind::End && !token.is(";") {
            match token.text {
                "(" | "[" => depth += 1,
                ")" | "]" if depth == 0 => break,
                ")" | "]" => depth -= 1,
                "," if depth == 0 => count += 1,
                _ => {}
            }
            token = lexer.next()?;
        }
        Ok(count)
    }

    /// A word or a number that means nothing: any word will do.
    fn ignored_operand(&mut self) -> Result<(), SyntaxError> {
        if self.peek.kind == Kind::Name {
            self.advance()?;
            self.emit(Op::Number(0.0));
        } else {
            self.expression()?;
        }
        self.emit(Op::OperandNumber);
        Ok(())
    }

    fn operand(&mut self, mnemonic: Mnemonic, place: usize, kind: &'static OperandKind) -> Result<(), SyntaxError> {
        match kind {
            OperandKind::Word(words) => return self.word_operand(mnemonic, place, words),
            OperandKind::Object(object) if self.peek.kind == Kind::Name => {
                let token = self.peek;
                self.advance()?;
                self.uses(token.offset, Meaning::Object(*object, token.text.to_owned()));
                let path = self.add_path(vec![Part::Fixed(PathSegment::Symbol(token.text.to_owned()))], token);
                self.emit(Op::OperandName(path));
                return Ok(());
            }
            OperandKind::Array(_) | OperandKind::ArrayOrNone if self.peek.is("[") => {
                return self.array();
            }
            OperandKind::ArrayOrNone | OperandKind::WrittenArray(_) | OperandKind::StructureOrNone(_)
                if self.peek.is_word("None") =>
            {
                self.advance()?;
                self.emit(Op::Number(0.0));
                self.emit(Op::OperandNumber);
                return Ok(());
            }
            _ => {}
        }
        let start = self.peek;
        let shape = self.expression()?;
        let op = match (kind, shape) {
            (OperandKind::Array(_) | OperandKind::ArrayOrNone, ExpressionShape::Path(path)) => Op::OperandRead(path),
            (
                OperandKind::WrittenArray(_) | OperandKind::Structure(_) | OperandKind::StructureOrNone(_),
                ExpressionShape::Path(path),
            ) => {
                // The instruction writes or keeps the tag itself: a variable of the program does not do.
                self.program.uses.pop();
                self.uses(start.offset, Meaning::Written(path));
                Op::OperandName(path)
            }
            _ => {
                self.emit(Op::OperandNumber);
                return Ok(());
            }
        };
        // The path itself goes into the call instead of its value.
        self.program.ops.pop();
        self.emit(op);
        Ok(())
    }

    /// `[a, b, …]`
    fn array(&mut self) -> Result<(), SyntaxError> {
        self.advance()?;
        let mut count = 0;
        loop {
            self.expression()?;
            count += 1;
            if self.peek.is(",") {
                self.advance()?;
            } else {
                self.expect("]", "`,` or `]`")?;
                break;
            }
        }
        self.emit(Op::OperandArray(count));
        Ok(())
    }

    /// An enumeration word in any spelling; other text is an expression.
    fn word_operand(&mut self, mnemonic: Mnemonic, place: usize, words: &'static Words) -> Result<(), SyntaxError> {
        /// `% of Time Master Driven` is the longest word there is, in tokens.
        const LONGEST: usize = 8;
        /// Memory for most words.
        const LONGEST_BYTES: usize = 32;
        let start = self.peek;
        let (mut lexer, mut token) = (self.lexer, self.peek);
        let mut text = String::with_capacity(LONGEST_BYTES);
        let mut count = 0;
        let mut end = self.last_end;
        while count <= LONGEST
            && (matches!(token.kind, Kind::Name | Kind::Number) || ["%", "-", "/"].iter().any(|sign| token.is(sign)))
        {
            text.push_str(token.text);
            count += 1;
            end = token.offset + token.text.len();
            token = lexer.next()?;
        }
        let named = text.contains(|c: char| c.is_ascii_alphabetic());
        if named
            && (token.is(",") || token.is(")"))
            && let Some(value) = words.parse_word(&text)
        {
            (self.lexer, self.peek, self.last_end) = (lexer, token, end);
            self.emit(Op::Number(value.into()));
            self.emit(Op::OperandNumber);
            return Ok(());
        }
        let context = WordPlace {
            mnemonic,
            place,
            text: text.chars().take(60).collect(),
            offset: start.offset,
        };
        if start.is("%") {
            return Err(unknown_word(self.text, &context, std::iter::empty()));
        }
        self.word = named.then_some(context);
        self.expression()?;
        self.word = None;
        self.emit(Op::OperandNumber);
        Ok(())
    }
}

/// The error of a word that an operand does not have. `tags`: names that could stand there too.
pub(crate) fn unknown_word(text: &str, word: &WordPlace, tags: impl Iterator<Item = String>) -> SyntaxError {
    let operand = word.mnemonic.instruction().operands.get(word.place);
    let words = match operand.map(|operand| &operand.kind) {
        Some(OperandKind::Word(words)) => words.words,
        _ => &[],
    };
    let keywords = words.iter().map(|word| word.keyword());
    let problem = SyntaxProblem::UnknownWord {
        place: word.place,
        operand: operand.map_or("", |operand| operand.name),
        word: word.text.clone(),
        suggestion: nearest(&word.text, keywords.chain(tags)),
    };
    SyntaxError::new(text, word.offset, problem)
}

fn object_name(object: Object) -> &'static str {
    match object {
        Object::MotionGroup => "the name of the motion group",
        Object::Axis => "the name of an axis",
        Object::CoordinateSystem => "the name of a coordinate system",
    }
}
