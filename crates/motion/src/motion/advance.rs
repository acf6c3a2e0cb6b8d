//! Coordinate systems from one tick to the next: ends of moves and stops that lie before it, set-points, tolerances.
//!
//! Real-time: no allocation; bounded by the axes and coordinate systems and by [`MAX_ENDS_PER_TICK`]. Positions are
//! position units, times seconds.

use arcline_drive::{Drives, Settled};
use arcline_instruction_set::{AxisId, Flag, MotionError, SystemId};
use arcline_planner::geometry::Point;
use arcline_planner::profile::{KinematicState, Phase};
use arcline_planner::{Clock, Ending, Instant, Move, MoveEvent, Sample};

use super::Motion;
use crate::axes::Axes;
use crate::axis::Axis;
use crate::axis::generator_kind::GeneratorKind;
use crate::cause::Cause;
use crate::status::phase_flags;
use crate::stop::AxisSet;
use crate::system::{Activity, Planned, Shown, component, numbered};

impl Motion {
    pub(crate) fn advance_system(&mut self, index: SystemId) {
        let system = &mut self.systems[index];
        let base = system.time_base(&self.clock);
        system.travel.steer(&base);
        for _ in 0..MAX_ENDS_PER_TICK {
            let system = &self.systems[index];
            if system.follower.is_some_and(|follower| follower.has_position_lock()) {
                break;
            }
            let moment = match system.travel.event(&system.time_base(&self.clock)) {
                None => break,
                Some(MoveEvent::HandOver(at)) => self.moment(index, at),
                Some(MoveEvent::Reached(at)) => match self.reached(index, at) {
                    Some(moment) => moment,
                    None => break,
                },
            };
            self.complete(index, moment);
            if !self.systems[index].is_busy() {
                break;
            }
        }
        let system = &mut self.systems[index];
        let base = system.time_base(&self.clock);
        system.travel.look_on(&base);
        if self.systems[index].is_busy() {
            self.sample_system(index);
        }
    }

    /// An instant of this update by what the active move is a function of, and in time.
    fn moment(&self, index: SystemId, own: Instant) -> Moment {
        let follower = &self.systems[index].follower;
        let time = follower
            .as_ref()
            .map_or(own, |follower| follower.instant_of(own, &self.clock));
        Moment { own, time }
    }

    /// The command is at the programmed end, or where a stop has led it. The instant at which the active
    /// move is complete, if it is.
    fn reached(&mut self, index: SystemId, at: Instant) -> Option<Moment> {
        if self.systems[index].activity == Activity::Stopping {
            self.sample_system(index);
            self.retired.extend(self.systems[index].travel.clear());
            self.release_axes(index);
            return None;
        }
        let moment = self.moment(index, at);
        if self.systems[index].travel.passes_on() {
            return Some(moment);
        }
        self.set_end_position(index);
        let active = self.systems[index].travel.active()?;
        if !active.data.termination.settles() {
            return Some(moment);
        }
        let system = &mut self.systems[index];
        // Where the end was come to inside an earlier update, the displacement of the master tells no more when that was.
        let time = match system.follower {
            Some(_) => *system.ended.get_or_insert(moment.time),
            None => moment.time,
        };
        let time = self.settled(index, time)?;
        let follower = &self.systems[index].follower;
        let own = follower
            .as_ref()
            .map_or(time, |follower| follower.displacement_at(time, &self.clock));
        Some(Moment { own, time })
    }

