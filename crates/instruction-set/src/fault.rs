//! The faults of an axis as data: name, bits, default action, meaning (spec/axis-and-data-types.md §9.3, §12).
//!
//! Configuration keys, words of the command line, the tag `FaultInject` and docs/FAULTS.md are made from it.
//! `arcline-motion` has the effect of a fault.

/// A kind of fault. Its place in [`FAULTS`] is its bit in a [`FaultSet`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum FaultKind {
    /// The actual position is above Soft Travel Limit Positive.
    SoftTravelPositive,
    /// The actual position is below Soft Travel Limit Negative.
    SoftTravelNegative,
    /// The following error is above its tolerance.
    PositionError,
    /// The drive reports a fault of its own.
    Drive,
    /// The motor takes too much current.
    Overcurrent,
    /// The motor turns too fast.
    Overspeed,
    /// The positive limit switch is hit.
    OvertravelPositive,
    /// The negative limit switch is hit.
    OvertravelNegative,
    /// The encoder gives no signal.
    FeedbackLoss,
    /// A command would have been beyond the limits that the axis can follow.
    CommandLimit,
    /// The drive does not answer.
    DriveCommunication,
}

/// Which words of an axis's tag a fault and its alarm show in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FaultWord {
    /// MotionFaultStatus and MotionAlarmStatus; AxisFault.MotionFault.
    Motion,
    /// CIPAxisFaults and CIPAxisAlarms; AxisFault.PhysicalAxisFault. Only of an axis with a drive.
    Cip,
}

/// The reaction of an axis when a fault's cause appears (spec/axis-and-data-types.md §9.3).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum ExceptionAction {
    /// No reaction.
    Ignore,
    /// The alarm bit, while the cause is there.
    Alarm,
    /// The fault bits; motion goes on.
    FaultStatusOnly,
    /// The axis decelerates, the servo stays on.
    StopPlanner,
    /// The axis decelerates, then the servo goes off.
    StopDrive,
    /// Shutdown at once.
    Shutdown,
}

/// One kind of fault.
#[derive(Debug)]
pub struct Fault {
    /// Which one.
    pub kind: FaultKind,
    /// Its word in configurations and on the command line.
    pub word: &'static str,
    /// The status words in which the fault shows.
    pub shows: FaultWord,
    /// Bit of those words.
    pub bit: u8,
    /// The action of an axis that is not configured otherwise.
    pub default: ExceptionAction,
    /// Whether the controller detects the fault while the machine runs; the others are only injected.
    pub detected: bool,
    /// The event, in a sentence.
    pub meaning: &'static str,
}

/// Every kind of fault; the place is the bit in a [`FaultSet`] and in the tag `FaultInject`.
#[rustfmt::skip]
pub static FAULTS: [Fault; FaultKind::COUNT] = [
    fault(FaultKind::SoftTravelPositive, "soft_travel_positive", FaultWord::Motion, 1, ExceptionAction::StopPlanner, true,
        "The actual position of a homed axis is above Soft Travel Limit Positive and it moves further out."),
    fault(FaultKind::SoftTravelNegative, "soft_travel_negative", FaultWord::Motion, 2, ExceptionAction::StopPlanner, true,
        "The actual position of a homed axis is below Soft Travel Limit Negative and it moves further out."),
    fault(FaultKind::PositionError, "position_error", FaultWord::Cip, 54, ExceptionAction::StopDrive, true,
        "The following error is above its tolerance for longer than the tolerance time."),
    fault(FaultKind::Drive, "drive", FaultWord::Cip, 62, ExceptionAction::StopDrive, true,
        "The drive switches off, or reports a fault without its cause (ControllerInitiatedFault)."),
    fault(FaultKind::Overcurrent, "overcurrent", FaultWord::Cip, 1, ExceptionAction::StopDrive, false,
        "The motor takes more current than its limit."),
    fault(FaultKind::Overspeed, "overspeed", FaultWord::Cip, 3, ExceptionAction::StopDrive, false,
        "The motor is faster than its factory limit."),
    fault(FaultKind::OvertravelPositive, "overtravel_positive", FaultWord::Cip, 50, ExceptionAction::StopDrive, false,
        "The positive limit switch is hit."),
    fault(FaultKind::OvertravelNegative, "overtravel_negative", FaultWord::Cip, 51, ExceptionAction::StopDrive, false,
        "The negative limit switch is hit."),
    fault(FaultKind::FeedbackLoss, "feedback_loss", FaultWord::Cip, 43, ExceptionAction::StopDrive, true,
        "The encoder gives no signal: nothing is written to the tag that feeds an axis of type feedback."),
    fault(FaultKind::CommandLimit, "command_limit", FaultWord::Motion, 31, ExceptionAction::StopPlanner, true,
        "A command beyond the command limits of the axis did not go out; the axis and the axes that moved with it stop."),
    fault(FaultKind::DriveCommunication, "drive_communication", FaultWord::Cip, 45, ExceptionAction::StopDrive, true,
        "The drive has not answered for three updates in a row."),
];

