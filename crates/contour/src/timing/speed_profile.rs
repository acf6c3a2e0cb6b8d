//! A first guess of the timing, used only to place the nodes: dense in slow parts of the motion.
//!
//! Speed bounds from curvature and its change, one backward and one forward pass with constant
//! acceleration. Seconds and position units.

use crate::limits::{MoveLimits, Smoothness};
use crate::path::reference::ReferencePath;
use crate::path::rounding::{Stretch, StretchShape};
use crate::tolerance::SAME_SAMPLE_UNITS;
use crate::tuning::TUNING;
use crate::{Path, Point};
use arcline_profile::{Jerk, KinematicState, Limits, Profile};

/// A point of the rounded reference path.
pub(crate) struct Sample {
    pub(crate) stretch: usize,
    pub(crate) u: f64,
    pub(crate) point: Point,
    pub(crate) progress: f64,
}

/// The speeds at the samples, as a first guess.
pub(crate) struct SampledSpeeds {
    /// Squares of the speed at the samples.
    pub(crate) square: Vec<f64>,
    /// Seconds from the first sample.
    pub(crate) times: Vec<f64>,
    /// Distance from sample to sample.
    pub(crate) length: Vec<f64>,
    /// Acceleration along the path from sample to sample.
    pub(crate) rate: Vec<f64>,
    pub(crate) curvature: Vec<Point>,
}

impl SampledSpeeds {
    /// The motion from one sample to the next has constant velocity.
    pub(crate) fn is_cruise(&self, i: usize) -> bool {
        let straight = self.curvature[i] == Point::zeros() && self.curvature[i + 1] == Point::zeros();
        self.square[i] == self.square[i + 1] && straight
    }

    /// Limits the speeds to those of a motion that begins with an acceleration along the path and comes to rest at the end, and whose
    /// acceleration changes with no more than a share of the permitted jerk.
    pub(crate) fn go_gently(&mut self, acceleration: f64, bound: &MoveLimits) {
        let tuning = &TUNING.speed_profile;
        let jerk = tuning.gentle_jerk_share * bound.least_jerk();
        let rate = bound
            .acceleration
            .min(bound.deceleration)
            .min(bound.axes.acceleration.min());
        let rate = tuning.gentle_rate_share * rate;
        let most = self.square.iter().copied().fold(0.0, f64::max).sqrt();
        let limits = Limits {
            speed: most,
            acceleration: rate,
            deceleration: rate,
            jerk: Some(Jerk {
                acceleration: jerk,
                deceleration: jerk,
            }),
        };
        let begin = |velocity: f64, acceleration: f64| {
            let state = KinematicState {
                position: 0.0,
                velocity,
                acceleration,
            };
            Profile::to_velocity(state, most, &limits)
        };
        let count = self.square.len();
        let first = self.square[0].sqrt();
        let least = tuning.gentle_least_share * first;
        bound_by(&begin(first, acceleration), least, &self.length, &mut self.square[1..]);
        // With time reversed, the end is a beginning from rest.
        self.length.reverse();
        self.square.reverse();
        bound_by(&begin(0.0, 0.0), 0.0, &self.length, &mut self.square[1..count - 1]);
        self.length.reverse();
        self.square.reverse();
        self.set_times();
    }

    fn set_times(&mut self) {
        for i in 0..self.length.len() {
            let both = self.square[i].sqrt() + self.square[i + 1].sqrt();
            self.times[i + 1] = self.times[i] + 2.0 * self.length[i] / both;
        }
    }
}

/// The rounded reference path as points.
pub(crate) fn sample(reference: &ReferencePath, stretches: &[Stretch]) -> Vec<Sample> {
    let mut samples: Vec<Sample> = Vec::new();
    let whole = reference.length();
    for (index, stretch) in stretches.iter().enumerate() {
        let span = stretch.to - stretch.from;
        let [line, arc] = [&TUNING.rounding.line_samples, &TUNING.rounding.arc_samples];
        let count = match &stretch.shape {
            StretchShape::Bezier(..) if stretch.turn() > TUNING.smooth.sharp => TUNING.rounding.samples,
            StretchShape::Bezier(..) => TUNING.rounding.gentle_samples,
            StretchShape::Piece(piece) => match &reference.pieces[*piece] {
                Path::Line(_) => (line[0] * span / whole).clamp(line[1], line[2]) as usize,
                Path::Arc(path) => (span / path.radius() * arc[0]).clamp(arc[1], arc[2]) as usize,
            },
        };
        for k in usize::from(!samples.is_empty())..=count {
            let u = k as f64 / count as f64;
            let point = stretch.at(reference, u);
            if samples
                .last()
                .is_some_and(|last| (last.point - point).norm() <= SAME_SAMPLE_UNITS)
            {
                continue;
            }
            samples.push(Sample {
                stretch: index,
                u,
                point,
                progress: stretch.from + span * u,
            });
        }
    }
    samples
}

