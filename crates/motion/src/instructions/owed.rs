//! Changes of dynamics that pending moves are still to be given (MCCD of Active and Pending Motion).
//!
//! A deep queue is changed over several ticks, while further changes may come. Of every value the last change that had it counts, so
//! what any move is owed takes no more room than one change, however many there have been: each value stands beside the number of
//! its change, and a move that knows up to which change it has been served takes the later ones. The result is the same as that of
//! all changes one by one. Real-time: nothing here grows with the queue.

use arcline_planner::Move;

pub(crate) use super::programmed::Change;
use crate::dynamics::JerkRate;
use crate::system::Planned;

/// What is owed, in the units of moves, and of those that only turn.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Owed([Values; 2]);

#[derive(Clone, Copy, Debug, Default)]
struct Values {
    speed: Last<f64>,
    /// The last speed that was not 0: jerks in percent of time follow it.
    moving: Last<f64>,
    acceleration: Last<f64>,
    deceleration: Last<f64>,
    acceleration_jerk: Last<JerkRate>,
    deceleration_jerk: Last<JerkRate>,
}

/// A value, and the number of the change that it is of.
#[derive(Clone, Copy, Debug)]
struct Last<V>(Option<(V, u64)>);

impl<V> Default for Last<V> {
    fn default() -> Self {
        Last(None)
    }
}

impl<V: Copy> Last<V> {
    fn set(&mut self, value: Option<V>, number: u64) {
        if let Some(value) = value {
            self.0 = Some((value, number));
        }
    }

    /// The value for what has the changes up to a number.
    fn since(&self, has: u64) -> Option<V> {
        self.0.filter(|(_, number)| *number > has).map(|(value, _)| value)
    }
}

impl Owed {
    /// Another change of all pending moves. Numbers grow.
    pub(crate) fn add(&mut self, number: u64, change: &[Change; 2]) {
        for (owed, change) in self.0.iter_mut().zip(change) {
            owed.speed.set(change.speed, number);
            owed.moving.set(change.speed.filter(|speed| *speed > 0.0), number);
            owed.acceleration.set(change.acceleration, number);
            owed.deceleration.set(change.deceleration, number);
            owed.acceleration_jerk.set(change.acceleration_jerk, number);
            owed.deceleration_jerk.set(change.deceleration_jerk, number);
        }
    }

    /// Gives a move that has the changes up to a number all later ones, no faster than the joints of robots let it be.
    pub(crate) fn give(&self, motion: &mut Move<Planned>, has: u64) {
        let owed = &self.0[usize::from(motion.data.only_turns)];
        let pace = motion.data.pace;
        let dynamics = &mut motion.data.dynamics;
        if let Some(acceleration) = owed.acceleration.since(has) {
            dynamics.acceleration = acceleration;
        }
        if let Some(deceleration) = owed.deceleration.since(has) {
            dynamics.deceleration = deceleration;
        }
        if let Some(moving) = owed.moving.since(has) {
            dynamics.set_speed(moving);
        }
        dynamics.keep_to(&pace);
        if let Some(speed) = owed.speed.since(has) {
            dynamics.set_speed(speed);
            dynamics.keep_to(&pace);
        }
        let jerks = dynamics.jerks_mut();
        jerks.acceleration = owed.acceleration_jerk.since(has).unwrap_or(jerks.acceleration);
        jerks.deceleration = owed.deceleration_jerk.since(has).unwrap_or(jerks.deceleration);
        motion.limits = motion.data.dynamics.limits();
    }
}

/// How many pending moves there are of each kind: a change can be refused for one of them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Kinds([u16; Kinds::COUNT]);

/// What decides whether a move can be changed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Kind {
    /// It is master driven.
    pub(super) driven: bool,
    pub(super) only_turns: bool,
    pub(super) s_curve: bool,
}

impl Kinds {
    const COUNT: usize = 8;

    pub(crate) fn add(&mut self, planned: &Planned) {
        let count = &mut self.0[Kind::of(planned).place()];
        *count = count.saturating_add(1);
    }

    pub(crate) fn remove(&mut self, planned: &Planned) {
        let count = &mut self.0[Kind::of(planned).place()];
        *count = count.saturating_sub(1);
    }

