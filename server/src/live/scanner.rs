//! The scan of a program on a running machine, a step at a time: the thread of the program makes the steps, a test may make them too.

use std::sync::Arc;
use std::time::{Duration, Instant};

use arcline_cell::{LoadError, Places, UnknownParts};
use arcline_routine::source::Project;
use arcline_routine::{Cell, Fault};

use super::host::{LiveHost, Pause};
use super::{Bound, Replacement, rebind};
use crate::audit::EventKind;
use crate::plant::{Mode, Plant, Principal, Program, ProgramState};

/// A program and its state.
pub(crate) struct Scanner {
    plant: Plant,
    program: Arc<Program>,
    cell: Cell,
    host: LiveHost,
    state: State,
    /// The newest tick whose tasks have run.
    tick: u64,
    period: u64,
    /// The state of the monitors that the cell traces; `None`: they are of the program before.
    monitor_changes: Option<u64>,
    is_monitored: bool,
    sampled_at: Instant,
    version: u64,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum State {
    Stopped,
    Running,
    Faulted,
}

impl Scanner {
    pub(crate) fn new(plant: Plant, program: Arc<Program>, cell: Cell, places: Places, pause: Pause) -> Self {
        Scanner {
            period: plant.machine().period_ns,
            host: LiveHost::new(plant.clone(), program.clone(), &cell, places, pause),
            monitor_changes: Some(0),
            is_monitored: false,
            sampled_at: Instant::now(),
            version: program.listing().0,
            plant,
            program,
            cell,
            state: State::Stopped,
            tick: 0,
        }
    }

    /// Takes a mode that was asked for, exchanges tags, and scans the tasks that are due in a tick that has not been scanned yet.
    /// Returns whether there was one.
    pub(crate) fn step(&mut self) -> bool {
        let scanned = self.scan();
        self.show();
        scanned
    }

    /// Samples the rungs that viewers watch. While no viewer watches, it reads one number.
    fn show(&mut self) {
        let monitors = &self.program.monitors;
        let changes = monitors.changes();
        if Some(changes) == self.monitor_changes && (!self.is_monitored || self.sampled_at.elapsed() < SHOW_EVERY) {
            return;
        }
        let mut all = monitors.lock();
        // A viewer may have gone while its monitor was compiled.
        all.retain(|_, one| one.samples.receiver_count() > 0);
        let current = all.values().filter(|one| one.version == self.version);
        if Some(changes) != self.monitor_changes {
            self.monitor_changes = Some(changes);
            self.is_monitored = !all.is_empty();
            self.cell.trace(current.clone().map(|one| one.monitor.routine()));
        }
        for one in current {
            let newest = self.cell.sample(&one.monitor);
            one.samples.send_if_modified(|shown| {
                let is_new = *shown != newest;
                *shown = newest;
                is_new
            });
        }
        self.sampled_at = Instant::now();
    }

    fn scan(&mut self) -> bool {
        let tick = self.host.exchange(self.cell.memory_mut());
        match (self.program.mode(), self.state) {
            (Mode::Run, State::Stopped) => self.run(tick),
            (Mode::Program, State::Running | State::Faulted) => self.stop(),
            _ => {}
        }
        if self.state != State::Running || tick == self.tick {
            return false;
        }
        self.tick = tick;
        let began = Instant::now();
        self.cell.lose_releases(tick.saturating_sub(1) * self.period);
        let scanned = self.cell.tick(tick, self.period, &mut self.host);
        self.host.exchange(self.cell.memory_mut());
        let took = u64::try_from(began.elapsed().as_micros()).unwrap_or(u64::MAX);
        self.program.show(|status| {
            status.scans += 1;
            status.last_us = took;
            status.longest_us = status.longest_us.max(took);
        });
        if let Err(fault) = scanned {
            self.fault(&fault);
        }
        true
    }

    /// Takes another project in place of this one, between two scans. Tags that both have with one type keep their values.
    pub(crate) fn replace(&mut self, replacement: &Replacement) -> Result<(), LoadError> {
        self.host.exchange(self.cell.memory_mut());
        let Replacement { source, unknown_parts } = replacement;
        let Bound { cell, places, listing } = self.bind(source, *unknown_parts)?;
        self.host.take_over(&cell, places);
        self.cell = cell;
        self.version = self.program.set_listing(listing);
        // The monitors of the program before are over.
        self.monitor_changes = None;
        if self.state == State::Running {
            self.run(self.tick);
        }
        Ok(())
    }

    fn bind(&self, source: &Project, unknown_parts: UnknownParts) -> Result<Bound, LoadError> {
        let machine = self.plant.machine();
        self.plant
            .exchange(true, |image| rebind(machine, image, source, unknown_parts))
    }

    /// Enters Run.
    fn run(&mut self, tick: u64) {
        self.state = State::Running;
        self.tick = tick;
        self.program.show(|shown| {
            (shown.state, shown.fault) = (ProgramState::Running, None);
            (shown.scans, shown.last_us, shown.longest_us) = (0, 0, 0);
        });
        let began = self.cell.start(tick * self.period, &mut self.host);
        self.host.exchange(self.cell.memory_mut());
        if let Err(fault) = began {
            self.fault(&fault);
        }
    }

    /// Leaves Run: motion stops, tags stay.
    fn stop(&mut self) {
        self.state = State::Stopped;
        self.plant.stop_all();
        self.program.show(|status| {
            (status.state, status.fault) = (ProgramState::Stopped, None);
        });
    }

    fn fault(&mut self, fault: &Fault) {
        self.state = State::Faulted;
        self.plant.stop_all();
        let words = fault.to_string();
        tracing::error!("the program of the controller has stopped: {words}");
        self.plant
            .record(Principal::Controller, EventKind::Stop, words.clone(), "major fault");
        self.program.show(|status| {
            (status.state, status.fault) = (ProgramState::Faulted(words), Some(fault.clone()));
        });
    }
}

/// Shortest time between two samples of watched rungs.
const SHOW_EVERY: Duration = Duration::from_millis(200);
