//! The programmed path, and the permitted deviation of the curve from it.

pub(crate) mod allowance;
pub(crate) mod corridor;
pub(crate) mod margin;
pub(crate) mod reach;
pub(crate) mod reference;
pub(crate) mod rounding;
pub(crate) mod smooth;
pub(crate) mod straight;
