//! A warm start of a continuation from two motions within their limits: the running one, and one over the same moves that begins at rest some
//! moves earlier. Away from their beginnings and ends both are nearly the same, the fastest motion, so the warm start changes from one to the
//! other where they are most alike. Position units and seconds.

use crate::extend::warm_start::{RoutePoint, Running, followed, knots};
use crate::section::{Section, Solved};
use crate::timing::control_points::{ControlPoints, blossom};
use crate::tuning::TUNING;
use crate::{AxesState, AxisLimits};

/// Control points of the whole motion from the splice on: the running one up to the point at which `fresh` is most like it, then
/// `fresh`. That is a plan of the moves of the section, and of some before them with the total length `before`. `None`: the two are
/// alike nowhere.
pub(crate) fn warm_start_joined(
    section: &Section<'_>,
    running: Running<'_>,
    limits: &AxisLimits,
    fresh: &Solved,
    before: f64,
) -> Option<ControlPoints> {
    let tolerance = section.allowance.least();
    let unlike = |a: &AxesState, b: &AxesState| {
        let mut sum = (a.position - b.position).norm() / tolerance;
        for axis in 0..3 {
            let rate = limits.acceleration[axis];
            sum += (a.velocity[axis] - b.velocity[axis]).abs() / (rate * TUNING.joined.soon_s);
            sum += (a.acceleration[axis] - b.acceleration[axis]).abs() / rate;
        }
        sum
    };
    let progress: Vec<f64> = fresh.control.progress.iter().map(|s| s - before).collect();
    let mut best: Option<(f64, f64, f64)> = None;
    for RoutePoint { time, progress: s, .. } in followed(section, running) {
        let k = progress.partition_point(|&other| other < s);
        let (Some(from), Some(to)) = (k.checked_sub(1), progress.get(k)) else {
            continue;
        };
        if time < TUNING.joined.least_followed_s {
            continue;
        }
        let part = ((s - progress[from]) / (to - progress[from])).clamp(0.0, 1.0);
        let about = fresh.times[from] + (fresh.times[k] - fresh.times[from]) * part;
        let here = running.trajectory.at(running.splice + time);
        for shift in -TUNING.joined.shifts..=TUNING.joined.shifts {
            let other = about + f64::from(shift) * TUNING.joined.shift_s;
            let off = unlike(&here, &fresh.trajectory.at(other));
            if best.is_none_or(|(least, ..)| off < least) {
                best = Some((off, time, other));
            }
        }
    }
    let (off, time, other) = best?;
    if off > TUNING.joined.most_unlike {
        return None;
    }
    Some(joined(section, running, fresh, &progress, (time, other)))
}

/// The running motion until `time` after the splice, then the other one from its own time on.
fn joined(
    section: &Section<'_>,
    running: Running<'_>,
    fresh: &Solved,
    progress: &[f64],
    (time, other): (f64, f64),
) -> ControlPoints {
    let until = Running {
        leave: running.splice + time,
        ..running
    };
    let mut grid = knots(section, until);
    let followed_knots = grid.len();
    let end = grid[followed_knots - 1];
    let first = fresh
        .times
        .partition_point(|&t| t <= other + TUNING.joined.least_span_s);
    grid.extend(fresh.times[first..].iter().map(|t| t - other + end));
    let sites = followed(section, until);
    let state = |k: usize| {
        if k < followed_knots {
            running.trajectory.at(running.splice + grid[k])
        } else {
            fresh.trajectory.at(fresh.times[first + k - followed_knots])
        }
    };
    let mut control = ControlPoints::continuing(running.trajectory.at(running.splice), &grid, followed_knots);
    let mut least = 0.0_f64;
    for (k, at) in grid.iter().enumerate() {
        let along = if k < followed_knots {
            let i = sites.partition_point(|point| point.time < *at).min(sites.len() - 1);
            sites[i].progress
        } else {
            progress[first + k - followed_knots]
        };
        least = least.max(along);
        control.progress.push(least);
        let own = first + k.saturating_sub(followed_knots);
        control.points.push(if k > followed_knots {
            fresh.control.points[own]
        } else {
            let before = grid[k.max(1)] - grid[k.max(1) - 1];
            let behind = grid.get(k + 1).map_or(0.0, |next| next - at);
            blossom(&state(k), [-before, 0.0, behind])
        });
    }
    control.completed(&section.reference)
}
