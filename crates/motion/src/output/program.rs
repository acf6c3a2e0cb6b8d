//! The program of an output cam: elements that latch and unlatch bits, and the compensation of each bit
//! (spec/axis-and-data-types.md §5, §8.9).
//!
//! A program that exists is legal: the errors 36 and 37 of MAOC are found here, beside the tick. Units: position units, seconds. Not here:
//! the position of the axis.

use std::ops::RangeInclusive;

use thiserror::Error;

/// Elements of one output cam; a longer array is refused.
pub const MAX_OUTPUT_ELEMENTS: usize = 128;

/// A practically infinite duration, seconds.
const LONGEST_DURATION: f64 = 1e9;

/// Bits of an output word.
pub const OUTPUT_BITS: usize = 32;

/// An element of an OUTPUT_CAM array, with the members of the tag.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CamElement {
    /// OutputBit: 0 to 31.
    pub output_bit: i32,
    /// LatchType: 0 inactive, 1 position, 2 enable, 3 position and enable.
    pub latch_type: i32,
    /// UnlatchType: 0 inactive, 1 position, 2 duration, 3 enable, 4 position and enable, 5 duration and enable.
    pub unlatch_type: i32,
    /// Left: the beginning of the range, position units of the cam.
    pub left: f64,
    /// Right: the end of the range.
    pub right: f64,
    /// Duration, seconds.
    pub duration: f64,
    /// EnableType: 0 input, 1 inverted input, 2 output, 3 inverted output.
    pub enable_type: i32,
    /// EnableBit: 0 to 31.
    pub enable_bit: i32,
}

/// An element of an OUTPUT_COMPENSATION array, with the members of the tag; its index is the output bit.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BitCompensation {
    /// Offset: added to both ends of a range, position units.
    pub offset: f64,
    /// LatchDelay: the time by which latching is advanced, seconds.
    pub latch_delay: f64,
    /// UnlatchDelay: the time by which unlatching is advanced, seconds.
    pub unlatch_delay: f64,
    /// Mode: 0 normal, 1 inverted, 2 pulsed, 3 inverted and pulsed.
    pub mode: i32,
    /// CycleTime of pulses, seconds.
    pub cycle_time: f64,
    /// DutyCycle: the share of a cycle that is on, percent.
    pub duty_cycle: f64,
}

/// The error of an illegal output cam. Indices count from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum OutputCamError {
    /// An element of the OUTPUT_CAM array (36).
    #[error("element {element} of the output cam cannot be")]
    Element {
        /// Its index.
        element: usize,
    },
    /// An element of the OUTPUT_COMPENSATION array (37).
    #[error("element {element} of the output compensation cannot be")]
    Compensation {
        /// Its index.
        element: usize,
    },
}

/// A legal output cam.
#[derive(Clone, Debug, PartialEq)]
pub struct OutputCam {
    pub(super) start: f64,
    pub(super) end: f64,
    pub(super) elements: Vec<Element>,
    pub(super) compensation: [Compensation; OUTPUT_BITS],
    /// The bits that an element sets or clears.
    pub(super) mask: u32,
}

/// The condition that latches or unlatches a bit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Element {
    pub(super) bit: u8,
    pub(super) latch: Latch,
    pub(super) unlatch: Unlatch,
    pub(super) left: f64,
    pub(super) right: f64,
    /// The compensated duration; at 0 and below, the element never latches.
    pub(super) duration: f64,
    pub(super) enable: Enable,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Latch {
    Inactive,
    Position,
    Enable,
    PositionAndEnable,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Unlatch {
    Inactive,
    Position,
    Duration,
    Enable,
    PositionAndEnable,
    DurationAndEnable,
}

impl Unlatch {
    pub(super) fn by_position(self) -> bool {
        matches!(self, Unlatch::Position | Unlatch::PositionAndEnable)
    }

    pub(super) fn by_duration(self) -> bool {
        matches!(self, Unlatch::Duration | Unlatch::DurationAndEnable)
    }

    pub(super) fn by_enable(self) -> bool {
        matches!(
            self,
            Unlatch::Enable | Unlatch::PositionAndEnable | Unlatch::DurationAndEnable
        )
    }
}

/// The bit that enables an element.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Enable {
    /// The bit belongs to the output word, otherwise to the input word.
    pub(super) of_output: bool,
    pub(super) inverted: bool,
    pub(super) bit: u8,
}

