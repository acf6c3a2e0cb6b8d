//! One coordinate system's active move, the end of the previous one, and the queue.
//!
//! Not here: moves, and the running move ([`crate::running`]), the look-ahead over the queue ([`crate::queue`]).

use std::collections::VecDeque;

use arcline_geometry::{Path, Point};
use arcline_profile::{DynamicsBits, KinematicState, Limits, Profile};

use crate::look_ahead::Plan;
use crate::merge_within::AxisLimitShare;
use crate::move_trajectory::{MoveTrajectory, Residual, Sample};
use crate::queue::Queue;
use crate::rotation_residual::RampingOut;
use crate::running::{AccelerationRemoval, Move, Parameter, Running, scaled_limits};
use crate::{Clock, Instant, MasterRate};

/// The queue has no room for another pending move.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct QueueFull;

/// One active move and up to `depth` pending ones.
#[derive(Debug)]
pub struct Planner<T> {
    pub(crate) active: Option<Running<T>>,
    /// The end of a previous move with which the active one blends.
    pub(crate) tail: Option<MoveTrajectory>,
    /// The limits for a stop of the rotation of that end, radians and seconds.
    pub(crate) tail_turns: Option<Limits>,
    /// The residual of a rotation that a merge took over.
    pub(crate) ramping_out: Option<RampingOut>,
    pub(crate) queue: Queue<T>,
    depth: usize,
    /// Seconds after the active trajectory's start at which the successor takes over, if before the programmed end.
    pub(crate) hand_over_at: Option<f64>,
    /// Paths of cancelled moves along which a stop of the active one may have to continue.
    trail: VecDeque<CancelledPath>,
    /// The path ends behind the trail.
    trail_ends: bool,
    /// Counts the plans of active moves.
    pub(crate) plans: u32,
    /// The share of the limits of the axes for the active move, if they are enforced.
    pub(crate) within: Option<AxisLimitShare>,
    /// The Dynamics Configuration Bits.
    pub(crate) dynamics_bits: DynamicsBits,
}

/// A path behind the active one, of a move that was cancelled.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CancelledPath {
    pub(crate) path: Path,
    /// The highest speed at which the axes can follow the corner before it, units/s.
    corner: f64,
}

impl CancelledPath {
    /// The path, and the highest speed at the corner before it.
    fn path_and_corner_speed(&self) -> (&Path, f64) {
        (&self.path, self.corner)
    }
}

/// The beginning of a move that becomes the active one.
#[derive(Clone, Copy)]
pub(crate) struct RunStart {
    /// The motion along its path.
    pub(crate) from: KinematicState,
    pub(crate) at: Instant,
    /// Terminated motion that ramps out beside it.
    pub(crate) residual: Option<Residual>,
    /// Its predecessor moves with it at first.
    pub(crate) blended: bool,
}

impl RunStart {
    /// From a motion along the path, alone.
    pub(crate) fn new(from: KinematicState, at: Instant) -> RunStart {
        RunStart {
            from,
            at,
            residual: None,
            blended: false,
        }
    }
}

impl<T: Copy> Planner<T> {
    /// A planner at rest with room for `depth` pending moves. `corner_step`: the largest velocity step of each axis at a corner that is not
    /// tangent, units/s. The only allocation.
    pub fn new(depth: usize, corner_step: Point) -> Self {
        Planner {
            active: None,
            tail: None,
            tail_turns: None,
            ramping_out: None,
            queue: Queue::new(depth, corner_step),
            depth,
            hand_over_at: None,
            trail: VecDeque::with_capacity(depth),
            trail_ends: false,
            plans: 0,
            within: None,
            dynamics_bits: DynamicsBits::ALL,
        }
    }

    /// Sets the Dynamics Configuration Bits for later instructions. At first all are set.
    pub fn set_dynamics_bits(&mut self, dynamics_bits: DynamicsBits) {
        self.dynamics_bits = dynamics_bits;
    }

