//! What a merge terminates ramps out beside the new path: `P = path(s) + r - D s / length`, where `D` is the whole of `r`
//! (spec/coordinated-instructions.md §6.3).
//!
//! The velocity is split along and across the path. What is along it begins the path's profile; the rest ramps out, over no more
//! way than a stop with the old dynamics takes. Both together are never faster than the fastest of the present, the old and the
//! new speed: where they would be, the path holds its speed until enough has ramped out. On a line both are at right angles, so
//! holding is always slow enough; where a path turns towards what ramps out, everything ramps out before the path begins.
//!
//! Position units and seconds (master units in place of seconds). Bounded; no allocation.

use arcline_geometry::{Path, Point};
use arcline_profile::{Jerk, KinematicState, Lead, Limits, Phase, Profile};

use crate::Clock;
use crate::junction::{braking, is_along};
use crate::planner::{Momentum, Move, NO_ACCELERATION, Planner, Relief, paced};
use crate::track::{Part, Residual};

impl<T: Copy> Planner<T> {
    /// Starts a move at the present tick out of another motion.
    pub fn merge(&mut self, mut motion: Move<T>, momentum: Momentum, clock: &Clock) {
        self.queue.forget_corners();
        self.tail = None;
        let speed = momentum.velocity.norm();
        if speed == 0.0 {
            self.start(motion, clock.now(), clock);
            return;
        }
        let widest = momentum.before.filter(|_| self.bounds.overshoot).map(|before| {
            let from = KinematicState {
                position: 0.0,
                velocity: speed,
                acceleration: momentum.acceleration.dot(&momentum.velocity) / speed,
            };
            Profile::stop(from, &before).reach()
        });
        let widest = widest.unwrap_or(f64::INFINITY);
        let mut momentum = momentum;
        if motion.limits.jerk.is_none() {
            momentum.acceleration = Point::zeros();
        }
        let old = self.active.map_or(0.0, |running| running.in_force.speed);
        let terminated = momentum.before.map_or(0.0, |before| before.speed);
        let programmed = self.programmed_speed(old, motion.limits.speed);
        let bound = speed.max(programmed).max(terminated);
        let (path, tangent) = (&motion.path, motion.path.start_tangent());
        let direction = momentum.velocity / speed;
        let along = momentum.acceleration.dot(&direction);
        let across = (momentum.acceleration - direction * along).norm();
        let level = across <= NO_ACCELERATION * momentum.acceleration.norm();
        if path.length() > 0.0 && level && is_along(&momentum.velocity, &tangent) {
            let from = KinematicState {
                position: 0.0,
                velocity: speed,
                acceleration: along,
            };
            let relief = if self.bounds.overshoot {
                motion.limits = short(from, &motion.limits, 1.0, path.length().max(widest));
                Relief {
                    ceiling: bound,
                    forward: Some(0.0),
                }
            } else {
                Relief::NONE
            };
            self.run_relieved(motion, from, relief, clock);
            return;
        }
        let out = RampOut {
            momentum,
            limits: self.ramping_out(&momentum, &motion.limits, widest, bound),
            widest,
            across: 1.0,
        };
        let rate = self.queue.rate();
        // A path without length cannot compensate: what ramps out comes back by itself.
        let pieces = if path.length() == 0.0 {
            Pieces {
                parts: out.and_back(),
                from: KinematicState::default(),
                limits: motion.limits,
                profile: None,
            }
        } else {
            pieces(&motion, out, rate, self.bounds.overshoot.then_some(bound))
        };
        let residual = Residual::new(pieces.parts, clock.now(), path);
        motion.limits = pieces.limits;
        self.run_beside(motion, residual, pieces.from, pieces.profile, clock);
    }

