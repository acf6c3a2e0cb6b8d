//! A queue whose moves are travelled as planned contours (`corner = "precise"`, `axis_limits = "enforce"`).
//!
//! Planning a contour is not bounded, so it is done elsewhere: the queue says which moves are to be planned
//! ([`ContourQueue::batch`]), gets a finished [`Trajectory`] back ([`ContourQueue::install`]) and evaluates it. A stop
//! slows down the pace at which the trajectory's own time runs, so it never leaves the path
//! (spec/motion-core.md §10.3). Nothing here allocates or frees: trajectories are handed back.

use std::collections::VecDeque;

use arcline_contour::{ContourMove, Trajectory};
use arcline_geometry::Point;
use arcline_profile::{Limits, Phase, Profile, State, stop_distance};

use crate::{Clock, Ending, Instant, Move, QueueFull, Sample};

/// One active move and the pending ones, of which the first few are on a planned trajectory.
#[derive(Debug)]
pub struct ContourQueue<T> {
    moves: VecDeque<Move<T>>,
    depth: usize,
    run: Option<Run>,
    asked: bool,
    generation: u32,
    /// When the last move was queued.
    grown: Option<Instant>,
}

/// A trajectory in execution.
#[derive(Debug)]
struct Run {
    trajectory: Box<Trajectory>,
    /// Moves of it that have been completed.
    passed: usize,
    /// The trajectory's own time, seconds, as a function of time.
    pace: Profile,
    start: Instant,
}

/// What lies at or before the present tick.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ContourPassage {
    /// The active move is complete and the next one of the trajectory is active.
    Next,
    /// The trajectory is at its end, or a stop is.
    End,
}

impl<T: Copy> ContourQueue<T> {
    /// An empty queue with `depth` pending places. The only allocation.
    pub fn new(depth: usize) -> Self {
        ContourQueue {
            moves: VecDeque::with_capacity(depth + 1),
            depth,
            run: None,
            asked: false,
            generation: 0,
            grown: None,
        }
    }

    /// Whether every pending place is taken.
    pub fn is_full(&self) -> bool {
        self.moves.len() > self.depth
    }

    /// The moves, the active one first.
    pub fn moves(&self) -> impl Iterator<Item = &Move<T>> {
        self.moves.iter()
    }

    /// Takes the first move out.
    pub fn pop(&mut self) -> Option<Move<T>> {
        self.moves.pop_front()
    }

    /// Takes the last move out, unless it is the active one of a trajectory.
    pub fn pop_pending(&mut self) -> Option<Move<T>> {
        if self.is_running() && self.moves.len() <= 1 {
            return None;
        }
        self.moves.pop_back()
    }

    /// Whether a trajectory is being travelled.
    pub fn is_running(&self) -> bool {
        self.run.is_some()
    }

    /// Puts a move behind the last one.
    ///
    /// # Errors
    /// [`QueueFull`] when all places are taken.
    pub fn push(&mut self, motion: Move<T>, clock: &Clock) -> Result<(), QueueFull> {
        if self.is_full() {
            return Err(QueueFull);
        }
        self.grown = Some(clock.now());
        self.moves.push_back(motion);
        Ok(())
    }

    /// The moves that are to be planned now, as one contour from rest to rest: up to the first that ends in a
    /// stop. Where none does and there is room for more, the queue is given a moment to grow. Asks once; the plan
    /// is expected with the generation that is returned.
    pub fn batch(&mut self, clock: &Clock, mut take: impl FnMut(ContourMove)) -> Option<u32> {
        if self.asked || self.run.is_some() || self.moves.is_empty() {
            return None;
        }
        let open = !self.is_full() && self.moves.iter().all(|motion| motion.ending != Ending::Stop);
        if open && self.grown.is_some_and(|grown| grown.elapsed(clock) < GATHER) {
            return None;
        }
        for (place, motion) in self.moves.iter().enumerate() {
            let (tolerance, last) = match motion.ending {
                Ending::Stop => (0.0, true),
                Ending::Blend { tolerance } if tolerance.is_finite() => (tolerance, false),
                Ending::Blend { .. } => (
                    self.moves.get(place + 1).map_or(0.0, |next| no_decel(motion, next)),
                    false,
                ),
                Ending::Contour { .. } => (0.0, false),
            };
            take(ContourMove {
                path: motion.path,
                speed: motion.limits.speed,
                acceleration: motion.limits.acceleration,
                deceleration: motion.limits.deceleration,
                jerk: motion.limits.jerk.map(|jerk| jerk.acceleration.min(jerk.deceleration)),
                tolerance,
            });
            if last {
                break;
            }
        }
        self.asked = true;
        self.generation = self.generation.wrapping_add(1);
        Some(self.generation)
    }

