//! The check, before any motion, that the robots moved by a coordinate system can follow a path
//! (spec/coordinated-instructions.md §19.8), and the limits that their joints put on the speed along it.
//!
//! The path is sampled in steps, which are halved if a joint turns far in one, so that neither a crossing of the first joint's axis nor the
//! edge of the workspace lies unnoticed between two samples. Real-time: nothing allocates; the number of samples is fixed.
//! Units: position units, degrees of joints.

use arcline_instruction_set::{AxisId, AxisIndex, MotionError, SystemId};
use arcline_planner::geometry::{Path, Point as Vector, Rotation, angle_rates, angles};
use arcline_profile::KinematicState;
use arcline_profile::numeric::try_bisect;

use super::present::Present;
use super::robot::RobotMap;
use super::sides::SideState;
use super::transform::{Map, Transform};
use crate::dynamics::PathLimits;
use crate::tolerance::{JOINT_FAR_DEG, NO_MOTION_UNITS, ORIGIN_STEP_SHARE, SAMPLED_LIMIT_SHARE};

/// The motion of a coordinate system along a path.
struct MovedPath<'a> {
    path: &'a Path,
    rotation: Option<&'a Rotation>,
    /// Rx, Ry, Rz at its start, degrees.
    heading: Vector,
}

impl PathLimits {
    /// Lowers the limits at a point of the path by the velocity and acceleration of a joint per unit of the path. Half of the joint's
    /// acceleration is reserved for each of the two.
    fn slow(&mut self, joint: &KinematicState, speed: f64, [acceleration, deceleration]: [f64; 2]) {
        let (slope, bend) = (joint.velocity.abs(), joint.acceleration.abs());
        let [speed, acceleration, deceleration] =
            [speed, acceleration, deceleration].map(|limit| SAMPLED_LIMIT_SHARE * limit);
        self.speed = self.speed.min(speed / slope);
        let least = 0.5 * acceleration.min(deceleration);
        self.speed = self.speed.min((least / bend).sqrt());
        self.acceleration = self.acceleration.min(0.5 * acceleration / slope);
        self.deceleration = self.deceleration.min(0.5 * deceleration / slope);
    }
}

