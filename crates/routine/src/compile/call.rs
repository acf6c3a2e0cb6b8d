//! Rungs and instructions: the table's row, the operands by their kinds.

use arcline_tag::Elementary;

use super::expression::{Sort, arithmetic, cast, compared};
use super::fit::transfers;
use super::{Compiler, Wrong};
use crate::code::{Argument, Compare, DintOperand, Ex, Instruction, Node, RealOperand, Select, Transfer, Width};
use crate::error::FindingKind;
use crate::expression::{Binary, Expression};
use crate::rll::Element;
use crate::table::{self, Form, Op, Row};

impl Compiler<'_> {
    /// The elements of a rung or a leg.
    pub(crate) fn nodes(&mut self, elements: &[Element]) -> Box<[Node]> {
        let mut nodes = Vec::with_capacity(elements.len());
        for element in elements {
            match element {
                Element::Branch(legs) => {
                    let legs = legs.iter().map(|leg| self.nodes(leg)).collect();
                    nodes.push(Node::Branch(legs));
                }
                Element::Instruction(instruction) => {
                    let operands: Vec<&str> = instruction.operands().iter().map(|one| one.text.as_str()).collect();
                    if let Some(compiled) = self.instruction(&instruction.name, &operands) {
                        nodes.push(simple(compiled));
                    }
                }
            }
        }
        nodes.into()
    }

    /// An instruction; `None`: a finding says why not.
    pub(crate) fn instruction(&mut self, name: &str, operands: &[&str]) -> Option<Instruction> {
        match self.try_instruction(name, operands) {
            Ok(Some(instruction)) => Some(instruction),
            Ok(None) => {
                self.find(FindingKind::Instruction, name, "");
                Some(self.passed_over(name))
            }
            Err(wrong) => {
                let written = format!("{name}({})", operands.join(","));
                self.find(wrong.kind(), &written, &wrong.to_string());
                (wrong.kind() == FindingKind::Absent).then(|| self.passed_over(name))
            }
        }
    }

    /// An instruction that the scan passes over; one that decides the condition behind it is false.
    fn passed_over(&mut self, name: &str) -> Instruction {
        let decides = table::row(name).is_some_and(|row| row.form == Form::Input || row.op == Op::Ons);
        Instruction {
            op: if decides { Op::Afi } else { Op::Missing },
            name: self.text(name),
            arguments: Box::default(),
            is_edge: false,
        }
    }

    fn try_instruction(&mut self, name: &str, operands: &[&str]) -> Result<Option<Instruction>, Wrong> {
        if let Some(call) = self.add_on_call(name, operands)? {
            let name = self.text(name);
            let arguments = Box::new([Argument::AddOn(Box::new(call))]);
            return Ok(Some(Instruction {
                op: Op::AddOn,
                name,
                arguments,
                is_edge: false,
            }));
        }
        if let Some(call) = self.motion_call(name, operands)? {
            let name = self.text(name);
            let arguments = Box::new([Argument::Motion(Box::new(call))]);
            return Ok(Some(Instruction {
                op: Op::Motion,
                name,
                arguments,
                is_edge: true,
            }));
        }
        // In Structured Text ALMD has another list of operands.
        let row = table::row(name).filter(|row| !(self.is_text && row.op == Op::Almd));
        let Some(row) = row else { return Ok(None) };
        // Ladder may name the operand of an instruction without one: MCR() and NOP() have none.
        let operands = if row.operands.is_empty() && !row.takes_more() && operands == [""] {
            &[]
        } else {
            operands
        };
        let shown = self.without_shown(row, operands);
        let operands = shown.as_deref().unwrap_or(operands);
        let expected = row.operands.len();
        if operands.len() < expected || (operands.len() > expected && !row.takes_more()) {
            return Err(format!("{} operands, expected {expected}", operands.len()).into());
        }
        let arguments = match row.op {
            Op::Compute => self.compute(row, operands)?,
            Op::Compare(compare) => vec![Argument::Integer(self.compare(compare, operands)?)],
            Op::Jsr => vec![Argument::Transfer(Box::new(self.transfer(operands)?))],
            Op::Ret => operands
                .iter()
                .map(|text| self.data_or_number(text))
                .collect::<Result<_, _>>()?,
            Op::Sbr | Op::Lbl => Vec::new(),
            Op::Gsv | Op::Ssv => match self.system(row.op, operands)? {
                Some(system) => vec![Argument::System(Box::new(system))],
                None => {
                    let described = operands.iter().take(3).copied().collect::<Vec<_>>().join(" ");
                    self.find(FindingKind::Instruction, &format!("{name} {described}"), "");
                    let missing = self.missing_attribute(operands).ok_or("expected a tag")?;
                    vec![Argument::System(Box::new(missing))]
                }
            },
            _ => {
                let mut arguments = Vec::with_capacity(expected);
                for ((what, kind), text) in row.operands.iter().zip(operands) {
                    let argument = self
                        .operand(*kind, text)
                        .map_err(|reason| reason.of(format_args!("{what} {text}")))?;
                    arguments.push(argument);
                }
                self.promote(row.op, operands, &mut arguments)?;
                super::fit::check(row.op, &arguments)?;
                if row.operands.iter().any(|(_, kind)| *kind == table::Kind::Unsigned) {
                    fill_with_zeros(&mut arguments);
                }
                if let (Op::Msg, [message, ..]) = (row.op, operands) {
                    arguments.extend(self.reply(message));
                }
                arguments
            }
        };
        self.first_numbers(row, operands)?;
        let name = self.text(name);
        let is_edge = row.form == Form::Edge;
        Ok(Some(Instruction {
            op: row.op,
            name,
            arguments: arguments.into(),
            is_edge,
        }))
    }

    /// In Structured Text the operands that only show a structure's members may be left out.
    fn without_shown<'o>(&self, row: &Row, operands: &[&'o str]) -> Option<Vec<&'o str>> {
        let shown = row
            .operands
            .iter()
            .filter(|(_, kind)| *kind == table::Kind::Shown)
            .count();
        if shown == 0 || operands.len() + shown != row.operands.len() {
            return None;
        }
        let mut given = operands.iter();
        let all = row.operands.iter().map(|(_, kind)| {
            if *kind == table::Kind::Shown {
                "?"
            } else {
                given.next().copied().unwrap_or_default()
            }
        });
        Some(all.collect())
    }

    /// Arithmetic and functions: an expression of the type of the highest operand, the destination among them.
    fn compute(&mut self, row: &Row, operands: &[&str]) -> Result<Vec<Argument>, Wrong> {
        let (dest, sources) = operands.split_last().ok_or("expected operands")?;
        let target = self.operand(table::Kind::Target, dest)?;
        let least = sort_of(&target);
        let mut values = Vec::new();
        for source in sources {
            let expression = Expression::parse(source).map_err(|error| format!("{source}: {error}"))?;
            let value = self.number(&expression, least).map_err(|reason| reason.of(source))?;
            values.push(value);
        }
        let name = row.name();
        let (value, sort) = match (name, values.as_slice()) {
            ("AND" | "OR" | "XOR", [a, b]) => {
                let [a, b] = [a, b].map(|(value, sort)| unsigned(cast(value.clone(), *sort, Sort::Whole)));
                let operation = match name {
                    "AND" => crate::code::Whole::And,
                    "OR" => crate::code::Whole::Or,
                    _ => crate::code::Whole::Xor,
                };
                (Ex::Whole(operation, Box::new((a, b))), Sort::Whole)
            }
            ("NOT", [(value, sort)]) => (
                Ex::Invert(Box::new(unsigned(cast(value.clone(), *sort, Sort::Whole)))),
                Sort::Whole,
            ),
            ("NEG", [(value, sort)]) => {
                let to = (*sort).max(least).max(Sort::Whole);
                let value = cast(value.clone(), *sort, to);
                (
                    arithmetic(Binary::Subtract, cast(Ex::Integer(0), Sort::Whole, to), value, to),
                    to,
                )
            }
            ("ADD" | "SUB" | "MUL" | "DIV" | "MOD" | "XPY", [(a, from_a), (b, from_b)]) => {
                let to = (*from_a).max(*from_b).max(least).max(Sort::Whole);
                let operator = match name {
                    "ADD" => Binary::Add,
                    "SUB" => Binary::Subtract,
                    "MUL" => Binary::Multiply,
                    "DIV" => Binary::Divide,
                    "MOD" => Binary::Modulo,
                    _ => Binary::Power,
                };
                (
                    arithmetic(operator, cast(a.clone(), *from_a, to), cast(b.clone(), *from_b, to), to),
                    to,
                )
            }
            (_, [value]) => self.apply(name, value.clone(), least).ok_or("no such function")?,
            _ => return Err("wrong operands".into()),
        };
        let value = if sort.is_real() {
            Argument::Real(value)
        } else {
            Argument::Integer(value)
        };
        let mut arguments = vec![value, target];
        if matches!(name, "AND" | "OR" | "XOR" | "NOT") {
            // Bits do not overflow.
            arguments.push(Argument::Word(0));
        }
        // The carry is that of 32 bits.
        if let ("ADD" | "SUB", [(a, Sort::Whole), (b, Sort::Whole)], false) = (name, values.as_slice(), sort.is_real())
            && self.uses_carry
        {
            arguments.extend([
                Argument::Integer(a.clone()),
                Argument::Integer(b.clone()),
                Argument::Word(i32::from(name == "SUB")),
            ]);
        }
        Ok(arguments)
    }

    /// Expressions whose destination decides the type of the arithmetic.
    fn promote(&mut self, op: Op, operands: &[&str], arguments: &mut [Argument]) -> Result<(), Wrong> {
        let (target, value) = match op {
            Op::Cpt => (0, 1),
            Op::Fal => (4, 5),
            _ => return Ok(()),
        };
        let (Some(of), Some(text)) = (arguments.get(target), operands.get(value)) else {
            return Ok(());
        };
        let least = sort_of(of);
        if least.is_real()
            && let Some(place) = arguments.get_mut(value)
        {
            let expression = Expression::parse(text).map_err(|error| error.to_string())?;
            let (value, sort) = self.number(&expression, least)?;
            *place = Argument::Real(cast(value, sort, sort.max(Sort::Single)));
        }
        Ok(())
    }

    fn compare(&mut self, compare: Compare, operands: &[&str]) -> Result<Ex, Wrong> {
        let [a, b] = operands else {
            return Err("expected 2 operands".into());
        };
        let parse = |text: &str| Expression::parse(text).map_err(|error| format!("{text}: {error}"));
        let (left, right) = (parse(a)?, parse(b)?);
        if let Some(texts) = self.texts(compare, &left, &right)? {
            return Ok(texts);
        }
        let a = self.number(&left, Sort::Whole).map_err(|reason| reason.of(a))?;
        let b = self.number(&right, Sort::Whole).map_err(|reason| reason.of(b))?;
        Ok(compared(compare, a, b))
    }

    /// JSR: the routine, the number of inputs, inputs, returns.
    fn transfer(&mut self, operands: &[&str]) -> Result<Transfer, Wrong> {
        let (name, rest) = operands.split_first().ok_or("expected a routine")?;
        let routine = self
            .routine_id(name)
            .ok_or_else(|| Wrong::absent(format!("there is no routine {name}")))?;
        let (count, rest) = match rest.split_first() {
            None => (0, rest),
            Some((count, rest)) => {
                let count = count
                    .parse::<usize>()
                    .map_err(|_| format!("{count}, expected the number of inputs"))?;
                (count, rest)
            }
        };
        if count > rest.len() {
            return Err(format!("{count} inputs, but {} operands follow", rest.len()).into());
        }
        let (inputs, returns) = rest.split_at(count);
        let inputs: Box<[Argument]> = inputs
            .iter()
            .map(|text| self.data_or_number(text))
            .collect::<Result<_, _>>()?;
        let returns: Box<[Argument]> = returns
            .iter()
            .map(|text| self.written(text))
            .collect::<Result<_, _>>()?;
        let parameters = self.operands_of(routine, "SBR").unwrap_or_default();
        let parameters = parameters.iter().filter(|text| !text.is_empty());
        let parameters: Box<[Argument]> = parameters.map(|text| self.written(text)).collect::<Result<_, _>>()?;
        for (number, (from, to)) in inputs.iter().zip(&parameters).enumerate() {
            transfers(from, to).map_err(|reason| reason.of(format_args!("input {}", number + 1)))?;
        }
        let values = self.operands_of(routine, "RET").unwrap_or_default();
        for (number, (text, to)) in values.iter().filter(|text| !text.is_empty()).zip(&returns).enumerate() {
            let from = self.data_or_number(text)?;
            transfers(&from, to).map_err(|reason| reason.of(format_args!("return {}", number + 1)))?;
        }
        Ok(Transfer {
            routine,
            inputs,
            parameters,
            returns,
        })
    }
}

