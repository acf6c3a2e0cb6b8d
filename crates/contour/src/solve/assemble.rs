//! The Gauss-Newton matrix of the optimisation and its negative gradient, from the barriers of all limited quantities.
//! Units and letters are those of [`crate::solve::problem`].

use crate::Point;
use crate::path::corridor::CorridorRow;
use crate::solve::banded::Banded;
use crate::solve::derivatives::Quantity;
use crate::solve::optimise::Weights;
use crate::solve::problem::Problem;
use crate::timing::control_points::GIVEN;
use crate::tuning::TUNING;

/// Derivatives of one number by the unknowns of five nodes.
type Row = [f64; MOST_LOCAL];

/// The part of matrix and gradient for one node.
struct Local {
    /// Number of unknowns in use.
    size: usize,
    values: [f64; MOST_LOCAL * MOST_LOCAL],
    slopes: Row,
}

impl Local {
    fn clear(&mut self) {
        self.values.fill(0.0);
        self.slopes.fill(0.0);
    }

    /// Adds the barrier of a number with this slope and curvature.
    fn add(&mut self, row: &Row, slope: f64, curvature: f64) {
        for r in 0..self.size {
            self.slopes[r] += slope * row[r];
            let weighted = curvature * row[r];
            for c in 0..=r {
                self.values[r * MOST_LOCAL + c] += weighted * row[c];
            }
        }
    }

    /// Adds all barriers of a quantity; `rows` are the derivatives of its components by axis.
    fn add_quantity(&mut self, q: &Quantity, rows: &[Row; 3]) {
        let counted = |slope: f64, curvature: f64| (slope * q.weight, curvature * q.weight);
        for axis in 0..3 {
            let inverse = q.axes[axis];
            let x = q.value[axis] * inverse;
            let slack = 1.0 - x * x;
            if inverse > 0.0 {
                let curvature = 2.0 * (1.0 + x * x) / (slack * slack) * inverse * inverse;
                let (slope, curvature) = counted(2.0 * x / slack * inverse, curvature);
                self.add(&rows[axis], slope, curvature);
            }
        }
        if q.vector > 0.0 {
            let square = q.vector * q.vector;
            let scale = 2.0 * square / (1.0 - q.value.norm_squared() * square);
            let (_, curvature) = counted(0.0, scale);
            for row in rows {
                self.add(row, 0.0, curvature);
            }
            let (slope, curvature) = counted(scale, scale * scale);
            self.add(&self.along(rows, &q.value), slope, curvature);
        }
        let (tangent, up, down) = q.along;
        if up > 0.0 {
            let x = tangent.dot(&q.value);
            let (a, b) = (up / (1.0 - x * up), down / (1.0 + x * down));
            let (slope, curvature) = counted(a - b, a * a + b * b);
            self.add(&self.along(rows, &tangent), slope, curvature);
        }
    }

    /// Derivatives of the component along a direction.
    fn along(&self, rows: &[Row; 3], direction: &Point) -> Row {
        let mut along = [0.0; MOST_LOCAL];
        for axis in 0..3 {
            for r in 0..self.size {
                along[r] += direction[axis] * rows[axis][r];
            }
        }
        along
    }
}

