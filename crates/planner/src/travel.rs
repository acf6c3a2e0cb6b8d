//! The coordinated motion of one system, however its moves are joined: two moves superposed ([`Planner`]), all as a planned contour
//! ([`ContourQueue`]), or a merged move that is superposed before a contour.
//!
//! The owner sees one active move and the moves that wait behind it, and never asks which of the three it is. Every method takes the
//! [`TimeBase`] of the present tick: what a move is a function of, and what a stop is a function of in its place.
//! Not here: instructions, status bits and axes. Real-time: bounded, nothing allocates or frees; a [`Trajectory`] that is no longer
//! needed is returned. How moves are changed stands in `change`, how they stop in `stopping`, where the motion is in `position`.

mod change;
mod position;
mod stopping;

use std::sync::Arc;

use arcline_contour::{AxisLimits, ContourMove, Trajectory};
use arcline_geometry::Point;
use arcline_profile::{Bounds, Jerk, Limits};

use crate::clock::TimeBase;
use crate::contour::ContourEvent;
use crate::move_event::MoveEvent;
use crate::{
    Clock, ContourBatch, ContourQueue, ContourRests, InitialMotion, Installed, Instant, MasterRate, Move, Planner,
    QueueFull, RotationResidual,
};

pub use stopping::PathStopping;

/// The moves of a coordinate system and their motion.
#[derive(Debug)]
pub struct Travel<T> {
    planner: Planner<T>,
    /// Where moves are planned as contours: those that are, and those that wait for it. A merged move is the planner's.
    contour: Option<ContourQueue<T>>,
    /// The override: share of the programmed speeds.
    rate: f64,
}

impl<T: Copy> Travel<T> {
    /// Moves that are superposed where they blend.
    pub fn superposed(planner: Planner<T>) -> Self {
        Travel {
            planner,
            contour: None,
            rate: 1.0,
        }
    }

    /// Moves that are planned as contours. The planner has the merged ones.
    pub fn contours(planner: Planner<T>, contour: ContourQueue<T>) -> Self {
        Travel {
            planner,
            contour: Some(contour),
            rate: 1.0,
        }
    }

    /// Sets the Dynamics Configuration Bits, which count from the next instruction on.
    pub fn set_bounds(&mut self, bounds: Bounds) {
        self.planner.set_bounds(bounds);
    }

    /// The contour, unless a merged move runs before it.
    fn contour_in_force(&self) -> Option<&ContourQueue<T>> {
        self.contour.as_ref().filter(|_| self.planner.active().is_none())
    }

    fn contour_in_force_mut(&mut self) -> Option<&mut ContourQueue<T>> {
        self.contour.as_mut().filter(|_| self.planner.active().is_none())
    }

    /// Whether a move may turn an orientation. Contours cannot.
    pub fn can_turn(&self) -> bool {
        self.contour.is_none()
    }

    /// The moves that are active or wait, the active one first.
    pub fn moves(&self) -> impl Iterator<Item = &Move<T>> {
        let active = self.planner.active().map(|running| &running.motion);
        let contour = self.contour.iter().flat_map(ContourQueue::moves);
        active.into_iter().chain(self.planner.pending()).chain(contour)
    }

    /// The moves that wait, the oldest first.
    pub fn waiting(&self) -> impl Iterator<Item = &Move<T>> {
        self.moves().skip(usize::from(self.active().is_some()))
    }

    /// The move that moves the axes.
    pub fn active(&self) -> Option<&Move<T>> {
        match self.contour_in_force() {
            Some(contour) => contour.active(),
            None => self.planner.active().map(|running| &running.motion),
        }
    }

    /// The owner's data of the active move, to change.
    pub fn active_data(&mut self) -> Option<&mut T> {
        match self.contour_in_force() {
            Some(_) => self.contour.as_mut()?.active_data(),
            None => self.planner.active_data(),
        }
    }

    /// The move that takes over at the end of the active one without a new plan.
    pub fn next(&self) -> Option<Move<T>> {
        match self.contour_in_force() {
            Some(contour) => contour.next_planned().copied(),
            None => self.planner.next(),
        }
    }

    /// The last move, active or waiting: a new one begins at its end.
    pub fn last(&self) -> Option<&Move<T>> {
        let contour = self.contour.as_ref().and_then(|contour| contour.moves().last());
        let active = || self.planner.active().map(|running| &running.motion);
        contour.or_else(|| self.planner.last_pending()).or_else(active)
    }