const fn fault(
    kind: FaultKind,
    word: &'static str,
    shows: FaultWord,
    bit: u8,
    default: ExceptionAction,
    detected: bool,
    meaning: &'static str,
) -> Fault {
    Fault {
        kind,
        word,
        shows,
        bit,
        default,
        detected,
        meaning,
    }
}

impl FaultKind {
    /// The number of kinds.
    pub const COUNT: usize = 11;

    /// Every kind, in the order of [`FAULTS`].
    pub const ALL: [FaultKind; FaultKind::COUNT] = [
        FaultKind::SoftTravelPositive,
        FaultKind::SoftTravelNegative,
        FaultKind::PositionError,
        FaultKind::Drive,
        FaultKind::Overcurrent,
        FaultKind::Overspeed,
        FaultKind::OvertravelPositive,
        FaultKind::OvertravelNegative,
        FaultKind::FeedbackLoss,
        FaultKind::CommandLimit,
        FaultKind::DriveCommunication,
    ];

    /// Its row. Real-time.
    pub fn fault(self) -> &'static Fault {
        &FAULTS[self as usize]
    }

    /// The kind of a word, case ignored, `-` as `_`.
    pub fn from_word(word: &str) -> Option<FaultKind> {
        let word = word.replace('-', "_");
        let found = FAULTS.iter().find(|fault| fault.word.eq_ignore_ascii_case(&word));
        found.map(|fault| fault.kind)
    }
}

impl ExceptionAction {
    /// Every action with its word in the configuration, in the order of the attribute's values from 0.
    pub const ALL: [(&'static str, ExceptionAction); 6] = [
        ("ignore", ExceptionAction::Ignore),
        ("alarm", ExceptionAction::Alarm),
        ("fault_status_only", ExceptionAction::FaultStatusOnly),
        ("stop_planner", ExceptionAction::StopPlanner),
        ("stop_drive", ExceptionAction::StopDrive),
        ("shutdown", ExceptionAction::Shutdown),
    ];

    /// Its word in the configuration.
    pub fn word(self) -> &'static str {
        Self::ALL[self as usize].0
    }

    /// Whether the action stops the axis, which errs with 20 until the fault is cleared.
    pub fn stops(self) -> bool {
        self >= ExceptionAction::StopPlanner
    }
}

/// A set of kinds of faults.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FaultSet(u32);

impl FaultSet {
    /// Every kind that an axis can have.
    pub fn possible(has_drive: bool) -> FaultSet {
        let kinds = FAULTS
            .iter()
            .filter(|fault| has_drive || fault.shows == FaultWord::Motion);
        kinds.fold(FaultSet::default(), |set, fault| set.with(fault.kind))
    }

    /// The set whose bits these are; bits that mean nothing are dropped.
    pub const fn from_bits(bits: u32) -> FaultSet {
        FaultSet(bits & ((1 << FaultKind::COUNT) - 1))
    }

    /// The bits, one for each kind, as in the tag `FaultInject`.
    pub const fn bits(self) -> u32 {
        self.0
    }

    /// The set with a further kind.
    #[must_use]
    pub const fn with(self, kind: FaultKind) -> FaultSet {
        FaultSet(self.0 | 1 << kind as u32)
    }

    /// The set without the kinds of another one.
    #[must_use]
    pub const fn without(self, other: FaultSet) -> FaultSet {
        FaultSet(self.0 & !other.0)
    }

