//! A stop that would begin at the next update: the motions that move a robot's joints, until they are at rest.
//!
//! It is the stop that the guard would execute (`crate::motion`), with the present jerk, accelerations and superposed motions. Not here:
//! the resulting motion of the joints ([`super::guard`]). Real-time: nothing allocates; bounded by the transforms, the coordinate systems
//! and the axes. Units: position units, seconds.

use arcline_instruction_set::{AxisId, SystemId};
use arcline_planner::geometry::{Point as Vector, angle_rates, angles};
use arcline_planner::profile::{DynamicsBits, Limits, Profile};
use arcline_planner::{Clock, PathStopping, Sample};
use arcline_profile::KinematicState;

use super::present::Present;
use super::sides::SideState;
use super::transform::Transform;
use crate::axes::{AxisList, share};
use crate::axis::generator::{Equation, Generator};
use crate::axis::generator_kind::GeneratorKind;
use crate::machine::MAX_SYSTEM_AXES;
use crate::system::{component, numbered};

/// Planned stops that have not begun; their memory is reused for every plan.
#[derive(Debug, Default)]
pub(crate) struct PlannedStops {
    paths: Vec<PathStop>,
    axes: Vec<AxisStop>,
    /// The displacement of each axis of the machine from its present position, and its rate.
    steps: Vec<KinematicState>,
}

/// The stop of a coordinate system on its path.
#[derive(Clone, Debug)]
struct PathStop {
    system: SystemId,
    stopping: PathStopping,
    /// Rx, Ry, Rz at the last sample, degrees.
    near: Vector,
}

/// The stop of a generator of an axis.
#[derive(Clone, Copy, Debug)]
struct AxisStop {
    axis: AxisId,
    profile: Profile,
    /// Seconds of the profile that have passed when the stop begins.
    since: f64,
    /// The present position of the generator.
    from: f64,
}

impl PlannedStops {
    /// For a machine with these numbers of axes and coordinate systems. The only allocation.
    pub(crate) fn new(axes: usize, systems: usize) -> Self {
        PlannedStops {
            paths: Vec::with_capacity(systems),
            axes: Vec::with_capacity(AXIS_STOPS),
            steps: vec![KinematicState::default(); axes],
        }
    }

    /// Seconds from the next update until all motion of the plan is at rest.
    pub(super) fn duration(&self) -> f64 {
        let paths = self.paths.iter().map(|stop| stop.stopping.duration());
        let axes = self.axes.iter().map(|stop| stop.profile.duration() - stop.since);
        paths.chain(axes).fold(0.0, f64::max)
    }

    /// The displacement of an axis from its present position at the last sample, by its own generators.
    pub(super) fn step(&self, axis: AxisId) -> KinematicState {
        self.steps[usize::from(axis)]
    }
}

