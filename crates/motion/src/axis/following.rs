//! An axis's part in gears and transforms: its master, the transforms that it belongs to, and the stop of motion that a cancelled
//! transform leaves.
//!
//! Not here: the positions that the axis follows (`crate::masters`, `crate::transforms`).

use arcline_instruction_set::{AxisIndex, MotionError};
use arcline_planner::Instant;
use arcline_planner::profile::{Limits, Profile};
use arcline_profile::KinematicState;

use super::Axis;
use super::generator::{Equation, Generator};
use super::generator_kind::GeneratorKind;
use crate::masters::gear::Gear;
use crate::transforms::id::TransformId;

/// The transforms to which an axis belongs.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct TransformMembership {
    /// The transform whose target the axis belongs to.
    pub(crate) target_of: Option<TransformId>,
    /// Transforms whose sources the axis belongs to, a bit for each.
    pub(crate) source_of: u64,
    /// The position that the axis keeps, in the frame of its generator, while no transform moves it.
    pub(crate) rest: f64,
    /// The feedback of transforms that have ended.
    pub(crate) settled: f64,
    /// A transform moves the axis.
    pub(crate) controlled: bool,
}

impl Axis {
    /// The axis belongs to the source or the target of a transform.
    pub(crate) fn is_transformed(&self) -> bool {
        self.transforms.target_of.is_some() || self.transforms.source_of != 0
    }

    /// Homing and redefining the position would break the link of an axis that a transform moves.
    ///
    /// # Errors
    /// `AxisInTransformMotion` (63) if the axis is part of a transform.
    pub(crate) fn not_in_transform(&self) -> Result<(), MotionError> {
        if self.is_transformed() {
            return Err(MotionError::AxisInTransformMotion(AxisIndex(0)));
        }
        Ok(())
    }

    /// The master and the equation of its gearing.
    pub(crate) fn gear(&self) -> Option<&Gear> {
        match &self.sum.get(GeneratorKind::Gear)?.equation {
            Equation::Geared(gear) => Some(gear),
            _ => None,
        }
    }

    /// A generator brakes motion that a cancelled transform left.
    pub(crate) fn stops_after_transform(&self) -> bool {
        self.sum.active().any(|(_, generator)| generator.after_transform)
    }

    /// Brakes the motion that a cancelled transform left, together with that of earlier ones.
    pub(crate) fn brake_after_transform(&mut self, moved: KinematicState, limits: &Limits, now: Instant) {
        let mut from = KinematicState {
            position: self.command.position,
            velocity: moved.velocity,
            acceleration: moved.acceleration,
        };
        if let Some(earlier) = self.sum.get(GeneratorKind::TransformStop) {
            from.velocity += earlier.now.velocity;
            from.acceleration += earlier.now.acceleration;
        }
        if limits.jerk.is_none() {
            from.acceleration = 0.0;
        }
        let mut generator = Generator::planned(Profile::stop_within(from, limits, None, self.dynamics_bits), now);
        generator.stopping = true;
        generator.after_transform = true;
        generator.s_curve = limits.jerk.is_some();
        self.sum.begin(GeneratorKind::TransformStop, generator);
        self.command = self.sum.command();
        self.stale = true;
    }

    /// Sets the position of an axis without a drive; slaves do not follow this shift.
    pub(crate) fn set_virtual(&mut self, position: f64) {
        self.redefine(position - self.command.position);
        self.stand_at(position);
        self.actual = self.command;
    }
}
