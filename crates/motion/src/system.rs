//! One coordinate system: its planner, its stop, and what its status bits remember.

use arcline_kinematics::{GeometryError, OrientedRobot, Robot};
use arcline_planner::geometry::Point;
use arcline_planner::precise::AxisLimits;
use arcline_planner::profile::Phase;
use arcline_planner::{Clock, ContourQueue, Instant, Move, Planner, Sample};

use crate::axis::Axis;
use crate::control::Execution;
use crate::dynamics::Dynamics;
use crate::dynamics::PathLimits;
use crate::events::Events;
use crate::machine::{AxisLimits as Limits, Build, CoordinateSystem, Corner, MAX_SYSTEM_AXES, three};
use crate::masters::follower::{LockTo, MasterFollower};
use crate::masters::links::MasterLinks;
use crate::stop::{AxisSet, Stop};

/// When a move is complete (spec/coordinated-instructions.md §7.1).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Termination {
    /// Type 0: the command is at the target and the axes are within the Actual Tolerance.
    ActualTolerance,
    /// Any other type: the command is at the target, or a successor has taken over as its ending tells.
    Command,
}

/// What motion keeps with a move in the planner.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Planned {
    pub(crate) execution: Execution,
    pub(crate) dynamics: Dynamics,
    pub(crate) termination: Termination,
    /// How fast it may be for the sake of robots' joints, where that is kept.
    pub(crate) pace: PathLimits,
    /// How it is master driven.
    pub(crate) lead: Option<Lead>,
    pub(crate) events: Option<Events>,
    /// Rx, Ry, Rz at its end, degrees, where it turns.
    pub(crate) heading: Option<Point>,
    /// It only turns: its way is an angle, in degrees.
    pub(crate) only_turns: bool,
}

/// The link by which a move is master driven, and its lock.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Lead {
    pub(crate) link: u32,
    pub(crate) lock: LockTo,
}

/// Whose motion the planner's active move is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Activity {
    /// Nothing is interpolated.
    Idle,
    /// The instruction that is active.
    Moving,
    /// A stop along the path; the instruction has ended.
    Stopping,
}

/// A coordinate system at the present tick.
#[derive(Debug)]
pub(crate) struct System {
    pub(crate) description: CoordinateSystem,
    /// Whose joints its axes are.
    pub(crate) robot: Option<Result<Robot, GeometryError>>,
    /// The same of a robot with a wrist.
    pub(crate) wrist: Option<Result<OrientedRobot, GeometryError>>,
    pub(crate) planner: Planner<Planned>,
    /// In place of the planner where moves are travelled as planned contours, but for one that was merged: the planner
    /// travels that, and the moves here wait behind it.
    pub(crate) contour: Option<ContourQueue<Planned>>,
    /// What contours keep of the axes' own limits.
    pub(crate) axis_limits: AxisLimits,
    pub(crate) activity: Activity,
    pub(crate) stop: Option<Stop>,
    /// Axes that brake by themselves since a coordinated move that took them was ended.
    pub(crate) braking: AxisSet,
    /// The moves that are under way have begun to move the axes.
    pub(crate) has_moved: bool,
    pub(crate) shutdown: bool,
    /// Links to masters (MDCC).
    pub(crate) links: MasterLinks,
    /// The MDCC whose motion is being stopped.
    pub(crate) stopping_link: Option<Execution>,
    /// What the active move is a function of, where that is not time.
    pub(crate) guide: Option<MasterFollower>,
    /// When a master driven move with Actual Tolerance came to its programmed end.
    pub(crate) ended: Option<Instant>,
    /// The plan that Calculated Data is of, and the tick from which on it is computed again.
    pub(crate) calculated: (u32, u64),
    /// What the speed along the path does, masters included.
    pub(crate) course: Phase,
    /// TrackingMaster of the active instruction, as last written.
    pub(crate) shown_tracking: bool,
    /// ACCEL and DECEL of the active instruction, as last written.
    pub(crate) shown_phase: Phase,
    pub(crate) in_actual_tolerance: bool,
    pub(crate) in_command_tolerance: bool,
    /// The active move blends with the end of the one before it, off the programmed path.
    pub(crate) in_transition: bool,
    /// Speed along the path, units/s; distance gone and length of the active path, units.
    pub(crate) along: [f64; 3],
    /// Share of the programmed speeds of all coordinated moves; 0 holds.
    pub(crate) feed_override: f64,
    /// Something happened since the commands of this tick were computed.
    pub(crate) stale: bool,
}

impl System {
    /// Where the tool of a robot is in the frame of its base while its joints are there; `centre`: of the tool, in the frame of the
    /// end of an arm with a wrist. NaN where the joints cannot be. Real-time.
    pub(crate) fn tool(&self, joints: &[f64; MAX_SYSTEM_AXES], centre: &Point) -> Option<[f64; 3]> {
        self.description.robot?;
        let arm = || self.robot.as_ref()?.as_ref().ok()?.forward(three(joints)).ok();
        let wrist = || {
            let taken = self.wrist.as_ref()?.as_ref().ok()?.forward(joints).ok()?;
            Some((taken.pose.position + taken.pose.rotation * centre).into())
        };
        Some(arm().or_else(wrist).unwrap_or([f64::NAN; 3]))
    }

