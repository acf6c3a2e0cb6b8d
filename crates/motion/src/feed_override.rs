//! The feed override of a coordinate system: a share of the programmed speed of every coordinated move.

use arcline_instruction_set::SystemId;
use arcline_planner::Clock;

use crate::machine::LimitPolicy;
use crate::motion::Motion;
use crate::system::{Activity, System};

/// Largest override: twice the programmed speed.
pub const MAX_OVERRIDE: f64 = 2.0;

impl Motion {
    /// Sets the share of the programmed speeds, 0 to [`MAX_OVERRIDE`], for all coordinated moves of a system: active, pending and later ones.
    /// Accelerations and jerks stay as programmed. 0 holds the active move, at rest on its path. A stop under way is not affected. A share that
    /// is not a number and an index without a system change nothing. Real-time.
    pub fn set_override(&mut self, system: SystemId, share: f64) {
        let clock = self.clock;
        if let Some(system) = self.systems.get_mut(system)
            && !share.is_nan()
        {
            // Under enforced joint limits no move can be faster than programmed.
            let most = match system.description.joint_limits {
                LimitPolicy::Enforce => 1.0,
                LimitPolicy::Ignore => MAX_OVERRIDE,
            };
            system.set_override(share.clamp(0.0, most), &clock);
        }
    }
}

impl System {
    fn set_override(&mut self, share: f64, clock: &Clock) {
        if self.travel.rate() == share {
            return;
        }
        let base = self.time_base(clock);
        self.travel.set_rate(share, &base);
        self.stale = self.activity == Activity::Moving;
    }
}
