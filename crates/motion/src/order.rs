//! The order in which axes are computed within a tick when some follow others: what is followed comes first.
//!
//! It is worked out when a link is made. A link that ended leaves an order that is still right. Not here: what a step
//! does. Nothing allocates after [`Order::new`]; working an order out is bounded by axes × links.

use crate::axes::share;
use crate::transforms::transform::Link;

/// A part of the computation of one tick.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Step {
    /// The coordinated move of a system that is linked to a master.
    System(u16),
    /// What an axis's own generators say, what follows masters included.
    Own(u16),
    /// Where a transform leads its target before the targets of its source lead anything back.
    Down(u16),
    /// What the motion of a transform's target adds to its source.
    Back(u16),
    /// Where a transform leads its target.
    Lead(u16),
    /// The whole command of an axis; its drive follows it.
    Whole(u16),
}

/// The axes of a machine follow each other in a circle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Circle;

/// Something that is to follow from the next tick on.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Follower<'a> {
    /// An axis and its master.
    Axis(u16, u16),
    /// A coordinate system and its master.
    System(usize, u16),
    /// The target system of a transform.
    Target(usize, &'a Link),
}

/// Who follows whom.
pub(crate) struct Followers<'a, M, S> {
    /// Axes of the machine.
    pub(crate) axes: usize,
    /// The masters of an axis.
    pub(crate) masters: M,
    /// The axes of a coordinate system, and its masters.
    pub(crate) systems: S,
    /// Transforms under way, at the place of their target system.
    pub(crate) links: &'a [Option<Link>],
}

/// Axes that one axis or coordinate system follows.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Masters {
    axes: [u16; MOST_MASTERS],
    count: usize,
}

/// Masters of one slave: by gear, by every link of an axis, and by what was begun by links that were replaced since.
const MOST_MASTERS: usize = 16;

impl Masters {
    pub(crate) fn add(&mut self, axis: u16) {
        if !self.iter().any(|known| known == axis)
            && let Some(place) = self.axes.get_mut(self.count)
        {
            *place = axis;
            self.count += 1;
        }
    }

    pub(crate) fn iter(&self) -> impl Iterator<Item = u16> {
        self.axes[..self.count].iter().copied()
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.count == 0
    }
}

impl FromIterator<u16> for Masters {
    fn from_iter<I: IntoIterator<Item = u16>>(axes: I) -> Self {
        let mut masters = Masters::default();
        for axis in axes {
            masters.add(axis);
        }
        masters
    }
}

/// The order of a tick's steps; empty when nothing follows.
#[derive(Debug)]
pub(crate) struct Order {
    steps: Vec<Step>,
    next: Vec<Step>,
    visits: Vec<Visit>,
    axes: usize,
    systems: usize,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Visit {
    Ahead,
    UnderWay,
    Over,
}

impl Order {
    /// For a machine of so many axes and coordinate systems. The only allocation.
    pub(crate) fn new(axes: usize, systems: usize) -> Self {
        let most = 2 * axes + 4 * systems;
        Order {
            steps: Vec::with_capacity(most),
            next: Vec::with_capacity(most),
            visits: vec![Visit::Ahead; most],
            axes,
            systems,
        }
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.steps.is_empty()
    }

    pub(crate) fn len(&self) -> usize {
        self.steps.len()
    }

    pub(crate) fn step(&self, place: usize) -> Option<Step> {
        self.steps.get(place).copied()
    }

    /// Nothing follows any more.
    pub(crate) fn clear(&mut self) {
        self.steps.clear();
    }

