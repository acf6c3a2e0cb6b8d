//! The samples of a tick: one row of numbers for the whole machine, in a fixed order.
//!
//! Column 0 is the tick. Then come the columns of every axis, then those of every coordinate system, then those of the tool of every
//! robot, in configuration order.
//! Status words are numbers too: a word of 32 bits fits a 64-bit float exactly, and so does a tick.

use arcline_instruction_set::predefined;
use arcline_tag::{DataType, Elementary, Template};

use crate::machine::{CoordinateSystem, Machine};
use crate::{AxisSnapshot, Snapshot, SystemSnapshot};

/// The columns of an axis, named as the members of its tag.
pub const AXIS: [&str; 13] = [
    "CommandPosition",
    "CommandVelocity",
    "CommandAcceleration",
    "ActualPosition",
    "ActualVelocity",
    "PositionError",
    "AxisFault",
    "AxisStatus",
    "MotionStatus",
    "AxisEvent",
    "OutputCamStatus",
    "OutputCamLockStatus",
    OUTPUTS,
];

/// The column of an axis that is not a member of its tag: the bits that its output cams have set, of all targets together.
const OUTPUTS: &str = "OutputCamBits";

/// The columns of a coordinate system; words are named as the members of its tag.
pub const SYSTEM: [&str; 4] = [
    "PathSpeed",
    "PathPosition",
    "CoordinateSystemStatus",
    "CoordinateMotionStatus",
];

/// The columns of a robot's coordinate system: the position of its tool in the frame of its base (see [`SystemSnapshot::tool`]).
pub const TOOL: [&str; 3] = ["ToolX", "ToolY", "ToolZ"];

/// The location of a signal in a row.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Column {
    /// The number in a column.
    Number(usize),
    /// A bit of the word in a column: 0 or 1.
    Bit {
        /// The column.
        column: usize,
        /// The bit.
        mask: u32,
    },
}

impl Column {
    /// The signal in a row; 0 if the row has no such column.
    pub fn of(self, row: &[f64]) -> f64 {
        match self {
            Self::Number(column) => row.get(column).copied().unwrap_or_default(),
            Self::Bit { column, mask } => {
                let word = row.get(column).copied().unwrap_or_default() as u32;
                f64::from(u8::from(word & mask != 0))
            }
        }
    }
}

/// Numbers in a row.
pub fn width(machine: &Machine) -> usize {
    tools(machine) + TOOL.len() * robots(machine).count()
}

/// The first column of a tool.
fn tools(machine: &Machine) -> usize {
    1 + AXIS.len() * machine.axes.len() + SYSTEM.len() * machine.systems.len()
}

/// The coordinate systems of robots, in configuration order.
pub fn robots(machine: &Machine) -> impl Iterator<Item = &CoordinateSystem> {
    machine.systems.iter().filter(|system| system.robot.is_some())
}

/// The row of a snapshot. Real-time: no allocation; it has [`width`] numbers.
pub fn row(snapshot: &Snapshot) -> impl Iterator<Item = f64> + '_ {
    let axes = snapshot.axes.iter().flat_map(axis);
    let systems = snapshot.systems.iter().flat_map(system);
    let tools = snapshot.systems.iter().filter_map(|system| system.tool).flatten();
    std::iter::once(snapshot.tick as f64)
        .chain(axes)
        .chain(systems)
        .chain(tools)
}

/// The names of all columns except the first, in order: `X.CommandPosition`.
pub fn names(machine: &Machine) -> Vec<String> {
    let axes = machine.axes.iter();
    let axes = axes.flat_map(|axis| AXIS.map(|signal| format!("{}.{signal}", axis.name)));
    let systems = machine.systems.iter();
    let systems = systems.flat_map(|system| SYSTEM.map(|signal| format!("{}.{signal}", system.name)));
    let tools = robots(machine).flat_map(|system| TOOL.map(|signal| format!("{}.{signal}", system.name)));
    axes.chain(systems).chain(tools).collect()
}

