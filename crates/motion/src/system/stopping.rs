//! Stops of a coordinate system: of its move on the path, and the instruction that reports the end.
//!
//! Not here: moves that are ended or aborted ([`super::take_over`]). Real-time: no allocation; bounded by the axes.

use arcline_instruction_set::{AxisId, Flag};
use arcline_planner::Clock;
use arcline_planner::profile::Limits;

use super::{Activity, System};
use crate::axes::Axes;
use crate::axis::Axis;
use crate::control::Controls;
use crate::stop::AxisSet;

impl System {
    /// Brakes its coordinated move on its path, in time, no longer as a function of a master. Its instructions have ended.
    pub(crate) fn stop_on_path(&mut self, limits: &Limits, clock: &Clock) {
        let tail = self.of_tail(limits);
        if !self.is_busy() {
            return;
        }
        let base = self.time_base(clock);
        self.travel.stop(limits, &base);
        if let Some(tail) = tail {
            self.travel.stop_tail(&tail, clock);
        }
        self.follower = None;
        self.activity = Activity::Stopping;
        self.stale = true;
    }

    /// As [`System::stop_on_path`], for a robot that cannot follow the move: a contour brakes without waiting until the limits of the axes
    /// permit it, an active stop brakes no later than planned, and a motion whose own profile comes to rest sooner continues on that
    /// profile.
    pub(crate) fn stop_on_path_at_once(&mut self, limits: &Limits, clock: &Clock) {
        if self.follower.is_some() {
            self.stop_on_path(limits, clock);
            return;
        }
        if !self.is_busy() {
            return;
        }
        self.travel.stop_soonest(limits, clock);
        self.activity = Activity::Stopping;
        self.stale = true;
    }

    /// Ends the active move's instruction; the caller ends the motion.
    pub(crate) fn end_active(&mut self, controls: &mut Controls) {
        if self.activity == Activity::Moving
            && let Some(active) = self.travel.detach_active()
        {
            controls.end_move(active.execution, 0);
        }
    }

    /// Ends an active stop's instruction without PC.
    pub(crate) fn end_stop(&mut self, controls: &mut Controls) {
        if let Some(stop) = self.stop.take() {
            controls.write(stop.execution, 0, Flag::Ip.mask());
        }
    }

    /// Completes the instruction of a stop when all its axes stand.
    pub(crate) fn finish_stop(&mut self, axes: &Axes, controls: &mut Controls) {
        let Some(stop) = self.stop else {
            return;
        };
        let braking = |(id, axis): (AxisId, &Axis)| stop.braking.contains(id) && axis.is_braking();
        if self.activity == Activity::Stopping || (!stop.braking.is_empty() && axes.ids().zip(axes.iter()).any(braking))
        {
            return;
        }
        self.stop = None;
        controls.write(stop.execution, Flag::Pc.mask(), Flag::Ip.mask());
    }

    /// Drops the braking axes that stand, or that another move uses.
    pub(crate) fn finish_braking(&mut self, axes: &Axes) {
        if !self.brakes(axes) {
            self.braking = AxisSet::default();
        }
    }

    /// Makes the system idle: no move is active.
    pub(crate) fn rest(&mut self) {
        self.activity = Activity::Idle;
        self.shown = self.shown.at_rest();
        self.follower = None;
        self.ended = None;
        self.stale = false;
    }
}
