//! Machines, moves and measures that all tests of contours share. Position units and seconds.

use arcline_contour::{
    AxisLimits, ContourMove, Deviation, ExtensionRequest, Path, Peaks, Point, Trajectory, extend, plan,
};
use arcline_geometry::{Arc, CirclePoint, Dimension, Direction};
use proptest::prelude::*;

pub(crate) const SPEED: f64 = 200.0;
/// Seconds of the trajectory's own time for a plan.
pub(crate) const LEAD: f64 = 0.05;

/// The profile of the moves; an S-curve has a jerk limit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Profile {
    Trapezoid,
    SCurve,
}

pub(crate) const PROFILES: [Profile; 2] = [Profile::Trapezoid, Profile::SCurve];

pub(crate) fn profile() -> impl Strategy<Value = Profile> {
    any::<bool>().prop_map(|jerk| PROFILES[usize::from(jerk)])
}

impl Profile {
    pub(crate) fn limits(self) -> AxisLimits {
        AxisLimits {
            speed: Point::new(300.0, 150.0, 200.0),
            acceleration: Point::new(5000.0, 3000.0, 4000.0),
            jerk: (self == Profile::SCurve).then(|| Point::new(100_000.0, 60_000.0, 80_000.0)),
        }
    }

    pub(crate) fn contour_move(self, path: Path, tolerance: f64) -> ContourMove {
        ContourMove {
            path,
            speed: SPEED,
            acceleration: 4000.0,
            deceleration: 3500.0,
            jerk: (self == Profile::SCurve).then_some(90_000.0),
            tolerance,
            deviation: Deviation::Corners,
        }
    }
}

/// An arc through a point, if there is one.
pub(crate) fn arc_through(from: Point, via: Point, to: Point) -> Option<Path> {
    let direction = Direction::from_word(0).expect("0 is a direction");
    let arc = Arc::new(Dimension::Three, from, to, CirclePoint::Via(via), direction);
    arc.ok().map(Path::Arc)
}

/// The point in the direction of a heading in the plane.
pub(crate) fn ahead(from: Point, heading: f64, length: f64) -> Point {
    from + Point::new(libm::cos(heading), libm::sin(heading), 0.0) * length
}

/// Distance of a point from a path, and how far along the path the nearest point is.
pub(crate) fn distance(path: &Path, q: &Point) -> (f64, f64) {
    let length = path.length();
    if let Path::Line(_) = path {
        let start = path.at(0.0).position;
        let along = path.at(length).position - start;
        let s = if length > 0.0 {
            along.dot(&(q - start)) / length
        } else {
            0.0
        };
        let s = s.clamp(0.0, length);
        return ((path.at(s).position - q).norm(), s);
    }
    let at = |s: f64| (path.at(s).position - q).norm();
    let step = length / 60.0;
    let middle = |k: i32| at(step * (f64::from(k) + 0.5));
    let best = (0..60).min_by(|&a, &b| middle(a).total_cmp(&middle(b))).unwrap_or(0);
    let mut low = (step * f64::from(best - 1)).max(0.0);
    let mut high = (step * f64::from(best + 2)).min(length);
    for _ in 0..60 {
        let (a, b) = (low + (high - low) / 3.0, high - (high - low) / 3.0);
        if at(a) < at(b) {
            high = b;
        } else {
            low = a;
        }
    }
    let s = 0.5 * (low + high);
    (at(s).min(at(0.0)).min(at(length)), s)
}

/// Distance of a point from the nearest of some paths.
pub(crate) fn off(moves: &[ContourMove], q: &Point) -> f64 {
    moves.iter().fold(f64::INFINITY, |least, one| {
        // No point of a path is further from its middle than half of its length.
        let middle = one.path.at(0.5 * one.path.length()).position;
        let nearest = (middle - q).norm() - 0.5 * one.path.length();
        if nearest >= least {
            least
        } else {
            least.min(distance(&one.path, q).0)
        }
    })
}

/// The extreme values of the axes are within their limits.
pub(crate) fn check_peaks(peaks: &Peaks, limits: &AxisLimits) -> Result<(), TestCaseError> {
    let most = |limit: f64| limit * (1.0 + 1e-9);
    for axis in 0..3 {
        prop_assert!(peaks.velocity[axis] <= most(limits.speed[axis]), "{peaks:?}");
        prop_assert!(peaks.acceleration[axis] <= most(limits.acceleration[axis]), "{peaks:?}");
        if let Some(jerk) = limits.jerk {
            prop_assert!(peaks.jerk[axis] <= most(jerk[axis]), "{peaks:?}");
        }
    }
    Ok(())
}

/// The time of all moves with a stop behind each.
pub(crate) fn with_stops(moves: &[ContourMove], limits: &AxisLimits) -> f64 {
    moves.chunks(1).map(|one| plan(one, limits).duration()).sum()
}

/// The arrival of moves.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Windows {
    /// Number of moves that arrive at a time.
    pub(crate) moves: usize,
    /// Seconds before the end of the planned moves at which they arrive.
    pub(crate) ahead: f64,
}

/// The result of a motion whose moves arrive in windows.
pub(crate) struct Travelled {
    pub(crate) duration: f64,
    /// Windows that could not be joined: a stop each.
    pub(crate) stops: usize,
}

/// An extension: the running trajectory, when it was asked for, and the longer one with the number of moves that were known.
pub(crate) struct Extended<'a> {
    pub(crate) running: &'a Trajectory,
    pub(crate) now: f64,
    pub(crate) longer: &'a Trajectory,
    /// Moves of which the running trajectory had planned the first.
    pub(crate) known: usize,
    pub(crate) planned: usize,
}

/// Travels moves that become known in windows. `check` sees each stretch of a trajectory that is travelled, `joined` each extension.
pub(crate) fn travel(
    moves: &[ContourMove],
    windows: Windows,
    limits: &AxisLimits,
    check: impl Fn(&Trajectory, f64, f64) -> Result<(), TestCaseError>,
    joined: impl Fn(&Extended<'_>) -> Result<(), TestCaseError>,
) -> Result<Travelled, TestCaseError> {
    let mut known = windows.moves.min(moves.len());
    let mut running = plan(&moves[..known], limits);
    let (mut passed, mut now, mut before, mut stops) = (0, 0.0, 0.0, 0);
    loop {
        let ask = if known < moves.len() {
            (running.duration() - windows.ahead).max(now)
        } else {
            running.duration()
        };
        check(&running, now, ask)?;
        now = ask;
        if known == moves.len() {
            let duration = before + now;
            return Ok(Travelled { duration, stops });
        }
        let on_it = running.move_at(now);
        passed += on_it;
        let next = (known + windows.moves).min(moves.len());
        let request = ExtensionRequest {
            running: &running,
            passed: on_it,
            moves: &moves[passed..next],
            limits,
            now,
            earliest: now + LEAD,
        };
        if let Some(longer) = extend(&request) {
            joined(&Extended {
                running: &running,
                now,
                longer: &longer,
                known: next - passed,
                planned: known - passed,
            })?;
            known = passed + longer.moves();
            running = longer;
        } else {
            stops += 1;
            check(&running, now, running.duration())?;
            before += running.duration();
            running = plan(&moves[known..next], limits);
            (passed, now) = (known, 0.0);
            known = next;
        }
    }
}
