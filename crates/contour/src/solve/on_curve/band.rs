//! Symmetric positive definite systems with four entries to either side of the diagonal.

use crate::tolerance::{LEAST_DIAGONAL, PIVOT_SHARE};

/// The lower half of the matrix row by row: the diagonal, then the entries to its left, the nearest first.
#[derive(Clone, Debug)]
pub(crate) struct Band {
    rows: Vec<[f64; 5]>,
    /// The reciprocal of each pivot.
    inverse: Vec<f64>,
}

impl Band {
    pub(crate) fn new(rows: usize) -> Band {
        Band {
            rows: vec![[0.0; 5]; rows],
            inverse: vec![0.0; rows],
        }
    }

    pub(crate) fn clear(&mut self) {
        self.rows.fill([0.0; 5]);
    }

    /// The entries of a row, the diagonal first.
    #[inline(always)]
    pub(crate) fn row(&mut self, row: usize) -> &mut [f64; 5] {
        &mut self.rows[row]
    }

    /// Removes a variable from the system: its row and column become those of the unit matrix.
    pub(crate) fn fix(&mut self, variable: usize) {
        self.rows[variable] = [1.0, 0.0, 0.0, 0.0, 0.0];
        for left in 1..5 {
            if let Some(row) = self.rows.get_mut(variable + left) {
                row[left] = 0.0;
            }
        }
    }

    /// Increases the diagonal by a share of itself.
    pub(crate) fn lift(&mut self, share: f64) {
        for row in &mut self.rows {
            row[0] *= 1.0 + share;
        }
    }

    /// Solves for `right` in place by Cholesky's method without roots, which destroys the matrix. A pivot not above `1e-14` of its diagonal is
    /// raised to that.
    pub(crate) fn solve(&mut self, right: &mut [f64]) {
        // The last four rows, their inverse pivots and their right sides; zeros before the first row.
        let mut l: [[f64; 5]; 4] = [[0.0; 5]; 4];
        let mut p = [0.0; 4];
        let mut y = [0.0; 4];
        for (i, row) in self.rows.iter_mut().enumerate() {
            let [diagonal, b1, b2, b3, b4] = *row;
            // `l[0]` is the previous row.
            let t4 = b4;
            let t3 = b3 - t4 * l[2][1];
            let t2 = b2 - t4 * l[1][2] - t3 * l[1][1];
            let t1 = b1 - t4 * l[0][3] - t3 * l[0][2] - t2 * l[0][1];
            let (l1, l2, l3, l4) = (t1 * p[0], t2 * p[1], t3 * p[2], t4 * p[3]);
            let pivot = diagonal - (t1 * l1 + t2 * l2) - (t3 * l3 + t4 * l4);
            let pivot = pivot.max(PIVOT_SHARE * diagonal.abs().max(LEAST_DIAGONAL));
            let inverse = 1.0 / pivot;
            *row = [pivot, l1, l2, l3, l4];
            self.inverse[i] = inverse;
            let value = right[i] - (l4 * y[3] + l3 * y[2]) - (l2 * y[1] + l1 * y[0]);
            right[i] = value;
            l = [*row, l[0], l[1], l[2]];
            p = [inverse, p[0], p[1], p[2]];
            y = [value, y[0], y[1], y[2]];
        }
        for (value, inverse) in right.iter_mut().zip(&self.inverse) {
            *value *= inverse;
        }
        for i in (0..self.rows.len()).rev() {
            let value = right[i];
            for left in 1..=i.min(4) {
                right[i - left] -= value * self.rows[i][left];
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_solution_satisfies_the_system() {
        let count = 23;
        let entry = |row: usize, left: usize| {
            if left == 0 {
                9.0 + (row % 5) as f64
            } else {
                libm::sin((3 * row + 7 * left) as f64)
            }
        };
        let mut band = Band::new(count);
        for row in 0..count {
            for left in 0..=row.min(4) {
                band.row(row)[left] = entry(row, left);
            }
        }
        let right: Vec<f64> = (0..count).map(|row| libm::cos(row as f64)).collect();
        let mut x = right.clone();
        band.solve(&mut x);
        for row in 0..count {
            let mut sum = 0.0;
            for column in row.saturating_sub(4)..(row + 5).min(count) {
                sum += entry(row.max(column), row.abs_diff(column)) * x[column];
            }
            assert!((sum - right[row]).abs() < 1e-12, "row {row}");
        }
    }
}
