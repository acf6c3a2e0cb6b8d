//! The rows of the newest ticks, in blocks: an append never moves older rows.

use std::collections::VecDeque;

/// Rows of a block.
const BLOCK: usize = 1024;

/// The newest rows.
#[derive(Debug)]
pub(super) struct Store {
    width: usize,
    /// Blocks of [`BLOCK`] rows; the last one may have fewer.
    blocks: VecDeque<Vec<f64>>,
    /// Blocks at most, 2 or more.
    most: usize,
    /// Ticks between the oldest and the newest that are missing, ever.
    missing: u64,
}

impl Store {
    /// An empty store of rows of `width` numbers, the first of which is the tick; it has room for at least `rows`.
    pub(super) fn new(width: usize, rows: usize) -> Self {
        Store {
            width,
            blocks: VecDeque::new(),
            most: rows.div_ceil(BLOCK) + 1,
            missing: 0,
        }
    }

    /// Appends whole rows, oldest first.
    pub(super) fn append(&mut self, rows: &[f64]) {
        for row in rows.chunks_exact(self.width) {
            if let Some(next) = self.next() {
                self.missing += tick_of(row).saturating_sub(next);
            }
            let full = BLOCK * self.width;
            if self.blocks.back().is_none_or(|block| block.len() == full) {
                let mut block = if self.blocks.len() == self.most {
                    self.blocks.pop_front().unwrap_or_default()
                } else {
                    Vec::with_capacity(full)
                };
                block.clear();
                self.blocks.push_back(block);
            }
            if let Some(block) = self.blocks.back_mut() {
                block.extend_from_slice(row);
            }
        }
    }

    /// The oldest tick in the store.
    pub(super) fn first(&self) -> Option<u64> {
        self.blocks.front()?.first().map(|tick| *tick as u64)
    }

    /// The tick behind the newest one.
    pub(super) fn next(&self) -> Option<u64> {
        let block = self.blocks.back()?;
        let row = block.len().checked_sub(self.width)?;
        block.get(row).map(|tick| *tick as u64 + 1)
    }

    /// The most rows in the store.
    pub(super) fn most(&self) -> usize {
        (self.most - 1) * BLOCK
    }

    /// Ticks that are missing, ever.
    pub(super) fn missing(&self) -> u64 {
        self.missing
    }

    /// The rows from a tick on, oldest first; where that tick is missing, from the next one that is there.
    pub(super) fn rows_from(&self, tick: u64) -> impl Iterator<Item = (u64, &[f64])> {
        let start = self.place(tick);
        let blocks = self.blocks.iter().skip(start / BLOCK);
        let rows = blocks.flat_map(|block| block.chunks_exact(self.width));
        rows.skip(start % BLOCK).map(|row| (tick_of(row), row))
    }

    /// The newest rows before a tick without a gap among them, oldest first, at most `most`.
    pub(super) fn run_before(&self, tick: u64, most: usize) -> impl Iterator<Item = (u64, &[f64])> {
        let within = move |from: u64| self.rows_from(from).take_while(move |(at, _)| *at < tick);
        let from = tick.saturating_sub(most as u64);
        let (mut first, mut expected) = (from, from);
        for (at, _) in within(from) {
            if at != expected {
                first = at;
            }
            expected = at + 1;
        }
        within(first)
    }

    /// The place of the first row whose tick is not before `tick`.
    fn place(&self, tick: u64) -> usize {
        let Some(first) = self.first() else { return 0 };
        // Without gaps the position is known; gaps only move it to the front.
        let (mut low, mut high) = (0, self.len().min(tick.saturating_sub(first) as usize));
        while low < high {
            let middle = low + (high - low).div_ceil(2);
            // The row in front of a place decides whether the place is too far behind.
            if self.tick_at(middle - 1) < tick {
                low = middle;
            } else {
                high = middle - 1;
            }
        }
        low
    }

    fn tick_at(&self, place: usize) -> u64 {
        let block = self.blocks.get(place / BLOCK);
        let tick = block.and_then(|block| block.get(place % BLOCK * self.width));
        tick.map_or(u64::MAX, |tick| *tick as u64)
    }

    fn len(&self) -> usize {
        let last = self.blocks.back().map_or(0, |block| block.len() / self.width);
        self.blocks.len().saturating_sub(1) * BLOCK + last
    }
}

fn tick_of(row: &[f64]) -> u64 {
    row.first().map_or(0, |tick| *tick as u64)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn with(ticks: impl IntoIterator<Item = u64>, rows: usize) -> Store {
        let mut store = Store::new(2, rows);
        for tick in ticks {
            store.append(&[tick as f64, tick as f64 / 2.0]);
        }
        store
    }

    #[test]
    fn the_oldest_go() {
        let store = with(0..10_000, 2000);
        assert_eq!(store.next(), Some(10_000));
        let first = store.first().expect("rows");
        assert!((10_000 - first) as usize >= 2000, "{first}");
        assert!(((10_000 - first) as usize) < 2000 + 3 * BLOCK, "{first}");
        assert_eq!(store.rows_from(0).map(|(tick, _)| tick).next(), Some(first));
        assert_eq!(store.missing(), 0);
    }

    #[test]
    fn an_empty_store_has_nothing() {
        let store = with([], 10);
        assert_eq!(
            (store.first(), store.next(), store.rows_from(5).count()),
            (None, None, 0)
        );
    }

    proptest! {
        #[test]
        fn rows_are_found_where_they_are(gaps in prop::collection::vec(1u64..4, 0..3000), from in 0u64..9000) {
            let ticks: Vec<u64> = gaps.iter().scan(0, |tick, gap| { *tick += gap; Some(*tick) }).collect();
            let store = with(ticks.iter().copied(), 100_000);
            let found: Vec<u64> = store.rows_from(from).map(|(tick, _)| tick).collect();
            let expected: Vec<u64> = ticks.iter().copied().filter(|tick| *tick >= from).collect();
            prop_assert_eq!(found, expected);
            let run: Vec<u64> = store.run_before(from, 100).map(|(tick, _)| tick).collect();
            prop_assert!(run.windows(2).all(|pair| pair[1] == pair[0] + 1) && run.len() <= 100, "{:?}", run);
            let window = ticks.iter().copied().filter(|tick| (from.saturating_sub(100)..from).contains(tick));
            prop_assert_eq!(run.last().copied(), window.clone().next_back());
            if let Some(first) = run.first() {
                prop_assert!(!window.clone().any(|tick| tick + 1 == *first), "{:?}", run);
            }
            let span = ticks.last().map_or(0, |last| last + 1 - ticks[0]);
            prop_assert_eq!(store.missing(), span - ticks.len() as u64);
        }
    }
}
