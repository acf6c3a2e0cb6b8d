//! Where a number enters and leaves a range that may be repeated.
//!
//! A range holds its left end and not its right one, so that a place is in it or not whichever way it was come to.

use crate::axis::modulo;

/// From `left` up to below `right`, and again every `cycle`, if there is one.
#[derive(Clone, Copy, Debug)]
pub(super) struct Window {
    pub(super) left: f64,
    pub(super) right: f64,
    pub(super) cycle: Option<f64>,
}

impl Window {
    pub(super) fn contains(&self, value: f64) -> bool {
        match self.cycle {
            None => (self.left..self.right).contains(&value),
            Some(cycle) => modulo(value - self.left, cycle) < self.right - self.left,
        }
    }

    /// The last place at which the range is entered on the way from one value to another, and the last at which it is left.
    pub(super) fn crossed(&self, from: f64, to: f64) -> [Option<f64>; 2] {
        let last = |edge: f64| {
            let place = match self.cycle {
                None => edge,
                Some(cycle) if to > from => edge + ((to - edge) / cycle).floor() * cycle,
                Some(cycle) => edge + (((to - edge) / cycle).floor() + 1.0) * cycle,
            };
            let (low, high) = if to > from { (from, to) } else { (to, from) };
            (low < place && place <= high).then_some(place)
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
            cycle: None,
        };
        let again = Window {
            cycle: Some(100.0),
            ..once
        };
        #[rustfmt::skip]
        let cases = [
            // why,                      window, from,  to,     entered at,    left at
            ("up to its end",            once,   0.0,   10.0,   Some(10.0),    None),
            ("from its end",             once,   10.0,  15.0,   None,          None),
            ("through it",               once,   0.0,   30.0,   Some(10.0),    Some(20.0)),
            ("back to its right end",    once,   30.0,  20.0,   None,          None),
            ("back over it",             once,   20.0,  19.0,   Some(20.0),    None),
            ("back to its left end",     once,   15.0,  10.0,   None,          None),
            ("back through it",          once,   30.0,  5.0,    Some(20.0),    Some(10.0)),
            ("the next one",             again,  50.0,  115.0,  Some(110.0),   None),
            ("two of them",              again,  50.0,  250.0,  Some(210.0),   Some(220.0)),
            ("below zero, back",         again,  0.0,   -85.0,  Some(-80.0),   None),
            ("at rest",                  again,  10.0,  10.0,   None,          None),
        ];
        for (why, window, from, to, entered, left) in cases {
            assert_eq!(window.crossed(from, to), [entered, left], "{why}");
        }
        for (value, inside) in [(9.9, false), (10.0, true), (19.9, true), (20.0, false), (110.0, true)] {
            assert_eq!(again.contains(value), inside, "{value}");
        }
        assert!(!once.contains(110.0));
    }
}
