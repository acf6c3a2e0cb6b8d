//! The command of one axis as the sum of all generators that move it at the same time (spec/axis-and-data-types.md §1.6).
//!
//! Each generator has its own frame: the positions that the axis would have if no other generator had moved it since this one began. The
//! command is the position of one generator plus the displacements by all others since then, so a generator that is alone reaches its end
//! to the last bit. The sum integrates nothing and knows no operands of instructions. Units: position units, seconds. Nothing allocates.

use arcline_planner::Clock;
use arcline_planner::profile::{Jerk, Limits};
use arcline_profile::KinematicState;

use super::generator::{Equation, Generator};
use super::generator_kind::{Displacements, GENERATOR_KINDS, GeneratorKind, kinds};
use crate::tolerance::START_UNITS;

/// The generators of one axis.
#[derive(Clone, Debug)]
pub(crate) struct Sum {
    generators: [Option<Generator>; GENERATOR_KINDS],
    /// The active entries of `generators`, by bit.
    active: u16,
    /// Displacements by generators that have ended.
    displaced: Displacements,
    /// The one active generator began when no other was active, and none has begun since: no other generator has displaced the axis.
    alone: bool,
    /// The position of the axis while no generator is active.
    rest: f64,
}

impl Sum {
    pub(crate) fn at_rest(position: f64) -> Self {
        Sum {
            generators: [const { None }; GENERATOR_KINDS],
            active: 0,
            displaced: [0.0; GENERATOR_KINDS],
            alone: false,
            rest: position,
        }
    }

    /// No generator is active.
    pub(crate) fn is_idle(&self) -> bool {
        self.active == 0
    }

    pub(crate) fn get(&self, kind: GeneratorKind) -> Option<&Generator> {
        if self.active & kind.bit() == 0 {
            return None;
        }
        self.generators[kind as usize].as_ref()
    }

    pub(crate) fn get_mut(&mut self, kind: GeneratorKind) -> Option<&mut Generator> {
        if self.active & kind.bit() == 0 {
            return None;
        }
        self.generators[kind as usize].as_mut()
    }

    pub(crate) fn is_active(&self, kind: GeneratorKind) -> bool {
        self.active & kind.bit() != 0
    }

    /// The next kind of generators behind `last`, in the order of [`GeneratorKind::ALL`], that is active or one of `others`.
    pub(super) fn next_active(
        &self,
        last: Option<GeneratorKind>,
        others: impl Iterator<Item = GeneratorKind>,
    ) -> Option<GeneratorKind> {
        let reported = last.map_or(0, |last| 2 * last.bit() - 1);
        let bits = others.fold(self.active, |bits, kind| bits | kind.bit()) & !reported;
        kinds(bits).next()
    }

    /// The one active generator, if it alone has displaced the axis since it began.
    pub(crate) fn sole(&self) -> Option<(GeneratorKind, &Generator)> {
        self.active().next().filter(|_| self.alone)
    }

    /// The command of the axis while the motion of the sole generator is `now` in its frame, of the shift `shift`: as [`Sum::command`].
    pub(crate) fn sole_command(now: &KinematicState, shift: f64) -> KinematicState {
        KinematicState {
            position: now.position + shift,
            // A sum has no negative zero.
            velocity: 0.0 + now.velocity,
            acceleration: 0.0 + now.acceleration,
        }
    }

    /// A generator of another kind is active.
    pub(crate) fn is_active_but(&self, kind: GeneratorKind) -> bool {
        self.active & !kind.bit() != 0
    }

    /// Every generator under way, with its kind.
    pub(crate) fn active(&self) -> impl Iterator<Item = (GeneratorKind, &Generator)> {
        kinds(self.active).filter_map(|kind| self.get(kind).map(|generator| (kind, generator)))
    }

    /// Begins a generator in place of the one of its kind. Its frame shows the present command at this instant, whatever position `generator`
    /// was created with; a profile must therefore start at the position of [`Sum::command`].
    pub(crate) fn begin(&mut self, kind: GeneratorKind, mut generator: Generator) {
        if kind == GeneratorKind::MasterOffset {
            self.generators[kind as usize] = Some(generator);
            self.active |= kind.bit();
            self.alone = false;
            return;
        }
        let present = self.command().position;
        self.end(kind);
        self.alone = self.is_idle();
        if self.alone {
            self.displaced = [0.0; GENERATOR_KINDS];
        }
        generator.now.position = present;
        generator.origin = present;
        generator.shift = 0.0;
        generator.last_displacement = 0.0;
        generator.others = self.displacements();
        self.generators[kind as usize] = Some(generator);
        self.active |= kind.bit();
    }

