//! The effect of an element of an output cam on its bit, one event after another.
//!
//! Not here: the instants of the events. Nothing allocates.

use arcline_planner::Instant;

use super::program::{Element, Latch, Unlatch};

/// The state of an element.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct ElementState {
    /// The axis is in the compensated range of the latch.
    in_latch: bool,
    /// The axis is in the compensated range of the unlatch.
    in_unlatch: bool,
    /// The enable bit fulfils the condition of the element.
    pub(super) enabled: bool,
    /// The axis entered the range of the latch after it last left that of the unlatch.
    met: bool,
    /// The axis left the range of the unlatch first: the compensated range is empty this time.
    spent: bool,
    /// The element has latched its bit, and will unlatch it.
    pub(super) holds: bool,
    /// The end of its duration.
    pub(super) off_at: Option<Instant>,
    /// The axis has left the ended cam of the element: positions have no effect any more.
    pub(super) passed: bool,
}

/// An event of an element. At equal positions the axis leaves a range before it enters one again.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum ElementEvent {
    UnlatchLeft,
    LatchLeft,
    UnlatchEntered,
    LatchEntered,
}

/// The effect of an event.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Effect {
    Nothing,
    /// The bit is latched.
    Latches,
    /// The bit is unlatched, unless another element holds it.
    Unlatches,
}

impl ElementState {
    /// The axis is in the range of the latch or, with false, in that of the unlatch.
    pub(super) fn is_in(&self, latch: bool) -> bool {
        if latch { self.in_latch } else { self.in_unlatch }
    }

    /// The element has no events left.
    pub(super) fn is_over(&self) -> bool {
        self.passed && self.off_at.is_none()
    }

    pub(super) fn happens(&mut self, element: &Element, what: ElementEvent) -> Effect {
        match what {
            ElementEvent::LatchEntered => {
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
            ElementEvent::LatchLeft => {
                self.in_latch = false;
                Effect::Nothing
            }
            ElementEvent::UnlatchEntered => {
                self.in_unlatch = true;
                self.spent = false;
                Effect::Nothing
            }
            ElementEvent::UnlatchLeft => {
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

    /// Takes a change of the enable condition. `armed`: an element with the latch type Enable latches.
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

    /// Arms the cam: an element with the latch type Enable latches if it is enabled.
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

    /// Unlatches the bit; an element that never latches unlatches the bits that other elements have latched.
    fn unlatch(&mut self, element: &Element) -> Effect {
        if !self.holds && element.latch != Latch::Inactive {
            return Effect::Nothing;
        }
        self.release()
    }

    /// Releases the bit.
    pub(super) fn release(&mut self) -> Effect {
        self.holds = false;
        self.off_at = None;
        Effect::Unlatches
    }
}
