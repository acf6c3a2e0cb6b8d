//! The errors of a geometry.

use thiserror::Error;

/// The reason why a point has no joints, or joints have no point.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
pub enum KinematicsError {
    /// Beyond the reach or the computed limits of a joint, or at its end during a motion (ERR 67).
    #[error("joint {} cannot reach the position", joint + 1)]
    Reach {
        /// Index of the joint, from 0.
        joint: u8,
    },
    /// At the singular origin: on the axis of the first joint, or at a point at which the arms hold no plate (ERR 68).
    #[error("the position is at the singular origin")]
    Origin,
    /// An orientation that the robot cannot take (ERR 67).
    #[error("the robot cannot make angle {} of the orientation", angle + 1)]
    Orientation {
        /// Index of the angle among X, Y, Z, Rx, Ry, Rz, from 0.
        angle: u8,
    },
}

/// The reason why parameters form no robot.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
pub enum GeometryError {
    /// A link length is not above 0, or both are equal in a delta (ERR 61, EXERR 9).
    #[error("link lengths must be above 0, and those of a delta must differ")]
    LinkLengths,
    /// The offsets leave no workspace (ERR 61, EXERR 10).
    #[error("base and end-effector offsets leave no workspace")]
    Offsets,
}
