//! The changes of the retained state: parts of tags when a client writes them, axes when a snapshot shows their change.
//!
//! The tracker only observes and sends. One message about axes is on its way at a time, so a slow disk makes these messages rarer and never
//! queues them up.

use std::collections::BTreeMap;

use arcline_controller::image::{Image, TagId};
use arcline_controller::{AxisSnapshot, Snapshot};
use arcline_instruction_set::predefined::{axis_status, cip_axis_status, motion_status};
use arcline_state::planted::is_planted;
use arcline_state::{Axis, AxisState, Change, Record, RetainedState, Tag};
use tokio::sync::oneshot;

use super::state_writer::{NotPersisted, PersistedReceiver, RecordSender};
use super::tags_of;

/// Detects changes and sends them to the state writer.
#[derive(Debug)]
pub(crate) struct ChangeTracker {
    records: RecordSender,
    tags: KeptTags,
    /// A record of tags was lost: the next one is the whole state.
    lost: bool,
    /// The changes of the table of tags that have been seen.
    table: u32,
    /// The axes as they were last sent.
    axes: Vec<Axis>,
    /// The last message about axes, until the disk has it.
    under_way: Option<PersistedReceiver>,
    /// Ticks between two positions of an axis that moves.
    interval: u64,
    /// The tick at which positions are due again.
    due: u64,
}

/// The tags in the state.
#[derive(Debug, Default, PartialEq)]
pub(super) struct KeptTags {
    /// Their places in the state.
    places: BTreeMap<TagId, u32>,
    /// Their names and kinds, in order: a new tag may have the id of one that was deleted.
    kinds: Vec<(String, String)>,
}

impl KeptTags {
    /// `ids`: those of the tags, in order.
    pub(super) fn new(tags: &[Tag], ids: Vec<TagId>) -> Self {
        KeptTags {
            places: ids.into_iter().zip(0..).collect(),
            kinds: tags.iter().map(|tag| (tag.name.clone(), tag.kind.clone())).collect(),
        }
    }
}

impl ChangeTracker {
    /// `axes` is how they stand in the state, in configuration order.
    pub(super) fn new(records: RecordSender, axes: Vec<Axis>, tags: KeptTags, period_ns: u64) -> Self {
        ChangeTracker {
            records,
            tags,
            lost: false,
            // No change of the table has been seen.
            table: u32::MAX,
            axes,
            under_way: None,
            interval: (POSITIONS_NS / period_ns.max(1)).max(1),
            due: 0,
        }
    }

    /// Sends the writes to the tags since the last call, as one change; `None`: there were none.
    ///
    /// When the tags themselves are others than before, it sends the whole state, which has the new tags and their bytes.
    pub(crate) fn tags(&mut self, image: &mut Image) -> Option<PersistedReceiver> {
        let written = image.take_written();
        if let Some(kept) = self.table(image) {
            return Some(kept);
        }
        let changes = written.iter().filter_map(|part| {
            Some(Change::Tag {
                tag: *self.tags.places.get(&part.id)?,
                offset: u32::try_from(part.offset).ok()?,
                bytes: image
                    .bytes(part.id)
                    .get(part.offset..part.offset + part.length)?
                    .to_vec(),
            })
        });
        let mut changes: Vec<Change> = changes.collect();
        if is_planted("half a message kept") {
            changes.truncate(1);
        }
        self.send_changes(changes)
    }

    fn table(&mut self, image: &Image) -> Option<PersistedReceiver> {
        if image.table_changes() == self.table && !self.lost {
            return None;
        }
        self.table = image.table_changes();
        let (tags, ids) = tags_of(image);
        let kept = KeptTags::new(&tags, ids);
        if kept == self.tags && !std::mem::take(&mut self.lost) {
            return None;
        }
        self.tags = kept;
        let state = RetainedState {
            axes: self.axes.clone(),
            tags,
        };
        Some(self.send(Record::State(state)))
    }

