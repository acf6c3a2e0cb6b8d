//! The way of a master as what a motion is a function of (spec/coordinated-instructions.md §8.1, §8.5, §8.6).
//!
//! A guide reads its master once a tick and shows how far it has gone in the lock direction since the lock: the furthest
//! place that it has reached, from which nothing is given back. A master that turns round is followed again from that
//! place on. Between two ticks the master is taken to go straight from the one position to the other, so the lock, and
//! the ends of moves, lie inside a tick. Nothing is integrated: the way is a difference of two positions.
//!
//! Not here: what is a function of it. Units: master units, seconds.

use arcline_planner::{Clock, Instant, Pace};

use super::MasterAt;
use super::master::{LockTo, Master, Sense};

/// How far the lock has come.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Lock {
    /// Until the master crosses a position: as it shows it, and within one turn where it is rotary.
    Crossing {
        position: f64,
        unwind: Option<f64>,
    },
    /// Until the master goes in the lock direction.
    Starting,
    Locked,
}

/// A master and the way that it has gone.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Guide {
    /// The link by which it was begun.
    pub(crate) link: u32,
    pub(crate) master: Master,
    pub(crate) sense: Sense,
    lock: Lock,
    /// Where the way begins.
    from: f64,
    /// The furthest place of the way so far: never less than before.
    way: f64,
    /// The master is at the furthest place, and did not come back from it.
    follows: bool,
    /// What is waited for lies in the lock direction.
    is_ahead: bool,
}

impl Guide {
    /// A guide from an instant of the update that ends now. `unwind` is the master's, and `at` what is read of it.
    pub(crate) fn begin(
        link: u32,
        master: &Master,
        lock: LockTo,
        unwind: Option<f64>,
        at: &MasterAt,
        since: Instant,
        clock: &Clock,
    ) -> Self {
        let mut master = *master;
        let from = master.position_at(since, clock);
        master.before = from;
        let mut guide = Guide {
            link,
            master,
            sense: lock.sense,
            lock: match lock.position {
                Some(position) => Lock::Crossing { position, unwind },
                None => Lock::Starting,
            },
            from,
            way: 0.0,
            follows: lock.position.is_none(),
            is_ahead: true,
        };
        guide.go_on(at);
        guide
    }

    /// The master at the present tick.
    pub(crate) fn advance(&mut self, at: &MasterAt, clock: &Clock) {
        self.master.read(at, clock);
        self.go_on(at);
    }

    fn go_on(&mut self, at: &MasterAt) {
        let sign = self.sense.sign();
        let (before, now) = (sign * self.master.before, sign * self.master.now.position);
        match self.lock {
            Lock::Crossing { position, unwind } => {
                let position = sign * (position - at.redefined + self.master.offset);
                // Standing on it at the beginning is no crossing; a rotary master comes to it once a turn.
                let next = match unwind {
                    Some(unwind) => position + ((before - position) / unwind + 1.0).floor() * unwind,
                    None => position,
                };
                self.is_ahead = next > before;
                if before < next && next <= now {
                    self.lock = Lock::Locked;
                    self.from = sign * next;
                    self.way = now - next;
                    self.follows = true;
                }
            }
            Lock::Starting => {
                let gone = now - sign * self.from;
                if gone > 0.0 {
                    self.lock = Lock::Locked;
                    self.way = gone;
                    self.follows = true;
                } else {
                    // It begins where the master turns to the lock direction.
                    self.follows &= gone == 0.0;
                    self.from = self.master.now.position;
                }
            }
            Lock::Locked => {
                let gone = now - sign * self.from;
                if gone > self.way {
                    self.way = gone;
                    self.follows = true;
                } else if gone < self.way {
                    self.follows = false;
                }
            }
        }
    }

    /// How far the master has gone.
    pub(crate) fn way(&self) -> f64 {
        self.way
    }

    /// What the motion is a function of now.
    pub(crate) fn clock(&self) -> Clock {
        Clock::of_way(self.way)
    }

    /// How the way goes on.
    pub(crate) fn pace(&self) -> Pace {
        let sign = self.sense.sign();
        let speed = sign * self.master.now.velocity;
        let acceleration = sign * self.master.now.acceleration;
        let stands = speed < 0.0 || (speed == 0.0 && acceleration < 0.0);
        if !self.follows || self.has_position_lock() || stands {
            return Pace::default();
        }
        Pace { speed, acceleration }
    }

    /// How the way would go on from now if it were locked: what a motion under way is taken over with.
    pub(crate) fn pace_of(master: &Master, sense: Sense) -> Pace {
        Pace {
            speed: (sense.sign() * master.now.velocity).max(0.0),
            acceleration: sense.sign() * master.now.acceleration,
        }
    }

