//! The reference pages, made from the catalogue. A test writes them and fails when they are old.

use std::fmt::Write;

use crate::enumerations::NoYes;
use crate::instruction::{ArrayRule, Axes, Condition, Instruction, Kind, Object, Operand, Range, services};
use crate::{ERRORS, ExceptionAction, FAULTS, FaultWord, Words};

/// docs/INSTRUCTIONS.md: every instruction with its operands.
pub fn instructions() -> String {
    let mut page = String::from(
        "# Instructions\n\nWritten by a test from the catalogue; do not edit. \"#\" is the faceplate position and the \
         EXERR of error 13. \"First\" is the\nfirst value in an instruction tag; a trailing operand that is left out is 0, \
         None, Disabled, Programmed.\nNo number has a magnitude above 1e15; a number that cannot be negative is 0, where that is legal, or at least \
         1e-15. Positions\nlie within the range of the axis ([section 4.6](spec/coordinated-instructions.md#46-legal-ranges), \"The range of positions\").\nErrors: see [ERRORS.md](ERRORS.md).\n",
    );
    for object in [Object::CoordinateSystem, Object::Axis, Object::MotionGroup] {
        let _ = write!(page, "\n## Class {:#06x}: {}\n", object.class_code(), object.name());
        for mnemonic in services(object) {
            instruction(&mut page, mnemonic.instruction());
        }
    }
    page
}

/// docs/ERRORS.md: every motion error.
pub fn errors() -> String {
    let mut page = String::from(
        "# Motion errors\n\nWritten by a test from the catalogue; do not edit.\n\n\
         | ERR | Name | EXERR | Cause | Remedy |\n|---|---|---|---|---|\n",
    );
    for row in ERRORS {
        let extended = row.extended.meaning();
        let _ = writeln!(
            page,
            "| {} | {} | {extended} | {} | {} |",
            row.err, row.name, row.cause, row.remedy
        );
    }
    page.push_str(
        "\n## Lists of their own\n\nWhat EXERR means for these errors. `arcline explain 13/4 MCLM` tells all of it for one \
         error.\n\n| ERR | EXERR | meaning |\n|---|---|---|\n",
    );
    for row in ERRORS {
        for (exerr, meaning) in row.details {
            let _ = writeln!(page, "| {} | {exerr} | {meaning} |", row.err);
        }
    }
    page
}

/// docs/FAULTS.md: every fault of an axis and every action.
pub fn faults() -> String {
    let mut page = String::from(FAULTS_HEAD);
    for (place, fault) in FAULTS.iter().enumerate() {
        let word = match fault.shows {
            FaultWord::Motion => "MotionFaultStatus",
            FaultWord::Cip => "CIPAxisFaults",
        };
        let found = if fault.detected { "" } else { " Injected only." };
        let _ = writeln!(
            page,
            "| `{}` | {place} | {word}.{} | `{}` | {}{found} |",
            fault.word,
            fault.bit,
            fault.default.word(),
            fault.meaning
        );
    }
    page.push_str("\n## Actions\n\n| action | value | effect |\n|---|---|---|\n");
    for (value, (word, action)) in ExceptionAction::ALL.into_iter().enumerate() {
        let _ = writeln!(page, "| `{word}` | {value} | {} |", action_effect(action));
    }
    page.push_str(FAULTS_TAIL);
    page
}

fn action_effect(action: ExceptionAction) -> &'static str {
    match action {
        ExceptionAction::Ignore => "Nothing.",
        ExceptionAction::Alarm => "The alarm bit (MotionAlarmStatus, CIPAxisAlarms), while the cause is there.",
        ExceptionAction::FaultStatusOnly => "The fault bits. Motion goes on, and instructions work.",
        ExceptionAction::StopPlanner => "The axis decelerates at Maximum Deceleration. The servo stays on.",
        ExceptionAction::StopDrive => {
            "The axis decelerates at Maximum Deceleration (CIPAxisState 7), then the servo goes off (8). A virtual axis, \
             which has no drive: as `stop_planner`."
        }
        ExceptionAction::Shutdown => "Servo off and shutdown at once (10); the axis coasts.",
    }
}

