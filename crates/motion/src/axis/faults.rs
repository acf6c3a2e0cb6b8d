//! The faults of one axis: their causes, the faults that a check finds, and the bits that show them
//! (spec/axis-and-data-types.md §9.3, §12).
//!
//! Not here: the effect of a fault on motion (`motion::faults`). Real-time: nothing allocates. Units: position units, seconds.

use arcline_instruction_set::predefined::axis_fault;
use arcline_instruction_set::{AxisId, ExceptionAction, FAULTS, FaultKind, FaultSet, FaultWord};

use crate::cause::{Cause, FaultChange, RefusedCommand};
use crate::machine::{Axis as Description, ExceptionActions, PositionErrorLimit, Travel};
use crate::tolerance::TRAVEL_UNITS;

/// The quantities of an axis at one update that the checks observe.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Observed {
    /// Actual position.
    pub(crate) position: f64,
    pub(crate) homed: bool,
    /// Command velocity.
    pub(crate) velocity: f64,
    /// Following error; `None`: the loop is open.
    pub(crate) error: Option<f64>,
    /// The positions of the tag that feeds the axis are overdue.
    pub(crate) lost: bool,
    /// The faults that the drive reports, and those that its feedback shows.
    pub(crate) drive: FaultSet,
}

/// The faults of an axis.
#[derive(Clone, Debug)]
pub(crate) struct Faults {
    actions: ExceptionActions,
    possible: FaultSet,
    travel: Option<Travel>,
    /// Position Error Tolerance and its time; 0: unchecked.
    position_error: PositionErrorLimit,
    /// Injected causes.
    injected: FaultSet,
    /// Causes that are present.
    causes: FaultSet,
    /// Causes that raised a fault in the last check, without the injected ones.
    found: FaultSet,
    /// Faults since the last reset.
    latched: FaultSet,
    /// Faults that the last check raised and that stop the axis.
    raised: FaultSet,
    /// Faults that a reset has cleared since the last check.
    cleared: FaultSet,
    /// Changes that are not reported yet: faults raised, faults that the check after their reset raised again, faults cleared, and the
    /// cause of the clearing.
    set: FaultSet,
    again: FaultSet,
    clear: FaultSet,
    cleared_by: Cause,
    /// The command of this update that did not go out, and the number of all such commands.
    refused: Option<RefusedCommand>,
    refusals: u32,
    /// Seconds for which the following error has been above its tolerance.
    exceeded: f64,
    /// The side of its travel on which the axis is: -1 below, 0 within, 1 above.
    side: i8,
    /// The axis is homed: its travel is checked.
    homed: bool,
}

impl Faults {
    pub(crate) fn new(description: &Description) -> Self {
        let mut faults = Faults {
            actions: description.exception_actions,
            possible: FaultSet::possible(!description.is_virtual()),
            travel: description.travel,
            position_error: description.position_error,
            injected: FaultSet::default(),
            causes: FaultSet::default(),
            found: FaultSet::default(),
            latched: FaultSet::default(),
            raised: FaultSet::default(),
            cleared: FaultSet::default(),
            set: FaultSet::default(),
            again: FaultSet::default(),
            clear: FaultSet::default(),
            cleared_by: Cause::Itself,
            refused: None,
            refusals: 0,
            exceeded: 0.0,
            side: 0,
            homed: description.start.homed,
        };
        let latched = description.start.faults.kinds();
        faults.latched = latched
            .filter(|kind| faults.possible.contains(*kind) && faults.is_fault(*kind))
            .fold(FaultSet::default(), FaultSet::with);
        faults.set = faults.latched;
        // An axis that starts outside its travel has not left it: that is no fault.
        faults.side = faults.side_of(description.start.position);
        faults
    }

    /// Replaces the injected causes.
    pub(crate) fn inject(&mut self, causes: FaultSet) {
        self.injected = FaultSet::from_bits(causes.bits() & self.possible.bits());
    }

