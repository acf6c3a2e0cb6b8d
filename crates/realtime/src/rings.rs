//! The rings across the border of the thread: bounded rings for commands, answers and events, a triple buffer for
//! snapshots. Neither side waits: the sender handles a full ring, or counts a loss.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use arcline_controller::machine::Machine;
use arcline_controller::{
    AcceptedMove, Command, ContourRequest, Event, FaultChange, InstructionWrite, Overtaking, PlannedContour, Port,
    Snapshot, StopRequest, Ticket, Trajectory,
};
use arcline_instruction_set::MotionControl;

use crate::clock::Stepper;
use crate::commands::{self, COMMANDS, CommandReceiver, CommandSender, STOPS};
use crate::contour::{self, Contours, Planning};
use crate::meter::Meter;
use crate::samples::{self, SampleSender, Samples};
use crate::stops::{self, StopReceiver, Stops};

/// Most events that can wait for their reader; one tick can cause as many.
pub const EVENTS: usize = 16_384;
/// Most changes of faults that can wait for their reader.
const FAULT_CHANGES: usize = 4096;
/// Most writes to tags that can wait for their reader.
const INSTRUCTION_WRITES: usize = 4096;
/// Most accepted moves that can wait for their reader; further ones are not shown.
pub const ACCEPTED: usize = 2048;

/// The status of an instruction's tag directly after its execution.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Answer {
    /// The tick of the execution.
    pub tick: u64,
    /// The execution.
    pub ticket: Ticket,
    /// The status of its tag.
    pub control: MotionControl,
}

/// The ends of the server.
///
/// All reports of a tick are in their rings before its snapshot is published: a reader who takes a
/// snapshot and then all answers and events up to its tick has the state of that one tick.
#[derive(Debug)]
pub struct ServerRings {
    /// Commands to the controller.
    pub commands: CommandSender,
    /// Requests to stop, which precede all commands.
    pub stops: Stops,
    /// One answer for every call, in the order in which they were executed.
    pub answers: rtrb::Consumer<Answer>,
    /// Changes of instructions, in order.
    pub events: rtrb::Consumer<Event>,
    /// Changes of the faults of axes, in order.
    pub fault_changes: rtrb::Consumer<FaultChange>,
    /// Writes of instructions to arrays, in order.
    pub instruction_writes: rtrb::Consumer<InstructionWrite>,
    /// Accepted coordinated moves, in order.
    pub accepted: rtrb::Consumer<AcceptedMove>,
    /// A row of samples for every tick; `None` once a reader has taken it.
    pub samples: Option<Samples>,
    /// The newest snapshot.
    pub snapshots: triple_buffer::Output<Snapshot>,
    /// The thread's measurements.
    pub meter: Arc<Meter>,
    /// The end of the planning thread, if the machine has planned contours.
    pub planning: Option<Planning>,
    /// Executes ticks, on the step clock.
    pub stepper: Option<Stepper>,
}

/// The controller's ends.
#[derive(Debug)]
pub struct Rings {
    commands: CommandReceiver,
    stops: StopReceiver,
    /// Number of commands in the ring that were sent before the newest stop of all axes.
    before_stop: usize,
    /// This tick has taken one of them.
    took_before_stop: bool,
    answers: rtrb::Producer<Answer>,
    events: rtrb::Producer<Event>,
    fault_changes: rtrb::Producer<FaultChange>,
    instruction_writes: rtrb::Producer<InstructionWrite>,
    accepted: rtrb::Producer<AcceptedMove>,
    samples: SampleSender,
    snapshots: triple_buffer::Input<Snapshot>,
    pub(crate) meter: Arc<Meter>,
    /// The tick that is under way or next.
    pub(crate) tick: u64,
    stop: Stop,
    contours: Option<Contours>,
    /// The clock is stepped: a tick may be shown several times, and its samples are sent at its end.
    is_stepped: bool,
    /// The state of the tick as last shown, on the step clock.
    shown: Snapshot,
}

