//! Binary frames of samples: every tick of the signals that a page draws, made once for all viewers that want them.
//!
//! A frame is `"ARC1"`, then little-endian: rows n (u32), signals m (u32), 0 (u32), the tick of the first row (u64), a base
//! of every signal (m × f64), and n × m differences from the bases (f32), row by row. Between two frames no tick is missing,
//! unless the viewer was too slow or the store has a gap: then the first tick shows the gap.
//!
//! Samples from before a viewer came are `"ARC2"`, requested piece by piece: after rows and signals follow the ticks k of a row
//! (u32), then as above. If such a frame has more signals than other frames, these are jerk and following error of each axis, and a row
//! has three differences of each signal: those of its value at the first tick, its least and its greatest.

use std::sync::Arc;
use std::time::Duration;

use bytes::{BufMut, Bytes, BytesMut};
use tokio::time::{MissedTickBehavior, interval};

use super::Shared;
use super::protocol::HistoryPiece;
use crate::plant::Plant;
use crate::trace::{Past, history};

/// Time between two frames.
const EVERY: Duration = Duration::from_millis(33);
/// Rows of a frame at most.
const ROWS: usize = 512;
/// Frames that may wait for a viewer: about two seconds.
pub(super) const WAITING: usize = 64;
/// Rows of a piece of the past at most, where a row is a tick.
const PAST_ROWS: usize = 512;

/// Makes frames while a viewer wants them, until the future is dropped.
pub(super) async fn produce(shared: Arc<Shared>) {
    let columns = history::columns(shared.plant.machine());
    let trace = shared.plant.trace();
    let mut from = None;
    let mut due = interval(EVERY);
    due.set_missed_tick_behavior(MissedTickBehavior::Delay);
    loop {
        due.tick().await;
        if shared.frames.receiver_count() == 0 {
            from = None;
            continue;
        }
        let mut next = from.unwrap_or_else(|| trace.stored_ticks().next);
        loop {
            let (first, rows, values) = trace.rows(next, &columns, ROWS);
            if rows == 0 {
                break;
            }
            next = first + rows as u64;
            // The last viewer may just have gone.
            let _ = shared.frames.send(frame(first, columns.len(), &values));
        }
        from = Some(next);
    }
}

/// The newest samples before a tick that the server has, as a frame, with its description.
pub(super) fn history_before(plant: &Plant, before: u64) -> (Bytes, HistoryPiece) {
    let columns = history::columns(plant.machine());
    let past = plant.trace().past(before, &columns, PAST_ROWS);
    let rows = past.values.len() / (past.signals * past.of_signal).max(1);
    let piece = HistoryPiece {
        first: past.first,
        every: past.every,
        rows,
    };
    (past_frame(&past), piece)
}

fn frame(first: u64, signals: usize, values: &[f64]) -> Bytes {
    let bases = values.get(..signals).unwrap_or_default();
    encode(*b"ARC1", first, 0, bases, values, 1)
}

fn past_frame(past: &Past) -> Bytes {
    let values = past.values.get(..past.signals * past.of_signal).unwrap_or_default();
    let bases: Vec<f64> = values.iter().copied().step_by(past.of_signal).collect();
    encode(
        *b"ARC2",
        past.first,
        past.every as u32,
        &bases,
        &past.values,
        past.of_signal,
    )
}

/// Rows of `of_signal` numbers of each signal; `word` is the third after the magic one.
fn encode(magic: [u8; 4], first: u64, word: u32, bases: &[f64], values: &[f64], of_signal: usize) -> Bytes {
    let rows = values.len() / (bases.len() * of_signal).max(1);
    // A base that is no number would leave none of its signal.
    let bases: Vec<f64> = bases
        .iter()
        .map(|base| if base.is_nan() { 0.0 } else { *base })
        .collect();
    let mut out = BytesMut::with_capacity(24 + 8 * bases.len() + 4 * values.len());
    out.put_slice(&magic);
    out.put_u32_le(rows as u32);
    out.put_u32_le(bases.len() as u32);
    out.put_u32_le(word);
    out.put_u64_le(first);
    bases.iter().for_each(|base| out.put_f64_le(*base));
    let of_values = bases.iter().flat_map(|base| std::iter::repeat_n(*base, of_signal));
    for (value, base) in values.iter().zip(of_values.cycle()) {
        out.put_f32_le((value - base) as f32);
    }
    out.freeze()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_frame_reads_as_it_says() {
        let frame = frame(0x0102, 2, &[1000.5, -3.0, 1001.0, -2.75]);
        #[rustfmt::skip]
        let expected = [
            b"ARC1".as_slice(), &2u32.to_le_bytes(), &2u32.to_le_bytes(), &[0; 4], &0x0102u64.to_le_bytes(),
            &1000.5f64.to_le_bytes(), &(-3.0f64).to_le_bytes(),
            &0f32.to_le_bytes(), &0f32.to_le_bytes(), &0.5f32.to_le_bytes(), &0.25f32.to_le_bytes(),
        ];
        assert_eq!(frame, expected.concat());
    }

    #[test]
    fn a_piece_of_the_past_reads_as_it_says() {
        let past = Past {
            first: 32,
            every: 16,
            signals: 2,
            of_signal: 3,
            values: vec![10.0, 9.0, 12.0, f64::NAN, 1.0, 2.0],
        };
        let frame = past_frame(&past);
        #[rustfmt::skip]
        let head = [
            b"ARC2".as_slice(), &1u32.to_le_bytes(), &2u32.to_le_bytes(), &16u32.to_le_bytes(), &32u64.to_le_bytes(),
            &10f64.to_le_bytes(), &0f64.to_le_bytes(),
        ].concat();
        assert_eq!(&frame[..40], head);
        let rest: Vec<f32> = frame[40..]
            .chunks_exact(4)
            .map(|bytes| f32::from_le_bytes(*bytes.first_chunk().expect("4 bytes")))
            .collect();
        assert_eq!((&rest[..3], &rest[4..]), (&[0.0, -1.0, 2.0][..], &[1.0, 2.0][..]));
        assert!(rest[3].is_nan());
    }
}
