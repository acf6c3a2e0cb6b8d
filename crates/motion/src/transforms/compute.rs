//! Transforms under way: two coordinate systems that lead each other (spec/coordinated-instructions.md §19, §20).
//!
//! The source leads the target: where the target would be without motion of its own is what the [`Map`] makes of the
//! source. Motion that the target has of its own leads the source back, so that both stay at the same point. Between
//! Cartesian frames that is a turn of what was added. Behind a robot's joints nothing is linear: what the target adds is
//! added to where the source leads it *before* that ([`Link::down`]), and the source is led back by where this is.
//!
//! Not here: when something is computed ([`super::order`]), what MCT refuses (`instructions::mct`), what happens when a
//! robot cannot follow ([`super::failing`]), what is shown of it ([`super::shown`]). Nothing allocates. Units: position units, seconds.

use arcline_instruction_set::{AxisIndex, MotionError};
use arcline_profile::KinematicState;

use super::guard;
use super::robot::positions;
use super::transform::{Link, Map, Side, add};
use crate::axis::generator::Generator;
use crate::axis::sum::Slot;
use crate::machine::MAX_SYSTEMS;
use crate::motion::Motion;

impl Motion {
    /// Transforms under way with the place of their target system.
    pub(crate) fn links(&self) -> impl Iterator<Item = (usize, &Link)> {
        let links = self.links.iter().enumerate();
        links.filter_map(|(index, link)| link.as_ref().map(|link| (index, link)))
    }

    /// The transform that has this axis on its target's side, and the axis's place there.
    pub(super) fn leader(&self, axis: u16) -> Option<(&Link, usize)> {
        let index = self.axes[usize::from(axis)].linked.leader?;
        let link = self.links.get(usize::from(index))?.as_ref()?;
        let place = link.target().iter().position(|other| *other == axis)?;
        Some((link, place))
    }

    /// Transforms that have this axis on their source's side, but for one.
    fn followed_by(&self, axis: u16, but: Option<usize>) -> impl Iterator<Item = &Link> {
        let mut left = self.axes[usize::from(axis)].linked.led_back_by & !but.map_or(0, bit);
        std::iter::from_fn(move || {
            let index = left.trailing_zeros() as usize;
            left &= left.wrapping_sub(1);
            self.links.get(index)
        })
        .flatten()
    }

    /// What the targets' own motions add to an axis, but for one transform's.
    fn led_back(&self, axis: u16, but: Option<usize>) -> KinematicState {
        let mut total = KinematicState::default();
        for link in self.followed_by(axis, but) {
            if let Some(place) = link.source().iter().position(|other| *other == axis) {
                add(&mut total, &link.back[place]);
            }
        }
        total
    }

    /// Where transforms would lead an axis without the motion that leads it back.
    fn lead(&self, axis: u16) -> KinematicState {
        let linked = &self.axes[usize::from(axis)].linked;
        let mut lead = match self.leader(axis) {
            Some((link, place)) => link.led[place],
            None => KinematicState::at_rest(linked.rest),
        };
        lead.position += linked.settled;
        lead
    }

    /// An axis without what one transform leads it back by.
    fn without(&self, axis: u16, link: usize) -> KinematicState {
        let mut total = self.seen(axis, self.lead(axis));
        add(&mut total, &self.led_back(axis, Some(link)));
        total
    }

    /// An axis without what one transform and later ones lead it back by, ever before the whole is known.
    fn above(&self, axis: u16, link: usize) -> KinematicState {
        let linked = &self.axes[usize::from(axis)].linked;
        let mut lead = match self.leader(axis) {
            Some((link, place)) => link.down[place],
            None => KinematicState::at_rest(linked.rest),
        };
        lead.position += linked.settled;
        let mut total = self.seen(axis, lead);
        for other in (0..link).filter(|other| linked.led_back_by & bit(*other) != 0) {
            if let Some(other) = &self.links[other]
                && let Some(place) = other.source().iter().position(|own| *own == axis)
            {
                add(&mut total, &other.back[place]);
            }
        }
        total
    }

    /// An axis with what moves it besides transforms, which lead it somewhere.
    fn seen(&self, axis: u16, lead: KinematicState) -> KinematicState {
        let state = &self.axes[usize::from(axis)];
        let mut total = state.sum.motion_of(|slot| slot != Slot::Transform);
        // `lead` is in the frame of the generator; the axis is where that shows.
        let position = state.sum.seen_from(Slot::Transform, Some(lead.position));
        total.position = position.unwrap_or(state.command.position);
        total.velocity += lead.velocity;
        total.acceleration += lead.acceleration;
        total
    }

    /// What has been added to an axis by others than the transforms that lead it, ever since it became part of one.
    fn added(&self, axis: u16) -> KinematicState {
        let state = &self.axes[usize::from(axis)];
        let mut added = state.sum.motion_of(|slot| slot != Slot::Transform);
        added.position = state.sum.seen_from(Slot::Transform, Some(0.0)).unwrap_or(0.0) + state.linked.settled;
        add(&mut added, &self.led_back(axis, None));
        added
    }