/// The progress of a final stop.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stop {
    No,
    /// The next command is a stop of all axes.
    Asked,
    /// No more commands are taken.
    Under,
}

/// The full rings. That of answers is never full: a call without room for its answer is not sent.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct FullRings {
    /// The ring of commands.
    pub commands: bool,
    /// The ring of changes of instructions.
    pub events: bool,
    /// The ring of samples.
    pub samples: bool,
}

/// The room in the rings.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Room {
    /// Commands.
    pub commands: usize,
    /// Additional stops.
    pub stops: usize,
    /// Changes of instructions.
    pub events: usize,
    /// Samples, as time, ns.
    pub samples_ns: u64,
}

/// The room in the server.
impl Default for Room {
    fn default() -> Self {
        Room {
            commands: COMMANDS,
            stops: STOPS,
            events: EVENTS,
            samples_ns: samples::WAITING_NS,
        }
    }
}

/// Rings for the controller of a machine. The only allocation.
pub fn link(machine: &Machine) -> (Rings, ServerRings) {
    rings_with(machine, Room::default())
}

/// Rings with another room, to simulate full rings.
pub fn rings_with(machine: &Machine, room: Room) -> (Rings, ServerRings) {
    let (command_sender, commands) = commands::link(room.commands, room.stops);
    // All commands in the ring may be answered before a reader takes an answer.
    let (answers, answer_receiver) = rtrb::RingBuffer::new(2 * (room.commands + room.stops));
    let (events, event_receiver) = rtrb::RingBuffer::new(room.events);
    let (fault_changes, fault_change_receiver) = rtrb::RingBuffer::new(FAULT_CHANGES);
    let (instruction_writes, instruction_write_receiver) = rtrb::RingBuffer::new(INSTRUCTION_WRITES);
    let (accepted, accepted_receiver) = rtrb::RingBuffer::new(ACCEPTED);
    let (samples, sample_receiver) = samples::link(machine, room.samples_ns);
    let (stop_receiver, stops) = stops::link(machine.axes.len());
    let (snapshots, snapshot_output) = triple_buffer::triple_buffer(&Snapshot::new(machine));
    let meter = Arc::new(Meter::default());
    let (contours, planning) = contour::link(machine).unzip();
    let rings = Rings {
        commands,
        stops: stop_receiver,
        before_stop: 0,
        took_before_stop: false,
        answers,
        events,
        fault_changes,
        instruction_writes,
        accepted,
        samples,
        snapshots,
        meter: meter.clone(),
        tick: 0,
        stop: Stop::No,
        contours,
        is_stepped: false,
        shown: Snapshot::new(machine),
    };
    let link = ServerRings {
        commands: command_sender,
        stops,
        answers: answer_receiver,
        events: event_receiver,
        fault_changes: fault_change_receiver,
        instruction_writes: instruction_write_receiver,
        accepted: accepted_receiver,
        samples: Some(sample_receiver),
        snapshots: snapshot_output,
        meter,
        planning,
        stepper: None,
    };
    (rings, link)
}

impl Rings {
    /// Sets the first tick, as for the controller ([`Controller::starting_at`](arcline_controller::Controller::starting_at)).
    #[must_use]
    pub fn starting_at(mut self, tick: u64) -> Self {
        self.tick = tick;
        self
    }

    /// The full rings.
    pub fn full(&self) -> FullRings {
        FullRings {
            commands: self.commands.is_full(),
            events: self.events.is_full(),
            samples: !self.samples.has_room(),
        }
    }

    /// Makes the controller take one more command, a stop of all axes, and no other.
    pub fn stop(&mut self) {
        if self.stop == Stop::No {
            self.stop = Stop::Asked;
        }
    }

    /// For the step clock: a tick is shown whenever it changes, and ends at [`Rings::close`].
    pub(crate) fn set_stepped(&mut self) {
        self.is_stepped = true;
        // Contours are planned in the tick.
        self.contours = None;
    }

    /// Ends the tick that was last shown: sends its samples.
    pub(crate) fn close(&mut self) {
        if !self.samples.send(&self.shown) {
            self.meter.lose_samples();
        }
        self.tick += 1;
    }