/// The type of a destination.
pub(crate) fn sort_of(target: &Argument) -> Sort {
    match target {
        Argument::Target(cell) => Sort::of(cell.kind),
        _ => Sort::Whole,
    }
}

/// Numbers in the text of a logical instruction have 32 bits beside tags of 32 bits or less.
fn fill_with_zeros(arguments: &mut [Argument]) {
    let is_long = |argument: &Argument| match argument {
        Argument::Integer(Ex::Load(cell)) => cell.kind.size() > 4,
        Argument::Target(cell) => cell.kind.size() > 4,
        _ => false,
    };
    if arguments.iter().any(is_long) {
        return;
    }
    for argument in arguments {
        if let Argument::Integer(Ex::Integer(value)) = argument {
            *value &= i64::from(u32::MAX);
        }
    }
}

/// A source of a logical instruction is not sign-extended.
pub(crate) fn unsigned(value: Ex) -> Ex {
    let size = match &value {
        Ex::Load(cell) => cell.kind.size(),
        Ex::Dint(_) => 4,
        _ => return value,
    };
    if size >= 8 {
        value
    } else {
        Ex::Unsigned(Box::new(value), size as u8)
    }
}

/// The short form of an instruction of one bit whose byte is known.
fn simple(instruction: Instruction) -> Node {
    let fixed = match instruction.arguments.first() {
        Some(Argument::Bit(bit)) => match (bit.place.fixed(), &bit.select) {
            (Some(at), Select::Mask(mask)) => Some((at, *mask)),
            _ => None,
        },
        _ => None,
    };
    let of_bit = match (instruction.op, fixed) {
        (Op::Xic, Some((at, mask))) => Some(Node::Xic(at, mask)),
        (Op::Xio, Some((at, mask))) => Some(Node::Xio(at, mask)),
        (Op::Ote, Some((at, mask))) => Some(Node::Ote(at, mask)),
        (Op::Otl, Some((at, mask))) => Some(Node::Otl(at, mask)),
        (Op::Otu, Some((at, mask))) => Some(Node::Otu(at, mask)),
        (Op::Ons, Some((at, mask))) => Some(Node::Ons(at, mask)),
        _ => None,
    };
    of_bit
        .or_else(|| of_dints(&instruction))
        .or_else(|| of_reals(&instruction))
        .or_else(|| of_counter(&instruction))
        .unwrap_or_else(|| Node::Instruction(Box::new(instruction)))
}