/// The Structured Text form, such as `MSO(Axis, MotionControl);`.
pub fn syntax(instruction: &Instruction) -> String {
    let operands: Vec<_> = instruction.operands.iter().map(Operand::member).collect();
    format!("{}({});", instruction.mnemonic, operands.join(", "))
}

/// The type of an operand, in words.
pub fn operand_type(kind: &Kind) -> String {
    match kind {
        Kind::Target(object) | Kind::Object(object) => format!("{object}"),
        Kind::MotionControl => "MOTION_INSTRUCTION".to_owned(),
        Kind::Word(_) => "word or number".to_owned(),
        Kind::Number(_) => "number".to_owned(),
        Kind::Integer(_) => "whole number".to_owned(),
        Kind::Array(_) => "REAL array".to_owned(),
        Kind::ArrayOrNone => "REAL array or 0".to_owned(),
        Kind::WrittenArray(_) => "REAL array tag or 0".to_owned(),
        Kind::Structure(name) => format!("{name} tag"),
        Kind::StructureOrNone(name) => format!("{name} tag or 0"),
    }
}

/// The legal values of an operand, in words.
pub fn operand_values(instruction: &Instruction, operand: &Operand) -> String {
    let values = match &operand.kind {
        Kind::Target(Object::CoordinateSystem) if instruction.axes != Axes::ANY => {
            format!("{} to {} axes", instruction.axes.least, instruction.axes.most)
        }
        Kind::Word(words) => word_list(words),
        Kind::Number(range) | Kind::Integer(range) => range_text(instruction, *range),
        Kind::Array(ArrayRule::PerAxis) => "an element for each axis".to_owned(),
        Kind::Array(ArrayRule::PerAxisUnless { operand, value }) => {
            format!(
                "an element for each axis; one if {}",
                condition(instruction, *operand, *value)
            )
        }
        Kind::Array(ArrayRule::AtLeast(least)) => format!("{least} elements or more"),
        _ => String::new(),
    };
    match operand.condition {
        Condition::Always => values,
        Condition::Changed(flag) => format!("{values}, if {}", condition(instruction, flag, NoYes::Yes as i32)),
        Condition::When { operand, value } => {
            format!("{values}, if {}", condition(instruction, operand, value))
        }
    }
}

fn instruction(page: &mut String, instruction: &Instruction) {
    let bits: Vec<_> = instruction.bits.iter().map(|flag| flag.name()).collect();
    let (class, service) = instruction.service();
    let _ = write!(
        page,
        "\n### {}: {}\n\n{} {} class; bits {}. Service {service:#04x} of class {class:#06x}.\n\n`{}`\n\n\
         | # | Operand | Type | Values | First | Notes |\n|---|---|---|---|---|---|\n",
        instruction.mnemonic,
        instruction.title,
        instruction.summary,
        match instruction.timing {
            crate::Timing::Immediate => "Immediate",
            crate::Timing::Message => "Message",
            crate::Timing::Process => "Process",
            crate::Timing::MessageProcess => "Message-process",
        },
        bits.join(" "),
        syntax(instruction),
    );
    for (place, operand) in instruction.operands.iter().enumerate() {
        let first = match operand.kind {
            Kind::Word(_) | Kind::Number(_) | Kind::Integer(_) => operand.initial.to_string(),
            _ => String::new(),
        };
        let row = [
            place.to_string(),
            operand.name.to_owned(),
            operand_type(&operand.kind),
            operand_values(instruction, operand),
            first,
            operand.note.to_owned(),
        ];
        let _ = writeln!(page, "| {} |", row.join(" | "));
    }
}

