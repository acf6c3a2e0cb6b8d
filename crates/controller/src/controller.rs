//! The tick: commands in, motion, drives, events and a snapshot out.

use std::sync::Arc;

use arcline_drive::Drives;
use arcline_instruction_set::{
    AxisId, Call, ControlSlot, FaultSet, Flag, JogEnd, MotionControl, MotionError, Setting, SystemId,
};
use arcline_motion::{
    AcceptedMove, AxisSet, CallData, ContourRequest, Event, FaultChange, Input, InstructionWrite, Motion, Ticket,
    Trajectory,
};

use crate::drives::simulated;
use crate::machine::{self, Machine};
use crate::overtaken::Overtaken;
use crate::snapshot::Snapshot;

/// A command to the controller from outside.
#[derive(Clone, Debug)]
pub enum Command {
    /// Execute an instruction: a false-to-true transition of its rung condition.
    Call(Ticket, Call),
    /// Execute an instruction with its data that stand in tags.
    CallWith(Ticket, Call, CallData),
    /// Execute a move of a series. The controller refuses it, and leaves its motion control tag unchanged, if its queue has no room or an earlier
    /// move of the same series has failed.
    CallOfSeries(Ticket, Call, Series),
    /// The rung condition of the instruction with this motion control tag is false.
    RungFalse(ControlSlot),
    /// Set the override of a coordinate system: the share of the programmed speeds of its moves, 0 to 2; 0 holds.
    Override {
        /// Index of the coordinate system.
        system: SystemId,
        /// The share.
        rate: f64,
    },
    /// Set an attribute of an axis or a coordinate system.
    Set(Setting),
    /// Inject causes of faults into an axis, in place of those injected before.
    Inject {
        /// Index of the axis.
        axis: AxisId,
        /// The causes.
        causes: FaultSet,
    },
    /// Take a value written to a tag that the machine reads.
    Input(Input),
    /// Stop all motion of every coordinate system in a controlled way, for a shutdown of the process.
    StopAll,
}

/// Identifies moves that one client has sent together: the ticket of the first one. Except for stops, no other command comes between them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Series(pub Ticket);

/// A request to stop, which precedes all commands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StopRequest {
    /// All motion, each axis separately.
    All,
    /// The jog that an instruction began on an axis: see [`Motion::end_jog`].
    Jog {
        /// Index of the axis.
        axis: AxisId,
        /// The instruction.
        ticket: Ticket,
        /// The cause of its end.
        why: JogEnd,
    },
}

/// A command that precedes others that were sent before it and still wait.
#[derive(Clone, Debug)]
pub struct Overtaking {
    /// An instruction that stops or disables, or its false rung condition.
    pub command: Command,
    /// The number of commands ever sent before it, without stops.
    pub sent_before: u64,
}

/// The connection of the controller to the rest of the server: rings in the real-time thread, plain collections in a test.
/// The tick calls every method; none may block or allocate. The trait has no default bodies, so an implementation that discards data does so
/// explicitly.
pub trait Port {
    /// The next request to stop. The tick takes every request before its first command.
    fn next_stop(&mut self) -> Option<StopRequest>;
    /// A command of this tick was sent before the newest [`StopRequest::All`]: the stop includes the motion that it began.
    fn was_sent_before_stop(&mut self) -> bool;
    /// Motion is inhibited: the controller refuses instructions of this tick that would begin motion.
    fn is_inhibited(&mut self) -> bool;
    /// The next stop that has more commands before it than this tick takes.
    fn next_overtaking(&mut self) -> Option<Overtaking>;
    /// The number of commands ever taken before the newest one of [`Port::next_command`], without stops.
    fn taken_before(&self) -> u64;
    /// The next command, if there is one.
    fn next_command(&mut self) -> Option<Command>;
    /// The status of the motion control tag directly after the execution of an instruction.
    fn answer(&mut self, ticket: Ticket, control: MotionControl);
    /// A change of an instruction's status.
    fn event(&mut self, event: &Event);
    /// The faults of an axis changed.
    fn fault_change(&mut self, change: &FaultChange);
    /// An instruction wrote to a tag.
    fn instruction_write(&mut self, write: &InstructionWrite);
    /// A coordinated move was accepted.
    fn accepted(&mut self, accepted: &AcceptedMove);
    /// The memory for the state at the end of this tick; `None` if no snapshot is wanted.
    fn snapshot(&mut self) -> Option<&mut Snapshot>;
    /// Publishes the filled snapshot.
    fn publish(&mut self);
    /// An empty request for the planning of a contour; `None` if no request can be taken now.
    fn contour_request(&mut self) -> Option<&mut ContourRequest>;
    /// Submits the filled request.
    fn submit_contour(&mut self);
    /// The next planned contour.
    fn planned_contour(&mut self) -> Option<PlannedContour>;
    /// Takes a trajectory to free it outside the tick.
    ///
    /// # Errors
    /// The trajectory, if it cannot be taken now: the controller offers it again.
    fn retire(&mut self, trajectory: Arc<Trajectory>) -> Result<(), Arc<Trajectory>>;
}

