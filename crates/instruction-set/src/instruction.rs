//! The parts of an instruction's faceplate.

use std::ops::RangeInclusive;

use crate::enumerations::JerkUnits;
use crate::words::compared;
use crate::{Flag, Mnemonic, Words, catalog};

/// A kind of motion object.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub enum Object {
    /// The motion group.
    MotionGroup,
    /// An axis.
    Axis,
    /// A coordinate system.
    CoordinateSystem,
}

impl Object {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::MotionGroup, Self::Axis, Self::CoordinateSystem];

    /// Its CIP class.
    pub const fn class_code(self) -> u16 {
        match self {
            Self::MotionGroup => 0x0300,
            Self::Axis => 0x0301,
            Self::CoordinateSystem => 0x0302,
        }
    }

    /// The object of a CIP class.
    pub const fn from_class_code(class: u16) -> Option<Self> {
        match class {
            0x0300 => Some(Self::MotionGroup),
            0x0301 => Some(Self::Axis),
            0x0302 => Some(Self::CoordinateSystem),
            _ => None,
        }
    }

    /// In words.
    pub const fn name(self) -> &'static str {
        match self {
            Self::MotionGroup => "motion group",
            Self::Axis => "axis",
            Self::CoordinateSystem => "coordinate system",
        }
    }

    /// In words, with its article.
    pub const fn with_article(self) -> &'static str {
        match self {
            Self::MotionGroup => "a motion group",
            Self::Axis => "an axis",
            Self::CoordinateSystem => "a coordinate system",
        }
    }

    /// The member of an instruction tag that names the target.
    pub const fn member(self) -> &'static str {
        match self {
            Self::MotionGroup => "MotionGroup",
            Self::Axis => "Axis",
            Self::CoordinateSystem => "CoordinateSystem",
        }
    }
}

impl std::fmt::Display for Object {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.pad(self.name())
    }
}

/// When DN comes.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Timing {
    /// In the same scan.
    Immediate,
    /// When the request is finished, after some coarse update periods.
    Message,
    /// As soon as the motion is accepted; IP while it runs.
    Process,
    /// When the request is armed or done; IP until its event.
    MessageProcess,
}

/// An instruction of the catalogue.
#[derive(Debug)]
pub struct Instruction {
    /// Its name.
    pub mnemonic: Mnemonic,
    /// Its full name.
    pub title: &'static str,
    /// The effect of the instruction, in a sentence.
    pub summary: &'static str,
    /// The object of the instruction.
    pub object: Object,
    /// When DN comes.
    pub timing: Timing,
    /// The status bits it uses.
    pub bits: &'static [Flag],
    /// The number of axes that its coordinate system must have; otherwise the error is 13 with operand 0.
    pub axes: Axes,
    /// In faceplate order: the place is also the EXERR of error 13.
    pub operands: &'static [Operand],
}

impl Instruction {
    /// Whether the instruction acts on an object; the others only calculate.
    pub fn has_target(&self) -> bool {
        matches!(
            self.operands.first().map(|operand| &operand.kind),
            Some(Kind::Target(_))
        )
    }

    /// Faceplate position of the motion control: 1, 2 behind a second object, or 0 where there is no object.
    pub fn control_operand(&self) -> usize {
        self.operands
            .iter()
            .position(|operand| matches!(operand.kind, Kind::MotionControl))
            .unwrap_or(1)
    }

    /// Faceplate positions of the operands behind target and motion control, in order.
    pub fn operands_behind_control(&self) -> impl Iterator<Item = usize> + '_ {
        let is_behind = |kind: &Kind| !matches!(kind, Kind::Target(_) | Kind::MotionControl);
        self.operands
            .iter()
            .enumerate()
            .filter(move |(_, operand)| is_behind(&operand.kind))
            .map(|(k, _)| k)
    }

    /// Faceplate position in front of which newer faceplates have one more operand, which is ignored.
    pub fn ignored_operand(&self) -> Option<usize> {
        let operands = self.operands.iter();
        operands
            .map(|operand| operand.ignored_before)
            .position(|name| name.is_some())
    }

    /// Faceplate position of an operand by its name or member name, case and blanks ignored.
    pub fn operand(&self, name: &str) -> Option<usize> {
        let letters = |name| compared(name).filter(|c| *c != '/');
        self.operands
            .iter()
            .position(|operand| letters(operand.name).eq(letters(name)))
    }

    /// The name of the operand that a motion error blames, where the call left it out.
    pub fn left_out(&self, err: i16, exerr: i8, operands: &[crate::UnboundOperand]) -> Option<&'static str> {
        let crate::MotionError::ParameterOutOfRange(place) = crate::MotionError::from_codes(err, exerr)? else {
            return None;
        };
        let place = usize::from(place.0);
        let index = self.operands_behind_control().position(|own| own == place)?;
        let missing = operands
            .get(index)
            .is_none_or(|operand| *operand == crate::UnboundOperand::Missing);
        missing
            .then(|| self.operands.get(place).map(|operand| operand.name))
            .flatten()
    }

    /// CIP class and service that execute it.
    pub fn service(&self) -> (u16, u8) {
        let place = services(self.object)
            .iter()
            .position(|mnemonic| *mnemonic == self.mnemonic);
        (
            self.object.class_code(),
            FIRST_SERVICE + place.map_or(0, |place| place as u8),
        )
    }
}

