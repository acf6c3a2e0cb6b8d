//! The state of the machine, pushed to every viewer: made once for all of them, and only while there is one.

use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Duration;

use arcline_controller::image::{Health, Image};
use arcline_controller::machine::Machine;
use arcline_instruction_set::predefined::{axis_status, motion_status};
use arcline_instruction_set::{AxisId, SystemId};
use arcline_tag::{DataType, Template};
use axum::extract::ws::Utf8Bytes;
use tokio::time::{sleep, timeout};

use super::protocol::{AxisStatus, GroupStatus, Push, RealTime, Status as State, SystemStatus, text_of};
use super::{Shared, paths};
use crate::plant::{Mover, View};

/// Shortest time between two pushes.
const EVERY: Duration = Duration::from_millis(60);
/// Longest time between two pushes while no tag changes.
const LONGEST: Duration = Duration::from_millis(500);

/// One push of the state.
#[derive(Clone, Debug, Default)]
pub(super) struct Status {
    /// Which paths it is about: other paths have another number.
    pub(super) paths: u64,
    /// The text for a viewer that has the paths already.
    pub(super) light: Utf8Bytes,
    /// The text with the paths.
    pub(super) whole: Utf8Bytes,
}

/// Makes a status when tags have changed, until the future is dropped.
pub(super) async fn produce(shared: Arc<Shared>) {
    let words = Words::new(&shared);
    let mut latest = Status::default();
    let (mut shown, mut viewers) = (Vec::new(), 0);
    let mut changes = shared.plant.changes();
    loop {
        sleep(EVERY).await;
        // Control of objects changes without the tags.
        if let Ok(None) = timeout(LONGEST, changes.next()).await {
            return;
        }
        if shared.status.receiver_count() == 0 {
            continue;
        }
        // A new viewer has no paths yet.
        let now = (versions(&shared), shared.viewers.load(Ordering::Relaxed));
        if now != (shown, viewers) {
            latest.paths += 1;
            latest.whole = text_of(&words.status(&shared, Paths::Drawn)).into();
        }
        (shown, viewers) = now;
        latest.light = text_of(&words.status(&shared, Paths::LeftOut)).into();
        shared.status.send_replace(latest.clone());
    }
}

/// The programmed paths of a status.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Paths {
    /// Every point of them.
    Drawn,
    /// Their versions.
    LeftOut,
}

/// The versions of the paths of all coordinate systems.
fn versions(shared: &Shared) -> Vec<u64> {
    let systems = shared.plant.machine().systems.len();
    shared
        .plant
        .view(|view| (0..systems).map(|system| view.moves.version(system)).collect())
}

/// The offsets of the status bits in the tag of each object.
#[derive(Debug)]
struct Words {
    axes: Vec<Vec<Bit>>,
    systems: Vec<Vec<Bit>>,
    group: Vec<Bit>,
}

/// A status bit of a tag.
#[derive(Debug)]
struct Bit {
    name: String,
    offset: usize,
    mask: u8,
}

impl Words {
    fn new(shared: &Shared) -> Self {
        let machine = shared.plant.machine();
        shared.plant.with_image(|image| Words {
            axes: machine.axes.iter().map(|axis| bits_of(image, &axis.name)).collect(),
            systems: machine
                .systems
                .iter()
                .map(|system| bits_of(image, &system.name))
                .collect(),
            group: bits_of(image, &machine.group),
        })
    }

