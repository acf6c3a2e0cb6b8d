//! Rotary axes: positions within one turn, and the targets of programmed positions
//! (spec/axis-and-data-types.md §3.4, spec/coordinated-instructions.md §12.2, §13.6).
//!
//! Units: position units of the axis. Commands are not unwound: a position is a whole number of turns plus the position that the axis
//! shows, from 0 to below the unwind.

use crate::tolerance::{SAME_POSITION_SHARE, UNWIND_SHARE};

/// The position within one turn.
pub(crate) fn shown(position: f64, unwind: f64) -> f64 {
    let shown = position.rem_euclid(unwind);
    if shown >= unwind * (1.0 - UNWIND_SHARE) {
        0.0
    } else {
        shown
    }
}

/// The position of a rotary axis, from which programmed positions are reached.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RotaryPosition {
    unwind: f64,
    /// Whole turns.
    turns: f64,
    /// The position that the axis shows, 0 to below the unwind.
    pub(crate) shown: f64,
}

impl RotaryPosition {
    pub(crate) fn at(position: f64, unwind: f64) -> Self {
        let shown = shown(position, unwind);
        RotaryPosition {
            unwind,
            turns: ((position - shown) / unwind).round(),
            shown,
        }
    }

    /// A position lies within one turn.
    pub(crate) fn contains(unwind: f64, position: f64) -> bool {
        (0.0..unwind).contains(&position)
    }

    /// The target of an absolute move. Its direction follows from comparing the positions, not from the shorter distance: a negative position
    /// is its positive equivalent, and a position beyond the unwind is more than one turn away (MAM Absolute).
    pub(crate) fn absolute(&self, position: f64) -> f64 {
        if position < 0.0 {
            self.in_turn(shown(position, self.unwind), 0.0)
        } else {
            self.in_turn(position, 0.0)
        }
    }

    /// The target of a forward move to a position within one turn, less than a turn away.
    pub(crate) fn forward(&self, position: f64) -> f64 {
        let more = if position >= self.shown { 0.0 } else { 1.0 };
        let distance = position - self.shown + more * self.unwind;
        let whole = distance >= self.unwind * (1.0 - SAME_POSITION_SHARE);
        self.in_turn(position, if whole { more - 1.0 } else { more })
    }

    /// The target of a backward move to a position within one turn, less than a turn away.
    pub(crate) fn backward(&self, position: f64) -> f64 {
        let less = if position <= self.shown { 0.0 } else { 1.0 };
        let distance = self.shown - position + less * self.unwind;
        let whole = distance >= self.unwind * (1.0 - SAME_POSITION_SHARE);
        self.in_turn(position, if whole { 1.0 - less } else { -less })
    }

    /// The target of the shortest move to a position within one turn; a distance of half a turn is covered forward.
    pub(crate) fn shortest(&self, position: f64) -> f64 {
        let ahead = (position - self.shown).rem_euclid(self.unwind);
        if ahead <= 0.5 * self.unwind {
            self.forward(position)
        } else {
            self.backward(position)
        }
    }

    /// The target by a sign for the direction and a magnitude for the position within one turn (MCLM, MCCM Absolute). `None` if the magnitude is
    /// beyond the unwind.
    pub(crate) fn signed(&self, position: f64) -> Option<f64> {
        if position.abs() > self.unwind {
            return None;
        }
        let within = shown(position.abs(), self.unwind);
        Some(if position < 0.0 {
            self.backward(within)
        } else {
            self.forward(within)
        })
    }

    /// The equivalent of a position that is nearest to another position.
    pub(crate) fn nearest(unwind: f64, position: f64, to: f64) -> f64 {
        position + unwind * ((to - position) / unwind).round()
    }

    fn in_turn(&self, position: f64, more: f64) -> f64 {
        let turns = self.turns + more;
        // Exact if the axis is in its first turn.
        if turns == 0.0 {
            position
        } else {
            turns * self.unwind + position
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn positions_are_shown_within_one_turn() {
        for (position, expected) in [
            (0.0, 0.0),
            (360.0, 0.0),
            (-90.0, 270.0),
            (725.0, 5.0),
            (-1e-20, 0.0),
            (360.0 - 1e-11, 0.0),
        ] {
            assert_eq!(shown(position, 360.0), expected, "{position}");
        }
    }

    #[test]
    fn distances_of_mam_by_move_type() {
        #[rustfmt::skip]
        let cases = [
            // from,   to,     absolute, shortest, forward, backward
            (10.0,     350.0,  340.0,    -20.0,    340.0,   -20.0),
            (350.0,    10.0,   -340.0,   20.0,     20.0,    -340.0),
            (90.0,     270.0,  180.0,    180.0,    180.0,   -180.0),
            (270.0,    90.0,   -180.0,   180.0,    180.0,   -180.0),
            (45.0,     45.0,   0.0,      0.0,      0.0,     0.0),
            (1090.0,   20.0,   10.0,     10.0,     10.0,    -350.0),
            (-10.0,    0.0,    -350.0,   10.0,     10.0,    -350.0),
            (0.0,      359.0,  359.0,    -1.0,     359.0,   -1.0),
        ];
        for (from, to, absolute, shortest, forward, backward) in cases {
            let turn = RotaryPosition::at(from, 360.0);
            for (why, target, distance) in [
                ("absolute", turn.absolute(to), absolute),
                ("shortest", turn.shortest(to), shortest),
                ("forward", turn.forward(to), forward),
                ("backward", turn.backward(to), backward),
            ] {
                assert_eq!(target - from, distance, "{why} from {from} to {to}");
            }
        }
        for (from, to, distance) in [(10.0, -90.0, 260.0), (10.0, 730.0, 720.0), (10.0, -450.0, 260.0)] {
            assert_eq!(
                RotaryPosition::at(from, 360.0).absolute(to) - from,
                distance,
                "{from} to {to}"
            );
        }
    }

    #[test]
    fn a_rounding_error_is_no_whole_turn() {
        for turns in [-7.0, 0.0, 3.0, 1000.0] {
            for (at, to) in [
                (10.0 + 1e-11, 10.0),
                (10.0 - 1e-11, 10.0),
                (-1e-11, 0.0),
                (1e-8, 0.0),
                (359.999_999_9, 0.0),
            ] {
                let from = turns * 360.0 + at;
                let turn = RotaryPosition::at(from, 360.0);
                for target in [turn.forward(to), turn.backward(to), turn.shortest(to)] {
                    assert!((target - from).abs() < 1e-6, "from {from} to {to}: {target}");
                }
            }
        }
    }

    #[test]
    fn distances_of_the_conformance_vectors() {
        for (from, position, distance) in [
            (350.0, 10.0, Some(20.0)),
            (10.0, 350.0, Some(340.0)),
            (10.0, -350.0, Some(-20.0)),
            (10.0, -360.0, Some(-10.0)),
            (10.0, 360.0, Some(350.0)),
            (10.0, 0.0, Some(350.0)),
            (10.0, -0.0, Some(350.0)),
            (10.0, 400.0, None),
            (10.0, -400.0, None),
        ] {
            let target = RotaryPosition::at(from, 360.0).signed(position);
            assert_eq!(
                target.map(|target| target - from),
                distance,
                "from {from} to {position}"
            );
        }
    }

    #[test]
    fn a_point_of_a_circle_is_taken_where_the_arc_is() {
        for (position, to, expected) in [(0.0, 360.0, 360.0), (90.0, 100.0, 90.0), (350.0, 5.0, -10.0)] {
            assert_eq!(RotaryPosition::nearest(360.0, position, to), expected);
        }
    }
}
