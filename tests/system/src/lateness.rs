//! The effect of a load on the ticks of a server, beside the effect of the machine itself on a thread that only sleeps.

use std::time::Duration;

use arcline_client::Client;
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
        ticks: between(&from, &to),
        bare: bare.join().expect("it does not panic"),
    };
    (done, seen)
}

/// The shares of a second's ticks whose lateness is measured.
pub const SHARES: [f64; 3] = [0.5, 0.9, 0.99];

/// The lateness that each of [`SHARES`] stayed within for a second, µs.
#[derive(Clone, Copy, Debug)]
pub struct Second {
    /// That of the ticks.
    pub tick: [f64; 3],
    /// That of a thread that only sleeps, in the same second.
    pub bare: [f64; 3],
}

/// Does some work, and measures each of the given number of seconds beside it.
///
/// # Panics
/// When the server does not report the lateness of its ticks.
#[must_use]
pub fn each_second<T>(server: &Server, seconds: u32, work: impl FnOnce() -> T) -> (T, Vec<Second>) {
    let address = server.address().to_string();
    let measure = async || {
        let client = Client::connect(&address).await.expect("it accepts a client");
        let counts = async || {
            let counts = client.read_numbers("RealTime.LatenessHistogram[0]").await;
            counts.expect("it reports the lateness")
        };
        let mut measured = Vec::new();
        for _ in 0..seconds {
            let from = counts().await;
            let bare = Bare::beside(Duration::from_secs(1), Duration::from_millis(1));
            let bare = bare.join().expect("it does not panic");
            let to = counts().await;
            let ticks = between(&from, &to);
            measured.push(Second {
                tick: SHARES.map(|share| percentile(&ticks, share)),
                bare: SHARES.map(|share| bare.percentile(share)),
            });
        }
        measured
    };
    std::thread::scope(|scope| {
        let measuring = scope.spawn(|| {
            let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build();
            runtime.expect("a runtime").block_on(measure())
        });
        let done = work();
        (done, measuring.join().expect("it does not panic"))
    })
}

/// The number of ticks in each bucket between two instants.
fn between(from: &[f64], to: &[f64]) -> Vec<f64> {
    from.iter().zip(to).map(|(from, to)| to - from).collect()
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
