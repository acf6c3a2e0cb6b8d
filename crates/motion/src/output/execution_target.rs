//! One execution target of an axis: its active output cam, its pending one, and the elements and durations that remain of the previous
//! one.
//!
//! This module handles instructions and the resulting bits. Not here: the motion of the axis ([`pieces`]), the events of elements
//! ([`events`]), and the remains of an ended cam ([`tail`]). Positions are those of the axis without the offset of redefined positions;
//! those of the cam begin at `zero`. Real-time: nothing allocates; an update is bounded by the elements of three cams. Units: position
//! units, seconds.

mod cam_state;
mod events;
mod piece;
mod pieces;
mod tail;

use arcline_instruction_set::TagAddress;
use std::sync::Arc;

use arcline_planner::{Clock, Instant};
use arcline_profile::KinematicState;

use super::program::{Compensation, OUTPUT_BITS, OutputCam};
use crate::execution::Execution;
use crate::masters::displacement::Crossing;
use arcline_instruction_set::enumerations::Reference;
pub(crate) use cam_state::ArmedCam;
use cam_state::{ACTIVE, CamState, PENDING, Phase, TAIL};
pub(super) use events::{Edge, MOST_EDGES};
use tail::CamExit;

/// The arming of a cam that is not pending.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Arming {
    /// The position at which the cam is armed; `None`: at once.
    pub(crate) lock: Option<Crossing>,
    /// Position of the cam at that point.
    pub(crate) entry: f64,
    pub(crate) reference: Reference,
    /// The tags of its output and its input, and their values.
    pub(crate) output: TagBits,
    pub(crate) input: Option<TagBits>,
}

/// Bits of a tag.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct TagBits {
    /// Its address in the directory.
    pub(crate) tag: TagAddress,
    /// The bits that count.
    pub(crate) mask: u32,
    pub(crate) bits: u32,
}

/// The result of an update.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Outcome {
    /// Instructions whose cams have ended.
    pub(crate) ended: [Option<Execution>; 2],
    /// Bits that have changed.
    pub(crate) written: Option<TagBits>,
}

/// Bits of OutputCamStatus, PendingStatus, LockStatus and TransitionStatus of a target.
pub(crate) type TargetStatus = [bool; 4];

#[derive(Clone, Debug)]
pub(crate) struct ExecutionTarget {
    phase: Phase,
    /// The active cam, the pending one, and the previous one.
    cams: [CamState; 3],
    pub(crate) reference: Reference,
    entry: f64,
    output: TagBits,
    input: Option<TagBits>,
    /// The axis position of the active cam's zero: the base, plus the turns of a repeated cam.
    base: f64,
    turns: f64,
    /// The direction in which it took over from another cam, if it did: forward, or reverse.
    came_forward: Option<bool>,
    forward: bool,
    /// The motion of the axis at the last update.
    last: KinematicState,
    /// The motion of the axis at the beginning of the present update; instructions may have changed its velocity since.
    pub(super) began: KinematicState,
    /// Bits that are latched, and the instants at which they were.
    on: u32,
    since: [Instant; OUTPUT_BITS],
    /// The exit from the previous cam, while events of it are pending or durations run.
    trailing: Option<CamExit>,
    /// Durations that continue without their elements, and the compensations that shape their bits.
    trailing_bits: [Option<Instant>; OUTPUT_BITS],
    trailing_bits_as: [Compensation; OUTPUT_BITS],
    /// The bits that cams own now, as last written.
    written: TagBits,
    /// Bits that are set, as last written, including those of ended cams.
    set: u32,
    locked: bool,
    /// The pending cam already sets bits, by its compensation.
    pending_sets_bits: bool,
    in_transition: bool,
    /// Holds the length of a tick only.
    ticks: Clock,
}

impl ExecutionTarget {
    pub(super) fn new(clock: &Clock) -> Self {
        let now = clock.now();
        ExecutionTarget {
            phase: Phase::Free,
            cams: [CamState::new(), CamState::new(), CamState::new()],
            reference: Reference::Actual,
            entry: 0.0,
            output: TagBits::default(),
            input: None,
            base: 0.0,
            turns: 0.0,
            came_forward: None,
            forward: true,
            last: KinematicState::default(),
            began: KinematicState::default(),
            on: 0,
            since: [now; OUTPUT_BITS],
            trailing: None,
            trailing_bits: [None; OUTPUT_BITS],
            trailing_bits_as: [Compensation::default(); OUTPUT_BITS],
            written: TagBits::default(),
            set: 0,
            locked: false,
            pending_sets_bits: false,
            in_transition: false,
            ticks: *clock,
        }
    }

    /// The target needs no updates of the axis.
    pub(super) fn is_idle(&self) -> bool {
        self.phase == Phase::Free
    }

    pub(super) fn shown(&self) -> TargetStatus {
        [
            self.is_alive(),
            self.cams[PENDING].program.is_some(),
            self.locked,
            self.in_transition,
        ]
    }

