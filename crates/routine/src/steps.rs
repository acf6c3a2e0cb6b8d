//! The steps of a project that can settle (see [`crate::run::Memory`]): rungs and statements of programs whose result depends on the memory alone,
//! and their operands. Any other is executed in each scan: what calls a routine, reads an attribute or leaves the rung with a true condition, what reads a
//! status bit or sends messages, and timers of Structured Text, which read the time in each scan. In a project that names the status bits of arithmetic (S:V, S:Z, S:N, S:C) no step settles, as
//! each result of another step stands in them.

use std::collections::BTreeMap;
use std::ops::Range;

use arcline_instruction_set::MotionControl;
use arcline_tag::Elementary;

use crate::code::{
    Action, AddOnCall, Area, Argument, Bit, Body, Cellular, Code, DintOperand, Ex, Index, Instruction, Node,
    NumberOperand, Place, RealOperand, Referenced, Rung, RungTimer, Select, Statement, TextPart,
};
use crate::readers::{Collector, Operands, Readers};
use crate::table::Op;

/// What is known of a step: whether it can settle, and the first byte of its timer ([`Rung::timer`]).
#[derive(Clone, Copy, Debug, Default)]
struct Step {
    settles: bool,
    timer: Option<u32>,
}

/// Numbers the steps of all programs, and finds the readers of the memory.
pub(crate) fn number(code: &mut Code) -> Readers {
    let mut collector = Collector::default();
    if code.uses_flags {
        return collector.readers();
    }
    let mut finder = Finder::new(code);
    // Of each routine the number of its first step, and its steps.
    let found: Vec<Option<(u32, Vec<Step>)>> = code
        .routines
        .iter()
        .map(|routine| {
            // The places of an add-on instruction are those of its calls.
            routine.of_program?;
            let known: Vec<Option<Vec<Operands>>> = match &routine.body {
                Body::Ladder(rungs) => rungs.iter().map(|rung| finder.of_rung(rung)).collect(),
                Body::Text(statements) => statements.iter().map(|one| finder.of_statement(one)).collect(),
            };
            let first = collector.add_steps(known.len());
            let rungs = match &routine.body {
                Body::Ladder(rungs) => &**rungs,
                Body::Text(_) => &[],
            };
            let found = (0..).zip(known).map(|(place, known)| {
                let Some(operands) = known else { return Step::default() };
                Step {
                    settles: collector.read(first + place as u32, &operands),
                    timer: rungs.get(place).and_then(|rung| timer(rung, &operands)),
                }
            });
            Some((first, found.collect()))
        })
        .collect();
    let readers = collector.readers();
    for (routine, found) in code.routines.iter_mut().zip(found) {
        let Some((first, found)) = found else { continue };
        routine.first_step = Some(first);
        match &mut routine.body {
            Body::Ladder(rungs) => {
                let mut behind = 0;
                for ((rung, step), number) in rungs.iter_mut().zip(found).zip(first..) {
                    behind += instructions(&rung.nodes) + 1;
                    let timer = step.timer.map(|at| RungTimer {
                        at,
                        is_read: times(at).any(|time| readers.has_others(&time, number)),
                    });
                    (rung.settles, rung.timer, rung.behind) = (step.settles, timer, behind);
                }
            }
            Body::Text(statements) => {
                for (statement, step) in statements.iter_mut().zip(found) {
                    statement.settles = step.settles;
                }
            }
        }
    }
    readers
}

/// The operands of an expression; `None`: its value depends on more than the memory.
pub(crate) fn operands(code: &Code, value: &Ex) -> Option<Vec<Operands>> {
    let mut finder = Finder::new(code);
    finder.expression(value)?;
    Some(finder.found)
}

/// Instructions of a rung: of all legs.
fn instructions(nodes: &[Node]) -> u32 {
    let of = |node: &Node| match node {
        Node::Branch(legs) => 1 + legs.iter().map(|leg| instructions(leg)).sum::<u32>(),
        _ => 1,
    };
    nodes.iter().map(of).sum()
}

/// The first byte of the only timer of a rung, if no other operand depends on its time: on ACC, or on the bits that hold the time of its last scan.
fn timer(rung: &Rung, operands: &[Operands]) -> Option<u32> {
    let mut found = Vec::new();
    timers(&rung.nodes, &mut found);
    let [Area { place, size, .. }] = found.as_slice() else {
        return None;
    };
    let at = place.fixed()?;
    let own = Operands {
        from: at,
        to: at + size,
        mask: 0xFF,
    };
    let depends = |one: &&Operands| times(at).any(|time| one.from < time.end && time.start < one.to);
    let mut dependent = operands.iter().filter(depends);
    (dependent.next() == Some(&own) && dependent.next().is_none()).then_some(at)
}

