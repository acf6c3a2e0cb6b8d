//! Ranges and the round numbers on them.

/// A range of values, the first smaller than the second.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(crate) struct Range(pub(crate) f64, pub(crate) f64);

impl Range {
    /// Of all values, with a margin; around a single value it is a little wide.
    pub(crate) fn of(values: impl IntoIterator<Item = f64>) -> Self {
        let start = (f64::INFINITY, f64::NEG_INFINITY);
        let (low, high) = values
            .into_iter()
            .fold(start, |(low, high), value| (low.min(value), high.max(value)));
        if low > high {
            return Self(-1.0, 1.0);
        }
        let span = high - low;
        let margin = if span > 1e-9 * low.abs().max(high.abs()).max(1e-9) {
            MARGIN * span
        } else {
            low.abs().max(1.0)
        };
        Self(low - margin, high + margin)
    }

    pub(crate) fn span(self) -> f64 {
        self.1 - self.0
    }

    pub(crate) fn middle(self) -> f64 {
        0.5 * (self.0 + self.1)
    }

    /// Round numbers, about `count` of them.
    pub(crate) fn ticks(self, count: usize) -> Vec<f64> {
        let step = self.step(count);
        let first = (self.0 / step - 1e-9).ceil();
        let last = (self.1 / step + 1e-9).floor();
        let mut ticks = Vec::new();
        let mut place = first;
        while place <= last && ticks.len() < 100 {
            ticks.push(place * step + 0.0);
            place += 1.0;
        }
        ticks
    }

    /// 1, 2 or 5 times a power of ten.
    fn step(self, count: usize) -> f64 {
        let raw = self.span() / count.max(1) as f64;
        let power = 10_f64.powi(raw.log10().floor() as i32);
        let factor = [1.0, 2.0, 5.0]
            .into_iter()
            .find(|factor| power * factor >= raw * (1.0 - 1e-9))
            .unwrap_or(10.0);
        power * factor
    }

    /// A number of this range, with as many digits as its ticks need.
    pub(crate) fn label(self, value: f64, count: usize) -> String {
        let digits = (-self.step(count).log10().floor()).clamp(0.0, 9.0) as usize;
        let text = format!("{value:.digits$}");
        if text.contains('.') {
            let short = text.trim_end_matches('0').trim_end_matches('.');
            return if short == "-0" {
                "0".to_owned()
            } else {
                short.to_owned()
            };
        }
        if text == "-0" { "0".to_owned() } else { text }
    }
}

const MARGIN: f64 = 0.06;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round() {
        #[rustfmt::skip]
        let cases: &[(Range, usize, &[&str])] = &[
            (Range(0.0, 10.0), 5, &["0", "2", "4", "6", "8", "10"]),
            (Range(-1.2, 1.3), 4, &["-1", "0", "1"]),
            (Range(0.0, 0.031), 4, &["0", "0.01", "0.02", "0.03"]),
            (Range(-2500.0, 2600.0), 4, &["-2000", "0", "2000"]),
            (Range(0.99, 1.01), 4, &["0.99", "0.995", "1", "1.005", "1.01"]),
        ];
        for (range, count, expected) in cases {
            let labels: Vec<String> = range
                .ticks(*count)
                .iter()
                .map(|tick| range.label(*tick, *count))
                .collect();
            assert_eq!(labels, *expected, "{range:?}");
        }
    }

    #[test]
    fn ranges_hold_their_values() {
        assert_eq!(Range::of([0.0, 100.0]), Range(-6.0, 106.0));
        assert_eq!(Range::of([5.0, 5.0]), Range(0.0, 10.0));
        assert_eq!(Range::of([]), Range(-1.0, 1.0));
    }
}
