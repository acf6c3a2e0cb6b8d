//! Ticks in which nothing happens but the motion of active moves along their courses, and of the axes after them: a virtual clock passes
//! over them.
//!
//! Such a tick calculates the same commands, exchanges them with the drives and takes the same feedback as [`Motion::begin`], to the last bit. It
//! does not look for events that cannot come, and the status that only shows is left to the next tick that [`Motion::begin`] begins. Any change
//! ends it: of a phase, of a move, of the feedback. Nothing allocates. Units: position units, seconds.

use arcline_drive::{Drives, Feedback, SetPoint};
use arcline_instruction_set::{AxisId, SystemId};
use arcline_planner::geometry::Point;
use arcline_planner::{Clock, Course, Instant};
use arcline_profile::{KinematicState, ProfileSegment};

use super::Motion;
use super::command_limits::Step;
use crate::axis::Axis;
use crate::axis::generator::{Equation, Generator};
use crate::axis::generator_kind::GeneratorKind;
use crate::axis::state::AxisState;
use crate::axis::sum::Sum;
use crate::system::{Activity, numbered};

/// The motion of a machine in uneventful ticks. Only memory: it is filled before each series of them.
#[derive(Debug, Default)]
pub(super) struct Uneventful {
    courses: Vec<MovingSystem>,
    axes: Vec<AwakeAxis>,
    ids: Vec<AxisId>,
    /// The drives of these axes are exactly at their set-points: exchanges are left out.
    are_exact: bool,
    /// The number of exchanges left out since the last one.
    left_out: u64,
}

/// A coordinate system that moves its axes.
#[derive(Debug)]
struct MovingSystem {
    id: SystemId,
    course: Course,
    /// Position, velocity and acceleration at the present tick.
    now: [Point; 3],
}

/// An axis that is not dormant.
#[derive(Debug)]
struct AwakeAxis {
    id: AxisId,
    moved_by: MovedBy,
    /// The motion of its generator at the present tick, in the generator's frame; the offset between this frame and the axis's.
    now: KinematicState,
    shift: f64,
    /// The command of the present tick.
    command: KinematicState,
    redefined: f64,
    /// The steps that its limits allow.
    step: Option<Step>,
    /// The set-point of the tick before the present one.
    before: KinematicState,
    /// The actual position at the present tick.
    position: f64,
}

/// The source of an axis's commands.
#[derive(Debug)]
enum MovedBy {
    /// It stands.
    Nothing,
    /// A course, by its index, and the index of the axis in that coordinate system.
    Course { course: usize, member: usize },
    /// A profile of its own: a segment, the instant from which it counts, and the time of its end.
    Profile {
        kind: GeneratorKind,
        segment: ProfileSegment,
        start: Instant,
        until: f64,
    },
}

impl Uneventful {
    pub(super) fn new(axes: usize, systems: usize) -> Self {
        Uneventful {
            courses: Vec::with_capacity(systems),
            axes: Vec::with_capacity(axes),
            ids: Vec::with_capacity(axes),
            are_exact: false,
            left_out: 0,
        }
    }

    /// Calculates the commands of a tick. False: a course has ended, and the tick is not uneventful.
    fn advance(&mut self, clock: &Clock) -> bool {
        for moving in &mut self.courses {
            match moving.course.at(clock) {
                Some(now) => moving.now = now,
                None => return false,
            }
        }
        for axis in &mut self.axes {
            axis.now = match &axis.moved_by {
                MovedBy::Nothing => continue,
                MovedBy::Course { course, member } => {
                    let now = self.courses[*course].now.map(|now| now[*member]);
                    let [position, velocity, acceleration] = now;
                    KinematicState {
                        position,
                        velocity,
                        acceleration,
                    }
                }
                MovedBy::Profile {
                    segment, start, until, ..
                } => {
                    let elapsed = start.elapsed(clock);
                    if elapsed >= *until {
                        return false;
                    }
                    segment.at(elapsed)
                }
            };
            axis.command = Sum::sole_command(&axis.now, axis.shift);
        }
        true
    }

    fn write_set_points(&mut self, set_points: &mut [SetPoint]) {
        for axis in &mut self.axes {
            let out = &mut set_points[axis.id.index()];
            axis.before = out.motion();
            out.set_motion(axis.machine_command());
            out.stood = 0.0;
        }
    }

    /// Exchanges the set-points of the present tick with the drives, or leaves it out.
    fn exchange(&mut self, set_points: &[SetPoint], feedback: &mut [Feedback], drives: &mut dyn Drives) {
        if self.are_exact {
            self.left_out += 1;
        } else {
            drives.exchange_of(&self.ids, set_points, feedback);
        }
    }

