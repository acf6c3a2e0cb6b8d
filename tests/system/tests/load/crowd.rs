//! A thousand clients at a time on one server: each reads ten tags, again and again, and the tick does not notice.
//!
//! Two seconds at one question a second for each, unless `ARCLINE_CROWD_SECONDS` says how long they ask ten times a second;
//! only then, and with `--release`, times mean something and are held against their limits.

use std::time::Duration;

use arcline_system_tests::gcode::high_water;
use arcline_system_tests::lateness::{beside, percentile};
use arcline_system_tests::load::{Load, Question, read_all};
use arcline_system_tests::server::Server;

const CLIENTS: usize = 1000;
/// The tags that each client reads: those of axes of the default machine.
const TAGS: [&str; 10] = [
    "X.ActualPosition",
    "Y.ActualPosition",
    "Z.ActualPosition",
    "S.ActualPosition",
    "A.ActualPosition",
    "X.CommandPosition",
    "Y.CommandPosition",
    "Z.CommandPosition",
    "CS1.CoordinateMotionStatus",
    "X.MotionStatus",
];
/// Resident, MiB.
const MOST_MEMORY: f64 = 100.0;
/// The greatest p99 time of an answer, µs.
const MOST_P99: f64 = 10_000.0;
/// The greatest rise of the tick's p99 lateness over that of an idle server, µs.
const MOST_RISE: f64 = 20.0;

#[test]
fn a_thousand_clients_read_ten_tags_each() {
    let _machine = crate::take_machine();
    let long = std::env::var("ARCLINE_CROWD_SECONDS")
        .ok()
        .and_then(|text| text.parse().ok());
    let (seconds, pace) = match long {
        Some(seconds) => (seconds, Duration::from_millis(100)),
        None => (2, Duration::from_secs(1)),
    };
    let time = Duration::from_secs(seconds);
    let server = Server::start();
    // Half of it before the load and half behind it, so that both see as many rare events of a machine that others use too. A
    // short run takes none: its figures are not judged.
    let rest = if long.is_some() { time / 2 } else { Duration::ZERO };
    let ((), before) = beside(&server, rest, || std::thread::sleep(rest));
    let load = Load {
        server: server.address(),
        question: Question::Connected(read_all(TAGS.map(str::to_owned)), 500),
        connections: CLIENTS,
        time,
        pace: Some(pace),
        tls: None,
    };
    // The connections stay open for a moment, so that the memory is that of all of them.
    let (outcome, loaded) = beside(&server, time, || load.run());
    let memory = peak_memory(server.process());
    println!(
        "{CLIENTS} clients, {} answers in {:?}: p50 {:.0} µs, p99 {:.0} µs, longest {:.0} µs; {memory:.1} MiB at most",
        outcome.times.len(),
        outcome.elapsed,
        outcome.percentile(0.5),
        outcome.percentile(0.99),
        outcome.percentile(1.0),
    );
    assert_eq!((outcome.errors, outcome.first_error.as_deref()), (0, None));
    assert!(outcome.times.len() >= CLIENTS, "everybody was answered");
    assert!(memory < MOST_MEMORY, "{memory} MiB");
    if long.is_none() {
        return;
    }
    let ((), behind) = beside(&server, rest, || std::thread::sleep(rest));
    let idle: Vec<f64> = before.ticks.iter().zip(&behind.ticks).map(|(a, b)| a + b).collect();
    let rise = |what: &str, idle: f64, loaded: f64| {
        println!("{what}: p99 lateness {idle:.1} µs idle, {loaded:.1} µs under the load");
        loaded - idle
    };
    let tick = rise("the tick", percentile(&idle, 0.99), percentile(&loaded.ticks, 0.99));
    let bare = before.bare.and(behind.bare);
    rise(
        "a thread that only sleeps",
        bare.percentile(0.99),
        loaded.bare.percentile(0.99),
    );
    let expected = CLIENTS as f64 * time.as_secs_f64() / pace.as_secs_f64();
    assert!(
        outcome.times.len() as f64 > 0.99 * expected,
        "the pace was kept: {expected}"
    );
    assert!(outcome.percentile(0.99) < MOST_P99);
    assert!(tick < MOST_RISE);
}

/// The most memory that a process has had in use, MiB.
fn peak_memory(process: u32) -> f64 {
    let bytes = high_water(process);
    assert!(bytes > 0, "Linux shows the memory of a process that runs");
    bytes as f64 / f64::from(1 << 20)
}
