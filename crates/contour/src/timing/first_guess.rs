//! The first control points of a motion from rest to rest: the rounded reference path, evenly in the time of its speed profile. Seconds and
//! position units.

use crate::Point;
use crate::limits::{MoveLimits, Smoothness};
use crate::path::allowance::Allowance;
use crate::path::reference::ReferencePath;
use crate::path::rounding::Stretch;
use crate::timing::control_points::ControlPoints;
use crate::timing::grid::{Density, grid, sites};
use crate::timing::speed_profile::{Sample, SampledSpeeds, sample, speeds};
use crate::timing::warp::Warp;
use crate::tuning::TUNING;

/// `bounds[i]` belongs to piece `i` of the reference path.
pub(crate) fn first_guess(
    reference: &ReferencePath,
    allowance: &Allowance,
    stretches: &[Stretch],
    bounds: &[MoveLimits],
    smoothness: Smoothness,
) -> ControlPoints {
    let samples = sample(reference, stretches);
    let count = samples.len();
    let profile = speeds(reference, &samples, bounds, smoothness, 0.0);
    let total = profile.times[count - 1];
    let share = TUNING.speed_profile.tangent_share;
    let warp = Warp::new(
        total,
        profile.rate[0] * share,
        profile.rate[count - 2] * share,
        bounds,
        smoothness,
    );
    let warped = |time: f64| warp.warped(time);
    let busy: Vec<(f64, f64)> = (0..count - 1)
        .filter(|&i| !profile.is_cruise(i))
        .map(|i| (warped(profile.times[i]), warped(profile.times[i + 1])))
        .collect();
    let fine = allowance.roundings(reference, |s| warped(time_at(&samples, &profile, s)));
    let pieces = bounds.len();
    let grid = grid(
        warp.stretched(total),
        &Density {
            busy,
            fine,
            pieces,
            spacing: allowance.spacing(),
        },
    );
    let mut control = ControlPoints::from_rest(&grid);
    let mut on_arc = Vec::with_capacity(grid.len());
    let mut i = 0;
    for at in sites(&grid) {
        let time = warp.nominal(at);
        while i + 2 < count && profile.times[i + 1] < time {
            i += 1;
        }
        let part = part_gone(&profile, i, time);
        let (here, next) = (&samples[i], &samples[i + 1]);
        let begin = if here.stretch == next.stretch { here.u } else { 0.0 };
        let u = begin + (next.u - begin) * part;
        control.points.push(stretches[next.stretch].at(reference, u));
        on_arc.push(stretches[next.stretch].is_arc(reference));
        control
            .progress
            .push(here.progress + (next.progress - here.progress) * part);
    }
    pass_through(&mut control.points, &grid, &on_arc);
    let last = grid.len() - 1;
    control.points[0] = reference.pieces[0].start();
    control.points[last] = reference.pieces[reference.pieces.len() - 1].end();
    control.progress[last] = reference.length();
    control
}

/// The instants at which the speed profile passes the ends of the pieces.
pub(crate) fn pass_times(
    reference: &ReferencePath,
    stretches: &[Stretch],
    bounds: &[MoveLimits],
    smoothness: Smoothness,
) -> Vec<f64> {
    let samples = sample(reference, stretches);
    let profile = speeds(reference, &samples, bounds, smoothness, 0.0);
    let ends = reference.starts.iter().skip(1);
    ends.map(|&s| time_at(&samples, &profile, s)).collect()
}

/// The time at which the profile passes an arc length of the reference path.
fn time_at(samples: &[Sample], profile: &SampledSpeeds, s: f64) -> f64 {
    let k = samples
        .partition_point(|sample| sample.progress < s)
        .clamp(1, samples.len() - 1);
    let (before, behind) = (samples[k - 1].progress, samples[k].progress);
    let times = &profile.times;
    times[k - 1] + (times[k] - times[k - 1]) * ((s - before) / (behind - before)).clamp(0.0, 1.0)
}

/// The share of the distance from sample `i` to the next that is covered at a time.
fn part_gone(profile: &SampledSpeeds, i: usize, time: f64) -> f64 {
    let (v0, v1) = (profile.square[i].sqrt(), profile.square[i + 1].sqrt());
    let (dt, t) = (profile.times[i + 1] - profile.times[i], time - profile.times[i]);
    ((v0 + (v1 - v0) / dt * t / 2.0) * t / profile.length[i]).clamp(0.0, 1.0)
}

/// Moves the control points of arcs outwards, such that the curve passes through their earlier positions on the arc.
fn pass_through(points: &mut [Point], grid: &[f64], on_arc: &[bool]) {
    let times: Vec<f64> = sites(grid).collect();
    let through: Vec<Point> = (0..points.len())
        .map(|i| {
            let inner = i > 1 && i + 2 < points.len() && on_arc[i - 1..=i + 1].iter().all(|&on| on);
            if !inner {
                return points[i];
            }
            let (before, behind) = (times[i] - times[i - 1], times[i + 1] - times[i]);
            let rates = [
                (points[i] - points[i - 1]) / before,
                (points[i + 1] - points[i]) / behind,
            ];
            let change = (rates[1] - rates[0]) * 2.0 / (before + behind);
            let [a, b, c] = [-1, 0, 1].map(|k| grid[i.wrapping_add_signed(k)] - times[i]);
            points[i] + change * ((a * b + b * c + c * a) / 6.0)
        })
        .collect();
    points.copy_from_slice(&through);
}