    /// The limits of a move with which a stop out of a motion takes no more than a way, and is no faster than `bound`.
    fn ramping_out(&self, momentum: &Momentum, own: &Limits, widest: f64, bound: f64) -> Limits {
        let speed = momentum.velocity.norm();
        let limits = braking(own, speed);
        if !self.bounds.overshoot {
            return limits;
        }
        let from = KinematicState {
            position: 0.0,
            velocity: speed,
            acceleration: momentum.acceleration.dot(&momentum.velocity) / speed,
        };
        let mut limits = relieved(from, &limits, bound);
        let old = momentum.before.and_then(|before| before.jerk);
        let mut wider = false;
        let wide = Profile::stop(from, &limits).reach() > widest * (1.0 + NEARLY);
        if let (Some(jerk), Some(old)) = (&mut limits.jerk, old.filter(|_| wide)) {
            // The old jerk takes the acceleration away in time; the rest of the way is the braking's.
            jerk.acceleration = jerk.acceleration.max(old.acceleration);
            wider = true;
        }
        let slowed = hastened(from, &limits, widest, wider);
        hastened(from, &slowed, widest, false)
    }
}

/// Limits with the jerks that take an acceleration away before a motion is faster than `fastest`, or passes through rest.
fn relieved(from: KinematicState, limits: &Limits, fastest: f64) -> Limits {
    let mut limits = *limits;
    let lead = forward(from, &limits, fastest);
    if let (Some(lead), Some(jerk)) = (lead, &mut limits.jerk) {
        if from.acceleration < 0.0 {
            jerk.deceleration = jerk.deceleration.max(lead.jerk);
        } else {
            jerk.acceleration = jerk.acceleration.max(lead.jerk);
        }
    }
    limits
}

/// Limits whose ramps are hastened, as little as need be, until a stop takes no more than a way.
fn hastened(from: KinematicState, limits: &Limits, widest: f64, braking: bool) -> Limits {
    let widest = widest * (1.0 + NEARLY);
    let fits = |limits: &Limits| stop_way(from, limits) <= widest;
    if widest.is_nan() || widest <= 0.0 || fits(limits) {
        return *limits;
    }
    // Of the braking alone, or of all.
    let faster = |factor: f64| {
        let all = limits.hastened(factor);
        let Some((own, all_jerk)) = limits.jerk.zip(all.jerk).filter(|_| braking) else {
            return all;
        };
        Limits {
            acceleration: limits.acceleration,
            jerk: Some(Jerk {
                acceleration: own.acceleration,
                ..all_jerk
            }),
            ..all
        }
    };
    if braking && !fits(&faster(MOST_HASTE)) {
        return *limits;
    }
    let (mut less, mut more) = (1.0, 2.0);
    for _ in 0..DOUBLINGS {
        if fits(&faster(more)) {
            break;
        }
        (less, more) = (more, 2.0 * more);
    }
    for _ in 0..HALVINGS {
        let middle = (less * more).sqrt();
        if fits(&faster(middle)) {
            more = middle;
        } else {
            less = middle;
        }
    }
    faster(more)
}

/// The way of a stop that does not pass through rest.
fn stop_way(from: KinematicState, limits: &Limits) -> f64 {
    Profile::led(Lead::before_rest(from, limits), from, |from| {
        Profile::stop(from, limits)
    })
    .reach()
}

/// Limits with which a stop, on a path that is travelled with a share of them, takes no more than a way.
fn short(from: KinematicState, limits: &Limits, pace: f64, widest: f64) -> Limits {
    let own = paced(limits, 1.0, pace);
    if stop_way(from, &own) <= widest * (1.0 + NEARLY) {
        return *limits;
    }
    let own = hastened(from, &own, widest, false);
    Limits {
        speed: limits.speed,
        acceleration: own.acceleration / pace,
        deceleration: own.deceleration / pace,
        jerk: own.jerk.map(|jerk| Jerk {
            acceleration: jerk.acceleration / pace,
            deceleration: jerk.deceleration / pace,
        }),
    }
}

/// The lead that keeps a motion below a speed, and from passing through rest.
fn forward(from: KinematicState, limits: &Limits, ceiling: f64) -> Option<Lead> {
    if from.velocity * from.acceleration < 0.0 {
        Lead::before_rest(from, limits)
    } else {
        Lead::below(from, limits, ceiling)
    }
}

