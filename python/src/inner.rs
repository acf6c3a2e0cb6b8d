//! The machine behind a `Machine` of Python: its programs, waiting events, future faults, and the journal of calls.

use std::collections::{BTreeMap, VecDeque};
use std::sync::Arc;

use arcline_config::Project;
use arcline_controller::image::Image;
use arcline_controller::machine::Machine as MachineConfig;
use arcline_controller::{Controller, Event};
use arcline_instruction_set::AxisId;
use arcline_simulation::{ImageNames, Observer, Origin, ProgramId, RunLimits, Runner, Simulation};
use arcline_structured_text::{Interpreter, OnError, Policy, Program, QueueFull};
use pyo3::prelude::*;

use crate::errors;
use crate::plant::{Plant, Shared};
use crate::signals::{Columns, Signal, sample};

/// Events that wait to be taken, at most; older ones are dropped.
const EVENTS: usize = 100_000;

/// The parts of a machine, behind its lock.
pub(crate) struct Inner {
    pub(crate) runner: Runner,
    /// The programs by their number, in the order in which they were started.
    pub(crate) programs: Vec<ProgramId>,
    pub(crate) events: Events,
    /// Faults that are to be injected, by tick: axis and causes, or none to take them away.
    pub(crate) faults: BTreeMap<u64, Vec<(AxisId, u32)>>,
    /// The calls since the beginning; `None`: the machine has no journal.
    pub(crate) journal: Option<Vec<Entry>>,
    /// The state that it shares with its plant.
    plant: Option<Shared>,
}

/// A call on a machine, with the data to repeat it.
#[derive(Clone, Debug)]
pub(crate) enum Entry {
    Step(u64),
    Write(String, arcline_tag::WriteValue),
    Program(String, bool, bool),
    Remove(usize),
    Fault(u64, u16, u32),
}

/// Collects events.
#[derive(Default)]
pub(crate) struct Events {
    pub(crate) waiting: VecDeque<(f64, Event, String)>,
    pub(crate) is_on: bool,
}

impl Observer for Events {
    fn needs_every_tick(&self) -> bool {
        false
    }

    fn event(&mut self, event: &Event, time: f64, image: &Image) {
        if !self.is_on || event.set | event.clear == 0 {
            return;
        }
        if self.waiting.len() == EVENTS {
            self.waiting.pop_front();
        }
        self.waiting
            .push_back((time, *event, image.control_name(event.control).to_owned()));
    }
}

/// Samples signals at the end of ticks.
struct Rows<'r> {
    events: &'r mut Events,
    columns: &'r Columns,
    rows: std::slice::ChunksExactMut<'r, f64>,
}

impl Observer for Rows<'_> {
    fn needs_every_tick(&self) -> bool {
        self.rows.len() > 0
    }

    fn event(&mut self, event: &Event, time: f64, image: &Image) {
        self.events.event(event, time, image);
    }

    fn tick(&mut self, _: u64, _: &MachineConfig, controller: &mut Controller) -> bool {
        if let Some(row) = self.rows.next() {
            self.columns.read(controller, row);
        }
        true
    }
}

/// A machine before its first tick, with a plant behind its drives.
pub(crate) fn simulation(project: &Project, plant: Option<Plant>) -> Simulation {
    match plant {
        None => Simulation::of_project(project),
        Some(plant) => {
            let axes = plant.axes();
            Simulation::with_model(
                Arc::new(project.machine.clone()),
                project.image(),
                Box::new(plant),
                &axes,
            )
        }
    }
}

impl Inner {
    /// A machine with a plant has no journal: the state of the plant is not known.
    pub(crate) fn new(project: &Project, journal: bool, plant: Option<Plant>) -> Self {
        let shared = plant.as_ref().map(Plant::shared);
        let runner = Runner::of(simulation(project, plant));
        runner.simulation().begin();
        Inner {
            runner,
            programs: Vec::new(),
            events: Events::default(),
            faults: BTreeMap::new(),
            journal: (journal && shared.is_none()).then(Vec::new),
            plant: shared,
        }
    }