impl Present<'_> {
    /// Checks that every robot moved by a coordinate system can follow its path, and returns the limits along it. `rotation`: that of the system's
    /// orientation on the path; without one the orientation stays. `heading`: Rx, Ry, Rz at its start, degrees.
    ///
    /// # Errors
    /// 67, 68 or 72: the error with which the transform would fail along the path, and 72 also for a joint outside of its soft travel.
    pub(crate) fn verify_reach(
        &self,
        system: SystemId,
        path: &Path,
        rotation: Option<&Rotation>,
        heading: Vector,
    ) -> Result<PathLimits, MotionError> {
        let mut limits = PathLimits::UNLIMITED;
        let moved = MovedPath {
            path,
            rotation,
            heading,
        };
        for transform in self.robots_moved_by(system) {
            self.verify_moved_path(system, transform, &moved, &mut limits)?;
        }
        Ok(limits)
    }

    /// The transforms with a robot as target that a coordinate system moves.
    fn robots_moved_by(&self, system: SystemId) -> impl Iterator<Item = &Transform> {
        let (transforms, system) = (self.transforms, &self.systems[system]);
        transforms
            .iter()
            .map(|(_, transform)| transform)
            .filter(move |transform| {
                let moves = || transforms.moves_source(system, transform, transforms.most());
                transform.has_robot_target() && !transform.braking && moves()
            })
    }

    /// The highest speed at the corner between the last move in the queue and a path behind it: within an update, the velocity of a joint changes
    /// there by no more than its limits allow, as for the source's axes (spec/coordinated-instructions.md §7.5). `shift`: from the queue's
    /// positions to the present ones. Real-time: one sample per transform.
    pub(crate) fn corner_speed(&self, system: SystemId, path: &Path, shift: &Vector) -> f64 {
        let Some(last) = self.systems[system].travel.last() else {
            return f64::INFINITY;
        };
        let turn = path.start_tangent() - last.path.end_tangent();
        let at = path.start() + shift;
        let mut speed = f64::INFINITY;
        for transform in self.robots_moved_by(system) {
            let axes = self.systems[system].description.linear();
            let source = self.when(transform, &|axis| {
                let index = axes.iter().position(|own| *own == axis);
                index.map_or_else(KinematicState::default, |index| KinematicState {
                    position: at[index] - self.axes[axis].command.position,
                    velocity: turn[index],
                    acceleration: 0.0,
                })
            });
            // A move to a point that the joints cannot reach comes to rest before the corner.
            let Ok(joints) = transform.target_of(&source) else {
                return 0.0;
            };
            for (axis, joint) in transform.target.iter().zip(&joints) {
                let dynamics = &self.axes[*axis].dynamics;
                let step = dynamics.acceleration.min(dynamics.deceleration) * self.clock.period();
                speed = speed.min(step / joint.velocity.abs());
            }
        }
        speed
    }

    /// The motion of a transform's source when its axes, or the axes of transforms before it, are a step away from their present positions.
    fn when(&self, transform: &Transform, step: &impl Fn(AxisId) -> KinematicState) -> SideState {
        let mut whole = self.transforms.step_of(transform, step, self.transforms.most());
        for (axis, point) in transform.source.iter().zip(&mut whole) {
            point.position += self.axes[*axis].command.position;
        }
        whole
    }

    /// The motion of a transform's source at a share of the path, with derivatives by path length. `near` holds the angles of the previous
    /// sample and takes those of this one.
    fn source_on(
        &self,
        system: SystemId,
        transform: &Transform,
        moved: &MovedPath<'_>,
        share: f64,
        near: &mut Vector,
    ) -> SideState {
        let description = &self.systems[system].description;
        let length = moved.path.length();
        let at = moved.path.at(share * length);
        let linear = [at.position, at.tangent, at.curvature];
        let rotation_state = moved.rotation.map(|rotation| {
            let rotation_state = rotation.at(share).in_time(length.recip(), 0.0);
            *near = angles(&rotation_state.orientation, near);
            let [rate, change] = angle_rates(near, &rotation_state.rate, &rotation_state.change);
            [*near, rate, change]
        });
        self.when(transform, &|axis| {
            let among = |axes: &[AxisId]| axes.iter().position(|own| *own == axis);
            let moved = among(description.linear()).map(|index| (index, linear));
            let rotation_state = || among(description.oriented()).zip(rotation_state);
            moved
                .or_else(rotation_state)
                .map_or_else(KinematicState::default, |(index, of)| KinematicState {
                    position: of[0][index] - self.axes[axis].command.position,
                    velocity: of[1][index],
                    acceleration: of[2][index],
                })
        })
    }

    fn verify_moved_path(
        &self,
        system: SystemId,
        transform: &Transform,
        moved: &MovedPath<'_>,
        limits: &mut PathLimits,
    ) -> Result<(), MotionError> {
        let Map::Robot(robot) = &transform.map else {
            return Ok(());
        };
        let mut robot = *robot;
        let mut heading = moved.heading;
        let mut source = |share: f64| self.source_on(system, transform, moved, share, &mut heading);
        let length = moved.path.length();
        let (mut samples, mut extremes) = (SAMPLES, EXTREMES);
        let mut joints = robot.begin(&source(0.0))?;
        self.verify_joints(transform, &joints, limits)?;
        let mut here = 0.0;
        for step in 1..=STEPS {
            let goal = f64::from(step) / f64::from(STEPS);
            let mut next = goal;
            while here < goal {
                let there = robot.target_of(&source(next))?;
                samples -= 1;
                if samples > 0 && turns_far(&robot, &joints, &there, (next - here) * length) {
                    if next - here < ORIGIN_STEP_SHARE {
                        return Err(MotionError::TransformAtOrigin);
                    }
                    next = 0.5 * (here + next);
                    continue;
                }
                self.verify_joints(transform, &there, limits)?;
                for index in 0..transform.target.len() {
                    let span = JointsBetween {
                        index,
                        ends: [here, next],
                        joints: [&joints, &there],
                    };
                    if extremes > 0 && span.turns_round(length) {
                        extremes -= 1;
                        self.verify_extreme(transform, &robot, &span, &mut source, limits)?;
                    }
                }
                robot.follow_joints(&there);
                (here, joints, next) = (next, there, goal);
                if samples == 0 {
                    return Ok(());
                }
            }
        }
        Ok(())
    }

    /// Samples the point between two samples at which a joint reverses: it may be out of reach, however short that part of the path is.
    fn verify_extreme(
        &self,
        transform: &Transform,
        robot: &RobotMap,
        span: &JointsBetween<'_>,
        source: &mut impl FnMut(f64) -> SideState,
        limits: &mut PathLimits,
    ) -> Result<(), MotionError> {
        let [low, high] = span.ends;
        let rises = span.joints[0][span.index].velocity > 0.0;
        // Each sample is checked; the point itself is of no use.
        try_bisect(low, high, HALVES, |share| {
            let joints = robot.target_of(&source(share))?;
            self.verify_joints(transform, &joints, limits)?;
            Ok((joints[span.index].velocity > 0.0) != rises)
        })?;
        Ok(())
    }

    /// Checks that the joints are within their soft travel, and lowers the limits by their motion per unit of the path.
    fn verify_joints(
        &self,
        transform: &Transform,
        joints: &SideState,
        limits: &mut PathLimits,
    ) -> Result<(), MotionError> {
        for (index, (axis, joint)) in transform.target.iter().zip(joints).enumerate() {
            let axis = &self.axes[*axis];
            if axis.faults.forbids_position(joint.position) {
                return Err(MotionError::MaxJointAngleExceeded(AxisIndex(index as u8)));
            }
            let dynamics = &axis.dynamics;
            limits.slow(joint, dynamics.speed, [dynamics.acceleration, dynamics.deceleration]);
        }
        Ok(())
    }
}

