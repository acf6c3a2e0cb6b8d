//! The junction between two moves (spec/coordinated-instructions.md §7).

use arcline_geometry::{Path, Point};
use arcline_profile::Limits;

use crate::Move;
use crate::tolerance::{COLLINEAR_SINE, SAME_TANGENT_SINE};

/// The ending of a move with a successor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Ending {
    /// The successor starts from rest (termination types 0 and 1).
    Stop,
    /// The successor is superposed on the rest of this move once the distance to go is within the tolerance and
    /// braking has begun (types 2 and 6; type 3 with an infinite tolerance).
    Blend {
        /// Position units; [`f64::INFINITY`]: as soon as braking begins.
        tolerance: f64,
    },
    /// The motion follows the path exactly, and keeps its speed as far as the corner permits (types 4 and 5).
    Contour {
        /// The successor must be able to stop within its own length (type 4).
        constrained: bool,
    },
}

/// The junction of two moves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Junction {
    /// Rest in between.
    Rest,
    /// Two collinear lines with a tolerance: the successor's limits hold from the tolerance on.
    Overtake { tolerance: f64 },
    /// Superposition.
    Blend { tolerance: f64 },
    /// The motion passes at a speed. `early`: the successor becomes active when braking begins.
    Pass { constrained: bool, early: bool },
}

/// The geometry and endings of a junction, which stay when speeds and rates change.
#[derive(Clone, Copy, Debug, PartialEq)]
enum JunctionShape {
    Rest,
    Overtake { tolerance: f64 },
    Blend { tolerance: f64 },
    Pass { constrained: bool, in_line: bool },
}

/// The junction from `first` to `second`; `blended`: another move blended into `first`.
pub(crate) fn junction<T>(first: &Move<T>, second: &Move<T>, blended: bool) -> Junction {
    match shape(first, second, blended) {
        JunctionShape::Rest => Junction::Rest,
        JunctionShape::Overtake { tolerance } => Junction::Overtake { tolerance },
        JunctionShape::Blend { tolerance } => Junction::Blend { tolerance },
        JunctionShape::Pass { constrained, in_line } => Junction::Pass {
            constrained,
            early: in_line && second.limits.speed < first.limits.speed,
        },
    }
}

fn shape<T>(first: &Move<T>, second: &Move<T>, blended: bool) -> JunctionShape {
    let other = first.parameter != second.parameter;
    if other || first.path.length() == 0.0 || second.path.length() == 0.0 {
        return JunctionShape::Rest;
    }
    let turns = [first.rotation, second.rotation]
        .iter()
        .flatten()
        .any(|rotation| !rotation.keeps_orientation());
    let in_line = !turns && collinear(&first.path, &second.path);
    match first.ending {
        Ending::Blend { tolerance } if tolerance > 0.0 => {
            let tolerance = effective_tolerance(tolerance, first, second, blended);
            match (in_line, tolerance.is_finite()) {
                (true, true) => JunctionShape::Overtake { tolerance },
                (true, false) => JunctionShape::Pass {
                    constrained: true,
                    in_line,
                },
                (false, _) => JunctionShape::Blend { tolerance },
            }
        }
        // A rotation begins and ends at rest.
        Ending::Contour { .. } if turns => JunctionShape::Rest,
        Ending::Contour { constrained } => JunctionShape::Pass { constrained, in_line },
        Ending::Stop | Ending::Blend { .. } => JunctionShape::Rest,
    }
}

/// The tolerance, limited to half of a move that may have blends at both ends (spec/coordinated-instructions.md §7.3). No Decel has no limit.
/// The path length of a rotation alone has its own unit, and limits only another rotation.
fn effective_tolerance<T>(tolerance: f64, first: &Move<T>, second: &Move<T>, blended: bool) -> f64 {
    if tolerance.is_infinite() {
        return tolerance;
    }
    let before = if blended { 0.5 } else { 1.0 };
    let after = if matches!(second.ending, Ending::Blend { .. }) {
        0.5
    } else {
        1.0
    };
    let own = tolerance.min(before * first.path.length());
    if first.path.stands() == second.path.stands() {
        own.min(after * second.path.length())
    } else {
        own
    }
}

/// The demand of a junction on the profile that reaches it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum JunctionDemand {
    /// None: the profile continues.
    Free,
    /// The second move is slower: its programmed speed.
    Slower { speed: f64 },
    /// Rest.
    Rest,
    /// A speed with acceleration 0: at most the lower programmed one and the limit of the corner. `constrained`: also at most a speed
    /// from which the second move can slow down.
    Pass { speed: f64, corner: f64, constrained: bool },
}

impl JunctionDemand {
    /// A profile must end at the junction.
    pub(crate) fn ends_run(&self) -> bool {
        !matches!(self, JunctionDemand::Free | JunctionDemand::Slower { .. })
    }

    /// The highest speed by the programmed ones.
    pub(crate) fn programmed(&self) -> f64 {
        match self {
            JunctionDemand::Free => f64::INFINITY,
            JunctionDemand::Rest => 0.0,
            JunctionDemand::Slower { speed } | JunctionDemand::Pass { speed, .. } => *speed,
        }
    }

    /// The highest speed by the corner.
    pub(crate) fn corner(&self) -> f64 {
        match self {
            JunctionDemand::Pass { corner, .. } => *corner,
            JunctionDemand::Rest => 0.0,
            _ => f64::INFINITY,
        }
    }

