//! The ring of samples: a row for every tick, from the thread to the trace.

use arcline_controller::machine::Machine;
use arcline_controller::{Snapshot, samples};

/// Limits for waiting rows, as time, ns, and as memory, bytes.
pub(crate) const WAITING_NS: u64 = 4_000_000_000;
const WAITING_BYTES: usize = 32 << 20;

/// The thread's end.
#[derive(Debug)]
pub(crate) struct SampleSender {
    ring: rtrb::Producer<f64>,
    width: usize,
}

/// The end of the server: rows of [`samples::row`], in order.
#[derive(Debug)]
pub struct Samples {
    ring: rtrb::Consumer<f64>,
    width: usize,
}

/// Both ends, for rows over a time, ns. The only allocation.
pub(crate) fn link(machine: &Machine, waiting_ns: u64) -> (SampleSender, Samples) {
    let width = samples::width(machine);
    let rows = (waiting_ns / machine.period_ns.max(1)) as usize;
    let rows = rows.min(WAITING_BYTES / (width * size_of::<f64>())).max(LEAST);
    let (mut sender, mut receiver) = rtrb::RingBuffer::new(rows * width);
    // Touched once, so that no tick causes a page fault.
    if let Ok(all) = sender.write_chunk(rows * width) {
        all.commit_all();
    }
    if let Ok(all) = receiver.read_chunk(rows * width) {
        all.commit_all();
    }
    let samples = Samples { ring: receiver, width };
    (SampleSender { ring: sender, width }, samples)
}

impl SampleSender {
    /// There is room for a row.
    pub(crate) fn has_room(&self) -> bool {
        self.ring.slots() >= self.width
    }

    /// Sends the row of a tick. Returns false if there is no room; the row is then lost. Real-time.
    pub(crate) fn send(&mut self, snapshot: &Snapshot) -> bool {
        match self.ring.write_chunk_uninit(self.width) {
            Ok(chunk) => {
                chunk.fill_from_iter(samples::row(snapshot));
                true
            }
            Err(_) => false,
        }
    }
}

impl Samples {
    /// Numbers in a row.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Takes every waiting row, oldest first, in pieces of whole rows.
    pub fn take(&mut self, mut give: impl FnMut(&[f64])) {
        let waiting = self.ring.slots() / self.width * self.width;
        let Ok(chunk) = self.ring.read_chunk(waiting) else {
            return;
        };
        let (first, second) = chunk.as_slices();
        // The ring has room for whole rows only, so no row crosses its end.
        give(first);
        if !second.is_empty() {
            give(second);
        }
        chunk.commit_all();
    }
}

/// The least number of rows that can wait.
const LEAST: usize = 16;
