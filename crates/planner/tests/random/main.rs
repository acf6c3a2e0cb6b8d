//! What random motion must keep, found again by its seed.
//!
//! `ARCLINE_CASES` sets how many cases of each kind are run.
#![allow(missing_docs)]

mod ceilings;
mod contour_pace;
mod merge_limits;
mod merges;
mod short_moves;
mod storms;
mod streams;

/// The number of cases that is asked for, or this one.
fn cases(usual: u64) -> u64 {
    let set = std::env::var("ARCLINE_CASES").ok();
    set.and_then(|count| count.parse().ok()).unwrap_or(usual)
}

/// The seeds of the cases: `ARCLINE_SEED` sets the first.
fn seeds(usual: u64) -> std::ops::Range<u64> {
    let set = std::env::var("ARCLINE_SEED").ok();
    let first = set.and_then(|seed| seed.parse().ok()).unwrap_or(0);
    first..first + cases(usual)
}

/// A generator of its own, so that a seed means the same case for ever (SplitMix64).
struct Random(u64);

impl Random {
    /// From 0 to 1.
    fn share(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    fn between(&mut self, least: f64, most: f64) -> f64 {
        least + (most - least) * self.share()
    }

    fn of<V: Copy>(&mut self, values: &[V]) -> V {
        values[((values.len() as f64) * self.share()) as usize % values.len()]
    }
}
