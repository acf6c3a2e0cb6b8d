//! Coordinate systems from one tick to the next: ends of moves and stops that lie before it, set-points, tolerances.
//!
//! Real-time: no allocation; bounded by the axes and coordinate systems and by [`MAX_ENDS_PER_TICK`]. Positions are
//! position units, times seconds.

use arcline_drive::Settling;
use arcline_instruction_set::Flag;
use arcline_planner::geometry::Point;
use arcline_planner::profile::Phase;
use arcline_planner::{Instant, Passage, Sample};

use super::Motion;
use crate::axis::Axis;
use crate::axis::sum::Slot;
use crate::system::{Activity, component};

impl Motion {
    pub(super) fn advance_system(&mut self, index: usize) {
        if self.systems[index].contour_in_force().is_some() {
            self.advance_contour(index);
            return;
        }
        for _ in 0..MAX_ENDS_PER_TICK {
            let at = match self.systems[index].planner.passage(&self.clock) {
                None => break,
                Some(Passage::HandOver(at)) => at,
                Some(Passage::Reached(at)) => match self.reached(index, at) {
                    Some(at) => at,
                    None => break,
                },
            };
            self.complete(index, at);
            if !self.systems[index].is_busy() {
                break;
            }
        }
        self.systems[index].planner.look_on(&self.clock);
        if self.systems[index].is_busy() {
            self.sample_system(index);
        }
    }

    /// The command is at the programmed end, or where a stop has led it. The instant at which the active
    /// move is complete, if it is.
    fn reached(&mut self, index: usize, at: Instant) -> Option<Instant> {
        if self.systems[index].activity == Activity::Stopping {
            self.sample_system(index);
            self.systems[index].planner.clear_active();
            self.release_axes(index);
            return None;
        }
        let active = self.systems[index].planner.active()?.motion.data;
        if self.systems[index].planner.passes_on() {
            return Some(at);
        }
        self.set_end_position(index);
        if active.termination.settles() {
            let end = self.systems[index].planner.active()?.motion.path.end();
            self.settled(index, &end, at)
        } else {
            Some(at)
        }
    }

    /// The active move is complete; the next one becomes active at the same instant.
    fn complete(&mut self, index: usize, at: Instant) {
        if let Some(active) = self.systems[index].planner.active_data().copied() {
            self.end_move(active.execution, Flag::Pc.mask());
            self.systems[index].in_actual_tolerance = active.termination.settles();
        }
        let next = self.systems[index].planner.hand_over(at, &self.clock).copied();
        match next {
            Some(next) => {
                let system = &mut self.systems[index];
                system.shown_phase = Phase::Steady;
                system.in_actual_tolerance = false;
                system.in_command_tolerance = false;
                self.controls.write(next.execution, Flag::Ac.mask(), 0, self.clock.tick);
                self.join_axes(index);
            }
            None => {
                self.systems[index].planner.clear_active();
                self.release_axes(index);
                // Moves behind a merged one are planned as a contour now.
                let system = &mut self.systems[index];
                if system
                    .contour
                    .as_ref()
                    .is_some_and(|contour| contour.moves().next().is_some())
                {
                    system.activity = Activity::Moving;
                }
            }
        }
    }

    /// The commands stand exactly on the programmed end of the active move.
    fn set_end_position(&mut self, index: usize) {
        if let Some(end) = self.systems[index].active_end() {
            self.hold_at(index, &end);
        }
    }

    /// The commands stand exactly on a point.
    pub(crate) fn hold_at(&mut self, index: usize, end: &Point) {
        for place in 0..self.systems[index].description.axes.len() {
            let axis = self.systems[index].description.axes[place];
            if let Some(axis) = self.axes.get_mut(usize::from(axis)) {
                axis.set_coordinated(arcline_drive::Motion {
                    position: component(end, place),
                    ..Default::default()
                });
            }
        }
    }