    /// Begins a cam in place of the active one; that one's durations run out if both have the same output. Returns the instruction of the
    /// replaced cam.
    pub(crate) fn begin(
        &mut self,
        program: ArmedCam,
        arming: &Arming,
        at: KinematicState,
        clock: &Clock,
    ) -> Option<Execution> {
        let before = self.cams[ACTIVE].program.as_ref().map(|program| program.execution);
        let ended = before.filter(|_| self.is_alive());
        if self.phase != Phase::Free && self.output.tag == arming.output.tag {
            self.carry(ACTIVE);
        } else {
            self.forget();
            self.set = 0;
        }
        self.phase = Phase::Free;
        self.cams[ACTIVE].load(program);
        self.on &= self.held();
        self.entry = arming.entry;
        self.reference = arming.reference;
        self.output = arming.output;
        self.input = arming.input;
        self.came_forward = None;
        self.written = TagBits::default();
        (self.last, self.began) = (at, at);
        self.enable_all(clock.now());
        self.phase = match arming.lock {
            Some(lock) => Phase::Waiting(lock),
            None => {
                self.arm(at.position, |delay| at.position + delay * at.velocity, clock.now());
                Phase::Armed
            }
        };
        self.settle(clock);
        ended
    }

    /// Makes a cam pending. Returns the instruction of the one that was pending before.
    pub(crate) fn wait(&mut self, program: ArmedCam, clock: &Clock) -> Option<Execution> {
        let before = self.cams[PENDING].program.take().map(|program| program.execution);
        self.cams[PENDING].load(program);
        self.enable(PENDING, clock.now());
        self.settle(clock);
        before
    }

    /// Disarms the target; the bits keep their values. Returns the instructions of the disarmed cams.
    pub(super) fn disarm(&mut self) -> [Option<Execution>; 2] {
        let alive = self.is_alive();
        self.forget();
        let [active, pending, _] = &mut self.cams;
        let ended = [active.take().filter(|_| alive), pending.take()];
        self.phase = Phase::Free;
        self.written = TagBits::default();
        (self.locked, self.pending_sets_bits, self.in_transition) = (false, false, false);
        ended
    }

    /// Takes a change of some bits of a tag.
    pub(super) fn take_word(&mut self, word: &TagBits, clock: &Clock) {
        let mut changed = false;
        let (own, words) = (self.written.mask, [Some(&mut self.output), self.input.as_mut()]);
        for (word_index, mine) in words.into_iter().enumerate() {
            if let Some(mine) = mine.filter(|mine| mine.tag == word.tag) {
                // A client that writes the whole word may write old bits of the target; the target's own ones are newer.
                let mask = if word_index == 0 { word.mask & !own } else { word.mask };
                let bits = (mine.bits & !mask) | (word.bits & mask);
                changed |= std::mem::replace(&mut mine.bits, bits) != bits || word_index == 0;
            }
        }
        if changed && !self.is_idle() {
            self.enable_all(clock.now());
        }
    }

    /// Updates the target with the position of the axis.
    pub(super) fn update(
        &mut self,
        to: KinematicState,
        clock: &Clock,
        edges: &mut Vec<Edge>,
    ) -> [Option<Execution>; 2] {
        let mut ended = [None; 2];
        if self.trailing.is_none() {
            // The last bits of the previous cam have been written.
            self.cams[TAIL].take();
            if self.phase == Phase::Ending && self.trailing_bits.iter().all(Option::is_none) {
                self.phase = Phase::Free;
                return ended;
            }
        }
        self.go(to, clock, edges, &mut ended);
        self.settle(clock);
        ended
    }

    /// Bits that it has set, including those of ended cams.
    pub(super) fn bits(&self) -> u32 {
        self.set
    }

    /// The present bits, if they differ from the last ones written. Bits that the target no longer owns are written one last time.
    pub(crate) fn write(&mut self, clock: &Clock) -> Option<TagBits> {
        let owned = self.owned();
        let before = self.written;
        let mask = owned | before.mask;
        let word = TagBits {
            tag: self.output.tag,
            mask,
            bits: self.shown_bits(mask, clock),
        };
        self.written = TagBits {
            mask: owned,
            bits: word.bits & owned,
            ..word
        };
        self.output.bits = (self.output.bits & !mask) | word.bits;
        self.set = (self.set & !mask) | word.bits;
        let changed = mask & !before.mask != 0 || (word.bits ^ before.bits) & mask != 0;
        changed.then_some(word)
    }

    /// The bits that its cams set and clear.
    fn owned(&self) -> u32 {
        let mask = |cam_index: usize| self.cams[cam_index].cam().map_or(0, |cam| cam.mask);
        let active = if self.phase == Phase::Armed { mask(ACTIVE) } else { 0 };
        let pending = if self.pending_sets_bits { mask(PENDING) } else { 0 };
        active | pending | self.tail()
    }

    /// The shown values of the bits of a mask.
    fn shown_bits(&self, mask: u32, clock: &Clock) -> u32 {
        let mut bits = 0;
        for bit in (0..OUTPUT_BITS).filter(|bit| mask & (1 << bit) != 0) {
            let of_cam = |cam: &&Arc<OutputCam>| cam.mask & (1 << bit) != 0;
            let cams = [ACTIVE, TAIL, PENDING].map(|cam_index| self.cams[cam_index].cam());
            let cam = cams.into_iter().flatten().find(of_cam);
            let Compensation { inverted, pulses, .. } =
                cam.map_or(self.trailing_bits_as[bit], |cam| cam.compensation[bit]);
            let mut on = self.on & (1 << bit) != 0;
            if let Some((cycle, duty)) = pulses.filter(|_| on) {
                let cycles = self.since[bit].elapsed(clock) / cycle;
                on = cycles - cycles.floor() < duty;
            }
            bits |= u32::from(on != inverted) << bit;
        }
        bits
    }

    /// A cam is armed, or will be when the axis crosses its arm position.
    fn is_alive(&self) -> bool {
        matches!(self.phase, Phase::Waiting(_) | Phase::Armed)
    }
}
