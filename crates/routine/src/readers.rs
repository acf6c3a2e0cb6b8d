//! The steps of a project by the words of the memory that are among their operands.

use std::ops::Range;

/// Bytes of a word.
pub(crate) const WORD: usize = 4;
/// A word with more readers than these has those of few bits by bit.
const MANY: usize = 4;
const FEW_BITS: u32 = 4;
/// Words of a page: those of a page without readers take no memory.
const PAGE: usize = 1024;
/// Most words that a step may have among its operands; one with more is executed in each scan.
const MAX_WORDS: usize = 4096;
/// Most readers of all words; the steps after them are executed in each scan.
const MAX_READERS: usize = 1 << 22;

/// A step that has a word of the memory among its operands.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) struct Reader {
    pub(crate) step: u32,
    /// The bits of the word.
    pub(crate) bits: u32,
}

/// Operands of a step: bytes of the memory, and the bits of the first byte if it is one.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub(crate) struct Operands {
    pub(crate) from: u32,
    pub(crate) to: u32,
    pub(crate) mask: u8,
}

/// The readers of all words.
#[derive(Clone, Debug, Default)]
pub(crate) struct Readers {
    /// The number of steps.
    pub(crate) steps: u32,
    /// For each page, the place of its first word in `words`; `None`: nothing reads it.
    pages: Vec<Option<u32>>,
    /// The words of the pages.
    words: Vec<Of>,
    /// Readers of some bits of words that have many.
    by_bit: Vec<ByBit>,
    readers: Vec<Reader>,
}

/// The readers of a word.
#[derive(Clone, Copy, Debug)]
struct Of {
    /// Those that are looked at in each write.
    from: u32,
    to: u32,
    /// The others; 0: there are none, else their place in `by_bit` and 1.
    by_bit: u32,
}

/// The readers of each bit of a word: those of bit `n` from the `n`th number on to the next one.
#[derive(Clone, Copy, Debug)]
struct ByBit([u32; WORD * 8 + 1]);

impl Readers {
    fn of(&self, word: usize) -> Option<Of> {
        let page = self.pages.get(word / PAGE).copied().flatten()?;
        self.words.get(page as usize + word % PAGE).copied()
    }

    fn between(&self, from: u32, to: u32) -> &[Reader] {
        self.readers.get(from as usize..to as usize).unwrap_or_default()
    }

    /// Calls a function with each step that has one of these bits of a word among its operands, with some more than once.
    #[inline]
    pub(crate) fn each(&self, word: usize, mut bits: u32, mut call: impl FnMut(u32)) {
        let Some(of) = self.of(word) else { return };
        for reader in self.between(of.from, of.to) {
            if reader.bits & bits != 0 {
                call(reader.step);
            }
        }
        let Some(by_bit) = (of.by_bit as usize).checked_sub(1).and_then(|at| self.by_bit.get(at)) else {
            return;
        };
        while bits != 0 {
            let bit = bits.trailing_zeros() as usize;
            if let (Some(from), Some(to)) = (by_bit.0.get(bit), by_bit.0.get(bit + 1)) {
                self.between(*from, *to).iter().for_each(|reader| call(reader.step));
            }
            bits &= bits - 1;
        }
    }

    /// Whether other steps than one have some of these bytes among their operands.
    pub(crate) fn has_others(&self, bytes: &Range<u32>, step: u32) -> bool {
        let mut found = false;
        for byte in bytes.clone() {
            let bits = 0xFF << (8 * (byte % WORD as u32));
            self.each(byte as usize / WORD, bits, |reader| found |= reader != step);
        }
        found
    }

    /// Adds the readers of a word.
    fn add(&mut self, of_word: &[(u32, Reader)]) {
        let is_by_bit = |reader: &Reader| of_word.len() > MANY && reader.bits.count_ones() <= FEW_BITS;
        let (by_bit, others): (Vec<Reader>, Vec<Reader>) =
            of_word.iter().map(|(_, reader)| *reader).partition(is_by_bit);
        let from = self.readers.len() as u32;
        self.readers.extend(others);
        let to = self.readers.len() as u32;
        if !by_bit.is_empty() {
            let mut ends = ByBit([to; WORD * 8 + 1]);
            for (bit, end) in ends.0.iter_mut().skip(1).enumerate() {
                self.readers
                    .extend(by_bit.iter().filter(|reader| reader.bits & 1 << bit != 0));
                *end = self.readers.len() as u32;
            }
            self.by_bit.push(ends);
        }
        let by_bit = if by_bit.is_empty() { 0 } else { self.by_bit.len() as u32 };
        self.words.push(Of { from, to, by_bit });
    }
}

/// Collects the operands of steps.
#[derive(Debug, Default)]
pub(crate) struct Collector {
    steps: u32,
    all: Vec<(u32, Reader)>,
}

impl Collector {
    /// Counts steps; returns the first one.
    pub(crate) fn add_steps(&mut self, count: usize) -> u32 {
        let first = self.steps;
        self.steps += count as u32;
        first
    }

