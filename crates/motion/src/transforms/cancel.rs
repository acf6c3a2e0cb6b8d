//! The end of a transform: nothing leads any more, and what it moved brakes (spec/coordinated-instructions.md §15.1,
//! §19.7).

use arcline_planner::profile::{Jerk, Limits, Profile};
use arcline_profile::KinematicState;

use super::compute::bit;
use super::transform::{Link, Positions, Side};
use crate::axis::sum::Slot;
use crate::axis::{Axis, AxisState};
use crate::motion::Motion;
use crate::stop::AxisSet;

/// How what a cancelled transform moved comes to rest, each axis by itself. What is not said is the maximum of the
/// coordinate system that the axis was moved for.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Release {
    /// Units/s².
    pub(crate) deceleration: Option<f64>,
    /// Units/s³, where the motion that was followed is an S-curve.
    pub(crate) jerk: Option<f64>,
}

impl Motion {
    /// Cancels every transform that an axis is part of; what they moved brakes at the maxima of the coordinate systems.
    pub(crate) fn cancel_transforms_of(&mut self, axis: u16) {
        if !self.axes[usize::from(axis)].is_linked() {
            return;
        }
        for index in 0..self.links.len() {
            if self.links[index].is_some_and(|link| link.has(axis)) {
                self.cancel_transform(index, &Release::default());
            }
        }
    }

    /// Cancels the transform of a target system. Returns the axes that brake.
    pub(crate) fn cancel_transform(&mut self, index: usize, release: &Release) -> AxisSet {
        let mut braking = AxisSet::default();
        let Some(link) = self.links.get_mut(index).and_then(Option::take) else {
            return braking;
        };
        if let Some(execution) = link.execution {
            self.end_move(execution, 0);
        }
        let mut s_curve = false;
        for axis in link.source() {
            s_curve |= self.axes[usize::from(*axis)].is_s_curve();
        }
        let mut own_s_curve = false;
        for axis in link.target() {
            let state = &self.axes[usize::from(*axis)];
            let mut own = state.sum.active().filter(|(slot, _)| *slot != Slot::Transform);
            own_s_curve |= own.any(|(_, generator)| generator.s_curve);
        }
        // Everything is let go of before anything brakes: positions stay as they are throughout.
        self.keep_beside(index, &link);
        for (axis, back) in link.source().iter().zip(&link.back) {
            let linked = &mut self.axes[usize::from(*axis)].linked;
            linked.settled += back.position;
            linked.led_back_by &= !bit(index);
            self.let_go(*axis);
        }
        for (axis, led) in link.target().iter().zip(&link.led) {
            let linked = &mut self.axes[usize::from(*axis)].linked;
            linked.rest = led.position;
            linked.leader = None;
            self.let_go(*axis);
        }
        for (axis, back) in link.source().iter().zip(&link.back) {
            self.part(
                *axis,
                back,
                &self.release(link.from, release, own_s_curve),
                &mut braking,
            );
        }
        for (axis, led) in link.target().iter().zip(&link.led) {
            self.part(*axis, led, &self.release(index, release, s_curve), &mut braking);
        }
        braking
    }

    /// What a cancelled transform had led a source back by stays beside what earlier ones make of that source: behind joints both
    /// together are something else than one after the other.
    fn keep_beside(&mut self, index: usize, cancelled: &Link) {
        for other in self.links.iter_mut().take(index).flatten() {
            let sources = other.source;
            for (axis, beside) in sources.iter().take(other.counts[0]).zip(&mut other.beside) {
                if let Some(place) = cancelled.source().iter().position(|own| own == axis) {
                    *beside += cancelled.back[place].position;
                }
            }
        }
    }

    /// Once all that transforms link stands, nothing is beside any more.
    pub(super) fn join_beside(&mut self) {
        let aside = |(_, link): (usize, &Link)| link.beside != Positions::default();
        if !self.links().any(aside) {
            return;
        }
        let adds = |link: &Link| link.robot().is_some() && link.back != Side::default();
        let moves = |(_, link): (usize, &Link)| adds(link) || self.moves_either_side(link);
        if !self.links().any(moves) {
            for link in self.links.iter_mut().flatten() {
                link.beside = Positions::default();
            }
        }
    }

    /// An axis is part of one transform less.
    fn let_go(&mut self, axis: u16) {
        let state = &mut self.axes[usize::from(axis)];
        if state.is_linked() {
            self.compose(axis);
        } else {
            state.linked.controlled = false;
            state.end(Slot::Transform);
        }
    }

    fn part(&mut self, axis: u16, moved: &KinematicState, limits: &Limits, braking: &mut AxisSet) {
        let state = &mut self.axes[usize::from(axis)];
        let limits = &within_travel(state, moved, limits);
        let stands = moved.velocity == 0.0 && (moved.acceleration == 0.0 || limits.jerk.is_none());
        if !stands && state.state == AxisState::Running {
            state.part(*moved, limits, self.clock.now());
            braking.insert(axis);
        }
    }

    fn release(&self, system: usize, release: &Release, s_curve: bool) -> Limits {
        let own = &self.systems[system].description;
        let rate = release.deceleration.unwrap_or(own.max_deceleration);
        let jerk = release.jerk.unwrap_or(own.max_deceleration_jerk);
        Limits {
            speed: own.max_speed,
            acceleration: rate,
            deceleration: rate,
            jerk: s_curve.then_some(Jerk {
                acceleration: jerk,
                deceleration: jerk,
            }),
        }
    }
}

/// A stop that ends within the travel of the axis, however short that is, at the rates of `limits` otherwise.
fn within_travel(axis: &Axis, moved: &KinematicState, limits: &Limits) -> Limits {
    let [down, up] = axis.faults.room(axis.command.position);
    let room = if moved.velocity < 0.0 { -down } else { up };
    let from = KinematicState {
        position: 0.0,
        velocity: moved.velocity,
        acceleration: limits.jerk.map_or(0.0, |_| moved.acceleration),
    };
    if room.is_infinite() || Profile::stop(from, limits).end().position.abs() <= room {
        return *limits;
    }
    let deceleration = 0.5 * moved.velocity * moved.velocity / room.max(NO_ROOM);
    Limits {
        deceleration: deceleration.max(limits.deceleration),
        jerk: None,
        ..*limits
    }
}

/// Position units.
const NO_ROOM: f64 = 1e-9;
