//! The check that a robot's joints could follow a stop that began at the next update (spec/coordinated-instructions.md §19.8).
//!
//! The guard samples the joints at a few instants of the stop, and additionally between two samples if a joint may exceed a limit there that
//! it keeps at both: between samples, the joint is assumed to follow the cubic through both positions and velocities. A joint that is too
//! fast only briefly is found by its displacement. Not here: the stop ([`super::ahead`]), and the reaction to a verdict (`crate::motion`).
//! Real-time: nothing allocates; the number of samples is fixed. Units: position units, degrees of joints, seconds.

use arcline_instruction_set::{AxisId, AxisIndex, Detail, MotionError};
use arcline_profile::KinematicState;

use super::TransformId;
use super::ahead::PlannedStops;
use super::present::Present;
use super::robot::RobotMap;
use super::sides::{SideState, positions};
use super::transform::{Map, Transform};
use crate::axis::generator_kind::GeneratorKind;
use crate::machine::MAX_SYSTEM_AXES;
use crate::tolerance::{
    JOINT_AT_ONCE_DEG, JOINT_DISTANCE_SHARE, JOINT_SPEED_SHARE, JOINT_UNITS, ODD_SPEED_SHARE, SAMPLE_ERROR_SHARE,
    SHORTEST_SAMPLE_INTERVAL_S,
};

/// The future of a transform.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Verdict {
    GoesOn,
    /// The transform continues; if all axes stand, the target's own displacement is included in the source's position.
    Settles,
    /// The robot will be unable to follow: every motion of either side must brake now.
    Brakes(MotionError),
    /// The robot can follow no longer.
    Fails(MotionError),
    /// The transform has failed, and both sides are at rest.
    Ends,
}

/// The joints at an instant of a stop.
#[derive(Clone, Copy, Debug, Default)]
struct JointSample {
    /// Seconds after the next update.
    at: f64,
    /// The motion of the joints by that of the source, in the robot's frame.
    by_source: SideState,
    /// The displacement of the joints from their present positions by their own motion.
    own: SideState,
}

impl JointSample {
    fn joint(&self, index: usize) -> KinematicState {
        let (by_source, own) = (&self.by_source[index], &self.own[index]);
        KinematicState {
            position: by_source.position + own.position,
            velocity: by_source.velocity + own.velocity,
            acceleration: 0.0,
        }
    }
}

/// The verdict of two samples on the interval between them.
#[derive(Clone, Copy, Debug, PartialEq)]
enum IntervalVerdict {
    WithinLimits,
    /// Only a sample between them can decide.
    Unknown,
    Exceeded(MotionError),
}

/// The limits of a joint.
#[derive(Clone, Copy, Debug)]
struct JointLimits {
    /// Units/s.
    speed: f64,
    /// Its permitted positions, in the frame of [`JointSample::joint`].
    room: [f64; 2],
    /// The error of a position outside of them.
    beyond: MotionError,
}

/// A planned stop under examination.
struct StopAhead<'a> {
    present: Present<'a>,
    transform: &'a Transform,
    ahead: &'a mut PlannedStops,
    /// Follows the joints from sample to sample.
    robot: RobotMap,
    now: JointSample,
    bounds: [JointLimits; MAX_SYSTEM_AXES],
    /// Samples whose intervals are to be judged, the last one first.
    goals: [JointSample; DEPTH],
    /// Remaining samples between others.
    left: u8,
}

