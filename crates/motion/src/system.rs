//! One coordinate system: its moves and their motion, its stop, and the status in its tags.

mod advance;
mod commands;
pub(crate) mod heading;
mod links;
mod shown;
mod stopping;
mod take_over;

use std::ops::{Deref, DerefMut, Index, IndexMut};
use std::sync::Arc;

use arcline_contour::{AxisLimits, Trajectory};
use arcline_instruction_set::{AxisId, AxisIndex, SystemId};
use arcline_kinematics::{GeometryError, OrientedRobot, Robot};
use arcline_planner::geometry::Point;
use arcline_planner::profile::{Limits, Phase};
use arcline_planner::{Clock, ContourQueue, Instant, MasterMotion, Move, Planner, QueueFull, TimeBase, Travel};

use crate::axes::Axes;
use crate::dynamics::PathLimits;
use crate::dynamics::{Dynamics, Maxima, stop_limits};
use crate::events::Events;
use crate::execution::Execution;
use crate::machine::{CoordinateSystem, KinematicStructure, MAX_SYSTEM_AXES, three};
use crate::masters::follower::{DrivenBy, MasterFollower};
use crate::masters::links::MasterLinks;
use crate::stop::{AxisSet, Stop};
pub(crate) use shown::Shown;

/// The condition for the completion of a move (spec/coordinated-instructions.md §7.1).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Termination {
    /// Type 0: the command is at the target and the axes are within the Actual Tolerance at the execution of the move, position units.
    ActualTolerance(f64),
    /// Any other type: the command is at the target, or a successor has taken over according to the ending.
    Command,
}

/// The data of a move in the queue of a coordinate system.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Planned {
    pub(crate) execution: Execution,
    pub(crate) dynamics: Dynamics,
    pub(crate) termination: Termination,
    /// The limits that the joints of robots put on the motion along the path, if they are enforced.
    pub(crate) path_limits: PathLimits,
    /// The link and lock of a master driven move.
    pub(crate) driven_by: Option<DrivenBy>,
    pub(crate) events: Option<Events>,
    /// Rx, Ry, Rz at its end, degrees, if it rotates.
    pub(crate) heading: Option<Point>,
    /// The move only rotates: its path length is an angle, in degrees.
    pub(crate) only_turns: bool,
}

/// The coordinated motion of a system.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Activity {
    /// No motion is interpolated.
    Idle,
    /// The active instruction moves the axes.
    Moving,
    /// A stop brakes along the path; the instruction has ended.
    Stopping,
}

/// Every coordinate system of a machine at the present tick.
#[derive(Debug)]
pub(crate) struct Systems {
    systems: Vec<System>,
    /// Trajectories that are no longer needed, to be freed outside the tick.
    pub(crate) retired: Vec<Arc<Trajectory>>,
}

impl Systems {
    /// All coordinate systems, in the order of the configuration.
    pub(crate) fn ids(&self) -> impl Iterator<Item = SystemId> + use<> {
        SystemId::first(self.systems.len())
    }

    pub(crate) fn get(&self, system: SystemId) -> Option<&System> {
        self.systems.get(system.index())
    }

    /// Ends all trajectories of a system; they are freed outside the tick.
    fn retire_all(&mut self, system: SystemId) {
        let trajectories = self.systems[system.index()].travel.clear();
        self.retired.extend(trajectories);
    }

    pub(crate) fn get_mut(&mut self, system: SystemId) -> Option<&mut System> {
        self.systems.get_mut(system.index())
    }
}

impl FromIterator<System> for Systems {
    fn from_iter<I: IntoIterator<Item = System>>(systems: I) -> Self {
        let systems: Vec<System> = systems.into_iter().collect();
        Systems {
            retired: Vec::with_capacity(2 * systems.len()),
            systems,
        }
    }
}

impl Deref for Systems {
    type Target = [System];

    fn deref(&self) -> &[System] {
        &self.systems
    }
}

impl DerefMut for Systems {
    fn deref_mut(&mut self) -> &mut [System] {
        &mut self.systems
    }
}

impl Index<SystemId> for Systems {
    type Output = System;

    fn index(&self, system: SystemId) -> &System {
        &self.systems[system.index()]
    }
}

impl IndexMut<SystemId> for Systems {
    fn index_mut(&mut self, system: SystemId) -> &mut System {
        &mut self.systems[system.index()]
    }
}