/// Bounds of the speed from curvature and its change, lowered to the rates along the path, from a speed (its square) at the first sample to
/// rest. `bounds[i]` belongs to piece `i` of the reference path.
pub(crate) fn speeds(
    reference: &ReferencePath,
    samples: &[Sample],
    bounds: &[MoveLimits],
    smoothness: Smoothness,
    start: f64,
) -> SampledSpeeds {
    let count = samples.len();
    let steps = samples.windows(2).map(|pair| pair[1].point - pair[0].point);
    let length: Vec<f64> = steps.clone().map(|d| d.norm()).collect();
    let tangent: Vec<Point> = steps.zip(&length).map(|(d, length)| d / *length).collect();
    let mut curvature = vec![Point::zeros(); count];
    for i in 1..count - 1 {
        curvature[i] = (tangent[i] - tangent[i - 1]) * 2.0 / (length[i] + length[i - 1]);
    }
    let mut square = vec![f64::INFINITY; count];
    let mut rate = vec![0.0; count - 1];
    for i in 0..count - 1 {
        let piece = reference.piece_at(0.5 * (samples[i].progress + samples[i + 1].progress));
        let step = Step {
            tangent: tangent[i],
            curvature: [curvature[i], curvature[i + 1]],
            length: length[i],
        };
        let most = step.most_square(&bounds[piece], smoothness);
        rate[i] = step.rate(&bounds[piece]);
        square[i] = square[i].min(most);
        square[i + 1] = square[i + 1].min(most);
    }
    (square[0], square[count - 1]) = (start, 0.0);
    pass(&mut square, &rate, &length, start);
    let mut speeds = SampledSpeeds {
        square,
        times: vec![0.0; count],
        length,
        rate,
        curvature,
    };
    speeds.set_times();
    speeds
}

/// Limits the squares of speeds after some lengths to those of a motion, or of a least speed.
fn bound_by(motion: &Profile, least: f64, lengths: &[f64], squares: &mut [f64]) {
    let (mut distance, mut time) = (0.0, 0.0);
    for (length, square) in lengths.iter().zip(squares) {
        distance += length;
        while time < motion.duration() && motion.at(time).position < distance {
            time += TUNING.speed_profile.gentle_step_s;
        }
        if time >= motion.duration() {
            return;
        }
        *square = square.min(motion.at(time).velocity.max(least).powi(2));
    }
}

/// The step from one sample to the next.
struct Step {
    tangent: Point,
    curvature: [Point; 2],
    length: f64,
}

impl Step {
    /// The square of the speed that curvature and its change permit.
    fn most_square(&self, bound: &MoveLimits, smoothness: Smoothness) -> f64 {
        let share = TUNING.speed_profile.normal_share;
        let mut most = bound.speed * bound.speed;
        for axis in 0..3 {
            most = most.min((bound.axes.speed[axis] / self.tangent[axis].abs()).powi(2));
        }
        let [here, next] = self.curvature;
        let turning = here.sup(&next.abs()).sup(&here.abs());
        for axis in 0..3 {
            most = most.min(share * bound.axes.acceleration[axis] / turning[axis]);
        }
        most = most.min(share * bound.norm_acceleration() / turning.norm());
        if smoothness == Smoothness::SCurve {
            let change = (next - here) / self.length;
            let mut cubed = TUNING.speed_profile.jerk_share * bound.jerk / change.norm();
            if let Some(jerk) = bound.axes.jerk {
                for axis in 0..3 {
                    cubed = cubed.min(TUNING.speed_profile.jerk_share * jerk[axis] / change[axis].abs());
                }
            }
            most = most.min(libm::cbrt(cubed).powi(2));
        }
        most
    }

    /// The acceleration along the path.
    fn rate(&self, bound: &MoveLimits) -> f64 {
        let mut rate = bound.acceleration.min(bound.deceleration);
        for axis in 0..3 {
            rate = f64::min(rate, bound.axes.acceleration[axis] / self.tangent[axis].abs());
        }
        rate
    }
}

/// Passes backwards and forwards: no square of a speed differs from the next by more than the rate permits.
fn pass(square: &mut [f64], rate: &[f64], length: &[f64], start: f64) {
    let share = TUNING.speed_profile.tangent_share;
    let count = square.len();
    for i in (0..count - 1).rev() {
        square[i] = square[i].min(square[i + 1] + 2.0 * share * rate[i] * length[i]);
    }
    for i in 0..count - 1 {
        square[i + 1] = square[i + 1].min(square[i] + 2.0 * share * rate[i] * length[i]);
    }
    // A start that is too fast for the path ahead brakes at the full rate.
    if square[0] < start {
        square[0] = start;
        for i in 0..count - 2 {
            square[i + 1] = square[i + 1].max(square[i] - 2.0 * rate[i] * length[i]);
        }
    }
}
