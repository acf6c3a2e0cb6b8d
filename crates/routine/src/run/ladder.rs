//! Rungs (spec/programs.md §9): every instruction runs in every scan, with a true or a false condition.

use arcline_tag::Elementary;

use super::Number;
use super::value::{holds, holds_real};
use super::{BUDGET, Cursor, Exit, Host, MAX_CALLS, Run, STATUS_EVENT, Scan};
use crate::NoMachine;
use crate::code::{Argument, Body, DintOperand, Instruction, Node, RealOperand, Rung, RungTimer, Statement, Transfer};
use crate::table::Op;

impl<'s> Scan<'s> {
    /// Runs a routine to its end.
    pub(crate) fn routine(&mut self, number: u32) -> Run<()> {
        let code = self.code;
        let Some(routine) = code.routines.get(number as usize) else {
            return Ok(());
        };
        if self.s.depth >= MAX_CALLS {
            return Err(self.fault(4, 84, None));
        }
        let (before, line) = (self.s.routine, self.s.line);
        self.s.routine = number;
        self.s.depth += 1;
        let ran = match &routine.body {
            Body::Ladder(rungs) => match self.s.traces.iter().position(|trace| trace.routine == number) {
                None => self.rungs::<false>(rungs, routine.first_step),
                Some(trace) => {
                    let outer = std::mem::replace(&mut self.s.trace, Cursor { trace, bit: 0 });
                    let ran = self.rungs::<true>(rungs, routine.first_step);
                    self.s.trace = outer;
                    ran
                }
            },
            Body::Text(statements) => self.text_routine(statements, routine.first_step),
        };
        self.s.depth -= 1;
        match ran {
            Err(Exit::Fault) => return Err(Exit::Fault),
            Err(Exit::Break) => {
                (self.s.routine, self.s.line) = (before, line);
                return Err(Exit::Break);
            }
            _ => {}
        }
        (self.s.routine, self.s.line) = (before, line);
        Ok(())
    }

    /// The rungs of a routine from its first step on; `TRACED`: a viewer watches their power flow. Settled ones are passed over.
    fn rungs<const TRACED: bool>(&mut self, rungs: &'s [Rung], first_step: Option<u32>) -> Run<()> {
        let mut next = 0;
        while let Some(rung) = rungs.get(next) {
            self.s.line = rung.number;
            let step = first_step.map(|first| first + next as u32);
            let settled = if TRACED {
                0
            } else {
                self.settled_rungs(step, rungs.get(next..).unwrap_or_default())
            };
            if settled > 0 {
                let over = rungs.get(next..next + settled).unwrap_or_default();
                let before = next.checked_sub(1).and_then(|before| rungs.get(before));
                let before = before.map_or(0, |rung| rung.behind);
                next += settled;
                let instructions = over.last().map_or(0, |rung| rung.behind - before);
                self.go_on(instructions as usize)?;
                continue;
            }
            if !TRACED && rung.is_simple {
                let end = (next + TOGETHER).min(rungs.len());
                next += self.simple_rungs(rungs.get(next..end).unwrap_or_default(), step);
                self.go_on(0)?;
                continue;
            }
            match self.spend(rung.nodes.len() + 1).and_then(|()| self.pass()) {
                Err(Exit::Fault) if self.recovers() => {
                    next += 1;
                    continue;
                }
                passed => passed?,
            }
            let power = self.has_power();
            if TRACED {
                self.s.trace_rung(next, power);
            }
            let settling = step.filter(|_| rung.settles);
            let changes = self.begin_step(settling);
            match self.nodes::<TRACED>(&rung.nodes, power) {
                Ok(_) => {
                    self.end_step(settling, changes, rung.timer);
                    next += 1;
                }
                Err(Exit::Jump(rung)) => next = rung as usize,
                Err(Exit::Return) => return Ok(()),
                Err(exit) => return Err(exit),
            }
        }
        Ok(())
    }

    /// After steps of so many instructions: counts them, takes the writes of clients, and checks the watchdog, whose fault the program may handle.
    pub(crate) fn go_on(&mut self, instructions: usize) -> Run<()> {
        match self.spend(instructions).and_then(|()| self.pass()) {
            Err(Exit::Fault) if self.recovers() => Ok(()),
            passed => passed,
        }
    }

