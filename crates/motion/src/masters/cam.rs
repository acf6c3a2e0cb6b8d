//! A slave axis that a cam leads: over the position of a master axis, or over time (spec/axis-and-data-types.md §3.9).
//!
//! The slave's displacement since the cam was locked is a function of the master's way since then, whatever the update period,
//! and nothing is integrated: the lock and the ends of the profile stand at positions of the master, not at ticks. Time
//! is a master that moves one unit a second. Units: position units of either axis, seconds.

use std::sync::Arc;

use arcline_cam::Profile;
use arcline_planner::{Clock, Instant};
use arcline_profile::KinematicState;

use super::MasterAt;
use crate::control::Execution;
use arcline_instruction_set::enumerations::{ExecutionMode, Reference};

/// What a cam's profile is over.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Source {
    /// The position of an axis.
    Axis { master: u16, reference: Reference },
    /// Seconds since it began.
    Time { since: Instant },
}

/// A position of the master at which a cam is locked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Lock {
    /// As the master is read: without what it was redefined by.
    pub(crate) position: f64,
    /// Only a master that moves this way crosses it: 1 or -1.
    pub(crate) way: Option<f64>,
    /// Length of a turn of a rotary master, on each of which it lies once.
    pub(crate) unwind: Option<f64>,
}

/// What an instruction says of a cam.
#[derive(Clone, Debug)]
pub(crate) struct Program {
    pub(crate) profile: Arc<Profile>,
    pub(crate) source: Source,
    /// Slave units per unit of the profile, negative when the profile is subtracted.
    pub(crate) slave_scale: f64,
    /// Master units per unit of the profile; below 0 where the master goes in reverse while the profile goes on.
    pub(crate) master_scale: f64,
    /// What it does at the ends of its profile: it is over (Once), begins again from where it has led the slave (Continuous), or
    /// waits for the master to come back (Persistent).
    pub(crate) mode: ExecutionMode,
    /// The only way of the master that is followed: 1 or -1.
    pub(crate) way: Option<f64>,
    /// Where the profile is entered when the cam is locked.
    pub(crate) entry: f64,
    /// The link to its master, where it is driven by one (MDAC).
    pub(crate) link: Option<u32>,
}

/// A cam that takes over when the one under way ends.
#[derive(Clone, Debug)]
pub(crate) struct Pending {
    pub(crate) program: Program,
    pub(crate) execution: Execution,
}

/// A cam under way.
#[derive(Clone, Debug)]
pub(crate) struct Cam {
    program: Program,
    /// Where it is going to be locked; `None`: it is.
    lock: Option<Lock>,
    /// What of the master is read now.
    read: Reference,
    /// Where the master was at the last look.
    last: f64,
    /// Where the master was when the cam was locked.
    master_from: f64,
    /// Where the slave was then, in its generator's frame.
    slave_from: f64,
    /// It was locked at once by a link, and begins where the master turns to the way that is followed.
    starting: bool,
    /// Furthest way of the master since then, where only one way is followed.
    furthest: f64,
    /// Place in the profile at the last look; that of Continuous goes on beyond its ends.
    place: f64,
    /// Which time Continuous runs, from 0; below 0 in reverse.
    turn: f64,
    /// The slave follows the master.
    follows: bool,
    /// Segment of the profile.
    segment: usize,
}

/// Where a profile was left.
#[derive(Clone, Copy, Debug)]
struct Exit {
    /// At its last point, else at its first.
    at_end: bool,
    /// Where the master was.
    master: f64,
    /// Where the slave stands.
    slave: f64,
}

/// What of a master's way is rounding: a share of the length of the profile.
const ROUNDING: f64 = 1e-12;

impl Cam {
    /// The cam of a program, with its master and its slave as they are. Without a lock it is locked at once.
    pub(crate) fn new(program: Program, lock: Option<Lock>, at: &MasterAt, slave: f64) -> Self {
        let entry = program.entry;
        Cam {
            follows: lock.is_none(),
            starting: lock.is_none() && program.link.is_some(),
            lock,
            read: at.read,
            last: at.point.position,
            master_from: at.point.position,
            slave_from: slave,
            furthest: 0.0,
            place: entry,
            turn: 0.0,
            segment: program.profile.at(entry).segment,
            program,
        }
    }

