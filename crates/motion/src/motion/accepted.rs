//! Coordinated moves as they were accepted: the data with which clients draw them.

use arcline_instruction_set::{ControlSlot, Mnemonic, SystemId};
use arcline_planner::geometry::Path;

use super::Motion;
use crate::execution::Ticket;

/// A coordinated move that was verified and queued.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AcceptedMove {
    /// When.
    pub tick: u64,
    /// Whose.
    pub ticket: Ticket,
    /// The tag it was executed with.
    pub control: ControlSlot,
    /// The instruction.
    pub mnemonic: Mnemonic,
    /// Index of the coordinate system.
    pub system: SystemId,
    /// The programmed path, in positions as they are now.
    pub path: Path,
    /// How far from the end of the path its successor may begin, position units; 0: it begins there, infinite: as soon as
    /// this one brakes.
    pub tolerance: f64,
}

/// Moves that are kept until the controller takes them; more are not shown.
pub(crate) const ACCEPTED: usize = 256;

impl Motion {
    /// The moves accepted since the last call, in order. Real-time as far as `report` is.
    pub fn accepted_moves(&mut self, report: impl FnMut(&AcceptedMove)) {
        self.accepted.iter().for_each(report);
        self.accepted.clear();
    }

    /// Notes an accepted move. Real-time.
    pub(crate) fn accept(&mut self, accepted: AcceptedMove) {
        if self.accepted.len() < ACCEPTED {
            self.accepted.push(accepted);
        }
    }
}