    /// Makes up for the exchanges that were left out: the last two of them.
    fn make_up(&mut self, set_points: &mut [SetPoint], feedback: &mut [Feedback], drives: &mut dyn Drives) {
        let left_out = std::mem::take(&mut self.left_out);
        if left_out > 1 {
            self.swap_set_points(set_points);
            drives.exchange_of(&self.ids, set_points, feedback);
            self.swap_set_points(set_points);
        }
        if left_out > 0 {
            drives.exchange_of(&self.ids, set_points, feedback);
        }
    }

    /// Swaps the set-points of the present tick and of the one before it.
    fn swap_set_points(&mut self, set_points: &mut [SetPoint]) {
        for axis in &mut self.axes {
            let out = &mut set_points[axis.id.index()];
            let present = out.motion();
            out.set_motion(axis.before);
            axis.before = present;
        }
    }
}

impl Motion {
    /// Begins the next tick, `tick`, in which something may happen, at most `most` ticks later, and passes over the uneventful ones before it.
    /// Returns their number. The state is then that of [`Motion::begin`] and [`Motion::finish`] in each of them, to the last bit.
    pub fn begin_after(&mut self, tick: u64, most: u64, drives: &mut dyn Drives) -> u64 {
        let mut uneventful = std::mem::take(&mut self.uneventful);
        let passed = if most > 0 && self.fill(&mut uneventful, drives) {
            self.pass_over(&mut uneventful, tick, most, drives)
        } else {
            self.begin(tick, drives);
            0
        };
        self.uneventful = uneventful;
        passed
    }

    fn pass_over(&mut self, uneventful: &mut Uneventful, tick: u64, most: u64, drives: &mut dyn Drives) -> u64 {
        for passed in 0..most {
            self.clock.tick = tick + passed;
            if !uneventful.advance(&self.clock) || !self.all_may_go_out(uneventful) {
                self.stay_before(uneventful, tick, passed, drives);
                self.begin(tick + passed, drives);
                return passed;
            }
            uneventful.write_set_points(&mut self.set_points);
            uneventful.exchange(&self.set_points, &mut self.feedback, drives);
            if !self.take_plain_feedback(uneventful) {
                uneventful.make_up(&mut self.set_points, &mut self.feedback, drives);
                self.controls.begin_tick(tick + passed);
                self.set_commands(uneventful);
                self.take_feedback(true, drives);
                return passed;
            }
        }
        self.stay_before(uneventful, tick, most, drives);
        self.begin(tick + most, drives);
        most
    }

    /// Fills `uneventful` for the ticks from the next one on. False: something may happen in it. Valid at the end of a tick.
    fn fill(&self, uneventful: &mut Uneventful, drives: &dyn Drives) -> bool {
        let Uneventful { courses, axes, ids, .. } = uneventful;
        courses.clear();
        axes.clear();
        ids.clear();
        if !self.expects_nothing() {
            return false;
        }
        for (id, system) in self.systems.ids().zip(self.systems.iter()) {
            if !system.expects_nothing() {
                return false;
            }
            if system.activity == Activity::Moving {
                let Some(course) = system.travel.course(&self.clock) else {
                    return false;
                };
                courses.push(MovingSystem {
                    id,
                    course,
                    now: Default::default(),
                });
            }
        }
        for (id, axis) in self.axes.ids().zip(self.axes.iter()) {
            if axis.dormant {
                continue;
            }
            let Some((moved_by, generator)) = self.moved_by(id, axis, courses) else {
                return false;
            };
            axes.push(AwakeAxis {
                id,
                moved_by,
                now: KinematicState::default(),
                shift: generator.map_or(0.0, Generator::shift),
                command: axis.command,
                redefined: axis.redefined,
                step: self.step(id),
                before: KinematicState::default(),
                position: axis.actual.position,
            });
            ids.push(id);
        }
        uneventful.are_exact = self.follow_exactly(&uneventful.ids, drives);
        drives.rest_but(&uneventful.ids)
    }

    /// The drives of these axes are exactly at their set-points as long as nothing happens.
    fn follow_exactly(&self, axes: &[AxisId], drives: &dyn Drives) -> bool {
        let is_armed = |set_point: &SetPoint| set_point.latches.iter().any(Option::is_some);
        let mut set_points = axes.iter().map(|id| &self.set_points[id.index()]);
        drives.follow_exactly(axes) && !set_points.any(is_armed)
    }

