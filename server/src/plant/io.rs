//! What implicit I/O does with the plant: the state of a tick for its inputs, and what its outputs command. Nothing here
//! waits for the controller.

use arcline_controller::Snapshot;
use arcline_controller::image::Image;

use super::{LiveMoves, Logged, Plant};

impl Plant {
    /// Reads the state of the newest tick.
    pub fn with_snapshot<R>(&self, read: impl FnOnce(&Snapshot) -> R) -> R {
        let mut state = self.0.lock();
        state.refresh();
        read(state.link.snapshots.output_buffer())
    }

    /// The newest changes of instructions behind a number, oldest first, with the tags of now.
    pub fn events_since<R>(&self, number: u64, read: impl FnOnce(&Image, Vec<Logged>) -> R) -> R {
        let mut state = self.0.lock();
        state.refresh();
        let events = state.log.since(number).copied().collect();
        read(state.image(), events)
    }

    /// Reads the state of the newest tick, the tags of the same one, and the moves under way.
    pub fn with_state<R>(&self, read: impl FnOnce(&Image, &Snapshot, &LiveMoves) -> R) -> R {
        let mut state = self.0.lock();
        state.refresh();
        let (image, snapshot, moves) = state.view();
        read(image, snapshot, moves)
    }

    /// As [`Plant::with_snapshot`], but does not wait for whoever has the plant: `None` when it is not to be had soon.
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
    pub fn set_feed_overrides(&self, percent: &[f32]) -> bool {
        self.override_each(|system| percent.get(system).copied())
    }

    /// Holds every coordinate system. `false`: there is no override to hold by.
    pub fn hold_all(&self) -> bool {
        self.override_each(|_| Some(0.0))
    }

    /// Gives every coordinate system that is held the override it had before.
    pub fn resume_all(&self) -> bool {
        let held: Vec<Option<f32>> = {
            let state = self.0.lock();
            let image = state.image();
            let overrides = image.feed_overrides();
            (0..)
                .zip(overrides)
                .map(|(system, percent)| match percent {
                    0.0 => image.feed_override_before_hold(system),
                    _ => None,
                })
                .collect()
        };
        self.override_each(|system| held.get(system).copied().flatten())
    }

    /// Stops everything that moves, every axis by itself. It cannot be refused, and waits for nothing: neither for a lock nor behind
    /// other commands. What was sent before and is executed later is stopped as soon as it is.
    pub fn stop_all(&self) {
        self.0.stops.stop_all();
    }

    fn override_each(&self, percent: impl Fn(usize) -> Option<f32>) -> bool {
        let mut all = true;
        {
            let mut state = self.0.lock();
            state.refresh();
            for system in 0..self.0.machine.systems.len() {
                let (Some(percent), Ok(place)) = (percent(system), u16::try_from(system)) else {
                    continue;
                };
                all &= state.image_mut().set_feed_override(place, percent).is_ok();
            }
            state.send_overrides();
        }
        self.0.sent.notify_one();
        all
    }
}

/// Looks at the lock: some microseconds, as long as it is held by somebody who runs.
const LOOKS: usize = 1000;
