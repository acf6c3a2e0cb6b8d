//! A slave axis geared to a master (spec/axis-and-data-types.md §3.5).
//!
//! The slave's displacement is the ratio times the master's since the start of the gearing, plus a slip: the clutch ramps out the difference
//! between the slave's speed and the geared speed. The position of the slave is thus a function of time and of the master's position,
//! whatever the update period, and nothing is integrated. Units: position units of either axis, seconds.

use arcline_planner::profile::{Limits, Profile};
use arcline_planner::{Clock, Instant};
use arcline_profile::KinematicState;

use super::MasterAt;
use super::master::Master;

/// A gearing under way.
#[derive(Clone, Debug)]
pub(crate) struct Gear {
    pub(crate) master: Master,
    /// Slave units per master unit, negative against the master's direction.
    pub(crate) ratio: f64,
    /// The position of the master at the start of the gearing.
    master_from: f64,
    /// The position of the slave at that instant, in its generator's frame.
    slave_from: f64,
    /// The slip: the difference of speeds that the clutch ramps out; at rest from the beginning without a clutch.
    clutch: Profile,
    since: Instant,
}

impl Gear {
    /// Starts the gearing of a slave to a master. `slave` is its position in its generator's frame and its present speed from an earlier
    /// gearing; `clutch` is the acceleration to the geared speed, `None` for no ramp.
    pub(crate) fn new(master: Master, ratio: f64, slave: KinematicState, clutch: Option<f64>, now: Instant) -> Self {
        let difference = slave.velocity - ratio * master.velocity();
        let clutch = match clutch {
            Some(rate) if difference != 0.0 => Profile::stop(
                KinematicState {
                    position: 0.0,
                    velocity: difference,
                    acceleration: 0.0,
                },
                &Limits {
                    speed: difference.abs(),
                    acceleration: rate,
                    deceleration: rate,
                    jerk: None,
                },
            ),
            _ => Profile::rest(0.0),
        };
        Gear {
            master,
            ratio,
            master_from: master.reader.now.position,
            slave_from: slave.position,
            clutch,
            since: now,
        }
    }

    /// The motion of the slave in its generator's frame. `at`: the master at the present tick.
    pub(crate) fn follow(&mut self, at: &MasterAt, clock: &Clock) -> KinematicState {
        self.master.read(at, clock);
        let (slip, master) = (self.clutch.at(self.since.elapsed(clock)), &self.master.reader.now);
        KinematicState {
            position: self.slave_from + self.ratio * (master.position - self.master_from) + slip.position,
            velocity: self.ratio * master.velocity + slip.velocity,
            acceleration: self.ratio * master.acceleration + slip.acceleration,
        }
    }

    /// The slave has the geared speed.
    pub(crate) fn is_locked(&self, clock: &Clock) -> bool {
        self.since.elapsed(clock) >= self.clutch.duration()
    }
}
