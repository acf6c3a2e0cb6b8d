//! The check that a stop along the curve keeps every limit: sampled piece by piece of the trajectory and segment by segment of the stop, at the ends
//! and in the middle of short steps. Position units, seconds. Nothing allocates.

use arcline_contour::{AxesState as Axes, Piece};
use arcline_geometry::Point;

use super::{Guard, Hidden, Permitted, RampSegment, Rate, STEP_S, sums};
use crate::contour::ramp::{Along, CurveStop};
use crate::tolerance::{PACE_SHARE, ROUNDING_SHARE};

/// A piece of a trajectory during a stop along the curve.
struct CurvePiece {
    piece: Piece,
    /// Length of the curve from the beginning of the stop to that of the piece.
    begin: f64,
}

/// An instant of a stop along the curve.
struct CurveState {
    own: f64,
    axes: Axes,
    rate: Rate,
    sums: [Point; 2],
}

impl CurveState {
    /// About its own time some seconds later.
    fn after(&self, seconds: f64) -> f64 {
        let Rate { pace, first, second } = self.rate;
        self.own + (pace + (first / 2.0 + second * (seconds / 6.0)) * seconds) * seconds
    }
}

impl Guard<'_> {
    /// A stop along the curve from `since` on.
    pub(super) fn allows_stop(&self, stop: &CurveStop, since: f64, left: &mut usize) -> bool {
        let CurveStop { along, from } = stop;
        let times = along.segment_times();
        let step = STEP_S.max((along.duration() - since) / STOP_STEPS);
        let mut own = self.trajectory.time_at_length(from + along.at(since).position);
        let mut piece_index = self.trajectory.piece_at(own);
        for (time_index, &begin) in times.iter().enumerate() {
            let begin = begin.max(since);
            let end = times.get(time_index + 1).copied().unwrap_or(along.duration());
            if end <= begin {
                continue;
            }
            let segment = RampSegment::new(along, begin, end - begin);
            let mut at = begin;
            loop {
                let Some(piece) = self.trajectory.piece(piece_index) else {
                    return false;
                };
                let behind = self.trajectory.arc_length(piece.until);
                let leaves = along.time_at_position(behind - from).filter(|&leaves| leaves < end);
                let until = leaves.unwrap_or(end).max(at);
                let curve = CurvePiece {
                    piece,
                    begin: behind - piece.length(piece.until) - from,
                };
                let steps = ((until - at) / step).ceil().max(1.0);
                let half = 0.5 * (until - at) / steps;
                let mut first = self.curve_state(&curve, &segment, at - begin, own);
                for k in 0..steps as usize {
                    let Some(less) = left.checked_sub(STOP_WORK) else {
                        *left = 0;
                        return false;
                    };
                    *left = less;
                    let after = |state: &CurveState, halves: usize| {
                        self.curve_state(&curve, &segment, at - begin + half * halves as f64, state.after(half))
                    };
                    let middle = first.as_ref().and_then(|first| after(first, 2 * k + 1));
                    let last = middle.as_ref().and_then(|middle| after(middle, 2 * k + 2));
                    let (Some(a), Some(b), Some(c)) = (&first, &middle, &last) else {
                        return false;
                    };
                    if !self.allows_step(&piece.jerk(), [a, b, c]) {
                        return false;
                    }
                    own = c.own;
                    first = last;
                }
                at = until;
                if leaves.is_none() {
                    break;
                }
                own = piece.until;
                piece_index += 1;
            }
        }
        true
    }

    /// The state of a stop along the curve; `near`: about its own time. `None`: the pace is not within its bounds, or the speed too low for it.
    fn curve_state(&self, curve: &CurvePiece, segment: &RampSegment, at: f64, near: f64) -> Option<CurveState> {
        let CurvePiece { piece, begin } = curve;
        let (length, along) = segment.at(at);
        let mut own = near.min(piece.until);
        for _ in 0..2 {
            let speed = piece.at(own).velocity.norm();
            if speed < self.least_speed {
                return None;
            }
            own -= (begin + piece.length(own) - length) / speed;
        }
        let axes = piece.at(own);
        let own_jerk = piece.jerk();
        let rate = Along::of(&axes).rate(&axes, &own_jerk, [along.pace, along.first, along.second]);
        let inside = (-PACE_SHARE..=1.0 + ROUNDING_SHARE).contains(&rate.pace);
        inside.then(|| CurveState {
            own,
            axes,
            rate,
            sums: sums(&axes, &own_jerk, &rate),
        })
    }

    /// A step of a stop along the curve, within a piece: its ends and its middle.
    fn allows_step(&self, own_jerk: &Point, states: [&CurveState; 3]) -> bool {
        // A parabola through three values exceeds them by at most an eighth of their second difference; four times that.
        let bend = |of: usize| {
            let [first, middle, last] = states.map(|state| state.sums[of]);
            (first - middle * 2.0 + last) * 0.5
        };
        let (acceleration, jerk) = (bend(0), bend(1));
        let hidden = Hidden {
            acceleration: acceleration.abs(),
            vector_acceleration: acceleration.norm(),
            jerk: jerk.abs(),
            vector_jerk: jerk.norm(),
        };
        states.iter().all(|CurveState { own, axes, sums, .. }| {
            let rates = self.trajectory.rates(self.trajectory.move_at(*own));
            rates.is_none_or(|rates| {
                let extra = self.extra.at(*own);
                self.allows_state(axes, own_jerk, &Permitted { rates, extra }, sums, &hidden)
            })
        })
    }
}

/// The work of a step of a stop along the curve, in samples.
const STOP_WORK: usize = 3;
/// The number of steps of a stop along the curve that takes longer than as many times [`STEP_S`].
const STOP_STEPS: f64 = 250.0;
