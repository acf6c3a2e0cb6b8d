//! The measures of a run: its trace as a hash, the peaks of each axis, its faults.

use arcline_controller::machine::Machine;
use arcline_controller::{Controller, FaultChange};
use arcline_instruction_set::{AxisId, Ending, FaultSet};
use sha2::{Digest as _, Sha256};

use crate::outcome::{Peak, Raised};

/// Changes of faults that are told one by one.
const TOLD: usize = 20;

/// The measures of one run so far; `tick` takes a tick, `fault` a fault.
#[derive(Clone, Debug, Default)]
pub struct Measures {
    hash: Sha256,
    row: Vec<u8>,
    pub(crate) ticks: u64,
    /// The four numbers of each axis at the last tick, as their bits.
    last: Vec<[u64; 4]>,
    pub(crate) peaks: Vec<Peak>,
    pub(crate) faults: Vec<Raised>,
    /// Faults that are put on axes at the end of a tick, the latest first.
    pending: Vec<(u64, AxisId, FaultSet)>,
}

impl Measures {
    /// The measures of a run with these faults, in the order of their ticks.
    pub fn with_faults(mut faults: Vec<(u64, AxisId, FaultSet)>) -> Self {
        faults.reverse();
        Measures {
            pending: faults,
            ..Measures::default()
        }
    }

    /// The end of a tick. The hash takes the tick as 8 bytes, and of each axis whose four numbers of a trace are not those of the tick before its place as
    /// 8 bytes and the numbers as 64-bit floats, all little-endian: what a CSV of all signals has, since its numbers read back to the same.
    pub fn tick(&mut self, tick: u64, controller: &mut Controller) {
        self.ticks = tick;
        self.row.clear();
        self.row.extend_from_slice(&tick.to_le_bytes());
        for (place, axis) in controller.trace().enumerate() {
            let bits = axis.map(f64::to_bits);
            match self.last.get_mut(place) {
                Some(last) if *last == bits => continue,
                Some(last) => *last = bits,
                None => {
                    self.last.push(bits);
                    self.peaks.push(Peak::default());
                }
            }
            self.row.extend_from_slice(&(place as u64).to_le_bytes());
            for value in bits {
                self.row.extend_from_slice(&value.to_le_bytes());
            }
            let [position, velocity, acceleration, actual] = axis;
            self.peaks[place].take(velocity, acceleration, position - actual);
        }
        self.hash.update(&self.row);
        while let Some((_, axis, cause)) = self.pending.pop_if(|(at, ..)| *at <= tick) {
            controller.inject(axis, cause);
        }
    }

    /// A change of faults, s after the beginning.
    pub fn fault(&mut self, change: &FaultChange, time: f64, machine: &Machine) {
        let axis = machine.axes.get(usize::from(change.axis));
        if change.set.is_empty() || self.faults.len() == TOLD {
            return;
        }
        self.faults.push(Raised {
            time_s: time,
            axis: axis.map_or_else(String::new, |axis| axis.name.clone()),
            faults: Ending::words(change.set)
                .iter()
                .map(|word| (*word).to_string())
                .collect(),
        });
    }

    /// The command positions at the last tick.
    pub(crate) fn positions(&self) -> impl Iterator<Item = f64> {
        self.last.iter().map(|[position, ..]| f64::from_bits(*position))
    }

    /// The hash of the trace so far, 64 hexadecimal digits.
    pub fn hash(&self) -> String {
        hex(&self.hash.clone().finalize())
    }
}

pub(crate) fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}