    /// Sets the update period, seconds: corners within one update change the velocity of an axis by no more than a single corner may.
    #[must_use]
    pub fn with_period(mut self, period: f64) -> Self {
        self.queue.set_period(period);
        self
    }

    /// The active move.
    pub fn active(&self) -> Option<&Running<T>> {
        self.active.as_ref()
    }

    /// The active move's data, mutable.
    pub fn active_data(&mut self) -> Option<&mut T> {
        self.active.as_mut().map(|running| &mut running.motion.data)
    }

    /// The oldest pending move.
    pub fn next(&self) -> Option<Move<T>> {
        self.queue.front().copied()
    }

    /// The pending moves, oldest first.
    pub fn pending(&self) -> impl DoubleEndedIterator<Item = &Move<T>> {
        self.queue.iter()
    }

    /// The newest pending move.
    pub fn last_pending(&self) -> Option<&Move<T>> {
        self.queue.back()
    }

    /// The queue has no room for another pending move.
    pub fn is_full(&self) -> bool {
        self.room() == 0
    }

    /// The number of further moves until `depth` of them wait behind the active one.
    pub fn room(&self) -> usize {
        self.depth.saturating_sub(self.queue.len())
    }

    /// Programmed end point of the last move in the queue, at which the next one begins.
    pub fn last_end(&self) -> Option<Point> {
        let last = self.queue.back();
        last.map(|waiting| waiting.path.end())
            .or_else(|| self.active.as_ref().map(|running| running.motion.path.end()))
    }

    /// Starts a move from rest at an instant, in place of the active one.
    pub fn start(&mut self, motion: Move<T>, at: Instant, clock: &Clock) {
        self.tail = None;
        self.queue.forget_corners();
        self.run(motion, RunStart::new(KinematicState::default(), at), clock);
    }

    /// Adds a move at the end of the queue. The end of the active move may change with it.
    ///
    /// # Errors
    /// [`QueueFull`] if the queue has no room.
    pub fn enqueue(&mut self, motion: Move<T>, clock: &Clock) -> Result<(), QueueFull> {
        if self.is_full() {
            return Err(QueueFull);
        }
        let active = self.active.as_ref();
        self.queue.push(
            motion,
            active.map(|running| (&running.motion, running.blended, running.run_start)),
        );
        self.raise_exit(clock);
        self.schedule(clock.now(), clock);
        Ok(())
    }

    /// Continues the look-ahead if it was too long for one tick: to be called in every tick, after all events of [`Planner::event`].
    pub fn continue_look_ahead(&mut self, clock: &Clock) {
        if self.queue.continue_pass() {
            self.raise_exit(clock);
            self.schedule(clock.now(), clock);
        }
    }

    /// The active move rests before its end until its speed changes.
    pub fn is_paused(&self) -> bool {
        self.active
            .as_ref()
            .is_some_and(|running| !running.trajectory.profile.arrives())
    }

    /// A number that changes whenever another move becomes active, or the active one is planned again.
    pub fn plans(&self) -> u32 {
        self.plans
    }

    /// The active move continues into its successor without rest.
    pub fn passes_on(&self) -> bool {
        self.active.as_ref().is_some_and(|running| running.exit > 0.0) && self.queue.front().is_some()
    }

    /// Removes the active move.
    pub fn clear_active(&mut self) -> Option<T> {
        self.clear_trail();
        self.tail = None;
        self.ramping_out = None;
        self.within = None;
        self.hand_over_at = None;
        self.active.take().map(|running| running.motion.data)
    }

    /// Removes the oldest pending move from the queue. If the profile of the active move crosses it, or keeps its speed for it, its
    /// path stays for [`Planner::stop`].
    pub fn cancel_pending(&mut self) -> Option<T> {
        self.hand_over_at = None;
        let passed = self.queue.is_passed_to();
        let corner = self.queue.corner();
        let cancelled = self.queue.pop()?;
        self.trail_ends |= !self.continues_onto(self.trail.len(), passed);
        if !self.trail_ends {
            self.trail.push_back(CancelledPath {
                path: cancelled.path,
                corner: corner * cancelled.parameter.speed,
            });
        }
        Some(cancelled.data)
    }

