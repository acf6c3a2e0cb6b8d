//! `--state FILE`: the state after a restart and after a SIGKILL at any instant, and the treatment of files that cannot be used.
//!
//! `ARCLINE_KILLS` sets how often a server is killed: 16 times without it in a release build (`.ci/run timed_tests`), 5 in others.
#![allow(missing_docs)]

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use arcline_client::{Client, ClientError, Flag, Mnemonic, Operands, TagValue, WriteValue};
use arcline_state::{Axis, AxisState, LockedFile, Pace, RetainedState, Writer, parse};
use arcline_system_tests::programs;
use arcline_system_tests::server::Server;
use arcline_tests::random::Random;

fn milliseconds(random: &mut Random, most: u64) -> Duration {
    Duration::from_micros(random.below(1000 * most + 1))
}

/// A position that a REAL holds exactly, within ±200.
fn position(random: &mut Random) -> f64 {
    f64::from(random.below(400_001) as f32 / 1000.0 - 200.0)
}

/// The longest time from the start of the process to its ready line. A debug build on a busy machine is measured, not checked.
const READY: Duration = Duration::from_millis(500);
/// After this time, the state of the axes is in the file. It is 10 ms and a write, but the machine may be busy.
const SEEN: Duration = Duration::from_millis(500);
/// DINTs that each writer writes in one message.
const ELEMENTS: usize = 16;
const WRITERS: usize = 3;

/// The default machine with a few plain tags, and a file for its state.
struct Files {
    _folder: tempfile::TempDir,
    config: PathBuf,
    state: PathBuf,
}

impl Files {
    fn new(tags: &[(&str, &str)]) -> Self {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let files = Files {
            config: folder.path().join("machine.toml"),
            state: folder.path().join("machine.state"),
            _folder: folder,
        };
        files.configure(arcline_config::DEFAULT, tags);
        files
    }

    fn configure(&self, machine: &str, tags: &[(&str, &str)]) {
        let tags = tags
            .iter()
            .map(|(name, kind)| format!("\n[[tag]]\nname = \"{name}\"\ntype = \"{kind}\"\n"));
        let text = machine.to_owned() + &tags.collect::<String>();
        std::fs::write(&self.config, text).expect("the folder is writable");
    }

    fn arguments(&self) -> [&str; 4] {
        let [config, state] = [&self.config, &self.state].map(|path| path.to_str().expect("temporary paths are UTF-8"));
        ["--config", config, "--state", state]
    }

    fn start(&self) -> Server {
        Server::start_with(&self.arguments())
    }

    /// The state in the file, which must be undamaged.
    fn read(&self) -> RetainedState {
        let bytes = std::fs::read(&self.state).expect("the file is there");
        parse(&bytes)
            .unwrap_or_else(|damage| panic!("{damage}, after {} bytes", bytes.len()))
            .state
    }

    /// The files beside the configuration, sorted.
    fn names(&self) -> Vec<String> {
        let folder = self.config.parent().expect("a file has a folder");
        let entries = std::fs::read_dir(folder).expect("the folder is readable");
        let name = |entry: std::io::Result<std::fs::DirEntry>| entry.expect("readable").file_name();
        let mut names: Vec<String> = entries
            .map(|entry| name(entry).to_string_lossy().into_owned())
            .collect();
        names.sort();
        names
    }
}

async fn connect(server: &Server) -> Client {
    let client = Client::connect(&server.address().to_string()).await;
    client.expect("a ready server accepts")
}

async fn axis(client: &Client, name: &str) -> TagValue {
    client
        .read(name)
        .await
        .unwrap_or_else(|error| panic!("{name}: {error}"))
}

async fn numbers(client: &Client, path: &str) -> Vec<f64> {
    client
        .read_numbers(path)
        .await
        .unwrap_or_else(|error| panic!("{path}: {error}"))
}

/// The axis has its stored position, its drive is off, and it is homed unless it was moving.
async fn holds(client: &Client, kept: &Axis, why: &str) {
    let AxisState {
        position,
        homed,
        moving,
        ..
    } = kept.state;
    let name = &kept.name;
    let shown = axis(client, name).await;
    for member in ["ActualPosition", "CommandPosition"] {
        let found = shown.number(member);
        assert_eq!(found, f64::from(position as f32), "{why}: {name}.{member}");
    }
    assert_eq!(shown.flag("AxisHomedStatus"), homed && !moving, "{why}: {name} homed");
    if kept.kind.starts_with("servo") {
        assert!(!shown.flag("ServoActionStatus"), "{why}: the drive of {name} is on");
        assert!(!shown.flag("DriveEnableStatus"), "{why}: the drive of {name} is on");
    }
}

