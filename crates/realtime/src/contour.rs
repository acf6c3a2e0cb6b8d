//! Planning contours beside the real-time thread: requests out, trajectories in, old ones out to be freed.
//!
//! A request is a buffer in circulation: the tick fills it, and the planning thread reads it and returns it empty, so neither side allocates one
//! during motion.

use std::panic::{AssertUnwindSafe, catch_unwind};
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
        self.step_with(ContourRequest::plan)
    }

    fn step_with(&mut self, plan: impl FnOnce(&mut ContourRequest) -> Option<Arc<Trajectory>>) -> bool {
        while self.retired.pop().is_ok() {}
        let Ok(mut request) = self.asked.pop() else {
            return false;
        };
        let planned = PlannedContour {
            system: request.system,
            generation: request.generation,
            trajectory: planned(&mut request, plan),
        };
        // Each system has at most one plan under way, so there is room for it and for the empty request.
        let _ = self.planned.push(planned);
        let _ = self.free.push(request);
        true
    }

    /// Plans until the end. A plan that panics is a defect of the planner; the motion goes on without it.
    pub(crate) fn run(&mut self, over: &AtomicBool) {
        while !over.load(Ordering::Acquire) {
            if !self.step() {
                std::thread::sleep(PAUSE);
            }
        }
    }
}

/// A plan. If it panics, a contour in execution is not extended, and one from rest stops at each joint; without either, the motion would wait for a
/// plan for ever.
fn planned(
    request: &mut ContourRequest,
    plan: impl FnOnce(&mut ContourRequest) -> Option<Arc<Trajectory>>,
) -> Option<Arc<Trajectory>> {
    let from_rest = request.extends.is_none();
    let moves = request.moves.len();
    let whole = catch_unwind(AssertUnwindSafe(|| plan(request)));
    whole.unwrap_or_else(|_| {
        tracing::error!(
            moves,
            from_rest,
            "a plan of a contour panicked, which is a defect of the planner"
        );
        let stops = from_rest.then(|| catch_unwind(AssertUnwindSafe(|| request.plan_with_stops())));
        stops.and_then(Result::ok)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use arcline_contour::{ContourMove, Deviation, Path, Point};
    use arcline_controller::machine::{Axis, AxisKind, Corner, MotionGroup};
    use arcline_instruction_set::AxisId;

    #[test]
    fn a_plan_that_panics_stops_at_each_joint_and_the_next_one_is_planned() {
        let axes = ["X", "Y"].map(|name| Axis::new(name, AxisKind::Virtual, 500.0, 5000.0));
        let mut system = CoordinateSystem::new("CS", &[AxisId(0), AxisId(1)], 500.0, 5000.0);
        system.corner = Corner::Precise;
        let machine = Machine::new(MotionGroup::new(axes.to_vec(), vec![system]));
        let (mut contours, mut planning) = link(&machine).expect("planned contours");
        let ends = [[0.0, 0.0], [10.0, 0.0], [10.0, 10.0]].map(|[x, y]| Point::new(x, y, 0.0));
        let moves = ends.windows(2).map(|pair| ContourMove {
            path: Path::line(pair[0], pair[1]),
            speed: 100.0,
            acceleration: 1000.0,
            deceleration: 1000.0,
            jerk: None,
            tolerance: 1.0,
            deviation: Deviation::default(),
        });
        let mut duration = |plan: fn(&mut ContourRequest) -> Option<Arc<Trajectory>>| {
            let request = contours.request().expect("an empty request");
            request.moves.clear();
            request.moves.extend(moves.clone());
            request.limits.speed = Point::repeat(500.0);
            request.limits.acceleration = Point::repeat(5000.0);
            contours.submit();
            assert!(planning.step_with(plan));
            let planned = contours.planned().expect("a plan").trajectory.expect("a trajectory");
            assert_eq!(planned.moves(), 2);
            planned.duration()
        };
        // Each move has ramps of 0.1 s and 10 mm.
        let stops = duration(|_| panic!("as a defect would"));
        assert!((stops - 0.4).abs() < 1e-9, "{stops} s");
        assert!(duration(ContourRequest::plan) < 0.99 * stops);
    }
}
