//! The machine in motion: one tick after another.

mod accepted;
mod command_limits;
mod faults;
mod follow;
mod generators;
mod homing;
mod master_links;
mod messages;
pub(crate) mod operands;
mod outputs;
mod probes;
mod tick;
mod transforms;
mod uneventful;

use arcline_contour::AxisLimits;
use arcline_drive::{Feedback, SetPoint};
use arcline_instruction_set::{AxisId, Call, ControlSlot, JogEnd, MotionControl, MotionError};
use arcline_planner::Clock;
use arcline_planner::geometry::Point;

use crate::axes::Axes;
use crate::axis::Axis;
use crate::axis::generator_kind::GeneratorKind;
use crate::cause::{Cause, FaultChange};
use crate::control::{Controls, Event};
use crate::events::InstructionWrite;
use crate::execution::{Execution, Ticket};
use crate::machine::{LimitPolicy, MotionGroup};
use crate::masters::link_numbers::LinkNumbers;
use crate::order::Order;
use crate::output::TagBits;
use crate::snapshot::{AxisSnapshot, SystemSnapshot};
use crate::status;
use crate::stop::Stop;
use crate::system::{System, Systems};
use crate::transforms::Transforms;
use crate::transforms::ahead::PlannedStops;

use accepted::ACCEPTED;
use messages::{MESSAGES, Message};
use uneventful::Uneventful;

pub use accepted::AcceptedMove;
pub use probes::Input;

/// Every axis and coordinate system of one motion group, and the instructions that move them.
#[derive(Debug)]
pub struct Motion {
    pub(crate) clock: Clock,
    pub(crate) axes: Axes,
    pub(crate) systems: Systems,
    /// The set-points of the last exchange, in the order of the axes.
    set_points: Vec<SetPoint>,
    /// The feedback of the last exchange.
    feedback: Vec<Feedback>,
    pub(crate) controls: Controls,
    pub(crate) transforms: Transforms,
    /// The order of a tick while some axes follow others.
    pub(crate) order: Order,
    /// The stopping motions with which transforms check their targets ahead.
    pub(crate) ahead: PlannedStops,
    pub(crate) link_numbers: LinkNumbers,
    /// Words that changed and that output cams have not read yet.
    words: Vec<TagBits>,
    /// The group's stop that is under way (MGS).
    pub(crate) group_stop: Option<Stop>,
    messages: Vec<Message>,
    /// Accepted coordinated moves that the controller has not read yet.
    pub(crate) accepted: Vec<AcceptedMove>,
    /// Instructions that would begin motion are refused.
    pub(crate) is_inhibited: bool,
    uneventful: Uneventful,
}

/// Words that output cams can write in one tick; further ones are lost.
const WORDS: usize = 1024;

impl Motion {
    /// The machine at rest, before its first tick. The only allocation.
    pub fn new(machine: &MotionGroup) -> Self {
        let clock = Clock::at(0, machine.period_ns.max(1));
        Motion {
            clock,
            axes: Axes::new(machine, &clock),
            systems: systems(machine),
            set_points: vec![SetPoint::default(); machine.axes.len()],
            feedback: vec![Feedback::default(); machine.axes.len()],
            controls: Controls::new(),
            transforms: Transforms::new(machine.systems.len()),
            order: Order::new(machine.axes.len(), machine.systems.len()),
            ahead: PlannedStops::new(machine.axes.len(), machine.systems.len()),
            link_numbers: LinkNumbers::default(),
            words: Vec::with_capacity(WORDS),
            group_stop: None,
            messages: Vec::with_capacity(MESSAGES),
            accepted: Vec::with_capacity(ACCEPTED),
            is_inhibited: false,
            uneventful: Uneventful::new(machine.axes.len(), machine.systems.len()),
        }
    }

    /// The present tick.
    pub fn tick(&self) -> u64 {
        self.clock.tick
    }

    /// Refuses an instruction without verification. Real-time.
    pub fn refuse_call(&mut self, ticket: Ticket, call: &Call, error: MotionError) -> MotionControl {
        let execution = Execution {
            ticket,
            control: call.control,
            mnemonic: call.mnemonic,
        };
        // For the tag, a collision with the earlier execution is a refusal as well.
        let begun = self.controls.begin(execution);
        self.controls.fail(execution, begun.err().unwrap_or(error));
        self.controls.word(call.control)
    }

    /// A false rung condition of the instruction with this motion control tag.
    pub fn rung_false(&mut self, control: ControlSlot) {
        self.controls.rung_false(control);
    }

    /// Ends the tick: recalculates commands for instructions that began in it, and reports every change.
    pub fn finish(&mut self, report: impl FnMut(&Event)) {
        let mut changed = false;
        for index in self.systems.ids() {
            if std::mem::take(&mut self.systems[index].stale) {
                self.sample_system(index);
                changed = true;
            }
        }
        self.refresh_axes(changed);
        for system in self.systems.iter_mut() {
            system.calculate(&mut self.controls, &self.clock);
        }
        self.show_links();
        self.finish_outputs();
        self.controls.drain(report);
    }

    /// The writes of instructions to tags in this tick, in order; to be called once a tick, after [`Motion::finish`]. Real-time as
    /// far as `report` is.
    pub fn take_instruction_writes(&mut self, report: impl FnMut(&InstructionWrite)) {
        self.controls.take_instruction_writes(report);
    }

    /// The changes of faults in this tick, axis after axis; to be called once a tick, before or after [`Motion::finish`].
    /// Real-time as far as `report` is; bounded by the axes.
    pub fn take_fault_changes(&mut self, mut report: impl FnMut(&FaultChange)) {
        for (index, axis) in self.axes.ids().zip(self.axes.all_mut()) {
            if axis.dormant {
                continue;
            }
            if let Some(change) = axis.faults.take_change(self.clock.tick, index) {
                report(&change);
            }
        }
    }

