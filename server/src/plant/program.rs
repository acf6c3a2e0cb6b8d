//! The controller's own program as the plant knows it: its mode, its state, and the exchange of tags. What runs it is `crate::live`.

use std::sync::atomic::Ordering;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use arcline_controller::image::Image;

use super::Plant;

/// The mode that the controller is to have.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Mode {
    /// The tasks do not run.
    Program,
    /// The tasks run.
    Run,
}

impl Mode {
    /// Its word in the configuration, on the command line and in the audit.
    pub fn word(self) -> &'static str {
        match self {
            Self::Program => "program",
            Self::Run => "run",
        }
    }
}

/// What the program does.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub enum ProgramState {
    /// The tasks do not run.
    #[default]
    Stopped,
    /// The tasks run.
    Running,
    /// A major fault that no fault routine cleared has stopped the tasks, in words.
    Faulted(String),
}

/// The state of the program, and its scans since it began to run.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct ProgramStatus {
    /// The name of the file.
    pub file: String,
    /// What it does.
    pub state: ProgramState,
    /// Ticks in which the due tasks were scanned.
    pub scans: u64,
    /// Time of the newest of these, µs.
    pub last_us: u64,
    /// The longest time of one, µs.
    pub longest_us: u64,
}

/// The mode and the state, which the thread of the program and the faces share.
#[derive(Debug)]
pub(crate) struct Program(Mutex<Shown>);

#[derive(Debug)]
struct Shown {
    mode: Mode,
    status: ProgramStatus,
}

impl Program {
    /// A program that does not run yet, and the mode that it is to have.
    pub(crate) fn new(file: String, mode: Mode) -> Self {
        let status = ProgramStatus {
            file,
            ..ProgramStatus::default()
        };
        Program(Mutex::new(Shown { mode, status }))
    }

    /// The mode that was asked for last.
    pub(crate) fn mode(&self) -> Mode {
        self.lock().mode
    }

    /// Asks for a mode. The thread of the program takes it between two scans.
    pub(super) fn ask(&self, mode: Mode) {
        self.lock().mode = mode;
    }

    /// Its state.
    pub(crate) fn status(&self) -> ProgramStatus {
        self.lock().status.clone()
    }

    /// Shows a state.
    pub(crate) fn show(&self, change: impl FnOnce(&mut ProgramStatus)) {
        change(&mut self.lock().status);
    }

    fn lock(&self) -> MutexGuard<'_, Shown> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Plant {
    /// From now on the controller has a program.
    pub(crate) fn set_program(&self, program: Arc<Program>) {
        // There is one, set at the start.
        let _ = self.0.program.set(program);
    }

    /// The state of the controller's program; `None`: it has none.
    pub fn program_status(&self) -> Option<ProgramStatus> {
        self.0.program.get().map(|program| program.status())
    }

    /// Whether there are changes of tags that the program has not taken. It waits for no lock.
    pub(crate) fn has_foreign_changes(&self) -> bool {
        self.0.published.foreign_changes.load(Ordering::Acquire)
    }

    /// Lets the program take what others have changed, and show what it has changed itself if it `shows` anything.
    pub(crate) fn exchange<R>(&self, shows: bool, exchange: impl FnOnce(&mut Image) -> R) -> R {
        let mut state = self.0.lock();
        state.refresh();
        exchange(state.image_of_program(shows))
    }
}
