//! One execution target of an axis: the output cam that is armed there, the one that waits for its end, and what still goes on of
//! the one before.
//!
//! What instructions do to it is here, and the bits that come of it. Not here: where the axis goes ([`pieces`]), what happens to
//! elements there ([`events`]), and what a cam leaves behind ([`tail`]). Positions are those of the axis without what it was
//! redefined by; the cam's own begin at `zero` of them. Real-time: nothing allocates; an update is bounded by the elements of three
//! cams. Units: position units, seconds.

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
use tail::Trailing;

/// The arming of a cam that does not wait for the end of another.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Arming {
    /// Where it is armed; `None`: at once.
    pub(crate) lock: Option<Crossing>,
    /// Position of the cam there.
    pub(crate) entry: f64,
    pub(crate) reference: Reference,
    /// The tags of its output and its input, and what is in them.
    pub(crate) output: Word,
    pub(crate) input: Option<Word>,
}

/// Bits of a tag.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Word {
    /// By what the directory calls it.
    pub(crate) tag: TagAddress,
    /// Which bits.
    pub(crate) mask: u32,
    pub(crate) bits: u32,
}

/// The result of an update.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Outcome {
    /// Instructions whose cams have ended by themselves.
    pub(crate) ended: [Option<Execution>; 2],
    /// Bits that are others than before.
    pub(crate) written: Option<Word>,
}

/// Bits of OutputCamStatus, PendingStatus, LockStatus and TransitionStatus of a target.
pub(crate) type TargetStatus = [bool; 4];

#[derive(Clone, Debug)]
pub(crate) struct Target {
    phase: Phase,
    /// The cam that is armed, the pending one, and the one before.
    cams: [CamState; 3],
    pub(crate) reference: Reference,
    entry: f64,
    output: Word,
    input: Option<Word>,
    /// Where the cam's positions begin: the base and so many turns of a repeated cam.
    base: f64,
    turns: f64,
    /// It took over from another one: forwards, or in reverse.
    came_forward: Option<bool>,
    forward: bool,
    /// The axis as the states know it.
    last: KinematicState,
    /// The axis when the update that is under way began: instructions have changed its speed since.
    pub(super) began: KinematicState,
    /// Bits that are latched, and since when.
    on: u32,
    since: [Instant; OUTPUT_BITS],
    /// How the cam before was left, while edges of it are to come or durations run.
    trailing: Option<Trailing>,
    /// Durations of elements that nothing else is left of, and how their bits show.
    trailing_bits: [Option<Instant>; OUTPUT_BITS],
    trailing_bits_as: [Compensation; OUTPUT_BITS],
    /// The bits that are cams' now, as they were written last.
    written: Word,
    /// Bits that are set as they were written last, also those of cams that are over.
    set: u32,
    locked: bool,
    /// The pending cam sets bits already.
    leads: bool,
    in_transition: bool,
    /// For the length of a tick alone.
    ticks: Clock,
}

impl Target {
    pub(super) fn new(clock: &Clock) -> Self {
        let now = clock.now();
        Target {
            phase: Phase::Free,
            cams: [CamState::new(), CamState::new(), CamState::new()],
            reference: Reference::Actual,
            entry: 0.0,
            output: Word::default(),
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
            written: Word::default(),
            set: 0,
            locked: false,
            leads: false,
            in_transition: false,
            ticks: *clock,
        }
    }

    /// Whether nothing of an axis concerns it.
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

    /// A cam in place of the one that is there, whose durations run out where both have one output. Returns whose it was.
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
        self.written = Word::default();
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

    /// A cam that waits for the end of the armed one. Returns whose had waited.
    pub(crate) fn wait(&mut self, program: ArmedCam, clock: &Clock) -> Option<Execution> {
        let before = self.cams[PENDING].program.take().map(|program| program.execution);
        self.cams[PENDING].load(program);
        self.enable(PENDING, clock.now());
        self.settle(clock);
        before
    }

    /// Nothing is armed or waits any more; the bits stay as they are. Returns whose cams these were.
    pub(super) fn disarm(&mut self) -> [Option<Execution>; 2] {
        let alive = self.is_alive();
        self.forget();
        let [active, pending, _] = &mut self.cams;
        let ended = [active.take().filter(|_| alive), pending.take()];
        self.phase = Phase::Free;
        self.written = Word::default();
        (self.locked, self.leads, self.in_transition) = (false, false, false);
        ended
    }

    /// Some bits of a tag have become others.
    pub(super) fn take_word(&mut self, word: &Word, clock: &Clock) {
        let mut changed = false;
        let (own, words) = (self.written.mask, [Some(&mut self.output), self.input.as_mut()]);
        for (word_index, mine) in words.into_iter().enumerate() {
            if let Some(mine) = mine.filter(|mine| mine.tag == word.tag) {
                // A client that writes the whole word may write bits of the target as they were before: the target's own are newer.
                let mask = if word_index == 0 { word.mask & !own } else { word.mask };
                let bits = (mine.bits & !mask) | (word.bits & mask);
                changed |= std::mem::replace(&mut mine.bits, bits) != bits || word_index == 0;
            }
        }
        if changed && !self.is_idle() {
            self.enable_all(clock.now());
        }
    }

    /// The axis has come to where it is now.
    pub(super) fn look(&mut self, to: KinematicState, clock: &Clock, edges: &mut Vec<Edge>) -> [Option<Execution>; 2] {
        let mut ended = [None; 2];
        if self.trailing.is_none() {
            // Its last bits have been written.
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

    /// Bits that it has set, also for cams that are over.
    pub(super) fn bits(&self) -> u32 {
        self.set
    }

    /// The bits as they are now, if they are others than those that were written last. Bits that it owns no longer are written a last
    /// time.
    pub(crate) fn write(&mut self, clock: &Clock) -> Option<Word> {
        let owned = self.owned();
        let before = self.written;
        let mask = owned | before.mask;
        let word = Word {
            tag: self.output.tag,
            mask,
            bits: self.shown_bits(mask, clock),
        };
        self.written = Word {
            mask: owned,
            bits: word.bits & owned,
            ..word
        };
        self.output.bits = (self.output.bits & !mask) | word.bits;
        self.set = (self.set & !mask) | word.bits;
        let changed = mask & !before.mask != 0 || (word.bits ^ before.bits) & mask != 0;
        changed.then_some(word)
    }

    /// The bits that cams set and clear now.
    fn owned(&self) -> u32 {
        let mask = |cam_index: usize| self.cams[cam_index].cam().map_or(0, |cam| cam.mask);
        let active = if self.phase == Phase::Armed { mask(ACTIVE) } else { 0 };
        let pending = if self.leads { mask(PENDING) } else { 0 };
        active | pending | self.tail()
    }

    /// Bits of a mask as they show.
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

    /// A cam is armed, or is going to be where the axis crosses its arm position.
    fn is_alive(&self) -> bool {
        matches!(self.phase, Phase::Waiting(_) | Phase::Armed)
    }
}
