//! The past beyond the stored rows: of every signal of the page the value, the least and the greatest of a few ticks at a time. The number of
//! ticks is the least power of two at which eleven minutes fit into the memory for it.
//!
//! Units are those of the samples; jerk in position units per s³. Not here: the frames that carry it (`hmi::frames`).

use arcline_controller::machine::Machine;
use arcline_controller::samples::{self, Column};

use super::store::Store;

/// The stored numbers of a signal: the value at the first tick, the least, the greatest.
pub(crate) const OF_SIGNAL: usize = 3;
/// The length of the history, s.
const KEPT_SECONDS: f64 = 660.0;
/// Memory for it, bytes.
const BYTES: usize = 24 << 20;
/// Columns of an axis that the page draws, the first ones.
const OF_AXIS: usize = 4;
/// The place of the command position, the acceleration and the actual position among them.
const COMMAND: usize = 0;
const ACCELERATION: usize = 2;
const ACTUAL: usize = 3;

/// The signals that a page gets of every tick, in order: four of each axis, then the path speed of each coordinate system, then the
/// place of the tool of each robot.
pub(crate) fn signals(machine: &Machine) -> Vec<String> {
    let axes = machine.axes.iter();
    let axes = axes.flat_map(|axis| {
        samples::AXIS[..OF_AXIS]
            .iter()
            .map(move |signal| format!("{}.{signal}", axis.name))
    });
    let systems = machine.systems.iter();
    let systems = systems.map(|system| format!("{}.{}", system.name, samples::SYSTEM[0]));
    let tools =
        samples::robots(machine).flat_map(|system| samples::TOOL.map(|signal| format!("{}.{signal}", system.name)));
    axes.chain(systems).chain(tools).collect()
}

/// The columns of [`signals`] in a row.
pub(crate) fn columns(machine: &Machine) -> Vec<Column> {
    let signals = signals(machine);
    let columns = signals.iter().filter_map(|signal| samples::find(machine, signal));
    columns.collect()
}

/// The newest eleven minutes, some ticks at a time.
#[derive(Debug)]
pub(super) struct History {
    quantities: Vec<Quantity>,
    period: f64,
    width: usize,
    every: u64,
    /// Rows of the number of the ticks' group, then [`OF_SIGNAL`] numbers of each quantity.
    store: Store,
    /// The row of the group that is under way.
    row: Vec<f64>,
    /// The row of the tick before.
    before: Vec<f64>,
}

/// A stored quantity, calculated from the row of a tick and that of the tick before.
#[derive(Clone, Copy, Debug)]
enum Quantity {
    /// A signal.
    Signal(Column),
    /// The change of a signal, per second.
    Change(Column),
    /// One signal minus another.
    Difference(Column, Column),
}

impl History {
    pub(super) fn new(machine: &Machine) -> Self {
        Self::within(machine, BYTES)
    }

    /// Makes a history within an amount of memory, bytes.
    fn within(machine: &Machine, bytes: usize) -> Self {
        let columns = columns(machine);
        let of_axes = columns.chunks_exact(OF_AXIS).take(machine.axes.len());
        let derived = of_axes.flat_map(|of| {
            [
                Quantity::Change(of[ACCELERATION]),
                Quantity::Difference(of[COMMAND], of[ACTUAL]),
            ]
        });
        let signals = columns.iter().copied().map(Quantity::Signal);
        let quantities: Vec<Quantity> = signals.chain(derived).collect();
        let wide = 1 + OF_SIGNAL * quantities.len();
        let rows = |every: u64| (KEPT_SECONDS / (machine.period() * every as f64)).ceil() as usize;
        let mut every = 1;
        while rows(every) * wide * size_of::<f64>() > bytes {
            every *= 2;
        }
        let width = samples::width(machine);
        History {
            quantities,
            period: machine.period(),
            width,
            every,
            store: Store::new(wide, rows(every)),
            row: Vec::with_capacity(wide),
            before: vec![f64::NAN; width],
        }
    }

    /// Ticks that are one row here.
    pub(super) fn every(&self) -> u64 {
        self.every
    }

    /// Appends whole rows of samples, oldest first.
    pub(super) fn append(&mut self, rows: &[f64]) {
        for row in rows.chunks_exact(self.width) {
            let tick = row.first().copied().unwrap_or_default();
            let group = (tick / self.every as f64).floor();
            if self.row.first().is_some_and(|under_way| *under_way != group) {
                self.store.append(&self.row);
                self.row.clear();
            }
            let consecutive = self.before.first() == Some(&(tick - 1.0));
            let (before, period) = (&self.before, self.period);
            let values = self.quantities.iter().map(|quantity| match *quantity {
                Quantity::Signal(column) => column.of(row),
                Quantity::Change(column) if consecutive => (column.of(row) - column.of(before)) / period,
                Quantity::Change(_) => f64::NAN,
                Quantity::Difference(of, from) => of.of(row) - from.of(row),
            });
            if self.row.is_empty() {
                self.row.push(group);
                self.row.extend(values.flat_map(|value| [value; OF_SIGNAL]));
            } else {
                for (kept, value) in self.row[1..].chunks_exact_mut(OF_SIGNAL).zip(values) {
                    // If one of the two is not a number, the minimum or maximum is the other.
                    kept[1] = kept[1].min(value);
                    kept[2] = kept[2].max(value);
                }
            }
            self.before.copy_from_slice(row);
        }
    }

