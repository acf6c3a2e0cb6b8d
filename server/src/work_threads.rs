//! The threads for work that no task of the network should wait for.

use tokio::task::spawn_blocking;

/// The threads that do long work.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum WorkThreads {
    /// Threads beside the runtime.
    Pool,
    /// On the thread of the caller, in order: a simulation has no other one.
    Caller,
}

impl WorkThreads {
    /// Does the work of a future that may compute for long.
    pub(crate) fn run(self, work: impl Future<Output = ()> + Send + 'static) {
        let runtime = tokio::runtime::Handle::current();
        match self {
            Self::Pool => drop(spawn_blocking(move || runtime.block_on(work))),
            Self::Caller => drop(runtime.spawn(work)),
        }
    }

    /// Does work whose end nothing waits for.
    pub(crate) fn run_beside(self, work: impl FnOnce() + Send + 'static) {
        match self {
            Self::Pool => drop(spawn_blocking(work)),
            Self::Caller => work(),
        }
    }
}
