//! The bytes of a file, without any file.
//!
//! ```text
//! page 0    "ARCSTATE"   format u32   checksum u32
//! page 1    length u64   checksum u32                                   the horizon: bytes that the disk has
//! page 2    the same, of the synchronisation before or after
//! record    length u32   checksum u32   length bytes   checksum u32     the state
//! record    …                                                           changes, and other states
//! ```
//!
//! Little-endian; a page has 4,096 bytes, the rest of each is zero. A record's checksum is a CRC-32 over the header and all records before it but
//! for their checksums: a record that is missing, moved or of another file does not fit. A length has its own, so that a damaged one is not
//! mistaken for a record that was cut off. Format 2, which is still read, has no horizon: its records stand behind the header.

use crc32fast::Hasher;
use serde::Serialize;

use crate::codec::{self, Borrowed, MAX_RECORD, Record};
use crate::horizon::{self, PAGE};
use crate::{Damage, RetainedState};

/// The format that is written.
pub const FORMAT: u32 = 3;
/// Longest file that is read, bytes.
pub const MAX_FILE: usize = 4 * MAX_RECORD;

/// The contents of a file.
#[derive(Clone, Debug, PartialEq)]
pub struct FileContents {
    /// The state, with all changes.
    pub state: RetainedState,
    /// Bytes at the end that were cut off: an unfinished record, or the remains that a crash of the system left of records that were
    /// never synchronised.
    pub cut_off: usize,
}

/// The checksum so far.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Chain(u32);

impl Chain {
    /// Appends a [`Record`], or a [`Borrowed`] one.
    pub(crate) fn push(&mut self, record: &impl Serialize, out: &mut Vec<u8>) {
        let head = out.len();
        out.extend_from_slice(&[0; HEAD]);
        codec::encode(record, out);
        let length = u32::try_from(out.len() - head - HEAD)
            .expect("a record is far below 4 GiB")
            .to_le_bytes();
        let (chain, data) = (self.over(&length), head + HEAD);
        out[head..head + 4].copy_from_slice(&length);
        out[head + 4..data].copy_from_slice(&chain.0.to_le_bytes());
        *self = chain.over(&out[data..]);
        out.extend_from_slice(&self.0.to_le_bytes());
    }

    fn over(self, bytes: &[u8]) -> Self {
        let mut hasher = Hasher::new_with_initial(self.0);
        hasher.update(bytes);
        Chain(hasher.finalize())
    }
}

/// A whole file with a state and no changes. Its horizon is its end, since it is synchronised before it gets its name.
pub(crate) fn fresh(state: &RetainedState) -> (Vec<u8>, Chain) {
    let mut out = MAGIC.to_vec();
    out.extend_from_slice(&FORMAT.to_le_bytes());
    let mut chain = Chain(0).over(&out);
    out.extend_from_slice(&chain.0.to_le_bytes());
    out.resize(RECORDS, 0);
    chain.push(&Borrowed::State(state), &mut out);
    let (horizon, at) = (horizon::page(out.len()), horizon::offset(0));
    out[at..at + horizon.len()].copy_from_slice(&horizon);
    (out, chain)
}

/// Reads a file. Records that are not whole and stand behind its horizon are left out: they were never synchronised, and one that the end of
/// the process cut off was never answered.
///
/// # Errors
/// All other damage: bytes that differ from those written.
pub fn parse(bytes: &[u8]) -> Result<FileContents, Damage> {
    if bytes.len() > MAX_FILE {
        return Err(Damage::TooLong { limit: MAX_FILE });
    }
    let too_short = Damage::TooShort { length: bytes.len() };
    let (format, chain) = header(bytes)?;
    let (first, horizon) = match format {
        FORMAT => (RECORDS, horizon::of(bytes)),
        WITHOUT_HORIZON => (HEADER, None),
        found => {
            return Err(Damage::OtherFormat {
                found,
                expected: FORMAT,
            });
        }
    };
    let mut reader = RecordReader {
        bytes,
        end: first,
        chain,
    };
    let mut state = match reader.next()? {
        Some((Record::State(state), behind)) => {
            state.check()?;
            reader = behind;
            state
        }
        Some((Record::Changes(_), _)) => return Err(Damage::Record { offset: first }),
        None => return Err(too_short),
    };
    let damage = loop {
        match reader.next() {
            Ok(Some((record, behind))) => match state.apply(&record) {
                Ok(()) => reader = behind,
                Err(damage) => break Some(damage),
            },
            Ok(None) => break None,
            Err(damage) => break Some(damage),
        }
    };
    let end = reader.end;
    let lost = match horizon {
        Some(synchronised) if (end as u64) < synchronised => Some(damage.unwrap_or(Damage::Truncated {
            length: end,
            synchronised,
        })),
        Some(_) => None,
        None => damage.filter(|damage| !is_zero_from(bytes, end, damage)),
    };
    match lost {
        Some(damage) => Err(damage),
        None => Ok(FileContents {
            state,
            cut_off: bytes.len() - end,
        }),
    }
}

