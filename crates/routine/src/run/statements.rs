//! Structured Text (spec/programs.md §12): from top to end in each scan.

use super::Number;
use super::{Exit, Run, Scan};
use crate::code::{Action, Argument, Instruction, Loop, Statement, TextPart};
use crate::table::Op;

impl<'s> Scan<'s> {
    /// The statements of a routine from its first step on. Settled ones are passed over.
    pub(crate) fn text_routine(&mut self, statements: &'s [Statement], first_step: Option<u32>) -> Run<()> {
        let mut next = 0;
        while let Some(statement) = statements.get(next) {
            self.s.line = statement.line;
            let step = first_step.map(|first| first + next as u32);
            let settled = self.settled_statements(step, statements.len() - next);
            if settled > 0 {
                let over = statements.get(next..next + settled).unwrap_or_default();
                self.check_settled(&[], over);
                next += settled;
                self.go_on(settled)?;
                continue;
            }
            let settling = step.filter(|_| statement.settles);
            let changes = self.begin_step(settling);
            self.statement_of_scan(statement)?;
            self.end_step(settling, changes, None);
            next += 1;
        }
        Ok(())
    }

    pub(crate) fn statements(&mut self, statements: &'s [Statement]) -> Run<()> {
        statements
            .iter()
            .try_for_each(|statement| self.statement_of_scan(statement))
    }

    /// Executes a statement, after the writes of clients, and handles its fault.
    fn statement_of_scan(&mut self, statement: &'s Statement) -> Run<()> {
        self.s.line = statement.line;
        match self
            .spend(1)
            .and_then(|()| self.pass())
            .and_then(|()| self.statement(statement))
        {
            Err(Exit::Fault) if self.recovers() => Ok(()),
            done => done,
        }
    }

    fn statement(&mut self, statement: &'s Statement) -> Run<()> {
        self.set_instruction(0);
        if self.s.prescan {
            return self.prescan_statement(statement);
        }
        match &statement.action {
            Action::Assign(to, from, _) => self.assignment(to, from),
            Action::If(branches, otherwise) => {
                for (condition, body) in branches {
                    if self.whole(condition)? != 0 {
                        return self.statements(body);
                    }
                }
                self.statements(otherwise)
            }
            Action::Case(selector, arms, otherwise) => {
                let value = self.whole(selector)?;
                for arm in arms {
                    for (first, last) in &arm.ranges {
                        if self.whole(first)? <= value && value <= self.whole(last)? {
                            return self.statements(&arm.body);
                        }
                    }
                }
                self.statements(otherwise)
            }
            Action::For(of) => self.for_(of),
            Action::While(condition, body) => {
                while self.whole(condition)? != 0 {
                    self.spend(1)?;
                    if self.turn(body)? {
                        break;
                    }
                }
                Ok(())
            }
            Action::Repeat(body, condition) => loop {
                self.spend(1)?;
                if self.turn(body)? || self.whole(condition)? != 0 {
                    return Ok(());
                }
            },
            Action::Exit => Err(Exit::Loop),
            Action::Return => Err(Exit::Return),
            Action::Call(instruction) => self.call_instruction(instruction),
        }
    }

    /// The body of a loop; true: EXIT ended it.
    fn turn(&mut self, body: &'s [Statement]) -> Run<bool> {
        match self.statements(body) {
            Ok(()) => Ok(false),
            Err(Exit::Loop) => Ok(true),
            Err(exit) => Err(exit),
        }
    }

    fn for_(&mut self, of: &'s Loop) -> Run<()> {
        let (mut value, to, by) = (self.whole(&of.from)?, self.whole(&of.to)?, self.whole(&of.by)?);
        self.store(&of.variable, Number::Whole(value))?;
        while if by >= 0 { value <= to } else { value >= to } {
            self.spend(1)?;
            if self.turn(&of.body)? {
                return Ok(());
            }
            let at = self.address(&of.variable.place)?;
            value = self.read_whole(at, of.variable.kind).wrapping_add(by);
            self.store(&of.variable, Number::Whole(value))?;
        }
        Ok(())
    }

    fn assignment(&mut self, to: &'s Argument, from: &'s Argument) -> Run<()> {
        match (to, from) {
            (Argument::Text(to), Argument::Text(from)) => self.copy_text(from, to),
            (Argument::Area(_), Argument::Area(_)) => self.copy_value(from, to),
            (to, from) => {
                let value = self.argument(from)?;
                self.assign(to, value)
            }
        }
    }

    /// A tag that is not retentive becomes 0, and a text empty.
    fn clear(&mut self, to: &Argument) -> Run<()> {
        match to {
            Argument::Text(TextPart::Tag { place, .. }) => {
                let at = self.address(place)?;
                self.put_dint(at, 0);
                Ok(())
            }
            Argument::Area(area) => {
                let range = self.range(area)?;
                let end = if area.is_whole {
                    range.array_end
                } else {
                    range.at + area.size
                };
                self.s.memory.fill(range.at as usize..end as usize, 0);
                Ok(())
            }
            to => self.assign(to, Number::Whole(0)),
        }
    }

    fn call_instruction(&mut self, instruction: &'s Instruction) -> Run<()> {
        // Instructions of edges see a false rung before the true one.
        if instruction.is_edge && instruction.op != Op::Motion {
            self.instruction(instruction, false)?;
        }
        self.instruction(instruction, true).map(|_| ())
    }

    /// Instructions in their form for prescan; tags that are not retentive become 0.
    fn prescan_statement(&mut self, statement: &'s Statement) -> Run<()> {
        match &statement.action {
            Action::Assign(to, _, false) => self.clear(to),
            Action::Assign(..) | Action::Exit | Action::Return => Ok(()),
            Action::If(branches, otherwise) => {
                for (_, body) in branches {
                    self.statements(body)?;
                }
                self.statements(otherwise)
            }
            Action::Case(_, arms, otherwise) => {
                for arm in arms {
                    self.statements(&arm.body)?;
                }
                self.statements(otherwise)
            }
            Action::For(of) => self.statements(&of.body),
            Action::While(_, body) | Action::Repeat(body, _) => self.statements(body),
            Action::Call(instruction) => self.instruction(instruction, false).map(|_| ()),
        }
    }
}
