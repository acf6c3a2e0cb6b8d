//! Commands on their way to the controller: through the ring, or waiting for room in it. The machine and its tags bound the number that waits.

use std::collections::{BTreeSet, VecDeque};
use std::sync::Arc;

use arcline_controller::image::CallRoom;
use arcline_controller::{Command, Input, MAX_COMMANDS_PER_TICK, Series, Ticket};
use arcline_instruction_set::{AxisId, Call, ControlSlot, FaultSet, Mnemonic, SystemId};
use arcline_realtime::STOPS;
use tokio::sync::oneshot;

use super::State;
use crate::plant::principal::Principal;
use crate::plant::records::Origin;

/// Commands that found no room in the ring and are sent as soon as there is some: each at most once, the newest in place of older ones,
/// so that they are bounded by the machine and its tags. Overrides and injected faults that wait are those that differ from the sent ones.
#[derive(PartialEq, Debug, Default)]
pub(super) struct WaitingCommands {
    /// Rung conditions that are false.
    rungs: BTreeSet<ControlSlot>,
    /// Writes of tags that the machine reads.
    inputs: VecDeque<Input>,
    overrides: bool,
    injected: bool,
    settings: bool,
}

impl WaitingCommands {
    fn input(&mut self, input: Input) {
        let same = self.inputs.iter_mut().find(|waiting| is_of_the_same(waiting, &input));
        match same {
            Some(waiting) => *waiting = input,
            None => self.inputs.push_back(input),
        }
    }
}

/// The order in which commands go to the controller.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Lane {
    /// Ahead of the others where more of them wait than one tick takes.
    Stops,
    /// In the order of their arrival.
    Others,
}

impl Lane {
    /// The lane of an instruction, and of its false rung conditions.
    fn of(mnemonic: Mnemonic) -> Self {
        match mnemonic.is_stop() {
            true => Lane::Stops,
            false => Lane::Others,
        }
    }
}

/// Whether two inputs are of the same axis, registration input or word.
fn is_of_the_same(one: &Input, other: &Input) -> bool {
    match (one, other) {
        (Input::Position { axis: one, .. }, Input::Position { axis: other, .. }) => one == other,
        (
            Input::Registration {
                axis: one, input: on, ..
            },
            Input::Registration { axis, input, .. },
        ) => (one, on) == (axis, input),
        (Input::HomeSwitch { axis: one, .. }, Input::HomeSwitch { axis: other, .. })
        | (Input::Enable { axis: one, .. }, Input::Enable { axis: other, .. }) => one == other,
        (Input::Word { tag: one, .. }, Input::Word { tag: other, .. }) => one == other,
        _ => false,
    }
}

impl State {
    /// A series of the moves that are sent next.
    pub(in crate::plant) fn series(&self) -> Series {
        Series(Ticket(self.next_ticket))
    }

    /// The number of moves that a coordinate system can still take, as far as the snapshot shows.
    pub(in crate::plant) fn queue_room(&mut self, system: SystemId) -> usize {
        let snapshot = self.link.snapshots.output_buffer();
        let shown = snapshot
            .systems
            .get(system.index())
            .map_or(0, |system| system.queue_room);
        let shown = usize::try_from(shown).unwrap_or(usize::MAX);
        // Each waiting call may be a move of this system. The plant sends one move all the same, since calls of other clients may always wait.
        shown.saturating_sub(self.waiting.len()).max(shown.min(1))
    }

    /// Sends a call; the receiver has its answer when DN, ER or IP is set.
    pub(in crate::plant) fn send(
        &mut self,
        principal: Principal,
        text: Option<Arc<str>>,
        call: Call,
        series: Option<Series>,
    ) -> (Ticket, oneshot::Receiver<()>) {
        let lane = Lane::of(call.mnemonic);
        if self.waiting_commands.rungs.remove(&call.control) {
            // The false rung condition is sent before it is true again.
            self.push(lane, Command::RungFalse(call.control));
        }
        let ticket = self.ticket(principal, text, call.target);
        let (sender, receiver) = oneshot::channel();
        self.waiting.insert(ticket, sender);
        let (data, staged) = self.image_mut().prepare(&call);
        if let Some(staged) = staged {
            self.staged.insert(ticket, staged);
        }
        let command = match (data, series) {
            (None, None) => Command::Call(ticket, call),
            (None, Some(series)) => Command::CallOfSeries(ticket, call, series),
            (Some(data), _) => Command::CallWith(ticket, call, data),
        };
        self.push(lane, command);
        self.motion_tickets.note(ticket, &call, &self.records);
        self.own(principal.owner(), ticket, &call);
        (ticket, receiver)
    }

    /// Notes the owner of a call, as far as an owner can be lost.
    fn own(&mut self, owner: Principal, ticket: Ticket, call: &Call) {
        if owner.session().is_none() {
            return;
        }
        self.owned.begin(owner, ticket, call, &self.records);
        if let (Mnemonic::Maj, Some(axis)) = (call.mnemonic, call.target) {
            let records = &self.records;
            self.guard
                .begin(owner, AxisId(axis), ticket, |ticket| records.may_run(ticket));
        }
    }

    pub(super) fn ticket(&mut self, principal: Principal, text: Option<Arc<str>>, target: Option<u16>) -> Ticket {
        let ticket = Ticket(self.next_ticket);
        self.next_ticket += 1;
        let client = principal.session().map(|session| self.guard.identity_of(session));
        let origin = Origin {
            principal,
            client: client.unwrap_or_default(),
            text,
        };
        self.records.begin(ticket, target, origin);
        ticket
    }

