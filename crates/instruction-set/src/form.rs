//! The parts of an instruction's form besides its operands: units, the fields that apply, and the target position dialog
//! (the reference page MCCM, "MCCM Target Position Entry Dialog Box").

use crate::Mnemonic;
use crate::enumerations::{CircleType, MoveType, NoYes};
use crate::instruction::{Condition, Instruction, Kind, Range};

/// The unit of an operand's number.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Unit {
    /// The unit that another operand selects, by its index.
    Operand(usize),
    /// Position units of the object.
    Position,
    /// Units of the master axis.
    Master,
    /// Degrees.
    Degrees,
    /// No unit.
    None,
}

/// Which fields the target position dialog shows for a move type and a circle type.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct TargetRow {
    /// Value of Move Type.
    pub move_type: MoveType,
    /// Value of Circle Type; `None`: the instruction has none.
    pub circle_type: Option<CircleType>,
    /// Title of the column of end points.
    pub target: &'static str,
    /// Title of the column of vias, centres or the radius.
    pub via: Option<&'static str>,
    /// Whether the dialog offers "Set Targets = Actuals".
    pub targets_from_actuals: bool,
    /// Whether the dialog offers "Set Vias = Actuals".
    pub vias_from_actuals: bool,
}

/// The target position dialog of an instruction, by the members that it fills.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct TargetDialog {
    /// Member of the end points.
    pub targets: &'static str,
    /// Member of the vias.
    pub vias: Option<&'static str>,
    /// Member of the move type.
    pub move_type: &'static str,
    /// Member of the circle type.
    pub circle_type: Option<&'static str>,
    /// The headings for every combination.
    pub rows: &'static [TargetRow],
}

impl Instruction {
    /// The unit of an operand.
    pub fn unit(&self, place: usize) -> Unit {
        let Some(operand) = self.operands.get(place) else {
            return Unit::None;
        };
        if let Kind::Number(Range::Jerk { units }) = operand.kind {
            return Unit::Operand(units.into());
        }
        let of = |name| self.operand(name).map_or(Unit::None, Unit::Operand);
        match operand.name {
            "Speed" => of("Speed Units"),
            "Accel Rate" => of("Accel Units"),
            "Decel Rate" => of("Decel Units"),
            "Position" | "Via/Center/Radius" | "Command Tolerance" | "Event Distance" | "Translation"
            | "Reference Position" => Unit::Position,
            "Lock Position" | "Master Lock Position" | "Cam Lock Position" | "Nominal Master Velocity" => Unit::Master,
            "Orientation" => Unit::Degrees,
            _ => Unit::None,
        }
    }

    /// The operand and the values of it for which an operand matters; `None`: it always does.
    pub fn shown_when(&self, place: usize) -> Option<(usize, i32)> {
        match self.operands.get(place)?.condition {
            Condition::Always => None,
            Condition::Changed(flag) => Some((flag.into(), NoYes::Yes as i32)),
            Condition::When { operand, value } => Some((operand.into(), value)),
        }
    }

    /// The target position dialog, where the instruction has one.
    pub fn target_dialog(&self) -> Option<&'static TargetDialog> {
        match self.mnemonic {
            Mnemonic::Mclm => Some(&LINE_DIALOG),
            Mnemonic::Mccm => Some(&CIRCLE_DIALOG),
            _ => None,
        }
    }
}

impl TargetRow {
    /// As people read it: `Absolute, Center Incremental`.
    pub fn title(&self) -> String {
        let move_type = self.move_type.definition().title;
        match self.circle_type {
            None => move_type.to_owned(),
            Some(circle) => format!("{move_type}, {}", circle.definition().title),
        }
    }
}

const TARGET_POSITION: &str = "Target Position";
const TARGET_INCREMENT: &str = "Target Increment";

static LINE_DIALOG: TargetDialog = TargetDialog {
    targets: "Position",
    vias: None,
    move_type: "MoveType",
    circle_type: None,
    rows: &[
        row(MoveType::Absolute, None, None, false),
        row(MoveType::Incremental, None, None, false),
    ],
};