    /// The active move is complete; the next one becomes active at the same instant. One that cannot fails, and the move
    /// before it ends as if there had been none: those behind it would begin elsewhere, and are cancelled.
    fn complete(&mut self, index: SystemId, moment: Moment) {
        let last = self.systems[index].travel.active().copied();
        if let Some(last) = &last {
            self.end_move(last.data.execution, Flag::Pc.mask());
            self.systems[index].shown.in_actual_tolerance = last.data.termination.settles();
        }
        if let Some(next) = self.systems[index].travel.next() {
            self.controls.because(next.data.execution.into());
            let promoted = self.promote(index, last.as_ref(), &next, moment);
            if let Ok(at) = promoted {
                let system = &mut self.systems[index];
                let base = system.time_base(&self.clock);
                system.travel.hand_over(at, &base);
                self.activate(index);
            } else if let Err(error) = promoted {
                self.controls.fail(next.data.execution, error, self.clock.tick);
                self.systems[index].travel.cancel_waiting();
                self.cancel_pending(index);
            }
            self.controls.because(Cause::Itself);
            if promoted.is_ok() {
                return;
            }
        }
        let base = self.systems[index].time_base(&self.clock);
        self.retired.extend(self.systems[index].travel.end(&base));
        self.release_axes(index);
        self.refuse_next(index, last.as_ref());
        // What still waits is planned as a contour now.
        let system = &mut self.systems[index];
        if system.travel.waiting().next().is_some() {
            system.activity = Activity::Moving;
        }
    }

    /// Whether the oldest pending move can follow the active one, and by what it is a function of (spec/coordinated-instructions.md §7.11, §8.7). The instant at
    /// which it begins.
    fn promote(
        &mut self,
        index: SystemId,
        last: Option<&Move<Planned>>,
        next: &Move<Planned>,
        moment: Moment,
    ) -> Result<Instant, MotionError> {
        if last.is_some_and(|last| last.parameter == next.parameter) {
            return Ok(moment.own);
        }
        verify_same_link(last, next)?;
        self.lead_system(index, next.data.driven_by, moment.time)?;
        let follower = &self.systems[index].follower;
        Ok(follower
            .as_ref()
            .map_or(moment.time, |_| Clock::of_displacement(0.0).now()))
    }

    /// A move that would have to follow the one that has just ended without rest, and cannot.
    fn refuse_next(&mut self, index: SystemId, last: Option<&Move<Planned>>) {
        let next = self.systems[index].travel.waiting().next();
        if let Some(Err(error)) = next.map(|next| verify_same_link(last, next)) {
            self.refuse(index, error);
        }
    }

    /// The move that was to begin cannot: it errs, and those behind it are cancelled.
    pub(crate) fn refuse(&mut self, index: SystemId, error: MotionError) {
        let (refused, trajectory) = self.systems[index].travel.refuse();
        self.retired.extend(trajectory);
        if let Some(refused) = refused {
            self.controls.fail(refused.execution, error, self.clock.tick);
            self.controls.because(refused.execution.into());
        }
        self.cancel_pending(index);
        self.controls.because(Cause::Itself);
    }

    /// Another move has become the active one.
    pub(crate) fn activate(&mut self, index: SystemId) {
        let system = &mut self.systems[index];
        system.shown = system.shown.of_next_move();
        system.ended = None;
        if let Some(active) = system.active() {
            let execution = active.execution;
            self.controls.write(execution, Flag::Ac.mask(), 0, self.clock.tick);
        }
        self.join_axes(index);
        self.calculate(index);
    }

    /// Calculated Data of the active move, if its plan is another one than it was computed of (spec/coordinated-instructions.md §9).
    pub(crate) fn calculate(&mut self, index: SystemId) {
        let system = &mut self.systems[index];
        let (plan, due) = system.calculated;
        let plans = system.travel.plans();
        if system.activity != Activity::Moving || plans == plan || self.clock.tick < due {
            return;
        }
        system.calculated.0 = plans;
        let Some(active) = system.active() else { return };
        let execution = active.execution;
        let Some(mut events) = active.events else { return };
        let base = system.time_base(&self.clock);
        let answered = !system.travel.is_paused() && events.answer(|distance| system.travel.reaches(distance, &base));
        if !answered {
            let available = Flag::CalculatedDataAvailable.mask();
            self.controls.write(execution, 0, available, self.clock.tick);
            return;
        }
        if let Some(active) = system.travel.active_data() {
            active.events = Some(events);
        }
        self.give(execution, &events);
    }

