//! A single straight line from rest to rest: closed form (`arcline-profile`), nothing to optimise.

use crate::trajectory::{AxesState, Knot};
use crate::{MoveLimits, Point, Trajectory};
use arcline_geometry::Line;
use arcline_profile::{Jerk, KinematicState as Along, Limits, Profile};

/// The motion along a line of more than zero length.
pub(crate) fn straight(line: &Line, bounds: &MoveLimits) -> Trajectory {
    let direction = line.direction();
    let least = |vector: f64, axes: Point| {
        (0..3).fold(vector, |least, axis| {
            f64::min(least, axes[axis] / direction[axis].abs())
        })
    };
    let jerk = bounds.axes.jerk.map_or(bounds.jerk, |axes| least(bounds.jerk, axes));
    let limits = Limits {
        speed: least(bounds.speed, bounds.axes.speed),
        acceleration: least(bounds.acceleration, bounds.axes.acceleration),
        deceleration: least(bounds.deceleration, bounds.axes.acceleration),
        jerk: jerk.is_finite().then_some(Jerk {
            acceleration: jerk,
            deceleration: jerk,
        }),
    };
    let profile = Profile::to_position(Along::default(), line.length(), 0.0, &limits);
    let mut starts = profile.segment_times().to_vec();
    starts.retain(|&t| t < profile.duration());
    let mut knots = Vec::with_capacity(starts.len() + 1);
    for (index, &time) in starts.iter().enumerate() {
        let next = starts.get(index + 1).copied().unwrap_or(profile.duration());
        let half = 0.5 * (next - time);
        let (here, middle) = (profile.at(time), profile.at(time + half));
        // The jerk of the segment and, as the acceleration may jump at its start, that from its middle.
        let jerk = (profile.at(time + 1.5 * half).acceleration - middle.acceleration) / (0.5 * half);
        let acceleration = middle.acceleration - jerk * half;
        knots.push(Knot {
            time,
            state: AxesState {
                position: line.position(here.position),
                velocity: direction * here.velocity,
                acceleration: direction * acceleration,
            },
            jerk: direction * jerk,
        });
    }
    knots.push(Knot {
        time: profile.duration(),
        state: AxesState::rest(line.end()),
        jerk: Point::zeros(),
    });
    Trajectory {
        end: line.end(),
        ..Trajectory::of(knots)
    }
}
