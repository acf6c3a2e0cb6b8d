//! A project that runs: its memory, its tasks, and the due work of a tick (spec/programs.md §8, §14).

use arcline_instruction_set::{ControlSlot, MotionControl, Object};

use crate::code::{Argument, Code, When};
use crate::compile::{Compiler, Directory, Known};
use crate::error::Finding;
use crate::expression::Expression;
use crate::memory::Tag;
use crate::readers::Operands;
use crate::run::{ExecutionState, Exit, Fault, FaultAt, Host, Memory, STATUS_OVERLAP, STATUS_TIMEOUT, Scan};
use crate::source::Project;
use crate::steps;

/// A project in the memory of a controller.
#[derive(Clone, Debug)]
pub struct Cell {
    code: Code,
    state: ExecutionState,
    tags: Vec<Tag>,
    /// The next release of each periodic task, ns.
    releases: Vec<u64>,
    /// Whether each program has been scanned.
    scanned: Vec<bool>,
    /// Tasks by priority: those of events, then periodic ones.
    order: Vec<usize>,
    /// The events of tasks: the last state of each, and the last run of the task, ns.
    events: Vec<Seen>,
    /// The tick of the next continuous scan, and the state of the phase's numbers.
    next_scan: u64,
    phase: Option<u64>,
}

/// The last event state of a task that waits for an event.
#[derive(Clone, Copy, Debug, Default)]
struct Seen {
    /// The bit of the event, or a number for the bytes.
    state: u64,
    /// The time of the task's last run, ns.
    ran: u64,
}

/// A project that was read.
#[derive(Debug)]
pub struct Loaded {
    /// The part of the project that runs.
    pub cell: Cell,
    /// The parts that do not run.
    pub findings: Vec<Finding>,
    /// The names of its tags and types, for a [`Listing`](crate::Listing).
    pub names: Names,
}

/// The names of a project that was loaded.
#[derive(Debug)]
pub struct Names(pub(crate) Known);

/// Compiles a project for a machine.
pub fn load(project: &Project, directory: &mut dyn Directory) -> Loaded {
    let mut compiler = Compiler::new(project, directory);
    compiler.compile();
    let shared = compiler.shared.iter().filter_map(|(number, id)| {
        let tag = compiler.tags.list.get(*number)?;
        Some((tag.at, tag.at + tag.tag_type.size() as u32, *id))
    });
    let shared = shared.collect();
    let mut state = ExecutionState::new(std::mem::take(&mut compiler.tags.bytes), &compiler.code);
    (state.objects, state.controls, state.shared) = (compiler.objects, compiler.controls, shared);
    let mut code = compiler.code;
    state.memory.set_readers(steps::number(&mut code));
    let mut order: Vec<usize> = (0..code.tasks.len()).collect();
    order.sort_by_key(|place| {
        code.tasks.get(*place).map(|task| {
            (
                match task.when {
                    When::Motion => 0,
                    When::Bit { .. } | When::Change { .. } => 1,
                    _ => 2,
                },
                task.priority,
                code.text(task.name).to_owned(),
            )
        })
    });
    let cell = Cell {
        releases: vec![0; code.tasks.len()],
        events: vec![Seen::default(); code.tasks.len()],
        scanned: vec![false; code.programs.len()],
        order,
        code,
        state,
        tags: compiler.tags.list.clone(),
        next_scan: 0,
        phase: None,
    };
    Loaded {
        cell,
        findings: compiler.findings,
        names: Names(Known {
            types: compiler.types,
            tags: compiler.tags,
        }),
    }
}

impl Cell {
    /// The code and its state.
    pub(crate) fn parts_mut(&mut self) -> (&Code, &mut ExecutionState) {
        (&self.code, &mut self.state)
    }

    /// The tags, in the order of the file.
    pub fn tags(&self) -> &[Tag] {
        &self.tags
    }

    /// The bytes of all tags; a tag begins at [`Tag::at`].
    pub fn memory(&self) -> &Memory {
        &self.state.memory
    }

    /// The bytes of all tags, to bring the machine's state to them.
    pub fn memory_mut(&mut self) -> &mut Memory {
        &mut self.state.memory
    }

