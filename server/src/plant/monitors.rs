//! The rungs or lines of the controller's program that viewers watch: each viewer watches one routine. The thread of the program samples them
//! between two scans; while no viewer watches, a scan only reads one counter.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

use arcline_routine::{Monitor, MonitorSample};

use super::control::ViewerId;
use crate::watch;

/// The rungs or lines that one viewer watches.
#[derive(Debug)]
pub(crate) struct ViewerMonitor {
    /// The version of the program that it was compiled for.
    pub(crate) version: u64,
    /// Its operands.
    pub(crate) monitor: Monitor,
    /// The newest samples.
    pub(crate) samples: watch::Sender<Vec<MonitorSample>>,
}

/// The rungs and lines that all viewers watch.
#[derive(Debug, Default)]
pub(crate) struct Monitors {
    all: Mutex<BTreeMap<ViewerId, ViewerMonitor>>,
    changes: AtomicU64,
}

impl Monitors {
    /// Makes a viewer watch these rungs or lines in place of its earlier ones. The samples come as they change.
    pub(crate) fn begin(
        &self,
        viewer: ViewerId,
        version: u64,
        monitor: Monitor,
    ) -> watch::Receiver<Vec<MonitorSample>> {
        let samples = watch::Sender::new(Vec::new());
        let receiver = samples.subscribe();
        let viewer_monitor = ViewerMonitor {
            version,
            monitor,
            samples,
        };
        self.lock().insert(viewer, viewer_monitor);
        self.changes.fetch_add(1, Ordering::AcqRel);
        receiver
    }

    /// A viewer stops watching.
    pub(crate) fn end(&self, viewer: ViewerId) {
        if self.lock().remove(&viewer).is_some() {
            self.changes.fetch_add(1, Ordering::AcqRel);
        }
    }

    /// Another number for other monitors.
    pub(crate) fn changes(&self) -> u64 {
        self.changes.load(Ordering::Acquire)
    }

    /// All of them.
    pub(crate) fn lock(&self) -> MutexGuard<'_, BTreeMap<ViewerId, ViewerMonitor>> {
        self.all.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