    fn status(&self, shared: &Shared, paths: Paths) -> Push<'static> {
        let machine = shared.plant.machine();
        let health = shared.plant.health();
        let drivers = shared.plant.control().drivers(machine);
        shared.plant.view(|view| {
            Push::Status(State {
                tick: view.snapshot.tick,
                time_s: view.snapshot.tick as f64 * machine.period(),
                axes: self.axes(machine, view),
                coordinate_systems: self.systems(machine, view, paths),
                group: GroupStatus {
                    name: machine.group.clone(),
                    bits: set(view.image, &machine.group, &self.group),
                },
                inhibited: shared.plant.is_inhibited(),
                audit_lost: shared.plant.audit_lost(),
                realtime: realtime(&health),
                drivers,
                controller: super::controller::status(&shared.plant),
            })
        })
    }

    fn axes(&self, machine: &Machine, view: &View<'_>) -> Vec<AxisStatus> {
        let ids = AxisId::first(machine.axes.len());
        let axes = machine.axes.iter().zip(&view.snapshot.axes).zip(&self.axes);
        let axes = axes.zip(ids).map(|(((axis, now), bits), id)| {
            let faults = now.faults.kinds().map(|kind| kind.fault().word).collect();
            AxisStatus {
                name: axis.name.clone(),
                command: now.command[0],
                actual: now.actual[0],
                error: now.position_error,
                velocity: now.command[1],
                acceleration: now.command[2],
                actual_velocity: now.actual[1],
                state: state_name(now.cip_state),
                homed: now.motion_status & motion_status::AXIS_HOMED_STATUS != 0,
                servo_on: now.status & axis_status::SERVO_ACTION_STATUS != 0,
                moving: now.command[1] != 0.0,
                moved_by: view.movers.of_axis(id).map(Mover::to_string),
                bits: set(view.image, &axis.name, bits),
                faults,
            }
        });
        axes.collect()
    }

    fn systems(&self, machine: &Machine, view: &View<'_>, drawn: Paths) -> Vec<SystemStatus> {
        let View { image, moves, .. } = *view;
        let ids = SystemId::first(machine.systems.len());
        let systems = machine.systems.iter().zip(&view.snapshot.systems).zip(&self.systems);
        let systems = systems.zip(ids).map(|(((system, now), bits), id)| {
            let index = id.index();
            // For a robot, the page draws the path of the tool, which differs from that of the axes.
            let is_drawn = drawn == Paths::Drawn && now.tool.is_none();
            SystemStatus {
                name: system.name.clone(),
                position: now.actual[..system.axes.len().min(now.actual.len())].to_vec(),
                moved_by: view.movers.of_system(id).map(Mover::to_string),
                active: paths::active(moves, index, image, now),
                pending: paths::pending(moves, index, image),
                path_version: moves.version(index),
                speed: now.path_speed,
                feed_override: 100.0 * now.feed_override,
                held: now.feed_override == 0.0,
                bits: set(image, &system.name, bits),
                path: is_drawn.then(|| paths::of(moves, index, system.linear().len())),
            }
        });
        systems.collect()
    }
}

fn realtime(health: &Health) -> RealTime {
    RealTime {
        p50_us: health.lateness.p50(),
        p99_us: health.lateness.p99(),
        max_us: health.lateness.max,
        compute_p99_us: health.compute.p99(),
        compute_max_us: health.compute.max,
        missed: health.overruns,
        fifo: health.fifo,
        memory_locked: health.memory_locked,
    }
}

/// CIPAxisState in words (spec/axis-and-data-types.md §8.5).
fn state_name(state: i16) -> &'static str {
    match state {
        2 => "Stopped",
        3 => "Starting",
        4 => "Running",
        6 => "Stopping",
        7 => "Aborting",
        8 => "Faulted",
        10 => "Shutdown",
        _ => "Unknown",
    }
}

/// The status bits of a tag, without those of faults and alarms, which have names of their own.
fn bits_of(image: &Image, tag: &str) -> Vec<Bit> {
    let Some(tag) = image.find(tag) else { return Vec::new() };
    let DataType::Structure(template) = &tag.tag_type.data_type else {
        return Vec::new();
    };
    let shown = |offset: u32| {
        let word = word_at(template, offset);
        !word.contains("Fault") && !word.contains("Alarm")
    };
    let members = template.members.iter();
    let bits = members.filter_map(|member| {
        let bit = member.bit.filter(|_| shown(member.offset))?;
        Some(Bit {
            name: member.name.clone(),
            offset: member.offset as usize,
            mask: 1 << bit,
        })
    });
    bits.collect()
}

/// The name of the word that holds the byte at an offset.
fn word_at(template: &Template, offset: u32) -> &str {
    let words = template.members.iter().filter(|member| member.bit.is_none());
    let mut holding = words.filter(|member| (member.offset..member.offset + member.size() as u32).contains(&offset));
    holding.next().map_or("", |member| &member.name)
}

/// The names of the bits that are set.
fn set(image: &Image, tag: &str, bits: &[Bit]) -> Vec<String> {
    let Some(tag) = image.find(tag) else { return Vec::new() };
    let bytes = image.bytes(tag.id);
    let on = |bit: &&Bit| bytes.get(bit.offset).is_some_and(|byte| byte & bit.mask != 0);
    bits.iter().filter(on).map(|bit| bit.name.clone()).collect()
}
