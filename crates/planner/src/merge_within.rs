//! A merge that keeps the limits of the axes (`axis_limits = "enforce"`).
//!
//! The terminated motion ramps out axis by axis during the path, `P = path(s) + r - r_end s / length`, each part with half of every limit, so
//! that the sum keeps the limit: an acceleration above its half ramps down as fast as that of the path may rise. The path waits for
//! a residual that still accelerates, which needs all of the jerk. If the sum would be too fast, or an axis must reverse first, the path waits
//! until the residual has ramped out, and both parts have the full limits. Position units, seconds.

use arcline_contour::AxisLimits;
use arcline_geometry::{Path, Point};
use arcline_profile::{Jerk, KinematicState, Limits, Profile};

use crate::Clock;
use crate::move_trajectory::{Residual, ResidualPart};
use crate::planner::{Planner, RunStart};
use crate::running::{InitialMotion, Move};
use crate::tolerance::{
    LEAST_RATE_UNITS, NO_ACCELERATION_SHARE, NO_COMPONENT_SINE, ROUNDING_SHARE, TIGHTER_SPIRAL_RATIO,
};

/// The share of the limits of the axes for a path.
#[derive(Clone, Copy, Debug)]
pub(crate) struct AxisLimitShare {
    axes: AxisLimits,
    path: Path,
    share: f64,
    /// The displacement of the residual that each unit of the path compensates.
    drift: Point,
}

impl<T: Copy> Planner<T> {
    /// As [`Planner::merge`], within the limits of the axes. The limits hold for later changes of this move, too.
    pub fn merge_within(&mut self, motion: Move<T>, initial: InitialMotion, axes: &AxisLimits, clock: &Clock) {
        self.tail = None;
        let own = motion.limits;
        let initial = match own.jerk {
            Some(_) => initial,
            None => InitialMotion {
                acceleration: Point::zeros(),
                ..initial
            },
        };
        let whole = AxisLimitShare {
            axes: *axes,
            path: motion.path,
            share: 1.0,
            drift: Point::zeros(),
        };
        let at_rest = initial.velocity == Point::zeros() && initial.acceleration == Point::zeros();
        if at_rest || continues_along(&motion.path, &initial) {
            let from = KinematicState {
                position: 0.0,
                velocity: initial.velocity.norm(),
                acceleration: motion.path.start_tangent().dot(&initial.acceleration),
            };
            self.run_within(motion, RunStart::new(from, clock.now()), whole, clock);
            return;
        }
        let plan = residual_beside(&motion, &initial, axes).unwrap_or_else(|| {
            let parts = ramped_out(&initial, &own, axes, &motion.path, 1.0);
            ResidualPlan {
                wait: parts.iter().map(|part| part.profile.duration()).fold(0.0, f64::max),
                within: AxisLimitShare {
                    drift: drift(&parts, &motion.path),
                    ..whole
                },
                parts,
            }
        });
        let residual = Residual {
            parts: plan.parts,
            start: clock.now(),
            share: 1.0,
        };
        let start = RunStart {
            residual: Some(residual),
            ..RunStart::new(KinematicState::default(), clock.now().after(plan.wait, clock))
        };
        self.run_within(motion, start, plan.within, clock);
    }

    /// The permitted limits for a change of the active move.
    pub(crate) fn allowed(&self, limits: &Limits) -> Limits {
        self.within.map_or(*limits, |within| within.limits(limits))
    }

    /// The largest override at which the axes keep their limits on the active move.
    pub(crate) fn most_rate(&self) -> f64 {
        let Some((within, running)) = self.within.zip(self.active) else {
            return f64::INFINITY;
        };
        let programmed = running.motion.limits;
        let fastest = within.limits(&Limits {
            speed: f64::INFINITY,
            ..programmed
        });
        if programmed.speed > 0.0 {
            fastest.speed / programmed.speed
        } else {
            f64::INFINITY
        }
    }

    fn run_within(&mut self, mut motion: Move<T>, start: RunStart, within: AxisLimitShare, clock: &Clock) {
        motion.limits = within.limits(&motion.limits);
        self.within = Some(within);
        self.run(motion, start, clock);
    }
}

