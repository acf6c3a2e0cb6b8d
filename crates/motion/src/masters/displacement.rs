//! The displacement of a master since a follower was locked to it (spec/coordinated-instructions.md §8.5, §8.6).
//!
//! A follower is locked at a position of its master, or at once. With one lock direction, the displacement is the greatest one that the
//! master has reached: the follower stands while the master returns, and follows again from the furthest position on. Nothing is integrated:
//! a displacement is a difference of two positions. Units: master units.

use super::master::PositionReader;

/// The direction in which a follower follows its master.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Sense {
    Forward,
    Reverse,
}

impl Sense {
    /// 1 or -1.
    pub(crate) fn sign(self) -> f64 {
        match self {
            Sense::Forward => 1.0,
            Sense::Reverse => -1.0,
        }
    }
}

/// A position that a master crosses.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Crossing {
    pub(crate) position: f64,
    /// Only a master that moves in this direction crosses the position.
    pub(crate) sense: Option<Sense>,
    /// Length of a turn of a rotary master; the position lies on each turn once.
    pub(crate) unwind: Option<f64>,
}

impl Crossing {
    /// The position at which a master crosses on its motion from one position to another; a master that starts on it does not cross it.
    pub(crate) fn crossed(&self, from: f64, to: f64) -> Option<f64> {
        let sense = if to > from { Sense::Forward } else { Sense::Reverse };
        if from == to || self.sense.is_some_and(|only| only != sense) {
            return None;
        }
        let next = self.next(from, sense);
        let (ahead, beyond) = (sense.sign() * (next - from), sense.sign() * (to - next));
        (ahead > 0.0 && beyond >= 0.0).then_some(next)
    }

    /// The crossing shifted by an offset.
    fn shifted(&self, by: f64) -> Self {
        Crossing {
            position: self.position + by,
            ..*self
        }
    }

    /// The position at which a master reaches the crossing in a direction; it may lie behind a linear master.
    fn next(&self, from: f64, sense: Sense) -> f64 {
        match self.unwind {
            None => self.position,
            Some(unwind) => {
                let turns = sense.sign() * (from - self.position) / unwind;
                self.position + sense.sign() * (turns.floor() + 1.0) * unwind
            }
        }
    }
}

/// The state of the lock.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Lock {
    /// It waits for the master to cross a position.
    Waiting(Crossing),
    /// It waits for the master to move in the lock direction.
    Starting,
    Locked,
}

/// The motion of a master in an update, for its follower.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum MasterProgress {
    /// The master has not reached the lock.
    BeforeLock,
    /// The master moves on in the lock direction.
    Ahead,
    /// The master stands at its furthest position.
    AtFurthest,
    /// The master moves back, or has not reached its furthest position again.
    Behind,
}

/// The displacement of a master since the lock.
#[derive(Clone, Copy, Debug)]
pub(super) struct Displacement {
    lock: Lock,
    /// The only direction that is followed; `None`: both.
    sense: Option<Sense>,
    /// The position of the master at displacement 0.
    pub(super) from: f64,
    /// The furthest displacement in the direction that is followed; it never decreases.
    pub(super) furthest: f64,
}

impl Displacement {
    /// Locks at the present position of a master; with `starting`, as soon as the master moves in the lock direction.
    pub(super) fn at_once(sense: Option<Sense>, from: f64, starting: bool) -> Self {
        Displacement {
            lock: if starting { Lock::Starting } else { Lock::Locked },
            sense,
            from,
            furthest: 0.0,
        }
    }

    /// Locks when the master crosses a position.
    pub(super) fn behind(crossing: Crossing, sense: Option<Sense>, from: f64) -> Self {
        Displacement {
            lock: Lock::Waiting(crossing),
            ..Displacement::at_once(sense, from, false)
        }
    }

    /// Starts again from a position.
    pub(super) fn restart(&mut self, from: f64) {
        *self = Displacement::at_once(self.sense, from, false);
    }

