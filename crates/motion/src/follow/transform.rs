//! Transforms under way: two coordinate systems that lead each other (spec/coordinated-instructions.md §19, §20).
//!
//! The source leads the target: where the target would be without motion of its own is what [`Link::place`] makes of
//! the source. Motion that the target has of its own leads the source back by what [`Link::turn_back`] makes of it, so
//! that both stay at the same point. These two functions and [`Link::source_of`] are all that knows the geometry; they
//! are the inverse and forward transform of other geometries.
//!
//! Not here: when something is computed ([`super::order`]), and what MCT refuses (`instructions::mct`). Nothing
//! allocates. Units: position units, seconds.

use arcline_drive::Motion as Point;
use arcline_planner::geometry::{Frame, Point as Vector};

use crate::axis::generator::Generator;
use crate::axis::sum::Slot;
use crate::control::Execution;
use crate::machine::{MAX_PRIMARY_AXES, MAX_SYSTEMS};
use crate::motion::Motion;

/// Position, velocity and acceleration of each axis of one side.
pub(crate) type Side = [Point; MAX_PRIMARY_AXES];

/// A transform under way. It is kept at the place of its target system.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Link {
    pub(crate) execution: Option<Execution>,
    /// Place of the source system.
    pub(crate) from: usize,
    frame: Frame,
    dimension: usize,
    source: [u16; MAX_PRIMARY_AXES],
    target: [u16; MAX_PRIMARY_AXES],
    /// What the target was off the transformed source at the start, in the frames of its axes' generators.
    offset: Vector,
    /// What had been added to the target at the start.
    added_from: Vector,
    /// Where the target is led to, in the frames of its axes' generators.
    pub(super) led: Side,
    /// What the target's own motion adds to the source.
    pub(super) back: Side,
    /// Whether the source moves, or is held to be moved, and so leads.
    pub(super) leads: bool,
    /// The same of the target's own motion.
    pub(super) leads_back: bool,
}

impl Link {
    pub(crate) fn new(execution: Option<Execution>, from: usize, frame: Frame, source: &[u16], target: &[u16]) -> Self {
        let mut link = Link {
            execution,
            from,
            frame,
            dimension: source.len().min(target.len()).min(MAX_PRIMARY_AXES),
            source: [0; MAX_PRIMARY_AXES],
            target: [0; MAX_PRIMARY_AXES],
            offset: Vector::zeros(),
            added_from: Vector::zeros(),
            led: Side::default(),
            back: Side::default(),
            leads: false,
            leads_back: false,
        };
        let places = link.source.iter_mut().zip(&mut link.target);
        for ((from, to), (source, target)) in places.zip(source.iter().zip(target)) {
            (*from, *to) = (*source, *target);
        }
        link
    }

    /// One that turns and shifts nothing.
    #[cfg(test)]
    pub(crate) fn between(source: &[u16], target: &[u16]) -> Self {
        let frame = Frame::new(Vector::zeros(), Vector::zeros());
        Link::new(None, 0, frame, source, target)
    }

    /// Axes of the source, in the order of its system.
    pub(crate) fn source(&self) -> &[u16] {
        &self.source[..self.dimension]
    }

    /// Axes of the target, in the order of its system.
    pub(crate) fn target(&self) -> &[u16] {
        &self.target[..self.dimension]
    }

    /// Whether an axis is on either side.
    pub(crate) fn has(&self, axis: u16) -> bool {
        self.source().contains(&axis) || self.target().contains(&axis)
    }

    /// The inverse transform: where the target is while the source is there.
    fn place(&self, source: &Side) -> Side {
        let [position, velocity, acceleration] = vectors(source);
        let placed = self.frame.place(&position) + self.offset;
        side([placed, self.frame.turn(&velocity), self.frame.turn(&acceleration)])
    }

    /// The forward transform of what has been added to the target.
    fn turn_back(&self, added: &Side) -> Side {
        side(vectors(added).map(|vector| self.frame.turn_back(&vector)))
    }

    /// The forward transform: where the source is while the target is there.
    pub(crate) fn source_of(&self, target: &Vector) -> Vector {
        self.frame.place_back(target)
    }
}

impl Motion {
    /// Transforms under way with the place of their target system.
    pub(crate) fn links(&self) -> impl Iterator<Item = (usize, &Link)> {
        let links = self.links.iter().enumerate();
        links.filter_map(|(index, link)| link.as_ref().map(|link| (index, link)))
    }

