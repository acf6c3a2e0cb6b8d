//! The joint optimisation of timing and shape by a barrier method.
//!
//! Unknown are, for every node `p[i] = reference + normals * offset`, its offset, and for every
//! interval between nodes `b[i]`, the square of the rate at which it is run through (`1/b.sqrt()` is
//! its time). Velocity, acceleration and jerk are divided differences:
//!
//! ```text
//! d[i] = p[i+1] - p[i]
//! velocity[i]     = sqrt(b[i]) d[i]
//! acceleration[i] = b[i] (3 d[i] - d[i-1])/4 + b[i-1] (d[i] - 3 d[i-1])/4      at node i
//! jerk[i]         = sqrt(b[i]) (acceleration[i+1] - acceleration[i])           in interval i
//! ```
//!
//! Minimised is `t * time - sum of log(1 - (quantity / limit)²)` for growing `t`, by Gauss-Newton steps
//! on a band matrix; a step that would leave the feasible set is shortened, so **every iterate keeps
//! all limits and the tube**, and the work can end at any time. Units: the nominal time between two
//! nodes is 1 (limits are scaled to it), lengths are position units.

use crate::Point;
use crate::banded::Banded;
use crate::course::Course;

/// Reciprocals of the limits at one node, 0 where there is none.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Limits {
    pub(crate) speed: Point,
    pub(crate) acceleration: Point,
    pub(crate) jerk: Point,
    /// Of the vector.
    pub(crate) vector_speed: f64,
    pub(crate) vector_acceleration: f64,
    pub(crate) vector_jerk: f64,
    /// Along the path.
    pub(crate) speeding_up: f64,
    pub(crate) slowing_down: f64,
}

/// What is optimised. `LATERAL` is how many directions across the path a node may move in:
/// 0 (timing only), 1 (a plane) or 2 (space).
pub(crate) struct Problem<'a> {
    pub(crate) course: &'a Course,
    pub(crate) points: Vec<Point>,
    pub(crate) limits: Vec<Limits>,
    pub(crate) normals: Vec<[Point; 2]>,
    pub(crate) tangents: Vec<Point>,
    /// Radius of the tube at each node; 0: the node stays where it is.
    pub(crate) tube: Vec<f64>,
    /// The piece that is nearest to each node.
    pub(crate) feet: Vec<usize>,
    pub(crate) rates: Vec<f64>,
    pub(crate) lateral: usize,
}

/// How hard to work.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Effort {
    pub(crate) first: f64,
    pub(crate) last: f64,
    pub(crate) factor: f64,
    pub(crate) steps: usize,
}

