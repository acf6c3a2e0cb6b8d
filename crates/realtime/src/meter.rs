//! Lateness, compute time and overruns: counters that one thread writes and all others can read.
//!
//! A reader may see the numbers of two neighbouring ticks; each single number is consistent.

use std::sync::atomic::Ordering::{Acquire, Relaxed, Release};
use std::sync::atomic::{AtomicBool, AtomicU64};

use arcline_controller::image::{Health, MeasuredTime};
use arcline_instruction_set::predefined::{HISTOGRAM_BUCKETS, histogram_bucket};

use crate::schedule::Report;

/// The measurements of one thread.
#[derive(Debug, Default)]
pub struct Meter {
    /// Number of published snapshots.
    snapshots: AtomicU64,
    ticks: AtomicU64,
    overruns: AtomicU64,
    caught_up: AtomicU64,
    resynchronised: AtomicU64,
    overlapping: AtomicBool,
    lateness: Histogram,
    compute: Histogram,
    lost_events: AtomicU64,
    lost_answers: AtomicU64,
    lost_samples: AtomicU64,
    fifo: AtomicBool,
    memory_locked: AtomicBool,
    /// The core plus 1; 0: not pinned.
    core: AtomicU64,
}

/// A measured time, ns.
#[derive(Debug, Default)]
struct Histogram {
    last: AtomicU64,
    max: AtomicU64,
    sum: AtomicU64,
    /// Mean over 250 ticks, ns times [`AVERAGE_SCALE`].
    average: AtomicU64,
    buckets: [AtomicU64; HISTOGRAM_BUCKETS],
}

impl Meter {
    /// All measurements so far.
    pub fn health(&self) -> Health {
        let ticks = self.ticks.load(Relaxed);
        Health {
            ticks,
            overruns: self.overruns.load(Relaxed),
            caught_up: self.caught_up.load(Relaxed),
            resynchronised: self.resynchronised.load(Relaxed),
            overlapping: self.overlapping.load(Relaxed),
            lateness: self.lateness.measured(ticks),
            compute: self.compute.measured(ticks),
            lost_events: self.lost_events.load(Relaxed),
            lost_answers: self.lost_answers.load(Relaxed),
            lost_samples: self.lost_samples.load(Relaxed),
            fifo: self.fifo.load(Relaxed),
            memory_locked: self.memory_locked.load(Relaxed),
            core: self
                .core
                .load(Relaxed)
                .checked_sub(1)
                .and_then(|core| u16::try_from(core).ok()),
        }
    }

    /// The number of published snapshots: a reader of this many has seen the newest one, with the events of its tick.
    pub fn snapshots(&self) -> u64 {
        self.snapshots.load(Acquire)
    }

    /// Counts a published snapshot. Real-time, one thread only.
    pub(crate) fn publish(&self) {
        self.snapshots
            .store(self.snapshots.load(Relaxed).wrapping_add(1), Release);
    }

    /// Counts a tick, with its lateness and its compute time, ns. Real-time, one thread only.
    pub(crate) fn tick(&self, lateness: u64, compute: u64, overran: bool, caught_up: bool) {
        self.lateness.add(lateness);
        self.compute.add(compute);
        add(&self.overruns, u64::from(overran));
        add(&self.caught_up, u64::from(caught_up));
        self.overlapping.store(overran, Relaxed);
        add(&self.ticks, 1);
    }

    pub(crate) fn resynchronise(&self) {
        add(&self.resynchronised, 1);
    }

    pub(crate) fn lose_event(&self) {
        add(&self.lost_events, 1);
    }

    pub(crate) fn lose_answer(&self) {
        add(&self.lost_answers, 1);
    }

    pub(crate) fn lose_samples(&self) {
        add(&self.lost_samples, 1);
    }

    pub(crate) fn report(&self, report: &Report) {
        self.fifo.store(report.fifo, Relaxed);
        self.memory_locked.store(report.memory_locked, Relaxed);
        self.core.store(report.core.map_or(0, |core| core as u64 + 1), Relaxed);
    }
}

impl Histogram {
    fn add(&self, time: u64) {
        self.last.store(time, Relaxed);
        self.max.store(self.max.load(Relaxed).max(time), Relaxed);
        add(&self.sum, time);
        let average = self.average.load(Relaxed) as i64;
        let step = (time.saturating_mul(AVERAGE_SCALE).min(i64::MAX as u64) as i64 - average) / AVERAGE_TICKS;
        self.average.store((average + step) as u64, Relaxed);
        add(&self.buckets[histogram_bucket(time)], 1);
    }

    fn measured(&self, ticks: u64) -> MeasuredTime {
        let us = |time: &AtomicU64| time.load(Relaxed) as f64 / 1e3;
        MeasuredTime {
            last: us(&self.last),
            max: us(&self.max),
            mean: us(&self.sum) / ticks.max(1) as f64,
            average: us(&self.average) / AVERAGE_SCALE as f64,
            histogram: std::array::from_fn(|bucket| self.buckets[bucket].load(Relaxed)),
        }
    }
}

/// For a single writer a load and a store suffice.
fn add(counter: &AtomicU64, number: u64) {
    counter.store(counter.load(Relaxed).wrapping_add(number), Relaxed);
}

/// Time constant of the averages (spec/axis-and-data-types.md §8.8).
const AVERAGE_TICKS: i64 = 250;
/// Scale that keeps the averages from sticking below their time constant.
const AVERAGE_SCALE: u64 = 1024;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_counted_and_averaged() {
        let meter = Meter::default();
        for _ in 0..99 {
            meter.tick(300, 10_000, false, false);
        }
        meter.tick(5_000_000, 2_000_000, true, true);
        let health = meter.health();
        assert_eq!(
            (health.ticks, health.overruns, health.caught_up, health.overlapping),
            (100, 1, 1, true)
        );
        assert_eq!((health.lateness.last, health.lateness.max), (5000.0, 5000.0));
        assert_eq!(health.lateness.histogram[1], 99);
        assert_eq!(health.lateness.p99(), 0.5, "99 of 100 were below 0.5 µs");
        assert!((health.compute.mean - (99.0 * 10.0 + 2000.0) / 100.0).abs() < 1e-9);
    }

    #[test]
    fn the_average_reaches_a_steady_time() {
        let meter = Meter::default();
        for _ in 0..5000 {
            meter.tick(0, 7_000, false, false);
        }
        assert!((meter.health().compute.average - 7.0).abs() < 0.01);
    }
}
