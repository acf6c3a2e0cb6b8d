//! New links to masters, and the master displacements of the moves that begin by these links.

use arcline_instruction_set::AxisId;
use arcline_instruction_set::enumerations::Reference;
use arcline_planner::{Clock, Parameter};

use super::links::MasterLink;
use super::master::Master;
use crate::axes::Axes;
use crate::execution::Execution;

/// Numbers of links, and of master displacements that moves are functions of: each number is used once.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct LinkNumbers {
    links: u32,
    parameters: u32,
}

impl LinkNumbers {
    /// No link has been made yet.
    pub(crate) fn is_unused(&self) -> bool {
        self.links == 0
    }

    /// A link to a master in its present state. `nominal`: the Nominal Master Velocity; if it is 0, the master's Maximum Speed counts.
    pub(crate) fn link(
        &mut self,
        execution: Execution,
        (master, reference): (AxisId, Reference),
        nominal: f64,
        axes: &Axes,
        clock: &Clock,
    ) -> MasterLink {
        self.links += 1;
        let at = axes.master_at(master, reference, clock);
        let has_nominal = nominal > 0.0;
        let nominal = if has_nominal {
            nominal
        } else {
            axes[master].dynamics.speed
        };
        MasterLink {
            id: self.links,
            execution,
            master: Master::new(master, reference, &at, clock),
            nominal,
            has_nominal,
            shown_active: false,
        }
    }

    /// The master displacement that a new move is a function of. Moves over the same one can blend.
    pub(crate) fn parameter(&mut self, link: &MasterLink) -> Parameter {
        self.parameters += 1;
        Parameter {
            number: self.parameters,
            speed: link.nominal,
        }
    }
}
