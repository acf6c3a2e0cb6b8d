//! The command of one axis as the sum of everything that moves it at the same time (spec/axis-and-data-types.md §1.6).
//!
//! Each generator has its own frame: the positions that the axis would have if nothing else had moved it since the
//! generator began. The command is what one generator says, plus what all others have displaced the axis since then; so a
//! generator that is alone reaches its end to the last bit. Nothing is integrated, and nothing here knows instructions'
//! operands. Units: position units, seconds. Nothing allocates.

use arcline_planner::Clock;
use arcline_planner::profile::{Jerk, Limits};
use arcline_profile::KinematicState;

use super::generator::{Generator, Law};

/// What can move an axis: one generator of each kind at a time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Slot {
    /// A coordinated move, or the axis's part of one that was ended and brakes.
    System,
    /// A stop of everything on the axis.
    Stop,
    /// MAM.
    Move,
    /// MAJ.
    Jog,
    /// MAH.
    Home,
    /// MAG.
    Gear,
    /// MAPC.
    PositionCam,
    /// MATC.
    TimeCam,
    /// MCT: the axis follows another coordinate system, or is led back by it.
    Transform,
    /// What a transform moved brakes: it was cancelled.
    Parting,
    /// MAM of a master offset: it moves the master of the position cam, as that sees it, and the axis only through that. Its
    /// frame is the offset, master units.
    MasterOffset,
}

impl Slot {
    pub(crate) const ALL: [Slot; SLOTS] = [
        Slot::System,
        Slot::Stop,
        Slot::Move,
        Slot::Jog,
        Slot::Home,
        Slot::Gear,
        Slot::PositionCam,
        Slot::TimeCam,
        Slot::Transform,
        Slot::Parting,
        Slot::MasterOffset,
    ];

    /// What can be a function of a master's way by itself.
    pub(crate) const GUIDED: [Slot; 3] = [Slot::Move, Slot::Jog, Slot::MasterOffset];

    /// Whether a single-axis instruction begins it: what merges and stops of the axis end.
    pub(crate) fn is_single_axis(self) -> bool {
        matches!(
            self,
            Slot::Move | Slot::Jog | Slot::Home | Slot::Gear | Slot::PositionCam | Slot::TimeCam
        )
    }

    /// Whether it moves the axis by itself: neither a coordinate system nor a transform gives it.
    pub(crate) fn is_own(self) -> bool {
        !matches!(self, Slot::System) && !self.is_of_transforms()
    }

    /// Whether a transform moves the axis by it, or what is left of one.
    pub(crate) fn is_of_transforms(self) -> bool {
        matches!(self, Slot::Transform | Slot::Parting)
    }

    /// What a person calls it.
    pub(crate) const fn name(self) -> &'static str {
        match self {
            Slot::System => "coordinated motion",
            Slot::Stop => "a stop",
            Slot::Move => "MAM",
            Slot::Jog => "MAJ",
            Slot::Home => "MAH",
            Slot::Gear => "MAG",
            Slot::PositionCam => "MAPC",
            Slot::TimeCam => "MATC",
            Slot::Transform => "a transform",
            Slot::Parting => "the stop of a cancelled transform",
            Slot::MasterOffset => "a master offset",
        }
    }

    const fn bit(self) -> u16 {
        1 << self as u8
    }
}

const SLOTS: usize = 11;

/// Displacements by kind of generator.
pub(super) type Displacements = [f64; SLOTS];

/// The generators of one axis.
#[derive(Clone, Debug)]
pub(crate) struct Sum {
    generators: [Option<Generator>; SLOTS],
    /// Places of `generators` that are taken, by bit.
    active: u16,
    /// What generators that are over have displaced the axis.
    displaced: Displacements,
    /// Where the axis stands while nothing is active.
    rest: f64,
}

impl Sum {
    pub(crate) fn at_rest(position: f64) -> Self {
        Sum {
            generators: [const { None }; SLOTS],
            active: 0,
            displaced: [0.0; SLOTS],
            rest: position,
        }
    }

    /// Whether nothing moves the axis or holds it.
    pub(crate) fn is_idle(&self) -> bool {
        self.active == 0
    }

    pub(crate) fn get(&self, slot: Slot) -> Option<&Generator> {
        if self.active & slot.bit() == 0 {
            return None;
        }
        self.generators[slot as usize].as_ref()
    }

    pub(crate) fn get_mut(&mut self, slot: Slot) -> Option<&mut Generator> {
        if self.active & slot.bit() == 0 {
            return None;
        }
        self.generators[slot as usize].as_mut()
    }

    pub(crate) fn is_active(&self, slot: Slot) -> bool {
        self.active & slot.bit() != 0
    }

    /// The next kind of generators behind `last`, in the order of [`Slot::ALL`], that is active or one of `others`.
    pub(super) fn next_active(&self, last: Option<Slot>, others: impl Iterator<Item = Slot>) -> Option<Slot> {
        let reported = last.map_or(0, |last| 2 * last.bit() - 1);
        let bits = others.fold(self.active, |bits, slot| bits | slot.bit()) & !reported;
        slots(bits).next()
    }

