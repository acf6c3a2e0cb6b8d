//! Accepted coordinated moves: the data from which clients draw them.

use arcline_instruction_set::{ControlSlot, Mnemonic, SystemId};
use arcline_planner::geometry::Path;

use super::Motion;
use crate::execution::Ticket;

/// A coordinated move that was verified and queued.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AcceptedMove {
    /// The tick.
    pub tick: u64,
    /// Its execution.
    pub ticket: Ticket,
    /// Its motion control tag.
    pub control: ControlSlot,
    /// The instruction.
    pub mnemonic: Mnemonic,
    /// Index of the coordinate system.
    pub system: SystemId,
    /// The programmed path, in present positions.
    pub path: Path,
    /// The distance from the end of the path at which the successor may begin, position units; 0: at the end, infinite: as soon as
    /// the move brakes.
    pub tolerance: f64,
}

/// Moves stored until the controller reads them; further ones are not shown.
pub(crate) const ACCEPTED: usize = 256;

impl Motion {
    /// The moves accepted since the last call, in order. Real-time as far as `report` is.
    pub fn accepted_moves(&mut self, report: impl FnMut(&AcceptedMove)) {
        self.accepted.iter().for_each(report);
        self.accepted.clear();
    }

    /// Records an accepted move. Real-time.
    pub(crate) fn accept(&mut self, accepted: AcceptedMove) {
        if self.accepted.len() < ACCEPTED {
            self.accepted.push(accepted);
        }
    }
}
