//! The order in which a tick computes axes when some follow others: a master comes before its followers.
//!
//! It is planned when a link or a transform is made: a list of edges (a step needs another one first), sorted topologically. The order
//! remains valid when a link or transform ends. Not here: the computation of a step. Nothing allocates after [`Order::new`]; planning an
//! order is bounded by the axes, their masters, and the pairs of transforms.

use crate::axes::share;
use crate::machine::MAX_SYSTEM_AXES;
use crate::transforms::TransformId;
use crate::transforms::compute::TransformStep;
use crate::transforms::transform::Transform;
use arcline_instruction_set::{AxisId, SystemId};

/// A step of the computation of one tick.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Step {
    /// The coordinated move of a system that is linked to a master.
    System(SystemId),
    /// An axis's own generators, with those that follow masters.
    Own(AxisId),
    /// A part of a transform.
    Transform(TransformStep),
    /// The whole command of an axis; its drive follows it.
    Whole(AxisId),
}

/// The axes of a machine would follow each other in a cycle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct DependencyCycle;

/// A planned order, ready to take effect.
#[derive(Debug)]
#[must_use]
pub(crate) struct PlannedOrder(());

/// A follower to add to the order.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Follower<'a> {
    /// An axis and its master.
    Axis(AxisId, AxisId),
    /// A coordinate system and its master.
    System(SystemId, AxisId),
    /// A transform.
    Target(TransformId, &'a Transform),
}

/// Most masters of one axis: of its gear, its cams, its links, and its moves that began by links replaced since.
const MOST_MASTERS: usize = 17;
/// Most masters of one coordinate system: of its links, of a new link, and of the active move.
const MOST_SYSTEM_MASTERS: usize = 4;

/// The order of a tick's steps; empty without followers.
#[derive(Debug)]
pub(crate) struct Order {
    steps: Vec<Step>,
    next: Vec<Step>,
    edges: Edges,
    visits: Vec<Visit>,
}

/// The edges of the order: the steps that each step needs first.
#[derive(Debug)]
pub(crate) struct Edges {
    /// A step, the edge's own number, and the step that is needed first.
    list: Vec<(u16, u32, u16)>,
    /// Every step of the machine at its number.
    steps: Vec<Step>,
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
    /// For a machine with these numbers of axes and coordinate systems. The only allocation.
    pub(crate) fn new(axes: usize, systems: usize) -> Self {
        let edges = Edges::new(axes, systems);
        let most = edges.steps.len();
        Order {
            steps: Vec::with_capacity(most),
            next: Vec::with_capacity(most),
            visits: vec![Visit::Ahead; most],
            edges,
        }
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.steps.is_empty()
    }

    pub(crate) fn len(&self) -> usize {
        self.steps.len()
    }

    pub(crate) fn step(&self, step_index: usize) -> Option<Step> {
        self.steps.get(step_index).copied()
    }

    /// Empties the order: no axis follows another.
    pub(crate) fn clear(&mut self) {
        self.steps.clear();
    }

    /// Plans the order of the steps with these edges. The present order stays in effect until [`Order::take`].
    ///
    /// # Errors
    /// If the edges form a cycle.
    pub(crate) fn plan(&mut self, add: impl FnOnce(&mut Edges)) -> Result<PlannedOrder, DependencyCycle> {
        self.next.clear();
        self.visits.fill(Visit::Ahead);
        self.edges.begin();
        add(&mut self.edges);
        self.edges.list.sort_unstable();
        for axis in AxisId::first(self.edges.axes) {
            self.visit(self.edges.number(Step::Whole(axis)))?;
        }
        Ok(PlannedOrder(()))
    }

    /// Puts the last planned order into effect from the next tick on.
    pub(crate) fn take(&mut self, _planned: PlannedOrder) {
        std::mem::swap(&mut self.steps, &mut self.next);
    }

    /// Adds a step after all steps that it needs. The depth is at most the number of steps.
    fn visit(&mut self, step: u16) -> Result<(), DependencyCycle> {
        let step_index = usize::from(step);
        match self.visits[step_index] {
            Visit::Ahead => {}
            Visit::UnderWay => return Err(DependencyCycle),
            Visit::Over => return Ok(()),
        }
        self.visits[step_index] = Visit::UnderWay;
        let mut edge = self.edges.list.partition_point(|(of, ..)| *of < step);
        while let Some((of, _, first)) = self.edges.list.get(edge).copied()
            && of == step
        {
            self.visit(first)?;
            edge += 1;
        }
        self.visits[step_index] = Visit::Over;
        self.next.push(self.edges.steps[step_index]);
        Ok(())
    }
}