    pub(crate) fn source(&self) -> Source {
        self.program.source
    }

    /// The link to its master, where it is driven by one.
    pub(crate) fn link(&self) -> Option<u32> {
        self.program.link
    }

    /// The only way of the master that is followed.
    pub(crate) fn way(&self) -> Option<f64> {
        self.program.way
    }

    /// Whether the slave follows the master now: …CamLockStatus.
    pub(crate) fn follows(&self) -> bool {
        self.follows
    }

    /// Segment of the profile, from 0.
    pub(crate) fn segment(&self) -> usize {
        self.segment
    }

    /// Whether it comes to an end by itself.
    pub(crate) fn will_end(&self) -> bool {
        matches!(self.program.source, Source::Time { .. }) && self.program.mode == ExecutionMode::Once
    }

    /// Brings the slave to where the master leads it; `slave` is where it is. At the end of the profile a pending cam takes
    /// over. Returns the slave in its generator's frame, and what has ended.
    pub(crate) fn follow(
        &mut self,
        at: &MasterAt,
        slave: f64,
        pending: &mut Option<Pending>,
    ) -> (KinematicState, Ended) {
        if self.read != at.read {
            // Command and actual position differ: the slave does not jump from the one to the other.
            self.read = at.read;
            self.master_from += at.point.position - self.last;
            self.last = at.point.position;
        }
        let before = std::mem::replace(&mut self.last, at.point.position);
        if let Some(lock) = self.lock {
            let Some(crossed) = lock.crossed(before, at.point.position) else {
                return (KinematicState::at_rest(slave), Ended::Nothing);
            };
            self.lock = None;
            self.master_from = crossed;
            self.slave_from = slave;
        }
        let (point, exit) = self.led(&at.point, pending.is_some());
        let Some(exit) = exit else {
            return (point, Ended::Nothing);
        };
        let Some(next) = pending.take() else {
            return (point, Ended::Cam);
        };
        self.hand_over(next.program, &exit);
        let (point, _) = self.led(&at.point, false);
        (point, Ended::HandedOver(next.execution))
    }

    /// Another profile goes on where this one was left.
    fn hand_over(&mut self, mut program: Program, exit: &Exit) {
        let (start, end) = (program.profile.start().0, program.profile.end().0);
        program.entry = if exit.at_end { start } else { end };
        (program.source, program.link) = (self.program.source, self.program.link);
        self.place = program.entry;
        self.program = program;
        self.master_from = exit.master;
        self.slave_from = exit.slave;
        self.starting = false;
        self.furthest = 0.0;
        self.turn = 0.0;
    }

    /// Where the master leads the slave, and where it has left the profile. `hands_over`: another cam waits for that.
    fn led(&mut self, master: &KinematicState, hands_over: bool) -> (KinematicState, Option<Exit>) {
        let Program {
            profile,
            slave_scale,
            master_scale,
            mode,
            way,
            entry,
            ..
        } = &self.program;
        let (slave_scale, master_scale, entry) = (*slave_scale, *master_scale, *entry);
        let mut gone = master.position - self.master_from;
        let mut moves = true;
        if let Some(way) = *way {
            if self.starting && way * gone < 0.0 {
                self.master_from = master.position;
                self.follows = false;
                return (KinematicState::at_rest(self.slave_from), None);
            }
            self.starting &= gone == 0.0;
            // The other way nothing is followed, until the master is back where it turned.
            moves = way * gone >= self.furthest;
            self.furthest = self.furthest.max(way * gone);
            gone = way * self.furthest;
        }
        let place = entry + gone / master_scale;
        let before = std::mem::replace(&mut self.place, place);
        let (start, length) = (profile.start().0, profile.length());
        let rounding = ROUNDING * length;
        let turn = match mode {
            ExecutionMode::Continuous => ((place - start) / length).floor(),
            ExecutionMode::Once | ExecutionMode::Persistent => 0.0,
        };
        let ends = *mode == ExecutionMode::Once || hands_over;
        let (first, last) = (start + self.turn * length, start + (self.turn + 1.0) * length);
        let beyond = |end: f64, sign: f64| {
            let (now, then) = (sign * (place - end), sign * (before - end));
            now > rounding || (now >= -rounding && then < -rounding)
        };
        let at_end = beyond(last, 1.0);
        if ends && (at_end || beyond(first, -1.0)) {
            let bound = if at_end { last } else { first };
            let risen = self.turn * profile.rise() + profile.at(if at_end { profile.end().0 } else { start }).y;
            let slave = self.slave_from + slave_scale * (risen - profile.at(entry).y);
            self.follows = false;
            // Persistent may have been left long ago.
            let outside = if at_end { before - bound } else { bound - before } > rounding;
            let left = self.master_from + (bound - entry) * master_scale;
            let exit = Exit {
                at_end,
                master: if outside { master.position } else { left },
                slave,
            };
            return (KinematicState::at_rest(slave), Some(exit));
        }
        self.turn = turn;
        let inside = place - turn * length;
        let value = profile.at(inside);
        let within =
            *mode == ExecutionMode::Continuous || (start - rounding..=start + length + rounding).contains(&inside);
        self.follows = moves && within;
        self.segment = value.segment;
        let risen = turn * profile.rise() + value.y - profile.at(entry).y;
        let rate = if self.follows {
            master.velocity / master_scale
        } else {
            0.0
        };
        let change = if self.follows {
            master.acceleration / master_scale
        } else {
            0.0
        };
        let point = KinematicState {
            position: self.slave_from + slave_scale * risen,
            velocity: slave_scale * value.slope * rate,
            acceleration: slave_scale * (value.curvature * rate * rate + value.slope * change),
        };
        (point, None)
    }
}