fn word_list(words: &Words) -> String {
    let list: Vec<_> = words
        .words
        .iter()
        .map(|word| format!("{} {}", word.value, word.title))
        .collect();
    list.join(", ")
}

fn range_text(instruction: &Instruction, range: Range) -> String {
    match range {
        Range::Any => "any".to_owned(),
        Range::NotNegative => "0 or more".to_owned(),
        Range::Positive => "more than 0".to_owned(),
        Range::Between(low, high) if low == high => format!("{low}"),
        Range::Between(low, high) => format!("{low} to {high}"),
        Range::Jerk { units } => {
            let name = instruction
                .operands
                .get(usize::from(units))
                .map_or("units", |operand| operand.name);
            format!("more than 0; at most 100 if {name} is % of Time")
        }
    }
}

fn condition(instruction: &Instruction, operand: u8, value: i32) -> String {
    let Some(operand) = instruction.operands.get(usize::from(operand)) else {
        return String::new();
    };
    let word = match &operand.kind {
        Kind::Word(words) => words.word(value).map(|word| word.title.to_owned()),
        _ => None,
    };
    format!("{} is {}", operand.name, word.unwrap_or_else(|| value.to_string()))
}

const FAULTS_HEAD: &str = "# Faults of an axis

Written by a test from the catalogue; do not edit. The word of a fault is its key in `exception_actions` of an axis in the
configuration and its name for `arcline fault`; the bit is its bit in the tag `FaultInject`.

| fault | bit | shows as | default action | meaning |
|---|---|---|---|---|
";

const FAULTS_TAIL: &str = "
A fault of MotionFaultStatus sets AxisFault.MotionFault (bit 4), one of CIPAxisFaults AxisFault.PhysicalAxisFault (bit 0). A
virtual axis has only faults of soft travel and of command limits, as PhysicalAxisFault. In COORDINATE_SYSTEM both show as PhysicalAxisFault and as the
axis's bit of PhysicalAxesFaulted, in MOTION_GROUP as PhysicalAxisFault. A fault whose action stops the axis ends the coordinated
motion that the axis takes part in: IP of its instructions clears without PC, the queue is emptied, and the other axes decelerate
each by itself. Until it is cleared, instructions that would move the axis err with 20.

## Clearing

MAFR clears the faults of an axis (a faulted axis is then Stopped: MSO), MASR, MCSR and MGSR clear them and leave shutdown. A cause
that is still there faults again at the next update; MCSR then errs with 20 and the axis's index, MGSR with 81.

## Soft travel

Limits hold for a homed axis. An axis that passes a limit has a fault, and so has one that moves further out beyond a limit. An axis that stands
beyond a limit or moves back has none. Beyond one whose action stops the axis, an instruction that would move it further out errs with 9.

## Injection

An injected cause is there until it is taken away.

- Tag `FaultInject`: DINT, an element for each axis in the order of the configuration, a bit for each cause that is there. In a
  program too: `FaultInject[0] := 16;`.
- Attribute 9 of the axis (class 0x0301): the same element, UDINT, can be set. Attribute 10: the bits that the axis can have.
- `arcline fault inject AXIS KIND`, `arcline fault list`, and `arcline fault clear AXIS [KIND]`, which takes causes away, executes
  MAFR, and waits for an axis that still brakes.
";

#[cfg(test)]
mod tests {
    #[test]
    fn reference_pages_are_new() {
        let docs = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs");
        for (name, page) in [
            ("INSTRUCTIONS.md", super::instructions()),
            ("ERRORS.md", super::errors()),
            ("FAULTS.md", super::faults()),
        ] {
            let path = docs.join(name);
            if std::env::var_os("UPDATE_EXPECT").is_some() {
                std::fs::write(&path, &page).expect("docs/ can be written");
            }
            let written = std::fs::read_to_string(&path).unwrap_or_default();
            assert!(written == page, "docs/{name} is old: run the test with UPDATE_EXPECT=1");
        }
    }
}
