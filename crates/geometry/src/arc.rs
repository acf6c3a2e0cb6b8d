//! Circular arcs and full circles in the plane and in space, as MCCM describes them
//! (spec/coordinated-instructions.md §13, spec/motion-core.md §9).
//!
//! Not here: the faceplate's move and circle types (the caller makes all points absolute) and the
//! limits of speed along the arc. Lengths in position units, angles in radians.

use core::f64::consts::{PI, TAU};

use crate::line::norm;
use crate::tolerance::{
    CIRCULAR_RATIO, COLLINEAR_SINE, HALF_CIRCLE_SHARE, LARGEST_MISMATCH_SHARE, NEWTON_STEP_SHARE, SAME_POINT_UNITS,
    SAME_RADIUS_SHARE, SMALLEST_RADIUS_UNITS,
};
use crate::{PathPoint, Point};

/// Number of primary axes of the coordinate system, whether the coordinates change or not.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Dimension {
    /// Two primary axes; the third coordinate of every point is 0.
    Two,
    /// Three primary axes.
    Three,
}

/// The second point of the circle, absolute (spec/coordinated-instructions.md §13.1).
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum CirclePoint {
    /// A point between start and end.
    Via(Point),
    /// The centre.
    Center(Point),
    /// Signed radius: positive for the arc up to half a circle, negative for the other one.
    Radius(f64),
}

/// Operand Direction. In two dimensions the words are clockwise and counter-clockwise, in three
/// shortest and longest (spec/coordinated-instructions.md §13.2, §13.3).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Direction {
    /// 0: clockwise (2D), shortest (3D).
    Clockwise,
    /// 1: counter-clockwise (2D), longest (3D).
    CounterClockwise,
    /// 2: full circle clockwise (2D), in the sense of the shortest arc (3D).
    ClockwiseFull,
    /// 3: full circle counter-clockwise (2D), in the sense of the longest arc (3D).
    CounterClockwiseFull,
}

impl Direction {
    /// Shortest arc (3D).
    pub const SHORTEST: Direction = Direction::Clockwise;
    /// Longest arc (3D).
    pub const LONGEST: Direction = Direction::CounterClockwise;
    /// Full circle in the sense of the shortest arc (3D).
    pub const SHORTEST_FULL: Direction = Direction::ClockwiseFull;
    /// Full circle in the sense of the longest arc (3D).
    pub const LONGEST_FULL: Direction = Direction::CounterClockwiseFull;

    /// The direction for the operand's value; `None` outside 0 to 3.
    #[must_use]
    pub const fn from_word(word: i32) -> Option<Direction> {
        match word {
            0 => Some(Direction::Clockwise),
            1 => Some(Direction::CounterClockwise),
            2 => Some(Direction::ClockwiseFull),
            3 => Some(Direction::CounterClockwiseFull),
            _ => None,
        }
    }

    /// The path is a full circle.
    #[must_use]
    pub const fn is_full(self) -> bool {
        matches!(self, Direction::ClockwiseFull | Direction::CounterClockwiseFull)
    }

    const fn is_counter_clockwise(self) -> bool {
        matches!(self, Direction::CounterClockwise | Direction::CounterClockwiseFull)
    }
}

/// The reason why points do not form an arc (spec/coordinated-instructions.md §13.4; the number is ERR).
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum ArcError {
    /// ERR 25: a radius does not define a circle in space.
    #[error("circle type Radius needs two primary axes, the coordinate system has three")]
    RadiusIn3d,
    /// ERR 44: start, end and the third point lie on one line.
    #[error("start, end and the third point of the circle are collinear")]
    Collinear,
    /// ERR 45: start and end are the same point.
    #[error("start and end of the arc are the same point")]
    StartEnd,
    /// ERR 46: start and end have distances from the centre that differ by more than 15 %.
    #[error("start is {start} from the centre, end {end}, expected at most 15 % difference")]
    RadiusMismatch {
        /// Distance of the start from the centre.
        start: f64,
        /// Distance of the end from the centre.
        end: f64,
    },
    /// ERR 49: the radius is below 0.001 or too short to span the points.
    #[error("the radius is {radius}, expected {least} or more")]
    SmallRadius {
        /// The radius, without its sign.
        radius: f64,
        /// The least possible radius.
        least: f64,
    },
}

impl ArcError {
    /// The error code of a motion control tag (ERR).
    #[must_use]
    pub const fn err(self) -> i16 {
        match self {
            ArcError::RadiusIn3d => 25,
            ArcError::Collinear => 44,
            ArcError::StartEnd => 45,
            ArcError::RadiusMismatch { .. } => 46,
            ArcError::SmallRadius { .. } => 49,
        }
    }
}

