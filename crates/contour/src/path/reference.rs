//! The programmed reference path: the pieces as commanded, in sequence, by arc length.
//!
//! It determines the distance of a point from the reference path, and rounds no corner. Lengths in position units.

use arcline_geometry::{Arc, Path};

use crate::Point;
use crate::tuning::TUNING;

/// The programmed pieces of one section, none of them of zero length.
#[derive(Clone, Debug)]
pub(crate) struct ReferencePath {
    pub(crate) pieces: Vec<Path>,
    /// Arc length of the reference path at the start of each piece, and its whole length as last element.
    pub(crate) starts: Vec<f64>,
    /// The point in the middle of each piece, and half of its length: no point of the piece is farther from the middle.
    middles: Vec<(Point, f64)>,
}

impl ReferencePath {
    pub(crate) fn new(pieces: Vec<Path>) -> ReferencePath {
        let mut starts = Vec::with_capacity(pieces.len() + 1);
        let mut sum = 0.0;
        starts.push(sum);
        for piece in &pieces {
            sum += piece.length();
            starts.push(sum);
        }
        let middle = |piece: &Path| {
            let half = 0.5 * piece.length();
            (piece.at(half).position, half)
        };
        ReferencePath {
            middles: pieces.iter().map(middle).collect(),
            pieces,
            starts,
        }
    }

    pub(crate) fn length(&self) -> f64 {
        *self.starts.last().unwrap_or(&0.0)
    }

    /// The piece at arc length `s` of the reference path; a joint belongs to the piece behind it.
    pub(crate) fn piece_at(&self, s: f64) -> usize {
        let behind = self.starts.partition_point(|&start| start <= s);
        behind.saturating_sub(1).min(self.pieces.len().saturating_sub(1))
    }

    /// The nearest point of the reference path that a descent from piece `hint` finds, with its piece. Its distance is never less than the true
    /// one.
    pub(crate) fn foot(&self, q: &Point, hint: usize) -> (Point, usize) {
        let last = self.pieces.len() - 1;
        let mut at = hint.min(last);
        let mut foot = nearest(&self.pieces[at], q);
        let mut least = (foot - q).norm_squared();
        loop {
            let centre = at;
            let distance = least.sqrt();
            for other in
                centre.saturating_sub(TUNING.corridor.foot_pieces)..=(centre + TUNING.corridor.foot_pieces).min(last)
            {
                if other == centre || self.is_farther(other, q, distance) {
                    continue;
                }
                let candidate = nearest(&self.pieces[other], q);
                let square = (candidate - q).norm_squared();
                if square < least {
                    (foot, least, at) = (candidate, square, other);
                }
            }
            if at == centre {
                return (foot, at);
            }
        }
    }

    /// All points of a piece are farther from `q` than this distance, as its middle shows.
    fn is_farther(&self, piece: usize, q: &Point, distance: f64) -> bool {
        let (middle, half) = self.middles[piece];
        let most = half + distance;
        (q - middle).norm_squared() > most * most
    }
}

/// The point of one piece that is nearest to `q`.
pub(crate) fn nearest(piece: &Path, q: &Point) -> Point {
    match piece {
        Path::Line(line) => {
            let along = (q - line.start()).dot(&line.direction());
            line.start() + line.direction() * along.clamp(0.0, line.length())
        }
        Path::Arc(arc) => nearest_on_arc(arc, q),
    }
}

/// The arc length of the point of a piece that is nearest to `q`.
pub(crate) fn along(piece: &Path, q: &Point) -> f64 {
    match piece {
        Path::Line(line) => (q - line.start()).dot(&line.direction()).clamp(0.0, line.length()),
        Path::Arc(arc) => {
            let angle = angle_of(arc, q);
            if angle <= arc.sweep() {
                arc.length() * angle / arc.sweep()
            } else if (q - arc.start()).norm_squared() <= (q - arc.end()).norm_squared() {
                0.0
            } else {
                arc.length()
            }
        }
    }
}

/// The angle about the centre of an arc from its start, 0 to 2 pi.
fn angle_of(arc: &Arc, q: &Point) -> f64 {
    let [x, y] = in_plane(arc, q);
    let angle = libm::atan2(y, x);
    if angle < 0.0 {
        angle + core::f64::consts::TAU
    } else {
        angle
    }
}

/// A point in the plane of an arc, from its centre along its axes.
fn in_plane(arc: &Arc, q: &Point) -> [f64; 2] {
    let from_center = q - arc.center();
    arc.axes().map(|axis| from_center.dot(&axis))
}

fn nearest_on_arc(arc: &Arc, q: &Point) -> Point {
    let [e1, e2] = arc.axes();
    let [x, y] = in_plane(arc, q);
    let unit = if arc.radius() == arc.end_radius() {
        // A true circle needs no angles: the point is before its end in the sense of the motion.
        let [end_x, end_y] = in_plane(arc, &arc.end());
        let (is_behind_start, is_before_end) = (y >= 0.0, x * end_y >= y * end_x);
        let is_within = if arc.sweep() > core::f64::consts::PI {
            is_behind_start || is_before_end
        } else {
            is_behind_start && is_before_end
        };
        let radius = (x * x + y * y).sqrt();
        (is_within && radius > 0.0).then(|| (arc.radius(), [x / radius, y / radius]))
    } else {
        let angle = angle_of(arc, q);
        let radius = arc.radius() + (arc.end_radius() - arc.radius()) * angle / arc.sweep();
        let (sin, cos) = libm::sincos(angle);
        (angle <= arc.sweep()).then_some((radius, [cos, sin]))
    };
    if let Some((radius, [cos, sin])) = unit {
        return arc.center() + (e1 * cos + e2 * sin) * radius;
    }
    if (q - arc.start()).norm_squared() <= (q - arc.end()).norm_squared() {
        arc.start()
    } else {
        arc.end()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use arcline_geometry::{CirclePoint, Dimension, Direction};
    use proptest::prelude::*;

    /// Points of an arc that the test measures.
    const SAMPLES: u32 = 2000;

    proptest! {
        /// On circles and spirals, from points on either side and in the middle.
        #[test]
        fn the_nearest_point_of_an_arc_is_no_farther_than_any_sample(
            to in 0.05..6.2_f64,
            direction in 0..4_i32,
            spiral in prop_oneof![Just(1.0), 0.9..1.1_f64],
            q in [-12.0..12.0_f64, -12.0..12.0_f64, -3.0..3.0_f64],
        ) {
            const RADIUS: f64 = 5.0;
            let center = CirclePoint::Center(Point::zeros());
            let start = Point::new(RADIUS, 0.0, 0.0);
            let end = Point::new(libm::cos(to), libm::sin(to), 0.0) * RADIUS * spiral;
            let direction = Direction::from_word(direction).expect("four directions");
            let arc = Arc::new(Dimension::Two, start, end, center, direction).expect("an arc");
            let q = Point::from(q);
            let path = Path::Arc(arc);
            let found = (nearest(&path, &q) - q).norm();
            let at = |k: u32| path.at(arc.length() * f64::from(k) / f64::from(SAMPLES)).position;
            let sampled = (0..=SAMPLES).map(|k| (at(k) - q).norm()).fold(f64::INFINITY, f64::min);
            // The nearest point of a spiral is that at the same angle, which is a little farther.
            let is_spiral = arc.radius() != arc.end_radius();
            prop_assert!(found <= sampled + if is_spiral { 0.5 } else { 1e-9 }, "{found} > {sampled}");
            prop_assert!(found >= sampled - 0.02, "{found} < {sampled}: not on the arc");
        }
    }
}