    /// Commands of a system's axes at the present tick, and ACCEL and DECEL of its active instruction.
    pub(crate) fn sample_system(&mut self, index: usize) {
        let system = &mut self.systems[index];
        let sample = match system.contour_in_force() {
            Some(contour) => contour.sample(&self.clock),
            None => system.planner.sample(&self.clock),
        };
        let Some(sample) = sample else {
            return;
        };
        let length = system
            .planner
            .active()
            .map_or(0.0, |running| running.motion.path.length());
        system.in_transition = system.planner.in_transition(&self.clock);
        system.along = [sample.along.velocity.abs(), sample.along.position, length];
        seat(&system.description.axes, &mut self.axes, &sample);
        if system.activity == Activity::Moving && sample.phase != system.shown_phase {
            system.shown_phase = sample.phase;
            let (set, clear) = match sample.phase {
                Phase::Accelerating => (Flag::Accel.mask(), Flag::Decel.mask()),
                Phase::Decelerating => (Flag::Decel.mask(), Flag::Accel.mask()),
                Phase::Steady => (0, Flag::Accel.mask() | Flag::Decel.mask()),
            };
            if let Some(active) = system.active() {
                self.controls.write(active.execution, set, clear, self.clock.tick);
            }
        }
    }

    /// The axes' part of a coordinated move that has just begun, so that others of the same tick see it.
    pub(crate) fn seat_axes(&mut self, index: usize) {
        let system = &self.systems[index];
        if let Some(sample) = system.planner.sample(&self.clock) {
            seat(&system.description.axes, &mut self.axes, &sample);
        }
    }

    /// The instant at which the axes came within the Actual Tolerance of the end that the command reached
    /// before the present tick: found inside the tick, so that a successor's start does not depend on the period.
    pub(crate) fn settled(&mut self, index: usize, end: &Point, reached: Instant) -> Option<Instant> {
        let system = &self.systems[index];
        let elapsed = reached.elapsed(&self.clock);
        let mut settling = Settling {
            drives: [arcline_drive::Drive::ideal(0.0); crate::machine::MAX_PRIMARY_AXES],
            ends: [0.0; crate::machine::MAX_PRIMARY_AXES],
            tolerance: system.description.actual_tolerance,
            period: self.clock.period(),
            rest: elapsed,
        };
        for (place, axis) in system.description.axes.iter().enumerate() {
            let axis = self.axes.get_mut(usize::from(*axis))?;
            axis.drive.rest_for(elapsed);
            settling.drives[place] = axis.drive;
            settling.ends[place] = axis.sum.seen_from(Slot::System, Some(component(end, place)))?;
        }
        let before = settling.within()?;
        Some(reached.after(elapsed - before, &self.clock))
    }

    pub(super) fn finish_stop(&mut self, index: usize) {
        let system = &self.systems[index];
        let Some(stop) = system.stop else {
            return;
        };
        let braking = |(place, axis): (usize, &Axis)| stop.braking.contains(place as u16) && axis.is_braking();
        if system.activity == Activity::Stopping
            || (!stop.braking.is_empty() && self.axes.iter().enumerate().any(braking))
        {
            return;
        }
        self.systems[index].stop = None;
        self.controls
            .write(stop.execution, Flag::Pc.mask(), Flag::Ip.mask(), self.clock.tick);
    }

    pub(super) fn update_tolerances(&mut self) {
        for system in &mut self.systems {
            if system.activity != Activity::Moving {
                continue;
            }
            if let Some(end) = system.active_end() {
                let axes = &self.axes;
                let squares = system.description.axes.iter().enumerate().map(|(place, axis)| {
                    let generator = axes.get(usize::from(*axis)).and_then(|axis| axis.sum.get(Slot::System));
                    let left = generator.map_or(0.0, |generator| generator.now.position) - component(&end, place);
                    left * left
                });
                system.in_command_tolerance = squares.sum::<f64>().sqrt() < system.description.command_tolerance;
            }
        }
    }
}

fn seat(places: &[u16], axes: &mut [Axis], sample: &Sample) {
    for (place, axis) in places.iter().enumerate() {
        if let Some(axis) = axes.get_mut(usize::from(*axis)) {
            axis.set_coordinated(arcline_drive::Motion {
                position: component(&sample.position, place),
                velocity: component(&sample.velocity, place),
                acceleration: component(&sample.acceleration, place),
            });
        }
    }
}

/// Moves of one coordinate system that can end within one tick; the rest end in the next one.
pub(crate) const MAX_ENDS_PER_TICK: usize = 64;
