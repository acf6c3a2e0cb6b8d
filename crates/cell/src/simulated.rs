//! A project on the virtual clock: its tasks beside its machine, tick by tick.
//!
//! In a tick the machine begins, then the tasks that are due run and call instructions of motion at this instant, then the machine ends the tick. No
//! other input enters, so two runs give the same bytes.

use std::collections::BTreeMap;

use arcline_config::Project as Configuration;
use arcline_controller::machine::Machine;
use arcline_instruction_set::AxisId;
use arcline_routine::source::Project;
use arcline_routine::{Cell, Fault, Finding};
use arcline_simulation::{Observer, Origin, Simulation};

use crate::binding::{Bound, LoadError, Surroundings, UnknownParts, bind};
use crate::json;
use crate::plant::Plant;

/// A project on a machine with a virtual clock. After [`SimulatedCell::begin`] tick 0 is open and was not scanned; behind a run it stands at the end of
/// a tick.
#[derive(Debug)]
pub struct SimulatedCell {
    pub(crate) cell: Cell,
    pub(crate) plant: Plant,
    source: Project,
    findings: Vec<Finding>,
    /// The numbers of the tags by program and name, in lower case.
    pub(crate) names: BTreeMap<(Option<String>, String), usize>,
    /// The major fault that stopped the tasks.
    stopped: Option<Fault>,
}

/// An expression of tags of a project.
#[derive(Clone, Debug)]
pub struct Condition {
    expression: arcline_routine::Condition,
    /// Whether it reads an axis, a coordinate system or the group.
    reads_machine: bool,
}

/// The limits of a run.
#[derive(Clone, Copy, Debug)]
pub struct RunLimits<'c> {
    /// The condition that ends it.
    pub until: Option<&'c Condition>,
    /// Most ticks.
    pub ticks: u64,
    /// The simulated time at whose tick it ends, s.
    pub time: f64,
}

/// The end of a run.
#[derive(Clone, PartialEq, Debug)]
pub enum End {
    /// The condition became true.
    Reached,
    /// The ticks or the time passed.
    Time,
    /// A major fault that no routine cleared: the tasks have stopped.
    Fault(Fault),
    /// The observer ended the run.
    Left,
}

/// A value that was not given to a tag.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
#[error("{tag}: {reason}")]
pub struct NotSet {
    /// The tag as it was given.
    pub tag: String,
    /// The reason in words.
    pub reason: String,
}

impl SimulatedCell {
    /// Loads a project on the machine of a configuration, before tick 0.
    ///
    /// # Errors
    /// Parts of the project do not run, or a tag has no place.
    pub fn load(
        configuration: &Configuration,
        mut source: Project,
        unknown_parts: UnknownParts,
    ) -> Result<Self, LoadError> {
        Surroundings::of(&configuration.server.controller).surround(&mut source);
        let mut simulation = Simulation::of_project(configuration);
        let machine = simulation.machine().clone();
        let bound = bind(&machine, simulation.image_mut(), &source, unknown_parts)?;
        let Bound {
            cell, places, findings, ..
        } = bound;
        let names = (0..).zip(cell.tags()).map(|(number, tag)| {
            let program = tag.program.as_deref().map(str::to_ascii_lowercase);
            ((program, tag.name.to_ascii_lowercase()), number)
        });
        Ok(SimulatedCell {
            names: names.collect(),
            cell,
            plant: Plant::new(simulation, places),
            source,
            findings,
            stopped: None,
        })
    }

    /// The parts of the project that do not run, and are passed over.
    pub fn findings(&self) -> &[Finding] {
        &self.findings
    }

    /// The machine.
    pub fn machine(&self) -> &Machine {
        self.plant.simulation().machine()
    }

    /// The machine and its tags as the machine last showed them. The project's own tags are in its memory: [`SimulatedCell::value`].
    pub fn simulation(&self) -> &Simulation {
        self.plant.simulation()
    }

    /// The names of all tags of the project, in the order of the file, with their programs.
    pub fn tags(&self) -> impl Iterator<Item = String> {
        self.cell.tags().iter().map(arcline_routine::Tag::full_name)
    }

    /// The present tick.
    pub fn tick(&self) -> u64 {
        self.plant.simulation().tick()
    }

    /// Simulated time at the present tick, s.
    pub fn time(&self) -> f64 {
        self.plant.simulation().time()
    }

    /// The major faults so far, those that were cleared among them.
    pub fn faults(&self) -> impl Iterator<Item = Fault> {
        self.cell.faults()
    }

