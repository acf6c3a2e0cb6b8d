//! The bytes of a file, without any file.
//!
//! ```text
//! header   "ARCSTATE"   format u32   checksum u32
//! record   length u32   checksum u32   length bytes   checksum u32     the state
//! record   …                                                           changes, any number
//! ```
//!
//! Little-endian. A checksum is a CRC-32 over everything in the file before it but the other checksums: a record that is
//! missing, moved or of another file does not fit. A length has its own, so that a damaged one is not mistaken for a
//! record that was cut off.

use crc32fast::Hasher;

use crate::codec::{self, MAX_RECORD, Record, RecordRef};
use crate::state::within;
use crate::{Change, Damage, Limit, State};

/// The format that is written and read.
pub const FORMAT: u32 = 2;
/// Longest file that is read, bytes.
pub const MAX_FILE: usize = 4 * MAX_RECORD;

/// What was read from a file.
#[derive(Clone, Debug, PartialEq)]
pub struct Kept {
    /// The state, with all changes.
    pub state: State,
    /// Where the next record goes. What stands behind was cut off while it was written.
    pub(crate) end: usize,
    pub(crate) chain: Chain,
}

/// The checksum so far.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Chain(u32);

impl Chain {
    /// Appends a record.
    pub(crate) fn push(&mut self, record: &RecordRef<'_>, out: &mut Vec<u8>) {
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

/// A whole file with a state and no changes.
pub(crate) fn fresh(state: &State) -> (Vec<u8>, Chain) {
    let mut out = MAGIC.to_vec();
    out.extend_from_slice(&FORMAT.to_le_bytes());
    let mut chain = Chain(0).over(&out);
    out.extend_from_slice(&chain.0.to_le_bytes());
    chain.push(&RecordRef::State(state), &mut out);
    (out, chain)
}

/// Appends changes that belong together.
pub(crate) fn changes(changes: &[Change], chain: &mut Chain, out: &mut Vec<u8>) {
    chain.push(&RecordRef::Changes(changes), out);
}

/// Reads a file. The last record may be cut off at any byte; it is left out then, since its writer never said that
/// it was kept.
///
/// # Errors
/// Anything else that is not as it was written.
pub fn parse(bytes: &[u8]) -> Result<Kept, Damage> {
    within(Limit::File, bytes.len(), MAX_FILE)?;
    let too_short = Damage::TooShort { length: bytes.len() };
    if bytes.is_empty() {
        return Err(too_short);
    }
    let magic = &bytes[..bytes.len().min(MAGIC.len())];
    if !MAGIC.starts_with(magic) {
        return Err(Damage::NotAState);
    }
    let Some(header) = bytes.first_chunk::<HEADER>() else {
        return Err(too_short);
    };
    let (told, checksum) = header.split_at(HEADER - CHECKSUM);
    let chain = Chain(0).over(told);
    if word(checksum) != chain.0 {
        return Err(Damage::Checksum {
            offset: HEADER - CHECKSUM,
        });
    }
    let found = word(&told[MAGIC.len()..]);
    if found != FORMAT {
        return Err(Damage::OtherFormat {
            found,
            expected: FORMAT,
        });
    }
    let mut reader = Reader {
        bytes,
        end: HEADER,
        chain,
    };
    let Some(Record::State(mut state)) = reader.next()? else {
        return Err(too_short);
    };
    state.check()?;
    loop {
        let offset = reader.end;
        match reader.next()? {
            None => break,
            Some(Record::Changes(changes)) => changes.iter().try_for_each(|change| state.apply(change))?,
            Some(Record::State(_)) => return Err(Damage::Record { offset }),
        }
    }
    Ok(Kept {
        state,
        end: reader.end,
        chain: reader.chain,
    })
}

struct Reader<'b> {
    bytes: &'b [u8],
    /// Behind the last whole record.
    end: usize,
    chain: Chain,
}

impl Reader<'_> {
    /// The next record; `None`: no whole one is left.
    fn next(&mut self) -> Result<Option<Record>, Damage> {
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
        (self.end, self.chain) = (tail + CHECKSUM, chain);
        Ok(Some(record))
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
