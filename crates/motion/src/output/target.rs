//! One execution target of an axis: the output cam that is armed there, and the one that waits for its end.
//!
//! Positions here are those of the axis without what it was redefined by; the cam's own begin at `zero` of them. Real-time:
//! nothing allocates; an update is bounded by the elements of two cams. Units: position units, seconds.

mod events;

use std::sync::Arc;

use arcline_drive::Motion as Point;
use arcline_planner::{Clock, Instant};

use super::course::Course;
use super::element::{Happens, State};
use super::program::{Compensation, Element, MAX_OUTPUT_ELEMENTS, OUTPUT_BITS, OutputCam};
use crate::control::Execution;
use crate::follow::cam::{Lock, Mode};
use crate::follow::gear::Reference;
use events::instant;
pub(super) use events::{Edge, MOST_EDGES};

/// An output cam that an instruction has brought.
#[derive(Clone, Debug)]
pub(crate) struct Program {
    pub(crate) cam: Arc<OutputCam>,
    pub(crate) mode: Mode,
    pub(crate) execution: Execution,
}

/// What an instruction says of a cam that does not wait for the end of another.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Arming {
    /// Where it is armed; `None`: at once.
    pub(crate) lock: Option<Lock>,
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
    pub(crate) tag: u32,
    /// Which bits.
    pub(crate) mask: u32,
    pub(crate) bits: u32,
}

/// What an update has brought.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Outcome {
    /// Instructions whose cams have ended by themselves.
    pub(crate) ended: [Option<Execution>; 2],
    /// Bits that are others than before.
    pub(crate) written: Option<Word>,
}

/// Bits of OutputCamStatus, PendingStatus, LockStatus and TransitionStatus of a target.
pub(crate) type Shown = [bool; 4];

#[derive(Clone, Copy, Debug, PartialEq)]
enum Phase {
    Free,
    /// Until the axis crosses the arm position.
    Waiting(Lock),
    Armed,
    /// It is over, but for durations.
    Ending,
}

/// A cam with the states of its elements.
#[derive(Clone, Debug)]
struct Lane {
    program: Option<Program>,
    states: Vec<State>,
}

#[derive(Clone, Debug)]
pub(crate) struct Target {
    phase: Phase,
    /// The cam that is armed, and the pending one.
    lanes: [Lane; 2],
    pub(crate) reference: Reference,
    entry: f64,
    output: Word,
    input: Option<Word>,
    /// Where the cam's positions begin: the base and so many turns of a repeated cam.
    base: f64,
    turns: f64,
    forward: bool,
    /// The axis as the states know it.
    last: Point,
    /// The axis when the update that is under way began: instructions have changed its speed since.
    pub(super) began: Point,
    /// Bits that are latched, and since when.
    on: u32,
    since: [Instant; OUTPUT_BITS],
    /// Durations of elements of cams that are over.
    carried: [Option<Instant>; OUTPUT_BITS],
    written: Word,
    locked: bool,
    in_transition: bool,
    /// For the length of a tick alone.
    ticks: Clock,
}

/// Most a piece of an update is cut into: at the arm position and at ends of cams.
const MOST_CUTS: usize = 4;
/// What of a cam's position is rounding: a share of its length.
const ROUNDING: f64 = 1e-12;
const ACTIVE: usize = 0;
const PENDING: usize = 1;

/// A way of the axis within an update, or a change of its speed at the beginning of one.
struct Piece {
    from: Point,
    to: Point,
    jumps: bool,
    period: f64,
}

impl Piece {
    /// The position of the axis, `delay` ahead.
    fn course(&self, delay: f64) -> Course {
        let [from, to] = [&self.from, &self.to].map(|point| {
            let rate = point.velocity + delay * point.acceleration;
            [point.position + delay * point.velocity, rate]
        });
        if self.jumps {
            Course::step(from[0], to[0])
        } else {
            Course::new(from, to, self.period)
        }
    }
}

