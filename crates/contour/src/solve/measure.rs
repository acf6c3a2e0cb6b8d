//! The exact check of the limits of the spline through the control points. Position units and seconds.

use crate::Trajectory;
use crate::limits::MoveLimits;
use crate::path::reference::ReferencePath;
use crate::solve::stages::StageResult;
use crate::timing::control_points::ControlPoints;
use crate::trajectory::Knot;

/// A motion with its excess.
pub(crate) struct Measured {
    pub(crate) trajectory: Trajectory,
    /// The time of each node.
    pub(crate) times: Vec<f64>,
    /// The factor by which the limits are exceeded.
    pub(crate) excess: f64,
}

/// The spline through the control points. A motion from rest whose result may be the plan is slowed down or sped up as a whole to its limits;
/// a continuation cannot be.
pub(crate) fn measured(
    control: &ControlPoints,
    bounds: &[MoveLimits],
    reference: &ReferencePath,
    result: StageResult,
) -> Measured {
    let trajectory = control.spline(&control.spans);
    let excess = excess(&trajectory, control, bounds, reference);
    if control.initial.is_some() || !excess.is_finite() {
        return Measured {
            times: control.times(&trajectory),
            trajectory,
            excess,
        };
    }
    let factor = if result == StageResult::Start { 1.0 } else { excess };
    let spans: Vec<f64> = control.spans.iter().map(|span| span * factor).collect();
    let trajectory = control.spline(&spans);
    Measured {
        times: control.times(&trajectory),
        trajectory,
        excess: 1.0,
    }
}

/// The factor by which the trajectory must take longer to keep every limit; below 1 it may be shorter. Infinite if a value of it is no number.
fn excess(trajectory: &Trajectory, control: &ControlPoints, bounds: &[MoveLimits], reference: &ReferencePath) -> f64 {
    if !trajectory.knots.iter().all(Knot::is_finite) {
        return f64::INFINITY;
    }
    let mut factor = 0.0_f64;
    let last = control.progress.len() - 1;
    for (k, pair) in trajectory.knots.windows(2).enumerate() {
        let (knot, next) = (&pair[0], &pair[1]);
        let bound = &bounds[reference.piece_at(control.progress[control.node_at(k).min(last)])];
        // Velocity is a parabola between knots: inside the hull of its Bezier points.
        let middle = knot.state.velocity + knot.state.acceleration * (0.5 * (next.time - knot.time));
        for velocity in [knot.state.velocity, middle] {
            factor = factor.max(velocity.norm() / bound.speed);
            for axis in 0..3 {
                factor = factor.max(velocity[axis].abs() / bound.axes.speed[axis]);
            }
        }
        factor = factor.max((knot.state.acceleration.norm() / bound.norm_acceleration()).sqrt());
        for axis in 0..3 {
            factor = factor.max((knot.state.acceleration[axis].abs() / bound.axes.acceleration[axis]).sqrt());
        }
        if bound.jerk.is_finite() {
            factor = factor.max(libm::cbrt(knot.jerk.norm() / bound.jerk));
        }
        if let Some(jerk) = bound.axes.jerk {
            for axis in 0..3 {
                factor = factor.max(libm::cbrt(knot.jerk[axis].abs() / jerk[axis]));
            }
        }
    }
    if factor > 0.0 { factor } else { 1.0 }
}