    /// The profile of the active move, or its exit speed, continues onto the pending move with this index. `is_passed_to`: there is no
    /// rest before that move.
    fn continues_onto(&self, index: usize, is_passed_to: bool) -> bool {
        self.active
            .is_some_and(|running| index < running.joined || (running.exit > 0.0 && is_passed_to))
    }

    fn clear_trail(&mut self) {
        self.trail.clear();
        self.trail_ends = false;
    }

    /// Two moves are superposed at the present tick.
    pub fn in_transition(&self, clock: &Clock) -> bool {
        self.tail
            .is_some_and(|tail| tail.start.elapsed(clock) < tail.duration(clock))
    }

    /// Brakes the active move on its path from the present tick on, and the end of a move that still blends with it. The path continues along the
    /// cancelled moves that the profile was to cross.
    pub fn stop(&mut self, limits: &Limits, clock: &Clock) {
        self.hand_over_at = None;
        let limits = &self.allowed(limits);
        let before = self.before();
        let running = self.active.iter_mut().map(|running| (&mut running.trajectory, before));
        for (trajectory, before) in running.chain(self.tail.iter_mut().map(|tail| (tail, None))) {
            let stop = trajectory.stop_from(trajectory.state(clock), limits, before.as_ref(), self.dynamics_bits);
            trajectory.replan(stop, clock.now());
        }
        if let Some(running) = &mut self.active {
            running.exit = 0.0;
            running.joined = 0;
            running.stopped = true;
        }
        self.end_trail();
    }

    /// Ends the trail before the first corner that a stop, which may be a gentle one, would pass faster than the axes can follow it.
    pub(crate) fn end_trail(&mut self) {
        let Some(trajectory) = self.active.as_ref().map(|running| &running.trajectory) else {
            return;
        };
        let followed = trajectory.followed(self.trail.iter().map(CancelledPath::path_and_corner_speed));
        self.trail.truncate(followed);
    }

    /// The paths along which a stop that began now could continue, with the highest speeds at the corners before them: those of cancelled moves,
    /// and those of the pending moves whose paths [`Planner::cancel_pending`] would keep.
    pub(crate) fn paths_of_stop(&self) -> impl Iterator<Item = (&Path, f64)> {
        let pending = (self.trail.len()..).zip(self.queue.junctions());
        let followed = pending
            .take_while(|(index, (_, passed, _))| !self.trail_ends && self.continues_onto(*index, *passed))
            .map(|(_, (motion, _, corner))| (&motion.path, corner * motion.parameter.speed));
        self.trail
            .iter()
            .map(CancelledPath::path_and_corner_speed)
            .chain(followed)
    }

    /// As [`Planner::stop`], for an active move that is a function of a master's displacement: `clock` shows the displacement, and `rate` is its
    /// rate. From now on the planner's clock is `time`.
    pub fn stop_in_time(&mut self, limits: &Limits, rate: &MasterRate, clock: &Clock, time: &Clock) {
        self.hand_over_at = None;
        self.ramp_out_in_time(rate, clock, time);
        let running = self.active.iter_mut().map(|running| &mut running.trajectory);
        for trajectory in running.chain(&mut self.tail) {
            trajectory.stop_in_time(limits, self.dynamics_bits, rate, clock, time);
        }
        if let Some(running) = &mut self.active {
            running.motion.parameter = Parameter::TIME;
            running.begun = time.now();
            running.exit = 0.0;
            running.joined = 0;
            running.stopped = true;
        }
        self.end_trail();
    }

