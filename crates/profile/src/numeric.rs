//! Numerical methods that several crates share.

use core::convert::Infallible;

/// Halves a bracket `halvings` times. Returns the lowest value found at which the condition holds; it must not hold at `below`, hold at `above`,
/// and change once between. The condition is not evaluated at the ends, and no more when no number is left between them. `above` may be the
/// lower number: then the result is the highest value found.
///
/// The result is an end of the last bracket: the condition holds at it, and does not hold one width of that bracket further towards `below`.
#[inline]
pub fn bisect(below: f64, above: f64, halvings: usize, mut holds: impl FnMut(f64) -> bool) -> f64 {
    match try_bisect(below, above, halvings, |at| Ok::<bool, Infallible>(holds(at))) {
        Ok(found) => found,
    }
}

/// [`bisect`] with a condition that can fail; the first error ends it.
///
/// # Errors
/// The first one of the condition.
#[inline]
pub fn try_bisect<E>(
    below: f64,
    above: f64,
    halvings: usize,
    holds: impl FnMut(f64) -> Result<bool, E>,
) -> Result<f64, E> {
    halve(below, above, halvings, |below, above| 0.5 * (below + above), holds)
}

/// [`bisect`] of a factor: divides a bracket of positive numbers at their geometric mean, such that each halving takes the root of the quotient
/// of its ends.
#[inline]
pub fn bisect_factor(below: f64, above: f64, halvings: usize, mut holds: impl FnMut(f64) -> bool) -> f64 {
    let mean = |below: f64, above: f64| (below * above).sqrt();
    match halve(below, above, halvings, mean, |at| Ok::<bool, Infallible>(holds(at))) {
        Ok(found) => found,
    }
}

#[inline]
fn halve<E>(
    mut below: f64,
    mut above: f64,
    halvings: usize,
    mean: impl Fn(f64, f64) -> f64,
    mut holds: impl FnMut(f64) -> Result<bool, E>,
) -> Result<f64, E> {
    for _ in 0..halvings {
        let middle = mean(below, above);
        if middle == below || middle == above {
            break;
        }
        if holds(middle)? {
            above = middle;
        } else {
            below = middle;
        }
    }
    Ok(above)
}

/// One step of [`newton`], for its stop test.
#[derive(Clone, Copy, Debug)]
pub struct NewtonStep {
    /// The argument of the step.
    pub at: f64,
    /// The function's value at it.
    pub value: f64,
    /// The argument after a whole step, which may be outside of the bracket or no number.
    pub newton: f64,
    /// The next argument: `newton` inside the bracket, otherwise the bracket's middle.
    pub next: f64,
    /// The ends of the bracket after the step, ascending.
    pub bracket: [f64; 2],
}

impl NewtonStep {
    /// The bracket is no wider than this share of its upper end.
    #[must_use]
    #[inline]
    pub fn is_closed(&self, share: f64) -> bool {
        let [low, high] = self.bracket;
        high - low <= share * high
    }
}

