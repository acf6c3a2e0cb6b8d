//! Compresses chords into a smooth curve: moves the nodes of a dense path inside the tolerance to the positions of least jerk.
//!
//! Nodes are at equal times of a first speed profile, so their third difference is the jerk at that speed. The objective is the sum of its
//! squares minus the logarithm of the distance to the corridor's wall: each round solves a band system in which the barrier is a spring to the
//! nearest point of the reference path, as stiff as the barrier is steep. Steps that would leave the corridor are shortened. A few numbers per
//! node and round. Position units.

use crate::Point;
use crate::limits::MoveLimits;
use crate::path::allowance::Allowance;
use crate::path::corridor::CorridorRow;
use crate::path::margin::ToleranceMargin;
use crate::path::reference::{ReferencePath, along};
use crate::solve::step_lengths::smooth_lengths;
use crate::timing::control_points::ControlPoints;
use crate::timing::grid::sites;
use crate::tuning::TUNING;

/// Moves the nodes of a curve inside its corridor such that it is smooth. The nodes of a running motion stay.
pub(crate) fn smooth(
    reference: &ReferencePath,
    allowance: &Allowance,
    margin: &ToleranceMargin,
    bounds: &[MoveLimits],
    control: &mut ControlPoints,
) {
    let count = control.points.len();
    let given = control.held_nodes.max(control.kept_nodes).max(TUNING.smooth.held_ends);
    if count < given + 2 * TUNING.smooth.held_ends {
        return;
    }
    let free = given..count - TUNING.smooth.held_ends;
    let is_rough = is_rough(reference);
    let mut rows: Vec<Row> = Vec::new();
    for node in given - 1..count - TUNING.smooth.held_ends {
        let at_joints = is_rough.then(|| joints(node, reference, control));
        let parts = PARTS.into_iter().chain(at_joints.into_iter().flatten());
        rows.extend(parts.map(|part| Row::new(node, part, reference, margin, control)));
    }
    if control.initial.is_some() {
        let beside = given + TUNING.smooth.beside_nodes;
        for row in rows.iter_mut().filter(|row| row.first < beside) {
            row.begin(reference, allowance, &control.points);
        }
    }
    let rate = |bound: &MoveLimits| bound.axes.acceleration.min().min(bound.norm_acceleration());
    let node_s = allowance.spacing().node_s;
    let least = bounds.iter().map(rate).fold(f64::INFINITY, f64::min);
    let third = least * node_s.powi(3) / TUNING.smooth.jerk_s;
    let stiffness = TUNING.smooth.stiffness / (third * third);
    let thirds = thirds(control, node_s);
    let mut system = Springs::new(count);
    let mut lengths = vec![1.0; count];
    let mut wanted = vec![1.0; count];
    for _ in 0..TUNING.smooth.rounds {
        system.clear();
        for (i, point) in control.points.iter().enumerate().filter(|(i, _)| !free.contains(i)) {
            system.hold(i, point);
        }
        for row in &mut rows {
            row.update(reference, allowance, &control.points);
            system.pull(row);
        }
        system.solve(stiffness, &thirds);
        for (step, point) in system.points.iter_mut().zip(&control.points) {
            *step -= point;
        }
        wanted.fill(1.0);
        for row in &rows {
            let part = row.step(&system.points);
            for node in [row.first + 1, row.first + 2] {
                wanted[node] = f64::min(wanted[node], part);
            }
        }
        smooth_lengths(&wanted, &mut lengths);
        for i in free.clone() {
            control.points[i] += system.points[i] * lengths[i];
        }
    }
}

/// A point of the curve, and the corridor's wall about it.
struct Row {
    /// The first of the four nodes whose weighted sum it is.
    first: usize,
    weights: [f64; 4],
    /// The nearest piece of the reference path at the last update.
    piece: usize,
    /// Share of the corridor.
    share: f64,
    /// The nearest point of the reference path, and the offset from it.
    foot: Point,
    off: Point,
    radius: f64,
    /// The least radius, for a curve that continues a running one.
    begun: f64,
    tangent: Point,
}

