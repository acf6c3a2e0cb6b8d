//! The coordinated motion of one system with any kind of junction: superposed moves ([`Planner`]), planned contours ([`ContourQueue`]), or a
//! merged move that is superposed before a contour.
//!
//! The owner sees one active move and the pending ones behind it, and never asks for the kind. Every method takes the [`TimeBase`] of the
//! present tick: the variables of the active move, and of a stop in its place.
//! Not here: instructions, status bits and axes. Real-time: bounded, nothing allocates or frees; a [`Trajectory`] that is no longer
//! needed is returned. Changes of moves are in `change`, stops in `stopping`, the present motion in `position`.

mod change;
mod position;
mod stopping;

use std::sync::Arc;

use arcline_contour::{AxisLimits, ContourMove, Trajectory};
use arcline_geometry::Point;
use arcline_profile::{DynamicsBits, Jerk, Limits};

use crate::clock::TimeBase;
use crate::contour::ContourEvent;
use crate::move_event::MoveEvent;
use crate::{
    Clock, ContourBatch, ContourQueue, ContourRests, InitialMotion, InstalledPlan, Instant, MasterRate, Move, Planner,
    QueueFull, RotationResidual,
};

pub use stopping::PathStopping;

/// The moves of a coordinate system and their motion.
#[derive(Debug)]
pub struct Travel<T> {
    planner: Planner<T>,
    /// The planned and unplanned moves of contours, if moves are planned as such. A merged move belongs to the planner.
    contour: Option<ContourQueue<T>>,
    /// The override: share of the programmed speeds.
    rate: f64,
}

impl<T: Copy> Travel<T> {
    /// For superposed moves.
    pub fn superposed(planner: Planner<T>) -> Self {
        Travel {
            planner,
            contour: None,
            rate: 1.0,
        }
    }

    /// For moves planned as contours. The planner has the merged ones.
    pub fn contours(planner: Planner<T>, contour: ContourQueue<T>) -> Self {
        Travel {
            planner,
            contour: Some(contour),
            rate: 1.0,
        }
    }

    /// Sets the Dynamics Configuration Bits for later instructions.
    pub fn set_dynamics_bits(&mut self, dynamics_bits: DynamicsBits) {
        self.planner.set_dynamics_bits(dynamics_bits);
        if let Some(contour) = &mut self.contour {
            contour.set_dynamics_bits(dynamics_bits);
        }
    }

    /// The contour, unless a merged move runs before it.
    fn contour_in_force(&self) -> Option<&ContourQueue<T>> {
        self.contour.as_ref().filter(|_| self.planner.active().is_none())
    }

    fn contour_in_force_mut(&mut self) -> Option<&mut ContourQueue<T>> {
        self.contour.as_mut().filter(|_| self.planner.active().is_none())
    }

    /// A move may rotate the orientation. Contours do not support it.
    pub fn can_turn(&self) -> bool {
        self.contour.is_none()
    }

    /// The active and the pending moves, the active one first.
    pub fn moves(&self) -> impl Iterator<Item = &Move<T>> {
        let active = self.planner.active().map(|running| &running.motion);
        let contour = self.contour.iter().flat_map(ContourQueue::moves);
        active.into_iter().chain(self.planner.pending()).chain(contour)
    }

    /// The pending moves, the oldest first.
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

    /// The owner's data of the active move, mutable.
    pub fn active_data(&mut self) -> Option<&mut T> {
        match self.contour_in_force() {
            Some(_) => self.contour.as_mut()?.active_data(),
            None => self.planner.active_data(),
        }
    }

    /// The move that becomes active at the end of the active one without a new plan.
    pub fn next(&self) -> Option<Move<T>> {
        match self.contour_in_force() {
            Some(contour) => contour.next_planned().copied(),
            None => self.planner.next(),
        }
    }

    /// The last move, active or pending: a new one begins at its end.
    pub fn last(&self) -> Option<&Move<T>> {
        let contour = self.contour.as_ref().and_then(|contour| contour.moves().last());
        let active = || self.planner.active().map(|running| &running.motion);
        contour.or_else(|| self.planner.last_pending()).or_else(active)
    }

    /// The queue has no room: `depth` moves wait.
    pub fn is_full(&self) -> bool {
        self.room() == 0
    }

    /// The number of further moves until `depth` of them wait.
    pub fn room(&self) -> usize {
        match &self.contour {
            Some(contour) => contour.room(usize::from(self.planner.active().is_some())),
            None => self.planner.room(),
        }
    }

    /// The active move rests until a speed changes.
    pub fn is_paused(&self) -> bool {
        match self.contour_in_force() {
            Some(contour) => contour.is_paused(),
            None => self.planner.is_paused(),
        }
    }

    /// The highest jerk of the moves that determine the motion, or its stop, by time; `None` if none of them is an S-curve. For a
    /// contour, which is planned as a whole, all its moves count; otherwise the active one.
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

    /// One of the moves that determine the motion, or its stop, is an S-curve.
    pub fn is_s_curve(&self) -> bool {
        match self.contour_in_force() {
            Some(contour) => {
                let mut moves = contour.moves();
                moves.any(|motion| motion.limits.jerk.is_some()) || contour.jerk_of_stop().is_some()
            }
            None => self.highest_jerk().is_some(),
        }
    }

    /// The limits of the active move by time, of a contour the programmed ones. `None` if a master drives the move, or if a stop of a contour
    /// has passed the ends of all its moves.
    pub fn limits_in_force(&self, base: &TimeBase) -> Option<Limits> {
        if base.master.is_some() {
            return None;
        }
        match self.contour_in_force() {
            Some(contour) => contour.moves().next().map(|active| active.limits),
            None => self.planner.before(),
        }
    }