impl Edges {
    fn new(axes: usize, systems: usize) -> Self {
        let own = AxisId::first(axes).map(Step::Own);
        let whole = AxisId::first(axes).map(Step::Whole);
        let parts = [TransformStep::Feedback, TransformStep::SetPoints, TransformStep::Before];
        let parts = parts.into_iter().flat_map(|part| {
            SystemId::first(systems).map(move |system| Step::Transform(part(TransformId::of_target(system))))
        });
        let of_systems = SystemId::first(systems).map(Step::System);
        let by_transform = 5 * MAX_SYSTEM_AXES + 1 + 5 * systems;
        let by_system = MAX_SYSTEM_AXES + MOST_SYSTEM_MASTERS + by_transform;
        Edges {
            list: Vec::with_capacity(axes * (1 + MOST_MASTERS) + systems * by_system),
            steps: own.chain(whole).chain(parts).chain(of_systems).collect(),
            axes,
            systems,
        }
    }

    /// Resets the edges: every axis needs its own generators first, and none follows another axis.
    fn begin(&mut self) {
        self.list.clear();
        for axis in AxisId::first(self.axes) {
            self.need(Step::Whole(axis), Step::Own(axis));
        }
    }

    /// Adds a coordinate system with these axes and its masters, if it has any.
    pub(crate) fn system(&mut self, index: SystemId, axes: &[AxisId], masters: impl Iterator<Item = AxisId>) {
        let system = Step::System(index);
        let before = self.list.len();
        for master in masters {
            self.need(system, Step::Whole(master));
        }
        if self.list.len() > before {
            for axis in axes {
                self.need(Step::Own(*axis), system);
            }
        }
    }

    /// Adds an axis that follows a master.
    pub(crate) fn axis(&mut self, slave: AxisId, master: AxisId) {
        self.need(Step::Own(slave), Step::Whole(master));
    }

