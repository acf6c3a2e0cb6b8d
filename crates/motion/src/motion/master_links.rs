//! Motions that begin by a link to a master, the causes that break links, and the status of links (spec/coordinated-instructions.md
//! §8.3, §8.9).
//!
//! Real-time: no allocation; bounded by the axes and the coordinate systems.

use arcline_instruction_set::{AxisId, Flag, MotionError, SystemId};
use arcline_planner::{Instant, Parameter};

use super::Motion;
use crate::axis::generator::Generator;
use crate::axis::generator_kind::GeneratorKind;
use crate::control::Controls;
use crate::execution::Execution;
use crate::masters::cam::Cam;
use crate::masters::follower::{Beginning, LockTo, MasterFollower};
use crate::masters::links::MasterLink;
use crate::masters::master::Master;
use crate::system::{Activity, DrivenBy};
use arcline_instruction_set::enumerations::Reference;

impl Motion {
    /// A link to a master as it is now. `nominal`: how fast the master moves in general; its Maximum Speed where that is 0.
    pub(crate) fn new_link(
        &mut self,
        execution: Execution,
        master: AxisId,
        reference: Reference,
        nominal: f64,
    ) -> MasterLink {
        self.link_count += 1;
        let at = self.axes.master_at(master, reference, &self.clock);
        let has_nominal = nominal > 0.0;
        let nominal = if has_nominal {
            nominal
        } else {
            self.axes[master].dynamics.speed
        };
        MasterLink {
            id: self.link_count,
            execution,
            master: Master::new(master, reference, &at, &self.clock),
            nominal,
            has_nominal,
            shown_active: false,
        }
    }

    /// The master displacement that a new move is a function of. Moves over the same one can blend.
    pub(crate) fn new_parameter(&mut self, link: &MasterLink) -> Parameter {
        self.way_count += 1;
        Parameter {
            number: self.way_count,
            speed: link.nominal,
        }
    }

    /// A move of a coordinate system becomes active at an instant of this update: the link by which it is driven is the
    /// active one from now on.
    ///
    /// # Errors
    /// `MdscNotActivated` (93) where there is no such link any more.
    pub(crate) fn lead_system(
        &mut self,
        index: SystemId,
        driven_by: Option<DrivenBy>,
        since: Instant,
    ) -> Result<(), MotionError> {
        let follower = match driven_by {
            None => None,
            Some(DrivenBy { link, lock }) => {
                let taken = self.systems[index].links.take_up(link);
                let (link, ended) = taken.ok_or(MotionError::MdscNotActivated)?;
                self.end_link(ended);
                Some(self.follower(&link, lock, since))
            }
        };
        let system = &mut self.systems[index];
        system.follower = follower;
        system.ended = None;
        Ok(())
    }

    /// The master follower of a motion that begins on an axis at the present tick; its link is the active one from now on.
    pub(crate) fn lead_axis(&mut self, axis: AxisId, driven_by: DrivenBy) -> Option<MasterFollower> {
        let (link, ended) = self.axes[axis].links.take_up(driven_by.link)?;
        self.end_link(ended);
        Some(self.follower(&link, driven_by.lock, self.clock.now()))
    }

    /// The link by which a cam begins on an axis is the active one from now on.
    pub(crate) fn take_up_link(&mut self, axis: AxisId, link: u32) {
        if let Some((_, ended)) = self.axes[axis].links.take_up(link) {
            self.end_link(ended);
        }
    }

    fn follower(&self, link: &MasterLink, lock: LockTo, since: Instant) -> MasterFollower {
        let Master { axis, reference, .. } = link.master;
        let at = self.axes.master_at(axis, reference, &self.clock);
        let unwind = self.axes[axis].unwind;
        let beginning = Beginning {
            link: link.id,
            lock,
            unwind,
            since,
        };
        MasterFollower::begin(beginning, &link.master, &at, &self.clock)
    }

    pub(crate) fn end_link(&mut self, execution: Option<Execution>) {
        if let Some(execution) = execution {
            self.end_move(execution, 0);
        }
    }

    /// Breaks every link that has an axis as its slave, or as one of its slave's axes. The motions that they drive brake.
    pub(crate) fn unlink_slave(&mut self, axis: AxisId) {
        self.unlink_axis(axis);
        for index in self.systems.ids() {
            if self.systems[index].has(axis) {
                self.unlink_system(index);
            }
        }
    }

    /// Breaks every link of the slaves of a master, those to other masters too.
    pub(crate) fn unlink_master(&mut self, master: AxisId) {
        for index in self.systems.ids() {
            let system = &self.systems[index];
            let follows = system.follower.is_some_and(|follower| follower.master.axis == master);
            if follows || system.links.iter().any(|link| link.master.axis == master) {
                self.unlink_system(index);
                for place in 0..self.systems[index].description.axes.len() {
                    self.unlink_slave(self.systems[index].description.axes[place]);
                }
            }
        }
        for axis in self.axes.ids() {
            let state = &self.axes[axis];
            let mut followers = state.sum.active().filter_map(|(_, generator)| generator.follower);
            let cam = state.cam(GeneratorKind::TimeCam).filter(|cam| cam.link().is_some());
            let cammed = cam.is_some() && state.cam_master(GeneratorKind::TimeCam) == Some(master);
            let follows = cammed || followers.any(|follower| follower.master.axis == master);
            drop(followers);
            if follows || state.links.iter().any(|link| link.master.axis == master) {
                self.unlink_slave(axis);
            }
        }
    }