/// The answer to a [`ContourRequest`].
#[derive(Debug)]
pub struct PlannedContour {
    /// Index of the coordinate system.
    pub system: SystemId,
    /// The generation of the request.
    pub generation: u32,
    /// The plan; `None`: the planner found none.
    pub trajectory: Option<Arc<Trajectory>>,
}

/// A machine under control. The number of the tick is its only time, so a run can be repeated exactly.
#[derive(Debug)]
pub struct Controller {
    motion: Motion,
    drives: Box<dyn Drives>,
    next_tick: u64,
    overtaken: Overtaken,
    /// The newest series with a failed move.
    failed: Option<Series>,
}

/// Planned contours that one tick takes.
const MAX_CONTOURS_PER_TICK: usize = 4;
/// Requests to stop that one tick takes: one for all axes, and one for each axis.
const MAX_STOPS_PER_TICK: usize = machine::MAX_AXES + 1;
/// Commands that one tick takes; the rest wait for the next one.
pub const MAX_COMMANDS_PER_TICK: usize = 64;
/// Overtaking stops among them: a limit, so that stops alone never keep other commands from the controller.
const MAX_OVERTAKING_PER_TICK: usize = 16;

impl Controller {
    /// The machine as configured with simulated drives, at rest, before tick 0. The only allocation.
    pub fn new(machine: &Machine) -> Self {
        Controller::with_drives(machine, Box::new(simulated(machine)))
    }

    /// The machine with specific drives, in the order of its axes, at rest, before tick 0.
    pub fn with_drives(machine: &Machine, drives: Box<dyn Drives>) -> Self {
        Controller {
            motion: Motion::new(machine),
            drives,
            next_tick: 0,
            overtaken: Overtaken::default(),
            failed: None,
        }
    }

    /// Starts before a later tick, for tests: counters of ticks approach their end after weeks.
    #[must_use]
    pub fn starting_at(mut self, tick: u64) -> Self {
        self.next_tick = tick;
        self
    }

    /// Executes one coarse update: the complete work of the real-time thread in a tick.
    ///
    /// Real-time: no allocation, lock, I/O, log or clock; bounded by the machine and [`MAX_COMMANDS_PER_TICK`].
    pub fn tick(&mut self, port: &mut impl Port) {
        self.begin_tick();
        for _ in 0..MAX_CONTOURS_PER_TICK {
            let Some(planned) = port.planned_contour() else { break };
            self.install_contour(planned);
        }
        self.take_commands(port);
        if let Some(request) = port.contour_request()
            && self.next_contour(request)
        {
            port.submit_contour();
        }
        while let Some(trajectory) = self.motion.retired_contour() {
            if let Err(trajectory) = port.retire(trajectory) {
                self.motion.keep_retired(trajectory);
                break;
            }
        }
        self.show(port);
    }

    /// Takes the waiting stops and commands, in the order of a tick. Returns true if there were any. Real-time, bounded by
    /// [`MAX_COMMANDS_PER_TICK`].
    pub fn take_commands(&mut self, port: &mut impl Port) -> bool {
        let mut any = false;
        for _ in 0..MAX_STOPS_PER_TICK {
            match port.next_stop() {
                Some(StopRequest::All) => self.stop_all(),
                Some(StopRequest::Jog { axis, ticket, why }) => self.end_jog(axis, ticket, why),
                None => break,
            }
            any = true;
        }
        self.inhibit(port.is_inhibited());
        let overtaking = self.take_overtaking(port);
        any |= overtaking > 0;
        for _ in overtaking..MAX_COMMANDS_PER_TICK {
            let Some(command) = port.next_command() else { break };
            let taken_before = port.taken_before();
            self.take(command, taken_before, port);
            any = true;
        }
        if port.was_sent_before_stop() {
            self.stop_all();
        }
        any
    }

    /// Reports the changes of the tick so far, and its state. Real-time as far as the port is.
    pub fn show(&mut self, port: &mut impl Port) {
        self.accepted_moves(|accepted| port.accepted(accepted));
        self.take_fault_changes(|change| port.fault_change(change));
        self.end_tick(|event| port.event(event));
        self.take_instruction_writes(|write| port.instruction_write(write));
        if let Some(snapshot) = port.snapshot() {
            self.snapshot(snapshot);
            port.publish();
        }
    }

