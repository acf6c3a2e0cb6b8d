//! A first curve inside the corridor: the programmed pieces with every corner rounded separately.
//!
//! Two lines get a Bezier curve with all inner control points on the corner: at an even parameter it is the curve of one axis that brakes while
//! the other accelerates, with constant acceleration (degree 2, trapezoid) or constant jerk (degree 3, S-curve). All other corners get a
//! quintic that continues direction and curvature on both sides (spec/motion-core.md §6.4). The optimisation only starts from this curve.
//! Lengths in position units.

use crate::Point;
use crate::limits::Smoothness;
use crate::path::allowance::Allowance;
use crate::path::reach::reach_of_lines;
use crate::path::reference::{ReferencePath, nearest};
use crate::tolerance::SAME_DIRECTION_SINE;
use crate::tuning::TUNING;
use arcline_geometry::Path;

/// A stretch of the rounded curve, with the corresponding arc length of the reference path.
#[derive(Clone, Debug)]
pub(crate) struct Stretch {
    pub(crate) shape: StretchShape,
    pub(crate) from: f64,
    pub(crate) to: f64,
}

#[derive(Clone, Debug)]
pub(crate) enum StretchShape {
    /// Part of a piece of the reference path.
    Piece(usize),
    /// A Bezier curve of degree `len - 1`.
    Bezier([Point; 6], usize),
}

impl Stretch {
    /// The stretch is part of an arc of the reference path.
    pub(crate) fn is_arc(&self, reference: &ReferencePath) -> bool {
        matches!(self.shape, StretchShape::Piece(index) if matches!(reference.pieces[index], Path::Arc(_)))
    }

    /// The change of the direction (of a unit vector) in a rounding; 0 in a part of a piece.
    pub(crate) fn turn(&self) -> f64 {
        match &self.shape {
            StretchShape::Piece(_) => 0.0,
            StretchShape::Bezier(points, count) => {
                let leg = |from: usize| (points[from + 1] - points[from]).normalize();
                (leg(count - 2) - leg(0)).norm()
            }
        }
    }

    /// The point at a progress within it, and its first two derivatives by the progress.
    pub(crate) fn derivatives(&self, reference: &ReferencePath, progress: f64) -> [Point; 3] {
        match &self.shape {
            StretchShape::Piece(index) => {
                let path = &reference.pieces[*index];
                let at = path.at((progress - reference.starts[*index]).clamp(0.0, path.length()));
                [at.position, at.tangent, at.curvature]
            }
            StretchShape::Bezier(points, count) => {
                let span = self.to - self.from;
                let u = ((progress - self.from) / span).clamp(0.0, 1.0);
                let (mut work, mut left) = (*points, *count);
                let mut result = [Point::zeros(); 3];
                let mut factor = 1.0;
                for (order, derivative) in result.iter_mut().enumerate() {
                    *derivative = casteljau(work, left, u) * factor;
                    left -= 1;
                    for i in 0..left {
                        work[i] = work[i + 1] - work[i];
                    }
                    factor *= (*count - 1 - order) as f64 / span;
                }
                result
            }
        }
    }

    /// The point at `u`, `0 <= u <= 1`.
    pub(crate) fn at(&self, reference: &ReferencePath, u: f64) -> Point {
        match &self.shape {
            StretchShape::Piece(index) => {
                let local = self.from + (self.to - self.from) * u - reference.starts[*index];
                reference.pieces[*index]
                    .at(local.clamp(0.0, reference.pieces[*index].length()))
                    .position
            }
            StretchShape::Bezier(points, count) => casteljau(*points, *count, u),
        }
    }
}

/// The curve that rounds a corner of two lines.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Corners {
    /// The curve of superposed motions.
    Superposed(Smoothness),
    /// A curve whose second derivative by the progress is continuous, as that of the curves beside arcs: its progress can be even.
    Even,
}

/// The point of a Bezier curve at `u`, by de Casteljau's algorithm.
fn casteljau(mut points: [Point; 6], count: usize, u: f64) -> Point {
    for level in (1..count).rev() {
        for i in 0..level {
            points[i] += (points[i + 1] - points[i]) * u;
        }
    }
    points[0]
}