impl Row {
    fn new(
        node: usize,
        part: f64,
        reference: &ReferencePath,
        margin: &ToleranceMargin,
        control: &ControlPoints,
    ) -> Row {
        let s = control.progress[node];
        let mut point = CorridorRow::exact(node, part, 0, 0.0);
        point.weigh(&control.spans);
        Row {
            first: point.first,
            weights: point.weights,
            piece: reference.piece_at(s),
            share: TUNING.smooth.inside_share * margin.at(s).min(margin.at(control.progress[node + 1])),
            foot: Point::zeros(),
            off: Point::zeros(),
            radius: 0.0,
            begun: 0.0,
            tangent: Point::zeros(),
        }
    }

    fn of(&self, points: &[Point]) -> Point {
        let p = &points[self.first..self.first + 4];
        let w = &self.weights;
        p[0] * w[0] + p[1] * w[1] + p[2] * w[2] + p[3] * w[3]
    }

    /// Widens the corridor for the running motion, which may be nearer to the wall than a smooth curve.
    fn begin(&mut self, reference: &ReferencePath, allowance: &Allowance, points: &[Point]) {
        self.update(reference, allowance, points);
        // Less where the curve was outside.
        let usual = TUNING.smooth.inside_share * TUNING.margin.usual_share;
        let most = TUNING.smooth.most_begun / usual * self.radius;
        self.begun = most.min(TUNING.smooth.beside_off * self.off.norm());
    }

    /// Finds the nearest point of the reference path, and the corridor there.
    fn update(&mut self, reference: &ReferencePath, allowance: &Allowance, points: &[Point]) {
        let point = self.of(points);
        (self.foot, self.piece) = reference.foot(&point, self.piece);
        let path = &reference.pieces[self.piece];
        let at = along(path, &point);
        self.radius = self.share * allowance.aim(reference, self.piece, reference.starts[self.piece] + at);
        self.radius = self.radius.max(self.begun);
        self.off = point - self.foot;
        self.tangent = path.at(at).tangent;
    }

    /// The steepness of the barrier.
    fn strength(&self) -> f64 {
        let square = self.radius * self.radius;
        1.0 / (square - self.off.norm_squared()).max(TUNING.smooth.least_room * square)
    }

    /// The part of a step of the nodes that stays inside. Along the path it is unlimited.
    fn step(&self, steps: &[Point]) -> f64 {
        let across = |v: &Point| v - self.tangent * self.tangent.dot(v);
        let (off, step) = (across(&self.off), across(&self.of(steps)));
        let (product, square) = (off.dot(&step), step.norm_squared());
        let room = self.radius * self.radius - off.norm_squared();
        if room <= 0.0 {
            return if product < 0.0 { 1.0 } else { 0.0 };
        }
        let most = (libm::sqrt(product * product + square * room) - product) / square;
        if most.is_finite() {
            (TUNING.smooth.most_step * most).min(1.0)
        } else {
            1.0
        }
    }
}

/// The shares of the span behind a knot at which the motion passes joints between pieces that are long beside the span: the curve is farthest from
/// its path there.
fn joints<'a>(node: usize, reference: &'a ReferencePath, control: &ControlPoints) -> impl Iterator<Item = f64> + 'a {
    let (from, until) = (control.progress[node], control.progress[node + 1]);
    let first = reference.piece_at(from);
    let last = reference.piece_at(until);
    let least = TUNING.smooth.joint_share * (until - from);
    let is_long = move |piece: usize| reference.pieces[piece].length() >= least;
    (first + 1..=last)
        .filter(move |&joint| is_long(joint - 1) && is_long(joint))
        .map(move |joint| (reference.starts[joint] - from) / (until - from))
}

/// The chords are those of a rough curve: on average, the direction changes at a joint otherwise than at its neighbours.
fn is_rough(reference: &ReferencePath) -> bool {
    let joints = 1..reference.pieces.len();
    let count = joints.len() as f64;
    joints
        .map(|joint| roughness(reference, joint).min(TUNING.smooth.sharp))
        .sum::<f64>()
        > TUNING.smooth.rough * count
}

