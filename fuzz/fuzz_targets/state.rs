//! Any bytes as a file of a retained state, and as a record in one whose checksums are right.
#![no_main]

use arcline_fuzz::timed;
use arcline_state::parse;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| timed(|| run(data)));

fn run(data: &[u8]) {
    let _ = parse(data);
    let mut file = b"ARCSTATE\x01\0\0\0".to_vec();
    let mut chain = crc32fast::hash(&file);
    file.extend_from_slice(&chain.to_le_bytes());
    // A state and then a change, as far as the bytes go: the first byte says where the one ends.
    let (first, rest) = data
        .split_first()
        .map_or((0, data), |(first, rest)| (usize::from(*first), rest));
    let (state, change) = rest.split_at(first.min(rest.len()));
    for record in [state, change] {
        for part in [&(record.len() as u32).to_le_bytes()[..], record] {
            let mut hasher = crc32fast::Hasher::new_with_initial(chain);
            hasher.update(part);
            chain = hasher.finalize();
            file.extend_from_slice(part);
            file.extend_from_slice(&chain.to_le_bytes());
        }
    }
    if let Ok(kept) = parse(&file) {
        assert_eq!(kept.state.check(), Ok(()));
    }
}