impl Problem<'_> {
    /// The Gauss-Newton matrix and the negative gradient.
    pub(crate) fn assemble(
        &self,
        weights: Weights,
        points: &[Point],
        spans: &[f64],
        matrix: &mut Banded,
        right: &mut [f64],
    ) {
        let block = self.block();
        matrix.clear();
        right.fill(0.0);
        for (i, &span) in spans.iter().enumerate() {
            right[i * block] -= weights.gradient * span;
            matrix.add(i * block, i * block, weights.matrix * span);
        }
        let mut local = Local {
            size: 5 * block,
            values: [0.0; MOST_LOCAL * MOST_LOCAL],
            slopes: [0.0; MOST_LOCAL],
        };
        for i in -1..=self.intervals() {
            local.clear();
            self.for_each_quantity(i, points, spans, |q| local.add_quantity(&q, &self.rows(i, &q)));
            self.scatter(i, &local, matrix, right);
        }
        if self.lateral > 0 {
            for row in &self.corridor {
                self.add_corridor(matrix, right, row, row.off(self.reference, points));
            }
        }
        self.fix_given(matrix, right);
        for row in 0..right.len() {
            let lift = TUNING.barrier.lift * matrix.diagonal(row);
            matrix.add(row, row, lift);
        }
    }

    /// Derivatives of the parts of a quantity by axis.
    #[inline]
    fn rows(&self, i: isize, q: &Quantity) -> [Row; 3] {
        let block = self.block();
        let normal = |k: usize| &self.normals[(i - 2 + k as isize).clamp(0, self.intervals()) as usize];
        let mut rows = [[0.0; MOST_LOCAL]; 3];
        for k in 0..5 {
            for axis in 0..3 {
                rows[axis][k * block] = q.by_span[k][axis];
                for side in 0..self.lateral {
                    if k > 0 {
                        rows[axis][k * block + 1 + side] = q.by_node[k - 1] * normal(k)[side][axis];
                    }
                }
            }
        }
        rows
    }

    /// Adds the part for node `i` to the band. Beyond the ends the span is that of the end.
    fn scatter(&self, i: isize, local: &Local, matrix: &mut Banded, right: &mut [f64]) {
        let (block, n) = (self.block(), self.intervals());
        let variable = |k: usize| -> Option<usize> {
            let node = i - 2 + (k / block) as isize;
            if k.is_multiple_of(block) {
                Some(node.clamp(0, n - 1) as usize * block)
            } else {
                (node >= 0 && node <= n).then(|| node as usize * block + k % block)
            }
        };
        for r in 0..local.size {
            let Some(row) = variable(r) else { continue };
            right[row] -= local.slopes[r];
            for c in 0..=r {
                let Some(column) = variable(c) else { continue };
                let value = local.values[r * MOST_LOCAL + c];
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

    /// Adds the barrier of one point of the curve.
    fn add_corridor(&self, matrix: &mut Banded, right: &mut [f64], corridor: &CorridorRow, off: Point) {
        let block = self.block();
        let scale = 2.0 / (corridor.radius * corridor.radius - off.norm_squared());
        for r in 0..4 * self.lateral {
            let (row_node, row_side) = (corridor.first + r / self.lateral, r % self.lateral);
            let weight = corridor.weights[r / self.lateral];
            if weight == 0.0 {
                continue;
            }
            let row = row_node * block + 1 + row_side;
            let row_normal = self.normals[row_node][row_side] * weight;
            let part = row_normal.dot(&off);
            right[row] -= scale * part;
            for c in 0..=r {
                let (node, side) = (corridor.first + c / self.lateral, c % self.lateral);
                let normal = self.normals[node][side] * corridor.weights[c / self.lateral];
                let value = scale * row_normal.dot(&normal) + scale * scale * part * normal.dot(&off);
                matrix.add(row, node * block + 1 + side, value);
            }
        }
    }

    /// Fixes the variables that the solver must not change: fixed nodes, spans of the running motion, and the span behind the last node.
    fn fix_given(&self, matrix: &mut Banded, right: &mut [f64]) {
        let block = self.block();
        let mut fix = |variable: usize| {
            matrix.fix(variable);
            right[variable] = 0.0;
        };
        for k in (0..self.points.len()).filter(|&k| self.fixed[k]) {
            for side in 0..self.lateral {
                fix(k * block + 1 + side);
            }
        }
        if self.continues {
            for k in 0..GIVEN {
                fix(k * block);
            }
        }
        fix((self.points.len() - 1) * block);
    }
}

/// Five nodes with one span and two offsets each.
const MOST_LOCAL: usize = 15;