/// A circular arc or a full circle by arc length.
///
/// If start and end have different distances from the centre (within 15 %), the radius changes
/// linearly with the angle: an Archimedean spiral that starts and ends exactly
/// (spec/motion-core.md §9.5).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Arc {
    start: Point,
    end: Point,
    center: Point,
    /// Unit vector from the centre to the start.
    e1: Point,
    /// Unit vector across, in the sense of the motion.
    e2: Point,
    /// Radius at the start.
    radius: f64,
    /// Change of the radius by angle, 0 for a true circle.
    slope: f64,
    sweep: f64,
    length: f64,
}

impl Arc {
    /// The arc from `start` to `end`, or a full circle through both that ends in `start`.
    ///
    /// All points are finite and absolute. With `Dimension::Two` the third coordinates are 0.
    ///
    /// # Errors
    /// Those of spec/coordinated-instructions.md §13.4, in its order, except that the check for equal start and end (45)
    /// precedes that for collinear points (44), which would always apply.
    pub fn new(
        dimension: Dimension,
        start: Point,
        end: Point,
        circle: CirclePoint,
        direction: Direction,
    ) -> Result<Arc, ArcError> {
        match (circle, dimension) {
            (CirclePoint::Via(via), _) => Arc::by_via(start, end, via, direction),
            (CirclePoint::Center(center), Dimension::Two) => Arc::by_center_2d(start, end, center, direction),
            (CirclePoint::Center(center), Dimension::Three) => Arc::by_center_3d(start, end, center, direction),
            (CirclePoint::Radius(radius), Dimension::Two) => Arc::by_radius(start, end, radius, direction),
            (CirclePoint::Radius(_), Dimension::Three) => Err(ArcError::RadiusIn3d),
        }
    }

    /// spec/motion-core.md §9.3.
    fn by_via(start: Point, end: Point, via: Point, direction: Direction) -> Result<Arc, ArcError> {
        let (a, b) = (via - start, end - start);
        if norm(b) <= SAME_POINT_UNITS {
            return Err(ArcError::StartEnd);
        }
        if norm(a) <= SAME_POINT_UNITS || norm(end - via) <= SAME_POINT_UNITS || collinear(a, b) {
            return Err(ArcError::Collinear);
        }
        let n = a.cross(&b);
        let to_center = (n.cross(&a) * b.norm_squared() + b.cross(&n) * a.norm_squared()) / (2.0 * n.norm_squared());
        Ok(Arc::circle(
            start,
            end,
            start + to_center,
            -to_center,
            n,
            direction.is_full(),
        ))
    }

    /// spec/motion-core.md §9.2, in the plane.
    fn by_center_2d(start: Point, end: Point, center: Point, direction: Direction) -> Result<Arc, ArcError> {
        let (r1, r2) = radii(start, end, center)?;
        let n = turn_axis(direction);
        if direction.is_full() || norm(end - start) <= SAME_POINT_UNITS {
            return Ok(Arc::circle(start, start, center, start - center, n, true));
        }
        Ok(Arc::spiral(start, end, center, n, r1, r2))
    }

    /// spec/motion-core.md §9.2, in space.
    fn by_center_3d(start: Point, end: Point, center: Point, direction: Direction) -> Result<Arc, ArcError> {
        if norm(end - start) <= SAME_POINT_UNITS {
            return Err(ArcError::StartEnd);
        }
        if collinear(center - start, end - start) {
            return Err(ArcError::Collinear);
        }
        let (r1, r2) = radii(start, end, center)?;
        let shortest = (start - center).cross(&(end - center));
        let n = if direction.is_counter_clockwise() {
            -shortest
        } else {
            shortest
        };
        if direction.is_full() {
            return Ok(Arc::circle(start, start, center, start - center, n, true));
        }
        Ok(Arc::spiral(start, end, center, n, r1, r2))
    }

    /// spec/motion-core.md §9.4.
    fn by_radius(start: Point, end: Point, signed: f64, direction: Direction) -> Result<Arc, ArcError> {
        let chord = end - start;
        let length = norm(chord);
        if length <= SAME_POINT_UNITS {
            return Err(ArcError::StartEnd);
        }
        let radius = signed.abs();
        let half = 0.5 * length;
        let least = SMALLEST_RADIUS_UNITS.max(half * (1.0 - HALF_CIRCLE_SHARE));
        if radius < least {
            return Err(ArcError::SmallRadius {
                radius,
                least: SMALLEST_RADIUS_UNITS.max(half),
            });
        }
        // Factored: no cancellation near the half circle.
        let height = ((radius - half).max(0.0) * (radius + half)).sqrt();
        let left = Point::new(-chord.y, chord.x, 0.0) / length;
        let side = if direction.is_counter_clockwise() == (signed > 0.0) {
            height
        } else {
            -height
        };
        let to_center = chord * 0.5 + left * side;
        Ok(Arc::circle(
            start,
            end,
            start + to_center,
            -to_center,
            turn_axis(direction),
            direction.is_full(),
        ))
    }

