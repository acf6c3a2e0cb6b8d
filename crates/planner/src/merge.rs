//! A merge: the terminated motion ramps out beside the new path, `P = path(s) + r - D s / length`, where `D` is the final value of `r`
//! (spec/coordinated-instructions.md §6.3).
//!
//! The velocity is split along and across the path. The part along it begins the path's profile; the rest ramps out (`ramp_out`), over a
//! distance no longer than a stop with the old dynamics. The sum is never faster than the fastest of the present, the old and the new speed
//! (`path_with_residual`). If the path turns towards the residual, everything ramps out before the path begins.
//!
//! Position units and seconds (master units in place of seconds). Bounded; no allocation.

use arcline_geometry::Point;
use arcline_profile::{KinematicState, Limits, Profile};

use crate::Clock;
use crate::junction::is_along;
use crate::move_trajectory::{Residual, ResidualPart};
use crate::path_with_residual::PathWithResidual;
use crate::planner::Planner;
use crate::ramp_out::{RampOut, short, stop_way};
use crate::running::{AccelerationRemoval, InitialMotion, Move, scaled_limits};
use crate::tolerance::{LEAST_PATH_SQUARED_SHARE, NO_ACCELERATION_SHARE, ROUNDING_SHARE, SPLIT_VELOCITY_SHARE};

impl<T: Copy> Planner<T> {
    /// Starts a move at the present tick from another motion.
    pub fn merge(&mut self, mut motion: Move<T>, initial: InitialMotion, clock: &Clock) {
        self.queue.forget_corners();
        self.tail = None;
        let speed = initial.velocity.norm();
        if speed == 0.0 {
            self.start(motion, clock.now(), clock);
            return;
        }
        let widest = initial.before.filter(|_| self.dynamics_bits.overshoot).map(|before| {
            let from = KinematicState {
                position: 0.0,
                velocity: speed,
                acceleration: initial.acceleration.dot(&initial.velocity) / speed,
            };
            stop_way(from, &before)
        });
        let widest = widest.unwrap_or(f64::INFINITY);
        let mut initial = initial;
        if motion.limits.jerk.is_none() {
            initial.acceleration = Point::zeros();
        }
        let old = self.active.as_ref().map_or(0.0, |running| running.in_force.speed);
        let terminated = initial.before.map_or(0.0, |before| before.speed);
        let programmed = self.programmed_speed(old.max(motion.limits.speed));
        let bound = speed.max(programmed).max(terminated);
        let (path, tangent) = (&motion.path, motion.path.start_tangent());
        let direction = initial.velocity / speed;
        let along = initial.acceleration.dot(&direction);
        let across = (initial.acceleration - direction * along).norm();
        let level = across <= NO_ACCELERATION_SHARE * initial.acceleration.norm();
        if path.length() > 0.0 && level && is_along(&initial.velocity, &tangent) {
            let from = KinematicState {
                position: 0.0,
                velocity: speed,
                acceleration: along,
            };
            let removal = if self.dynamics_bits.overshoot {
                motion.limits = short(from, &motion.limits, 1.0, path.length().max(widest));
                AccelerationRemoval {
                    ceiling: bound,
                    forward: Some(0.0),
                }
            } else {
                AccelerationRemoval::NONE
            };
            self.run_with_removal(motion, from, removal, clock);
            return;
        }
        let out = RampOut {
            initial,
            limits: self.ramping_out(&initial, &motion.limits, widest, bound),
            widest,
            across: 1.0,
        };
        let rate = self.queue.rate();
        // A path without length cannot compensate: the residual returns by itself.
        let pieces = if path.length() == 0.0 {
            Pieces {
                parts: out.and_back(),
                from: KinematicState::default(),
                limits: motion.limits,
                profile: None,
            }
        } else {
            pieces(&motion, out, rate, self.dynamics_bits.overshoot.then_some(bound))
        };
        let residual = Residual::new(pieces.parts, clock.now(), path);
        motion.limits = pieces.limits;
        self.run_beside(motion, residual, pieces.from, pieces.profile, clock);
    }
}

