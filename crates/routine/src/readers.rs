//! The steps of a project by the words of the memory that are among their operands.

/// Bytes of a word.
pub(crate) const WORD: usize = 4;
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
    /// For each page, the place of its first word in `starts`; `None`: nothing reads it.
    pages: Vec<Option<u32>>,
    /// The first reader of each word of the pages, and the end of the last.
    starts: Vec<u32>,
    readers: Vec<Reader>,
}

impl Readers {
    /// The readers of a word.
    pub(crate) fn of(&self, word: usize) -> &[Reader] {
        let Some(page) = self.pages.get(word / PAGE).copied().flatten() else {
            return &[];
        };
        let at = page as usize + word % PAGE;
        let (Some(from), Some(to)) = (self.starts.get(at), self.starts.get(at + 1)) else {
            return &[];
        };
        self.readers.get(*from as usize..*to as usize).unwrap_or_default()
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
            pages: vec![None; last / PAGE + 1],
            ..Readers::default()
        };
        let mut rest = self.all.as_slice();
        for (number, page) in result.pages.iter_mut().enumerate() {
            let end = rest.partition_point(|(word, _)| (*word as usize) / PAGE <= number);
            let (of_page, behind) = rest.split_at(end);
            rest = behind;
            if of_page.is_empty() {
                continue;
            }
            *page = Some(result.starts.len() as u32);
            for place in 0..=PAGE {
                let before = of_page.partition_point(|(word, _)| (*word as usize) < number * PAGE + place);
                result.starts.push((result.readers.len() + before) as u32);
            }
            result.readers.extend(of_page.iter().map(|(_, reader)| *reader));
        }
        result
    }
}

#[cfg(test)]
mod tests {
    use super::{Collector, Operands, PAGE, Reader, WORD};

    #[test]
    fn words_have_their_readers() {
        let mut collector = Collector::default();
        assert_eq!(collector.add_steps(3), 0);
        let far = (5 * PAGE * WORD + 8) as u32;
        let bytes = |from: u32, to: u32, mask: u8| Operands { from, to, mask };
        assert!(collector.read(0, &[bytes(1, 2, 0x10), bytes(1, 2, 0x01), bytes(4, 12, 0xFF)]));
        assert!(collector.read(2, &[bytes(6, 7, 0xFF), bytes(far, far + 4, 0xFF)]));
        let readers = collector.readers();
        let all = |word: usize| readers.of(word).to_vec();
        assert_eq!(all(0), [Reader { step: 0, bits: 0x1100 }]);
        let (first, third) = (
            Reader {
                step: 0,
                bits: u32::MAX,
            },
            Reader {
                step: 2,
                bits: 0xFF_0000,
            },
        );
        assert_eq!(all(1), [first, third]);
        assert_eq!(all(2), [first]);
        assert_eq!(all(3), []);
        assert_eq!(
            all(far as usize / WORD),
            [Reader {
                step: 2,
                bits: u32::MAX
            }]
        );
        assert_eq!(all(2 * PAGE), []);
        assert_eq!(all(far as usize / WORD + 1), []);
        assert_eq!(all(9 * PAGE), [], "behind all");
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
