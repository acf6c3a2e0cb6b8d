//! A tick with access to its snapshot: a simulation checks every tick, while a reader of the triple buffer sees only the newest one.

use std::sync::Arc;

use arcline_controller::{
    AcceptedMove, Command, ContourRequest, Controller, Event, FaultChange, InstructionWrite, Overtaking,
    PlannedContour, Port, Snapshot, StopRequest, Ticket, Trajectory,
};
use arcline_instruction_set::MotionControl;

use crate::rings::Rings;

/// As [`step`](crate::step); `see` gets the snapshot of the tick before it is published. Returns the number of changes of instructions and
/// faults that the tick has reported, whether or not the rings had room for them.
pub fn step_seen(controller: &mut Controller, rings: &mut Rings, see: &mut dyn FnMut(&Snapshot)) -> u64 {
    let mut tap = Tap {
        rings,
        see,
        reported: 0,
    };
    controller.tick(&mut tap);
    let reported = tap.reported;
    rings.tick += 1;
    reported
}

/// The rings, with access to each snapshot.
struct Tap<'r> {
    rings: &'r mut Rings,
    see: &'r mut dyn FnMut(&Snapshot),
    reported: u64,
}

impl Port for Tap<'_> {
    fn next_stop(&mut self) -> Option<StopRequest> {
        self.rings.next_stop()
    }

    fn was_sent_before_stop(&mut self) -> bool {
        self.rings.was_sent_before_stop()
    }

    fn is_inhibited(&mut self) -> bool {
        self.rings.is_inhibited()
    }

    fn next_overtaking(&mut self) -> Option<Overtaking> {
        self.rings.next_overtaking()
    }

    fn taken_before(&self) -> u64 {
        self.rings.taken_before()
    }

    fn next_command(&mut self) -> Option<Command> {
        self.rings.next_command()
    }

    fn answer(&mut self, ticket: Ticket, control: MotionControl) {
        self.rings.answer(ticket, control);
    }

    fn event(&mut self, event: &Event) {
        self.reported += 1;
        self.rings.event(event);
    }

    fn fault_change(&mut self, change: &FaultChange) {
        self.reported += 1;
        self.rings.fault_change(change);
    }

    fn instruction_write(&mut self, write: &InstructionWrite) {
        self.rings.instruction_write(write);
    }

    fn accepted(&mut self, accepted: &AcceptedMove) {
        self.rings.accepted(accepted);
    }

    fn snapshot(&mut self) -> Option<&mut Snapshot> {
        self.rings.snapshot()
    }

    fn publish(&mut self) {
        if let Some(snapshot) = self.rings.snapshot() {
            (self.see)(snapshot);
        }
        self.rings.publish();
    }

    fn contour_request(&mut self) -> Option<&mut ContourRequest> {
        self.rings.contour_request()
    }

    fn submit_contour(&mut self) {
        self.rings.submit_contour();
    }

    fn planned_contour(&mut self) -> Option<PlannedContour> {
        self.rings.planned_contour()
    }

    fn retire(&mut self, trajectory: Arc<Trajectory>) -> Result<(), Arc<Trajectory>> {
        self.rings.retire(trajectory)
    }
}
