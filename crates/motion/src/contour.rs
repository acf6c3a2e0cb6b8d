//! Coordinate systems whose moves are travelled as planned contours: between the queue of moves and the
//! planning, which is done outside the tick.

use std::sync::Arc;

use arcline_instruction_set::{Flag, MotionError};
use arcline_planner::geometry::Point;
use arcline_planner::precise::{self, AxisLimits, ContourMove, Trajectory};
use arcline_planner::profile::Phase;
use arcline_planner::{Clock, ContourPassage, Ending, Extension, Installed, Move};

use crate::cause::Cause;
use crate::motion::{MAX_ENDS_PER_TICK, Motion};
use crate::system::{Activity, Planned};

/// Moves that are to be planned as one contour.
#[derive(Clone, Debug)]
pub struct ContourRequest {
    /// Index of the coordinate system.
    pub system: u16,
    /// Tells this request from others of the same system.
    pub generation: u32,
    /// The moves, to rest.
    pub moves: Vec<ContourMove>,
    /// The trajectory in execution that they extend; `None`: they begin at rest.
    pub extends: Option<Extension>,
    /// Limits of the axes that are kept.
    pub limits: AxisLimits,
}

impl ContourRequest {
    /// Room for the longest queue that can be configured, so that a tick can fill it without allocating.
    pub fn new() -> Self {
        ContourRequest {
            system: 0,
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

    /// Plans the contour; `None` where a trajectory in execution cannot be extended. Not bounded: outside the tick, and
    /// what it has been given is freed.
    pub fn plan(&mut self) -> Option<Arc<Trajectory>> {
        let planned = match self.extends.take() {
            None => precise::plan(&self.moves, &self.limits),
            Some(extension) => extension.plan(&self.moves, &self.limits)?,
        };
        Some(Arc::new(planned))
    }
}

impl Default for ContourRequest {
    fn default() -> Self {
        Self::new()
    }
}

impl Motion {
    /// Fills a request for the next contour that is to be planned; false when there is none. Real-time.
    pub fn next_contour(&mut self, request: &mut ContourRequest) -> bool {
        for (index, system) in self.systems.iter_mut().enumerate() {
            let wanted = system.activity == Activity::Moving && !system.is_merged();
            let own = system.contour_clock(&self.clock);
            let Some(contour) = system.contour.as_mut().filter(|_| wanted) else {
                continue;
            };
            request.moves.clear();
            if let Some(batch) = contour.batch(&own, &self.clock, |motion| request.moves.push(motion)) {
                request.system = index as u16;
                request.generation = batch.generation;
                request.extends = batch.extends;
                request.limits = system.axis_limits;
                return true;
            }
        }
        false
    }

    /// Begins to travel a planned contour at the present tick, or goes on with it, if it is still wanted and in time.
    /// Real-time.
    pub fn install_contour(&mut self, system: u16, generation: u32, planned: Option<Arc<Trajectory>>) {
        let index = usize::from(system);
        let Some(system) = self.systems.get_mut(index) else {
            self.retired.extend(planned);
            return;
        };
        // One that begins does so at the beginning of a way of its own.
        let lead = system.moves().next().and_then(|first| first.data.lead);
        let begins = lead.is_some() && system.guide.is_none();
        let own = if begins {
            Clock::of_way(0.0)
        } else {
            system.contour_clock(&self.clock)
        };
        let installed = match &mut system.contour {
            Some(contour) => contour.install(generation, planned, &own),
            None => Err(planned),
        };
        match installed {
            Ok(Installed::Started) => {
                if let Err(error) = self.lead_system(index, lead, self.clock.now()) {
                    self.refuse_contour(index, error);
                    return;
                }
                self.systems[index].stale = true;
                self.activate(index);
                self.join_axes(index);
            }
            // The set-points are the same up to the splice.
            Ok(Installed::Extended(old)) => self.retired.push(old),
            Err(unwanted) => self.retired.extend(unwanted),
        }
    }

    /// A trajectory that is no longer needed, to be freed outside the tick. Real-time.
    pub fn retired_contour(&mut self) -> Option<Arc<Trajectory>> {
        self.retired.pop()
    }

    /// Keeps a trajectory that could not be freed yet.
    pub fn keep_retired(&mut self, trajectory: Arc<Trajectory>) {
        self.retired.push(trajectory);
    }

    /// The contour that was to begin cannot: its first move errs, and those behind it are cancelled.
    fn refuse_contour(&mut self, index: usize, error: MotionError) {
        let refused = self.systems[index].contour.as_mut().and_then(|contour| {
            self.retired.extend(contour.finish());
            contour.pop()
        });
        if let Some(refused) = refused {
            self.controls.fail(refused.data.execution, error, self.clock.tick);
            self.controls.because(refused.data.execution.into());
        }
        self.cancel_pending_contour(index);
        self.controls.because(Cause::Itself);
    }

    /// A move of another mode or master than the one that has just ended cannot follow it without rest (spec/coordinated-instructions.md §7.11).
    pub(crate) fn refuse_next_contour(&mut self, index: usize, last: &Move<Planned>) {
        let link = |motion: &Move<Planned>| motion.data.lead.map(|lead| lead.link);
        let contour = self.systems[index].contour.as_ref();
        let next = contour.and_then(|contour| contour.moves().next());
        if last.ending != Ending::Stop && next.is_some_and(|next| link(last) != link(next)) {
            self.refuse_contour(index, MotionError::MdscInvalidModeOrMasterChange);
        }
    }

    /// Queues a move of a system that travels planned contours.
    pub(crate) fn queue_contour(&mut self, index: usize, mut planned: Move<Planned>) -> Result<(), MotionError> {
        planned.limits = planned.parameter.in_time(&planned.limits);
        let system = &mut self.systems[index];
        let Some(contour) = &mut system.contour else {
            return Err(MotionError::InvalidPlannerState);
        };
        contour
            .push(planned, &self.clock)
            .map_err(|_| MotionError::CoordinateSystemQueueFull)?;
        if system.activity == Activity::Idle {
            system.activity = Activity::Moving;
            system.in_actual_tolerance = false;
            system.in_command_tolerance = false;
        }
        Ok(())
    }

    /// Ends every pending move; where no trajectory is travelled yet, every move.
    pub(crate) fn cancel_pending_contour(&mut self, index: usize) {
        while let Some(cancelled) = self.systems[index]
            .contour
            .as_mut()
            .and_then(|contour| contour.pop_pending())
        {
            self.end_move(cancelled.data.execution, 0);
        }
        let contour = self.systems[index].contour_in_force();
        if contour.is_some_and(|contour| !contour.is_running()) {
            self.retire_contour(index);
            self.rest_system(index);
        }
    }

    /// Forgets a contour; its trajectory is freed elsewhere.
    pub(crate) fn retire_contour(&mut self, index: usize) {
        let contour = self.systems[index].contour.as_mut();
        let trajectory = contour.and_then(|contour| contour.clear());
        self.retired.extend(trajectory);
    }

    /// Moves of a contour that end by the present tick, and the end of it.
    pub(crate) fn advance_contour(&mut self, index: usize) {
        let system = &mut self.systems[index];
        let own = system.contour_clock(&self.clock);
        if let Some(contour) = &mut system.contour {
            contour.steer(&own);
        }
        let waits = system.guide.is_some_and(|guide| guide.has_position_lock());
        for _ in 0..MAX_ENDS_PER_TICK {
            let Some(contour) = &mut self.systems[index].contour else {
                return;
            };
            match contour.passage(&own).filter(|_| !waits) {
                None => break,
                Some(ContourPassage::Next) => {
                    if let Some(passed) = contour.pass(&own) {
                        self.end_move(passed.data.execution, Flag::Pc.mask());
                        self.activate(index);
                    }
                }
                Some(ContourPassage::End) => {
                    self.sample_system(index);
                    self.end_contour(index);
                    return;
                }
            }
        }
        self.sample_system(index);
    }

    /// The trajectory is at its end, or a stop on it is.
    fn end_contour(&mut self, index: usize) {
        let system = &mut self.systems[index];
        let (end, active) = (system.active_end(), system.active());
        let (Some(end), Some(active), false) = (end, active, system.activity == Activity::Stopping) else {
            self.retire_contour(index);
            self.release_axes(index);
            return;
        };
        self.hold_at(index, &end);
        if active.termination.settles() && self.settled(index, &end, self.clock.now()).is_none() {
            return;
        }
        self.end_move(active.execution, Flag::Pc.mask());
        let own = self.systems[index].contour_clock(&self.clock);
        let mut last = None;
        if let Some(contour) = &mut self.systems[index].contour {
            last = contour.pass(&own);
            self.retired.extend(contour.finish());
        }
        if let Some(last) = &last {
            self.refuse_next_contour(index, last);
        }
        let contour = self.systems[index].contour.as_ref();
        let more = contour.is_some_and(|contour| contour.moves().next().is_some());
        self.release_axes(index);
        let system = &mut self.systems[index];
        system.in_actual_tolerance = active.termination.settles();
        if more {
            system.activity = Activity::Moving;
        }
    }

    fn activate(&mut self, index: usize) {
        let system = &mut self.systems[index];
        system.shown_phase = Phase::Steady;
        system.in_actual_tolerance = false;
        system.in_command_tolerance = false;
        if let Some(next) = system.active() {
            self.controls.write(next.execution, Flag::Ac.mask(), 0, self.clock.tick);
            self.calculate(index);
        }
    }
}