    /// The newest rows without a gap that begin before a tick, at most `most`: the tick of the first, and the rows without
    /// the number of their group.
    pub(super) fn before(&self, tick: u64, most: usize) -> (u64, Vec<&[f64]>) {
        let rows: Vec<(u64, &[f64])> = self.store.run_before(tick.div_ceil(self.every), most).collect();
        let first = rows.first().map_or(tick, |(group, _)| group * self.every);
        (first, rows.iter().map(|(_, row)| &row[1..]).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn machine() -> Machine {
        let project = arcline_config::load(arcline_config::DEFAULT, "default").expect("it is valid");
        project.machine
    }

    /// The row of a tick: X stands at the tick squared, and follows by 2; its acceleration is 10 × tick.
    fn row(machine: &Machine, tick: u64) -> Vec<f64> {
        let mut row = vec![0.0; samples::width(machine)];
        let mut put = |name: &str, value: f64| match samples::find(machine, name) {
            Some(Column::Number(column)) => row[column] = value,
            other => panic!("{name}: {other:?}"),
        };
        let square = (tick * tick) as f64;
        put("X.CommandPosition", square);
        put("X.ActualPosition", square - 2.0);
        put("X.CommandAcceleration", 10.0 * tick as f64);
        put("XY.PathSpeed", -(tick as f64));
        row[0] = tick as f64;
        row
    }

    #[test]
    fn every_signal_has_a_column() {
        let machine = machine();
        let names = signals(&machine);
        assert_eq!(
            (names.len(), names[0].as_str(), names[31].as_str()),
            (32, "X.CommandPosition", "XY.PathSpeed")
        );
        assert_eq!(columns(&machine).len(), names.len());
        let robot = include_str!("../../../docs/images/tool-path.toml");
        let machine = arcline_config::load(robot, "robot.toml").expect("it is valid").machine;
        let names = signals(&machine);
        assert_eq!((names.len(), names[28].as_str()), (6 * 4 + 2 + 3, "PICKER.ToolZ"));
        assert_eq!(columns(&machine).len(), names.len());
    }

    #[test]
    fn groups_tell_value_least_and_greatest() {
        let machine = machine();
        assert_eq!(History::new(&machine).every(), 32, "eleven minutes at 1 ms");
        let mut history = History::within(&machine, 2 * BYTES);
        assert_eq!(history.every(), 16, "in twice the room");
        for tick in 5..100 {
            history.append(&row(&machine, tick));
        }
        // Groups 0 to 5 are whole; the seventh is under way.
        let (first, rows) = history.before(100, 1000);
        assert_eq!((first, rows.len()), (0, 6));
        let of = |row: usize, signal: usize| &rows[row][OF_SIGNAL * signal..OF_SIGNAL * (signal + 1)];
        let derived = signals(&machine).len();
        assert_eq!(of(0, 0), [25.0, 25.0, 225.0], "from the first tick on");
        assert_eq!(of(1, 0), [256.0, 256.0, 961.0]);
        assert_eq!(of(1, 31), [-16.0, -31.0, -16.0]);
        assert_eq!(of(1, derived), [10_000.0; 3], "jerk: 10 more each ms");
        assert!(of(0, derived)[0].is_nan(), "nothing is known before the first tick");
        assert_eq!(of(0, derived)[1..], [10_000.0; 2]);
        assert_eq!(of(2, derived + 1), [2.0; 3], "following error");
        let (first, rows) = history.before(65, 2);
        assert_eq!((first, rows.len()), (48, 2), "that of the tick 64 begins before 65");
        assert_eq!(history.before(64, 1).0, 48);
        assert_eq!(history.before(0, 10), (0, Vec::new()));
    }

    #[test]
    fn behind_a_gap_it_begins_again() {
        let machine = machine();
        let mut history = History::within(&machine, 2 * BYTES);
        for tick in (0..64).chain(128..256) {
            history.append(&row(&machine, tick));
        }
        let (first, rows) = history.before(240, 1000);
        assert_eq!((first, rows.len()), (128, 7));
        let (first, rows) = history.before(first, 1000);
        assert_eq!((first, rows.len()), (0, 4));
    }

    #[test]
    fn it_is_as_fine_as_its_memory_allows() {
        let mut machine = machine();
        machine.period_ns = 32_000_000;
        assert_eq!(History::new(&machine).every(), 1);
        machine.period_ns = 250_000;
        assert_eq!(History::new(&machine).every(), 128);
        assert_eq!(History::within(&machine, 12 << 20).every(), 256);
    }
}