    /// A true circle about `center`; `x0` is the start seen from the centre, `n` any vector along the axis.
    fn circle(start: Point, end: Point, center: Point, x0: Point, n: Point, full: bool) -> Arc {
        let radius = norm(x0);
        let e1 = x0 / radius;
        let e2 = n.cross(&e1);
        let e2 = e2 / norm(e2);
        let (sweep, end) = if full {
            (TAU, start)
        } else {
            // Relative to the start: the centre may be far away and the arc short.
            (sweep_angle(x0, x0 + (end - start), e1, e2), end)
        };
        Arc {
            start,
            end,
            center,
            e1,
            e2,
            radius,
            slope: 0.0,
            sweep,
            length: radius * sweep,
        }
    }

    fn spiral(start: Point, end: Point, center: Point, n: Point, r1: f64, r2: f64) -> Arc {
        let mut arc = Arc::circle(start, end, center, start - center, n, false);
        if (r2 - r1).abs() > SAME_RADIUS_SHARE * r1 {
            arc.slope = (r2 - r1) / arc.sweep;
            arc.length = arc.length_between(0.0, arc.sweep);
        }
        arc
    }

    pub(crate) fn shifted(self, by: &Point) -> Arc {
        Arc {
            start: self.start + by,
            end: self.end + by,
            center: self.center + by,
            ..self
        }
    }

    /// True arc length in position units. For differing radii this is the length of the spiral, along which the move keeps its
    /// programmed speed; it differs from the `sweep * (R1 + R2) / 2` of spec/coordinated-instructions.md §13.4.
    #[must_use]
    pub fn length(&self) -> f64 {
        self.length
    }

    /// First point.
    #[must_use]
    pub fn start(&self) -> Point {
        self.start
    }

    /// Last point; the first one for a full circle.
    #[must_use]
    pub fn end(&self) -> Point {
        self.end
    }

    /// Centre.
    #[must_use]
    pub fn center(&self) -> Point {
        self.center
    }

    /// Radius at the start.
    #[must_use]
    pub fn radius(&self) -> f64 {
        self.radius
    }

    /// Radius at the end; differs from [`Arc::radius`] only on a spiral.
    #[must_use]
    pub fn end_radius(&self) -> f64 {
        self.radius + self.slope * self.sweep
    }

    /// Swept angle, radians, above 0.
    #[must_use]
    pub fn sweep(&self) -> f64 {
        self.sweep
    }

    /// Unit vector along the axis; the motion rotates about it by the right-hand rule.
    #[must_use]
    pub fn normal(&self) -> Point {
        self.e1.cross(&self.e2)
    }

    /// Unit vectors in the plane of the arc: from the centre to the start, and across in the sense of the motion.
    #[must_use]
    pub fn axes(&self) -> [Point; 2] {
        [self.e1, self.e2]
    }

    /// The point at arc length `s`: `start` at 0 and `end` at `length` bit for bit, along the same
    /// curve outside. Real-time safe: a true circle takes one sine and cosine, a spiral at most
    /// `NEWTON_STEPS` steps more.
    #[must_use]
    pub fn at(&self, s: f64) -> PathPoint {
        let mut point = if self.slope == 0.0 {
            self.at_on_circle(s)
        } else {
            self.at_on_spiral(s)
        };
        if s == 0.0 {
            point.position = self.start;
        } else if s == self.length {
            point.position = self.end;
        }
        point
    }

    fn at_on_circle(&self, s: f64) -> PathPoint {
        let (sin, cos) = libm::sincos(0.5 * s / self.radius);
        // Twice the half angle. The position is relative to the start: no loss of digits to a distant centre.
        let (sine, versine) = (2.0 * sin * cos, 2.0 * sin * sin);
        let outwards = self.e1 * (1.0 - versine) + self.e2 * sine;
        let tangent = self.e2 * (1.0 - versine) - self.e1 * sine;
        PathPoint {
            position: self.start + (self.e2 * sine - self.e1 * versine) * self.radius,
            tangent,
            curvature: outwards / -self.radius,
            curvature_change: tangent / -(self.radius * self.radius),
        }
    }