    /// The kinds of which there are any.
    pub(super) fn present(&self) -> impl Iterator<Item = Kind> {
        let present = |place: &usize| self.0[*place] > 0;
        (0..Self::COUNT).filter(present).map(|place| Kind {
            driven: place & 1 != 0,
            only_turns: place & 2 != 0,
            s_curve: place & 4 != 0,
        })
    }
}

impl Kind {
    fn of(planned: &Planned) -> Self {
        Kind {
            driven: planned.lead.is_some(),
            only_turns: planned.only_turns,
            s_curve: planned.dynamics.is_s_curve(),
        }
    }

    fn place(self) -> usize {
        usize::from(self.driven) + 2 * usize::from(self.only_turns) + 4 * usize::from(self.s_curve)
    }
}

#[cfg(test)]
mod tests {
    use arcline_instruction_set::{ControlSlot, Mnemonic};
    use arcline_planner::geometry::{Line, Path, Point};
    use arcline_planner::{Ending, Parameter};

    use super::*;
    use crate::control::{Execution, Ticket};
    use crate::dynamics::PathLimits;
    use crate::dynamics::{Dynamics, Jerks, Shape};
    use crate::instructions::programmed::Rates;
    use crate::system::Termination;

    fn waiting(pace: PathLimits) -> Move<Planned> {
        let dynamics = Dynamics {
            speed: 40.0,
            acceleration: 300.0,
            deceleration: 350.0,
            shape: Shape::SCurve(Jerks {
                acceleration: JerkRate::PercentOfTime(30.0),
                deceleration: JerkRate::Units(5000.0),
            }),
            last_speed: 40.0,
        };
        Move {
            path: Path::Line(Line::new(Point::zeros(), Point::from([1.0, 0.0, 0.0]))),
            turn: None,
            corner: f64::INFINITY,
            limits: dynamics.limits(),
            ending: Ending::Stop,
            parameter: Parameter::TIME,
            data: Planned {
                execution: Execution {
                    ticket: Ticket(0),
                    control: ControlSlot(0),
                    mnemonic: Mnemonic::Mclm,
                },
                dynamics,
                termination: Termination::Command,
                pace,
                lead: None,
                events: None,
                heading: None,
                only_turns: false,
            },
        }
    }

    /// Numbers that look random.
    struct Random(u64);

    impl Random {
        fn below(&mut self, count: u64) -> u64 {
            self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(0x9E37_79B9);
            (self.0 >> 33) % count
        }

        fn value(&mut self) -> Option<f64> {
            (self.below(2) == 0).then(|| 10.0 * (1 + self.below(30)) as f64)
        }

        fn change(&mut self) -> Change {
            let jerk = |random: &mut Random| {
                let value = random.value()?;
                Some(if random.below(2) == 0 {
                    JerkRate::Units(value)
                } else {
                    JerkRate::PercentOfTime(value / 3.0)
                })
            };
            Change {
                speed: if self.below(4) == 0 { Some(0.0) } else { self.value() },
                acceleration: self.value(),
                deceleration: self.value(),
                acceleration_jerk: jerk(self),
                deceleration_jerk: jerk(self),
                rates: Rates::of_nothing(),
            }
        }
    }

    #[test]
    fn what_is_given_at_last_is_what_all_changes_one_by_one_make() {
        for seed in 0..500 {
            let mut random = Random(seed);
            let bounded = PathLimits {
                speed: 95.0,
                acceleration: 180.0,
                deceleration: 210.0,
            };
            let pace = if seed % 2 == 0 { PathLimits::UNLIMITED } else { bounded };
            let first = waiting(pace);
            let mut each = first;
            each.data.dynamics.keep_to(&pace);
            let mut late = each;
            let (mut owed, mut has) = (Owed::default(), 0);
            for number in 1..=8 {
                let change = random.change();
                owed.add(number, &[change, change]);
                each.data.dynamics = change.of(each.data.dynamics).expect("nothing is 0");
                each.data.dynamics.keep_to(&pace);
                if random.below(3) == 0 {
                    owed.give(&mut late, has);
                    has = number;
                }
            }
            owed.give(&mut late, has);
            assert_eq!(late.data.dynamics, each.data.dynamics, "seed {seed}");
            assert_eq!(late.limits, each.data.dynamics.limits(), "seed {seed}");
        }
    }
}
