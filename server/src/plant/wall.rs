//! The clock on the wall: the system's, or that of a simulation. Only dates of events come from it: nothing waits for it.

use std::time::SystemTime;

/// A clock on a wall.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Wall(pub(crate) fn() -> SystemTime);

impl Wall {
    /// The date.
    pub(crate) fn now(self) -> SystemTime {
        (self.0)()
    }
}

impl Default for Wall {
    fn default() -> Self {
        Wall(SystemTime::now)
    }
}