/// The reference page's table "Target Position Entry Dialog Box Changes", row by row.
#[rustfmt::skip]
static CIRCLE_DIALOG: TargetDialog = TargetDialog {
    targets: "Position",
    vias: Some("ViaCenterRadius"),
    move_type: "MoveType",
    circle_type: Some("CircleType"),
    rows: &[
        row(MoveType::Absolute, Some(CircleType::Via), Some("Via Position"), true),
        row(MoveType::Incremental, Some(CircleType::Via), Some("Via Increment"), false),
        row(MoveType::Absolute, Some(CircleType::Center), Some("Center Position"), true),
        row(MoveType::Incremental, Some(CircleType::Center), Some("Center Increment"), false),
        row(MoveType::Absolute, Some(CircleType::Radius), Some("Radius"), false),
        row(MoveType::Incremental, Some(CircleType::Radius), Some("Radius"), false),
        row(MoveType::Absolute, Some(CircleType::CenterIncremental), Some("Center Incremental"), false),
        row(MoveType::Incremental, Some(CircleType::CenterIncremental), Some("Center Incremental"), false),
    ],
};

/// Targets can be set to the actual positions when the move is absolute.
const fn row(
    move_type: MoveType,
    circle_type: Option<CircleType>,
    via: Option<&'static str>,
    vias_from_actuals: bool,
) -> TargetRow {
    let absolute = matches!(move_type, MoveType::Absolute);
    TargetRow {
        move_type,
        circle_type,
        target: if absolute { TARGET_POSITION } else { TARGET_INCREMENT },
        via,
        targets_from_actuals: absolute,
        vias_from_actuals,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_dialog_is_the_seeds_table() {
        #[rustfmt::skip]
        let expected = [
            // move type, circle type,          target,             via,                   targets, vias
            ("Absolute, Via",                   "Target Position",  "Via Position",        true,    true),
            ("Incremental, Via",                "Target Increment", "Via Increment",       false,   false),
            ("Absolute, Center",                "Target Position",  "Center Position",     true,    true),
            ("Incremental, Center",             "Target Increment", "Center Increment",    false,   false),
            ("Absolute, Radius",                "Target Position",  "Radius",              true,    false),
            ("Incremental, Radius",             "Target Increment", "Radius",              false,   false),
            ("Absolute, Center Incremental",    "Target Position",  "Center Incremental",  true,    false),
            ("Incremental, Center Incremental", "Target Increment", "Center Incremental",  false,   false),
        ];
        let dialog = Mnemonic::Mccm.instruction().target_dialog().expect("MCCM has one");
        assert_eq!(dialog.rows.len(), expected.len());
        for (row, (title, target, via, targets, vias)) in dialog.rows.iter().zip(expected) {
            assert_eq!(row.title(), title);
            let shown = (row.target, row.via, row.targets_from_actuals, row.vias_from_actuals);
            assert_eq!(shown, (target, Some(via), targets, vias), "{title}");
        }
    }

    #[test]
    fn dialogs_fill_operands_that_there_are() {
        for mnemonic in Mnemonic::ALL {
            let instruction = mnemonic.instruction();
            let Some(dialog) = instruction.target_dialog() else {
                continue;
            };
            let members = [
                Some(dialog.targets),
                dialog.vias,
                Some(dialog.move_type),
                dialog.circle_type,
            ];
            for member in members.into_iter().flatten() {
                assert!(instruction.operand(member).is_some(), "{mnemonic} {member}");
            }
        }
    }

    #[test]
    fn units_and_conditions_are_those_of_the_faceplate() {
        #[rustfmt::skip]
        let cases = [
            // instruction,  operand,             unit,                 shown when
            (Mnemonic::Mclm, "Position",          Some("position"),     None),
            (Mnemonic::Mclm, "Speed",             Some("Speed Units"),  None),
            (Mnemonic::Mclm, "Accel Jerk",        Some("Jerk Units"),   Some(("Profile", 1))),
            (Mnemonic::Mclm, "Command Tolerance", Some("position"),     Some(("Termination Type", 6))),
            (Mnemonic::Mccd, "Speed",             Some("Speed Units"),  Some(("Change Speed", 1))),
            (Mnemonic::Mcs,  "Decel Rate",        Some("Decel Units"),  Some(("Change Decel", 1))),
            (Mnemonic::Mag,  "Ratio",             None,                 Some(("Ratio Format", 0))),
        ];
        for (mnemonic, operand, unit, when) in cases {
            let instruction = mnemonic.instruction();
            let place = instruction.operand(operand).expect(operand);
            let shown = match instruction.unit(place) {
                Unit::Operand(other) => Some(instruction.operands[other].name),
                Unit::Position => Some("position"),
                Unit::Master | Unit::Degrees | Unit::None => None,
            };
            let condition = instruction.shown_when(place);
            let condition = condition.map(|(other, value)| (instruction.operands[other].name, value));
            assert_eq!((shown, condition), (unit, when), "{mnemonic} {operand}");
        }
    }
}
