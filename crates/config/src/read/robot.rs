//! What a coordinate system's axes are: X Y Z, with Rx Ry Rz behind them, or the joints of a robot with its parameters.

use arcline_controller::machine::{Axis, Build, Geometry, MAX_PRIMARY_AXES, Orientation, Parameters, Robot, Wrist};

use super::dynamics::{POSITIVE_RATE, POSITIVE_SPEED};
use crate::error::{ConfigError, Problem};
use crate::section::Section;

/// `type` and `definition` of a coordinate system.
#[derive(Clone, Copy)]
pub(super) struct Kind {
    /// Word of [`BUILDS`].
    build: &'static str,
    definition: Option<&'static str>,
}

impl Kind {
    pub(super) fn read(section: &Section<'_>) -> Result<Kind, ConfigError> {
        let build = section.word("type", BUILDS, BUILD)?.unwrap_or(0);
        let build = BUILDS.get(build).copied().unwrap_or(CARTESIAN);
        let word = section.word("definition", DEFINITIONS, DEFINITION)?;
        let definition = word.and_then(|place| DEFINITIONS.get(place).copied());
        let kind = Kind { build, definition };
        if definition.is_some() && !kind.is_oriented() && kind.wrist().is_none() {
            return Err(refuse(section, "definition", "a definition that the type has"));
        }
        Ok(kind)
    }

    /// How many axes there may be, from least to most, and what that is called.
    pub(super) fn axes(&self) -> (std::ops::RangeInclusive<usize>, &'static str) {
        let joints = match self.wrist() {
            Some(wrist) => wrist.joints(),
            None if self.is_oriented() => 6,
            None => return (1..=MAX_PRIMARY_AXES, PRIMARY_AXES),
        };
        let expected = match joints {
            3 => "a list of 3 names of axes",
            4 => "a list of 4 names of axes",
            5 => "a list of 5 names of axes",
            _ => "a list of 6 names of axes",
        };
        (joints..=joints, expected)
    }

    fn is_oriented(&self) -> bool {
        self.build == CARTESIAN && self.definition == Some(Orientation::DEFINITION)
    }

    fn wrist(&self) -> Option<Wrist> {
        let mut wrists = WRISTS.iter().filter(|(build, _)| *build == self.build);
        wrists.find_map(|(_, wrist)| (Some(wrist.definition()) == self.definition).then_some(*wrist))
    }

    /// The maxima of the turn, where there is one: those that are not given are the least of Rx, Ry and Rz.
    pub(super) fn orientation<'a>(
        &self,
        section: &Section<'_>,
        axes: impl Iterator<Item = &'a Axis> + Clone,
    ) -> Result<Option<Orientation>, ConfigError> {
        if !self.is_oriented() {
            return match ORIENTATION.iter().find(|key| section.value(key).is_some()) {
                Some(key) => Err(refuse(
                    section,
                    key,
                    "no such key: the coordinate system has no Rx, Ry, Rz",
                )),
                None => Ok(None),
            };
        }
        let turning = axes.skip(MAX_PRIMARY_AXES);
        let least = |of: fn(&Axis) -> f64| turning.clone().map(of).fold(f64::INFINITY, f64::min);
        let [speed, acceleration, deceleration] = ORIENTATION;
        let max_acceleration = section.number(acceleration, &POSITIVE_RATE)?;
        let max_deceleration = section.number(deceleration, &POSITIVE_RATE)?.or(max_acceleration);
        let braking = |axis: &Axis| match axis.max_deceleration {
            none if none <= 0.0 => axis.max_acceleration,
            rate => rate,
        };
        Ok(Some(Orientation {
            max_speed: section
                .number(speed, &POSITIVE_SPEED)?
                .unwrap_or_else(|| least(|axis| axis.max_speed)),
            max_acceleration: max_acceleration.unwrap_or_else(|| least(|axis| axis.max_acceleration)),
            max_deceleration: max_deceleration.unwrap_or_else(|| least(braking)),
        }))
    }

    /// The robot, with the parameters that it has.
    pub(super) fn robot(&self, section: &Section<'_>, axes: usize) -> Result<Option<Robot>, ConfigError> {
        let mut parameters = Parameters::default();
        section.numbers("link_lengths", "two numbers", &mut parameters.link_lengths)?;
        section.numbers("base_offsets", THREE_NUMBERS, &mut parameters.base_offsets)?;
        section.numbers(
            "end_effector_offsets",
            THREE_NUMBERS,
            &mut parameters.end_effector_offsets,
        )?;
        let (angles, expected) = match self.wrist().map_or(0, Wrist::joints) {
            4 => (4, "a list of four numbers"),
            5 => (5, "a list of five numbers"),
            6 => (6, "a list of six numbers"),
            _ => (3, THREE_NUMBERS),
        };
        section.numbers("zero_angles", expected, &mut parameters.zero_angles[..angles])?;
        let plane = axes == 2;
        let build = match (self.wrist(), self.build) {
            (Some(wrist), _) => Build::Wrist(wrist),
            (None, "articulated_independent") if plane => Build::Arm(Geometry::ArticulatedIndependent2),
            (None, "articulated_independent") => Build::Arm(Geometry::ArticulatedIndependent3),
            (None, "articulated_dependent") if plane => Build::Arm(Geometry::ArticulatedDependent2),
            (None, "articulated_dependent") => Build::Arm(Geometry::ArticulatedDependent3),
            (None, "scara_independent") => Build::Arm(Geometry::ScaraIndependent),
            (None, "scara_delta") => Build::Arm(Geometry::ScaraDelta),
            (None, "delta") if plane => Build::Arm(Geometry::Delta2),
            (None, "delta") => Build::Arm(Geometry::Delta3),
            _ => {
                return match PARAMETERS.iter().find(|key| section.value(key).is_some()) {
                    Some(key) => Err(refuse(section, key, "no such key: the coordinate system is Cartesian")),
                    None => Ok(None),
                };
            }
        };
        if build.joints() != axes {
            return Err(refuse(section, "axes", "as many axes as the geometry has joints"));
        }
        Ok(Some(Robot { build, parameters }))
    }
}

