//! One value with many receivers, each of which waits for changes and sees the newest: [`tokio::sync::watch`], but the receivers wake in
//! the order in which they began to wait. Those of tokio wake in a random order, and a run of the server could not be repeated.

use std::fmt;
use std::ops::Deref;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use tokio::sync::Notify;

/// A channel that begins with a value.
pub(crate) fn channel<T>(value: T) -> (Sender<T>, Receiver<T>) {
    let sender = Sender::new(value);
    let receiver = sender.subscribe();
    (sender, receiver)
}

/// The end that changes the value.
pub(crate) struct Sender<T>(Arc<Shared<T>>);

/// An end that sees the value.
pub(crate) struct Receiver<T> {
    shared: Arc<Shared<T>>,
    /// The number of the last change that it has seen.
    seen: u64,
}

/// The sender has gone.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) struct Closed;

/// The value as it is; all else that is done with the channel waits until it is dropped.
pub(crate) struct Ref<'a, T>(MutexGuard<'a, State<T>>);

struct Shared<T> {
    state: Mutex<State<T>>,
    changed: Notify,
}

struct State<T> {
    value: T,
    /// The number of the last change.
    change: u64,
    receivers: usize,
    is_closed: bool,
}

impl<T> Shared<T> {
    fn lock(&self) -> MutexGuard<'_, State<T>> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl<T> Sender<T> {
    /// Begins with a value.
    pub(crate) fn new(value: T) -> Self {
        let state = State {
            value,
            change: 0,
            receivers: 0,
            is_closed: false,
        };
        Self(Arc::new(Shared {
            state: Mutex::new(state),
            changed: Notify::new(),
        }))
    }

    /// A receiver to which the value is not new.
    pub(crate) fn subscribe(&self) -> Receiver<T> {
        let mut state = self.0.lock();
        state.receivers += 1;
        Receiver {
            shared: self.0.clone(),
            seen: state.change,
        }
    }

    /// The number of receivers.
    pub(crate) fn receiver_count(&self) -> usize {
        self.0.lock().receivers
    }

    /// The value.
    pub(crate) fn borrow(&self) -> Ref<'_, T> {
        Ref(self.0.lock())
    }

    /// Sets the value.
    pub(crate) fn send_replace(&self, value: T) {
        self.send_modify(|old| *old = value);
    }

    /// Changes the value.
    pub(crate) fn send_modify(&self, modify: impl FnOnce(&mut T)) {
        self.send_if_modified(|value| {
            modify(value);
            true
        });
    }

    /// Changes the value; the receivers wake if `modify` returns true.
    pub(crate) fn send_if_modified(&self, modify: impl FnOnce(&mut T) -> bool) {
        let mut state = self.0.lock();
        if modify(&mut state.value) {
            state.change += 1;
            drop(state);
            self.0.changed.notify_waiters();
        }
    }
}

impl<T: Default> Default for Sender<T> {
    fn default() -> Self {
        Self::new(T::default())
    }
}

impl<T> Drop for Sender<T> {
    fn drop(&mut self) {
        self.0.lock().is_closed = true;
        self.0.changed.notify_waiters();
    }
}

impl<T> Receiver<T> {
    /// The value.
    pub(crate) fn borrow(&self) -> Ref<'_, T> {
        Ref(self.shared.lock())
    }

    /// The value, which is seen then.
    pub(crate) fn borrow_and_update(&mut self) -> Ref<'_, T> {
        let state = self.shared.lock();
        self.seen = state.change;
        Ref(state)
    }

    /// Whether there is a change that it has not seen.
    pub(crate) fn has_changed(&self) -> bool {
        self.shared.lock().change != self.seen
    }

    /// The value is new to it, whether or not it has seen it.
    pub(crate) fn mark_changed(&mut self) {
        // No change has this number.
        self.seen = u64::MAX;
    }

    /// Waits for a change that it has not seen, and has seen it then.
    ///
    /// A caller that drops it before it is ready misses nothing.
    pub(crate) async fn changed(&mut self) -> Result<(), Closed> {
        loop {
            // Made before the look, so that no change between them is missed.
            let changed = self.shared.changed.notified();
            {
                let state = self.shared.lock();
                if state.change != self.seen {
                    self.seen = state.change;
                    return Ok(());
                }
                if state.is_closed {
                    return Err(Closed);
                }
            }
            changed.await;
        }
    }
}

