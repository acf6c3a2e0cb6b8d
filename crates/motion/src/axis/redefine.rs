//! Redefined positions of an axis: MRP, homing, whole turns of rotary axes.
//!
//! Shifts move nothing; the followers of an axis subtract the change of `redefined`. Not here: instructions that begin motion. Units:
//! position units.

use arcline_planner::Clock;

use super::Axis;
use crate::rotary;

impl Axis {
    /// Shifts every position such that the command is exactly `position`, to the last bit.
    pub(crate) fn redefine_command(&mut self, position: f64) {
        // The second shift corrects the rounding of the first.
        for _ in 0..2 {
            self.redefine(position - self.command.position);
        }
    }

    /// Redefines the actual position.
    pub(crate) fn redefine_actual(&mut self, position: f64) {
        for _ in 0..2 {
            self.redefine(position - self.actual.position);
        }
    }

    /// Shifts every position by an offset: command, actual, and the ends of generators under way. The axis does not move.
    pub(crate) fn redefine(&mut self, offset: f64) {
        if let Some(feeding) = &mut self.feeding {
            feeding.redefine(offset);
        }
        self.sum.redefine(offset);
        self.shift(offset);
    }

    /// Removes whole turns of a rotary axis when the shown position stays the same: at rest, and in an endless jog.
    pub(crate) fn fold(&mut self, clock: &Clock) {
        // A position from a tag is on the nearest turn already.
        let Some(unwind) = self.unwind.filter(|_| self.feeding.is_none()) else {
            return;
        };
        let offset = if self.sum.is_idle() {
            let position = self.command.position;
            let shown = rotary::shown(position, unwind);
            if shown != position {
                self.sum.set_position(shown);
            }
            shown - position
        } else {
            self.sum.fold_jog(unwind, clock)
        };
        if offset != 0.0 {
            self.shift(offset);
        }
    }

    /// Takes over the shifted command and shifts the actual position with it; the drive does not take part.
    pub(super) fn shift(&mut self, offset: f64) {
        self.command = self.sum.command();
        self.redefined += offset;
        if self.has_drive() {
            self.update_actual();
        } else {
            self.actual.position += offset;
        }
        self.faults.redefined(self.actual.position);
    }

    /// A position as the axis shows it: rotary ones within one turn.
    pub(crate) fn shown(&self, position: f64) -> f64 {
        match self.unwind {
            Some(unwind) => rotary::shown(position, unwind),
            None => position,
        }
    }
}
