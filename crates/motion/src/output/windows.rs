//! The crossings of a value into and out of a range that may be repeated.
//!
//! A range contains its left end but not its right one, so membership of a position does not depend on the direction of approach.

use arcline_profile::numeric::modulo;

/// The range from `left` to below `right`, repeated every `cycle` in the turns that count.
#[derive(Clone, Copy, Debug)]
pub(super) struct Window {
    pub(super) left: f64,
    pub(super) right: f64,
    /// More than 0, and at least the length of the range.
    pub(super) cycle: f64,
    pub(super) turns: Turns,
}

/// Turns of a range, from the first to the last; the present one is 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Turns {
    pub(super) first: f64,
    pub(super) last: f64,
}

impl Turns {
    /// The present turn only.
    pub(super) const ONE: Self = Turns { first: 0.0, last: 0.0 };
    pub(super) const ALL: Self = Turns {
        first: f64::NEG_INFINITY,
        last: f64::INFINITY,
    };
}

impl Window {
    /// An empty range.
    pub(super) const NONE: Self = Window {
        left: 0.0,
        right: 0.0,
        cycle: 1.0,
        turns: Turns::ONE,
    };

    pub(super) fn contains(&self, value: f64) -> bool {
        let turn = ((value - self.left) / self.cycle).floor();
        let counts = self.turns.first <= turn && turn <= self.turns.last;
        counts && modulo(value - self.left, self.cycle) < self.right - self.left
    }

    /// The last position at which a value on its motion from one position to another enters the range, and the last at which it leaves it.
    pub(super) fn crossed(&self, from: f64, to: f64) -> [Option<f64>; 2] {
        let last = |edge: f64| {
            let whole = ((to - edge) / self.cycle).floor();
            let turn = if to > from { whole } else { whole + 1.0 };
            let crossing = edge + turn.max(self.turns.first).min(self.turns.last) * self.cycle;
            let (low, high) = if to > from { (from, to) } else { (to, from) };
            (low < crossing && crossing <= high).then_some(crossing)
        };
        if from == to {
            [None, None]
        } else if to > from {
            [last(self.left), last(self.right)]
        } else {
            [last(self.right), last(self.left)]
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_are_entered_and_left() {
        let once = Window {
            left: 10.0,
            right: 20.0,
            cycle: 100.0,
            turns: Turns::ONE,
        };
        let again = Window {
            turns: Turns::ALL,
            ..once
        };
        let never_on = Window {
            turns: Turns {
                last: 0.0,
                ..Turns::ALL
            },
            ..once
        };
        let never_back = Window {
            turns: Turns {
                first: 0.0,
                ..Turns::ALL
            },
            ..once
        };
        #[rustfmt::skip]
        let cases = [
            // why,                      window,     from,  to,     entered at,    left at
            ("up to its end",            once,       0.0,   10.0,   Some(10.0),    None),
            ("from its end",             once,       10.0,  15.0,   None,          None),
            ("through it",               once,       0.0,   30.0,   Some(10.0),    Some(20.0)),
            ("back to its right end",    once,       30.0,  20.0,   None,          None),
            ("back over it",             once,       20.0,  19.0,   Some(20.0),    None),
            ("back to its left end",     once,       15.0,  10.0,   None,          None),
            ("back through it",          once,       30.0,  5.0,    Some(20.0),    Some(10.0)),
            ("where it would repeat",    once,       50.0,  250.0,  None,          None),
            ("the next one",             again,      50.0,  115.0,  Some(110.0),   None),
            ("two of them",              again,      50.0,  250.0,  Some(210.0),   Some(220.0)),
            ("below zero, back",         again,      0.0,   -85.0,  Some(-80.0),   None),
            ("at rest",                  again,      10.0,  10.0,   None,          None),
            ("the last one",             never_on,   -95.0, 250.0,  Some(10.0),    Some(20.0)),
            ("none behind the last one", never_on,   50.0,  115.0,  None,          None),
            ("one before the last one",  never_on,   -95.0, -85.0,  Some(-90.0),   None),
            ("the first one",            never_back, 50.0,  -250.0, Some(20.0),    Some(10.0)),
            ("none before the first",    never_back, 0.0,   -85.0,  None,          None),
        ];
        for (why, window, from, to, entered, left) in cases {
            assert_eq!(window.crossed(from, to), [entered, left], "{why}");
        }
        for (value, inside) in [(9.9, false), (10.0, true), (19.9, true), (20.0, false), (110.0, true)] {
            assert_eq!(again.contains(value), inside, "{value}");
        }
        assert!(!once.contains(110.0) && !once.contains(-85.0));
        assert!(!never_on.contains(110.0) && never_on.contains(-85.0));
        assert!(never_back.contains(110.0) && !never_back.contains(-85.0));
        assert!(!Window::NONE.contains(0.0));
    }
}
