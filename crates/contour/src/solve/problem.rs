//! The optimisation problem: timing and shape of one motion, and all its limited quantities.
//!
//! A node is a control point of a cubic B-spline in time with its instant. The unknowns are, for every node
//! `p[i] = reference + normals * offset`, its offset, and for every interval between nodes the logarithm of its duration `h[i]`. The
//! limited quantities are the control points of the spline's derivatives ([`crate::solve::derivatives`]); the spline lies within their hull, so
//! the limits hold at every instant. Not here: the search for a better motion ([`crate::solve::optimise`]). Units: the first time between two
//! nodes is 1 (limits are scaled to it), lengths are position units.

use crate::Point;
use crate::limits::MoveLimits;
use crate::path::corridor::CorridorRow;
use crate::path::reference::ReferencePath;
use crate::tuning::{SlowDown, TUNING};

/// The problem of one stage.
pub(crate) struct Problem<'a> {
    pub(crate) reference: &'a ReferencePath,
    pub(crate) points: Vec<Point>,
    /// Differences from node to node, if only the timing is optimised.
    pub(crate) differences: Vec<Point>,
    pub(crate) limits: Vec<NodeLimits>,
    pub(crate) normals: Vec<[Point; 2]>,
    pub(crate) tangents: Vec<Point>,
    /// The points that the corridor keeps near the reference path.
    pub(crate) corridor: Vec<CorridorRow>,
    /// Nodes that must not move.
    pub(crate) fixed: Vec<bool>,
    pub(crate) spans: Vec<f64>,
    /// Number of directions across the path in which a node may move: 0 (timing only), 1 (a plane) or 2 (space).
    pub(crate) lateral: usize,
    /// It continues a running motion: the first nodes and spans are given.
    pub(crate) continues: bool,
    /// The number of nodes close to the running motion.
    pub(crate) kept_nodes: usize,
    /// The part that is slowed down if the start is outside the limits.
    pub(crate) slow_down: SlowDown,
    /// The shares of the reciprocal limits of speed, acceleration and jerk, by node from -1 on, for a start outside of them; empty: the full
    /// limits.
    pub(crate) relaxed: Vec<[f64; 3]>,
}

/// Reciprocals of the limits at one node, 0 for no limit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct NodeLimits {
    pub(crate) speed: Point,
    pub(crate) acceleration: Point,
    pub(crate) jerk: Point,
    /// Reciprocal limits of the vector.
    pub(crate) vector_speed: f64,
    pub(crate) vector_acceleration: f64,
    pub(crate) vector_jerk: f64,
    /// Reciprocal limits along the path.
    pub(crate) speeding_up: f64,
    pub(crate) slowing_down: f64,
}

impl NodeLimits {
    /// The reciprocals for a first time between two nodes of `span` seconds. A vector's limit beyond the corner of those of the axes is omitted.
    pub(crate) fn reciprocal(bounds: &MoveLimits, span: f64) -> NodeLimits {
        let (second, third) = (span * span, span * span * span);
        let inverse = |limit: Point, unit: f64| limit.map(|l| 1.0 / (l * unit));
        let corner = bounds.axes.acceleration.norm();
        let binds = bounds.acceleration.min(bounds.deceleration) < corner;
        let jerk_corner = bounds.axes.jerk.map_or(f64::INFINITY, |jerk| jerk.norm());
        let one = |limit: f64, unit: f64, on: bool| if on { 1.0 / (limit * unit) } else { 0.0 };
        NodeLimits {
            speed: inverse(bounds.axes.speed, span),
            acceleration: inverse(bounds.axes.acceleration, second),
            jerk: bounds.axes.jerk.map_or(Point::zeros(), |jerk| inverse(jerk, third)),
            vector_speed: one(bounds.speed, span, bounds.speed < bounds.axes.speed.norm()),
            vector_acceleration: one(bounds.norm_acceleration(), second, binds),
            vector_jerk: one(bounds.jerk, third, bounds.jerk < jerk_corner),
            speeding_up: one(bounds.acceleration, second, binds),
            slowing_down: one(bounds.deceleration, second, binds),
        }
    }

    /// The jerk is limited.
    #[inline(always)]
    pub(crate) fn has_jerk(&self) -> bool {
        self.jerk != Point::zeros() || self.vector_jerk > 0.0
    }

    pub(crate) fn stricter(&self, other: &NodeLimits) -> NodeLimits {
        NodeLimits {
            speed: self.speed.sup(&other.speed),
            acceleration: self.acceleration.sup(&other.acceleration),
            jerk: self.jerk.sup(&other.jerk),
            vector_speed: self.vector_speed.max(other.vector_speed),
            vector_acceleration: self.vector_acceleration.max(other.vector_acceleration),
            vector_jerk: self.vector_jerk.max(other.vector_jerk),
            speeding_up: self.speeding_up.max(other.speeding_up),
            slowing_down: self.slowing_down.max(other.slowing_down),
        }
    }
}

impl Problem<'_> {
    pub(crate) fn intervals(&self) -> isize {
        self.points.len() as isize - 1
    }

    /// The curve is fixed, and only its timing is optimised.
    pub(crate) fn is_timing(&self) -> bool {
        self.lateral == 0
    }

    /// The weight of the barrier of a limit with a share.
    #[inline(always)]
    pub(crate) fn weight_of(share: f64) -> f64 {
        if share < 1.0 { TUNING.relax.weight } else { 1.0 }
    }
}
