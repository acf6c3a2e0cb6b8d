//! Ranges of operands: error 13 (spec/coordinated-instructions.md §4.6, §12.3, §13.7, §14.3;
//! spec/axis-and-data-types.md §7.2).
//!
//! Not here: checks that depend on the state of the machine, such as positions beyond the unwind, or units that
//! do not go together (94, 95).

use crate::enumerations::NoYes;
use crate::instruction::{ArrayRule, Condition, Instruction, Kind, Operand, Range};
use crate::{Argument, Call, OperandIndex};

impl Instruction {
    /// Finds the first operand out of range, in faceplate order. `axes` is the number of primary axes of the
    /// coordinate system; for axes and groups it does not matter.
    ///
    /// Real-time: no allocation; bounded by the operands of one faceplate.
    ///
    /// # Errors
    /// The position of the operand, the EXERR of error 13.
    pub fn verify(&self, call: &Call, axes: usize) -> Result<(), OperandIndex> {
        if !self.axes.range().contains(&axes) {
            return Err(OperandIndex(0));
        }
        for (place, operand) in self.operands.iter().enumerate() {
            if !operand.accepts(call, place, axes) {
                return Err(OperandIndex(place as u8));
            }
        }
        Ok(())
    }
}

impl Operand {
    /// Whether the call's argument at `place` is in range.
    fn accepts(&self, call: &Call, place: usize, axes: usize) -> bool {
        let applies = match self.condition {
            Condition::Always => true,
            Condition::Changed(flag) if call.word(usize::from(flag)) != NoYes::Yes as i32 => return true,
            Condition::Changed(_) => true,
            Condition::When { operand, value } => call.word(usize::from(operand)) == value,
        };
        match &self.kind {
            // Names were resolved when the call was bound.
            Kind::Target(_) | Kind::MotionControl | Kind::Object(_) | Kind::Structure(_) | Kind::StructureOrNone(_) => {
                true
            }
            Kind::Word(words) => match as_dint(call.number(place)) {
                Some(value) => words.contains(value),
                None => false,
            },
            Kind::Number(range) => {
                let number = call.number(place);
                number.is_finite() && (!applies || range.contains(number, call))
            }
            Kind::Integer(range) => match as_dint(call.number(place)) {
                Some(value) => !applies || range.contains(f64::from(value), call),
                None => false,
            },
            Kind::Array(rule) => {
                let least = rule.least(call, axes);
                let array = call.array(place);
                array.len() >= least && array[..least].iter().all(|number| Range::Any.holds(*number))
            }
            Kind::ArrayOrNone => call.array(place).iter().all(|number| Range::Any.holds(*number)),
            Kind::WrittenArray(_) => {
                matches!(call.argument(place), Argument::None | Argument::Written(_))
            }
        }
    }
}

impl Range {
    /// Whether a number is legal; `call` has the units of a jerk. Real-time.
    pub fn contains(self, number: f64, call: &Call) -> bool {
        self.holds(number)
            && match self {
                Self::Jerk { units } => {
                    let percent_of_time = Range::PERCENT_OF_TIME.contains(&call.word(usize::from(units)));
                    !percent_of_time || number <= 100.0
                }
                _ => true,
            }
    }

    /// Whether a number is legal in any units. No magnitude is above 1e15, and no speed, rate, jerk or scaling
    /// but 0 below 1e-15: all that is calculated from them is finite. Real-time.
    pub fn holds(self, number: f64) -> bool {
        let positive = || (SMALLEST..=LARGEST).contains(&number);
        match self {
            Self::Any => number.abs() <= LARGEST,
            Self::NotNegative => number == 0.0 || positive(),
            Self::Positive | Self::Jerk { .. } => positive(),
            Self::Between(low, high) => (low..=high).contains(&number),
        }
    }
}

impl ArrayRule {
    /// Elements that must be there. Real-time.
    pub fn least(self, call: &Call, axes: usize) -> usize {
        match self {
            Self::PerAxis => axes,
            Self::PerAxisUnless { operand, value } if call.word(usize::from(operand)) == value => 1,
            Self::PerAxisUnless { .. } => axes,
            Self::AtLeast(least) => usize::from(least),
        }
    }
}

/// The largest magnitude of a number.
const LARGEST: f64 = 1e15;
/// The smallest speed, rate, jerk or scaling above 0.
const SMALLEST: f64 = 1e-15;

/// Rounds half to even; `None` for NaN, an infinity, or a number beyond a DINT.
fn as_dint(number: f64) -> Option<i32> {
    let rounded = number.round_ties_even();
    (f64::from(i32::MIN)..=f64::from(i32::MAX))
        .contains(&rounded)
        .then_some(rounded as i32)
}