    /// Takes the overtaking stops, and returns their number. Real-time.
    fn take_overtaking(&mut self, port: &mut impl Port) -> usize {
        for number in 0..MAX_OVERTAKING_PER_TICK {
            let Some(Overtaking { command, sent_before }) = port.next_overtaking() else {
                return number;
            };
            if let Command::Call(_, call) | Command::CallWith(_, call, _) = &command {
                self.overtaken.note(self.motion.axes_of(call), sent_before);
            }
            self.take(command, u64::MAX, port);
        }
        MAX_OVERTAKING_PER_TICK
    }

    /// Executes a command; `taken_before`: the number of commands taken before it. Real-time.
    fn take(&mut self, command: Command, taken_before: u64, port: &mut impl Port) {
        match command {
            Command::Call(ticket, call) | Command::CallWith(ticket, call, _)
                if self
                    .overtaken
                    .refuses(&call, taken_before, || self.motion.axes_of(&call)) =>
            {
                let control = self.motion.refuse_call(ticket, &call, MotionError::ExecutionCollision);
                port.answer(ticket, control);
            }
            Command::Call(ticket, call) => {
                let control = self.execute(ticket, &call);
                port.answer(ticket, control);
            }
            Command::CallWith(ticket, call, data) => {
                let control = self.execute_with(ticket, &call, Some(data));
                port.answer(ticket, control);
            }
            Command::CallOfSeries(ticket, call, series) => {
                let control = self.execute_of_series(ticket, &call, series, taken_before);
                port.answer(ticket, control);
            }
            Command::RungFalse(control) => self.rung_false(control),
            Command::Override { system, rate } => self.set_override(system, rate),
            Command::Set(setting) => self.set(setting),
            Command::Inject { axis, causes } => self.inject(axis, causes),
            Command::Input(input) => self.input(input),
            Command::StopAll => self.stop_all(),
        }
    }

    /// Advances the machine to the next tick; the first call begins tick 0. Real-time.
    pub fn begin_tick(&mut self) {
        self.motion.begin(self.next_tick, self.drives.as_mut());
        self.next_tick += 1;
    }

    /// Begins the next tick in which something may happen, at most `most` ticks later, and passes over the uneventful ones before it: they change
    /// only the motion of the axes, and report nothing. The state is the same as after all these ticks one by one. Returns their number.
    pub fn begin_tick_after(&mut self, most: u64) -> u64 {
        let passed = self.motion.begin_after(self.next_tick, most, self.drives.as_mut());
        self.next_tick += passed + 1;
        passed
    }

    /// Executes an instruction at the present tick and returns the status of its motion control tag. Real-time.
    pub fn execute(&mut self, ticket: Ticket, call: &Call) -> MotionControl {
        self.motion.execute(ticket, call)
    }

    /// As [`Controller::execute`], with the data of the instruction that stand in tags. Real-time.
    pub fn execute_with(&mut self, ticket: Ticket, call: &Call, data: Option<CallData>) -> MotionControl {
        self.motion.execute_with(ticket, call, data)
    }

    /// Executes a move of a series; `taken_before`: the number of commands taken before it. Real-time.
    fn execute_of_series(&mut self, ticket: Ticket, call: &Call, series: Series, taken_before: u64) -> MotionControl {
        if self.failed == Some(series) {
            return MotionControl::refused(MotionError::ExecutionCollision);
        }
        let control = if !self.has_room(call) {
            MotionControl::refused(MotionError::CoordinateSystemQueueFull)
        } else if self.overtaken.refuses(call, taken_before, || self.motion.axes_of(call)) {
            self.motion.refuse_call(ticket, call, MotionError::ExecutionCollision)
        } else {
            self.execute(ticket, call)
        };
        if control.has(Flag::Er) {
            self.failed = Some(series);
        }
        control
    }

    /// Handles a false rung condition. Real-time.
    pub fn rung_false(&mut self, control: ControlSlot) {
        self.motion.rung_false(control);
    }

    /// Sets the override of a coordinate system: see [`Motion::set_override`]. Real-time.
    pub fn set_override(&mut self, system: SystemId, rate: f64) {
        self.motion.set_override(system, rate);
    }

    /// Sets an attribute of an axis or a coordinate system: see [`Motion::set`]. Real-time.
    pub fn set(&mut self, setting: Setting) {
        self.motion.set(setting);
    }

    /// Injects causes of faults into an axis: see [`Motion::inject`]. Real-time.
    pub fn inject(&mut self, axis: AxisId, causes: FaultSet) {
        self.motion.inject(axis, causes);
    }

    /// Takes a value written to a tag that the machine reads. Real-time.
    pub fn input(&mut self, input: Input) {
        self.motion.input(input, self.drives.as_mut());
    }

