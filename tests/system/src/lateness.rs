//! The effect of a load on the ticks of a server, beside the effect of the machine itself on a thread that only sleeps.

use std::time::Duration;

use arcline_instruction_set::predefined::{HISTOGRAM_BUCKETS, histogram_edge};

use crate::bare::Bare;
use crate::command_line::read_numbers;
use crate::server::Server;

/// The measurements during some work.
pub struct Seen {
    /// The number of ticks in each bucket of lateness.
    pub ticks: Vec<f64>,
    /// The lateness of a thread that only sleeps in the same time.
    pub bare: Bare,
}

/// Does some work of a given duration, and measures its effect on the ticks.
///
/// # Panics
/// When the server does not report the lateness of its ticks.
#[must_use]
pub fn beside<T>(server: &Server, time: Duration, work: impl FnOnce() -> T) -> (T, Seen) {
    let from = ticks(server);
    let bare = Bare::beside(time, Duration::from_millis(1));
    let done = work();
    let to = ticks(server);
    let seen = Seen {
        ticks: from.iter().zip(&to).map(|(from, to)| to - from).collect(),
        bare: bare.join().expect("it does not panic"),
    };
    (done, seen)
}

/// The number of ticks in each bucket of lateness so far.
fn ticks(server: &Server) -> Vec<f64> {
    let names: Vec<String> = (0..HISTOGRAM_BUCKETS)
        .map(|bucket| format!("RealTime.LatenessHistogram[{bucket}]"))
        .collect();
    read_numbers(server.address(), &names.iter().map(String::as_str).collect::<Vec<_>>())
}

/// The lateness that so large a share of the counts in buckets stayed within, µs; within its bucket by proportion.
#[must_use]
pub fn percentile(counts: &[f64], share: f64) -> f64 {
    let wanted = counts.iter().sum::<f64>() * share;
    let mut below = 0.0;
    for (bucket, count) in counts.iter().enumerate() {
        if below + count >= wanted {
            let Some(end) = histogram_edge(bucket) else { break };
            let begin = if bucket == 0 { 0.0 } else { end / 2.0 };
            return (begin + (end - begin) * (wanted - below) / count) * 1e6;
        }
        below += count;
    }
    f64::INFINITY
}
