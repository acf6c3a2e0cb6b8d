//! Programmed paths as polylines, and how far their moves have come.

use arcline_controller::image::Image;
use arcline_controller::{Path, Point, SystemSnapshot};

use super::protocol::{ActiveMove, Circle, Paths, PendingMove};
use crate::plant::{LiveMove, LiveMoves};

/// The paths of a coordinate system of `axes` axes: of the active move, of pending ones, and where they blend.
pub(super) fn of(moves: &LiveMoves, system: usize, axes: usize) -> Paths {
    let all = || moves.of(system).take(DRAWN);
    let polyline = |live: &LiveMove| points(&live.accepted.path, axes);
    let active = all().find(|live| live.is_active()).map(polyline);
    let pending = all().filter(|live| !live.is_active()).map(polyline).collect();
    let blends = all().filter(|live| live.accepted.tolerance > 0.0 && live.accepted.tolerance.is_finite());
    let tolerance = blends
        .map(|live| circle(&live.accepted.path.end(), live.accepted.tolerance, axes))
        .collect();
    Paths {
        active: active.unwrap_or_default(),
        pending,
        tolerance,
    }
}

/// The active move, with its way along the path.
pub(super) fn active(moves: &LiveMoves, system: usize, image: &Image, now: &SystemSnapshot) -> Option<ActiveMove> {
    let live = moves.of(system).find(|live| live.is_active())?;
    let remaining = (now.path_length - now.path_position).max(0.0);
    let progress = if now.path_length > 0.0 {
        (now.path_position / now.path_length).clamp(0.0, 1.0)
    } else {
        1.0
    };
    Some(ActiveMove {
        tag: image.control_name(live.accepted.control).to_owned(),
        instruction: live.accepted.mnemonic.name(),
        progress,
        remaining,
        eta_s: now.time_left,
    })
}

/// The moves that wait.
pub(super) fn pending(moves: &LiveMoves, system: usize, image: &Image) -> Vec<PendingMove> {
    let waiting = moves.of(system).filter(|live| !live.is_active());
    let waiting = waiting.map(|live| PendingMove {
        tag: image.control_name(live.accepted.control).to_owned(),
        instruction: live.accepted.mnemonic.name(),
    });
    waiting.take(DRAWN).collect()
}

/// A path as points, as many coordinates each as there are axes.
fn points(path: &Path, axes: usize) -> Vec<Vec<f64>> {
    let steps = match path {
        Path::Line(_) => 1,
        Path::Arc(arc) => ((arc.sweep().abs() / STEP).ceil() as u32).clamp(2, STEPS),
    };
    let length = path.length();
    let point = |step: u32| {
        if step == steps {
            path.end()
        } else {
            path.at(length * f64::from(step) / f64::from(steps)).position
        }
    };
    (0..=steps).map(|step| coordinates(&point(step), axes)).collect()
}

/// A circle of a tolerance.
pub(super) fn circle(centre: &Point, radius: f64, axes: usize) -> Circle {
    Circle {
        centre: coordinates(centre, axes),
        radius,
    }
}

fn coordinates(point: &Point, axes: usize) -> Vec<f64> {
    point.iter().take(axes).copied().collect()
}

/// Moves that are drawn of a queue.
const DRAWN: usize = 200;
/// Angle between two points of an arc, radians, and how many steps there are at most.
const STEP: f64 = 0.05;
const STEPS: u32 = 256;