/// Legal numbers of axes, 1 to `usize::MAX` if it does not matter.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Axes {
    /// The least number.
    pub least: usize,
    /// The greatest number.
    pub most: usize,
}

impl Axes {
    /// Any number, none included.
    pub const ANY: Axes = Axes {
        least: 0,
        most: usize::MAX,
    };

    /// As a range.
    pub const fn range(self) -> RangeInclusive<usize> {
        self.least..=self.most
    }
}

/// One operand of a faceplate.
#[derive(Clone, Copy, Debug)]
pub struct Operand {
    /// As the faceplate prints it, such as `Accel Rate`.
    pub name: &'static str,
    /// Type and legal values.
    pub kind: Kind,
    /// The condition under which the range applies.
    pub condition: Condition,
    /// First value in an instruction tag: a full-speed S-curve. Not the value of an
    /// operand that is left out, which is always [`Operand::OMITTED`].
    pub initial: f32,
    /// Unit and meaning.
    pub note: &'static str,
    /// The name of one more operand that newer faceplates have in front of this one. It is accepted, ignored, and not counted.
    pub ignored_before: Option<&'static str>,
}

impl Operand {
    /// The value of a trailing operand that is left out: 0, None, Disabled, Programmed.
    pub const OMITTED: f64 = 0.0;

    /// Member of an instruction tag and name in Structured Text: no blanks, no slashes.
    pub fn member(&self) -> String {
        self.name.chars().filter(|c| !c.is_whitespace() && *c != '/').collect()
    }
}

/// Type and range of an operand.
#[derive(Clone, Copy, Debug)]
pub enum Kind {
    /// The object that the instruction acts on; always operand 0. Instructions without one are services of `object`.
    Target(Object),
    /// The MOTION_INSTRUCTION tag.
    MotionControl,
    /// Names another object: master axis, target system.
    Object(Object),
    /// An enumeration.
    Word(&'static Words),
    /// A magnitude, any numeric type.
    Number(Range),
    /// A count.
    Integer(Range),
    /// A REAL array that is read.
    Array(ArrayRule),
    /// A REAL array that is read, or 0: not used.
    ArrayOrNone,
    /// Names a REAL array tag that is written, or 0: not used. Holds the elements of its instruction-tag member.
    WrittenArray(u16),
    /// Names a tag of this type.
    Structure(&'static str),
    /// Names a tag of this type, or 0: none.
    StructureOrNone(&'static str),
}

/// Legal magnitudes. NaN and infinities never are.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Range {
    /// Every finite number.
    Any,
    /// 0 or more.
    NotNegative,
    /// More than 0.
    Positive,
    /// From the first to the second, both included.
    Between(f64, f64),
    /// More than 0, and at most 100 when the units operand says "% of time" (2 or 6).
    Jerk {
        /// Faceplate position of Jerk Units.
        units: u8,
    },
}

impl Range {
    /// Jerk Units that are a percentage of time: a jerk in them is at most 100.
    pub const PERCENT_OF_TIME: [i32; 2] = [
        JerkUnits::PercentOfTime as i32,
        JerkUnits::PercentOfTimeMasterDriven as i32,
    ];
}

/// Legal lengths of an array operand.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum ArrayRule {
    /// One element for each axis of the coordinate system.
    PerAxis,
    /// As `PerAxis`, but one element is enough when another operand has a value (Circle Type Radius).
    PerAxisUnless {
        /// Faceplate position of the other operand.
        operand: u8,
        /// Its value.
        value: i32,
    },
    /// At least this number.
    AtLeast(u8),
}

/// The condition under which a range applies. Enumerations always apply.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Condition {
    /// Always.
    Always,
    /// Only when the operand at this position is Yes; otherwise any value is legal, NaN included.
    Changed(u8),
    /// Only when an operand has a value; otherwise any finite number is legal.
    When {
        /// Faceplate position of the other operand.
        operand: u8,
        /// Its value.
        value: i32,
    },
}

/// Service code of the first instruction of each class.
pub const FIRST_SERVICE: u8 = 0x32;

/// The instructions of an object in the order of their service codes: 0x32 plus the place.
pub fn services(object: Object) -> &'static [Mnemonic] {
    match object {
        Object::MotionGroup => catalog::MOTION_GROUP,
        Object::Axis => catalog::AXIS,
        Object::CoordinateSystem => catalog::COORDINATE_SYSTEM,
    }
}

/// The instruction that a CIP service executes.
pub fn by_service(class: u16, service: u8) -> Option<Mnemonic> {
    let place = usize::from(service.checked_sub(FIRST_SERVICE)?);
    services(Object::from_class_code(class)?).get(place).copied()
}