fn table(number: i64) -> WriteValue {
    WriteValue::Array(vec![WriteValue::from(number); ELEMENTS])
}

/// The newest sent and the newest acknowledged value of a writer.
#[derive(Clone, Copy, Default)]
struct WriterProgress {
    sent: i64,
    acknowledged: i64,
}

/// A move: its start, its end, and its observed positions with their times.
#[derive(Clone, Debug)]
struct Leg {
    from: [f64; 3],
    to: [f64; 3],
    answered: Option<Instant>,
    done: Option<Instant>,
}

type Shared<T> = Arc<Mutex<T>>;

fn put<T, R>(shared: &Shared<T>, change: impl FnOnce(&mut T) -> R) -> R {
    change(&mut shared.lock().unwrap_or_else(PoisonError::into_inner))
}

/// Writes ever larger numbers until the server is gone.
async fn write(address: String, tag: String, written: Shared<WriterProgress>) -> Result<(), ClientError> {
    let client = Client::connect(&address).await?;
    loop {
        let number = put(&written, |written| {
            written.sent += 1;
            written.sent
        });
        client.write(&tag, table(number)).await?;
        put(&written, |written| written.acknowledged = number);
    }
}

/// Moves a coordinate system from place to place until the server is gone.
async fn travel(
    address: String,
    system: &'static str,
    servos: &'static [&'static str],
    mut random: Random,
    mut from: [f64; 3],
    legs: Shared<Vec<Leg>>,
) -> Result<(), ClientError> {
    let client = Client::connect(&address).await?;
    for servo in servos {
        client.execute(Mnemonic::Mso, servo, "", &[]).await?;
        while !axis_flag(&client, servo, "ServoActionStatus").await? {}
    }
    loop {
        let to = [position(&mut random), position(&mut random), position(&mut random)];
        let leg = Leg {
            from,
            to,
            answered: None,
            done: None,
        };
        put(&legs, |legs| legs.push(leg));
        let operands = Operands::full_speed(Mnemonic::Mclm).with("Position", to.to_vec())?;
        let execution = client.execute(Mnemonic::Mclm, system, "", operands.as_slice()).await?;
        put(&legs, |legs| {
            legs.last_mut().expect("pushed").answered = Some(Instant::now())
        });
        client.wait_for(&execution, Flag::Pc, Duration::from_secs(60)).await?;
        put(&legs, |legs| {
            legs.last_mut().expect("pushed").done = Some(Instant::now())
        });
        from = to;
        tokio::time::sleep(milliseconds(&mut random, 800)).await;
    }
}

async fn axis_flag(client: &Client, axis: &str, flag: &str) -> Result<bool, ClientError> {
    Ok(client.read(&format!("{axis}.{flag}")).await?.as_bool() == Some(true))
}

/// The axes of a coordinate system are in a state that there was in the time [`SEEN`] before the kill. The last move may have
/// begun within this time: then a state of the move before it is one, too.
fn judge(kept: &[Axis], legs: &[Leg], killed: Instant, why: &str) {
    let Some(last) = legs.last() else { return };
    let seen = |when: Option<Instant>| when.is_some_and(|when| killed.saturating_duration_since(when) > SEEN);
    let begun = legs.iter().rposition(|leg| seen(leg.answered));
    let recent = &legs[begun.unwrap_or(0)..];
    for (place, axis) in kept.iter().enumerate() {
        let AxisState { position, moving, .. } = axis.state;
        let during = |leg: &Leg| {
            let (from, to) = (leg.from[place], leg.to[place]);
            let within = (from.min(to) - 0.05..=from.max(to) + 0.05).contains(&position);
            let (at_rest, on_the_way) = (!moving && position == to, moving && within && !seen(leg.done));
            at_rest || on_the_way
        };
        let not_begun = begun.is_none() && !moving && position == recent[0].from[place];
        let (name, state) = (&axis.name, axis.state);
        assert!(
            not_begun || recent.iter().any(during),
            "{why}: {name} was kept as {state:?}, {} moves may be the one; the last: {last:?}",
            recent.len()
        );
    }
}

