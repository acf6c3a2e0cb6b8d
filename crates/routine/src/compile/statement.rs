//! Statements of Structured Text.

use arcline_tag::DataType;

use super::expression::{Sort, cast};
use super::{Compiler, Lines, Wrong};
use crate::code::{Action, Argument, Arm, Cellular, Ex, Loop, Statement, TextPart};
use crate::error::Line;
use crate::expression::Expression;
use crate::st::{self, StatementKind};
use crate::types::text_layout;

impl Compiler<'_> {
    pub(crate) fn statements(&mut self, statements: &[st::Statement], lines: &Lines<'_>) -> Box<[Statement]> {
        let mut compiled = Vec::with_capacity(statements.len());
        for statement in statements {
            let line = lines.number(statement.at);
            self.set_line(Line::Text(line));
            match self.statement(statement, lines) {
                Ok(Some(action)) => compiled.push(Statement {
                    line,
                    settles: false,
                    action,
                }),
                Ok(None) => {}
                Err(wrong) => {
                    self.set_line(Line::Text(line));
                    self.find(wrong.kind(), "statement", &wrong.to_string());
                }
            }
        }
        compiled.into()
    }

    fn statement(&mut self, statement: &st::Statement, lines: &Lines<'_>) -> Result<Option<Action>, Wrong> {
        Ok(Some(match &statement.kind {
            StatementKind::Empty => return Ok(None),
            StatementKind::Exit => Action::Exit,
            StatementKind::Return => Action::Return,
            StatementKind::Assign {
                target,
                value,
                is_retentive,
            } => {
                let written = format!("{target}");
                let (to, from) = self
                    .assignment(&Expression::Reference(target.clone()), value)
                    .map_err(|reason| reason.of(format_args!("{written} := {value}")))?;
                Action::Assign(to, from, *is_retentive)
            }
            StatementKind::If(branches, otherwise) => {
                let mut compiled = Vec::new();
                for (condition, body) in branches {
                    let condition = self.condition(condition)?;
                    compiled.push((condition, self.statements(body, lines)));
                }
                Action::If(compiled.into(), self.statements(otherwise, lines))
            }
            StatementKind::Case(selector, arms, otherwise) => {
                let selector = self.whole(selector)?;
                let mut compiled = Vec::new();
                for arm in arms {
                    let mut ranges = Vec::new();
                    for (first, last) in &arm.ranges {
                        ranges.push((self.whole(first)?, self.whole(last)?));
                    }
                    compiled.push(Arm {
                        ranges: ranges.into(),
                        body: self.statements(&arm.body, lines),
                    });
                }
                Action::Case(selector, compiled.into(), self.statements(otherwise, lines))
            }
            StatementKind::For {
                variable,
                from,
                to,
                by,
                body,
            } => {
                let target = self.target(&Expression::Reference(variable.clone()))?;
                let Argument::Target(variable) = target else {
                    return Err(format!("{variable} cannot count, expected a whole number").into());
                };
                let (from, to) = (self.whole(from)?, self.whole(to)?);
                let by = by.as_ref().map_or(Ok(Ex::Integer(1)), |by| self.whole(by))?;
                let body = self.statements(body, lines);
                Action::For(Box::new(Loop {
                    variable,
                    from,
                    to,
                    by,
                    body,
                }))
            }
            StatementKind::While(condition, body) => {
                Action::While(self.condition(condition)?, self.statements(body, lines))
            }
            StatementKind::Repeat(body, condition) => {
                let condition = self.condition(condition)?;
                Action::Repeat(self.statements(body, lines), condition)
            }
            StatementKind::Call(name, operands) => {
                let operands: Vec<&str> = operands.iter().map(|operand| operand.text.as_str()).collect();
                match self.instruction(name, &operands) {
                    Some(instruction) => Action::Call(instruction),
                    None => return Ok(None),
                }
            }
        }))
    }

    /// The value of a condition, as a truth value.
    pub(crate) fn truth(&mut self, expression: &Expression) -> Result<Ex, Wrong> {
        match self.number(expression, Sort::Whole)? {
            (value, sort) if sort.is_real() => Ok(Ex::CompareReal(
                crate::code::Compare::NotEqual,
                Box::new((value, Ex::Real(0.0))),
            )),
            (value, _) => Ok(value),
        }
    }

    /// A tag and a value that is written to it from outside.
    pub(crate) fn value_for(&mut self, target: &Expression, value: &str) -> Result<(Argument, Argument), Wrong> {
        let value = match value.to_ascii_lowercase().as_str() {
            "true" => Expression::Integer(1),
            "false" => Expression::Integer(0),
            _ => Expression::parse(value).map_err(|error| error.to_string())?,
        };
        self.assignment(target, &value)
    }

    fn condition(&mut self, condition: &Expression) -> Result<Ex, Wrong> {
        let (value, sort) = self
            .number(condition, Sort::Whole)
            .map_err(|reason| reason.of(condition))?;
        Ok(cast(value, sort, Sort::Whole))
    }

    /// The tag and the value of an assignment: numbers, bits, texts, and whole structures of one type.
    fn assignment(&mut self, target: &Expression, value: &Expression) -> Result<(Argument, Argument), Wrong> {
        let Expression::Reference(reference) = target else {
            return Err("expected a tag".into());
        };
        let found = self.resolve(reference)?;
        if let (Some((data, capacity)), false) = (text_layout(&found.data_type), found.is_array()) {
            let to = TextPart::Tag {
                place: found.place(),
                data,
                capacity,
            };
            if let Some(from) = self.text_part(value) {
                return Ok((Argument::Text(to), Argument::Text(from)));
            }
        }
        if matches!(found.data_type, DataType::Structure(_)) || found.is_array() {
            let (from, to) = (self.data(value)?, Argument::Area(found.area()));
            super::fit::transfers(&from, &to)?;
            return Ok((to, from));
        }
        let to = self.target(target)?;
        let from = self.value(value)?;
        if let (Argument::Target(Cellular { kind, .. }), Argument::Integer(whole)) = (&to, &from)
            && kind.is_real()
        {
            let value = cast(whole.clone(), Sort::Whole, Sort::of(*kind));
            return Ok((to, Argument::Real(value)));
        }
        Ok((to, from))
    }
}