/// The location of a signal by its name, case ignored: a column, a bit of a status word by its name (`X.MoveStatus`), or a bit of any word
/// by its number (`X.OutputCamBits.3`).
pub fn find(machine: &Machine, name: &str) -> Option<Column> {
    let (object, signal) = name.split_once('.')?;
    if let Some(index) = machine.axis(object) {
        let index = usize::from(index);
        let template = if machine.axes[index].is_virtual() {
            predefined::axis_virtual()
        } else {
            predefined::axis_cip_drive()
        };
        return within(&AXIS, &template, signal, 1 + index * AXIS.len());
    }
    let index = usize::from(machine.system(object)?);
    let described = machine.systems.get(index)?;
    if let Some(number) = TOOL.iter().position(|column| column.eq_ignore_ascii_case(signal)) {
        described.robot?;
        let before = robots(machine).take_while(|other| other.name != described.name);
        return Some(Column::Number(tools(machine) + TOOL.len() * before.count() + number));
    }
    let first = 1 + machine.axes.len() * AXIS.len() + index * SYSTEM.len();
    within(&SYSTEM, &predefined::coordinate_system(), signal, first)
}

/// A signal among the columns of an object that begin at `first`.
fn within(columns: &[&str], template: &Template, signal: &str, first: usize) -> Option<Column> {
    if let Some(index) = columns.iter().position(|column| column.eq_ignore_ascii_case(signal)) {
        return Some(Column::Number(first + index));
    }
    if let Some((word, bit)) = signal.split_once('.') {
        let index = columns.iter().position(|column| column.eq_ignore_ascii_case(word))?;
        let is_word = columns[index] == OUTPUTS
            || template.member(columns[index]).is_some_and(|member| {
                member.data_type == DataType::Elementary(Elementary::Dint) && member.bit.is_none()
            });
        let bit = bit.parse::<u32>().ok().filter(|bit| is_word && *bit < u32::BITS)?;
        return Some(Column::Bit {
            column: first + index,
            mask: 1 << bit,
        });
    }
    let member = template.member(signal)?;
    let bit = u32::from(member.bit?);
    columns.iter().enumerate().find_map(|(index, column)| {
        let word = template.member(column).filter(|word| word.bit.is_none())?;
        let byte = member.offset.checked_sub(word.offset).filter(|byte| *byte < 4)?;
        Some(Column::Bit {
            column: first + index,
            mask: 1 << (8 * byte + bit),
        })
    })
}

fn axis(axis: &AxisSnapshot) -> [f64; AXIS.len()] {
    [
        axis.command[0],
        axis.command[1],
        axis.command[2],
        axis.actual[0],
        axis.actual[1],
        axis.position_error,
        axis.fault.into(),
        axis.status.into(),
        axis.motion_status.into(),
        axis.event.into(),
        axis.output_cams[0].into(),
        axis.output_cams[2].into(),
        axis.outputs.into(),
    ]
}

fn system(system: &SystemSnapshot) -> [f64; SYSTEM.len()] {
    [
        system.path_speed,
        system.path_position,
        system.status.into(),
        system.motion_status.into(),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_have_bits_by_name_and_by_number() {
        let template = predefined::axis_cip_drive();
        let find = |signal: &str| within(&AXIS, &template, signal, 1);
        let column = |name: &str| AXIS.iter().position(|column| *column == name).map(|index| 1 + index);
        let bit = |name: &str, bit: u32| column(name).map(|column| Column::Bit { column, mask: 1 << bit });
        #[rustfmt::skip]
        let cases = [
            ("MoveStatus",           bit("MotionStatus", 2)),
            ("motionstatus.2",       bit("MotionStatus", 2)),
            ("OutputCamBits",        column(OUTPUTS).map(Column::Number)),
            ("OutputCamBits.31",     bit(OUTPUTS, 31)),
            ("OutputCamStatus.0",    bit("OutputCamStatus", 0)),
            ("OutputCamBits.32",     None),
            ("OutputCamBits.x",      None),
            ("CommandPosition.1",    None),
            ("Nothing.1",            None),
        ];
        for (signal, expected) in cases {
            assert_eq!(find(signal), expected, "{signal}");
        }
    }
}
