//! Implicit I/O with a real server: a minute at 2 ms (five seconds where `ARCLINE_IO_SECONDS` does not say so, which is for
//! a release build and `--test-threads=1`), the shortest interval that is confirmed, a scanner that dies, and Wireshark's findings.
//!
//! Every server has a loopback address of its own, so that it can have port 2222.

use std::net::{Ipv4Addr, UdpSocket};
use std::sync::atomic::{AtomicU8, Ordering};
use std::time::{Duration, Instant};

use arcline_proto::cip::CipStatus;
use arcline_system_tests::bare::{Bare, percentile};
use arcline_system_tests::capture::Capture;
use arcline_system_tests::scanner::{Arrival, Connection, Sent, Session, Wanted};
use arcline_system_tests::server::Server;
use arcline_system_tests::{eventually, not_run};
use rustix::net::sockopt::set_socket_recv_buffer_size;

/// The size of the input assembly of the default machine: four coordinate systems, seven axes (docs/IO.md).
const INPUT: u16 = 12 + 4 * 24 + 7 * 20;
const OUTPUT: u16 = 4 + 4 * 4;
/// The offset of ConnectionStatus, and its bits.
const STATUS: usize = 4;
const OWNED: u32 = 1;
const RUN: u32 = 2;

/// A server on the next loopback address of this process.
fn server() -> Server {
    static NEXT: AtomicU8 = AtomicU8::new(1);
    let [.., high, low] = std::process::id().to_be_bytes();
    let address = Ipv4Addr::new(127, high | 0x80, low, NEXT.fetch_add(1, Ordering::Relaxed));
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("io.toml");
    let listen = format!("[server]\nio = \"{address}:2222\"\n");
    let text = arcline_config::DEFAULT.replacen("[server]\n", &listen, 1);
    std::fs::write(&file, text).expect("a file");
    let file = file.to_str().expect("the path is UTF-8");
    Server::start_at(&format!("{address}:0"), &["--config", file])
}

/// A socket with room for the datagrams of [`PAUSE`] at the shortest interval, and a thread that reads it in time if the system
/// allows that.
fn socket() -> UdpSocket {
    let _ = arcline_realtime::prepare_beside_tick();
    let socket = UdpSocket::bind("0.0.0.0:0").expect("a free port");
    // Linux gives as much as it grants, and that twice.
    set_socket_recv_buffer_size(&socket, 1 << 20).expect("a socket");
    socket
}

fn owner(serial: u16, rpi: u32) -> Wanted {
    Wanted {
        serial,
        points: [150, 100],
        sizes: [OUTPUT, INPUT],
        rpi,
        multiplier: 7,
        sent: Sent::Alone,
    }
}

fn input_only(serial: u16, rpi: u32) -> Wanted {
    Wanted {
        points: [254, 100],
        sizes: [0, INPUT],
        ..owner(serial, rpi)
    }
}

fn seconds() -> u64 {
    std::env::var("ARCLINE_IO_SECONDS")
        .ok()
        .and_then(|text| text.parse().ok())
        .unwrap_or(5)
}

fn status(arrival: &Arrival) -> u32 {
    let bytes = arrival.data[STATUS..STATUS + 4].try_into().expect("four bytes");
    u32::from_le_bytes(bytes)
}

/// The longest pause: after a longer one the socket may overflow, and the scanner or the machine is the cause of a loss.
const PAUSE: Duration = Duration::from_millis(250);
/// The shortest interval that is confirmed under any load, and some, µs (docs/IO.md).
const CONFIRMED: u32 = 40_000;
/// Runs of which one must be without such a pause, and keep the interval.
const TRIES: usize = 5;

/// A connection with the server's consent: a server that the machine has delayed confirms no interval that short before its timing
/// has improved.
fn opened(session: &mut Session, wanted: Wanted) -> Connection {
    let unconfirmed = CipStatus::connection(0x0111);
    eventually("a confirmed interval", Duration::from_secs(60), || {
        match session.open(wanted, socket()) {
            Err(status) if status == unconfirmed => None,
            answer => Some(answer.unwrap_or_else(|status| panic!("{wanted:?}: {status}"))),
        }
    })
}

/// Exchanges data for a time on a connection of its own, and checks the interval of the datagrams. It repeats the exchange if the machine
/// delayed the scanner or stalled the server, but not in a run of its own.
fn exchanged(
    session: &mut Session,
    wanted: Wanted,
    time: Duration,
    output: &[u8],
) -> Option<(Connection, Vec<Arrival>)> {
    let mut wrong = None;
    for _ in 0..TRIES {
        let mut connection = opened(session, wanted);
        assert_eq!(connection.confirmed, [wanted.rpi; 2]);
        let bare = Bare::beside(time, Duration::from_micros(wanted.rpi.into()));
        let arrivals = connection.exchange(time, output);
        let bare = bare.join().expect("it does not panic");
        if connection.longest_pause < PAUSE {
            match kept(&arrivals, &bare, time, wanted.rpi) {
                Ok(()) => return Some((connection, arrivals)),
                Err(why) if alone() => panic!("{why}"),
                Err(why) => {
                    println!("{why}");
                    wrong = Some(why);
                }
            }
        } else {
            println!(
                "the scanner was kept from its socket for {:?}",
                connection.longest_pause
            );
        }
        assert!(session.close(wanted.serial).is_success());
    }
    assert_eq!(wrong, None, "in none of {TRIES} runs");
    not_run("the interval of implicit I/O", "the machine is too busy for a scanner");
    None
}

