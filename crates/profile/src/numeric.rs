//! Numerical methods that several crates share.

/// Halves a bracket `halvings` times. Returns the lowest value found at which the condition holds; it must not hold at `below`, hold at `above`,
/// and change once between. The condition is not evaluated at the ends.
pub fn bisect(mut below: f64, mut above: f64, halvings: usize, mut holds: impl FnMut(f64) -> bool) -> f64 {
    for _ in 0..halvings {
        let middle = 0.5 * (below + above);
        if holds(middle) {
            above = middle;
        } else {
            below = middle;
        }
    }
    above
}

/// The remainder of a distance by a turn: 0 to below `turn`.
pub fn modulo(distance: f64, turn: f64) -> f64 {
    let rest = distance - turn * (distance / turn).floor();
    if rest >= turn { 0.0 } else { rest }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bracket_closes_around_the_place() {
        let root = bisect(0.0, 2.0, 60, |at| at * at >= 2.0);
        assert!((root - std::f64::consts::SQRT_2).abs() <= f64::EPSILON, "{root}");
        assert_eq!(bisect(1.0, 3.0, 0, |_| true), 3.0);
        assert_eq!(bisect(3.0, 1.0, 60, |at| at <= 2.0), 2.0, "downwards");
    }

    #[test]
    fn rests_lie_within_one_turn() {
        for (distance, expected) in [
            (0.0, 0.0),
            (359.0, 359.0),
            (360.0, 0.0),
            (-1.0, 359.0),
            (-1e-20, 0.0),
            (725.0, 5.0),
        ] {
            assert_eq!(modulo(distance, 360.0), expected, "{distance}");
        }
    }
}