impl Present<'_> {
    /// The verdict on a transform, once the commands of this update are known.
    pub(crate) fn verdict(&self, id: TransformId, ahead: &mut PlannedStops) -> Verdict {
        let robot = |transform: &&Transform| transform.robot().is_some();
        let Some(transform) = self.transforms.get(id).filter(robot) else {
            return Verdict::GoesOn;
        };
        if let Some(error) = transform.failed {
            return Verdict::Fails(error);
        }
        if transform.braking && !self.transforms.moves_either_side(self.axes, transform) {
            return Verdict::Ends;
        }
        match self.look_ahead(id, transform, ahead) {
            // Motion that has begun since the transform started to brake must brake too.
            Err(error) => Verdict::Brakes(error),
            Ok(()) if transform.braking => Verdict::GoesOn,
            Ok(()) => Verdict::Settles,
        }
    }

    /// Checks that the joints could follow a stop that began at the next update, each within its speed and its travel.
    ///
    /// # Errors
    /// The error of the first limit that a joint would exceed.
    fn look_ahead(&self, id: TransformId, transform: &Transform, ahead: &mut PlannedStops) -> Result<(), MotionError> {
        let Map::Robot(robot) = &transform.map else {
            return Ok(());
        };
        let own = |axis: &AxisId| self.axes[*axis].moves_itself();
        if !transform.has_robot_target() || !(transform.source_moves || transform.target.iter().any(own)) {
            return Ok(());
        }
        if self.source_moves_by_feedback(id, transform) {
            return self.check_next_update(transform, robot);
        }
        self.plan_ahead(transform, ahead);
        let duration = ahead.duration();
        let now = self.joints_now(transform);
        let mut stop = StopAhead {
            present: *self,
            transform,
            ahead,
            robot: *robot,
            now,
            bounds: self.bounds(transform, robot),
            goals: [JointSample::default(); DEPTH],
            left: CLOSER,
        };
        let mut before = now;
        for index in 0..=SAMPLES {
            let share = f64::from(index) / f64::from(SAMPLES);
            before = stop.go_to(before, duration * share)?;
            if duration <= 0.0 {
                break;
            }
        }
        Ok(())
    }

    /// The joints at the present tick, one update before the stop.
    fn joints_now(&self, transform: &Transform) -> JointSample {
        let mut sample = JointSample {
            at: -self.clock.period(),
            by_source: transform.target_before,
            own: SideState::default(),
        };
        for (joint, offset) in sample.by_source.iter_mut().zip(transform.offset) {
            joint.position -= offset;
        }
        for (axis, own) in transform.target.iter().zip(&mut sample.own) {
            *own = self.axes[*axis].sum.motion_of(|kind| kind != GeneratorKind::Transform);
        }
        sample
    }

    /// The feedback of other transforms moves the source, or the source of a preceding transform.
    fn source_moves_by_feedback(&self, id: TransformId, transform: &Transform) -> bool {
        let (mut chain, mut at) = (id.bit(), Some(transform));
        for _ in 0..self.transforms.most() {
            let Some(next) = at else { break };
            let moved_by_feedback = |axis: &AxisId| {
                let others = self.axes[*axis].transforms.source_of & !chain;
                let mut all = self.transforms.iter();
                others != 0 && all.any(|(id, other)| others & id.bit() != 0 && other.target_moves)
            };
            if next.source.iter().any(moved_by_feedback) {
                return true;
            }
            let preceding = self.transforms.preceding(next);
            chain |= preceding.map_or(0, |(id, _)| id.bit());
            at = preceding.map(|(_, preceding)| preceding);
        }
        false
    }

    /// Checks a source that the feedback of other transforms moves: it is assumed to continue straight and to stop at its axes' maxima.
    fn check_next_update(&self, transform: &Transform, robot: &RobotMap) -> Result<(), MotionError> {
        let mut robot = *robot;
        let added = self.transforms.added_to(self.axes, transform);
        let mut joints = positions(&transform.target_set_points);
        for (joint, (added, offset)) in joints.iter_mut().zip(added.iter().zip(transform.offset)) {
            *joint += added.position - offset;
        }
        robot.note_joints(joints);
        let (mut source, mut seconds) = (SideState::default(), self.clock.period());
        for (axis, point) in transform.source.iter().zip(&mut source) {
            let state = &self.axes[*axis];
            *point = KinematicState {
                acceleration: 0.0,
                ..state.command
            };
            seconds = seconds.max(self.clock.period() + 0.5 * point.velocity.abs() / state.dynamics.deceleration);
        }
        for sample in 0..=SAMPLES {
            let share = f64::from(sample) / f64::from(SAMPLES);
            let mut there = source;
            for point in &mut there {
                point.position += point.velocity * seconds * share;
                point.velocity *= (1.0 - share).sqrt();
            }
            let joints = robot.target_of(&there)?;
            robot.follow_joints(&joints);
            for (index, (axis, joint)) in transform.target.iter().zip(&joints).enumerate() {
                if joint.velocity.abs() > self.axes[*axis].dynamics.speed * (1.0 + JOINT_SPEED_SHARE) {
                    return Err(MotionError::MaxJointVelocityExceeded(AxisIndex(index as u8)));
                }
            }
        }
        Ok(())
    }

    fn bounds(&self, transform: &Transform, robot: &RobotMap) -> [JointLimits; MAX_SYSTEM_AXES] {
        let added = self.transforms.added_to(self.axes, transform);
        std::array::from_fn(|index| {
            let mut bounds = JointLimits {
                speed: f64::INFINITY,
                room: [f64::NEG_INFINITY, f64::INFINITY],
                beyond: MotionError::MaxJointAngleExceeded(AxisIndex(index as u8)),
            };
            let Some(axis) = transform.target.get(index) else {
                return bounds;
            };
            let axis = &self.axes[*axis];
            let now = transform.target_before[index].position - transform.offset[index];
            bounds.speed = axis.dynamics.speed;
            bounds.room = axis.faults.room(axis.command.position).map(|room| now + room);
            if let Some([least, most]) = robot.range(index) {
                let own = [least, most].map(|end| end - added[index].position);
                if !robot.has_mirror() && (own[0] > bounds.room[0] || own[1] < bounds.room[1]) {
                    bounds.beyond = MotionError::InvalidTransformPosition(Detail(index as i8));
                }
                // A joint outside of its range may return.
                bounds.room = [bounds.room[0].max(own[0].min(now)), bounds.room[1].min(own[1].max(now))];
            }
            bounds
        })
    }
}