    /// The number of instructions that the plant can still send; those that only stop or switch off have room of their own.
    pub(in crate::plant) fn room(&self) -> CallRoom {
        let waiting = self.waiting.len();
        let calls = OUTSTANDING.saturating_sub(waiting);
        let stops = (OUTSTANDING + FOR_STOPS).saturating_sub(waiting);
        CallRoom {
            calls: calls.min(self.link.commands.slots().saturating_sub(RESERVE)),
            // A false rung condition may go ahead of each.
            stops: stops.min(self.link.commands.stop_slots() / 2),
        }
    }

    /// Whether the plant can send an instruction.
    pub(in crate::plant) fn has_room(&self, mnemonic: Mnemonic) -> bool {
        let CallRoom { calls, stops } = self.room();
        if mnemonic.is_stop() { stops > 0 } else { calls > 0 }
    }

    /// Sends a command for which there is room.
    fn push(&mut self, lane: Lane, command: Command) {
        let sent = match lane {
            Lane::Stops => self.link.commands.push_stop(command),
            Lane::Others => self.link.commands.push(command),
        };
        if let Err(error) = sent {
            tracing::error!(%error, "a command is lost");
        }
    }

    /// Whether the ring has room for a command that can wait.
    fn has_room_to_wait(&self, lane: Lane) -> bool {
        match lane {
            Lane::Stops => self.link.commands.stop_slots() > 0,
            Lane::Others => self.link.commands.slots() > RESERVE,
        }
    }

    /// Sends the commands that wait for room.
    pub(in crate::plant) fn flush(&mut self) {
        while self.has_room_to_wait(Lane::Others)
            && let Some(control) = self.waiting_commands.rungs.pop_first()
        {
            self.push(Lane::Others, Command::RungFalse(control));
        }
        while self.has_room_to_wait(Lane::Others)
            && let Some(input) = self.waiting_commands.inputs.pop_front()
        {
            self.push(Lane::Others, Command::Input(input));
        }
        if self.waiting_commands.overrides {
            self.send_overrides();
        }
        if self.waiting_commands.injected {
            self.send_injected();
        }
        if self.waiting_commands.settings {
            self.send_settings();
        }
    }

    /// Whether a call waits for an answer or a command for room.
    pub(in crate::plant) fn is_busy(&self) -> bool {
        !self.waiting.is_empty() || self.waiting_commands != WaitingCommands::default()
    }

    /// The rung condition of an instruction is false. It never overtakes the instruction, which was sent before.
    pub(in crate::plant) fn rung_false(&mut self, mnemonic: Mnemonic, control: ControlSlot) {
        let lane = Lane::of(mnemonic);
        if self.has_room_to_wait(lane) {
            self.waiting_commands.rungs.remove(&control);
            self.push(lane, Command::RungFalse(control));
        } else {
            self.waiting_commands.rungs.insert(control);
        }
    }

    /// Sends a written input, behind those that wait.
    pub(in crate::plant) fn send_input(&mut self, input: Input) {
        if self.waiting_commands.inputs.is_empty() && self.has_room_to_wait(Lane::Others) {
            self.push(Lane::Others, Command::Input(input));
        } else {
            self.waiting_commands.input(input);
        }
    }

    /// Sends the changed overrides to the controller.
    pub(in crate::plant) fn send_overrides(&mut self) {
        self.waiting_commands.overrides = false;
        let overrides: Vec<f32> = self.image.feed_overrides().collect();
        for (place, now) in overrides.into_iter().enumerate() {
            if self.overrides.get(place).is_none_or(|sent| *sent == now) {
                continue;
            }
            if !self.has_room_to_wait(Lane::Others) {
                self.waiting_commands.overrides = true;
                return;
            }
            self.overrides[place] = now;
            self.push(
                Lane::Others,
                Command::Override {
                    system: SystemId::from_index(place),
                    rate: f64::from(now) / 100.0,
                },
            );
        }
    }

    /// Sends the changed injected causes of faults to the controller.
    pub(super) fn send_injected(&mut self) {
        self.waiting_commands.injected = false;
        let injected: Vec<FaultSet> = self.image.injected_faults().collect();
        for (place, causes) in injected.into_iter().enumerate() {
            if self.injected.get(place).is_none_or(|sent| *sent == causes) {
                continue;
            }
            if !self.has_room_to_wait(Lane::Others) {
                self.waiting_commands.injected = true;
                return;
            }
            self.injected[place] = causes;
            self.push(
                Lane::Others,
                Command::Inject {
                    axis: AxisId::from_index(place),
                    causes,
                },
            );
        }
    }

    /// Sends the controller the attributes that were set.
    pub(super) fn send_settings(&mut self) {
        self.waiting_commands.settings = false;
        for place in 0..self.settings.len() {
            let setting = match self.image.settings().get(place) {
                Some(setting) if *setting != self.settings[place] => *setting,
                _ => continue,
            };
            if !self.has_room_to_wait(Lane::Others) {
                self.waiting_commands.settings = true;
                return;
            }
            self.settings[place] = setting;
            self.push(Lane::Others, Command::Set(setting));
        }
    }
}

/// Calls that may wait for the controller at a time.
pub(in crate::plant) const OUTSTANDING: usize = 512;
/// Calls that may wait besides if they only stop or switch off.
const FOR_STOPS: usize = STOPS / 2;
/// Room of the ring for false rung conditions that go ahead of their instruction: the number that the controller takes in two ticks.
const RESERVE: usize = 2 * MAX_COMMANDS_PER_TICK;
