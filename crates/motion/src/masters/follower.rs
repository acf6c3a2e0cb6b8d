//! The displacement of a master as the variable of motions (spec/coordinated-instructions.md §8.1, §8.5, §8.6).
//!
//! A follower reads its master once a tick and computes the displacement in the lock direction since the lock ([`super::displacement`]).
//! Between two ticks the master is assumed to move linearly from one position to the other, so the lock and the ends of moves lie at
//! exact instants inside a tick.
//!
//! Not here: those motions. Units: master units, seconds.

use arcline_planner::{Clock, Instant, MasterRate};

use super::MasterAt;
use super::displacement::{Crossing, Displacement, MasterProgress, Sense};
use super::master::Master;

/// The link by which a move is master driven, and its lock.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct DrivenBy {
    pub(crate) link: u32,
    pub(crate) lock: LockCondition,
}

/// The lock operands of an instruction (Lock Direction and Lock Position).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct LockCondition {
    pub(crate) sense: Sense,
    /// The lock position of the master, in positions that the master shows; `None`: the lock closes at once.
    pub(crate) position: Option<f64>,
}

/// The parameters of a follower that begins.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FollowerStart {
    /// The link by which the motion begins.
    pub(crate) link: u32,
    pub(crate) lock: LockCondition,
    /// The unwind of the master, if it is rotary.
    pub(crate) unwind: Option<f64>,
    /// An instant of the update that ends now.
    pub(crate) since: Instant,
}

/// A master and its displacement.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MasterFollower {
    /// The link by which the motion began.
    pub(crate) link: u32,
    pub(crate) master: Master,
    pub(crate) sense: Sense,
    displacement: Displacement,
    /// The lock has closed, and the master is at its furthest position or moves on from it.
    follows: bool,
    /// The lock lies in the lock direction.
    is_ahead: bool,
}

impl MasterFollower {
    /// `at`: the master at the present tick.
    pub(crate) fn begin(beginning: FollowerStart, master: &Master, at: &MasterAt, clock: &Clock) -> Self {
        let FollowerStart {
            link,
            lock: LockCondition { sense, position },
            unwind,
            since,
        } = beginning;
        let mut master = *master;
        let from = master.reader.position_at(since, clock);
        master.reader.before = from;
        let only = Some(sense);
        let crossing = |position| Crossing {
            position,
            sense: only,
            unwind,
        };
        let mut follower = MasterFollower {
            link,
            master,
            sense,
            displacement: match position {
                Some(position) => Displacement::behind(crossing(position), only, from),
                None => Displacement::at_once(only, from, true),
            },
            follows: position.is_none(),
            is_ahead: true,
        };
        follower.go_on(at);
        follower
    }

    /// The master at the present tick.
    pub(crate) fn advance(&mut self, at: &MasterAt, clock: &Clock) {
        self.master.read(at, clock);
        self.go_on(at);
    }

    fn go_on(&mut self, at: &MasterAt) {
        let master = &self.master.reader;
        let shift = master.offset - at.redefined;
        self.is_ahead = self.displacement.is_ahead(master, shift);
        match self.displacement.go_on(master, shift) {
            MasterProgress::Ahead => self.follows = true,
            MasterProgress::Behind => self.follows = false,
            MasterProgress::BeforeLock | MasterProgress::AtFurthest => {}
        }
    }

    /// The displacement of the master.
    pub(crate) fn displacement(&self) -> f64 {
        self.displacement.furthest
    }

    /// The displacement as the clock of the motion.
    pub(crate) fn clock(&self) -> Clock {
        Clock::of_displacement(self.displacement())
    }

    /// The rate of change of the displacement at the present tick.
    pub(crate) fn rate(&self) -> MasterRate {
        let sign = self.sense.sign();
        let speed = sign * self.master.reader.now.velocity;
        let acceleration = sign * self.master.reader.now.acceleration;
        let stands = speed < 0.0 || (speed == 0.0 && acceleration < 0.0);
        if !self.follows || self.has_position_lock() || stands {
            return MasterRate::default();
        }
        MasterRate { speed, acceleration }
    }

    /// The rate of change that the displacement would have if the follower were locked; a motion that is taken over is converted with it.
    pub(crate) fn rate_of(master: &Master, sense: Sense) -> MasterRate {
        MasterRate {
            speed: (sense.sign() * master.reader.now.velocity).max(0.0),
            acceleration: sense.sign() * master.reader.now.acceleration,
        }
    }

    /// The motion follows the master: the lock has closed, and the master is not behind its furthest position.
    pub(crate) fn follows(&self) -> bool {
        self.follows
    }

    /// The master has moved in the lock direction since the lock; before that, the motion has not begun.
    pub(crate) fn has_begun(&self) -> bool {
        self.displacement.is_locked()
    }

    /// The lock still waits for a position of the master.
    pub(crate) fn has_position_lock(&self) -> bool {
        self.displacement.is_waiting()
    }

    /// The master, at its present velocity, will advance the displacement, or reach the lock.
    pub(crate) fn will_go_on(&self) -> bool {
        self.is_ahead && self.sense.sign() * self.master.velocity() > 0.0
    }

    /// The instant of the update that ends now at which the master reached a displacement; for earlier displacements, the beginning of the
    /// update.
    pub(crate) fn instant_of(&self, displacement: Instant, clock: &Clock) -> Instant {
        let sign = self.sense.sign();
        let short = displacement.elapsed(&self.clock());
        let (before, now) = (sign * self.master.reader.before, sign * self.master.reader.now.position);
        let period = clock.period();
        let back = if now > before {
            short / (now - before) * period
        } else {
            0.0
        };
        let began = Clock::at(clock.tick.saturating_sub(1), clock.period_ns);
        began.now().after((period - back).clamp(0.0, period), &began)
    }

