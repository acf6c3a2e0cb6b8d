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
        ReferencePath { pieces, starts }
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
            for other in
                centre.saturating_sub(TUNING.corridor.foot_pieces)..=(centre + TUNING.corridor.foot_pieces).min(last)
            {
                if other == centre {
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
    let e1 = (arc.start() - arc.center()) / arc.radius();
    let e2 = arc.normal().cross(&e1);
    let from_center = q - arc.center();
    let angle = libm::atan2(from_center.dot(&e2), from_center.dot(&e1));
    if angle < 0.0 {
        angle + core::f64::consts::TAU
    } else {
        angle
    }
}

fn nearest_on_arc(arc: &Arc, q: &Point) -> Point {
    let normal = arc.normal();
    let e1 = (arc.start() - arc.center()) / arc.radius();
    let e2 = normal.cross(&e1);
    let angle = angle_of(arc, q);
    if angle <= arc.sweep() {
        let radius = arc.radius() + (arc.end_radius() - arc.radius()) * angle / arc.sweep();
        let (sin, cos) = libm::sincos(angle);
        return arc.center() + (e1 * cos + e2 * sin) * radius;
    }
    if (q - arc.start()).norm_squared() <= (q - arc.end()).norm_squared() {
        arc.start()
    } else {
        arc.end()
    }
}