    /// Whether `depth` moves wait.
    pub fn is_full(&self) -> bool {
        self.room() == 0
    }

    /// How many moves it takes until `depth` of them wait.
    pub fn room(&self) -> usize {
        match &self.contour {
            Some(contour) => contour.room(usize::from(self.planner.active().is_some())),
            None => self.planner.room(),
        }
    }

    /// Whether the active move stays at rest until a speed is changed.
    pub fn is_paused(&self) -> bool {
        match self.contour_in_force() {
            Some(contour) => contour.is_paused(),
            None => self.planner.is_paused(),
        }
    }

    /// The highest jerk of the moves that determine the motion, a stop of them included, by time; `None` where none of them is an
    /// S-curve. Of a contour, which is planned as a whole, all its moves count; of other moves the active one.
    pub fn highest_jerk(&self) -> Option<f64> {
        let highest = |jerk: Jerk| jerk.acceleration.max(jerk.deceleration);
        match self.contour_in_force() {
            Some(contour) => {
                let programmed = contour.moves().filter_map(|motion| motion.limits.jerk);
                programmed.map(highest).reduce(f64::max).or(contour.jerk_of_stop())
            }
            None => {
                let motion = &self.planner.active()?.motion;
                motion.parameter.in_time(&motion.limits).jerk.map(highest)
            }
        }
    }

    /// The limits that the active move keeps by time; `None` where a master drives it, or a stop of a contour has left all its moves
    /// behind. A contour's are those that its active move was programmed with.
    pub fn limits_in_force(&self, base: &TimeBase) -> Option<Limits> {
        if base.master.is_some() {
            return None;
        }
        match self.contour_in_force() {
            Some(contour) => contour.moves().next().map(|active| active.limits),
            None => self.planner.before(),
        }
    }

    /// A number that changes whenever the active move is another one, or comes to its end at another instant.
    pub fn plans(&self) -> u32 {
        let contour = self.contour.as_ref().map_or(0, ContourQueue::plans);
        self.planner.plans().wrapping_add(contour)
    }

    /// Puts a move behind the last one.
    ///
    /// # Errors
    /// [`QueueFull`] when all pending places are taken.
    pub fn push(&mut self, mut motion: Move<T>, base: &TimeBase) -> Result<(), QueueFull> {
        match &mut self.contour {
            Some(contour) => {
                motion.limits = motion.parameter.in_time(&motion.limits);
                contour.push(motion, &base.time)
            }
            None => self.planner.enqueue(motion, &base.clock()),
        }
    }

    /// Whether a move that takes over a motion begins in this tick: else it waits, for the active one or for its plan.
    pub fn begins_at_once(&self, initial: &InitialMotion) -> bool {
        match self.contour {
            Some(_) => initial.velocity != Point::zeros() || initial.acceleration != Point::zeros(),
            None => self.planner.active().is_none(),
        }
    }

    /// Begins a move out of a motion, and out of a turn that ramps out beside it. `kept`: limits of the axes that it keeps.
    pub fn merge(
        &mut self,
        motion: Move<T>,
        initial: InitialMotion,
        residual: Option<RotationResidual>,
        kept: Option<&AxisLimits>,
        base: &TimeBase,
    ) {
        let clock = base.clock();
        match kept {
            Some(limits) => {
                // Also after the merge: no override leads beyond the limits of the axes.
                self.planner.set_rate(self.rate, &clock);
                self.planner.merge_within(motion, initial, limits, &clock);
                self.planner.set_rate(self.rate, &clock);
            }
            None => self.planner.merge(motion, initial, &clock),
        }
        self.planner.ramp_out(residual, &clock);
    }

    /// Before [`Travel::event`] at every tick.
    pub fn steer(&mut self, base: &TimeBase) {
        let clock = self.contour_clock(base);
        if let Some(contour) = self.contour_in_force_mut() {
            contour.steer(&clock);
            // A stop goes on over the ends of moves, which have left the queue.
            while contour.moves().next().is_none() && contour.event(&clock) == Some(ContourEvent::Next) {
                contour.pass(&clock);
            }
        }
    }

