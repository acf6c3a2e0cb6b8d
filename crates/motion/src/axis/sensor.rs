//! Where the home switch and the marker of an axis are, seen from where it is (spec/axis-and-data-types.md §11).
//!
//! Machine positions, position units; a direction is 1 or -1. An edge or marker that lies behind by less than
//! [`WIDTH`] is one that the axis stands on. Not here: what finds them. Nothing allocates.

use crate::machine::{HomeMarker, HomeSwitch};

/// How far the axis may be beyond a place that it is still said to stand on: far more than what rounding moves it.
const WIDTH: f64 = 1e-9;

impl HomeSwitch {
    /// Whether the switch is active. `turn`: length of one turn of a rotary axis.
    pub(crate) fn is_active(&self, machine: f64, turn: Option<f64>) -> bool {
        match turn {
            None => (self.min..=self.max).contains(&machine),
            Some(turn) => modulo(machine - self.min, turn) <= modulo(self.max - self.min, turn),
        }
    }

    /// Where it becomes active in a direction, and inactive in the other.
    pub(crate) fn edge(&self, direction: f64) -> f64 {
        if direction > 0.0 { self.min } else { self.max }
    }
}

impl HomeMarker {
    /// The first marker from a machine position on; `None` when there is none that way.
    pub(crate) fn ahead(&self, machine: f64, direction: f64) -> Option<f64> {
        ahead(machine, self.at, direction, self.every)
    }
}

/// The first of the places `at`, repeated `every` so many units, from a machine position on; `None` when none lies that way.
pub(crate) fn ahead(machine: f64, at: f64, direction: f64, every: Option<f64>) -> Option<f64> {
    let distance = direction * (at - machine);
    let width = WIDTH * machine.abs().max(1.0);
    match every {
        None => (distance.is_finite() && distance >= -width).then_some(at),
        Some(every) => {
            let turns = ((-width - distance) / every).ceil();
            Some(at + direction * turns * every)
        }
    }
}

/// What is left of a distance within one turn: 0 to below `turn`.
pub(crate) fn modulo(distance: f64, turn: f64) -> f64 {
    let rest = distance - turn * (distance / turn).floor();
    if rest >= turn { 0.0 } else { rest }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_ahead() {
        #[rustfmt::skip]
        let cases = [
            // why,                         from,          at,    direction, every,        ahead
            ("a single one in front",       -5.0,          3.0,   1.0,       None,         Some(3.0)),
            ("a single one behind",         5.0,           3.0,   1.0,       None,         None),
            ("one that it stands on",       3.0,           3.0,   1.0,       None,         Some(3.0)),
            ("just beyond by rounding",     3.0 + 1e-13,   3.0,   1.0,       None,         Some(3.0)),
            ("an end that there is not",    3.0,           f64::NEG_INFINITY, -1.0, None,  None),
            ("repeated, forward",           12.0,          3.0,   1.0,       Some(10.0),   Some(13.0)),
            ("repeated, reverse",           12.0,          3.0,   -1.0,      Some(10.0),   Some(3.0)),
            ("repeated, stands on one",     23.0 + 1e-12,  3.0,   1.0,       Some(10.0),   Some(23.0)),
            ("repeated, stands on one",     -17.0 - 1e-12, 3.0,   -1.0,      Some(10.0),   Some(-17.0)),
        ];
        for (why, from, at, direction, every, expected) in cases {
            assert_eq!(ahead(from, at, direction, every), expected, "{why}");
        }
    }

    #[test]
    fn a_switch_of_a_turn_leads_across_zero() {
        let switch = HomeSwitch { min: 350.0, max: 10.0 };
        for (machine, active) in [
            (0.0, true),
            (-10.0, true),
            (370.0, true),
            (371.0, false),
            (349.0, false),
        ] {
            assert_eq!(switch.is_active(machine, Some(360.0)), active, "{machine}");
        }
        let switch = HomeSwitch {
            min: 0.0,
            max: f64::INFINITY,
        };
        assert!(switch.is_active(0.0, None) && !switch.is_active(-1e-6, None));
    }
}
