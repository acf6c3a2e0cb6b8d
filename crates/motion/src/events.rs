//! Event Distance and Calculated Data: the times at which a move reaches given distances before its end (spec/coordinated-instructions.md
//! §9, the reference page MCCD).
//!
//! Times and master distances count from the start of the move, whatever has changed since. A distance that the move passed before a change
//! keeps its answer. Not here: the tick at which answers are due, and the memory of the arrays. Nothing allocates.

use arcline_instruction_set::operands::EventOperands;
use arcline_instruction_set::{MAX_ELEMENTS, MotionError, RealArray, TagAddress, WrittenArray};
use arcline_planner::profile::Profile;
use arcline_planner::{Clock, EventTime, Instant};

/// A write of an instruction to a tag.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InstructionWrite {
    /// The tick.
    pub tick: u64,
    /// The tag, by its address in the directory.
    pub tag: TagAddress,
    /// The values.
    pub values: WrittenValues,
}

/// Numbers of an array, or bits of a word.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum WrittenValues {
    /// The first elements of a REAL array.
    Numbers(RealArray),
    /// Bits of a DINT.
    Bits {
        /// The bits to write.
        mask: u32,
        /// Their new values.
        bits: u32,
    },
}

/// The rule for the length of Calculated Data compared with Event Distance.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum LengthRule {
    /// At least as long: MCLM, MCCM.
    AtLeast,
    /// Equally long: MAM.
    Exactly,
}

/// The distances of one instruction and the answers to them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Events {
    distances: RealArray,
    into: TagAddress,
    answers: [f64; MAX_ELEMENTS],
}

impl Events {
    /// The Event Distance operands of an instruction; `None`: it has none.
    ///
    /// # Errors
    /// `MdscCalculatedDataSize` (101) if the answers do not fit.
    pub(crate) fn of(operands: &EventOperands, fit: LengthRule) -> Result<Option<Events>, MotionError> {
        let EventOperands {
            event_distance,
            calculated_data,
        } = operands;
        let distances = event_distance.as_slice();
        if distances.is_empty() {
            return Ok(None);
        }
        let into = calculated_data.filter(|into| {
            let room = usize::from(into.elements);
            match fit {
                LengthRule::AtLeast => room >= distances.len(),
                LengthRule::Exactly => room == distances.len(),
            }
        });
        let Some(WrittenArray { tag, .. }) = into else {
            return Err(MotionError::MdscCalculatedDataSize);
        };
        Ok(Some(Events {
            distances: **event_distance,
            into: tag,
            answers: [0.0; MAX_ELEMENTS],
        }))
    }

    /// Calculates every answer. Returns false and leaves them unchanged if the move does not reach one of the points.
    pub(crate) fn answer(&mut self, reaches: impl Fn(f64) -> EventTime) -> bool {
        let mut answers = self.answers;
        for (answer, distance) in answers.iter_mut().zip(self.distances.as_slice()) {
            // A negative one is skipped.
            match if *distance < 0.0 {
                EventTime::At(-1.0)
            } else {
                reaches(*distance)
            } {
                EventTime::At(when) => *answer = when,
                EventTime::Passed => {}
                EventTime::Never => return false,
            }
        }
        self.answers = answers;
        true
    }

    /// The write of the present answers.
    pub(crate) fn write(&self, tick: u64) -> InstructionWrite {
        InstructionWrite {
            tick,
            tag: self.into,
            values: WrittenValues::Numbers(RealArray::from_slice(&self.answers[..self.distances.as_slice().len()])),
        }
    }
}

/// The events of a move of one axis.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MoveEvents {
    pub(crate) events: Events,
    /// The start of the move, in time or master displacement.
    pub(crate) begun: Instant,
    /// The start and the end of the move, in its generator's frame.
    pub(crate) from: f64,
    pub(crate) to: f64,
    /// The tick at which the answers are due next.
    pub(crate) due: Option<u64>,
}

impl MoveEvents {
    /// Calculates every answer by a profile from `start` on, as [`Events::answer`]. `clock` shows time or master displacement as the
    /// profile does.
    pub(crate) fn answer(&mut self, profile: &Profile, start: Instant, clock: &Clock) -> bool {
        if !profile.arrives() {
            return false;
        }
        let since = self.begun.elapsed(clock) - start.elapsed(clock);
        let displacement = self.to - self.from;
        let sign = if displacement < 0.0 { -1.0 } else { 1.0 };
        self.events.answer(|distance| {
            if distance > displacement.abs() {
                return EventTime::At(0.0);
            }
            if distance == 0.0 {
                return EventTime::At(since + profile.duration());
            }
            let position = self.to - sign * distance;
            if sign * (position - profile.start().position) < 0.0 {
                return EventTime::Passed;
            }
            match profile.time_at_position(position) {
                Some(planned) => EventTime::At(since + planned),
                None => EventTime::Passed,
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn negative_distances_are_skipped_and_passed_ones_keep_their_answers() {
        let mut events = Events {
            distances: RealArray::from_slice(&[0.0, -3.0, 40.0]),
            into: TagAddress::new(7, 0).expect("an address"),
            answers: [0.0; MAX_ELEMENTS],
        };
        let first = |distance: f64| EventTime::At(100.0 - distance);
        assert!(events.answer(first));
        let numbers = |numbers: [f64; 3]| WrittenValues::Numbers(RealArray::from_slice(&numbers));
        assert_eq!(events.write(5).values, numbers([100.0, -1.0, 60.0]));
        let later = |distance: f64| {
            if distance > 0.0 {
                EventTime::Passed
            } else {
                EventTime::At(120.0)
            }
        };
        assert!(events.answer(later));
        let written = events.write(6);
        assert_eq!((written.tick, written.tag.tag()), (6, 7));
        assert_eq!(written.values, numbers([120.0, -1.0, 60.0]));
        assert!(!events.answer(|_| EventTime::Never), "a paused move answers nothing");
        assert_eq!(events.write(7).values, numbers([120.0, -1.0, 60.0]));
    }
}
