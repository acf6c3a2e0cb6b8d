//! Threads beside, for what viewers ask and takes long: nothing else waits for it.

use std::sync::Arc;

use tokio::sync::Semaphore;

use super::protocol::Refusal;

/// The threads that compute for all viewers, but for simulations and programs.
#[derive(Debug)]
pub(super) struct Workers(Arc<Semaphore>);

impl Default for Workers {
    fn default() -> Self {
        Workers(Arc::new(Semaphore::new(THREADS)))
    }
}

impl Workers {
    /// Computes on a thread that nothing else waits for.
    ///
    /// # Errors
    /// It could not be computed.
    pub(super) async fn compute<T: Send + 'static>(
        &self,
        work: impl FnOnce() -> T + Send + 'static,
    ) -> Result<T, Refusal> {
        // At most one request of each viewer and its watched values wait here.
        let turn = self.0.clone().acquire_owned().await;
        let computed = tokio::task::spawn_blocking(move || {
            let result = work();
            drop(turn);
            result
        });
        computed
            .await
            .map_err(|_| Refusal::new("the server could not compute the answer"))
    }

    /// The same, but on this thread if it is short.
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
