//! The motion of the axis within an update: the arming and the end of cams.
//!
//! Not here: the events of elements meanwhile ([`super::events`]). Real-time: nothing allocates; an update is divided into a bounded
//! number of pieces.

use arcline_instruction_set::enumerations::ExecutionMode;
use arcline_planner::{Clock, Instant};
use arcline_profile::KinematicState;

use super::super::interpolation::Interpolation;
use super::super::program::{Compensation, OUTPUT_BITS};
use super::super::windows::Turns;
use super::ExecutionTarget;
use super::cam_state::{ACTIVE, PENDING, Phase};
use super::events::Edge;
use super::piece::{Piece, instant};
use crate::execution::Execution;
use crate::tolerance::OUTPUT_CAM_SHARE;

/// Most cuts of an update: at the arm position and at ends of cams.
const MOST_CUTS: usize = 4;

impl ExecutionTarget {
    /// Moves the axis from its last motion to its present one. `ended`: the instructions of cams that end meanwhile.
    pub(super) fn go(
        &mut self,
        to: KinematicState,
        clock: &Clock,
        edges: &mut Vec<Edge>,
        ended: &mut [Option<Execution>; 2],
    ) {
        let period = clock.period();
        let pieces = [(self.last, self.began, true), (self.began, to, false)];
        for (from, to, jumps) in pieces {
            if jumps && from == to {
                continue;
            }
            let piece = Piece {
                from,
                to,
                jumps,
                period,
            };
            self.walk(&piece, clock, edges, ended);
        }
        self.last = to;
        self.began = to;
    }

    /// The axis position of the active cam's zero.
    pub(super) fn zero(&self) -> f64 {
        let length = self.cams[ACTIVE].cam().map_or(0.0, |cam| cam.end - cam.start);
        self.base + self.turns * length
    }

    /// The turns of the axis that belong to the active cam: in those behind it the pending cam applies, in those before it the previous one.
    pub(super) fn turns_of_active(&self) -> Turns {
        let repeats = |mode: ExecutionMode| mode == ExecutionMode::Continuous;
        if !self.cams[ACTIVE]
            .program
            .as_ref()
            .is_some_and(|program| repeats(program.mode))
        {
            return Turns::ONE;
        }
        let mut turns = Turns::ALL;
        if self.cams[PENDING].program.is_some() {
            if self.forward {
                turns.last = 0.0;
            } else {
                turns.first = 0.0;
            }
        }
        match self.came_forward {
            None => {}
            Some(true) => turns.first = turns.first.max(-self.turns),
            Some(false) => turns.last = turns.last.min(-self.turns),
        }
        turns
    }

    fn walk(&mut self, piece: &Piece, clock: &Clock, edges: &mut Vec<Edge>, ended: &mut [Option<Execution>; 2]) {
        let interval = piece.interpolation(0.0);
        if interval.to != interval.from {
            self.forward = interval.to > interval.from;
        }
        let mut share = 0.0;
        for _ in 0..MOST_CUTS {
            match self.phase {
                Phase::Free => return,
                Phase::Ending => {
                    self.run(piece, share, 1.0, clock, edges);
                    return;
                }
                Phase::Waiting(lock) => {
                    let Some(crossed) = lock.crossed(interval.at(share), interval.to) else {
                        self.run(piece, share, 1.0, clock, edges);
                        return;
                    };
                    let until = interval.share_of(crossed).max(share);
                    self.run(piece, share, until, clock, edges);
                    share = until;
                    let at = instant(piece, share, clock);
                    self.arm(crossed, |delay| piece.interpolation(delay).at(share), at);
                    self.phase = Phase::Armed;
                }
                Phase::Armed => {
                    let Some((until, position)) = self.exit(&interval, share) else {
                        self.run(piece, share, 1.0, clock, edges);
                        return;
                    };
                    self.run(piece, share, until, clock, edges);
                    share = until;
                    let at = instant(piece, share, clock);
                    let over = self.end_active(position, at);
                    if let Some(free) = ended.iter_mut().find(|ended| ended.is_none()) {
                        *free = over;
                    }
                }
            }
        }
    }

    /// The point after a share of the interval at which the axis leaves a cam that ends there: its share and its position.
    fn exit(&self, interval: &Interpolation, share: f64) -> Option<(f64, f64)> {
        let program = self.cams[ACTIVE].program.as_ref()?;
        if program.mode != ExecutionMode::Once && self.cams[PENDING].program.is_none() {
            return None;
        }
        let zero = self.zero();
        let rounding = OUTPUT_CAM_SHARE * (program.cam.end - program.cam.start);
        let (start, end) = (zero + program.cam.start, zero + program.cam.end);
        let beyond = |position: f64| position > end + rounding || position < start - rounding;
        let here = interval.at(share);
        if beyond(here) {
            // The axis left a persistent cam in an earlier update.
            return Some((share, here));
        }
        if !beyond(interval.to) {
            return None;
        }
        let bound = if interval.to > here { end } else { start };
        Some((interval.share_of(bound).max(share), bound))
    }

    /// Arms the cam at a position of the axis. `ahead`: the position with a delay.
    pub(super) fn arm(&mut self, position: f64, ahead: impl Fn(f64) -> f64, at: Instant) {
        (self.base, self.turns) = (position - self.entry, 0.0);
        for element in 0..self.cams[ACTIVE].states.len() {
            let Some((own, compensation)) = self.cams[ACTIVE].element(element) else {
                continue;
            };
            let window = self.window(ACTIVE, own, compensation);
            let inside = [true, false].map(|latch| window.contains(ahead(compensation.delay(latch))));
            self.correct(ACTIVE, element, inside, at);
        }
        self.arm_enabled(at);
    }

    /// Advances durations, whole turns and the shown bits to the present tick.
    pub(super) fn settle(&mut self, clock: &Clock) {
        let now = clock.now();
        self.expire(now, clock);
        self.let_pass(now);
        (self.locked, self.pending_sets_bits, self.in_transition) = (false, false, false);
        let Some(program) = self.cams[ACTIVE].program.as_ref() else {
            return;
        };
        if self.phase != Phase::Armed {
            return;
        }
        let (cam, repeats) = (&program.cam, program.mode == ExecutionMode::Continuous);
        let length = cam.end - cam.start;
        let from_base = self.last.position - self.base;
        let is_behind = |forward: bool| {
            if forward {
                from_base < cam.start
            } else {
                from_base > cam.end
            }
        };
        if self.came_forward.is_some_and(is_behind) {
            // The axis is back across the point of the takeover: the cam repeats in that direction, too.
            self.came_forward = None;
        }
        let turns = ((self.last.position - self.zero() - cam.start) / length).floor();
        if repeats && self.cams[PENDING].program.is_none() {
            self.turns += turns;
        }
        let position = self.last.position - self.zero();
        self.locked = (cam.start..=cam.end).contains(&position);
        let beyond = |compensation: &Compensation| {
            [true, false].into_iter().any(|latch| {
                let position = position + compensation.delay(latch) * self.last.velocity - compensation.offset;
                if self.forward {
                    position > cam.end
                } else {
                    position < cam.start
                }
            })
        };
        self.pending_sets_bits = self.cams[PENDING].cam().is_some_and(|cam| {
            (0..OUTPUT_BITS).any(|bit| cam.mask & (1 << bit) != 0 && beyond(&cam.compensation[bit]))
        });
        self.in_transition = self.pending_sets_bits || self.lags();
    }
}