/// Path and residual at the same time, if that keeps the limits.
fn residual_beside<T>(motion: &Move<T>, initial: &InitialMotion, axes: &AxisLimits) -> Option<ResidualPlan> {
    let own = &motion.limits;
    if motion.path.length() <= 0.0 {
        return None;
    }
    let parts = ramped_out(initial, own, axes, &motion.path, HALF);
    let mut wait = 0.0_f64;
    for (axis, part) in parts.iter().enumerate() {
        let (v, a) = (initial.velocity[axis], initial.acceleration[axis]);
        if a == 0.0 {
            continue;
        }
        // An axis that reverses accelerates again, with all of the jerk.
        if v * a < 0.0 && turns(&part.profile, v) {
            return None;
        }
        if v * a >= 0.0 {
            wait = wait.max(a.abs() / axes.jerk.map_or(f64::INFINITY, |jerk| jerk[axis]));
        }
    }
    let within = AxisLimitShare {
        axes: *axes,
        path: motion.path,
        share: HALF,
        drift: drift(&parts, &motion.path),
    };
    // At any time from a hold to the highest override.
    let limits = within.limits(&Limits {
        speed: MOST_RATE * own.speed,
        ..*own
    });
    let along = Profile::to_position(KinematicState::default(), motion.path.length(), 0.0, &limits);
    let whole = parts.iter().map(|part| part.profile.duration()).fold(0.0, f64::max);
    let most = within.most_tangent();
    let mut speed = 0.0_f64;
    let is_within = (0..=SAMPLES).all(|k| {
        let t = whole * f64::from(k) / f64::from(SAMPLES);
        speed = speed.max(along.at((t + whole / f64::from(SAMPLES) - wait).max(0.0)).velocity);
        (0..3).all(|axis| {
            let residual = parts[axis].profile.at(t).velocity;
            let path = most[axis] * speed;
            let sum = match motion.path {
                Path::Line(_) => residual + path,
                Path::Arc(_) => residual.abs() + path,
            };
            residual.abs().max(sum.abs()) <= axes.speed[axis] * (1.0 + ROUNDING_SHARE)
        })
    });
    is_within.then_some(ResidualPlan { parts, wait, within })
}

/// The plan of a residual and a path.
struct ResidualPlan {
    parts: [ResidualPart; 3],
    /// Seconds that the path waits.
    wait: f64,
    within: AxisLimitShare,
}

/// The velocity continues along a path, with a component across it below the 0.1 degree of other merges.
fn continues_along(path: &Path, initial: &InitialMotion) -> bool {
    let tangent = path.start_tangent();
    let along = tangent.dot(&initial.acceleration);
    let across = (initial.acceleration - tangent * along).norm();
    matches!(path, Path::Line(_))
        && path.length() > 0.0
        && initial.velocity.dot(&tangent) > 0.0
        && initial.velocity.cross(&tangent).norm() <= NO_ACCELERATION_SHARE * initial.velocity.norm()
        && across <= NO_ACCELERATION_SHARE * initial.acceleration.norm()
}

/// Ramps out the motion of the axes with a share of their limits, and of the programmed deceleration. A path without length cannot
/// compensate: the residual returns by itself.
fn ramped_out(initial: &InitialMotion, own: &Limits, axes: &AxisLimits, path: &Path, share: f64) -> [ResidualPart; 3] {
    let speed = initial.velocity.norm();
    let moving = initial.acceleration != Point::zeros();
    // Along the direction of motion if only a velocity ramps out.
    let most = |vector: f64, limits: &Point| {
        (0..3).fold(vector, |most, axis| {
            most.min(share * limits[axis] * speed / initial.velocity[axis].abs())
        })
    };
    let rate = |axis: usize, vector: f64, limits: &Point| {
        let along = most(vector, limits) * initial.velocity[axis].abs() / speed;
        let alone = if moving {
            (share * limits[axis]).min(0.5 * vector)
        } else {
            0.0
        };
        f64::max(if along.is_finite() { along } else { 0.0 }, alone).max(LEAST_RATE_UNITS)
    };
    [0, 1, 2].map(|axis| {
        let deceleration = rate(axis, own.deceleration, &axes.acceleration);
        let jerk = own.jerk.map(|jerk| {
            let limits = axes.jerk.unwrap_or(Point::repeat(f64::INFINITY));
            // The acceleration ramps down as fast as that of the path may rise.
            let slow = match limits[axis] {
                own if moving && own.is_finite() => share * own,
                _ => rate(axis, jerk.deceleration, &limits),
            };
            Jerk {
                // An accelerating part gets all of the jerk: only then it surely stays below the axis's speed.
                acceleration: if limits[axis].is_finite() { limits[axis] } else { slow },
                deceleration: slow,
            }
        });
        let from = KinematicState {
            position: 0.0,
            velocity: initial.velocity[axis],
            acceleration: initial.acceleration[axis],
        };
        let limits = Limits {
            speed: axes.speed[axis].min(own.speed).max(from.velocity.abs()),
            acceleration: deceleration,
            deceleration,
            jerk,
        };
        let mut direction = Point::zeros();
        direction[axis] = 1.0;
        let profile = if path.length() > 0.0 {
            Profile::stop(from, &limits)
        } else {
            Profile::to_position(from, 0.0, 0.0, &limits)
        };
        ResidualPart::new(direction, profile)
    })
}

