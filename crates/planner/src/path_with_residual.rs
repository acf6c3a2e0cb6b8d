//! The profile of a path beside a residual: the sum of both never exceeds a speed.
//!
//! If it would, the path holds its speed until enough of the residual has ramped out. On a line the two are at right angles, so a hold is
//! always slow enough. Not here: the residual (`ramp_out`), and the start of a merge (`merge`). Position units and seconds.
//! Bounded; no allocation.

use arcline_geometry::{Path, Point};
use arcline_profile::numeric::bisect;
use arcline_profile::{AccelerationRemovalPhase, KinematicState, Limits, Phase, Profile};

use crate::move_trajectory::ResidualPart;
use crate::ramp_out::forward;
use crate::tolerance::{ROUNDING_SHARE, VERTEX_SHARE};

/// A path during which a residual ramps out.
pub(crate) struct PathWithResidual<'a> {
    pub(crate) path: &'a Path,
    pub(crate) parts: &'a [ResidualPart; 3],
    /// Seconds for which the residual has ramped out at the beginning of the path's profile.
    pub(crate) since: f64,
    /// The highest speed of the sum.
    pub(crate) bound: f64,
}

impl PathWithResidual<'_> {
    /// The fastest profile along the path whose sum with the residual keeps the bound: the one of `plan`, or one after a hold. `removal`: the
    /// jerk that removes an acceleration before a hold. `None` if a hold is too fast.
    pub(crate) fn profile(
        &self,
        from: KinematicState,
        limits: &Limits,
        removal: f64,
        plan: impl Fn(KinematicState, &Limits) -> Profile,
    ) -> Option<Profile> {
        let free = Profile::after_removal(
            forward(from, limits, self.bound / self.max_displacement_per_unit()),
            from,
            |from| plan(from, limits),
        );
        if self.is_within_bound(&free) {
            return Some(free);
        }
        let held = |wait| held(from, limits, removal, wait, &plan);
        let longest = self.until();
        let mut best = held(longest);
        if !self.is_within_bound(&best) {
            return None;
        }
        // The last profile within the bound is that of the shortest wait.
        bisect(0.0, longest, HALVINGS, |wait| {
            let tried = held(wait);
            let within = self.is_within_bound(&tried);
            if within {
                best = tried;
            }
            within
        });
        Some(best)
    }

    /// The profile that holds its speed until the residual has ramped out.
    pub(crate) fn waiting(
        &self,
        from: KinematicState,
        limits: &Limits,
        removal: f64,
        plan: impl Fn(KinematicState, &Limits) -> Profile,
    ) -> Profile {
        held(from, limits, removal, self.until(), &plan)
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
        self.parts.iter().map(ResidualPart::total).sum::<Point>() / self.path.length()
    }

    /// The largest displacement for a unit of the path, with the compensation.
    fn max_displacement_per_unit(&self) -> f64 {
        match self.path {
            Path::Line(line) => (line.direction() - self.drift()).norm(),
            Path::Arc(_) => 1.0 + self.drift().norm(),
        }
    }

    /// The sum keeps the bound until the residual has ramped out: at the joints of all profiles, between them, and at the vertices of the
    /// parabolas through three samples.
    fn is_within_bound(&self, along: &Profile) -> bool {
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
        let most = self.bound * self.bound * (1.0 + ROUNDING_SHARE);
        let (mut begin, mut first) = (0.0, square(0.0));
        for &end in times.iter() {
            let length = end - begin;
            if length <= 0.0 {
                continue;
            }
            let mut samples = [first; INTERVALS + 1];
            for (index, sample) in samples.iter_mut().enumerate().skip(1) {
                *sample = square(begin + length * index as f64 / INTERVALS as f64);
            }
            if highest(&square, begin, end, &samples, most) > most {
                return false;
            }
            (begin, first) = (end, samples[INTERVALS]);
        }
        true
    }
}

/// The maximum of a smooth function between two instants, from `samples` at equal distances; exact if it is close to `most`.
fn highest(square: &impl Fn(f64) -> f64, begin: f64, end: f64, samples: &[f64; INTERVALS + 1], most: f64) -> f64 {
    let (mut begin, mut end, mut samples) = (begin, end, *samples);
    let mut found = vertices(&samples);
    for _ in 0..NARROWINGS {
        if found > most || found <= most * (1.0 - VERTEX_SHARE) {
            break;
        }
        let top = (0..=INTERVALS).fold(0, |top, index| if samples[index] > samples[top] { index } else { top });
        let (before, after) = (top.saturating_sub(1), (top + 1).min(INTERVALS));
        let step = (end - begin) / INTERVALS as f64;
        (begin, end) = (begin + step * before as f64, begin + step * after as f64);
        let part = (end - begin) / INTERVALS as f64;
        samples = std::array::from_fn(|index| square(begin + part * index as f64));
        found = vertices(&samples);
    }
    found
}

/// The highest of samples at equal distances, and of the vertices of the parabolas through three of them.
fn vertices(samples: &[f64; INTERVALS + 1]) -> f64 {
    let vertex = |window: &[f64]| {
        let bend = 0.5 * (window[0] + window[2]) - window[1];
        let slope = 0.5 * (window[2] - window[0]);
        let within = bend < 0.0 && slope.abs() < -2.0 * bend;
        window[1] - if within { 0.25 * slope * slope / bend } else { 0.0 }
    };
    let most = samples.windows(3).map(vertex).fold(samples[0], f64::max);
    most.max(samples[INTERVALS])
}

/// A plan after a hold of this duration, unless the plan must slow down earlier.
fn held(
    from: KinematicState,
    limits: &Limits,
    removal: f64,
    wait: f64,
    plan: &impl Fn(KinematicState, &Limits) -> Profile,
) -> Profile {
    let jerk = if from.acceleration * from.velocity < 0.0 {
        let own = limits.jerk.map_or(f64::INFINITY, |jerk| jerk.deceleration);
        let critical = AccelerationRemovalPhase::before_rest(from, limits).map_or(0.0, |phase| phase.jerk);
        own.max(critical)
    } else {
        removal
    };
    let removal_phase = AccelerationRemovalPhase { from, jerk, hold: 0.0 };
    let level = removal_phase.end();
    let hold = wait - removal_phase.duration();
    let free = || removal_phase.then(&plan(level, limits));
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
            return removal_phase.then(&slow);
        }
    }
    let removal_phase = AccelerationRemovalPhase { hold, ..removal_phase };
    removal_phase.then(&plan(removal_phase.end(), limits))
}

/// Halvings of the wait before a hold ends.
const HALVINGS: usize = 6;
const MOST_JOINTS: usize = 64;
/// Parts of the time between two joints.
/// Intervals between two instants; their ends are samples.
const INTERVALS: usize = 4;
/// Narrowings, each of which samples at most half of the interval before.
const NARROWINGS: usize = 4;