impl Present<'_> {
    /// Plans a stop of all motion that moves a transform, including the target's own motion, from the next update on.
    pub(super) fn plan_ahead(&self, transform: &Transform, ahead: &mut PlannedStops) {
        ahead.paths.clear();
        ahead.axes.clear();
        let involved = self.involved(transform);
        for axis in involved.iter().copied() {
            ahead.steps[usize::from(axis)] = KinematicState::default();
            self.plan_axis(axis, ahead);
        }
        for (index, system) in self.systems.ids().zip(self.systems.iter()) {
            if !system.is_busy() || !share(system.taken(), &involved) {
                continue;
            }
            for axis in system.taken() {
                ahead.steps[usize::from(*axis)] = KinematicState::default();
            }
            if let Some(stopping) = self.stopping(index)
                && ahead.paths.len() < ahead.paths.capacity()
            {
                let near = self.turned_to(index);
                ahead.paths.push(PathStop {
                    system: index,
                    stopping,
                    near,
                });
            }
        }
    }

    /// Samples a plan at an instant, `seconds` after the next update.
    pub(super) fn sample_stop(&self, ahead: &mut PlannedStops, seconds: f64) {
        for stop in &ahead.axes {
            ahead.steps[usize::from(stop.axis)] = KinematicState::default();
        }
        for stop in &ahead.paths {
            for axis in self.systems[stop.system].taken() {
                ahead.steps[usize::from(*axis)] = KinematicState::default();
            }
        }
        for stop in &ahead.axes {
            let at = stop.profile.at(stop.since + seconds);
            let step = &mut ahead.steps[usize::from(stop.axis)];
            step.position += at.position - stop.from;
            step.velocity += at.velocity;
            step.acceleration += at.acceleration;
        }
        let clock = self.clock.next().later(seconds);
        for stop in &mut ahead.paths {
            let system = &self.systems[stop.system];
            if let Some(sample) = system.travel.sample_stopping(&stop.stopping, &clock) {
                self.step_along(stop, &sample, &mut ahead.steps);
            }
        }
    }

    /// The axes of both sides of a transform, and of the sources of the transforms before it.
    fn involved(&self, transform: &Transform) -> AxisList<INVOLVED> {
        let mut involved: AxisList<INVOLVED> = transform.target.iter().copied().collect();
        let mut next = Some(transform);
        for _ in 0..self.transforms.most() {
            let Some(transform) = next else { break };
            involved.extend(transform.source.iter().copied());
            next = self.transforms.preceding(transform).map(|(_, preceding)| preceding);
        }
        involved
    }

    fn plan_axis(&self, axis: AxisId, ahead: &mut PlannedStops) {
        let state = &self.axes[axis];
        let limits = state.guarded_stop();
        for (kind, generator) in state.sum.active() {
            if matches!(kind, GeneratorKind::Transform | GeneratorKind::MasterOffset) || ahead.axes.len() >= AXIS_STOPS
            {
                continue;
            }
            let own = match &generator.equation {
                Equation::Planned { profile, start } if generator.follower.is_none() => {
                    Some((profile, start.elapsed(&self.clock.next())))
                }
                // The coordinate system plans this generator.
                Equation::Followed if kind == GeneratorKind::System => continue,
                _ => None,
            };
            let stop = kind.is_single_axis().then(|| {
                let next = coming(generator, own, self.clock.period());
                generator.soonest(own, next, &limits, state.dynamics_bits)
            });
            let (profile, since) = match (stop.flatten(), own) {
                (Some(stop), _) => (stop, 0.0),
                (None, Some((own, since))) => (*own, since),
                (None, None) => continue,
            };
            ahead.axes.push(AxisStop {
                axis,
                profile,
                since,
                from: generator.now.position,
            });
        }
    }

    fn stopping(&self, index: SystemId) -> Option<PathStopping> {
        let system = &self.systems[index];
        let mut base = system.time_base(self.clock);
        base.time = self.clock.next();
        // The master keeps its present motion for an update.
        if let Some(master) = &mut base.master {
            let (period, rate) = (self.clock.period(), master.rate);
            let gone = (rate.speed + 0.5 * rate.acceleration * period) * period;
            master.displacement += gone.max(0.0);
            master.rate.speed = (rate.speed + rate.acceleration * period).max(0.0);
        }
        system.travel.stopping(&system.guarded_stop(), &base)
    }

    /// Rx, Ry, Rz of a coordinate system's own move, degrees.
    fn turned_to(&self, index: SystemId) -> Vector {
        let mut near = Vector::zeros();
        for (axis, angle) in self.systems[index].description.oriented().iter().zip(near.iter_mut()) {
            *angle = self.coordinated(*axis);
        }
        near
    }

    /// The position of the coordinated part of an axis's motion.
    fn coordinated(&self, axis: AxisId) -> f64 {
        let generator = self.axes[axis].sum.get(GeneratorKind::System);
        generator.map_or(0.0, |generator| generator.now.position)
    }

    fn step_along(&self, stop: &mut PathStop, sample: &Sample, steps: &mut [KinematicState]) {
        let system = &self.systems[stop.system].description;
        let mut add = |axes: &[AxisId], [position, velocity, acceleration]: [Vector; 3]| {
            for (component_index, axis) in numbered(axes) {
                let step = &mut steps[usize::from(axis)];
                step.position += component(&position, component_index) - self.coordinated(axis);
                step.velocity += component(&velocity, component_index);
                step.acceleration += component(&acceleration, component_index);
            }
        };
        add(system.linear(), [sample.position, sample.velocity, sample.acceleration]);
        if let Some(rotation_state) = &sample.rotation_state {
            stop.near = angles(&rotation_state.orientation, &stop.near);
            let [rate, change] = angle_rates(&stop.near, &rotation_state.rate, &rotation_state.change);
            add(system.oriented(), [stop.near, rate, change]);
        }
    }

    /// The position of a transform's source at the last sample of a plan.
    pub(super) fn source_ahead(&self, transform: &Transform, ahead: &PlannedStops) -> SideState {
        let transforms = self.transforms;
        let mut source = transforms.step_of(transform, &|axis| ahead.step(axis), transforms.most());
        for (point, present) in source
            .iter_mut()
            .zip(&transform.source_before)
            .take(transform.source.len())
        {
            point.position += present.position;
        }
        source
    }
}

/// The motion of a generator at the next update: by its profile, or by its present motion.
fn coming(generator: &Generator, own: Option<(&Profile, f64)>, period: f64) -> KinematicState {
    match own {
        Some((profile, since)) => profile.at(since),
        None => {
            let now = generator.now;
            KinematicState {
                position: now.position + (now.velocity + 0.5 * now.acceleration * period) * period,
                velocity: now.velocity + now.acceleration * period,
                ..now
            }
        }
    }
}

impl Generator {
    /// A stop from a state, unless the generator's own profile, of which this many seconds have passed then, comes to rest sooner.
    pub(crate) fn soonest(
        &self,
        own: Option<(&Profile, f64)>,
        mut from: KinematicState,
        limits: &Limits,
        dynamics_bits: DynamicsBits,
    ) -> Option<Profile> {
        if limits.jerk.is_none() {
            from.acceleration = 0.0;
        }
        let before = self.in_force.filter(|_| self.follower.is_none());
        let stop = Profile::stop_within(from, limits, before.as_ref(), dynamics_bits);
        let sooner =
            own.is_some_and(|(own, since)| own.end().velocity == 0.0 && own.duration() - since <= stop.duration());
        (!sooner).then_some(stop)
    }

    /// Its own profile over time, and the seconds of it that have passed at the present tick.
    pub(crate) fn timed(&self, clock: &Clock) -> Option<(&Profile, f64)> {
        match &self.equation {
            Equation::Planned { profile, start } if self.follower.is_none() => Some((profile, start.elapsed(clock))),
            _ => None,
        }
    }
}

/// Axes of a transform and of its sources: four systems.
const INVOLVED: usize = 4 * MAX_SYSTEM_AXES;
/// Generators in one plan; further ones are noticed only after they have moved the joints too far.
const AXIS_STOPS: usize = 32;