    /// The motion objects among the tags: first byte, kind and index.
    pub fn objects(&self) -> &[(u32, Object, u16)] {
        &self.state.objects
    }

    /// Tags that the host has too: first byte, end, and the host's id.
    pub fn shared(&self) -> &[(u32, u32, u32)] {
        &self.state.shared
    }

    /// Brings a change of an instruction's status to its motion control tag.
    pub fn change_control(&mut self, slot: ControlSlot, change: impl FnOnce(&mut MotionControl)) {
        let Some((at, _)) = self.state.controls.iter().find(|(_, of)| *of == slot).copied() else {
            return;
        };
        self.state.memory.change_control(at as usize, change);
    }

    /// Scans of the continuous task fall in every second to ninth tick, by this seed.
    pub fn set_phase(&mut self, seed: u64) {
        self.phase = Some(seed | 1);
    }

    /// The faults so far, those that were cleared among them.
    pub fn faults(&self) -> impl Iterator<Item = Fault> {
        self.state.faults.iter().map(|fault| fault.told(&self.code))
    }

    /// The motion control structures: first byte and slot.
    pub fn controls(&self) -> &[(u32, ControlSlot)] {
        &self.state.controls
    }

    /// Loses the releases of periodic tasks up to a time, ns, but the last of each, and counts them: a task that still ran then is
    /// not released again.
    pub fn lose_releases(&mut self, until: u64) {
        let tasks = self
            .code
            .tasks
            .iter()
            .zip(&mut self.releases)
            .zip(&mut self.state.overlaps)
            .zip(&mut self.state.status);
        for (((task, release), overlaps), status) in tasks {
            if let When::Periodic(rate) = task.when
                && *release < until
            {
                let lost = (until - *release) / rate;
                *release += lost * rate;
                *overlaps = overlaps.saturating_add(i32::try_from(lost).unwrap_or(i32::MAX));
                *status |= if lost > 0 { STATUS_OVERLAP } else { 0 };
            }
        }
    }

    /// Enters Run at a time, ns: periodic tasks are released from then on, first scans come again, and every scheduled program is
    /// prescanned.
    ///
    /// # Errors
    /// A major fault.
    pub fn start(&mut self, now: u64, host: &mut dyn Host) -> Result<(), Fault> {
        self.releases.fill(now);
        self.scanned.fill(false);
        self.next_scan = 0;
        for task in 0..self.events.len() {
            let state = self.event_state(task);
            if let Some(seen) = self.events.get_mut(task) {
                *seen = Seen { state, ran: now };
            }
        }
        let Cell { code, state, .. } = self;
        state.triggered.fill(false);
        state.begin_wires();
        (state.now, state.now_ms) = (now, (now / 1_000_000) as i64);
        for task in &code.tasks {
            for program in &task.programs {
                let Some(main) = code.programs.get(*program as usize).and_then(|one| one.main) else {
                    continue;
                };
                state.program = *program;
                state.begin_run(task.longest_us(), host);
                state.begin();
                state.prescan = true;
                let mut scan = Scan {
                    code,
                    s: &mut *state,
                    host: &mut *host,
                    caller: None,
                };
                let ran = scan.prescan(main);
                let fault = scan.take_fault();
                state.prescan = false;
                if let (Err(Exit::Fault), Some(fault)) = (ran, fault) {
                    return Err(self.told(fault));
                }
            }
        }
        Ok(())
    }

    /// Whether [`Cell::tick`] would read the memory at a tick: a task may be due, or there are wires or tasks that wait for an event.
    pub fn reads(&self, tick: u64, period: u64) -> bool {
        let now = tick * period;
        let is_due = |(task, release): (&crate::code::Task, &u64)| match task.when {
            When::Continuous => tick >= self.next_scan,
            When::Periodic(_) => *release <= now,
            When::Motion | When::Triggered | When::Bit { .. } | When::Change { .. } => true,
        };
        !self.code.wires.is_empty() || self.code.tasks.iter().zip(&self.releases).any(is_due)
    }

