//! A slave axis geared to a master (spec/axis-and-data-types.md §3.5).
//!
//! The slave's displacement is the ratio times the master's since they met, and what is left of the difference between
//! the speed that the slave had and the geared speed: the clutch ramps this difference out. So everything is a function
//! of time and of where the master is, whatever the update period, and nothing is integrated. Units: position units of
//! either axis, seconds.

use arcline_planner::profile::{Limits, Profile};
use arcline_planner::{Clock, Instant};
use arcline_profile::KinematicState;

use super::MasterAt;
use arcline_instruction_set::enumerations::Reference;

/// A gearing under way.
#[derive(Clone, Debug)]
pub(crate) struct Gear {
    pub(crate) master: u16,
    pub(crate) reference: Reference,
    /// Slave units per master unit, negative against the master's direction.
    pub(crate) ratio: f64,
    /// What of the master is read now: a master without torque has no command of its own.
    read: Reference,
    /// Where the master was when they met.
    master_from: f64,
    /// Where the slave was then, in its generator's frame.
    slave_from: f64,
    /// What is left of the difference of speeds; at rest from the beginning without a clutch.
    clutch: Profile,
    since: Instant,
}

impl Gear {
    /// The slave meets the master. `slave` is its position in its generator's frame and the geared speed that it has;
    /// `clutch`: the acceleration that takes it to the new one, or at once.
    pub(crate) fn new(
        master: u16,
        reference: Reference,
        ratio: f64,
        at: &MasterAt,
        slave: KinematicState,
        clutch: Option<f64>,
        now: Instant,
    ) -> Self {
        let difference = slave.velocity - ratio * at.point.velocity;
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
            reference,
            ratio,
            read: at.read,
            master_from: at.point.position,
            slave_from: slave.position,
            clutch,
            since: now,
        }
    }

    /// Where the slave is, in its generator's frame.
    pub(crate) fn follow(&mut self, at: &MasterAt, slave: f64, clock: &Clock) -> KinematicState {
        let slip = self.clutch.at(self.since.elapsed(clock));
        if self.read != at.read {
            // Command and actual position differ: the slave does not jump from the one to the other.
            self.read = at.read;
            self.master_from = at.point.position;
            self.slave_from = slave - slip.position;
        }
        KinematicState {
            position: self.slave_from + self.ratio * (at.point.position - self.master_from) + slip.position,
            velocity: self.ratio * at.point.velocity + slip.velocity,
            acceleration: self.ratio * at.point.acceleration + slip.acceleration,
        }
    }

    /// Whether the slave has the geared speed.
    pub(crate) fn is_locked(&self, clock: &Clock) -> bool {
        self.since.elapsed(clock) >= self.clutch.duration()
    }
}
