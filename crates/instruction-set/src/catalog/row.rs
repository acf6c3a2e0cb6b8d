//! The language of the catalogue's tables: a row for each operand, groups of rows, and the structs that come of them.
//!
//! A row names another operand, on which its range depends, as the faceplate does ([`super::resolve`]).

use std::marker::PhantomData;

use crate::enumerations::*;
use crate::instruction::{ArrayRule, Condition, Kind, Object, Operand, Range};
use crate::{AxisId, Enumeration, RealArray, SystemId, TagAddress, Words, WrittenArray};

/// An operand whose references to others are names yet.
#[derive(Clone, Copy)]
pub(crate) struct Draft {
    pub(super) operand: Operand,
    /// The operand that the condition is about.
    pub(super) condition_on: &'static str,
    /// The operand that the range or the length of an array depends on.
    pub(super) range_on: &'static str,
}

/// An operand that is read as a `T`.
pub(super) struct Row<T> {
    draft: Draft,
    value: PhantomData<fn() -> T>,
}

impl<T> Row<T> {
    const fn new(kind: Kind, note: &'static str) -> Self {
        Row {
            draft: Draft {
                operand: Operand {
                    name: "",
                    kind,
                    condition: Condition::Always,
                    initial: 0.0,
                    note,
                    ignored_before: None,
                },
                condition_on: "",
                range_on: "",
            },
            value: PhantomData,
        }
    }

    /// First value in an instruction tag.
    pub(super) const fn first(mut self, initial: f32) -> Self {
        self.draft.operand.initial = initial;
        self
    }

    /// The range applies only when the named operand is Yes.
    pub(super) const fn changed_by(mut self, flag: &'static str) -> Self {
        self.draft.operand.condition = Condition::Changed(0);
        self.draft.condition_on = flag;
        self
    }

    /// The range applies only when the named operand has this value.
    pub(super) const fn when(mut self, operand: &'static str, value: i32) -> Self {
        self.draft.operand.condition = Condition::When { operand: 0, value };
        self.draft.condition_on = operand;
        self
    }

    /// Range or length depends on the named operand.
    const fn ranged_by(mut self, operand: &'static str) -> Self {
        self.draft.range_on = operand;
        self
    }

    /// Newer faceplates have one more operand in front of this one, which is ignored.
    pub(super) const fn behind_ignored(mut self, name: &'static str) -> Self {
        self.draft.operand.ignored_before = Some(name);
        self
    }

    /// As the faceplate prints it, where that is not the name of the field.
    pub(super) const fn named(mut self, name: &'static str) -> Self {
        self.draft.operand.name = name;
        self
    }

    /// The row of a field, by the name that follows from it.
    pub(super) const fn drafts(mut self, name: &'static str) -> [Draft; 1] {
        if self.draft.operand.name.is_empty() {
            self.draft.operand.name = name;
        }
        [self.draft]
    }
}

const FULL_SCALE: f32 = 100.0;
const S_CURVE: i32 = VelocityProfile::SCurve as i32;

pub(super) const fn target(object: Object) -> Row<()> {
    Row::new(Kind::Target(object), "")
}

pub(super) const fn axis() -> Row<()> {
    target(Object::Axis)
}

pub(super) const fn system() -> Row<()> {
    target(Object::CoordinateSystem)
}

pub(super) const fn group() -> Row<()> {
    target(Object::MotionGroup)
}

pub(super) const fn control() -> Row<()> {
    Row::new(Kind::MotionControl, "a MOTION_INSTRUCTION tag of its own")
}

pub(super) const fn other_axis(note: &'static str) -> Row<Option<AxisId>> {
    Row::new(Kind::Object(Object::Axis), note)
}

pub(super) const fn other_system() -> Row<Option<SystemId>> {
    Row::new(Kind::Object(Object::CoordinateSystem), "")
}

/// Any value of an enumeration.
pub(super) const fn word<E: Enumeration>() -> Row<E> {
    word_of(E::WORDS)
}

/// Some values of an enumeration.
pub(super) const fn word_of<E: Enumeration>(words: &'static Words) -> Row<E> {
    Row::new(Kind::Word(words), "")
}

pub(super) const fn number(range: Range, note: &'static str) -> Row<f64> {
    Row::new(Kind::Number(range), note)
}

pub(super) const fn count(range: Range, note: &'static str) -> Row<i32> {
    Row::new(Kind::Integer(range), note)
}

pub(super) const fn array(rule: ArrayRule, note: &'static str) -> Row<RealArray> {
    Row::new(Kind::Array(rule), note)
}

/// An element for each axis, or one where the named operand has a value.
pub(super) const fn per_axis_unless(operand: &'static str, value: i32, note: &'static str) -> Row<RealArray> {
    array(ArrayRule::PerAxisUnless { operand: 0, value }, note).ranged_by(operand)
}

pub(super) const fn array_or_none(note: &'static str) -> Row<RealArray> {
    Row::new(Kind::ArrayOrNone, note)
}

pub(super) const fn written(elements: u16, note: &'static str) -> Row<Option<WrittenArray>> {
    Row::new(Kind::WrittenArray(elements), note)
}

pub(super) const fn structure(type_name: &'static str, note: &'static str) -> Row<Option<TagAddress>> {
    Row::new(Kind::Structure(type_name), note)
}

pub(super) const fn structure_or_none(type_name: &'static str, note: &'static str) -> Row<Option<TagAddress>> {
    Row::new(Kind::StructureOrNone(type_name), note)
}