/// The bytes of a timer that change while it times.
fn times(at: u32) -> impl Iterator<Item = Range<u32>> {
    [at..at + TIME_OF_SCAN, at + ACCUMULATED..at + ACCUMULATED + 4].into_iter()
}

fn timers<'n>(nodes: &'n [Node], found: &mut Vec<&'n Area>) {
    for node in nodes {
        match node {
            Node::Branch(legs) => legs.iter().for_each(|leg| timers(leg, found)),
            Node::Instruction(instruction) => {
                if let (Op::Ton | Op::Tof | Op::Rto, [Argument::Area(area), ..]) =
                    (instruction.op, &*instruction.arguments)
                {
                    found.push(area);
                }
            }
            _ => {}
        }
    }
}

/// Bytes at the beginning of a timer that hold the time of its last scan, and the place of ACC.
const TIME_OF_SCAN: u32 = 3;
const ACCUMULATED: u32 = 8;

/// Finds the operands of a step.
struct Finder<'c> {
    code: &'c Code,
    /// The body of an add-on instruction is looked at: its places other than those of the memory itself are operands of the outermost call.
    is_inside: bool,
    /// The operands of the bodies of add-on instructions so far in the memory itself, where literals stand that they pass; `None`: their result depends
    /// on more than the memory.
    bodies: BTreeMap<u32, Option<Vec<Operands>>>,
    found: Vec<Operands>,
}

/// `Some`: its result depends on the memory alone, and its operands are noted.
type Known = Option<()>;

impl<'c> Finder<'c> {
    fn new(code: &'c Code) -> Self {
        Finder {
            code,
            is_inside: false,
            bodies: BTreeMap::new(),
            found: Vec::new(),
        }
    }

    /// The operands of a rung; `None`: it cannot settle.
    fn of_rung(&mut self, rung: &Rung) -> Option<Vec<Operands>> {
        self.found.clear();
        self.nodes(&rung.nodes)?;
        Some(std::mem::take(&mut self.found))
    }

    /// The same of a statement.
    fn of_statement(&mut self, statement: &Statement) -> Option<Vec<Operands>> {
        self.found.clear();
        self.statement(statement)?;
        Some(std::mem::take(&mut self.found))
    }

    fn note(&mut self, from: u32, to: u32, mask: u8) -> Known {
        self.found.push(Operands { from, to, mask });
        Some(())
    }

    fn nodes(&mut self, nodes: &[Node]) -> Known {
        nodes.iter().try_for_each(|node| match node {
            Node::Xic(at, mask)
            | Node::Xio(at, mask)
            | Node::Ote(at, mask)
            | Node::Otl(at, mask)
            | Node::Otu(at, mask)
            | Node::Ons(at, mask) => self.note(*at, at + 1, *mask),
            Node::Compute(_, a, b, to) => self.operands([*a, *b, DintOperand::At(*to)]),
            Node::Move(from, to) => self.operands([*from, DintOperand::At(*to)]),
            Node::Compare(_, a, b) => self.operands([*a, *b]),
            Node::ComputeReal(_, a, b, to) => self.operands([*a, *b, RealOperand::At(*to)]),
            Node::MoveReal(from, to) => self.operands([*from, RealOperand::At(*to)]),
            Node::CompareReal(_, a, b) => self.operands([*a, *b]),
            Node::Count(_, at) => self.note(*at, at + COUNTER, 0xFF),
            Node::Branch(legs) => legs.iter().try_for_each(|leg| self.nodes(leg)),
            Node::Instruction(instruction) => self.instruction(instruction),
        })
    }

    /// DINTs or REALs.
    fn operands<T, const N: usize>(&mut self, all: [NumberOperand<T>; N]) -> Known {
        all.into_iter().try_for_each(|one| match one {
            NumberOperand::Number(_) => Some(()),
            NumberOperand::At(at) => self.note(at, at + 4, 0xFF),
        })
    }

    fn statements(&mut self, statements: &[Statement]) -> Known {
        statements.iter().try_for_each(|one| self.statement(one))
    }

