//! Whether a robot's joints could follow a stop that began at the next update (spec/coordinated-instructions.md §19.8).
//!
//! The way of the stop is looked at at a few instants, and between two of them wherever a joint may do there what it does
//! at neither: its way between them is taken for the cubic through both positions and velocities. A joint that is too fast only
//! briefly is found by how far it gets. Not here: what the stop is ([`super::ahead`]), what is done about it
//! ([`super::failing`]). Real-time: nothing allocates; the number of looks is fixed. Units: position units, degrees of joints,
//! seconds.

use arcline_instruction_set::{AxisIndex, Detail, MotionError};
use arcline_profile::KinematicState;

use super::ahead::Ahead;
use super::compute::bit;
use super::robot::{RobotMap, positions};
use super::transform::{Link, Map, Side};
use crate::axis::sum::Slot;
use crate::machine::MAX_SYSTEM_AXES;
use crate::motion::Motion;

/// The joints at an instant of a stop.
#[derive(Clone, Copy, Debug, Default)]
struct Look {
    /// Seconds after the next update.
    at: f64,
    /// Where the source leads them, in the robot's frame.
    led: Side,
    /// How far they are by themselves from where they are now.
    own: Side,
}

impl Look {
    fn joint(&self, place: usize) -> KinematicState {
        let (led, own) = (&self.led[place], &self.own[place]);
        KinematicState {
            position: led.position + own.position,
            velocity: led.velocity + own.velocity,
            acceleration: 0.0,
        }
    }
}

/// What two looks say of the way between them.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Between {
    Kept,
    /// It depends on what lies between.
    Unknown,
    Exceeded(MotionError),
}

/// What a joint must keep.
#[derive(Clone, Copy, Debug)]
struct Bounds {
    /// Units/s.
    speed: f64,
    /// From where to where it may be, in the frame of [`Look::joint`].
    room: [f64; 2],
    /// What is wrong beyond.
    beyond: MotionError,
}

/// A stop that is looked at.
struct Stop<'a> {
    motion: &'a Motion,
    link: &'a Link,
    ahead: &'a mut Ahead,
    /// Follows the joints from look to look.
    robot: RobotMap,
    now: Look,
    bounds: [Bounds; MAX_SYSTEM_AXES],
    /// What is still to be looked at, the last one first.
    goals: [Look; DEPTH],
    /// Looks between others that are left.
    left: u8,
}

impl Motion {
    /// Whether the joints could follow a stop that began at the next update, each within its speed and its travel.
    ///
    /// # Errors
    /// What they would fail with.
    pub(super) fn look_ahead(&self, index: usize, link: &Link, ahead: &mut Ahead) -> Result<(), MotionError> {
        let Map::Robot(robot) = &link.map else {
            return Ok(());
        };
        let own = |axis: &u16| self.axes[usize::from(*axis)].moves_itself();
        if !link.leads_joints() || !(link.leads || link.target().iter().any(own)) {
            return Ok(());
        }
        if self.is_led_by_others(index, link) {
            return self.look_straight_on(link, robot);
        }
        self.plan_ahead(link, ahead);
        let duration = ahead.duration();
        let now = self.joints_now(link);
        let mut stop = Stop {
            motion: self,
            link,
            ahead,
            robot: *robot,
            now,
            bounds: self.bounds(link, robot),
            goals: [Look::default(); DEPTH],
            left: CLOSER,
        };
        let mut before = now;
        for place in 0..=LOOKS {
            let share = f64::from(place) / f64::from(LOOKS);
            before = stop.go_to(before, duration * share)?;
            if duration <= 0.0 {
                break;
            }
        }
        Ok(())
    }

    /// The joints now, an update before the stop.
    fn joints_now(&self, link: &Link) -> Look {
        let mut look = Look {
            at: -self.clock.period(),
            led: link.down,
            own: Side::default(),
        };
        for (led, offset) in look.led.iter_mut().zip(link.offset) {
            led.position -= offset;
        }
        for (axis, own) in link.target().iter().zip(&mut look.own) {
            *own = self.axes[usize::from(*axis)]
                .sum
                .motion_of(|slot| slot != Slot::Transform);
        }
        look
    }

