//! Ticks that pass because a client says so: the step clock (spec/contract.md §10).

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use arcline_realtime::Steps;
use arcline_tag::TagPath;
use tokio::sync::oneshot;

use super::{Plant, Principal, Shared};

impl Plant {
    /// Lets ticks pass for a principal as long as its client is there ([`Signs::leave`](crate::guard::Signs::leave)), see [`Plant::step`].
    pub(super) async fn step_for(&self, principal: Principal, ticks: u32, until: Option<TagPath>) {
        let left = principal.session().and_then(|session| self.0.guard.left(session));
        let steps = self.step(ticks, until);
        match left {
            Some(left) => left.run_until_cancelled(steps).await,
            None => Some(steps.await),
        };
    }

    /// Lets ticks pass, `ticks` at most, until a tag is not 0; the present tick counts too. Others step when this is done, or dropped, which ends
    /// the steps at the present tick. Returns the number of ticks that have passed: 0 where the clock is not stepped.
    async fn step(&self, ticks: u32, until: Option<TagPath>) -> u32 {
        let Some(stepper) = &self.0.stepper else { return 0 };
        let _turn = self.0.step_turn.lock().await;
        // Dropped before the turn.
        let waits = Waits::default();
        let (done, passed) = oneshot::channel();
        let shared = Arc::downgrade(&self.0);
        stepper.step(Steps {
            ticks,
            until: until.map(|path| {
                let until = move || {
                    shared
                        .upgrade()
                        .is_none_or(|shared: Arc<Shared>| is_true(&shared, &path))
                };
                Box::new(until) as Box<dyn FnMut() -> bool + Send>
            }),
            abandoned: waits.0.clone(),
            // The client may have gone.
            done: Box::new(|passed| {
                let _ = done.send(passed);
            }),
        });
        passed.await.unwrap_or(0)
    }
}

/// Abandons steps when it is dropped.
#[derive(Default)]
struct Waits(Arc<AtomicBool>);

impl Drop for Waits {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Release);
    }
}

/// Whether a tag is not 0 at the present tick; a deleted tag ends the steps too.
fn is_true(shared: &Shared, path: &TagPath) -> bool {
    let mut state = shared.lock();
    state.refresh();
    state.image().read(path).map_or(true, |value| value.as_bool())
}