    /// Whether anything but generators of one kind is under way.
    pub(crate) fn is_active_but(&self, slot: Slot) -> bool {
        self.active & !slot.bit() != 0
    }

    /// Every generator under way, with its kind.
    pub(crate) fn active(&self) -> impl Iterator<Item = (Slot, &Generator)> {
        slots(self.active).filter_map(|slot| self.get(slot).map(|generator| (slot, generator)))
    }

    /// Begins a generator in place of the one of its kind. Its frame shows the present command at this instant,
    /// whatever position `generator` was made with: planned ones are planned from [`Sum::command`]'s position.
    pub(crate) fn begin(&mut self, slot: Slot, mut generator: Generator) {
        if slot == Slot::MasterOffset {
            self.generators[slot as usize] = Some(generator);
            self.active |= slot.bit();
            return;
        }
        let present = self.command().position;
        self.end(slot);
        if self.is_idle() {
            self.displaced = [0.0; SLOTS];
        }
        generator.now.position = present;
        generator.origin = present;
        generator.shift = 0.0;
        generator.others = self.displacements();
        self.generators[slot as usize] = Some(generator);
        self.active |= slot.bit();
    }

    /// Ends a generator; the axis stays where it is. Returns it as it was.
    pub(crate) fn end(&mut self, slot: Slot) -> Option<Generator> {
        self.get(slot)?;
        self.rest = self.command().position;
        self.active &= !slot.bit();
        let generator = self.generators[slot as usize].take()?;
        if slot != Slot::MasterOffset {
            self.displaced[slot as usize] += generator.displacement();
        }
        Some(generator)
    }

    /// Everything is over: the axis stands at a position.
    pub(crate) fn place(&mut self, position: f64) {
        *self = Sum::at_rest(position);
    }

    /// Shifts every position by an offset; nothing moves (MRP, homing).
    pub(crate) fn redefine(&mut self, offset: f64) {
        self.rest += offset;
        for slot in Slot::ALL {
            if let Some(generator) = self.get_mut(slot) {
                generator.shift += offset;
            }
        }
    }

    /// Folds away whole turns of an endless jog. Returns the shift of every position.
    pub(super) fn fold_jog(&mut self, unwind: f64, clock: &Clock) -> f64 {
        let jog = self.get_mut(Slot::Jog).filter(|jog| !jog.stopping);
        jog.map_or(0.0, |jog| jog.fold(unwind, clock))
    }

    /// Velocity and acceleration of some kinds of generators together; the position is 0.
    pub(crate) fn motion_of(&self, which: impl Fn(Slot) -> bool) -> KinematicState {
        let mut total = KinematicState::default();
        for (slot, generator) in self.moving() {
            if which(slot) {
                total.velocity += generator.now.velocity;
                total.acceleration += generator.now.acceleration;
            }
        }
        total
    }

    /// The limits that some kinds of generators keep together; `None` where those of one that moves by time are not known.
    pub(crate) fn in_force(&self, which: impl Fn(Slot) -> bool) -> Option<Limits> {
        let mut all: Option<Limits> = None;
        for (_, generator) in self.moving().filter(|(slot, _)| which(*slot)) {
            let still = generator.now.velocity == 0.0 && generator.now.acceleration == 0.0;
            let own = generator.in_force.filter(|_| generator.guide.is_none());
            match (own, still) {
                (Some(own), _) => all = Some(all.map_or(own, |all| together(&all, &own))),
                (None, true) => {}
                (None, false) => return None,
            }
        }
        all
    }

    /// What positions were redefined by since a generator began: its frame does not know.
    pub(crate) fn shift_of(&self, slot: Slot) -> f64 {
        self.get(slot).map_or(0.0, |generator| generator.shift)
    }

    /// Says where a generator that somebody else computes is, in its own frame.
    pub(crate) fn set(&mut self, slot: Slot, now: KinematicState) {
        if let Some(generator) = self.get_mut(slot) {
            generator.now = now;
        }
    }

    /// Brings planned generators to the present tick.
    pub(crate) fn advance(&mut self, clock: &Clock) {
        for slot in slots(self.active) {
            if let Some(generator) = self.get_mut(slot)
                && let Law::Planned { .. } = generator.law
            {
                generator.advance(clock);
            }
        }
    }

    /// Every generator under way that moves the axis itself.
    fn moving(&self) -> impl Iterator<Item = (Slot, &Generator)> {
        self.active().filter(|(slot, _)| *slot != Slot::MasterOffset)
    }

    /// The generator with the highest velocity; one whose velocity is no number first.
    pub(crate) fn fastest(&self) -> Option<(Slot, &Generator)> {
        let speed = |generator: &Generator| {
            let speed = generator.now.velocity.abs();
            if speed.is_nan() { f64::INFINITY } else { speed }
        };
        self.moving()
            .max_by(|(_, one), (_, other)| speed(one).total_cmp(&speed(other)))
    }

