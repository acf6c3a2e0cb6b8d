//! The motion classes 0x0300 to 0x0302: ids of their attributes, lists of instances, and the reply of their services.
//!
//! Instances count from 1 in the order of the configuration. The class codes are those of
//! `arcline_instruction_set::Object`; its `Attribute` defines the numeric attributes.

use std::fmt;

use bytes::{BufMut, Bytes, BytesMut};

use super::machine::Identification;
use super::{put_name, read_name};
use crate::wire::Reader;

/// Attribute 1 of all three classes: the name, SHORT_STRING.
pub const NAME: u16 = 1;

/// Attributes of the Motion Group, class 0x0300.
pub mod group {
    /// Coarse update period, UDINT, ns.
    pub const PERIOD: u16 = 2;
    /// The instances of its axes, a list of [`encode_instances`](super::encode_instances).
    pub const AXES: u16 = 3;
}

/// Attributes of an Axis, class 0x0301.
pub mod axis {
    /// USINT: 0 virtual, 1 servo.
    pub const KIND: u16 = 2;
    /// Position units, SHORT_STRING.
    pub const UNITS: u16 = 8;
    /// The causes of faults that are injected, UDINT, can be set.
    pub const INJECTED_FAULTS: u16 = 9;
    /// The causes of faults that can be injected, UDINT.
    pub const POSSIBLE_FAULTS: u16 = 10;
    /// The faults of the axis, UDINT.
    pub const FAULTS: u16 = 12;
    /// The origin of the axis's motion, a [`Mover`](super::Mover).
    pub const MOVER: u16 = 13;
}

/// Attributes of a Coordinate System, class 0x0302.
pub mod coordinate_system {
    /// The instances of its axes, a list of [`encode_instances`](super::encode_instances).
    pub const AXES: u16 = 2;
    /// Feed override, REAL, percent, 0 to 200, can be set.
    pub const FEED_OVERRIDE: u16 = 10;
    /// The last feed override that was not 0, REAL, percent.
    pub const OVERRIDE_BEFORE_HOLD: u16 = 11;
    /// First of the attributes 12 to 25: the dimensions of a robot, LREAL.
    pub const ROBOT: u16 = 12;
    /// Distance to go of the active move, LREAL, position units.
    pub const DISTANCE_TO_GO: u16 = 27;
    /// Length of the path of the active move, LREAL, position units; 0: no move is active.
    pub const PATH_LENGTH: u16 = 28;
    /// Time to the end of the active move, LREAL, s; NaN: not known.
    pub const TIME_LEFT: u16 = 29;
    /// The origin of the coordinate system's motion, a [`Mover`](super::Mover).
    pub const MOVER: u16 = 30;
}

/// A list of instances: `count UINT, instance UINT × count`.
pub fn encode_instances(instances: impl IntoIterator<Item = u16>) -> Bytes {
    let mut out = BytesMut::new();
    out.put_u16_le(0);
    let mut count = 0_u16;
    for instance in instances.into_iter().take(u16::MAX.into()) {
        out.put_u16_le(instance);
        count += 1;
    }
    if let Some(head) = out.first_chunk_mut::<2>() {
        *head = count.to_le_bytes();
    }
    out.freeze()
}

/// The other direction of [`encode_instances`]; `None` when the list is cut.
pub fn decode_instances(data: &[u8]) -> Option<Vec<u16>> {
    let mut reader = Reader::new(data);
    let count = reader.u16()?;
    (0..count).map(|_| reader.u16()).collect()
}

/// The kind of a [`Mover`].
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct MoverKind(pub u8);

impl MoverKind {
    /// The object does not move by an instruction.
    pub const NONE: Self = Self(0);
    /// A CIP client.
    pub const CLIENT: Self = Self(1);
    /// A viewer of the server's page.
    pub const VIEWER: Self = Self(2);
    /// A program that a viewer of the page has started.
    pub const PROGRAM: Self = Self(3);
    /// The outputs of implicit I/O.
    pub const IO: Self = Self(4);
    /// The server, such as the stop of a lost client.
    pub const SERVER: Self = Self(5);
    /// The program of the controller.
    pub const CONTROLLER: Self = Self(6);
}