    fn at_on_spiral(&self, s: f64) -> PathPoint {
        let angle = self.angle_at(s);
        let (b, r) = (self.slope, self.radius + self.slope * angle);
        let (sin, cos) = libm::sincos(0.5 * angle);
        let (sine, versine) = (2.0 * sin * cos, 2.0 * sin * sin);
        let outwards = self.e1 * (1.0 - versine) + self.e2 * sine;
        let across = self.e2 * (1.0 - versine) - self.e1 * sine;
        // Derivatives by angle, then by arc length: m = ds/dangle and its derivatives.
        let m = (r * r + b * b).sqrt();
        let m1 = r * b / m;
        let m2 = (b * b - m1 * m1) / m;
        let d1 = outwards * b + across * r;
        let d2 = across * (2.0 * b) - outwards * r;
        let d3 = outwards * (-3.0 * b) - across * r;
        let (m_2, m_3) = (m * m, m * m * m);
        PathPoint {
            position: self.start + (self.e2 * sine - self.e1 * versine) * self.radius + outwards * (b * angle),
            tangent: d1 / m,
            curvature: d2 / m_2 - d1 * (m1 / m_3),
            curvature_change: d3 / m_3 - d2 * (3.0 * m1 / (m_2 * m_2)) + d1 * ((3.0 * m1 * m1 / m - m2) / (m_2 * m_2)),
        }
    }

    /// The angle of a spiral at the arc length `s`.
    fn angle_at(&self, s: f64) -> f64 {
        let (b, r1) = (self.slope, self.radius);
        // Exact for ds = r dangle; Newton's method adds the radial part.
        let root = r1 * r1 + 2.0 * b * s;
        let first = if root > 0.0 {
            2.0 * s / (r1 + root.sqrt())
        } else {
            self.sweep * s / self.length
        };
        if b.abs() < CIRCULAR_RATIO * r1 {
            return first;
        }
        let mut angle = first;
        for _ in 0..NEWTON_STEPS {
            let r = r1 + b * angle;
            let step = (self.length_between(0.0, angle) - s) / (r * r + b * b).sqrt();
            angle -= step;
            if step.abs() <= NEWTON_STEP_SHARE * angle.abs() {
                break;
            }
        }
        angle
    }

    /// Arc length between two angles of a spiral: the integral of sqrt(r^2 + b^2).
    fn length_between(&self, from: f64, to: f64) -> f64 {
        let (b, r1) = (self.slope, self.radius);
        if b.abs() < CIRCULAR_RATIO * r1 {
            return (to - from) * (r1 + 0.5 * b * (from + to));
        }
        let half = 0.5 * (to - from);
        if (b * half).abs() <= 0.1 * r1 {
            // Gauss-Legendre in place of the closed form, which loses all digits as b goes to 0.
            // The integrand's singularities r = ±ib stay ten half-intervals away, so eight points
            // are exact to rounding for any b.
            let middle = r1 + 0.5 * b * (from + to);
            let mut sum = 0.0;
            for (node, weight) in GAUSS {
                let (low, high) = (middle - b * half * node, middle + b * half * node);
                sum += weight * ((low * low + b * b).sqrt() + (high * high + b * b).sqrt());
            }
            return half * sum;
        }
        let primitive = |angle: f64| {
            let r = r1 + b * angle;
            0.5 * (r * (r * r + b * b).sqrt() / b + b * libm::asinh(r / b.abs()))
        };
        primitive(to) - primitive(from)
    }
}

/// Distances of start and end from the centre, checked.
fn radii(start: Point, end: Point, center: Point) -> Result<(f64, f64), ArcError> {
    let (r1, r2) = (norm(start - center), norm(end - center));
    if (r1 - r2).abs() > LARGEST_MISMATCH_SHARE * r1 {
        return Err(ArcError::RadiusMismatch { start: r1, end: r2 });
    }
    if r1 < SMALLEST_RADIUS_UNITS {
        return Err(ArcError::SmallRadius {
            radius: r1,
            least: SMALLEST_RADIUS_UNITS,
        });
    }
    Ok((r1, r2))
}

/// Angle from `x0` to `x1` in the sense of `e1` towards `e2`, above 0 and at most 2 pi.
fn sweep_angle(x0: Point, x1: Point, e1: Point, e2: Point) -> f64 {
    // The components across and along; the difference keeps the digits of short arcs.
    let angle = libm::atan2((x1 - x0).dot(&e2), x1.dot(&e1));
    if angle > 0.0 { angle } else { angle + 2.0 * PI }
}

fn collinear(a: Point, b: Point) -> bool {
    norm(a.cross(&b)) <= COLLINEAR_SINE * norm(a) * norm(b)
}

/// The axis of turning in the plane.
fn turn_axis(direction: Direction) -> Point {
    Point::new(0.0, 0.0, if direction.is_counter_clockwise() { 1.0 } else { -1.0 })
}

/// Newton steps from arc length to angle; two or three suffice inside the arc.
const NEWTON_STEPS: usize = 8;
/// Gauss-Legendre nodes and weights, eight points on -1..1.
const GAUSS: [(f64, f64); 4] = [
    (0.183_434_642_495_649_8, 0.362_683_783_378_362),
    (0.525_532_409_916_329, 0.313_706_645_877_887_3),
    (0.796_666_477_413_626_7, 0.222_381_034_453_374_5),
    (0.960_289_856_497_536_3, 0.101_228_536_290_376_26),
];
