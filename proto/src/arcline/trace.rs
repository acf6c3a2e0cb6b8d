//! Trace, class 0x0304: samples of every tick, by signal and from a trigger on (docs/TRACE.md).
//!
//! Not here: the names of the signals. Ticks count from the start of the server; samples are 64-bit floating point numbers.

use bytes::{BufMut, Bytes, BytesMut};

use super::RequestReader;
use crate::cip::CipStatus;
use crate::wire::{Reader, counted};

/// The class code.
pub const CLASS: u16 = 0x0304;
/// Signals of a trace at most.
pub const MAX_SIGNALS: u16 = 256;
/// An unknown name is refused with 0x05 and the index of its signal; this index stands for the name in the trigger.
pub const TRIGGER_INDEX: u16 = 0xFFFF;

/// Services besides Create, Delete and those of attributes.
pub mod service {
    /// On the class: [`ListSignals`](super::ListSignals).
    pub const LIST_SIGNALS: u8 = 0x32;
    /// On an instance: [`ReadRows`](super::ReadRows).
    pub const READ: u8 = 0x33;
    /// On an instance: arms the trace again.
    pub const START: u8 = 0x06;
    /// On an instance: ends the trace; its rows can still be read.
    pub const STOP: u8 = 0x07;
}

/// Attributes of the class.
pub mod class_attribute {
    /// Coarse update period, UDINT, ns.
    pub const PERIOD: u16 = 8;
    /// Signals that List Signals lists, UINT.
    pub const SIGNALS: u16 = 9;
    /// The oldest recorded tick, ULINT.
    pub const FIRST_TICK: u16 = 10;
    /// The tick behind the newest recorded one, ULINT.
    pub const NEXT_TICK: u16 = 11;
    /// Ticks that are stored at most, UDINT.
    pub const CAPACITY: u16 = 12;
    /// Ticks that were not recorded, UDINT.
    pub const MISSING: u16 = 13;
}

/// Attributes of a trace.
pub mod attribute {
    /// [`State`](super::State), USINT.
    pub const STATE: u16 = 1;
    /// The tick of the trigger, ULINT; 0 while armed.
    pub const TRIGGER_TICK: u16 = 2;
    /// Its first tick, ULINT; 0 while armed.
    pub const FIRST_TICK: u16 = 3;
    /// The tick behind its newest one, ULINT.
    pub const NEXT_TICK: u16 = 4;
    /// Number of signals, UINT.
    pub const SIGNALS: u16 = 5;
    /// Ticks from row to row, UINT.
    pub const EVERY: u16 = 6;
    /// Ticks inside the trace that were not recorded, UDINT.
    pub const MISSING: u16 = 7;
}

/// The state of a trace.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum State {
    /// 0: waits for its trigger.
    Armed,
    /// 1: records.
    Running,
    /// 2: has recorded all ticks that were asked for.
    Complete,
    /// 3: was stopped.
    Stopped,
}

impl State {
    /// The code on the wire.
    pub const fn code(self) -> u8 {
        match self {
            Self::Armed => 0,
            Self::Running => 1,
            Self::Complete => 2,
            Self::Stopped => 3,
        }
    }

    /// The state of a code. An unknown code is an ended trace: nothing more is read of it.
    pub const fn from_code(code: u8) -> Self {
        match code {
            0 => Self::Armed,
            1 => Self::Running,
            2 => Self::Complete,
            _ => Self::Stopped,
        }
    }
}

/// When a trace begins.
#[derive(Clone, PartialEq, Debug, Default)]
pub enum Trigger {
    /// 0: at once.
    #[default]
    Now,
    /// 1: a signal comes to a level from below.
    Rises {
        /// Its name.
        signal: String,
        /// In its units, finite.
        level: f64,
    },
    /// 2: a signal comes to a level from above.
    Falls {
        /// Its name.
        signal: String,
        /// In its units, finite.
        level: f64,
    },
    /// 3: a bit becomes true.
    BecomesTrue {
        /// Its name.
        signal: String,
    },
    /// 4: a bit becomes false.
    BecomesFalse {
        /// Its name.
        signal: String,
    },
    /// 5: one of some bits of an instruction is set.
    Instruction {
        /// A motion control tag, an instruction tag, or a mnemonic.
        name: String,
        /// Bits of MOTION_INSTRUCTION.FLAGS; 0: ER.
        flags: u32,
    },
}

impl Trigger {
    /// The name in it, of a signal or an instruction.
    pub fn name(&self) -> Option<&str> {
        match self {
            Self::Now => None,
            Self::Rises { signal, .. }
            | Self::Falls { signal, .. }
            | Self::BecomesTrue { signal }
            | Self::BecomesFalse { signal } => Some(signal),
            Self::Instruction { name, .. } => Some(name),
        }
    }

