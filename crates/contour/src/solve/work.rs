//! The budget of a planning call, counted and not timed: the same call gives the same plan on every computer.

use crate::limits::Smoothness;
use crate::solve::stages::Quality;
use crate::tuning::TUNING;

/// The remaining work, in visits of one node: a step of the optimisation and each attempt to shorten it visit every node.
#[derive(Debug)]
pub(crate) struct Work {
    left: u64,
    visited: u64,
}

/// The work of a whole search, in visits as well.
#[derive(Debug)]
pub(crate) struct Budget {
    left: u64,
    spent: u64,
}

impl Budget {
    /// About as much as a processor does in these seconds.
    pub(crate) fn of(seconds: f64) -> Budget {
        Budget {
            left: (seconds * TUNING.work.visits_per_s) as u64,
            spent: 0,
        }
    }

    /// Only each attempt has a limit.
    pub(crate) fn unlimited() -> Budget {
        Budget {
            left: u64::MAX,
            spent: 0,
        }
    }

    pub(crate) fn is_spent(&self) -> bool {
        self.left == 0
    }

    /// The time of what was spent, about, in seconds.
    pub(crate) fn seconds(&self) -> f64 {
        self.spent as f64 / TUNING.work.visits_per_s
    }

    /// Counts an attempt that begins with this number of nodes, without the steps of its optimisation.
    pub(crate) fn begin(&mut self, nodes: usize) {
        self.count(TUNING.work.attempt_each * nodes as u64);
    }

    /// The same for an attempt that begins with a smooth curve.
    pub(crate) fn begin_smooth(&mut self, nodes: usize) {
        self.count(TUNING.work.smooth_attempt_each * nodes as u64);
    }

    /// Counts the path of an attempt from a warm start outside of the limits, of this number of pieces.
    pub(crate) fn round(&mut self, pieces: usize) {
        self.count(TUNING.work.piece_each * pieces as u64);
    }

    /// The same for the speeds along the path of a gentle continuation.
    pub(crate) fn round_gently(&mut self, pieces: usize) {
        self.count(TUNING.work.gentle_piece_each * pieces as u64);
    }

    fn count(&mut self, visits: u64) {
        self.left = self.left.saturating_sub(visits);
        self.spent += visits;
    }

    /// Does work of a quality within the budget.
    pub(crate) fn spend<R>(&mut self, quality: Quality, work: &mut Work, with: impl FnOnce(&mut Work) -> R) -> R {
        let each = match quality {
            Quality::Full => TUNING.work.together_each,
            Quality::Smooth | Quality::TimingOnly => 1,
        };
        let before = work.visited;
        let done = work.at_most(self.left / each, with);
        let visited = each * (work.visited - before);
        self.count(visited);
        done
    }
}

impl Work {
    /// For a number of visits.
    pub(crate) fn of(left: u64) -> Work {
        Work { left, visited: 0 }
    }

    /// For a motion from rest that begins with this number of nodes.
    pub(crate) fn from_rest(nodes: usize) -> Work {
        Work::of(TUNING.work.from_rest + TUNING.work.from_rest_each * nodes as u64)
    }

    /// For the smooth curve of a motion from rest that others continue.
    pub(crate) fn to_begin(smoothness: Smoothness) -> Work {
        Work::of(match smoothness {
            Smoothness::Trapezoid => TUNING.work.to_begin,
            Smoothness::SCurve => TUNING.work.to_begin_s_curve,
        })
    }

    /// For all attempts to continue a motion, the first of which begins with this number of nodes; on a smooth curve for one attempt.
    pub(crate) fn to_continue(nodes: usize, quality: Quality) -> Work {
        let some = match quality {
            Quality::Smooth => 0,
            Quality::Full | Quality::TimingOnly => TUNING.work.to_continue,
        };
        Work::of(some + TUNING.work.to_continue_each * nodes as u64)
    }

    /// Does work with at most this number of visits.
    pub(crate) fn at_most<R>(&mut self, visits: u64, with: impl FnOnce(&mut Work) -> R) -> R {
        let (left, before) = (self.left, self.visited);
        self.left = left.min(visits);
        let done = with(self);
        self.left = left.saturating_sub(self.visited - before);
        done
    }

    /// Counts one visit of each of this number of nodes.
    pub(crate) fn visit(&mut self, nodes: usize) {
        self.left = self.left.saturating_sub(nodes as u64);
        self.visited += nodes as u64;
    }

    /// Counts what a stage along a smooth curve of this number of nodes takes beside its optimisation; the budget of the optimisation remains.
    pub(crate) fn smooth_stage(&mut self, nodes: usize) {
        self.visited += TUNING.work.stage_each * nodes as u64;
    }

    /// Leaves at least this number of visits of each of this number of nodes.
    pub(crate) fn allow(&mut self, each: u64, nodes: usize) {
        self.left = self.left.max(each * nodes as u64);
    }

    pub(crate) fn is_done(&self) -> bool {
        self.left == 0
    }
}