/// An instruction whose operands are DINTs with known places.
fn of_dints(instruction: &Instruction) -> Option<Node> {
    match (instruction.op, &*instruction.arguments) {
        (Op::Compute, [Argument::Integer(Ex::Whole(operation, operands)), target]) => {
            let (a, b) = (dint(&operands.0)?, dint(&operands.1)?);
            Some(Node::Compute(*operation, a, b, dint_target(target)?))
        }
        (Op::Mov, [Argument::Integer(value), target]) => Some(Node::Move(dint(value)?, dint_target(target)?)),
        (Op::Compare(_), [Argument::Integer(Ex::Compare(compare, operands))]) => {
            Some(Node::Compare(*compare, dint(&operands.0)?, dint(&operands.1)?))
        }
        _ => None,
    }
}

/// An instruction whose operands are REALs with known places.
fn of_reals(instruction: &Instruction) -> Option<Node> {
    match (instruction.op, &*instruction.arguments) {
        (Op::Compute, [Argument::Real(Ex::Float(operation, Width::Single, operands)), target]) => {
            let (a, b) = (real(&operands.0)?, real(&operands.1)?);
            Some(Node::ComputeReal(*operation, a, b, real_target(target)?))
        }
        (Op::Mov, [Argument::Real(value), target]) => Some(Node::MoveReal(real(value)?, real_target(target)?)),
        (Op::Compare(_), [Argument::Integer(Ex::CompareReal(compare, operands))]) => {
            Some(Node::CompareReal(*compare, real(&operands.0)?, real(&operands.1)?))
        }
        _ => None,
    }
}