/// The compensation and the output mode of a bit.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Compensation {
    pub(super) offset: f64,
    pub(super) latch_delay: f64,
    pub(super) unlatch_delay: f64,
    pub(super) inverted: bool,
    /// Length of a cycle, s, and the share of it that is on.
    pub(super) pulses: Option<(f64, f64)>,
}

impl OutputCam {
    /// The output cam of a range of positions, both ends included.
    ///
    /// An element that reaches beyond the range is cut off at its ends. Bits beyond the compensation array have no compensation.
    ///
    /// # Errors
    /// The first illegal element; those of the cam come first.
    pub fn new(
        range: RangeInclusive<f64>,
        elements: &[CamElement],
        compensation: &[BitCompensation],
    ) -> Result<Self, OutputCamError> {
        if elements.len() > MAX_OUTPUT_ELEMENTS {
            return Err(OutputCamError::Element {
                element: MAX_OUTPUT_ELEMENTS,
            });
        }
        let (start, end) = range.into_inner();
        let mut cam = OutputCam {
            start,
            end,
            elements: Vec::with_capacity(elements.len()),
            compensation: [Compensation::default(); OUTPUT_BITS],
            mask: 0,
        };
        for (index, element) in elements.iter().enumerate() {
            let element = element
                .checked(start, end)
                .ok_or(OutputCamError::Element { element: index })?;
            if (element.latch, element.unlatch) != (Latch::Inactive, Unlatch::Inactive) {
                cam.mask |= 1 << element.bit;
                cam.elements.push(element);
            }
        }
        for (index, (own, given)) in cam.compensation.iter_mut().zip(compensation).enumerate() {
            *own = given.checked().ok_or(OutputCamError::Compensation { element: index })?;
        }
        for element in &mut cam.elements {
            let own = &cam.compensation[usize::from(element.bit)];
            element.duration = (element.duration + own.latch_delay - own.unlatch_delay).min(LONGEST_DURATION);
        }
        Ok(cam)
    }
}

impl CamElement {
    fn checked(&self, start: f64, end: f64) -> Option<Element> {
        let bit = bit(self.output_bit)?;
        let latch = match self.latch_type {
            0 => Latch::Inactive,
            1 => Latch::Position,
            2 => Latch::Enable,
            3 => Latch::PositionAndEnable,
            _ => return None,
        };
        let unlatch = match self.unlatch_type {
            0 => Unlatch::Inactive,
            1 => Unlatch::Position,
            2 => Unlatch::Duration,
            3 => Unlatch::Enable,
            4 => Unlatch::PositionAndEnable,
            5 => Unlatch::DurationAndEnable,
            _ => return None,
        };
        let (mut left, mut right) = (self.left, self.right);
        if matches!(latch, Latch::Position | Latch::PositionAndEnable) || unlatch.by_position() {
            let legal = left < right;
            (left, right) = (left.max(start), right.min(end));
            // A NaN is never less than a number.
            if !legal || left >= right {
                return None;
            }
        }
        let lasts = self.duration > 0.0 && self.duration.is_finite();
        if unlatch.by_duration() && !lasts {
            return None;
        }
        let mut enable = Enable {
            of_output: false,
            inverted: false,
            bit: 0,
        };
        if matches!(latch, Latch::Enable | Latch::PositionAndEnable) || unlatch.by_enable() {
            if !(0..=3).contains(&self.enable_type) {
                return None;
            }
            enable = Enable {
                of_output: self.enable_type >= 2,
                inverted: self.enable_type % 2 == 1,
                bit: self::bit(self.enable_bit)?,
            };
        }
        Some(Element {
            bit,
            latch,
            unlatch,
            left,
            right,
            duration: self.duration,
            enable,
        })
    }
}

impl BitCompensation {
    fn checked(&self) -> Option<Compensation> {
        let numbers = [self.offset, self.latch_delay, self.unlatch_delay];
        if !(0..=3).contains(&self.mode) || numbers.iter().any(|number| !number.is_finite()) {
            return None;
        }
        let pulses = if self.mode >= 2 {
            let cycles = self.cycle_time > 0.0 && self.cycle_time.is_finite();
            if !cycles || !(0.0..=100.0).contains(&self.duty_cycle) {
                return None;
            }
            Some((self.cycle_time, self.duty_cycle / 100.0))
        } else {
            None
        };
        Some(Compensation {
            offset: self.offset,
            latch_delay: self.latch_delay,
            unlatch_delay: self.unlatch_delay,
            inverted: self.mode % 2 == 1,
            pulses,
        })
    }
}

