//! The controller's own program as the plant knows it: its mode, its state, and the exchange of tags. `crate::live` runs it.

use std::sync::atomic::Ordering;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use arcline_controller::Input;
use arcline_controller::image::Image;
use arcline_routine::{Fault, Listing};

use super::Plant;
use super::forces::Forces;
use super::monitors::Monitors;

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

/// The state of the controller's own program.
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
    /// The state.
    pub state: ProgramState,
    /// Ticks in which the due tasks were scanned.
    pub scans: u64,
    /// Time of the newest of these, µs.
    pub last_us: u64,
    /// The longest time of one, µs.
    pub longest_us: u64,
    /// The major fault that has stopped the tasks.
    pub fault: Option<Fault>,
    /// Another number for each program that was loaded.
    pub version: u64,
}

/// The data that the thread of the program and the interfaces share: the mode and the state, the listing for people, the rungs that viewers watch,
/// and the forced inputs.
#[derive(Debug)]
pub(crate) struct Program {
    shown: Mutex<Shown>,
    pub(crate) monitors: Monitors,
    pub(crate) forces: Forces,
}

#[derive(Debug)]
struct Shown {
    mode: Mode,
    status: ProgramStatus,
    listing: Arc<Listing>,
}

impl Program {
    /// A program that does not run yet, and the mode that it is to have.
    pub(crate) fn new(file: String, mode: Mode, listing: Listing) -> Self {
        let status = ProgramStatus {
            file,
            version: 1,
            ..ProgramStatus::default()
        };
        let listing = Arc::new(listing);
        Program {
            shown: Mutex::new(Shown { mode, status, listing }),
            monitors: Monitors::default(),
            forces: Forces::default(),
        }
    }

    /// The program as people read it, and its version.
    pub(crate) fn listing(&self) -> (u64, Arc<Listing>) {
        let shown = self.lock();
        (shown.status.version, shown.listing.clone())
    }

    /// Another program has taken the place of this one. Returns its version.
    pub(crate) fn set_listing(&self, listing: Listing) -> u64 {
        let mut shown = self.lock();
        shown.status.version += 1;
        shown.listing = Arc::new(listing);
        shown.status.version
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
        self.shown.lock().unwrap_or_else(PoisonError::into_inner)
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

    /// The controller's program; `None`: it has none.
    pub(crate) fn program(&self) -> Option<&Arc<Program>> {
        self.0.program.get()
    }

    /// Whether there are changes of tags that the program has not taken. The call waits for no lock.
    pub(crate) fn has_foreign_changes(&self) -> bool {
        self.0.published.foreign_changes.load(Ordering::Acquire)
    }

    /// Lets the program take the changes of the clients, and show its own changes if it `shows` any.
    pub(crate) fn exchange<R>(&self, shows: bool, exchange: impl FnOnce(&mut Image) -> R) -> R {
        let mut state = self.0.lock();
        state.refresh();
        exchange(state.image_of_program(shows))
    }

    /// A wire of the program gives an input of an axis a value.
    pub(crate) fn give_input(&self, input: Input) {
        self.0.lock().send_input(input);
    }
}
