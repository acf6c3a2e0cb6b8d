//! The thread: absolute deadlines, late ticks, and a controlled end.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc;
use std::thread::JoinHandle;

use arcline_controller::Controller;
use arcline_controller::machine::Machine;
use rustix::thread::clock_nanosleep_absolute;
use rustix::time::{ClockId, Timespec, clock_gettime};

use crate::clock::{self, Clock, Stepper};
use crate::meter::Meter;
use crate::rings::{Rings, ServerRings, link};
use crate::schedule::{self, Report};

/// The options of the thread.
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// Priority under SCHED_FIFO, 1 to 99.
    pub priority: i32,
    /// The core to which it is pinned; `None`: the last one, if there are several and the priority was granted.
    pub core: Option<usize>,
    /// Most missed ticks that are caught up; if more are missed, the time base moves.
    pub catch_up: u64,
    /// Longest wait for the end of all motion when the thread is stopped, ticks.
    pub grace: u64,
    /// The clock of the ticks.
    pub clock: Clock,
}

impl Default for Options {
    fn default() -> Self {
        Options {
            priority: 80,
            core: None,
            catch_up: 1000,
            grace: 30_000,
            clock: Clock::Real,
        }
    }
}

/// The thread could not be started.
#[derive(Debug)]
pub struct SpawnError(std::io::Error);

impl std::fmt::Display for SpawnError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "the real-time thread could not be started: {}", self.0)
    }
}

impl std::error::Error for SpawnError {}

/// The running thread. Dropping it also stops the thread, without a wait for its end.
#[derive(Debug)]
pub struct Handle {
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
    report: Report,
}

impl Handle {
    /// The results of the thread's requests to the system.
    pub fn report(&self) -> &Report {
        &self.report
    }

    /// Stops all motion in a controlled way, waits until all axes stand (at most
    /// [`Options::grace`] ticks), and ends the thread. Blocks until then.
    pub fn stop(mut self) {
        self.stop.store(true, Ordering::Release);
        if let Some(thread) = self.thread.take() {
            // It never panics: a panic ends the process.
            let _ = thread.join();
        }
    }
}

impl Drop for Handle {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Release);
    }
}

/// Starts the controller of a machine on its own thread. Logs one warning if the system granted less
/// than was requested.
///
/// # Errors
/// If the system has no thread left.
pub fn spawn(machine: &Machine, options: Options) -> Result<(ServerRings, Handle), SpawnError> {
    let (mut rings, mut link) = link(machine);
    let mut period = machine.period_ns.max(1);
    match options.clock {
        Clock::Real => {}
        Clock::Fast(times) => period = ((period as f64 / times) as u64).max(1),
        Clock::Step => {
            rings.set_stepped();
            link.planning = None;
            link.stepper = Some(Stepper::new());
        }
    }
    let stepper = link.stepper.clone();
    let controller = Controller::new(machine);
    let stop = Arc::new(AtomicBool::new(false));
    let asked = stop.clone();
    let (report_sender, report) = mpsc::sync_channel(1);
    let thread = std::thread::Builder::new()
        .name("arcline-tick".to_owned())
        .stack_size(STACK)
        .spawn(move || {
            let _abort = AbortOnPanic;
            // Steps need no deadlines.
            let report = match &stepper {
                Some(_) => Report::default(),
                None => schedule::prepare(options.priority, options.core),
            };
            rings.meter.report(&report);
            // The process may end before it reads the report.
            let _ = report_sender.send(report);
            match &stepper {
                Some(stepper) => clock::run(controller, rings, stepper, options.grace, &asked),
                None => run(controller, rings, period, &options, &asked),
            }
        })
        .map_err(SpawnError)?;
    if let Some(mut planning) = link.planning.take() {
        let over = stop.clone();
        std::thread::Builder::new()
            .name("arcline-contour".to_owned())
            .spawn(move || {
                schedule::prefer();
                planning.run(&over);
            })
            .map_err(SpawnError)?;
    }
    let report = report.recv().unwrap_or_default();
    if !report.shortfalls.is_empty() {
        let shortfalls: Vec<String> = report.shortfalls.iter().map(ToString::to_string).collect();
        tracing::warn!(
            "no real-time priority, the system did not grant {}: ticks may be late. See the tag RealTime. Harmless in tests",
            shortfalls.join(", ")
        );
    }
    Ok((
        link,
        Handle {
            stop,
            thread: Some(thread),
            report,
        },
    ))
}

/// The body of the loop: one tick, commands taken from the rings, and answers, events and a snapshot put there.
///
/// Real-time: no allocation, lock, system call or log; bounded as [`Controller::tick`].
pub fn step(controller: &mut Controller, rings: &mut Rings) {
    controller.tick(rings);
    rings.tick += 1;
}

fn run(mut controller: Controller, mut rings: Rings, period: u64, options: &Options, asked: &AtomicBool) {
    let meter: Arc<Meter> = rings.meter.clone();
    let mut due = now();
    let mut grace = options.grace;
    loop {
        let mut begun = now();
        let caught_up = begun >= due + period;
        if begun < due {
            sleep_until(due);
            begun = now();
        } else if (begun - due) / period > options.catch_up {
            due += (begun - due) / period * period;
            meter.resynchronise();
        }
        if asked.load(Ordering::Acquire) {
            rings.stop();
            if grace == 0 || (controller.at_rest() && grace < options.grace) {
                return;
            }
            grace -= 1;
        }
        step(&mut controller, &mut rings);
        let ended = now();
        meter.tick(
            begun.saturating_sub(due),
            ended.saturating_sub(begun),
            ended >= due + period,
            caught_up,
        );
        due += period;
    }
}

/// Monotonic time, ns.
pub(crate) fn now() -> u64 {
    let time = clock_gettime(ClockId::Monotonic);
    time.tv_sec as u64 * NANOSECONDS + time.tv_nsec as u64
}

fn sleep_until(due: u64) {
    let request = Timespec {
        tv_sec: (due / NANOSECONDS) as i64,
        tv_nsec: (due % NANOSECONDS) as _,
    };
    // A signal ends the sleep early: the deadline stays.
    while clock_nanosleep_absolute(ClockId::Monotonic, &request) == Err(rustix::io::Errno::INTR) {}
}

/// A panic in the tick is a bug, and motion must not continue without the tick: the process ends.
struct AbortOnPanic;

impl Drop for AbortOnPanic {
    fn drop(&mut self) {
        if std::thread::panicking() {
            std::process::abort();
        }
    }
}

const NANOSECONDS: u64 = 1_000_000_000;
const STACK: usize = 1024 * 1024;