/// The format of a file, and the checksum behind its header.
fn header(bytes: &[u8]) -> Result<(u32, Chain), Damage> {
    let magic = &bytes[..bytes.len().min(MAGIC.len())];
    if !MAGIC.starts_with(magic) {
        return Err(Damage::NotAState);
    }
    let header = bytes.first_chunk::<HEADER>();
    let header = header.ok_or(Damage::TooShort { length: bytes.len() })?;
    let (told, checksum) = header.split_at(HEADER - CHECKSUM);
    let chain = Chain(0).over(told);
    if word(checksum) != chain.0 {
        let offset = HEADER - CHECKSUM;
        return Err(Damage::Checksum { offset });
    }
    Ok((word(&told[MAGIC.len()..]), chain))
}

/// Whether a file without a horizon has only zeros from the sector of the damage on. A crash of the system leaves such zeros in a file that
/// had grown before it was written.
fn is_zero_from(bytes: &[u8], end: usize, damage: &Damage) -> bool {
    let at = match damage {
        Damage::Checksum { offset } => offset - offset % SECTOR,
        _ => end,
    };
    bytes[at.max(end)..].iter().all(|byte| *byte == 0)
}

#[derive(Clone, Copy)]
struct RecordReader<'b> {
    bytes: &'b [u8],
    /// Behind the last whole record.
    end: usize,
    chain: Chain,
}

impl<'b> RecordReader<'b> {
    /// The next record and the reader behind it; `None`: no whole one is left.
    fn next(self) -> Result<Option<(Record, RecordReader<'b>)>, Damage> {
        let offset = self.end;
        let Some(head) = self.bytes.get(offset..).and_then(<[u8]>::first_chunk::<HEAD>) else {
            return Ok(None);
        };
        let (length, checksum) = head.split_at(HEAD - CHECKSUM);
        let chain = self.chain.over(length);
        if word(checksum) != chain.0 {
            return Err(Damage::Checksum { offset: offset + 4 });
        }
        let length = word(length) as usize;
        if length > MAX_RECORD {
            return Err(Damage::Record { offset });
        }
        let tail = offset + HEAD + length;
        let Some(checksum) = self.bytes.get(tail..tail + CHECKSUM) else {
            return Ok(None);
        };
        let data = &self.bytes[offset + HEAD..tail];
        let chain = chain.over(data);
        if word(checksum) != chain.0 {
            return Err(Damage::Checksum { offset: tail });
        }
        let record = codec::decode(data).ok_or(Damage::Record { offset })?;
        let end = tail + CHECKSUM;
        Ok(Some((record, RecordReader { end, chain, ..self })))
    }
}

fn word(bytes: &[u8]) -> u32 {
    bytes.first_chunk().copied().map_or(0, u32::from_le_bytes)
}

const MAGIC: [u8; 8] = *b"ARCSTATE";
const CHECKSUM: usize = 4;
const HEADER: usize = MAGIC.len() + 4 + CHECKSUM;
/// Length and checksum in front of a record.
const HEAD: usize = 4 + CHECKSUM;
/// The offset of the first record: behind the header and the two horizons.
pub(crate) const RECORDS: usize = 3 * PAGE;
/// The format before this one.
const WITHOUT_HORIZON: u32 = 2;
/// The unit that a disk writes whole or not at all, bytes.
const SECTOR: usize = 512;