    /// The number of ticks after this one in which [`Cell::tick`] has nothing to do: no task is due. 0 if a task, a wire or a message waits for
    /// something that may come in any tick.
    pub fn idle_ticks(&self, tick: u64, period: u64) -> u64 {
        if !self.code.wires.is_empty() || self.state.has_messages() {
            return 0;
        }
        let tasks = self.code.tasks.iter().zip(&self.releases);
        let idle = tasks.map(|(task, release)| match task.when {
            When::Periodic(_) => release.div_ceil(period.max(1)).saturating_sub(tick + 1),
            _ => 0,
        });
        idle.min().unwrap_or(u64::MAX)
    }

    /// Scans the tasks that are due in a tick.
    ///
    /// # Errors
    /// A major fault that no routine cleared: the tasks stop.
    pub fn tick(&mut self, tick: u64, period: u64, host: &mut dyn Host) -> Result<(), Fault> {
        let now = tick * period;
        self.state.executions = 0;
        self.state.now = now;
        let mut scan = Scan {
            code: &self.code,
            s: &mut self.state,
            host: &mut *host,
            caller: None,
        };
        scan.messages();
        scan.latch_inputs(now);
        self.tasks(tick, now, host)?;
        self.see_cleared_bits();
        let mut scan = Scan {
            code: &self.code,
            s: &mut self.state,
            host,
            caller: None,
        };
        scan.give_outputs(now);
        Ok(())
    }

    /// Scans the tasks that are due.
    fn tasks(&mut self, tick: u64, now: u64, host: &mut dyn Host) -> Result<(), Fault> {
        for number in 0..self.order.len() {
            let Some(task) = self.order.get(number).copied() else {
                continue;
            };
            match self.code.tasks.get(task).map(|task| task.when) {
                Some(When::Motion) => self.run(task, now, host)?,
                Some(When::Periodic(rate)) => self.periodic(task, rate, now, host)?,
                Some(When::Bit { .. } | When::Change { .. } | When::Triggered) => self.event(task, now, host)?,
                _ => {}
            }
        }
        if tick < self.next_scan {
            return Ok(());
        }
        self.next_scan = tick + 1;
        if let Some(seed) = &mut self.phase {
            // Marsaglia's xorshift.
            *seed ^= *seed << 13;
            *seed ^= *seed >> 7;
            *seed ^= *seed << 17;
            self.next_scan = tick + 2 + *seed % 8;
        }
        for number in 0..self.order.len() {
            let Some(task) = self.order.get(number).copied() else {
                continue;
            };
            if self
                .code
                .tasks
                .get(task)
                .is_some_and(|task| task.when == When::Continuous)
            {
                self.run(task, now, host)?;
            }
        }
        Ok(())
    }

    fn periodic(&mut self, task: usize, rate: u64, now: u64, host: &mut dyn Host) -> Result<(), Fault> {
        for _ in 0..MAX_RELEASES {
            let Some(release) = self.releases.get_mut(task) else {
                return Ok(());
            };
            if *release > now {
                return Ok(());
            }
            let nominal = *release;
            *release += rate;
            self.run(task, nominal, host)?;
        }
        // Releases that no tick can take are lost.
        if let Some(release) = self.releases.get_mut(task) {
            let lost = now.saturating_sub(*release) / rate;
            *release += lost * rate;
            if let Some(count) = self.state.overlaps.get_mut(task) {
                *count = count.saturating_add(lost as i32);
            }
            if let Some(status) = self.state.status.get_mut(task).filter(|_| lost > 0) {
                *status |= STATUS_OVERLAP;
            }
        }
        Ok(())
    }

    /// The bit that a task waits for, or a number for its bytes.
    fn event_state(&self, task: usize) -> u64 {
        let memory = &self.state.memory;
        match self.code.tasks.get(task).map(|task| task.when) {
            Some(When::Bit { at, mask }) => memory.get(at as usize).map_or(0, |byte| u64::from(byte & mask != 0)),
            Some(When::Change { from, to }) => {
                let bytes = memory.get(from as usize..to as usize).unwrap_or_default();
                // Fowler, Noll and Vo's hash.
                let hash = |hash: u64, byte: &u8| (hash ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01B3);
                bytes.iter().fold(0xCBF2_9CE4_8422_2325, hash)
            }
            _ => 0,
        }
    }

