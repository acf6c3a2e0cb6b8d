//! Home switch, marker and mechanical stops of an axis, by its position (spec/axis-and-data-types.md §11).
//!
//! Machine positions, position units; a direction is 1 or -1. An axis stands on an edge or marker that is behind it by less than
//! [`SENSOR_WIDTH_SHARE`]. Nothing allocates.

use arcline_profile::numeric::modulo;

use super::tolerance::SENSOR_WIDTH_SHARE;
use crate::Trigger;

/// The sensors that an axis passes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sensor {
    /// The home switch is active from the first position to the second one, forward; infinite for an open end. For a rotary axis both are within
    /// one turn, and the interval may contain 0.
    pub switch: Option<[f64; 2]>,
    /// The position of one marker, and the distance between two; `None`: there is only one marker.
    pub marker: Option<(f64, Option<f64>)>,
    /// The mechanical stops.
    pub stops: Option<[f64; 2]>,
    /// The length of one turn of a rotary axis.
    pub turn: Option<f64>,
}

impl Sensor {
    /// The home switch is active at a position.
    pub fn is_active(&self, machine: f64) -> bool {
        self.switch.is_some_and(|[min, max]| match self.turn {
            None => (min..=max).contains(&machine),
            Some(turn) => modulo(machine - min, turn) <= modulo(max - min, turn),
        })
    }

    /// The position at which the home switch becomes active in a direction, and inactive in the opposite one; infinite for an open end.
    pub fn edge(&self, direction: f64) -> Option<f64> {
        self.switch.map(|[min, max]| if direction > 0.0 { min } else { max })
    }

    /// The first position of the trigger in a direction from a position; `None` if there is none.
    pub(super) fn ahead(&self, trigger: Trigger, machine: f64, direction: f64) -> Option<f64> {
        match trigger {
            Trigger::SwitchOn => ahead(machine, self.edge(direction)?, direction, self.turn),
            Trigger::SwitchOff => ahead(machine, self.edge(-direction)?, direction, self.turn),
            Trigger::Marker => {
                let (at, every) = self.marker?;
                ahead(machine, at, direction, every)
            }
            Trigger::Stop => self.stops.map(|[min, max]| if direction > 0.0 { max } else { min }),
            Trigger::RegistrationOn | Trigger::RegistrationOff => None,
        }
    }
}

/// The first of the positions `at`, repeated `every` units, in a direction from a machine position; `None` if there is none.
fn ahead(machine: f64, at: f64, direction: f64, every: Option<f64>) -> Option<f64> {
    let distance = direction * (at - machine);
    let width = SENSOR_WIDTH_SHARE * machine.abs().max(1.0);
    match every {
        None => (distance.is_finite() && distance >= -width).then_some(at),
        Some(every) => {
            let turns = ((-width - distance) / every).ceil();
            Some(at + direction * turns * every)
        }
    }
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
        let switch = |min, max, turn| Sensor {
            switch: Some([min, max]),
            turn,
            ..Sensor::default()
        };
        let across = switch(350.0, 10.0, Some(360.0));
        for (machine, active) in [
            (0.0, true),
            (-10.0, true),
            (370.0, true),
            (371.0, false),
            (349.0, false),
        ] {
            assert_eq!(across.is_active(machine), active, "{machine}");
        }
        let open = switch(0.0, f64::INFINITY, None);
        assert!(open.is_active(0.0) && !open.is_active(-1e-6));
    }
}