/// No datagram is lost or comes twice: sequences and counts go up by one.
fn assert_gapless(arrivals: &[Arrival]) {
    for (place, pair) in arrivals.windows(2).enumerate() {
        assert_eq!(
            (pair[1].sequence, pair[1].count),
            (pair[0].sequence.wrapping_add(1), pair[0].count.wrapping_add(1)),
            "datagram {place}"
        );
    }
}

/// The deviation of each arrival from a schedule without drift, as a share of the interval, sorted: a drift spreads the values
/// over the whole of it. Slots that a stalled machine left out do not count, since the schedule stays.
fn deviations(arrivals: &[Arrival], rpi: u32) -> Vec<f64> {
    let first = arrivals[0].at;
    let phase = |arrival: &Arrival| (arrival.at - first).as_secs_f64() * 1e6 / f64::from(rpi);
    let mut phases: Vec<f64> = arrivals.iter().map(|arrival| phase(arrival).rem_euclid(1.0)).collect();
    phases.sort_by(f64::total_cmp);
    // The schedule's own phase is where arrivals are densest: the narrowest stretch that holds a quarter of them.
    let quarter = phases.len() / 4;
    let wrapped = |place: usize| phases[place % phases.len()] + (place / phases.len()) as f64;
    let width = |place: &usize| wrapped(place + quarter) - wrapped(*place);
    let densest = (0..phases.len())
        .min_by(|a, b| width(a).total_cmp(&width(b)))
        .unwrap_or(0);
    let centre = wrapped(densest);
    let mut deviations: Vec<f64> = phases
        .iter()
        .map(|phase| {
            let offset = (phase - centre).rem_euclid(1.0);
            offset.min(1.0 - offset)
        })
        .collect();
    deviations.sort_by(f64::total_cmp);
    deviations
}

/// Times between arrivals, sorted, µs.
fn intervals(arrivals: &[Arrival]) -> Vec<f64> {
    let mut intervals: Vec<f64> = arrivals
        .windows(2)
        .map(|pair| (pair[1].at - pair[0].at).as_secs_f64() * 1e6)
        .collect();
    intervals.sort_by(f64::total_cmp);
    intervals
}

/// Whether this is a run of its own: elsewhere tests run beside this one, and the scanner itself is late.
fn alone() -> bool {
    std::env::var_os("ARCLINE_IO_SECONDS").is_some()
}

/// Checks that the datagrams of a time came at the interval, without drift.
///
/// # Panics
/// When a datagram is lost, or comes twice or too often.
fn kept(arrivals: &[Arrival], bare: &Bare, time: Duration, rpi: u32) -> Result<(), String> {
    assert_gapless(arrivals);
    let expected = (time.as_micros() / u128::from(rpi)) as usize;
    let came = arrivals.len();
    let intervals = intervals(arrivals);
    let at = |share| percentile(&intervals, share);
    println!(
        "{rpi} µs: {came} of {expected} datagrams, intervals p1 {:.0} µs, p50 {:.0} µs, p99 {:.0} µs, max {:.0} µs",
        at(0.01),
        at(0.5),
        at(0.99),
        at(1.0)
    );
    let deviations = deviations(arrivals, rpi);
    let drift = percentile(&deviations, 0.5);
    let p99 = percentile(&deviations, 0.99) * f64::from(rpi);
    let machine = bare.percentile(0.99);
    println!(
        "{rpi} µs: {} slots left out, 99 of 100 datagrams within {p99:.0} µs of the schedule; a thread that only sleeps left out {} and was \
         within {machine:.0} µs",
        expected.saturating_sub(came),
        bare.left_out
    );
    assert!(came <= expected + 1, "{came} of {expected}: nothing comes too often");
    // A busy machine may leave out some, beside the slots that no thread could have met.
    let excused = if alone() { 0 } else { bare.left_out };
    if (came + excused) * 10 < expected * 9 {
        return Err(format!("{came} of {expected}, {excused} excused"));
    }
    if drift >= 0.2 {
        return Err(format!("it drifts: half of it is {drift} intervals off the schedule"));
    }
    if alone() && p99 >= 250.0 {
        return Err(format!("{p99} µs off the schedule"));
    }
    Ok(())
}