    /// The transform that has this axis on its target's side, and the axis's place there.
    fn leader(&self, axis: u16) -> Option<(&Link, usize)> {
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
    fn led_back(&self, axis: u16, but: Option<usize>) -> Point {
        let mut total = Point::default();
        for link in self.followed_by(axis, but) {
            if let Some(place) = link.source().iter().position(|other| *other == axis) {
                add(&mut total, &link.back[place]);
            }
        }
        total
    }

    /// Where transforms would lead an axis without the motion that leads it back.
    fn lead(&self, axis: u16) -> Point {
        let linked = &self.axes[usize::from(axis)].linked;
        let mut lead = match self.leader(axis) {
            Some((link, place)) => link.led[place],
            None => standing(linked.rest),
        };
        lead.position += linked.settled;
        lead
    }

    /// An axis without what one transform leads it back by.
    fn without(&self, axis: u16, link: usize) -> Point {
        let lead = self.lead(axis);
        let state = &self.axes[usize::from(axis)];
        let mut total = state.sum.motion_of(|slot| slot != Slot::Transform);
        // `lead` is in the frame of the generator; the axis is where that shows.
        let position = state.sum.seen_from(Slot::Transform, Some(lead.position));
        total.position = position.unwrap_or(state.command.position);
        total.velocity += lead.velocity;
        total.acceleration += lead.acceleration;
        add(&mut total, &self.led_back(axis, Some(link)));
        total
    }

    /// What has been added to an axis by others than the transforms that lead it, ever since it became part of one.
    fn added(&self, axis: u16) -> Point {
        let state = &self.axes[usize::from(axis)];
        let mut added = state.sum.motion_of(|slot| slot != Slot::Transform);
        added.position = state.sum.seen_from(Slot::Transform, Some(0.0)).unwrap_or(0.0) + state.linked.settled;
        add(&mut added, &self.led_back(axis, None));
        added
    }

    /// Whether the targets' own motions lead an axis, but for one transform's.
    fn is_led_back(&self, axis: u16, but: Option<usize>) -> bool {
        self.followed_by(axis, but).any(|link| link.leads_back)
    }

    /// What the target's own motion adds to the source now.
    pub(super) fn compute_back(&mut self, index: usize) {
        let Some(link) = self.links[index] else {
            return;
        };
        let mut added = Side::default();
        for ((place, axis), added) in link.target().iter().enumerate().zip(&mut added) {
            *added = self.added(*axis);
            added.position -= link.added_from[place];
        }
        let moves = |axis: &u16| self.axes[usize::from(*axis)].moves_itself() || self.is_led_back(*axis, None);
        let leads_back = link.target().iter().any(moves);
        if let Some(own) = &mut self.links[index] {
            own.back = link.turn_back(&added);
            own.leads_back = leads_back;
        }
    }

    /// Where the source leads the target now.
    pub(super) fn compute_lead(&mut self, index: usize) {
        let Some(link) = self.links[index] else {
            return;
        };
        let source = self.source_without(index, &link);
        let mut s_curve = false;
        let mut leads = false;
        for axis in link.source() {
            let state = &self.axes[usize::from(*axis)];
            s_curve |= state.is_s_curve();
            let led = self.leader(*axis).is_some_and(|(other, _)| other.leads);
            leads |= state.moves_itself() || led || self.is_led_back(*axis, Some(index));
        }
        if let Some(own) = &mut self.links[index] {
            own.led = link.place(&source);
            own.leads = leads;
        }
        for axis in link.target() {
            if let Some(generator) = self.axes[usize::from(*axis)].sum.get_mut(Slot::Transform) {
                generator.s_curve = s_curve;
            }
        }
    }

    fn source_without(&self, index: usize, link: &Link) -> Side {
        let mut source = Side::default();
        for (axis, point) in link.source().iter().zip(&mut source) {
            *point = self.without(*axis, index);
        }
        source
    }

    /// What all transforms make of an axis now.
    pub(super) fn compose(&mut self, axis: u16) {
        if !self.axes[usize::from(axis)].is_linked() {
            return;
        }
        let mut total = self.lead(axis);
        add(&mut total, &self.led_back(axis, None));
        let led = self.leader(axis).is_some_and(|(link, _)| link.leads);
        let led_back = self.is_led_back(axis, None);
        let state = &mut self.axes[usize::from(axis)];
        state.linked.controlled = led || led_back;
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
        for (place, axis) in targets.iter().enumerate().take(link.dimension) {
            link.added_from[place] = self.added(*axis).position;
        }
        let source = self.source_without(target, &link);
        let placed = link.place(&source);
        for (place, axis) in targets.iter().enumerate().take(link.dimension) {
            let rest = self.axes[usize::from(*axis)].linked.rest;
            link.offset[place] = rest - placed[place].position;
            link.led[place] = standing(rest);
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

fn vectors(side: &Side) -> [Vector; 3] {
    let mut vectors = [Vector::zeros(); 3];
    for (place, point) in side.iter().enumerate() {
        vectors[0][place] = point.position;
        vectors[1][place] = point.velocity;
        vectors[2][place] = point.acceleration;
    }
    vectors
}

fn side([position, velocity, acceleration]: [Vector; 3]) -> Side {
    let mut side = Side::default();
    for (place, point) in side.iter_mut().enumerate() {
        *point = Point {
            position: position[place],
            velocity: velocity[place],
            acceleration: acceleration[place],
        };
    }
    side
}

fn add(total: &mut Point, more: &Point) {
    total.position += more.position;
    total.velocity += more.velocity;
    total.acceleration += more.acceleration;
}

fn standing(position: f64) -> Point {
    Point {
        position,
        velocity: 0.0,
        acceleration: 0.0,
    }
}
