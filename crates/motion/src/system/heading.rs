//! The orientation of a coordinate system with Rx, Ry, Rz: the end orientation of a path move that rotates, and its axes during the move
//! (spec/coordinated-instructions.md §22.8, §23.3).
//!
//! The axes show fixed X-Y-Z angles: Ry within a quarter turn of 0, Rx and Rz continuous over turns. When the rotation passes a quarter turn
//! of Ry, the other two change by half a turn at once, as the reference's mirror rule states. Real-time: nothing allocates. Units: degrees.

use arcline_planner::geometry::{
    Path, Point, Rotation, angle_rates, angles, angular_rates, continued, nearest, rotation,
};
use arcline_planner::profile::{KinematicState, Limits};
use arcline_planner::{AngularState, Sample};

use crate::axes::Axes;
use crate::axis::Axis;
use crate::axis::generator_kind::GeneratorKind;
use crate::machine::MAX_PRIMARY_AXES;
use crate::system::{Activity, System, component, numbered};
use crate::tolerance::{ANGLES_AT_ONCE_DEG, ANGLES_FAR_DEG, HALF_ROTATION_SHARE, HALF_TURN_DEG};

/// An orientation with Rx and Rz above -180 up to 180 and Ry from -90 to 90 (spec/coordinated-instructions.md §22.8).
pub(crate) fn normal(given: &Point) -> Point {
    let upright = Point::new(0.0, 0.0, 0.0);
    let found = angles(&rotation(given), &upright);
    // Angles within their ranges stay unchanged.
    let kept = given.y.abs() <= 90.0
        && [given.x, given.z]
            .iter()
            .all(|angle| *angle > -180.0 && *angle <= 180.0);
    if kept { *given } else { found.map(above_half_turn) }
}

/// Replaces an angle of -180, and any that rounds to it, by 180.
fn above_half_turn(angle: f64) -> f64 {
    if angle <= -180.0 + HALF_TURN_DEG {
        angle + 360.0
    } else {
        angle
    }
}

/// The rotation between two triples of angles. Whole turns of Rz in `to` beyond half a turn are the rotation of a joint with a turns
/// counter.
pub(crate) fn rotation_between(from: &Point, to: &Point) -> Rotation {
    let [start, end] = [from, to].map(rotation);
    let shortest = Rotation::new(&start, &end, 0.0);
    let mut passed = *from;
    for sample in 1..=SAMPLES {
        let share = f64::from(sample) / f64::from(SAMPLES);
        passed = continued(&shortest.at(share).orientation, &passed);
    }
    let missing = (to.z - passed.z) / 360.0;
    // A difference of half a turn is due to the mirror rule.
    let turns = if missing.abs() <= 0.5 + HALF_ROTATION_SHARE {
        0.0
    } else {
        missing.round()
    };
    let (followed, mirrored) = shown_at_end(&shortest, from);
    let mut shown = *to;
    if mirrored {
        // A difference of half a turn of Rx is due to the mirror rule.
        let beside = (to.x - passed.x) / 360.0;
        shown.x -= if beside.abs() <= 0.5 + HALF_ROTATION_SHARE {
            0.0
        } else {
            360.0 * beside.round()
        };
    } else {
        shown.x = nearest(to.x, followed.x);
        // Close to straight up, where Rz changes by half a turn over a short distance, it may do so on the other side.
        shown.z = nearest(to.z, followed.z + 360.0 * turns);
    }
    Rotation::new(&start, &end, turns).showing([*from, shown])
}

/// The shortest rotation between two triples of angles, with additional whole turns about Z.
pub(crate) fn rotation_by(from: &Point, to: &Point, turns: f64) -> Rotation {
    let to = &if to.y.abs() > 90.0 { normal(to) } else { *to };
    let [start, end] = [from, to].map(rotation);
    let (passed, _) = shown_at_end(&Rotation::new(&start, &end, 0.0), from);
    let shown = Point::new(nearest(to.x, passed.x), to.y, nearest(to.z, passed.z) + 360.0 * turns);
    Rotation::new(&start, &end, turns).showing([*from, shown])
}

/// The angles at the end of a rotation, followed from those at its start without a step, and whether the rotation passes straight up or
/// down, where Rx and Rz change by half a turn at once, in either direction. Bounded.
fn shown_at_end(rotation: &Rotation, from: &Point) -> (Point, bool) {
    let (mut at, mut here, mut mirrored) = (*from, 0.0, false);
    let whole = f64::from(SAMPLES).recip();
    let mut step = whole;
    for _ in 0..MOST_SAMPLES {
        let share = f64::min(here + step, 1.0);
        let there = angles(&rotation.at(share).orientation, &at);
        if (there.x - at.x).abs().max((there.z - at.z).abs()) > ANGLES_FAR_DEG {
            if step * rotation.angle() > ANGLES_AT_ONCE_DEG {
                step *= 0.5;
                continue;
            }
            mirrored = true;
        }
        (at, here, step) = (there, share, whole.min(2.0 * step));
        if share >= 1.0 {
            break;
        }
    }
    (at, mirrored)
}

impl System {
    /// Rx, Ry, Rz at the end of the last move in the queue, if one of its moves rotates, in the frame in which the queue began.
    pub(crate) fn queued_heading(&self) -> Option<Point> {
        if self.activity != Activity::Moving {
            return None;
        }
        self.travel.last()?.data.heading
    }