/// A path and its residual.
struct Pieces {
    parts: [ResidualPart; 3],
    /// The start state on the path.
    from: KinematicState,
    /// Its limits.
    limits: Limits,
    /// The profile of the path; `None`: planned by its limits.
    profile: Option<Profile>,
}

/// Path and residual, no faster in sum than `bound`.
fn pieces<T: Copy>(motion: &Move<T>, out: RampOut, rate: f64, bound: Option<f64>) -> Pieces {
    let path = &motion.path;
    let level = |factor| RampOut { across: factor, ..out };
    let travelled = |split: &Pieces| {
        let beside = PathWithResidual {
            path,
            parts: &split.parts,
            since: 0.0,
            bound: bound?,
        };
        let share = Residual::share_of(&split.parts, path);
        let limits = scaled_limits(&split.limits, rate, share);
        let total = out.initial.acceleration.norm();
        let removal = out
            .limits
            .jerk
            .map_or(0.0, |jerk| split.from.acceleration * jerk.acceleration / total);
        let plan = |from, limits: &Limits| Profile::to_position(from, path.length(), 0.0, limits);
        Some((
            beside.profile(split.from, &limits, removal, plan),
            beside.waiting(split.from, &limits, removal, plan),
        ))
    };
    if bound.is_none() {
        return split(motion, &out).unwrap_or_else(|| apart(motion, &out));
    }
    for factor in ACROSS {
        let Some(mut split) = split(motion, &level(factor)) else {
            break;
        };
        let share = Residual::share_of(&split.parts, path);
        split.limits = short(split.from, &split.limits, share, path.length().max(out.widest));
        let has_across = split.parts[1].moves();
        if let Some((Some(profile), _)) = travelled(&split) {
            split.profile = Some(profile);
            return split;
        }
        if !has_across {
            break;
        }
    }
    let mut last = apart(motion, &out);
    for factor in ACROSS {
        last = apart(motion, &level(factor));
        if let Some((profile, waiting)) = travelled(&last) {
            let found = profile.is_some();
            last.profile = Some(profile.unwrap_or(waiting));
            if found {
                break;
            }
        }
    }
    last
}

/// Ramps out all of the motion; the path begins from rest.
fn apart<T>(motion: &Move<T>, out: &RampOut) -> Pieces {
    Pieces {
        parts: out.parts(out.initial.velocity, out.initial.acceleration),
        from: KinematicState::default(),
        limits: motion.limits,
        profile: None,
    }
}

/// Splits the motion: the part along the path, with compensation, begins the path. `None` if no motion is along it, or the path is too short
/// to decide.
fn split<T>(motion: &Move<T>, out: &RampOut) -> Option<Pieces> {
    let path = &motion.path;
    let InitialMotion {
        velocity, acceleration, ..
    } = out.initial;
    let tangent = path.start_tangent();
    let mut drift = Point::zeros();
    for _ in 0..SPLITTINGS {
        let direction = tangent - drift;
        let square = direction.norm_squared();
        let along = KinematicState {
            position: 0.0,
            velocity: velocity.dot(&direction) / square,
            acceleration: acceleration.dot(&direction) / square,
        };
        // A velocity along the path within rounding counts as across it.
        let forward = along.velocity * square.sqrt();
        if square < LEAST_PATH_SQUARED_SHARE || forward.is_nan() || forward <= ROUNDING_SHARE * velocity.norm() {
            return None;
        }
        let parts = out.parts(
            velocity - direction * along.velocity,
            acceleration - direction * along.acceleration,
        );
        let before = drift;
        drift = parts.iter().map(ResidualPart::total).sum::<Point>() / path.length();
        // The splitting causes a step of the velocity.
        if (drift - before).norm() * along.velocity <= SPLIT_VELOCITY_SHARE * velocity.norm() {
            return Some(Pieces {
                parts,
                from: along,
                limits: motion.limits,
                profile: None,
            });
        }
    }
    None
}

/// Factors for a faster removal of an acceleration across the velocity.
const ACROSS: [f64; 3] = [1.0, 4.0, f64::INFINITY];
const SPLITTINGS: usize = 32;
