//! An encoder: positions in whole counts. Not here: roll-over; positions are unbounded, in position units.

/// An encoder with this many counts per unit, or one without steps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Encoder {
    pub(crate) resolution: Option<f64>,
}

impl Encoder {
    /// The position of the nearest count.
    pub(crate) fn read(self, position: f64) -> f64 {
        match self.resolution {
            Some(resolution) => (position * resolution).round() / resolution,
            None => position,
        }
    }
}