    /// Passes over settled rungs at the beginning of these, and brings the timers of those forward that are timing; returns how many they are.
    fn settled_rungs(&mut self, step: Option<u32>, rungs: &[Rung]) -> usize {
        let Some(first) = step.filter(|_| self.has_power()) else {
            return 0;
        };
        let mut count = 0;
        loop {
            let here = first + count as u32;
            let (settled, timing) = self.s.memory.settled(here);
            let rest = rungs.get(count..).unwrap_or_default();
            let rest = rest.get(..settled.trailing_ones() as usize).unwrap_or(rest);
            match self.settled_of_word(here, rest, timing) {
                0 => return count,
                passed => count += passed,
            }
        }
    }

    /// The same for rungs that were all settled, with a bit for each of them that is timing. It ends behind a timer that may have unsettled others.
    fn settled_of_word(&mut self, step: u32, rungs: &[Rung], mut timing: u64) -> usize {
        let mut count = 0;
        loop {
            let place = timing.trailing_zeros() as usize;
            self.check_settled(rungs.get(count..place.min(rungs.len())).unwrap_or_default(), &[]);
            let Some((rung, timer)) = rungs.get(place).and_then(|rung| Some((rung, rung.timer?))) else {
                return rungs.len();
            };
            if !self.passes_timing(step + place as u32, rung, timer) {
                return place;
            }
            count = place + 1;
            if timer.is_read {
                return count;
            }
            timing &= timing - 1;
        }
    }

    /// Brings the timer of a rung forward, if that is all that the rung would do.
    fn passes_timing(&mut self, step: u32, rung: &Rung, timer: RungTimer) -> bool {
        if !cfg!(debug_assertions) {
            return self.bring_forward(timer, step);
        }
        let at = timer.at;
        // Executing the rung must do the same.
        let Some(expected) = self.running(at) else { return false };
        let (changes, budget) = (self.s.memory.changes(), self.s.budget);
        let (instruction, line) = (self.s.instruction, self.s.line);
        (self.s.is_restless, self.s.timing, self.s.budget) = (false, None, BUDGET);
        let executed = self.on(&mut NoMachine).nodes::<false>(&rung.nodes, true);
        let only_timer = self.s.timing.is_some_and(|timing| {
            timing.at == at && self.s.memory.changes() == changes + timing.changes && !self.s.is_restless
        });
        debug_assert!(
            executed.is_ok() && only_timer && expected == (self.dint(at) as u32, self.dint(at + 8)),
            "the timing rung {} does more than to time",
            rung.number
        );
        self.s.memory.settle(step, true);
        (self.s.budget, self.s.instruction, self.s.line) = (budget, instruction, line);
        true
    }

    /// The same scan with another host.
    fn on<'a>(&'a mut self, host: &'a mut dyn Host) -> Scan<'a> {
        Scan {
            code: self.code,
            s: &mut *self.s,
            host,
            caller: None,
        }
    }

    /// The number of settled statements from one on, of so many. Nothing is settled where rungs have no power.
    pub(crate) fn settled_statements(&self, step: Option<u32>, most: usize) -> usize {
        let Some(first) = step.filter(|_| self.has_power()) else {
            return 0;
        };
        let mut count = 0;
        while count < most {
            let (settled, _) = self.s.memory.settled(first + count as u32);
            match settled.trailing_ones() as usize {
                0 => break,
                more => count += more,
            }
        }
        count.min(most)
    }

    /// A rung begins with power: it is no prescan, and no zone is off.
    fn has_power(&self) -> bool {
        !self.s.prescan && !self.s.zone
    }

    /// Begins a step, which is `settling` if it can settle; returns the number of changes of the memory.
    pub(crate) fn begin_step(&mut self, settling: Option<u32>) -> u64 {
        self.s.is_restless &= settling.is_none();
        self.s.timing = None;
        self.s.memory.changes()
    }

