//! Requests to stop, which the tick reads before every other command.
//!
//! They do not pass through the ring of commands: each is one atomic word, allocated at start-up. A request therefore never waits for other
//! commands, never finds the ring full, and needs no lock; repeating a request that the tick has not read yet has no further effect.
//! Not here: the effect of a stop (`arcline-controller`), and the decision to stop.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use arcline_controller::{StopRequest, Ticket};
use arcline_instruction_set::{AxisId, JogEnd};

/// The senders' end; clones are equivalent. Every method may be called from any thread, and none blocks.
#[derive(Clone, Debug)]
pub struct Stops(Arc<Shared>);

/// The controller's end.
#[derive(Debug)]
pub(crate) struct StopReceiver {
    shared: Arc<Shared>,
    /// The axis to examine next; `None`: no request was found.
    next: Option<usize>,
}

#[derive(Debug)]
struct Shared {
    /// A word below was written since the tick last read them.
    any: AtomicBool,
    all: AtomicBool,
    /// Motion is inhibited until it is released.
    inhibited: AtomicBool,
    /// For each axis, the newest ticket whose jog must end, and the reason ([`word`]); 0: none.
    jogs: Box<[AtomicU64]>,
}

/// A request to end a jog as one word: the ticket above two bits for the reason, from 1. A newer ticket is a larger word.
fn word(ticket: Ticket, why: JogEnd) -> u64 {
    let why = match why {
        JogEnd::Lost => 1,
        JogEnd::Silent => 2,
        JogEnd::Released => 3,
    };
    ticket.0 << 2 | why
}

/// The ticket and the reason of a word; `None`: no request.
fn request(word: u64) -> Option<(Ticket, JogEnd)> {
    let why = match word & 3 {
        0 => return None,
        1 => JogEnd::Lost,
        2 => JogEnd::Silent,
        _ => JogEnd::Released,
    };
    Some((Ticket(word >> 2), why))
}

impl Stops {
    /// Stops all motion, each axis separately.
    pub fn stop_all(&self) {
        self.0.all.store(true, Ordering::Release);
        self.0.any.store(true, Ordering::Release);
    }

    /// Stops all motion, and inhibits motion until [`Stops::release`]: instructions that would begin motion are refused.
    pub fn inhibit(&self) {
        // Before the stop, so that no motion begins after it.
        self.0.inhibited.store(true, Ordering::Release);
        self.stop_all();
    }

    /// Ends the inhibition of motion.
    pub fn release(&self) {
        self.0.inhibited.store(false, Ordering::Release);
    }

    /// Motion is inhibited.
    pub fn is_inhibited(&self) -> bool {
        self.0.inhibited.load(Ordering::Acquire)
    }

    /// Stops the jog that an instruction began on an axis (by its index in the machine), at the axis's full deceleration. A jog of
    /// another instruction continues. `why` is the cause of its end, unless it has ended otherwise.
    pub fn end_jog(&self, axis: AxisId, ticket: Ticket, why: JogEnd) {
        if let Some(jog) = self.0.jogs.get(usize::from(axis)) {
            // One instruction jogs an axis at a time: the newest.
            jog.fetch_max(word(ticket, why), Ordering::AcqRel);
            self.0.any.store(true, Ordering::Release);
        }
    }
}

/// Both ends, for a machine with this number of axes. The only allocation.
pub(crate) fn link(axes: usize) -> (StopReceiver, Stops) {
    let shared = Arc::new(Shared {
        any: AtomicBool::new(false),
        all: AtomicBool::new(false),
        inhibited: AtomicBool::new(false),
        jogs: (0..axes).map(|_| AtomicU64::new(0)).collect(),
    });
    let receiver = StopReceiver {
        shared: shared.clone(),
        next: None,
    };
    (receiver, Stops(shared))
}

impl StopReceiver {
    /// Motion is inhibited. Real-time.
    pub(crate) fn is_inhibited(&self) -> bool {
        self.shared.inhibited.load(Ordering::Acquire)
    }

    /// The next request. Real-time: bounded by the number of axes until it is `None`.
    pub(crate) fn next(&mut self) -> Option<StopRequest> {
        let mut axis = match self.next {
            Some(axis) => axis,
            None => {
                if !self.shared.any.swap(false, Ordering::AcqRel) {
                    return None;
                }
                if self.shared.all.swap(false, Ordering::AcqRel) {
                    self.next = Some(0);
                    return Some(StopRequest::All);
                }
                0
            }
        };
        while let Some(jog) = self.shared.jogs.get(axis) {
            if let Some((ticket, why)) = request(jog.swap(0, Ordering::AcqRel)) {
                self.next = Some(axis + 1);
                return Some(StopRequest::Jog {
                    axis: AxisId::from_index(axis),
                    ticket,
                    why,
                });
            }
            axis += 1;
        }
        self.next = None;
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_request_is_seen_once_and_repetitions_are_one() {
        let (mut receiver, stops) = link(3);
        assert_eq!(receiver.next(), None);
        stops.end_jog(AxisId(2), Ticket(7), JogEnd::Lost);
        stops.end_jog(AxisId(2), Ticket(5), JogEnd::Released);
        stops.end_jog(AxisId(0), Ticket(6), JogEnd::Silent);
        stops.end_jog(AxisId(9), Ticket(8), JogEnd::Lost);
        for _ in 0..100_000 {
            stops.stop_all();
        }
        let jog = |axis, ticket, why| {
            Some(StopRequest::Jog {
                axis,
                ticket: Ticket(ticket),
                why,
            })
        };
        let seen: Vec<_> = (0..4).map(|_| receiver.next()).collect();
        assert_eq!(
            seen,
            [
                Some(StopRequest::All),
                jog(AxisId(0), 6, JogEnd::Silent),
                jog(AxisId(2), 7, JogEnd::Lost),
                None
            ]
        );
        assert_eq!(receiver.next(), None);
        stops.stop_all();
        assert_eq!(receiver.next(), Some(StopRequest::All));
        assert_eq!(receiver.next(), None, "no jog was asked for");
    }
}
