//! Starts that are outside the limits: from rest everything takes longer; a motion under way is started with wider limits
//! that close in from step to step, as the tube does.

use crate::Point;
use crate::nodes::LEAD;
use crate::problem::Problem;

impl Problem<'_> {
    /// Lengthens all spans until every limit is kept with room to spare.
    pub(crate) fn make_feasible(&mut self) {
        if self.led {
            // A motion under way cannot be slowed down as a whole: the limits give way instead, and close in.
            self.slow_down();
            self.ease = vec![[0.0; 3]; self.points.len() + 1];
            return;
        }
        for _ in 0..200 {
            if self.worst() < FEASIBLE {
                return;
            }
            for rate in &mut self.spans {
                *rate *= 1.2;
            }
        }
    }

    /// Lengthens the spans behind the given beginning, gradually, where most of what comes there is far from its limits.
    fn slow_down(&mut self) {
        let (mut most, mut far) = (0.0_f64, 0);
        for i in self.kept as isize..=self.intervals() {
            let [speed, acceleration, jerk] = self.quotients(i, &self.points, &self.spans);
            let factor = speed.max(acceleration.sqrt()).max(libm::cbrt(jerk));
            most = most.max(factor);
            far += usize::from(factor > FAR);
        }
        if 2 * far < self.points.len() - self.kept {
            return;
        }
        for (k, span) in self.spans.iter_mut().enumerate().skip(self.kept) {
            let u = ((k - self.kept) as f64 / RAMP).min(1.0);
            *span *= 1.0 + (most / FEASIBLE - 1.0) * u * u * (3.0 - 2.0 * u);
        }
    }

    /// The largest quotient of a quantity and its limit.
    fn worst(&self) -> f64 {
        let here = |i| self.quotients(i, &self.points, &self.spans);
        (-1..=self.intervals()).flat_map(here).fold(0.0, f64::max)
    }

    /// The largest quotients at one node.
    fn quotients(&self, i: isize, points: &[Point], spans: &[f64]) -> [f64; 3] {
        let mut worst = [0.0_f64; 3];
        self.for_each_quantity(i, points, spans, |q| {
            let most = &mut worst[q.kind];
            for axis in 0..3 {
                *most = most.max((q.value[axis] * q.axes[axis]).abs());
            }
            *most = most.max(q.value.norm() * q.vector);
            let along = q.along.0.dot(&q.value);
            *most = most.max(along * q.along.1).max(-along * q.along.2);
        });
        worst
    }

    /// Closes eased limits in, as [`Problem::narrow`] does with the tube.
    pub(crate) fn tighten(&mut self, points: &[Point], spans: &[f64]) -> bool {
        if !self.ease.iter().flatten().any(|&ease| ease < 1.0) {
            return false;
        }
        let mut ease = core::mem::take(&mut self.ease);
        for (place, ease) in ease.iter_mut().enumerate() {
            // Without `self.ease` the limits are the full ones.
            let worst = self.quotients(place as isize - 1, points, spans);
            for (kind, ease) in ease.iter_mut().enumerate().filter(|(_, ease)| **ease < 1.0) {
                let off = worst[kind];
                let slack = match off {
                    _ if *ease > 0.0 => (0.5 * (1.0 / *ease - off)).max(LEAST_WIDTH * off),
                    _ if off < INSIDE => 0.0,
                    _ if off < 1.0 + LEAST_WIDTH => LEAST_WIDTH * off,
                    _ => WIDEN_LIMIT * off,
                };
                *ease = (1.0 / (off + slack).max(1.0)).max(*ease);
            }
        }
        self.ease = ease;
        true
    }

    pub(crate) fn is_eased(&self) -> bool {
        let full = |place: usize| if place < LEAD + 2 { NEAR_FULL } else { 1.0 };
        let mut eased = self.ease.iter().enumerate();
        eased.any(|(place, ease)| ease.iter().any(|&ease| ease < full(place)))
    }
}

/// A quotient up to which a limit is kept with room to spare.
const INSIDE: f64 = 1.0 - 1e-5;
/// How much more a limit counts while it is eased: so that it is not where the others push to.
pub(crate) const EASED: f64 = 30.0;
/// How much too fast a start is slowed down, and within how many nodes.
const FAR: f64 = 1.5;
const RAMP: f64 = 80.0;
/// What counts as a full limit where a motion is continued: next to it the hull of the spline is a little wider than
/// the motion itself, which is measured when it is done.
const NEAR_FULL: f64 = 0.9995;
/// Further steps in which limits that were eased close in, in each stage.
pub(crate) const MOST_CLOSING: usize = 24;
/// Room that a limit which is exceeded is given, and the least of it, as shares of the quotient.
const WIDEN_LIMIT: f64 = 0.3;
const LEAST_WIDTH: f64 = 1e-3;
/// Where the barrier starts, as a share of the limits.
const FEASIBLE: f64 = 0.7;