impl Problem<'_> {
    /// Lowers all rates until every limit is kept with room to spare.
    pub(crate) fn make_feasible(&mut self) {
        for _ in 0..200 {
            if self.worst() < FEASIBLE {
                return;
            }
            for rate in &mut self.rates {
                *rate *= 0.7;
            }
        }
    }

    /// The largest quotient of a quantity and its limit.
    fn worst(&self) -> f64 {
        let mut worst = 0.0_f64;
        for i in -1..=self.intervals() {
            self.for_each_quantity(i, &self.points, &self.rates, |q| {
                for axis in 0..3 {
                    worst = worst.max((q.value[axis] * q.axes[axis]).abs());
                }
                worst = worst.max(q.value.norm() * q.vector);
                let along = q.along.0.dot(&q.value);
                worst = worst.max(along * q.along.1).max(-along * q.along.2);
            });
        }
        worst
    }

    fn intervals(&self) -> isize {
        self.points.len() as isize - 1
    }

    fn rate(rates: &[f64], i: isize) -> f64 {
        rates[i.clamp(0, rates.len() as isize - 1) as usize]
    }

    /// Velocity and jerk of interval `i` and the acceleration at node `i`, `-1 <= i <= intervals`.
    #[inline]
    fn for_each_quantity(&self, i: isize, points: &[Point], rates: &[f64], mut each: impl FnMut(Quantity)) {
        let n = self.intervals();
        let node = |k: isize| points[k.clamp(0, n) as usize];
        let b = |k: isize| Self::rate(rates, k);
        let limits = &self.limits[i.clamp(0, n) as usize];
        let (p0, p1, p2, p3) = (node(i - 1), node(i), node(i + 1), node(i + 2));
        let (d0, d1, d2) = (p1 - p0, p2 - p1, p3 - p2);
        let (b0, b1, b2) = (b(i - 1), b(i), b(i + 1));
        let zero = Point::zeros();
        let none = (zero, 0.0, 0.0);
        // Acceleration at node i and at node i + 1, with their derivatives by d and b.
        let (at0, at1) = (d1 * 0.75 - d0 * 0.25, d1 * 0.25 - d0 * 0.75);
        let (bt0, bt1) = (d2 * 0.75 - d1 * 0.25, d2 * 0.25 - d1 * 0.75);
        let here = if i < 0 { zero } else { at0 * b1 + at1 * b0 };
        let next = if i >= n { zero } else { bt0 * b2 + bt1 * b1 };
        let (alpha0, gamma0) = if i < 0 { (0.0, 0.0) } else { (0.75 * b1 + 0.25 * b0, 0.25 * b1 + 0.75 * b0) };
        let (alpha1, gamma1) = if i >= n { (0.0, 0.0) } else { (0.75 * b2 + 0.25 * b1, 0.25 * b2 + 0.75 * b1) };
        let root = b1.sqrt();
        if i >= 0 && i < n {
            each(Quantity {
                value: d1 * root,
                by_rate: [zero, d1 * (0.5 / root), zero],
                by_node: [0.0, -root, root, 0.0],
                axes: limits.speed,
                vector: limits.vector_speed,
                along: none,
            });
        }
        if i >= 0 {
            each(Quantity {
                value: here,
                by_rate: [at1, at0, zero],
                by_node: [gamma0, -alpha0 - gamma0, alpha0, 0.0],
                axes: limits.acceleration,
                vector: limits.vector_acceleration,
                along: (self.tangents[i as usize], limits.speeding_up, limits.slowing_down),
            });
        }
        if limits.jerk != zero || limits.vector_jerk > 0.0 {
            let change = next - here;
            let (here0, here1) = if i < 0 { (zero, zero) } else { (at1, at0) };
            let (next1, next2) = if i >= n { (zero, zero) } else { (bt1, bt0) };
            each(Quantity {
                value: change * root,
                by_rate: [here0 * -root, change * (0.5 / root) + (next1 - here1) * root, next2 * root],
                by_node: [
                    -root * gamma0,
                    root * (gamma1 + alpha0 + gamma0),
                    root * (-alpha1 - gamma1 - alpha0),
                    root * alpha1,
                ],
                axes: limits.jerk,
                vector: limits.vector_jerk,
                along: none,
            });
        }
    }

    fn place(&self, offsets: &[[f64; 2]], points: &mut [Point]) {
        for (i, point) in points.iter_mut().enumerate() {
            *point = self.points[i] + self.normals[i][0] * offsets[i][0] + self.normals[i][1] * offsets[i][1];
        }
    }

    /// The function to be minimised; infinite outside the feasible set.
    fn merit(&self, t: f64, points: &[Point], rates: &[f64], feet: &mut [usize]) -> f64 {
        let mut sum = 0.0;
        for (i, rate) in rates.iter().enumerate() {
            // Negated so that a NaN ends here too.
            if !(*rate > 0.0) {
                return f64::INFINITY;
            }
            let _ = i;
            sum += t / rate.sqrt();
        }
        for i in -1..=self.intervals() {
            let mut product = 1.0;
            let mut inside = true;
            self.for_each_quantity(i, points, rates, |q| {
                for axis in 0..3 {
                    let x = q.value[axis] * q.axes[axis];
                    let slack = 1.0 - x * x;
                    inside &= slack > 0.0;
                    product *= slack;
                }
                if q.vector > 0.0 {
                    let slack = 1.0 - q.value.norm_squared() * q.vector * q.vector;
                    inside &= slack > 0.0;
                    product *= slack;
                }
                if q.along.1 > 0.0 {
                    let along = q.along.0.dot(&q.value);
                    let (up, down) = (1.0 - along * q.along.1, 1.0 + along * q.along.2);
                    inside &= up > 0.0 && down > 0.0;
                    product *= up * down;
                }
            });
            if self.lateral > 0 && i >= 0 && self.tube[i as usize] > 0.0 {
                let k = i as usize;
                let (foot, piece) = self.course.foot(&points[k], feet[k]);
                feet[k] = piece;
                let slack = 1.0 - (points[k] - foot).norm_squared() / (self.tube[k] * self.tube[k]);
                inside &= slack > 0.0;
                product *= slack;
            }
            if !inside {
                return f64::INFINITY;
            }
            sum -= libm::log(product);
        }
        sum
    }

    /// Improves `rates` and `points` in place; returns the number of steps taken.
    pub(crate) fn run(&mut self, effort: Effort) -> usize {
        let count = self.points.len();
        let block = 1 + self.lateral;
        let mut matrix = Banded::new(count * block, 4 * block - 1);
        let mut right = vec![0.0; count * block];
        let mut offsets = vec![[0.0; 2]; count];
        let mut points = self.points.clone();
        let mut rates = self.rates.clone();
        let mut feet = self.feet.clone();
        let (mut trial_offsets, mut trial_points, mut trial_rates) = (offsets.clone(), points.clone(), rates.clone());
        let mut t = effort.first;
        let mut steps = 0;
        loop {
            let mut value = self.merit(t, &points, &rates, &mut feet);
            if !value.is_finite() {
                break;
            }
            let last = t >= effort.last;
            for _ in 0..effort.steps {
                self.assemble(t, &points, &rates, &feet, &mut matrix, &mut right);
                let gradient = right.clone();
                matrix.solve(&mut right);
                let decrement: f64 = -gradient.iter().zip(&right).map(|(g, s)| g * s).sum::<f64>();
                steps += 1;
                if !decrement.is_finite() || -decrement < CONVERGED * count as f64 {
                    break;
                }
                // `right` solved H x = -g with the sign turned in `assemble`; the slope is -|..|.
                let slope = decrement;
                let mut length = 1.0_f64;
                for (i, rate) in rates.iter().enumerate() {
                    let change = right[i * block];
                    if change < -0.8 * rate {
                        length = length.min(-0.8 * rate / change);
                    }
                }
                let mut improved = false;
                for _ in 0..24 {
                    for i in 0..count {
                        for k in 0..self.lateral {
                            trial_offsets[i][k] = offsets[i][k] + length * right[i * block + 1 + k];
                        }
                    }
                    for (i, rate) in trial_rates.iter_mut().enumerate() {
                        *rate = rates[i] + length * right[i * block];
                    }
                    if self.lateral > 0 {
                        self.place(&trial_offsets, &mut trial_points);
                    }
                    let trial = self.merit(t, &trial_points, &trial_rates, &mut feet);
                    if trial <= value + 1e-4 * length * slope {
                        value = trial;
                        improved = true;
                        break;
                    }
                    length *= 0.6;
                }
                if !improved {
                    break;
                }
                core::mem::swap(&mut offsets, &mut trial_offsets);
                core::mem::swap(&mut points, &mut trial_points);
                core::mem::swap(&mut rates, &mut trial_rates);
                if std::env::var("CONTOUR_TRACE").is_ok() {
                    let time: f64 = rates.iter().map(|b| 1.0 / b.sqrt()).sum();
                    eprintln!("t {t:9.1} step {steps} time {time:.3} dec {decrement:.3e} len {length:.3}");
                }
            }
            if last {
                break;
            }
            t = (t * effort.factor).min(effort.last);
        }
        self.points = points;
        self.rates = rates;
        self.feet = feet;
        steps
    }

    /// The Gauss-Newton matrix and minus the gradient.
    fn assemble(
        &self,
        t: f64,
        points: &[Point],
        rates: &[f64],
        feet: &[usize],
        matrix: &mut Banded,
        right: &mut [f64],
    ) {
        let block = 1 + self.lateral;
        let n = self.intervals();
        matrix.clear();
        right.fill(0.0);
        for (i, &rate) in rates.iter().enumerate() {
            let power = 1.0 / (rate * rate.sqrt());
            right[i * block] += 0.5 * t * power;
            matrix.add(i * block, i * block, 0.75 * t * power / rate);
        }
        let mut local = [0.0; MAX_LOCAL * MAX_LOCAL];
        let mut slopes = [0.0; MAX_LOCAL];
        let size = 4 * block;
        for i in -1..=n {
            local.fill(0.0);
            slopes.fill(0.0);
            let normal = |k: usize| &self.normals[(i - 1 + k as isize).clamp(0, n) as usize];
            self.for_each_quantity(i, points, rates, |q| {
                // Rows of the Jacobian by axis.
                let mut rows = [[0.0; MAX_LOCAL]; 3];
                for k in 0..4 {
                    for axis in 0..3 {
                        if k < 3 {
                            rows[axis][k * block] = q.by_rate[k][axis];
                        }
                        for side in 0..self.lateral {
                            rows[axis][k * block + 1 + side] = q.by_node[k] * normal(k)[side][axis];
                        }
                    }
                }
                let mut add = |row: &[f64; MAX_LOCAL], slope: f64, weight: f64| {
                    for r in 0..size {
                        slopes[r] += slope * row[r];
                        let weighted = weight * row[r];
                        for c in 0..=r {
                            local[r * MAX_LOCAL + c] += weighted * row[c];
                        }
                    }
                };
                for axis in 0..3 {
                    let inverse = q.axes[axis];
                    let x = q.value[axis] * inverse;
                    let slack = 1.0 - x * x;
                    if inverse > 0.0 {
                        let weight = 2.0 * (1.0 + x * x) / (slack * slack) * inverse * inverse;
                        add(&rows[axis], 2.0 * x / slack * inverse, weight);
                    }
                }
                if q.vector > 0.0 {
                    let square = q.vector * q.vector;
                    let scale = 2.0 * square / (1.0 - q.value.norm_squared() * square);
                    let mut along = [0.0; MAX_LOCAL];
                    for axis in 0..3 {
                        for r in 0..size {
                            along[r] += q.value[axis] * rows[axis][r];
                        }
                        add(&rows[axis], 0.0, scale);
                    }
                    add(&along, scale, scale * scale);
                }
                if q.along.1 > 0.0 {
                    let (tangent, up, down) = q.along;
                    let mut along = [0.0; MAX_LOCAL];
                    for axis in 0..3 {
                        for r in 0..size {
                            along[r] += tangent[axis] * rows[axis][r];
                        }
                    }
                    let x = tangent.dot(&q.value);
                    let (a, b) = (up / (1.0 - x * up), down / (1.0 + x * down));
                    add(&along, a - b, a * a + b * b);
                }
            });
            // Into the band. Beyond the ends the rate is that of the end.
            let variable = |k: usize| -> Option<usize> {
                let node = i - 1 + (k / block) as isize;
                if k % block == 0 {
                    Some(node.clamp(0, n - 1) as usize * block)
                } else {
                    (node >= 0 && node <= n).then(|| node as usize * block + k % block)
                }
            };
            for r in 0..size {
                let Some(row) = variable(r) else { continue };
                right[row] -= slopes[r];
                for c in 0..=r {
                    let Some(column) = variable(c) else { continue };
                    let value = local[r * MAX_LOCAL + c];
                    if value == 0.0 {
                        continue;
                    }
                    if row == column {
                        matrix.add(row, row, if r == c { value } else { 2.0 * value });
                    } else {
                        matrix.add(row.max(column), row.min(column), value);
                    }
                }
            }
        }
        for k in 0..points.len() {
            if self.lateral == 0 {
                break;
            }
            let tube = self.tube[k];
            if tube <= 0.0 {
                for side in 0..self.lateral {
                    matrix.fix(k * block + 1 + side);
                    right[k * block + 1 + side] = 0.0;
                }
                continue;
            }
            let (foot, _) = self.course.foot(&points[k], feet[k]);
            let off = points[k] - foot;
            let scale = 2.0 / (tube * tube - off.norm_squared());
            for side in 0..self.lateral {
                let part = self.normals[k][side].dot(&off);
                right[k * block + 1 + side] -= scale * part;
                for other in 0..=side {
                    let cross = part * self.normals[k][other].dot(&off);
                    let own = if other == side { scale } else { 0.0 };
                    matrix.add(k * block + 1 + side, k * block + 1 + other, own + scale * scale * cross);
                }
            }
        }
        // The last node has no interval behind it.
        let idle = (points.len() - 1) * block;
        matrix.fix(idle);
        right[idle] = 0.0;
        for row in 0..right.len() {
            let lift = REGULAR * matrix.diagonal(row);
            matrix.add(row, row, lift);
        }
    }
}

/// A vector that is limited, and what it depends on: rates of intervals `i-1..=i+1`, nodes `i-1..=i+2`.
struct Quantity {
    value: Point,
    by_rate: [Point; 3],
    by_node: [f64; 4],
    axes: Point,
    vector: f64,
    along: (Point, f64, f64),
}

/// Four nodes with one rate and two offsets each.
const MAX_LOCAL: usize = 12;
/// Where the barrier starts, as a share of the limits.
const FEASIBLE: f64 = 0.7;
/// Newton decrement per node at which a stage ends.
const CONVERGED: f64 = 1e-3;
/// Relative lift of the diagonal.
const REGULAR: f64 = 1e-9;