#[test]
fn two_milliseconds_without_loss_and_nothing_malformed() {
    let _machine = crate::take_machine();
    let server = server();
    let capture = Capture::with_io(server.address());
    let mut session = Session::connect(server.address());
    let time = Duration::from_secs(seconds());
    let output = [0; OUTPUT as usize];
    let Some((mut owning, arrivals)) = exchanged(&mut session, owner(1, 2000), time, &output) else {
        return;
    };
    assert_eq!(arrivals[0].sequence, 1, "the first one");
    assert_eq!(status(arrivals.last().expect("some")), OWNED | RUN);

    // All kinds of refusals and connections for the dissectors, at an interval that is confirmed under any load: one that is not would
    // be the first refusal.
    assert_eq!(
        session.open(owner(2, CONFIRMED), socket()).err(),
        Some(CipStatus::connection(0x0106))
    );
    let wrong = Wanted {
        sizes: [OUTPUT, INPUT + 4],
        ..owner(2, CONFIRMED)
    };
    let size = CipStatus::connection(0x0127);
    assert!(session.open(wrong, socket()).is_err_and(|status| status.is(size)));
    let fast = session.open(input_only(2, 999), socket()).err();
    assert_eq!(fast, Some(CipStatus::connection(0x0111)));
    let listening = Wanted {
        points: [255, 100],
        ..input_only(2, CONFIRMED)
    };
    let mut listener = session.open(listening, socket()).expect("there is something to hear");
    for (serial, sent) in [(3, Sent::ToGroup), (4, Sent::ToGroupOnChange), (5, Sent::ToGroup)] {
        let wanted = Wanted {
            sent,
            ..input_only(serial, CONFIRMED)
        };
        assert!(session.open(wanted, socket()).is_ok(), "{sent:?}");
    }
    let mut heard = 0;
    eventually("five datagrams for the listener", Duration::from_secs(20), || {
        owning.send(&output);
        heard += listener.exchange(Duration::from_millis(10), &[]).len();
        (heard >= 5).then_some(())
    });
    assert!(session.close(1).is_success());
    assert_eq!(session.close(1), CipStatus::connection(0x0107));

    match capture.and_then(Capture::finish) {
        Ok(verdict) => {
            let no_faults: &[String] = &[];
            assert_eq!(verdict.faults, no_faults, "malformed");
            assert!(verdict.frames > 2 * arrivals.len() - 50, "{} frames", verdict.frames);
        }
        Err(why) => not_run("what Wireshark says to implicit I/O", &why),
    }
}

#[test]
fn one_millisecond_is_kept_on_an_absolute_schedule() {
    let _machine = crate::take_machine();
    let server = server();
    let mut session = Session::connect(server.address());
    let time = Duration::from_secs(seconds());
    exchanged(&mut session, input_only(1, 1000), time, &[]);
}

#[test]
fn longer_intervals_are_kept_too() {
    let _machine = crate::take_machine();
    let server = server();
    let mut session = Session::connect(server.address());
    // Long in comparison with the pauses of a stalled machine; a check of one in 100 needs many.
    let time = Duration::from_secs(if alone() { seconds() } else { 2 });
    for (serial, rpi) in (1..).zip([5000, 10_000, 100_000]) {
        exchanged(&mut session, input_only(serial, rpi), time, &[]);
    }
}

#[test]
fn a_scanner_that_dies_is_timed_out_and_another_takes_over() {
    let _machine = crate::take_machine();
    let server = server();
    let mut session = Session::connect(server.address());
    let mut witness = opened(&mut session, input_only(1, 1000));
    let mut owner_session = Session::connect(server.address());
    // 10 ms times 32.
    let dying = Wanted {
        multiplier: 3,
        ..owner(2, 10_000)
    };
    let mut dying = opened(&mut owner_session, dying);
    dying.send(&[0; OUTPUT as usize]);
    let began = Instant::now();
    drop((dying, owner_session));
    let (mut sequence, mut seen_run) = (None, false);
    let released = eventually("the end of the owner", Duration::from_secs(20), || {
        for arrival in witness.exchange(Duration::from_millis(1), &[]) {
            assert_eq!(
                sequence
                    .replace(arrival.sequence)
                    .map_or(arrival.sequence, |last| last + 1),
                arrival.sequence
            );
            let owned = status(&arrival) & (OWNED | RUN);
            seen_run |= owned == OWNED | RUN;
            // Datagrams that waited in the socket are from before the owner.
            if seen_run && owned == 0 {
                return Some(arrival.at - began);
            }
        }
        None
    });
    println!("timed out after {released:?}, 320 ms were agreed");
    assert!(released >= Duration::from_millis(320), "too early: {released:?}");
    assert!(released < Duration::from_millis(2000), "too late: {released:?}");
    // Outputs that were not free would be refused with 0x0106.
    opened(&mut session, owner(3, 10_000));
}

#[test]
fn the_default_port_is_free_beside_another_tcp_port() {
    let _machine = crate::take_machine();
    let server = Server::start();
    let mut session = Session::connect(server.address());
    let mut connection = opened(&mut session, input_only(1, 5000));
    let arrivals = connection.exchange(Duration::from_millis(100), &[]);
    assert!(!arrivals.is_empty());
    assert_gapless(&arrivals);
}
