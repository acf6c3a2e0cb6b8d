//! Strangers that only take places: thousands of connections that send no bytes, and hundreds that send a byte a second, on EtherNet/IP, on TLS
//! and on the page at once. A client that works is not disturbed, a new one gets in, and the tick does not notice.
//!
//! 1,600 connections for three seconds, unless `ARCLINE_FLOOD` says how many; only then, and with `--release`, times mean something and are held
//! against their limits, in five floods with as much time without one before each.

use std::net::{Ipv4Addr, SocketAddr};
use std::process::Command;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use arcline_system_tests::bare::median;
use arcline_system_tests::lateness::{SHARES, Second, each_second};
use arcline_system_tests::load::{Load, Outcome, Question, read};
use arcline_system_tests::secured::Secured;
use arcline_system_tests::server::Server;
use arcline_system_tests::{command_line, not_granted, programs};
use rustix::process::{Resource, getrlimit, setrlimit};
use tokio::io::AsyncWriteExt as _;
use tokio::net::{TcpSocket, TcpStream};

/// The greatest p99 time of an answer to the working client, µs.
const MOST_P99: f64 = 50_000.0;
/// The greatest rise of the tick's lateness over that of an idle server, beyond a thread that only sleeps in the same second, µs. Medians of many
/// seconds: what else the computer does comes in bursts, and delays both.
const MOST_RISE: f64 = 20.0;
/// The number of silent connections for each one that sends a byte a second.
const SILENT_PER_SLOW: usize = 8;
/// Addresses that the strangers come from: 127.0.1.1 and so on.
const ADDRESSES: u8 = 8;

#[test]
fn silent_and_slow_strangers_disturb_no_client() {
    let _machine = crate::take_machine();
    let asked = std::env::var("ARCLINE_FLOOD").ok().and_then(|text| text.parse().ok());
    let silent: usize = asked.unwrap_or(1600);
    if !descriptors_for(silent + silent / SILENT_PER_SLOW + 200) {
        return not_granted("the flood of connections", "the limit of open files is too low");
    }
    let seconds = if asked.is_some() { 20 } else { 3 };
    let time = Duration::from_secs(u64::from(seconds));
    let secured = Secured::start(arcline_config::DEFAULT, "", &["--hmi", "127.0.0.1:0"]);
    let server = &secured.server;
    let listeners =
        [Some(server.address()), server.tls(), server.hmi()].map(|listener| listener.expect("three listeners"));
    let rounds = if asked.is_some() { 5 } else { 1 };
    let (mut idle, mut flooded) = (Vec::new(), Vec::new());
    for _ in 0..rounds {
        idle.extend(each_second(server, seconds, || std::thread::sleep(time)).1);
        let flood = Flood::start(&listeners, silent);
        flood.wait_until_open();
        let (outcome, measured) = each_second(server, seconds, || works(server, time));
        flooded.extend(measured);
        // A client that connects during the flood.
        let begun = Instant::now();
        let newcomer = command_line::read_numbers(server.address(), &["X.ActualPosition"]);
        let newcomer_after = begun.elapsed();
        let opened = flood.end();
        let begun = Instant::now();
        let behind = works(server, Duration::from_millis(500));
        println!(
            "{opened} connections of strangers: {} answers, p50 {:.0} µs, p99 {:.0} µs, longest {:.0} µs; a newcomer's after {newcomer_after:?}; \
             behind the flood the first within {:?}, p99 {:.0} µs",
            outcome.times.len(),
            outcome.percentile(0.5),
            outcome.percentile(0.99),
            outcome.percentile(1.0),
            begun.elapsed().saturating_sub(behind.elapsed),
            behind.percentile(0.99),
        );
        assert_eq!((outcome.errors, outcome.first_error.as_deref()), (0, None));
        assert_eq!((behind.errors, behind.first_error), (0, None));
        assert_eq!(newcomer.len(), 1);
        if asked.is_some() {
            assert!(outcome.percentile(0.99) < MOST_P99);
        }
    }
    for (place, share) in SHARES.into_iter().enumerate() {
        let beyond = |when: &str, seconds: &[Second]| {
            let of = |value: &dyn Fn(&Second) -> f64| median(seconds.iter().map(value).collect());
            let (tick, bare) = (of(&|second| second.tick[place]), of(&|second| second.bare[place]));
            let beyond = of(&|second| second.tick[place] - second.bare[place]);
            println!(
                "{when}, medians of {} seconds: p{:.0} lateness of the tick {tick:.1} µs, of a thread that only sleeps {bare:.1} µs, \
                 of the tick beyond it {beyond:.1} µs",
                seconds.len(),
                share * 100.0
            );
            beyond
        };
        let rise = beyond("flooded", &flooded) - beyond("idle", &idle);
        if asked.is_some() {
            assert!(rise < MOST_RISE, "a rise by {rise} µs");
        }
    }
}