/// The source of the motion of an axis or coordinate system: `kind USINT, line UDINT`, then `address, product, user, program`, each a
/// SHORT_STRING. A part that the client has not sent is empty.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct Mover {
    /// Its kind.
    pub kind: MoverKind,
    /// The line of the program's statement, from 1; 0: no line.
    pub line: u32,
    /// The address of the client; of a viewer with its number.
    pub address: String,
    /// The identification that the client has sent; its product also as its connection shows it.
    pub identification: Identification,
}

impl Mover {
    /// The value of the attribute.
    pub fn to_bytes(&self) -> Bytes {
        let mut out = BytesMut::new();
        out.put_u8(self.kind.0);
        out.put_u32_le(self.line);
        put_name(&mut out, &self.address);
        out.put_slice(&self.identification.to_bytes());
        out.freeze()
    }

    /// Reads the value; `None` when it is cut, or a text is no UTF-8.
    pub fn decode(data: &[u8]) -> Option<Self> {
        let mut reader = Reader::new(data);
        Some(Self {
            kind: MoverKind(reader.u8()?),
            line: reader.u32()?,
            address: read_name(&mut reader)?,
            identification: Identification {
                product: read_name(&mut reader)?,
                user: read_name(&mut reader)?,
                program: read_name(&mut reader)?,
            },
        })
    }
}

impl fmt::Display for Mover {
    /// `10.0.0.5:50123 (pycomm3)`, `the program of 10.0.0.7 #3 (Firefox 128), line 7`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            kind,
            line,
            address,
            identification,
        } = self;
        let address = if address.is_empty() { "a client" } else { address };
        match *kind {
            MoverKind::NONE => f.write_str("nothing"),
            MoverKind::IO => f.write_str("the outputs of implicit I/O"),
            MoverKind::SERVER => f.write_str("the server"),
            MoverKind::CONTROLLER => f.write_str("the program of the controller"),
            MoverKind::PROGRAM => write!(f, "the program of {address}{identification}, line {line}"),
            _ => write!(f, "{address}{identification}"),
        }
    }
}

/// The reply data of a motion service whose instruction was accepted: `instance UDINT, MOTION_INSTRUCTION`.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Accepted {
    /// Its instance of class 0x0303.
    pub instance: u32,
    /// The MOTION_INSTRUCTION structure as it was when DN or ER was set.
    pub control: [u8; Self::CONTROL],
}

impl Accepted {
    /// Bytes of a MOTION_INSTRUCTION.
    pub const CONTROL: usize = 16;
    /// Bytes of the reply data.
    pub const LEN: usize = 4 + Self::CONTROL;

    /// The reply data.
    pub fn to_bytes(&self) -> Bytes {
        let mut out = BytesMut::with_capacity(Self::LEN);
        out.put_u32_le(self.instance);
        out.put_slice(&self.control);
        out.freeze()
    }

    /// Reads reply data; `None` when it is cut.
    pub fn decode(data: &[u8]) -> Option<Self> {
        let mut reader = Reader::new(data);
        Some(Self {
            instance: reader.u32()?,
            control: reader.array()?,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn movers_are_read_as_they_were_written() {
        let mover = Mover {
            kind: MoverKind::PROGRAM,
            line: 7,
            address: "10.0.0.5 #3".into(),
            identification: Identification {
                product: "Firefox 128".into(),
                ..Identification::default()
            },
        };
        let data = mover.to_bytes();
        assert_eq!(&data[..6], &[3, 7, 0, 0, 0, 11]);
        assert_eq!(mover.to_string(), "the program of 10.0.0.5 #3 (Firefox 128), line 7");
        assert_eq!(Mover::decode(&data), Some(mover));
        for cut in 0..data.len() {
            assert_eq!(Mover::decode(&data[..cut]), None, "{cut}");
        }
        assert_eq!(Mover::decode(&Mover::default().to_bytes()), Some(Mover::default()));
    }
}