pub(super) const fn change() -> Row<NoYes> {
    word()
}

pub(super) const fn speed() -> Row<f64> {
    let note = "in Speed Units; 0: the move waits until MCCD or MCD gives it a speed";
    number(Range::NotNegative, note).first(FULL_SCALE)
}

pub(super) const fn rate(note: &'static str) -> Row<f64> {
    number(Range::Positive, note).first(FULL_SCALE)
}

pub(super) const fn accel_rate() -> Row<f64> {
    rate("in Accel Units")
}

pub(super) const fn decel_rate() -> Row<f64> {
    rate("in Decel Units")
}

pub(super) const fn speed_units(words: &'static Words) -> Row<SpeedUnits> {
    word_of(words).first(SpeedUnits::PercentOfMaximum as i32 as f32)
}

pub(super) const fn rate_units(words: &'static Words) -> Row<RateUnits> {
    word_of(words).first(RateUnits::PercentOfMaximum as i32 as f32)
}

/// A jerk, whose range depends on Jerk Units.
pub(super) const fn jerk() -> Row<f64> {
    number(Range::Jerk { units: 0 }, "in Jerk Units; used by an S-curve only")
        .ranged_by("Jerk Units")
        .first(FULL_SCALE)
}

/// The jerk of an instruction with a Profile.
pub(super) const fn profile_jerk() -> Row<f64> {
    jerk().when("Profile", S_CURVE)
}

pub(super) const fn jerk_units(words: &'static Words) -> Row<JerkUnits> {
    word_of(words).first(JerkUnits::PercentOfTime as i32 as f32)
}

pub(super) const fn profile() -> Row<VelocityProfile> {
    word().first(S_CURVE as f32)
}

/// The name on the faceplate of a field: `speed_units` is "Speed Units".
pub(super) const fn title<const N: usize>(field: &str) -> [u8; N] {
    let mut title = [b' '; N];
    let mut place = 0;
    while place < N {
        let letter = field.as_bytes()[place];
        if place == 0 || field.as_bytes()[place - 1] == b'_' {
            title[place] = letter.to_ascii_uppercase();
        } else if letter != b'_' {
            title[place] = letter;
        }
        place += 1;
    }
    title
}

macro_rules! faceplate_name {
    ($field:ident) => {{
        const BYTES: [u8; stringify!($field).len()] = title(stringify!($field));
        match std::str::from_utf8(&BYTES) {
            Ok(name) => name,
            Err(_) => panic!("the name of a field is ASCII"),
        }
    }};
}

/// Operands that several instructions have one behind the other: a struct, and the rows with the words of their units.
macro_rules! operand_groups {
    ($($(#[$doc:meta])* $group:ident($($words:ident),*) [$($field:ident: $type:ty = $row:expr),* $(,)?];)*) => {
        $(
            $(#[$doc])*
            #[derive(Clone, Copy, PartialEq, Debug)]
            #[allow(missing_docs, reason = "docs/INSTRUCTIONS.md describes every operand")]
            pub struct $group {
                $(pub $field: OperandValue<$type>,)*
            }

            impl $group {
                pub(super) const fn rows($($words: &'static Words),*) -> Rows<{ [$(stringify!($field)),*].len() }> {
                    Rows([$({
                        let row: Row<$type> = $row;
                        row.drafts(faceplate_name!($field))[0]
                    }),*])
                }
            }

            impl Operands for $group {
                fn read(reader: &mut OperandReader<'_>) -> Self {
                    $group {
                        $($field: Operands::read(reader),)*
                    }
                }
            }
        )*
    };
}

/// The rows of a group of operands.
pub(super) struct Rows<const N: usize>(pub(super) [Draft; N]);

impl<const N: usize> Rows<N> {
    /// Its operands have names of their own.
    pub(super) const fn drafts(self, _: &str) -> [Draft; N] {
        self.0
    }
}

/// Instructions: the faceplate of each, and a struct of its operands but for target and motion control.
macro_rules! instructions {
    ($($constant:ident = $mnemonic:ident on $object:ident, $timing:ident, $bits:expr, $axes:expr, $summary:literal:
       [$($field:ident $(as $group:ident)? $(: $type:ty)? = $row:expr),* $(,)?];)*) => {
        $(
            #[doc = $summary]
            pub static $constant: Instruction = Instruction {
                mnemonic: Mnemonic::$mnemonic,
                title: Mnemonic::$mnemonic.title(),
                summary: $summary,
                object: Object::$object,
                timing: Timing::$timing,
                bits: $bits,
                axes: $axes,
                operands: &{
                    const PARTS: &[&[Draft]] = &[$(&{
                        let row $(: Row<$type>)? = $row;
                        row.drafts(faceplate_name!($field))
                    }),*];
                    const COUNT: usize = total(PARTS);
                    resolved::<COUNT>(PARTS)
                },
            };

            #[doc = $summary]
            #[derive(Clone, Copy, PartialEq, Debug)]
            #[allow(missing_docs, reason = "docs/INSTRUCTIONS.md describes every operand")]
            pub struct $mnemonic {
                $($(pub $field: OperandValue<$type>,)? $(pub $field: $group,)?)*
            }

            impl Operands for $mnemonic {
                fn read(reader: &mut OperandReader<'_>) -> Self {
                    let _ = &reader;
                    $mnemonic {
                        $(
                            $($field: <OperandValue<$type> as Operands>::read(reader),)?
                            $($field: <$group as Operands>::read(reader),)?
                        )*
                    }
                }
            }
        )*
    };
}