    fn statement(&mut self, statement: &Statement) -> Known {
        match &statement.action {
            Action::Assign(to, from, _) => {
                self.argument(to)?;
                self.argument(from)
            }
            Action::If(branches, otherwise) => {
                for (condition, body) in branches {
                    self.expression(condition)?;
                    self.statements(body)?;
                }
                self.statements(otherwise)
            }
            Action::Case(selector, arms, otherwise) => {
                self.expression(selector)?;
                for arm in arms {
                    for (first, last) in &arm.ranges {
                        self.expression(first)?;
                        self.expression(last)?;
                    }
                    self.statements(&arm.body)?;
                }
                self.statements(otherwise)
            }
            Action::For(of) => {
                self.number(&of.variable)?;
                self.expression(&of.from)?;
                self.expression(&of.to)?;
                self.expression(&of.by)?;
                self.statements(&of.body)
            }
            Action::While(condition, body) | Action::Repeat(body, condition) => {
                self.expression(condition)?;
                self.statements(body)
            }
            Action::Exit | Action::Return => Some(()),
            Action::Call(instruction) => self.instruction(instruction),
        }
    }

    fn instruction(&mut self, instruction: &Instruction) -> Known {
        match (instruction.op, &*instruction.arguments) {
            (Op::Ton | Op::Tof | Op::Rto | Op::Ctu | Op::Ctd | Op::Res, [Argument::Area(one), ..]) => {
                self.place(&one.place, one.size, 0xFF)
            }
            // What they do with a true rung is more than writes to the memory, or leaves the step: it settles with a false one.
            (Op::Jsr | Op::For | Op::Gsv | Op::Ssv | Op::Event | Op::Jmp | Op::Tnd | Op::Ret | Op::Brk, _) => Some(()),
            // Its operands are read when it executes, which no settled step does.
            (Op::Motion, [Argument::Motion(call)]) => self.place(&call.control, CONTROL, 0xFF),
            (Op::AddOn, [Argument::AddOn(call)]) => self.add_on(call),
            (
                Op::Ons
                | Op::Osr
                | Op::Osf
                | Op::Xic
                | Op::Xio
                | Op::Ote
                | Op::Otl
                | Op::Otu
                | Op::Compare(_)
                | Op::Cmp
                | Op::Lim
                | Op::Meq
                | Op::Compute
                | Op::Cpt
                | Op::Mov
                | Op::Mvm
                | Op::Btd
                | Op::Clr
                | Op::Swpb
                | Op::Cop
                | Op::Fll
                | Op::Size
                | Op::Fal
                | Op::Fsc
                | Op::Ave
                | Op::Std
                | Op::Srt
                | Op::Bsl
                | Op::Bsr
                | Op::Ffl
                | Op::Ffu
                | Op::Lfl
                | Op::Lfu
                | Op::Sqi
                | Op::Sqo
                | Op::Sql
                | Op::Nop
                | Op::Lbl
                | Op::Afi
                | Op::Uid
                | Op::Missing,
                all,
            ) => all.iter().try_for_each(|one| self.argument(one)),
            (op, all) if op.is_of_texts() => all.iter().try_for_each(|one| self.argument(one)),
            _ => None,
        }
    }

    fn argument(&mut self, argument: &Argument) -> Known {
        match argument {
            Argument::Shown | Argument::Word(_) | Argument::Label(_) => Some(()),
            Argument::Bit(bit) => self.bit(bit),
            Argument::Integer(value) | Argument::Real(value) => self.expression(value),
            Argument::Target(number) => self.number(number),
            Argument::Area(area) => self.area(area),
            Argument::Text(text) => self.text(text),
            _ => None,
        }
    }

    /// A call: its operands, the instance, and the body for the instructions in it.
    fn add_on(&mut self, call: &AddOnCall) -> Known {
        self.place(&call.instance, call.size, 0xFF)?;
        for reference in &call.references {
            self.reference(reference)?;
        }
        call.inputs.iter().try_for_each(|copy| self.argument(&copy.from))?;
        call.outputs.iter().try_for_each(|copy| self.argument(&copy.to))?;
        let was_inside = std::mem::replace(&mut self.is_inside, true);
        let copies = call.inputs.iter().map(|copy| &copy.to);
        let mut copies = copies.chain(call.outputs.iter().map(|copy| &copy.from));
        let known = copies
            .try_for_each(|one| self.argument(one))
            .and_then(|()| self.body(call.definition));
        self.is_inside = was_inside;
        known
    }

