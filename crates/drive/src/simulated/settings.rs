//! The settings of a simulated servo. The configuration checks them.

/// A simulated servo drive with its motor, load and encoder.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Bandwidth of the position loop, Hz, more than 0.
    pub bandwidth: f64,
    /// Share of the command velocity that is fed forward, 0 to 1.
    pub feedforward: f64,
    /// Highest speed of the motor, units/s, more than 0; infinite: no limit.
    pub speed_limit: f64,
    /// Acceleration of the axis under the motor's highest torque, units/s², more than 0; infinite: no limit.
    pub torque_limit: f64,
    /// Encoder counts per unit, more than 0; `None`: the position is seen as it is.
    pub encoder_resolution: Option<f64>,
}

impl Settings {
    /// A servo without limits, seen as it is: the transfer function of its loop and nothing else.
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
    /// A bandwidth of 40 Hz, all velocity fed forward, no limits.
    fn default() -> Self {
        Settings::unlimited(40.0, 1.0)
    }
}
