//! The reaction of motion to the loss of the connection that began it, and to the close of that connection.

use arcline_config::ConnectionLoss;
use arcline_instruction_set::{Flag, Mnemonic};
use arcline_proto::cip::{Request, service};
use arcline_proto::encap::Command;
use arcline_proto::epath::Epath;
use arcline_tag::Elementary;

use super::motion::{line, name, numbers, on};
use super::*;

/// The end of a connection.
#[derive(Clone, Copy, PartialEq, Debug)]
enum End {
    /// The TCP connection closes without UnRegisterSession or Forward Close.
    Dropped,
    /// Its watchdog expires, the TCP connection stays.
    Silent,
    /// Forward Close; the TCP connection is closed later, without a word.
    Closed,
    /// UnRegisterSession.
    Unregistered,
}

/// The state of the motion afterwards.
#[derive(Clone, Copy, PartialEq, Debug)]
enum Then {
    Runs,
    Stopped,
    Held,
}

const JOG: &str = "Jogging";
const MOVE: &str = "Moving";
const LINE: &str = "Lining";
/// A move that another client began.
const OTHER: &str = "Others";

/// Axes of the default machine: S, A and B. CS1 has X, Y and Z.
const S: u32 = 4;
const A: u32 = 5;
const B: u32 = 6;

/// A jog at 5 units/s.
fn jog(control: &str, axis: u32) -> Request {
    let mut operands = vec![name(control)];
    operands.extend([0.0, 5.0, 0.0, 1000.0, 0.0, 1000.0, 0.0].map(|number| numbers(&[number])));
    on(Mnemonic::Maj, axis, &operands)
}

/// A move to 1,000 at 5 units/s.
fn single(control: &str, axis: u32) -> Request {
    let mut operands = vec![name(control)];
    operands.extend([0.0, 1000.0, 5.0, 0.0, 1000.0, 0.0, 1000.0, 0.0].map(|number| numbers(&[number])));
    on(Mnemonic::Mam, axis, &operands)
}

impl Bench {
    fn runs(&self, control: &str) -> bool {
        let plant = &self.device.plant;
        plant.with_image(|image| {
            let slot = image.known_control(control).expect("a motion control").expect("known");
            image.control(slot).has(Flag::Ip)
        })
    }

    fn tick(&self) -> u64 {
        self.device.plant.with_image(|image| image.snapshot_tick())
    }

    fn overrides(&self) -> f32 {
        self.device
            .plant
            .with_image(|image| image.feed_overrides().next().expect("CS1"))
    }

    async fn eventually(&self, what: &str, condition: impl Fn(&Self) -> bool) {
        let wait = async {
            while !condition(self) {
                tokio::task::yield_now().await;
            }
        };
        tokio::time::timeout(PATIENCE, wait)
            .await
            .unwrap_or_else(|_| panic!("{what}: not in time"));
    }
}

/// Begins motion over a class 3 connection of 10 ms × 4, ends the connection, and returns the state of the motion.
async fn after(bench: &Bench, loss: Option<u8>, end: End) -> [Then; 3] {
    let mut other = bench.client().await;
    assert!(other.ask(&jog(OTHER, B)).await.status.is_success());
    let mut client = bench.client().await;
    let key = ConnectionKey {
        serial: 1,
        vendor: 2,
        originator: 3,
    };
    let mut open = forward_open(500, key);
    let mut asked = ForwardOpen::decode(&open.data, true).expect("our own");
    if end == End::Silent {
        asked.multiplier = 0;
        asked.o_to_t_rpi = 10_000;
    }
    open.data = asked.to_bytes(true).expect("short");
    let reply = client.ask(&open).await;
    let id = ForwardOpenReply::decode(&reply.data).expect("opened").o_to_t_id;
    let mut connected = Connected { id, sequence: 0, key };
    let (jogs, moves, lines) = (
        jog(JOG, S),
        single(MOVE, A),
        on(Mnemonic::Mclm, 1, &line(LINE, &[100_000.0, 0.0, 0.0])),
    );
    let set = loss.map(|loss| Request::new(service::SET_ATTRIBUTE_SINGLE, Epath::attribute(6, 1, 100), vec![loss]));
    for request in set.iter().chain([&jogs, &moves, &lines]) {
        let reply = client.ask_connected(&mut connected, request).await;
        assert!(reply.status.is_success(), "{}", reply.status);
    }
    match end {
        End::Dropped => drop(client),
        End::Silent => {
            bench
                .eventually("the watchdog", |bench| bench.device.open_connections() == 0)
                .await;
            assert_eq!(client.read("aDint").await.data.len(), 4, "the session lives");
        }
        End::Closed => {
            assert!(client.close(&connected).await.status.is_success());
            drop(client);
        }
        End::Unregistered => {
            let frame = EncapFrame::request(Command::UNREGISTER_SESSION, client.session, CONTEXT, Bytes::new());
            client.send(&frame.to_bytes()).await;
            assert_eq!(client.frame().await, None);
        }
    }
    // Sessions are numbered from 0: the other one's is 0, this one's 1.
    bench
        .eventually("its end", |bench| bench.device.plant.owners(1).is_empty())
        .await;
    let seen = bench.tick();
    // All stops are short: 5 units/s at 1,000 units/s² and 400 at 5,000.
    bench.eventually("some time", |bench| bench.tick() > seen + 200).await;
    assert!(bench.runs(OTHER), "what somebody else began goes on");
    [JOG, MOVE, LINE].map(|control| match bench.runs(control) {
        false => Then::Stopped,
        true if control == LINE && bench.overrides() == 0.0 => Then::Held,
        true => Then::Runs,
    })
}