    /// The body of an add-on instruction, which is looked at once.
    fn body(&mut self, definition: u32) -> Known {
        if !self.bodies.contains_key(&definition) {
            // One within itself does not settle.
            self.bodies.insert(definition, None);
            let before = std::mem::take(&mut self.found);
            let known = self.routines_of(definition);
            let mut own = std::mem::replace(&mut self.found, before);
            own.sort_unstable();
            own.dedup();
            self.bodies.insert(definition, known.map(|()| own));
        }
        let own = self.bodies.get(&definition)?.as_ref()?;
        self.found.extend(own);
        Some(())
    }

    fn routines_of(&mut self, definition: u32) -> Known {
        let code = self.code;
        let definition = code.add_ons.get(definition as usize)?;
        let routines = [definition.logic, definition.enable_in_false];
        routines
            .into_iter()
            .flatten()
            .try_for_each(|routine| match &code.routines.get(routine as usize)?.body {
                Body::Ladder(rungs) => rungs.iter().try_for_each(|rung| self.nodes(&rung.nodes)),
                Body::Text(statements) => self.statements(statements),
            })
    }

    /// The operand of a parameter by reference.
    fn reference(&mut self, reference: &Referenced) -> Known {
        let Referenced { place, bit, sizes } = reference;
        match (bit, sizes) {
            (Some(Select::Mask(mask)), _) => self.place(place, 1, *mask),
            (None, Some(sizes)) => self.place(place, sizes.bytes, 0xFF),
            // One that the add-on instruction around has by reference itself.
            _ => self.place(place, 0, 0xFF).filter(|()| place.base != 0),
        }
    }

    fn expression(&mut self, value: &Ex) -> Known {
        match value {
            Ex::Integer(_) | Ex::Real(_) => Some(()),
            Ex::Dint(at) => self.note(*at, at + 4, 0xFF),
            Ex::Load(number) => self.number(number),
            Ex::Bit(bit) => self.bit(bit),
            Ex::Status(_) => None,
            Ex::ToReal(value, _)
            | Ex::ToInteger(value)
            | Ex::Negate(value)
            | Ex::NegateReal(value)
            | Ex::Invert(value)
            | Ex::IsZero(value)
            | Ex::Unsigned(value, _)
            | Ex::Function(_, _, value) => self.expression(value),
            Ex::Whole(_, both) | Ex::Float(_, _, both) | Ex::Compare(_, both) | Ex::CompareReal(_, both) => {
                self.expression(&both.0)?;
                self.expression(&both.1)
            }
            Ex::CompareText(_, both) => {
                self.text(&both.0)?;
                self.text(&both.1)
            }
        }
    }

    fn number(&mut self, number: &Cellular) -> Known {
        let is_bit = number.kind == Elementary::Bool;
        self.place(&number.place, number.kind.size() as u32, if is_bit { 1 } else { 0xFF })
    }

    fn bit(&mut self, bit: &Bit) -> Known {
        match &bit.select {
            Select::Mask(mask) => self.place(&bit.place, 1, *mask),
            Select::Referenced => self.place(&bit.place, 1, 0xFF),
            Select::Number { value, bits, .. } => {
                self.expression(value)?;
                self.place(&bit.place, bits.unwrap_or_default().div_ceil(8), 0xFF)
            }
        }
    }

    fn text(&mut self, text: &TextPart) -> Known {
        match text {
            TextPart::Literal(_) => Some(()),
            TextPart::Tag { place, data, capacity } => self.place(place, data + capacity, 0xFF),
        }
    }

    /// An area with all that stands behind it in its tag.
    fn area(&mut self, area: &Area) -> Known {
        let before = area.skipped;
        let place = Place {
            at: area.place.at.checked_sub(before)?,
            ..area.place.clone()
        };
        self.place(&place, area.end.saturating_sub(place.at), 0xFF)
    }

    /// Bytes at a place, wherever its subscripts lead.
    fn place(&mut self, place: &Place, size: u32, mask: u8) -> Known {
        let mut behind = 0;
        for Index {
            value, size, stride, ..
        } in &place.index
        {
            self.expression(value)?;
            behind += size.saturating_sub(1) * stride;
        }
        if place.base != 0 {
            return self.is_inside.then_some(());
        }
        self.note(place.at, place.at + behind + size, mask)
    }
}

/// Bytes of a counter.
const COUNTER: u32 = 12;
/// Bytes of a motion control tag.
const CONTROL: u32 = MotionControl::SIZE as u32;
