//! The machine in motion: one tick after another.

use arcline_instruction_set::{Call, Flag, MotionControl, MotionError, Object};
use arcline_planner::geometry::Point;
use arcline_planner::precise::{AxisLimits, Trajectory};
use arcline_planner::profile::Phase;
use arcline_planner::{Clock, Instant, Passage};

use crate::axis::{Axis, AxisState, Source};
use crate::control::{Controls, Event, Execution, Ticket};
use crate::instructions::{self, Layouts};
use crate::machine::Machine;
use crate::snapshot::{AxisSnapshot, SystemSnapshot};
use crate::status;
use crate::stop::AxisSet;
use crate::system::{Activity, System, component};

/// Every axis and coordinate system of one motion group, and the instructions that move them.
#[derive(Debug)]
pub struct Motion {
    pub(crate) clock: Clock,
    pub(crate) axes: Vec<Axis>,
    pub(crate) systems: Vec<System>,
    pub(crate) controls: Controls,
    pub(crate) layouts: Layouts,
    /// Trajectories that are no longer needed, to be freed outside the tick.
    pub(crate) retired: Vec<Box<Trajectory>>,
    messages: Vec<Message>,
}

/// A request to a drive: its instruction is done an update later.
#[derive(Clone, Copy, Debug)]
struct Message {
    execution: Execution,
    axis: u16,
    /// The state that the axis has then reached.
    reached: Option<AxisState>,
}

/// Moves of one coordinate system that can end within one tick; the rest end in the next one.
pub(crate) const MAX_ENDS_PER_TICK: usize = 64;
/// Messages under way at once; one more is done at once.
const MESSAGES: usize = 1024;
/// Bisections of a settling time: to the last bit of a period.
const SETTLING_BISECTIONS: u32 = 60;

impl Motion {
    /// The machine at rest, before its first tick. The only allocation.
    pub fn new(machine: &Machine) -> Self {
        Motion {
            clock: Clock {
                tick: 0,
                period_ns: machine.period_ns.max(1),
            },
            axes: machine.axes.iter().map(Axis::new).collect(),
            systems: systems(machine),
            controls: Controls::new(),
            layouts: Layouts::new(),
            retired: Vec::with_capacity(2 * machine.systems.len()),
            messages: Vec::with_capacity(MESSAGES),
        }
    }

    /// The present tick.
    pub fn tick(&self) -> u64 {
        self.clock.tick
    }

    /// Brings everything to a tick: commands, drives, and the ends of moves, stops and messages that lie before
    /// it. Real-time: bounded by the number of axes and coordinate systems and by a fixed number of moves.
    pub fn begin(&mut self, tick: u64) {
        self.clock.tick = tick;
        self.finish_messages();
        for index in 0..self.systems.len() {
            if self.systems[index].is_busy() {
                self.advance_system(index);
            }
        }
        let period = self.clock.period();
        for axis in &mut self.axes {
            axis.advance(&self.clock);
            axis.follow(period);
        }
        for index in 0..self.systems.len() {
            self.finish_stop(index);
        }
        self.update_tolerances();
    }

    /// Executes an instruction at the present tick and returns what its motion control tag shows then.
    /// Real-time: bounded by the instruction and the coordinate systems that share its axes.
    pub fn execute(&mut self, ticket: Ticket, call: &Call) -> MotionControl {
        let execution = Execution {
            ticket,
            control: call.control,
            mnemonic: call.mnemonic,
        };
        let tick = self.clock.tick;
        let result = self
            .controls
            .begin(execution, tick)
            .and_then(|()| instructions::execute(self, execution, call));
        if let Err(error) = result {
            self.controls.fail(execution, error, tick);
        }
        self.controls.word(call.control)
    }

    /// A false rung condition of the instruction with this motion control tag.
    pub fn rung_false(&mut self, control: arcline_instruction_set::ControlSlot) {
        self.controls.rung_false(control, self.clock.tick);
    }

    /// Closes the tick: what instructions began at it shows in its commands, and every change is reported.
    pub fn finish(&mut self, report: impl FnMut(&Event)) {
        for index in 0..self.systems.len() {
            if std::mem::take(&mut self.systems[index].stale) {
                self.sample_system(index);
            }
        }
        self.controls.drain(self.clock.tick, report);
    }

