//! The horizon of a file: how many of its bytes the disk was known to have.
//!
//! Behind the horizon a crash of the system may leave anything: fewer bytes, zeros, other bytes. A broken record there was never
//! synchronised, and the reader cuts it off. Before the horizon a broken record is damage. A horizon is written after each synchronisation and
//! synchronised with the next one, in turn to one of two pages, so that at any instant one of them is whole.

/// The used part of the horizon page of a file with this number of synchronised bytes.
pub(crate) fn page(synchronised: usize) -> [u8; SIZE] {
    let mut bytes = [0; SIZE];
    bytes[..LENGTH].copy_from_slice(&(synchronised as u64).to_le_bytes());
    let checksum = crc32fast::hash(&bytes[..LENGTH]);
    bytes[LENGTH..].copy_from_slice(&checksum.to_le_bytes());
    bytes
}

/// The farther of the two horizons of a file, bytes; `None`: neither page is whole.
pub(crate) fn of(file: &[u8]) -> Option<u64> {
    let pages = [0, 1].map(|turn| file.get(offset(turn)..).and_then(read));
    pages.into_iter().flatten().max()
}

fn read(page: &[u8]) -> Option<u64> {
    let (length, rest) = page.split_first_chunk::<LENGTH>()?;
    let checksum = rest.first_chunk()?;
    (crc32fast::hash(length) == u32::from_le_bytes(*checksum)).then(|| u64::from_le_bytes(*length))
}

/// The offset of the horizon that is written at this turn.
pub(crate) fn offset(turn: usize) -> usize {
    PAGE * (1 + turn % 2)
}

const LENGTH: usize = 8;
const SIZE: usize = LENGTH + 4;
/// The unit that a disk or a file system writes as one, bytes: damage to one page leaves the others alone.
pub(crate) const PAGE: usize = 4096;