    /// Whether the source is led by something that is no motion of it, or of a source above it: another target of one of these.
    fn is_led_by_others(&self, index: usize, link: &Link) -> bool {
        let (mut chain, mut at) = (bit(index), Some(link));
        for _ in 0..self.links.len() {
            let Some(next) = at else { break };
            let led = |axis: &u16| {
                let others = self.axes[usize::from(*axis)].linked.led_back_by & !chain;
                others != 0
                    && self
                        .links()
                        .any(|(index, other)| others & bit(index) != 0 && other.leads_back)
            };
            if next.source().iter().any(led) {
                return true;
            }
            at = self.above_of(next);
            let above = at.and_then(|above| self.links().find(|(_, other)| std::ptr::eq(*other, above)));
            chain |= above.map_or(0, |(index, _)| bit(index));
        }
        false
    }

    /// The same for a source that others lead too: it is taken to go straight on and to stop at its axes' maxima.
    fn look_straight_on(&self, link: &Link, robot: &RobotMap) -> Result<(), MotionError> {
        let mut robot = *robot;
        let added = self.added_to(link);
        let mut joints = positions(&link.led);
        for (joint, (added, offset)) in joints.iter_mut().zip(added.iter().zip(link.offset)) {
            *joint += added.position - offset;
        }
        robot.stand(joints);
        let (mut source, mut seconds) = (Side::default(), self.clock.period());
        for (axis, point) in link.source().iter().zip(&mut source) {
            let state = &self.axes[usize::from(*axis)];
            *point = KinematicState {
                acceleration: 0.0,
                ..state.command
            };
            seconds = seconds.max(self.clock.period() + 0.5 * point.velocity.abs() / state.dynamics.deceleration);
        }
        for look in 0..=LOOKS {
            let share = f64::from(look) / f64::from(LOOKS);
            let mut there = source;
            for point in &mut there {
                point.position += point.velocity * seconds * share;
                point.velocity *= (1.0 - share).sqrt();
            }
            let led = robot.place(&there)?;
            robot.follow_joints(&led);
            for (place, (axis, joint)) in link.target().iter().zip(&led).enumerate() {
                if joint.velocity.abs() > self.axes[usize::from(*axis)].dynamics.speed * (1.0 + ROUNDING) {
                    return Err(MotionError::MaxJointVelocityExceeded(AxisIndex(place as u8)));
                }
            }
        }
        Ok(())
    }

    fn bounds(&self, link: &Link, robot: &RobotMap) -> [Bounds; MAX_SYSTEM_AXES] {
        let added = self.added_to(link);
        std::array::from_fn(|place| {
            let mut bounds = Bounds {
                speed: f64::INFINITY,
                room: [f64::NEG_INFINITY, f64::INFINITY],
                beyond: MotionError::MaxJointAngleExceeded(AxisIndex(place as u8)),
            };
            let Some(axis) = link.target().get(place) else {
                return bounds;
            };
            let axis = &self.axes[usize::from(*axis)];
            let now = link.down[place].position - link.offset[place];
            bounds.speed = axis.dynamics.speed;
            bounds.room = axis.faults.room(axis.command.position).map(|room| now + room);
            if let Some([least, most]) = robot.range(place) {
                let own = [least, most].map(|end| end - added[place].position);
                if !robot.has_mirror() && (own[0] > bounds.room[0] || own[1] < bounds.room[1]) {
                    bounds.beyond = MotionError::InvalidTransformPosition(Detail(place as i8));
                }
                // A joint that is beyond may come back.
                bounds.room = [bounds.room[0].max(own[0].min(now)), bounds.room[1].min(own[1].max(now))];
            }
            bounds
        })
    }
}

