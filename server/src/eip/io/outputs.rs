//! The commands of the output assembly, and the reaction when no client commands any more.
//!
//! The connection decides which client may command. Overrides are in percent.

use arcline_config::IoLoss;
use tracing::warn;

use super::layout::{command, decode_output};
use crate::plant::{Plant, Principal};

/// The newest outputs that the server has applied.
#[derive(Clone, Debug, Default)]
pub(crate) struct Outputs {
    word: u32,
    overrides: Vec<f32>,
    refused: bool,
    /// The assembly as it came.
    data: Vec<u8>,
}

impl Outputs {
    /// The command word.
    pub(crate) fn word(&self) -> u32 {
        self.word
    }

    /// Whether an override was out of range.
    pub(crate) fn refused(&self) -> bool {
        self.refused
    }

    /// The assembly as it came; empty when no client commands.
    pub(crate) fn data(&self) -> &[u8] {
        &self.data
    }

    /// Applies the differences from the previous outputs. A stop comes first; the other bits and values of the same outputs cannot undo it.
    pub(crate) fn apply(&mut self, data: &[u8], plant: &Plant) {
        if data == self.data {
            return;
        }
        let Some((word, overrides)) = decode_output(data) else {
            return;
        };
        let rises = |bit: u32| word & !self.word & bit != 0;
        let wanted = word & command::OVERRIDE != 0 && word & command::HOLD == 0;
        let changed = rises(command::OVERRIDE) || self.word & command::HOLD != 0 || !same(&overrides, &self.overrides);
        let (resume, hold, stop) = (rises(command::RESUME), rises(command::HOLD), rises(command::STOP));
        if stop {
            // It waits for no lock. The other bits and values do, and cannot undo it.
            plant.stop_all();
        }
        if wanted && changed {
            self.refused = !plant.set_feed_overrides(Principal::Io, &overrides);
        } else if !wanted {
            self.refused = false;
        }
        if resume && !hold {
            plant.resume_all(Principal::Io);
        }
        if hold {
            hold_or_stop(plant);
        }
        self.word = word;
        self.overrides = overrides;
        self.data.clear();
        self.data.extend_from_slice(data);
    }

    /// No client commands any more.
    pub(crate) fn lose(&mut self, reaction: IoLoss, plant: &Plant) {
        *self = Self::default();
        match reaction {
            IoLoss::Stop => plant.stop_all(),
            IoLoss::Hold => hold_or_stop(plant),
            IoLoss::Finish => {}
        }
    }
}

/// A machine whose configuration uses the name of the overrides for another tag cannot be held.
fn hold_or_stop(plant: &Plant) {
    if !plant.hold_all(Principal::Io) {
        warn!("there is no feed override to hold by: stopping instead");
        plant.stop_all();
    }
}

/// Bit by bit: a value that is no number is the same as itself.
fn same(one: &[f32], other: &[f32]) -> bool {
    one.iter()
        .map(|value| value.to_bits())
        .eq(other.iter().map(|value| value.to_bits()))
}