    /// The commands stand exactly on the programmed end of the active move.
    fn set_end_position(&mut self, index: SystemId) {
        if let Some(active) = self.systems[index].travel.active() {
            let end = active.path.end();
            self.hold_at(index, &end);
            self.hold_heading(index);
        }
    }

    /// The commands stand exactly on a point.
    fn hold_at(&mut self, index: SystemId, end: &Point) {
        for (member, axis) in numbered(self.systems[index].description.linear()) {
            if let Some(axis) = self.axes.get_mut(axis) {
                axis.set_coordinated(KinematicState {
                    position: component(end, member),
                    ..Default::default()
                });
            }
        }
    }

    /// Commands of a system's axes at the present tick, and ACCEL and DECEL of its active instruction.
    pub(crate) fn sample_system(&mut self, index: SystemId) {
        let system = &mut self.systems[index];
        let base = system.time_base(&self.clock);
        let Some((sample, planned)) = system.travel.sample(&base) else {
            return;
        };
        let length = system.travel.length();
        // The vector of all that it moves X, Y and Z with; a move that only turns has a speed by its angle.
        let only_turns = system.active().is_some_and(|active| active.only_turns);
        let speed = match sample.velocity.norm() {
            0.0 if only_turns => sample.along.velocity.abs(),
            speed => speed,
        };
        // Nothing has begun while a lock is waited for.
        let waits = system.follower.is_some_and(|follower| !follower.has_begun());
        let phase = if waits { Phase::Steady } else { sample.phase };
        let (moves, trend) = match &system.follower {
            // Its master may stand.
            Some(_) => (sample.along.velocity != 0.0, sample.along.phase()),
            None => (!system.travel.is_paused() && length > 0.0, phase),
        };
        system.shown = Shown {
            in_transition: system.travel.in_transition(&base),
            has_moved: system.shown.has_moved || moves,
            trend,
            speed,
            distance: sample.along.position.clamp(0.0, length),
            length,
            ..system.shown
        };
        set_commands(system.description.linear(), &mut self.axes, &sample);
        self.set_turned_commands(index, &sample);
        let system = &mut self.systems[index];
        let Some(execution) = system.active().map(|active| active.execution) else {
            return;
        };
        let tick = self.clock.tick;
        if system.activity == Activity::Moving && phase != system.shown.phase {
            system.shown.phase = phase;
            let (set, clear) = phase_flags(phase);
            self.controls.write(execution, set, clear, tick);
        }
        let tracking = system.is_tracking(planned);
        if std::mem::replace(&mut system.shown.tracking, tracking) != tracking {
            self.controls.flag(execution, Flag::TrackingMaster, tracking, tick);
        }
    }

    /// The axes' part of a coordinated move that has just begun, so that others of the same tick see it.
    pub(crate) fn set_axis_commands(&mut self, index: SystemId) {
        let system = &self.systems[index];
        if let Some((sample, _)) = system.travel.sample(&system.time_base(&self.clock)) {
            set_commands(system.description.linear(), &mut self.axes, &sample);
            self.set_turned_commands(index, &sample);
        }
    }

    /// The instant at which the axes came within the Actual Tolerance of the end at which their commands stand since `reached`: at
    /// once where every axis follows exactly, otherwise as the last exchange said. Unknown as yet, it is asked for behind the next
    /// one.
    pub(crate) fn settled(&mut self, index: SystemId, reached: Instant) -> Option<Instant> {
        let system = &mut self.systems[index];
        let axes = system.description.linear();
        let stood = reached.elapsed(&self.clock);
        for axis in axes {
            self.axes[*axis].link.stood = stood;
        }
        if axes.iter().all(|axis| self.axes[*axis].follows_exactly()) {
            return Some(reached);
        }
        if let Some(settled) = system.settled.take() {
            return Some(settled);
        }
        system.settling = Some(reached);
        None
    }

