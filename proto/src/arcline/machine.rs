//! Machine, class 0x0305: STOP, the identification of a client, series of moves, and counters of commands (docs/spec/contract.md §4, §7).
//!
//! One instance, number 1. Not here: the stops of single objects, which are instructions.

use std::fmt;

use bytes::{BufMut, Bytes, BytesMut};

use super::motion::Accepted;
use super::{RequestReader, put_name, read_name};
use crate::cip::{CipStatus, REPLY_HEAD, Reply};
use crate::wire::Reader;

/// The class code.
pub const CLASS: u16 = 0x0305;
/// The only instance.
pub const INSTANCE: u32 = 1;

/// Services of the instance.
pub mod service {
    /// STOP: stops all motion and inhibits it until [`RELEASE`]. No data.
    pub const STOP: u8 = 0x32;
    /// Releases a STOP, of every client. No data.
    pub const RELEASE: u8 = 0x33;
    /// Identifies the client to the server, by an [`Identification`](super::Identification).
    pub const IDENTIFY: u8 = 0x34;
    /// Executes moves of coordinate systems in their order up to the first that fails or finds no room. The data is that of a Multiple
    /// Service Packet with the motion services, the reply data a [`SeriesReply`](super::SeriesReply).
    pub const EXECUTE_SERIES: u8 = 0x35;
    /// Lets ticks pass on the step clock, a [`Step`](super::Step). The reply comes when they have passed.
    pub const STEP: u8 = 0x36;
}

/// Attributes of the instance.
pub mod attribute {
    /// Whether STOP inhibits motion, BOOL.
    pub const MOTION_INHIBITED: u16 = 1;
    /// The commands since the start by their kind, a list of [`encode_counts`](super::encode_counts).
    pub const COMMANDS: u16 = 2;
    /// The mode of the controller's program, a [`ControllerMode`](super::ControllerMode) as USINT. It can be set to 1 and 2.
    pub const MODE: u16 = 3;
    /// The major fault that has stopped the program, in words, as `length UINT` and UTF-8; empty: none.
    pub const MAJOR_FAULT: u16 = 4;
    /// The tick, ULINT: the coarse update periods since the start.
    pub const TICK: u16 = 5;
    /// Whether the machine is on the step clock, BOOL.
    pub const IS_STEPPED: u16 = 6;
}

/// The mode of the controller's program.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum ControllerMode {
    /// The controller has no program.
    None,
    /// The tasks do not run.
    Program,
    /// The tasks run.
    Run,
    /// A major fault has stopped the tasks.
    Faulted,
}

impl ControllerMode {
    const ALL: [Self; 4] = [Self::None, Self::Program, Self::Run, Self::Faulted];

    /// Its number.
    pub fn number(self) -> u8 {
        self as u8
    }

    /// The mode of a number; `None`: there is no such mode.
    pub fn from_number(number: u8) -> Option<Self> {
        Self::ALL.into_iter().find(|mode| mode.number() == number)
    }

    /// Its word, for people.
    pub fn word(self) -> &'static str {
        match self {
            Self::None => "no program",
            Self::Program => "program",
            Self::Run => "run",
            Self::Faulted => "faulted",
        }
    }
}

/// A text as `length UINT` and UTF-8.
pub fn encode_text(text: &str) -> Bytes {
    let length = u16::try_from(text.len()).unwrap_or(u16::MAX);
    let mut out = BytesMut::with_capacity(2 + usize::from(length));
    out.put_u16_le(length);
    out.put_slice(text.as_bytes().get(..length.into()).unwrap_or_default());
    out.freeze()
}

/// The other direction of [`encode_text`]; `None` when it is cut or no UTF-8.
pub fn decode_text(data: &[u8]) -> Option<String> {
    let mut reader = Reader::new(data);
    let length = reader.u16()?;
    String::from_utf8(reader.take(length.into())?.to_vec()).ok()
}

/// Ticks that are to pass: `ticks UDINT`, then, where a tag is to end them, its path as SHORT_STRING.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct Step {
    /// How many, at most.
    pub ticks: u32,
    /// The tag that ends the steps when it is not 0; empty: none.
    pub until: String,
}

impl Step {
    /// The request data of [`service::STEP`].
    pub fn to_bytes(&self) -> Bytes {
        let mut out = BytesMut::new();
        out.put_u32_le(self.ticks);
        if !self.until.is_empty() {
            put_name(&mut out, &self.until);
        }
        out.freeze()
    }

    /// Reads request data.
    ///
    /// # Errors
    /// 0x13 when it is cut, 0x15 for bytes behind it, 0x20 for a path that is no UTF-8.
    pub fn decode(data: &[u8]) -> Result<Self, CipStatus> {
        let (ticks, rest) = data.split_first_chunk().ok_or(CipStatus::NOT_ENOUGH_DATA)?;
        let mut reader = RequestReader::new(rest);
        let until = if rest.is_empty() { String::new() } else { reader.name()? };
        reader.end()?;
        Ok(Self {
            ticks: u32::from_le_bytes(*ticks),
            until,
        })
    }
}

