//! A value between the beginning and the end of an update: it changes monotonically, and with the given rates at both ends if possible.
//!
//! A cubic through both ends, with slopes limited such that it is monotonic; under constant acceleration it is the exact parabola of
//! the axis. Shares of an update are 0 at its beginning and 1 at its end.

use arcline_profile::numeric::bisect;

/// Halvings of a share down to the last bit.
const HALVINGS: usize = 54;
/// A cubic is monotonic with slopes up to this multiple of the mean one: the radius of the circle of Fritsch and Carlson.
const STEEPEST: f64 = 3.0;

/// A value over one update.
#[derive(Clone, Copy, Debug)]
pub(super) struct Interpolation {
    pub(super) from: f64,
    pub(super) to: f64,
    /// Slopes at both ends, per update.
    slopes: [f64; 2],
}

impl Interpolation {
    /// Between two values with their rates, units/s, over `period` seconds.
    pub(super) fn new(from: [f64; 2], to: [f64; 2], period: f64) -> Self {
        let displacement = to[0] - from[0];
        let mut slopes = [from[1], to[1]].map(|rate| {
            let slope = rate * period;
            if slope * displacement > 0.0 { slope } else { 0.0 }
        });
        let steep = (slopes[0] * slopes[0] + slopes[1] * slopes[1]).sqrt();
        let most = STEEPEST * displacement.abs();
        if steep > most {
            slopes = slopes.map(|slope| slope * most / steep);
        }
        Interpolation {
            from: from[0],
            to: to[0],
            slopes,
        }
    }

    /// A step: the share is that of the displacement.
    pub(super) fn step(from: f64, to: f64) -> Self {
        Interpolation {
            from,
            to,
            slopes: [to - from; 2],
        }
    }

    /// The value at a share of the update.
    pub(super) fn at(&self, share: f64) -> f64 {
        if share >= 1.0 {
            return self.to;
        }
        let rest = share - 1.0;
        let displacement = self.to - self.from;
        self.from
            + displacement * share * share * (3.0 - 2.0 * share)
            + share * rest * (self.slopes[0] * rest + self.slopes[1] * share)
    }

    /// The share at which the value reaches one between its ends.
    pub(super) fn share_of(&self, value: f64) -> f64 {
        let sign = if self.to >= self.from { 1.0 } else { -1.0 };
        bisect(0.0, 1.0, HALVINGS, |share| sign * (self.at(share) - value) >= 0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_constant_acceleration_is_met_to_the_last_digits() {
        let (period, rate, acceleration) = (0.004, 30.0, -2000.0);
        let position = |time: f64| 5.0 + rate * time + 0.5 * acceleration * time * time;
        let end = [position(period), rate + acceleration * period];
        let interpolation = Interpolation::new([5.0, rate], end, period);
        for step in 0..=8 {
            let share = f64::from(step) / 8.0;
            let value = position(share * period);
            assert!((interpolation.at(share) - value).abs() < 1e-12, "{share}");
            assert!((interpolation.share_of(value) - share).abs() < 1e-9, "{share}");
        }
    }

    #[test]
    fn it_does_not_turn_round() {
        #[rustfmt::skip]
        let cases = [
            // why,                    from,         to
            ("a sudden stop",          [0.0, 100.0], [0.0, 0.0]),
            ("a jump without speed",   [0.0, 0.0],   [9.0, 0.0]),
            ("far too fast",           [0.0, 9e3],   [1.0, 9e3]),
            ("against its speed",      [0.0, -50.0], [0.1, -50.0]),
            ("back",                   [1.0, -80.0], [0.5, 30.0]),
        ];
        for (why, from, to) in cases {
            let interpolation = Interpolation::new(from, to, 0.001);
            let sign = (to[0] - from[0]).signum();
            let values: Vec<f64> = (0..=100)
                .map(|step| interpolation.at(f64::from(step) / 100.0))
                .collect();
            let falls = values.windows(2).any(|pair| sign * (pair[1] - pair[0]) < -1e-12);
            assert!(!falls, "{why}: {values:?}");
            assert_eq!((values[0], values[100]), (from[0], to[0]), "{why}");
        }
    }
}
