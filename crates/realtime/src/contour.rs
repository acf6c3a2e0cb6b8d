//! Planning contours beside the real-time thread: requests out, trajectories in, old ones out to be freed.
//!
//! A request is a buffer in circulation: the tick fills it, and the planning thread reads it and returns it empty, so neither side allocates one
//! during motion.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use arcline_controller::machine::{CoordinateSystem, Machine};
use arcline_controller::{ContourRequest, PlannedContour, Trajectory};

/// Requests under way at once.
const REQUESTS: usize = 2;
/// Most trajectories that can wait to be taken or freed.
const TRAJECTORIES: usize = 64;
/// The interval at which the planning thread polls for work: the tick must not wake it.
const PAUSE: Duration = Duration::from_millis(1);

/// The controller's ends.
#[derive(Debug)]
pub(crate) struct Contours {
    free: rtrb::Consumer<Box<ContourRequest>>,
    asked: rtrb::Producer<Box<ContourRequest>>,
    planned: rtrb::Consumer<PlannedContour>,
    retired: rtrb::Producer<Arc<Trajectory>>,
    filling: Option<Box<ContourRequest>>,
}

/// The planning thread's ends.
#[derive(Debug)]
pub struct Planning {
    free: rtrb::Producer<Box<ContourRequest>>,
    asked: rtrb::Consumer<Box<ContourRequest>>,
    planned: rtrb::Producer<PlannedContour>,
    retired: rtrb::Consumer<Arc<Trajectory>>,
}

/// Both ends, if the machine has a coordinate system with planned contours.
pub(crate) fn link(machine: &Machine) -> Option<(Contours, Planning)> {
    if !machine.systems.iter().any(CoordinateSystem::plans_contours) {
        return None;
    }
    let (mut free, empty) = rtrb::RingBuffer::new(REQUESTS);
    let (asked, requests) = rtrb::RingBuffer::new(REQUESTS);
    let (planned, plans) = rtrb::RingBuffer::new(TRAJECTORIES);
    let (retired, old) = rtrb::RingBuffer::new(TRAJECTORIES);
    for _ in 0..REQUESTS {
        // The ring has room for all requests.
        let _ = free.push(Box::new(ContourRequest::new()));
    }
    let contours = Contours {
        free: empty,
        asked,
        planned: plans,
        retired,
        filling: None,
    };
    let planning = Planning {
        free,
        asked: requests,
        planned,
        retired: old,
    };
    Some((contours, planning))
}

impl Contours {
    pub(crate) fn request(&mut self) -> Option<&mut ContourRequest> {
        if self.filling.is_none() {
            self.filling = self.free.pop().ok();
        }
        self.filling.as_deref_mut()
    }

    pub(crate) fn submit(&mut self) {
        if let Some(request) = self.filling.take() {
            // The ring has room for all requests.
            let _ = self.asked.push(request);
        }
    }

    pub(crate) fn planned(&mut self) -> Option<PlannedContour> {
        self.planned.pop().ok()
    }

    pub(crate) fn retire(&mut self, trajectory: Arc<Trajectory>) -> Result<(), Arc<Trajectory>> {
        self.retired
            .push(trajectory)
            .map_err(|rtrb::PushError::Full(trajectory)| trajectory)
    }
}

impl Planning {
    /// Plans one request, if one waits, and frees retired trajectories. Returns true if there was a request.
    pub fn step(&mut self) -> bool {
        while self.retired.pop().is_ok() {}
        let Ok(mut request) = self.asked.pop() else {
            return false;
        };
        let planned = PlannedContour {
            system: request.system,
            generation: request.generation,
            trajectory: request.plan(),
        };
        // Each system has at most one plan under way, so there is room for it and for the empty request.
        let _ = self.planned.push(planned);
        let _ = self.free.push(request);
        true
    }

    pub(crate) fn run(&mut self, over: &AtomicBool) {
        while !over.load(Ordering::Acquire) {
            if !self.step() {
                std::thread::sleep(PAUSE);
            }
        }
    }
}
