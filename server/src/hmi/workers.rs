//! Threads for long work of viewers, so that no other task waits for it.

use std::sync::Arc;

use tokio::sync::Semaphore;
use tokio::task::spawn_blocking;

use super::protocol::Refusal;
use crate::work_threads::WorkThreads;

/// The threads that compute for all viewers, but for simulations and programs.
#[derive(Debug)]
pub(super) struct Workers {
    turns: Arc<Semaphore>,
    threads: WorkThreads,
}

impl Workers {
    pub(super) fn new(threads: WorkThreads) -> Self {
        Workers {
            turns: Arc::new(Semaphore::new(THREADS)),
            threads,
        }
    }

    /// Computes on a thread that nothing else waits for.
    ///
    /// # Errors
    /// It could not be computed.
    pub(super) async fn compute<T: Send + 'static>(
        &self,
        work: impl FnOnce() -> T + Send + 'static,
    ) -> Result<T, Refusal> {
        if self.threads == WorkThreads::Caller {
            return Ok(work());
        }
        // At most one request of each viewer and its watched values wait here.
        let turn = self.turns.clone().acquire_owned().await;
        let computed = spawn_blocking(move || {
            let result = work();
            drop(turn);
            result
        });
        computed
            .await
            .map_err(|_| Refusal::new("the server could not compute the answer"))
    }

    /// As [`Workers::compute`], but on this thread if the computation is short.
    ///
    /// # Errors
    /// As [`Workers::compute`].
    pub(super) async fn compute_if<T: Send + 'static>(
        &self,
        is_long: bool,
        work: impl FnOnce() -> T + Send + 'static,
    ) -> Result<T, Refusal> {
        if is_long { self.compute(work).await } else { Ok(work()) }
    }
}

const THREADS: usize = 2;