/// Newton's method for the zero of a function between `below`, where it is not above 0, and `above`, where it is not below 0; either may be the
/// lower number. `f` returns the value and the derivative, and is not evaluated at the ends. Starts in the middle of the bracket.
///
/// Each step narrows the bracket to the side of the zero; a step of Newton that would leave the bracket is replaced by a halving, so a wrong or
/// vanishing derivative costs time and does no harm. `found` receives each step and returns the result when that is exact enough; without it the
/// result is the last argument after `steps` evaluations. A result that `found` takes from `at`, `next` or `bracket` lies in the bracket.
#[inline]
pub fn newton(
    mut below: f64,
    mut above: f64,
    steps: usize,
    mut f: impl FnMut(f64) -> (f64, f64),
    found: impl Fn(&NewtonStep) -> Option<f64>,
) -> f64 {
    let mut at = 0.5 * (below + above);
    for _ in 0..steps {
        let (value, slope) = f(at);
        if value < 0.0 {
            below = at;
        } else {
            above = at;
        }
        let bracket = if below <= above { [below, above] } else { [above, below] };
        let [low, high] = bracket;
        let newton = at - value / slope;
        let inside = newton > low && newton < high;
        let next = if inside { newton } else { 0.5 * (below + above) };
        if let Some(zero) = found(&NewtonStep {
            at,
            value,
            newton,
            next,
            bracket,
        }) {
            return zero;
        }
        at = next;
    }
    at
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
    fn a_bisection_ends_when_no_number_is_left_between_the_ends() {
        let mut evaluations = 0;
        let above = bisect(1.0, 1.0 + 4.0 * f64::EPSILON, 60, |at| {
            evaluations += 1;
            at > 1.0
        });
        assert_eq!((above, evaluations), (1.0 + f64::EPSILON, 2));
        assert_eq!(bisect(1.0, 1.0, 60, |_| unreachable!("no number is between")), 1.0);
    }

    #[test]
    fn a_condition_that_fails_ends_the_bisection() {
        let mut evaluations = 0;
        let refused = try_bisect(0.0, 8.0, 60, |at| {
            evaluations += 1;
            if at < 3.0 { Err(at) } else { Ok(true) }
        });
        assert_eq!((refused, evaluations), (Err(2.0), 2));
        assert_eq!(try_bisect(0.0, 8.0, 3, |at| Ok::<_, ()>(at >= 3.0)), Ok(3.0));
    }

    #[test]
    fn a_factor_is_bisected_at_geometric_means() {
        let mut tried = Vec::new();
        let factor = bisect_factor(1.0, 256.0, 3, |at| {
            tried.push(at);
            at >= 5.0
        });
        assert_eq!(tried, [16.0, 4.0, 8.0]);
        assert_eq!(factor, 8.0);
    }

    /// Stops at a bracket of two roundings, or at a step of one.
    fn exact(step: &NewtonStep) -> Option<f64> {
        let small = (step.next - step.at).abs() <= f64::EPSILON * step.at;
        (step.value == 0.0 || small || step.is_closed(2.0 * f64::EPSILON)).then_some(step.at)
    }

    #[test]
    fn newton_finds_zeros_of_rising_and_falling_functions() {
        for (why, below, above, expected, f) in [
            (
                "rising",
                0.0,
                2.0,
                core::f64::consts::SQRT_2,
                (|x| (x * x - 2.0, 2.0 * x)) as fn(f64) -> (f64, f64),
            ),
            ("falling", 2.0, 0.0, core::f64::consts::SQRT_2, |x| {
                (2.0 - x * x, -2.0 * x)
            }),
            ("a zero in the middle", 0.0, 2.0, 1.0, |x| (x - 1.0, 1.0)),
            ("a zero at the lower end", 0.0, 8.0, 0.0, |x| (x, 1.0)),
            ("no derivative", 0.0, 3.0, 1.0, |x| (x - 1.0, 0.0)),
            ("a derivative of the wrong sign", 0.0, 3.0, 1.0, |x| (x - 1.0, -1.0)),
            ("steps beyond the bracket", 0.0, 1e6, 1.0, |x| {
                (x.powi(9) - 1.0, 9.0 * x.powi(8))
            }),
            ("no derivative at the zero", -1.0, 2.0, 0.0, |x| {
                (x * x * x, 3.0 * x * x)
            }),
        ] {
            let zero = newton(below, above, 200, f, exact);
            assert!((zero - expected).abs() <= 1e-15, "{why}: {zero}");
        }
    }

    #[test]
    fn newton_stays_inside_its_bracket_and_narrows_it() {
        let tried = core::cell::RefCell::new(Vec::new());
        let f = |x: f64| (libm::atan(x - 3.0), 1.0 / (1.0 + (x - 3.0) * (x - 3.0)));
        let zero = newton(-20.0, 100.0, 60, f, |step| {
            tried.borrow_mut().push(*step);
            (step.next == step.at || step.is_closed(1e-15)).then_some(step.next)
        });
        assert!((zero - 3.0).abs() <= 1e-14, "{zero}");
        let mut before = [-20.0, 100.0];
        for step in tried.into_inner() {
            let [low, high] = step.bracket;
            assert!(
                before[0] <= low && high <= before[1] && low <= 3.0 && 3.0 <= high,
                "{step:?}"
            );
            assert!(low <= step.next && step.next <= high, "{step:?}");
            before = step.bracket;
        }
    }

    #[test]
    fn newton_returns_its_last_argument_after_the_permitted_steps() {
        let mut evaluations = 0;
        let last = newton(0.0, 4.0, 2, |x| (x * x - 2.0, 2.0 * x), |_| None);
        // 2 - 2/4 = 1.5, 1.5 - 0.25/3.
        assert!((last - 17.0 / 12.0).abs() < 1e-15, "{last}");
        let count = |x: f64| {
            evaluations += 1;
            (x, 1.0)
        };
        assert_eq!(newton(0.0, 4.0, 0, count, |_| None), 2.0, "the middle without a step");
        assert_eq!(evaluations, 0);
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
