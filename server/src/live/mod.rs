//! The controller's own program on the running machine (spec/programs.md §14): the tasks of an L5X project on a thread of their own,
//! below the tick, which they can never delay. Clients see its tags in the tag memory and write between two rungs.
//!
//! Not here: the execution of routines (`arcline-routine`), the names of a machine for them, and a project on a virtual clock (`arcline-cell`).

mod host;
mod scanner;
#[cfg(test)]
mod tests;

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError, mpsc};
use std::thread::JoinHandle;
use std::time::Duration;

use arcline_cell::{LoadError, Places, Surroundings, UnknownParts, remove_others, told};
use arcline_config::Project as Configuration;
use arcline_controller::image::Image;
use arcline_controller::machine::Machine;
use arcline_routine::source::Project;
use arcline_routine::{Cell, Listing};

use crate::cli::Failure;
use crate::plant::{Mode, Plant, Program, machine_changes};
use scanner::Scanner;

/// A project that is to take the place of another one.
#[derive(Clone, Debug)]
pub(crate) struct Replacement {
    source: Project,
    unknown_parts: UnknownParts,
}

/// A project on a machine, before the machine runs.
pub(crate) struct Prepared {
    bound: Bound,
    settings: ProgramSettings,
}

/// A project whose tags are tags of the machine.
struct Bound {
    cell: Cell,
    places: Places,
    listing: Listing,
}

/// A program as the command line or the configuration names it.
#[derive(Clone, Debug)]
pub(crate) struct ProgramSettings {
    /// The L5X file.
    pub(crate) file: PathBuf,
    /// The mode at the start.
    pub(crate) mode: Mode,
    /// The treatment of unknown instructions.
    pub(crate) unknown_parts: UnknownParts,
    /// Whether the machine comes from the file too.
    pub(crate) has_machine: bool,
    /// The surroundings that the configuration gives the program.
    pub(crate) around: Surroundings,
}

/// The thread of a program. Dropped, it ends the thread.
#[derive(Debug)]
pub(crate) struct Live {
    over: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
    replacements: Arc<Mutex<Option<Order>>>,
    settings: ProgramSettings,
}

/// A project to run from the next scan on, and the place of the answer.
#[derive(Debug)]
struct Order {
    replacement: Replacement,
    answer: mpsc::SyncSender<Result<(), String>>,
}

/// Reads the program of a project's file.
fn read(file: &Path, around: &Surroundings) -> Result<Project, Failure> {
    let text = crate::l5x::read(file)?;
    let source = arcline_l5x::logic(&text, &file.display().to_string());
    let mut source = source.map_err(|error| Failure::usage(error.to_string()))?;
    around.surround(&mut source);
    Ok(source)
}

/// The configuration of the machine that a project's file describes. Its tags are the program's.
pub(crate) fn configuration(file: &Path) -> Result<Configuration, Failure> {
    let text = crate::l5x::read(file)?;
    let machine = arcline_l5x::machine(&text, &file.display().to_string());
    machine.map_err(|error| Failure::usage(error.to_string()))
}

impl Prepared {
    /// Loads the project of a file on a machine, and makes its tags tags of the machine.
    pub(crate) fn load(settings: ProgramSettings, machine: &Machine, image: &mut Image) -> Result<Self, Failure> {
        let ProgramSettings {
            file,
            unknown_parts,
            around,
            ..
        } = &settings;
        let source = read(file, around)?;
        let bound = bind(machine, image, &source, *unknown_parts);
        let bound = bound.map_err(|error| Failure::usage(format!("{}: {error}", file.display())))?;
        tell(file, &bound.listing);
        Ok(Prepared { bound, settings })
    }

