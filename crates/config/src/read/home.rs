//! `home` of an `[[axis]]` table: how MAH homes it, and the simulated sensor (spec/axis-and-data-types.md §9.4, §11).

use arcline_controller::machine::{Home, HomeDirection, HomeMarker, HomeMode, HomeSequence, HomeSwitch};

use super::axis::{ANY, POSITIVE_LENGTH};
use super::dynamics::{Dynamics, POSITIVE_RATE, POSITIVE_SPEED};
use crate::error::{ConfigError, Problem};
use crate::section::Section;

/// `turn`: the axis's `unwind`. Only a servo has inputs for a sensor.
pub(super) fn home(
    axis: &Section<'_>,
    dynamics: &Dynamics,
    turn: Option<f64>,
    servo: bool,
) -> Result<Home, ConfigError> {
    let (section, _) = axis.table("home", HOME, "a table such as { sequence = \"switch\", speed = 50.0 }")?;
    let word = |key, words, expected| section.word(key, words, expected);
    let mode = match word("mode", MODES, MODE)? {
        Some(0) => HomeMode::Passive,
        _ => HomeMode::Active,
    };
    let sequence = word("sequence", SEQUENCE_WORDS, SEQUENCE)?;
    let sequence = sequence.map_or(HomeSequence::Immediate, |place| SEQUENCES[place]);
    let direction = word("direction", DIRECTION_WORDS, DIRECTION)?;
    let direction = direction.map_or(HomeDirection::BidirectionalForward, |place| DIRECTIONS[place]);
    let position = section.number("position", &ANY)?.unwrap_or(0.0);
    if turn.is_some_and(|turn| !(0.0..turn).contains(&position)) {
        return Err(refuse(&section, "position", "a number from 0 to below `unwind`"));
    }
    let moves = mode == HomeMode::Active && sequence != HomeSequence::Immediate;
    let speed = if moves {
        section.required_number("speed", &POSITIVE_SPEED)?
    } else {
        section.number("speed", &POSITIVE_SPEED)?.unwrap_or(0.0)
    };
    let sensors = [
        ("switch", switch(&section, turn)?.is_some()),
        ("marker", marker(&section, turn)?.is_some()),
    ];
    if let Some((key, _)) = sensors.iter().find(|(_, there)| *there && !servo) {
        let problem = Problem::Conflict {
            other: "type = \"virtual\"",
            reason: "only a servo has a home sensor",
        };
        return Err(section.refuse_key(key, problem));
    }
    Ok(Home {
        mode,
        sequence,
        direction,
        position,
        offset: section.number("offset", &ANY)?.unwrap_or(0.0),
        speed,
        return_speed: section.number("return_speed", &POSITIVE_SPEED)?.unwrap_or(speed),
        acceleration: section
            .number("acceleration", &POSITIVE_RATE)?
            .unwrap_or(dynamics.acceleration),
        deceleration: section
            .number("deceleration", &POSITIVE_RATE)?
            .unwrap_or(dynamics.deceleration),
        switch: switch(&section, turn)?,
        marker: marker(&section, turn)?,
        stops: None,
    })
}

/// The interval in which the switch is active: 0 and up where nothing else is said.
fn switch(home: &Section<'_>, turn: Option<f64>) -> Result<Option<HomeSwitch>, ConfigError> {
    let (section, present) = home.table("switch", SWITCH, "a table such as { min = 0.0, max = 20.0 }")?;
    if !present {
        return Ok(None);
    }
    let Some(turn) = turn else {
        let (min, max) = (section.number("min", &ANY)?, section.number("max", &ANY)?);
        let open = if max.is_some() { f64::NEG_INFINITY } else { 0.0 };
        let switch = HomeSwitch {
            min: min.unwrap_or(open),
            max: max.unwrap_or(f64::INFINITY),
        };
        if switch.min >= switch.max {
            return Err(refuse(&section, "max", "a number above `min`"));
        }
        return Ok(Some(switch));
    };
    let switch = HomeSwitch {
        min: section.required_number("min", &ANY)?,
        max: section.required_number("max", &ANY)?,
    };
    for (key, place) in [("min", switch.min), ("max", switch.max)] {
        if !(0.0..turn).contains(&place) {
            return Err(refuse(&section, key, "a number from 0 to below `unwind`"));
        }
    }
    if switch.min == switch.max {
        return Err(refuse(&section, "max", "another number than `min`"));
    }
    Ok(Some(switch))
}

/// The marker: at 0, of a rotary axis once a turn, where nothing else is said.
fn marker(home: &Section<'_>, turn: Option<f64>) -> Result<Option<HomeMarker>, ConfigError> {
    let (section, present) = home.table("marker", MARKER, "a table such as { at = 0.0, every = 10.0 }")?;
    if !present {
        return Ok(None);
    }
    Ok(Some(HomeMarker {
        at: section.number("at", &ANY)?.unwrap_or(0.0),
        every: section.number("every", &POSITIVE_LENGTH)?.or(turn),
    }))
}

fn refuse(section: &Section<'_>, key: &str, expected: &'static str) -> ConfigError {
    let problem = Problem::Value {
        found: section.found(key),
        expected,
        suggestion: None,
    };
    section.refuse_key(key, problem)
}

pub(super) const HOME: &[&str] = &[
    "mode",
    "sequence",
    "direction",
    "position",
    "offset",
    "speed",
    "return_speed",
    "acceleration",
    "deceleration",
    "switch",
    "marker",
];
pub(super) const SWITCH: &[&str] = &["min", "max"];
pub(super) const MARKER: &[&str] = &["at", "every"];
const MODE: &str = "\"active\" or \"passive\"";
const MODES: &[&str] = &["passive", "active"];
const SEQUENCE: &str = "\"immediate\", \"switch\", \"marker\", \"switch-marker\", \"torque\" or \"torque-marker\"";
const SEQUENCE_WORDS: &[&str] = &[
    "immediate",
    "switch",
    "marker",
    "switch-marker",
    "torque",
    "torque-marker",
];
const SEQUENCES: [HomeSequence; 6] = [
    HomeSequence::Immediate,
    HomeSequence::Switch,
    HomeSequence::Marker,
    HomeSequence::SwitchMarker,
    HomeSequence::Torque,
    HomeSequence::TorqueMarker,
];
const DIRECTION: &str = "\"bidirectional-\" or \"unidirectional-\", then \"forward\" or \"reverse\"";
const DIRECTION_WORDS: &[&str] = &[
    "unidirectional-forward",
    "bidirectional-forward",
    "unidirectional-reverse",
    "bidirectional-reverse",
];
const DIRECTIONS: [HomeDirection; 4] = [
    HomeDirection::UnidirectionalForward,
    HomeDirection::BidirectionalForward,
    HomeDirection::UnidirectionalReverse,
    HomeDirection::BidirectionalReverse,
];