/// Makes the axes homed again, for lack of anything that would do so in the server. Where they were moving they
/// were moving.
fn home_again(file: &Path) {
    let place = LockedFile::lock(file).expect("no other process has it");
    let mut state = place.read().expect("whole").expect("it is there").state;
    for axis in &mut state.axes {
        axis.state.homed = true;
    }
    write_state(place, state);
}

/// Puts a state in the place of the stored one.
fn write_state(place: LockedFile, state: RetainedState) {
    let mut writer = Writer::<_, ()>::start(place, state, Pace::default(), Duration::ZERO);
    assert_eq!(writer.actions().count(), 0, "the folder is writable");
}

/// Checks that a server shows the state on which it has just started.
async fn shows(server: &Server, kept: &RetainedState, why: &str) {
    let client = connect(server).await;
    for axis in &kept.axes {
        holds(&client, axis, why).await;
    }
    for tag in &kept.tags {
        let expected: Vec<f64> = elements(&tag.bytes).map(f64::from).collect();
        assert_eq!(numbers(&client, &tag.name).await, expected, "{why}: {}", tag.name);
    }
}

fn elements(bytes: &[u8]) -> impl Iterator<Item = i32> {
    bytes
        .chunks_exact(4)
        .filter_map(|four| four.first_chunk().copied().map(i32::from_le_bytes))
}

