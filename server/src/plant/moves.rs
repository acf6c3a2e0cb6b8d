//! The coordinated moves that are active or pending, with their paths: the data for a picture of them.

use std::collections::VecDeque;

use arcline_controller::{AcceptedMove, Event, Snapshot};
use arcline_instruction_set::predefined::coordinate_system_status;
use arcline_instruction_set::{Flag, MotionControl};

/// A move under way.
#[derive(Clone, Copy, Debug)]
pub struct LiveMove {
    /// The accepted move.
    pub accepted: AcceptedMove,
    /// The newest state of its motion control tag.
    control: MotionControl,
}

impl LiveMove {
    /// Whether the move is active; otherwise it is pending.
    pub fn is_active(&self) -> bool {
        self.control.has(Flag::Ac)
    }
}

/// The moves of every coordinate system.
#[derive(Debug)]
pub struct LiveMoves {
    systems: Vec<Queue>,
}

#[derive(Clone, Debug, Default)]
struct Queue {
    moves: VecDeque<LiveMove>,
    version: u64,
}

impl LiveMoves {
    pub(super) fn new(systems: usize) -> Self {
        LiveMoves {
            systems: vec![Queue::default(); systems],
        }
    }

    /// The moves of a coordinate system, oldest first.
    pub fn of(&self, system: usize) -> impl Iterator<Item = &LiveMove> {
        self.systems.get(system).into_iter().flat_map(|queue| &queue.moves)
    }

    /// Another number whenever the moves of a coordinate system have changed.
    pub fn version(&self, system: usize) -> u64 {
        self.systems.get(system).map_or(0, |queue| queue.version)
    }

    pub(super) fn accept(&mut self, accepted: AcceptedMove) {
        if let Some(queue) = self.systems.get_mut(usize::from(accepted.system)) {
            queue.version += 1;
            if queue.moves.len() == MOST {
                queue.moves.pop_front();
            }
            queue.moves.push_back(LiveMove {
                accepted,
                control: MotionControl::default(),
            });
        }
    }

    pub(super) fn event(&mut self, event: &Event) {
        for queue in &mut self.systems {
            let Some(place) = queue.moves.iter().position(|live| live.accepted.ticket == event.ticket) else {
                continue;
            };
            let live = &mut queue.moves[place];
            let before = live.is_active();
            event.apply(&mut live.control);
            let (active, over) = (live.is_active(), !live.control.has(Flag::Ip));
            if over {
                queue.moves.remove(place);
            }
            if over || active != before {
                queue.version += 1;
            }
            return;
        }
    }

    /// Removes the moves of systems that stand still, in case an event was lost.
    pub(super) fn settle(&mut self, snapshot: &Snapshot) {
        for (queue, now) in self.systems.iter_mut().zip(&snapshot.systems) {
            if now.status & coordinate_system_status::MOTION_STATUS == 0 && !queue.moves.is_empty() {
                queue.moves.clear();
                queue.version += 1;
            }
        }
    }
}

/// Moves of one system: the deepest queue and the moves that still run before it.
const MOST: usize = 1024;
