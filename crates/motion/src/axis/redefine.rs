//! Where an axis counts its positions from: MRP, homing, whole turns of rotary axes.
//!
//! Shifts move nothing; the followers of an axis subtract the change of `redefined`. Not here: instructions that begin motion. Units:
//! position units.

use arcline_planner::Clock;

use super::Axis;
use crate::rotary;

impl Axis {
    /// Shifts every position so that the command is at one, to the last bit.
    pub(crate) fn redefine_command(&mut self, position: f64) {
        // What the first shift rounds off, the second one adds.
        for _ in 0..2 {
            self.redefine(position - self.command.position);
        }
    }

    /// The same for the actual position.
    pub(crate) fn redefine_actual(&mut self, position: f64) {
        for _ in 0..2 {
            self.redefine(position - self.actual.position);
        }
    }

    /// Shifts every position by an offset: command, actual, and the ends of what runs. Nothing moves.
    pub(crate) fn redefine(&mut self, offset: f64) {
        if let Some(feeding) = &mut self.feeding {
            feeding.redefine(offset);
        }
        self.sum.redefine(offset);
        self.shift(offset);
    }

    /// Folds whole turns of a rotary axis away where what is shown stays the same: at rest, and in an endless jog.
    pub(crate) fn fold(&mut self, clock: &Clock) {
        // What is fed is of the nearest turn by itself.
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

    /// The axis goes along with a command whose positions were shifted; the drive knows nothing of it.
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
