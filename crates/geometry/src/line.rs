//! Straight lines.

use crate::{PathPoint, Point};

/// A straight line by arc length; it may have zero length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Line {
    start: Point,
    end: Point,
    direction: Point,
    length: f64,
}

impl Line {
    /// The line between two points. Equal points give a line of length 0, whose tangent is the
    /// zero vector.
    #[must_use]
    pub fn new(start: Point, end: Point) -> Line {
        let difference = end - start;
        let length = norm(difference);
        let direction = if length > 0.0 {
            difference / length
        } else {
            Point::zeros()
        };
        Line {
            start,
            end,
            direction,
            length,
        }
    }

    /// A line that stays at a point for a length.
    pub(crate) fn stationary(at: Point, length: f64) -> Line {
        Line {
            start: at,
            end: at,
            direction: Point::zeros(),
            length: length.max(0.0),
        }
    }

    pub(crate) fn shifted(self, by: &Point) -> Line {
        Line {
            start: self.start + by,
            end: self.end + by,
            ..self
        }
    }

    /// Length in position units.
    #[must_use]
    pub fn length(&self) -> f64 {
        self.length
    }

    /// First point.
    #[must_use]
    pub fn start(&self) -> Point {
        self.start
    }

    /// Last point.
    #[must_use]
    pub fn end(&self) -> Point {
        self.end
    }

    /// Unit vector from start to end; zero for a line of length 0.
    #[must_use]
    pub fn direction(&self) -> Point {
        self.direction
    }

    /// The point at arc length `s`: `start` at 0 and `end` at `length` bit for bit, extended
    /// straight outside. Real-time safe, constant time.
    #[must_use]
    pub fn at(&self, s: f64) -> PathPoint {
        PathPoint {
            position: self.position(s),
            tangent: self.direction,
            curvature: Point::zeros(),
            curvature_change: Point::zeros(),
        }
    }

    /// As [`Line::at`], the position only.
    #[must_use]
    pub fn position(&self, s: f64) -> Point {
        // From the nearer end, so that both ends are exact and the error is that of the nearer one.
        if s <= 0.5 * self.length {
            self.start + self.direction * s
        } else {
            self.end + self.direction * (s - self.length)
        }
    }
}

/// Euclidean length that neither overflows nor underflows for components of any finite size.
pub(crate) fn norm(v: Point) -> f64 {
    let largest = v.amax();
    if largest == 0.0 || !largest.is_finite() {
        return largest;
    }
    if (1e-140..1e140).contains(&largest) {
        return (v.x * v.x + v.y * v.y + v.z * v.z).sqrt();
    }
    let u = v / largest;
    largest * (u.x * u.x + u.y * u.y + u.z * u.z).sqrt()
}