    /// Checks for causes, once an update. Returns the strongest action of the new faults.
    pub(crate) fn check(&mut self, observed: &Observed, period: f64) -> Option<ExceptionAction> {
        let mut causes = self.injected;
        let mut found = FaultSet::default();
        let side = self.side_of(observed.position);
        let before = std::mem::replace(&mut self.side, side);
        self.homed = observed.homed;
        for (side, kind) in TRAVEL {
            if self.homed && self.side == side {
                causes = causes.with(kind);
                if before != side || observed.velocity * f64::from(side) > 0.0 {
                    found = found.with(kind);
                }
            }
        }
        let PositionErrorLimit { tolerance, time } = self.position_error;
        match observed.error {
            Some(error) if tolerance > 0.0 && error.abs() > tolerance => {
                // Half an update: sums of periods are not exact.
                if self.exceeded + 0.5 * period >= time {
                    causes = causes.with(FaultKind::PositionError);
                    found = found.with(FaultKind::PositionError);
                }
                self.exceeded += period;
            }
            _ => self.exceeded = 0.0,
        }
        if observed.lost {
            causes = causes.with(FaultKind::FeedbackLoss);
            found = found.with(FaultKind::FeedbackLoss);
        }
        if self.refused.is_some() {
            causes = causes.with(FaultKind::CommandLimit);
            found = found.with(FaultKind::CommandLimit);
        }
        causes = causes.union(observed.drive);
        found = found.union(observed.drive);
        self.causes = causes;
        self.found = found;
        let cleared = std::mem::take(&mut self.cleared);
        self.raised = FaultSet::default();
        let raised = found.union(self.injected);
        if raised.is_empty() {
            return None;
        }
        let raised = raised.kinds().map(|kind| (kind, self.actions.of(kind)));
        let raised = raised.filter(|(_, action)| *action >= ExceptionAction::FaultStatusOnly);
        let mut strongest = None;
        for (kind, action) in raised {
            if !self.latched.contains(kind) {
                strongest = strongest.max(Some(action));
                self.set = self.set.with(kind);
                if action.stops() {
                    self.raised = self.raised.with(kind);
                }
                if cleared.contains(kind) {
                    self.again = self.again.with(kind);
                }
            }
            self.latched = self.latched.with(kind);
        }
        strongest
    }

    /// The next check would find the same causes as the last one and report nothing.
    pub(crate) fn are_steady(&self) -> bool {
        let none = [
            self.injected,
            self.found,
            self.raised,
            self.cleared,
            self.set,
            self.again,
            self.clear,
        ];
        none.iter().all(|faults| faults.is_empty()) && self.refused.is_none() && self.exceeded == 0.0
    }

    /// The axis stays within its travel and its tolerance: with no other cause, a check at this position and following error finds nothing, and
    /// changes nothing.
    pub(crate) fn allow(&self, position: f64, error: f64) -> bool {
        let tolerance = self.position_error.tolerance;
        self.side == 0 && self.side_of(position) == 0 && !(tolerance > 0.0 && error.abs() > tolerance)
    }

    /// Records that a command of the present update did not go out, for the next check.
    pub(crate) fn refuse(&mut self, command: RefusedCommand) {
        self.refused = Some(command);
        self.refusals = self.refusals.saturating_add(1);
    }

    /// The number of commands that did not go out since the start.
    pub(crate) fn refusals(&self) -> u32 {
        self.refusals
    }

    /// Clears every fault because of an instruction. Returns true if none of their causes is still present.
    pub(crate) fn reset(&mut self, by: Cause) -> bool {
        self.cleared = self.latched;
        self.clear = self.clear.union(self.latched);
        self.cleared_by = by;
        self.latched = FaultSet::default();
        !self.injected.union(self.found).kinds().any(|kind| self.is_fault(kind))
    }

    /// The faults that the last check raised and that stop the axis.
    pub(crate) fn raised(&self) -> FaultSet {
        self.raised
    }

