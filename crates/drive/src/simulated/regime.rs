//! A servo loop within limits of speed and torque, solved exactly between one switch of its regime and the next.
//!
//! Let `w` be the velocity of the loop, cut to the speed limit. The axis has this velocity, `x' = w`, while its torque suffices; otherwise it
//! accelerates towards it at the full torque, until it reaches it. In each regime the following error and the velocity are [`Curve`]s, and the
//! end of the regime is a curve that rises above 0, so the instant of the switch is found on the exact solution and does not depend on the
//! update period.
//!
//! Not here: the motion over a period without limits ([`crate::servo`]). Units: position units, seconds.

use super::curve::Curve;
use super::servo::Velocity;
use super::tolerance::{SPEED_MARGIN_SHARE, TERM_SHARE, TORQUE_MARGIN_SHARE};

/// A position loop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Loop {
    /// 1/s.
    pub(crate) gain: f64,
    /// Share of the command velocity.
    pub(crate) feedforward: f64,
}

/// The limits of a drive, more than 0; infinite for no limit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct DriveLimits {
    /// Units/s.
    pub(crate) speed: f64,
    /// Units/s².
    pub(crate) torque: f64,
}

/// The quantity that determines the velocity of the axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Regime {
    /// The loop: the axis has the velocity of the loop.
    Linear,
    /// The speed limit, with its direction.
    Speed(f64),
    /// The torque limit, with its direction: the velocity approaches that of the loop.
    Torque(f64),
}

/// The axis at an instant, and the command from there on.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LoopState {
    pub(crate) error: f64,
    pub(crate) velocity: f64,
    pub(crate) regime: Regime,
    pub(crate) command: Velocity,
}

/// Error and velocities in a regime, from its beginning on.
struct RegimeCurves {
    error: Curve,
    asked: Curve,
    velocity: Curve,
}

/// Most switches within one period. A torque limit that lets the axis oscillate causes about `sqrt(K · period / 2)` of them: 32 at the longest
/// period and the highest bandwidth. The last regime holds for the rest of the period.
pub(crate) const MAX_SWITCHES: usize = 64;

impl Loop {
    /// `p0 + p1 t + p2 t²`: the following error by the command alone, without the decaying part.
    pub(crate) fn particular(&self, velocity: &Velocity) -> [f64; 3] {
        let [c0, c1, c2] = velocity.c;
        let g = 1.0 - self.feedforward;
        let k = self.gain;
        let p2 = g * c2 / k;
        let p1 = (g * c1 - 2.0 * p2) / k;
        let p0 = (g * c0 - p1) / k;
        [p0, p1, p2]
    }

    /// The velocity of the loop.
    fn asked(&self, error: &Curve, command: &Velocity) -> Curve {
        let [c0, c1, c2] = command.c;
        let [e0, e1, e2, e3] = error.c;
        let (k, f) = (self.gain, self.feedforward);
        Curve {
            c: [k * e0 + f * c0, k * e1 + f * c1, k * e2 + f * c2, k * e3],
            d: k * error.d,
            k: error.k,
        }
    }
}

impl DriveLimits {
    /// The regime of an axis whose velocity differs from that of the loop.
    pub(crate) fn regime_at(&self, asked: f64, velocity: f64) -> Regime {
        let wanted = asked.clamp(-self.speed, self.speed);
        if self.torque.is_finite() && wanted != velocity {
            Regime::Torque((wanted - velocity).signum() * self.torque)
        } else if wanted != asked {
            Regime::Speed(wanted)
        } else {
            Regime::Linear
        }
    }
}

impl LoopState {
    /// The state after a span of time, and the part of the span for which its regime has lasted. Bounded.
    pub(crate) fn after(mut self, control: &Loop, limits: &DriveLimits, span: f64) -> (LoopState, f64) {
        let mut left = span;
        for _ in 0..MAX_SWITCHES {
            let curves = self.curves(control);
            let Some(end) = self.end(&curves, control, limits, left) else {
                break;
            };
            self.advance(&curves, limits, end);
            left = (left - end).max(0.0);
            self.switch(control, limits);
        }
        let curves = self.curves(control);
        self.advance(&curves, limits, left);
        (self, left)
    }