    /// Breaks every link there is.
    pub(crate) fn unlink_all(&mut self) {
        for axis in self.axes.ids() {
            self.unlink_axis(axis);
        }
        for index in self.systems.ids() {
            self.unlink_system(index);
        }
    }

    fn unlink_axis(&mut self, axis: AxisId) {
        let links = std::mem::take(&mut self.axes[axis].links);
        for link in links.iter() {
            self.end_move(link.execution, 0);
        }
        let cam = self.axes[axis].cam(GeneratorKind::TimeCam).and_then(Cam::link);
        if cam.is_some() {
            self.end_pending_cams(axis, Some(GeneratorKind::TimeCam));
        }
        for kind in GeneratorKind::GUIDED
            .into_iter()
            .chain(cam.map(|_| GeneratorKind::TimeCam))
        {
            let generator = self.axes[axis].sum.get(kind);
            let driven = |generator: &&Generator| generator.follower.is_some() || kind == GeneratorKind::TimeCam;
            if let Some(generator) = generator.filter(driven) {
                let limits = self.axes[axis].dynamics.stop(generator.s_curve);
                self.stop_generator(axis, kind, &limits, None);
            }
        }
    }

    /// The motion that the system's master was driving brakes on its path, in time, at the maxima of the coordinate system.
    fn unlink_system(&mut self, index: SystemId) {
        let links = std::mem::take(&mut self.systems[index].links);
        for link in links.iter() {
            if self.systems[index].stopping_link == Some(link.execution) {
                // AC is shown until all stands.
                self.controls.write(link.execution, 0, Flag::Ip.mask(), self.clock.tick);
            } else {
                self.end_move(link.execution, 0);
            }
        }
        let system = &self.systems[index];
        if system.follower.is_none() {
            return;
        }
        let mut limits = system.path_stop();
        limits.deceleration = self.kept_by_turn(index, limits.deceleration);
        self.cancel_pending(index);
        self.end_active(index);
        self.stop_on_path(index, &limits);
    }

    /// AC of links: it shows at once that a motion by the link begins or ends.
    pub(crate) fn show_links(&mut self) {
        // In every tick, and few machines have a link.
        if self.link_count == 0 {
            return;
        }
        for index in self.systems.ids() {
            self.end_stopping_link(index);
            let system = &self.systems[index];
            if system.links.is_empty() {
                continue;
            }
            let moving = system.activity == Activity::Moving;
            let used = system.follower.filter(|_| moving).map(|follower| follower.link);
            let stopping = system.stopping_link;
            for link in self.systems[index].links.iter_mut() {
                let is_used = used == Some(link.id) || stopping == Some(link.execution);
                link.show_active(is_used, &mut self.controls, self.clock.tick);
            }
        }
        for axis in self.axes.awake_mut().filter(|axis| !axis.links.is_empty()) {
            let follower = |kind| axis.sum.get(kind)?.follower.map(|follower| follower.link);
            let cam = axis.cam(GeneratorKind::TimeCam).and_then(Cam::link);
            let [moves, jogs, offsets] = GeneratorKind::GUIDED.map(follower);
            let used = [moves, jogs, offsets, cam];
            for link in axis.links.iter_mut() {
                link.show_active(used.contains(&Some(link.id)), &mut self.controls, self.clock.tick);
            }
        }
    }

    /// The link by which the active move of a system is driven goes on to show AC while an instruction stops that move.
    pub(crate) fn keep_stopping_link(&mut self, index: SystemId) {
        let system = &mut self.systems[index];
        let follower = system.follower.filter(|_| system.activity == Activity::Moving);
        if let Some(used) = follower.and_then(|follower| system.links.active.filter(|link| link.id == follower.link)) {
            system.stopping_link = Some(used.execution);
        }
    }

    fn end_stopping_link(&mut self, index: SystemId) {
        let system = &mut self.systems[index];
        let Some(execution) = system.stopping_link.filter(|_| system.stop.is_none()) else {
            return;
        };
        system.stopping_link = None;
        for link in system.links.iter_mut().filter(|link| link.execution == execution) {
            link.shown_active = false;
        }
        self.controls.flag(execution, Flag::Ac, false, self.clock.tick);
    }
}

impl MasterLink {
    /// AC of the link's instruction: whether a motion that began by the link is under way.
    fn show_active(&mut self, is_used: bool, controls: &mut Controls, tick: u64) {
        if std::mem::replace(&mut self.shown_active, is_used) != is_used {
            controls.flag(self.execution, Flag::Ac, is_used, tick);
        }
    }
}
