//! A simulated machine: servos with limits and encoders, home switches, markers and mechanical stops, solved exactly over each
//! update period.
//!
//! Units: position units, seconds. Nothing allocates after [`SimulatedDrives::new`].

mod curve;
mod drive;
mod encoder;
mod machine;
mod model;
mod regime;
mod sensor;
mod servo;
mod settings;
mod settling;
mod tolerance;

pub use drive::Drive;
pub use machine::{SimulatedAxis, SimulatedDrives};
pub use model::{MechanicalModel, ModelDrives, ModelFailed, ModelledAxis};
pub use sensor::Sensor;
pub use servo::Servo;
pub use settings::Settings;
pub use settling::Settling;