    /// Whether a coordinated move would find the queue of its coordinate system full.
    pub fn has_room(&self, call: &Call) -> bool {
        if !instructions::is_queued(call.mnemonic) {
            return true;
        }
        let system = call.target.and_then(|index| self.systems.get(usize::from(index)));
        system.is_none_or(|system| !system.is_busy() || !system.is_full())
    }

    /// Whether nothing moves and nothing is under way that would end.
    pub fn at_rest(&self) -> bool {
        self.messages.is_empty()
            && self
                .systems
                .iter()
                .all(|system| !system.is_busy() && system.stop.is_none())
            && self.axes.iter().all(|axis| !axis.in_motion())
    }

    /// Stops everything that moves, every axis by itself; the instructions end without PC.
    pub fn stop_all(&mut self) {
        for index in 0..self.systems.len() {
            self.end_stop(index);
            self.abort_system(index, |_| false);
        }
    }

    /// Command position, velocity and acceleration, and actual position, of every axis.
    pub fn trace(&self) -> impl Iterator<Item = [f64; 4]> {
        self.axes.iter().map(|axis| {
            let command = axis.command;
            let actual = axis.shown(axis.drive.actual().position);
            [
                axis.shown(command.position),
                command.velocity,
                command.acceleration,
                actual,
            ]
        })
    }

    /// Events that found no room, ever.
    pub fn lost_events(&self) -> u64 {
        self.controls.lost()
    }

    /// What a motion control tag shows.
    pub fn control(&self, slot: arcline_instruction_set::ControlSlot) -> MotionControl {
        self.controls.word(slot)
    }

    /// Every axis at the present tick, in configuration order.
    pub fn axes(&self) -> impl Iterator<Item = AxisSnapshot> {
        self.axes.iter().map(status::axis)
    }

    /// Every coordinate system at the present tick, in configuration order.
    pub fn systems(&self) -> impl Iterator<Item = SystemSnapshot> {
        self.systems.iter().map(|system| status::system(system, &self.axes))
    }

    // ---- what instructions use -----------------------------------------------------------------------------

    pub(crate) fn target_axis(&self, call: &Call) -> Result<u16, MotionError> {
        call.target
            .filter(|index| usize::from(*index) < self.axes.len())
            .ok_or(instructions::no_target())
    }

    pub(crate) fn target_system(&self, call: &Call) -> Result<usize, MotionError> {
        call.target
            .map(usize::from)
            .filter(|index| *index < self.systems.len())
            .ok_or(instructions::no_target())
    }

    /// Step 5 of the verification: the operands, in faceplate order.
    pub(crate) fn verify_operands(&self, call: &Call) -> Result<(), MotionError> {
        let instruction = call.mnemonic.instruction();
        let axes = match instruction.object {
            Object::CoordinateSystem => {
                let index = self.target_system(call)?;
                self.systems[index].description.axes.len()
            }
            Object::Axis | Object::MotionGroup => 1,
        };
        instruction.verify(call, axes).map_err(MotionError::ParameterOutOfRange)
    }

    /// Sets DN now.
    pub(crate) fn done(&mut self, execution: Execution) {
        self.controls.write(execution, Flag::Dn.mask(), 0, self.clock.tick);
    }

    /// Sets DN at the next update, once the axis has reached a state.
    pub(crate) fn done_next_update(&mut self, execution: Execution, axis: u16, reached: Option<AxisState>) {
        if self.messages.len() < MESSAGES {
            self.messages.push(Message {
                execution,
                axis,
                reached,
            });
        } else {
            self.done(execution);
        }
    }

    /// Ends a move's instruction: it will never report again.
    pub(crate) fn end_move(&mut self, execution: Execution, set: u32) {
        let over = Flag::Ip.mask() | Flag::Ac.mask() | Flag::Accel.mask() | Flag::Decel.mask();
        self.controls.write(execution, set, over & !set, self.clock.tick);
    }

    /// Cancels every pending move of a coordinate system.
    pub(crate) fn cancel_pending(&mut self, index: usize) {
        if self.systems[index].contour.is_some() {
            self.cancel_pending_contour(index);
        }
        while let Some(cancelled) = self.systems[index].planner.cancel_pending() {
            self.end_move(cancelled.execution, 0);
        }
    }

