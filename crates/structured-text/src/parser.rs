//! From tokens to operations, in one pass. Which operand takes which form is the catalogue's matter
//! (`arcline-instruction-set`); this file only asks it.

use arcline_instruction_set::{Kind as OperandKind, Mnemonic, Object, Words};
use arcline_tag::{PathError, PathSegment, TagPath};

use crate::code::{Binary, Meaning, Op, Part, Path, Use, WordPlace};
use crate::error::{SyntaxError, SyntaxProblem, nearest};
use crate::lexer::{Kind, Lexer, Token, number};
use crate::program::{CallStatement, OperandText, Program};

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

/// What an expression turned out to be.
#[derive(Clone, Copy, PartialEq)]
enum Shape {
    /// A path and nothing else: the last operation reads it.
    Path(u32),
    Other,
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

    // Statements

    /// Statements up to one of the keywords, which stays; without keywords up to the end.
    fn statements(&mut self, ends: &[&str]) -> Result<(), SyntaxError> {
        self.deeper()?;
        loop {
            let token = self.peek;
            if token.kind == Kind::End && ends.is_empty() || ends.iter().any(|end| token.is_word(end)) {
                break;
            }
            if token.is(";") {
                self.advance()?;
                continue;
            }
            self.statement(ends)?;
            self.expect(";", "`;` at the end of the statement")?;
        }
        self.depth -= 1;
        Ok(())
    }

    fn statement(&mut self, ends: &[&str]) -> Result<(), SyntaxError> {
        let token = self.peek;
        if token.kind != Kind::Name {
            return Err(self.unexpected(&token, block_expected(ends)));
        }
        self.emit(Op::Statement(token.line));
        match keyword(token.text) {
            Some("IF") => self.if_statement(),
            Some("FOR") => self.for_statement(),
            Some("WHILE") => self.while_statement(),
            Some("REPEAT") => self.repeat_statement(),
            Some("EXIT") => {
                self.advance()?;
                let jump = self.program.ops.len();
                let Some(exits) = self.loops.last_mut() else {
                    return Err(self.unexpected(&token, "it only within FOR, WHILE or REPEAT"));
                };
                exits.push(jump);
                self.emit(Op::Jump(0));
                Ok(())
            }
            Some("WAIT") => {
                self.advance()?;
                self.expect("(", "`(` behind WAIT")?;
                let start = self.here();
                self.expression()?;
                self.expect(")", "`)` or an operator")?;
                let done = self.emit(Op::JumpIfTrue(0));
                self.emit(Op::Tick);
                self.emit(Op::Jump(start));
                self.patch(done);
                Ok(())
            }
            Some("DELAY") => {
                self.advance()?;
                self.expect("(", "`(` behind DELAY")?;
                self.expression()?;
                self.expect(")", "`)` or an operator")?;
                self.emit(Op::Delay);
                Ok(())
            }
            Some(_) => Err(self.unexpected(&token, block_expected(ends))),
            None => {
                self.advance()?;
                if self.peek.is("(") {
                    self.call(token)
                } else {
                    self.assignment(token)
                }
            }
        }
    }

    fn if_statement(&mut self) -> Result<(), SyntaxError> {
        let mut ends = Vec::new();
        loop {
            // IF or ELSIF
            self.advance()?;
            self.expression()?;
            self.expect_word("THEN", "THEN or an operator")?;
            let otherwise = self.emit(Op::JumpIfFalse(0));
            self.statements(&["ELSIF", "ELSE", "END_IF"])?;
            ends.push(self.emit(Op::Jump(0)));
            self.patch(otherwise);
            if self.peek.is_word("ELSIF") {
                continue;
            }
            if self.peek.is_word("ELSE") {
                self.advance()?;
                self.statements(&["END_IF"])?;
            }
            self.expect_word("END_IF", "END_IF")?;
            break;
        }
        for end in ends {
            self.patch(end);
        }
        Ok(())
    }

