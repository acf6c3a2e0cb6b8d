//! The budget of a planning call, counted and not timed: the same call gives the same plan on every computer.

use crate::solve::stages::Quality;
use crate::tuning::TUNING;

/// The remaining work, in visits of one node: a step of the optimisation and each attempt to shorten it visit every node.
#[derive(Debug)]
pub(crate) struct Work {
    left: u64,
}

impl Work {
    /// For a motion from rest that begins with this number of nodes.
    pub(crate) fn from_rest(nodes: usize) -> Work {
        Work {
            left: TUNING.work.from_rest + TUNING.work.from_rest_each * nodes as u64,
        }
    }

    /// For all attempts to continue a motion, the first of which begins with this number of nodes; on a smooth curve for one attempt.
    pub(crate) fn to_continue(nodes: usize, quality: Quality) -> Work {
        let some = match quality {
            Quality::Smooth => 0,
            Quality::Full | Quality::TimingOnly => TUNING.work.to_continue,
        };
        Work {
            left: some + TUNING.work.to_continue_each * nodes as u64,
        }
    }

    /// For a number of visits.
    #[cfg(test)]
    pub(crate) fn of(left: u64) -> Work {
        Work { left }
    }

    /// Counts one visit of each of this number of nodes.
    pub(crate) fn visit(&mut self, nodes: usize) {
        self.left = self.left.saturating_sub(nodes as u64);
    }

    pub(crate) fn is_done(&self) -> bool {
        self.left == 0
    }
}
