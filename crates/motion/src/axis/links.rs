//! The links of one axis to masters (MDAC): motions that begin by them, their end, and the bits that show them.
//!
//! Real-time: nothing allocates; bounded by the links of an axis.

use arcline_instruction_set::AxisId;
use arcline_planner::Clock;

use super::Axis;
use super::generator::Generator;
use super::generator_kind::GeneratorKind;
use crate::control::Controls;
use crate::masters::cam::Cam;

impl Axis {
    /// Makes the link of a cam that begins the active one.
    pub(crate) fn take_up_link(&mut self, link: u32, controls: &mut Controls) {
        if let Some((_, ended)) = self.links.take_up(link) {
            controls.end_links([ended]);
        }
    }

    /// Breaks its links to masters. The motions that they drive brake.
    pub(crate) fn unlink(&mut self, controls: &mut Controls, clock: &Clock) {
        let links = std::mem::take(&mut self.links);
        for link in links.iter() {
            controls.end_move(link.execution, 0);
        }
        let cam = self.cam(GeneratorKind::TimeCam).and_then(Cam::link);
        if cam.is_some() {
            self.end_pending_cams(Some(GeneratorKind::TimeCam), controls);
        }
        for kind in GeneratorKind::MASTER_DRIVEN
            .into_iter()
            .chain(cam.map(|_| GeneratorKind::TimeCam))
        {
            let generator = self.sum.get(kind);
            let driven = |generator: &&Generator| generator.follower.is_some() || kind == GeneratorKind::TimeCam;
            if let Some(generator) = generator.filter(driven) {
                let limits = self.dynamics.stop(generator.s_curve);
                self.stop_generator(kind, &limits, None, controls, clock);
            }
        }
    }

    /// Updates AC of its links as soon as a motion by a link begins or ends.
    pub(crate) fn show_links(&mut self, controls: &mut Controls) {
        if self.links.is_empty() {
            return;
        }
        let follower = |kind| self.sum.get(kind)?.follower.map(|follower| follower.link);
        let cam = self.cam(GeneratorKind::TimeCam).and_then(Cam::link);
        let [moves, jogs, offsets] = GeneratorKind::MASTER_DRIVEN.map(follower);
        let used = [moves, jogs, offsets, cam];
        for link in self.links.iter_mut() {
            link.show_active(used.contains(&Some(link.id)), controls);
        }
    }

    /// The masters of its gear, its cams, its links and its motions.
    pub(crate) fn masters(&self) -> impl Iterator<Item = AxisId> {
        let gear = self.gear().map(|gear| gear.master.axis);
        let cams = Axis::CAMS.into_iter().filter_map(|kind| self.cam_master(kind));
        let driven = self.sum.active().filter_map(|(_, generator)| generator.follower);
        let links = self.links.iter().map(|link| link.master.axis);
        gear.into_iter()
            .chain(cams)
            .chain(links)
            .chain(driven.map(|follower| follower.master.axis))
    }

    /// The axis is the master of one of its links, or of a motion that began by one.
    pub(crate) fn is_linked_to(&self, master: AxisId) -> bool {
        let mut followers = self.sum.active().filter_map(|(_, generator)| generator.follower);
        let cam = self.cam(GeneratorKind::TimeCam).filter(|cam| cam.link().is_some());
        let cammed = cam.is_some() && self.cam_master(GeneratorKind::TimeCam) == Some(master);
        cammed
            || followers.any(|follower| follower.master.axis == master)
            || self.links.iter().any(|link| link.master.axis == master)
    }
}
