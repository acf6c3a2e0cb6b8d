//! The effect of the machine itself on a schedule: a thread that only sleeps from slot to slot, beside a measurement.

use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// The result of a thread that only sleeps to a schedule; it has priority if the system allows that.
#[derive(Debug, Default)]
pub struct Bare {
    /// The number of missed slots.
    pub left_out: usize,
    /// The lateness in the others, sorted, µs.
    late: Vec<f64>,
}

impl Bare {
    /// Keeps a schedule for a time, on a thread of its own.
    #[must_use]
    pub fn beside(time: Duration, interval: Duration) -> JoinHandle<Self> {
        std::thread::spawn(move || {
            let _ = arcline_realtime::prepare_beside_tick();
            let began = Instant::now();
            let mut bare = Self::default();
            let mut due = began + interval;
            while due < began + time {
                std::thread::sleep(due.saturating_duration_since(Instant::now()));
                let late = due.elapsed();
                let missed = (late.as_nanos() / interval.as_nanos().max(1)) as u32;
                bare.left_out += missed as usize;
                bare.late.push((late - interval * missed).as_secs_f64() * 1e6);
                due += interval * (missed + 1);
            }
            bare.late.sort_by(f64::total_cmp);
            bare
        })
    }

    /// Both together.
    #[must_use]
    pub fn and(mut self, other: Self) -> Self {
        self.left_out += other.left_out;
        self.late.extend(other.late);
        self.late.sort_by(f64::total_cmp);
        self
    }

    /// The lateness that so large a share of the slots stayed within, µs.
    ///
    /// # Panics
    /// When there was not even one slot.
    #[must_use]
    pub fn percentile(&self, share: f64) -> f64 {
        percentile(&self.late, share)
    }
}

/// The value that a share of sorted values does not exceed.
///
/// # Panics
/// When there are none.
#[must_use]
pub fn percentile(sorted: &[f64], share: f64) -> f64 {
    sorted[((sorted.len() - 1) as f64 * share) as usize]
}

/// The value in the middle of some.
///
/// # Panics
/// When there are none.
#[must_use]
pub fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}
