//! Each system call of the retained state is once the last one of the server, and once one that fails.

use std::sync::Arc;
use std::time::{Duration, Instant};

use arcline_client::Client;
use arcline_system_tests::server::Server;
use tokio::sync::Semaphore;
use tokio::task::{JoinSet, spawn_blocking};

use super::{CALLS, ELEMENTS, Files, connect, is_not_persistent, strace_is_missing, write};

/// Up to which call. strace counts the calls of each kind, and those of each thread.
fn last_call() -> u32 {
    std::env::var("ARCLINE_CALLS").map_or(40, |calls| calls.parse().expect("a number"))
}

/// Writes until the server is gone. Returns the last number that was answered, and the last one that was sent.
async fn write_to_the_end(server: &Server, from: i64) -> (i64, i64) {
    let Ok(client) = Client::connect(&server.address().to_string()).await else {
        return (from, from);
    };
    for number in from + 1..from + 5000 {
        if write(&client, number).await.is_err() {
            return (number - 1, number);
        }
    }
    (from + 4999, from + 4999)
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_kill_at_any_call_keeps_all_answered_writes() {
    if strace_is_missing("kill at any call") {
        return;
    }
    let kills = last_call();
    let files = Files::new();
    drop(files.start());
    let (mut number, mut at_start, mut written) = (0, 0, 0);
    for call in 1..=kills {
        let why = format!("kill at call {call} of a thread");
        let before = files.table(&why);
        let range = match files.start_injected(&format!("{CALLS}:signal=SIGKILL:when={call}")) {
            Err(_) => {
                at_start += 1;
                number..=number
            }
            Ok(server) => {
                let (answered, sent) = write_to_the_end(&server, number).await;
                drop(server);
                written += answered - number;
                answered..=sent
            }
        };
        let kept = files.table(&why).or(before).unwrap_or_default();
        assert!(
            range.contains(&kept),
            "{why}: {kept} is kept, and {range:?} were answered and sent"
        );
        number = kept;
    }
    let server = files.start();
    let shown = connect(&server).await.read_numbers("Table").await.expect("a tag");
    assert_eq!(shown, [number as f64; ELEMENTS]);
    println!("{kills} kills, {at_start} of them while the server started; {written} writes answered, none lost");
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_disk_that_fails_is_an_answer_and_recovers() {
    let test = "calls that fail";
    if strace_is_missing(test) {
        return;
    }
    // strace counts the calls of each thread: the first ones are those at the start, and those that follow in the threads.
    let cases = [
        "fdatasync:error=EIO:when=1",
        "fdatasync:error=EIO:when=2",
        "fsync:error=EIO:when=1",
        "rename:error=EIO:when=1",
        "openat:error=EMFILE:when=3",
        "write:error=ENOSPC:when=2..3",
        "pwrite64:error=EIO:when=1",
    ];
    for case in cases {
        let files = Files::new();
        let server = files
            .start_injected(case)
            .unwrap_or_else(|not_ready| panic!("{case}: {not_ready}"));
        let client = connect(&server).await;
        let (mut answered, mut refused) = (0, 0);
        let until = Instant::now() + Duration::from_secs(4);
        let mut number = 0;
        while Instant::now() < until {
            number += 1;
            match write(&client, number).await {
                Ok(()) => answered = number,
                Err(error) if is_not_persistent(&error) => refused += 1,
                Err(error) => panic!("{case}: {error}"),
            }
            tokio::time::sleep(Duration::from_millis(5)).await;
        }
        let log = server.kill();
        assert_eq!(answered, number, "{case}: it is kept again at the end; {log}");
        assert_eq!(files.table(case), Some(answered), "{case}");
        assert_eq!(
            refused > 0,
            log.contains("writes of plain tags are refused"),
            "{case}: {log}"
        );
        assert_eq!(refused > 0, log.contains("is written again"), "{case}: {log}");
        println!("{case}: {number} writes, {refused} of them refused");
    }
}

/// The effect of an error at one call.
enum Met {
    /// The server reported that it cannot use the file, and did not start.
    Refused,
    /// The number of writes that were answered as not persistent, until the state was in a new file.
    NotPersistent(u32),
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn an_error_at_any_call_loses_nothing_and_recovers() {
    if strace_is_missing("an error at any call") {
        return;
    }
    let files = Files::new();
    let server = files.start();
    write(&connect(&server).await, FIRST).await.expect("the disk works");
    drop(server);
    let state = std::fs::read(files.path("machine.state")).expect("it is there");
    let (calls, at_once) = (last_call(), Arc::new(Semaphore::new(AT_ONCE)));
    let mut runs = JoinSet::new();
    for (error, text) in [("EIO", "Input/output error"), ("ENOSPC", "No space left on device")] {
        for call in 1..=calls {
            let (state, at_once) = (state.clone(), at_once.clone());
            runs.spawn(async move {
                let _permit = at_once.acquire().await.expect("it is never closed");
                fail_once(error, text, call, state).await
            });
        }
    }
    let (mut at_start, mut met, mut refused) = (0, 0, 0);
    while let Some(ended) = runs.join_next().await {
        match ended {
            Ok(Met::Refused) => at_start += 1,
            Ok(Met::NotPersistent(writes)) => {
                met += u32::from(writes > 0);
                refused += writes;
            }
            Err(panic) => std::panic::resume_unwind(panic.into_panic()),
        }
    }
    println!(
        "EIO and ENOSPC at calls 1 to {calls}: {at_start} servers did not start, {met} refused writes for a while, {refused} in all; none \
         was lost"
    );
    // The first opens are those of the start; from a few calls on, each is a write of the state.
    assert!(at_start > 0 && at_start + met + 4 >= 2 * calls, "the calls fail");
}

/// Runs a server one call of which fails: it loses no write that it has answered as persistent, and in the end all writes are persistent again.
async fn fail_once(error: &'static str, text: &'static str, call: u32, state: Vec<u8>) -> Met {
    let why = format!("{error} at call {call} of a kind");
    let begun = spawn_blocking(move || {
        let files = Files::with_state(&state);
        let server = files.start_injected(&format!("{CALLS}:error={error}:when={call}"));
        (files, server)
    });
    let (files, server) = begun.await.expect("no panic");
    let server = match server {
        Ok(server) => server,
        Err(not_ready) => {
            let log = not_ready.to_string();
            assert!(log.contains("--state") && log.contains(text), "{why}: {log}");
            assert_eq!(files.table(&why), Some(FIRST), "{why}: it is as it was");
            return Met::Refused;
        }
    };
    let client = connect(&server).await;
    let shown = client.read_numbers("Table").await.expect("a tag");
    assert_eq!(shown, [FIRST as f64; ELEMENTS], "{why}: at the start");
    let (mut answered, mut sent, mut refused) = (FIRST, FIRST, 0);
    let (began, mut good_since) = (Instant::now(), Instant::now());
    // Each write of a tag is a call, so that the one that fails is among them.
    while good_since.elapsed() < GOOD || sent - FIRST < i64::from(call) + 20 {
        assert!(began.elapsed() < RECOVERED, "{why}: it is never kept again");
        sent += 1;
        match write(&client, sent).await {
            Ok(()) => answered = sent,
            Err(error) if is_not_persistent(&error) => {
                // A kill at this instant would leave this file.
                let kept = files.table(&why).unwrap_or_default();
                assert!(
                    (answered..=sent).contains(&kept),
                    "{why}: the file has {kept}, {answered} was answered and {sent} sent"
                );
                refused += 1;
                good_since = Instant::now();
            }
            Err(error) => panic!("{why}: {error}"),
        }
        tokio::time::sleep(Duration::from_millis(4)).await;
    }
    let log = kill(server, client).await;
    assert_eq!(files.table(&why), Some(answered), "{why}: {log}");
    assert_eq!(answered, sent, "{why}: {log}");
    assert_eq!(refused > 0, log.contains("is written again"), "{why}: {log}");
    Met::NotPersistent(refused)
}

async fn kill(server: Server, client: Client) -> String {
    drop(client);
    spawn_blocking(|| server.kill()).await.expect("no panic")
}

/// The number in the state before.
const FIRST: i64 = 7;
/// Servers under strace at a time: they wait most of the time.
const AT_ONCE: usize = 8;
/// The time for which all writes are persistent before a run ends: longer than the pause after which the disk is synchronised.
const GOOD: Duration = Duration::from_millis(1500);
/// An error is over by then, also on a busy machine.
const RECOVERED: Duration = Duration::from_secs(30);