    /// Begins a generator at an earlier position: in its frame it has stood at `start` since, while other generators may have moved the axis.
    pub(crate) fn begin_from(&mut self, kind: GeneratorKind, generator: Generator, start: f64) {
        self.begin(kind, generator);
        let moved = self.command().position - start;
        if moved.abs() <= START_UNITS {
            return;
        }
        self.alone = false;
        if let Some(generator) = self.get_mut(kind) {
            generator.now.position = start;
            generator.origin = start;
            // Only the sum of these displacements counts, so any other kind can hold this one.
            generator.others[(kind as usize + 1) % GENERATOR_KINDS] -= moved;
        }
    }

    /// Ends a generator and returns its last state; the position of the axis stays.
    pub(crate) fn end(&mut self, kind: GeneratorKind) -> Option<Generator> {
        self.get(kind)?;
        self.rest = self.command().position;
        self.active &= !kind.bit();
        let generator = self.generators[kind as usize].take()?;
        if kind != GeneratorKind::MasterOffset {
            self.displaced[kind as usize] += generator.displacement();
        }
        Some(generator)
    }

    /// Ends all generators; the axis stands at a position.
    pub(crate) fn set_position(&mut self, position: f64) {
        *self = Sum::at_rest(position);
    }

    /// Shifts every position by an offset without motion (MRP, homing).
    pub(crate) fn redefine(&mut self, offset: f64) {
        self.rest += offset;
        for kind in GeneratorKind::ALL {
            if let Some(generator) = self.get_mut(kind) {
                generator.shift += offset;
            }
        }
    }

    /// Removes whole turns of an endless jog. Returns the shift of every position.
    pub(super) fn fold_jog(&mut self, unwind: f64, clock: &Clock) -> f64 {
        let jog = self.get_mut(GeneratorKind::Jog).filter(|jog| !jog.stopping);
        jog.map_or(0.0, |jog| jog.fold(unwind, clock))
    }

    /// The sum of velocities and accelerations of some kinds of generators; the position is 0.
    pub(crate) fn motion_of(&self, which: impl Fn(GeneratorKind) -> bool) -> KinematicState {
        let mut total = KinematicState::default();
        for (kind, generator) in self.moving() {
            if which(kind) {
                total.velocity += generator.now.velocity;
                total.acceleration += generator.now.acceleration;
            }
        }
        total
    }

    /// The limits that some kinds of generators keep together; `None` if those of a generator over time are unknown.
    pub(crate) fn in_force(&self, which: impl Fn(GeneratorKind) -> bool) -> Option<Limits> {
        let mut all: Option<Limits> = None;
        for (_, generator) in self.moving().filter(|(kind, _)| which(*kind)) {
            let still = generator.now.velocity == 0.0 && generator.now.acceleration == 0.0;
            let own = generator.in_force.filter(|_| generator.follower.is_none());
            match (own, still) {
                (Some(own), _) => all = Some(all.map_or(own, |all| together(&all, &own))),
                (None, true) => {}
                (None, false) => return None,
            }
        }
        all
    }

    /// The offset by which positions were redefined since a generator began: its frame does not have it.
    pub(crate) fn shift_of(&self, kind: GeneratorKind) -> f64 {
        self.get(kind).map_or(0.0, |generator| generator.shift)
    }

    /// Sets the position of a generator that is computed outside of the axis, in its own frame.
    pub(crate) fn set(&mut self, kind: GeneratorKind, now: KinematicState) {
        if let Some(generator) = self.get_mut(kind) {
            generator.now = now;
        }
    }

    /// Advances planned generators to the present tick.
    pub(crate) fn advance(&mut self, clock: &Clock) {
        for kind in kinds(self.active) {
            if let Some(generator) = self.get_mut(kind)
                && let Equation::Planned { .. } = generator.equation
            {
                generator.advance(clock);
            }
        }
    }

    /// Every active generator that moves the axis itself.
    fn moving(&self) -> impl Iterator<Item = (GeneratorKind, &Generator)> {
        self.active().filter(|(kind, _)| *kind != GeneratorKind::MasterOffset)
    }

    /// Keeps the displacement of each generator, for [`Sum::suspect`] at the next tick.
    pub(crate) fn keep_displacements(&mut self) {
        for kind in kinds(self.active) {
            if let Some(generator) = self.get_mut(kind) {
                generator.last_displacement = generator.displacement();
            }
        }
    }