/// A coordinate system at the present tick.
#[derive(Debug)]
pub(crate) struct System {
    pub(crate) description: CoordinateSystem,
    /// The robot whose joints are its axes.
    pub(crate) robot: Option<Result<Robot, GeometryError>>,
    /// The robot with a wrist whose joints are its axes.
    pub(crate) wrist: Option<Result<OrientedRobot, GeometryError>>,
    /// The moves and their motion.
    pub(crate) travel: Travel<Planned>,
    /// The axes' own limits that contours keep.
    pub(crate) axis_limits: AxisLimits,
    pub(crate) activity: Activity,
    pub(crate) stop: Option<Stop>,
    /// Axes that brake separately after the end of a coordinated move.
    pub(crate) braking: AxisSet,
    pub(crate) shutdown: bool,
    /// Links to masters (MDCC).
    pub(crate) links: MasterLinks,
    /// The MDCC whose motion brakes.
    pub(crate) stopping_link: Option<Execution>,
    /// The master displacement that the active move is a function of; `None`: time.
    pub(crate) follower: Option<MasterFollower>,
    /// The instant at which a master driven move with Actual Tolerance reached its programmed end.
    pub(crate) ended: Option<Instant>,
    /// The instant since which the commands stand at the end of a move that waits for its axes; the next exchange shows whether they have
    /// settled.
    pub(crate) settling: Option<Instant>,
    /// The instant at which the axes came within the Actual Tolerance of that end.
    pub(crate) settled: Option<Instant>,
    /// The plan to which Calculated Data belong, and the tick from which on they are calculated again.
    pub(crate) calculated: (u32, u64),
    pub(crate) shown: Shown,
    /// A move has begun or changed since the commands of this tick were computed.
    pub(crate) stale: bool,
}

impl System {
    /// The position of a robot's tool in the frame of its base for given joint positions; `centre`: the tool centre in the frame of the end of an
    /// arm with a wrist. NaN if the joints are in no possible position. Real-time.
    pub(crate) fn tool(&self, joints: &[f64; MAX_SYSTEM_AXES], centre: &Point) -> Option<[f64; 3]> {
        self.description.robot?;
        let arm = || self.robot.as_ref()?.as_ref().ok()?.forward(three(joints)).ok();
        let wrist = || {
            let taken = self.wrist.as_ref()?.as_ref().ok()?.forward(joints).ok()?;
            Some((taken.pose.position + taken.pose.rotation * centre).into())
        };
        Some(arm().or_else(wrist).unwrap_or([f64::NAN; 3]))
    }

    /// `corner_step`: the largest velocity step of each axis at a corner, which takes one update of this period, units/s and seconds
    /// (spec/coordinated-instructions.md §7.5).
    pub(crate) fn new(
        description: &CoordinateSystem,
        corner_step: Point,
        period: f64,
        axis_limits: AxisLimits,
    ) -> Self {
        let mut planner = Planner::new(description.queue_depth, corner_step).with_period(period);
        planner.set_dynamics_bits(description.dynamics_bits);
        let travel = if description.plans_contours() {
            let queue = ContourQueue::new(description.queue_depth).deviating(description.deviation);
            Travel::contours(planner, queue)
        } else {
            Travel::superposed(planner)
        };
        System {
            travel,
            axis_limits,
            robot: description.robot.and_then(|robot| match robot.structure {
                KinematicStructure::Arm(geometry) => Some(Robot::new(geometry, &robot.parameters)),
                KinematicStructure::Wrist(_) => None,
            }),
            wrist: description.robot.and_then(|robot| match robot.structure {
                KinematicStructure::Arm(_) => None,
                KinematicStructure::Wrist(wrist) => Some(OrientedRobot::new(wrist, &robot.parameters)),
            }),
            description: description.clone(),
            activity: Activity::Idle,
            stop: None,
            braking: AxisSet::default(),
            shutdown: false,
            links: MasterLinks::default(),
            stopping_link: None,
            follower: None,
            ended: None,
            settling: None,
            settled: None,
            calculated: (0, 0),
            shown: Shown::default(),
            stale: false,
        }
    }

    /// The axes that its coordinated moves may use: those that they move, and Rx, Ry, Rz, which only some of them rotate.
    pub(crate) fn taken(&self) -> &[AxisId] {
        match self.description.orientation {
            Some(_) => &self.description.axes,
            None => self.description.linear(),
        }
    }

    /// The variable of the active move at the present tick: time, or the displacement of a master.
    pub(crate) fn time_base(&self, time: &Clock) -> TimeBase {
        TimeBase {
            time: *time,
            master: self.follower.as_ref().map(|follower| MasterMotion {
                displacement: follower.displacement(),
                rate: follower.rate(),
            }),
        }
    }

    /// It has masters, active or not, and is therefore computed after them.
    pub(crate) fn follows(&self) -> bool {
        self.follower.is_some() || !self.links.is_empty()
    }

    /// Seconds until the end of the active move, or until its successor becomes active, as planned now. `None` if the time is unknown:
    /// no move is active, it is held or stopped, or it is master driven.
    pub(crate) fn time_left(&self, time: &Clock) -> Option<f64> {
        if self.activity != Activity::Moving || self.follower.is_some() {
            return None;
        }
        self.travel.time_left(time)
    }

    /// A move or a stop is active that ends on its own; one that waits for a master does not.
    pub(crate) fn will_end(&self, time: &Clock) -> bool {
        let at_end = || self.travel.event(&self.time_base(time)).is_some();
        self.is_busy() && self.follower.is_none_or(|follower| follower.will_go_on() || at_end())
    }