    /// The changes since the last call.
    pub(crate) fn take_change(&mut self, tick: u64, axis: AxisId) -> Option<FaultChange> {
        let refused = self.refused.take();
        if self.set.is_empty() && self.clear.is_empty() {
            return None;
        }
        Some(FaultChange {
            tick,
            axis,
            set: std::mem::take(&mut self.set),
            again: std::mem::take(&mut self.again),
            clear: std::mem::take(&mut self.clear),
            by: std::mem::take(&mut self.cleared_by),
            refused,
        })
    }

    /// Faults since the last reset.
    pub(crate) fn latched(&self) -> FaultSet {
        self.latched
    }

    /// The strongest action of the faults since the last reset.
    pub(crate) fn strongest(&self) -> Option<ExceptionAction> {
        self.latched.kinds().map(|kind| self.actions.of(kind)).max()
    }

    /// The configured action makes the kind a fault; it is neither an alarm nor ignored.
    fn is_fault(&self, kind: FaultKind) -> bool {
        self.actions.of(kind) >= ExceptionAction::FaultStatusOnly
    }

    /// A fault prevents motion of the axis.
    pub(crate) fn block(&self) -> bool {
        self.latched.kinds().any(|kind| self.actions.of(kind).stops())
    }

    /// The axis has left its travel, and motion in this direction goes further out.
    pub(crate) fn forbids(&self, direction: f64) -> bool {
        TRAVEL.into_iter().any(|(side, kind)| {
            let outside = (self.homed && self.side == side) || self.injected.contains(kind);
            outside && direction * f64::from(side) > 0.0 && self.actions.of(kind).stops()
        })
    }

    /// Faults since the last reset, in a word of the tag.
    pub(crate) fn word(&self, word: FaultWord) -> u64 {
        self.latched.word(word)
    }

    /// Causes that are present and only alarm, in a word of the tag.
    pub(crate) fn alarms(&self, word: FaultWord) -> u64 {
        let alarms = self.causes.kinds();
        alarms
            .filter(|kind| self.actions.of(*kind) == ExceptionAction::Alarm)
            .fold(FaultSet::default(), FaultSet::with)
            .word(word)
    }

    /// AxisFault. AXIS_VIRTUAL has no MotionFault; its motion faults count as a physical fault.
    pub(crate) fn axis_fault(&self, is_virtual: bool) -> u32 {
        let mut shown = 0;
        if self.latched.word(FaultWord::Cip) != 0 {
            shown |= axis_fault::PHYSICAL_AXIS_FAULT;
        }
        if self.latched.word(FaultWord::Motion) != 0 {
            shown |= if is_virtual {
                axis_fault::PHYSICAL_AXIS_FAULT
            } else {
                axis_fault::MOTION_FAULT
            };
        }
        shown
    }

    /// The position is outside the travel that a motion must not leave.
    pub(crate) fn forbids_position(&self, position: f64) -> bool {
        let side = self.side_of(position);
        let stops = |(own, kind): (i8, FaultKind)| own == side && self.actions.of(kind).stops();
        self.homed && side != 0 && TRAVEL.into_iter().any(stops)
    }

    /// The permitted displacements from a position within that travel, down and up: infinite on a side without a limit, 0 on a side whose
    /// limit the position has passed.
    pub(crate) fn room(&self, position: f64) -> [f64; 2] {
        let stops = |side: i8| {
            let mut kinds = TRAVEL.into_iter().filter(|(own, _)| *own == side);
            self.homed && kinds.any(|(_, kind)| self.actions.of(kind).stops())
        };
        let travel = self.travel;
        let down = travel.filter(|_| stops(-1)).map(|travel| travel.min - position);
        let up = travel.filter(|_| stops(1)).map(|travel| travel.max - position);
        [
            down.map_or(f64::NEG_INFINITY, |down| down.min(0.0)),
            up.map_or(f64::INFINITY, |up| up.max(0.0)),
        ]
    }

