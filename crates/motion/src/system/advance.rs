//! Coordinate systems from one tick to the next: the ends of moves before the tick, and the moves that follow them.
//!
//! Real-time: no allocation; bounded by the axes and coordinate systems and by [`MAX_ENDS_PER_TICK`]. Positions are
//! position units, times seconds.

use arcline_drive::{Drives, Settled};
use arcline_instruction_set::{Flag, MotionError, SystemId};
use arcline_planner::{Clock, Ending, Instant, Move, MoveEvent};

use super::{Activity, Planned, System, Systems};
use crate::axes::Axes;
use crate::cause::Cause;
use crate::control::Controls;

impl Systems {
    /// Advances a coordinate system to the present tick: the ends of moves before it, then the commands of its axes.
    pub(crate) fn advance(&mut self, index: SystemId, axes: &mut Axes, controls: &mut Controls, clock: &Clock) {
        let system = &mut self[index];
        let base = system.time_base(clock);
        system.travel.steer(&base);
        for _ in 0..MAX_ENDS_PER_TICK {
            let system = &self[index];
            if system.follower.is_some_and(|follower| follower.has_position_lock()) {
                break;
            }
            let moment = match system.travel.event(&system.time_base(clock)) {
                None => break,
                Some(MoveEvent::HandOver(at)) => self[index].moment(at, clock),
                Some(MoveEvent::Reached(at)) => match self.reached(index, at, axes, clock, controls) {
                    Some(moment) => moment,
                    None => break,
                },
            };
            self.complete(index, moment, axes, controls, clock);
            if !self[index].is_busy() {
                break;
            }
        }
        let system = &mut self[index];
        let base = system.time_base(clock);
        system.travel.continue_look_ahead(&base);
        if self[index].is_busy() {
            self[index].sample(axes, controls, clock);
        }
    }

    /// Handles a command that has reached the programmed end, or the end of a stop. Returns the instant at which the active move is complete,
    /// if it is.
    fn reached(
        &mut self,
        index: SystemId,
        at: Instant,
        axes: &mut Axes,
        clock: &Clock,
        controls: &mut Controls,
    ) -> Option<Moment> {
        if self[index].activity == Activity::Stopping {
            self[index].sample(axes, controls, clock);
            self.retire_all(index);
            self[index].release_axes(axes);
            return None;
        }
        let moment = self[index].moment(at, clock);
        if self[index].travel.passes_on() {
            return Some(moment);
        }
        self[index].set_end_position(axes);
        let active = self[index].travel.active()?;
        if active.data.termination.tolerance().is_none() {
            return Some(moment);
        }
        let system = &mut self[index];
        // After an end inside an earlier update, the displacement of the master no longer yields the instant of that end.
        let time = match system.follower {
            Some(_) => *system.ended.get_or_insert(moment.time),
            None => moment.time,
        };
        let time = self[index].settled(time, axes, clock)?;
        let follower = &self[index].follower;
        let own = follower
            .as_ref()
            .map_or(time, |follower| follower.displacement_at(time, clock));
        Some(Moment { own, time })
    }

    /// Completes the active move and activates the next one at the same instant. If the next one cannot begin, it fails, the completed move
    /// ends as if it had no successor, and the moves behind are cancelled, since they would begin elsewhere.
    fn complete(&mut self, index: SystemId, moment: Moment, axes: &mut Axes, controls: &mut Controls, clock: &Clock) {
        let last = self[index].travel.active().copied();
        if let Some(last) = &last {
            controls.end_move(last.data.execution, Flag::Pc.mask());
            self[index].shown.in_actual_tolerance = last.data.termination.tolerance().is_some();
        }
        if let Some(next) = self[index].travel.next() {
            controls.because(next.data.execution.into());
            let promoted = self[index].promote(last.as_ref(), &next, moment, axes, controls, clock);
            if let Ok(at) = promoted {
                let system = &mut self[index];
                let base = system.time_base(clock);
                system.travel.hand_over(at, &base);
                self[index].activate(axes, controls, clock);
            } else if let Err(error) = promoted {
                controls.fail(next.data.execution, error);
                self[index].travel.cancel_waiting();
                self.cancel_pending(index, controls);
            }
            controls.because(Cause::Itself);
            if promoted.is_ok() {
                return;
            }
        }
        let base = self[index].time_base(clock);
        let trajectory = self[index].travel.end(&base);
        self.retired.extend(trajectory);
        self[index].release_axes(axes);
        self.refuse_next(index, last.as_ref(), controls);
        // The moves that still wait are planned as a contour now.
        let system = &mut self[index];
        if system.travel.waiting().next().is_some() {
            system.activity = Activity::Moving;
        }
    }

    /// Refuses a move that should follow the completed one without rest, but cannot.
    fn refuse_next(&mut self, index: SystemId, last: Option<&Move<Planned>>, controls: &mut Controls) {
        let next = self[index].travel.waiting().next();
        if let Some(Err(error)) = next.map(|next| verify_same_link(last, next)) {
            self.refuse(index, error, controls);
        }
    }

