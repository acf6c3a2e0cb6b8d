//! One coordinate system's active move, the end of the one before it, and its queue.

use arcline_geometry::{Path, Point};
use arcline_profile::{Limits, Profile, State, entry_speed, passing_speed};

use crate::junction::{Ending, Junction, braking, is_along, junction, same_rates};
use crate::look_ahead::{Ends, turns_back};
use crate::queue::Queue;
use crate::track::{Approach, Part, Residual, Sample, Track};
use crate::{Clock, Instant};

/// A path to travel and the limits along it. `T` is whatever the owner wants back with it.
#[derive(Clone, Copy, Debug)]
pub struct Move<T> {
    /// The geometric path, by arc length.
    pub path: Path,
    /// Limits of the speed along the path and of its derivatives.
    pub limits: Limits,
    /// What happens at its end if it has a successor.
    pub ending: Ending,
    /// The owner's own data.
    pub data: T,
}

/// The move being interpolated.
#[derive(Clone, Copy, Debug)]
pub struct Running<T> {
    /// The move itself.
    pub motion: Move<T>,
    pub(crate) track: Track,
    /// Speed with which the profile ends.
    pub(crate) exit: f64,
    /// Pending moves that the profile runs over too.
    pub(crate) joined: usize,
    /// Whether something blended into it.
    pub(crate) blended: bool,
    /// Where on its run of moves it begins.
    pub(crate) place: f64,
    /// Whether a stop brakes it: nothing changes that.
    pub(crate) stopped: bool,
}

/// A point on the way of the active move that lies at or before the present tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Passage {
    /// The successor is to become active: [`Planner::hand_over`].
    HandOver(Instant),
    /// The programmed end is reached and nothing has taken over.
    Reached(Instant),
}

/// Velocity and acceleration with which a merge begins.
#[derive(Clone, Copy, Debug)]
pub struct Momentum {
    /// Velocity of the motion that is terminated, units/s.
    pub velocity: Point,
    /// Its acceleration, units/s².
    pub acceleration: Point,
}

/// The pending places are all taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct QueueFull;

/// One active move and up to `depth` pending ones.
#[derive(Debug)]
pub struct Planner<T> {
    pub(crate) active: Option<Running<T>>,
    /// The end of a move that the active one blends with.
    pub(crate) tail: Option<Track>,
    pub(crate) queue: Queue<T>,
    depth: usize,
    /// Seconds after the active track's start at which the successor takes over before the programmed end.
    pub(crate) hand_over_at: Option<f64>,
}

/// Share of a distance that is rounding.
const NEAR: f64 = 1e-12;
/// Seconds to an instant that does not come.
const NEVER: f64 = 1e9;
/// Share of an acceleration that is none: what rounding leaves across the direction of motion.
const NO_ACCELERATION: f64 = 1e-9;

impl<T: Copy> Planner<T> {
    /// A planner at rest with `depth` pending places. `corner_step`: the change of velocity that each axis may
    /// make at once in a corner that is not tangent, units/s. The only allocation.
    pub fn new(depth: usize, corner_step: Point) -> Self {
        Planner {
            active: None,
            tail: None,
            queue: Queue::new(depth, corner_step),
            depth,
            hand_over_at: None,
        }
    }

    /// The active move.
    pub fn active(&self) -> Option<&Running<T>> {
        self.active.as_ref()
    }

    /// The active move's data, to change.
    pub fn active_data(&mut self) -> Option<&mut T> {
        self.active.as_mut().map(|running| &mut running.motion.data)
    }

    /// The moves that wait, oldest first.
    pub fn pending(&self) -> impl Iterator<Item = &Move<T>> {
        self.queue.iter()
    }

    /// The moves that wait, oldest first, to change; [`Planner::change_limits`] makes it take effect.
    pub fn pending_mut(&mut self) -> impl Iterator<Item = &mut Move<T>> {
        self.queue.iter_mut()
    }

    /// Whether every pending place is taken.
    pub fn is_full(&self) -> bool {
        self.queue.len() >= self.depth
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
        self.run(motion, State::default(), at, None, false, clock);
    }