    fn curves(&self, control: &Loop) -> RegimeCurves {
        let (error, velocity) = match self.regime {
            Regime::Linear => {
                let [p0, p1, p2] = control.particular(&self.command);
                let error = Curve {
                    c: [p0, p1, p2, 0.0],
                    d: self.error - p0,
                    k: control.gain,
                };
                (error, control.asked(&error, &self.command))
            }
            Regime::Speed(velocity) => (self.behind(velocity, 0.0), cubic([velocity, 0.0, 0.0, 0.0])),
            Regime::Torque(rate) => (self.behind(self.velocity, rate), cubic([self.velocity, rate, 0.0, 0.0])),
        };
        RegimeCurves {
            error,
            asked: control.asked(&error, &self.command),
            velocity,
        }
    }

    /// The following error at a velocity that changes at a constant rate.
    fn behind(&self, velocity: f64, rate: f64) -> Curve {
        let [c0, c1, c2] = self.command.c;
        cubic([self.error, c0 - velocity, 0.5 * (c1 - rate), c2 / 3.0])
    }

    /// The instant of the regime's end, if it is within a span.
    fn end(&self, curves: &RegimeCurves, control: &Loop, limits: &DriveLimits, span: f64) -> Option<f64> {
        let mut first = None;
        let mut ends = |curve: Curve| {
            first = curve.first_above(first.unwrap_or(span)).or(first);
        };
        match self.regime {
            Regime::Linear => {
                let rate = curves.asked.slope();
                let [speed, torque] = self.margins(control, limits);
                for sign in [1.0, -1.0] {
                    ends(curves.asked.above(sign, limits.speed + speed));
                    ends(rate.above(sign, limits.torque + torque));
                }
            }
            Regime::Speed(velocity) => ends(curves.asked.above(-velocity.signum(), -limits.speed)),
            Regime::Torque(rate) => {
                ends(curves.velocity.minus(&curves.asked).above(rate.signum(), 0.0));
                ends(curves.velocity.above(rate.signum(), limits.speed));
            }
        }
        first
    }

    /// The excess of the loop over the limits of speed and torque up to which it is not limited.
    fn margins(&self, control: &Loop, limits: &DriveLimits) -> [f64; 2] {
        let [c0, c1, c2] = self.command.c.map(f64::abs);
        let k = control.gain;
        let speed = k * self.error.abs() + c0 + (c1 + c2 / k) / k;
        [
            SPEED_MARGIN_SHARE * limits.speed + TERM_SHARE * speed,
            TORQUE_MARGIN_SHARE * limits.torque + TERM_SHARE * k * speed,
        ]
    }

    fn advance(&mut self, curves: &RegimeCurves, limits: &DriveLimits, span: f64) {
        self.error = curves.error.at(span);
        self.velocity = curves.velocity.at(span).clamp(-limits.speed, limits.speed);
        self.command = self.command.from(span);
    }

    /// Determines the next regime. The axis has just reached the velocity of the loop, or is about to deviate from it.
    fn switch(&mut self, control: &Loop, limits: &DriveLimits) {
        let [c0, c1, _] = self.command.c;
        let asked = control.gain * self.error + control.feedforward * c0;
        let rate = control.gain * (c0 - self.velocity) + control.feedforward * c1;
        let [speed, torque] = self.margins(control, limits);
        let outward = asked.abs() - limits.speed;
        if outward > 2.0 * speed || (outward.abs() <= 2.0 * speed && outward.is_finite() && rate * asked >= 0.0) {
            self.velocity = limits.speed.copysign(asked);
            self.regime = Regime::Speed(self.velocity);
            return;
        }
        // Exactly the velocity of the loop, so that rounding does not end a torque limit at once.
        self.velocity = asked;
        self.regime = if rate.abs() > limits.torque + 0.5 * torque {
            Regime::Torque(limits.torque.copysign(rate))
        } else {
            Regime::Linear
        };
    }
}

fn cubic(c: [f64; 4]) -> Curve {
    Curve { c, d: 0.0, k: 0.0 }
}