    /// Ends a step with this timer alone: it settles if it has changed nothing, or nothing but the time of its timer.
    pub(crate) fn end_step(&mut self, settling: Option<u32>, changes: u64, timer: Option<RungTimer>) {
        let Some(step) = settling.filter(|_| self.has_power() && !self.s.is_restless) else {
            return;
        };
        let of_timer = match self.s.timing {
            None => 0,
            Some(timing) if timer.is_some_and(|timer| timer.at == timing.at) => timing.changes,
            Some(_) => return,
        };
        if self.s.memory.changes() == changes + of_timer {
            self.s.memory.settle(step, self.s.timing.is_some());
        }
    }

    /// Executes settled steps in a debug build: they must change nothing.
    pub(crate) fn check_settled(&mut self, rungs: &[Rung], statements: &[Statement]) {
        if !cfg!(debug_assertions) {
            return;
        }
        let (changes, budget) = (self.s.memory.changes(), self.s.budget);
        let (instruction, line) = (self.s.instruction, self.s.line);
        let flags = (self.s.overflow, self.s.zero, self.s.negative, self.s.carry);
        (self.s.is_restless, self.s.timing, self.s.budget) = (false, None, BUDGET);
        let mut host = NoMachine;
        let mut scan = self.on(&mut host);
        let executed = rungs
            .iter()
            .try_for_each(|rung| scan.nodes::<false>(&rung.nodes, true).map(|_| ()))
            .and_then(|()| scan.statements(statements));
        debug_assert!(
            executed.is_ok() && !self.s.is_restless && self.s.timing.is_none() && self.s.memory.changes() == changes,
            "a settled step from line {line} on changes something"
        );
        (self.s.budget, self.s.instruction, self.s.line) = (budget, instruction, line);
        (self.s.overflow, self.s.zero, self.s.negative, self.s.carry) = flags;
    }

    /// Runs the simple rungs at the beginning of these, up to a settled one; returns how many they are.
    fn simple_rungs(&mut self, rungs: &'s [Rung], step: Option<u32>) -> usize {
        let on = self.has_power();
        let step = step.filter(|_| on);
        let (mut count, mut instructions) = (0, 0);
        for rung in rungs.iter().take_while(|rung| rung.is_simple) {
            let step = step.filter(|_| rung.settles).map(|step| step + count as u32);
            if step.is_some_and(|step| count > 0 && self.s.memory.settled(step).0 & 1 != 0) {
                break;
            }
            let changes = self.begin_step(step);
            let mut power = on;
            for node in &rung.nodes {
                power = self.simple(node, power);
            }
            self.end_step(step, changes, None);
            count += 1;
            instructions += rung.nodes.len() + 1;
        }
        self.s.budget -= instructions as i64;
        count
    }

    /// Executes an instruction of bits, numbers or a counter with known places; returns the condition behind it.
    #[inline]
    fn simple(&mut self, node: &Node, power: bool) -> bool {
        match node {
            Node::Xic(at, mask) => power && self.has(*at, *mask),
            Node::Xio(at, mask) => power && !self.has(*at, *mask),
            Node::Ote(at, mask) => {
                self.set(*at, *mask, power);
                power
            }
            Node::Otl(at, mask) => {
                if power {
                    self.set(*at, *mask, true);
                }
                power
            }
            Node::Otu(at, mask) => {
                if power {
                    self.set(*at, *mask, false);
                }
                power
            }
            Node::Compute(operation, a, b, to) => {
                if power {
                    self.begin_arithmetic();
                    let result = self.operate(*operation, self.dint_operand(*a), self.dint_operand(*b));
                    self.store_dint(*to, result);
                }
                power
            }
            Node::Move(from, to) => {
                if power {
                    self.begin_arithmetic();
                    self.store_dint(*to, self.dint_operand(*from));
                }
                power
            }
            Node::Compare(compare, a, b) => power && holds(*compare, self.dint_operand(*a).cmp(&self.dint_operand(*b))),
            Node::ComputeReal(operation, a, b, to) => {
                if power {
                    self.begin_arithmetic();
                    let result = self.operate_real(*operation, self.real_operand(*a), self.real_operand(*b));
                    self.store_real(*to, result);
                }
                power
            }
            Node::MoveReal(from, to) => {
                if power {
                    self.begin_arithmetic();
                    self.store_real(*to, self.real_operand(*from));
                }
                power
            }
            Node::CompareReal(compare, a, b) => {
                power && holds_real(*compare, self.real_operand(*a), self.real_operand(*b))
            }
            Node::Ons(at, mask) => self.one_shot_rising(*at, *mask, power),
            Node::Count(op, at) => {
                self.count(*op, *at, power);
                power
            }
            Node::Branch(_) | Node::Instruction(_) => power,
        }
    }