    /// Notes the operands of a step. False: they are too many.
    pub(crate) fn read(&mut self, step: u32, operands: &[Operands]) -> bool {
        let words = |of: &Operands| of.from / WORD as u32..of.to.div_ceil(WORD as u32);
        let count: usize = operands.iter().map(|of| words(of).len()).sum();
        if count > MAX_WORDS || self.all.len() + count > MAX_READERS {
            return false;
        }
        for of in operands {
            for word in words(of) {
                let bits = if of.to - of.from == 1 {
                    u32::from(of.mask) << (8 * (of.from % WORD as u32))
                } else {
                    u32::MAX
                };
                self.all.push((word, Reader { step, bits }));
            }
        }
        true
    }

    /// The readers of a memory.
    pub(crate) fn readers(mut self) -> Readers {
        self.all.sort_by_key(|(word, reader)| (*word, reader.step));
        self.all.dedup_by(|(word, reader), (kept_word, kept)| {
            let is_same = word == kept_word && reader.step == kept.step;
            if is_same {
                kept.bits |= reader.bits;
            }
            is_same
        });
        let last = self.all.last().map_or(0, |(word, _)| *word as usize);
        let mut result = Readers {
            steps: self.steps,
            ..Readers::default()
        };
        let mut rest = self.all.as_slice();
        for number in 0..=last / PAGE {
            let end = rest.partition_point(|(word, _)| (*word as usize) / PAGE <= number);
            let (of_page, behind) = rest.split_at(end);
            rest = behind;
            if of_page.is_empty() {
                result.pages.push(None);
                continue;
            }
            result.pages.push(Some(result.words.len() as u32));
            let mut of_page = of_page;
            for place in 0..PAGE {
                let end = of_page.partition_point(|(word, _)| *word as usize <= number * PAGE + place);
                let (of_word, behind) = of_page.split_at(end);
                of_page = behind;
                result.add(of_word);
            }
        }
        result
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::{Collector, Operands, PAGE, Readers, WORD};

    /// The steps that have some of these bits of a word among their operands.
    fn steps(readers: &Readers, word: usize, bits: u32) -> Vec<u32> {
        let mut found = Vec::new();
        readers.each(word, bits, |step| found.push(step));
        found.sort_unstable();
        found.dedup();
        found
    }

    #[test]
    fn words_have_their_readers() {
        let mut collector = Collector::default();
        assert_eq!(collector.add_steps(3), 0);
        let far = (5 * PAGE * WORD + 8) as u32;
        let bytes = |from: u32, to: u32, mask: u8| Operands { from, to, mask };
        assert!(collector.read(0, &[bytes(1, 2, 0x10), bytes(1, 2, 0x01), bytes(4, 12, 0xFF)]));
        assert!(collector.read(2, &[bytes(6, 7, 0xFF), bytes(far, far + 4, 0xFF)]));
        let readers = collector.readers();
        let far = far as usize / WORD;
        #[rustfmt::skip]
        let cases: [(usize, u32, &[u32]); 12] = [
            (0, 0x0100, &[0]), (0, 0x1000, &[0]), (0, !0x1100, &[]),
            (1, u32::MAX, &[0, 2]), (1, 0x1_0000, &[0, 2]), (1, 0xFFFF, &[0]),
            (2, 1, &[0]), (3, u32::MAX, &[]),
            (far, 1 << 31, &[2]), (far + 1, u32::MAX, &[]), (2 * PAGE, u32::MAX, &[]), (9 * PAGE, u32::MAX, &[]),
        ];
        for (word, bits, expected) in cases {
            assert_eq!(steps(&readers, word, bits), expected, "word {word}, bits {bits:#x}");
        }
        let others = |bytes: std::ops::Range<u32>, step| readers.has_others(&bytes, step);
        assert!(others(4..8, 0) && others(4..8, 2), "both read it");
        assert!(!others(4..6, 0) && others(4..6, 2) && !others(12..16, 2));
    }

    proptest! {
        #[test]
        fn words_with_many_readers_have_them_all(
            all in prop::collection::vec((0_u32..40, 0_u32..12, 1_u32..6, any::<u8>()), 0..80),
            bits in any::<u32>(),
        ) {
            let mut collector = Collector::default();
            collector.add_steps(40);
            for (step, from, count, mask) in &all {
                collector.read(*step, &[Operands { from: *from, to: from + count, mask: *mask }]);
            }
            let readers = collector.readers();
            for word in 0..5 {
                for bits in [bits, 1 << (bits % 32)] {
                    let reads = |from: u32, count: u32, mask: u8| {
                        let to = from + count;
                        if count == 1 {
                            from / 4 == word && u32::from(mask) << (8 * (from % 4)) & bits != 0
                        } else {
                            from / 4 <= word && word <= (to - 1) / 4
                        }
                    };
                    let read = all.iter().filter(|(_, from, count, mask)| bits != 0 && reads(*from, *count, *mask));
                    let mut expected: Vec<u32> = read.map(|(step, ..)| *step).collect();
                    expected.sort_unstable();
                    expected.dedup();
                    prop_assert_eq!(steps(&readers, word as usize, bits), expected, "word {}, bits {:#x}", word, bits);
                }
            }
        }
    }

    #[test]
    fn a_step_with_too_many_operands_is_none() {
        let mut collector = Collector::default();
        let all = Operands {
            from: 0,
            to: (super::MAX_WORDS * WORD + 4) as u32,
            mask: 0xFF,
        };
        assert!(!collector.read(0, &[all]));
    }
}
