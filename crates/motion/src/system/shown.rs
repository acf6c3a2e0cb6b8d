//! The status of a coordinate system's motion, as its tags show it.

use arcline_planner::profile::Phase;

/// The status of the motion in the tags of a coordinate system and of its active instruction.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Shown {
    /// ACCEL and DECEL of the active instruction, as last written.
    pub(crate) phase: Phase,
    /// TrackingMaster of the active instruction, as last written.
    pub(crate) tracking: bool,
    /// The phase of the speed along the path, including the effect of masters.
    pub(crate) trend: Phase,
    /// ActualPosToleranceStatus.
    pub(crate) in_actual_tolerance: bool,
    /// CommandPosToleranceStatus.
    pub(crate) in_command_tolerance: bool,
    /// The active move blends with the end of the one before it, off the programmed path.
    pub(crate) in_transition: bool,
    /// The moves under way have begun to move the axes.
    pub(crate) has_moved: bool,
    /// Speed along the path, units/s.
    pub(crate) speed: f64,
    /// Distance covered on the active path, units.
    pub(crate) distance: f64,
    /// Length of the active path, units.
    pub(crate) length: f64,
}

impl Shown {
    /// The status at the change to another active move.
    pub(crate) fn of_next_move(self) -> Self {
        Shown {
            phase: Phase::Steady,
            tracking: false,
            in_actual_tolerance: false,
            in_command_tolerance: false,
            ..self
        }
    }

    /// The status after the end of all moves.
    pub(crate) fn at_rest(self) -> Self {
        Shown {
            in_actual_tolerance: self.in_actual_tolerance,
            in_command_tolerance: self.in_command_tolerance,
            ..Shown::default()
        }
    }
}
