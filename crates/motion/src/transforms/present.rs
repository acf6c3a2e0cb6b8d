//! The state from which a look ahead begins.

use arcline_planner::Clock;

use super::Transforms;
use crate::axes::Axes;
use crate::system::Systems;

/// Axes, coordinate systems and transforms at the present tick, to look ahead from.
#[derive(Clone, Copy)]
pub(crate) struct Present<'a> {
    pub(crate) axes: &'a Axes,
    pub(crate) systems: &'a Systems,
    pub(crate) transforms: &'a Transforms,
    pub(crate) clock: &'a Clock,
}
