//! The invariants of each tick, M1 to M3, and the deadlines of stops, L1 and L2.

use arcline_controller::machine::Machine;
use arcline_controller::{AxisSnapshot, Snapshot};
use arcline_instruction_set::predefined::axis_status;

use crate::path::Path;
use crate::record::Record;

/// The check of every tick.
pub(crate) struct Watch {
    limits: Vec<[f64; 2]>,
    period: f64,
    before: Option<Vec<AxisSnapshot>>,
    /// The number of ticks for which motion has been inhibited.
    inhibited: u64,
    deadlines: Vec<Deadline>,
    path: Path,
    /// Hash of the command positions of all ticks.
    pub(crate) hash: crate::record::Fnv,
    pub(crate) moving: bool,
}

/// An axis must stand at a time.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Deadline {
    pub(crate) axis: usize,
    /// ms of the scenario.
    pub(crate) at: u64,
    pub(crate) why: &'static str,
}

impl Watch {
    pub(crate) fn new(machine: &Machine) -> Self {
        let limits = machine.axes.iter().map(|axis| {
            let most = |one: f64, other: f64| one.max(other);
            [axis.max_speed, most(axis.max_acceleration, axis.max_deceleration)]
        });
        Watch {
            limits: limits.collect(),
            period: machine.period(),
            before: None,
            inhibited: 0,
            deadlines: Vec::new(),
            path: Path::default(),
            hash: crate::record::Fnv::default(),
            moving: false,
        }
    }

    /// The server has ended: the next tick is one of another.
    pub(crate) fn restart(&mut self) {
        self.before = None;
        self.inhibited = 0;
        self.deadlines.clear();
        self.path.restart();
    }

    pub(crate) fn expect_rest(&mut self, deadline: Deadline) {
        self.deadlines.push(deadline);
    }

    /// No task beside the tick runs in this millisecond: deadlines of late messages move by as much.
    pub(crate) fn postpone(&mut self) {
        self.deadlines.iter_mut().for_each(|deadline| deadline.at += 1);
    }

    /// The axis is moved again on purpose.
    pub(crate) fn forget(&mut self, axis: usize) {
        self.deadlines.retain(|deadline| deadline.axis != axis);
    }

    /// A line of CS1 may begin.
    pub(crate) fn expect_line(&mut self, target: [f64; 3]) {
        self.path.expect(target);
    }

    /// The line was refused.
    pub(crate) fn forget_line(&mut self, target: [f64; 3]) {
        self.path.forget(target);
    }

    /// Checks a tick; `is_inhibited` is the state before it.
    pub(crate) fn see(&mut self, snapshot: &Snapshot, is_inhibited: bool, record: &Record) {
        self.inhibited = if is_inhibited { self.inhibited + 1 } else { 0 };
        self.moving = false;
        if let Some(off) = self.path.see(&snapshot.axes, is_inhibited) {
            record.violated("M1", &format!("a line of CS1 is left by {off}"));
        }
        for (index, (axis, [speed, rate])) in snapshot.axes.iter().zip(&self.limits).enumerate() {
            let [position, velocity, acceleration] = axis.command;
            self.hash.add(&position.to_bits().to_le_bytes());
            self.moving |= velocity != 0.0;
            if velocity.abs() > speed * SLACK || acceleration.abs() > rate * SLACK {
                record.violated(
                    "M1",
                    &format!("axis {index}: velocity {velocity}, acceleration {acceleration}"),
                );
            }
            let Some(before) = self.before.as_ref().map(|axes| &axes[index]) else {
                continue;
            };
            let step = (position - before.command[0]).abs();
            if step > speed * self.period * SLACK {
                record.violated("M2", &format!("axis {index}: a step of {step} in one tick"));
            }
            let is_on = |axis: &AxisSnapshot| axis.status & axis_status::SERVO_ACTION_STATUS != 0;
            // An axis coasts after a fault has switched it off.
            let coasts = axis.faults.kinds().next().is_some() && velocity.abs() <= before.command[1].abs();
            if !is_on(before) && !is_on(axis) && velocity != 0.0 && !coasts {
                record.violated(
                    "M3",
                    &format!("axis {index} is off and moves: {before:?}, then {axis:?}"),
                );
            }
            // The jerk is limited: an acceleration ends, but not at once.
            let faster = velocity.abs() > before.command[1].abs() + 1e-9;
            if self.inhibited > 2 && faster && acceleration.abs() > before.command[2].abs() + 1e-6 {
                record.violated("M3", &format!("axis {index} accelerates to {velocity} under STOP"));
            }
            // The longest stop: from the highest speed at the highest deceleration.
            if self.inhibited as f64 * self.period > 2.0 * speed / rate + 0.1 && velocity != 0.0 {
                record.violated("M3", &format!("axis {index} still moves at {velocity} under STOP"));
            }
        }
        match &mut self.before {
            Some(before) => before.copy_from_slice(&snapshot.axes),
            None => self.before = Some(snapshot.axes.clone()),
        }
    }

    /// Holds the deadlines that are due.
    pub(crate) fn due(&mut self, now: u64, record: &Record) {
        let Some(axes) = &self.before else { return };
        self.deadlines.retain(|deadline| {
            let velocity = axes[deadline.axis].command[1];
            if deadline.at <= now && velocity != 0.0 {
                record.violated(
                    "L1",
                    &format!("axis {} moves at {velocity}: {}", deadline.axis, deadline.why),
                );
            }
            deadline.at > now
        });
    }
}

/// Rounding.
const SLACK: f64 = 1.000_001;