/// A counter with a known place.
fn of_counter(instruction: &Instruction) -> Option<Node> {
    match (instruction.op, &*instruction.arguments) {
        (op @ (Op::Ctu | Op::Ctd), [Argument::Area(counter), ..]) => Some(Node::Count(op, counter.place.fixed()?)),
        _ => None,
    }
}

fn dint(value: &Ex) -> Option<DintOperand> {
    match value {
        Ex::Integer(number) => i32::try_from(*number).ok().map(DintOperand::Number),
        Ex::Dint(at) => Some(DintOperand::At(*at)),
        _ => None,
    }
}

fn real(value: &Ex) -> Option<RealOperand> {
    match value {
        Ex::Real(number) => Some(*number as f32)
            .filter(|single| f64::from(*single) == *number)
            .map(RealOperand::Number),
        Ex::Load(cell) if cell.kind == Elementary::Real => cell.place.fixed().map(RealOperand::At),
        _ => None,
    }
}

/// The first byte of a DINT with a known place.
fn dint_target(target: &Argument) -> Option<u32> {
    target_of(target, Elementary::Dint)
}

fn real_target(target: &Argument) -> Option<u32> {
    target_of(target, Elementary::Real)
}

fn target_of(target: &Argument, kind: Elementary) -> Option<u32> {
    match target {
        Argument::Target(cell) if cell.kind == kind => cell.place.fixed(),
        _ => None,
    }
}