    /// Notes the bits of events that an instruction of this tick has cleared: MAH clears that of the axis's home event, which may come in the next tick.
    fn see_cleared_bits(&mut self) {
        for task in 0..self.events.len() {
            let Some(When::Bit { .. }) = self.code.tasks.get(task).map(|task| task.when) else {
                continue;
            };
            let state = self.event_state(task);
            if let Some(seen) = self.events.get_mut(task) {
                seen.state = seen.state.min(state);
            }
        }
    }

    /// Runs a task whose event has come, or has not come for its longest time.
    fn event(&mut self, task: usize, now: u64, host: &mut dyn Host) -> Result<(), Fault> {
        let state = self.event_state(task);
        let (Some(of), Some(seen)) = (self.code.tasks.get(task), self.events.get_mut(task)) else {
            return Ok(());
        };
        let has_come = match of.when {
            When::Bit { .. } => state > seen.state,
            _ => state != seen.state,
        };
        seen.state = state;
        let is_late = of
            .timeout
            .is_some_and(|longest| now.saturating_sub(seen.ran) >= longest);
        if !has_come && !is_late {
            return Ok(());
        }
        if !has_come && let Some(status) = self.state.status.get_mut(task) {
            *status |= STATUS_TIMEOUT;
        }
        self.run(task, now, host)
    }

    /// Runs a task, then those that it triggered.
    fn run(&mut self, task: usize, now: u64, host: &mut dyn Host) -> Result<(), Fault> {
        self.run_alone(task, now, host)?;
        for _ in 0..MAX_TRIGGERED {
            let triggered = self
                .order
                .iter()
                .copied()
                .find(|place| self.state.triggered.get(*place) == Some(&true));
            let Some(next) = triggered else { return Ok(()) };
            if let Some(flag) = self.state.triggered.get_mut(next) {
                *flag = false;
            }
            self.run_alone(next, now, host)?;
        }
        Ok(())
    }

    fn run_alone(&mut self, task: usize, now: u64, host: &mut dyn Host) -> Result<(), Fault> {
        let Cell {
            code,
            state,
            scanned,
            events,
            ..
        } = self;
        let Some(of) = code.tasks.get(task) else { return Ok(()) };
        if state.inhibited.get(task) == Some(&true) {
            return Ok(());
        }
        if let Some(seen) = events.get_mut(task) {
            state.before_ms = (std::mem::replace(&mut seen.ran, now) / 1_000_000) as i64;
        }
        (state.now, state.now_ms) = (now, (now / 1_000_000) as i64);
        state.begin_run(of.longest_us(), host);
        for program in &of.programs {
            let place = *program as usize;
            let main = code.programs.get(place).and_then(|one| one.main);
            let Some(main) = main.filter(|_| state.disabled.get(place) == Some(&false)) else {
                continue;
            };
            state.program = *program;
            state.first_scan = scanned.get(place) == Some(&false);
            state.begin();
            let mut scan = Scan {
                code,
                s: &mut *state,
                host: &mut *host,
                caller: None,
            };
            let of = code.programs.get(place);
            let mut ran = of
                .and_then(|one| one.before)
                .map_or(Ok(()), |copies| scan.routine(copies));
            if ran.is_ok() {
                ran = scan.routine(main);
            }
            if ran.is_ok()
                && let Some(copies) = of.and_then(|one| one.behind)
            {
                scan.s.leave_zone();
                ran = scan.routine(copies);
            }
            let fault = scan.take_fault();
            if let Some(flag) = scanned.get_mut(place) {
                *flag = true;
            }
            if let (Err(Exit::Fault), Some(fault)) = (ran, fault) {
                return Err(self.told(fault));
            }
        }
        Ok(())
    }

    fn told(&mut self, fault: FaultAt) -> Fault {
        if !self.state.faults.contains(&fault) {
            self.state.faults.push(fault);
        }
        fault.told(&self.code)
    }

