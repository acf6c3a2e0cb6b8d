//! MCLM, Motion Coordinated Linear Move (spec/coordinated-instructions.md §12).

use arcline_instruction_set::{Call, MotionError, OperandIndex};
use arcline_planner::geometry::Path;

use super::moves::{self, INCREMENTAL, target_point};
use crate::control::Execution;
use crate::motion::Motion;
use crate::system::component;

pub(super) fn execute(motion: &mut Motion, execution: Execution, call: &Call) -> Result<(), MotionError> {
    let layout = motion.layouts.mclm;
    moves::execute(motion, execution, call, &layout, 1, |motion, system, start| {
        let axes = system.description.axes.len();
        let position = call.array(layout.position);
        let incremental = call.word(layout.move_type) == INCREMENTAL;
        let mut target = target_point(&position[..axes.min(position.len())], &start, incremental);
        for (place, axis) in system.description.axes.iter().enumerate() {
            let unwind = motion.axes.get(usize::from(*axis)).and_then(|axis| axis.unwind);
            if let (Some(unwind), false) = (unwind, incremental) {
                let from = component(&start, place);
                let distance = rotary_distance(from, position[place], unwind)
                    .ok_or(MotionError::ParameterOutOfRange(OperandIndex(layout.position as u8)))?;
                target[place] = from + distance;
            }
        }
        Ok(Path::line(start, target))
    })
}

/// Signed distance of an absolute move of a rotary axis: the sign of the position is the direction, its
/// magnitude the target within one turn (§12.2). `None` when the magnitude is beyond the unwind.
fn rotary_distance(from: f64, position: f64, unwind: f64) -> Option<f64> {
    let modulo = |distance: f64| distance - unwind * (distance / unwind).floor();
    if position.abs() > unwind {
        return None;
    }
    Some(if position < 0.0 {
        -modulo(from - position.abs())
    } else {
        modulo(position - from)
    })
}

#[cfg(test)]
mod tests {
    use super::rotary_distance;

    #[test]
    fn rotary_distances_of_the_conformance_vectors() {
        for (from, position, distance) in [
            (350.0, 10.0, Some(20.0)),
            (10.0, 350.0, Some(340.0)),
            (10.0, -350.0, Some(-20.0)),
            (10.0, -360.0, Some(-10.0)),
            (10.0, 0.0, Some(350.0)),
            (10.0, 400.0, None),
        ] {
            assert_eq!(
                rotary_distance(from, position, 360.0),
                distance,
                "from {from} to {position}"
            );
        }
    }
}