/// What is terminated, and how it ramps out.
#[derive(Clone, Copy)]
struct RampOut {
    momentum: Momentum,
    limits: Limits,
    /// The way of a stop with the limits that the motion had.
    widest: f64,
    /// How many times faster an acceleration across the velocity is taken away; infinite: at once.
    across: f64,
}

/// A path and what ramps out beside it.
struct Pieces {
    parts: [Part; 3],
    /// Where the path begins.
    from: KinematicState,
    /// Its limits.
    limits: Limits,
    /// How the path is travelled; `None`: as its limits let it.
    profile: Option<Profile>,
}

/// Path and residual together, no faster than `bound`.
fn pieces<T: Copy>(motion: &Move<T>, out: RampOut, rate: f64, bound: Option<f64>) -> Pieces {
    let path = &motion.path;
    let level = |factor| RampOut { across: factor, ..out };
    let travelled = |split: &Pieces| {
        let beside = Beside {
            path,
            parts: &split.parts,
            since: 0.0,
            bound: bound?,
        };
        let pace = Residual::pace_of(&split.parts, path);
        let limits = paced(&split.limits, rate, pace);
        let total = out.momentum.acceleration.norm();
        let relief = out
            .limits
            .jerk
            .map_or(0.0, |jerk| split.from.acceleration * jerk.acceleration / total);
        let plan = |from, limits: &Limits| Profile::to_position(from, path.length(), 0.0, limits);
        Some((
            beside.profile(split.from, &limits, relief, plan),
            beside.waiting(split.from, &limits, relief, plan),
        ))
    };
    if bound.is_none() {
        return split(motion, &out).unwrap_or_else(|| apart(motion, &out));
    }
    for factor in ACROSS {
        let Some(mut split) = split(motion, &level(factor)) else {
            break;
        };
        let pace = Residual::pace_of(&split.parts, path);
        split.limits = short(split.from, &split.limits, pace, path.length().max(out.widest));
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

/// All of the motion ramps out; the path begins from rest.
fn apart<T>(motion: &Move<T>, out: &RampOut) -> Pieces {
    Pieces {
        parts: out.parts(out.momentum.velocity, out.momentum.acceleration),
        from: KinematicState::default(),
        limits: motion.limits,
        profile: None,
    }
}

/// What is along the path, compensation included, begins it; `None` where nothing is, or where the path is too short to tell.
fn split<T>(motion: &Move<T>, out: &RampOut) -> Option<Pieces> {
    let path = &motion.path;
    let Momentum {
        velocity, acceleration, ..
    } = out.momentum;
    let tangent = path.start_tangent();
    let mut drift = Point::zeros();
    for _ in 0..SPLITTINGS {
        let way = tangent - drift;
        let square = way.norm_squared();
        let along = KinematicState {
            position: 0.0,
            velocity: velocity.dot(&way) / square,
            acceleration: acceleration.dot(&way) / square,
        };
        // What is across the path but for rounding is across it.
        let forward = along.velocity * square.sqrt();
        if square < LEAST_WAY || forward.is_nan() || forward <= NEARLY * velocity.norm() {
            return None;
        }
        let parts = out.parts(velocity - way * along.velocity, acceleration - way * along.acceleration);
        let before = drift;
        drift = parts.iter().map(Part::total).sum::<Point>() / path.length();
        // The velocity steps by this.
        if (drift - before).norm() * along.velocity <= ROUNDING * velocity.norm() {
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

impl RampOut {
    fn parts(&self, velocity: Point, acceleration: Point) -> [Part; 3] {
        let speed = velocity.norm();
        let direction = velocity.try_normalize(0.0).unwrap_or_default();
        let mut along = acceleration.dot(&direction);
        let slow = self
            .limits
            .jerk
            .is_some_and(|jerk| speed < 0.5 * along * along / jerk.deceleration * (1.0 - NEARLY));
        if along < 0.0 && slow {
            along = 0.0;
        }
        let mut across = acceleration - direction * along;
        if across.norm() <= NO_ACCELERATION * self.momentum.acceleration.norm() || self.across.is_infinite() {
            across = Point::zeros();
        }
        let nothing = Part::new(Point::zeros(), Profile::rest(0.0));
        let first = if speed > 0.0 {
            let from = KinematicState {
                position: 0.0,
                velocity: speed,
                acceleration: along,
            };
            let limits = hastened(from, &self.limits, self.widest, false);
            Part::new(direction, Profile::stop(from, &limits))
        } else {
            nothing
        };
        let second = match across.try_normalize(0.0) {
            Some(direction) => {
                let from = KinematicState {
                    acceleration: across.norm(),
                    ..KinematicState::default()
                };
                let limits = self.limits.hastened(self.across);
                let limits = hastened(from, &limits, ASIDE * self.widest, false);
                Part::new(direction, Profile::stop(from, &limits))
            }
            None => nothing,
        };
        [first, second, nothing]
    }

    /// All of the motion ramps out, and comes back.
    fn and_back(&self) -> [Part; 3] {
        let mut parts = self.parts(self.momentum.velocity, self.momentum.acceleration);
        for part in &mut parts {
            let from = part.profile.start();
            *part = Part::new(part.direction, Profile::to_position(from, 0.0, 0.0, &self.limits));
        }
        parts
    }
}

/// A path that is travelled while something ramps out.
pub(crate) struct Beside<'a> {
    pub(crate) path: &'a Path,
    pub(crate) parts: &'a [Part; 3],
    /// Seconds for which the parts have ramped out when the path is at the beginning of its profile.
    pub(crate) since: f64,
    /// The speed that both together may have.
    pub(crate) bound: f64,
}

impl Beside<'_> {
    /// The fastest profile along the path with which both keep the bound: as `plan` makes it, or behind a hold. `relief`: the
    /// jerk with which an acceleration is taken away before a hold. `None` where a hold is too fast.
    pub(crate) fn profile(
        &self,
        from: KinematicState,
        limits: &Limits,
        relief: f64,
        plan: impl Fn(KinematicState, &Limits) -> Profile,
    ) -> Option<Profile> {
        let free = Profile::led(forward(from, limits, self.bound / self.most_way()), from, |from| {
            plan(from, limits)
        });
        if self.keeps(&free) {
            return Some(free);
        }
        let held = |wait| held(from, limits, relief, wait, &plan);
        let mut longest = self.until();
        let mut best = held(longest);
        if !self.keeps(&best) {
            return None;
        }
        let mut shortest = 0.0;
        for _ in 0..BISECTIONS {
            let middle = 0.5 * (shortest + longest);
            let tried = held(middle);
            if self.keeps(&tried) {
                (best, longest) = (tried, middle);
            } else {
                shortest = middle;
            }
        }
        Some(best)
    }

    /// The path holds its speed until everything has ramped out.
    pub(crate) fn waiting(
        &self,
        from: KinematicState,
        limits: &Limits,
        relief: f64,
        plan: impl Fn(KinematicState, &Limits) -> Profile,
    ) -> Profile {
        held(from, limits, relief, self.until(), &plan)
    }

    fn until(&self) -> f64 {
        let whole = self
            .parts
            .iter()
            .map(|part| part.profile.duration())
            .fold(0.0, f64::max);
        (whole - self.since).max(0.0)
    }

    fn drift(&self) -> Point {
        self.parts.iter().map(Part::total).sum::<Point>() / self.path.length()
    }

    /// How far a unit of the path leads at most, compensation included.
    fn most_way(&self) -> f64 {
        match self.path {
            Path::Line(line) => (line.direction() - self.drift()).norm(),
            Path::Arc(_) => 1.0 + self.drift().norm(),
        }
    }

    /// Whether both keep the bound until everything has ramped out: at the joints of all profiles, between them, and at the
    /// vertices of the parabolas through three such places.
    fn keeps(&self, along: &Profile) -> bool {
        let until = self.until();
        let mut times = [until; MOST_JOINTS];
        let mut count = 0;
        let mut note = |time: f64| {
            if time > 0.0 && time < until && count + 1 < MOST_JOINTS {
                times[count] = time;
                count += 1;
            }
        };
        along.segment_times().iter().for_each(|time| note(*time));
        note(along.duration());
        for part in self.parts {
            part.profile
                .segment_times()
                .iter()
                .for_each(|time| note(time - self.since));
        }
        let times = &mut times[..=count];
        times.sort_unstable_by(f64::total_cmp);
        let drift = self.drift();
        let line = match self.path {
            Path::Line(line) => Some(line.direction()),
            Path::Arc(_) => None,
        };
        let square = |time: f64| {
            let now = along.at(time);
            let tangent = line.unwrap_or_else(|| self.path.at(now.position).tangent);
            let mut velocity = (tangent - drift) * now.velocity;
            for part in self.parts {
                velocity += part.direction * part.profile.at(self.since + time).velocity;
            }
            velocity.norm_squared()
        };
        let most = self.bound * self.bound * (1.0 + NEARLY);
        let (mut begin, mut first) = (0.0, square(0.0));
        for &end in times.iter() {
            let length = end - begin;
            if length <= 0.0 {
                continue;
            }
            let mut looks = [first; LOOKS + 1];
            for (place, look) in looks.iter_mut().enumerate().skip(1) {
                *look = square(begin + length * place as f64 / LOOKS as f64);
            }
            let peak = |window: &[f64]| {
                let bend = 0.5 * (window[0] + window[2]) - window[1];
                let slope = 0.5 * (window[2] - window[0]);
                let within = bend < 0.0 && slope.abs() < -2.0 * bend;
                window[1] - if within { 0.25 * slope * slope / bend } else { 0.0 }
            };
            let too_fast = looks.iter().any(|look| *look > most);
            if too_fast || looks.windows(3).any(|window| peak(window) > most) {
                return false;
            }
            (begin, first) = (end, looks[LOOKS]);
        }
        true
    }
}

/// A plan behind a hold that ends so many seconds from now, unless the plan must slow down before.
fn held(
    from: KinematicState,
    limits: &Limits,
    relief: f64,
    wait: f64,
    plan: &impl Fn(KinematicState, &Limits) -> Profile,
) -> Profile {
    let lead = if from.acceleration * from.velocity < 0.0 {
        let own = limits.jerk.map_or(f64::INFINITY, |jerk| jerk.deceleration);
        let critical = Lead::before_rest(from, limits).map_or(0.0, |lead| lead.jerk);
        own.max(critical)
    } else {
        relief
    };
    let lead = Lead {
        from,
        jerk: lead,
        hold: 0.0,
    };
    let level = lead.end();
    let hold = wait - lead.duration();
    let free = || lead.then(&plan(level, limits));
    if hold <= 0.0 || level.velocity < 0.0 || level.velocity >= limits.speed {
        return free();
    }
    if level.velocity > 0.0 {
        let slow = plan(
            level,
            &Limits {
                speed: level.velocity,
                ..*limits
            },
        );
        let steady = slow
            .segment_times()
            .iter()
            .find(|time| slow.phase(**time) != Phase::Steady);
        if steady.is_some_and(|steady| hold >= *steady) {
            return lead.then(&slow);
        }
    }
    let lead = Lead { hold, ..lead };
    lead.then(&plan(lead.end(), limits))
}

/// Factors by which an acceleration across the velocity may be taken away faster.
const ACROSS: [f64; 3] = [1.0, 4.0, f64::INFINITY];
/// How wide an acceleration across the velocity may lead, as a share of the stop.
const ASIDE: f64 = 0.1;
/// The most that braking alone is hastened.
const MOST_HASTE: f64 = 1e6;
/// How often a stop is hastened twofold at most, and how exactly the least haste is found.
const DOUBLINGS: usize = 24;
const HALVINGS: usize = 20;
const SPLITTINGS: usize = 32;
/// Square of the share of a path that a compensation may leave.
const LEAST_WAY: f64 = 0.01;
const BISECTIONS: usize = 6;
const MOST_JOINTS: usize = 64;
/// Parts of the time between two joints.
const LOOKS: usize = 4;
/// Share of a speed that is rounding.
const NEARLY: f64 = 1e-9;
const ROUNDING: f64 = 1e-13;