fn bit(number: i32) -> Option<u8> {
    u8::try_from(number).ok().filter(|bit| usize::from(*bit) < OUTPUT_BITS)
}

#[cfg(test)]
mod tests {
    use super::*;

    const WINDOW: CamElement = CamElement {
        output_bit: 3,
        latch_type: 1,
        unlatch_type: 1,
        left: 10.0,
        right: 20.0,
        duration: 0.0,
        enable_type: 0,
        enable_bit: 0,
    };

    #[test]
    fn elements_that_cannot_be() {
        let with = |change: fn(&mut CamElement)| {
            let mut element = WINDOW;
            change(&mut element);
            element
        };
        #[rustfmt::skip]
        let cases: &[(&str, CamElement, bool)] = &[
            ("a window",                      WINDOW,                                                          true),
            ("nothing at all",                CamElement::default(),                                           true),
            ("the last bit",                  with(|e| e.output_bit = 31),                                     true),
            ("a bit too many",                with(|e| e.output_bit = 32),                                     false),
            ("a bit below 0",                 with(|e| e.output_bit = -1),                                     false),
            ("a latch type",                  with(|e| e.latch_type = 4),                                      false),
            ("an unlatch type",               with(|e| e.unlatch_type = 6),                                    false),
            ("left of itself",                with(|e| e.right = 10.0),                                        false),
            ("no number",                     with(|e| e.left = f64::NAN),                                     false),
            ("beyond the range",              with(|e| (e.left, e.right) = (100.0, 110.0)),                    false),
            ("across its end",                with(|e| e.right = 1000.0),                                      true),
            ("positions that do not count",   with(|e| (e.latch_type, e.unlatch_type, e.right) = (2, 3, 0.0)), true),
            ("no duration",                   with(|e| e.unlatch_type = 2),                                    false),
            ("a duration",                    with(|e| (e.unlatch_type, e.duration) = (5, 0.1)),               true),
            ("an enable type",                with(|e| (e.latch_type, e.enable_type) = (3, 4)),                false),
            ("an enable bit",                 with(|e| (e.unlatch_type, e.enable_bit) = (4, 32)),              false),
            ("an enable that does not count", with(|e| (e.enable_type, e.enable_bit) = (9, 99)),               true),
        ];
        for (why, element, legal) in cases {
            let cam = OutputCam::new(0.0..=100.0, &[WINDOW, *element], &[]);
            let expected = OutputCamError::Element { element: 1 };
            assert_eq!(cam.err(), (!legal).then_some(expected), "{why}");
        }
        let many = [WINDOW; MAX_OUTPUT_ELEMENTS + 1];
        assert!(OutputCam::new(0.0..=100.0, &many, &[]).is_err());
        let cut = OutputCam::new(15.0..=18.0, &[WINDOW], &[]).expect("it reaches beyond both ends");
        assert_eq!((cut.elements[0].left, cut.elements[0].right), (15.0, 18.0));
        assert_eq!(cut.mask, 8);
    }

    #[test]
    fn compensations_that_cannot_be() {
        let pulses = BitCompensation {
            mode: 2,
            cycle_time: 0.1,
            duty_cycle: 50.0,
            ..BitCompensation::default()
        };
        #[rustfmt::skip]
        let cases: &[(&str, BitCompensation, bool)] = &[
            ("none",                     BitCompensation::default(),                                   true),
            ("a mode",                   BitCompensation { mode: 4, ..pulses },                        false),
            ("pulses",                   pulses,                                                       true),
            ("no cycle",                 BitCompensation { cycle_time: 0.0, ..pulses },                false),
            ("more than all of it",      BitCompensation { duty_cycle: 100.5, ..pulses },              false),
            ("where nothing pulses",     BitCompensation { mode: 1, duty_cycle: 100.5, ..pulses },     true),
            ("a delay without end",      BitCompensation { latch_delay: f64::INFINITY, ..pulses },     false),
        ];
        for (why, compensation, legal) in cases {
            let cam = OutputCam::new(0.0..=100.0, &[WINDOW], &[BitCompensation::default(), *compensation]);
            let expected = OutputCamError::Compensation { element: 1 };
            assert_eq!(cam.err(), (!legal).then_some(expected), "{why}");
        }
    }
}