/// The reference path with every joint rounded.
pub(crate) fn round(reference: &ReferencePath, allowance: &Allowance, corners: Corners) -> Vec<Stretch> {
    let count = reference.pieces.len();
    let mut stretches = Vec::with_capacity(2 * count);
    let mut begin = 0.0;
    for index in 0..count {
        let (from, to) = (reference.starts[index], reference.starts[index + 1]);
        let corner = (index + 1 < count).then(|| {
            // Each end has half of a piece; the ends of the reference path have all of it.
            let before = if index == 0 { to - from } else { 0.5 * (to - from) };
            let behind = reference.starts[index + 2] - to;
            let behind = if index + 2 == count { behind } else { 0.5 * behind };
            let room = before
                .min(behind)
                .min(TUNING.rounding.inside_share * allowance.room(reference, index));
            corner(reference, index, allowance.corner(index), room, corners)
        });
        let (reach, shape) = corner.map_or((0.0, None), |(reach, shape)| (reach, Some(shape)));
        if to - reach > begin {
            stretches.push(Stretch {
                shape: StretchShape::Piece(index),
                from: begin,
                to: to - reach,
            });
        }
        begin = to + reach;
        if let Some(shape) = shape
            && reach > 0.0
        {
            stretches.push(Stretch {
                shape,
                from: to - reach,
                to: to + reach,
            });
        }
    }
    stretches
}

/// The length to either side of the rounding of the joint behind piece `index`, and its curve.
fn corner(reference: &ReferencePath, index: usize, tolerance: f64, room: f64, corners: Corners) -> (f64, StretchShape) {
    let (before, behind) = (&reference.pieces[index], &reference.pieces[index + 1]);
    let (u1, u2) = (before.end_tangent(), behind.start_tangent());
    let (sine, cosine) = (u1.cross(&u2).norm(), u1.dot(&u2));
    let limit = TUNING.rounding.inside_share * tolerance;
    let are_lines = matches!((before, behind), (Path::Line(_), Path::Line(_)));
    if are_lines && sine <= SAME_DIRECTION_SINE && cosine > 0.0 {
        return (0.0, StretchShape::Piece(index));
    }
    if let (true, Corners::Superposed(smoothness)) = (are_lines, corners) {
        let reach = reach_of_lines(before, behind, limit, smoothness).min(room);
        let (first, middle, last) = (before.end() - u1 * reach, before.end(), behind.start() + u2 * reach);
        let shape = match smoothness {
            Smoothness::Trapezoid => StretchShape::Bezier([first, middle, last, last, last, last], 3),
            Smoothness::SCurve => StretchShape::Bezier([first, middle, middle, last, last, last], 4),
        };
        return (reach, shape);
    }
    // Shortens the rounding until it is inside.
    let mut reach = room.min(most_of_arc(before, behind));
    if are_lines {
        reach = reach.min(reach_of_lines(before, behind, limit, Smoothness::SCurve));
    }
    for _ in 0..TUNING.rounding.shortenings {
        let shape = quintic(before, behind, reach);
        let stretch = Stretch {
            shape,
            from: 0.0,
            to: 0.0,
        };
        let off = (1..TUNING.rounding.measured)
            .map(|k| {
                let q = stretch.at(reference, f64::from(k) / f64::from(TUNING.rounding.measured));
                (nearest(before, &q) - q).norm().min((nearest(behind, &q) - q).norm())
            })
            .fold(0.0, f64::max);
        if off <= limit {
            return (reach, stretch.shape);
        }
        reach *= TUNING.rounding.shorten;
    }
    (0.0, StretchShape::Piece(index))
}

/// The largest length of a rounding along the shorter of two arcs.
fn most_of_arc(before: &Path, behind: &Path) -> f64 {
    [before, behind]
        .iter()
        .map(|path| match path {
            Path::Line(_) => f64::INFINITY,
            Path::Arc(arc) => TUNING.rounding.arc_share * arc.radius(),
        })
        .fold(f64::INFINITY, f64::min)
}

fn quintic(before: &Path, behind: &Path, reach: f64) -> StretchShape {
    let p = before.at(before.length() - reach);
    let q = behind.at(reach);
    let speed = 2.0 * reach;
    let (a, b) = (speed / 5.0, speed * speed / 20.0);
    StretchShape::Bezier(
        [
            p.position,
            p.position + p.tangent * a,
            p.position + p.tangent * (2.0 * a) + p.curvature * b,
            q.position - q.tangent * (2.0 * a) + q.curvature * b,
            q.position - q.tangent * a,
            q.position,
        ],
        6,
    )
}