    const fn code(&self) -> u8 {
        match self {
            Self::Now => 0,
            Self::Rises { .. } => 1,
            Self::Falls { .. } => 2,
            Self::BecomesTrue { .. } => 3,
            Self::BecomesFalse { .. } => 4,
            Self::Instruction { .. } => 5,
        }
    }

    fn decode(reader: &mut RequestReader<'_>) -> Result<Self, CipStatus> {
        let code = reader.u8()?;
        if code == 0 {
            return Ok(Self::Now);
        }
        let name = match code {
            1..=5 => reader.name()?,
            _ => return Err(CipStatus::INVALID_PARAMETER),
        };
        let mut level = || {
            let level = reader.f64()?;
            level.is_finite().then_some(level).ok_or(CipStatus::INVALID_PARAMETER)
        };
        Ok(match code {
            1 => Self::Rises {
                level: level()?,
                signal: name,
            },
            2 => Self::Falls {
                level: level()?,
                signal: name,
            },
            3 => Self::BecomesTrue { signal: name },
            4 => Self::BecomesFalse { signal: name },
            _ => Self::Instruction {
                flags: reader.u32()?,
                name,
            },
        })
    }
}

/// Request data of Create: the signals of the trace and its trigger.
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

/// A request that the layout has no room for.
#[derive(Clone, Copy, PartialEq, Eq, Debug, thiserror::Error)]
pub enum TooLong {
    /// More than [`MAX_SIGNALS`].
    #[error("{count} signals, expected at most {MAX_SIGNALS}")]
    Signals {
        /// How many.
        count: usize,
    },
    /// A name of more than 255 bytes.
    #[error("a name of {bytes} bytes, expected at most 255")]
    Name {
        /// How many.
        bytes: usize,
    },
}

impl TraceRequest {
    /// The request data.
    ///
    /// # Errors
    /// [`TooLong`].
    pub fn to_bytes(&self) -> Result<Bytes, TooLong> {
        let mut out = BytesMut::new();
        out.put_u32_le(self.before);
        out.put_u32_le(self.length);
        out.put_u16_le(self.every);
        out.put_u8(self.trigger.code());
        if let Some(name) = self.trigger.name() {
            put_name(&mut out, name)?;
        }
        match &self.trigger {
            Trigger::Rises { level, .. } | Trigger::Falls { level, .. } => out.put_f64_le(*level),
            Trigger::Instruction { flags, .. } => out.put_u32_le(*flags),
            Trigger::Now | Trigger::BecomesTrue { .. } | Trigger::BecomesFalse { .. } => {}
        }
        let count = self.signals.len();
        let signals = u16::try_from(count).ok().filter(|count| *count <= MAX_SIGNALS);
        out.put_u16_le(signals.ok_or(TooLong::Signals { count })?);
        for signal in &self.signals {
            put_name(&mut out, signal)?;
        }
        Ok(out.freeze())
    }

    /// Reads request data.
    ///
    /// # Errors
    /// 0x13 and 0x15 for too little and too much data; 0x20 for a trigger there is not, a level that is not finite, no signal or
    /// more than [`MAX_SIGNALS`], and a name that is no UTF-8.
    pub fn decode(data: &[u8]) -> Result<Self, CipStatus> {
        let mut reader = RequestReader::new(data);
        let (before, length, every) = (reader.u32()?, reader.u32()?, reader.u16()?);
        let trigger = Trigger::decode(&mut reader)?;
        let count = reader.u16()?;
        if !(1..=MAX_SIGNALS).contains(&count) {
            return Err(CipStatus::INVALID_PARAMETER);
        }
        let signals = (0..count).map(|_| reader.name()).collect::<Result<_, _>>()?;
        reader.end()?;
        Ok(Self {
            signals,
            before,
            length,
            every,
            trigger,
        })
    }
}

fn put_name(out: &mut BytesMut, name: &str) -> Result<(), TooLong> {
    let bytes = name.len();
    out.put_u8(u8::try_from(bytes).map_err(|_| TooLong::Name { bytes })?);
    out.put_slice(name.as_bytes());
    Ok(())
}

/// Request data of List Signals: `first UINT`.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct ListSignals {
    /// Index of the first name that is asked for.
    pub first: u16,
}

impl ListSignals {
    /// The request data.
    pub fn to_bytes(self) -> Bytes {
        Bytes::copy_from_slice(&self.first.to_le_bytes())
    }

