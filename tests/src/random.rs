//! Random numbers for sequences that a seed reproduces.

/// A small generator of its own, so that a seed means the same sequence for ever (SplitMix64).
#[derive(Clone, Debug)]
pub struct Random(pub u64);

impl Random {
    /// 64 random bits.
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// A number between two, in steps of a thousandth.
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        let share = (self.bits() >> 11) as f64 / (1u64 << 53) as f64;
        ((low + share * (high - low)) * 1000.0).round() / 1000.0
    }

    /// A whole number below `count`.
    pub fn below(&mut self, count: u64) -> u64 {
        self.bits() % count
    }

    /// Draws one of several.
    ///
    /// # Panics
    /// When there is none.
    pub fn one_of<'t, T>(&mut self, choices: &'t [T]) -> &'t T {
        &choices[self.below(choices.len() as u64) as usize]
    }
}

/// `ARCLINE_LONG` is set, as in `.ci/run campaigns`: tests run all of their cases.
#[must_use]
pub fn is_long() -> bool {
    std::env::var_os("ARCLINE_LONG").is_some()
}

/// All cases of a test in a long run ([`is_long`]); in a plain `cargo test` the one at an index.
#[must_use]
pub fn one_or_all<T>(cases: &[T], one: usize) -> &[T] {
    if is_long() { cases } else { &cases[one..=one] }
}

/// The seeds of a random property: as many as `ARCLINE_CASES` says from `ARCLINE_SEED` on. Without them `long` seeds from 0 on in a long run
/// ([`is_long`]); one of 40 of them in a plain `cargo test`.
///
/// # Panics
/// When a variable is no number.
#[must_use]
pub fn seeds(long: u64) -> std::ops::Range<u64> {
    let number = |name: &str| {
        std::env::var(name)
            .ok()
            .map(|text| text.parse::<u64>().expect("a number"))
    };
    let usual = if is_long() { long } else { long.div_ceil(40) };
    let first = number("ARCLINE_SEED").unwrap_or(0);
    first..first + number("ARCLINE_CASES").unwrap_or(usual)
}