    fn for_statement(&mut self) -> Result<(), SyntaxError> {
        self.advance()?;
        let name = self.expect_kind(Kind::Name, "the variable of FOR")?;
        let variable = self.path(name)?;
        if self.program.paths[variable as usize].computed() > 0 {
            return Err(self.unexpected(&name, "a variable without computed index"));
        }
        self.uses(name.offset, Meaning::Assigned(variable));
        self.expect(":=", "`:=` behind the variable of FOR")?;
        self.expression()?;
        self.emit(Op::Store(variable));
        let limit = self.hidden_variable();
        self.expect_word("TO", "TO or an operator")?;
        self.expression()?;
        self.emit(Op::SetVariable(limit));
        let step = self.hidden_variable();
        if self.peek.is_word("BY") {
            self.advance()?;
            self.expression()?;
        } else {
            self.emit(Op::Number(1.0));
        }
        self.emit(Op::SetVariable(step));
        let line = self.peek.line;
        self.expect_word("DO", "DO or an operator")?;

        let start = self.here();
        self.emit(Op::Statement(line));
        self.emit(Op::Read(variable));
        self.emit(Op::Variable(limit));
        self.emit(Op::Variable(step));
        self.emit(Op::ForTest);
        let done = self.emit(Op::JumpIfFalse(0));
        self.loops.push(Vec::new());
        self.statements(&["END_FOR"])?;
        self.advance()?;
        self.emit(Op::Read(variable));
        self.emit(Op::Variable(step));
        self.emit(Op::Binary(Binary::Add));
        self.emit(Op::Store(variable));
        self.emit(Op::Jump(start));
        self.patch(done);
        self.end_loop();
        Ok(())
    }

    fn while_statement(&mut self) -> Result<(), SyntaxError> {
        let start = self.here();
        self.emit(Op::Statement(self.peek.line));
        self.advance()?;
        self.expression()?;
        self.expect_word("DO", "DO or an operator")?;
        let done = self.emit(Op::JumpIfFalse(0));
        self.loops.push(Vec::new());
        self.statements(&["END_WHILE"])?;
        self.advance()?;
        self.emit(Op::Jump(start));
        self.patch(done);
        self.end_loop();
        Ok(())
    }

    fn repeat_statement(&mut self) -> Result<(), SyntaxError> {
        let start = self.here();
        self.emit(Op::Statement(self.peek.line));
        self.advance()?;
        self.loops.push(Vec::new());
        self.statements(&["UNTIL"])?;
        self.advance()?;
        self.expression()?;
        self.expect_word("END_REPEAT", "END_REPEAT or an operator")?;
        self.emit(Op::JumpIfFalse(start));
        self.end_loop();
        Ok(())
    }

    fn end_loop(&mut self) {
        for exit in self.loops.pop().unwrap_or_default() {
            self.patch(exit);
        }
    }

    fn assignment(&mut self, name: Token<'t>) -> Result<(), SyntaxError> {
        let path = self.path(name)?;
        self.uses(name.offset, Meaning::Assigned(path));
        self.expect(":=", "`:=` for an assignment or `(` for a call")?;
        self.expression()?;
        self.emit(Op::Store(path));
        Ok(())
    }

    // Calls