    /// Whether the master is followed: the lock is on.
    pub(crate) fn follows(&self) -> bool {
        self.follows
    }

    /// Whether the master has gone in the lock direction since the lock: before, the motion has not begun.
    pub(crate) fn has_begun(&self) -> bool {
        self.lock == Lock::Locked
    }

    /// Whether the lock is still waited for at a position.
    pub(crate) fn has_position_lock(&self) -> bool {
        matches!(self.lock, Lock::Crossing { .. })
    }

    /// Whether the master, as it moves, will go on with the way, or lock.
    pub(crate) fn will_go_on(&self) -> bool {
        self.is_ahead && self.sense.sign() * self.master.now.velocity > 0.0
    }

    /// When, in the update that ends now, the way came to a place of itself. Places before that update are its beginning.
    pub(crate) fn instant_of(&self, place: Instant, clock: &Clock) -> Instant {
        let sign = self.sense.sign();
        let short = place.elapsed(&self.clock());
        let (before, now) = (sign * self.master.before, sign * self.master.now.position);
        let period = clock.period();
        let back = if now > before {
            short / (now - before) * period
        } else {
            0.0
        };
        let began = Clock::at(clock.tick.saturating_sub(1), clock.period_ns);
        began.now().after((period - back).clamp(0.0, period), &began)
    }

    /// The place of the way at an instant of the update that ends now.
    pub(crate) fn place_at(&self, instant: Instant, clock: &Clock) -> Instant {
        let gone = self.sense.sign() * (self.master.position_at(instant, clock) - self.from);
        Clock::of_way(gone.clamp(0.0, self.way)).now()
    }
}

#[cfg(test)]
mod tests {
    use arcline_profile::KinematicState;

    use super::*;
    use arcline_instruction_set::enumerations::Reference;

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

    fn lock(sense: Sense, position: Option<f64>) -> LockTo {
        LockTo { sense, position }
    }

    /// The ways that a guide shows while its master goes through positions, the first of them at the beginning.
    fn ways(lock: LockTo, unwind: Option<f64>, positions: &[f64]) -> Vec<(f64, bool)> {
        let clock = Clock::at(0, PERIOD_NS);
        let first = at(positions[0]);
        let master = Master::new(0, Reference::Command, &first, &clock);
        let mut guide = Guide::begin(1, &master, lock, unwind, &first, clock.now(), &clock);
        let mut ways = vec![(guide.way, guide.follows)];
        for (tick, position) in (1..).zip(&positions[1..]) {
            guide.advance(&at(*position), &Clock::at(tick, PERIOD_NS));
            ways.push((guide.way, guide.follows));
        }
        ways
    }

    /// Its name, the lock, the master's unwind, its positions and the way at each.
    type Case<'a> = (&'a str, LockTo, Option<f64>, &'a [f64], &'a [(f64, bool)]);

    #[test]
    fn a_way_is_how_far_the_master_has_gone_in_the_lock_direction() {
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
            ("standing on it",              lock(Forward, Some(0.0)), None, &[0.0, 9.0, 0.0, -1.0, 0.0, 1.0],
                &[(0.0, false), (0.0, false), (0.0, false), (0.0, false), (0.0, true), (1.0, true)]),
            ("crossed the other way",       lock(Reverse, Some(10.0)), None, &[0.0, 12.0, 11.0, 8.0],
                &[(0.0, false), (0.0, false), (0.0, false), (2.0, true)]),
            ("once a turn",                 lock(Forward, Some(10.0)), Some(360.0), &[10.0, 300.0, 371.0],
                &[(0.0, false), (0.0, false), (1.0, true)]),
        ];
        for (why, lock, unwind, positions, expected) in cases {
            assert_eq!(ways(lock, unwind, positions), expected, "{why}");
        }
    }

    #[test]
    fn places_and_instants_lie_on_a_straight_line_within_an_update() {
        let clock = Clock::at(0, PERIOD_NS);
        let master = Master::new(0, Reference::Command, &at(0.0), &clock);
        let lock = lock(Sense::Forward, None);
        let mut guide = Guide::begin(1, &master, lock, None, &at(0.0), clock.now(), &clock);
        let clock = Clock::at(7, PERIOD_NS);
        guide.advance(&at(4.0), &clock);
        let place = Clock::of_way(1.0).now();
        let instant = guide.instant_of(place, &clock);
        assert!((instant.elapsed(&clock) - 0.75e-3).abs() < 1e-15);
        assert!((guide.place_at(instant, &clock).elapsed(&guide.clock()) - 3.0).abs() < 1e-12);
        let next = Guide::begin(2, &guide.master, lock, None, &at(4.0), instant, &clock);
        assert!((next.way - 3.0).abs() < 1e-12, "it begins inside the update");
    }
}