    /// The angles at the end of the last queued move or, without such a move, the command positions.
    pub(crate) fn heading(&self, axes: &Axes) -> Point {
        self.queued_heading().unwrap_or_else(|| self.angles(axes))
    }

    /// The rotation of a move behind the queue that keeps the orientation; `None` without an orientation.
    pub(crate) fn keeping_heading(&self, axes: &Axes) -> Option<Rotation> {
        self.description.orientation?;
        Some(Rotation::keeping(&self.heading(axes)))
    }

    /// The offsets by which Rx, Ry, Rz were redefined since the queue began to use them.
    pub(crate) fn heading_shift(&self, axes: &Axes) -> Point {
        match self.queued_heading() {
            Some(_) => self.oriented(axes, |axis| axis.sum.shift_of(GeneratorKind::System)),
            None => Point::zeros(),
        }
    }

    /// The present rotation of the coordinated motion of a system.
    pub(crate) fn turning(&self, axes: &Axes) -> Option<AngularState> {
        let limits = self.travel.turn_limits()?;
        let moves = |axis: &Axis| {
            axis.sum
                .get(GeneratorKind::System)
                .map(|generator| generator.now)
                .unwrap_or_default()
        };
        let angles = self.angles(axes);
        let [rate, change] = angular_rates(
            &angles,
            &self.oriented(axes, |axis| moves(axis).velocity),
            &self.oriented(axes, |axis| moves(axis).acceleration),
        );
        Some(AngularState {
            angles,
            rate,
            change,
            limits,
        })
    }

    fn oriented(&self, axes: &Axes, quantity: impl Fn(&Axis) -> f64) -> Point {
        let mut point = Point::zeros();
        for (axis, component) in self.description.oriented().iter().zip(point.iter_mut()) {
            *component = axes.get(*axis).map_or(0.0, &quantity);
        }
        point
    }

    /// The command positions of the axes Rx, Ry, Rz.
    fn angles(&self, axes: &Axes) -> Point {
        self.oriented(axes, |axis| axis.command.position)
    }

    /// The deceleration along the path, a share of the Maximum Deceleration, reduced such that the rotation of the active move needs no more than
    /// that share of its own maximum. For a move that only rotates, it is a share of the maximum of the orientation.
    pub(crate) fn kept_by_turn(&self, deceleration: f64) -> f64 {
        let active = self.travel.active();
        active.map_or(deceleration, |active| {
            self.kept_by(deceleration, &active.path, active.rotation.as_ref())
        })
    }

    fn kept_by(&self, deceleration: f64, path: &Path, rotation: Option<&Rotation>) -> f64 {
        let (Some(turns), Some(rotation)) = (self.description.orientation, rotation) else {
            return deceleration;
        };
        let own = deceleration / self.description.max_deceleration * turns.max_deceleration;
        if path.stands() {
            own
        } else if rotation.angle() > 0.0 {
            deceleration.min(own * path.length() / rotation.angle())
        } else {
            deceleration
        }
    }

    /// Converts the limits of a stop of the active move to those of the move that it blends with, if one of them rotates: the path length of
    /// either may be an angle or a distance.
    pub(super) fn of_tail(&self, limits: &Limits) -> Option<Limits> {
        self.description.orientation?;
        let (path, rotation) = self.travel.tail()?;
        // The active move brakes at this share of the maxima; its own rotation must not reduce the deceleration of both moves.
        let most = self.description.max_deceleration;
        let deceleration = (limits.deceleration / self.kept_by_turn(most) * most).min(most);
        Some(Limits {
            deceleration: self.kept_by(deceleration, path, rotation),
            ..*limits
        })
    }

    /// Sets the axes' part of a rotation at the present tick.
    pub(super) fn set_turned_commands(&self, axes: &mut Axes, sample: &Sample) {
        let Some(rotation_state) = &sample.rotation_state else {
            return;
        };
        let shown = rotation_state.angles();
        let [velocity, acceleration] = angle_rates(&shown, &rotation_state.rate, &rotation_state.change);
        self.set_angle_commands(axes, [shown, velocity, acceleration]);
    }

    /// Sets the axes exactly to the end of the active move's rotation.
    pub(super) fn hold_heading(&self, axes: &mut Axes) {
        if let Some(end) = self.active().and_then(|active| active.heading) {
            self.set_angle_commands(axes, [end, Point::zeros(), Point::zeros()]);
        }
    }

    fn set_angle_commands(&self, axes: &mut Axes, [position, velocity, acceleration]: [Point; 3]) {
        for (member, axis) in numbered(self.description.oriented()).take(MAX_PRIMARY_AXES) {
            if let Some(axis) = axes.get_mut(axis) {
                axis.set_coordinated(KinematicState {
                    position: component(&position, member),
                    velocity: component(&velocity, member),
                    acceleration: component(&acceleration, member),
                });
            }
        }
    }
}

/// Samples of a rotation of at most half a turn: its angles change by less than a quarter turn from one to the next.
const SAMPLES: u32 = 16;
/// Most samples, with steps that are halved close to straight up.
const MOST_SAMPLES: u32 = 200;