    /// Stops all motion, each axis separately. Real-time.
    pub fn stop_all(&mut self) {
        self.motion.stop_all();
    }

    /// Starts or ends the refusal of instructions that would begin motion: see [`Motion::inhibit`]. Real-time.
    pub fn inhibit(&mut self, is_inhibited: bool) {
        self.motion.inhibit(is_inhibited);
    }

    /// Stops the jog that an instruction began on an axis, at full deceleration: see [`Motion::end_jog`]. Real-time.
    pub fn end_jog(&mut self, axis: AxisId, ticket: Ticket, why: JogEnd) {
        self.motion.end_jog(axis, ticket, why);
    }

    /// Fills a request for the next contour to plan; returns false if there is none. Real-time.
    pub fn next_contour(&mut self, request: &mut ContourRequest) -> bool {
        self.motion.next_contour(request)
    }

    /// Starts a planned contour at the present tick, if it is still wanted. Real-time.
    pub fn install_contour(&mut self, planned: PlannedContour) {
        let PlannedContour {
            system,
            generation,
            trajectory,
        } = planned;
        self.motion.install_contour(system, generation, trajectory);
    }

    /// Plans every waiting contour at once. Not bounded: for a virtual clock.
    pub fn plan_contours(&mut self, request: &mut ContourRequest) {
        while self.next_contour(request) {
            self.install_contour(PlannedContour {
                system: request.system,
                generation: request.generation,
                trajectory: request.plan(),
            });
        }
        while self.motion.retired_contour().is_some() {}
    }

    /// The coordinated moves accepted since the last call, in order. Real-time as far as `report` is.
    pub fn accepted_moves(&mut self, report: impl FnMut(&AcceptedMove)) {
        self.motion.accepted_moves(report);
    }

    /// Ends the tick and reports the changes, in order. Real-time as far as `report` is.
    pub fn end_tick(&mut self, report: impl FnMut(&Event)) {
        self.motion.finish(report);
    }

    /// Reports the changes of faults in the tick that ends; to be called once a tick. Real-time as far as `report` is.
    pub fn take_fault_changes(&mut self, report: impl FnMut(&FaultChange)) {
        self.motion.take_fault_changes(report);
    }

    /// Reports the writes of instructions to tags in the tick that ended. Real-time as far as `report` is.
    pub fn take_instruction_writes(&mut self, report: impl FnMut(&InstructionWrite)) {
        self.motion.take_instruction_writes(report);
    }

    /// The queue of the coordinate system has room for the instruction.
    pub fn has_room(&self, call: &Call) -> bool {
        self.motion.has_room(call)
    }

    /// The queue of a coordinate system has room for another move.
    pub fn has_place(&self, system: Option<u16>) -> bool {
        self.motion.has_place(system)
    }

    /// No motion is under way that would end on its own.
    pub fn at_rest(&self) -> bool {
        self.motion.at_rest()
    }

    /// No axis moves, and none will before another instruction is executed.
    pub fn is_still(&self) -> bool {
        self.motion.is_still()
    }

    /// The present tick.
    pub fn tick_number(&self) -> u64 {
        self.motion.tick()
    }

    /// The status that a motion control tag shows at the present tick.
    pub fn control(&self, slot: ControlSlot) -> MotionControl {
        self.motion.control(slot)
    }

    /// Command position, velocity and acceleration, and actual position, of every axis in configuration order.
    pub fn trace(&self) -> impl Iterator<Item = [f64; 4]> {
        self.motion.trace()
    }

    /// The tool positions of the robots, of every coordinate system in configuration order (see [`crate::SystemSnapshot::tool`]).
    pub fn tools(&self) -> impl Iterator<Item = Option<[f64; 3]>> {
        self.motion.systems().map(|system| system.tool)
    }

    /// Fills a snapshot with the state at the present tick. Real-time if the snapshot was created for this machine.
    pub fn snapshot(&self, snapshot: &mut Snapshot) {
        self.update(snapshot, None);
    }

    /// The same for a snapshot that shows an earlier tick, `since`: axes that are the same as then stay as they are. Returns the others. Real-time.
    pub fn update(&self, snapshot: &mut Snapshot, since: Option<u64>) -> AxisSet {
        let mut changed = AxisSet::default();
        snapshot.tick = self.motion.tick();
        snapshot.lost_events = self.motion.lost_events();
        for (id, axis) in self.motion.axes_since(since) {
            if let Some(shown) = snapshot.axes.get_mut(id.index()) {
                *shown = axis;
                changed.insert(id);
            }
        }
        for (shown, system) in snapshot.systems.iter_mut().zip(self.motion.systems()) {
            *shown = system;
        }
        changed
    }
}
