//! The links of coordinate systems to masters: moves that begin by them, their end, and the bits that show them
//! (spec/coordinated-instructions.md §8.3).
//!
//! Real-time: no allocation; bounded by the links of a coordinate system.

use arcline_instruction_set::{AxisId, Flag, MotionError, SystemId};
use arcline_planner::{Clock, Instant};

use super::{Activity, System, Systems};
use crate::axes::Axes;
use crate::control::Controls;
use crate::masters::follower::DrivenBy;

impl System {
    /// Activates the link that drives a move which becomes active at an instant of this update.
    ///
    /// # Errors
    /// `MdscNotActivated` (93) if the link no longer exists.
    pub(crate) fn activate_link(
        &mut self,
        driven_by: Option<DrivenBy>,
        since: Instant,
        axes: &Axes,
        controls: &mut Controls,
        clock: &Clock,
    ) -> Result<(), MotionError> {
        let follower = match driven_by {
            None => None,
            Some(DrivenBy { link, lock }) => {
                let taken = self.links.take_up(link);
                let (link, ended) = taken.ok_or(MotionError::MdscNotActivated)?;
                controls.end_links([ended]);
                Some(axes.follower(&link, lock, since, clock))
            }
        };
        self.follower = follower;
        self.ended = None;
        Ok(())
    }

    /// Keeps AC of the link that drives the active move while an instruction stops that move.
    pub(crate) fn keep_stopping_link(&mut self) {
        let follower = self.follower.filter(|_| self.activity == Activity::Moving);
        if let Some(used) = follower.and_then(|follower| self.links.active.filter(|link| link.id == follower.link)) {
            self.stopping_link = Some(used.execution);
        }
    }

    /// Updates AC of its links as soon as a motion by a link begins or ends.
    pub(crate) fn show_links(&mut self, controls: &mut Controls) {
        self.end_stopping_link(controls);
        if self.links.is_empty() {
            return;
        }
        let moving = self.activity == Activity::Moving;
        let used = self.follower.filter(|_| moving).map(|follower| follower.link);
        let stopping = self.stopping_link;
        for link in self.links.iter_mut() {
            let is_used = used == Some(link.id) || stopping == Some(link.execution);
            link.show_active(is_used, controls);
        }
    }

    fn end_stopping_link(&mut self, controls: &mut Controls) {
        let Some(execution) = self.stopping_link.filter(|_| self.stop.is_none()) else {
            return;
        };
        self.stopping_link = None;
        for link in self.links.iter_mut().filter(|link| link.execution == execution) {
            link.shown_active = false;
        }
        controls.flag(execution, Flag::Ac, false);
    }

    /// Reads its masters at the present tick, and the displacement of its move.
    pub(crate) fn read_masters(&mut self, axes: &Axes, clock: &Clock) {
        for link in self.links.iter_mut() {
            let at = axes.master_at(link.master.axis, link.master.reference, clock);
            link.master.read(&at, clock);
        }
        if let Some(follower) = &mut self.follower {
            let at = axes.master_at(follower.master.axis, follower.master.reference, clock);
            follower.advance(&at, clock);
        }
    }

    /// The masters of its links and of its active move.
    pub(crate) fn masters(&self) -> impl Iterator<Item = AxisId> {
        let follower = self.follower.map(|follower| follower.master.axis);
        let links = self.links.iter().map(|link| link.master.axis);
        links.chain(follower)
    }

    /// The axis is a master of its active move or of one of its links.
    pub(crate) fn has_master(&self, master: AxisId) -> bool {
        self.masters().any(|own| own == master)
    }
}

impl Systems {
    /// Breaks the links of a system. The motion that its master was driving brakes on its path, in time, at the maxima of the
    /// coordinate system.
    pub(crate) fn unlink(&mut self, index: SystemId, controls: &mut Controls, clock: &Clock) {
        let system = &mut self[index];
        let links = std::mem::take(&mut system.links);
        for link in links.iter() {
            if system.stopping_link == Some(link.execution) {
                // AC stays set until all axes stand.
                controls.write(link.execution, 0, Flag::Ip.mask());
            } else {
                controls.end_move(link.execution, 0);
            }
        }
        if system.follower.is_none() {
            return;
        }
        let mut limits = system.path_stop();
        limits.deceleration = system.kept_by_turn(limits.deceleration);
        self.cancel_pending(index, controls);
        let system = &mut self[index];
        system.end_active(controls);
        system.stop_on_path(&limits, clock);
    }
}
