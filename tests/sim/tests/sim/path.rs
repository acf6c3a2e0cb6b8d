//! The error of the path (M1): X, Y and Z are on one of the lines that the client of CS1 has asked for.

use arcline_controller::AxisSnapshot;
use arcline_instruction_set::predefined::motion_status;

/// The axes of CS1 are the first ones.
const AXES: usize = 3;
/// Targets that are remembered: those of the lines that may still run or wait, and of some before.
const TARGETS: usize = 6;
/// Rounding, position units.
const EXACT: f64 = 1e-6;

type Point = [f64; AXES];

/// The region in which the axes may be.
#[derive(Debug, Default)]
pub(crate) struct Path {
    /// Their last position at rest.
    rest: Option<Point>,
    /// The newest is the last.
    targets: Vec<Point>,
    /// Each axis stops by itself until all stand.
    is_left: bool,
}

impl Path {
    /// The server has ended.
    pub(crate) fn restart(&mut self) {
        *self = Path::default();
    }

    /// A line to a target may begin, from where the axes stand or from the target before.
    pub(crate) fn expect(&mut self, target: Point) {
        if self.targets.len() == TARGETS {
            self.targets.remove(0);
        }
        self.targets.push(target);
    }

    /// The line to a target was refused.
    pub(crate) fn forget(&mut self, target: Point) {
        self.targets.retain(|known| *known != target);
    }

    /// Checks a tick: returns the distance of the axes from every line, if it is too great.
    pub(crate) fn see(&mut self, axes: &[AxisSnapshot], is_inhibited: bool) -> Option<f64> {
        let axes = axes.first_chunk::<AXES>()?;
        let point = [0, 1, 2].map(|axis| axes[axis].command[0]);
        let stands = axes.iter().all(|axis| axis.command[1] == 0.0);
        // A stop of everything brakes each axis by itself.
        let brakes = axes
            .iter()
            .any(|axis| axis.motion_status & motion_status::STOPPING_STATUS != 0);
        self.is_left = !stands && (self.is_left || is_inhibited || brakes);
        if stands {
            self.rest = Some(point);
            return None;
        }
        let rest = self.rest.filter(|_| !self.is_left)?;
        let ends = self.targets.iter();
        let lines = ends.clone().flat_map(|from| ends.clone().map(move |to| (*from, *to)));
        let lines = ends.clone().rev().map(|to| (rest, *to)).chain(lines);
        let mut nearest = f64::INFINITY;
        for (from, to) in lines {
            nearest = nearest.min(distance(point, from, to));
            if nearest <= EXACT {
                return None;
            }
        }
        Some(nearest)
    }
}

/// The distance of a point from the line between two others.
fn distance(point: Point, from: Point, to: Point) -> f64 {
    let minus = |one: Point, other: Point| [0, 1, 2].map(|axis| one[axis] - other[axis]);
    let dot = |one: Point, other: Point| (0..AXES).map(|axis| one[axis] * other[axis]).sum::<f64>();
    let (along, offset) = (minus(to, from), minus(point, from));
    let length = dot(along, along);
    let share = if length > 0.0 {
        (dot(offset, along) / length).clamp(0.0, 1.0)
    } else {
        0.0
    };
    let error = minus(offset, along.map(|part| part * share));
    dot(error, error).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_distance_is_that_to_the_nearest_point_of_the_line() {
        #[rustfmt::skip]
        let cases = [
            ("on it",          [1.0, 0.0, 0.0],  0.0),
            ("beside it",      [1.0, 3.0, 4.0],  5.0),
            ("before it",      [-3.0, 4.0, 0.0], 5.0),
            ("behind its end", [5.0, 0.0, 4.0],  5.0),
        ];
        for (why, point, expected) in cases {
            assert_eq!(distance(point, [0.0; 3], [2.0, 0.0, 0.0]), expected, "{why}");
        }
        assert_eq!(
            distance([0.0, 3.0, 4.0], [0.0; 3], [0.0; 3]),
            5.0,
            "a line without length"
        );
    }
}