/// The identification that a client sends: `product, user, program`, each a SHORT_STRING that may be empty.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct Identification {
    /// The product with its version, such as `arcline 0.2.0`.
    pub product: String,
    /// The user.
    pub user: String,
    /// The program that the client runs.
    pub program: String,
}

impl Identification {
    /// The request data of [`service::IDENTIFY`].
    pub fn to_bytes(&self) -> Bytes {
        let mut out = BytesMut::new();
        for text in [&self.product, &self.user, &self.program] {
            put_name(&mut out, text);
        }
        out.freeze()
    }

    /// Reads request data.
    ///
    /// # Errors
    /// 0x13 when it is cut, 0x15 for bytes behind it, 0x20 for a text that is no UTF-8.
    pub fn decode(data: &[u8]) -> Result<Self, CipStatus> {
        let mut reader = RequestReader::new(data);
        let this = Self {
            product: reader.name()?,
            user: reader.name()?,
            program: reader.name()?,
        };
        reader.end()?;
        Ok(this)
    }

    /// With texts fit to be shown: printable characters, at most [`Self::LONGEST`] of each text.
    #[must_use]
    pub fn bounded(self) -> Self {
        let bounded = |text: String| text.chars().filter(|c| !c.is_control()).take(Self::LONGEST).collect();
        Self {
            product: bounded(self.product),
            user: bounded(self.user),
            program: bounded(self.program),
        }
    }

    /// Characters of a text that are shown.
    pub const LONGEST: usize = 60;
}

impl fmt::Display for Identification {
    /// ` (arcline 0.2.0, user jane, program part.st)`, to stand behind the address of the client; empty when the client has not identified itself.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let parts = [("", &self.product), ("user ", &self.user), ("program ", &self.program)];
        let known = parts.into_iter().filter(|(_, part)| !part.is_empty());
        let known: Vec<String> = known.map(|(word, part)| format!("{word}{part}")).collect();
        if known.is_empty() {
            return Ok(());
        }
        write!(f, " ({})", known.join(", "))
    }
}

/// The reply data of [`service::EXECUTE_SERIES`]: `accepted UINT, depth UINT`, an [`Accepted`] for each of the first moves, and the reply of
/// the next move if that has failed.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct SeriesReply {
    /// The first moves, which were accepted.
    pub accepted: Vec<Accepted>,
    /// The next move was not executed as its queue has no room: moves that can wait in that queue.
    pub full: Option<u16>,
    /// The next move has failed.
    pub failed: Option<Reply>,
}

impl SeriesReply {
    /// Bytes in front of the moves.
    const HEAD: usize = 4;
    /// Bytes of the longest reply of a move that has failed: with ERR and EXERR.
    const FAILED: usize = REPLY_HEAD + 2 * 2;

    /// How many moves a reply of at most `budget` bytes (head included) has room for.
    pub fn room(budget: usize) -> usize {
        budget.saturating_sub(REPLY_HEAD + Self::HEAD + Self::FAILED) / Accepted::LEN
    }

    /// The reply data.
    pub fn to_bytes(&self) -> Bytes {
        let mut out = BytesMut::new();
        out.put_u16_le(u16::try_from(self.accepted.len()).unwrap_or(u16::MAX));
        out.put_u16_le(self.full.map_or(0, |depth| depth.max(1)));
        for accepted in &self.accepted {
            out.put_slice(&accepted.to_bytes());
        }
        if let Some(failed) = &self.failed {
            failed.encode(&mut out);
        }
        out.freeze()
    }

    /// Reads reply data; `None` when it is cut.
    pub fn decode(data: &Bytes) -> Option<Self> {
        let mut reader = Reader::new(data);
        let (count, depth) = (reader.u16()?, reader.u16()?);
        let accepted = (0..count).map(|_| Accepted::decode(reader.take(Accepted::LEN)?));
        let accepted = accepted.collect::<Option<_>>()?;
        let rest = data.slice_ref(reader.rest());
        Some(Self {
            accepted,
            full: (depth > 0).then_some(depth),
            failed: if rest.is_empty() {
                None
            } else {
                Some(Reply::decode(&rest)?)
            },
        })
    }
}

/// Commands of one kind since the start.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct CommandCount {
    /// The kind, such as `instructions`.
    pub kind: String,
    /// Commands that were executed.
    pub done: u64,
    /// Commands that were refused.
    pub refused: u64,
}

/// A list of counts: `count UINT, (kind SHORT_STRING, done ULINT, refused ULINT) × count`.
pub fn encode_counts(counts: &[CommandCount]) -> Bytes {
    let mut out = BytesMut::new();
    let length = u16::try_from(counts.len()).unwrap_or(u16::MAX);
    out.put_u16_le(length);
    for count in counts.iter().take(length.into()) {
        put_name(&mut out, &count.kind);
        out.put_u64_le(count.done);
        out.put_u64_le(count.refused);
    }
    out.freeze()
}