    /// Everything behind the name, which must be a mnemonic.
    fn call(&mut self, name: Token<'t>) -> Result<(), SyntaxError> {
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
        let before = self.text.get(..name.offset).unwrap_or_default();
        let line_start = before.rfind('\n').map_or(0, |at| at + 1);
        let mut statement = CallStatement {
            mnemonic,
            target: String::new(),
            control: None,
            operands: Vec::new(),
            line: name.line as usize,
            column: before[line_start..].chars().count() + 1,
        };
        let mut place = 0;
        loop {
            let start = self.peek;
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
            statement.operands.push(OperandText {
                name: operand.name,
                text: self
                    .text
                    .get(start.offset..self.last_end)
                    .unwrap_or_default()
                    .to_owned(),
                offset: start.offset,
            });
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

    fn operand(&mut self, mnemonic: Mnemonic, place: usize, kind: &'static OperandKind) -> Result<(), SyntaxError> {
        match kind {
            OperandKind::Word(words) => return self.word_operand(mnemonic, place, words),
            OperandKind::Reference(object) if self.peek.kind == Kind::Name => {
                let token = self.peek;
                self.advance()?;
                self.uses(token.offset, Meaning::Object(*object, token.text.to_owned()));
                let path = self.add_path(vec![Part::Fixed(PathSegment::Symbol(token.text.to_owned()))], token);
                self.emit(Op::GiveName(path));
                return Ok(());
            }
            OperandKind::Array(_) | OperandKind::ArrayOrNone if self.peek.is("[") => {
                return self.array();
            }
            OperandKind::ArrayOrNone | OperandKind::WrittenArray(_) if self.peek.is_word("None") => {
                self.advance()?;
                self.emit(Op::Number(0.0));
                self.emit(Op::GiveNumber);
                return Ok(());
            }
            _ => {}
        }
        let start = self.peek;
        let shape = self.expression()?;
        let op = match (kind, shape) {
            (OperandKind::Array(_) | OperandKind::ArrayOrNone, Shape::Path(path)) => Op::GiveRead(path),
            (OperandKind::WrittenArray(_) | OperandKind::Structure(_), Shape::Path(path)) => {
                // The instruction writes or keeps the tag itself: a variable of the program does not do.
                self.program.uses.pop();
                self.uses(start.offset, Meaning::Written(path));
                Op::GiveName(path)
            }
            _ => {
                self.emit(Op::GiveNumber);
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
        self.emit(Op::GiveArray(count));
        Ok(())
    }

    /// An enumeration word in any spelling; what is none is an expression.
    fn word_operand(&mut self, mnemonic: Mnemonic, place: usize, words: &'static Words) -> Result<(), SyntaxError> {
        /// `% of Time Master Driven` is the longest word there is, in tokens.
        const LONGEST: usize = 8;
        let start = self.peek;
        let (mut lexer, mut token) = (self.lexer, self.peek);
        let mut text = String::new();
        let mut count = 0;
        while count <= LONGEST
            && (matches!(token.kind, Kind::Name | Kind::Number) || ["%", "-", "/"].iter().any(|sign| token.is(sign)))
        {
            text.push_str(token.text);
            count += 1;
            token = lexer.next()?;
        }
        let named = text.contains(|c: char| c.is_ascii_alphabetic());
        let context = WordPlace {
            mnemonic,
            place,
            text: text.chars().take(60).collect(),
            offset: start.offset,
        };
        if named && (token.is(",") || token.is(")")) && words.parse_word(&text).is_some() {
            for _ in 0..count {
                self.advance()?;
            }
            let word = place_of(self.program.words.len());
            self.program.words.push(text);
            self.emit(Op::GiveWord(word));
            return Ok(());
        }
        if start.is("%") {
            return Err(unknown_word(self.text, &context, std::iter::empty()));
        }
        self.word = named.then_some(context);
        self.expression()?;
        self.word = None;
        self.emit(Op::GiveNumber);
        Ok(())
    }

    // Expressions

    fn expression(&mut self) -> Result<Shape, SyntaxError> {
        self.binary(0)
    }

    /// Operators that bind at least as tightly as `level`.
    fn binary(&mut self, level: u8) -> Result<Shape, SyntaxError> {
        self.deeper()?;
        let mut shape = self.unary()?;
        while let Some((operator, binds)) = operator(&self.peek)
            && binds >= level
        {
            self.advance()?;
            self.binary(binds + 1)?;
            self.emit(Op::Binary(operator));
            shape = Shape::Other;
        }
        self.depth -= 1;
        Ok(shape)
    }

    fn unary(&mut self) -> Result<Shape, SyntaxError> {
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
        Ok(if signed { Shape::Other } else { shape })
    }

    fn primary(&mut self) -> Result<Shape, SyntaxError> {
        const EXPECTED: &str = "a number, a tag or `(`";
        let token = self.peek;
        match token.kind {
            Kind::Number => {
                self.advance()?;
                let value = self.number(&token)?;
                self.emit(Op::Number(value));
                Ok(Shape::Other)
            }
            Kind::Name if token.is_word("TRUE") || token.is_word("FALSE") => {
                self.advance()?;
                self.emit(Op::Bool(token.is_word("TRUE")));
                Ok(Shape::Other)
            }
            Kind::Name if keyword(token.text).is_none() => {
                self.advance()?;
                let path = self.path(token)?;
                self.uses(token.offset, Meaning::Read(path));
                self.emit(Op::Read(path));
                Ok(Shape::Path(path))
            }
            Kind::Sign if token.is("(") => {
                self.advance()?;
                self.expression()?;
                self.expect(")", "`)` or an operator")?;
                Ok(Shape::Other)
            }
            _ => Err(self.unexpected(&token, EXPECTED)),
        }
    }

    /// The rest of a tag path behind its name; operations of computed indices are emitted.
    fn path(&mut self, name: Token<'t>) -> Result<u32, SyntaxError> {
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

    // Tools

    fn add_path(&mut self, parts: Vec<Part>, name: Token<'t>) -> u32 {
        let place = place_of(self.program.paths.len());
        self.program.paths.push(Path {
            parts,
            offset: name.offset,
            variable: None,
        });
        place
    }

    fn hidden_variable(&mut self) -> u32 {
        self.program.variables += 1;
        self.program.variables - 1
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

    /// Lets the jump at `place` lead here.
    fn patch(&mut self, place: usize) {
        let here = self.here();
        match &mut self.program.ops[place] {
            Op::Jump(to) | Op::JumpIfFalse(to) | Op::JumpIfTrue(to) => *to = here,
            _ => {}
        }
    }

    fn deeper(&mut self) -> Result<(), SyntaxError> {
        self.depth += 1;
        if self.depth > MAX_DEPTH {
            return Err(self.error(self.peek.offset, SyntaxProblem::TooDeep { limit: MAX_DEPTH }));
        }
        Ok(())
    }

    fn number(&self, token: &Token<'_>) -> Result<f64, SyntaxError> {
        let found = || token.text.chars().take(60).collect();
        number(token.text).ok_or_else(|| self.error(token.offset, SyntaxProblem::Number { found: found() }))
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

pub(crate) fn object_name(object: Object) -> &'static str {
    match object {
        Object::MotionGroup => "the name of the motion group",
        Object::Axis => "the name of an axis",
        Object::CoordinateSystem => "the name of a coordinate system",
    }
}

/// The keyword in upper case, when the name is one.
fn keyword(text: &str) -> Option<&'static str> {
    KEYWORDS
        .iter()
        .copied()
        .find(|keyword| keyword.eq_ignore_ascii_case(text))
}

/// The operator and how tightly it binds (IEC 61131-3, table of operators).
fn operator(token: &Token<'_>) -> Option<(Binary, u8)> {
    let found = OPERATORS.iter().find(|(text, ..)| match token.kind {
        Kind::Sign => token.text == *text,
        Kind::Name => token.text.eq_ignore_ascii_case(text),
        _ => false,
    });
    found.map(|(_, operator, binds)| (*operator, *binds))
}

fn block_expected(ends: &[&str]) -> &'static str {
    match ends {
        [] => "a statement",
        ["END_IF"] => "a statement or END_IF",
        ["END_FOR"] => "a statement or END_FOR",
        ["END_WHILE"] => "a statement or END_WHILE",
        ["UNTIL"] => "a statement or UNTIL",
        _ => "a statement, ELSIF, ELSE or END_IF",
    }
}

/// Places fit: the program has at most [`MAX_TEXT`] bytes, and each makes a few operations at most.
fn place_of(length: usize) -> u32 {
    u32::try_from(length).expect("fewer than 2^32 operations in a bounded text")
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
