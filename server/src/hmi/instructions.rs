//! `/api/instructions`: the catalogue as JSON, for forms that are made from it and nothing else.

use arcline_instruction_set::{
    ArrayRule, ERRORS, ErrorText, FAULTS, Instruction, Kind, Mnemonic, Operand, Range, TargetDialog, Unit, Words,
};
use serde_json::{Value, json};

/// Every instruction, every error and every fault of an axis.
pub(super) fn catalogue() -> Value {
    let instructions = Mnemonic::ALL.iter().map(|mnemonic| instruction(mnemonic.instruction()));
    let errors = ERRORS.iter().map(error);
    json!({
        "instructions": instructions.collect::<Vec<_>>(),
        "errors": errors.collect::<Vec<_>>(),
        "faults": FAULTS.iter().map(|fault| json!({"word": fault.word, "meaning": fault.meaning})).collect::<Vec<_>>(),
    })
}

fn error(row: &ErrorText) -> Value {
    json!({
        "err": row.err,
        "exerr": Value::Null,
        "name": row.name,
        "extended": row.extended.meaning(),
        "cause": row.cause,
        "remedy": row.remedy,
    })
}

fn instruction(instruction: &Instruction) -> Value {
    let operands = (0..).zip(instruction.operands);
    json!({
        "mnemonic": instruction.mnemonic.to_string(),
        "title": instruction.title,
        "summary": instruction.summary,
        "object": instruction.object.member(),
        "operands": operands.map(|(place, shown)| operand(instruction, place, shown)).collect::<Vec<_>>(),
        "target_position": instruction.target_dialog().map(dialog),
    })
}

fn operand(instruction: &Instruction, place: usize, operand: &Operand) -> Value {
    let member = |place: usize| instruction.operands.get(place).map(Operand::member);
    let unit = match instruction.unit(place) {
        Unit::Operand(units) => json!({"member": member(units)}),
        Unit::Position => json!({"text": "position"}),
        Unit::Master => json!({"text": "master units"}),
        Unit::Degrees => json!({"text": "deg"}),
        Unit::None => Value::Null,
    };
    let shown = instruction
        .shown_when(place)
        .map(|(other, value)| json!([{"member": member(other), "in": [value]}]));
    let mut described = json!({
        "name": operand.name,
        "member": operand.member(),
        "kind": kind(&operand.kind),
        "unit": unit,
        "shown_when": shown,
        "default": operand.initial,
        "help": operand.note,
    });
    match &operand.kind {
        Kind::Target(object) | Kind::Reference(object) => described["object"] = object.member().into(),
        Kind::Structure(name) | Kind::StructureOrNone(name) => described["type"] = (*name).into(),
        Kind::Word(words) => described["words"] = choices(words),
        Kind::Number(limits) | Kind::Integer(limits) => described["range"] = range(instruction, *limits),
        Kind::Array(rule) => {
            described["default"] = json!([]);
            described["elements"] = match rule {
                ArrayRule::PerAxis | ArrayRule::PerAxisUnless { .. } => "per_axis".into(),
                ArrayRule::AtLeast(least) => json!({"at_least": least}),
            };
            if let ArrayRule::PerAxisUnless { operand, value } = rule {
                described["single_when"] = json!({"member": member(usize::from(*operand)), "in": [value]});
            }
        }
        Kind::ArrayOrNone => described["default"] = json!([]),
        Kind::MotionControl | Kind::WrittenArray(_) => {}
    }
    described
}

fn kind(kind: &Kind) -> &'static str {
    match kind {
        Kind::Target(_) => "target",
        Kind::MotionControl => "control",
        Kind::Reference(_) => "reference",
        Kind::Word(_) => "word",
        Kind::Number(_) => "number",
        Kind::Integer(_) => "integer",
        Kind::Array(_) => "array",
        Kind::ArrayOrNone => "array_or_none",
        Kind::WrittenArray(_) => "written_array",
        Kind::Structure(_) => "structure",
        Kind::StructureOrNone(_) => "structure_or_none",
    }
}

fn choices(words: &Words) -> Value {
    let words = words.words.iter();
    words
        .map(|word| json!({"text": word.keyword(), "value": word.value, "title": word.title}))
        .collect()
}

fn range(instruction: &Instruction, range: Range) -> Value {
    match range {
        Range::Any => Value::Null,
        Range::NotNegative => json!({"min": 0, "max": null}),
        Range::Positive => json!({"min": 0, "min_exclusive": true, "max": null}),
        Range::Between(low, high) => json!({"min": low, "max": high}),
        Range::Jerk { units } => {
            let units = instruction.operands.get(usize::from(units)).map(Operand::member);
            json!({
                "min": 0,
                "min_exclusive": true,
                "max": null,
                "max_when": {"member": units, "in": Range::PERCENT_OF_TIME, "max": 100},
            })
        }
    }
}

fn dialog(dialog: &TargetDialog) -> Value {
    let rows = dialog.rows.iter().map(|row| {
        json!({
            "move_type": row.move_type as i32,
            "circle_type": row.circle_type.map(|circle| circle as i32),
            "target": row.target,
            "via": row.via,
            "targets_from_actuals": row.targets_from_actuals,
            "vias_from_actuals": row.vias_from_actuals,
        })
    });
    json!({
        "targets": dialog.targets,
        "vias": dialog.vias,
        "move_type": dialog.move_type,
        "circle_type": dialog.circle_type,
        "rows": rows.collect::<Vec<_>>(),
    })
}