impl Target {
    pub(super) fn new(clock: &Clock) -> Self {
        let now = clock.now();
        let lane = || Lane {
            program: None,
            states: Vec::with_capacity(MAX_OUTPUT_ELEMENTS),
        };
        Target {
            phase: Phase::Free,
            lanes: [lane(), lane()],
            reference: Reference::Actual,
            entry: 0.0,
            output: Word::default(),
            input: None,
            base: 0.0,
            turns: 0.0,
            forward: true,
            last: Point::default(),
            began: Point::default(),
            on: 0,
            since: [now; OUTPUT_BITS],
            carried: [None; OUTPUT_BITS],
            written: Word::default(),
            locked: false,
            in_transition: false,
            ticks: *clock,
        }
    }

    /// Whether nothing of an axis concerns it.
    pub(super) fn is_idle(&self) -> bool {
        self.phase == Phase::Free
    }

    pub(super) fn shown(&self) -> Shown {
        [
            matches!(self.phase, Phase::Waiting(_) | Phase::Armed),
            self.lanes[PENDING].program.is_some(),
            self.locked,
            self.in_transition,
        ]
    }

    /// A cam in place of the one that is there. Returns whose it was.
    pub(crate) fn begin(&mut self, program: Program, arming: &Arming, at: Point, clock: &Clock) -> Option<Execution> {
        let before = self.lanes[ACTIVE].program.take().map(|program| program.execution);
        let ended = before.filter(|_| matches!(self.phase, Phase::Waiting(_) | Phase::Armed));
        self.phase = Phase::Free;
        self.lanes[ACTIVE].load(program);
        self.entry = arming.entry;
        self.reference = arming.reference;
        self.output = arming.output;
        self.input = arming.input;
        self.on = 0;
        self.carried = [None; OUTPUT_BITS];
        self.written = Word::default();
        (self.locked, self.in_transition) = (false, false);
        (self.last, self.began) = (at, at);
        for lane in [ACTIVE, PENDING] {
            self.enable(lane, clock.now());
        }
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
    pub(crate) fn wait(&mut self, program: Program, clock: &Clock) -> Option<Execution> {
        let before = self.lanes[PENDING].program.take().map(|program| program.execution);
        self.lanes[PENDING].load(program);
        self.enable(PENDING, clock.now());
        self.settle(clock);
        before
    }

    /// Nothing is armed or waits any more; the bits stay as they are. Returns whose cams these were.
    pub(super) fn disarm(&mut self) -> [Option<Execution>; 2] {
        let alive = matches!(self.phase, Phase::Waiting(_) | Phase::Armed);
        let [active, pending] = &mut self.lanes;
        let ended = [active.take().filter(|_| alive), pending.take()];
        self.phase = Phase::Free;
        (self.locked, self.in_transition) = (false, false);
        ended
    }

    /// Some bits of a tag have become others.
    pub(super) fn take_word(&mut self, word: &Word, clock: &Clock) {
        let mut changed = false;
        let (own, words) = (self.written.mask, [Some(&mut self.output), self.input.as_mut()]);
        for (place, mine) in words.into_iter().enumerate() {
            if let Some(mine) = mine.filter(|mine| mine.tag == word.tag) {
                // What it has written itself it knows better than whoever writes the word as it was.
                let mask = if place == 0 { word.mask & !own } else { word.mask };
                let bits = (mine.bits & !mask) | (word.bits & mask);
                changed |= std::mem::replace(&mut mine.bits, bits) != bits || place == 0;
            }
        }
        if changed && !self.is_idle() {
            for lane in [ACTIVE, PENDING] {
                self.enable(lane, clock.now());
            }
        }
    }

    /// The axis has come to where it is now.
    pub(super) fn look(&mut self, to: Point, clock: &Clock, edges: &mut Vec<Edge>) -> [Option<Execution>; 2] {
        let mut ended = [None; 2];
        if self.phase == Phase::Ending && self.carried.iter().all(Option::is_none) {
            self.lanes[ACTIVE].take();
            self.phase = Phase::Free;
            return ended;
        }
        let period = clock.period();
        let pieces = [(self.last, self.began, true), (self.began, to, false)];
        for (from, to, jumps) in pieces {
            if jumps && (from == to || self.phase == Phase::Ending) {
                continue;
            }
            let piece = Piece {
                from,
                to,
                jumps,
                period,
            };
            self.walk(&piece, clock, edges, &mut ended);
        }
        self.last = to;
        self.began = to;
        self.settle(clock);
        ended
    }

    /// The bits that it has written last and that are set.
    pub(super) fn bits(&self) -> u32 {
        self.written.bits
    }

    /// The bits as they are now, if they are others than those that were written last.
    pub(crate) fn write(&mut self, clock: &Clock) -> Option<Word> {
        let word = self.word(clock);
        let before = std::mem::replace(&mut self.written, word);
        (word.mask != 0 && word != before).then_some(word)
    }

    fn word(&self, clock: &Clock) -> Word {
        let mut word = Word {
            tag: self.output.tag,
            ..Word::default()
        };
        if matches!(self.phase, Phase::Free | Phase::Waiting(_)) {
            return word;
        }
        let cams = self.lanes.each_ref().map(Lane::cam);
        let lead = if self.in_transition { cams[PENDING] } else { None };
        for cam in [cams[ACTIVE], lead].into_iter().flatten() {
            for bit in (0..OUTPUT_BITS).filter(|bit| cam.mask & !word.mask & (1 << bit) != 0) {
                let Compensation { inverted, pulses, .. } = cam.compensation[bit];
                let mut on = self.on & (1 << bit) != 0;
                if let Some((cycle, duty)) = pulses.filter(|_| on) {
                    let cycles = self.since[bit].elapsed(clock) / cycle;
                    on = cycles - cycles.floor() < duty;
                }
                word.bits |= u32::from(on != inverted) << bit;
            }
            word.mask |= cam.mask;
        }
        word
    }

    fn zero(&self) -> f64 {
        let length = self.lanes[ACTIVE].cam().map_or(0.0, |cam| cam.end - cam.start);
        self.base + self.turns * length
    }

    fn walk(&mut self, piece: &Piece, clock: &Clock, edges: &mut Vec<Edge>, ended: &mut [Option<Execution>; 2]) {
        let way = piece.course(0.0);
        if way.to != way.from {
            self.forward = way.to > way.from;
        }
        let mut share = 0.0;
        for _ in 0..MOST_CUTS {
            match self.phase {
                Phase::Free | Phase::Ending => return,
                Phase::Waiting(lock) => {
                    let Some(crossed) = lock.crossed(way.at(share), way.to) else {
                        return;
                    };
                    share = way.share_of(crossed).max(share);
                    let at = instant(piece, share, clock);
                    self.arm(crossed, |delay| piece.course(delay).at(share), at);
                    self.phase = Phase::Armed;
                }
                Phase::Armed => {
                    let Some((until, place)) = self.exit(&way, share) else {
                        self.run(piece, share, 1.0, clock, edges);
                        return;
                    };
                    self.run(piece, share, until, clock, edges);
                    share = until;
                    let at = instant(piece, share, clock);
                    let over = self.leave(place, at);
                    if let Some(free) = ended.iter_mut().find(|ended| ended.is_none()) {
                        *free = over;
                    }
                }
            }
        }
    }

    /// Where, on its way from a share on, the axis leaves a cam that ends there: the share, and the place.
    fn exit(&self, way: &Course, share: f64) -> Option<(f64, f64)> {
        let program = self.lanes[ACTIVE].program.as_ref()?;
        if program.mode != Mode::Once && self.lanes[PENDING].program.is_none() {
            return None;
        }
        let zero = self.zero();
        let rounding = ROUNDING * (program.cam.end - program.cam.start);
        let (start, end) = (zero + program.cam.start, zero + program.cam.end);
        let beyond = |place: f64| place > end + rounding || place < start - rounding;
        let here = way.at(share);
        if beyond(here) {
            // A persistent one was left long ago.
            return Some((share, here));
        }
        if !beyond(way.to) {
            return None;
        }
        let bound = if way.to > here { end } else { start };
        Some((way.share_of(bound).max(share), bound))
    }

    /// The cam is armed where the axis is at a place. `ahead`: where it is with a delay.
    fn arm(&mut self, place: f64, ahead: impl Fn(f64) -> f64, at: Instant) {
        (self.base, self.turns) = (place - self.entry, 0.0);
        for element in 0..self.lanes[ACTIVE].states.len() {
            let Some((own, compensation)) = self.lanes[ACTIVE].element(element) else {
                continue;
            };
            let window = self.window(ACTIVE, own, compensation);
            let inside = [true, false].map(|latch| window.contains(ahead(compensation.delay(latch))));
            self.correct(ACTIVE, element, inside, at);
        }
        self.arm_enabled(at);
    }

    /// The armed cam is over at a place; the pending one takes over. Returns whose is over.
    fn leave(&mut self, place: f64, at: Instant) -> Option<Execution> {
        let zero = self.zero();
        for element in 0..self.lanes[ACTIVE].states.len() {
            for what in [Happens::LatchLeft, Happens::UnlatchLeft] {
                self.happens(ACTIVE, element, what, at);
            }
            // Durations go on without it.
            let Some((own, _)) = self.lanes[ACTIVE].element(element) else {
                continue;
            };
            let bit = usize::from(own.bit);
            let state = &mut self.lanes[ACTIVE].states[element];
            if let Some(off_at) = state.off_at.take() {
                self.carried[bit] = Some(off_at);
            }
            state.holds = false;
        }
        let over = self.lanes[ACTIVE].program.as_ref().map(|program| program.execution);
        if self.lanes[PENDING].program.is_none() {
            self.phase = Phase::Ending;
            return over;
        }
        let forward = self.lanes[ACTIVE].cam().is_none_or(|cam| place - zero >= cam.end);
        self.lanes[ACTIVE].take();
        self.lanes.swap(ACTIVE, PENDING);
        let entry = self.lanes[ACTIVE]
            .cam()
            .map_or(0.0, |cam| if forward { cam.start } else { cam.end });
        (self.base, self.turns) = (place - entry, 0.0);
        self.arm_enabled(at);
        over
    }

    /// What is true at the present tick: durations, whole turns, what is shown.
    fn settle(&mut self, clock: &Clock) {
        let now = clock.now();
        self.expire(now, clock);
        (self.locked, self.in_transition) = (false, false);
        let Some(program) = self.lanes[ACTIVE].program.as_ref() else {
            return;
        };
        if self.phase != Phase::Armed {
            return;
        }
        let (cam, repeats) = (&program.cam, program.mode == Mode::Continuous);
        let length = cam.end - cam.start;
        let turns = ((self.last.position - self.zero() - cam.start) / length).floor();
        if repeats && self.lanes[PENDING].program.is_none() {
            self.turns += turns;
        }
        let place = self.last.position - self.zero();
        self.locked = (cam.start..=cam.end).contains(&place);
        let beyond = |compensation: &Compensation| {
            [true, false].into_iter().any(|latch| {
                let place = place + compensation.delay(latch) * self.last.velocity - compensation.offset;
                if self.forward {
                    place > cam.end
                } else {
                    place < cam.start
                }
            })
        };
        self.in_transition = self.lanes[PENDING].cam().is_some_and(|cam| {
            (0..OUTPUT_BITS).any(|bit| cam.mask & (1 << bit) != 0 && beyond(&cam.compensation[bit]))
        });
    }
}

impl Lane {
    fn load(&mut self, program: Program) {
        self.states.clear();
        self.states.resize(program.cam.elements.len(), State::default());
        self.program = Some(program);
    }

    fn take(&mut self) -> Option<Execution> {
        self.states.clear();
        self.program.take().map(|program| program.execution)
    }

    fn cam(&self) -> Option<&Arc<OutputCam>> {
        self.program.as_ref().map(|program| &program.cam)
    }

    /// An element with what compensates its bit.
    fn element(&self, place: usize) -> Option<(&Element, &Compensation)> {
        let cam = self.cam()?;
        let element = cam.elements.get(place)?;
        Some((element, &cam.compensation[usize::from(element.bit)]))
    }
}

impl Compensation {
    fn delay(&self, latch: bool) -> f64 {
        if latch { self.latch_delay } else { self.unlatch_delay }
    }
}
