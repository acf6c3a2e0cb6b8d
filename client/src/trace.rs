//! Every tick of any signals: the Trace object, class 0x0304 (docs/TRACE.md).
//!
//! Not here: what a trace is written to. Ticks count from the start of the server; values are exact 64-bit numbers.

use std::time::Duration;

use bytes::{BufMut, Bytes, BytesMut};

use arcline_instruction_set::{Flag, Mnemonic};
use arcline_proto::cip::{CipStatus, Request, service};
use arcline_proto::epath::Epath;
use arcline_proto::wire::Reader;

use crate::{Client, ClientError};

const CLASS: u16 = 0x0304;
/// Class attribute: coarse update period, UDINT ns.
const PERIOD: u16 = 8;
/// Services of the class and of an instance.
const LIST_SIGNALS: u8 = 0x32;
const READ: u8 = 0x33;
const STOP: u8 = 0x07;
/// A name is refused with this status and its place; this place is the trigger's.
const TRIGGER_PLACE: u16 = 0xFFFF;
/// Most signals that are listed.
const MAX_SIGNALS: usize = 65_535;
/// Samples of a row: what a trace can have.
const MAX_WIDTH: u16 = 256;

/// When a trace begins.
#[derive(Clone, PartialEq, Debug, Default)]
pub enum Trigger {
    /// At once.
    #[default]
    Now,
    /// A signal comes to a level from below.
    Rises {
        /// Its name.
        signal: String,
        /// In its units.
        level: f64,
    },
    /// A signal comes to a level from above.
    Falls {
        /// Its name.
        signal: String,
        /// In its units.
        level: f64,
    },
    /// A bit becomes true.
    True {
        /// Its name.
        signal: String,
    },
    /// A bit becomes false.
    False {
        /// Its name.
        signal: String,
    },
    /// A bit of an instruction is set.
    Instruction {
        /// A motion control tag, an instruction tag, or a mnemonic.
        name: String,
        /// Which bit.
        flag: Flag,
    },
}

/// What is traced.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct TraceRequest {
    /// Such as `X.CommandPosition`, in the order of the samples.
    pub signals: Vec<String>,
    /// Ticks in front of the trigger.
    pub before: u32,
    /// Ticks from the trigger on; 0: until it is stopped.
    pub length: u32,
    /// Every how many ticks a row; 0 and 1: every tick.
    pub every: u16,
    /// When it begins.
    pub trigger: Trigger,
}

/// How a trace stands.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum TraceState {
    /// Waits for its trigger.
    Armed,
    /// Records.
    Running,
    /// Has all it was asked for, or has been stopped.
    Ended,
}

/// Rows of a trace, without a gap between them.
#[derive(Clone, PartialEq, Debug)]
pub struct TraceRows {
    /// How the trace stands.
    pub state: TraceState,
    /// Tick of the first row.
    pub first: u64,
    /// Ticks from row to row.
    pub every: u16,
    /// One sample for each signal.
    pub rows: Vec<Vec<f64>>,
}

impl TraceRows {
    /// What the next request asks from.
    pub fn next(&self) -> u64 {
        self.first
            .saturating_add(self.rows.len() as u64 * u64::from(self.every.max(1)))
    }
}

impl Client {
    /// The coarse update period: the time of a tick.
    ///
    /// # Errors
    /// [`ClientError::Refused`] when the server has no Trace object.
    pub async fn trace_period(&self) -> Result<Duration, ClientError> {
        let path = Epath::attribute(CLASS, 0, PERIOD);
        let reply = self
            .ask("the trace", service::GET_ATTRIBUTE_SINGLE, path, Bytes::new())
            .await?;
        let nanoseconds = Reader::new(&reply.data).u32().ok_or(CUT)?;
        Ok(Duration::from_nanos(nanoseconds.into()))
    }

