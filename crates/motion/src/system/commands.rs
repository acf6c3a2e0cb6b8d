//! The set-points that a coordinate system calculates for its axes, the start and end of its use of them, and the settling at an end.
//!
//! Not here: ends of moves ([`super::advance`]). Real-time: no allocation; bounded by the axes. Units: position units, seconds.

use arcline_instruction_set::Flag;
use arcline_planner::geometry::Point;
use arcline_planner::profile::{KinematicState, Phase};
use arcline_planner::{Clock, Instant, Sample};

use super::{Activity, Shown, System, component, numbered};
use crate::axes::Axes;
use crate::axis::generator_kind::GeneratorKind;
use crate::control::{Controls, phase_flags};

impl System {
    /// Calculates the commands of its axes at the present tick, and ACCEL and DECEL of its active instruction.
    pub(crate) fn sample(&mut self, axes: &mut Axes, controls: &mut Controls, clock: &Clock) {
        let base = self.time_base(clock);
        let Some((sample, planned)) = self.travel.sample(&base) else {
            return;
        };
        let length = self.travel.length();
        // The vector of all its motion of X, Y and Z; a move that only rotates has an angular speed.
        let only_turns = self.active().is_some_and(|active| active.only_turns);
        let speed = match sample.velocity.norm() {
            0.0 if only_turns => sample.along.velocity.abs(),
            speed => speed,
        };
        // No motion has begun while the move waits for a lock.
        let waits = self.follower.is_some_and(|follower| !follower.has_begun());
        let phase = if waits { Phase::Steady } else { sample.phase };
        let (moves, trend) = match &self.follower {
            // The move may be steady while its master accelerates or stands.
            Some(_) => (sample.along.velocity != 0.0, sample.along.phase()),
            None => (!self.travel.is_paused() && length > 0.0, phase),
        };
        self.shown = Shown {
            in_transition: self.travel.in_transition(&base),
            has_moved: self.shown.has_moved || moves,
            trend,
            speed,
            distance: sample.along.position.clamp(0.0, length),
            length,
            ..self.shown
        };
        self.set_commands(axes, &sample);
        let Some(execution) = self.active().map(|active| active.execution) else {
            return;
        };
        if self.activity == Activity::Moving && phase != self.shown.phase {
            self.shown.phase = phase;
            let (set, clear) = phase_flags(phase);
            controls.write(execution, set, clear);
        }
        let tracking = self.is_tracking(planned);
        if std::mem::replace(&mut self.shown.tracking, tracking) != tracking {
            controls.flag(execution, Flag::TrackingMaster, tracking);
        }
    }

    /// Sets the axes' part of a coordinated move that has just begun, for instructions later in the same tick.
    pub(crate) fn set_axis_commands(&self, axes: &mut Axes, clock: &Clock) {
        if let Some((sample, _)) = self.travel.sample(&self.time_base(clock)) {
            self.set_commands(axes, &sample);
        }
    }

    fn set_commands(&self, axes: &mut Axes, sample: &Sample) {
        for (member, axis) in numbered(self.description.linear()) {
            if let Some(axis) = axes.get_mut(axis) {
                axis.set_coordinated(KinematicState {
                    position: component(&sample.position, member),
                    velocity: component(&sample.velocity, member),
                    acceleration: component(&sample.acceleration, member),
                });
            }
        }
        self.set_turned_commands(axes, sample);
    }

    /// Sets the commands exactly to the programmed end of the active move.
    pub(super) fn set_end_position(&self, axes: &mut Axes) {
        if let Some(active) = self.travel.active() {
            let end = active.path.end();
            self.hold_at(axes, &end);
            self.hold_heading(axes);
        }
    }

    /// Sets the commands exactly to a point.
    fn hold_at(&self, axes: &mut Axes, end: &Point) {
        for (member, axis) in numbered(self.description.linear()) {
            if let Some(axis) = axes.get_mut(axis) {
                axis.set_coordinated(KinematicState {
                    position: component(end, member),
                    ..Default::default()
                });
            }
        }
    }

    /// The instant at which the axes came within the Actual Tolerance of the end at which their commands have stood since `reached`: at once if
    /// every axis follows exactly, otherwise according to the last exchange. If it is not known yet, the system asks for it after the next
    /// exchange.
    pub(super) fn settled(&mut self, reached: Instant, axes: &mut Axes, clock: &Clock) -> Option<Instant> {
        let own = self.description.linear();
        let stood = reached.elapsed(clock);
        for axis in own {
            axes[*axis].link.stood = stood;
        }
        if own.iter().all(|axis| axes[*axis].follows_exactly()) {
            return Some(reached);
        }
        if let Some(settled) = self.settled.take() {
            return Some(settled);
        }
        self.settling = Some(reached);
        None
    }

    /// Makes its axes part of its coordinated move, or of the next one.
    pub(crate) fn join_axes(&self, axes: &mut Axes) {
        let s_curve = self.is_s_curve();
        let active = self.active();
        let turns = active.is_some_and(|active| active.heading.is_some());
        let description = &self.description;
        let taken = if turns {
            description.axes.len()
        } else {
            description.linear().len()
        };
        let start = self.travel.active().map(|active| active.path.start());
        let linear = description.linear().len();
        for (member, axis) in numbered(&description.axes[..taken]) {
            let Some(axis) = axes.get_mut(axis) else {
                continue;
            };
            match axis.sum.get_mut(GeneratorKind::System) {
                Some(generator) if !generator.stopping => {
                    generator.s_curve = s_curve;
                    axis.mark_start();
                }
                _ => match start.filter(|_| usize::from(member.0) < linear) {
                    Some(start) => axis.begin_coordinated_from(s_curve, component(&start, member)),
                    None => axis.begin_coordinated(s_curve),
                },
            }
        }
    }

    /// Makes Rx, Ry, Rz part of the pending moves: from now on, other rotation of these axes adds to that of the moves.
    pub(crate) fn begin_coordinated_rotation(&self, axes: &mut Axes, s_curve: bool) {
        for axis in self.description.oriented() {
            if let Some(axis) = axes.get_mut(*axis)
                && !axis.is_coordinated()
            {
                axis.begin_coordinated(s_curve);
            }
        }
    }

    /// Releases its axes from its coordinated move in their present motion.
    pub(crate) fn release_axes_in_motion(&self, axes: &mut Axes) {
        for axis in self.taken() {
            if let Some(axis) = axes.get_mut(*axis) {
                axis.release();
            }
        }
    }

    /// Releases its axes at rest; no move is active any more.
    pub(crate) fn release_axes(&mut self, axes: &mut Axes) {
        self.rest();
        for axis in self.taken() {
            if let Some(axis) = axes.get_mut(*axis)
                && axis.is_coordinated()
            {
                axis.release();
            }
        }
    }

    /// CommandPosToleranceStatus at the present tick.
    pub(crate) fn update_tolerance(&mut self, axes: &Axes) {
        if self.activity != Activity::Moving {
            return;
        }
        if let Some(end) = self.travel.active().map(|active| active.path.end()) {
            let squares = numbered(self.description.linear()).map(|(member, axis)| {
                let generator = axes.get(axis).and_then(|axis| axis.sum.get(GeneratorKind::System));
                let left = generator.map_or(0.0, |generator| generator.now.position) - component(&end, member);
                left * left
            });
            self.shown.in_command_tolerance = squares.sum::<f64>().sqrt() < self.description.command_tolerance;
        }
    }
}
