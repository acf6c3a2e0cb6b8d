//! The server without threads: the tick, the contour planner, the writer of the retained state and the trace are steps that the caller
//! makes, and the listener, the page and the tasks beside the plant run on the runtime of the caller, whose clock may be paused. A simulation
//! (`tests/sim`) drives the server so, from a seed.
//!
//! This module makes no decisions: each step is the one that a thread of the program makes in its loop.

use std::net::SocketAddr;
use std::path::PathBuf;
use std::sync::mpsc::Receiver;
use std::time::{Duration, SystemTime};

use arcline_config::Project;
use arcline_controller::{Controller, Snapshot};
pub use arcline_realtime::{FullRings, Room};
use arcline_realtime::{Planning, Rings};
use arcline_state::{Disk, Ended, LockedFile, Pace, Task};

use crate::audit::{Audit, Event};
pub use crate::eip::Datagrams;
use crate::eip::Settings;
use crate::eip::stepped::SteppedInterface;
pub use crate::eip::stepped::{Duplex, Held};
use crate::hmi::stepped::SteppedPage;
use crate::plant::Plant;
use crate::plant::wall_clock::WallClock;
use crate::retained::{Job, SteppedState, Turn, WriterWorker};

/// A server whose loops the caller runs. Dropped together with its runtime, it is a server that was killed.
#[derive(Debug)]
pub struct Stepped<D: Disk> {
    plant: Plant,
    controller: Controller,
    rings: Rings,
    planning: Option<Planning>,
    worker: Option<WriterWorker<D>>,
    interface: SteppedInterface,
    page: SteppedPage,
    audit: Receiver<Option<Event>>,
    /// Changes of instructions and faults that the ticks have reported.
    reported: u64,
}

/// Changes of instructions and faults.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Changes {
    /// As the ticks have reported them.
    pub reported: u64,
    /// As the plant has logged them.
    pub logged: u64,
}

/// The settings of a stepped server beside its project.
#[derive(Clone, Copy, Debug)]
pub struct Conditions {
    /// The room in the rings to and from the tick.
    pub room: Room,
    /// The number of the first tick.
    pub first_tick: u64,
    /// The clock on the wall.
    pub wall: fn() -> SystemTime,
}

/// The conditions of the program itself.
impl Default for Conditions {
    fn default() -> Self {
        Conditions {
            room: Room::default(),
            first_tick: 0,
            wall: WallClock::default().0,
        }
    }
}

/// An event that the audit makes a line of (spec/security.md §9).
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Audited {
    /// The kind: the word of its line.
    pub kind: String,
    /// The client's address.
    pub from: String,
    /// The tag, or the instruction with its target.
    pub object: String,
    /// The value written, hexadecimal; empty if the event is not a write.
    pub new: String,
    /// `done`, or the reason for the refusal.
    pub result: &'static str,
}

/// The reason for which a server does not start.
#[derive(Debug, thiserror::Error)]
#[error("the server does not start: {0}")]
pub struct StartError(String);

impl<D: Disk> Stepped<D> {
    /// Starts the server of a project with the state of a file on a disk, to which it writes at a pace; `None`: the state is not stored.
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
        conditions: Conditions,
    ) -> Result<Self, StartError> {
        let failed = |error: &dyn std::fmt::Display| StartError(error.to_string());
        let state = match disk {
            Some((disk, file, pace)) => {
                let locked = LockedFile::lock_on(disk, file).map_err(|error| failed(&error))?;
                Some(SteppedState::open(locked, pace, &mut project).map_err(|error| failed(&error))?)
            }
            None => None,
        };
        let (image, watch, worker) = match state {
            Some(SteppedState { image, watch, worker }) => (image, Some(watch), Some(worker)),
            None => (project.image(), None, None),
        };
        let (rings, mut link) = arcline_realtime::rings_with(&project.machine, conditions.room);
        let planning = link.planning.take();
        let plant = Plant::start_stepped(&project, link, image, watch, WallClock(conditions.wall));
        let (audit, events) = Audit::stepped();
        plant.set_audit(audit);
        let interface = SteppedInterface::start(plant.clone(), settings).map_err(|error| failed(&error))?;
        let page = SteppedPage::start(plant.clone());
        Ok(Stepped {
            plant,
            controller: Controller::new(&project.machine).starting_at(conditions.first_tick),
            rings: rings.starting_at(conditions.first_tick),
            planning,
            worker,
            interface,
            page,
            audit: events,
            reported: 0,
        })
    }

    /// The running machine.
    pub fn plant(&self) -> &Plant {
        &self.plant
    }

    /// Runs one tick. `see` gets its snapshot.
    pub fn tick(&mut self, see: &mut dyn FnMut(&Snapshot)) {
        self.reported += arcline_realtime::step_seen(&mut self.controller, &mut self.rings, see);
    }

    /// The rings that have no more room.
    pub fn full_rings(&self) -> FullRings {
        self.rings.full()
    }

    /// Changes of instructions and faults that the ticks have reported, and those of them that the plant has logged.
    pub fn changes(&self) -> Changes {
        let newest = |_: &_, _: &_, events: Vec<crate::plant::Logged>| events.last().map_or(0, |logged| logged.number);
        Changes {
            reported: self.reported,
            logged: self.plant.events_since(0, newest),
        }
    }

    /// Makes one turn of the contour planner. Returns whether there was a request.
    pub fn plan(&mut self) -> bool {
        self.planning.as_mut().is_some_and(Planning::step)
    }

    /// Makes one turn of the trace.
    pub fn trace(&self) {
        self.plant.trace().step();
    }

    /// Makes one turn of implicit I/O, on the clock of the runtime of [`Stepped::start`], which the caller has entered.
    pub fn exchange(&mut self) {
        self.interface.exchange();
    }

    /// Makes one turn of the writer of the retained state, at a time since the start, with the end of a synchronisation. Returns the next
    /// synchronisation, which takes as long as the caller likes.
    pub fn step_writer(&mut self, ended: Option<Ended>, now: Duration) -> Option<Task<D>> {
        let worker = self.worker.as_mut()?;
        let turn = match ended {
            Some(ended) => worker.turn(Some(Job::Ended(ended)), now),
            None => worker.step(now),
        };
        match turn {
            Turn::Synchronise(task) => Some(task),
            Turn::Idle | Turn::Closed(_) => None,
        }
    }

    /// The events of the audit since the last call.
    pub fn audited(&self) -> impl Iterator<Item = Audited> {
        self.audit.try_iter().flatten().map(|event| Audited {
            kind: serde_json::to_value(event.kind)
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
        self.interface.connect(Ok((stream, peer)));
    }

    /// The system refuses to accept the next client.
    pub fn refuse(&self, error: std::io::Error) {
        self.interface.connect(Err(error));
    }

    /// A browser comes in from an address, to the page.
    pub fn browse(&self, stream: Box<dyn Duplex>, peer: SocketAddr) {
        self.page.connect((stream, peer));
    }

    /// The number of clients and connections of the server.
    pub fn held(&self) -> Held {
        Held {
            browsers: self.page.browsers(),
            ..self.interface.held()
        }
    }
}