    /// The signals that can be traced; the bits of words, which can be traced too, are not listed.
    ///
    /// # Errors
    /// As [`Client::trace_period`].
    pub async fn trace_signals(&self) -> Result<Vec<String>, ClientError> {
        let mut names: Vec<String> = Vec::new();
        loop {
            let from = u16::try_from(names.len()).map_err(|_| CUT)?;
            let mut data = BytesMut::new();
            data.put_u16_le(from);
            let reply = self
                .ask("the trace", LIST_SIGNALS, Epath::object(CLASS, 0), data.freeze())
                .await?;
            let mut reader = Reader::new(&reply.data);
            let (total, count) = reader.u16().zip(reader.u16()).ok_or(CUT)?;
            for _ in 0..count {
                let length = reader.u8().ok_or(CUT)?;
                let name = reader.take(length.into()).ok_or(CUT)?;
                names.push(String::from_utf8_lossy(name).into_owned());
            }
            if count == 0 || names.len() >= usize::from(total).min(MAX_SIGNALS) {
                return Ok(names);
            }
        }
    }

    /// Arms a trace. Gives its instance, which is deleted when nobody asks about it for a minute.
    ///
    /// # Errors
    /// [`ClientError::UnknownTag`] for a signal, a tag or an instruction that there is not; [`ClientError::Refused`] when
    /// there are too many traces, or one is too long.
    pub async fn start_trace(&self, request: &TraceRequest) -> Result<u32, ClientError> {
        let data = encode(request)?;
        let reply = self
            .request(Request::new(service::CREATE, Epath::object(CLASS, 0), data))
            .await?;
        if reply.status.is_success() {
            return Reader::new(&reply.data).u32().ok_or(CUT);
        }
        let place = reply.status.additional().first().copied();
        let is_name = reply.status.general() == CipStatus::PATH_DESTINATION_UNKNOWN.general();
        let Some(place) = place.filter(|_| is_name) else {
            return Err(ClientError::refused("the trace", reply.status));
        };
        let name = match &request.trigger {
            Trigger::Rises { signal, .. } | Trigger::Falls { signal, .. } if place == TRIGGER_PLACE => signal,
            Trigger::True { signal } | Trigger::False { signal } if place == TRIGGER_PLACE => signal,
            Trigger::Instruction { name, .. } if place == TRIGGER_PLACE => {
                return Err(ClientError::unknown_tag(
                    name,
                    self.instruction_names().await.unwrap_or_default(),
                ));
            }
            _ => request.signals.get(usize::from(place)).ok_or(CUT)?,
        };
        let known = self.trace_signals().await.unwrap_or_default();
        Err(ClientError::unknown_tag(name, known))
    }

    /// What can stand for an instruction in a trigger: motion control tags, instruction tags, mnemonics. A motion control tag
    /// that its first execution will make can too, and is not among them.
    ///
    /// # Errors
    /// As [`Client::browse`].
    pub async fn instruction_names(&self) -> Result<Vec<String>, ClientError> {
        let tags = self.browse().await?.into_iter();
        let of_type = |name: &str| name == "MOTION_INSTRUCTION" || name.parse::<Mnemonic>().is_ok();
        let tags = tags.filter(|tag| of_type(&tag.type_name())).map(|tag| tag.name);
        Ok(tags.chain(Mnemonic::ALL.iter().map(ToString::to_string)).collect())
    }

    /// The rows of a trace from a tick on, as many as one reply holds; `from` 0 is its beginning.
    ///
    /// # Errors
    /// What the session meets.
    pub async fn read_trace(&self, instance: u32, from: u64) -> Result<TraceRows, ClientError> {
        let mut data = BytesMut::new();
        data.put_u64_le(from);
        data.put_u16_le(0);
        let path = Epath::object(CLASS, instance);
        let reply = self.ask("the trace", READ, path, data.freeze()).await?;
        decode(&reply.data).ok_or(CUT)
    }

    /// Ends a trace; what it has recorded can still be read.
    ///
    /// # Errors
    /// What the session meets.
    pub async fn stop_trace(&self, instance: u32) -> Result<(), ClientError> {
        self.ask("the trace", STOP, Epath::object(CLASS, instance), Bytes::new())
            .await
            .map(drop)
    }

    /// Deletes a trace.
    ///
    /// # Errors
    /// What the session meets.
    pub async fn delete_trace(&self, instance: u32) -> Result<(), ClientError> {
        let path = Epath::object(CLASS, instance);
        self.ask("the trace", service::DELETE, path, Bytes::new())
            .await
            .map(drop)
    }
}