    /// The kinds of either set.
    #[must_use]
    pub const fn union(self, other: FaultSet) -> FaultSet {
        FaultSet(self.0 | other.0)
    }

    /// Whether the set contains a kind.
    pub const fn contains(self, kind: FaultKind) -> bool {
        self.0 & 1 << kind as u32 != 0
    }

    /// Whether the set is empty.
    pub const fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// The kinds in it, in order.
    pub fn kinds(self) -> impl Iterator<Item = FaultKind> {
        let mut left = self.0;
        std::iter::from_fn(move || {
            // Of an empty set the lowest bit is 32, where no kind is.
            let kind = *FaultKind::ALL.get(left.trailing_zeros() as usize)?;
            left &= left - 1;
            Some(kind)
        })
    }

    /// The kinds in it whose bits stand in one of the words, as that word.
    pub fn word(self, word: FaultWord) -> u64 {
        let shown = self.kinds().map(FaultKind::fault).filter(|fault| fault.shows == word);
        shown.fold(0, |bits, fault| bits | 1 << fault.bit)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::predefined::{self, EXCESSIVE_POSITION_ERROR_FAULT, motion_fault_status};

    #[test]
    fn every_kind_stands_at_its_place_and_has_its_bits_in_the_tag() {
        for (place, fault) in FAULTS.iter().enumerate() {
            assert_eq!(
                (fault.kind as usize, fault.kind),
                (place, FaultKind::ALL[place]),
                "{}",
                fault.word
            );
            assert_eq!(FaultKind::from_word(&fault.word.to_uppercase()), Some(fault.kind));
            assert_eq!(FaultKind::from_word(&fault.word.replace('_', "-")), Some(fault.kind));
            let set = FaultSet::default().with(fault.kind);
            let other = match fault.shows {
                FaultWord::Motion => FaultWord::Cip,
                FaultWord::Cip => FaultWord::Motion,
            };
            assert_eq!((set.word(fault.shows), set.word(other)), (1 << fault.bit, 0));
            if fault.kind == FaultKind::CommandLimit {
                // Arcline's own: AXIS_CIP_DRIVE has no member for it.
                continue;
            }
            // A member of AXIS_CIP_DRIVE overlays the bit, in the fault word and in the alarm word.
            let words = match fault.shows {
                FaultWord::Motion => ["MotionFaultStatus", "MotionAlarmStatus"],
                FaultWord::Cip => ["CIPAxisFaults", "CIPAxisAlarms"],
            };
            let template = predefined::axis_cip_drive();
            for (word, end) in words.into_iter().zip(["Fault", "Alarm"]) {
                let offset = template.member(word).expect(word).offset;
                let (byte, bit) = (offset + u32::from(fault.bit / 8), fault.bit % 8);
                let named = template
                    .members
                    .iter()
                    .any(|member| (member.offset, member.bit) == (byte, Some(bit)) && member.name.ends_with(end));
                assert!(named, "{word} has no bit {}", fault.bit);
            }
        }
        let soft = FaultSet::default().with(FaultKind::SoftTravelPositive);
        let bit = u64::from(motion_fault_status::SOFT_TRAVEL_LIMIT_POSITIVE_FAULT);
        assert_eq!(soft.word(FaultWord::Motion), bit);
        let error = FaultSet::default().with(FaultKind::PositionError);
        assert_eq!(error.word(FaultWord::Cip), EXCESSIVE_POSITION_ERROR_FAULT);
    }

    #[test]
    fn an_axis_without_a_drive_has_no_faults_of_one() {
        let kinds: Vec<_> = FaultSet::possible(false).kinds().collect();
        let own = [
            FaultKind::SoftTravelPositive,
            FaultKind::SoftTravelNegative,
            FaultKind::CommandLimit,
        ];
        assert_eq!(kinds, own);
        assert_eq!(FaultSet::possible(true), FaultSet::from_bits(u32::MAX));
    }

    #[test]
    fn actions_stand_in_the_order_of_their_values() {
        for (place, (word, action)) in ExceptionAction::ALL.into_iter().enumerate() {
            assert_eq!((action as usize, action.word()), (place, word));
        }
    }
}
