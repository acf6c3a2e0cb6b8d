//! The meanings of the words of the keys: the reader and the writer use these lists. A test checks that each list has the words of its key in
//! the table of keys.

use arcline_controller::image::{Access, Writers};
use arcline_controller::machine::{
    AxisKind, Corner, Deviation, HomeDirection, HomeMode, HomeSequence, LimitPolicy, ProgrammedStopMode,
};
use arcline_instruction_set::ExceptionAction;

use crate::{ConnectionLoss, IoLoss, PlainAccess, Role};

/// The words of a key, each with its meaning.
pub(crate) type Words<T> = &'static [(&'static str, T)];

pub(crate) const IO_LOSS: Words<IoLoss> = &IoLoss::WORDS;
pub(crate) const CONNECTION_LOSS: Words<ConnectionLoss> = &ConnectionLoss::WORDS;
pub(crate) const PLAIN: Words<PlainAccess> = &PlainAccess::WORDS;
/// Whether the server refuses such connections.
pub(crate) const IO_OVER_TLS: Words<bool> = &[("refuse", true), ("plain", false)];
pub(crate) const ROLES: Words<Role> = &[
    (Role::Viewer.word(), Role::Viewer),
    (Role::Operator.word(), Role::Operator),
    (Role::Engineer.word(), Role::Engineer),
    (Role::Administrator.word(), Role::Administrator),
];
/// Whether the program does not run at first.
pub(crate) const CONTROLLER_MODES: Words<bool> = &[("run", false), ("program", true)];
pub(crate) const AXIS_KINDS: Words<AxisKind> = &[
    ("servo", AxisKind::Servo),
    ("virtual", AxisKind::Virtual),
    ("feedback", AxisKind::Feedback),
];
pub(crate) const STOP_MODES: Words<ProgrammedStopMode> = &ProgrammedStopMode::ALL;
pub(crate) const ACTIONS: Words<ExceptionAction> = &ExceptionAction::ALL;
pub(crate) const HOME_MODES: Words<HomeMode> = &[("active", HomeMode::Active), ("passive", HomeMode::Passive)];
pub(crate) const HOME_SEQUENCES: Words<HomeSequence> = &[
    ("immediate", HomeSequence::Immediate),
    ("switch", HomeSequence::Switch),
    ("marker", HomeSequence::Marker),
    ("switch-marker", HomeSequence::SwitchMarker),
    ("torque", HomeSequence::Torque),
    ("torque-marker", HomeSequence::TorqueMarker),
];
pub(crate) const HOME_DIRECTIONS: Words<HomeDirection> = &[
    ("bidirectional-forward", HomeDirection::BidirectionalForward),
    ("bidirectional-reverse", HomeDirection::BidirectionalReverse),
    ("unidirectional-forward", HomeDirection::UnidirectionalForward),
    ("unidirectional-reverse", HomeDirection::UnidirectionalReverse),
];
pub(crate) const CORNERS: Words<Corner> = &[("logix", Corner::Logix), ("precise", Corner::Precise)];
pub(crate) const DEVIATIONS: Words<Deviation> = &[("corners", Deviation::Corners), ("anywhere", Deviation::Anywhere)];
pub(crate) const LIMITS: Words<LimitPolicy> = &[("ignore", LimitPolicy::Ignore), ("enforce", LimitPolicy::Enforce)];
pub(crate) const ACCESS: Words<Access> = &[("read_write", Access::ReadWrite), ("read_only", Access::ReadOnly)];
pub(crate) const WRITERS: Words<Writers> = &[
    ("operator", Writers::Operators),
    ("engineer", Writers::Engineers),
    ("administrator", Writers::Administrators),
];

/// The word of a meaning.
pub(crate) fn word_of<T: PartialEq>(words: Words<T>, meaning: &T) -> &'static str {
    let word = words.iter().find(|(_, other)| other == meaning);
    word.map_or("", |(word, _)| word)
}