impl StopAhead<'_> {
    /// Examines the stop from one instant to a later one, with as many samples as necessary.
    ///
    /// # Errors
    /// The error of the first limit that a joint would exceed until then.
    fn go_to(&mut self, mut before: JointSample, at: f64) -> Result<JointSample, MotionError> {
        let mut count = 1;
        self.goals[0] = self.sample(at)?;
        while count > 0 {
            let mut next = self.goals[count - 1];
            if self.transform.source_moves {
                next.by_source = self.robot.near(next.by_source);
            }
            match self.between(&before, &next) {
                IntervalVerdict::Exceeded(error) => return Err(error),
                // The interval before the next update has no plan of the stop.
                IntervalVerdict::Unknown
                    if self.left > 0
                        && count < DEPTH
                        && before.at >= 0.0
                        && next.at - before.at > SHORTEST_SAMPLE_INTERVAL_S =>
                {
                    self.left -= 1;
                    self.goals[count] = self.sample(0.5 * (before.at + next.at))?;
                    count += 1;
                    continue;
                }
                IntervalVerdict::Unknown => self.judge(&before, &next)?,
                IntervalVerdict::WithinLimits => {}
            }
            if self.transform.source_moves {
                self.robot.follow_joints(&next.by_source);
            }
            before = next;
            count -= 1;
        }
        Ok(before)
    }

    /// # Errors
    /// The error of a position that the joints cannot take.
    fn sample(&mut self, at: f64) -> Result<JointSample, MotionError> {
        self.present.sample_stop(self.ahead, at);
        let mut sample = JointSample { at, ..self.now };
        if self.transform.source_moves {
            let source = self.present.source_ahead(self.transform, self.ahead);
            sample.by_source = self.robot.target_of(&source)?;
        }
        for (axis, own) in self.transform.target.iter().zip(&mut sample.own) {
            *own = self.ahead.step(*axis);
        }
        Ok(sample)
    }

    fn between(&self, before: &JointSample, next: &JointSample) -> IntervalVerdict {
        let width = next.at - before.at;
        let mut verdict = IntervalVerdict::WithinLimits;
        for index in 0..self.transform.target.len() {
            let bounds = &self.bounds[index];
            let (from, to) = (before.joint(index), next.joint(index));
            if to.velocity.abs() > bounds.speed * (1.0 + JOINT_SPEED_SHARE) {
                return IntervalVerdict::Exceeded(MotionError::MaxJointVelocityExceeded(AxisIndex(index as u8)));
            }
            let [least, most] = bounds.room;
            if to.position < least - JOINT_UNITS || to.position > most + JOINT_UNITS {
                return IntervalVerdict::Exceeded(bounds.beyond);
            }
            if width <= 0.0 {
                continue;
            }
            let mean = (to.position - from.position) / width;
            let ends = 0.5 * (from.velocity + to.velocity);
            let middle = 1.5 * mean - 0.5 * ends;
            let fastest = middle.abs().max(mean.abs());
            let turns = from.velocity * to.velocity < 0.0;
            // The bound of its excess beyond the positions at both ends.
            let out = 0.25 * width * from.velocity.abs().max(to.velocity.abs());
            let near_an_end =
                from.position.min(to.position) - out < least || from.position.max(to.position) + out > most;
            if fastest > bounds.speed * (1.0 + JOINT_DISTANCE_SHARE)
                || (middle - ends).abs() > ODD_SPEED_SHARE * bounds.speed
                || (turns && near_an_end)
            {
                verdict = IntervalVerdict::Unknown;
            }
        }
        verdict
    }

    /// Judges an interval by its ends, if it is too short for another sample.
    fn judge(&self, before: &JointSample, next: &JointSample) -> Result<(), MotionError> {
        let width = next.at - before.at;
        let mut verdict = Ok(());
        for index in 0..self.transform.target.len() {
            let distance = (next.joint(index).position - before.joint(index).position).abs();
            if distance > self.bounds[index].speed * width * (1.0 + JOINT_DISTANCE_SHARE) + JOINT_UNITS {
                if distance > JOINT_AT_ONCE_DEG {
                    return Err(MotionError::TransformAtOrigin);
                }
                verdict = verdict.and(Err(MotionError::MaxJointVelocityExceeded(AxisIndex(index as u8))));
            }
        }
        verdict
    }
}

/// A joint is faster, or was displaced further in an update, than its maximum speed permits.
pub(super) fn too_far(before: &KinematicState, now: &KinematicState, speed: f64, period: f64) -> bool {
    now.velocity.abs() > speed * (1.0 + SAMPLE_ERROR_SHARE)
        || (now.position - before.position).abs() > speed * period * (1.0 + SAMPLE_ERROR_SHARE) + JOINT_UNITS
}

/// Samples of a stop, evenly spaced in time.
const SAMPLES: u8 = 4;
/// Most additional samples between these.
const CLOSER: u8 = 32;
/// Nested intervals.
const DEPTH: usize = 14;
