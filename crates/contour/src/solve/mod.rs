//! The optimisation of timing and shape together: the limited quantities, and the search for a faster motion within the limits.

mod assemble;
mod banded;
pub(crate) mod derivatives;
pub(crate) mod measure;
mod merit;
mod on_curve;
pub(crate) mod optimise;
pub(crate) mod problem;
pub(crate) mod relax;
pub(crate) mod setup;
pub(crate) mod stages;
pub(crate) mod step_lengths;
pub(crate) mod work;
