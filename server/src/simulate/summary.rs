//! The summary of a simulation for people: its time, the positions of the axes, the faults.

use std::fmt::Write as _;

use arcline_controller::machine::Machine;
use arcline_controller::{Controller, FaultChange};
use arcline_instruction_set::Ending;

/// The observations so far.
#[derive(Debug, Default)]
pub(super) struct Summary {
    /// Instructions that were executed.
    pub(super) executed: u64,
    ticks: u64,
    /// Positions of the axes, in position units, at the first tick and at the last.
    first: Vec<f64>,
    last: Vec<f64>,
    /// Faults as they were raised, and how many more there were.
    faults: Vec<String>,
    more: u64,
    /// Instructions that a fault ended.
    pub(super) stopped: Vec<String>,
}

impl Summary {
    pub(super) fn tick(&mut self, tick: u64, machine: &Machine, controller: &Controller) {
        self.ticks = tick;
        self.last.clear();
        self.last.extend(controller.trace().map(|axis| axis[0]));
        if self.first.len() != machine.axes.len() {
            self.first.clone_from(&self.last);
        }
    }

    pub(super) fn fault(&mut self, change: &FaultChange, time: f64, axis: &str) {
        if change.set.is_empty() {
            return;
        }
        if self.faults.len() == SHOWN {
            self.more += 1;
            return;
        }
        let words = Ending::words(change.set).join(", ");
        let refused = change
            .refused
            .map_or_else(String::new, |command| format!(" ({command})"));
        self.faults
            .push(format!("at {time} s: {axis} faulted: {words}{refused}"));
    }

    /// The lines; of a run that did not finish the faults alone, since its error follows.
    pub(super) fn text(&self, file: &str, machine: &Machine, finished: bool) -> String {
        let mut text = String::new();
        for line in self.faults.iter().chain(self.stopped.iter().take(SHOWN)) {
            let _ = writeln!(text, "{file}: {line}");
        }
        if self.more > 0 {
            let _ = writeln!(text, "{file}: {} more changes of faults", self.more);
        }
        if finished {
            let seconds = self.ticks as f64 * machine.period_ns as f64 / 1e9;
            let noun = if self.executed == 1 {
                "instruction"
            } else {
                "instructions"
            };
            let _ = write!(text, "{file}: ended after {seconds} s, {} {noun}", self.executed);
            let ends = machine.axes.iter().zip(&self.last).zip(&self.first);
            let moved = ends.filter(|((_, last), first)| last != first);
            let mut before = "; ";
            for ((axis, last), _) in moved {
                let _ = write!(text, "{before}{} at {last} {}", axis.name, axis.units);
                before = ", ";
            }
            text.push('\n');
        }
        text
    }
}

/// The most faults and instructions that the summary lists one by one.
const SHOWN: usize = 20;