    /// Reads request data.
    ///
    /// # Errors
    /// 0x13, 0x15.
    pub fn decode(data: &[u8]) -> Result<Self, CipStatus> {
        let mut reader = RequestReader::new(data);
        let first = reader.u16()?;
        reader.end()?;
        Ok(Self { first })
    }
}

/// Reply data of List Signals: `total UINT, count UINT, SHORT_STRING × count`.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct SignalList {
    /// All signals that there are.
    pub total: u16,
    /// Names from the first one on that was asked for.
    pub names: Vec<String>,
}

impl SignalList {
    /// The reply data with as many of `names` as `room` bytes hold.
    pub fn encode<N: AsRef<str>>(total: u16, names: impl IntoIterator<Item = N>, room: usize) -> Bytes {
        let mut out = BytesMut::new();
        out.put_u16_le(total);
        out.put_u16_le(0);
        let mut count = 0_u16;
        for name in names.into_iter().take(u16::MAX.into()) {
            let (length, name) = counted(name.as_ref().as_bytes());
            if out.len() + 1 + name.len() > room {
                break;
            }
            out.put_u8(length);
            out.put_slice(name);
            count += 1;
        }
        if let Some(field) = out.get_mut(2..4) {
            field.copy_from_slice(&count.to_le_bytes());
        }
        out.freeze()
    }

    /// Reads reply data; `None` when it is cut.
    pub fn decode(data: &[u8]) -> Option<Self> {
        let mut reader = Reader::new(data);
        let (total, count) = (reader.u16()?, reader.u16()?);
        let mut names = Vec::new();
        for _ in 0..count {
            let length = reader.u8()?;
            names.push(String::from_utf8_lossy(reader.take(length.into())?).into_owned());
        }
        Some(Self { total, names })
    }
}

/// Request data of Read: `from ULINT, most UINT`.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct ReadRows {
    /// The tick of the first row; 0: the beginning of the trace.
    pub from: u64,
    /// Rows at most; 0: as many as the reply holds.
    pub most: u16,
}

impl ReadRows {
    /// The request data.
    pub fn to_bytes(self) -> Bytes {
        let mut out = BytesMut::with_capacity(10);
        out.put_u64_le(self.from);
        out.put_u16_le(self.most);
        out.freeze()
    }

    /// Reads request data.
    ///
    /// # Errors
    /// 0x13, 0x15.
    pub fn decode(data: &[u8]) -> Result<Self, CipStatus> {
        let mut reader = RequestReader::new(data);
        let (from, most) = (reader.u64()?, reader.u16()?);
        reader.end()?;
        Ok(Self { from, most })
    }
}

/// Reply data of Read: `state USINT, 0, rows UINT, signals UINT, every UINT, first ULINT, LREAL × rows × signals`.
#[derive(Clone, PartialEq, Debug)]
pub struct Rows {
    /// State of the trace.
    pub state: State,
    /// Samples of a row, 1 or more.
    pub signals: u16,
    /// Ticks from row to row.
    pub every: u16,
    /// Tick of the first row.
    pub first: u64,
    /// The samples, row by row.
    pub samples: Vec<f64>,
}

impl Rows {
    /// Bytes in front of the samples.
    pub const HEAD: usize = 16;

    /// Rows of `signals` samples that `room` bytes hold.
    pub fn fit(room: usize, signals: usize) -> usize {
        room.saturating_sub(Self::HEAD) / (signals.max(1) * size_of::<f64>())
    }

    /// The reply data.
    pub fn to_bytes(&self) -> Bytes {
        let rows = self.samples.len() / usize::from(self.signals.max(1));
        let mut out = BytesMut::with_capacity(Self::HEAD + self.samples.len() * size_of::<f64>());
        out.put_u8(self.state.code());
        out.put_u8(0);
        out.put_u16_le(u16::try_from(rows).unwrap_or(u16::MAX));
        out.put_u16_le(self.signals);
        out.put_u16_le(self.every);
        out.put_u64_le(self.first);
        self.samples.iter().for_each(|sample| out.put_f64_le(*sample));
        out.freeze()
    }

    /// Reads reply data; `None` when it is cut or its rows have no samples.
    pub fn decode(data: &[u8]) -> Option<Self> {
        let mut reader = Reader::new(data);
        let state = State::from_code(reader.u8()?);
        reader.u8()?;
        let (rows, signals, every) = (reader.u16()?, reader.u16()?, reader.u16()?);
        let first = reader.u64()?;
        let samples = reader.take(usize::from(rows) * usize::from(signals) * size_of::<f64>())?;
        let (samples, _) = samples.as_chunks();
        (signals > 0).then(|| Self {
            state,
            signals,
            every,
            first,
            samples: samples.iter().map(|sample| f64::from_le_bytes(*sample)).collect(),
        })
    }
}
