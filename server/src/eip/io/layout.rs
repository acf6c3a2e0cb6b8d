//! The bytes of the input and output assemblies (docs/IO.md): which number stands where.
//!
//! All fields are four bytes, little-endian: UDINT or REAL. Only the tables here have them; the page
//! is written from them by a test. Positions are in position units, overrides in percent.

use arcline_controller::Snapshot;
use arcline_controller::machine::Machine;
use arcline_motion::{AxisSnapshot, SystemSnapshot};
use arcline_proto::io::{Assemblies, Assembly};
use bytes::{BufMut, BytesMut};

/// Instance of the input assembly.
pub(crate) const INPUT: u32 = 100;
/// Instance of the output assembly.
pub(crate) const OUTPUT: u32 = 150;
/// Instance of the configuration assembly, which has no data.
pub(crate) const CONFIGURATION: u32 = 151;
/// Connection point in place of the output: inputs only.
pub(crate) const INPUT_ONLY: u32 = 254;
/// Connection point in place of the output: listens only.
pub(crate) const LISTEN_ONLY: u32 = 255;

/// Bits of the command word. The first three act when they rise.
pub(crate) mod command {
    /// Holds every coordinate system.
    pub(crate) const HOLD: u32 = 1 << 0;
    /// Goes on after a hold.
    pub(crate) const RESUME: u32 = 1 << 1;
    /// Stops everything that moves.
    pub(crate) const STOP: u32 = 1 << 2;
    /// Takes the feed overrides.
    pub(crate) const OVERRIDE: u32 = 1 << 3;
}

/// Bits of the connection status.
pub(crate) mod status {
    /// The outputs have an owner.
    pub(crate) const OWNED: u32 = 1 << 0;
    /// The owner is in run.
    pub(crate) const RUN: u32 = 1 << 1;
    /// The newest outputs hold a feed override that is out of range.
    pub(crate) const REFUSED: u32 = 1 << 2;
}

/// A number in an assembly.
pub(crate) struct Field<T> {
    /// Name; a name that ends in `[n]` is an element.
    pub(crate) name: &'static str,
    /// Meaning.
    pub(crate) meaning: &'static str,
    number: Number<T>,
}

enum Number<T> {
    Word(fn(&T) -> u32),
    Real(fn(&T) -> f64),
}

impl<T> Field<T> {
    const fn word(name: &'static str, meaning: &'static str, of: fn(&T) -> u32) -> Self {
        Self {
            name,
            meaning,
            number: Number::Word(of),
        }
    }

    const fn real(name: &'static str, meaning: &'static str, of: fn(&T) -> f64) -> Self {
        Self {
            name,
            meaning,
            number: Number::Real(of),
        }
    }

    /// Name of its type.
    pub(crate) const fn type_name(&self) -> &'static str {
        match self.number {
            Number::Word(_) => "UDINT",
            Number::Real(_) => "REAL",
        }
    }

    fn put(&self, from: &T, out: &mut BytesMut) {
        match self.number {
            Number::Word(of) => out.put_u32_le(of(from)),
            Number::Real(of) => out.put_f32_le(of(from) as f32),
        }
    }
}

/// The fields in front of the inputs.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Head {
    /// The tick of the data; it wraps.
    pub(crate) tick: u32,
    /// Bits of [`status`].
    pub(crate) status: u32,
    /// The command word that was applied last.
    pub(crate) command: u32,
}

pub(crate) const HEAD: [Field<Head>; 3] = [
    Field::word(
        "Tick",
        "number of the coarse update that the data is of; it wraps",
        |head| head.tick,
    ),
    Field::word(
        "ConnectionStatus",
        "bit 0: the outputs have an owner; bit 1: it is in run; bit 2: its newest outputs hold a feed override that is out of range and was not taken",
        |head| head.status,
    ),
    Field::word("CommandEcho", "the command word that was applied last", |head| {
        head.command
    }),
];

pub(crate) const SYSTEM: [Field<SystemSnapshot>; 6] = [
    Field::word("CoordinateSystemStatus", "as the member of its tag", |system| {
        system.status
    }),
    Field::word("CoordinateMotionStatus", "as the member of its tag", |system| {
        system.motion_status
    }),
    Field::real("FeedOverride", "percent", |system| system.feed_override * 100.0),
    Field::real("ActualPosition[0]", "position units; 0 beyond its axes", |system| {
        system.actual[0]
    }),
    Field::real("ActualPosition[1]", "position units", |system| system.actual[1]),
    Field::real("ActualPosition[2]", "position units", |system| system.actual[2]),
];

pub(crate) const AXIS: [Field<AxisSnapshot>; 5] = [
    Field::word("AxisFault", "as the member of its tag", |axis| axis.fault),
    Field::word("AxisStatus", "as the member of its tag", |axis| axis.status),
    Field::word("MotionStatus", "as the member of its tag", |axis| axis.motion_status),
    Field::word(
        "CIPAxisStatus",
        "as the member of its tag; 0 of a virtual axis",
        |axis| axis.cip_status,
    ),
    Field::real("ActualPosition", "position units", |axis| axis.actual[0]),
];

/// Bytes of a field.
pub(crate) const FIELD: usize = 4;
/// Bytes of the first field of the inputs, which is never the same twice.
pub(crate) const TICK: usize = FIELD;

/// The assemblies of a machine.
pub(crate) fn assemblies(machine: &Machine) -> Assemblies {
    let (systems, axes) = (machine.systems.len(), machine.axes.len());
    let size = |fields: usize| u16::try_from(fields * FIELD).expect("a machine has few systems and axes");
    Assemblies {
        input: Assembly {
            instance: INPUT,
            size: size(HEAD.len() + SYSTEM.len() * systems + AXIS.len() * axes),
        },
        output: Assembly {
            instance: OUTPUT,
            size: size(1 + systems),
        },
        configuration: CONFIGURATION,
        input_only: INPUT_ONLY,
        listen_only: LISTEN_ONLY,
    }
}

/// Appends the input assembly; the tick is the snapshot's.
pub(crate) fn encode_input(head: Head, snapshot: &Snapshot, out: &mut BytesMut) {
    let head = Head {
        tick: snapshot.tick as u32,
        ..head
    };
    HEAD.iter().for_each(|field| field.put(&head, out));
    for system in &snapshot.systems {
        SYSTEM.iter().for_each(|field| field.put(system, out));
    }
    for axis in &snapshot.axes {
        AXIS.iter().for_each(|field| field.put(axis, out));
    }
}

/// Writes the head of an input assembly again, but for its tick.
pub(crate) fn renew_head(head: Head, input: &mut BytesMut) {
    let mut bytes = BytesMut::with_capacity(HEAD.len() * FIELD);
    HEAD.iter().for_each(|field| field.put(&head, &mut bytes));
    if let (Some(head), Some(bytes)) = (input.get_mut(FIELD..bytes.len()), bytes.get(FIELD..)) {
        head.copy_from_slice(bytes);
    }
}

/// Decodes the command word and the feed overrides of an output assembly. Overrides that the data lack are left out.
pub(crate) fn decode_output(data: &[u8]) -> Option<(u32, Vec<f32>)> {
    let (word, overrides) = data.split_first_chunk()?;
    let overrides = overrides.as_chunks::<FIELD>().0.iter();
    Some((
        u32::from_le_bytes(*word),
        overrides.map(|bytes| f32::from_le_bytes(*bytes)).collect(),
    ))
}