    fn dint_operand(&self, operand: DintOperand) -> i64 {
        i64::from(match operand {
            DintOperand::Number(number) => number,
            DintOperand::At(at) => self.dint(at),
        })
    }

    /// Stores a result with its flags; an overflow keeps the low bits.
    fn store_dint(&mut self, to: u32, result: i64) {
        let low = result as i32;
        if i64::from(low) != result {
            self.set_overflow();
        }
        self.put_dint(to, low);
        self.flags(Number::Whole(i64::from(low)));
    }

    fn real_operand(&self, operand: RealOperand) -> f64 {
        match operand {
            RealOperand::Number(number) => f64::from(number),
            RealOperand::At(at) => self.read_real(at, Elementary::Real),
        }
    }

    /// Stores a result with its flags.
    fn store_real(&mut self, to: u32, result: f64) {
        self.write(to, Elementary::Real, Number::Real(result));
        self.flags(Number::Real(f64::from(result as f32)));
    }

    fn nodes<const TRACED: bool>(&mut self, nodes: &'s [Node], mut power: bool) -> Run<bool> {
        for node in nodes {
            power = match node {
                Node::Branch(legs) => {
                    let mut out = false;
                    for leg in legs {
                        self.s.budget -= leg.len() as i64;
                        out |= self.nodes::<TRACED>(leg, power)?;
                    }
                    out
                }
                Node::Instruction(instruction) => self.instruction(instruction, power)?,
                simple => self.simple(simple, power),
            };
            if TRACED {
                self.s.trace_power(power);
            }
        }
        Ok(power)
    }

    /// Executes an instruction, and handles its fault.
    pub(crate) fn instruction(&mut self, instruction: &'s Instruction, power: bool) -> Run<bool> {
        self.set_instruction(instruction.name);
        match self.act(instruction, power) {
            Err(Exit::Fault) if self.recovers() => Ok(power),
            done => done,
        }
    }