    /// `corner_step`: the change of velocity of each axis that a corner may make at once, in one update of this period, units/s and
    /// seconds (spec/coordinated-instructions.md §7.5).
    pub(crate) fn new(
        description: &CoordinateSystem,
        corner_step: Point,
        period: f64,
        axis_limits: AxisLimits,
    ) -> Self {
        let contours = description.corner == Corner::Precise || description.axis_limits == Limits::Enforce;
        let mut planner = Planner::new(description.queue_depth, corner_step).with_period(period);
        planner.set_bounds(description.dynamics_bits);
        System {
            contour: contours.then(|| ContourQueue::new(description.queue_depth).deviating(description.deviation)),
            axis_limits,
            robot: description.robot.and_then(|robot| match robot.build {
                Build::Arm(geometry) => Some(Robot::new(geometry, &robot.parameters)),
                Build::Wrist(_) => None,
            }),
            wrist: description.robot.and_then(|robot| match robot.build {
                Build::Arm(_) => None,
                Build::Wrist(wrist) => Some(OrientedRobot::new(wrist, &robot.parameters)),
            }),
            planner,
            description: description.clone(),
            activity: Activity::Idle,
            stop: None,
            braking: AxisSet::default(),
            has_moved: false,
            shutdown: false,
            links: MasterLinks::default(),
            stopping_link: None,
            guide: None,
            ended: None,
            calculated: (0, 0),
            course: Phase::Steady,
            shown_tracking: false,
            shown_phase: Phase::Steady,
            in_actual_tolerance: false,
            in_command_tolerance: false,
            in_transition: false,
            along: [0.0; 3],
            feed_override: 1.0,
            stale: false,
        }
    }

    /// The axes that its coordinated moves may have taken: those that they move, and Rx, Ry, Rz, which some of them turn.
    pub(crate) fn taken(&self) -> &[u16] {
        match self.description.orientation {
            Some(_) => &self.description.axes,
            None => self.description.linear(),
        }
    }

    /// What the planner's active move is a function of at the present tick: time, or a master's way.
    pub(crate) fn clock(&self, time: &Clock) -> Clock {
        self.guide.map_or(*time, |guide| guide.clock())
    }

    /// What its planned contours are functions of at the present tick: time, or the time that a master at the speed they were planned
    /// for would have taken for its way.
    pub(crate) fn contour_clock(&self, time: &Clock) -> Clock {
        self.guide.map_or(*time, |guide| {
            Clock::of_way(guide.displacement() / self.contour_speed())
        })
    }

    /// How the time of its planned contours goes on, where a master leads.
    pub(crate) fn contour_pace(&self, guide: &MasterFollower) -> arcline_planner::Pace {
        let (pace, speed) = (guide.pace(), self.contour_speed());
        arcline_planner::Pace {
            speed: pace.speed / speed,
            acceleration: pace.acceleration / speed,
        }
    }

    /// The speed of a master that the contour was planned for, master units/s.
    pub(crate) fn contour_speed(&self) -> f64 {
        let first = self.contour.as_ref().and_then(|contour| contour.moves().next());
        first.map_or(1.0, |motion| motion.parameter.speed)
    }

    /// Whether it has masters, active or not: it is computed behind them then.
    pub(crate) fn follows(&self) -> bool {
        self.guide.is_some() || !self.links.is_empty()
    }

    /// Where the active move is at the present tick, by time, and its speed by what it is a function of.
    pub(crate) fn sample(&self, time: &Clock) -> Option<(Sample, f64)> {
        let contour = self.contour_in_force();
        let mut sample = match contour {
            Some(contour) => contour.sample(&self.contour_clock(time)),
            None => self.planner.sample(&self.clock(time)),
        }?;
        let planned = sample.along.velocity;
        if let Some(guide) = &self.guide {
            let pace = if contour.is_some() {
                self.contour_pace(guide)
            } else {
                guide.pace()
            };
            sample = pace.sample(sample);
        }
        Some((sample, planned))
    }

    /// Seconds until the active move is at its end or its successor becomes active, as planned now. `None` where no time is known:
    /// nothing is active, it is held, it is stopped, or a master leads it.
    pub(crate) fn time_left(&self, time: &Clock) -> Option<f64> {
        if self.activity != Activity::Moving || self.guide.is_some() {
            return None;
        }
        match self.contour_in_force() {
            Some(contour) => contour.time_left(time),
            None => self.planner.time_left(time),
        }
    }

    /// A move, or a stop, that comes to an end by itself: not one that waits for a master.
    pub(crate) fn will_end(&self) -> bool {
        self.is_busy()
            && self
                .guide
                .is_none_or(|guide| guide.will_go_on() || self.planner.passage(&guide.clock()).is_some())
    }

