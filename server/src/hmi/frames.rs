//! Binary frames of samples: every tick of the signals that a page draws, made once for all viewers that want them.
//!
//! A frame is `"ARC1"`, then little-endian: rows n (u32), signals m (u32), 0 (u32), the tick of the first row (u64), a base
//! of every signal (m × f64), and n × m differences from the bases (f32), row by row. Between two frames no tick is missing,
//! unless the viewer was too slow or the store has a gap: then the first tick tells.

use std::sync::Arc;
use std::time::Duration;

use arcline_controller::machine::Machine;
use arcline_controller::samples::{self, Column};
use bytes::{BufMut, Bytes, BytesMut};
use tokio::time::{MissedTickBehavior, interval};

use super::Shared;

/// Time between two frames.
const EVERY: Duration = Duration::from_millis(33);
/// Rows of a frame at most.
const ROWS: usize = 512;
/// Frames that may wait for a viewer: about two seconds.
pub(super) const WAITING: usize = 64;
/// Signals of an axis, the first of its columns.
const OF_AXIS: usize = 4;

/// The names of the signals of a frame, in order.
pub(super) fn signals(machine: &Machine) -> Vec<String> {
    let axes = machine.axes.iter();
    let axes = axes.flat_map(|axis| {
        samples::AXIS[..OF_AXIS]
            .iter()
            .map(move |signal| format!("{}.{signal}", axis.name))
    });
    let systems = machine.systems.iter();
    let systems = systems.map(|system| format!("{}.{}", system.name, samples::SYSTEM[0]));
    axes.chain(systems).collect()
}

/// Makes frames while somebody wants them, until the future is dropped.
pub(super) async fn produce(shared: Arc<Shared>) {
    let machine = shared.plant.machine();
    let columns: Vec<Column> = signals(machine)
        .iter()
        .filter_map(|signal| samples::find(machine, signal))
        .collect();
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
        let mut next = from.unwrap_or_else(|| trace.kept().next);
        loop {
            let (first, rows, values) = trace.rows(next, &columns, ROWS);
            if rows == 0 {
                break;
            }
            next = first + rows as u64;
            // Everybody may just have gone.
            let _ = shared.frames.send(frame(first, columns.len(), &values));
        }
        from = Some(next);
    }
}

fn frame(first: u64, signals: usize, values: &[f64]) -> Bytes {
    let bases = values.get(..signals).unwrap_or_default();
    let rows = values.len() / signals.max(1);
    let mut out = BytesMut::with_capacity(24 + 8 * signals + 4 * values.len());
    out.put_slice(b"ARC1");
    out.put_u32_le(rows as u32);
    out.put_u32_le(signals as u32);
    out.put_u32_le(0);
    out.put_u64_le(first);
    bases.iter().for_each(|base| out.put_f64_le(*base));
    for (value, base) in values.iter().zip(bases.iter().cycle()) {
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
    fn every_signal_has_a_column() {
        let project = arcline_config::load(arcline_config::DEFAULT, "default").expect("it is valid");
        let names = signals(&project.machine);
        assert_eq!(
            (names.len(), names[0].as_str(), names[31].as_str()),
            (32, "X.CommandPosition", "XY.PathSpeed")
        );
        assert!(names.iter().all(|name| samples::find(&project.machine, name).is_some()));
    }
}
