//! The one entry for commands: every command of every interface goes through [`Plant::apply`], or through a [`Transaction`] where several
//! commands and reads are one action. Under one lock a command is authorized, written, sent to the writer of the retained state, and
//! queued for the controller with the operands as they are then. The caller waits for the answers without the lock.
//!
//! Only the stops that must wait for no lock do not take it: [`Plant::stop_all`], [`Plant::inhibit`] and the end of jogs of lost
//! clients (`crate::guard`).

use std::sync::Arc;

use arcline_config::Role;
use arcline_controller::image::{Image, ReadError, WriteEffect, WriteError};
use arcline_controller::{Series, Ticket, UNNAMED};
use arcline_instruction_set::{SystemId, bind};
use arcline_state::planted::is_planted;
use arcline_tag::{DataType, TagPath, Value};
use tokio::sync::oneshot;

use super::command::{Call, Command, Outcome, Refused, Systems};
use super::control::MotionObject;
use super::records::instance_of;
use super::series::{LONGEST_SERIES, SeriesEnd};
use super::state::State;
use super::{ANSWER_WITHIN, CallRefused, Executed, Plant, Principal, Right, Shared, policy};
use crate::retained::{NotPersisted, PersistedReceiver};

/// Commands and reads of one principal that are one action: nothing changes between them, and the controller is sent all effects at the
/// end.
pub struct Transaction<'t> {
    principal: Principal,
    /// The role of the principal as the transaction began.
    role: Role,
    /// The first right that was missing.
    denied: Option<Right>,
    shared: &'t Shared,
    state: &'t mut State,
    /// The effects of the writes so far, which the controller is not sent yet.
    effects: Vec<WriteEffect>,
    pending: Pending,
    /// Whether the transaction has changed a part of the retained state.
    retained: bool,
    /// The series that the instructions belong to.
    series: Option<Series>,
    is_packet: bool,
}

/// The instructions and writes of a transaction that are not answered or not in the file of the retained state yet.
#[derive(Debug, Default)]
#[must_use = "the writes may not be in the file of the retained state yet"]
pub struct Pending {
    /// The instructions that were sent.
    answers: Vec<(Ticket, oneshot::Receiver<()>)>,
    /// Is ready when the file of the retained state has all writes; `None`: no write belongs to the retained state.
    persisted: Option<PersistedReceiver>,
    /// The ticks that are to pass behind them for a principal, in their order.
    steps: Vec<(Principal, u32, Option<TagPath>)>,
}

impl Plant {
    /// Executes a command and waits until it is done: until an instruction shows DN, ER or IP (MAH sets DN at its end only), and until
    /// the file of the retained state has the writes.
    ///
    /// # Errors
    /// See [`Refused`].
    pub async fn apply(&self, principal: Principal, command: Command<'_>) -> Result<Outcome, Refused> {
        // Stops wait for no lock.
        match command {
            Command::StopAll => self.stop_all(),
            Command::Inhibit => self.inhibit(),
            command => return self.apply_locked(principal, command).await,
        }
        Ok(Outcome::Done)
    }

    async fn apply_locked(&self, principal: Principal, command: Command<'_>) -> Result<Outcome, Refused> {
        let (outcome, pending) = self.transact(principal, |transaction| transaction.apply(command));
        let is_answered = self.settle(pending).await;
        let outcome = outcome?;
        match outcome {
            Outcome::Begun(instance) => {
                let unanswered = matches!(is_answered, Err(Unsettled::NoAnswer));
                let control = self.instruction_instance(instance).filter(|_| !unanswered);
                let control = control.ok_or(CallRefused::NoAnswer)?;
                Ok(Outcome::Executed(Executed { instance, control }))
            }
            outcome => match is_answered {
                Err(Unsettled::NotPersisted) => Err(NotPersisted.into()),
                // Its tag says so.
                Err(Unsettled::NoAnswer) | Ok(()) => Ok(outcome),
            },
        }
    }