    /// The motion of the master since the previous tick. `shift`: from positions of the lock to those of the reader.
    pub(super) fn go_on(&mut self, master: &PositionReader, shift: f64) -> MasterProgress {
        let now = master.now.position;
        let mut locks = false;
        if let Lock::Waiting(crossing) = self.lock {
            let Some(crossed) = crossing.shifted(shift).crossed(master.before, now) else {
                return MasterProgress::BeforeLock;
            };
            self.restart(crossed);
            locks = true;
        }
        let Some(sense) = self.sense else {
            return MasterProgress::Ahead;
        };
        let gone = sense.sign() * (now - self.from);
        if gone > self.furthest || locks {
            self.lock = Lock::Locked;
            self.furthest = gone;
            return MasterProgress::Ahead;
        }
        if self.lock == Lock::Starting {
            // The displacement begins at the position at which the master turns to the lock direction.
            self.from = now;
        }
        if gone < self.furthest {
            MasterProgress::Behind
        } else {
            MasterProgress::AtFurthest
        }
    }

    /// The lock position lies in the lock direction from the master's position at the previous tick; `shift` as in
    /// [`Displacement::go_on`].
    pub(super) fn is_ahead(&self, master: &PositionReader, shift: f64) -> bool {
        match (self.lock, self.sense) {
            (Lock::Waiting(crossing), Some(sense)) => {
                let next = crossing.shifted(shift).next(master.before, sense);
                sense.sign() * (next - master.before) > 0.0
            }
            _ => true,
        }
    }

    /// The lock waits for a position.
    pub(super) fn is_waiting(&self) -> bool {
        matches!(self.lock, Lock::Waiting(_))
    }

    /// The lock has closed, and the master has moved in the lock direction since.
    pub(super) fn is_locked(&self) -> bool {
        self.lock == Lock::Locked
    }

    /// The displacement of the master, with its sign.
    pub(super) fn gone(&self, master: &PositionReader) -> f64 {
        match self.sense {
            Some(sense) => sense.sign() * self.furthest,
            None => master.now.position - self.from,
        }
    }
}

#[cfg(test)]
mod tests {
    use Sense::{Forward, Reverse};

    use super::*;

    #[test]
    fn positions_are_crossed_where_they_lie() {
        #[rustfmt::skip]
        let cases = [
            // why,                        position, sense,         unwind,       from,   to,    crossed
            ("forward",                    5.0,      None,       None,         4.0,    6.0,   Some(5.0)),
            ("up to it",                   5.0,      None,       None,         4.0,    5.0,   Some(5.0)),
            ("from it",                    5.0,      None,       None,         5.0,    6.0,   None),
            ("not as far",                 5.0,      None,       None,         4.0,    4.9,   None),
            ("reverse",                    5.0,      None,       None,         6.0,    4.0,   Some(5.0)),
            ("the other way",              5.0,      Some(Forward), None,         6.0,    4.0,   None),
            ("that way",                   5.0,      Some(Reverse), None,         6.0,    4.0,   Some(5.0)),
            ("at rest",                    5.0,      None,       None,         5.0,    5.0,   None),
            ("the next turn",              10.0,     None,       Some(360.0),  360.0,  371.0, Some(370.0)),
            ("on it, the next turn",       10.0,     None,       Some(360.0),  10.0,   370.0, Some(370.0)),
            ("below zero",                 10.0,     None,       Some(360.0),  -360.0, -340.0, Some(-350.0)),
            ("reverse over a turn",        10.0,     Some(Reverse), Some(360.0),  375.0,  365.0, Some(370.0)),
            ("reverse, on it",             10.0,     None,       Some(360.0),  370.0,  369.0, None),
        ];
        for (why, position, sense, unwind, from, to, expected) in cases {
            let crossing = Crossing {
                position,
                sense,
                unwind,
            };
            assert_eq!(crossing.crossed(from, to), expected, "{why}");
        }
    }
}
