//! Links to master axes: MDCC's of coordinate systems, MDAC's of axes (spec/coordinated-instructions.md §8.3, §18;
//! spec/axis-and-data-types.md §3.8).
//!
//! A link moves nothing. A motion that begins by it has its own master follower, which continues when the link is replaced. A link to
//! another master waits behind the active one until a motion begins by it. Not here: the causes that break links (`motion::master_links`).

use arcline_instruction_set::Flag;
use arcline_instruction_set::enumerations::MdacMotionType;

use super::master::Master;
use crate::control::Controls;
use crate::execution::Execution;

/// A link to a master.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MasterLink {
    /// Its number, unique in the machine.
    pub(crate) id: u32,
    pub(crate) execution: Execution,
    pub(crate) master: Master,
    /// The nominal speed of the master, master units/s, more than 0.
    pub(crate) nominal: f64,
    /// The nominal speed comes from Nominal Master Velocity.
    pub(crate) has_nominal: bool,
    /// AC, as last written.
    pub(crate) shown_active: bool,
}

impl MasterLink {
    /// Updates AC of the link's instruction: a motion that began by the link is under way.
    pub(crate) fn show_active(&mut self, is_used: bool, controls: &mut Controls) {
        if std::mem::replace(&mut self.shown_active, is_used) != is_used {
            controls.flag(self.execution, Flag::Ac, is_used);
        }
    }
}

/// The links of one slave.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct MasterLinks {
    pub(crate) active: Option<MasterLink>,
    /// The link that becomes active when a motion begins by it.
    pub(crate) pending: Option<MasterLink>,
}

impl MasterLinks {
    /// The link by which a new motion begins.
    pub(crate) fn newest(&self) -> Option<&MasterLink> {
        self.pending.as_ref().or(self.active.as_ref())
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.active.is_none() && self.pending.is_none()
    }

    /// The active and the pending link, if they exist.
    pub(crate) fn iter(&self) -> impl Iterator<Item = &MasterLink> {
        self.active.iter().chain(&self.pending)
    }

    /// The active and the pending link, if they exist, mutable.
    pub(crate) fn iter_mut(&mut self) -> impl Iterator<Item = &mut MasterLink> {
        self.active.iter_mut().chain(&mut self.pending)
    }

    /// Starts a motion by a link: a pending link replaces the active one. Returns the link, if it still exists, and the instruction of the link
    /// that ended.
    pub(crate) fn take_up(&mut self, id: u32) -> Option<(MasterLink, Option<Execution>)> {
        if let Some(link) = self.pending.filter(|link| link.id == id) {
            self.pending = None;
            let ended = self.active.replace(link).map(|ended| ended.execution);
            return Some((link, ended));
        }
        self.active.filter(|link| link.id == id).map(|link| (link, None))
    }

    /// Makes a link. A link to the same master is renewed; a link to another master waits behind the active one and replaces the link that waited
    /// before. Returns the instructions of the links that ended.
    pub(crate) fn make(&mut self, mut link: MasterLink) -> [Option<Execution>; 2] {
        let same = |other: &MasterLink| {
            other.master.axis == link.master.axis && other.master.reference == link.master.reference
        };
        let waited = self.pending.take();
        let waiting = waited.filter(same);
        match self.active {
            Some(active) if active.master.axis == link.master.axis => {
                if same(&active) {
                    link.id = active.id;
                    link.master = active.master;
                }
                self.active = Some(link);
                [Some(active.execution), waited.map(|ended| ended.execution)]
            }
            Some(_) => {
                link.id = waiting.map_or(link.id, |waiting| waiting.id);
                self.pending = Some(link);
                [None, waited.map(|ended| ended.execution)]
            }
            None => {
                self.active = Some(link);
                [None, None]
            }
        }
    }
}

/// The kinds of motion that a link of all kinds serves.
const KINDS: [MdacMotionType; 4] = [
    MdacMotionType::Move,
    MdacMotionType::Jog,
    MdacMotionType::TimeCam,
    MdacMotionType::MasterOffsetMove,
];

/// The links of one axis.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct AxisMasterLinks {
    links: [MasterLinks; 1 + KINDS.len()],
    /// The axis has had a link; ticks pass over the links of other axes.
    made: bool,
}

impl AxisMasterLinks {
    /// The links of one Motion Type.
    pub(crate) fn of(&self, serves: MdacMotionType) -> &MasterLinks {
        &self.links[serves as usize]
    }

    /// The links of one Motion Type, mutable.
    pub(crate) fn of_mut(&mut self, serves: MdacMotionType) -> &mut MasterLinks {
        self.made = true;
        &mut self.links[serves as usize]
    }

    /// The link by which a new motion begins: of its own kind, or of all kinds.
    pub(crate) fn newest(&self, serves: MdacMotionType) -> Option<&MasterLink> {
        self.of(serves)
            .newest()
            .or_else(|| self.of(MdacMotionType::All).newest())
    }

    /// A link for all kinds of motion would coexist with one for a single kind.
    pub(crate) fn conflict(&self, serves: MdacMotionType) -> bool {
        let taken = |other: MdacMotionType| !self.of(other).is_empty();
        match serves {
            MdacMotionType::All => KINDS.iter().any(|other| taken(*other)),
            _ => taken(MdacMotionType::All),
        }
    }

    pub(crate) fn is_empty(&self) -> bool {
        !self.made || self.links.iter().all(MasterLinks::is_empty)
    }

    /// Every link.
    pub(crate) fn iter(&self) -> impl Iterator<Item = &MasterLink> {
        self.links.iter().flat_map(MasterLinks::iter)
    }

    /// Every link, mutable.
    pub(crate) fn iter_mut(&mut self) -> impl Iterator<Item = &mut MasterLink> {
        self.links.iter_mut().flat_map(MasterLinks::iter_mut)
    }

    /// As [`MasterLinks::take_up`].
    pub(crate) fn take_up(&mut self, id: u32) -> Option<(MasterLink, Option<Execution>)> {
        self.links.iter_mut().find_map(|links| links.take_up(id))
    }
}