    /// A move that waits for its axes goes on at the instant at which they came within the tolerance: the position of its successor at
    /// this tick is known now, and goes out at the next one.
    pub(super) fn finish_settling(&mut self, index: SystemId, drives: &dyn Drives) {
        let system = &mut self.systems[index];
        let Some(reached) = system.settling.take() else {
            return;
        };
        let (axes, tolerance) = (system.description.linear(), system.description.actual_tolerance);
        let stood = reached.elapsed(&self.clock);
        if axes.iter().any(|axis| self.axes[*axis].is_lost()) {
            return;
        }
        let before_end_s = match drives.settled(axes, tolerance, stood) {
            Settled::Within { before_end_s } => before_end_s,
            Settled::No => return,
            Settled::Unknown => {
                let behind = axes.iter().map(|axis| self.axes[*axis].behind());
                if behind.map(|error| error * error).sum::<f64>().sqrt() > tolerance {
                    return;
                }
                0.0
            }
        };
        system.settled = Some(reached.after(stood - before_end_s, &self.clock));
        self.advance_system(index);
        self.systems[index].settled = None;
    }

    /// Axes that stand, or that another move has taken, brake no more.
    pub(super) fn finish_braking(&mut self, index: SystemId) {
        if !self.systems[index].brakes(&self.axes) {
            self.systems[index].braking = AxisSet::default();
        }
    }

    pub(super) fn finish_stop(&mut self, index: SystemId) {
        let system = &self.systems[index];
        let Some(stop) = system.stop else {
            return;
        };
        let braking = |(id, axis): (AxisId, &Axis)| stop.braking.contains(id) && axis.is_braking();
        if system.activity == Activity::Stopping
            || (!stop.braking.is_empty() && self.axes.ids().zip(self.axes.iter()).any(braking))
        {
            return;
        }
        self.systems[index].stop = None;
        self.controls
            .write(stop.execution, Flag::Pc.mask(), Flag::Ip.mask(), self.clock.tick);
    }

    pub(super) fn update_tolerances(&mut self) {
        for system in self.systems.iter_mut() {
            if system.activity != Activity::Moving {
                continue;
            }
            if let Some(end) = system.travel.active().map(|active| active.path.end()) {
                let axes = &self.axes;
                let squares = numbered(system.description.linear()).map(|(member, axis)| {
                    let generator = axes.get(axis).and_then(|axis| axis.sum.get(GeneratorKind::System));
                    let left = generator.map_or(0.0, |generator| generator.now.position) - component(&end, member);
                    left * left
                });
                system.shown.in_command_tolerance = squares.sum::<f64>().sqrt() < system.description.command_tolerance;
            }
        }
    }
}

/// An instant of an update.
#[derive(Clone, Copy, Debug)]
struct Moment {
    /// By what the active move is a function of.
    own: Instant,
    time: Instant,
}

/// A move of another mode or master than the one before cannot follow that without rest (spec/coordinated-instructions.md §7.11).
fn verify_same_link(last: Option<&Move<Planned>>, next: &Move<Planned>) -> Result<(), MotionError> {
    let link = |motion: &Move<Planned>| motion.data.driven_by.map(|driven_by| driven_by.link);
    match last {
        Some(last) if last.ending != Ending::Stop && link(last) != link(next) => {
            Err(MotionError::MdscInvalidModeOrMasterChange)
        }
        _ => Ok(()),
    }
}

fn set_commands(members: &[AxisId], axes: &mut Axes, sample: &Sample) {
    for (member, axis) in numbered(members) {
        if let Some(axis) = axes.get_mut(axis) {
            axis.set_coordinated(KinematicState {
                position: component(&sample.position, member),
                velocity: component(&sample.velocity, member),
                acceleration: component(&sample.acceleration, member),
            });
        }
    }
}

/// Moves of one coordinate system that can end within one tick; the rest end in the next one.
const MAX_ENDS_PER_TICK: usize = 64;