    /// The next event of the active move that lies at or before the present tick.
    pub fn event(&self, base: &TimeBase) -> Option<MoveEvent> {
        let now = || base.clock().now();
        match self.contour_in_force() {
            Some(contour) => Some(match contour.event(&self.contour_clock(base))? {
                ContourEvent::Next => MoveEvent::HandOver(now()),
                ContourEvent::End => MoveEvent::Reached(now()),
            }),
            None => self.planner.event(&base.clock()),
        }
    }

    /// Whether the active move goes over into its successor without rest.
    pub fn passes_on(&self) -> bool {
        self.planner.passes_on()
    }

    /// The active move is complete, and [`Travel::next`] becomes active at an instant.
    pub fn hand_over(&mut self, at: Instant, base: &TimeBase) {
        let clock = self.contour_clock(base);
        match self.contour_in_force_mut() {
            Some(contour) => {
                contour.pass(&clock);
            }
            None => {
                self.planner.hand_over(at, &base.clock());
            }
        }
    }

    /// Goes on with the look-ahead, behind all events of a tick.
    pub fn look_on(&mut self, base: &TimeBase) {
        self.planner.look_on(&base.clock());
    }

    /// Takes a waiting move out: the newest of a contour, since its plan may be on the way, else the oldest.
    pub fn cancel_waiting(&mut self) -> Option<T> {
        let contour = self.contour.as_mut().and_then(ContourQueue::pop_pending);
        let data = contour.map(|motion| motion.data);
        data.or_else(|| self.planner.cancel_pending())
    }

    /// The active move's data, whose path goes on without it until [`Travel::end`].
    pub fn detach_active(&mut self) -> Option<T> {
        match self.contour_in_force() {
            Some(_) => self.contour.as_mut()?.pop().map(|motion| motion.data),
            None => self.planner.active_data().copied(),
        }
    }

    /// Ends the active move: what waits stays, and is planned from rest.
    pub fn end(&mut self, base: &TimeBase) -> Option<Arc<Trajectory>> {
        if self.planner.clear_active().is_some() {
            return None;
        }
        self.contour.as_mut()?.end(&base.time)
    }

    /// Forgets the active move, and all that wait for a plan.
    pub fn clear(&mut self) -> Option<Arc<Trajectory>> {
        self.planner.clear_active();
        self.contour.as_mut()?.clear()
    }

    /// Rests of its contours on the way.
    pub fn contour_rests(&self) -> ContourRests {
        self.contour
            .as_ref()
            .map_or_else(ContourRests::default, ContourQueue::rests)
    }

    /// The moves that are to be planned as a contour now ([`ContourQueue::batch`]).
    pub fn batch(&mut self, base: &TimeBase, take: impl FnMut(ContourMove)) -> Option<ContourBatch> {
        let clock = self.contour_clock(base);
        self.contour_in_force_mut()?.batch(&clock, &base.time, take)
    }

    /// Takes a plan ([`ContourQueue::install`]). One that begins does so at the displacement 0 of its master.
    ///
    /// # Errors
    /// The plan itself when it cannot be used.
    pub fn install(
        &mut self,
        generation: u32,
        planned: Option<Arc<Trajectory>>,
        base: &TimeBase,
    ) -> Result<Installed, Option<Arc<Trajectory>>> {
        let clock = self.contour_clock(base);
        match &mut self.contour {
            Some(contour) => contour.install(generation, planned, &clock),
            None => Err(planned),
        }
    }

    /// The first move of a contour that was to begin: it cannot. What waits stays.
    pub fn refuse(&mut self) -> (Option<T>, Option<Arc<Trajectory>>) {
        let Some(contour) = &mut self.contour else {
            return (None, None);
        };
        let trajectory = contour.finish();
        (contour.pop().map(|motion| motion.data), trajectory)
    }

    /// The variable that contours are functions of: time, or the time that a master at the speed that they are planned for would have taken for its
    /// displacement.
    fn contour_clock(&self, base: &TimeBase) -> Clock {
        base.master.as_ref().map_or(base.time, |master| {
            Clock::of_displacement(master.displacement / self.nominal())
        })
    }

    /// How that goes on, where a master leads.
    fn contour_rate(&self, base: &TimeBase) -> MasterRate {
        let rate = base.master.as_ref().map(|master| master.rate).unwrap_or_default();
        MasterRate {
            speed: rate.speed / self.nominal(),
            acceleration: rate.acceleration / self.nominal(),
        }
    }

    fn nominal(&self) -> f64 {
        self.contour.as_ref().map_or(1.0, ContourQueue::nominal)
    }
}