/// The difference between the change of direction at a joint and that at its neighbours: on the chords of a smooth curve it is small.
fn roughness(reference: &ReferencePath, joint: usize) -> f64 {
    let change = |joint: usize| {
        let before = joint.checked_sub(1).and_then(|before| reference.pieces.get(before));
        let pair = before.zip(reference.pieces.get(joint));
        pair.map(|(before, behind)| behind.start_tangent() - before.end_tangent())
    };
    let Some(here) = change(joint) else { return 0.0 };
    let beside = |other: Option<Point>| other.unwrap_or(here);
    let mean = (beside(change(joint.wrapping_sub(1))) + beside(change(joint + 1))) * 0.5;
    (here - mean).norm()
}

/// Weights of four nodes whose sum is the jerk times the root of its duration, in units of the usual time between two nodes.
fn thirds(control: &ControlPoints, node_s: f64) -> Vec<[f64; 4]> {
    let mut time = 0.0;
    let knots: Vec<f64> = core::iter::once(0.0)
        .chain(control.spans.iter().map(|span| {
            time += span / node_s;
            time
        }))
        .collect();
    let at: Vec<f64> = sites(&knots).collect();
    at.windows(4)
        .map(|t| {
            let lasts = libm::sqrt((t[3] - t[0]) / 3.0);
            core::array::from_fn(|k| {
                let others = (0..4).filter(|&other| other != k);
                6.0 * lasts / others.map(|other| t[k] - t[other]).product::<f64>()
            })
        })
        .collect()
}

/// Nodes on springs, with a cost for their third differences.
struct Springs {
    /// Lower half of the band: the diagonal, then three to its left.
    band: Vec<[f64; 4]>,
    points: Vec<Point>,
}

impl Springs {
    fn new(count: usize) -> Springs {
        Springs {
            band: vec![[0.0; 4]; count],
            points: vec![Point::zeros(); count],
        }
    }

    fn clear(&mut self) {
        self.band.fill([0.0; 4]);
        self.points.fill(Point::zeros());
    }

    fn hold(&mut self, node: usize, at: &Point) {
        self.band[node][0] += TUNING.smooth.held_spring;
        self.points[node] += at * TUNING.smooth.held_spring;
    }

    fn pull(&mut self, row: &Row) {
        let strength = row.strength();
        for (k, &weight) in row.weights.iter().enumerate() {
            let pull = strength * weight;
            self.points[row.first + k] += row.foot * pull;
            for (before, other) in row.weights.iter().enumerate().take(k + 1) {
                self.band[row.first + k][k - before] += pull * other;
            }
        }
    }

    /// Solves for the equilibrium of the nodes, in `points`: by Cholesky's method without roots.
    fn solve(&mut self, stiffness: f64, thirds: &[[f64; 4]]) {
        let Springs { band, points } = self;
        let count = band.len();
        for (first, third) in thirds.iter().enumerate() {
            for row in 0..4 {
                for column in 0..=row {
                    band[first + row][row - column] += stiffness * third[row] * third[column];
                }
            }
        }
        for i in 0..count {
            let most = i.min(3);
            for left in (1..=most).rev() {
                let mut sum = band[i][left];
                for other in left + 1..=most {
                    sum -= band[i][other] * band[i - left][other - left] * band[i - other][0];
                }
                band[i][left] = sum / band[i - left][0];
            }
            for left in 1..=most {
                band[i][0] -= band[i][left] * band[i][left] * band[i - left][0];
                let before = points[i - left];
                points[i] -= before * band[i][left];
            }
        }
        for i in 0..count {
            points[i] /= band[i][0];
        }
        for i in (0..count).rev() {
            let value = points[i];
            for left in 1..=i.min(3) {
                points[i - left] -= value * band[i][left];
            }
        }
    }
}

/// Shares of the span between two knots at which the curve must be inside.
const PARTS: [f64; 2] = [0.0, 0.5];
