//! Cubics with one decaying exponential: the form of a servo's error, speed and torque between two switches of its limits; and the first
//! instant at which one rises above 0.
//!
//! Not here: the quantities of the curves. Units: seconds and the unit of the quantity.

/// `c0 + c1 t + c2 t² + c3 t³ + d exp(-k t)`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Curve {
    pub(crate) c: [f64; 4],
    pub(crate) d: f64,
    pub(crate) k: f64,
}

/// Instants that divide a span into pieces on which a curve is monotone: its ends, and the changes of sign of its slope.
/// The third derivative is monotone, so the curve has at most 4 zeros and its slope 3; one entry is spare.
#[derive(Clone, Copy)]
struct Cuts {
    at: [f64; 6],
    count: usize,
}

/// Steps to enclose a zero; each at least halves the bracket.
const STEPS: u32 = 64;

impl Curve {
    pub(crate) fn at(&self, t: f64) -> f64 {
        let [c0, c1, c2, c3] = self.c;
        let cubic = c0 + t * (c1 + t * (c2 + t * c3));
        if self.d == 0.0 {
            cubic
        } else {
            cubic + self.d * libm::exp(-self.k * t)
        }
    }

    pub(crate) fn slope(&self) -> Curve {
        let [_, c1, c2, c3] = self.c;
        Curve {
            c: [c1, 2.0 * c2, 3.0 * c3, 0.0],
            d: -self.k * self.d,
            k: self.k,
        }
    }

    /// `sign · curve - level`.
    pub(crate) fn above(&self, sign: f64, level: f64) -> Curve {
        let [c0, c1, c2, c3] = self.c;
        Curve {
            c: [sign * c0 - level, sign * c1, sign * c2, sign * c3],
            d: sign * self.d,
            k: self.k,
        }
    }

    /// A curve without exponential minus another one.
    pub(crate) fn minus(&self, other: &Curve) -> Curve {
        let [a0, a1, a2, a3] = self.c;
        let [b0, b1, b2, b3] = other.c;
        Curve {
            c: [a0 - b0, a1 - b1, a2 - b2, a3 - b3],
            d: -other.d,
            k: other.k,
        }
    }

    /// The first instant from 0 to `until` at which the curve is above 0, or rises above it. Bounded.
    pub(crate) fn first_above(&self, until: f64) -> Option<f64> {
        let [_, c1, c2, c3] = self.c.map(|c| c.max(0.0));
        if self.c[0] + until * (c1 + until * (c2 + until * c3)) + self.d.max(0.0) <= 0.0 {
            return None;
        }
        if self.at(0.0) > 0.0 {
            return Some(0.0);
        }
        let cuts = self.slope().cuts(until);
        let mut left = 0.0;
        for right in cuts.at.into_iter().take(cuts.count).skip(1) {
            if self.at(right) > 0.0 {
                return Some(self.zero(left, right, true));
            }
            left = right;
        }
        None
    }

    /// 0, the instants at which this curve changes its sign, and `until`.
    fn cuts(&self, until: f64) -> Cuts {
        let first = self.slope();
        let second = first.slope();
        let mut cuts = Cuts {
            at: [0.0, until, 0.0, 0.0, 0.0, 0.0],
            count: 2,
        };
        for curve in [&second, &first, self] {
            cuts = curve.refine(&cuts);
        }
        cuts
    }

    /// The ends of a span and the zeros between them, from instants between which the curve is monotone.
    fn refine(&self, monotone: &Cuts) -> Cuts {
        let mut zeros = Cuts { at: [0.0; 6], count: 1 };
        let mut left = 0.0;
        let mut at_left = self.at(0.0);
        for right in monotone.at.into_iter().take(monotone.count).skip(1) {
            let at_right = self.at(right);
            if at_left * at_right < 0.0 {
                zeros.push(self.zero(left, right, at_right > 0.0));
            }
            (left, at_left) = (right, at_right);
        }
        zeros.push(left);
        zeros
    }

    /// The zero between two instants with opposite signs on a monotone piece: Newton's steps, each with a halving.
    ///
    /// Its own loop beside [`arcline_profile::numeric::newton`], as each step divides the bracket twice: at its own instant and in the
    /// middle.
    fn zero(&self, mut left: f64, mut right: f64, rises: bool) -> f64 {
        let slope = self.slope();
        let mut t = 0.5 * (left + right);
        for _ in 0..STEPS {
            let value = self.at(t);
            let newton = t - value / slope.at(t);
            if (newton - t).abs() <= f64::EPSILON * right {
                return newton;
            }
            for t in [t, 0.5 * (left + right)] {
                if left < t && t < right {
                    if (self.at(t) > 0.0) == rises {
                        right = t;
                    } else {
                        left = t;
                    }
                }
            }
            t = if left < newton && newton < right {
                newton
            } else {
                0.5 * (left + right)
            };
        }
        t
    }
}

impl Cuts {
    fn push(&mut self, t: f64) {
        if let Some(zero) = self.at.get_mut(self.count) {
            *zero = t;
            self.count += 1;
        }
    }
}
