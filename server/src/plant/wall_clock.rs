//! The wall clock: the system's, or that of a simulation. Only dates of events come from it: nothing waits for it.

use std::time::SystemTime;

/// The clock of the dates of events.
#[derive(Clone, Copy, Debug)]
pub(crate) struct WallClock(pub(crate) fn() -> SystemTime);

impl WallClock {
    /// The date.
    pub(crate) fn now(self) -> SystemTime {
        (self.0)()
    }
}

impl Default for WallClock {
    fn default() -> Self {
        WallClock(SystemTime::now)
    }
}
