//! The server without threads: the tick, the contour planner, the writer of the retained state and the trace are steps that the caller
//! makes, and the listener and the tasks beside the plant run on the runtime of the caller, whose clock may be paused. A simulation
//! (`tests/sim`) drives the server so, from a seed.
//!
//! Nothing here decides anything: each step is the one that a thread of the program makes in its loop.

use std::net::SocketAddr;
use std::path::PathBuf;
use std::sync::mpsc::Receiver;
use std::time::Duration;

use arcline_config::Project;
use arcline_controller::{Controller, Snapshot};
use arcline_realtime::{Planning, Rings};
use arcline_state::{Disk, Ended, LockedFile, Pace, Task};

use crate::audit::{Audit, Event};
pub use crate::eip::Datagrams;
use crate::eip::Settings;
use crate::eip::stepped::SteppedFace;
pub use crate::eip::stepped::{Duplex, Held};
use crate::plant::Plant;
use crate::retained::{Job, Keeper, SteppedState, Turn};

/// A server whose loops the caller runs. Dropped together with its runtime, it is a server that was killed.
#[derive(Debug)]
pub struct Stepped<D: Disk> {
    plant: Plant,
    controller: Controller,
    rings: Rings,
    planning: Option<Planning>,
    keeper: Option<Keeper<D>>,
    face: SteppedFace,
    audit: Receiver<Option<Event>>,
}

/// An event that the audit makes a line of (spec/security.md §9).
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Audited {
    /// Its kind, the word of its line.
    pub what: String,
    /// The client's address.
    pub from: String,
    /// The tag, or the instruction with its target.
    pub object: String,
    /// The value written, hexadecimal; empty for what is no write.
    pub new: String,
    /// `done`, or why not.
    pub result: &'static str,
}

/// Why a server does not start.
#[derive(Debug, thiserror::Error)]
#[error("the server does not start: {0}")]
pub struct StartError(String);

impl<D: Disk> Stepped<D> {
    /// Starts the server of a project with the state of a file on a disk, which it keeps there at a pace; `None`: nothing is kept.
    ///
    /// # Errors
    /// The disk cannot be used.
    ///
    /// # Panics
    /// Outside of a tokio runtime.
    pub fn start(
        mut project: Project,
        disk: Option<(D, PathBuf, Pace)>,
        settings: Settings,
    ) -> Result<Self, StartError> {
        let failed = |error: &dyn std::fmt::Display| StartError(error.to_string());
        let state = match disk {
            Some((disk, file, pace)) => {
                let locked = LockedFile::lock_on(disk, file).map_err(|error| failed(&error))?;
                Some(SteppedState::open(locked, pace, &mut project).map_err(|error| failed(&error))?)
            }
            None => None,
        };
        let (image, watch, keeper) = match state {
            Some(SteppedState { image, watch, keeper }) => (image, Some(watch), Some(keeper)),
            None => (project.image(), None, None),
        };
        let (rings, mut link) = arcline_realtime::link(&project.machine);
        let planning = link.planning.take();
        let plant = Plant::start_stepped(&project, link, image, watch);
        let (audit, events) = Audit::stepped();
        plant.set_audit(audit);
        let face = SteppedFace::start(plant.clone(), settings).map_err(|error| failed(&error))?;
        Ok(Stepped {
            plant,
            controller: Controller::new(&project.machine),
            rings,
            planning,
            keeper,
            face,
            audit: events,
        })
    }

    /// The running machine.
    pub fn plant(&self) -> &Plant {
        &self.plant
    }

    /// One tick. `see` gets its snapshot.
    pub fn tick(&mut self, see: &mut dyn FnMut(&Snapshot)) {
        arcline_realtime::step_seen(&mut self.controller, &mut self.rings, see);
    }

    /// One turn of the contour planner. Whether there was a request.
    pub fn plan(&mut self) -> bool {
        self.planning.as_mut().is_some_and(Planning::step)
    }

    /// One turn of the trace.
    pub fn trace(&self) {
        self.plant.trace().step();
    }

    /// One turn of implicit I/O. On the clock of the runtime of [`Stepped::start`], which the caller has entered.
    pub fn exchange(&mut self) {
        self.face.exchange();
    }

    /// One turn of the writer of the retained state, at a time since the start, with the end of a synchronisation. Returns the next
    /// synchronisation, which takes as long as the caller likes.
    pub fn keep(&mut self, ended: Option<Ended>, now: Duration) -> Option<Task<D>> {
        let keeper = self.keeper.as_mut()?;
        let turn = match ended {
            Some(ended) => keeper.turn(Some(Job::Ended(ended)), now),
            None => keeper.step(now),
        };
        match turn {
            Turn::Synchronise(task) => Some(task),
            Turn::Idle | Turn::Closed(_) => None,
        }
    }

    /// The events of the audit since the last call.
    pub fn audited(&self) -> impl Iterator<Item = Audited> {
        self.audit.try_iter().flatten().map(|event| Audited {
            what: serde_json::to_value(event.what)
                .ok()
                .and_then(|word| word.as_str().map(str::to_owned))
                .unwrap_or_default(),
            from: event.from.to_string(),
            object: event.object,
            new: event.values.map(|(_, new)| new).unwrap_or_default(),
            result: event.result,
        })
    }

    /// A client comes in from an address.
    pub fn connect(&self, stream: Box<dyn Duplex>, peer: SocketAddr) {
        self.face.connect(Ok((stream, peer)));
    }

    /// The system refuses to accept the next client.
    pub fn refuse(&self, error: std::io::Error) {
        self.face.connect(Err(error));
    }

    /// What the server holds of its clients.
    pub fn held(&self) -> Held {
        self.face.held()
    }
}