    /// Adds the active transforms.
    pub(crate) fn transforms<'a>(&mut self, get: impl Fn(TransformId) -> Option<&'a Transform>) {
        let systems = self.systems;
        let ids = || SystemId::first(systems).map(TransformId::of_target);
        let all = || ids().filter_map(|id| Some((id, get(id)?)));
        for (id, transform) in all() {
            let [feedback, set_points, before] =
                [TransformStep::Feedback, TransformStep::SetPoints, TransformStep::Before]
                    .map(|part| Step::Transform(part(id)));
            for axis in transform.source.iter() {
                self.need(Step::Whole(*axis), feedback);
                self.need(before, Step::Own(*axis));
                self.need(set_points, Step::Own(*axis));
            }
            for axis in transform.target.iter() {
                self.need(Step::Whole(*axis), set_points);
                self.need(feedback, Step::Own(*axis));
            }
            for (other, near) in all() {
                let part = |part: fn(TransformId) -> TransformStep| Step::Transform(part(other));
                if share(&near.source, &transform.target) {
                    self.need(feedback, part(TransformStep::Feedback));
                }
                if share(&near.source, &transform.source) {
                    if other < id {
                        self.need(before, part(TransformStep::Feedback));
                    }
                    self.need(set_points, part(TransformStep::Feedback));
                }
                if share(&near.target, &transform.source) {
                    self.need(before, part(TransformStep::Before));
                    self.need(set_points, part(TransformStep::SetPoints));
                }
            }
            // The feedback from a robot's joints depends on the positions that the source gives them.
            if transform.robot().is_some() {
                self.need(feedback, before);
            }
        }
    }

    fn need(&mut self, step: Step, first: Step) {
        let edge = (self.number(step), self.list.len() as u32, self.number(first));
        self.list.push(edge);
    }

    fn number(&self, step: Step) -> u16 {
        let (axes, systems) = (self.axes as u16, self.systems as u16);
        match step {
            Step::Own(axis) => axis.0,
            Step::Whole(axis) => axes + axis.0,
            Step::Transform(TransformStep::Feedback(id)) => 2 * axes + id.target_system().0,
            Step::Transform(TransformStep::SetPoints(id)) => 2 * axes + systems + id.target_system().0,
            Step::Transform(TransformStep::Before(id)) => 2 * axes + 2 * systems + id.target_system().0,
            Step::System(index) => 2 * axes + 3 * systems + index.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    type Gear = (u16, u16);
    type Sides = ([u16; 2], [u16; 2]);

    fn own(axis: u16) -> Step {
        Step::Own(AxisId(axis))
    }

    fn whole(axis: u16) -> Step {
        Step::Whole(AxisId(axis))
    }

    fn feedback(target: u16) -> Step {
        Step::Transform(TransformStep::Feedback(TransformId::of_target(SystemId(target))))
    }

    fn set_points(target: u16) -> Step {
        Step::Transform(TransformStep::SetPoints(TransformId::of_target(SystemId(target))))
    }

    /// Orders gears (slave, master) and transforms (source axes, target axes) of a machine of nine axes.
    fn plan(gears: &[Gear], transforms: &[Sides]) -> Result<Vec<Step>, DependencyCycle> {
        plan_driven(gears, transforms, None)
    }

    /// The same; one coordinate system has a master.
    fn plan_driven(
        gears: &[Gear],
        transforms: &[Sides],
        driven: Option<(&[u16], u16)>,
    ) -> Result<Vec<Step>, DependencyCycle> {
        let transforms: Vec<Transform> = transforms
            .iter()
            .map(|(source, target)| Transform::between(&source.map(AxisId), &target.map(AxisId)))
            .collect();
        let mut order = Order::new(9, transforms.len().max(usize::from(driven.is_some())));
        let planned = order.plan(|edges| {
            if let Some((axes, master)) = driven {
                let axes: Vec<_> = axes.iter().copied().map(AxisId).collect();
                edges.system(SystemId(0), &axes, std::iter::once(AxisId(master)));
            }
            for (slave, master) in gears {
                edges.axis(AxisId(*slave), AxisId(*master));
            }
            edges.transforms(|id| transforms.get(id.index()));
        })?;
        order.take(planned);
        Ok(order.steps)
    }

    #[test]
    fn masters_and_sources_are_computed_before_their_followers() {
        type Case<'a> = (&'a str, &'a [Gear], &'a [Sides], &'a [(Step, Step)]);
        let cases: [Case<'_>; 5] = [
            ("a master", &[(0, 5)], &[], &[(whole(5), own(0))]),
            (
                "a master of a master",
                &[(0, 5), (5, 8)],
                &[],
                &[(whole(8), own(5)), (whole(5), own(0))],
            ),
            (
                "a source and its target, both ways",
                &[],
                &[([4, 5], [0, 1])],
                &[
                    (own(4), set_points(0)),
                    (own(0), feedback(0)),
                    (feedback(0), whole(4)),
                    (set_points(0), whole(0)),
                ],
            ),
            (
                "a chain, from its first source to its last target and back",
                &[],
                &[([2, 3], [0, 1]), ([4, 5], [2, 3])],
                &[
                    (set_points(1), set_points(0)),
                    (feedback(0), feedback(1)),
                    (feedback(1), whole(4)),
                ],
            ),
            (
                "a gear behind a transform",
                &[(1, 0)],
                &[([4, 5], [0, 8])],
                &[(set_points(0), own(1))],
            ),
        ];
        for (why, gears, transforms, pairs) in cases {
            let steps = plan(gears, transforms).expect(why);
            let step_index = |step: &Step| steps.iter().position(|other| other == step).expect(why);
            for (first, second) in pairs {
                assert!(
                    step_index(first) < step_index(second),
                    "{why}: {first:?} before {second:?} in {steps:?}"
                );
            }
            assert_eq!(steps.len(), 18 + 2 * transforms.len(), "{why}");
        }
    }

    #[test]
    fn a_master_comes_before_the_system_and_that_before_its_axes() {
        let steps = plan_driven(&[(5, 7), (8, 0)], &[], Some((&[0, 1], 5))).expect("there is no cycle");
        let step_index = |step: Step| steps.iter().position(|other| *other == step);
        let chain = [
            whole(7),
            own(5),
            whole(5),
            Step::System(SystemId(0)),
            own(0),
            whole(0),
            own(8),
        ];
        for pair in chain.windows(2) {
            assert!(step_index(pair[0]) < step_index(pair[1]), "{pair:?} in {steps:?}");
        }
        assert!(plan_driven(&[(5, 1)], &[], Some((&[0, 1], 5))).is_err(), "a cycle");
    }

    #[test]
    fn cycles_are_found() {
        type Case<'a> = (&'a str, &'a [Gear], &'a [Sides], bool);
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
