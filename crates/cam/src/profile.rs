//! A calculated profile and its evaluation.

use crate::SegmentType;

/// From a point of a profile to the next: `y = y0 + a1·u + a2·u² + a3·u³` with `u = x − x0`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CamSegment {
    /// Master position at its beginning.
    pub x: f64,
    /// The slave there: A0.
    pub y: f64,
    /// A1, A2 and A3; zeros at the last point.
    pub coefficients: [f64; 3],
    /// The type of its curve; ignored at the last point.
    pub kind: SegmentType,
}

/// The slave at a position of the master.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct Value {
    /// Position of the slave.
    pub y: f64,
    /// First derivative by the master's position.
    pub slope: f64,
    /// Second derivative by the master's position.
    pub curvature: f64,
    /// Segment at the master position, from 0.
    pub segment: usize,
}

/// A slave's position over a master's, from its first point to its last.
#[derive(Clone, Debug, PartialEq)]
pub struct Profile {
    /// One segment for each point; the last one is the end of the profile.
    segments: Vec<CamSegment>,
    /// See [`Profile::reach`].
    reach: f64,
}

impl Profile {
    /// A profile from stored segments; the last one ends it. `None`: fewer than two, master positions that do not increase, or a
    /// number that is not finite.
    pub fn from_segments(segments: Vec<CamSegment>) -> Option<Self> {
        let finite = segments.iter().all(|segment| {
            let [a1, a2, a3] = segment.coefficients;
            [segment.x, segment.y, a1, a2, a3].into_iter().all(f64::is_finite)
        });
        let rising = segments.windows(2).all(|pair| pair[0].x < pair[1].x);
        (segments.len() >= 2 && finite && rising).then(|| Profile {
            reach: reach(&segments),
            segments,
        })
    }

    /// The largest distance of the slave from its first point, in units of the profile.
    pub fn reach(&self) -> f64 {
        self.reach
    }

    /// The segments, and the last point.
    pub fn segments(&self) -> &[CamSegment] {
        &self.segments
    }

    /// Master and slave at the first point.
    pub fn start(&self) -> (f64, f64) {
        let first = &self.segments[0];
        (first.x, first.y)
    }

    /// Master and slave at the last point.
    pub fn end(&self) -> (f64, f64) {
        let last = &self.segments[self.segments.len() - 1];
        (last.x, last.y)
    }

    /// Displacement of the master over the whole profile, above 0.
    pub fn length(&self) -> f64 {
        self.end().0 - self.start().0
    }

    /// Displacement of the slave over the whole profile, with its sign.
    pub fn rise(&self) -> f64 {
        self.end().1 - self.start().1
    }

    /// The master position is within the profile, both ends included.
    pub fn contains(&self, x: f64) -> bool {
        (self.start().0..=self.end().0).contains(&x)
    }

    /// The slave at a position of the master. Beyond the ends it is at rest; at an end it has the derivatives just inside of it.
    ///
    /// Exact at the points. Real-time: bounded by the logarithm of the points.
    pub fn at(&self, x: f64) -> Value {
        let last = self.segments.len() - 1;
        let behind = self.segments.partition_point(|segment| segment.x <= x);
        let index = behind.saturating_sub(1).min(last - 1);
        let segment = &self.segments[index];
        let [a1, a2, a3] = segment.coefficients;
        let inside = x.clamp(segment.x, self.segments[index + 1].x);
        let u = inside - segment.x;
        // At the last point exactly its own position, without rounding.
        let y = if inside >= self.segments[last].x {
            self.segments[last].y
        } else {
            segment.y + u * (a1 + u * (a2 + u * a3))
        };
        let moves = self.contains(x);
        Value {
            y,
            slope: if moves { a1 + u * (2.0 * a2 + u * 3.0 * a3) } else { 0.0 },
            curvature: if moves { 2.0 * a2 + u * 6.0 * a3 } else { 0.0 },
            segment: index,
        }
    }
}

/// A bound of the distance of all segments from the first point.
fn reach(segments: &[CamSegment]) -> f64 {
    let first = segments.first().map_or(0.0, |first| first.y);
    let of = |pair: &[CamSegment]| {
        let [a1, a2, a3] = pair[0].coefficients.map(f64::abs);
        let u = pair[1].x - pair[0].x;
        (pair[0].y - first).abs() + u * (a1 + u * (a2 + u * a3))
    };
    segments.windows(2).map(of).fold(0.0, f64::max)
}
