//! The nodes of the next run: at equal times of the last run's curve. Position units and seconds.

use crate::limits::Smoothness;
use crate::path::reference::{ReferencePath, along};
use crate::timing::control_points::{ControlPoints, blossom};
use crate::timing::grid::{Density, Spacing, continued_grid, grid, sites};
use crate::timing::warp::Warp;
use crate::tuning::TUNING;
use crate::{MoveLimits, Point, Trajectory};

/// The same curve with nodes at equal intervals of its time, warped at its ends for an S-curve.
pub(crate) fn resample(
    trajectory: &Trajectory,
    times: &[f64],
    control: &ControlPoints,
    bounds: &[MoveLimits],
    (fine, spacing): (&[(f64, f64)], Spacing),
    smoothness: Smoothness,
) -> ControlPoints {
    let rate =
        |bound: Option<&MoveLimits>| bound.map_or(f64::INFINITY, |b| b.axes.acceleration.min().min(b.acceleration));
    let warp = Warp::new(
        trajectory.duration(),
        // A continuation does not begin at rest.
        if control.initial.is_some() {
            0.0
        } else {
            rate(bounds.first())
        },
        rate(bounds.last()),
        bounds,
        smoothness,
    );
    let whole = warp.stretched(trajectory.duration());
    let mut busy: Vec<(f64, f64)> = Vec::new();
    for pair in trajectory.knots.windows(2) {
        let (here, next) = (&pair[0], &pair[1]);
        let most = here.state.acceleration.norm().max(next.state.acceleration.norm());
        if most > TUNING.grid.idle_share * rate(bounds.first()).min(rate(bounds.last())) {
            busy.push((warp.warped(here.time), warp.warped(next.time)));
        }
    }
    let fine: Vec<(f64, f64)> = fine
        .iter()
        .map(|&(from, to)| (warp.warped(from), warp.warped(to)))
        .collect();
    let pieces = bounds.len();
    let density = Density {
        busy,
        fine,
        pieces,
        spacing,
    };
    if control.initial.is_some() {
        return resample_continued(trajectory, times, control, &density, &warp);
    }
    let grid = grid(whole, &density);
    let intervals = grid.len() - 1;
    let mut points = Vec::with_capacity(intervals + 1);
    let mut progress = Vec::with_capacity(intervals + 1);
    let mut i = 0;
    for at in sites(&grid) {
        let time = warp.nominal(at);
        points.push(trajectory.at(time).position);
        while i + 2 < times.len() && times[i + 1] < time {
            i += 1;
        }
        let part = ((time - times[i]) / (times[i + 1] - times[i])).clamp(0.0, 1.0);
        progress.push(control.progress[i] + (control.progress[i + 1] - control.progress[i]) * part);
    }
    points[0] = control.points[0];
    points[intervals] = trajectory.end;
    // Control points whose curve passes through the points (to the fourth order).
    let through: Vec<Point> = points
        .windows(3)
        .map(|p| p[1] - (p[2] - p[1] * 2.0 + p[0]) / 6.0)
        .collect();
    if let Some(inner) = points.get_mut(3..intervals.saturating_sub(2)) {
        inner.copy_from_slice(&through[2..intervals - 3]);
    }
    ControlPoints {
        points,
        progress,
        ..ControlPoints::from_rest(&grid)
    }
}

/// The same for a continuation: its first nodes stay.
fn resample_continued(
    trajectory: &Trajectory,
    times: &[f64],
    control: &ControlPoints,
    density: &Density,
    warp: &Warp,
) -> ControlPoints {
    let kept_nodes = control.kept_nodes;
    let mut fresh = control.clone();
    fresh.held_nodes = kept_nodes;
    let whole = warp.stretched(trajectory.duration());
    let grid = continued_grid(times[..=kept_nodes].to_vec(), whole, density);
    fresh.spans = grid.windows(2).map(|pair| pair[1] - pair[0]).collect();
    fresh.points.truncate(kept_nodes);
    fresh.progress.truncate(kept_nodes);
    let mut i = 0;
    for k in kept_nodes..grid.len() {
        let time = warp.nominal(grid[k]);
        let before = time - warp.nominal(grid[k - 1]);
        let behind = grid.get(k + 1).map_or(whole, |&next| warp.nominal(next)) - time;
        fresh.points.push(blossom(&trajectory.at(time), [-before, 0.0, behind]));
        while i + 2 < times.len() && times[i + 1] < time {
            i += 1;
        }
        let part = ((time - times[i]) / (times[i + 1] - times[i])).clamp(0.0, 1.0);
        let (here, next) = (control.progress[i], control.progress[i + 1]);
        fresh.progress.push(here + (next - here) * part);
    }
    if let (Some(point), Some(progress)) = (fresh.points.last_mut(), fresh.progress.last_mut()) {
        *point = trajectory.end;
        *progress = control.progress[control.progress.len() - 1];
    }
    fresh
}

/// Sets the progress of every node to that of the nearest point of the reference path, ascending.
pub(crate) fn project(reference: &ReferencePath, control: &mut ControlPoints) {
    let mut least = 0.0;
    for (point, progress) in control.points.iter().zip(&mut control.progress) {
        let (_, piece) = reference.foot(point, reference.piece_at(*progress));
        let along = reference.starts[piece] + along(&reference.pieces[piece], point);
        least = f64::max(least, along);
        *progress = least;
    }
    let whole = reference.length();
    for progress in &mut control.progress {
        *progress = progress.min(whole);
    }
    if let Some(last) = control.progress.last_mut() {
        *last = whole;
    }
}