    /// Works out an order, to be taken by [`Order::take`].
    ///
    /// # Errors
    /// When there is none. The present order stays.
    pub(crate) fn plan<'a, M, S>(&mut self, followers: &Followers<'a, M, S>) -> Result<(), Circle>
    where
        M: Fn(u16) -> Masters,
        S: Fn(usize) -> (&'a [u16], Masters),
    {
        self.next.clear();
        self.visits.fill(Visit::Ahead);
        for axis in 0..followers.axes {
            self.visit(Step::Whole(axis as u16), followers)?;
        }
        Ok(())
    }

    /// The order that was planned last is that of the next tick.
    pub(crate) fn take(&mut self) {
        std::mem::swap(&mut self.steps, &mut self.next);
    }

    /// A step behind all that it needs. As deep as there are steps at most.
    fn visit<'a, M, S>(&mut self, step: Step, followers: &Followers<'a, M, S>) -> Result<(), Circle>
    where
        M: Fn(u16) -> Masters,
        S: Fn(usize) -> (&'a [u16], Masters),
    {
        let place = self.place(step);
        match self.visits.get(place) {
            Some(Visit::Ahead) => {}
            Some(Visit::UnderWay) => return Err(Circle),
            Some(Visit::Over) | None => return Ok(()),
        }
        self.visits[place] = Visit::UnderWay;
        let links = || {
            let links = followers.links.iter().enumerate();
            links.filter_map(|(index, link)| link.as_ref().map(|link| (index as u16, link)))
        };
        match step {
            Step::System(index) => {
                for master in (followers.systems)(usize::from(index)).1.iter() {
                    self.visit(Step::Whole(master), followers)?;
                }
            }
            Step::Own(axis) => {
                for index in 0..self.systems {
                    let (axes, masters) = (followers.systems)(index);
                    if !masters.is_empty() && axes.contains(&axis) {
                        self.visit(Step::System(index as u16), followers)?;
                    }
                }
                for master in (followers.masters)(axis).iter() {
                    self.visit(Step::Whole(master), followers)?;
                }
            }
            Step::Whole(axis) => {
                self.visit(Step::Own(axis), followers)?;
                for (index, link) in links() {
                    if link.source().contains(&axis) {
                        self.visit(Step::Back(index), followers)?;
                    }
                    if link.target().contains(&axis) {
                        self.visit(Step::Lead(index), followers)?;
                    }
                }
            }
            Step::Back(index) => {
                let Some(Some(link)) = followers.links.get(usize::from(index)) else {
                    return Ok(());
                };
                for axis in link.target() {
                    self.visit(Step::Own(*axis), followers)?;
                }
                for (other, further) in links() {
                    if share(further.source(), link.target()) {
                        self.visit(Step::Back(other), followers)?;
                    }
                }
                // Behind a robot's joints what is added depends on where they are led to.
                if link.robot().is_some() {
                    self.visit(Step::Down(index), followers)?;
                }
            }
            Step::Down(index) => {
                let Some(Some(link)) = followers.links.get(usize::from(index)) else {
                    return Ok(());
                };
                for axis in link.source() {
                    self.visit(Step::Own(*axis), followers)?;
                }
                for (other, near) in links() {
                    if other < index && share(near.source(), link.source()) {
                        self.visit(Step::Back(other), followers)?;
                    }
                    if share(near.target(), link.source()) {
                        self.visit(Step::Down(other), followers)?;
                    }
                }
            }
            Step::Lead(index) => {
                let Some(Some(link)) = followers.links.get(usize::from(index)) else {
                    return Ok(());
                };
                for axis in link.source() {
                    self.visit(Step::Own(*axis), followers)?;
                }
                for (other, near) in links() {
                    if share(near.source(), link.source()) {
                        self.visit(Step::Back(other), followers)?;
                    }
                    if share(near.target(), link.source()) {
                        self.visit(Step::Lead(other), followers)?;
                    }
                }
            }
        }
        self.visits[place] = Visit::Over;
        self.next.push(step);
        Ok(())
    }

    fn place(&self, step: Step) -> usize {
        let (axes, systems) = (self.axes, self.systems);
        match step {
            Step::Own(axis) => usize::from(axis),
            Step::Whole(axis) => axes + usize::from(axis),
            Step::Back(index) => 2 * axes + usize::from(index),
            Step::Lead(index) => 2 * axes + systems + usize::from(index),
            Step::Down(index) => 2 * axes + 2 * systems + usize::from(index),
            Step::System(index) => 2 * axes + 3 * systems + usize::from(index),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    type Gear = (u16, u16);
    type Transform = ([u16; 2], [u16; 2]);

    /// Orders gears (slave, master) and transforms (source axes, target axes) of a machine of nine axes.
    fn plan(gears: &[Gear], transforms: &[Transform]) -> Result<Vec<Step>, Circle> {
        plan_driven(gears, transforms, None)
    }

    /// The same; one coordinate system has masters.
    fn plan_driven(
        gears: &[Gear],
        transforms: &[Transform],
        driven: Option<(&[u16], u16)>,
    ) -> Result<Vec<Step>, Circle> {
        let links: Vec<Option<Link>> = transforms
            .iter()
            .map(|(source, target)| Some(Link::between(source, target)))
            .collect();
        let mut order = Order::new(9, links.len().max(usize::from(driven.is_some())));
        order.plan(&Followers {
            axes: 9,
            masters: |axis| {
                let own = gears.iter().filter(|(slave, _)| *slave == axis);
                own.map(|(_, master)| *master).collect()
            },
            systems: |index| match driven {
                Some((axes, master)) if index == 0 => (axes, [master].into_iter().collect()),
                _ => (&[][..], Masters::default()),
            },
            links: &links,
        })?;
        order.take();
        Ok(order.steps)
    }

    #[test]
    fn what_is_followed_comes_first() {
        type Case<'a> = (&'a str, &'a [Gear], &'a [Transform], &'a [(Step, Step)]);
        let cases: [Case<'_>; 5] = [
            ("a master", &[(0, 5)], &[], &[(Step::Whole(5), Step::Own(0))]),
            (
                "a master of a master",
                &[(0, 5), (5, 8)],
                &[],
                &[(Step::Whole(8), Step::Own(5)), (Step::Whole(5), Step::Own(0))],
            ),
            (
                "a source and its target, both ways",
                &[],
                &[([4, 5], [0, 1])],
                &[
                    (Step::Own(4), Step::Lead(0)),
                    (Step::Own(0), Step::Back(0)),
                    (Step::Back(0), Step::Whole(4)),
                    (Step::Lead(0), Step::Whole(0)),
                ],
            ),
            (
                "a chain, from its first source to its last target and back",
                &[],
                &[([2, 3], [0, 1]), ([4, 5], [2, 3])],
                &[
                    (Step::Lead(1), Step::Lead(0)),
                    (Step::Back(0), Step::Back(1)),
                    (Step::Back(1), Step::Whole(4)),
                ],
            ),
            (
                "a gear behind a transform",
                &[(1, 0)],
                &[([4, 5], [0, 8])],
                &[(Step::Lead(0), Step::Own(1))],
            ),
        ];
        for (why, gears, transforms, pairs) in cases {
            let steps = plan(gears, transforms).expect(why);
            let place = |step: &Step| steps.iter().position(|other| other == step).expect(why);
            for (first, second) in pairs {
                assert!(
                    place(first) < place(second),
                    "{why}: {first:?} before {second:?} in {steps:?}"
                );
            }
            assert_eq!(steps.len(), 18 + 2 * transforms.len(), "{why}");
        }
    }

    #[test]
    fn a_master_comes_before_the_system_and_that_before_its_axes() {
        let steps = plan_driven(&[(5, 7), (8, 0)], &[], Some((&[0, 1], 5))).expect("there is no circle");
        let place = |step: Step| steps.iter().position(|other| *other == step);
        let chain = [
            Step::Whole(7),
            Step::Own(5),
            Step::Whole(5),
            Step::System(0),
            Step::Own(0),
            Step::Whole(0),
            Step::Own(8),
        ];
        for pair in chain.windows(2) {
            assert!(place(pair[0]) < place(pair[1]), "{pair:?} in {steps:?}");
        }
        assert!(plan_driven(&[(5, 1)], &[], Some((&[0, 1], 5))).is_err(), "a circle");
    }

    #[test]
    fn circles_are_found() {
        type Case<'a> = (&'a str, &'a [Gear], &'a [Transform], bool);
        #[rustfmt::skip]
        let cases: [Case<'_>; 9] = [
            ("nothing follows",                       &[], &[], true),
            ("its own master",                        &[(0, 0)], &[], false),
            ("three gears in a ring",                 &[(0, 1), (1, 2), (2, 0)], &[], false),
            ("two transforms against each other",     &[], &[([0, 1], [2, 3]), ([2, 3], [0, 1])], false),
            ("three transforms in a ring",            &[], &[([0, 1], [2, 3]), ([2, 3], [4, 5]), ([4, 5], [0, 1])], false),
            ("a target geared to its source",         &[(2, 0)], &[([0, 1], [2, 3])], false),
            ("a source geared to its target",         &[(0, 2)], &[([0, 1], [2, 3])], false),
            ("a source geared to another source",     &[(1, 0)], &[([0, 1], [2, 3])], true),
            ("one source of two targets",             &[], &[([0, 1], [2, 3]), ([0, 1], [4, 5])], true),
        ];
        for (why, gears, transforms, possible) in cases {
            assert_eq!(plan(gears, transforms).is_ok(), possible, "{why}");
        }
    }
}