/// Every descriptor of the server is taken: the client that works goes on, and a new one gets in as soon as there are some again.
#[test]
fn descriptors_run_out_and_come_back() {
    let _machine = crate::take_machine();
    // The shell becomes the server.
    let mut shell = Command::new("sh");
    shell
        .arg("-c")
        .arg("ulimit -n 96; exec \"$0\" \"$@\"")
        .arg(programs::arcline_server());
    let server = Server::try_start(shell, &["--hmi", "127.0.0.1:0"]).unwrap_or_else(|not_ready| panic!("{not_ready}"));
    let address = server.address();
    let (outcome, opened) = std::thread::scope(|scope| {
        let works = scope.spawn(|| works(&server, Duration::from_secs(3)));
        std::thread::sleep(Duration::from_millis(300));
        let flood = Flood::start(&[address, server.hmi().expect("it has a page")], 300);
        flood.wait_until_open();
        (works.join().expect("it does not panic"), flood.end())
    });
    assert!(opened >= 300);
    assert_eq!((outcome.errors, outcome.first_error.as_deref()), (0, None));
    assert!(outcome.times.len() > 100, "{} answers", outcome.times.len());
    let again = works(&server, Duration::from_millis(300));
    assert_eq!((again.errors, again.first_error), (0, None));
}

/// A client that reads a tag a hundred times a second.
fn works(server: &Server, time: Duration) -> Outcome {
    Load {
        server: server.address(),
        question: Question::Connected(read("X.ActualPosition"), 500),
        connections: 1,
        time,
        pace: Some(Duration::from_millis(10)),
        tls: None,
    }
    .run()
}

/// Lets this process, and the server that it starts, open `count` files; returns whether the system permits it.
fn descriptors_for(count: usize) -> bool {
    let mut limit = getrlimit(Resource::Nofile);
    if limit.current.is_some_and(|current| current < count as u64) {
        limit.current = Some(count as u64);
    }
    setrlimit(Resource::Nofile, limit).is_ok()
}

/// Connections of strangers, on a thread of their own.
struct Flood {
    open: Arc<AtomicUsize>,
    goal: usize,
    ends: Arc<AtomicBool>,
    thread: JoinHandle<()>,
}

impl Flood {
    fn start(listeners: &[SocketAddr], silent: usize) -> Self {
        let slow = silent / SILENT_PER_SLOW;
        let (open, ends) = (Arc::new(AtomicUsize::new(0)), Arc::new(AtomicBool::new(false)));
        let (counted, told, listeners) = (open.clone(), ends.clone(), listeners.to_vec());
        let thread = std::thread::spawn(move || {
            let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build();
            runtime
                .expect("a runtime")
                .block_on(flood(&listeners, [silent, slow], &counted, &told));
        });
        Self {
            open,
            goal: silent + slow,
            ends,
            thread,
        }
    }

    fn wait_until_open(&self) {
        arcline_system_tests::eventually("the connections of strangers", Duration::from_secs(60), || {
            (self.open.load(Ordering::Relaxed) >= self.goal).then_some(())
        });
    }

    /// Closes all; how many were opened.
    fn end(self) -> usize {
        self.ends.store(true, Ordering::Relaxed);
        self.thread.join().expect("it does not panic");
        self.open.load(Ordering::Relaxed)
    }
}

/// Opens the connections, and sends a byte a second on those that are slow. A slow one that the server closes comes again.
async fn flood(listeners: &[SocketAddr], [silent, slow]: [usize; 2], open: &AtomicUsize, ends: &AtomicBool) {
    let mut held = Vec::with_capacity(silent);
    for number in 0..silent {
        held.push(connect(listeners, number, open).await);
    }
    let mut slowly = Vec::with_capacity(slow);
    for number in 0..slow {
        slowly.push(connect(listeners, number, open).await);
    }
    while !ends.load(Ordering::Relaxed) {
        for (number, stream) in slowly.iter_mut().enumerate() {
            let sent = match stream {
                Some(stream) => stream.write_all(b"\x65").await.is_ok(),
                None => false,
            };
            if !sent {
                *stream = connect(listeners, number, open).await;
            }
        }
        tokio::time::sleep(Duration::from_secs(1)).await;
    }
}

/// `None`: the server did not take it, and it counts as one that was tried.
async fn connect(listeners: &[SocketAddr], number: usize, open: &AtomicUsize) -> Option<TcpStream> {
    let from = Ipv4Addr::new(127, 0, 1, 1 + (number % usize::from(ADDRESSES)) as u8);
    let socket = TcpSocket::new_v4().expect("descriptors for it");
    socket.bind((from, 0).into()).expect("a loopback address");
    let connecting = socket.connect(listeners[number % listeners.len()]);
    let stream = tokio::time::timeout(Duration::from_millis(200), connecting).await;
    open.fetch_add(1, Ordering::Relaxed);
    stream.ok()?.ok()
}
