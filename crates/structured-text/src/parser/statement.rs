//! Statements: `IF`, loops, `WAIT`, `DELAY`, assignments. Jumps are patched once their end is known.

use super::{Parser, keyword};
use crate::code::{Binary, Meaning, Op};
use crate::error::SyntaxError;
use crate::lexer::{Kind, Token};

impl<'t> Parser<'t> {
    /// Statements up to one of the keywords, which stays; without keywords up to the end.
    pub(super) fn statements(&mut self, ends: &[&str]) -> Result<(), SyntaxError> {
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
            if token.is("/")
                && let Some(error) = self.unsupported_sign(&token)
            {
                return Err(error);
            }
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
                if let Some(error) = self.unsupported_statement(&token) {
                    return Err(error);
                }
                if self.peek.is("(") && Self::is_system_value(&token) {
                    self.system_value(token)
                } else if self.peek.is("(") {
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

    fn hidden_variable(&mut self) -> u32 {
        self.program.variables += 1;
        self.program.variables - 1
    }

    /// Lets the jump at `place` lead here.
    fn patch(&mut self, place: usize) {
        let here = self.here();
        match &mut self.program.ops[place] {
            Op::Jump(to) | Op::JumpIfFalse(to) | Op::JumpIfTrue(to) => *to = here,
            _ => {}
        }
    }
}

/// The text for messages about a missing statement, in front of these ends.
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
