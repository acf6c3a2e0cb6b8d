//! Symmetric positive definite systems whose entries lie within a band about the diagonal.

use crate::tolerance::{LEAST_DIAGONAL, PIVOT_SHARE};

/// The lower half of a symmetric band matrix, row by row, `width` entries left of the diagonal.
#[derive(Clone, Debug)]
pub(crate) struct Banded {
    rows: usize,
    width: usize,
    values: Vec<f64>,
}

impl Banded {
    pub(crate) fn new(rows: usize, width: usize) -> Banded {
        Banded {
            rows,
            width,
            values: vec![0.0; rows * (width + 1)],
        }
    }

    pub(crate) fn clear(&mut self) {
        self.values.fill(0.0);
    }

    /// Adds to the entry `(row, column)`, `column <= row <= column + width`.
    pub(crate) fn add(&mut self, row: usize, column: usize, value: f64) {
        self.values[row * (self.width + 1) + self.width + column - row] += value;
    }

    pub(crate) fn diagonal(&self, row: usize) -> f64 {
        self.values[row * (self.width + 1) + self.width]
    }

    /// Removes a variable from the system: its row and column become those of the unit matrix.
    pub(crate) fn fix(&mut self, variable: usize) {
        let stride = self.width + 1;
        self.values[variable * stride..(variable + 1) * stride].fill(0.0);
        self.values[variable * stride + self.width] = 1.0;
        for row in variable + 1..(variable + stride).min(self.rows) {
            self.values[row * stride + self.width + variable - row] = 0.0;
        }
    }

    /// Solves for `right` in place by Cholesky's method, which destroys the matrix. A pivot not above `1e-14` of its diagonal is raised to that.
    pub(crate) fn solve(&mut self, right: &mut [f64]) {
        let (width, stride) = (self.width, self.width + 1);
        for row in 0..self.rows {
            let first = row.saturating_sub(width);
            let (done, rest) = self.values.split_at_mut(row * stride);
            let this = &mut rest[..stride];
            for column in first..row {
                let other = &done[column * stride..(column + 1) * stride];
                let from = first.max(column.saturating_sub(width));
                let a = &this[width + from - row..width + column - row];
                let b = &other[width + from - column..width];
                let sum: f64 = a.iter().zip(b).map(|(x, y)| x * y).sum();
                let at = width + column - row;
                this[at] = (this[at] - sum) / other[width];
            }
            let sum: f64 = this[width + first - row..width].iter().map(|x| x * x).sum();
            let diagonal = this[width];
            this[width] = (diagonal - sum)
                .max(PIVOT_SHARE * diagonal.abs().max(LEAST_DIAGONAL))
                .sqrt();
            let product: f64 = this[width + first - row..width]
                .iter()
                .zip(&right[first..row])
                .map(|(x, y)| x * y)
                .sum();
            right[row] = (right[row] - product) / this[width];
        }
        for row in (0..self.rows).rev() {
            let value = right[row] / self.values[row * stride + width];
            right[row] = value;
            let first = row.saturating_sub(width);
            let left = &self.values[row * stride + width + first - row..row * stride + width];
            for (entry, factor) in right[first..row].iter_mut().zip(left) {
                *entry -= factor * value;
            }
        }
    }
}