    /// The master driven active move has reached its programmed speed. `planned`: its speed per master unit.
    pub(crate) fn is_tracking(&self, planned: f64) -> bool {
        self.follower.is_some_and(|follower| follower.has_begun())
            && self.activity == Activity::Moving
            && self.shown.phase == Phase::Steady
            && planned > 0.0
            && !self.shown.in_transition
    }

    /// Axes brake separately after the end of a coordinated move that used them.
    pub(crate) fn brakes(&self, axes: &Axes) -> bool {
        !self.braking.is_empty()
            && self.taken().iter().any(|index| {
                let axis = axes.get(*index).filter(|_| self.braking.contains(*index));
                axis.is_some_and(|axis| axis.has_coordinated_motion() && !axis.is_coordinated())
            })
    }

    /// Adds a move at the end of the queue.
    ///
    /// # Errors
    /// [`QueueFull`] if the queue has no room.
    pub(crate) fn push(&mut self, motion: Move<Planned>, time: &Clock) -> Result<(), QueueFull> {
        let base = self.time_base(time);
        self.travel.push(motion, &base)?;
        if self.activity == Activity::Idle {
            self.activity = Activity::Moving;
            self.shown = self.shown.of_next_move();
        }
        Ok(())
    }

    /// Changes the active move, from the present tick on.
    pub(crate) fn change_active(&mut self, dynamics: Dynamics, time: &Clock) {
        let base = self.time_base(time);
        if let Some(active) = self.travel.active_data() {
            active.dynamics = dynamics;
        }
        self.travel.change_limits(dynamics.limits(), &base);
        self.stale = true;
    }

    /// The active instruction, while it moves the axes.
    pub(crate) fn active(&self) -> Option<&Planned> {
        self.travel.active().map(|motion| &motion.data)
    }

    /// The active motion, or the stop of it, is an S-curve: stops have a jerk limit then.
    pub(crate) fn is_s_curve(&self) -> bool {
        self.travel.is_s_curve()
    }

    /// The stop on the path at the maxima of the coordinate system.
    pub(crate) fn path_stop(&self) -> Limits {
        Maxima::from(&self.description).stop(self.is_s_curve())
    }

    /// The stop on the path that keeps a robot within its reach: with no less jerk than programmed.
    pub(crate) fn guarded_stop(&self) -> Limits {
        let maxima = Maxima::from(&self.description);
        let jerk = self.travel.highest_jerk();
        stop_limits(
            maxima.speed,
            maxima.deceleration,
            jerk.map(|own| own.max(maxima.deceleration_jerk)),
        )
    }

    /// Nothing but the active move can change the system in the next tick: no stop, link or change is under way. Valid at the end of a tick.
    pub(crate) fn expects_nothing(&self) -> bool {
        let is_plain = match self.activity {
            Activity::Idle => self.travel.moves().next().is_none(),
            Activity::Moving => self.calculated.0 == self.travel.plans(),
            Activity::Stopping => false,
        };
        is_plain
            && self.stop.is_none()
            && self.braking.is_empty()
            && !self.follows()
            && self.stopping_link.is_none()
            && self.settling.is_none()
            && !self.stale
    }

    /// A coordinated move of this system is active, pending, or braking on its path.
    pub(crate) fn is_busy(&self) -> bool {
        self.activity != Activity::Idle
    }

    /// The number of further moves that it accepts: at least one while it is idle.
    pub(crate) fn room(&self) -> usize {
        self.travel.room().max(usize::from(!self.is_busy()))
    }

    /// Its axes rotate a tool besides moving it: MCTO can link it, MCT cannot.
    pub(crate) fn is_oriented(&self) -> bool {
        self.description.orientation.is_some() || self.wrist.is_some()
    }

    /// A coordinated move that a master drives uses the axis.
    pub(crate) fn is_driven_by_master(&self, axis: AxisId) -> bool {
        self.follower.is_some() && self.has(axis)
    }

    pub(crate) fn has(&self, axis: AxisId) -> bool {
        self.description.axes.contains(&axis)
    }

    /// The index in this system of an axis that another system has, too.
    pub(crate) fn shared_axis(&self, other: &System) -> Option<AxisIndex> {
        let mut axes = numbered(&self.description.axes);
        axes.find(|(_, axis)| other.has(*axis)).map(|(index, _)| index)
    }
}

impl Termination {
    /// The tolerance that the axes must be within; until then the command stays at the end.
    pub(crate) fn tolerance(self) -> Option<f64> {
        match self {
            Termination::ActualTolerance(tolerance) => Some(tolerance),
            Termination::Command => None,
        }
    }
}

/// Axes of a coordinate system with their indices.
pub(crate) fn numbered(axes: &[AxisId]) -> impl Iterator<Item = (AxisIndex, AxisId)> + Clone {
    (0..).map(AxisIndex).zip(axes.iter().copied())
}

/// The component of a point that belongs to an axis of the coordinate system.
pub(crate) fn component(point: &Point, axis: AxisIndex) -> f64 {
    point.get(usize::from(axis.0)).copied().unwrap_or(0.0)
}
