//! A disk whose synchronisations take two seconds: no answer waits for them.

use std::time::{Duration, Instant};

use super::{Files, connect, strace_is_missing, write};

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_slow_disk_delays_no_answer() {
    if strace_is_missing("a slow disk") {
        return;
    }
    // An answer that waits for the disk waits in every try; a machine that is busy with something else delays some answers of some tries.
    let mut tries = Vec::new();
    for _ in 0..TRIES {
        let quick = longest_answer(Duration::ZERO).await;
        let slow = longest_answer(SYNCHRONISATION).await;
        println!("longest answer: {quick:?}, and {slow:?} while each fdatasync takes {SYNCHRONISATION:?} longer");
        tries.push((quick, slow));
        if slow <= quick + DELAY {
            return;
        }
    }
    panic!("answers wait for the disk, longest without and with delay: {tries:?}");
}

/// The longest answer to a write of some seconds, on a disk whose synchronisations take longer by `delay`.
async fn longest_answer(delay: Duration) -> Duration {
    let files = Files::new();
    let server = files.start_injected(&format!("fdatasync:delay_enter={}", delay.as_micros()));
    let server = server.unwrap_or_else(|not_ready| panic!("{not_ready}"));
    let client = connect(&server).await;
    let (mut longest, began) = (Duration::ZERO, Instant::now());
    let mut number = 0;
    // The second synchronisation begins a pause of one second after the first has ended.
    while began.elapsed() < SYNCHRONISATION + Duration::from_millis(2500) {
        number += 1;
        let asked = Instant::now();
        write(&client, number).await.expect("it is kept");
        longest = longest.max(asked.elapsed());
        tokio::time::sleep(Duration::from_millis(1)).await;
    }
    longest
}

const SYNCHRONISATION: Duration = Duration::from_secs(2);
/// The delay that must not show in any answer.
const DELAY: Duration = Duration::from_millis(10);
const TRIES: usize = 5;
