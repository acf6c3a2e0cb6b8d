//! What the plant's lock guards: tags, rings, and which tickets somebody waits for; and what of it is published for readers.
//! It never blocks and knows no tasks.

use std::collections::{BTreeMap, VecDeque};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use arc_swap::ArcSwap;
use arcline_controller::image::{Edge, Image, Staged, TagKind};
use arcline_controller::{Command, Snapshot, Ticket};
use arcline_instruction_set::{Call, FaultSet, Flag, MotionControl, MotionError};
use arcline_realtime::Link;
use tokio::sync::oneshot;

use super::OUTSTANDING;
use super::log::Log;
use super::moves::LiveMoves;
use super::owned::{Owned, Owner};
use super::records::Records;
use crate::retained::{Watch, WhenKept};
use crate::trace::Trace;

/// What readers have without the lock.
#[derive(Debug)]
pub(super) struct Published {
    /// The tag memory after the last change.
    pub(super) image: ArcSwap<Image>,
    /// How many snapshots there were when its newest one was taken.
    pub(super) snapshots: AtomicU64,
}

/// Everything behind the plant's lock.
#[derive(Debug)]
pub(super) struct State {
    image: Image,
    /// Whether the image is another one than what was published of it.
    changed: bool,
    /// Who is to be told as soon as the image is published.
    done: Vec<oneshot::Sender<()>>,
    /// How many snapshots there were when the newest one was taken.
    snapshots: u64,
    pub(super) link: Link,
    /// Whether a snapshot was ever published.
    began: bool,
    next_ticket: u64,
    pub(super) waiting: BTreeMap<Ticket, oneshot::Sender<()>>,
    /// What found no room in the ring, in order.
    pub(super) backlog: VecDeque<Command>,
    pub(super) records: Records,
    pub(super) log: Log,
    pub(super) moves: LiveMoves,
    /// What connections have begun.
    pub(super) owned: Owned,
    lost: u64,
    /// What instructions under way write to tags when they are done.
    staged: BTreeMap<Ticket, Staged>,
    /// The overrides that the controller has been sent, percent.
    overrides: Vec<f32>,
    /// The injected causes of faults that the controller has been sent.
    injected: Vec<FaultSet>,
    /// Sees what is kept over a restart.
    pub(super) watch: Option<Watch>,
    /// Sees what triggers it.
    trace: Trace,
}

impl State {
    /// On rings of which nothing has come yet.
    pub(super) fn new(image: Image, link: Link, watch: Option<Watch>, trace: Trace) -> Self {
        let moves = LiveMoves::new(link.snapshots.output_buffer().systems.len());
        State {
            overrides: image.feed_overrides().collect(),
            injected: image.injected_faults().collect(),
            image,
            changed: false,
            done: Vec::new(),
            snapshots: 0,
            link,
            began: false,
            next_ticket: 1,
            waiting: BTreeMap::new(),
            backlog: VecDeque::new(),
            staged: BTreeMap::new(),
            records: Records::default(),
            log: Log::default(),
            moves,
            owned: Owned::default(),
            lost: 0,
            watch,
            trace,
        }
    }

    /// The tag memory.
    pub(super) fn image(&self) -> &Image {
        &self.image
    }

    /// The tag memory, the snapshot that it shows, and the moves under way.
    pub(super) fn view(&mut self) -> (&Image, &Snapshot, &LiveMoves) {
        (&self.image, self.link.snapshots.output_buffer(), &self.moves)
    }

    /// The tag memory, which is then published anew.
    pub(super) fn image_mut(&mut self) -> &mut Image {
        self.changed = true;
        &mut self.image
    }

    /// Publishes the tag memory if it has changed, then tells those who waited for what it shows now.
    pub(super) fn publish(&mut self, published: &Published) {
        if std::mem::take(&mut self.changed) {
            published.image.store(Arc::new(self.image.clone()));
        }
        published.snapshots.store(self.snapshots, Ordering::Release);
        for waiting in self.done.drain(..) {
            // Whoever waited may have given up.
            let _ = waiting.send(());
        }
    }

    /// What has to be kept of what was written.
    pub(super) fn keep(&mut self) -> Option<WhenKept> {
        let watch = self.watch.as_mut()?;
        watch.tags(&mut self.image)
    }