impl Stop<'_> {
    /// From one instant to a later one, as closely as need be.
    ///
    /// # Errors
    /// What the joints would fail with on the way.
    fn go_to(&mut self, mut before: Look, at: f64) -> Result<Look, MotionError> {
        let mut count = 1;
        self.goals[0] = self.look(at)?;
        while count > 0 {
            let mut next = self.goals[count - 1];
            if self.link.leads {
                next.led = self.robot.near(next.led);
            }
            match self.between(&before, &next) {
                Between::Exceeded(error) => return Err(error),
                // Before the next update nothing is planned.
                Between::Unknown
                    if self.left > 0 && count < DEPTH && before.at >= 0.0 && next.at - before.at > FINEST =>
                {
                    self.left -= 1;
                    self.goals[count] = self.look(0.5 * (before.at + next.at))?;
                    count += 1;
                    continue;
                }
                Between::Unknown => self.judge(&before, &next)?,
                Between::Kept => {}
            }
            if self.link.leads {
                self.robot.follow_joints(&next.led);
            }
            before = next;
            count -= 1;
        }
        Ok(before)
    }

    /// # Errors
    /// Where the joints cannot be.
    fn look(&mut self, at: f64) -> Result<Look, MotionError> {
        self.motion.look_at(self.ahead, at);
        let mut look = Look { at, ..self.now };
        if self.link.leads {
            let source = self.motion.source_ahead(self.link, self.ahead);
            look.led = self.robot.place(&source)?;
        }
        for (axis, own) in self.link.target().iter().zip(&mut look.own) {
            *own = self.ahead.step(*axis);
        }
        Ok(look)
    }

    fn between(&self, before: &Look, next: &Look) -> Between {
        let width = next.at - before.at;
        let mut verdict = Between::Kept;
        for place in 0..self.link.target().len() {
            let bounds = &self.bounds[place];
            let (from, to) = (before.joint(place), next.joint(place));
            if to.velocity.abs() > bounds.speed * (1.0 + ROUNDING) {
                return Between::Exceeded(MotionError::MaxJointVelocityExceeded(AxisIndex(place as u8)));
            }
            let [least, most] = bounds.room;
            if to.position < least - SMALL || to.position > most + SMALL {
                return Between::Exceeded(bounds.beyond);
            }
            if width <= 0.0 {
                continue;
            }
            let mean = (to.position - from.position) / width;
            let ends = 0.5 * (from.velocity + to.velocity);
            let middle = 1.5 * mean - 0.5 * ends;
            let fastest = middle.abs().max(mean.abs());
            let turns = from.velocity * to.velocity < 0.0;
            // How far it may get beyond both ends.
            let out = 0.25 * width * from.velocity.abs().max(to.velocity.abs());
            let near_an_end =
                from.position.min(to.position) - out < least || from.position.max(to.position) + out > most;
            if fastest > bounds.speed * (1.0 + NEAR)
                || (middle - ends).abs() > ODD * bounds.speed
                || (turns && near_an_end)
            {
                verdict = Between::Unknown;
            }
        }
        verdict
    }

    /// What could not be looked at more closely.
    fn judge(&self, before: &Look, next: &Look) -> Result<(), MotionError> {
        let width = next.at - before.at;
        let mut verdict = Ok(());
        for place in 0..self.link.target().len() {
            let way = (next.joint(place).position - before.joint(place).position).abs();
            if way > self.bounds[place].speed * width * (1.0 + NEAR) + SMALL {
                if way > AT_ONCE {
                    return Err(MotionError::TransformAtOrigin);
                }
                verdict = verdict.and(Err(MotionError::MaxJointVelocityExceeded(AxisIndex(place as u8))));
            }
        }
        verdict
    }
}

/// Whether a joint got further in an update than its speed lets it.
pub(super) fn too_far(before: &KinematicState, now: &KinematicState, speed: f64, period: f64) -> bool {
    now.velocity.abs() > speed * (1.0 + SLACK)
        || (now.position - before.position).abs() > speed * period * (1.0 + SLACK) + SMALL
}

/// The share by which a joint may be faster than its Maximum Speed before the source leads it no more: what lies between the looks
/// at a stop.
const SLACK: f64 = 0.02;
/// A joint that gets further, in degrees, between two looks that cannot be nearer turns at once.
pub(super) const AT_ONCE: f64 = 10.0;
/// Places on the way of a stop that are looked at.
const LOOKS: u8 = 4;
/// Looks between these, at most.
const CLOSER: u8 = 32;
/// Nested intervals.
const DEPTH: usize = 14;
/// Seconds between two looks, at least.
const FINEST: f64 = 2e-5;
/// Share of its Maximum Speed by which the speed of a joint in the middle of an interval may be off the mean of those at the
/// ends.
const ODD: f64 = 0.25;
/// A joint this little too fast, as a share, is as fast as it may be.
const ROUNDING: f64 = 1e-9;
/// The same of a way between two looks.
const NEAR: f64 = 1e-3;
/// Position units or degrees.
const SMALL: f64 = 1e-9;
