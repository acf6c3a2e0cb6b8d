//! What a geometry refuses.

use thiserror::Error;

/// Why there are no joints for a point, or no point for joints.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
pub enum KinematicsError {
    /// Beyond the reach or the computed limits of a joint, or at its very end while it moves (ERR 67).
    #[error("joint {} cannot reach the position", joint + 1)]
    Reach {
        /// Place of the joint, from 0.
        joint: u8,
    },
    /// At the singular origin: on the axis of the first joint, or where the arms hold nothing (ERR 68).
    #[error("the position is at the singular origin")]
    Origin,
    /// An orientation that the robot cannot make (ERR 67).
    #[error("the robot cannot make angle {} of the orientation", angle + 1)]
    Orientation {
        /// Place of the angle among X, Y, Z, Rx, Ry, Rz, from 0.
        angle: u8,
    },
}

/// Why parameters make no robot.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
pub enum GeometryError {
    /// A link length is not above 0, or both are equal in a delta (ERR 61, EXERR 9).
    #[error("link lengths must be above 0, and those of a delta must differ")]
    LinkLengths,
    /// The offsets leave no workspace (ERR 61, EXERR 10).
    #[error("base and end-effector offsets leave no workspace")]
    Offsets,
}
