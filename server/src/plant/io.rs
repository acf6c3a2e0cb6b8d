//! Views of the plant, and the commands of its interfaces that do not wait for the controller.

use std::sync::Arc;

use arcline_controller::Snapshot;
use arcline_controller::image::Image;
use arcline_instruction_set::SystemId;

use arcline_state::planted::is_planted;

use super::{Command, Counter, Executions, LiveMoves, Logged, Movers, Plant, Principal, Systems};
use crate::audit::EventKind;

/// Everything that one tick shows.
#[derive(Debug)]
pub struct View<'v> {
    /// The tags.
    pub image: &'v Image,
    /// The state of the controller.
    pub snapshot: &'v Snapshot,
    /// The moves under way.
    pub moves: &'v LiveMoves,
    /// The principals that move axes and coordinate systems.
    pub movers: Arc<Movers>,
}

impl Plant {
    /// Reads the state of the newest tick.
    pub fn with_snapshot<R>(&self, read: impl FnOnce(&Snapshot) -> R) -> R {
        let mut state = self.0.lock();
        state.refresh();
        read(state.link.snapshots.output_buffer())
    }

    /// Reads the newest changes of instructions behind a number, oldest first, with the present tags and the executions.
    pub(crate) fn events_since<R>(&self, number: u64, read: impl FnOnce(&Image, &Executions, Vec<Logged>) -> R) -> R {
        let mut state = self.0.lock();
        state.refresh();
        let events = state.log.since(number).copied().collect();
        read(state.image(), &state.records, events)
    }

    /// Reads all data of one tick.
    pub fn view<R>(&self, look: impl FnOnce(&View<'_>) -> R) -> R {
        let mut state = self.0.lock();
        state.refresh();
        look(&state.view())
    }

    /// The principals that move axes and coordinate systems, as of the last change. It waits for no lock.
    pub fn movers(&self) -> Arc<Movers> {
        self.0.published.movers.load_full()
    }

    /// As [`Plant::with_snapshot`], but does not wait for the lock: `None` when another thread holds it for longer.
    pub fn try_with_snapshot<R>(&self, read: impl FnOnce(&Snapshot) -> R) -> Option<R> {
        for _ in 0..LOOKS {
            if let Some(mut state) = self.0.try_lock() {
                state.refresh();
                return Some(read(state.link.snapshots.output_buffer()));
            }
            std::hint::spin_loop();
        }
        None
    }

    /// Sets feed overrides, in percent, in configuration order. `false`: at least one is out of range, and stays as it
    /// was.
    pub fn set_feed_overrides(&self, principal: Principal, percent: &[f32]) -> bool {
        let systems = SystemId::first(self.0.machine.systems.len());
        let (all, _) = self.transact(principal, |transaction| {
            let set = systems.zip(percent).map(|(system, percent)| {
                let percent = *percent;
                transaction.apply(Command::SetFeedOverride { system, percent }).is_ok()
            });
            set.fold(true, |all, is_set| all & is_set)
        });
        all
    }

    /// Holds every coordinate system. `false`: there is no override to hold by.
    pub fn hold_all(&self, principal: Principal) -> bool {
        let held = self.transact(principal, |transaction| transaction.apply(Command::Hold(Systems::All)));
        held.0.is_ok()
    }

    /// Gives every coordinate system that is held the override it had before.
    pub fn resume_all(&self, principal: Principal) -> bool {
        let resumed = self.transact(principal, |transaction| {
            transaction.apply(Command::Resume(Systems::All))
        });
        resumed.0.is_ok()
    }

    /// Stops all motion, every axis by itself. The plant cannot refuse it, and it waits neither for a lock nor behind other commands. It also
    /// stops motion that an earlier command begins later.
    pub fn stop_all(&self) {
        self.0.counters.count(Counter::Stops, true);
        self.0.stops.stop_all();
        self.record(
            Principal::Server,
            EventKind::Estop,
            "stop of everything".to_owned(),
            "done",
        );
    }

    /// STOP: as [`Plant::stop_all`], and motion stays inhibited for every interface and program until [`Command::Release`].
    pub fn inhibit(&self) {
        self.0.counters.count(Counter::Stops, true);
        if is_planted("STOP does not hold") {
            return self.0.stops.stop_all();
        }
        self.0.stops.inhibit();
        self.record(Principal::Server, EventKind::Estop, "STOP".to_owned(), "done");
        // The tags show it with the next look.
        self.0.sent.notify_one();
    }

    /// Whether motion is inhibited by STOP.
    pub fn is_inhibited(&self) -> bool {
        self.0.stops.is_inhibited()
    }
}

/// Tries to take the lock: some microseconds, as long as a running thread holds it.
const LOOKS: usize = 1000;
