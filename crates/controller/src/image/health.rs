//! The health of the real-time thread, as the tag `RealTime` shows it.
//!
//! Plain numbers that `arcline-realtime` measures. Times are microseconds, except the coarse update period.

use arcline_instruction_set::predefined::{HISTOGRAM_BUCKETS, real_time_offset as at};
use arcline_tag::Value;

use crate::machine::Machine;

/// Name of the tag.
pub const REAL_TIME_TAG: &str = "RealTime";

/// Measurements of the real-time thread since its start.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Health {
    /// Ticks executed.
    pub ticks: u64,
    /// Ticks that ended after the next one was due.
    pub overruns: u64,
    /// Ticks executed late, one after another without sleeping, to catch up.
    pub caught_up: u64,
    /// Times the thread was so late that it stopped catching up and moved its time base.
    pub resynchronised: u64,
    /// The latest tick overran.
    pub overlapping: bool,
    /// Delay of a tick's beginning after its due time.
    pub lateness: MeasuredTime,
    /// Execution of a tick.
    pub compute: MeasuredTime,
    /// Events lost on their way out for lack of room.
    pub lost_events: u64,
    /// Answers lost on their way out for lack of room.
    pub lost_answers: u64,
    /// Ticks whose samples were lost on their way out for lack of room.
    pub lost_samples: u64,
    /// The thread has a real-time scheduling class.
    pub fifo: bool,
    /// Its memory is locked.
    pub memory_locked: bool,
    /// The core to which it is pinned.
    pub core: Option<u16>,
}

/// A measured time, µs.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MeasuredTime {
    /// The latest.
    pub last: f64,
    /// The largest.
    pub max: f64,
    /// Mean of all.
    pub mean: f64,
    /// Mean with a time constant of 250 ticks.
    pub average: f64,
    /// The number of values in each bucket ([`arcline_instruction_set::predefined::histogram_bucket`]).
    pub histogram: [u64; HISTOGRAM_BUCKETS],
}

impl MeasuredTime {
    /// The upper edge of the bucket below which half of the values lie, at most the largest value, µs.
    pub fn p50(&self) -> f64 {
        self.below(50)
    }

    /// The upper edge of the bucket below which 99 of 100 values lie, at most the largest value, µs.
    pub fn p99(&self) -> f64 {
        self.below(99)
    }

    fn below(&self, of_hundred: u64) -> f64 {
        let all: u64 = self.histogram.iter().sum();
        let mut below = 0;
        for (bucket, count) in self.histogram.iter().enumerate() {
            below += count;
            // Integer form of below / all >= of_hundred / 100.
            if below * 100 >= all * of_hundred {
                return (0.25 * (1u64 << bucket) as f64).min(self.max);
            }
        }
        self.max
    }
}

impl Health {
    /// Writes the REAL_TIME structure.
    pub(super) fn encode(&self, bytes: &mut [u8]) {
        let mut put = |offset: usize, value: Value| {
            // A member is inside its template.
            let _ = bytes.get_mut(offset..).and_then(|member| value.write(member));
        };
        put(at::TICKS, Value::Lint(self.ticks as i64));
        put(at::OVERRUNS, count(self.overruns));
        let lateness = [at::LATENESS_LAST, at::LATENESS_MEAN, at::LATENESS_P99, at::LATENESS_MAX];
        let compute = [at::COMPUTE_LAST, at::COMPUTE_MEAN, at::COMPUTE_P99, at::COMPUTE_MAX];
        for (measured, numbers, histogram) in [
            (&self.lateness, lateness, at::LATENESS_HISTOGRAM),
            (&self.compute, compute, at::COMPUTE_HISTOGRAM),
        ] {
            let shown = [measured.last, measured.mean, measured.p99(), measured.max];
            for (offset, number) in numbers.into_iter().zip(shown) {
                put(offset, Value::Real(number as f32));
            }
            for (element, number) in measured.histogram.iter().enumerate() {
                put(histogram + element * size_of::<i32>(), count(*number));
            }
        }
        let state = [self.fifo, self.memory_locked, self.core.is_some()];
        let state = state
            .iter()
            .enumerate()
            .fold(0, |word, (bit, on)| word | i32::from(*on) << bit);
        put(at::STATE, Value::Dint(state));
    }
}

/// Writes the coarse update period, which is constant, to the REAL_TIME structure.
pub(super) fn encode_period(machine: &Machine, bytes: &mut [u8]) {
    let milliseconds = Value::Real((machine.period_ns as f64 / 1e6) as f32);
    // A member is inside its template.
    let _ = bytes
        .get_mut(at::UPDATE_PERIOD..)
        .and_then(|member| milliseconds.write(member));
}

/// A counter as a DINT, at most its largest.
fn count(number: u64) -> Value {
    Value::Dint(i32::try_from(number).unwrap_or(i32::MAX))
}
