//! The axes of a coordinate system: X Y Z, with Rx Ry Rz behind them, or the joints of a robot with its parameters.

use arcline_controller::machine::{
    Axis, Geometry, KinematicStructure, MAX_PRIMARY_AXES, Orientation, Parameters, Robot, Wrist,
};

use crate::section::Section;

/// `type` and `definition` of a coordinate system.
#[derive(Clone, Copy)]
pub(super) struct Kind {
    /// Word of `type`.
    type_word: &'static str,
    definition: Option<&'static str>,
}

impl Kind {
    pub(super) fn read(section: &Section<'_>) -> Kind {
        let type_word = section.word("type").unwrap_or_default();
        let definition = section.word("definition");
        let kind = Kind { type_word, definition };
        if definition.is_some() && !kind.is_oriented() && kind.wrist().is_none() {
            section.refuse_value("definition", "a definition that the type has");
        }
        kind
    }

    /// The possible numbers of axes, from least to most, and the name of such axes.
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
        self.type_word == CARTESIAN && self.definition == Some(Orientation::DEFINITION)
    }

    fn wrist(&self) -> Option<Wrist> {
        let mut wrists = WRISTS.iter().filter(|(word, _)| *word == self.type_word);
        wrists.find_map(|(_, wrist)| (Some(wrist.definition()) == self.definition).then_some(*wrist))
    }

    /// The maxima of the turn, where there is one: those that are not given are the least of Rx, Ry and Rz.
    pub(super) fn orientation<'a>(
        &self,
        section: &Section<'_>,
        axes: impl Iterator<Item = &'a Axis> + Clone,
    ) -> Option<Orientation> {
        if !self.is_oriented() {
            for key in ORIENTATION.iter().filter(|key| section.has(key)) {
                section.refuse_value(key, "no such key: the coordinate system has no Rx, Ry, Rz");
            }
            return None;
        }
        let turning = axes.skip(MAX_PRIMARY_AXES);
        let least = |of: fn(&Axis) -> f64| turning.clone().map(of).fold(f64::INFINITY, f64::min);
        let [speed, acceleration, deceleration] = ORIENTATION;
        let max_acceleration = section.number(acceleration);
        let max_deceleration = section.number(deceleration).or(max_acceleration);
        let braking = |axis: &Axis| match axis.max_deceleration {
            none if none <= 0.0 => axis.max_acceleration,
            rate => rate,
        };
        Some(Orientation {
            max_speed: section.number(speed).unwrap_or_else(|| least(|axis| axis.max_speed)),
            max_acceleration: max_acceleration.unwrap_or_else(|| least(|axis| axis.max_acceleration)),
            max_deceleration: max_deceleration.unwrap_or_else(|| least(braking)),
        })
    }

    /// The robot, with the parameters that it has.
    pub(super) fn robot(&self, section: &Section<'_>) -> Option<Robot> {
        let axes = section.count("axes");
        let Some(structure) = self.structure(axes == 2) else {
            for key in PARAMETERS.iter().filter(|key| section.has(key)) {
                section.refuse_value(key, "no such key: the coordinate system is Cartesian");
            }
            return None;
        };
        if self.axes().0.contains(&axes) && structure.joints() != axes {
            section.refuse_value("axes", "as many axes as the geometry has joints");
        }
        let mut parameters = Parameters::default();
        section.numbers("link_lengths", "two numbers", &mut parameters.link_lengths);
        section.numbers("base_offsets", THREE_NUMBERS, &mut parameters.base_offsets);
        let offsets = &mut parameters.end_effector_offsets;
        section.numbers("end_effector_offsets", THREE_NUMBERS, offsets);
        let (angles, expected) = match self.wrist().map_or(0, Wrist::joints) {
            4 => (4, "a list of four numbers"),
            5 => (5, "a list of five numbers"),
            6 => (6, "a list of six numbers"),
            _ => (3, THREE_NUMBERS),
        };
        section.numbers("zero_angles", expected, &mut parameters.zero_angles[..angles]);
        Some(Robot { structure, parameters })
    }

    /// `plane`: of two axes. `None`: it is Cartesian.
    fn structure(&self, plane: bool) -> Option<KinematicStructure> {
        let geometry = match (self.wrist(), self.type_word) {
            (Some(wrist), _) => return Some(KinematicStructure::Wrist(wrist)),
            (None, "articulated_independent") if plane => Geometry::ArticulatedIndependent2,
            (None, "articulated_independent") => Geometry::ArticulatedIndependent3,
            (None, "articulated_dependent") if plane => Geometry::ArticulatedDependent2,
            (None, "articulated_dependent") => Geometry::ArticulatedDependent3,
            (None, "scara_independent") => Geometry::ScaraIndependent,
            (None, "scara_delta") => Geometry::ScaraDelta,
            (None, "delta") if plane => Geometry::Delta2,
            (None, "delta") => Geometry::Delta3,
            _ => return None,
        };
        Some(KinematicStructure::Arm(geometry))
    }
}

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
pub fn definitions(type_word: &str) -> impl Iterator<Item = (&'static str, usize)> + use<'_> {
    let oriented = (type_word == CARTESIAN).then_some((Orientation::DEFINITION, 6));
    let wrists = WRISTS.iter().filter(move |(other, _)| *other == type_word);
    oriented
        .into_iter()
        .chain(wrists.map(|(_, wrist)| (wrist.definition(), wrist.joints())))
}

/// Keys that only robots have.
const PARAMETERS: &[&str] = &["link_lengths", "base_offsets", "end_effector_offsets", "zero_angles"];
/// Keys that only a Cartesian system with orientation has.
const ORIENTATION: [&str; 3] = [
    "max_orientation_speed",
    "max_orientation_acceleration",
    "max_orientation_deceleration",
];

const THREE_NUMBERS: &str = "a list of three numbers";
const PRIMARY_AXES: &str = "a list of 1 to 3 names of axes";