    /// Whether the targets' own motions lead an axis, but for one transform's.
    pub(super) fn is_led_back(&self, axis: u16, but: Option<usize>) -> bool {
        self.followed_by(axis, but).any(|link| link.leads_back)
    }

    /// Where the source leads the target before anything leads it back.
    pub(crate) fn compute_down(&mut self, index: usize) {
        let Some(mut link) = self.links[index].filter(|link| link.failed.is_none()) else {
            return;
        };
        let mut above = Side::default();
        for ((axis, point), beside) in link.source().iter().zip(&mut above).zip(link.beside) {
            *point = self.above(*axis, index);
            point.position -= beside;
        }
        let placed = link.place(&above).and_then(|down| match link.is_led_aside() {
            true => Ok(down),
            false => self.within_speeds(&link, down, &link.down),
        });
        match placed {
            Ok(down) => (link.above, link.down) = (above, down),
            Err(error) => link.fail(error, self.clock.period()),
        }
        if let (Map::Robot(robot), None) = (&mut link.map, link.failed) {
            let mut joints = positions(&link.down);
            for (joint, offset) in joints.iter_mut().zip(link.offset) {
                *joint -= offset;
            }
            robot.follow(&above, &joints);
        }
        self.links[index] = Some(link);
    }

    /// Joints that the source leads further in an update than their speeds let them are led no more: they brake out of what they
    /// did before.
    ///
    /// # Errors
    /// 69, or 68 where a joint would turn at once.
    fn within_speeds(&self, link: &Link, led: Side, before: &Side) -> Result<Side, MotionError> {
        if !link.leads_joints() {
            return Ok(led);
        }
        let period = self.clock.period();
        for (place, axis) in link.target().iter().enumerate() {
            let (now, before) = (&led[place], &before[place]);
            if guard::too_far(before, now, self.axes[usize::from(*axis)].dynamics.speed, period) {
                let at_once = (now.position - before.position).abs() > guard::AT_ONCE;
                return Err(if at_once {
                    MotionError::TransformAtOrigin
                } else {
                    MotionError::MaxJointVelocityExceeded(AxisIndex(place as u8))
                });
            }
        }
        Ok(led)
    }

    /// The same where the target's own motion leads joints back.
    fn within_speeds_back(&self, link: &Link, back: Side) -> Result<Side, MotionError> {
        if link.robot().is_none() || link.leads_joints() {
            return Ok(back);
        }
        let period = self.clock.period();
        for (place, axis) in link.source().iter().enumerate() {
            // What the joint does besides is not the target's doing.
            let most = self.axes[usize::from(*axis)].dynamics.speed + link.above[place].velocity.abs();
            if guard::too_far(&link.back[place], &back[place], most, period) {
                return Err(MotionError::MaxJointVelocityExceeded(AxisIndex(place as u8)));
            }
        }
        Ok(back)
    }

    /// What the target's own motion adds to the source now.
    pub(crate) fn compute_back(&mut self, index: usize) {
        let Some(link) = self.links[index] else {
            return;
        };
        let leads_back = link.target().iter().any(|axis| self.leads_by_itself(*axis));
        let back = link.turn_back(&self.added_to(&link));
        let back = back.and_then(|back| self.within_speeds_back(&link, back));
        let period = self.clock.period();
        if let Some(own) = &mut self.links[index] {
            own.leads_back = leads_back;
            match back {
                _ if own.failed.is_some() => {}
                Ok(back) => {
                    own.back = back;
                    own.follow_turn();
                }
                Err(error) => own.fail(error, period),
            }
        }
    }

    /// What has been added to the target since the transform began, or since that became part of where the source is.
    pub(super) fn added_to(&self, link: &Link) -> Side {
        let mut added = Side::default();
        for ((place, axis), added) in link.target().iter().enumerate().zip(&mut added) {
            *added = self.added(*axis);
            added.position -= link.added_from[place];
        }
        added
    }

    /// Whether an axis moves otherwise than by a transform that leads it.
    pub(super) fn leads_by_itself(&self, axis: u16) -> bool {
        self.axes[usize::from(axis)].moves_itself() || self.is_led_back(axis, None)
    }

    /// Whether an axis of the source leads the target.
    pub(super) fn leads_on(&self, axis: u16, index: usize) -> bool {
        let led = self.leader(axis).is_some_and(|(other, _)| other.leads);
        self.axes[usize::from(axis)].moves_itself() || led || self.is_led_back(axis, Some(index))
    }