    /// Waits until the readers of samples and events have made room, at most a second: ticks faster than real time must not cause losses. Not for
    /// the real-time thread.
    pub(crate) fn wait_for_room(&self, ends: &AtomicBool) {
        for _ in 0..PATIENCE {
            if self.samples.has_room()
                && self.events.slots() > EVENTS / 2
                && self.fault_changes.slots() > FAULT_CHANGES / 2
            {
                return;
            }
            if ends.load(Ordering::Acquire) {
                return;
            }
            std::thread::sleep(Duration::from_micros(500));
        }
    }
}

/// Most pauses of half a millisecond.
const PATIENCE: u32 = 2000;

impl Port for Rings {
    fn next_stop(&mut self) -> Option<StopRequest> {
        let stop = self.stops.next();
        if stop == Some(StopRequest::All) {
            self.before_stop = self.commands.waiting();
        }
        stop
    }

    fn was_sent_before_stop(&mut self) -> bool {
        std::mem::take(&mut self.took_before_stop)
    }

    fn is_inhibited(&mut self) -> bool {
        self.stops.is_inhibited()
    }

    fn next_overtaking(&mut self) -> Option<Overtaking> {
        match self.stop {
            Stop::No => self.commands.overtaking(),
            Stop::Asked | Stop::Under => None,
        }
    }

    fn taken_before(&self) -> u64 {
        self.commands.taken().saturating_sub(1)
    }

    fn next_command(&mut self) -> Option<Command> {
        match self.stop {
            Stop::No => {
                let taken = self.commands.taken();
                let command = self.commands.next()?;
                // Stops begin no motion.
                if self.commands.taken() > taken {
                    self.took_before_stop |= self.before_stop > 0;
                    self.before_stop = self.before_stop.saturating_sub(1);
                }
                Some(command)
            }
            Stop::Asked => {
                self.stop = Stop::Under;
                Some(Command::StopAll)
            }
            Stop::Under => None,
        }
    }

    fn answer(&mut self, ticket: Ticket, control: MotionControl) {
        if self
            .answers
            .push(Answer {
                tick: self.tick,
                ticket,
                control,
            })
            .is_err()
        {
            self.meter.lose_answer();
        }
    }

    fn event(&mut self, event: &Event) {
        if self.events.push(*event).is_err() {
            self.meter.lose_event();
        }
    }

    fn fault_change(&mut self, change: &FaultChange) {
        if self.fault_changes.push(*change).is_err() {
            self.meter.lose_event();
        }
    }

    fn instruction_write(&mut self, write: &InstructionWrite) {
        if self.instruction_writes.push(*write).is_err() {
            self.meter.lose_event();
        }
    }

    fn accepted(&mut self, accepted: &AcceptedMove) {
        // Without room the move is not drawn, but it is executed.
        let _ = self.accepted.push(*accepted);
    }

    fn snapshot(&mut self) -> Option<&mut Snapshot> {
        Some(self.snapshots.input_buffer_mut())
    }

    fn publish(&mut self) {
        if !self.is_stepped && !self.samples.send(self.snapshots.input_buffer_mut()) {
            self.meter.lose_samples();
        }
        if self.is_stepped {
            self.shown.clone_from(self.snapshots.input_buffer_mut());
        }
        self.snapshots.publish();
        self.meter.publish();
    }

    fn contour_request(&mut self) -> Option<&mut ContourRequest> {
        self.contours.as_mut()?.request()
    }

    fn submit_contour(&mut self) {
        if let Some(contours) = &mut self.contours {
            contours.submit();
        }
    }

    fn planned_contour(&mut self) -> Option<PlannedContour> {
        self.contours.as_mut()?.planned()
    }

    fn retire(&mut self, trajectory: Arc<Trajectory>) -> Result<(), Arc<Trajectory>> {
        match &mut self.contours {
            Some(contours) => contours.retire(trajectory),
            None => Err(trajectory),
        }
    }
}
