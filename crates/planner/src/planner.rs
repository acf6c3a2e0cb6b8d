//! One coordinate system's active move, the end of the one before it, and its queue.
//!
//! Not here: moves, and the running move ([`crate::running`]), the look-ahead over the queue ([`crate::queue`]).

use std::collections::VecDeque;

use arcline_geometry::{Path, Point};
use arcline_profile::{Bounds, KinematicState, Limits, Profile};

use crate::look_ahead::Plan;
use crate::merge_within::Within;
use crate::move_trajectory::{MoveTrajectory, Residual, Sample};
use crate::queue::Queue;
use crate::rotation_residual::RampingOut;
use crate::running::{AccelerationRemoval, Move, Parameter, Running, scaled_limits};
use crate::{Clock, Instant, MasterRate};

/// The pending places are all taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct QueueFull;

/// One active move and up to `depth` pending ones.
#[derive(Debug)]
pub struct Planner<T> {
    pub(crate) active: Option<Running<T>>,
    /// The end of a move that the active one blends with.
    pub(crate) tail: Option<MoveTrajectory>,
    /// The limits of a stop of the rotation of that end, radians and seconds.
    pub(crate) tail_turns: Option<Limits>,
    /// The rest of a rotation that a merge took over.
    pub(crate) ramping_out: Option<RampingOut>,
    pub(crate) queue: Queue<T>,
    depth: usize,
    /// Seconds after the active trajectory's start at which the successor takes over before the programmed end.
    pub(crate) hand_over_at: Option<f64>,
    /// Paths of cancelled moves along which a stop of the active one may have to go on.
    trail: VecDeque<Beyond>,
    /// The path does not go on behind the trail.
    trail_ends: bool,
    /// Counts the plans of active moves.
    pub(crate) plans: u32,
    /// The share of the limits of the axes that the active move may use, where these are kept.
    pub(crate) within: Option<Within>,
    /// The Dynamics Configuration Bits.
    pub(crate) bounds: Bounds,
}

/// A path behind the active one, of a move that was cancelled.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Beyond {
    pub(crate) path: Path,
    /// The highest speed at which the axes can follow the corner before it, units/s.
    corner: f64,
}

impl Beyond {
    /// The path and the highest speed of the corner before it.
    fn joint(&self) -> (&Path, f64) {
        (&self.path, self.corner)
    }
}