/// The motion of a joint between two samples of a path, at shares of it.
struct JointsBetween<'a> {
    index: usize,
    ends: [f64; 2],
    joints: [&'a SideState; 2],
}

impl JointsBetween<'_> {
    /// The joint reverses its direction between the two samples.
    fn turns_round(&self, length: f64) -> bool {
        let [before, after] = self.joints.map(|joints| joints[self.index].velocity);
        let reached = (self.ends[1] - self.ends[0]) * length;
        before * after < 0.0 && before.abs().max(after.abs()) * reached > NO_MOTION_UNITS
    }
}

/// A rotary joint turns further than permitted for a step, or may do so between its ends. `length`: of the step, path units.
fn turns_far(robot: &RobotMap, before: &SideState, after: &SideState, length: f64) -> bool {
    let mut joints = before.iter().zip(after).enumerate();
    joints.any(|(index, (before, after))| {
        let gone = after.position - before.position;
        // The deviation of the cubic through both ends, in its middle, from the mean of the velocities.
        let bent = 1.5 * (gone - 0.5 * (before.velocity + after.velocity) * length);
        robot.turns(index) && (gone.abs() > JOINT_FAR_DEG || bent.abs() > JOINT_FAR_DEG)
    })
}

/// Steps of a path.
const STEPS: u16 = 32;
/// Samples of one path, including those of halved steps.
const SAMPLES: u16 = 400;
/// Reversals of joints that are searched for, and halvings of a step for one.
const EXTREMES: u16 = 24;
const HALVES: usize = 18;