    /// The displacement at an instant of the update that ends now.
    pub(crate) fn displacement_at(&self, instant: Instant, clock: &Clock) -> Instant {
        let gone = self.sense.sign() * (self.master.reader.position_at(instant, clock) - self.displacement.from);
        Clock::of_displacement(gone.clamp(0.0, self.displacement())).now()
    }
}

#[cfg(test)]
mod tests {
    use arcline_instruction_set::AxisId;
    use arcline_profile::KinematicState;

    use super::super::Reference;
    use super::*;

    const PERIOD_NS: u64 = 1_000_000;

    fn at(position: f64) -> MasterAt {
        MasterAt {
            point: KinematicState {
                position,
                ..KinematicState::default()
            },
            read: Reference::Command,
            redefined: 0.0,
        }
    }

    fn lock(sense: Sense, position: Option<f64>) -> LockCondition {
        LockCondition { sense, position }
    }

    /// The displacements of a follower while its master moves through positions, starting at the first.
    fn displacements(lock: LockCondition, unwind: Option<f64>, positions: &[f64]) -> Vec<(f64, bool)> {
        let clock = Clock::at(0, PERIOD_NS);
        let first = at(positions[0]);
        let master = Master::new(AxisId(0), Reference::Command, &first, &clock);
        let mut follower = MasterFollower::begin(
            FollowerStart {
                link: 1,
                lock,
                unwind,
                since: clock.now(),
            },
            &master,
            &first,
            &clock,
        );
        let mut displacements = vec![(follower.displacement(), follower.follows)];
        for (tick, position) in (1..).zip(&positions[1..]) {
            follower.advance(&at(*position), &Clock::at(tick, PERIOD_NS));
            displacements.push((follower.displacement(), follower.follows));
        }
        displacements
    }

    /// The reason, the lock, the master's unwind, its positions, and the displacement at each.
    type Case<'a> = (&'a str, LockCondition, Option<f64>, &'a [f64], &'a [(f64, bool)]);

    #[test]
    fn a_displacement_is_the_farthest_distance_of_the_master_in_the_lock_direction() {
        use Sense::{Forward, Reverse};
        #[rustfmt::skip]
        let cases: [Case<'_>; 9] = [
            ("at once, forward",            lock(Forward, None), None, &[5.0, 6.0, 8.0], &[(0.0, true), (1.0, true), (3.0, true)]),
            ("at once, reverse",            lock(Reverse, None), None, &[5.0, 4.0, 2.0], &[(0.0, true), (1.0, true), (3.0, true)]),
            ("a master that stands",        lock(Forward, None), None, &[5.0, 5.0], &[(0.0, true), (0.0, true)]),
            ("against it, then with it",    lock(Forward, None), None, &[5.0, 4.0, 6.0], &[(0.0, true), (0.0, false), (2.0, true)]),
            ("there, back and there again", lock(Forward, None), None, &[0.0, 4.0, 1.0, 3.0, 4.0, 5.0],
                &[(0.0, true), (4.0, true), (4.0, false), (4.0, false), (4.0, false), (5.0, true)]),
            ("a position that is crossed",  lock(Forward, Some(10.0)), None, &[0.0, 9.0, 12.0, 13.0],
                &[(0.0, false), (0.0, false), (2.0, true), (3.0, true)]),
            ("at rest on it",               lock(Forward, Some(0.0)), None, &[0.0, 9.0, 0.0, -1.0, 0.0, 1.0],
                &[(0.0, false), (0.0, false), (0.0, false), (0.0, false), (0.0, true), (1.0, true)]),
            ("crossed the other way",       lock(Reverse, Some(10.0)), None, &[0.0, 12.0, 11.0, 8.0],
                &[(0.0, false), (0.0, false), (0.0, false), (2.0, true)]),
            ("once a turn",                 lock(Forward, Some(10.0)), Some(360.0), &[10.0, 300.0, 371.0],
                &[(0.0, false), (0.0, false), (1.0, true)]),
        ];
        for (why, lock, unwind, positions, expected) in cases {
            assert_eq!(displacements(lock, unwind, positions), expected, "{why}");
        }
    }

    #[test]
    fn displacements_and_instants_are_proportional_within_an_update() {
        let clock = Clock::at(0, PERIOD_NS);
        let master = Master::new(AxisId(0), Reference::Command, &at(0.0), &clock);
        let lock = lock(Sense::Forward, None);
        let mut follower = MasterFollower::begin(
            FollowerStart {
                link: 1,
                lock,
                unwind: None,
                since: clock.now(),
            },
            &master,
            &at(0.0),
            &clock,
        );
        let clock = Clock::at(7, PERIOD_NS);
        follower.advance(&at(4.0), &clock);
        let gone = Clock::of_displacement(1.0).now();
        let instant = follower.instant_of(gone, &clock);
        assert!((instant.elapsed(&clock) - 0.75e-3).abs() < 1e-15);
        assert!((follower.displacement_at(instant, &clock).elapsed(&follower.clock()) - 3.0).abs() < 1e-12);
        let next = MasterFollower::begin(
            FollowerStart {
                link: 2,
                lock,
                unwind: None,
                since: instant,
            },
            &follower.master,
            &at(4.0),
            &clock,
        );
        assert!((next.displacement() - 3.0).abs() < 1e-12, "it begins inside the update");
    }
}
