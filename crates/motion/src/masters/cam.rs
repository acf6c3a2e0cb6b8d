//! A slave axis that follows a cam: over the position of a master axis, or over time (spec/axis-and-data-types.md §3.9).
//!
//! The slave's displacement since the lock of the cam is a function of the master's displacement since then, whatever the update period,
//! and nothing is integrated: the lock and the ends of the profile are positions of the master, not ticks. Time is a master that moves at
//! one unit per second. Units: position units of either axis, seconds.

use arcline_instruction_set::AxisId;
use std::sync::Arc;

use arcline_cam::Profile;
use arcline_instruction_set::enumerations::{ExecutionMode, Reference};
use arcline_planner::{Clock, Instant};
use arcline_profile::KinematicState;

use super::MasterAt;
use super::displacement::{Crossing, Displacement, MasterProgress, Sense};
use super::master::PositionReader;
use crate::execution::Execution;
use crate::tolerance::CAM_LENGTH_SHARE;

/// The variable of a cam's profile.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Source {
    /// The position of an axis.
    Axis { master: AxisId, reference: Reference },
    /// Seconds since the cam began.
    Time { since: Instant },
}

/// The operands of a cam.
#[derive(Clone, Debug)]
pub(crate) struct CamProgram {
    pub(crate) profile: Arc<Profile>,
    pub(crate) source: Source,
    /// Slave units per unit of the profile, negative when the profile is subtracted.
    pub(crate) slave_scale: f64,
    /// Master units per unit of the profile; below 0 if the master moves in reverse while the profile advances.
    pub(crate) master_scale: f64,
    /// The behaviour of the cam at the ends of its profile: it ends (Once), begins again from the slave's position there (Continuous), or
    /// waits for the master to return (Persistent).
    pub(crate) mode: ExecutionMode,
    /// The only direction in which the slave follows the master; `None`: both.
    pub(crate) sense: Option<Sense>,
    /// The position in the profile at which the cam begins when it is locked.
    pub(crate) entry: f64,
    /// The link to its master, if a link drives the cam (MDAC).
    pub(crate) link: Option<u32>,
}

/// A pending cam: it replaces the active one at that one's end.
#[derive(Clone, Debug)]
pub(crate) struct Pending {
    pub(crate) program: CamProgram,
    pub(crate) execution: Execution,
}

/// A cam under way.
#[derive(Clone, Debug)]
pub(crate) struct Cam {
    program: CamProgram,
    /// Its master, or time.
    master: PositionReader,
    /// The displacement of the master since the lock of the cam.
    displacement: Displacement,
    /// The position of the slave at the lock, in its generator's frame.
    slave_from: f64,
    /// Position in the profile at the last update; a Continuous cam counts on beyond its ends.
    position: f64,
    /// The number of the present run of a Continuous cam, from 0; below 0 in reverse.
    turn: f64,
    /// The slave follows the master.
    follows: bool,
    /// Segment of the profile.
    segment: usize,
}

/// The end at which the cam left its profile.
#[derive(Clone, Copy, Debug)]
struct Exit {
    /// The end is the last point of the profile, otherwise its first.
    at_end: bool,
    /// The position of the master there.
    master: f64,
    /// The position of the slave there.
    slave: f64,
}

impl Cam {
    /// The cam of a program, from the present state of its master and its slave. `lock`: a position of the master, without the offset of
    /// redefined positions. Without a lock position the cam is locked at once; a cam that a link drives, when the master moves in its direction.
    pub(crate) fn new(program: CamProgram, lock: Option<Crossing>, at: &MasterAt, slave: f64, clock: &Clock) -> Self {
        let (entry, from) = (program.entry, at.point.position);
        let displacement = match lock {
            Some(crossing) => Displacement::behind(crossing, program.sense, from),
            None => Displacement::at_once(program.sense, from, program.link.is_some()),
        };
        Cam {
            follows: lock.is_none(),
            master: PositionReader::new(at, clock),
            displacement,
            slave_from: slave,
            position: entry,
            turn: 0.0,
            segment: program.profile.at(entry).segment,
            program,
        }
    }

    pub(crate) fn source(&self) -> Source {
        self.program.source
    }

    /// The link to its master, if a link drives the cam.
    pub(crate) fn link(&self) -> Option<u32> {
        self.program.link
    }

    /// The only direction in which the slave follows the master; `None`: both.
    pub(crate) fn sense(&self) -> Option<Sense> {
        self.program.sense
    }

    /// The slave follows the master at this tick: …CamLockStatus.
    pub(crate) fn follows(&self) -> bool {
        self.follows
    }