    pub(crate) fn tick(&self) -> u64 {
        self.runner.simulation().tick()
    }

    pub(crate) fn note(&mut self, entry: Entry) {
        let Some(journal) = &mut self.journal else { return };
        match (journal.last_mut(), &entry) {
            (Some(Entry::Step(before)), Entry::Step(more)) => *before += more,
            _ => journal.push(entry),
        }
    }

    /// Lets ticks pass, and injects the faults that are due.
    pub(crate) fn step(&mut self, ticks: u64) {
        self.note(Entry::Step(ticks));
        let end = self.tick().saturating_add(ticks);
        while self.inject_due() < end && !self.plant_has_failed() {
            let limits = RunLimits {
                ticks: self.ticks_at_once(end),
                until: f64::INFINITY,
            };
            self.runner.step(limits, &mut self.events);
        }
    }

    /// The same with a row of signals at the end of each tick.
    pub(crate) fn trace(&mut self, ticks: u64, signals: &[Signal], rows: &mut [f64]) {
        if signals.is_empty() {
            return self.step(ticks);
        }
        let width = signals.len();
        if signals.iter().any(Signal::is_tag) {
            for row in rows.chunks_exact_mut(width) {
                sample(&mut self.runner.simulation(), signals, row);
                self.step(1);
            }
            return;
        }
        self.note(Entry::Step(ticks));
        let end = self.tick().saturating_add(ticks);
        let columns = Columns::new(signals);
        let mut rows = rows;
        while self.inject_due() < end && !self.plant_has_failed() {
            let count = self.ticks_at_once(end);
            let (part, rest) = std::mem::take(&mut rows).split_at_mut(count as usize * width);
            rows = rest;
            let mut observer = Rows {
                events: &mut self.events,
                columns: &columns,
                rows: part.chunks_exact_mut(width),
            };
            let limits = RunLimits {
                ticks: count,
                until: f64::INFINITY,
            };
            self.runner.step(limits, &mut observer);
        }
    }

    fn plant_has_failed(&self) -> bool {
        self.plant.as_ref().is_some_and(Shared::has_failed)
    }

    /// Ticks that may pass before something is to be done between two: a fault that is injected; with a plant one, since it may fail.
    fn ticks_at_once(&self, end: u64) -> u64 {
        if self.plant.is_some() {
            return 1;
        }
        let next = self.faults.keys().next().copied().unwrap_or(end).min(end);
        next.saturating_sub(self.tick())
    }

    /// Injects the faults whose time has come. The present tick.
    pub(crate) fn inject_due(&mut self) -> u64 {
        let now = self.tick();
        while let Some(entry) = self.faults.first_entry().filter(|entry| *entry.key() <= now) {
            let mut simulation = self.runner.simulation();
            for (axis, bits) in entry.remove() {
                // The axis and the causes were checked.
                let _ = simulation.write(Origin::default(), |image| image.inject_faults(axis, bits));
            }
        }
        now
    }

    pub(crate) fn start(&mut self, py: Python<'_>, text: &str, wait: bool, keep_going: bool) -> PyResult<usize> {
        let program = parsed(py, self.runner.simulation().image(), text)?;
        let id = self.runner.start(Interpreter::new(program), policy(wait, keep_going));
        self.programs.push(id);
        self.note(Entry::Program(text.to_owned(), wait, keep_going));
        Ok(self.programs.len() - 1)
    }
}

/// A program whose names are those of a machine.
pub(crate) fn parsed(py: Python<'_>, image: &Image, text: &str) -> PyResult<Program> {
    let checked = Program::parse(text).and_then(|mut program| program.check(&ImageNames(image)).map(|()| program));
    checked.map_err(|error| errors::program(py, &error.to_string(), error.line))
}

/// The policy of a program.
pub(crate) fn policy(wait: bool, keep_going: bool) -> Policy {
    Policy {
        queue_full: if wait { QueueFull::Wait } else { QueueFull::Error },
        on_error: if keep_going { OnError::KeepGoing } else { OnError::Stop },
    }
}
