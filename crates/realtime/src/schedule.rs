//! The requests of a thread to the system for punctual execution, and their results.

use std::fmt;
use std::num::NonZeroU64;

use rustix::io::Errno;
use rustix::mm::MlockAllFlags;
use rustix::process::{Resource, getrlimit, setpriority_process};
use rustix::thread::{CpuSet, sched_getaffinity, sched_setaffinity, set_current_timer_slack};

/// The results for the real-time thread.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Report {
    /// The thread runs under SCHED_FIFO.
    pub fifo: bool,
    /// Memory is locked.
    pub memory_locked: bool,
    /// The core to which it is pinned.
    pub core: Option<usize>,
    /// The refused requests.
    pub shortfalls: Vec<Shortfall>,
}

/// A request that the system refused.
#[derive(Clone, Debug, PartialEq)]
pub struct Shortfall {
    /// The request.
    pub what: &'static str,
    /// The reason.
    pub why: String,
}

impl fmt::Display for Shortfall {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} ({})", self.what, self.why)
    }
}

impl Report {
    fn lacks(&mut self, what: &'static str, why: impl fmt::Display) {
        self.shortfalls.push(Shortfall {
            what,
            why: why.to_string(),
        });
    }
}

/// Prepares the calling thread. Every request is optional: a refused one is reported.
pub(crate) fn prepare(priority: i32, core: Option<usize>) -> Report {
    let mut report = Report::default();
    prefault_stack();
    if let Err(error) = lock_memory() {
        report.lacks("memory lock", error);
    } else {
        report.memory_locked = true;
    }
    // Under the normal class a sleep may otherwise end 50 µs late.
    if let Err(error) = set_current_timer_slack(NonZeroU64::new(1)) {
        report.lacks("timer slack of 1 ns", error);
    }
    match fifo(priority) {
        Ok(()) => report.fifo = true,
        Err(error) => report.lacks("SCHED_FIFO", error),
    }
    // Pinned without a priority, the thread would wait for any other process on that core.
    if report.fifo || core.is_some() {
        match pin(core) {
            Ok(core) => report.core = core,
            Err(error) => report.lacks("core pinning", error),
        }
    }
    report
}

/// Prepares the calling thread for its own deadlines beside the tick: punctual sleeps, and SCHED_FIFO at a
/// priority that never delays the tick. Every request is optional: a refused one is reported.
///
/// The thread must bound its own work: it precedes everything that is not real-time.
pub fn prepare_beside_tick() -> Report {
    let mut report = Report::default();
    if let Err(error) = set_current_timer_slack(NonZeroU64::new(1)) {
        report.lacks("timer slack of 1 ns", error);
    }
    match fifo(BESIDE_TICK) {
        Ok(()) => report.fifo = true,
        Err(error) => report.lacks("SCHED_FIFO", error),
    }
    report
}

/// Gives the calling thread a larger share of a busy processor than other threads of the normal class, if the system allows that.
pub(crate) fn prefer() {
    if let Err(error) = setpriority_process(None, PREFERRED) {
        tracing::debug!("no higher priority for the planning of contours: {error}");
    }
}

/// The nice value of a preferred thread: nine times the weight of a normal one.
const PREFERRED: i32 = -10;

/// Far below the tick's own priority.
const BESIDE_TICK: i32 = 40;

fn lock_memory() -> Result<(), Errno> {
    // Under a limit, locking future memory would make later allocations fail, so only present memory is locked.
    let limit = getrlimit(Resource::Memlock).current;
    let flags = match limit {
        None => MlockAllFlags::CURRENT | MlockAllFlags::FUTURE,
        Some(_) => MlockAllFlags::CURRENT,
    };
    rustix::mm::mlockall(flags)
}

/// Pins to the given core, or to the last of several that the thread may use.
fn pin(core: Option<usize>) -> Result<Option<usize>, Errno> {
    let allowed = sched_getaffinity(None)?;
    let core = match core {
        Some(core) => core,
        None if allowed.count() < 2 => return Ok(None),
        None => match (0..CpuSet::MAX_CPU).rev().find(|core| allowed.is_set(*core)) {
            Some(core) => core,
            None => return Ok(None),
        },
    };
    if core >= CpuSet::MAX_CPU {
        return Err(Errno::INVAL);
    }
    let mut only = CpuSet::new();
    only.set(core);
    sched_setaffinity(None, &only)?;
    Ok(Some(core))
}

#[allow(unsafe_code)]
fn fifo(priority: i32) -> Result<(), std::io::Error> {
    // SAFETY: the structure consists of plain numbers, and all zeros is a valid value.
    let mut parameters: libc::sched_param = unsafe { std::mem::zeroed() };
    parameters.sched_priority = priority;
    // SAFETY: 0 is the calling thread; the pointer is to a live structure that is only read.
    match unsafe { libc::sched_setscheduler(0, libc::SCHED_FIFO, &parameters) } {
        0 => Ok(()),
        _ => Err(std::io::Error::last_os_error()),
    }
}

/// Touches the stack that the ticks will use, so that none of them causes a page fault.
#[inline(never)]
fn prefault_stack() {
    let mut pages = [0u8; PREFAULTED_STACK];
    for page in pages.chunks_mut(PAGE) {
        if let Some(byte) = page.first_mut() {
            *byte = 1;
        }
    }
    std::hint::black_box(&mut pages);
}

const PREFAULTED_STACK: usize = 256 * 1024;
const PAGE: usize = 4096;