fn refuse(section: &Section<'_>, key: &'static str, expected: &'static str) -> ConfigError {
    let found = section.found(key);
    section.refuse_key(
        key,
        Problem::Value {
            found,
            expected,
            suggestion: None,
        },
    )
}

/// Words of `type`; `definition` and how many axes there are tell the rest.
const BUILDS: &[&str] = &[
    CARTESIAN,
    "articulated_independent",
    "articulated_dependent",
    "scara_independent",
    "scara_delta",
    "delta",
];
const CARTESIAN: &str = "cartesian";
/// Which of them have a wrist behind the arm.
pub(crate) const WRISTS: &[(&str, Wrist)] = &[
    ("delta", Wrist::DeltaJ1J2J6),
    ("delta", Wrist::DeltaJ1J2J3J6),
    ("delta", Wrist::DeltaJ1J2J3J4J5),
    ("scara_independent", Wrist::ScaraJ1J2J3J6),
    ("articulated_independent", Wrist::ArticulatedJ1J2J3J4J5J6),
];

/// The words of `definition` that a `type` has, with how many axes each takes.
pub fn definitions(build: &str) -> impl Iterator<Item = (&'static str, usize)> + use<'_> {
    let oriented = (build == CARTESIAN).then_some((Orientation::DEFINITION, 6));
    let wrists = WRISTS.iter().filter(move |(other, _)| *other == build);
    oriented
        .into_iter()
        .chain(wrists.map(|(_, wrist)| (wrist.definition(), wrist.joints())))
}

/// Words of `definition`.
const DEFINITIONS: &[&str] = &[
    Orientation::DEFINITION,
    Wrist::DeltaJ1J2J6.definition(),
    Wrist::DeltaJ1J2J3J6.definition(),
    Wrist::DeltaJ1J2J3J4J5.definition(),
    Wrist::ArticulatedJ1J2J3J4J5J6.definition(),
];
/// Keys that only robots have.
const PARAMETERS: &[&str] = &["link_lengths", "base_offsets", "end_effector_offsets", "zero_angles"];
/// Keys that only a Cartesian system with orientation has.
const ORIENTATION: [&str; 3] = [
    "max_orientation_speed",
    "max_orientation_acceleration",
    "max_orientation_deceleration",
];

const BUILD: &str = "\"cartesian\", \"articulated_independent\", \"articulated_dependent\", \"scara_independent\", \"scara_delta\" or \"delta\"";
const DEFINITION: &str = "\"XYZRxRyRz\", \"J1J2J6\", \"J1J2J3J6\", \"J1J2J3J4J5\" or \"J1J2J3J4J5J6\"";
const THREE_NUMBERS: &str = "a list of three numbers";
const PRIMARY_AXES: &str = "a list of 1 to 3 names of axes";
