//! Faults (spec/programs.md §16): where they happened, fault routines.

use std::fmt;

use super::{Exit, Pace, Run, Scan};
use crate::code::{Code, TextId};
use crate::error::Line;

/// A major fault, where it happened.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) struct FaultAt {
    pub(crate) kind: u16,
    pub(crate) code: u16,
    pub(crate) program: u32,
    pub(crate) routine: u32,
    pub(crate) line: u32,
    pub(crate) instruction: TextId,
    /// The operand at fault and its value.
    pub(crate) operand: Option<(TextId, i64)>,
}

/// A major fault in words.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Fault {
    /// Type and code.
    pub kind: u16,
    /// Code.
    pub code: u16,
    /// The program.
    pub program: String,
    /// The routine; of an add-on instruction its name and routine.
    pub routine: String,
    /// Rung or line.
    pub place: Line,
    /// The instruction.
    pub instruction: String,
    /// The operand at fault and its value.
    pub operand: Option<(String, i64)>,
}

impl FaultAt {
    pub(crate) fn told(&self, code: &Code) -> Fault {
        let routine = code.routines.get(self.routine as usize);
        let program = code
            .programs
            .get(self.program as usize)
            .map_or("", |program| code.text(program.name));
        let name = routine.map_or("", |routine| code.text(routine.name));
        let owner = routine.map_or("", |routine| code.text(routine.program));
        Fault {
            kind: self.kind,
            code: self.code,
            program: program.to_owned(),
            routine: if owner == program {
                name.to_owned()
            } else {
                format!("{owner}.{name}")
            },
            place: code.line(self.routine, self.line),
            instruction: code.text(self.instruction).to_owned(),
            operand: self.operand.map(|(text, value)| (code.text(text).to_owned(), value)),
        }
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            kind,
            code,
            program,
            routine,
            place,
            instruction,
            operand,
        } = self;
        write!(
            f,
            "major fault {kind}/{code} ({}) in {program}/{routine} {place}",
            meaning(*kind, *code)
        )?;
        if !instruction.is_empty() {
            write!(f, ", {instruction}")?;
        }
        match operand {
            Some((operand, value)) => write!(f, ": {operand} is {value}"),
            None => Ok(()),
        }
    }
}

fn meaning(kind: u16, code: u16) -> &'static str {
    match (kind, code) {
        (4, 16) => "unknown instruction",
        (4, 20) => "subscript out of range",
        (4, 21) => "LEN or POS of a CONTROL out of range",
        (4, 31) => "parameters of a subroutine do not fit",
        (4, 34) => "negative PRE or ACC of a timer",
        (4, 42) => "jump to a missing label",
        (4, 83) => "value out of range",
        (4, 84) => "too many calls within one another",
        (4, 990..=999) => "of the program",
        (6, 1) => "watchdog",
        _ => "fault",
    }
}

impl Scan<'_> {
    /// A major fault with an operand at fault.
    pub(crate) fn fault(&mut self, kind: u16, code: u16, operand: Option<(TextId, i64)>) -> Exit {
        self.s.is_handled = false;
        self.s.is_restless = true;
        self.s.fault = Some(FaultAt {
            kind,
            code,
            program: self.s.program,
            routine: self.s.routine,
            line: self.s.line,
            instruction: self.s.instruction,
            operand,
        });
        Exit::Fault
    }

    /// The fault of operands that an instruction does not take, which loading refuses.
    pub(crate) fn unknown(&mut self) -> Exit {
        self.fault(4, 16, None)
    }

    /// A minor fault of type 4: its bit, and S:MINOR.
    pub(crate) fn minor(&mut self) {
        self.s.minor = true;
        self.s.is_restless = true;
        self.s.minor_bits |= 1 << 4;
        let [minor, _] = &mut self.s.events;
        *minor = minor.saturating_add(1);
    }

    pub(crate) fn set_instruction(&mut self, name: TextId) {
        self.s.instruction = name;
    }

    /// Counts instructions against the budget that stands for the watchdog.
    pub(crate) fn spend(&mut self, count: usize) -> Run<()> {
        self.s.budget -= count as i64;
        if self.s.budget < 0 {
            return Err(self.watchdog());
        }
        Ok(())
    }

    /// Lets clients write between two rungs or statements; the host's watchdog may end the run there.
    pub(crate) fn pass(&mut self) -> Run<()> {
        match self.host.between(&mut self.s.memory) {
            Pace::InTime => Ok(()),
            Pace::TooLong => Err(self.watchdog()),
        }
    }

    /// The watchdog: fault routines have the time of one more run, and a run that needs more than that ends.
    fn watchdog(&mut self) -> Exit {
        self.s.watchdogs += 1;
        self.s.budget = super::BUDGET;
        self.host.begin_task(self.s.watchdog_us);
        self.fault(6, 1, None)
    }

    /// Runs the fault routine of the program, then the controller's fault handler: true, when one of them cleared the fault,
    /// so that the scan goes on behind the instruction.
    pub(crate) fn recovers(&mut self) -> bool {
        let Some(fault) = self.s.fault else { return false };
        if self.s.prescan && fault.kind == 4 && (fault.code == 20 || fault.code == 83) {
            self.s.fault = None;
            return true;
        }
        let is_over = fault.kind == 6 && self.s.watchdogs > 1;
        if self.s.in_fault || self.s.add_ons > 0 || self.s.is_handled || is_over {
            return false;
        }
        if self.s.faults.len() < MAX_FAULTS {
            self.s.faults.push(fault);
        }
        self.s.major_bits |= 1_u32.checked_shl(fault.kind.into()).unwrap_or_default();
        let [_, major] = &mut self.s.events;
        *major = major.saturating_add(1);
        let program = self.s.program;
        let own = self.code.programs.get(program as usize).and_then(|one| one.fault);
        let handler = self.code.fault_handler;
        let handler_main = handler.and_then(|place| self.code.programs.get(place as usize)?.main);
        let attempts = [(program, own), (handler.unwrap_or_default(), handler_main)];
        let (routine, line, instruction) = (self.s.routine, self.s.line, self.s.instruction);
        let (prescan, zone) = (self.s.prescan, self.s.zone);
        for (of, routine) in attempts {
            let Some(routine) = routine else { continue };
            if let Some(record) = self.s.records.get_mut(of as usize) {
                let [low, high, kind_code, ..] = record;
                let micros = self.s.now / 1000;
                (*low, *high) = (micros as i32, (micros >> 32) as i32);
                *kind_code = i32::from(fault.kind) | i32::from(fault.code) << 16;
            }
            (self.s.in_fault, self.s.prescan, self.s.zone, self.s.program) = (true, false, false, of);
            let _ = self.routine(routine);
            self.s.in_fault = false;
            let cleared = self.s.records.get(of as usize).is_some_and(|record| record[2] == 0);
            (self.s.prescan, self.s.zone, self.s.program) = (prescan, zone, program);
            (self.s.routine, self.s.line, self.s.instruction) = (routine_of(fault), line, instruction);
            if cleared {
                self.s.fault = None;
                self.s.routine = routine_of(fault);
                self.s.is_restless = true;
                return true;
            }
        }
        self.s.routine = routine;
        self.s.fault = Some(fault);
        self.s.is_handled = true;
        false
    }

    pub(crate) fn take_fault(&mut self) -> Option<FaultAt> {
        self.s.fault.take()
    }
}

fn routine_of(fault: FaultAt) -> u32 {
    fault.routine
}

/// Faults that are listed.
pub(crate) const MAX_FAULTS: usize = 256;
