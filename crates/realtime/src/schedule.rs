//! What a thread asks the system for so that it runs on time, and what it got.

use std::fmt;
use std::num::NonZeroU64;

use rustix::io::Errno;
use rustix::mm::MlockAllFlags;
use rustix::process::{Resource, getrlimit};
use rustix::thread::{CpuSet, sched_getaffinity, sched_setaffinity, set_current_timer_slack};

/// What the real-time thread obtained.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Report {
    /// Runs under SCHED_FIFO.
    pub fifo: bool,
    /// Memory is locked.
    pub memory_locked: bool,
    /// The core it is pinned to.
    pub core: Option<usize>,
    /// What it did not get, and why.
    pub shortfalls: Vec<Shortfall>,
}

/// Something that the system refused.
#[derive(Clone, Debug, PartialEq)]
pub struct Shortfall {
    /// What was asked for.
    pub what: &'static str,
    /// Why not.
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

/// Prepares the calling thread. Nothing here is necessary: what cannot be had is reported.
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
    // Pinned but not preferred, it would wait behind whatever else runs on that core.
    if report.fifo || core.is_some() {
        match pin(core) {
            Ok(core) => report.core = core,
            Err(error) => report.lacks("core pinning", error),
        }
    }
    report
}

/// Prepares the calling thread for deadlines of its own beside the tick's: a sleep that ends on time, and SCHED_FIFO at a
/// priority that never delays the tick. Nothing here is necessary: what cannot be had is reported.
///
/// The thread must bound its own work: it comes before everything that is not real-time.
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

/// Far below the tick's own priority.
const BESIDE_TICK: i32 = 40;

fn lock_memory() -> Result<(), Errno> {
    // With a limit, locking what comes later would make later allocations fail: refuse instead.
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
    // SAFETY: the structure is plain numbers, and all zeros is a value of it.
    let mut parameters: libc::sched_param = unsafe { std::mem::zeroed() };
    parameters.sched_priority = priority;
    // SAFETY: 0 is the calling thread; the pointer is to a live structure that is only read.
    match unsafe { libc::sched_setscheduler(0, libc::SCHED_FIFO, &parameters) } {
        0 => Ok(()),
        _ => Err(std::io::Error::last_os_error()),
    }
}

/// Touches the stack that the ticks will use, so that none of them meets a page fault.
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