    /// Runs commands and reads as one action. [`Plant::complete`] waits for the pending answers and writes; a caller that does not wait drops them.
    pub fn transact<R>(&self, principal: Principal, work: impl FnOnce(&mut Transaction<'_>) -> R) -> (R, Pending) {
        let mut state = self.0.lock();
        state.refresh();
        let mut transaction = Transaction {
            principal,
            role: self.0.roles.of(principal),
            denied: None,
            shared: &self.0,
            state: &mut state,
            effects: Vec::new(),
            pending: Pending::default(),
            retained: false,
            series: None,
            is_packet: false,
        };
        transaction.update_room();
        let result = work(&mut transaction);
        let (denied, role) = (transaction.denied, transaction.role);
        let pending = transaction.finish();
        drop(state);
        self.0.sent.notify_one();
        if let Some(right) = denied {
            self.log_denied(principal, right, role);
        }
        (result, pending)
    }

    /// Waits until all instructions of a transaction are answered and the retained state has all writes; at most [`ANSWER_WITHIN`].
    ///
    /// # Errors
    /// [`NotPersisted`]: the tags have the written values, but may not have them after a restart.
    pub async fn complete(&self, pending: Pending) -> Result<(), NotPersisted> {
        match self.settle(pending).await {
            Err(Unsettled::NotPersisted) => Err(NotPersisted),
            Err(Unsettled::NoAnswer) => {
                tracing::warn!("the controller did not answer a written EnableIn in time");
                Ok(())
            }
            Ok(()) => Ok(()),
        }
    }

    pub(super) async fn settle(&self, pending: Pending) -> Result<(), Unsettled> {
        let Pending {
            answers,
            persisted,
            steps,
        } = pending;
        let (tickets, receivers): (Vec<Ticket>, Vec<_>) = answers.into_iter().unzip();
        let all = async {
            for receiver in receivers {
                // The sender goes only with the plant.
                let _ = receiver.await;
            }
        };
        let answered = tokio::time::timeout(ANSWER_WITHIN, all).await.is_ok();
        let mut results = None;
        if !answered {
            let mut state = self.0.lock();
            for ticket in tickets {
                state.waiting.remove(&ticket);
            }
        } else if !tickets.is_empty() {
            results = self.0.lock().send_results();
        }
        for (principal, ticks, until) in steps {
            self.step_for(principal, ticks, until).await;
        }
        for persisted in persisted.into_iter().chain(results) {
            if !matches!(tokio::time::timeout(ANSWER_WITHIN, persisted).await, Ok(Ok(Ok(())))) {
                return Err(Unsettled::NotPersisted);
            }
        }
        if answered { Ok(()) } else { Err(Unsettled::NoAnswer) }
    }
}

impl Pending {
    /// Whether every sent instruction is answered.
    pub(crate) fn is_answered(&mut self) -> bool {
        use oneshot::error::TryRecvError;
        let waits = |answer: &mut oneshot::Receiver<()>| matches!(answer.try_recv(), Err(TryRecvError::Empty));
        self.answers.retain_mut(|(_, answer)| waits(answer));
        self.answers.is_empty()
    }
}

/// Stops that find room when packets have taken theirs.
const STOPS_OF_SINGLE_REQUESTS: usize = arcline_realtime::STOPS / 4;

/// The reason for which a transaction is not complete.
pub(super) enum Unsettled {
    NoAnswer,
    NotPersisted,
}

impl Transaction<'_> {
    /// The writes are those of one packet. They leave the reserved room to the stops of single requests, so that a client that toggles many
    /// stops does not block a stop of another client.
    pub(crate) fn of_packet(&mut self) {
        self.is_packet = true;
        self.update_room();
    }

    /// The tags as they are now.
    pub fn image(&self) -> &Image {
        self.state.image()
    }

