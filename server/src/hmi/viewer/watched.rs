//! The tags whose values a viewer watches: after the first push only those that have changed are pushed.

use std::time::Duration;

use arcline_controller::image::TagId;
use tokio::time::{Instant, sleep_until};

use crate::hmi::tags;
use crate::plant::{Changes, Plant, TagChanges};

/// Shortest time between two pushes of values.
const EVERY: Duration = Duration::from_millis(100);

/// The watched tags of one viewer.
#[derive(Debug)]
pub(super) struct Watched {
    names: Vec<Name>,
    changes: Changes,
    /// When values may be pushed again.
    due: Instant,
}

/// A watched name.
#[derive(Debug)]
struct Name {
    text: String,
    /// The tag that it named at the last push.
    tag: Option<TagId>,
    /// Whether the server has pushed the value.
    is_pushed: bool,
}

impl Watched {
    /// No tags.
    pub(super) fn new(plant: &Plant) -> Self {
        Watched {
            names: Vec::new(),
            changes: plant.changes(),
            due: Instant::now(),
        }
    }

    /// Watches other tags.
    pub(super) fn watch(&mut self, plant: &Plant, names: Vec<String>) {
        let name = |text| Name {
            text,
            tag: None,
            is_pushed: false,
        };
        self.names = names.into_iter().map(name).collect();
        self.changes = plant.changes();
        self.due = Instant::now();
    }

    /// Waits for changes, and until values may be pushed again; for ever, where nothing is watched. `None`: the plant has gone.
    pub(super) async fn changes(&mut self) -> Option<TagChanges> {
        if self.names.is_empty() {
            return std::future::pending().await;
        }
        sleep_until(self.due).await;
        self.changes.next().await
    }

    /// The names whose values are to be pushed now.
    pub(super) fn take(&mut self, plant: &Plant, changes: &TagChanges) -> Vec<String> {
        self.due = Instant::now() + EVERY;
        plant.with_image(|image| {
            let mut names = Vec::new();
            for name in &mut self.names {
                let tag = tags::tag_of(image, &name.text);
                let has_changed = tag != name.tag || tag.is_some_and(|tag| changes.has(tag));
                if has_changed || !name.is_pushed {
                    names.push(name.text.clone());
                }
                (name.tag, name.is_pushed) = (tag, true);
            }
            names
        })
    }
}
