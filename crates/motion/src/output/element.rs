//! The effect of an element of an output cam on its bit, one event after another.
//!
//! Not here: when the events come. Nothing allocates.

use arcline_planner::Instant;

use super::program::{Element, Latch, Unlatch};

/// How far an element is.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct State {
    /// The axis is in the range that is compensated for the latch.
    in_latch: bool,
    /// The axis is in the range that is compensated for the unlatch.
    in_unlatch: bool,
    /// The enable bit is as it must be.
    pub(super) enabled: bool,
    /// The range of the latch was entered since that of the unlatch was left.
    met: bool,
    /// That of the unlatch was left first: the compensated range is empty this time.
    spent: bool,
    /// It has latched its bit, and will unlatch it.
    pub(super) holds: bool,
    /// When its duration is over.
    pub(super) off_at: Option<Instant>,
    /// Its cam is over and left behind: positions do not count any more.
    pub(super) passed: bool,
}

/// Something that happens to an element. At one place the range is left before it is entered again.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Happens {
    UnlatchLeft,
    LatchLeft,
    UnlatchEntered,
    LatchEntered,
}

/// Its effect.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Effect {
    Nothing,
    /// The bit is latched.
    Latches,
    /// The bit is unlatched, unless another element holds it.
    Unlatches,
}

impl State {
    /// Whether the axis is in the range of the latch, and in that of the unlatch.
    pub(super) fn is_in(&self, latch: bool) -> bool {
        if latch { self.in_latch } else { self.in_unlatch }
    }

    /// Nothing of it is to come.
    pub(super) fn is_over(&self) -> bool {
        self.passed && self.off_at.is_none()
    }

    pub(super) fn happens(&mut self, element: &Element, what: Happens) -> Effect {
        match what {
            Happens::LatchEntered => {
                self.in_latch = true;
                self.met = true;
                let spent = std::mem::take(&mut self.spent);
                let latches = match element.latch {
                    Latch::Position => true,
                    Latch::PositionAndEnable => self.enabled,
                    Latch::Inactive | Latch::Enable => false,
                };
                if latches && !(spent && element.unlatch.by_position()) {
                    self.latch(element)
                } else {
                    Effect::Nothing
                }
            }
            Happens::LatchLeft => {
                self.in_latch = false;
                Effect::Nothing
            }
            Happens::UnlatchEntered => {
                self.in_unlatch = true;
                self.spent = false;
                Effect::Nothing
            }
            Happens::UnlatchLeft => {
                self.in_unlatch = false;
                self.spent = !std::mem::take(&mut self.met);
                if element.unlatch.by_position() {
                    self.unlatch(element)
                } else {
                    Effect::Nothing
                }
            }
        }
    }

    /// The enable bit has become as it must be, or is not so any more. `armed`: what is enabled alone latches.
    pub(super) fn enable(&mut self, element: &Element, enabled: bool, armed: bool) -> Effect {
        let was = std::mem::replace(&mut self.enabled, enabled);
        match (was, enabled) {
            (false, true) => match element.latch {
                Latch::Enable if armed => self.latch(element),
                Latch::PositionAndEnable if self.in_latch => self.latch(element),
                _ => Effect::Nothing,
            },
            (true, false) if element.unlatch.by_enable() => self.unlatch(element),
            _ => Effect::Nothing,
        }
    }

    /// What is enabled alone latches when its cam is armed.
    pub(super) fn arm(&mut self, element: &Element) -> Effect {
        if self.enabled && element.latch == Latch::Enable {
            self.latch(element)
        } else {
            Effect::Nothing
        }
    }

    fn latch(&mut self, element: &Element) -> Effect {
        if element.unlatch.by_duration() && element.duration <= 0.0 {
            return Effect::Nothing;
        }
        self.holds = element.unlatch != Unlatch::Inactive;
        Effect::Latches
    }

    /// One that never latches unlatches what others have latched for good.
    fn unlatch(&mut self, element: &Element) -> Effect {
        if !self.holds && element.latch != Latch::Inactive {
            return Effect::Nothing;
        }
        self.release()
    }

    /// It does not hold its bit any more.
    pub(super) fn release(&mut self) -> Effect {
        self.holds = false;
        self.off_at = None;
        Effect::Unlatches
    }
}