    /// Ends the active move's instruction; the path is left to the caller.
    pub(crate) fn end_active(&mut self, index: usize) {
        if self.systems[index].activity == Activity::Moving
            && let Some(active) = self.systems[index].take_active()
        {
            self.end_move(active.execution, 0);
        }
    }

    /// Ends all coordinated motion of a system at once. Its axes brake by themselves, but for those that
    /// `hold` says stand or are without torque. Returns the axes that brake.
    pub(crate) fn abort_system(&mut self, index: usize, hold: impl Fn(u16) -> bool) -> AxisSet {
        let mut braking = AxisSet::default();
        if !self.systems[index].is_busy() {
            return braking;
        }
        self.cancel_pending(index);
        self.end_active(index);
        self.retire_contour(index);
        let s_curve = self.systems[index]
            .planner
            .clear_active()
            .is_some_and(|active| active.dynamics.is_s_curve());
        self.rest_system(index);
        for place in 0..self.systems[index].description.axes.len() {
            let axis = self.systems[index].description.axes[place];
            let Some(state) = self.axes.get_mut(usize::from(axis)) else {
                continue;
            };
            if hold(axis) {
                state.release();
            } else {
                state.brake(s_curve, self.clock.now());
                braking.insert(axis);
            }
        }
        braking
    }

    /// Ends all coordinated motion of a system at once for another one that takes the axes they share; the
    /// rest of its axes brake.
    pub(crate) fn abort_system_but(&mut self, index: usize, taker: usize) {
        let mut taken = AxisSet::default();
        for axis in &self.systems[taker].description.axes {
            taken.insert(*axis);
        }
        self.abort_system(index, |axis| taken.contains(axis));
    }

    /// Takes an axis out of every motion: the systems that move it are aborted, their other axes brake.
    pub(crate) fn leave(&mut self, axis: u16) {
        for index in 0..self.systems.len() {
            if self.systems[index].has(axis) {
                self.end_stop(index);
                self.abort_system(index, |other| other == axis);
            }
        }
    }

    /// Ends a running stop's instruction without PC.
    pub(crate) fn end_stop(&mut self, index: usize) {
        if let Some(stop) = self.systems[index].stop.take() {
            self.controls.write(stop.execution, 0, Flag::Ip.mask(), self.clock.tick);
        }
    }

    // ---- a tick --------------------------------------------------------------------------------------------

    fn finish_messages(&mut self) {
        for place in 0..self.messages.len() {
            let Message {
                execution,
                axis,
                reached,
            } = self.messages[place];
            if let (Some(state), Some(axis)) = (reached, self.axes.get_mut(usize::from(axis)))
                && matches!(
                    (axis.state, state),
                    (AxisState::Starting, AxisState::Running) | (AxisState::Stopping, AxisState::Stopped)
                )
            {
                axis.state = state;
            }
            self.done(execution);
        }
        self.messages.clear();
    }

    fn advance_system(&mut self, index: usize) {
        if self.systems[index].contour.is_some() {
            self.advance_contour(index);
            return;
        }
        for _ in 0..MAX_ENDS_PER_TICK {
            let at = match self.systems[index].planner.passage(&self.clock) {
                None => break,
                Some(Passage::HandOver(at)) => at,
                Some(Passage::Reached(at)) => match self.reached(index, at) {
                    Some(at) => at,
                    None => break,
                },
            };
            self.complete(index, at);
            if !self.systems[index].is_busy() {
                break;
            }
        }
        if self.systems[index].is_busy() {
            self.sample_system(index);
        }
    }

    /// The command is at the programmed end, or where a stop has led it. The instant at which the active
    /// move is complete, if it is.
    fn reached(&mut self, index: usize, at: Instant) -> Option<Instant> {
        if self.systems[index].activity == Activity::Stopping {
            self.sample_system(index);
            self.systems[index].planner.clear_active();
            self.release_axes(index);
            return None;
        }
        let active = self.systems[index].planner.active()?.motion.data;
        if self.systems[index].planner.passes_on() {
            return Some(at);
        }
        self.set_end_position(index);
        if active.termination.settles() {
            let end = self.systems[index].planner.active()?.motion.path.end();
            self.settled(index, &end, at)
        } else {
            Some(at)
        }
    }

