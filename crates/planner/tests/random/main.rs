//! The properties of random motion; its seed reproduces a case.
//!
//! `ARCLINE_CASES` sets how many cases of each kind are run, `ARCLINE_SEED` the first (0). Without them `ARCLINE_LONG` runs the number
//! that stands in the test (`.ci/run campaigns`), and a plain `cargo test` a twentieth of it. Of kinds whose cases take long a stated
//! share is run: a night of 100,000 cases (`tests/nightly`) ends by the morning.
#![allow(missing_docs)]

mod ceilings;
mod contour_pace;
mod merge_limits;
mod merges;
mod short_moves;
mod stops;
mod storms;
mod streams;

/// `ARCLINE_LONG` is set: tests run all of their cases.
fn is_long() -> bool {
    std::env::var_os("ARCLINE_LONG").is_some()
}

/// The seeds of so many cases, of a twentieth of them, or of as many as are asked for.
fn seeds(long: u64) -> std::ops::Range<u64> {
    seeds_of_long(long, 1)
}

/// The same of cases that take as long as so many others: as many fewer are run where a number is asked for, one at least.
fn seeds_of_long(long: u64, weight: u64) -> std::ops::Range<u64> {
    let set = |name: &str| std::env::var(name).ok().and_then(|number| number.parse::<u64>().ok());
    let first = set("ARCLINE_SEED").unwrap_or(0);
    let usual = if is_long() { long } else { long.div_ceil(20) };
    let count = set("ARCLINE_CASES").map_or(usual, |count| (count / weight).max(1));
    first..first + count
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