    /// A number that changes with the active move, and with the instant of its end.
    pub fn plans(&self) -> u32 {
        let contour = self.contour.as_ref().map_or(0, ContourQueue::plans);
        self.planner.plans().wrapping_add(contour)
    }

    /// Adds a move at the end of the queue.
    ///
    /// # Errors
    /// [`QueueFull`] if the queue has no room.
    pub fn push(&mut self, mut motion: Move<T>, base: &TimeBase) -> Result<(), QueueFull> {
        match &mut self.contour {
            Some(contour) => {
                motion.limits = motion.parameter.in_time(&motion.limits);
                motion.last_speed *= motion.parameter.speed;
                contour.push(motion, &base.time)
            }
            None => self.planner.enqueue(motion, &base.clock()),
        }
    }

    /// A move that takes over a motion begins in this tick; otherwise it waits for the active one or for its plan.
    pub fn begins_at_once(&self, initial: &InitialMotion) -> bool {
        match self.contour {
            Some(_) => initial.velocity != Point::zeros() || initial.acceleration != Point::zeros(),
            None => self.planner.active().is_none(),
        }
    }

    /// Begins a move from a motion, and from a rotation that ramps out beside it. `axis_limits`: limits of the axes that both observe.
    pub fn merge(
        &mut self,
        motion: Move<T>,
        initial: InitialMotion,
        residual: Option<RotationResidual>,
        axis_limits: Option<&AxisLimits>,
        base: &TimeBase,
    ) {
        let clock = base.clock();
        match axis_limits {
            Some(limits) => {
                // Also after the merge, no override exceeds the limits of the axes.
                self.planner.set_rate(self.rate, &clock);
                self.planner.merge_within(motion, initial, limits, &clock);
                self.planner.set_rate(self.rate, &clock);
            }
            None => self.planner.merge(motion, initial, &clock),
        }
        self.planner.ramp_out(residual, &clock);
    }

    /// To be called before [`Travel::event`] in every tick.
    pub fn steer(&mut self, base: &TimeBase) {
        let clock = self.contour_clock(base);
        if let Some(contour) = self.contour_in_force_mut() {
            contour.steer(&clock);
            // A stop continues across the ends of moves, which have left the queue.
            while contour.moves().next().is_none() && contour.event(&clock) == Some(ContourEvent::Next) {
                contour.pass(&clock);
            }
        }
    }

    /// The next event of the active move at or before the present tick.
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

    /// The active move continues into its successor without rest.
    pub fn passes_on(&self) -> bool {
        self.planner.passes_on()
    }

    /// Completes the active move, and makes [`Travel::next`] active at an instant.
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

    /// Continues the look-ahead, after all events of a tick.
    pub fn continue_look_ahead(&mut self, base: &TimeBase) {
        self.planner.continue_look_ahead(&base.clock());
    }

    /// Removes a pending move: the newest one of a contour, since its plan may be under way, otherwise the oldest.
    pub fn cancel_waiting(&mut self) -> Option<T> {
        let contour = self.contour.as_mut().and_then(ContourQueue::pop_pending);
        let data = contour.map(|motion| motion.data);
        data.or_else(|| self.planner.cancel_pending())
    }

    /// The active move's data; its path continues without them until [`Travel::end`].
    pub fn detach_active(&mut self) -> Option<T> {
        match self.contour_in_force() {
            Some(_) => self.contour.as_mut()?.pop().map(|motion| motion.data),
            None => self.planner.active_data().copied(),
        }
    }

    /// Ends the active move: the pending ones stay, and are planned from rest.
    pub fn end(&mut self, base: &TimeBase) -> Option<Arc<Trajectory>> {
        if self.planner.clear_active().is_some() {
            return None;
        }
        self.contour.as_mut()?.end(&base.time)
    }

    /// Removes the active move and all unplanned ones.
    pub fn clear(&mut self) -> Option<Arc<Trajectory>> {
        self.planner.clear_active();
        self.contour.as_mut()?.clear()
    }

    /// Unwanted rests of its contours.
    pub fn contour_rests(&self) -> ContourRests {
        self.contour
            .as_ref()
            .map_or_else(ContourRests::default, ContourQueue::rests)
    }

    /// The moves to plan as a contour now ([`ContourQueue::batch`]).
    pub fn batch(&mut self, base: &TimeBase, take: impl FnMut(ContourMove)) -> Option<ContourBatch> {
        let clock = self.contour_clock(base);
        self.contour_in_force_mut()?.batch(&clock, &base.time, take)
    }

    /// Takes a plan ([`ContourQueue::install`]). A plan that begins does so at the displacement 0 of its master.
    ///
    /// # Errors
    /// The plan itself if it cannot be used.
    pub fn install(
        &mut self,
        generation: u32,
        planned: Option<Arc<Trajectory>>,
        base: &TimeBase,
    ) -> Result<InstalledPlan, Option<Arc<Trajectory>>> {
        let clock = self.contour_clock(base);
        match &mut self.contour {
            Some(contour) => contour.install(generation, planned, &clock),
            None => Err(planned),
        }
    }

    /// Removes the first move of a contour, which was to begin but cannot. The pending moves stay.
    pub fn refuse(&mut self) -> (Option<T>, Option<Arc<Trajectory>>) {
        let Some(contour) = &mut self.contour else {
            return (None, None);
        };
        let trajectory = contour.finish();
        (contour.pop().map(|motion| motion.data), trajectory)
    }

    /// The variable of contours: time, or the time that a master at its nominal speed needs for the displacement.
    fn contour_clock(&self, base: &TimeBase) -> Clock {
        base.master.as_ref().map_or(base.time, |master| {
            Clock::of_displacement(master.displacement / self.nominal())
        })
    }

    /// The rate of that variable if the contour is master driven.
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