    /// Every tag as JSON, with the simulated time and the faults.
    pub fn tags_json(&mut self) -> String {
        self.show_machine();
        json::json(&self.cell, self.time())
    }

    /// Lets the scans of the continuous task fall in other ticks, by a seed.
    pub fn set_phase(&mut self, seed: u64) {
        self.cell.set_phase(seed);
    }

    /// An expression of tags in the controller's scope: `Done`, `Program:Main.C1.ACC >= 5`.
    ///
    /// # Errors
    /// The error in words.
    pub fn condition(&self, text: &str) -> Result<Condition, String> {
        let compiled = self
            .plant
            .with_names(|names| self.cell.condition(&self.source, names, text));
        compiled.map(|expression| Condition {
            reads_machine: self.plant.is_read_by(&expression),
            expression,
        })
    }

    /// Whether a condition holds now.
    pub fn holds(&mut self, condition: &Condition) -> bool {
        if condition.reads_machine {
            self.show_machine();
        }
        self.cell.holds(&condition.expression, &mut self.plant)
    }

    /// Begins tick 0 and enters Run: every scheduled program is prescanned.
    ///
    /// # Errors
    /// A major fault of the prescan.
    pub fn begin(&mut self, observer: &mut impl Observer) -> Result<(), Fault> {
        observer.begin(self.plant.simulation().machine());
        self.open();
        self.show_machine();
        let began = self.cell.start(0, &mut self.plant);
        self.stopped = began.as_ref().err().cloned();
        began
    }

    /// Writes values as Structured Text has them, to tags and parts of tags: `Go` and `1`, `Program:Main.T1.PRE` and `500`.
    ///
    /// # Errors
    /// The first tag that cannot be written.
    pub fn set(&mut self, given: &[(&str, &str)]) -> Result<(), NotSet> {
        let writes = self
            .plant
            .with_names(|names| self.cell.writes(&self.source, names, given));
        let writes = writes.map_err(|(tag, reason)| NotSet { tag, reason })?;
        self.show_machine();
        let written = self.cell.write(&writes, &mut self.plant);
        written.map_err(|tag| NotSet {
            tag,
            reason: "it cannot be written".to_owned(),
        })
    }

    /// Whether the present tick has begun and was not scanned.
    pub fn is_open(&self) -> bool {
        self.plant.simulation().is_open()
    }

    /// Runs ticks until the condition holds at the end of one, a limit is reached, or a major fault stops the tasks. At least one tick passes, unless a
    /// fault has stopped them before or no tick may.
    pub fn run(&mut self, limits: RunLimits<'_>, observer: &mut impl Observer) -> End {
        let mut left = limits.ticks;
        while left > 0 {
            if let Some(fault) = &self.stopped {
                return End::Fault(fault.clone());
            }
            let period = self.machine().period_ns;
            left -= 1;
            if !self.is_open() {
                let most = self.plant.simulation().unseen_ticks(limits.time, observer).min(left);
                let most = most.min(self.cell.idle_ticks(self.tick(), period));
                let sees_machine = limits.until.is_some_and(|condition| condition.reads_machine);
                left -= self.plant.begin_after(if sees_machine { 0 } else { most });
            }
            if self.cell.reads(self.tick(), period) {
                self.show_machine();
            }
            let scanned = self.cell.tick(self.tick(), period, &mut self.plant);
            let goes_on = self.plant.end_tick(&mut self.cell, observer);
            if let Err(fault) = scanned {
                self.stopped = Some(fault.clone());
                return End::Fault(fault);
            }
            if limits.until.is_some_and(|condition| self.holds(condition)) {
                return End::Reached;
            }
            if !goes_on {
                return End::Left;
            }
            if self.time() >= limits.time {
                return End::Time;
            }
        }
        End::Time
    }

    /// Brings axes and coordinate systems in the project's memory up to this moment, unless they are.
    fn show_machine(&mut self) {
        self.plant.show_changes(self.cell.memory_mut());
    }

    /// Begins the next tick, unless the present one is open.
    pub(crate) fn open(&mut self) {
        if !self.is_open() {
            self.plant.begin_after(0);
        }
    }

    /// Injects causes of faults on an axis; none take them away. The axis and the causes must be possible.
    pub fn inject(&mut self, axis: AxisId, causes: u32) {
        let simulation = self.plant.simulation_mut();
        // The caller has looked that it is possible.
        let _ = simulation.write(Origin::default(), |image| image.inject_faults(axis, causes));
    }
}
