//! The stream of changes: which tags have changed, step by step, for readers that would otherwise poll.
//!
//! A step is one publication of the tag memory in which tags have changed, at most one a tick but for writes. The log has only the number of
//! each tag's last step, so the number of tags bounds it. A reader takes all steps since its last read at once: a slow one gets their number
//! ([`TagChanges::steps`]) and delays no other reader. Values are not here; a reader reads those that it wants.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use arcline_controller::image::{Image, TagId};

use super::Plant;
use crate::watch;

/// The last steps of all tags. It is empty while there are no readers.
#[derive(Debug, Default)]
pub(super) struct ChangeLog {
    /// The number of the newest step.
    newest: watch::Sender<u64>,
    tags: Arc<Mutex<Steps>>,
}

#[derive(Debug, Default)]
struct Steps {
    /// The number of the newest step.
    newest: u64,
    /// The tick that it shows.
    tick: u64,
    /// The number of the last step in which a tag changed, came or went.
    of: BTreeMap<TagId, u64>,
}

/// The changes of tags since a reader's last look.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct TagChanges {
    /// The tick that the tags show now.
    pub tick: u64,
    /// The steps that were taken together; more than 1: values between them were missed.
    pub steps: u64,
    /// The tags that have changed, came or went, ascending.
    pub tags: Vec<TagId>,
}

impl TagChanges {
    /// Whether a tag has changed.
    pub fn has(&self, tag: TagId) -> bool {
        self.tags.binary_search(&tag).is_ok()
    }
}

/// A reader of the stream of changes, from [`Plant::changes`].
#[derive(Debug)]
pub struct Changes {
    newest: watch::Receiver<u64>,
    tags: Arc<Mutex<Steps>>,
    /// The number of the last step that was taken.
    taken: u64,
}

impl ChangeLog {
    /// Notes the differences of two publications, if there is a reader.
    pub(super) fn note(&self, before: &Image, now: &Image) {
        let mut steps = lock(&self.tags);
        if self.newest.receiver_count() == 0 {
            steps.of.clear();
            return;
        }
        let number = steps.newest + 1;
        steps.tick = now.snapshot_tick();
        now.for_each_change(before, |tag| {
            steps.newest = number;
            steps.of.insert(tag, number);
        });
        let is_step = steps.newest == number;
        drop(steps);
        if is_step {
            self.newest.send_replace(number);
        }
    }

    fn read(&self) -> Changes {
        let newest = self.newest.subscribe();
        let taken = lock(&self.tags).newest;
        Changes {
            newest,
            tags: self.tags.clone(),
            taken,
        }
    }
}

impl Changes {
    /// Waits for changes after those that were taken last, and takes all there are. `None`: the plant has gone.
    ///
    /// A caller that drops it before it is ready misses nothing.
    pub async fn next(&mut self) -> Option<TagChanges> {
        let taken = self.taken;
        while *self.newest.borrow_and_update() <= taken {
            self.newest.changed().await.ok()?;
        }
        let steps = lock(&self.tags);
        self.taken = steps.newest;
        let changed = steps.of.iter().filter(|(_, number)| **number > taken);
        Some(TagChanges {
            tick: steps.tick,
            steps: steps.newest - taken,
            tags: changed.map(|(tag, _)| *tag).collect(),
        })
    }
}

impl Plant {
    /// The stream of changes from now on. Reads of the tags after this call, together with the stream, miss no change.
    pub fn changes(&self) -> Changes {
        // A lock keeps the call out of the middle of a publication.
        let _held = self.0.lock();
        self.0.published.changes.read()
    }
}

fn lock(steps: &Mutex<Steps>) -> MutexGuard<'_, Steps> {
    steps.lock().unwrap_or_else(PoisonError::into_inner)
}