impl<T: Copy> Planner<T> {
    /// A planner at rest with `depth` pending places. `corner_step`: the change of velocity that each axis may
    /// make at once in a corner that is not tangent, units/s. The only allocation.
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
            bounds: Bounds::ALL,
        }
    }

    /// Sets the Dynamics Configuration Bits, which count from the next instruction on. All are set at first.
    pub fn set_bounds(&mut self, bounds: Bounds) {
        self.bounds = bounds;
    }

    /// The same for updates of a period, seconds: corners that lie within one update change the velocity of an axis by no more
    /// than one corner may.
    #[must_use]
    pub fn with_period(mut self, period: f64) -> Self {
        self.queue.set_period(period);
        self
    }

    /// The active move.
    pub fn active(&self) -> Option<&Running<T>> {
        self.active.as_ref()
    }

    /// The active move's data, to change.
    pub fn active_data(&mut self) -> Option<&mut T> {
        self.active.as_mut().map(|running| &mut running.motion.data)
    }

    /// The oldest move that waits.
    pub fn next(&self) -> Option<Move<T>> {
        self.queue.front().copied()
    }

    /// The moves that wait, oldest first.
    pub fn pending(&self) -> impl DoubleEndedIterator<Item = &Move<T>> {
        self.queue.iter()
    }

    /// The newest move that waits.
    pub fn last_pending(&self) -> Option<&Move<T>> {
        self.queue.back()
    }

    /// Whether every pending place is taken.
    pub fn is_full(&self) -> bool {
        self.room() == 0
    }

    /// How many moves it takes until `depth` of them wait behind the active one.
    pub fn room(&self) -> usize {
        self.depth.saturating_sub(self.queue.len())
    }

    /// Programmed end point of the last move in the queue: where the next one begins.
    pub fn last_end(&self) -> Option<Point> {
        let last = self.queue.back();
        last.map(|waiting| waiting.path.end())
            .or_else(|| self.active.map(|running| running.motion.path.end()))
    }

    /// Starts a move from rest at an instant, in place of whatever was active.
    pub fn start(&mut self, motion: Move<T>, at: Instant, clock: &Clock) {
        self.tail = None;
        self.queue.forget_corners();
        self.run(motion, KinematicState::default(), at, None, false, clock);
    }

    /// Puts a move behind the last one. What the active one does at its end may change with it.
    ///
    /// # Errors
    /// [`QueueFull`] when all pending places are taken.
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

    /// Goes on with the look-ahead where it was too long for one tick: to be called at every tick, after
    /// all that [`Planner::event`] tells.
    pub fn look_on(&mut self, clock: &Clock) {
        if self.queue.continue_pass() {
            self.raise_exit(clock);
            self.schedule(clock.now(), clock);
        }
    }

    /// Whether the active move stays at rest before its end, until its speed is changed.
    pub fn is_paused(&self) -> bool {
        self.active.is_some_and(|running| !running.trajectory.profile.arrives())
    }

    /// A number that changes whenever the active move is another one or planned again.
    pub fn plans(&self) -> u32 {
        self.plans
    }

    /// Whether the active move goes over into its successor without rest.
    pub fn passes_on(&self) -> bool {
        self.active.is_some_and(|running| running.exit > 0.0) && self.queue.front().is_some()
    }

    /// Ends the active move and forgets it.
    pub fn clear_active(&mut self) -> Option<T> {
        self.clear_trail();
        self.tail = None;
        self.ramping_out = None;
        self.within = None;
        self.hand_over_at = None;
        self.active.take().map(|running| running.motion.data)
    }

    /// Takes the oldest pending move out of the queue. Where the profile of the active one leads over it, or the speed was kept for
    /// it, its path is kept for [`Planner::stop`].
    pub fn cancel_pending(&mut self) -> Option<T> {
        self.hand_over_at = None;
        let passed = self.queue.is_passed_to();
        let corner = self.queue.corner();
        let cancelled = self.queue.pop()?;
        self.trail_ends |= !self.leads_over(self.trail.len(), passed);
        if !self.trail_ends {
            self.trail.push_back(Beyond {
                path: cancelled.path,
                corner: corner * cancelled.parameter.speed,
            });
        }
        Some(cancelled.data)
    }

    /// Whether the profile of the active move, or the speed that it keeps, leads over the move so many places behind it. A move is
    /// passed to when no rest is asked for before it.
    fn leads_over(&self, index: usize, is_passed_to: bool) -> bool {
        self.active
            .is_some_and(|running| index < running.joined || (running.exit > 0.0 && is_passed_to))
    }

    fn clear_trail(&mut self) {
        self.trail.clear();
        self.trail_ends = false;
    }

    /// Whether two moves are superposed at the present tick.
    pub fn in_transition(&self, clock: &Clock) -> bool {
        self.tail
            .is_some_and(|tail| tail.start.elapsed(clock) < tail.duration(clock))
    }

    /// Brakes the active move on its path from the present tick on, and what still blends with it. The path goes on
    /// along the cancelled moves that the profile was leading over.
    pub fn stop(&mut self, limits: &Limits, clock: &Clock) {
        self.hand_over_at = None;
        let limits = &self.allowed(limits);
        let before = self.before();
        let running = self.active.iter_mut().map(|running| (&mut running.trajectory, before));
        for (trajectory, before) in running.chain(self.tail.iter_mut().map(|tail| (tail, None))) {
            let stop = trajectory.stop_from(trajectory.state(clock), limits, before.as_ref(), self.bounds);
            trajectory.replan(stop, clock.now());
        }
        if let Some(running) = &mut self.active {
            running.exit = 0.0;
            running.joined = 0;
            running.stopped = true;
        }
        self.end_trail();
    }

    /// A trail ends before the first corner that a stop, which may be a gentle one, would pass faster than the axes can follow it.
    pub(crate) fn end_trail(&mut self) {
        let Some(trajectory) = self.active.as_ref().map(|running| &running.trajectory) else {
            return;
        };
        let followed = trajectory.followed(self.trail.iter().map(Beyond::joint));
        self.trail.truncate(followed);
    }

    /// The paths along which a stop that began now could lead, with the highest speeds of the corners before them: those of cancelled moves,
    /// and those of the pending moves that [`Planner::cancel_pending`] would keep.
    pub(crate) fn beyond(&self) -> impl Iterator<Item = (&Path, f64)> {
        let pending = (self.trail.len()..).zip(self.queue.joints());
        let kept = pending
            .take_while(|(index, (_, passed, _))| !self.trail_ends && self.leads_over(*index, *passed))
            .map(|(_, (motion, _, corner))| (&motion.path, corner * motion.parameter.speed));
        self.trail.iter().map(Beyond::joint).chain(kept)
    }

    /// As [`Planner::stop`], for an active move that is a function of a master's displacement: `clock` shows it, and `rate` how it goes
    /// on. From now on the planner's clock is `time`.
    pub fn stop_in_time(&mut self, limits: &Limits, rate: &MasterRate, clock: &Clock, time: &Clock) {
        self.hand_over_at = None;
        self.ramp_out_in_time(rate, clock, time);
        let running = self.active.iter_mut().map(|running| &mut running.trajectory);
        for trajectory in running.chain(&mut self.tail) {
            trajectory.stop_in_time(limits, self.bounds, rate, clock, time);
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

    /// Where the coordinate system is at the present tick.
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

    pub(crate) fn run(
        &mut self,
        motion: Move<T>,
        from: KinematicState,
        at: Instant,
        residual: Option<Residual>,
        blended: bool,
        clock: &Clock,
    ) {
        let trajectory = MoveTrajectory {
            path: motion.path,
            rotation: motion.rotation,
            lead: None,
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

    /// As [`Planner::run`] at the present tick, out of another motion along the path.
    pub(crate) fn run_relieved(
        &mut self,
        motion: Move<T>,
        from: KinematicState,
        removal: AccelerationRemoval,
        clock: &Clock,
    ) {
        self.run(motion, from, clock.now(), None, false, clock);
        let Some(mut running) = self.active else { return };
        running.removal = removal;
        let (plan, profile) = self.planned(&running, from);
        running.aim(&plan);
        running.trajectory.profile = profile;
        self.active = Some(running);
        self.schedule(clock.now(), clock);
    }

    /// As [`Planner::run`] at the present tick, beside what ramps out; along a profile, if there is one.
    pub(crate) fn run_beside(
        &mut self,
        motion: Move<T>,
        residual: Residual,
        from: KinematicState,
        along: Option<Profile>,
        clock: &Clock,
    ) {
        self.run(motion, from, clock.now(), Some(residual), false, clock);
        if let (Some(running), Some(along)) = (&mut self.active, along) {
            running.trajectory.profile = along;
            self.schedule(clock.now(), clock);
        }
    }

    /// Begins a move on a trajectory whose profile is still to be planned from `from`, where an acceleration may be being taken away.
    pub(crate) fn begin(&mut self, mut running: Running<T>, from: KinematicState, clock: &Clock) {
        self.clear_trail();
        running.run_start = self.queue.relink(&running.motion, running.blended);
        if running.removal.ceiling.is_infinite() && self.bounds.overshoot {
            running.removal = AccelerationRemoval::FORWARD;
        }
        let (plan, profile) = self.planned(&running, from);
        running.aim(&plan);
        running.trajectory.profile = profile;
        self.active = Some(running);
        self.schedule(running.begun, clock);
    }

    /// The aim of the profile of a move, and the profile, behind the removal of a present acceleration.
    pub(crate) fn planned(&self, running: &Running<T>, from: KinematicState) -> (Plan, Profile) {
        let lead = running.removal.lead(from, &self.limits(running));
        let level = lead.map_or(from, |lead| lead.end());
        let plan = self.plan(running, level);
        let profile = self.profile(running, level, &plan);
        (plan, lead.map_or(profile, |lead| lead.then(&profile)))
    }

    /// The limits that the active profile keeps, the override included.
    pub fn before(&self) -> Option<Limits> {
        let rate = self.queue.rate();
        self.active.map(|running| scaled_limits(&running.in_force, rate, 1.0))
    }

    /// The acceleration that the curvature of the paths gives at the present tick: it ends with them, and nothing limits it.
    pub fn centripetal(&self, clock: &Clock) -> Point {
        let trajectories = self.active.iter().map(|running| &running.trajectory).chain(&self.tail);
        trajectories.map(|trajectory| trajectory.centripetal(clock)).sum()
    }
}
