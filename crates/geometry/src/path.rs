//! A path of either kind, and its properties at one of its points.

use crate::{Arc, Line, Point};

/// A geometric path by arc length `s`, `0 <= s <= length`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Path {
    /// A straight line.
    Line(Line),
    /// A circular arc or a full circle.
    Arc(Arc),
}

/// A point of a path and the derivatives there; `q(s)` is the position at arc length `s`.
///
/// With the speed `v`, acceleration `a` and jerk `j` along the path, the axes have (spec/motion-core.md §1)
/// velocity `tangent * v`, acceleration `tangent * a + curvature * v^2` and jerk
/// `tangent * j + 3 * curvature * v * a + curvature_change * v^3`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathPoint {
    /// `q`, position units.
    pub position: Point,
    /// `dq/ds`, a unit vector (zero only on a path of length 0, and on a path that stays at a point).
    pub tangent: Point,
    /// `d2q/ds2`, 1 / position unit; points to the centre of curvature.
    pub curvature: Point,
    /// `d3q/ds3`, 1 / position unit squared.
    pub curvature_change: Point,
}

impl Path {
    /// The straight line between two points.
    #[must_use]
    pub fn line(from: Point, to: Point) -> Path {
        Path::Line(Line::new(from, to))
    }

    /// A path that stays at a point for a length: the path of a rotation alone, whose length has its own unit.
    #[must_use]
    pub fn stationary(at: Point, length: f64) -> Path {
        Path::Line(Line::stationary(at, length))
    }

    /// The path stays at a point for a length.
    #[must_use]
    pub fn stands(&self) -> bool {
        matches!(self, Path::Line(line) if line.length() > 0.0 && line.direction() == Point::zeros())
    }

    /// The path with every point moved by `by`.
    ///
    /// ```
    /// use arcline_geometry::{Path, Point};
    ///
    /// let path = Path::line(Point::zeros(), Point::new(3.0, 4.0, 0.0)).shifted(&Point::new(10.0, 0.0, 0.0));
    /// assert_eq!((path.length(), path.end()), (5.0, Point::new(13.0, 4.0, 0.0)));
    /// ```
    #[must_use]
    pub fn shifted(self, by: &Point) -> Path {
        match self {
            Path::Line(line) => Path::Line(line.shifted(by)),
            Path::Arc(arc) => Path::Arc(arc.shifted(by)),
        }
    }

    /// Arc length in position units.
    #[must_use]
    pub fn length(&self) -> f64 {
        match self {
            Path::Line(line) => line.length(),
            Path::Arc(arc) => arc.length(),
        }
    }

    /// First point.
    #[must_use]
    pub fn start(&self) -> Point {
        match self {
            Path::Line(line) => line.start(),
            Path::Arc(arc) => arc.start(),
        }
    }

    /// Last point; the first one for a full circle.
    #[must_use]
    pub fn end(&self) -> Point {
        match self {
            Path::Line(line) => line.end(),
            Path::Arc(arc) => arc.end(),
        }
    }

    /// The point at arc length `s`. `s = 0` gives [`Path::start`] and `s = length` gives
    /// [`Path::end`] bit for bit; outside, a line is extended straight and an arc along its curve.
    /// Real-time safe, bounded time.
    #[must_use]
    pub fn at(&self, s: f64) -> PathPoint {
        match self {
            Path::Line(line) => line.at(s),
            Path::Arc(arc) => arc.at(s),
        }
    }

    /// Unit tangent at the start of the path.
    #[must_use]
    pub fn start_tangent(&self) -> Point {
        self.at(0.0).tangent
    }

    /// Unit tangent at the end of the path.
    #[must_use]
    pub fn end_tangent(&self) -> Point {
        self.at(self.length()).tangent
    }
}
