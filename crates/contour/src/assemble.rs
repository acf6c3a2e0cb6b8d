//! The Gauss-Newton matrix of the optimisation and minus its gradient, from the barriers of everything that is limited.
//! Units and letters are those of [`crate::problem`].

use crate::Point;
use crate::banded::Banded;
use crate::nodes::LEAD;
use crate::problem::Problem;
use crate::tube::TubeRow;

impl Problem<'_> {
    /// Adds the barrier of one point of the curve.
    fn add_tube(&self, matrix: &mut Banded, right: &mut [f64], tube: &TubeRow, off: Point) {
        let block = 1 + self.lateral;
        let scale = 2.0 / (tube.radius * tube.radius - off.norm_squared());
        for r in 0..4 * self.lateral {
            let (row_node, row_side) = (tube.first + r / self.lateral, r % self.lateral);
            let weight = tube.weights[r / self.lateral];
            if weight == 0.0 {
                continue;
            }
            let row = row_node * block + 1 + row_side;
            let row_normal = self.normals[row_node][row_side] * weight;
            let part = row_normal.dot(&off);
            right[row] -= scale * part;
            for c in 0..=r {
                let (node, side) = (tube.first + c / self.lateral, c % self.lateral);
                let normal = self.normals[node][side] * tube.weights[c / self.lateral];
                let value = scale * row_normal.dot(&normal) + scale * scale * part * normal.dot(&off);
                matrix.add(row, node * block + 1 + side, value);
            }
        }
    }

    /// The Gauss-Newton matrix and minus the gradient.
    pub(crate) fn assemble(&self, t: f64, points: &[Point], spans: &[f64], matrix: &mut Banded, right: &mut [f64]) {
        let block = 1 + self.lateral;
        let n = self.intervals();
        matrix.clear();
        right.fill(0.0);
        for (i, &span) in spans.iter().enumerate() {
            right[i * block] -= t * span;
            matrix.add(i * block, i * block, t * span);
        }
        let mut local = [0.0; MAX_LOCAL * MAX_LOCAL];
        let mut slopes = [0.0; MAX_LOCAL];
        let size = 5 * block;
        for i in -1..=n {
            local.fill(0.0);
            slopes.fill(0.0);
            let normal = |k: usize| &self.normals[(i - 2 + k as isize).clamp(0, n) as usize];
            self.for_each_quantity(i, points, spans, |q| {
                // Rows of the Jacobian by axis.
                let mut rows = [[0.0; MAX_LOCAL]; 3];
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
                let mut add = |row: &[f64; MAX_LOCAL], slope: f64, weight: f64| {
                    let (slope, weight) = (slope * q.weight, weight * q.weight);
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
                let node = i - 2 + (k / block) as isize;
                if k.is_multiple_of(block) {
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
        if self.lateral > 0 {
            for row in &self.tube {
                self.add_tube(matrix, right, row, row.off(self.course, points));
            }
            for k in (0..points.len()).filter(|&k| self.fixed[k]) {
                for side in 0..self.lateral {
                    matrix.fix(k * block + 1 + side);
                    right[k * block + 1 + side] = 0.0;
                }
            }
        }
        if self.led {
            for k in 0..LEAD {
                matrix.fix(k * block);
                right[k * block] = 0.0;
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

/// Five nodes with one span and two offsets each.
const MAX_LOCAL: usize = 15;
/// Relative lift of the diagonal.
const REGULAR: f64 = 1e-9;