    /// Starts a move at the present tick out of another motion: a velocity along the new path is kept, any other
    /// ramps out with the deceleration of the move (spec/coordinated-instructions.md §6.3).
    pub fn merge(&mut self, motion: Move<T>, momentum: Momentum, clock: &Clock) {
        self.tail = None;
        let speed = momentum.velocity.norm();
        if speed == 0.0 {
            self.start(motion, clock.now(), clock);
            return;
        }
        let direction = momentum.velocity / speed;
        let acceleration = if motion.limits.jerk.is_some() {
            momentum.acceleration
        } else {
            Point::zeros()
        };
        let along = State {
            position: 0.0,
            velocity: speed,
            acceleration: acceleration.dot(&direction),
        };
        let across = acceleration - direction * along.acceleration;
        let length = motion.path.length();
        let kept = length > 0.0 && is_along(&momentum.velocity, &motion.path.start_tangent());
        let from = if kept { along } else { State::default() };
        if kept && across.norm() <= NO_ACCELERATION * acceleration.norm() {
            self.run(motion, from, clock.now(), None, false, clock);
            return;
        }
        let limits = braking(&motion.limits, speed);
        // A path without length cannot compensate: what ramps out comes back by itself.
        let ramped_out = |from: State| {
            if length > 0.0 {
                Profile::stop(from, &limits)
            } else {
                Profile::to_position(from, 0.0, 0.0, &limits)
            }
        };
        let part = |direction, from| Part {
            direction,
            profile: ramped_out(from),
        };
        let parts = [
            part(direction, if kept { State::default() } else { along }),
            part(
                across.try_normalize(0.0).unwrap_or_default(),
                State {
                    acceleration: across.norm(),
                    ..State::default()
                },
            ),
        ];
        let residual = Residual::new(parts, clock.now(), &motion.path);
        self.run(motion, from, clock.now(), Some(residual), false, clock);
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
            active.map(|running| (&running.motion, running.blended, running.place)),
        );
        self.raise_exit(clock);
        self.schedule(clock.now(), clock);
        Ok(())
    }

    /// Goes on with the look-ahead where it was too long for one tick: to be called at every tick, after
    /// all that [`Planner::passage`] tells.
    pub fn look_on(&mut self, clock: &Clock) {
        if self.queue.carry_on() {
            self.raise_exit(clock);
            self.schedule(clock.now(), clock);
        }
    }

    /// The next point on the way that lies at or before the present tick.
    pub fn passage(&self, clock: &Clock) -> Option<Passage> {
        let running = self.active.as_ref()?;
        let elapsed = running.track.start.elapsed(clock);
        let instant = |seconds: f64| running.track.start.after(seconds, clock);
        if let Some(at) = self.hand_over_at
            && elapsed >= at
        {
            return Some(Passage::HandOver(instant(at)));
        }
        if !running.track.profile.arrives() {
            return None;
        }
        let mut end = running.track.duration(clock);
        if running.exit == 0.0
            && let Some(tail) = &self.tail
        {
            end = end.max(tail.duration(clock) + elapsed - tail.start.elapsed(clock));
        }
        (elapsed >= end).then(|| Passage::Reached(instant(end)))
    }

    /// Whether the active move goes over into its successor without rest.
    pub fn passes_on(&self) -> bool {
        self.active.is_some_and(|running| running.exit > 0.0) && self.queue.front().is_some()
    }

    /// The oldest pending move becomes active at an instant: from rest, blending, or at the speed of the junction.
    pub fn hand_over(&mut self, at: Instant, clock: &Clock) -> Option<&mut T> {
        let last = self.active.take();
        let early = self.hand_over_at.take().is_some();
        let next = self.queue.pop()?;
        let Some(last) = last else {
            self.start(next, at, clock);
            return self.active_data();
        };
        let between = junction(&last.motion, &next, last.blended);
        if last.joined > 0 {
            self.go_on(&last, next, between, at, clock);
            return self.active_data();
        }
        let end = last.track.profile.end();
        match between {
            Junction::Blend { .. } if early => {
                self.tail = Some(last.track);
                self.run(next, State::default(), at, None, true, clock);
            }
            Junction::Overtake { .. } if early && self.overtake(&last, next, at, clock) => {}
            Junction::Pass { .. } | Junction::Overtake { .. } if early => {
                let start = last.track.start.after(last.track.profile.duration(), clock);
                let approach = Approach {
                    path: last.motion.path,
                    profile: last.track.profile,
                    start: last.track.start,
                    offset: last.track.offset,
                    limits: last.motion.limits,
                };
                let blended = matches!(between, Junction::Overtake { .. });
                self.run(next, passing(end), start, None, blended, clock);
                if let Some(running) = &mut self.active {
                    running.track.approach = Some(approach);
                }
            }
            _ => {
                let from = if last.exit > 0.0 {
                    passing(end)
                } else {
                    State::default()
                };
                self.run(next, from, at, None, false, clock);
            }
        }
        self.active_data()
    }

    /// Ends the active move and forgets it.
    pub fn clear_active(&mut self) -> Option<T> {
        self.tail = None;
        self.hand_over_at = None;
        self.active.take().map(|running| running.motion.data)
    }

    /// Takes the oldest pending move out of the queue.
    pub fn cancel_pending(&mut self) -> Option<T> {
        self.hand_over_at = None;
        self.queue.pop().map(|waiting| waiting.data)
    }

    /// Whether two moves are superposed at the present tick.
    pub fn in_transition(&self, clock: &Clock) -> bool {
        self.tail
            .is_some_and(|tail| tail.start.elapsed(clock) < tail.duration(clock))
    }

    /// Gives the active move new limits from the present tick on: the profile is planned again from the
    /// present state, in two stages when the end can no longer be met (spec/motion-core.md §5). Rates with which a
    /// corner that the motion is to pass could no longer be met hold from there on only (§5.3).
    pub fn change_limits(&mut self, limits: Limits, clock: &Clock) {
        self.queue.refresh();
        let Some(running) = &mut self.active else {
            return;
        };
        let before = running.motion.limits;
        running.motion.limits = limits;
        if self.replan(clock) && !same_rates(&before, &limits) {
            // The old rates; those of the moves that the motion was already braking along; the new ones all the same.
            let following = self.queue.front().map_or(limits, |next| next.limits);
            for rates in [before, following, limits] {
                if let Some(running) = &mut self.active {
                    running.motion.limits = Limits {
                        speed: limits.speed,
                        ..rates
                    };
                }
                if !self.replan(clock) {
                    break;
                }
            }
        }
    }

    /// Takes a share (at least 0) of the programmed speeds of the active move, the pending and all later ones, from the
    /// present tick on; 0 holds. Of no effect on a stop that is under way.
    pub fn set_rate(&mut self, rate: f64, clock: &Clock) {
        self.queue.set_rate(rate);
        self.replan(clock);
    }

    /// Plans the active move again from its present state. Whether it comes to the next corner too fast.
    fn replan(&mut self, clock: &Clock) -> bool {
        let Some(mut running) = self.active.filter(|running| !running.stopped) else {
            return false;
        };
        running.place = self.queue.relink(&running.motion, running.blended);
        if let Some(approach) = running.track.approach.filter(|_| running.track.is_approaching(clock))
            && !same_rates(&approach.limits, &running.motion.limits)
        {
            let start = self.approach_again(&mut running, approach, clock);
            return self.plan_from(running, start, clock);
        }
        let from = running.track.state(clock);
        let plan = self.plan(&running, from);
        let profile = if plan.exit > 0.0 || plan.cap == 0.0 {
            self.profile(&running, from, &plan)
        } else {
            let limits = Limits {
                speed: plan.cap,
                ..self.limits(&running)
            };
            Profile::to_position_two_stage(from, plan.target, &limits)
        };
        running.follow(&plan, profile, clock.now());
        self.active = Some(running);
        self.schedule(clock.now(), clock);
        plan.ends == Ends::TooFast
    }

    /// The way to the start of the active path, which has other rates, is planned again. The state there.
    fn approach_again(&self, running: &mut Running<T>, mut approach: Approach, clock: &Clock) -> State {
        let elapsed = approach.start.elapsed(clock);
        let mut from = approach.profile.at(elapsed);
        from.position -= approach.offset;
        let limits = Limits {
            speed: approach.limits.speed * self.queue.rate(),
            ..approach.limits
        };
        let length = approach.path.length();
        let wanted = self.entry(running).min(limits.speed);
        let exit = passing_speed(from, length - from.position, wanted, &limits).speed;
        let capped = Limits {
            speed: limits.speed.max(exit),
            ..limits
        };
        approach.profile = Profile::to_position(from, length, exit, &capped);
        approach.offset = 0.0;
        approach.start = clock.now();
        let arrives = approach.profile.arrives();
        let way = if arrives { approach.profile.duration() } else { NEVER };
        running.track.start = clock.now().after(way, clock);
        running.track.approach = Some(approach);
        State {
            position: 0.0,
            velocity: exit,
            acceleration: 0.0,
        }
    }

    /// The highest speed with which the active path can be begun.
    fn entry(&self, running: &Running<T>) -> f64 {
        let limits = self.limits(running);
        let end = self.queue.run_end(running.place + running.motion.path.length());
        let bound = self.queue.slower().next().unwrap_or(&end);
        let way = bound.at - running.place;
        limits.speed.min(entry_speed(way, self.queue.speed(bound), &limits))
    }

    /// The profile of the active path from its beginning, which lies ahead.
    fn plan_from(&mut self, mut running: Running<T>, from: State, clock: &Clock) -> bool {
        let plan = self.plan(&running, from);
        running.track.profile = self.profile(&running, from, &plan);
        running.track.offset = 0.0;
        running.aim(&plan);
        self.active = Some(running);
        self.schedule(clock.now(), clock);
        plan.ends == Ends::TooFast
    }

    /// Brakes the active move on its path from the present tick on, and what still blends with it.
    pub fn stop(&mut self, limits: &Limits, clock: &Clock) {
        self.hand_over_at = None;
        let tracks = self
            .active
            .iter_mut()
            .map(|running| &mut running.track)
            .chain(&mut self.tail);
        for track in tracks {
            let from = track.state(clock);
            track.replan(Profile::stop(from, limits), clock.now());
        }
        if let Some(running) = &mut self.active {
            running.exit = 0.0;
            running.joined = 0;
            running.stopped = true;
        }
    }

    /// Where the coordinate system is at the present tick.
    pub fn sample(&self, clock: &Clock) -> Option<Sample> {
        let mut sample = self.active.as_ref()?.track.sample(clock);
        if let Some(tail) = &self.tail {
            let rest = tail.sample(clock);
            sample.position += rest.position - tail.path.end();
            sample.velocity += rest.velocity;
            sample.acceleration += rest.acceleration;
        }
        Some(sample)
    }

    fn run(
        &mut self,
        motion: Move<T>,
        from: State,
        at: Instant,
        residual: Option<Residual>,
        blended: bool,
        clock: &Clock,
    ) {
        let track = Track {
            path: motion.path,
            lead: None,
            approach: None,
            profile: Profile::rest(0.0),
            start: at,
            offset: 0.0,
            residual,
        };
        self.begin(motion, track, from, blended, clock);
    }

    /// Begins a move within its tolerance before its path, with its own rates; not where these are too low for what
    /// lies ahead.
    fn overtake(&mut self, last: &Running<T>, next: Move<T>, at: Instant, clock: &Clock) -> bool {
        let mut from = last
            .track
            .profile
            .at(last.track.start.elapsed(clock) - at.elapsed(clock));
        from.position -= last.track.offset + last.motion.path.length();
        let track = Track {
            path: next.path,
            lead: (from.position < 0.0).then_some(last.motion.path),
            approach: None,
            profile: Profile::rest(0.0),
            start: at,
            offset: 0.0,
            residual: None,
        };
        let running = Running {
            motion: next,
            track,
            exit: 0.0,
            joined: 0,
            blended: true,
            place: self.queue.relink(&next, true),
            stopped: false,
        };
        let safe = self.plan(&running, from).ends == Ends::AsItMust && !turns_back(&from, &next.limits);
        if safe {
            self.begin(next, track, from, true, clock);
        }
        safe
    }

    /// Begins a move on a track whose profile is still to be planned from `from`.
    fn begin(&mut self, motion: Move<T>, track: Track, from: State, blended: bool, clock: &Clock) {
        let mut running = Running {
            motion,
            track,
            exit: 0.0,
            joined: 0,
            blended,
            place: self.queue.relink(&motion, blended),
            stopped: false,
        };
        let plan = self.plan(&running, from);
        running.aim(&plan);
        running.track.profile = self.profile(&running, from, &plan);
        self.active = Some(running);
        self.schedule(track.start, clock);
    }

    /// The next of several joined moves becomes active: the profile runs on, or is planned again where the new move
    /// has another speed.
    fn go_on(&mut self, last: &Running<T>, next: Move<T>, between: Junction, at: Instant, clock: &Clock) {
        let mut track = last.track;
        track.offset += last.motion.path.length();
        track.path = next.path;
        let blended = matches!(between, Junction::Overtake { .. });
        track.lead = blended.then_some(last.motion.path);
        track.approach = None;
        if last.motion.limits.speed != next.limits.speed {
            let mut from = track.profile.at(track.start.elapsed(clock) - at.elapsed(clock));
            from.position -= track.offset;
            if from.position.abs() <= NEAR * track.offset {
                from.position = 0.0;
            }
            track.replan(track.profile, at);
            self.begin(next, track, from, blended, clock);
            return;
        }
        self.active = Some(Running {
            motion: next,
            track,
            exit: last.exit,
            joined: last.joined - 1,
            blended,
            place: self.queue.relink(&next, blended),
            stopped: false,
        });
        self.schedule(at, clock);
    }
}

/// The state in which a junction is passed, on the path behind it.
fn passing(end: State) -> State {
    State { position: 0.0, ..end }
}
