//! Transforms: pairs of coordinate systems that move each other (spec/coordinated-instructions.md §19, §20).
//!
//! [`Transforms`] owns the active transforms and their rules: the map of positions ([`robot`], [`transform`]), set-points and feedback
//! within a tick ([`compute`]), and the end ([`cancel`]). The checks that a robot can follow start from a [`present::Present`]: a path is
//! checked before it begins ([`reach`]), a stop before it is too late ([`ahead`], [`guard`]). `Motion` orders the reaction
//! (`crate::motion`). Nothing allocates after [`Transforms::new`].

pub(crate) mod ahead;
pub(crate) mod cancel;
pub(crate) mod compute;
pub(crate) mod guard;
pub(crate) mod id;
pub(crate) mod present;
mod reach;
pub(crate) mod robot;
pub(crate) mod shown;
pub(crate) mod sides;
pub(crate) mod transform;

use arcline_instruction_set::{AxisId, SystemId};
use arcline_profile::KinematicState;

use crate::axes::{Axes, share};
use crate::execution::Execution;
use crate::system::System;
pub(crate) use id::TransformId;
use sides::{SideState, add};
use transform::Transform;

/// Transforms under way.
#[derive(Debug)]
pub(crate) struct Transforms {
    /// The transforms at the indices of their target systems.
    active: Vec<Option<Transform>>,
}

impl Transforms {
    /// Without transforms, for a machine with this number of coordinate systems. The only allocation.
    pub(crate) fn new(systems: usize) -> Self {
        Transforms {
            active: vec![None; systems],
        }
    }

    /// The largest number of transforms: one for each target system.
    pub(crate) fn most(&self) -> usize {
        self.active.len()
    }

    /// Every possible transform.
    pub(crate) fn ids(&self) -> impl Iterator<Item = TransformId> + use<> {
        SystemId::first(self.active.len()).map(TransformId::of_target)
    }

    /// A transform, if it is active.
    pub(crate) fn get(&self, id: TransformId) -> Option<&Transform> {
        self.active.get(id.index())?.as_ref()
    }

    fn get_mut(&mut self, id: TransformId) -> Option<&mut Transform> {
        self.active.get_mut(id.index())?.as_mut()
    }

    /// Active transforms.
    pub(crate) fn iter(&self) -> impl Iterator<Item = (TransformId, &Transform)> {
        self.ids().filter_map(|id| Some((id, self.get(id)?)))
    }

    /// The transform whose target has axes of the source of this one.
    pub(crate) fn preceding(&self, transform: &Transform) -> Option<(TransformId, &Transform)> {
        self.iter().find(|(_, other)| share(&other.target, &transform.source))
    }

    /// A system moves axes of the source of a transform, or of the source of a transform before it.
    fn moves_source(&self, system: &System, transform: &Transform, depth: usize) -> bool {
        if transform.source.iter().any(|axis| system.has(*axis)) {
            return true;
        }
        let mut others = self.iter();
        depth > 0
            && others.any(|(_, preceding)| {
                share(&preceding.target, &transform.source) && self.moves_source(system, preceding, depth - 1)
            })
    }

    /// The displacement of a transform's source by steps of its own axes, and of those of the transforms before it.
    fn step_of(&self, transform: &Transform, step: &impl Fn(AxisId) -> KinematicState, depth: usize) -> SideState {
        let mut whole = SideState::default();
        for (axis, point) in transform.source.iter().zip(&mut whole) {
            *point = step(*axis);
        }
        for (_, preceding) in self.iter() {
            if depth == 0 || !share(&preceding.target, &transform.source) {
                continue;
            }
            let steps = preceding.turned(&self.step_of(preceding, step, depth - 1));
            for (axis, step) in preceding.target.iter().zip(&steps) {
                if let Some(index) = transform.source.index_of(*axis) {
                    add(&mut whole[index], step);
                }
            }
        }
        whole
    }

    /// Marks a failed transform: every motion of either side must brake. Returns its instruction, if that has not ended before.
    pub(crate) fn begin_braking(&mut self, id: TransformId) -> Option<Execution> {
        let transform = self.get_mut(id)?;
        transform.braking = true;
        transform.execution.take()
    }

    /// An axis of either side of a transform is in motion.
    fn moves_either_side(&self, axes: &Axes, transform: &Transform) -> bool {
        transform.axes().any(|axis| axes[axis].in_motion())
    }
}