    /// No motion is under way that would end on its own. Motion that waits for a standing master does not.
    pub fn at_rest(&self) -> bool {
        self.messages.is_empty()
            && self.group_stop.is_none()
            && self
                .systems
                .iter()
                .all(|system| !system.will_end(&self.clock) && system.stop.is_none())
            && self
                .axes
                .iter()
                .all(|axis| !axis.will_end() && !axis.is_homed_actively())
    }

    /// No axis moves, and none will before another instruction is executed: all velocities are 0, no time cam runs, and no axis is being
    /// homed. Unlike [`Motion::at_rest`], this holds while a move with a speed of 0 is in process, and not while an axis jogs.
    pub fn is_still(&self) -> bool {
        self.messages.is_empty()
            && self.axes.iter().all(|axis| {
                axis.command.velocity == 0.0 && !axis.sum.is_active(GeneratorKind::TimeCam) && !axis.is_homed_actively()
            })
    }

    /// Stops all motion, each axis separately; the instructions end without PC. Real-time.
    pub fn stop_all(&mut self) {
        self.controls.because(Cause::StopAll);
        for index in self.systems.ids() {
            self.systems[index].end_stop(&mut self.controls);
            self.abort_system(index, |_| false);
        }
        self.unlink_all();
        for axis in self.axes.ids() {
            self.stop_axis(axis, None);
        }
        self.controls.because(Cause::Itself);
    }

    /// Starts or ends the refusal of instructions that would begin motion (error 53). Motion under way continues. Real-time.
    pub fn inhibit(&mut self, is_inhibited: bool) {
        self.is_inhibited = is_inhibited;
    }

    /// Stops the jog that an instruction began on an axis, at the axis's full deceleration, and makes the stops that are under way
    /// on the axis as hard. It cannot be refused; a jog of another instruction continues. Real-time.
    pub fn end_jog(&mut self, axis: AxisId, ticket: Ticket, why: JogEnd) {
        if self.axes.get(axis).is_none() {
            return;
        }
        self.controls.because(Cause::Jog(why));
        self.axes[axis].end_jog(|execution| execution.ticket == ticket, &mut self.controls, &self.clock);
        self.controls.because(Cause::Itself);
    }

    /// Command position, velocity and acceleration, and actual position, of every axis.
    pub fn trace(&self) -> impl Iterator<Item = [f64; 4]> {
        self.axes.iter().map(|axis| {
            let command = axis.command;
            let actual = axis.shown(axis.actual.position);
            [
                axis.shown(command.position),
                command.velocity,
                command.acceleration,
                actual,
            ]
        })
    }

    /// The number of events lost for lack of room since the start.
    pub fn lost_events(&self) -> u64 {
        self.controls.lost()
    }

    /// The status that a motion control tag shows.
    pub fn control(&self, slot: ControlSlot) -> MotionControl {
        self.controls.word(slot)
    }

    /// The axes that may differ from their state at the end of an earlier tick, in configuration order; all axes without one.
    pub fn axes_since(&self, tick: Option<u64>) -> impl Iterator<Item = (AxisId, AxisSnapshot)> {
        let is_same = move |axis: &Axis| axis.dormant && tick.is_some_and(|tick| axis.dormant_since <= tick);
        let axes = self.axes.ids().zip(self.axes.iter());
        let axes = axes.filter(move |(_, axis)| !is_same(axis));
        axes.map(|(id, axis)| (id, status::axis(axis, &self.clock)))
    }

    /// Every coordinate system at the present tick, in configuration order.
    pub fn systems(&self) -> impl Iterator<Item = SystemSnapshot> {
        let present = self.present();
        let systems = self.systems.ids().zip(self.systems.iter());
        systems.map(move |(id, system)| SystemSnapshot {
            time_left: system.time_left(&self.clock),
            ..status::system(system, &self.axes, present.role(id))
        })
    }
}

/// The coordinate systems of a machine. At a corner the velocity of an axis may change by its Maximum Acceleration times one
/// update (spec/coordinated-instructions.md §7.5).
fn systems(machine: &MotionGroup) -> Systems {
    let step = |axis: &AxisId| {
        let axis = machine.axes.get(usize::from(*axis));
        axis.map_or(0.0, |axis| axis.max_acceleration * machine.period())
    };
    let system = |description: &crate::machine::CoordinateSystem| {
        let mut corner_step = Point::zeros();
        for (axis, own) in description.linear().iter().zip(corner_step.iter_mut()) {
            *own = step(axis);
        }
        System::new(
            description,
            corner_step,
            machine.period(),
            enforced(machine, description),
        )
    };
    machine.systems.iter().map(system).collect()
}

/// The limits of its axes that planned contours of a coordinate system must keep.
fn enforced(machine: &MotionGroup, system: &crate::machine::CoordinateSystem) -> AxisLimits {
    let unlimited = Point::repeat(f64::INFINITY);
    let mut limits = AxisLimits {
        speed: unlimited,
        acceleration: unlimited,
        jerk: None,
    };
    if system.axis_limits == LimitPolicy::Ignore {
        return limits;
    }
    let mut jerk = unlimited;
    for (member, axis) in system.linear().iter().enumerate() {
        if let Some(axis) = machine.axes.get(usize::from(*axis)) {
            limits.speed[member] = axis.max_speed;
            limits.acceleration[member] = axis.max_acceleration.min(axis.max_deceleration);
            jerk[member] = axis.max_acceleration_jerk.min(axis.max_deceleration_jerk);
        }
    }
    limits.jerk = Some(jerk);
    limits
}