/// The axes of a coordinate system in a state, and where they are.
fn of_system<'s>(state: &'s RetainedState, axes: [&str; 3]) -> ([&'s AxisState; 3], Vec<Axis>) {
    let find = |name: &str| state.axes.iter().find(|axis| axis.name == name);
    let found = axes.map(|name| find(name).expect("an axis of the machine"));
    (found.map(|axis| &axis.state), found.map(Clone::clone).to_vec())
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_kill_at_any_instant_leaves_a_state_that_there_was() {
    let usual = if cfg!(debug_assertions) { 5 } else { 16 };
    let kills = std::env::var("ARCLINE_KILLS").map_or(usual, |kills| kills.parse().expect("a number"));
    let _ = programs::arcline_server(); // built before the clock runs
    let names: Vec<String> = (0..WRITERS).map(|writer| format!("Table{writer}")).collect();
    let kind = format!("DINT[{ELEMENTS}]");
    let tags: Vec<(&str, &str)> = names.iter().map(|name| (name.as_str(), kind.as_str())).collect();
    let files = Files::new(&tags);
    drop(files.start());
    let mut random = Random(0x5EED);
    let (mut starts, mut moving, mut acknowledged, mut longest) = (Vec::new(), 0, 0, 0);
    for number in 1..=kills {
        let why = format!("kill {number} of {kills}");
        home_again(&files.state);
        let before = files.read();
        // Now and then one is killed while it starts.
        if random.bits().is_multiple_of(4) {
            let mut child = Command::new(programs::arcline_server())
                .args(["--listen", "127.0.0.1:0", "--hmi", "off"])
                .args(files.arguments())
                .stdout(Stdio::null())
                .stderr(Stdio::null())
                .spawn()
                .expect("a built program");
            tokio::time::sleep(milliseconds(&mut random, 60)).await;
            child.kill().expect("our child");
            child.wait().expect("our child");
            for (was, is) in before.axes.iter().zip(files.read().axes) {
                let homed = is.state.homed && !is.state.moving;
                let known = (is.state.position, homed) == (was.state.position, was.state.homed && !was.state.moving);
                assert!(known, "{why}, while it started: {was:?} became {is:?}");
            }
            assert_eq!(files.read().tags, before.tags, "{why}, while it started");
        }
        let server = files.start();
        starts.push(server.ready_after());
        assert!(
            cfg!(debug_assertions) || server.ready_after() < READY,
            "{why}: ready after {:?}, expected less than {READY:?}",
            server.ready_after()
        );
        shows(&server, &before, &why).await;

        let address = server.address().to_string();
        let mut tasks = tokio::task::JoinSet::new();
        let written: Vec<Shared<WriterProgress>> = (before.tags.iter())
            .map(|tag| {
                let last = elements(&tag.bytes).next().map_or(0, i64::from);
                let written = WriterProgress {
                    sent: last,
                    acknowledged: last,
                };
                Arc::new(Mutex::new(written))
            })
            .collect();
        let first: Vec<i64> = written
            .iter()
            .map(|written| put(written, |written| written.sent))
            .collect();
        for (name, written) in names.iter().zip(&written) {
            tasks.spawn(write(address.clone(), name.clone(), written.clone()));
        }
        let systems: [(_, &[&str], _); 2] = [
            ("CS1", &["X", "Y", "Z"], ["X", "Y", "Z"]),
            ("CS3", &[], ["A", "B", "C"]),
        ];
        let legs: [Shared<Vec<Leg>>; 2] = Default::default();
        for ((system, servos, axes), legs) in systems.into_iter().zip(&legs) {
            let from = of_system(&before, axes).0.map(|state| state.position);
            let travel = travel(
                address.clone(),
                system,
                servos,
                Random(random.bits()),
                from,
                legs.clone(),
            );
            tasks.spawn(travel);
        }
        let latest = if random.bits().is_multiple_of(5) { 60 } else { 2500 };
        tokio::time::sleep(milliseconds(&mut random, latest)).await;
        let killed = Instant::now();
        let log = server.kill();
        while let Some(ended) = tasks.join_next().await {
            let error = ended
                .expect("no panic")
                .expect_err("they go on until the server is gone");
            assert!(error.is_connection(), "{why}: {error}");
        }
        assert!(!log.contains("panicked"), "{why}: {log}");

        let kept = files.read();
        longest = longest.max(std::fs::metadata(&files.state).expect("it is there").len());
        for (((tag, written), name), first) in kept.tags.iter().zip(&written).zip(&names).zip(first) {
            let found: Vec<i64> = elements(&tag.bytes).map(i64::from).collect();
            let WriterProgress {
                sent,
                acknowledged: last,
            } = put(written, |written| *written);
            assert_eq!(found, vec![found[0]; ELEMENTS], "{why}: {name} is of one message");
            assert!(
                (last..=sent).contains(&found[0]),
                "{why}: {name} is {}, acknowledged was {last} and sent {sent}",
                found[0]
            );
            acknowledged += last - first;
        }
        for (axis, was) in kept.axes.iter().zip(&before.axes) {
            let touched = systems
                .iter()
                .zip(&legs)
                .any(|((_, _, axes), legs)| axes.contains(&axis.name.as_str()) && put(legs, |legs| !legs.is_empty()));
            let (name, state) = (&axis.name, axis.state);
            moving += u32::from(state.moving);
            if !touched {
                let homed = was.state.homed && !was.state.moving;
                assert_eq!(state.homed, homed, "{why}: {name} homed");
                assert_eq!(state.position, was.state.position, "{why}: {name} did not move");
                assert!(!state.moving, "{why}: {name} did not move");
            }
        }
        for ((_, _, axes), legs) in systems.iter().zip(&legs) {
            judge(
                &of_system(&kept, *axes).1,
                &put(legs, |legs| legs.clone()),
                killed,
                &why,
            );
        }
        assert_eq!(
            files.names().iter().find(|name| name.contains("set-aside")),
            None,
            "{why}: nothing is damaged"
        );
    }
    starts.sort();
    println!("{}", commit());
    println!(
        "{kills} kills: ready again after {:.1?} (median), at most {:.1?}; {acknowledged} writes acknowledged, {moving} axes killed while \
         they moved; the file had at most {longest} bytes",
        starts[starts.len() / 2],
        starts[starts.len() - 1]
    );
}

/// The commit and its date, as docs/campaigns/kills.txt begins.
fn commit() -> String {
    let git = std::process::Command::new("git")
        .args(["show", "-s", "--abbrev=8", "--format=commit %h of %cs", "HEAD"])
        .output();
    git.map_or_else(
        |_| "no commit".to_owned(),
        |shown| String::from_utf8_lossy(&shown.stdout).trim().to_owned(),
    )
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_controlled_stop_saves_where_it_stopped() {
    let files = Files::new(&[("Count", "DINT"), ("Label", "STRING")]);
    let server = files.start();
    let client = connect(&server).await;
    let shown = axis(&client, "X").await;
    assert!(shown.flag("ServoActionStatus"), "nothing was kept: as configured");
    client.write("Count", -7).await.expect("writable");
    client.write("Label", "kept").await.expect("writable");
    let operands = Operands::full_speed(Mnemonic::Mclm).with("Position", vec![1000.0, -500.0, 0.25]);
    let operands = operands.expect("an operand of it");
    let execution = client.execute(Mnemonic::Mclm, "CS1", "", operands.as_slice()).await;
    execution.expect("it can be executed");
    while axis(&client, "X").await.number("ActualPosition") < 1.0 {}
    let (status, log) = server.terminate();
    assert_eq!(status.code(), Some(0), "{log}");
    let kept = files.read();
    for axis in &kept.axes {
        assert!(axis.state.homed && !axis.state.moving, "{axis:?}");
    }
    let position = |name: &str| of_system(&kept, [name; 3]).0[0].position;
    assert!(position("X") > 1.0 && position("X") < 999.0, "it stopped on the way");
    let again = files.start();
    let client = connect(&again).await;
    for axis in &kept.axes {
        holds(&client, axis, "after SIGTERM").await;
    }
    assert_eq!(numbers(&client, "Count").await, [-7.0]);
    assert_eq!(client.read("Label").await.expect("a tag").text(), Some("kept"));
    let (status, log) = again.terminate();
    assert_eq!((status.code(), log.as_str()), (Some(0), ""), "nothing to say");
    assert_eq!(files.read(), kept, "and nothing has changed");
    assert_eq!(files.names(), ["machine.state", "machine.state.lock", "machine.toml"]);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_fault_comes_back_until_it_is_reset() {
    let files = Files::new(&[]);
    let server = files.start();
    let client = connect(&server).await;
    client.write("FaultInject[0]", 8).await.expect("writable");
    while !axis(&client, "X").await.flag("PhysicalAxisFault") {}
    while files.read().axes[0].state.faults != 8 {}
    let _ = server.kill();
    let again = files.start();
    let client = connect(&again).await;
    for (name, faulted) in [("X", true), ("Y", false)] {
        let shown = axis(&client, name).await;
        assert_eq!(shown.flag("PhysicalAxisFault"), faulted, "{name}");
        assert_eq!(shown.flag("ControllerInitiatedFault"), faulted, "{name}");
    }
    let operands = Operands::full_speed(Mnemonic::Mafr);
    let reset = client.execute(Mnemonic::Mafr, "X", "", operands.as_slice()).await;
    reset.expect("it can be executed");
    while axis(&client, "X").await.flag("PhysicalAxisFault") {}
    let (status, log) = again.terminate();
    assert_eq!(status.code(), Some(0), "{log}");
    assert_eq!(files.read().axes[0].state.faults, 0);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn without_a_file_nothing_is_kept() {
    let files = Files::new(&[("Count", "DINT")]);
    for state in [&["--state", "off"][..], &[]] {
        let config = ["--config", files.config.to_str().expect("UTF-8")];
        let server = Server::start_with(&[&config[..], state].concat());
        let client = connect(&server).await;
        assert_eq!(numbers(&client, "Count").await, [0.0]);
        client.write("Count", 1).await.expect("writable");
        assert_eq!(server.terminate().0.code(), Some(0));
        assert_eq!(files.names(), ["machine.toml"]);
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_file_that_cannot_be_used_is_set_aside_with_a_message() {
    let files = Files::new(&[("Count", "DINT")]);
    let server = files.start();
    connect(&server).await.write("Count", 5).await.expect("writable");
    assert_eq!(server.terminate().0.code(), Some(0));
    let whole = std::fs::read(&files.state).expect("it is there");
    let mut damaged = whole.clone();
    damaged[(12_288 + whole.len()) / 2] ^= 0x10;
    let mut other = RetainedState::default();
    other.axes.push(Axis {
        name: "Arm".to_owned(),
        kind: "servo, deg".to_owned(),
        state: AxisState::default(),
    });
    write_state(LockedFile::lock(&files.state).expect("no other process has it"), other);
    let foreign = std::fs::read(&files.state).expect("it is there");
    let cases: [(&str, &[u8]); 4] = [
        ("is wrong", &damaged),
        ("before its first state is whole", &whole[..20]),
        ("is not a retained state of Arcline", b"[server]\nname = \"not this\"\n"),
        ("the state of another machine", &foreign),
    ];
    for (number, (message, bytes)) in (1..).zip(cases) {
        std::fs::write(&files.state, bytes).expect("the folder is writable");
        let server = files.start();
        let client = connect(&server).await;
        assert_eq!(numbers(&client, "Count").await, [0.0], "{message}");
        assert!(
            axis(&client, "X").await.flag("ServoActionStatus"),
            "{message}: as configured"
        );
        let log = server.kill();
        let aside = format!("{}.set-aside-{number}", files.state.display());
        assert_eq!(log.lines().count(), 1, "one message: {log}");
        assert!(log.contains(message) && log.contains(&aside), "{message}: {log}");
        assert_eq!(
            std::fs::read(aside).expect("it is there"),
            bytes,
            "{message}: as it was"
        );
        assert_eq!(files.read().axes.len(), 7, "{message}: begun anew");
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_full_disk_refuses_only_the_writes_that_it_cannot_keep() {
    let files = Files::new(&[("Table", "DINT[16]")]);
    let server = Server::start_short_of_space(64, &files.arguments());
    let client = connect(&server).await;
    let mut acknowledged = 0;
    let refused = loop {
        assert!(acknowledged < 10_000, "the file has a limit");
        match client.write("Table", table(acknowledged + 1)).await {
            Ok(()) => acknowledged += 1,
            Err(error) => break error,
        }
    };
    assert!(refused.to_string().contains("could not save it"), "{refused}");
    assert!(acknowledged > 10, "there was room for a few");
    let kept = files.read();
    assert_eq!(elements(&kept.tags[0].bytes).next(), i32::try_from(acknowledged).ok());
    assert_eq!(
        numbers(&client, "Table").await,
        [acknowledged as f64 + 1.0; 16],
        "the tag has it all the same"
    );
    client.write("Move1.Speed", 20.0).await.expect("it is not kept");
    client
        .execute(Mnemonic::Mso, "X", "", &[])
        .await
        .expect("it is no write");
    // Written anew the file is short again.
    let mut tries = 0;
    while client.write("Table", table(acknowledged + 100)).await.is_err() {
        tries += 1;
        assert!(tries < 1000, "it is never written again");
        tokio::time::sleep(Duration::from_millis(10)).await;
    }
    let log = server.kill();
    assert!(
        log.contains("cannot be written") && log.contains("is written again"),
        "{log}"
    );
    assert_eq!(
        log.lines().filter(|line| line.contains("cannot be written")).count(),
        1,
        "said once"
    );
    let server = files.start();
    let shown = numbers(&connect(&server).await, "Table").await;
    assert_eq!(shown, [acknowledged as f64 + 100.0; 16]);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_changed_configuration_takes_over_the_axes_and_tags_that_it_still_has() {
    let files = Files::new(&[("Count", "DINT"), ("Old", "DINT"), ("Wider", "INT")]);
    let server = files.start();
    let client = connect(&server).await;
    for tag in ["Count", "Old", "Wider"] {
        client.write(tag, 5).await.expect("writable");
    }
    assert_eq!(server.terminate().0.code(), Some(0));
    let machine = arcline_config::DEFAULT.replacen("name = \"S\"", "name = \"T\"", 1);
    let machine = machine.replacen("\"S\"]", "\"T\"]", 1);
    files.configure(&machine, &[("Wider", "DINT"), ("New", "DINT"), ("Count", "DINT")]);
    let server = files.start();
    let client = connect(&server).await;
    for (tag, expected) in [("Count", 5.0), ("Wider", 0.0), ("New", 0.0)] {
        assert_eq!(numbers(&client, tag).await, [expected], "{tag}");
    }
    assert!(axis(&client, "T").await.flag("ServoActionStatus"), "as configured");
    assert!(!axis(&client, "X").await.flag("ServoActionStatus"), "taken over");
    let (status, log) = server.terminate();
    assert_eq!(status.code(), Some(0));
    assert!(
        log.contains("axis S (servo, mm), tag Old (DINT), tag Wider (INT)"),
        "{log}"
    );
}

#[test]
fn files_that_cannot_be_had_are_told() {
    let files = Files::new(&[]);
    let server = files.start();
    let folder = files.config.parent().and_then(Path::to_str).expect("UTF-8");
    let missing = format!("{folder}/missing/machine.state");
    let taken = files.state.to_str().expect("UTF-8");
    let cases = [
        (taken, "another server keeps its state there"),
        (folder, "it is not a file"),
        (missing.as_str(), "No such file or directory"),
    ];
    for (file, message) in cases {
        let output = Command::new(programs::arcline_server())
            .args(["--listen", "127.0.0.1:0", "--hmi", "off", "--state", file])
            .output()
            .expect("a built program");
        let log = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{message}: {log}");
        let expected = format!("arcline-server: --state {file}: {message}");
        assert!(log.starts_with(&expected), "{expected}: {log}");
    }
    drop(server);
}
