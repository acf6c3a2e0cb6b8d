//! The optimisation problem of one stage: limits, directions and corridor of every node.

use crate::Point;
use crate::limits::MoveLimits;
use crate::path::allowance::Allowance;
use crate::path::corridor::CorridorRow;
use crate::path::reference::ReferencePath;
use crate::solve::problem::{NodeLimits, Problem};
use crate::solve::stages::Quality;
use crate::timing::control_points::{ControlPoints, GIVEN};
use crate::tolerance::{LEAST_LENGTH_UNITS, SAME_CONTROL_POINT_UNITS, SAME_POINT_UNITS};
use crate::tuning::{SlowDown, TUNING};

/// The conditions of a stage.
pub(crate) struct Conditions<'a> {
    pub(crate) reference: &'a ReferencePath,
    pub(crate) allowance: &'a Allowance,
    /// Limits by piece of the reference path.
    pub(crate) limits: &'a [MoveLimits],
    /// The same for the nodes close to the running motion.
    pub(crate) kept_limits: &'a [MoveLimits],
    /// Share of the tolerance for the corridor, by node.
    pub(crate) margins: &'a [f64],
    pub(crate) slow_down: SlowDown,
}

impl<'a> Conditions<'a> {
    /// The optimisation problem of the control points.
    pub(crate) fn problem(&self, control: &ControlPoints, quality: Quality) -> Problem<'a> {
        let span = control.spans[0];
        let progress = control.progress.iter();
        let pieces: Vec<usize> = progress.map(|&s| self.reference.piece_at(s)).collect();
        let timing = Problem {
            reference: self.reference,
            points: control.points.clone(),
            differences: control.points.windows(2).map(|pair| pair[1] - pair[0]).collect(),
            limits: self.limits_by_node(control, &pieces),
            normals: Vec::new(),
            tangents: self.tangents(control),
            corridor: Vec::new(),
            fixed: Vec::new(),
            spans: control.spans.iter().map(|h| h / span).collect(),
            lateral: 0,
            continues: control.initial.is_some(),
            kept_nodes: control.kept_nodes,
            slow_down: self.slow_down,
            relaxed: Vec::new(),
        };
        match quality {
            Quality::TimingOnly | Quality::Smooth => timing,
            Quality::Full => self.with_shape(timing, control, &pieces),
        }
    }

    /// The same with nodes that may move across the path, if there are any.
    fn with_shape(&self, timing: Problem<'a>, control: &ControlPoints, pieces: &[usize]) -> Problem<'a> {
        let plane = plane_of(&control.points);
        let radii = self.radii(control, pieces);
        let corridor = self.corridor(control, pieces, &radii);
        if corridor.is_empty() {
            return timing;
        }
        let tangents = timing.tangents.iter();
        Problem {
            normals: tangents.map(|tangent| across(tangent, plane)).collect(),
            corridor,
            fixed: radii.iter().map(|&radius| is_fixed(radius)).collect(),
            lateral: 1 + usize::from(plane.is_none()),
            ..timing
        }
    }

    /// The limits by node; beside a joint the stricter ones of both pieces.
    fn limits_by_node(&self, control: &ControlPoints, pieces: &[usize]) -> Vec<NodeLimits> {
        let (count, span) = (pieces.len(), control.spans[0]);
        let of_node = |i: usize| {
            let bounds = if i < control.kept_nodes {
                self.kept_limits
            } else {
                self.limits
            };
            let mut limit = NodeLimits::reciprocal(&bounds[pieces[i]], span);
            for other in [i.saturating_sub(1), (i + 1).min(count - 1)] {
                if pieces[other] != pieces[i] {
                    limit = limit.stricter(&NodeLimits::reciprocal(&bounds[pieces[other]], span));
                }
            }
            limit
        };
        (0..count).map(of_node).collect()
    }

    /// Directions of the curve at the nodes.
    fn tangents(&self, control: &ControlPoints) -> Vec<Point> {
        let points = &control.points;
        let mut tangent = self.reference.pieces[0].start_tangent();
        let of_node = |i: usize| {
            let d = points[(i + 1).min(points.len() - 1)] - points[i.saturating_sub(1)];
            if d.norm() > SAME_CONTROL_POINT_UNITS {
                tangent = d / d.norm();
            }
            tangent
        };
        (0..points.len()).map(of_node).collect()
    }

    /// The permitted distance of the nodes from the reference path; 0 for fixed nodes.
    fn radii(&self, control: &ControlPoints, pieces: &[usize]) -> Vec<f64> {
        let count = pieces.len();
        let given = if control.initial.is_some() { GIVEN } else { 2 };
        let of_node = |i: usize| {
            let s = control.progress[i];
            let tolerance = self.allowance.aim(self.reference, pieces[i], s);
            if i < given || i + 3 > count {
                0.0
            } else {
                self.coned(control, s, self.margins[i] * tolerance)
            }
        };
        (0..count).map(of_node).collect()
    }

    /// A radius, smaller near the ends: the motion leaves and arrives along the programmed direction, as the corridor opens like a cone.
    fn coned(&self, control: &ControlPoints, s: f64, radius: f64) -> f64 {
        let left = self.reference.length() - s;
        // A continuation does not begin at rest.
        let near = if control.initial.is_some() { left } else { s.min(left) };
        radius.min(TUNING.corridor.cone * near)
    }

    /// Points of the curve that must be near the reference path.
    fn corridor(&self, control: &ControlPoints, pieces: &[usize], radii: &[f64]) -> Vec<CorridorRow> {
        let Conditions {
            reference, allowance, ..
        } = *self;
        let mut rows = Vec::new();
        let edges = allowance.edges(reference);
        let widest = self.margins.iter().copied().fold(0.0, f64::max);
        // The first points of a continuation have next to no freedom.
        let first = if control.initial.is_some() { GIVEN + 1 } else { 0 };
        for i in (first..pieces.len()).filter(|&i| !is_fixed(radii[i])) {
            let (piece, s) = (pieces[i], control.progress[i]);
            let exact = allowance.keeps_close_at(reference, piece, s);
            let row = if exact { CorridorRow::exact } else { CorridorRow::new };
            rows.push(row(i, 0.0, piece, radii[i]));
            if is_fixed(radii[i + 1]) {
                continue;
            }
            // In a narrow corridor, the middle of the curve between two knots also counts.
            if exact && piece == pieces[i + 1] && allowance.is_near_rounding(reference, piece, s) {
                rows.push(row(i, 0.5, piece, 0.5 * (radii[i] + radii[i + 1])));
            }
            if self.margins[i].min(self.margins[i + 1]) < widest {
                self.add_edges(control, i, &edges, &mut rows);
            }
            for joint in piece + 1..=pieces[i + 1] {
                self.add_joint(control, i, joint, radii, &mut rows);
            }
        }
        rows
    }

    /// Adds the edges of the corridor behind node `i`: a curve inside at both nodes may be outside there. If it was, the corridor is
    /// narrower there.
    fn add_edges(&self, control: &ControlPoints, i: usize, edges: &[(usize, f64)], rows: &mut Vec<CorridorRow>) {
        let (here, next) = (control.progress[i], control.progress[i + 1]);
        let margin = self.margins[i].min(self.margins[i + 1]);
        let first = edges.partition_point(|&(_, s)| s <= here);
        for &(piece, s) in edges[first..].iter().take_while(|&&(_, s)| s < next) {
            let width = margin * self.allowance.aim(self.reference, piece, s);
            let radius = self.coned(control, s, width);
            if !is_fixed(radius) {
                rows.push(CorridorRow::exact(i, (s - here) / (next - here), piece, radius));
            }
        }
    }

    /// The joint between nodes `i` and `i + 1`, which must be near both its pieces.
    fn add_joint(&self, control: &ControlPoints, i: usize, joint: usize, radii: &[f64], rows: &mut Vec<CorridorRow>) {
        let start = self.reference.starts[joint];
        let (here, next) = (control.progress[i], control.progress[i + 1]);
        let part = ((start - here) / (next - here)).clamp(0.0, 1.0);
        // Beside a piece that the curve keeps close to, the nodes' corridors are narrower than that of the joint between them.
        let width = self.allowance.at_joint(self.reference, joint);
        let row = if width.is_some() {
            CorridorRow::exact
        } else {
            CorridorRow::new
        };
        let radius = width.map_or_else(
            || radii[i].min(radii[i + 1]),
            |width| self.coned(control, start, self.margins[i].min(self.margins[i + 1]) * width),
        );
        rows.push(row(i, part, joint - 1, radius));
        rows.push(row(i, part, joint, radius));
    }
}

fn is_fixed(radius: f64) -> bool {
    radius <= SAME_POINT_UNITS
}

/// The unit normal of the plane through all points, if there is one that is normal to an axis.
fn plane_of(points: &[Point]) -> Option<Point> {
    let first = points[0];
    (0..3)
        .rev()
        .find(|&axis| points.iter().all(|p| p[axis] == first[axis]))
        .map(|axis| {
            let mut normal = Point::zeros();
            normal[axis] = 1.0;
            normal
        })
}

/// Two unit vectors across a tangent, the first one in the plane if there is one.
fn across(tangent: &Point, plane: Option<Point>) -> [Point; 2] {
    let helper = plane.unwrap_or_else(|| {
        let axis = tangent.abs().imin();
        let mut unit = Point::zeros();
        unit[axis] = 1.0;
        unit
    });
    let first = helper.cross(tangent);
    let first = first / first.norm().max(LEAST_LENGTH_UNITS);
    [first, tangent.cross(&first)]
}