    /// The second move must be able to slow down in time.
    pub(crate) fn is_constrained(&self) -> bool {
        !matches!(self, JunctionDemand::Pass { constrained: false, .. })
    }
}

/// The junction of two moves, without their speeds and rates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct JunctionGeometry {
    shape: JunctionShape,
    /// The highest speed by the corner, in units per second or master unit.
    corner: f64,
}

impl JunctionGeometry {
    /// The junction before the first move.
    pub(crate) const FIRST: JunctionGeometry = JunctionGeometry {
        shape: JunctionShape::Rest,
        corner: 0.0,
    };

    /// `blended`: another move blended into `first`; `corner_step`: the largest change of each axis's velocity at a corner, units/s.
    pub(crate) fn new<T>(first: &Move<T>, second: &Move<T>, blended: bool, corner_step: &Point) -> JunctionGeometry {
        let shape = shape(first, second, blended);
        let mut corner = match shape {
            JunctionShape::Pass { .. } => {
                corner_speed(&turn(&first.path, &second.path), corner_step) / first.parameter.speed
            }
            _ => 0.0,
        };
        if corner.is_finite() {
            corner = corner.min(second.corner);
        }
        JunctionGeometry { shape, corner }
    }

    /// The junction with a limit on the speed at its corner, if it has one.
    pub(crate) fn at_most(self, corner: f64) -> JunctionGeometry {
        if self.corner.is_finite() {
            let corner = self.corner.min(corner);
            return JunctionGeometry { corner, ..self };
        }
        self
    }

    /// The motion follows the path across the junction without a rest.
    pub(crate) fn is_passed(&self) -> bool {
        match self.shape {
            JunctionShape::Overtake { .. } => true,
            JunctionShape::Pass { .. } => self.corner > 0.0,
            JunctionShape::Rest | JunctionShape::Blend { .. } => false,
        }
    }

    /// The highest speed by the corner, in units per second or master unit; infinite without a corner, where one profile continues.
    pub(crate) fn corner(&self) -> f64 {
        match self.shape {
            JunctionShape::Overtake { .. } => f64::INFINITY,
            JunctionShape::Pass { .. } => self.corner,
            JunctionShape::Rest | JunctionShape::Blend { .. } => 0.0,
        }
    }

    /// The second move is superposed on the first one, or overtakes it.
    pub(crate) fn blends(&self) -> bool {
        matches!(self.shape, JunctionShape::Blend { .. } | JunctionShape::Overtake { .. })
    }

    /// The demand of the junction of two moves with these limits. One profile can continue across it if the path has no corner there, the rates
    /// are the same, and the second move can stop in time (spec/motion-core.md §7).
    pub(crate) fn demand(&self, first: &Limits, second: &Limits) -> JunctionDemand {
        let rates_stay = same_rates(first, second);
        match self.shape {
            JunctionShape::Rest | JunctionShape::Blend { .. } => JunctionDemand::Rest,
            JunctionShape::Overtake { .. } if rates_stay => JunctionDemand::Free,
            // The successor slows down from its tolerance on, if that is safe.
            JunctionShape::Overtake { .. } => JunctionDemand::Pass {
                speed: first.speed,
                corner: f64::INFINITY,
                constrained: true,
            },
            JunctionShape::Pass { constrained, .. } => {
                let corner = self.corner;
                let speed = first.speed.min(second.speed);
                if corner == 0.0 {
                    JunctionDemand::Rest
                } else if !constrained || !rates_stay || corner.is_finite() {
                    JunctionDemand::Pass {
                        speed,
                        corner,
                        constrained,
                    }
                } else if second.speed < first.speed {
                    JunctionDemand::Slower { speed }
                } else {
                    JunctionDemand::Free
                }
            }
        }
    }
}

/// The limits differ in their speed at most.
pub(crate) fn same_rates(first: &Limits, second: &Limits) -> bool {
    Limits {
        speed: second.speed,
        ..*first
    } == *second
}

/// The change of direction at a corner; zeros for tangent paths and collinear lines.
pub(crate) fn turn(first: &Path, second: &Path) -> Point {
    let turn = second.start_tangent() - first.end_tangent();
    if turn.norm() <= SAME_TANGENT_SINE || collinear(first, second) {
        return Point::zeros();
    }
    turn
}

/// The highest speed at which a change of direction changes no axis's velocity by more than its step.
pub(crate) fn corner_speed(turn: &Point, corner_step: &Point) -> f64 {
    let bounds = turn.iter().zip(corner_step.iter()).filter(|(turn, _)| **turn != 0.0);
    bounds
        .map(|(turn, step)| step / turn.abs())
        .fold(f64::INFINITY, f64::min)
}

fn collinear(first: &Path, second: &Path) -> bool {
    let (Path::Line(first), Path::Line(second)) = (first, second) else {
        return false;
    };
    let (before, after) = (first.direction(), second.direction());
    before.dot(&after) > 0.0 && before.cross(&after).norm() <= COLLINEAR_SINE
}

/// A velocity runs along a tangent, in the same direction, within the angle of collinear lines.
pub(crate) fn is_along(velocity: &Point, tangent: &Point) -> bool {
    velocity.dot(tangent) > 0.0 && velocity.cross(tangent).norm() <= COLLINEAR_SINE * velocity.norm()
}

/// The limits of a stop that ramps out a residual velocity.
pub(crate) fn braking(limits: &Limits, speed: f64) -> Limits {
    Limits {
        speed: limits.speed.max(speed),
        ..*limits
    }
}