    /// The active move is complete; the next one becomes active at the same instant.
    fn complete(&mut self, index: usize, at: Instant) {
        if let Some(active) = self.systems[index].planner.active_data().copied() {
            self.end_move(active.execution, Flag::Pc.mask());
            self.systems[index].in_actual_tolerance = active.termination.settles();
        }
        let next = self.systems[index].planner.hand_over(at, &self.clock).copied();
        match next {
            Some(next) => {
                let system = &mut self.systems[index];
                system.shown_phase = Phase::Steady;
                system.in_actual_tolerance = false;
                system.in_command_tolerance = false;
                self.controls.write(next.execution, Flag::Ac.mask(), 0, self.clock.tick);
                self.join_axes(index);
            }
            None => {
                self.systems[index].planner.clear_active();
                self.release_axes(index);
            }
        }
    }

    /// Takes the axes of a system into its coordinated move.
    pub(crate) fn join_axes(&mut self, index: usize) {
        for place in 0..self.systems[index].description.axes.len() {
            let axis = self.systems[index].description.axes[place];
            if let Some(axis) = self.axes.get_mut(usize::from(axis)) {
                axis.join();
            }
        }
    }

    /// Everything the system moved stands; nothing is active any more.
    pub(crate) fn release_axes(&mut self, index: usize) {
        self.rest_system(index);
        for place in 0..self.systems[index].description.axes.len() {
            let axis = self.systems[index].description.axes[place];
            if let Some(axis) = self.axes.get_mut(usize::from(axis))
                && matches!(axis.source, Source::System)
            {
                axis.release();
            }
        }
    }

    pub(crate) fn rest_system(&mut self, index: usize) {
        let system = &mut self.systems[index];
        system.activity = Activity::Idle;
        system.shown_phase = Phase::Steady;
        system.in_transition = false;
        system.along = [0.0; 3];
        system.stale = false;
    }

    /// The commands stand exactly on the programmed end of the active move.
    fn set_end_position(&mut self, index: usize) {
        if let Some(end) = self.systems[index].active_end() {
            self.hold_at(index, &end);
        }
    }

    /// The commands stand exactly on a point.
    pub(crate) fn hold_at(&mut self, index: usize, end: &Point) {
        for place in 0..self.systems[index].description.axes.len() {
            let axis = self.systems[index].description.axes[place];
            if let Some(axis) = self.axes.get_mut(usize::from(axis)) {
                axis.command.position = component(end, place);
                axis.release();
                axis.source = Source::System;
            }
        }
    }

    /// Commands of a system's axes at the present tick, and ACCEL and DECEL of its active instruction.
    pub(crate) fn sample_system(&mut self, index: usize) {
        let system = &mut self.systems[index];
        let sample = match &system.contour {
            Some(contour) => contour.sample(&self.clock),
            None => system.planner.sample(&self.clock),
        };
        let Some(sample) = sample else {
            return;
        };
        let length = system
            .planner
            .active()
            .map_or(0.0, |running| running.motion.path.length());
        system.in_transition = system.planner.in_transition(&self.clock);
        system.along = [sample.along.velocity.abs(), sample.along.position, length];
        for (place, axis) in system.description.axes.iter().enumerate() {
            let Some(axis) = self.axes.get_mut(usize::from(*axis)) else {
                continue;
            };
            axis.command = arcline_drive::Motion {
                position: component(&sample.position, place),
                velocity: component(&sample.velocity, place),
                acceleration: component(&sample.acceleration, place),
            };
        }
        if system.activity == Activity::Moving && sample.phase != system.shown_phase {
            system.shown_phase = sample.phase;
            let (set, clear) = match sample.phase {
                Phase::Accelerating => (Flag::Accel.mask(), Flag::Decel.mask()),
                Phase::Decelerating => (Flag::Decel.mask(), Flag::Accel.mask()),
                Phase::Steady => (0, Flag::Accel.mask() | Flag::Decel.mask()),
            };
            if let Some(active) = system.active() {
                self.controls.write(active.execution, set, clear, self.clock.tick);
            }
        }
    }