    /// Begins to travel a trajectory at the present tick.
    ///
    /// # Errors
    /// The trajectory itself when it is no longer wanted: the moves were cancelled meanwhile.
    pub fn install(
        &mut self,
        generation: u32,
        trajectory: Box<Trajectory>,
        clock: &Clock,
    ) -> Result<(), Box<Trajectory>> {
        if !self.asked || generation != self.generation || trajectory.moves() > self.moves.len() {
            return Err(trajectory);
        }
        self.asked = false;
        let running = State {
            position: 0.0,
            velocity: 1.0,
            acceleration: 0.0,
        };
        self.run = Some(Run {
            pace: Profile::to_velocity(running, 1.0, &unit_limits(1.0)),
            trajectory,
            passed: 0,
            start: clock.now(),
        });
        Ok(())
    }

    /// Forgets every move and the trajectory, which is handed back to be freed elsewhere.
    pub fn clear(&mut self) -> Option<Box<Trajectory>> {
        self.moves.clear();
        self.asked = false;
        self.run.take().map(|run| run.trajectory)
    }

    /// The trajectory is at its end: hands it back.
    pub fn finish(&mut self) -> Option<Box<Trajectory>> {
        self.run.take().map(|run| run.trajectory)
    }

    /// What lies at or before the present tick, one thing at a time.
    pub fn passage(&self, clock: &Clock) -> Option<ContourPassage> {
        let run = self.run.as_ref()?;
        let now = run.pace.at(run.start.elapsed(clock));
        if now.velocity == 0.0 && now.acceleration == 0.0 {
            return Some(ContourPassage::End);
        }
        if now.position >= run.trajectory.duration() {
            return Some(ContourPassage::End);
        }
        let next = run.trajectory.move_end(run.passed)?;
        let more = run.passed + 1 < run.trajectory.moves();
        (more && now.position >= next).then_some(ContourPassage::Next)
    }

    /// The active move of the trajectory is complete: takes it out.
    pub fn pass(&mut self) -> Option<Move<T>> {
        if let Some(run) = &mut self.run {
            run.passed += 1;
        }
        self.moves.pop_front()
    }

    /// Brakes on the path from the present tick on. The moves are the caller's to end.
    pub fn stop(&mut self, limits: &Limits, clock: &Clock) {
        let Some(run) = &mut self.run else {
            return;
        };
        let now = run.pace.at(run.start.elapsed(clock));
        let speed = run.trajectory.at(now.position).velocity.norm().max(1e-3 * limits.speed);
        let rate = |limit: f64| limit / speed;
        let limits = Limits {
            speed: 1.0,
            acceleration: rate(limits.deceleration),
            deceleration: rate(limits.deceleration),
            jerk: limits.jerk.map(|jerk| arcline_profile::Jerk {
                acceleration: rate(jerk.deceleration),
                deceleration: rate(jerk.deceleration),
            }),
        };
        run.pace = Profile::stop(now, &limits);
        run.start = clock.now();
    }

    /// Where the coordinate system is at the present tick.
    pub fn sample(&self, clock: &Clock) -> Option<Sample> {
        let run = self.run.as_ref()?;
        let pace = run.pace.at(run.start.elapsed(clock));
        let at = run.trajectory.at(pace.position);
        let velocity: Point = at.velocity * pace.velocity;
        let acceleration = at.acceleration * (pace.velocity * pace.velocity) + at.velocity * pace.acceleration;
        let power = velocity.dot(&acceleration);
        let speed = velocity.norm();
        Some(Sample {
            position: at.position,
            velocity,
            acceleration,
            along: State {
                position: 0.0,
                velocity: speed,
                acceleration: if speed > 0.0 { power / speed } else { 0.0 },
            },
            phase: match power.partial_cmp(&0.0) {
                Some(std::cmp::Ordering::Greater) => Phase::Accelerating,
                Some(std::cmp::Ordering::Less) => Phase::Decelerating,
                _ => Phase::Steady,
            },
        })
    }
}

/// How long a contour without an end waits for another move, seconds: clients send them one by one.
const GATHER: f64 = 0.01;

/// How far from a corner superposition without a tolerance would pass it: what No Decel may round by
/// (spec/motion-core.md §6.1; the lower bound, which holds for S-curves too).
fn no_decel<T>(first: &Move<T>, second: &Move<T>) -> f64 {
    let turn = (second.path.start_tangent() - first.path.end_tangent()).norm();
    0.125 * turn * stop_distance(first.limits.speed, &first.limits)
}

fn unit_limits(rate: f64) -> Limits {
    Limits {
        speed: 1.0,
        acceleration: rate,
        deceleration: rate,
        jerk: None,
    }
}