impl<T> Clone for Receiver<T> {
    fn clone(&self) -> Self {
        self.shared.lock().receivers += 1;
        Self {
            shared: self.shared.clone(),
            seen: self.seen,
        }
    }
}

impl<T> Drop for Receiver<T> {
    fn drop(&mut self) {
        self.shared.lock().receivers -= 1;
    }
}

impl<T> Deref for Ref<'_, T> {
    type Target = T;

    fn deref(&self) -> &T {
        &self.0.value
    }
}

impl<T: fmt::Debug> fmt::Debug for Sender<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("Sender").field(&self.0.lock().value).finish()
    }
}

impl<T: fmt::Debug> fmt::Debug for Receiver<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("Receiver").field(&self.shared.lock().value).finish()
    }
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc;

    use super::*;

    #[tokio::test]
    async fn receivers_wake_in_the_order_in_which_they_waited() {
        let sender = Sender::new(0);
        let (woken, order) = mpsc::channel();
        let tasks: Vec<_> = (0..40)
            .map(|number| {
                let (mut receiver, woken) = (sender.subscribe(), woken.clone());
                tokio::spawn(async move {
                    while receiver.changed().await.is_ok() {
                        woken.send((*receiver.borrow(), number)).expect("it is read");
                    }
                })
            })
            .collect();
        for value in 1..=3 {
            tokio::task::yield_now().await;
            sender.send_replace(value);
        }
        tokio::task::yield_now().await;
        drop(sender);
        for task in tasks {
            task.await.expect("it ends");
        }
        drop(woken);
        let expected: Vec<_> = (1..=3)
            .flat_map(|value| (0..40).map(move |number| (value, number)))
            .collect();
        assert_eq!(order.iter().collect::<Vec<_>>(), expected);
    }

    #[tokio::test]
    async fn a_receiver_sees_the_newest_value_once() {
        let (sender, mut receiver) = channel("first");
        assert_eq!((sender.receiver_count(), receiver.has_changed()), (1, false));
        sender.send_replace("second");
        sender.send_replace("third");
        assert!(receiver.has_changed());
        assert_eq!(receiver.changed().await, Ok(()));
        assert_eq!(*receiver.borrow(), "third");
        assert!(!receiver.has_changed());
        sender.send_if_modified(|_| false);
        assert!(!receiver.has_changed());
        receiver.mark_changed();
        let copy = receiver.clone();
        assert_eq!(*receiver.borrow_and_update(), "third");
        assert!(!receiver.has_changed());
        assert_eq!((copy.has_changed(), sender.receiver_count()), (true, 2));
        drop(copy);
        assert_eq!(sender.receiver_count(), 1);
    }

    #[tokio::test]
    async fn the_last_change_is_seen_before_the_end() {
        let (sender, mut receiver) = channel(1);
        sender.send_replace(2);
        drop(sender);
        assert_eq!(receiver.changed().await, Ok(()));
        assert_eq!(receiver.changed().await, Err(Closed));
        assert_eq!(*receiver.borrow(), 2);
    }

    #[tokio::test]
    async fn a_wait_that_is_dropped_misses_nothing() {
        let (sender, mut receiver) = channel(1);
        tokio::select! {
            biased;
            _ = receiver.changed() => unreachable!("nothing has changed"),
            () = std::future::ready(()) => {}
        }
        sender.send_replace(2);
        assert_eq!(receiver.changed().await, Ok(()));
    }
}
