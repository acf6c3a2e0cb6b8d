//! The settings of a simulated servo. The configuration checks them.

/// A simulated servo drive with its motor, load and encoder.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Bandwidth of the position loop, Hz, more than 0.
    pub bandwidth: f64,
    /// Feed-forward share of the command velocity, 0 to 1.
    pub feedforward: f64,
    /// Highest speed of the motor, units/s, more than 0; infinite: unlimited.
    pub speed_limit: f64,
    /// Acceleration of the axis at the motor's highest torque, units/s², more than 0; infinite: unlimited.
    pub torque_limit: f64,
    /// Encoder counts per unit, more than 0; `None`: the feedback is the true position.
    pub encoder_resolution: Option<f64>,
}

impl Settings {
    /// A servo without limits and without an encoder: the transfer function of its loop only.
    pub fn unlimited(bandwidth: f64, feedforward: f64) -> Self {
        Settings {
            bandwidth,
            feedforward,
            speed_limit: f64::INFINITY,
            torque_limit: f64::INFINITY,
            encoder_resolution: None,
        }
    }
}

impl Default for Settings {
    /// A bandwidth of 40 Hz, full velocity feed-forward, no limits.
    fn default() -> Self {
        Settings::unlimited(40.0, 1.0)
    }
}