    /// The instant at which the axes came within the Actual Tolerance of the end that the command reached
    /// before the present tick: found inside the tick, so that a successor's start does not depend on the period.
    pub(crate) fn settled(&self, index: usize, end: &Point, reached: Instant) -> Option<Instant> {
        let system = &self.systems[index];
        let period = self.clock.period();
        let mut drives = [arcline_drive::Drive::ideal(0.0); crate::machine::MAX_PRIMARY_AXES];
        for ((place, axis), drive) in system.description.axes.iter().enumerate().zip(&mut drives) {
            *drive = self.axes.get(usize::from(*axis))?.drive;
            drive.cycle(
                arcline_drive::Motion {
                    position: component(end, place),
                    velocity: 0.0,
                    acceleration: 0.0,
                },
                period,
            );
        }
        let distance = |before: f64| {
            let squares = drives.iter().map(|drive| {
                let error = drive.error_before(before);
                error * error
            });
            squares.sum::<f64>().sqrt()
        };
        let tolerance = system.description.actual_tolerance;
        if distance(0.0) > tolerance {
            return None;
        }
        let available = reached.elapsed(&self.clock).min(period);
        if distance(available) <= tolerance {
            let early = reached.elapsed(&self.clock) - available;
            return Some(reached.after(early, &self.clock));
        }
        let (mut inside, mut outside) = (0.0, available);
        for _ in 0..SETTLING_BISECTIONS {
            let middle = 0.5 * (inside + outside);
            if distance(middle) <= tolerance {
                inside = middle;
            } else {
                outside = middle;
            }
        }
        Some(reached.after(reached.elapsed(&self.clock) - inside, &self.clock))
    }

    fn finish_stop(&mut self, index: usize) {
        let system = &self.systems[index];
        let Some(stop) = system.stop else {
            return;
        };
        let braking = |(place, axis): (usize, &Axis)| {
            stop.braking.contains(place as u16) && matches!(axis.source, Source::Braking { .. })
        };
        if system.is_busy() || (!stop.braking.is_empty() && self.axes.iter().enumerate().any(braking)) {
            return;
        }
        self.systems[index].stop = None;
        self.controls
            .write(stop.execution, Flag::Pc.mask(), Flag::Ip.mask(), self.clock.tick);
    }

    fn update_tolerances(&mut self) {
        for system in &mut self.systems {
            if system.activity != Activity::Moving {
                continue;
            }
            if let Some(end) = system.active_end() {
                let axes = &self.axes;
                let squares = system.description.axes.iter().enumerate().map(|(place, axis)| {
                    let command = axes.get(usize::from(*axis)).map_or(0.0, |axis| axis.command.position);
                    let left = command - component(&end, place);
                    left * left
                });
                system.in_command_tolerance = squares.sum::<f64>().sqrt() < system.description.command_tolerance;
            }
        }
    }
}

/// The coordinate systems of a machine. A corner may change the velocity of an axis by what its Maximum
/// Acceleration allows within one update (spec/coordinated-instructions.md §7.5).
fn systems(machine: &Machine) -> Vec<System> {
    let step = |axis: &u16| {
        let axis = machine.axes.get(usize::from(*axis));
        axis.map_or(0.0, |axis| axis.max_acceleration * machine.period())
    };
    let system = |description: &crate::machine::CoordinateSystem| {
        let mut corner_step = Point::zeros();
        for (axis, own) in description.axes.iter().zip(corner_step.iter_mut()) {
            *own = step(axis);
        }
        System::new(description, corner_step, enforced(machine, description))
    };
    machine.systems.iter().map(system).collect()
}

/// What planned contours of a coordinate system keep of the limits of its axes.
fn enforced(machine: &Machine, system: &crate::machine::CoordinateSystem) -> AxisLimits {
    let unlimited = Point::repeat(f64::INFINITY);
    let mut limits = AxisLimits {
        speed: unlimited,
        acceleration: unlimited,
        jerk: None,
    };
    if system.axis_limits == crate::machine::AxisLimits::Ignore {
        return limits;
    }
    let mut jerk = unlimited;
    for (place, axis) in system.axes.iter().enumerate() {
        if let Some(axis) = machine.axes.get(usize::from(*axis)) {
            limits.speed[place] = axis.max_speed;
            limits.acceleration[place] = axis.max_acceleration.min(axis.max_deceleration);
            jerk[place] = axis.max_acceleration_jerk.min(axis.max_deceleration_jerk);
        }
    }
    limits.jerk = Some(jerk);
    limits
}