    fn act(&mut self, i: &'s Instruction, power: bool) -> Run<bool> {
        let a = &*i.arguments;
        let prescan = self.s.prescan;
        // The elements of FAL and FSC are behind the end when the file is done.
        if i.is_edge && !power && !prescan && !matches!(i.op, Op::Fal | Op::Fsc) {
            self.touch(a)?;
        }
        match (i.op, a) {
            (Op::Xic, [one]) => Ok(power && self.argument_whole(one)? != 0),
            (Op::Xio, [one]) => Ok(power && self.argument_whole(one)? == 0),
            (Op::Ote, [one]) => self.assign(one, Number::Whole(i64::from(power))).map(|()| power),
            (Op::Otl, [one]) if power => self.assign(one, Number::Whole(1)).map(|()| power),
            (Op::Otu, [one]) if power => self.assign(one, Number::Whole(0)).map(|()| power),
            (Op::Ons | Op::Osr | Op::Osf | Op::Osri | Op::Osfi, _) => self.one_shot(i.op, a, power),
            (Op::Ton | Op::Tof | Op::Rto | Op::Tonr | Op::Tofr | Op::Rtor, [Argument::Area(timer), ..]) => {
                self.timer(i.op, timer, power).map(|()| power)
            }
            (Op::Ctu | Op::Ctd | Op::Ctud, [Argument::Area(counter), ..]) => {
                self.counter(i.op, counter, power).map(|()| power)
            }
            (Op::Res, [Argument::Area(area)]) if power => self.reset(area).map(|()| power),
            (Op::Compare(_) | Op::Cmp, [Argument::Integer(value)]) => Ok(power && self.whole(value)? != 0),
            (Op::Cmp, [value]) => Ok(power && self.argument(value)? != Number::Real(0.0)),
            (Op::Lim | Op::Meq, _) => Ok(power && self.limit(i.op, a)?),
            (Op::Compute, [value, target, rest @ ..]) if power => self.compute(value, target, rest).map(|()| true),
            (Op::Cpt, [target, value]) if power => self.compute(value, target, &[]).map(|()| true),
            (
                Op::Mov | Op::Mvm | Op::Btd | Op::Clr | Op::Swpb | Op::Cop | Op::Fll | Op::Size | Op::Mvmt | Op::Btdt,
                _,
            ) if power => self.move_data(i.op, a).map(|()| true),
            (Op::Jsr, [Argument::Transfer(transfer)]) => self.call(transfer, power).map(|()| power),
            (Op::For, [Argument::Routine(routine), index, from, to, by]) => {
                self.repeat(*routine, [index, from, to, by], power).map(|()| power)
            }
            (Op::Ret, values) if power => {
                self.give(values)?;
                Err(Exit::Return)
            }
            (Op::Tnd, _) if power => Err(Exit::Return),
            (Op::Brk, _) if power => Err(Exit::Break),
            (Op::Jmp, [Argument::Label(rung)]) if power => Err(Exit::Jump(*rung)),
            (Op::Mcr, _) => {
                // Its own rung is false in a zone, which ends there.
                if !prescan && !power {
                    self.s.zone = !self.s.zone;
                }
                Ok(power)
            }
            (Op::Afi, _) => Ok(false),
            (Op::Event, [Argument::Task(task)]) if power => {
                self.s.is_restless = true;
                if let Some(triggered) = self.s.triggered.get_mut(*task as usize) {
                    *triggered = true;
                }
                if let Some(status) = self.s.status.get_mut(*task as usize) {
                    *status |= STATUS_EVENT;
                }
                Ok(true)
            }
            (Op::Fal | Op::Fsc, _) => self.file(i.op, a, power).map(|()| power),
            (Op::Ave | Op::Std | Op::Srt, _) => self.statistics(i.op, a, power).map(|()| power),
            (Op::Bsl | Op::Bsr, _) => self.shift(i.op, a, power).map(|()| power),
            (Op::Ffl | Op::Ffu | Op::Lfl | Op::Lfu, _) => self.queue(i.op, a, power).map(|()| power),
            (Op::Sqi, _) => Ok(power && self.sequencer_input(a)?),
            (Op::Sqo | Op::Sql, _) => self.sequencer(i.op, a, power).map(|()| power),
            (op, _) if power && op.is_of_texts() => self.text(op, a).map(|()| true),
            (Op::Gsv | Op::Ssv, [Argument::System(system)]) if power => self.system(i.op, system).map(|()| true),
            (Op::Msg, [Argument::Area(area), reply @ ..]) => {
                let reply = match reply {
                    [Argument::Reply(reply)] => Some(*reply),
                    _ => None,
                };
                self.message(area, reply, power).map(|()| power)
            }
            (Op::Almd, [Argument::Area(alarm), operands @ ..]) => self.alarm(alarm, operands, power).map(|()| power),
            (Op::Motion, [Argument::Motion(call)]) => self.motion(call, power).map(|()| power),
            (Op::AddOn, [Argument::AddOn(call)]) => self.add_on(call, power),
            (Op::Nop | Op::Sbr | Op::Lbl | Op::Uid | Op::Missing, _) => Ok(power),
            // The others with a false rung.
            _ if !power => Ok(false),
            _ => Err(self.unknown()),
        }
    }

    /// Evaluates the operands of an instruction whose rung is false: its subscripts must be in range even then.
    fn touch(&mut self, arguments: &[Argument]) -> Run<()> {
        for argument in arguments {
            match argument {
                Argument::Bit(bit) => {
                    self.bit_at(bit)?;
                }
                Argument::Target(cell) if !cell.place.index.is_empty() => {
                    self.address(&cell.place)?;
                }
                Argument::Area(area) if !area.place.index.is_empty() => {
                    self.address(&area.place)?;
                }
                _ => {}
            }
        }
        Ok(())
    }