    /// An expression of tags in the controller's scope, for an evaluation after each tick: `Done`, `C1.ACC >= 5`.
    ///
    /// # Errors
    /// The error, in words.
    pub fn condition(&self, project: &Project, directory: &mut dyn Directory, text: &str) -> Result<Condition, String> {
        let mut compiler = Compiler::new(project, directory);
        let text = program_scopes(text);
        let expression = Expression::parse(&text).map_err(|error| error.to_string())?;
        compiler.owner = crate::compile::Owner::Program(usize::MAX);
        let value = compiler.truth(&expression)?;
        let mut code = Code::default();
        std::mem::swap(&mut code, &mut compiler.code);
        let operands = steps::operands(&code, &value);
        Ok(Condition { value, code, operands })
    }

    /// Whether a condition holds.
    pub fn holds(&mut self, condition: &Condition, host: &mut dyn Host) -> bool {
        let mut scan = Scan {
            code: &condition.code,
            s: &mut self.state,
            host,
            caller: None,
        };
        let value = scan.whole(&condition.value);
        let _ = scan.take_fault();
        value.is_ok_and(|value| value != 0)
    }

    /// Writes of values to tags in the controller's scope: `Go`, `Program:Main.T1.PRE`.
    ///
    /// # Errors
    /// The first tag that cannot be written, and why in words.
    pub fn writes(
        &self,
        project: &Project,
        directory: &mut dyn Directory,
        given: &[(&str, &str)],
    ) -> Result<Writes, (String, String)> {
        let mut compiler = Compiler::new(project, directory);
        compiler.owner = crate::compile::Owner::Program(usize::MAX);
        let mut all = Vec::new();
        for (tag, value) in given {
            let write = Expression::parse(&program_scopes(tag))
                .map_err(|error| error.to_string())
                .and_then(|target| Ok(compiler.value_for(&target, value)?))
                .map_err(|reason| ((*tag).to_owned(), reason))?;
            all.push(((*tag).to_owned(), write));
        }
        let code = std::mem::take(&mut compiler.code);
        Ok(Writes { all, code })
    }

    /// Writes values to tags.
    ///
    /// # Errors
    /// The first tag whose subscript is out of range.
    pub fn write(&mut self, writes: &Writes, host: &mut dyn Host) -> Result<(), String> {
        let mut scan = Scan {
            code: &writes.code,
            s: &mut self.state,
            host,
            caller: None,
        };
        for (tag, (to, from)) in &writes.all {
            let written = scan.copy_value(from, to);
            let _ = scan.take_fault();
            written.map_err(|_| tag.clone())?;
        }
        Ok(())
    }
}

/// Values that are written to tags.
#[derive(Clone, Debug)]
pub struct Writes {
    /// The tag as it was given, the place and the value.
    all: Vec<(String, (Argument, Argument))>,
    code: Code,
}

/// An expression of tags.
#[derive(Clone, Debug)]
pub struct Condition {
    value: crate::code::Ex,
    code: Code,
    /// `None`: they cannot be told.
    operands: Option<Vec<Operands>>,
}

impl Condition {
    /// Whether it may read one of these bytes of the memory.
    pub fn reads(&self, at: u32, size: usize) -> bool {
        let overlaps = |of: &Operands| of.from < at.saturating_add(size as u32) && at < of.to;
        self.operands.as_ref().is_none_or(|all| all.iter().any(overlaps))
    }
}

/// `Program:Main.Done` as routines write it: `\Main.Done`.
pub(crate) fn program_scopes(text: &str) -> String {
    let mut result = String::new();
    let mut rest = text;
    while let Some(place) = rest.to_ascii_lowercase().find("program:") {
        let (before, behind) = rest.split_at(place);
        result.push_str(before);
        result.push('\\');
        rest = behind.get("program:".len()..).unwrap_or_default();
    }
    result.push_str(rest);
    result
}

/// Releases of a task in one tick.
const MAX_RELEASES: usize = 64;
/// Triggered tasks that run behind one task.
const MAX_TRIGGERED: usize = 16;
