//! One coordinate system's active move and its queue.

use std::collections::VecDeque;

use arcline_geometry::{Path, PathPoint, Point};
use arcline_profile::{Limits, Phase, Profile, State};

use crate::{Clock, Instant};

/// A path to travel and the limits along it. `T` is whatever the owner wants back with it.
#[derive(Clone, Copy, Debug)]
pub struct Move<T> {
    /// The geometric path, by arc length.
    pub path: Path,
    /// Limits of the speed along the path and of its derivatives.
    pub limits: Limits,
    /// The owner's own data.
    pub data: T,
}

/// The move being interpolated.
#[derive(Clone, Copy, Debug)]
pub struct Running<T> {
    /// The move itself.
    pub motion: Move<T>,
    profile: Profile,
    start: Instant,
}

/// Where the system is at one instant.
#[derive(Clone, Copy, Debug)]
pub struct Sample {
    /// Position of the axes, position units.
    pub position: Point,
    /// Velocity of the axes, units/s.
    pub velocity: Point,
    /// Acceleration of the axes, units/s².
    pub acceleration: Point,
    /// State along the path: distance from its start, speed, tangential acceleration.
    pub along: State,
    /// What the speed along the path does.
    pub phase: Phase,
}

/// The pending places are all taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct QueueFull;

/// One active move and up to `depth` pending ones.
#[derive(Debug)]
pub struct Planner<T> {
    active: Option<Running<T>>,
    pending: VecDeque<Move<T>>,
    depth: usize,
}

impl<T: Copy> Planner<T> {
    /// A planner at rest with `depth` pending places. The only allocation.
    pub fn new(depth: usize) -> Self {
        Planner {
            active: None,
            pending: VecDeque::with_capacity(depth),
            depth,
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
        self.pending.iter()
    }

    /// The moves that wait, oldest first, to change.
    pub fn pending_mut(&mut self) -> impl Iterator<Item = &mut Move<T>> {
        self.pending.iter_mut()
    }

    /// Whether every pending place is taken.
    pub fn is_full(&self) -> bool {
        self.pending.len() >= self.depth
    }

    /// Programmed end point of the last move in the queue: where the next one begins.
    pub fn last_end(&self) -> Option<Point> {
        let last = self.pending.back();
        last.map(|waiting| waiting.path.end())
            .or_else(|| self.active.map(|running| running.motion.path.end()))
    }

    /// Starts a move from rest at an instant, in place of whatever was active.
    pub fn start(&mut self, motion: Move<T>, at: Instant) {
        let profile = Profile::to_position(at_rest(0.0), motion.path.length(), 0.0, &motion.limits);
        self.active = Some(Running {
            motion,
            profile,
            start: at,
        });
    }

    /// Puts a move behind the last one.
    ///
    /// # Errors
    /// [`QueueFull`] when all pending places are taken.
    pub fn enqueue(&mut self, motion: Move<T>) -> Result<(), QueueFull> {
        if self.is_full() {
            return Err(QueueFull);
        }
        self.pending.push_back(motion);
        Ok(())
    }

    /// Ends the active move; the oldest pending one starts from rest at `at`.
    pub fn promote(&mut self, at: Instant) -> Option<&mut T> {
        self.active = None;
        let next = self.pending.pop_front()?;
        self.start(next, at);
        self.active_data()
    }

    /// Ends the active move and forgets it.
    pub fn clear_active(&mut self) -> Option<T> {
        self.active.take().map(|running| running.motion.data)
    }

    /// Takes the oldest pending move out of the queue.
    pub fn cancel_pending(&mut self) -> Option<T> {
        self.pending.pop_front().map(|waiting| waiting.data)
    }

    /// The instant at which the active profile came to its end, if that is not after the present tick.
    pub fn reached(&self, clock: &Clock) -> Option<Instant> {
        let running = self.active.as_ref()?;
        let elapsed = running.start.elapsed(clock);
        let done = running.profile.arrives() && elapsed >= running.profile.duration();
        done.then(|| running.start.after(running.profile.duration(), clock))
    }

    /// Gives the active move new limits from the present tick on: the profile is planned again from the
    /// present state, in two stages when the end can no longer be met (spec/motion-core.md §5).
    pub fn change_limits(&mut self, limits: Limits, clock: &Clock) {
        if let Some(running) = &mut self.active {
            let from = running.profile.at(running.start.elapsed(clock));
            running.motion.limits = limits;
            running.profile = Profile::to_position_two_stage(from, running.motion.path.length(), &limits);
            running.start = clock.now();
        }
    }

    /// Brakes the active move on its path from the present tick on. It ends where the ramp ends.
    pub fn stop(&mut self, limits: &Limits, clock: &Clock) {
        if let Some(running) = &mut self.active {
            let from = running.profile.at(running.start.elapsed(clock));
            running.profile = Profile::stop(from, limits);
            running.start = clock.now();
        }
    }

    /// Where the active move is at the present tick.
    pub fn sample(&self, clock: &Clock) -> Option<Sample> {
        self.active.as_ref().map(|running| running.sample(clock))
    }
}

impl<T: Copy> Running<T> {
    fn sample(&self, clock: &Clock) -> Sample {
        let elapsed = self.start.elapsed(clock);
        let along = self.profile.at(elapsed);
        let PathPoint {
            position,
            tangent,
            curvature,
            ..
        } = self.motion.path.at(along.position);
        Sample {
            position,
            velocity: tangent * along.velocity,
            acceleration: tangent * along.acceleration + curvature * (along.velocity * along.velocity),
            along,
            phase: self.profile.phase(elapsed),
        }
    }
}

fn at_rest(position: f64) -> State {
    State {
        position,
        velocity: 0.0,
        acceleration: 0.0,
    }
}