    /// No instruction, transform, follower or output cam is under way besides moves.
    fn expects_nothing(&self) -> bool {
        self.messages.is_empty()
            && self.group_stop.is_none()
            && self.order.is_empty()
            && self.transforms.iter().next().is_none()
            && self.words.is_empty()
            && !self.axes.have_output_cams
            && self.controls.are_reported()
    }

    /// The source of the commands of an axis that is not dormant. `None`: something else can happen to it.
    fn moved_by<'a>(
        &self,
        id: AxisId,
        axis: &'a Axis,
        courses: &[MovingSystem],
    ) -> Option<(MovedBy, Option<&'a Generator>)> {
        if axis.state != AxisState::Running || !axis.expects_nothing() {
            return None;
        }
        if axis.sum.is_idle() {
            return axis.unwind.is_none().then_some((MovedBy::Nothing, None));
        }
        let (kind, generator) = axis.sum.sole()?;
        let moved_by = match &generator.equation {
            Equation::Followed if kind == GeneratorKind::System => {
                let moves = |moving: &MovingSystem| {
                    let mut own = numbered(self.systems[moving.id].description.linear());
                    own.find(|(_, own)| *own == id).map(|(member, _)| usize::from(member.0))
                };
                let mut found = courses.iter().enumerate();
                let (course, member) = found.find_map(|(course, moving)| Some((course, moves(moving)?)))?;
                MovedBy::Course { course, member }
            }
            Equation::Planned { profile, start } if kind != GeneratorKind::Jog || axis.unwind.is_none() => {
                let (segment, until) = generator.segment(profile, start, &self.clock)?;
                MovedBy::Profile {
                    kind,
                    segment,
                    start: *start,
                    until,
                }
            }
            _ => return None,
        };
        (!generator.ending).then_some((moved_by, Some(generator)))
    }

    /// The limits of all axes allow the commands of the present tick.
    fn all_may_go_out(&self, uneventful: &Uneventful) -> bool {
        uneventful.axes.iter().all(|axis| {
            let next = axis.machine_command();
            let last = &self.set_points[axis.id.index()];
            let stands = next.position == last.position && next.velocity == last.velocity;
            stands || axis.step.is_some_and(|step| step.allows(last, &next)) || self.may_go_out(axis.id, &next)
        })
    }

    /// Takes the feedback of an exchange if it changes only the motion of the axes; otherwise nothing is taken.
    fn take_plain_feedback(&mut self, uneventful: &mut Uneventful) -> bool {
        for axis in &mut uneventful.axes {
            let id = axis.id.index();
            let (feedback, sent) = (&self.feedback[id], &self.set_points[id]);
            let followed = &self.axes[axis.id];
            let position = if uneventful.are_exact {
                followed.plain_exact_position(axis.command.position)
            } else {
                followed.plain_position(feedback, sent, axis.command.position)
            };
            match position {
                Some(position) => axis.position = position,
                None => return false,
            }
        }
        for (axis, known) in self.axes.awake_mut().zip(&uneventful.axes) {
            axis.average.take(known.position - axis.redefined);
        }
        true
    }

    /// Writes the commands and the feedback of the last of the passed ticks back to the axes: their state is then that at its end.
    fn stay_before(&mut self, uneventful: &mut Uneventful, tick: u64, passed: u64, drives: &mut dyn Drives) {
        if passed == 0 {
            return;
        }
        uneventful.make_up(&mut self.set_points, &mut self.feedback, drives);
        self.clock.tick = tick + passed - 1;
        uneventful.advance(&self.clock);
        self.set_commands(uneventful);
        let values = self.set_points.iter().zip(&self.feedback);
        for (axis, (sent, feedback)) in self.axes.all_mut().zip(values) {
            if !axis.dormant {
                axis.set_feedback(feedback, sent);
            }
        }
        for system in self.systems.iter_mut() {
            system.update_tolerance(&self.axes);
        }
    }

    /// Writes the commands of the present tick back to the axes and the coordinate systems.
    fn set_commands(&mut self, uneventful: &Uneventful) {
        for moving in &uneventful.courses {
            self.sample_system(moving.id);
        }
        for (axis, known) in self.axes.awake_mut().zip(&uneventful.axes) {
            let kind = match known.moved_by {
                MovedBy::Nothing => continue,
                MovedBy::Course { .. } => GeneratorKind::System,
                MovedBy::Profile { kind, .. } => kind,
            };
            axis.set_sole(kind, known.now, known.command);
        }
    }
}

impl AwakeAxis {
    /// The command of the present tick, without the offset of redefined positions.
    fn machine_command(&self) -> KinematicState {
        KinematicState {
            position: self.command.position - self.redefined,
            ..self.command
        }
    }
}
