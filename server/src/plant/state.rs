//! The state that the plant's lock guards: tags, rings, and the tickets whose senders wait; and the copies for readers.
//! It never blocks and knows no tasks.

mod sending;

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::Duration;

use arc_swap::ArcSwap;
use arcline_controller::image::{Image, StagedWrites, TagKind, WriteEffect};
use arcline_controller::machine::Machine;
use arcline_controller::{ContourRests, Event, Ticket};
use arcline_instruction_set::{AxisId, FaultSet, Flag, MotionControl, MotionError, OperandIndex, Setting, SystemId};
use arcline_realtime::ServerRings;
use tokio::sync::oneshot;

pub(super) use self::sending::OUTSTANDING;
use self::sending::WaitingCommands;

use super::changes::ChangeLog;
use super::io::View;
use super::log::{Change, ContourRest, Log, RestCause};
use super::movers::{MotionTickets, Mover, Movers};
use super::moves::LiveMoves;
use super::owned::OwnedInstructions;
use super::principal::Principal;
use super::records::Executions;
use super::wall_clock::WallClock;
use crate::guard::Guard;
use crate::retained::{ChangeTracker, PersistedReceiver};
use crate::trace::Trace;
use arcline_state::planted::is_planted;

/// The copies that readers have without the lock.
#[derive(Debug)]
pub(super) struct Published {
    /// The tag memory after the last change.
    pub(super) image: ArcSwap<Image>,
    /// The number of snapshots up to the newest one in the image.
    pub(super) snapshots: AtomicU64,
    /// The principals that move objects, as of the last change.
    pub(super) movers: ArcSwap<Movers>,
    /// The tags that have changed.
    pub(super) changes: ChangeLog,
    /// Whether the controller's program has yet to take changes.
    pub(super) foreign_changes: AtomicBool,
}

/// Everything behind the plant's lock.
#[derive(Debug)]
pub(super) struct State {
    image: Image,
    /// Whether the image differs from its published copy.
    changed: bool,
    /// The calls that are answered as soon as the image is published.
    done: Vec<oneshot::Sender<()>>,
    /// The number of snapshots up to the newest one in the image.
    snapshots: u64,
    pub(super) link: ServerRings,
    /// Whether the controller has published a snapshot.
    began: bool,
    next_ticket: u64,
    pub(super) waiting: BTreeMap<Ticket, oneshot::Sender<()>>,
    /// Commands that found no room in the ring.
    waiting_commands: WaitingCommands,
    /// Stops the jogs of clients that are lost.
    pub(super) guard: Guard,
    pub(super) records: Executions,
    pub(super) log: Log,
    pub(super) moves: LiveMoves,
    /// The instructions that connections have sent.
    pub(super) owned: OwnedInstructions,
    /// The instructions by which objects move.
    pub(super) motion_tickets: MotionTickets,
    lost: u64,
    /// Whether the tags show that motion is inhibited.
    inhibited: bool,
    /// Writes to tags that instructions make when they are done.
    staged: BTreeMap<Ticket, StagedWrites>,
    /// The overrides that the controller has been sent, percent.
    overrides: Vec<f32>,
    /// The injected causes of faults that the controller has been sent.
    injected: Vec<FaultSet>,
    /// The settable attributes that the controller has been sent.
    settings: Vec<Setting>,
    /// The rests on the way that are in the log.
    rests: Vec<ContourRests>,
    /// Sends the changes of the retained state to its writer.
    pub(super) watch: Option<ChangeTracker>,
    /// Watches for the triggers of traces.
    trace: Trace,
}

/// The observers of a plant's changes.
pub(super) struct Observers {
    /// Sends the changes of the retained state to its writer.
    pub(super) watch: Option<ChangeTracker>,
    /// Watches for the triggers of traces.
    pub(super) trace: Trace,
    /// Watches the jogs.
    pub(super) guard: Guard,
    /// The clock for the dates of observations.
    pub(super) wall: WallClock,
}