#[tokio::test(flavor = "multi_thread")]
async fn motion_of_a_lost_connection_does_as_configured() {
    use ConnectionLoss::{Finish, Hold, Jogs, Stop};
    use Then::{Held, Runs, Stopped};
    #[rustfmt::skip]
    let cases = [
        // configured, set over the connection, how it ends, jog, move, line
        (Jogs,   None,    End::Dropped,      [Stopped, Runs,    Runs]),
        (Jogs,   None,    End::Silent,       [Stopped, Runs,    Runs]),
        (Stop,   None,    End::Silent,       [Stopped, Stopped, Stopped]),
        (Hold,   None,    End::Dropped,      [Stopped, Runs,    Held]),
        (Finish, None,    End::Dropped,      [Runs,    Runs,    Runs]),
        (Stop,   None,    End::Closed,       [Runs,    Runs,    Runs]),
        (Stop,   None,    End::Unregistered, [Runs,    Runs,    Runs]),
        (Finish, Some(1), End::Dropped,      [Stopped, Stopped, Stopped]),
        (Stop,   Some(3), End::Silent,       [Runs,    Runs,    Runs]),
    ];
    for (configured, set, end, expected) in cases {
        let bench = Bench::with(|settings| settings.config.connection_loss = configured);
        let found = after(&bench, set, end).await;
        assert_eq!(found, expected, "{configured:?}, set to {set:?}, {end:?}");
    }
}

/// An HMI without connections, and one that writes tags.
#[tokio::test(flavor = "multi_thread")]
async fn a_session_without_connections_is_lost_too() {
    let bench = Bench::of(
        crate::plant::Plant::start(&jog_tag()).expect("a thread"),
        settings_of("Bench"),
    );
    let mut client = bench.client().await;
    let speed = 5_f32.to_le_bytes();
    assert!(
        client
            .write("Jog1.Speed", Elementary::Real.into(), &speed)
            .await
            .is_success()
    );
    assert!(
        client
            .write("Jog1.SpeedUnits", Elementary::Dint.into(), &[0; 4])
            .await
            .is_success()
    );
    assert!(
        client
            .write("Jog1.EnableIn", Elementary::Bool.into(), &[1])
            .await
            .is_success()
    );
    assert!(client.ask(&single(MOVE, A)).await.status.is_success());
    bench.eventually("the jog", |bench| bench.runs("Jog1")).await;
    drop(client);
    bench
        .eventually("the end of the jog", |bench| !bench.runs("Jog1"))
        .await;
    assert!(bench.runs(MOVE));
}

impl Bench {
    fn velocity(&self, axis: u32) -> f64 {
        let place = axis as usize - 1;
        self.device
            .plant
            .with_snapshot(|snapshot| snapshot.axes[place].command[1])
    }
}

/// A MAS of an axis at 0.001 units/s², of everything (0), the jog (1) or the move (2).
fn weak_stop(axis: u32, stop_type: f64) -> Request {
    let mut operands = vec![name("Weak")];
    operands.extend([stop_type, 1.0, 0.001, 0.0, 0.0, 100.0, 2.0].map(|number| numbers(&[number])));
    on(Mnemonic::Mas, axis, &operands)
}