    /// Where the source leads the target now.
    pub(crate) fn compute_lead(&mut self, index: usize) {
        let Some(mut link) = self.links[index] else {
            return;
        };
        let s_curve = link
            .source()
            .iter()
            .any(|axis| self.axes[usize::from(*axis)].is_s_curve());
        link.leads = link.source().iter().any(|axis| self.leads_on(*axis, index));
        if link.failed.is_none() {
            let led = self.lead_of(index, &link);
            match led.and_then(|led| self.within_speeds(&link, led, &link.led)) {
                Ok(led) => link.led = led,
                Err(error) => link.fail(error, self.clock.period()),
            }
        }
        self.links[index] = Some(link);
        for axis in link.target() {
            if let Some(generator) = self.axes[usize::from(*axis)].sum.get_mut(Slot::Transform) {
                generator.s_curve = s_curve;
            }
        }
    }

    fn lead_of(&self, index: usize, link: &Link) -> Result<Side, MotionError> {
        let source = self.source_without(index, link);
        let Map::Robot(robot) = &link.map else {
            return link.place(&source);
        };
        if source == link.above {
            return Ok(link.down);
        }
        // Later targets lead the source as well: this one follows to where all of them lead it.
        let mut whole = source;
        for (whole, back) in whole.iter_mut().zip(&link.back) {
            add(whole, back);
        }
        let added = self.added_to(link);
        let mut moved = *link;
        let mut own = *robot;
        own.stand(positions(&link.with(&added)));
        moved.map = Map::Robot(own);
        let mut led = moved.place(&whole)?;
        for (led, added) in led.iter_mut().zip(&added) {
            led.position -= added.position;
            led.velocity -= added.velocity;
            led.acceleration -= added.acceleration;
        }
        Ok(led)
    }

    /// What the target of a robot's transform has moved by itself becomes part of where the source is, once all stands: the
    /// arm is then in the solution in which its joints are.
    pub(super) fn settle_transform(&mut self, index: usize) {
        let Some(mut link) = self.links[index].filter(|link| link.failed.is_none()) else {
            return;
        };
        let moves = link.target().iter().any(|axis| self.leads_by_itself(*axis))
            || link.source().iter().any(|axis| self.leads_on(*axis, index));
        let added = self.added_to(&link);
        if moves || added == Side::default() || link.robot().is_none() {
            return;
        }
        let whole = link.with(&added);
        for (place, axis) in link.source.iter().enumerate().take(link.counts[0]) {
            self.axes[usize::from(*axis)].linked.settled += link.back[place].position;
            link.above[place].position += link.back[place].position;
        }
        link.back = Side::default();
        for (place, (axis, added)) in link.target.iter().zip(&added).enumerate().take(link.counts[1]) {
            link.added_from[place] = self.added(*axis).position;
            link.offset[place] -= added.position;
        }
        if let Map::Robot(robot) = &mut link.map {
            robot.settle(&link.above, &whole);
        }
        self.links[index] = Some(link);
    }

    fn source_without(&self, index: usize, link: &Link) -> Side {
        let mut source = Side::default();
        for (axis, point) in link.source().iter().zip(&mut source) {
            *point = self.without(*axis, index);
        }
        source
    }

    /// What all transforms make of an axis now.
    pub(crate) fn compose(&mut self, axis: u16) {
        if !self.axes[usize::from(axis)].is_linked() {
            return;
        }
        let mut total = self.lead(axis);
        add(&mut total, &self.led_back(axis, None));
        self.show_controlled(axis);
        let state = &mut self.axes[usize::from(axis)];
        state.sum.set(Slot::Transform, total);
        state.command = state.sum.command();
    }

    /// A transform begins; what it refuses has been looked at. The order of the next tick has been planned for it.
    pub(crate) fn begin_transform(&mut self, target: usize, mut link: Link) {
        for axis in link.source().iter().chain(link.target()) {
            let state = &mut self.axes[usize::from(*axis)];
            if !state.is_linked() {
                state.linked.rest = state.command.position;
                state.linked.settled = 0.0;
                state.sum.begin(Slot::Transform, Generator::followed(false));
            }
            state.stale = true;
        }
        let targets = link.target;
        for (place, axis) in targets.iter().enumerate().take(link.counts[1]) {
            link.added_from[place] = self.added(*axis).position;
        }
        let source = self.source_without(target, &link);
        // What it is cannot fail: it has been verified for this position.
        let placed = link.place(&source).unwrap_or_default();
        link.above = source;
        for (place, axis) in targets.iter().enumerate().take(link.counts[1]) {
            let rest = self.axes[usize::from(*axis)].linked.rest;
            link.offset[place] = rest - placed[place].position;
            link.down[place] = KinematicState::at_rest(rest);
            link.led[place] = KinematicState::at_rest(rest);
            // No machine has more systems than a byte counts.
            self.axes[usize::from(*axis)].linked.leader = Some(target as u8);
        }
        for axis in link.source() {
            self.axes[usize::from(*axis)].linked.led_back_by |= bit(target);
        }
        self.links[target] = Some(link);
        self.order.take();
    }
}

/// The bit of a transform in an axis's `Linked`, by the place of its target system.
pub(super) fn bit(index: usize) -> u64 {
    const { assert!(MAX_SYSTEMS <= 64) };
    1 << index
}