/// A stop passes through rest and reverses.
fn turns(stop: &Profile, velocity: f64) -> bool {
    stop.segment_times()
        .iter()
        .any(|&t| stop.at(t).velocity * velocity < 0.0)
}

fn drift(parts: &[ResidualPart; 3], path: &Path) -> Point {
    let length = path.length();
    let total: Point = parts.iter().map(ResidualPart::total).sum();
    if length > 0.0 { total / length } else { Point::zeros() }
}

impl AxisLimitShare {
    /// Limits along the path at which no axis exceeds its share of its own.
    pub(crate) fn limits(&self, own: &Limits) -> Limits {
        match &self.path {
            Path::Line(line) => self.on_line(own, &(line.direction() - self.drift)),
            Path::Arc(arc) => {
                let curvature = TIGHTER_SPIRAL_RATIO / arc.radius().min(arc.end_radius());
                self.on_arc(own, &arc.normal(), curvature)
            }
        }
    }

    /// The displacement of every axis for a unit of the path; for an arc the largest one.
    fn most_tangent(&self) -> Point {
        match &self.path {
            Path::Line(line) => line.direction() - self.drift,
            Path::Arc(arc) => in_plane(&arc.normal()) + self.drift.abs(),
        }
    }

    fn on_line(&self, own: &Limits, direction: &Point) -> Limits {
        let least = |vector: f64, limits: &Point, share: f64| {
            (0..3).fold(vector, |least, axis| {
                least.min(share * limits[axis] / direction[axis].abs())
            })
        };
        let jerk = |vector: f64| match &self.axes.jerk {
            Some(axes) => least(vector, axes, self.share),
            None => vector,
        };
        // Includes the compensation.
        let compensated = 1.0 / direction.norm().max(1.0);
        Limits {
            speed: least(own.speed * compensated, &self.axes.speed, 1.0),
            acceleration: least(own.acceleration, &self.axes.acceleration, self.share),
            deceleration: least(own.deceleration, &self.axes.acceleration, self.share),
            jerk: own.jerk.map(|own| Jerk {
                acceleration: jerk(own.acceleration),
                deceleration: jerk(own.deceleration),
            }),
        }
    }

    /// Halves of the acceleration along and across; thirds of the jerk `j t + 3 v a k n - k² v³ t`.
    fn on_arc(&self, own: &Limits, normal: &Point, curvature: f64) -> Limits {
        let in_plane = in_plane(normal);
        let each = || (0..3).filter(|&axis| in_plane[axis] > NO_COMPONENT_SINE);
        let along = |axis: usize| in_plane[axis] + self.drift[axis].abs();
        let across = |axis: usize| in_plane[axis] * curvature;
        let a_of = |axis: usize| self.share * self.axes.acceleration[axis] / 2.0;
        let j_of = |axis: usize| match &self.axes.jerk {
            Some(jerk) if own.jerk.is_some() => self.share * jerk[axis] / 3.0,
            _ => f64::INFINITY,
        };
        let most_speed = each().fold(f64::INFINITY, |speed, axis| {
            speed
                .min(self.axes.speed[axis] / along(axis))
                .min((a_of(axis) / across(axis)).sqrt())
                .min(libm::cbrt(j_of(axis) / (across(axis) * curvature * curvature)))
        });
        let speed = own.speed / (1.0 + self.drift.norm());
        // A later override may double the speed.
        let coupled = most_speed.min(MOST_RATE * speed);
        let rate = each().fold(f64::INFINITY, |rate, axis| {
            rate.min(a_of(axis) / along(axis))
                .min(j_of(axis) / (3.0 * across(axis) * coupled))
        });
        let most = each().fold(f64::INFINITY, |most, axis| most.min(j_of(axis) / along(axis)));
        Limits {
            speed: speed.min(most_speed),
            acceleration: own.acceleration.min(rate),
            deceleration: own.deceleration.min(rate),
            jerk: own.jerk.map(|own| Jerk {
                acceleration: own.acceleration.min(most),
                deceleration: own.deceleration.min(most),
            }),
        }
    }
}

/// The largest component of a unit vector in a plane along each axis.
fn in_plane(normal: &Point) -> Point {
    normal.map(|n| (1.0 - n * n).max(0.0).sqrt())
}

/// The shares of the limits for residual and path.
const HALF: f64 = 0.5;
/// The highest override of a move.
const MOST_RATE: f64 = 2.0;
/// Samples of the sum of both.
const SAMPLES: u32 = 100;