/// What a look at a cam has brought to its end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Ended {
    Nothing,
    /// The cam: nothing was pending.
    Cam,
    /// The cam; the pending one of this instruction goes on.
    HandedOver(Execution),
}

impl Lock {
    /// Where a master that went from one position to another has crossed it; one that stood on it has not.
    pub(crate) fn crossed(&self, from: f64, to: f64) -> Option<f64> {
        let sign = if to > from { 1.0 } else { -1.0 };
        if from == to || self.way.is_some_and(|way| way != sign) {
            return None;
        }
        let position = match self.unwind {
            None => self.position,
            Some(unwind) => {
                let turns = sign * (from - self.position) / unwind;
                self.position + sign * (turns.floor() + 1.0) * unwind
            }
        };
        let ahead = sign * (position - from);
        (ahead > 0.0 && ahead <= sign * (to - from)).then_some(position)
    }
}

/// Time as a master.
pub(crate) fn time(since: Instant, clock: &Clock) -> MasterAt {
    MasterAt {
        point: KinematicState {
            position: since.elapsed(clock),
            velocity: 1.0,
            acceleration: 0.0,
        },
        read: Reference::Command,
        redefined: 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn locks_are_crossed_where_they_lie() {
        #[rustfmt::skip]
        let cases = [
            // why,                        position, way,        unwind,       from,   to,    crossed
            ("forward",                    5.0,      None,       None,         4.0,    6.0,   Some(5.0)),
            ("up to it",                   5.0,      None,       None,         4.0,    5.0,   Some(5.0)),
            ("from it",                    5.0,      None,       None,         5.0,    6.0,   None),
            ("not as far",                 5.0,      None,       None,         4.0,    4.9,   None),
            ("reverse",                    5.0,      None,       None,         6.0,    4.0,   Some(5.0)),
            ("the other way",              5.0,      Some(1.0),  None,         6.0,    4.0,   None),
            ("that way",                   5.0,      Some(-1.0), None,         6.0,    4.0,   Some(5.0)),
            ("at rest",                    5.0,      None,       None,         5.0,    5.0,   None),
            ("the next turn",              10.0,     None,       Some(360.0),  360.0,  371.0, Some(370.0)),
            ("on it, the next turn",       10.0,     None,       Some(360.0),  10.0,   370.0, Some(370.0)),
            ("below zero",                 10.0,     None,       Some(360.0),  -360.0, -340.0, Some(-350.0)),
            ("reverse over a turn",        10.0,     Some(-1.0), Some(360.0),  375.0,  365.0, Some(370.0)),
            ("reverse, on it",             10.0,     None,       Some(360.0),  370.0,  369.0, None),
        ];
        for (why, position, way, unwind, from, to, expected) in cases {
            let lock = Lock { position, way, unwind };
            assert_eq!(lock.crossed(from, to), expected, "{why}");
        }
    }
}
