//! A hash over everything that a bench shows: the proof that a change of the code changes no behaviour, to the bit.
//!
//! With `ARCLINE_TRACES=FILE` in the environment every bench hashes each of its snapshots, events and changes of faults, and
//! appends one line with the test's name and that hash when it is dropped. `tests/trace_table.py` makes a table with one
//! line per test of them, and compares it with the stored one.

use std::fs::OpenOptions;
use std::hash::{DefaultHasher, Hasher};
use std::io::Write;
use std::sync::OnceLock;

use arcline_controller::{AxisSnapshot, Event, FaultChange, Snapshot, SystemSnapshot};

/// The hash of one bench so far. Rename a field of a snapshot and the table stays as it is: only values are hashed.
pub(crate) struct Trace(DefaultHasher);

impl Trace {
    /// A trace to write, where the environment asks for one.
    pub(crate) fn asked() -> Option<Trace> {
        file().map(|_| Trace(DefaultHasher::new()))
    }

    /// One tick.
    pub(crate) fn snapshot(&mut self, snapshot: &Snapshot) {
        self.0.write_u64(snapshot.tick);
        self.0.write_u64(snapshot.lost_events);
        for axis in &snapshot.axes {
            self.axis(axis);
        }
        for system in &snapshot.systems {
            self.system(system);
        }
    }

    /// A change of a motion control tag.
    pub(crate) fn event(&mut self, event: &Event) {
        self.0.write_u64(event.tick);
        self.0.write_u64(event.ticket.0);
        self.0.write_u32(event.control.0);
        self.0.write_u8(u8::from(event.owner));
        self.0.write(event.mnemonic.name().as_bytes());
        self.0.write_u32(event.set);
        self.0.write_u32(event.clear);
        self.0.write_i16(event.err);
        self.0.write_i8(event.exerr);
        self.0.write_i32(event.segment);
        self.0.write(format!("{:?}", event.cause).as_bytes());
    }

    /// A change of an axis's faults.
    pub(crate) fn fault_change(&mut self, change: &FaultChange) {
        self.0.write_u64(change.tick);
        self.0.write_u16(change.axis.0);
        let sets = [change.set, change.again, change.clear];
        self.0.write(format!("{sets:?} {:?}", change.by).as_bytes());
    }

    fn axis(&mut self, axis: &AxisSnapshot) {
        for word in [
            axis.fault,
            axis.status,
            axis.event,
            axis.motion_status,
            axis.cip_status,
            axis.cip_io,
            axis.outputs,
        ] {
            self.0.write_u32(word);
        }
        for word in axis.motion_faults.iter().chain(&axis.output_cams) {
            self.0.write_u32(*word);
        }
        for word in axis.cip_faults {
            self.0.write_u64(word);
        }
        self.0.write(format!("{:?}", axis.faults).as_bytes());
        self.0.write_i16(axis.cip_state);
        for time in axis.registered_at.iter().flatten() {
            self.0.write_i32(*time);
        }
        let single = [axis.redefined, axis.average_velocity, axis.position_error, axis.watched];
        self.numbers(&single);
        for numbers in [
            axis.command,
            axis.actual,
            axis.master_offset,
            axis.registered[0],
            axis.registered[1],
        ] {
            self.numbers(&numbers);
        }
        self.numbers(&axis.started_at);
        self.numbers(&axis.strobed);
    }

    fn system(&mut self, system: &SystemSnapshot) {
        let words = [
            system.status,
            system.motion_status,
            system.fault,
            system.axes_faulted,
            system.axes_shutdown,
            system.axes_servo_on,
        ];
        for word in words {
            self.0.write_u32(word);
        }
        for frame in system.frames {
            self.0.write_i32(frame);
        }
        for turns in system.turns {
            self.0.write_i16(turns);
        }
        self.0.write_i32(system.configuration);
        self.numbers(&system.actual);
        self.numbers(&system.tool.unwrap_or_default());
        let along = [
            system.path_speed,
            system.path_position,
            system.path_length,
            system.feed_override,
        ];
        self.numbers(&along);
    }

    /// Bits of numbers; both zeros are one, and so is everything that is no number.
    fn numbers(&mut self, numbers: &[f64]) {
        for number in numbers {
            let one = if number.is_nan() { f64::NAN } else { number + 0.0 };
            self.0.write_u64(one.to_bits());
        }
    }
}

impl Drop for Trace {
    fn drop(&mut self) {
        let Some(file) = file() else { return };
        let thread = std::thread::current();
        let line = format!("{}\t{:016x}\n", thread.name().unwrap_or("unnamed"), self.0.finish());
        let written = OpenOptions::new().append(true).create(true).open(file);
        let written = written.and_then(|mut file| file.write_all(line.as_bytes()));
        if let Err(error) = written {
            eprintln!("the trace cannot be written to {file}: {error}");
        }
    }
}

fn file() -> Option<&'static str> {
    static FILE: OnceLock<Option<String>> = OnceLock::new();
    FILE.get_or_init(|| std::env::var("ARCLINE_TRACES").ok()).as_deref()
}
