//! AverageVelocity: the displacement of an axis within the Average Velocity Timebase (spec/axis-and-data-types.md §9.1).
//!
//! Units: position units, seconds. Nothing allocates after [`Average::new`].

/// The actual positions of one timebase.
#[derive(Clone, Debug)]
pub(crate) struct Average {
    positions: Box<[f64]>,
    /// The oldest of them.
    next: usize,
    /// Length of the timebase in whole updates, seconds.
    timebase: f64,
    /// Displacement of the axis within the timebase.
    displacement: f64,
    /// Consecutive updates with the same position.
    unchanged: usize,
}

impl Average {
    /// At rest at a position. The timebase is rounded to whole updates, at least one.
    pub(crate) fn new(position: f64, timebase: f64, period: f64) -> Self {
        let updates = (timebase / period).round().max(1.0);
        Average {
            positions: vec![position; updates as usize].into_boxed_slice(),
            next: 0,
            timebase: updates * period,
            displacement: 0.0,
            unchanged: 0,
        }
    }

    /// Takes the position of the next update. Real-time.
    pub(crate) fn take(&mut self, position: f64) {
        let newest = self.next.checked_sub(1).unwrap_or(self.positions.len() - 1);
        let is_same = self.positions.get(newest) == Some(&position);
        self.unchanged = if is_same { self.unchanged.saturating_add(1) } else { 0 };
        if let Some(oldest) = self.positions.get_mut(self.next) {
            self.displacement = position - std::mem::replace(oldest, position);
            self.next += 1;
            if self.next == self.positions.len() {
                self.next = 0;
            }
        }
    }

    /// Units/s. The division is done only where the velocity is read.
    pub(crate) fn velocity(&self) -> f64 {
        self.displacement / self.timebase
    }

    /// All positions are the same: another one like them changes nothing.
    pub(crate) fn is_steady(&self) -> bool {
        self.unchanged >= self.positions.len()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_step_of_velocity_is_a_ramp_over_the_timebase() {
        for period in [0.001, 0.005, 0.05] {
            let mut average = Average::new(3.0, 0.25, period);
            let mut updates = 0.0;
            while updates * period < 0.5 {
                updates += 1.0;
                average.take(3.0 + 10.0 * updates * period);
                let expected = 10.0 * (updates * period / 0.25).min(1.0);
                assert!((average.velocity() - expected).abs() < 1e-9, "{period} {updates}");
            }
        }
    }
}