    /// Takes over positions that were shifted without motion: the axis stays on its side of the travel.
    pub(crate) fn redefined(&mut self, position: f64) {
        self.side = self.side_of(position);
    }

    fn side_of(&self, position: f64) -> i8 {
        match self.travel {
            Some(travel) if position > travel.max + TRAVEL_UNITS => 1,
            Some(travel) if position < travel.min - TRAVEL_UNITS => -1,
            _ => 0,
        }
    }
}

/// Sides of the travel and their faults.
const TRAVEL: [(i8, FaultKind); 2] = [(1, FaultKind::SoftTravelPositive), (-1, FaultKind::SoftTravelNegative)];

const _: () = assert!(FAULTS.len() == FaultKind::COUNT);

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machine::AxisKind;

    const PERIOD: f64 = 0.001;

    fn axis(time: f64) -> Description {
        Description {
            travel: Some(Travel { min: -10.0, max: 10.0 }),
            position_error: PositionErrorLimit { tolerance: 2.0, time },
            ..Description::new("X", AxisKind::Servo, 100.0, 1000.0)
        }
    }

    fn at(position: f64, velocity: f64) -> Observed {
        Observed {
            position,
            homed: true,
            velocity,
            error: Some(0.0),
            lost: false,
            drive: FaultSet::default(),
        }
    }

    #[test]
    fn travel_is_left_once_and_standing_outside_is_no_fault() {
        let mut faults = Faults::new(&axis(0.0));
        let stop = Some(ExceptionAction::StopPlanner);
        #[rustfmt::skip]
        let cases = [
            // why,                       observed,            reset before, result, direction forbidden
            ("inside",                    at(9.0, 50.0),       false, None,  false),
            ("on the limit",              at(10.0, 50.0),      false, None,  false),
            ("out",                       at(10.1, 50.0),      false, stop,  true),
            ("further out, still there",  at(10.2, 50.0),      false, None,  true),
            ("cleared while it moves on", at(10.3, 40.0),      true,  stop,  true),
            ("cleared and standing",      at(10.5, 0.0),       true,  None,  true),
            ("back in",                   at(10.4, -5.0),      false, None,  true),
            ("out again",                 at(10.5, 5.0),       false, stop,  true),
            ("inside, not cleared",       at(9.0, -5.0),       false, None,  false),
            ("coasting out",              at(-10.1, 0.0),      true,  stop,  false),
        ];
        for (why, observed, reset, expected, forbidden) in cases {
            if reset {
                faults.reset(Cause::Itself);
            }
            assert_eq!(faults.check(&observed, PERIOD), expected, "{why}");
            assert_eq!(faults.forbids(1.0), forbidden, "{why}");
        }
        assert_eq!(faults.word(FaultWord::Motion), 1 << 2);
        let mut not_homed = Faults::new(&axis(0.0));
        let observed = Observed {
            homed: false,
            ..at(11.0, 1.0)
        };
        assert_eq!(not_homed.check(&observed, PERIOD), None);
        assert!(!not_homed.forbids(1.0));
        assert_eq!(not_homed.check(&at(11.0, 0.0), PERIOD), None, "homed while it stands");
    }

    #[test]
    fn a_position_error_must_last() {
        let erring = |error| Observed {
            error: Some(error),
            ..at(0.0, 0.0)
        };
        for (time, updates) in [(0.0, 1), (0.001, 2), (0.005, 6)] {
            let mut faults = Faults::new(&axis(time));
            assert_eq!(faults.check(&erring(2.0), PERIOD), None, "at the tolerance");
            let first = (1..20).find(|_| faults.check(&erring(-2.1), PERIOD).is_some());
            assert_eq!(first, Some(updates), "{time} s");
            assert!(!faults.reset(Cause::Itself), "it is still there");
            faults.check(&erring(1.0), PERIOD);
            assert!(faults.reset(Cause::Itself));
        }
    }
}
