//! The machine of the tests.

use arcline_controller::machine::{Axis, AxisKind, CoordinateSystem, Machine, MotionGroup};
use arcline_instruction_set::AxisId;

/// A servo axis X and a virtual axis Y (1000 units/s, 10,000 units/s², 200,000 units/s³) in the coordinate system CS1 (half of that), whose
/// queue holds one pending move.
pub(crate) fn machine(period_ns: u64) -> Machine {
    let axis = |name: &str, kind| Axis {
        max_acceleration_jerk: 200_000.0,
        max_deceleration_jerk: 200_000.0,
        ..Axis::new(name, kind, 1000.0, 10_000.0)
    };
    let system = CoordinateSystem {
        max_acceleration_jerk: 100_000.0,
        max_deceleration_jerk: 100_000.0,
        actual_tolerance: 0.01,
        command_tolerance: 0.5,
        ..CoordinateSystem::new("CS1", &[AxisId(0), AxisId(1)], 500.0, 5000.0)
    };
    let axes = vec![axis("X", AxisKind::Servo), axis("Y", AxisKind::Virtual)];
    Machine::new(MotionGroup {
        period_ns,
        ..MotionGroup::new(axes, vec![system])
    })
}