impl State {
    /// Makes the state for rings that are still empty.
    pub(super) fn new(
        machine: &Machine,
        image: Image,
        link: ServerRings,
        Observers {
            watch,
            trace,
            guard,
            wall,
        }: Observers,
    ) -> Self {
        let moves = LiveMoves::new(link.snapshots.output_buffer().systems.len());
        State {
            overrides: image.feed_overrides().collect(),
            injected: image.injected_faults().collect(),
            settings: image.settings().to_vec(),
            image,
            changed: false,
            done: Vec::new(),
            snapshots: 0,
            link,
            began: false,
            next_ticket: 1,
            waiting: BTreeMap::new(),
            waiting_commands: WaitingCommands::default(),
            guard,
            staged: BTreeMap::new(),
            records: Executions::default(),
            log: Log::new(Duration::from_nanos(machine.period_ns), wall),
            moves,
            owned: OwnedInstructions::default(),
            motion_tickets: MotionTickets::new(machine),
            lost: 0,
            inhibited: false,
            rests: vec![ContourRests::default(); machine.systems.len()],
            watch,
            trace,
        }
    }

    /// The tag memory.
    pub(super) fn image(&self) -> &Image {
        &self.image
    }

    /// The tag memory, the snapshot that it shows, the moves under way and the movers.
    pub(super) fn view(&mut self) -> View<'_> {
        View {
            movers: self.movers(),
            image: &self.image,
            snapshot: self.link.snapshots.output_buffer(),
            moves: &self.moves,
        }
    }

    /// The movers as the executions and the newest snapshot are now.
    fn movers(&mut self) -> Arc<Movers> {
        let snapshot = self.link.snapshots.output_buffer();
        self.motion_tickets.movers(&self.records, snapshot)
    }

    /// A mover of an axis that is not of a viewer's own.
    pub(super) fn another_mover(&mut self, axis: AxisId, viewer: Option<u64>) -> Option<Mover> {
        let snapshot = self.link.snapshots.output_buffer();
        self.motion_tickets.another_mover(axis, viewer, &self.records, snapshot)
    }

    /// The tag memory, which is then published anew.
    pub(super) fn image_mut(&mut self) -> &mut Image {
        self.changed = true;
        &mut self.image
    }

    /// Publishes the tag memory if it has changed, then answers the calls that waited for the changes in it.
    pub(super) fn publish(&mut self, published: &Published) {
        if is_planted("stale reads") && self.next_ticket % 8 == 3 && self.began {
            return;
        }
        if std::mem::take(&mut self.changed) {
            let before = published.image.swap(Arc::new(self.image.clone()));
            published.changes.note(&before, &self.image);
        }
        published
            .foreign_changes
            .store(self.image.has_foreign_changes(), Ordering::Release);
        let movers = self.movers();
        if !Arc::ptr_eq(&movers, &published.movers.load()) {
            published.movers.store(movers);
        }
        published.snapshots.store(self.snapshots, Ordering::Release);
        for answer in self.done.drain(..) {
            // The caller may have given up.
            let _ = answer.send(());
        }
    }

    /// The tag memory for the controller's program, which takes the changes of the clients. The plant publishes it anew if the program shows
    /// changes of its own.
    pub(super) fn image_of_program(&mut self, shows: bool) -> &mut Image {
        self.changed |= shows;
        &mut self.image
    }

    /// Sends the results of instructions in plain tags to the writer of the retained state, if there are any that no write has sent.
    pub(super) fn send_results(&mut self) -> Option<PersistedReceiver> {
        if self.image.has_written() {
            self.send_writes()
        } else {
            None
        }
    }

    /// Sends new writes to the writer of the retained state.
    pub(super) fn send_writes(&mut self) -> Option<PersistedReceiver> {
        let watch = self.watch.as_mut()?;
        watch.tags(&mut self.image)
    }

    /// Takes the newest snapshot and everything that happened up to its tick.
    pub(super) fn refresh(&mut self) {
        self.snapshots = self.link.meter.snapshots();
        let is_inhibited = self.link.stops.is_inhibited();
        if is_inhibited != self.inhibited {
            self.inhibited = is_inhibited;
            self.image_mut().show_inhibited(is_inhibited);
        }
        let updated = self.link.snapshots.update();
        self.began |= updated;
        if !self.began {
            return;
        }
        let tick = self.link.snapshots.output_buffer().tick;
        while let Ok(accepted) = self.link.accepted.peek() {
            if accepted.tick > tick {
                break;
            }
            let accepted = *accepted;
            let _ = self.link.accepted.pop();
            self.moves.accept(accepted);
        }
        while let Ok(event) = self.link.events.peek() {
            if event.tick > tick {
                break;
            }
            let event = *event;
            self.take_fault_changes(event.tick, tick);
            let _ = self.link.events.pop();
            self.image_mut().apply_event(&event);
            self.moves.event(&event);
            let at = self.log.time_of(event.tick, tick);
            self.records.note_end(&event, at);
            let target = self.records.target(event.ticket);
            self.log.push(Change::Instruction { event, target }, at);
            let tag = self.image.control_name(event.control);
            self.trace.event(event.tick, tag, event.mnemonic, event.set);
            let control = self.records.update(event.ticket, |control| {
                event.apply(control);
                *control
            });
            if let Some(control) = control {
                self.motion_tickets.executions_changed();
                if event.set & Flag::Ip.mask() != 0 {
                    let Event { mnemonic, ticket, .. } = event;
                    self.motion_tickets.began(mnemonic, target, ticket, &self.records);
                }
                if is_accepted(&control) {
                    self.complete(event.ticket, &control);
                }
            }
        }
        self.take_fault_changes(tick, tick);
        while let Ok(write) = self.link.instruction_writes.peek() {
            if write.tick > tick {
                break;
            }
            self.image.apply_instruction_write(write);
            let _ = self.link.instruction_writes.pop();
        }
        while let Ok(answer) = self.link.answers.peek() {
            if answer.tick > tick {
                break;
            }
            let answer = *answer;
            let _ = self.link.answers.pop();
            if is_accepted(&answer.control) {
                // Its event says the same, unless that was lost.
                let changed = self.records.update(answer.ticket, |control| {
                    let is_late = !is_accepted(control);
                    if is_late {
                        *control = answer.control;
                    }
                    is_late
                });
                if changed == Some(true) {
                    self.motion_tickets.executions_changed();
                }
                self.complete(answer.ticket, &answer.control);
            }
        }
        let is_shown = !is_planted("bits of another tick") || tick.is_multiple_of(16);
        if updated && is_shown {
            self.changed = true;
            self.motion_tickets.snapshot_changed();
            self.log_rests(tick);
            let snapshot = self.link.snapshots.output_buffer();
            self.image.apply_snapshot(snapshot);
            self.moves.settle(snapshot);
            if let Some(watch) = &mut self.watch {
                watch.axes(snapshot);
            }
            let health = self.link.meter.health();
            self.image.apply_health(&health);
            let lost = snapshot.lost_events + health.lost_events + health.lost_answers;
            if lost > self.lost {
                tracing::warn!(
                    lost = lost - self.lost,
                    "too many status changes within one tick: some of them were lost"
                );
                self.lost = lost;
                self.records.changes_lost();
                self.motion_tickets.executions_changed();
            }
        }
    }

    /// Logs the rests on the way that the snapshot of a tick has counted.
    fn log_rests(&mut self, tick: u64) {
        let snapshot = self.link.snapshots.output_buffer();
        let systems = SystemId::first(snapshot.systems.len()).zip(&snapshot.systems);
        for ((system, shown), known) in systems.zip(&mut self.rests) {
            let now = shown.contour_rests;
            let before = std::mem::replace(known, now);
            for (cause, before, count) in [
                (RestCause::Starved, before.starved, now.starved),
                (RestCause::Unplanned, before.unplanned, now.unplanned),
            ] {
                if before != count {
                    let rest = ContourRest {
                        tick,
                        system,
                        cause,
                        count,
                    };
                    self.log.push(Change::Rest(rest), self.log.time_of(tick, tick));
                }
            }
        }
    }

    /// Takes the changes of faults up to a tick, ahead of the changes of instructions that they brought about. `newest`: the
    /// newest tick.
    fn take_fault_changes(&mut self, until: u64, newest: u64) {
        while let Ok(change) = self.link.fault_changes.peek() {
            if change.tick > until {
                break;
            }
            let change = *change;
            let _ = self.link.fault_changes.pop();
            let at = self.log.time_of(change.tick, newest);
            self.log.push(Change::Fault(change), at);
        }
    }

    fn complete(&mut self, ticket: Ticket, control: &MotionControl) {
        if let Some(staged) = self.staged.remove(&ticket) {
            self.image_mut().settle(staged, control);
        }
        self.done.extend(self.waiting.remove(&ticket));
    }

    /// Sends the controller the effect of a write. Of an instruction: its ticket, and the receiver of the answer, which comes when DN, ER
    /// or IP is set.
    pub(super) fn send_effect(
        &mut self,
        principal: Principal,
        effect: WriteEffect,
    ) -> Option<(Ticket, oneshot::Receiver<()>)> {
        let id = match effect {
            WriteEffect::Rising(id) | WriteEffect::Falling(id) => id,
            WriteEffect::FeedOverride => {
                self.send_overrides();
                return None;
            }
            WriteEffect::FaultInject => {
                self.send_injected();
                return None;
            }
            WriteEffect::Inhibit(on) => {
                self.inhibited = on;
                self.image_mut().show_inhibited(on);
                if on {
                    self.link.stops.inhibit();
                } else {
                    self.link.stops.release();
                }
                return None;
            }
            WriteEffect::Setting => {
                self.send_settings();
                return None;
            }
            // The transaction does it at its end.
            WriteEffect::Steps(_) => return None,
            WriteEffect::Input => {
                for input in self.image.take_inputs() {
                    self.send_input(input);
                }
                return None;
            }
        };
        let TagKind::Instruction(kind) = self.image.tag(id)?.kind else {
            return None;
        };
        if let WriteEffect::Falling(_) = effect {
            // The controller does not know a call that is refused below.
            let mut control = self.image.control(kind.control);
            if is_answered(&control) {
                control.clear(Flag::En);
                self.image_mut().set_control(kind.control, control);
            }
            self.rung_false(kind.mnemonic, kind.control);
            return None;
        }
        let error = match self.image.call_of(id)? {
            Ok(call) if self.has_room(call.mnemonic) => {
                if is_planted("edge lost") && !self.waiting.is_empty() {
                    return None;
                }
                return Some(self.send(principal, None, call, None));
            }
            Ok(_) => MotionError::ExecutionCollision,
            // A name among the operands that means nothing is a value out of range.
            Err(error) => MotionError::ParameterOutOfRange(error.operand().unwrap_or(OperandIndex(0))),
        };
        let ticket = self.ticket(principal, None, None);
        let refused = MotionControl::refused(error);
        self.image_mut().set_control(kind.control, refused);
        self.records.update(ticket, |control| *control = refused);
        None
    }
}

/// Whether an execution runs, or may yet run.
pub(super) fn may_run(control: &MotionControl) -> bool {
    control.has(Flag::Ip) || !is_answered(control)
}

/// Whether the sender has its answer: it does not wait for the end of a process that has begun.
fn is_accepted(control: &MotionControl) -> bool {
    is_answered(control) || control.has(Flag::Ip)
}

fn is_answered(control: &MotionControl) -> bool {
    control.has(Flag::Dn) || control.has(Flag::Er)
}
