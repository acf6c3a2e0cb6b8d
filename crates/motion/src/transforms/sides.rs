//! The axes of one side of a transform, and their motion.
//!
//! Units: position units or degrees, seconds.

use arcline_planner::geometry::Point as Vector;
use arcline_profile::KinematicState;

use crate::axes::AxisList;
use crate::machine::{MAX_PRIMARY_AXES, MAX_SYSTEM_AXES};

/// Position, velocity and acceleration of each axis of one side.
pub(crate) type SideState = [KinematicState; MAX_SYSTEM_AXES];

/// The axes of one side.
pub(crate) type SideAxes = AxisList<MAX_SYSTEM_AXES>;

/// A position of each axis of one side.
pub(crate) type Positions = [f64; MAX_SYSTEM_AXES];

/// A side with motion of its first three axes only.
pub(super) fn wide([first, second, third]: [KinematicState; MAX_PRIMARY_AXES]) -> SideState {
    let mut side = SideState::default();
    (side[0], side[1], side[2]) = (first, second, third);
    side
}

/// The positions of a side.
pub(super) fn positions(side: &SideState) -> Positions {
    side.map(|point| point.position)
}

/// A side at rest.
pub(super) fn at_rest(positions: &Positions) -> SideState {
    positions.map(KinematicState::at_rest)
}

/// The first three axes of a side as vectors: position, velocity, acceleration.
pub(super) fn vectors(side: &SideState) -> [Vector; 3] {
    let mut vectors = [Vector::zeros(); 3];
    for (index, point) in side.iter().enumerate().take(MAX_PRIMARY_AXES) {
        vectors[0][index] = point.position;
        vectors[1][index] = point.velocity;
        vectors[2][index] = point.acceleration;
    }
    vectors
}

/// A side of three axes from vectors.
pub(super) fn side([position, velocity, acceleration]: [Vector; 3]) -> SideState {
    wide([0, 1, 2].map(|index| KinematicState {
        position: position[index],
        velocity: velocity[index],
        acceleration: acceleration[index],
    }))
}

/// Adds a motion to another.
pub(super) fn add(total: &mut KinematicState, more: &KinematicState) {
    total.position += more.position;
    total.velocity += more.velocity;
    total.acceleration += more.acceleration;
}
