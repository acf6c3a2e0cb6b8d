//! Series: moves of coordinate systems that one client sends together (docs/spec/contract.md §4), so that a program is not bound to one move
//! a tick.
//!
//! The moves are executed in their order. The controller refuses every move behind one that has failed, and takes no more than its queue
//! has room for; both leave the motion control tags of the moves that were not executed as they were. Not here: the bytes of the
//! service, and the wait for room, which is the client's.

use arcline_instruction_set::{Flag, MotionControl, MotionError, SystemId};

use super::command::Call;
use super::{CallRefused, Executed, Plant, Principal, Refused};

/// The moves of a series that were executed, and its end.
#[derive(Clone, PartialEq, Debug)]
pub struct SeriesOutcome {
    /// The first moves.
    pub executed: Vec<Executed>,
    /// The reason for which the next move was not executed.
    pub end: SeriesEnd,
}

/// The reason for the end of a series.
#[derive(Clone, PartialEq, Debug)]
pub enum SeriesEnd {
    /// All were sent and executed; the server has read no others.
    Sent,
    /// The queue of the next move has no room.
    NoRoom {
        /// The coordinate system of that queue.
        system: SystemId,
    },
    /// The next move has erred: its motion control tag shows this.
    Erred(MotionControl),
    /// The next move was refused.
    Refused(Refused),
}

impl Plant {
    /// Executes the first moves of a series, [`LONGEST_SERIES`] at most, each with the principal that it belongs to, and waits until they are
    /// verified.
    pub async fn execute_series(&self, moves: &[(Principal, Call<'_>)]) -> SeriesOutcome {
        let Some((first, _)) = moves.first() else {
            return SeriesOutcome {
                executed: Vec::new(),
                end: SeriesEnd::Sent,
            };
        };
        let ((sent, end), pending) = self.transact(*first, |transaction| transaction.send_series(moves));
        // An instruction without an answer is found below.
        let _ = self.settle(pending).await;
        let mut executed = Vec::with_capacity(sent.len());
        let mut state = self.0.lock();
        state.refresh();
        for (instance, (_, call)) in sent.into_iter().zip(moves) {
            let control = state.records.by_instance(instance).unwrap_or_default();
            let end = if control.has(Flag::Er) {
                match call.target.map(SystemId) {
                    Some(system) if control.err == MotionError::CoordinateSystemQueueFull.err() => {
                        SeriesEnd::NoRoom { system }
                    }
                    _ => SeriesEnd::Erred(control),
                }
            } else if control.has(Flag::Dn) || control.has(Flag::Ip) {
                executed.push(Executed { instance, control });
                continue;
            } else {
                SeriesEnd::Refused(CallRefused::NoAnswer.into())
            };
            return SeriesOutcome { executed, end };
        }
        SeriesOutcome { executed, end }
    }
}

/// Moves of a series that are executed at a time: those behind them wait for the client to send them again.
pub const LONGEST_SERIES: usize = 64;