    /// The generator that most likely causes a command that the axis cannot follow: the one whose displacement since the last tick, of
    /// `period` s, disagrees most with its own velocity; if all agree, the fastest.
    pub(crate) fn suspect(&self, period: f64) -> Option<(GeneratorKind, &Generator)> {
        let number = |value: f64| if value.is_nan() { f64::INFINITY } else { value };
        let jump = |generator: &Generator| {
            let step = generator.displacement() - generator.last_displacement;
            let jump = number((step - generator.now.velocity * period).abs());
            // An acceleration that is no jump makes a difference, too, which is small beside the distance.
            if jump > 0.5 * step.abs() { jump } else { 0.0 }
        };
        let order = |generator: &Generator| [jump(generator), number(generator.now.velocity.abs())];
        self.moving().max_by(|(_, one), (_, other)| {
            let [[jump, speed], [other_jump, other_speed]] = [order(one), order(other)];
            jump.total_cmp(&other_jump).then(speed.total_cmp(&other_speed))
        })
    }

    /// Position, velocity and acceleration of the axis.
    pub(crate) fn command(&self) -> KinematicState {
        let mut total = KinematicState::default();
        let mut first = None;
        for (kind, generator) in self.moving() {
            total.velocity += generator.now.velocity;
            total.acceleration += generator.now.acceleration;
            first = first.or(Some(kind));
        }
        total.position = match first.and_then(|kind| self.seen_from(kind, None)) {
            Some(position) => position,
            None => self.rest,
        };
        total
    }

    /// Converts a position in a generator's frame (by default its present one) to a position of the axis at this tick.
    pub(crate) fn seen_from(&self, kind: GeneratorKind, position: Option<f64>) -> Option<f64> {
        let generator = self.get(kind)?;
        let position = position.unwrap_or(generator.now.position);
        if self.alone {
            return Some(position + generator.shift);
        }
        let mut others = generator.shift;
        // Most axes have one generator, and only displacements by ended generators add to it.
        let now = if self.active == kind.bit() {
            self.displaced
        } else {
            self.displacements()
        };
        for (other, (now, then)) in now.iter().zip(generator.others).enumerate() {
            if other != kind as usize {
                others += now - then;
            }
        }
        Some(position + others)
    }

    fn displacements(&self) -> Displacements {
        let mut displacements = self.displaced;
        for (kind, generator) in self.moving() {
            displacements[kind as usize] += generator.displacement();
        }
        displacements
    }
}

/// The limits of two simultaneous motions: the sum of the speeds, and the higher ones of the rates.
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

    /// A move from the present command position, superimposed on the active generators.
    fn begin_move(sum: &mut Sum, kind: GeneratorKind, target: f64, clock: &Clock) {
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
        sum.begin(kind, Generator::planned(profile, clock.now()));
        sum.advance(clock);
    }

    #[test]
    fn a_generator_that_is_alone_ends_on_its_target_to_the_last_bit() {
        let mut sum = Sum::at_rest(0.1);
        for (index, target) in [33.3, -7.1, 1e6 / 3.0, 0.3].into_iter().enumerate() {
            let start = at(index as u64 * 10_000_000);
            begin_move(&mut sum, GeneratorKind::Move, target, &start);
            sum.advance(&at(start.tick + 9_999_999));
            assert_eq!(sum.command().position, target);
            sum.end(GeneratorKind::Move);
            assert_eq!(sum.command().position, target);
        }
    }

    #[test]
    fn generators_add_and_the_ends_of_either_change_nothing() {
        let mut sum = Sum::at_rest(10.0);
        begin_move(&mut sum, GeneratorKind::Move, 40.0, &at(0));
        sum.advance(&at(100));
        let alone = sum.command();
        begin_move(&mut sum, GeneratorKind::Jog, alone.position + 5.0, &at(100));
        assert_eq!(sum.command().position, alone.position);
        sum.advance(&at(10_000));
        assert!((sum.command().position - 45.0).abs() < 1e-12);
        for kind in [GeneratorKind::Move, GeneratorKind::Jog] {
            let before = sum.command().position;
            sum.end(kind);
            assert!((sum.command().position - before).abs() < 1e-12);
        }
        assert!(sum.is_idle());
        sum.redefine(100.0);
        assert!((sum.command().position - 145.0).abs() < 1e-12);
    }

    #[test]
    fn redefining_shifts_the_shown_position_and_the_end() {
        let mut sum = Sum::at_rest(0.0);
        begin_move(&mut sum, GeneratorKind::Move, 20.0, &at(0));
        sum.advance(&at(50));
        let before = sum.command();
        sum.redefine(-3.0);
        assert_eq!(sum.command().position, before.position - 3.0);
        assert_eq!(sum.command().velocity, before.velocity);
        sum.advance(&at(10_000));
        assert_eq!(sum.command().position, 17.0);
    }
}