    /// Whether the active move has its full speed by its master's. `planned`: its speed by the master's way.
    pub(crate) fn is_tracking(&self, planned: f64) -> bool {
        self.guide.is_some_and(|guide| guide.has_begun())
            && self.activity == Activity::Moving
            && self.shown_phase == Phase::Steady
            && planned > 0.0
            && !self.in_transition
    }

    /// Whether a merged move is travelled by the planner although the others are planned contours.
    pub(crate) fn is_merged(&self) -> bool {
        self.contour.is_some() && self.planner.active().is_some()
    }

    /// The contours, unless a merged move is travelled.
    pub(crate) fn contour_in_force(&self) -> Option<&ContourQueue<Planned>> {
        self.contour.as_ref().filter(|_| self.planner.active().is_none())
    }

    /// The moves that are active or wait, the active one first.
    pub(crate) fn moves(&self) -> impl Iterator<Item = &Move<Planned>> {
        let active = self.planner.active().map(|running| &running.motion);
        let contour = self.contour.iter().flat_map(ContourQueue::moves);
        active.into_iter().chain(self.planner.pending()).chain(contour)
    }

    /// Whether every pending place is taken.
    pub(crate) fn is_full(&self) -> bool {
        match &self.contour {
            Some(contour) if self.is_merged() => contour.moves().count() >= self.description.queue_depth,
            Some(contour) => contour.is_full(),
            None => self.planner.is_full(),
        }
    }

    /// Whether axes brake by themselves since a coordinated move that took them was ended.
    pub(crate) fn brakes(&self, axes: &[Axis]) -> bool {
        !self.braking.is_empty()
            && self.taken().iter().any(|index| {
                let axis = axes.get(usize::from(*index)).filter(|_| self.braking.contains(*index));
                axis.is_some_and(|axis| axis.has_coordinated_motion() && !axis.is_coordinated())
            })
    }

    /// Whether what it travels stays at rest until a speed is changed.
    pub(crate) fn is_paused(&self) -> bool {
        match self.contour_in_force() {
            Some(contour) => contour.is_paused(),
            None => self.planner.is_paused(),
        }
    }

    /// Whether a move waits behind the active one.
    pub(crate) fn has_pending(&self) -> bool {
        match &self.contour {
            Some(contour) => contour.moves().nth(usize::from(contour.is_running())).is_some(),
            None => self.planner.pending().next().is_some(),
        }
    }

    /// The active instruction, while it moves the axes.
    pub(crate) fn active(&mut self) -> Option<Planned> {
        match self.contour_in_force() {
            Some(contour) if contour.is_running() => contour.moves().next().map(|motion| motion.data),
            Some(_) => None,
            None => self.planner.active_data().copied(),
        }
    }

    /// The same, to change.
    pub(crate) fn active_mut(&mut self) -> Option<&mut Planned> {
        match &mut self.contour {
            Some(contour) if self.planner.active().is_none() => contour.active_data(),
            _ => self.planner.active_data(),
        }
    }

    /// The active instruction, taken out of a contour whose path goes on without it.
    pub(crate) fn take_active(&mut self) -> Option<Planned> {
        match &mut self.contour {
            Some(contour) if self.planner.active().is_none() => contour.pop().map(|motion| motion.data),
            _ => self.planner.active_data().copied(),
        }
    }

    /// Programmed end point of the active move.
    pub(crate) fn active_end(&self) -> Option<Point> {
        match self.contour_in_force() {
            Some(contour) if contour.is_running() => contour.moves().next().map(|motion| motion.path.end()),
            Some(_) => None,
            None => self.planner.active().map(|running| running.motion.path.end()),
        }
    }

    /// Programmed end point of the last move in the queue.
    pub(crate) fn last_end(&self) -> Option<Point> {
        let contour = self.contour.as_ref().and_then(|contour| contour.moves().last());
        contour
            .map(|motion| motion.path.end())
            .or_else(|| self.planner.last_end())
    }

    /// Whether a coordinated move of this system is active, pending, or being stopped on its path.
    pub(crate) fn is_busy(&self) -> bool {
        self.activity != Activity::Idle
    }

    /// Whether its axes turn a tool besides moving it: MCTO links it, not MCT.
    pub(crate) fn is_oriented(&self) -> bool {
        self.description.orientation.is_some() || self.wrist.is_some()
    }

    /// Whether it moves an axis as a master leads it.
    pub(crate) fn guides(&self, axis: u16) -> bool {
        self.guide.is_some() && self.has(axis)
    }

    pub(crate) fn has(&self, axis: u16) -> bool {
        self.description.axes.contains(&axis)
    }

    /// Whether this system and another one have an axis in common; its place here.
    pub(crate) fn shared_axis(&self, other: &System) -> Option<usize> {
        self.description.axes.iter().position(|axis| other.has(*axis))
    }
}

impl Termination {
    /// Whether a type holds the command at the end until the axes have settled.
    pub(crate) fn settles(self) -> bool {
        self == Termination::ActualTolerance
    }
}

/// Component of a point that belongs to the axis at a place of the coordinate system.
pub(crate) fn component(point: &Point, place: usize) -> f64 {
    point.get(place).copied().unwrap_or(0.0)
}