    /// Position, velocity and acceleration of the axis.
    pub(crate) fn command(&self) -> KinematicState {
        let mut total = KinematicState::default();
        let mut lead = None;
        for (slot, generator) in self.moving() {
            total.velocity += generator.now.velocity;
            total.acceleration += generator.now.acceleration;
            lead = lead.or(Some(slot));
        }
        total.position = match lead.and_then(|slot| self.seen_from(slot, None)) {
            Some(position) => position,
            None => self.rest,
        };
        total
    }

    /// A position in a generator's frame, or its present one, as a position of the axis at this tick.
    pub(crate) fn seen_from(&self, slot: Slot, position: Option<f64>) -> Option<f64> {
        let generator = self.get(slot)?;
        let mut others = generator.shift;
        // Alone, as nearly always, an axis has only what has been.
        let now = if self.active == slot.bit() {
            self.displaced
        } else {
            self.displacements()
        };
        for (other, (now, then)) in now.iter().zip(generator.others).enumerate() {
            if other != slot as usize {
                others += now - then;
            }
        }
        Some(position.unwrap_or(generator.now.position) + others)
    }

    fn displacements(&self) -> Displacements {
        let mut displacements = self.displaced;
        for (slot, generator) in self.moving() {
            displacements[slot as usize] += generator.displacement();
        }
        displacements
    }
}

/// The kinds of generators whose bits are set.
fn slots(mut bits: u16) -> impl Iterator<Item = Slot> {
    std::iter::from_fn(move || {
        let slot = *Slot::ALL.get(bits.trailing_zeros() as usize)?;
        bits &= bits - 1;
        Some(slot)
    })
}

/// The limits of two motions at once: the speeds add up, the harder rates count.
pub(crate) fn together(one: &Limits, other: &Limits) -> Limits {
    let jerk = match (one.jerk, other.jerk) {
        (Some(one), Some(other)) => Some(Jerk {
            acceleration: one.acceleration.max(other.acceleration),
            deceleration: one.deceleration.max(other.deceleration),
        }),
        (one, other) => one.or(other),
    };
    Limits {
        speed: one.speed + other.speed,
        acceleration: one.acceleration.max(other.acceleration),
        deceleration: one.deceleration.max(other.deceleration),
        jerk,
    }
}

#[cfg(test)]
mod tests {
    use arcline_planner::profile::Profile;

    use super::*;

    const CLOCK: Clock = Clock::at(0, 1_000_000);

    fn at(tick: u64) -> Clock {
        Clock::at(tick, CLOCK.period_ns)
    }

    /// A move from where the axis is commanded to be, superimposed on what runs.
    fn begin_move(sum: &mut Sum, slot: Slot, target: f64, clock: &Clock) {
        let from = KinematicState {
            position: sum.command().position,
            ..KinematicState::default()
        };
        let limits = Limits {
            speed: 70.0,
            acceleration: 900.0,
            deceleration: 700.0,
            jerk: None,
        };
        let profile = Profile::to_position(from, target, 0.0, &limits);
        sum.begin(slot, Generator::planned(profile, clock.now()));
        sum.advance(clock);
    }

    #[test]
    fn a_generator_that_is_alone_ends_on_its_target_to_the_last_bit() {
        let mut sum = Sum::at_rest(0.1);
        for (place, target) in [33.3, -7.1, 1e6 / 3.0, 0.3].into_iter().enumerate() {
            let start = at(place as u64 * 10_000_000);
            begin_move(&mut sum, Slot::Move, target, &start);
            sum.advance(&at(start.tick + 9_999_999));
            assert_eq!(sum.command().position, target);
            sum.end(Slot::Move);
            assert_eq!(sum.command().position, target);
        }
    }

    #[test]
    fn generators_add_and_the_ends_of_either_change_nothing() {
        let mut sum = Sum::at_rest(10.0);
        begin_move(&mut sum, Slot::Move, 40.0, &at(0));
        sum.advance(&at(100));
        let alone = sum.command();
        begin_move(&mut sum, Slot::Jog, alone.position + 5.0, &at(100));
        assert_eq!(sum.command().position, alone.position);
        sum.advance(&at(10_000));
        assert!((sum.command().position - 45.0).abs() < 1e-12);
        for slot in [Slot::Move, Slot::Jog] {
            let before = sum.command().position;
            sum.end(slot);
            assert!((sum.command().position - before).abs() < 1e-12);
        }
        assert!(sum.is_idle());
        sum.redefine(100.0);
        assert!((sum.command().position - 145.0).abs() < 1e-12);
    }

    #[test]
    fn redefining_shifts_what_is_shown_and_the_end_with_it() {
        let mut sum = Sum::at_rest(0.0);
        begin_move(&mut sum, Slot::Move, 20.0, &at(0));
        sum.advance(&at(50));
        let before = sum.command();
        sum.redefine(-3.0);
        assert_eq!(sum.command().position, before.position - 3.0);
        assert_eq!(sum.command().velocity, before.velocity);
        sum.advance(&at(10_000));
        assert_eq!(sum.command().position, 17.0);
    }
}
