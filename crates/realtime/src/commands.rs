//! Commands to the controller: one order, in two rings, so that a stop need not wait for the commands that were sent before it.
//!
//! Commands are taken in the order in which they were sent, [`MAX_COMMANDS_PER_TICK`] in a tick. A stop with more waiting commands before it
//! than one tick takes precedes them, and the controller refuses overtaken commands that would move the stopped axes. The order therefore never
//! changes while the controller keeps up. Not here: the choice of the instructions that are stops, and the refusal of overtaken commands.

use arcline_controller::{Command, MAX_COMMANDS_PER_TICK, Overtaking};

/// Most commands that can wait for the controller: those of 16 ticks, which limits the wait of a command.
pub const COMMANDS: usize = 16 * MAX_COMMANDS_PER_TICK;
/// Most stops that can wait in addition.
pub const STOPS: usize = COMMANDS / 2;

/// There is no room for a command; it was not sent.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Full;

impl std::fmt::Display for Full {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("too many commands wait for the controller")
    }
}

impl std::error::Error for Full {}

/// The sender's end.
#[derive(Debug)]
pub struct CommandSender {
    commands: rtrb::Producer<Command>,
    stops: rtrb::Producer<Overtaking>,
    /// Number of commands sent, without stops.
    sent: u64,
}

/// The controller's end.
#[derive(Debug)]
pub(crate) struct CommandReceiver {
    commands: rtrb::Consumer<Command>,
    stops: rtrb::Consumer<Overtaking>,
    /// Number of commands taken, without stops.
    taken: u64,
}

/// Both ends, for these numbers of commands and stops. The only allocation.
pub(crate) fn link(commands: usize, stops: usize) -> (CommandSender, CommandReceiver) {
    let (command_sender, commands) = rtrb::RingBuffer::new(commands);
    let (stop_sender, stops) = rtrb::RingBuffer::new(stops);
    let sender = CommandSender {
        commands: command_sender,
        stops: stop_sender,
        sent: 0,
    };
    let receiver = CommandReceiver {
        commands,
        stops,
        taken: 0,
    };
    (sender, receiver)
}

impl CommandSender {
    /// Sends a command that waits for those before it.
    ///
    /// # Errors
    /// There is no room.
    pub fn push(&mut self, command: Command) -> Result<(), Full> {
        self.commands.push(command).map_err(|_| Full)?;
        self.sent += 1;
        Ok(())
    }

    /// Sends a stop, or the false rung condition of one.
    ///
    /// # Errors
    /// There is no room.
    pub fn push_stop(&mut self, command: Command) -> Result<(), Full> {
        let overtaking = Overtaking {
            command,
            sent_before: self.sent,
        };
        self.stops.push(overtaking).map_err(|_| Full)
    }

    /// Room for further commands.
    pub fn slots(&self) -> usize {
        self.commands.slots()
    }

    /// Room for further stops.
    pub fn stop_slots(&self) -> usize {
        self.stops.slots()
    }
}

impl CommandReceiver {
    /// There is no room for another command.
    pub(crate) fn is_full(&self) -> bool {
        self.commands.slots() == self.commands.buffer().capacity()
    }

    /// Number of waiting commands, without stops. Real-time.
    pub(crate) fn waiting(&self) -> usize {
        self.commands.slots()
    }

    /// Number of commands taken, without stops. Real-time.
    pub(crate) fn taken(&self) -> u64 {
        self.taken
    }

    /// A stop with more waiting commands before it than a tick takes. Real-time.
    pub(crate) fn overtaking(&mut self) -> Option<Overtaking> {
        let sent_before = self.stops.peek().ok()?.sent_before;
        if sent_before.saturating_sub(self.taken) <= MAX_COMMANDS_PER_TICK as u64 {
            return None;
        }
        self.stops.pop().ok()
    }

    /// The next command in the order in which they were sent. Real-time.
    pub(crate) fn next(&mut self) -> Option<Command> {
        // Read first: a stop that was sent before a command that waits now is then seen below.
        let waits = self.commands.slots() > 0;
        if self.stops.peek().is_ok_and(|stop| stop.sent_before <= self.taken) {
            return self.stops.pop().ok().map(|stop| stop.command);
        }
        if !waits {
            return None;
        }
        let command = self.commands.pop().ok()?;
        self.taken += 1;
        Some(command)
    }
}

#[cfg(test)]
mod tests {
    use arcline_instruction_set::ControlSlot;

    use super::*;

    fn command(number: u32) -> Command {
        Command::RungFalse(ControlSlot(number))
    }

    fn slot(command: Option<Command>) -> Option<u32> {
        match command {
            Some(Command::RungFalse(slot)) => Some(slot.0),
            _ => None,
        }
    }

    #[test]
    fn while_the_controller_keeps_up_the_order_is_that_of_sending() {
        let (mut sender, mut receiver) = link(COMMANDS, STOPS);
        for number in 0..MAX_COMMANDS_PER_TICK as u32 {
            sender.push(command(number)).expect("room");
            sender.push_stop(command(1000 + number)).expect("room");
        }
        assert!(receiver.overtaking().is_none(), "one tick takes what is before them");
        for number in 0..MAX_COMMANDS_PER_TICK as u32 {
            assert_eq!(slot(receiver.next()), Some(number));
            assert_eq!(slot(receiver.next()), Some(1000 + number));
        }
        assert_eq!(slot(receiver.next()), None);
    }

    #[test]
    fn a_stop_overtakes_more_commands_than_a_tick_takes() {
        let (mut sender, mut receiver) = link(COMMANDS, STOPS);
        for number in 0..COMMANDS as u32 {
            sender.push(command(number)).expect("room");
        }
        assert!(
            sender.push(command(0)).is_err(),
            "the ring is full, and nothing counts it"
        );
        for number in 0..STOPS as u32 {
            sender.push_stop(command(number)).expect("there is room for stops");
        }
        assert!(sender.push_stop(command(0)).is_err());
        for number in 0..STOPS as u32 {
            let overtaking = receiver.overtaking().expect("it comes first");
            assert_eq!(overtaking.sent_before, COMMANDS as u64);
            assert_eq!(slot(Some(overtaking.command)), Some(number));
        }
        assert_eq!(slot(receiver.next()), Some(0));
    }
}