    /// JSR: parameters by value, the routine, values back.
    fn call(&mut self, transfer: &'s Transfer, power: bool) -> Run<()> {
        if self.s.prescan {
            return self.prescan(transfer.routine);
        }
        if !power {
            return Ok(());
        }
        if let Some(code) = self.fault_code(transfer)? {
            return Err(self.fault(4, code, None));
        }
        if transfer.parameters.len() > transfer.inputs.len() {
            return Err(self.fault(4, 31, None));
        }
        for (from, to) in transfer.inputs.iter().zip(&transfer.parameters) {
            self.copy_value(from, to)?;
        }
        let outer = self.caller.replace(transfer);
        let ran = self.routine(transfer.routine);
        self.caller = outer;
        self.s.is_restless = true;
        ran
    }

    /// The code of a fault that the program makes: a JSR to its fault routine with one number of 990 to 999.
    fn fault_code(&mut self, transfer: &Transfer) -> Run<Option<u16>> {
        let own = self
            .code
            .programs
            .get(self.s.program as usize)
            .and_then(|one| one.fault);
        if own != Some(transfer.routine) || self.s.in_fault {
            return Ok(None);
        }
        let [input @ (Argument::Integer(_) | Argument::Target(_))] = &*transfer.inputs else {
            return Ok(None);
        };
        let code = self.argument_whole(input)?;
        Ok(u16::try_from(code).ok().filter(|code| (990..=999).contains(code)))
    }

    fn repeat(&mut self, routine: u32, [index, from, to, by]: [&Argument; 4], power: bool) -> Run<()> {
        if self.s.prescan {
            return self.prescan(routine);
        }
        if !power {
            return Ok(());
        }
        let (mut value, to, by) = (
            self.argument_whole(from)?,
            self.argument_whole(to)?,
            self.argument_whole(by)?,
        );
        self.assign(index, Number::Whole(value))?;
        self.s.is_restless = true;
        while if by >= 0 { value <= to } else { value >= to } {
            self.spend(1)?;
            let ran = self.routine(routine);
            self.s.is_restless = true;
            match ran {
                Ok(()) => {}
                Err(Exit::Break) => return Ok(()),
                Err(exit) => return Err(exit),
            }
            value = self.argument_whole(index)?.wrapping_add(by);
            self.assign(index, Number::Whole(value))?;
        }
        Ok(())
    }

    /// Prescans a routine, once on each path of calls.
    pub(crate) fn prescan(&mut self, routine: u32) -> Run<()> {
        if self.s.path.contains(&routine) || self.s.path.len() >= MAX_CALLS {
            return Ok(());
        }
        self.s.path.push(routine);
        let ran = self.routine(routine);
        self.s.path.pop();
        ran
    }

    /// Copies a value by its type: numbers converted, structures and arrays by their bytes.
    pub(crate) fn copy_value(&mut self, from: &Argument, to: &Argument) -> Run<()> {
        if let (Argument::Area(from), Argument::Area(to)) = (from, to) {
            let (source, target) = (self.range(from)?, self.range(to)?);
            let length = |range: super::value::Range, area: &crate::code::Area| {
                if area.is_whole {
                    range.array_end - range.at
                } else {
                    area.size
                }
            };
            let count = length(source, from).min(length(target, to));
            return self.copy_bytes(source.at, target.at, count);
        }
        if let (Argument::Text(from), Argument::Text(to)) = (from, to) {
            return self.copy_text(from, to);
        }
        let value = self.argument(from)?;
        self.assign(to, value)
    }

    pub(crate) fn copy_bytes(&mut self, from: u32, to: u32, count: u32) -> Run<()> {
        let (from, to, count) = (from as usize, to as usize, count as usize);
        let length = self.s.memory.len();
        if from + count > length || to + count > length {
            return Err(self.outside());
        }
        self.s.memory.copy(from, to, count);
        Ok(())
    }
}

/// Simple rungs between which clients do not write.
const TOGETHER: usize = 16;