    /// The motion of the coordinate system at the present tick.
    pub fn sample(&self, clock: &Clock) -> Option<Sample> {
        let mut sample = self.active.as_ref()?.trajectory.sample_along(self.trail(), clock);
        if let Some(tail) = &self.tail {
            sample = tail.add_rest(sample, clock);
        }
        if let Some(out) = &self.ramping_out {
            sample.rotation_state = Some(out.beside(sample.rotation_state, clock));
        }
        Some(sample)
    }

    /// Paths of cancelled moves behind the active one.
    pub(crate) fn trail(&self) -> impl Iterator<Item = &Path> {
        self.trail.iter().map(|beyond| &beyond.path)
    }

    pub(crate) fn run(&mut self, motion: Move<T>, start: RunStart, clock: &Clock) {
        let RunStart {
            from,
            at,
            residual,
            blended,
        } = start;
        let trajectory = MoveTrajectory {
            path: motion.path,
            rotation: motion.rotation,
            run_up: None,
            approach: None,
            profile: Profile::rest(0.0),
            start: at,
            offset: 0.0,
            residual,
        };
        let running = Running {
            blended,
            ..Running::new(motion, trajectory)
        };
        self.begin(running, from, clock);
    }

    /// As [`Planner::run`] at the present tick, from another motion along the path.
    pub(crate) fn run_with_removal(
        &mut self,
        motion: Move<T>,
        from: KinematicState,
        removal: AccelerationRemoval,
        clock: &Clock,
    ) {
        self.run(motion, RunStart::new(from, clock.now()), clock);
        let Some(mut running) = self.active else { return };
        running.removal = removal;
        let (plan, profile) = self.planned(&running, from);
        running.aim(&plan);
        running.trajectory.profile = profile;
        self.active = Some(running);
        self.schedule(clock.now(), clock);
    }

    /// As [`Planner::run`] at the present tick, beside a residual; along a given profile, if there is one.
    pub(crate) fn run_beside(
        &mut self,
        motion: Move<T>,
        residual: Residual,
        from: KinematicState,
        along: Option<Profile>,
        clock: &Clock,
    ) {
        let start = RunStart {
            residual: Some(residual),
            ..RunStart::new(from, clock.now())
        };
        self.run(motion, start, clock);
        if let (Some(running), Some(along)) = (&mut self.active, along) {
            running.trajectory.profile = along;
            self.schedule(clock.now(), clock);
        }
    }

    /// Begins a move on a trajectory, and plans its profile from `from`, which may be in the removal of an acceleration.
    pub(crate) fn begin(&mut self, mut running: Running<T>, from: KinematicState, clock: &Clock) {
        self.clear_trail();
        running.run_start = self.queue.relink(&running.motion, running.blended);
        if running.removal.ceiling.is_infinite() && self.dynamics_bits.overshoot {
            running.removal = AccelerationRemoval::FORWARD;
        }
        let (plan, profile) = self.planned(&running, from);
        running.aim(&plan);
        running.trajectory.profile = profile;
        self.active = Some(running);
        self.schedule(running.begun, clock);
    }

    /// The aim of a move's profile, and the profile, after the removal of a present acceleration.
    pub(crate) fn planned(&self, running: &Running<T>, from: KinematicState) -> (Plan, Profile) {
        let removal_phase = running.removal.phase(from, &self.limits(running));
        let level = removal_phase.map_or(from, |phase| phase.end());
        let plan = self.plan(running, level);
        let profile = self.profile(running, level, &plan);
        (plan, removal_phase.map_or(profile, |phase| phase.then(&profile)))
    }

    /// The limits of the active profile, including the override.
    pub fn before(&self) -> Option<Limits> {
        let rate = self.queue.rate();
        self.active
            .as_ref()
            .map(|running| scaled_limits(&running.in_force, rate, 1.0))
    }

    /// The acceleration from the curvature of the paths at the present tick: it ends with them, and is not limited.
    pub fn centripetal(&self, clock: &Clock) -> Point {
        let trajectories = self.active.iter().map(|running| &running.trajectory).chain(&self.tail);
        trajectories.map(|trajectory| trajectory.centripetal(clock)).sum()
    }
}
