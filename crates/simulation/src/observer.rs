//! The reports of a simulation.

use arcline_controller::image::Image;
use arcline_controller::machine::Machine;
use arcline_controller::{Controller, Event, FaultChange, InstructionWrite, Ticket};
use arcline_instruction_set::Call;

/// Observes a simulation, tick by tick. In a tick, its methods are called in the order of their definition.
pub trait Observer {
    /// Before the first tick.
    fn begin(&mut self, machine: &Machine) {
        let _ = machine;
    }
    /// An instruction was accepted in this tick.
    fn accepted(&mut self, ticket: Ticket, call: &Call) {
        let _ = (ticket, call);
    }
    /// A change of the faults of an axis, s after the beginning.
    fn fault(&mut self, change: &FaultChange, time: f64, machine: &Machine) {
        let _ = (change, time, machine);
    }
    /// A write of an instruction to a tag: stores it in the tag memory.
    fn instruction_written(&mut self, write: &InstructionWrite, image: &mut Image) {
        image.apply_instruction_write(write);
    }
    /// A change of an instruction's status, s after the beginning.
    fn event(&mut self, event: &Event, time: f64, image: &Image) {
        let _ = (event, time, image);
    }
    /// It must see every tick. Otherwise [`Observer::tick`] is called only after those in which something may have happened besides the motion
    /// of moves that are under way.
    fn needs_every_tick(&self) -> bool {
        true
    }
    /// The state at the end of a tick. False ends the run.
    fn tick(&mut self, tick: u64, machine: &Machine, controller: &mut Controller) -> bool {
        let _ = (tick, machine, controller);
        true
    }
}

/// Ignores all reports.
#[derive(Clone, Copy, Debug, Default)]
pub struct Blind;

impl Observer for Blind {
    fn needs_every_tick(&self) -> bool {
        false
    }
}