    /// Sends the changes that a snapshot shows. The beginning and the end of an axis's motion, a homing, a fault and a redefined position go
    /// at once; the positions of moving axes go every 100 ms.
    pub(crate) fn axes(&mut self, snapshot: &Snapshot) {
        if let Some(sent) = &mut self.under_way {
            if matches!(sent.try_recv(), Err(oneshot::error::TryRecvError::Empty)) {
                return;
            }
            self.under_way = None;
        }
        let due = snapshot.tick >= self.due;
        let news = self.news(snapshot, |was, is| {
            due || !(was.moving && is.moving) || was.homed != is.homed || was.faults != is.faults
        });
        if due {
            self.due = snapshot.tick + self.interval;
        }
        self.under_way = self.send_changes(news);
    }

    /// Sends the axes as they are after a controlled stop. An axis whose drive is on comes to rest at its command position.
    pub(crate) fn axes_at_the_end(&mut self, snapshot: &Snapshot) {
        let settled = Snapshot {
            axes: snapshot.axes.iter().copied().map(settled).collect(),
            ..snapshot.clone()
        };
        let news = self.news(&settled, |_, _| true);
        self.under_way = self.send_changes(news);
    }

    fn news(&mut self, snapshot: &Snapshot, wanted: impl Fn(&AxisState, &AxisState) -> bool) -> Vec<Change> {
        let axes = (0..).zip(self.axes.iter_mut().zip(&snapshot.axes));
        axes.filter_map(|(axis, (was, shown))| {
            let state = state(shown);
            let was = &mut was.state;
            let news =
                state != *was && wanted(was, &state) && state.position.is_finite() && state.redefined.is_finite();
            news.then(|| {
                *was = state;
                Change::Axis { axis, state }
            })
        })
        .collect()
    }

    fn send_changes(&mut self, changes: Vec<Change>) -> Option<PersistedReceiver> {
        (!changes.is_empty()).then(|| self.send(Record::Changes(changes)))
    }

    fn send(&mut self, record: Record) -> PersistedReceiver {
        self.records.send(record).unwrap_or_else(|| {
            self.lost = true;
            let (sender, receiver) = oneshot::channel();
            let _ = sender.send(Err(NotPersisted));
            receiver
        })
    }
}

/// The state that a snapshot shows of an axis.
fn state(axis: &AxisSnapshot) -> AxisState {
    let [_, velocity, acceleration] = axis.command;
    let standstill = axis.cip_status & cip_axis_status::VELOCITY_STANDSTILL_STATUS != 0;
    let moving = axis.motion_status & MOVED != 0 || velocity != 0.0 || acceleration != 0.0 || !standstill;
    // At rest under its drive the axis stands exactly at its command position, and does so again after the next start.
    let held = is_on(axis) && axis.cip_status & cip_axis_status::POSITION_LOCK_STATUS != 0;
    AxisState {
        position: if held && !moving {
            axis.command[0]
        } else {
            axis.actual[0]
        },
        homed: axis.motion_status & motion_status::AXIS_HOMED_STATUS != 0,
        moving,
        faults: axis.faults.bits(),
        redefined: axis.redefined,
    }
}

/// The axis when its drive has caught up with the command.
fn settled(axis: AxisSnapshot) -> AxisSnapshot {
    if !is_on(&axis) {
        return axis;
    }
    AxisSnapshot {
        cip_status: axis.cip_status
            | cip_axis_status::VELOCITY_STANDSTILL_STATUS
            | cip_axis_status::POSITION_LOCK_STATUS,
        actual: axis.command,
        ..axis
    }
}

fn is_on(axis: &AxisSnapshot) -> bool {
    axis.status & axis_status::SERVO_ACTION_STATUS != 0
}

/// Bits of MotionStatus of a motion that has an end, which it has not come to. An axis in gear may well stand.
const MOVED: u32 = motion_status::ACCEL_STATUS
    | motion_status::DECEL_STATUS
    | motion_status::MOVE_STATUS
    | motion_status::JOG_STATUS
    | motion_status::HOMING_STATUS
    | motion_status::STOPPING_STATUS
    | motion_status::MASTER_OFFSET_MOVE_STATUS
    | motion_status::COORDINATED_MOTION_STATUS;
/// Time between two positions of an axis that moves, ns.
const POSITIONS_NS: u64 = 100_000_000;