    /// Segment of the profile, from 0.
    pub(crate) fn segment(&self) -> usize {
        self.segment
    }

    /// The cam ends on its own.
    pub(crate) fn will_end(&self) -> bool {
        matches!(self.program.source, Source::Time { .. }) && self.program.mode == ExecutionMode::Once
    }

    /// Updates the slave to the position of the master; `slave` is its present position. At the end of the profile a pending cam takes over.
    /// Returns the slave in its generator's frame, and the cam that has ended.
    pub(crate) fn follow(
        &mut self,
        at: &MasterAt,
        slave: f64,
        pending: &mut Option<Pending>,
        clock: &Clock,
    ) -> (KinematicState, Ended) {
        self.master.read(at, clock);
        let waited = self.displacement.is_waiting();
        let going = self.displacement.go_on(&self.master, self.master.offset);
        if going == MasterProgress::BeforeLock {
            return (KinematicState::at_rest(slave), Ended::Nothing);
        }
        if waited {
            self.slave_from = slave;
        }
        let (point, exit) = self.slave_motion(going, pending.is_some());
        let Some(exit) = exit else {
            return (point, Ended::Nothing);
        };
        let Some(next) = pending.take() else {
            return (point, Ended::Cam);
        };
        self.hand_over(next.program, &exit);
        let going = self.displacement.go_on(&self.master, 0.0);
        let (point, _) = self.slave_motion(going, false);
        (point, Ended::HandedOver(next.execution))
    }

    /// Continues with another profile at the exit of this one.
    fn hand_over(&mut self, mut program: CamProgram, exit: &Exit) {
        let (start, end) = (program.profile.start().0, program.profile.end().0);
        program.entry = if exit.at_end { start } else { end };
        (program.source, program.link) = (self.program.source, self.program.link);
        self.position = program.entry;
        self.program = program;
        self.displacement = Displacement::at_once(self.program.sense, exit.master, false);
        self.slave_from = exit.slave;
        self.turn = 0.0;
    }

    /// The motion of the slave that belongs to the master, and the exit if the cam has left its profile. `hands_over`: a pending cam waits for
    /// the exit.
    fn slave_motion(&mut self, going: MasterProgress, hands_over: bool) -> (KinematicState, Option<Exit>) {
        let CamProgram {
            profile,
            slave_scale,
            master_scale,
            mode,
            entry,
            ..
        } = &self.program;
        let (slave_scale, master_scale, entry) = (*slave_scale, *master_scale, *entry);
        let master = self.master.now;
        let gone = self.displacement.gone(&self.master);
        let position = entry + gone / master_scale;
        let before = std::mem::replace(&mut self.position, position);
        let (start, length) = (profile.start().0, profile.length());
        let rounding = CAM_LENGTH_SHARE * length;
        let turn = match mode {
            ExecutionMode::Continuous => ((position - start) / length).floor(),
            ExecutionMode::Once | ExecutionMode::Persistent => 0.0,
        };
        let ends = *mode == ExecutionMode::Once || hands_over;
        let (first, last) = (start + self.turn * length, start + (self.turn + 1.0) * length);
        let beyond = |end: f64, sign: f64| {
            let (now, then) = (sign * (position - end), sign * (before - end));
            now > rounding || (now >= -rounding && then < -rounding)
        };
        let at_end = beyond(last, 1.0);
        if ends && (at_end || beyond(first, -1.0)) {
            let bound = if at_end { last } else { first };
            let risen = self.turn * profile.rise() + profile.at(if at_end { profile.end().0 } else { start }).y;
            let slave = self.slave_from + slave_scale * (risen - profile.at(entry).y);
            self.follows = false;
            // A Persistent cam may have left its profile in an earlier update.
            let outside = if at_end { before - bound } else { bound - before } > rounding;
            let left = self.displacement.from + (bound - entry) * master_scale;
            let exit = Exit {
                at_end,
                master: if outside { master.position } else { left },
                slave,
            };
            return (KinematicState::at_rest(slave), Some(exit));
        }
        self.turn = turn;
        let inside = position - turn * length;
        let value = profile.at(inside);
        let within =
            *mode == ExecutionMode::Continuous || (start - rounding..=start + length + rounding).contains(&inside);
        // In the other direction the slave waits until the master is back at the position at which it reversed.
        self.follows = going != MasterProgress::Behind && within;
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

/// The cam that an update of the master has ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Ended {
    Nothing,
    /// The cam; none was pending.
    Cam,
    /// The cam; the pending one of this instruction continues.
    HandedOver(Execution),
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
