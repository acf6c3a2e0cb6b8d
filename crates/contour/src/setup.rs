//! The optimisation problem of one run: limits, directions and tube of every node.

use crate::allowance::Allowance;
use crate::course::Course;
use crate::nodes::{LEAD, Nodes};
use crate::plan::{Effort, SHORTEST};
use crate::problem::{Limits, Problem};
use crate::tube::TubeRow;
use crate::{Bounds, Point};

/// The optimisation of the nodes as they stand within `bounds`, the kept ones within theirs; `shares` of the
/// tolerance make the tube.
pub(crate) fn problem<'a>(
    course: &'a Course,
    nodes: &Nodes,
    (bounds, kept): (&[Bounds], &[Bounds]),
    allowance: &Allowance,
    effort: Effort,
    shares: &[f64],
) -> Problem<'a> {
    let count = nodes.points.len();
    let span = nodes.spans[0];
    let pieces: Vec<usize> = nodes.progress.iter().map(|&s| course.piece_at(s)).collect();
    let limits: Vec<Limits> = (0..count)
        .map(|i| {
            let bounds = if i < nodes.kept { kept } else { bounds };
            let mut limit = reciprocal(&bounds[pieces[i]], span);
            for other in [i.saturating_sub(1), (i + 1).min(count - 1)] {
                if pieces[other] != pieces[i] {
                    limit = limit.stricter(&reciprocal(&bounds[pieces[other]], span));
                }
            }
            limit
        })
        .collect();
    let mut tangents = Vec::with_capacity(count);
    let mut normals = Vec::with_capacity(count);
    let mut radii = Vec::with_capacity(count);
    let plane = plane_of(&nodes.points);
    let given = if nodes.lead.is_some() { LEAD } else { 2 };
    let mut tangent = course.pieces[0].start_tangent();
    for i in 0..count {
        let d = nodes.points[(i + 1).min(count - 1)] - nodes.points[i.saturating_sub(1)];
        if d.norm() > 1e-12 {
            tangent = d / d.norm();
        }
        tangents.push(tangent);
        normals.push(across(&tangent, plane));
        let tolerance = allowance.aim(course, pieces[i], nodes.progress[i]);
        // It leaves and arrives along the programmed direction: the tube opens as a cone.
        let radius = (shares[i] * tolerance).min(CONE * end_near(course, nodes, nodes.progress[i]));
        radii.push(if i < given || i + 3 > count { 0.0 } else { radius });
    }
    let fixed: Vec<bool> = radii.iter().map(|&r| r <= SHORTEST).collect();
    let mut tube = Vec::new();
    let edges = allowance.edges(course);
    let widest = shares.iter().copied().fold(0.0, f64::max);
    // The first points of a led curve have next to no freedom.
    let first = if nodes.lead.is_some() { LEAD + 1 } else { 0 };
    for i in (first..count).filter(|&i| !fixed[i]) {
        let exact = allowance.keeps_at(course, pieces[i], nodes.progress[i]);
        let row = if exact { TubeRow::exact } else { TubeRow::new };
        tube.push(row(i, 0.0, pieces[i], radii[i]));
        if fixed[i + 1] {
            continue;
        }
        // Where the tube is narrow the curve between two knots counts too.
        if exact && pieces[i] == pieces[i + 1] && allowance.is_near_rounding(course, pieces[i], nodes.progress[i]) {
            tube.push(row(i, 0.5, pieces[i], 0.5 * (radii[i] + radii[i + 1])));
        }
        let (here, next) = (nodes.progress[i], nodes.progress[i + 1]);
        // Where the tube stops narrowing between two knots, a curve inside at both may be outside. One that was has it narrower there.
        let first_edge = edges.partition_point(|&(_, s)| s <= here);
        for &(piece, s) in edges[first_edge..].iter().take_while(|&&(_, s)| s < next) {
            let share = shares[i].min(shares[i + 1]);
            let width = share * allowance.aim(course, piece, s);
            let radius = width.min(CONE * end_near(course, nodes, s));
            if share < widest && radius > SHORTEST {
                tube.push(TubeRow::exact(i, (s - here) / (next - here), piece, radius));
            }
        }
        for joint in pieces[i] + 1..=pieces[i + 1] {
            let part = ((course.starts[joint] - here) / (next - here)).clamp(0.0, 1.0);
            // Beside a piece that is kept to, the nodes' tubes are narrower than that of the joint between them.
            let exact = allowance.at_joint(course, joint).is_some();
            let row = if exact { TubeRow::exact } else { TubeRow::new };
            let radius = allowance.at_joint(course, joint).map_or_else(
                || radii[i].min(radii[i + 1]),
                |width| {
                    (shares[i].min(shares[i + 1]) * width).min(CONE * end_near(course, nodes, course.starts[joint]))
                },
            );
            tube.push(row(i, part, joint - 1, radius));
            tube.push(row(i, part, joint, radius));
        }
    }
    let lateral = match effort {
        Effort::Quick => 0,
        Effort::Full if tube.is_empty() => 0,
        Effort::Full => 1 + usize::from(plane.is_none()),
    };
    Problem {
        course,
        points: nodes.points.clone(),
        limits,
        normals,
        tangents,
        tube,
        fixed,
        spans: nodes.spans.iter().map(|h| h / span).collect(),
        lateral,
        led: nodes.lead.is_some(),
        kept: nodes.kept,
        ease: Vec::new(),
    }
}

/// How far the nearer end of the course is at which the motion rests.
fn end_near(course: &Course, nodes: &Nodes, s: f64) -> f64 {
    let left = course.length() - s;
    if nodes.lead.is_some() { left } else { s.min(left) }
}

/// The unit normal of the plane that holds all points, when they lie in one that is normal to an axis.
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
    let first = first / first.norm().max(1e-300);
    [first, tangent.cross(&first)]
}

fn reciprocal(bounds: &Bounds, span: f64) -> Limits {
    let (second, third) = (span * span, span * span * span);
    let inverse = |limit: Point, unit: f64| limit.map(|l| 1.0 / (l * MARGIN * unit));
    let corner = bounds.axes.acceleration.norm();
    let binds = bounds.acceleration.min(bounds.deceleration) < corner;
    let jerk_corner = bounds.axes.jerk.map_or(f64::INFINITY, |jerk| jerk.norm());
    let one = |limit: f64, unit: f64, on: bool| if on { 1.0 / (limit * MARGIN * unit) } else { 0.0 };
    Limits {
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

impl Limits {
    fn stricter(&self, other: &Limits) -> Limits {
        Limits {
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

/// How fast the tube opens at the ends of the course.
const CONE: f64 = 0.25;
/// Share of the limits that the optimisation uses; the rest is for its discretisation.
const MARGIN: f64 = 1.0;
