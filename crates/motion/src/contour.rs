//! Coordinate systems that execute their moves as planned contours: the link between the queue of moves and the planning, which runs
//! outside the tick.

use arcline_instruction_set::SystemId;
use std::sync::Arc;

use arcline_contour::{AxisLimits, ContourMove, Trajectory};
use arcline_planner::geometry::Point;
use arcline_planner::{Extension, InstalledPlan, MasterMotion};

use crate::motion::Motion;
use crate::system::Activity;

/// Moves to plan as one contour.
#[derive(Clone, Debug)]
pub struct ContourRequest {
    /// Index of the coordinate system.
    pub system: SystemId,
    /// Distinguishes this request from others of the same system.
    pub generation: u32,
    /// The moves; the last one ends at rest.
    pub moves: Vec<ContourMove>,
    /// The trajectory in execution that they extend; `None`: they start from rest.
    pub extends: Option<Extension>,
    /// The axis limits that the trajectory keeps.
    pub limits: AxisLimits,
}

impl ContourRequest {
    /// Room for the longest queue that can be configured, so that a tick can fill it without allocating.
    pub fn new() -> Self {
        ContourRequest {
            system: SystemId::default(),
            generation: 0,
            moves: Vec::with_capacity(crate::machine::MAX_QUEUE_DEPTH + 1),
            extends: None,
            limits: AxisLimits {
                speed: Point::zeros(),
                acceleration: Point::zeros(),
                jerk: None,
            },
        }
    }

    /// Plans the contour; `None` if the trajectory in execution cannot be extended. Runs outside the tick: its time is not bounded, and it frees
    /// the extension.
    pub fn plan(&mut self) -> Option<Arc<Trajectory>> {
        let planned = match self.extends.take() {
            None => arcline_contour::begin(&self.moves, &self.limits),
            Some(extension) => extension.plan(&self.moves, &self.limits)?,
        };
        Some(Arc::new(planned))
    }

    /// Plans the contour from rest with a stop at each joint. Outside the tick as well.
    #[must_use]
    pub fn plan_with_stops(&self) -> Arc<Trajectory> {
        Arc::new(arcline_contour::plan_with_stops(&self.moves, &self.limits))
    }
}

impl Default for ContourRequest {
    fn default() -> Self {
        Self::new()
    }
}

impl Motion {
    /// Fills a request for the next contour to plan; returns false if there is none. Real-time.
    pub fn next_contour(&mut self, request: &mut ContourRequest) -> bool {
        for (id, system) in self.systems.ids().zip(self.systems.iter_mut()) {
            if system.activity != Activity::Moving {
                continue;
            }
            request.moves.clear();
            let base = system.time_base(&self.clock);
            if let Some(batch) = system.travel.batch(&base, |motion| request.moves.push(motion)) {
                request.system = id;
                request.generation = batch.generation;
                request.extends = batch.extends;
                request.limits = system.axis_limits;
                return true;
            }
        }
        false
    }

    /// Starts a planned contour at the present tick, or extends the one in execution, if the contour is still wanted and in time.
    /// Real-time.
    pub fn install_contour(&mut self, system: SystemId, generation: u32, planned: Option<Arc<Trajectory>>) {
        let id = system;
        let Some(system) = self.systems.get_mut(id) else {
            self.systems.retired.extend(planned);
            return;
        };
        // A contour that starts does so at the displacement 0 of its master.
        let driven_by = system.travel.moves().next().and_then(|first| first.data.driven_by);
        let mut base = system.time_base(&self.clock);
        if driven_by.is_some() && system.follower.is_none() {
            base.master = Some(MasterMotion::default());
        }
        let installed = system.travel.install(generation, planned, &base);
        match installed {
            Ok(InstalledPlan::Started) => {
                if let Err(error) = self.systems[id].activate_link(
                    driven_by,
                    self.clock.now(),
                    &self.axes,
                    &mut self.controls,
                    &self.clock,
                ) {
                    self.systems.refuse(id, error, &mut self.controls);
                    return;
                }
                self.systems[id].stale = true;
                self.systems[id].activate(&mut self.axes, &mut self.controls, &self.clock);
            }
            // The set-points are the same up to the splice.
            Ok(InstalledPlan::Extended(old)) => self.systems.retired.push(old),
            Err(unwanted) => self.systems.retired.extend(unwanted),
        }
    }

    /// A trajectory that is no longer needed, to be freed outside the tick. Real-time.
    pub fn retired_contour(&mut self) -> Option<Arc<Trajectory>> {
        self.systems.retired.pop()
    }

    /// Takes back a trajectory that could not be freed yet.
    pub fn keep_retired(&mut self, trajectory: Arc<Trajectory>) {
        self.systems.retired.push(trajectory);
    }
}
