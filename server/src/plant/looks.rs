//! The pauses between two looks for the answers of the controller.

use std::time::Duration;

use tokio::sync::Notify;

/// The clock of the pauses.
#[derive(Clone, Copy, Debug)]
pub(super) enum Looks {
    /// That of the computer, by a sleep on a thread of the runtime: its timers have a resolution of a millisecond, with which a client that waits for each
    /// answer sends in one tick of three.
    OnTime,
    /// That of the runtime, which may be virtual.
    OnRuntime,
}

const IDLE: Duration = Duration::from_millis(10);
const BUSY: Duration = Duration::from_millis(1);
const LEAST_BUSY: Duration = Duration::from_micros(100);

impl Looks {
    /// Waits for the next look. `busy`: a call waits for its answer. A sent command ends the pause.
    pub(super) async fn pause(self, busy: bool, period_ns: u64, sent: &Notify) {
        if let Looks::OnTime = self
            && busy
        {
            let part_of_a_tick = Duration::from_nanos(period_ns / 4).clamp(LEAST_BUSY, BUSY);
            let _ = tokio::task::spawn_blocking(move || std::thread::sleep(part_of_a_tick)).await;
        } else {
            let pause = if busy { BUSY } else { IDLE };
            let _ = tokio::time::timeout(pause, sent.notified()).await;
        }
    }
}
