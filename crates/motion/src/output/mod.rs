//! Output cams: bits of a DINT that the position of an axis sets and clears (MAOC, MDOC; spec/axis-and-data-types.md §5).
//!
//! An axis has as many execution targets as configured; each has one active output cam and one pending one. Between two ticks the axis is
//! assumed to move monotonically from one position and velocity to the other ([`interpolation`]): every edge has its exact instant there, so
//! durations and pulses do not depend on the update period. The bits are those at the tick. Changed bits leave the tick as an
//! [`crate::InstructionWrite`].
//!
//! Not here: operands ([`crate::instructions`]), tags' memory. Real-time: nothing allocates after [`OutputCams::new`].

mod element;
mod execution_target;
mod interpolation;
mod program;
mod windows;

use arcline_planner::Clock;
use arcline_profile::KinematicState;

pub(crate) use execution_target::{ArmedCam, Arming, ExecutionTarget, Outcome, TagBits};
pub use program::{BitCompensation, CamElement, MAX_OUTPUT_ELEMENTS, OUTPUT_BITS, OutputCam, OutputCamError};

use crate::execution::Execution;
use arcline_instruction_set::enumerations::Reference;
use execution_target::{Edge, MOST_EDGES};

/// The execution targets of one axis.
#[derive(Clone, Debug)]
pub(crate) struct OutputCams {
    targets: Vec<ExecutionTarget>,
    edges: Vec<Edge>,
}

impl OutputCams {
    /// For an axis with this number of targets.
    pub(crate) fn new(targets: usize, clock: &Clock) -> Self {
        OutputCams {
            targets: (0..targets).map(|_| ExecutionTarget::new(clock)).collect(),
            edges: Vec::with_capacity(if targets == 0 { 0 } else { MOST_EDGES }),
        }
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.len() == 0
    }

    pub(crate) fn len(&self) -> usize {
        self.targets.len()
    }

    pub(crate) fn target_mut(&mut self, target: usize) -> Option<&mut ExecutionTarget> {
        self.targets.get_mut(target)
    }

    /// The position of its axis, actual or command, that a target follows while a cam is armed or pending on it.
    pub(crate) fn reference(&self, target: usize) -> Option<Reference> {
        let target = self.targets.get(target)?;
        (!target.is_idle()).then_some(target.reference)
    }

    /// Begins an update at the present motion of the axis, including the velocity that instructions have changed.
    pub(crate) fn begin_update(&mut self, target: usize, at: KinematicState) {
        if let Some(target) = self.targets.get_mut(target) {
            target.began = at;
        }
    }

    /// Updates a target with the present motion of the axis.
    pub(crate) fn update(&mut self, target: usize, at: KinematicState, clock: &Clock) -> Outcome {
        let Some(target) = self.targets.get_mut(target) else {
            return Outcome::default();
        };
        Outcome {
            ended: target.update(at, clock, &mut self.edges),
            written: target.write(clock),
        }
    }

    /// Takes a change of some bits of a tag. Returns the bits that a target changes as a result.
    pub(crate) fn take_word(&mut self, target: usize, word: &TagBits, clock: &Clock) -> Option<TagBits> {
        let target = self.targets.get_mut(target).filter(|target| !target.is_idle())?;
        target.take_word(word, clock);
        target.write(clock)
    }

    /// Disarms a target. Returns the instructions of its cams.
    pub(crate) fn disarm(&mut self, target: usize) -> [Option<Execution>; 2] {
        self.targets.get_mut(target).map_or([None; 2], ExecutionTarget::disarm)
    }

    /// OutputCamStatus, PendingStatus, LockStatus and TransitionStatus: a bit for each target.
    pub(crate) fn status(&self) -> [u32; 4] {
        let mut words = [0; 4];
        for (target_index, target) in self.targets.iter().enumerate() {
            for (word, shown) in words.iter_mut().zip(target.shown()) {
                *word |= u32::from(shown) << target_index;
            }
        }
        words
    }

    /// Bits that the output cams of the axis have set, of all targets together.
    pub(crate) fn bits(&self) -> u32 {
        self.targets.iter().fold(0, |bits, target| bits | target.bits())
    }
}