    /// Runs it on a thread of its own.
    pub(crate) fn spawn(self, plant: &Plant) -> std::io::Result<Live> {
        let Prepared { bound, settings } = self;
        let Bound { cell, places, listing } = bound;
        let program = Arc::new(Program::new(
            settings.file.display().to_string(),
            settings.mode,
            listing,
        ));
        plant.set_program(program.clone());
        plant.exchange(false, Image::follow_for_program);
        let pause = Box::new(|| std::thread::sleep(MOMENT));
        let mut scanner = Scanner::new(plant.clone(), program, cell, places, pause);
        let over = Arc::new(AtomicBool::new(false));
        let replacements: Arc<Mutex<Option<Order>>> = Arc::default();
        let (ended, ordered) = (over.clone(), replacements.clone());
        // A quarter of a tick at most, so that none is missed while the tasks are short.
        let pause = Duration::from_nanos(plant.machine().period_ns / 4).clamp(MOMENT, Duration::from_millis(5));
        let thread = std::thread::Builder::new()
            .name("arcline-program".to_owned())
            .stack_size(arcline_routine::STACK);
        let thread = thread.spawn(move || {
            while !ended.load(Ordering::Acquire) {
                let order = ordered.lock().unwrap_or_else(PoisonError::into_inner).take();
                if let Some(order) = order {
                    let done = scanner.replace(&order.replacement);
                    // The caller may have given up.
                    let _ = order.answer.send(done.map_err(|error| error.to_string()));
                }
                if !scanner.step() {
                    std::thread::sleep(pause);
                }
            }
        })?;
        Ok(Live {
            over,
            thread: Some(thread),
            replacements,
            settings,
        })
    }
}

impl Live {
    /// Reads the file again. The new program is loaded and checked as a whole on a copy of the tags before it replaces the running one.
    ///
    /// # Errors
    /// Why the program stays as it is.
    pub(crate) fn reload(&self, plant: &Plant) -> Result<(), Failure> {
        let ProgramSettings {
            file,
            unknown_parts,
            has_machine,
            around,
            ..
        } = &self.settings;
        let shown = file.display();
        let wrong = |error: String| Failure::usage(format!("{shown}: {error}"));
        if *has_machine {
            let changes = machine_changes(plant.machine(), &configuration(file)?.machine);
            if !changes.is_empty() {
                return Err(wrong(format!("{} changed, which needs a restart", changes.join(", "))));
            }
        }
        let source = read(file, around)?;
        let mut copy = plant.with_image(Image::clone);
        let bound = rebind(plant.machine(), &mut copy, &source, *unknown_parts);
        tell(file, &bound.map_err(|error| wrong(error.to_string()))?.listing);
        let (answer, done) = mpsc::sync_channel(1);
        let replacement = Replacement {
            source,
            unknown_parts: *unknown_parts,
        };
        let order = Order { replacement, answer };
        *self.replacements.lock().unwrap_or_else(PoisonError::into_inner) = Some(order);
        match done.recv_timeout(REPLACED_WITHIN) {
            Ok(done) => done.map_err(wrong),
            Err(_) => Err(wrong("the program did not come to the end of a scan".to_owned())),
        }
    }

    /// Ends the thread between two scans.
    pub(crate) fn stop(mut self) {
        self.over.store(true, Ordering::Release);
        if let Some(thread) = self.thread.take() {
            // A scan that panicked has said so.
            let _ = thread.join();
        }
    }
}

impl Drop for Live {
    fn drop(&mut self) {
        self.over.store(true, Ordering::Release);
    }
}

/// Logs the parts of a project that do not run.
fn tell(file: &Path, listing: &Listing) {
    let file = file.display();
    for line in told(listing.findings()) {
        tracing::warn!("{file}: {line}");
    }
}

/// Loads a project on a machine, and makes its tags tags of the machine.
fn bind(
    machine: &Machine,
    image: &mut Image,
    source: &Project,
    unknown_parts: UnknownParts,
) -> Result<Bound, LoadError> {
    let arcline_cell::Bound {
        cell,
        places,
        findings,
        names,
    } = arcline_cell::bind(machine, image, source, unknown_parts)?;
    Ok(Bound {
        cell,
        places,
        listing: Listing::new(source.clone(), names, findings),
    })
}

/// Loads a project on a machine that has a program, and removes the tags of the former program that the project does not have.
fn rebind(
    machine: &Machine,
    image: &mut Image,
    source: &Project,
    unknown_parts: UnknownParts,
) -> Result<Bound, LoadError> {
    // Work on a copy without the tags of the present program, so that an error changes nothing.
    let mut copy = image.clone();
    copy.remove_program_tags(|_| false);
    let Bound { cell, .. } = bind(machine, &mut copy, source, unknown_parts)?;
    remove_others(image, &cell);
    bind(machine, image, source, unknown_parts)
}

/// A moment of a thread that waits for the tick.
const MOMENT: Duration = Duration::from_micros(100);
/// Longest wait for the end of a scan.
const REPLACED_WITHIN: Duration = Duration::from_secs(10);