/// The other direction of [`encode_counts`]; `None` when the list is cut or a kind is no UTF-8.
pub fn decode_counts(data: &[u8]) -> Option<Vec<CommandCount>> {
    let mut reader = Reader::new(data);
    let length = reader.u16()?;
    let count = |_| {
        Some(CommandCount {
            kind: read_name(&mut reader)?,
            done: reader.u64()?,
            refused: reader.u64()?,
        })
    };
    (0..length).map(count).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn identifications_are_read_as_they_were_written() {
        let identification = Identification {
            product: "arcline 0.2.0".into(),
            user: "jane".into(),
            program: String::new(),
        };
        let data = identification.to_bytes();
        assert_eq!(&data[..4], &[13, b'a', b'r', b'c']);
        assert_eq!(Identification::decode(&data), Ok(identification));
        for cut in 0..data.len() {
            assert_eq!(
                Identification::decode(&data[..cut]),
                Err(CipStatus::NOT_ENOUGH_DATA),
                "{cut}"
            );
        }
        let longer = [&data[..], &[0]].concat();
        assert_eq!(Identification::decode(&longer), Err(CipStatus::TOO_MUCH_DATA));
        assert_eq!(
            Identification::decode(&[1, 0xFF, 0, 0]),
            Err(CipStatus::INVALID_PARAMETER)
        );
    }

    #[test]
    fn an_identification_is_shown() {
        #[rustfmt::skip]
        let cases = [
            ("nothing",       ["", "", ""],                          ""),
            ("the product",   ["pycomm3", "", ""],                   " (pycomm3)"),
            ("all of it",     ["arcline 0.2.0", "jane", "part.st"],  " (arcline 0.2.0, user jane, program part.st)"),
            ("the user only", ["", "jane", ""],                      " (user jane)"),
            ("what a terminal would obey", ["a\u{1b}[31mb\n", "", ""], " (a[31mb)"),
        ];
        for (why, [product, user, program], expected) in cases {
            let identification = Identification {
                product: product.into(),
                user: user.into(),
                program: program.into(),
            };
            assert_eq!(identification.bounded().to_string(), expected, "{why}");
        }
        let long = Identification {
            user: "x".repeat(1000),
            ..Identification::default()
        };
        assert_eq!(long.bounded().user.len(), Identification::LONGEST);
    }

    #[test]
    fn replies_to_series_are_read_as_they_were_written() {
        let accepted = |instance| Accepted {
            instance,
            control: [7; Accepted::CONTROL],
        };
        let failed = || Reply::error(0x32, CipStatus::vendor(13, 4));
        let whole = SeriesReply {
            accepted: vec![accepted(5), accepted(6)],
            full: None,
            failed: Some(failed()),
        };
        let full = SeriesReply {
            full: Some(1000),
            ..SeriesReply::default()
        };
        for reply in [whole.clone(), full, SeriesReply::default()] {
            assert_eq!(SeriesReply::decode(&reply.to_bytes()), Some(reply));
        }
        let data = whole.to_bytes();
        let at_an_end = 4 + 2 * Accepted::LEN;
        for cut in (0..data.len()).filter(|cut| *cut != at_an_end) {
            assert_eq!(SeriesReply::decode(&data.slice(..cut)), None, "{cut}");
        }
        let budget = REPLY_HEAD + data.len();
        assert_eq!([SeriesReply::room(budget - 1), SeriesReply::room(budget)], [1, 2]);
    }

    #[test]
    fn modes_and_texts_are_read_as_they_were_written() {
        for (number, mode) in (0..).zip(ControllerMode::ALL) {
            assert_eq!(
                (mode.number(), ControllerMode::from_number(number)),
                (number, Some(mode))
            );
        }
        assert_eq!(ControllerMode::from_number(4), None);
        let data = encode_text("major fault 4/20");
        assert_eq!(decode_text(&data).as_deref(), Some("major fault 4/20"));
        for cut in 0..data.len() {
            assert_eq!(decode_text(&data[..cut]), None, "{cut}");
        }
    }

    #[test]
    fn counts_are_read_as_they_were_written() {
        let count = |kind: &str, done, refused| CommandCount {
            kind: kind.into(),
            done,
            refused,
        };
        let counts = vec![count("writes", 7, 1), count("stops", u64::MAX, 0)];
        let data = encode_counts(&counts);
        assert_eq!(decode_counts(&data), Some(counts));
        for cut in 0..data.len() {
            assert_eq!(decode_counts(&data[..cut]), None, "{cut}");
        }
        assert_eq!(decode_counts(&encode_counts(&[])), Some(Vec::new()));
    }
}