    /// Fails the move that was to begin, and cancels those behind it.
    pub(crate) fn refuse(&mut self, index: SystemId, error: MotionError, controls: &mut Controls) {
        let (refused, trajectory) = self[index].travel.refuse();
        self.retired.extend(trajectory);
        if let Some(refused) = refused {
            controls.fail(refused.execution, error);
            controls.because(refused.execution.into());
        }
        self.cancel_pending(index, controls);
        controls.because(Cause::Itself);
    }

    /// Continues a move that waits for its axes, from the instant at which they came within the tolerance: the position of its successor at
    /// this tick is known now, and goes out at the next one.
    pub(crate) fn finish_settling(
        &mut self,
        index: SystemId,
        drives: &dyn Drives,
        axes: &mut Axes,
        controls: &mut Controls,
        clock: &Clock,
    ) {
        self[index].settled = self[index].take_settled(drives, axes, clock);
        if self[index].settled.is_some() {
            self.advance(index, axes, controls, clock);
            self[index].settled = None;
        }
    }
}

impl System {
    /// Converts an instant of the active move's variable to an instant in time, within this update.
    fn moment(&self, own: Instant, clock: &Clock) -> Moment {
        let time = self
            .follower
            .as_ref()
            .map_or(own, |follower| follower.instant_of(own, clock));
        Moment { own, time }
    }

    /// Checks that the oldest pending move can follow the active one by its variable (spec/coordinated-instructions.md §7.11, §8.7).
    /// Returns the instant at which it begins.
    fn promote(
        &mut self,
        last: Option<&Move<Planned>>,
        next: &Move<Planned>,
        moment: Moment,
        axes: &Axes,
        controls: &mut Controls,
        clock: &Clock,
    ) -> Result<Instant, MotionError> {
        if last.is_some_and(|last| last.parameter == next.parameter) {
            return Ok(moment.own);
        }
        verify_same_link(last, next)?;
        self.activate_link(next.data.driven_by, moment.time, axes, controls, clock)?;
        let follower = &self.follower;
        Ok(follower
            .as_ref()
            .map_or(moment.time, |_| Clock::of_displacement(0.0).now()))
    }

    /// Updates the system for the move that has become active.
    pub(crate) fn activate(&mut self, axes: &mut Axes, controls: &mut Controls, clock: &Clock) {
        self.shown = self.shown.of_next_move();
        self.ended = None;
        if let Some(active) = self.active() {
            let execution = active.execution;
            controls.write(execution, Flag::Ac.mask(), 0);
        }
        self.join_axes(axes);
        self.calculate(controls, clock);
    }

    /// Writes Calculated Data of the active move if its plan differs from the one that they were calculated for
    /// (spec/coordinated-instructions.md §9).
    pub(crate) fn calculate(&mut self, controls: &mut Controls, clock: &Clock) {
        let (plan, due) = self.calculated;
        let plans = self.travel.plans();
        if self.activity != Activity::Moving || plans == plan || clock.tick < due {
            return;
        }
        self.calculated.0 = plans;
        let Some(active) = self.active() else { return };
        let execution = active.execution;
        let Some(mut events) = active.events else { return };
        let base = self.time_base(clock);
        let answered = !self.travel.is_paused() && events.answer(|distance| self.travel.reaches(distance, &base));
        if !answered {
            let available = Flag::CalculatedDataAvailable.mask();
            controls.write(execution, 0, available);
            return;
        }
        if let Some(active) = self.travel.active_data() {
            active.events = Some(events);
        }
        controls.give(execution, &events);
    }

    /// The instant at which the axes of a move that waits for them came within the Actual Tolerance.
    fn take_settled(&mut self, drives: &dyn Drives, axes: &Axes, clock: &Clock) -> Option<Instant> {
        let reached = self.settling.take()?;
        let own = self.description.linear();
        let tolerance = self.travel.active()?.data.termination.tolerance()?;
        let stood = reached.elapsed(clock);
        if own.iter().any(|axis| axes[*axis].is_lost()) {
            return None;
        }
        let before_end_s = match drives.settled(own, tolerance, stood) {
            Settled::Within { before_end_s } => before_end_s,
            Settled::No => return None,
            Settled::Unknown => {
                let behind = own.iter().map(|axis| axes[*axis].behind());
                if behind.map(|error| error * error).sum::<f64>().sqrt() > tolerance {
                    return None;
                }
                0.0
            }
        };
        Some(reached.after(stood - before_end_s, clock))
    }
}

/// An instant of an update.
#[derive(Clone, Copy, Debug)]
struct Moment {
    /// In the variable of the active move.
    own: Instant,
    time: Instant,
}

/// Checks that a move has the same mode and master as the previous one; otherwise it cannot follow without rest
/// (spec/coordinated-instructions.md §7.11).
fn verify_same_link(last: Option<&Move<Planned>>, next: &Move<Planned>) -> Result<(), MotionError> {
    let link = |motion: &Move<Planned>| motion.data.driven_by.map(|driven_by| driven_by.link);
    match last {
        Some(last) if last.ending != Ending::Stop && link(last) != link(next) => {
            Err(MotionError::MdscInvalidModeOrMasterChange)
        }
        _ => Ok(()),
    }
}

/// Moves of one coordinate system that can end within one tick; further ones end in the next tick.
const MAX_ENDS_PER_TICK: usize = 64;