#[tokio::test(flavor = "multi_thread")]
async fn a_lost_client_stops_at_full_deceleration_whatever_others_programmed() {
    #[rustfmt::skip]
    let cases: [(&str, Request, u32, f64, &[Request]); 6] = [
        ("a jog, a weak stop of the jog",        jog(JOG, S),     S, 5.0,   &[weak_stop(S, 1.0)]),
        ("a jog, a weak stop of everything",     jog(JOG, S),     S, 5.0,   &[weak_stop(S, 0.0)]),
        ("a jog, one after the other",           jog(JOG, S),     S, 5.0,   &[weak_stop(S, 1.0), weak_stop(S, 0.0)]),
        ("a move, a weak stop of the move",      single(MOVE, A), A, 5.0,   &[weak_stop(A, 2.0)]),
        ("a move, a weak stop of everything",    single(MOVE, A), A, 5.0,   &[weak_stop(A, 0.0)]),
        ("a line, a weak stop of the line",      long_line(),     1, 400.0, &[weak_stop_of_line()]),
    ];
    for (why, begin, axis, speed, stops) in cases {
        let bench = Bench::with(|settings| settings.config.connection_loss = ConnectionLoss::Stop);
        let mut client = bench.client().await;
        assert!(client.ask(&begin).await.status.is_success(), "{why}");
        bench
            .eventually(why, |bench| (bench.velocity(axis) - speed).abs() < 1e-9)
            .await;
        let mut other = bench.client().await;
        for stop in stops {
            assert!(other.ask(stop).await.status.is_success(), "{why}");
        }
        assert!(bench.velocity(axis) > 0.9 * speed, "{why}: a weak stop is weak");
        drop(client);
        bench.eventually(why, |bench| bench.velocity(axis) == 0.0).await;
    }
}

/// An MCLM of CS1 in X.
fn long_line() -> Request {
    on(Mnemonic::Mclm, 1, &line(LINE, &[100_000.0, 0.0, 0.0]))
}

/// An MCS of CS1's coordinated move at 0.001 units/s².
fn weak_stop_of_line() -> Request {
    let mut operands = vec![name("Weak")];
    operands.extend([2.0, 1.0, 0.001, 0.0, 0.0, 100.0, 2.0].map(|number| numbers(&[number])));
    on(Mnemonic::Mcs, 1, &operands)
}

fn with_silence(silence: u16) -> arcline_config::Project {
    let mut project = project();
    project.server.jog_silence = silence;
    project
}

#[tokio::test(flavor = "multi_thread")]
async fn a_silent_client_stops_its_jogs_and_nothing_else() {
    for (loss, expected) in [
        (ConnectionLoss::Jogs, Then::Stopped),
        (ConnectionLoss::Finish, Then::Runs),
    ] {
        let mut settings = settings_of("Bench");
        settings.config.connection_loss = loss;
        let bench = Bench::of(Plant::start(&with_silence(400)).expect("a thread"), settings);
        let (mut client, mut talks) = (bench.client().await, bench.client().await);
        assert!(client.ask(&jog(JOG, S)).await.status.is_success());
        assert!(client.ask(&single(MOVE, A)).await.status.is_success());
        assert!(talks.ask(&jog(OTHER, B)).await.status.is_success());
        let silent_from = std::time::Instant::now();
        // A client that polls keeps its jogs; a silent client does not.
        while silent_from.elapsed() < Duration::from_millis(900) {
            talks.read("aDint").await;
            tokio::time::sleep(Duration::from_millis(10)).await;
        }
        assert!(bench.runs(OTHER), "{loss:?}: a client that polls is not silent");
        assert!(bench.runs(MOVE), "{loss:?}: a move ends by itself");
        let found = if bench.runs(JOG) { Then::Runs } else { Then::Stopped };
        assert_eq!(found, expected, "{loss:?}");
        assert_eq!(client.read("aDint").await.data.len(), 4, "{loss:?}: the session lives");
    }
}

fn jog_tag() -> arcline_config::Project {
    let tag = "[[instruction]]\ntag = \"Jog1\"\ntype = \"MAJ\"\ntarget = \"S\"\n";
    arcline_config::load(&format!("{}\n{tag}", arcline_config::DEFAULT), "test").expect("valid")
}

#[tokio::test]
async fn the_reaction_is_an_attribute_of_the_session() {
    let bench = Bench::new();
    let mut client = bench.client().await;
    let mut connected = client.open(500, 1).await;
    let get = Request::new(service::GET_ATTRIBUTE_SINGLE, Epath::attribute(6, 1, 100), Bytes::new());
    let set = |value: &'static [u8]| Request::new(service::SET_ATTRIBUTE_SINGLE, Epath::attribute(6, 1, 100), value);
    assert_eq!(client.ask_connected(&mut connected, &get).await.data[..], [0]);
    assert!(
        client
            .ask_connected(&mut connected, &set(&[2]))
            .await
            .status
            .is_success()
    );
    assert_eq!(client.ask_connected(&mut connected, &get).await.data[..], [2]);
    assert_eq!(client.ask(&get).await.data[..], [0], "the session's own is another");
    for (value, expected) in [(&[4][..], 0x09), (&[], 0x13), (&[1, 0, 0], 0x15)] {
        let reply = client.ask_connected(&mut connected, &set(value)).await;
        assert_eq!(codes(reply.status), (expected, 0), "{value:?}");
    }
    // The reaction is forgotten with the connection.
    assert!(client.close(&connected).await.status.is_success());
    let mut again = client.open(500, 1).await;
    assert_eq!(client.ask_connected(&mut again, &get).await.data[..], [0]);
}