fn encode(request: &TraceRequest) -> Result<BytesMut, ClientError> {
    let mut data = BytesMut::new();
    data.put_u32_le(request.before);
    data.put_u32_le(request.length);
    data.put_u16_le(request.every);
    match &request.trigger {
        Trigger::Now => data.put_u8(0),
        Trigger::Rises { signal, level } => {
            data.put_u8(1);
            put_name(&mut data, signal)?;
            data.put_f64_le(*level);
        }
        Trigger::Falls { signal, level } => {
            data.put_u8(2);
            put_name(&mut data, signal)?;
            data.put_f64_le(*level);
        }
        Trigger::True { signal } => {
            data.put_u8(3);
            put_name(&mut data, signal)?;
        }
        Trigger::False { signal } => {
            data.put_u8(4);
            put_name(&mut data, signal)?;
        }
        Trigger::Instruction { name, flag } => {
            data.put_u8(5);
            put_name(&mut data, name)?;
            data.put_u32_le(flag.mask());
        }
    }
    let claimed = request.signals.len();
    let count = u16::try_from(claimed).ok().filter(|count| *count <= MAX_WIDTH);
    data.put_u16_le(count.ok_or(ClientError::TooLarge {
        what: "the number of signals",
        claimed,
        limit: MAX_WIDTH.into(),
    })?);
    for signal in &request.signals {
        put_name(&mut data, signal)?;
    }
    Ok(data)
}

fn put_name(data: &mut BytesMut, name: &str) -> Result<(), ClientError> {
    let limit = usize::from(u8::MAX);
    let length = u8::try_from(name.len()).map_err(|_| ClientError::TooLarge {
        what: "the length of a name",
        claimed: name.len(),
        limit,
    })?;
    data.put_u8(length);
    data.put_slice(name.as_bytes());
    Ok(())
}

fn decode(data: &[u8]) -> Option<TraceRows> {
    let mut reader = Reader::new(data);
    let state = match reader.u8()? {
        0 => TraceState::Armed,
        1 => TraceState::Running,
        _ => TraceState::Ended,
    };
    reader.u8()?;
    let (count, width, every) = (reader.u16()?, reader.u16()?, reader.u16()?);
    let first = reader.u64()?;
    let mut rows = Vec::new();
    for _ in 0..count {
        let row: Option<Vec<f64>> = (0..width).map(|_| reader.array().map(f64::from_le_bytes)).collect();
        rows.push(row?);
    }
    Some(TraceRows {
        state,
        first,
        every,
        rows,
    })
}

const CUT: ClientError = ClientError::Malformed {
    what: "a reply of the trace is cut",
};

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn requests_and_rows_are_laid_out_as_documented() {
        let request = TraceRequest {
            signals: vec!["X.A".to_owned()],
            before: 5,
            length: 7,
            every: 2,
            trigger: Trigger::Instruction {
                name: "M1".to_owned(),
                flag: Flag::Pc,
            },
        };
        let bytes = encode(&request).expect("short enough");
        #[rustfmt::skip]
        assert_eq!(bytes[..], [5, 0, 0, 0, 7, 0, 0, 0, 2, 0, 5, 2, b'M', b'1', 0, 0, 0, 8, 1, 0, 3, b'X', b'.', b'A']);
        let mut reply = BytesMut::new();
        reply.put_slice(&[1, 0, 2, 0, 1, 0, 3, 0]);
        reply.put_u64_le(100);
        reply.put_f64_le(1.5);
        reply.put_f64_le(-2.5);
        let rows = decode(&reply).expect("rows");
        assert_eq!((rows.state, rows.first, rows.next()), (TraceState::Running, 100, 106));
        assert_eq!(rows.rows, [[1.5], [-2.5]]);
        for length in 0..reply.len() {
            assert_eq!(decode(&reply[..length]), None, "cut to {length}");
        }
        let long = TraceRequest {
            signals: vec!["X".to_owned(); 300],
            ..TraceRequest::default()
        };
        assert!(matches!(encode(&long), Err(ClientError::TooLarge { claimed: 300, .. })));
    }
}