    /// Sends the first moves of a series: as many as find room and are not refused. The number of moves sent, and the end of the series.
    pub(super) fn send_series(&mut self, moves: &[(Principal, Call<'_>)]) -> (Vec<u32>, SeriesEnd) {
        self.series = Some(self.state.series());
        let mut sent = Vec::with_capacity(moves.len().min(LONGEST_SERIES));
        for (principal, call) in moves.iter().take(LONGEST_SERIES) {
            let system = call.target.map(SystemId);
            if let Some(system) = system
                && self.state.queue_room(system) == 0
            {
                return (sent, SeriesEnd::NoRoom { system });
            }
            self.principal = *principal;
            match self.apply(Command::Call(call.clone())) {
                Ok(Outcome::Begun(instance)) => sent.push(instance),
                Ok(_) => {}
                // The waiting moves get their answers soon.
                Err(Refused::Call(CallRefused::Busy)) if !sent.is_empty() => break,
                Err(refused) => return (sent, SeriesEnd::Refused(refused)),
            }
        }
        (sent, SeriesEnd::Sent)
    }

    /// Executes a command. An instruction is sent and not waited for.
    ///
    /// # Errors
    /// See [`Refused`]; nothing has changed then.
    pub fn apply(&mut self, command: Command<'_>) -> Result<Outcome, Refused> {
        let (counter, retained) = (policy::counter(&command), policy::is_retained(&command));
        let mut event = self
            .shared
            .event(self.principal, self.role, &command, self.state.image());
        let done = self.authorized(command);
        if let Some(event) = &mut event {
            self.shared.finish(event, &done);
        }
        if let (Some(event), Some(audit)) = (event, self.shared.audit.get()) {
            audit.record(event);
        }
        self.shared.counters.count(counter, done.is_ok());
        match &done {
            Ok(_) => self.retained |= retained,
            Err(Refused::Role { right, .. }) => self.denied = self.denied.or(Some(*right)),
            Err(refused) => tracing::debug!(principal = ?self.principal, ?counter, %refused, "a command was refused"),
        }
        done
    }

    /// Writes a number at a path, converted to the type that is there.
    ///
    /// # Errors
    /// As [`Transaction::apply`].
    pub fn write_value(&mut self, path: &TagPath, value: Value) -> Result<Outcome, Refused> {
        let (tag, place) = self.image().locate(path).map_err(WriteError::from)?;
        let offset = place.offset;
        if let Some(bit) = place.bit {
            let on = value.as_bool();
            return self.apply(Command::WriteBit { tag, offset, bit, on });
        }
        let DataType::Elementary(kind) = place.data_type else {
            let (path, data_type) = (path.to_string(), place.data_type.name().to_owned());
            return Err(WriteError::from(ReadError::NotAValue { path, data_type }).into());
        };
        let mut bytes = [0; 8];
        let data = &mut bytes[..kind.size()];
        value.convert(kind).write(data);
        self.apply(Command::WriteTag { tag, offset, data })
    }

    fn authorized(&mut self, command: Command<'_>) -> Result<Outcome, Refused> {
        let (image, machine) = (self.state.image(), &self.shared.machine);
        if !is_planted("role not checked") {
            policy::authorize_role(self.principal, self.role, &command, image)?;
        }
        policy::authorize(self.principal, &command, image, machine, &self.shared.control())?;
        self.check_alone(&command)?;
        self.execute(command)
    }

    /// Refuses a command on an axis that another principal moves.
    fn check_alone(&mut self, command: &Command<'_>) -> Result<(), Refused> {
        let Some(axis) = policy::alone_on(self.principal, command) else {
            return Ok(());
        };
        match self.state.another_mover(axis, self.principal.viewer()) {
            Some(mover) => Err(Refused::MovedByAnother {
                object: MotionObject::Axis(axis).name(&self.shared.machine).to_owned(),
                mover,
            }),
            None => Ok(()),
        }
    }

    fn execute(&mut self, command: Command<'_>) -> Result<Outcome, Refused> {
        let effect = match command {
            Command::WriteTag { tag, offset, data } => self.state.image_mut().write(tag, offset, data)?,
            Command::WriteBit { tag, offset, bit, on } => self.state.image_mut().write_bit(tag, offset, bit, on)?,
            Command::SetAttribute {
                attribute,
                index,
                value,
            } => Some(self.state.image_mut().set_attribute(attribute, index, value)?),
            Command::InjectFaults { axis, bits } => self.state.image_mut().inject_faults(axis, bits)?,
            Command::SetFeedOverride { system, percent } => {
                self.state.image_mut().set_feed_override(system, percent)?
            }
            Command::Hold(systems) => return self.override_each(systems, |_, _| Some(0.0)),
            Command::Resume(systems) => {
                return self.override_each(systems, |image, system| {
                    match image.feed_overrides().nth(system.into()) {
                        Some(0.0) => image.feed_override_before_hold(system),
                        _ => None,
                    }
                });
            }
            Command::Call(call) => return self.call(call),
            Command::Execute(call) => return self.send(None, *call),
            Command::RungFalse(mnemonic, control) => {
                self.send_effects();
                self.state.rung_false(mnemonic, control);
                None
            }
            Command::SetMode(mode) => {
                self.shared.program.get().ok_or(Refused::NoProgram)?.ask(mode);
                None
            }
            Command::Force(force) => {
                let program = self.shared.program.get().ok_or(Refused::NoProgram)?;
                program.forces.set(force.clone())?;
                None
            }
            Command::RemoveForce(name) => {
                self.shared
                    .program
                    .get()
                    .ok_or(Refused::NoProgram)?
                    .forces
                    .remove(name)?;
                None
            }
            Command::CreateTag(tag) => return Ok(Outcome::Created(self.state.image_mut().create(tag)?)),
            Command::DeleteTag(tag) => {
                self.state.image_mut().delete(tag)?;
                None
            }
            Command::Reload { old, new } => {
                self.state.image_mut().reload(old, new)?;
                None
            }
            Command::Lose { lost, reaction } => {
                self.send_effects();
                return Ok(Outcome::Lost(self.state.lose(lost.owner(), reaction)));
            }
            Command::Disown(principal) => {
                self.state.disown(principal.owner());
                None
            }
            Command::StopAll => {
                self.shared.stops.stop_all();
                None
            }
            Command::Inhibit => Some(WriteEffect::Inhibit(true)),
            Command::Release => Some(WriteEffect::Inhibit(false)),
            Command::Step { ticks, until } => {
                if self.shared.stepper.is_none() {
                    return Err(Refused::NotStepped);
                }
                if let Some(path) = &until {
                    self.state.image().read(path).map_err(WriteError::from)?;
                }
                self.pending.steps.push((self.principal, ticks, until));
                None
            }
        };
        if let Some(WriteEffect::Steps(ticks)) = effect {
            self.pending.steps.push((self.principal, ticks, None));
        }
        self.effects.extend(effect);
        Ok(Outcome::Done)
    }

    /// Sets overrides; those for which there is no percent stay.
    fn override_each(
        &mut self,
        systems: Systems,
        percent: impl Fn(&Image, SystemId) -> Option<f32>,
    ) -> Result<Outcome, Refused> {
        let (from, count) = match systems {
            Systems::One(system) => (system.index(), 1),
            Systems::All => (0, self.shared.machine.systems.len()),
        };
        let mut done = Ok(Outcome::Done);
        for system in SystemId::first(from + count).skip(from) {
            let Some(percent) = percent(self.image(), system) else {
                continue;
            };
            match self.state.image_mut().set_feed_override(system, percent) {
                Ok(effect) => self.effects.extend(effect),
                Err(error) => done = Err(error.into()),
            }
        }
        done
    }

    fn call(&mut self, call: Call<'_>) -> Result<Outcome, Refused> {
        let Call {
            mnemonic,
            target,
            control,
            operands,
            text,
        } = call;
        if self.series.is_some() && !mnemonic.instruction().joins_series(operands) {
            return Err(CallRefused::NotOfSeries { mnemonic }.into());
        }
        // The effects of earlier writes go first.
        self.send_effects();
        if !self.state.has_room(mnemonic) {
            return Err(CallRefused::Busy.into());
        }
        // Bound before the tag is made: a refused call makes no tag.
        let mut call = bind(mnemonic, target, UNNAMED, operands, self.state.image()).map_err(CallRefused::from)?;
        if let Some(name) = control {
            call.control = self.state.image_mut().control_slot(name).map_err(CallRefused::from)?;
        }
        self.send(text, call)
    }

    /// Sends a bound call.
    fn send(&mut self, text: Option<Arc<str>>, call: arcline_instruction_set::Call) -> Result<Outcome, Refused> {
        self.send_effects();
        if !self.state.has_room(call.mnemonic) {
            return Err(CallRefused::Busy.into());
        }
        let (ticket, answer) = self.state.send(self.principal, text, call, self.series);
        self.pending.answers.push((ticket, answer));
        self.update_room();
        Ok(Outcome::Begun(instance_of(ticket)))
    }

    /// Sends the controller the effects of the writes so far, with the operands as they are now.
    fn send_effects(&mut self) {
        for effect in std::mem::take(&mut self.effects) {
            self.pending
                .answers
                .extend(self.state.send_effect(self.principal, effect));
        }
    }

    /// Updates the number of instructions that writes may begin.
    fn update_room(&mut self) {
        let mut room = self.state.room();
        if self.is_packet {
            room.stops = room.stops.saturating_sub(STOPS_OF_SINGLE_REQUESTS);
        }
        self.state.image_mut().set_call_room(room);
    }

    fn finish(mut self) -> Pending {
        self.send_effects();
        if self.retained {
            // Sent under the lock, so that the file has the writes in their order.
            self.pending.persisted = self.state.send_writes();
        }
        self.pending
    }
}