    /// Takes the newest snapshot and everything that happened up to its tick.
    pub(super) fn refresh(&mut self) {
        self.snapshots = self.link.meter.snapshots();
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
            let _ = self.link.events.pop();
            self.image_mut().apply_event(&event);
            self.moves.event(&event);
            self.log.push(event, self.records.target(event.ticket));
            let tag = self.image.control_name(event.control);
            self.trace.event(event.tick, tag, event.mnemonic, event.set);
            let record = self.records.get_mut(event.ticket);
            if let Some(control) = record {
                event.apply(control);
                if is_accepted(control) {
                    let control = *control;
                    self.complete(event.ticket, &control);
                }
            }
        }
        while let Ok(write) = self.link.array_writes.peek() {
            if write.tick > tick {
                break;
            }
            self.image.apply_array_write(write);
            let _ = self.link.array_writes.pop();
        }
        while let Ok(answer) = self.link.answers.peek() {
            if answer.tick > tick {
                break;
            }
            let answer = *answer;
            let _ = self.link.answers.pop();
            if is_accepted(&answer.control) {
                // Its event says the same, unless that was lost.
                if let Some(control) = self
                    .records
                    .get_mut(answer.ticket)
                    .filter(|control| !is_accepted(control))
                {
                    *control = answer.control;
                }
                self.complete(answer.ticket, &answer.control);
            }
        }
        if updated {
            self.changed = true;
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
                    "status changes were lost: there were too many within one tick"
                );
                self.lost = lost;
            }
        }
    }

    fn complete(&mut self, ticket: Ticket, control: &MotionControl) {
        if let Some(staged) = self.staged.remove(&ticket) {
            self.image_mut().settle(staged, control);
        }
        self.done.extend(self.waiting.remove(&ticket));
    }

    /// Sends a call for an owner, as [`Self::send`].
    pub(super) fn send_for(&mut self, owner: Option<Owner>, call: Call) -> (Ticket, oneshot::Receiver<()>) {
        let sent = self.send(call);
        if let Some(owner) = owner {
            self.owned.begin(owner, sent.0, &call, &self.records);
        }
        sent
    }

    /// Sends a call; the receiver is told when DN, ER or IP is set.
    pub(super) fn send(&mut self, call: Call) -> (Ticket, oneshot::Receiver<()>) {
        let ticket = self.ticket(call.target);
        let (sender, receiver) = oneshot::channel();
        self.waiting.insert(ticket, sender);
        let (material, staged) = self.image_mut().prepare(&call);
        if let Some(staged) = staged {
            self.staged.insert(ticket, staged);
        }
        self.push(match material {
            None => Command::Call(ticket, call),
            Some(material) => Command::CallWith(ticket, call, material),
        });
        (ticket, receiver)
    }

    fn ticket(&mut self, target: Option<u16>) -> Ticket {
        let ticket = Ticket(self.next_ticket);
        self.next_ticket += 1;
        self.records.begin(ticket, target);
        ticket
    }

    pub(super) fn push(&mut self, command: Command) {
        self.backlog.push_back(command);
        self.flush();
    }

    pub(super) fn flush(&mut self) {
        while let Some(command) = self.backlog.pop_front() {
            if let Err(rtrb::PushError::Full(command)) = self.link.commands.push(command) {
                self.backlog.push_front(command);
                break;
            }
        }
    }

    /// Tells the controller which overrides have changed.
    pub(super) fn send_overrides(&mut self) {
        let overrides: Vec<f32> = self.image.feed_overrides().collect();
        for ((system, now), sent) in (0..)
            .zip(&overrides)
            .zip(std::mem::replace(&mut self.overrides, overrides.clone()))
        {
            if *now != sent {
                self.push(Command::Override {
                    system,
                    rate: f64::from(*now) / 100.0,
                });
            }
        }
    }

    /// Tells the controller which injected causes of faults have changed.
    fn send_injected(&mut self) {
        let injected: Vec<FaultSet> = self.image.injected_faults().collect();
        for ((axis, causes), sent) in (0..)
            .zip(&injected)
            .zip(std::mem::replace(&mut self.injected, injected.clone()))
        {
            if *causes != sent {
                self.push(Command::Inject { axis, causes: *causes });
            }
        }
    }

    pub(super) fn edge(&mut self, owner: Option<Owner>, edge: Edge) -> Option<oneshot::Receiver<()>> {
        let id = match edge {
            Edge::Rising(id) | Edge::Falling(id) => id,
            Edge::FeedOverride => {
                self.send_overrides();
                return None;
            }
            Edge::FaultInject => {
                self.send_injected();
                return None;
            }
            Edge::Input => {
                for input in self.image.take_inputs() {
                    self.push(Command::Input(input));
                }
                return None;
            }
        };
        let TagKind::Instruction(kind) = self.image.tag(id)?.kind else {
            return None;
        };
        if let Edge::Falling(_) = edge {
            // Of a call that was refused below, the controller knows nothing.
            let mut control = self.image.control(kind.control);
            if is_answered(&control) {
                control.clear(Flag::En);
                self.image_mut().set_control(kind.control, control);
            }
            self.push(Command::RungFalse(kind.control));
            return None;
        }
        let error = match self.image.call_of(id)? {
            Ok(call) if self.waiting.len() < OUTSTANDING => return Some(self.send_for(owner, call).1),
            Ok(_) => MotionError::from_codes(EXECUTION_COLLISION, 0)?,
            // A name among the operands that means nothing is a value out of range.
            Err(error) => MotionError::from_codes(OUT_OF_RANGE, error.operand().map_or(0, |operand| operand.0 as i8))?,
        };
        let ticket = self.ticket(None);
        let refused = MotionControl::refused(error);
        self.image_mut().set_control(kind.control, refused);
        if let Some(control) = self.records.get_mut(ticket) {
            *control = refused;
        }
        None
    }
}

/// Whoever sent it is told now: a process that has begun is not waited for.
fn is_accepted(control: &MotionControl) -> bool {
    is_answered(control) || control.has(Flag::Ip)
}

fn is_answered(control: &MotionControl) -> bool {
    control.has(Flag::Dn) || control.has(Flag::Er)
}

/// ERR of a call that finds no room.
const EXECUTION_COLLISION: i16 = 3;
/// ERR of an operand out of range.
const OUT_OF_RANGE: i16 = 13;
