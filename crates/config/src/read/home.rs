//! `home` of an `[[axis]]` table: how MAH homes it, and the sensor of its simulated drive (spec/axis-and-data-types.md §9.4, §11).

use arcline_controller::machine::{Home, HomeInputs, HomeMode, HomeSequence};

use super::dynamics::Dynamics;
use crate::section::Section;
use crate::words;

/// `turn`: the axis's `unwind`. Only a servo has inputs for a sensor; which ones, its drive says.
pub(super) fn home(axis: &Section<'_>, dynamics: &Dynamics, turn: Option<f64>, servo: bool) -> Home {
    let (section, _) = axis.table("home");
    let mode = section.one_of("mode", words::HOME_MODES);
    let sequence = section.one_of("sequence", words::HOME_SEQUENCES);
    let position = section.required("position");
    if turn.is_some_and(|turn| !(0.0..turn).contains(&position)) {
        section.refuse_value("position", "a number from 0 to below `unwind`");
    }
    let moves = mode == HomeMode::Active && sequence != HomeSequence::Immediate;
    if moves && !section.has("speed") {
        section.missing("speed");
    }
    let speed = section.number("speed").unwrap_or(0.0);
    for key in ["switch", "marker"] {
        if section.has(key) && !servo {
            section.conflict(key, "type = \"virtual\"", "only a servo has a home sensor");
        }
    }
    Home {
        mode,
        sequence,
        direction: section.one_of("direction", words::HOME_DIRECTIONS),
        position,
        offset: section.required("offset"),
        speed,
        return_speed: section.number("return_speed").unwrap_or(speed),
        acceleration: section.number("acceleration").unwrap_or(dynamics.acceleration),
        deceleration: section.number("deceleration").unwrap_or(dynamics.deceleration),
        inputs: HomeInputs::default(),
    }
}

/// The interval in which the switch is active: 0 and up where nothing else is said.
pub(super) fn switch(home: &Section<'_>, turn: Option<f64>) -> Option<[f64; 2]> {
    let (section, present) = home.table("switch");
    let (min, max) = (section.number("min"), section.number("max"));
    if !present {
        return None;
    }
    let Some(turn) = turn else {
        let open = if max.is_some() { f64::NEG_INFINITY } else { 0.0 };
        let [min, max] = [min.unwrap_or(open), max.unwrap_or(f64::INFINITY)];
        if min >= max {
            section.refuse_value("max", "a number above `min`");
        }
        return Some([min, max]);
    };
    for (key, place) in [("min", min), ("max", max)] {
        match place {
            Some(place) if (0.0..turn).contains(&place) => {}
            Some(_) => section.refuse_value(key, "a number from 0 to below `unwind`"),
            None if section.has(key) => {}
            None => section.missing(key),
        }
    }
    if min.is_some() && min == max {
        section.refuse_value("max", "another number than `min`");
    }
    Some([min?, max?])
}

/// The marker, and the distance between two: at 0, of a rotary axis once a turn, where nothing else is said.
pub(super) fn marker(home: &Section<'_>, turn: Option<f64>) -> Option<(f64, Option<f64>)> {
    let (section, present) = home.table("marker");
    present.then(|| (section.required("at"), section.number("every").or(turn)))
}
