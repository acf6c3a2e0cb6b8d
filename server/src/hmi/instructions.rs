//! `/api/instructions`: the catalogue as JSON, for forms that are made from it and nothing else.

use arcline_instruction_set::{
    ArrayRule, ERRORS, ErrorText, FAULTS, Instruction, Kind, Mnemonic, Operand, Range, TargetDialog, Unit, Words,
};
use serde::Serialize;

/// Every instruction, error and fault.
#[derive(Serialize, Debug)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(super) struct Catalogue {
    /// Every instruction.
    instructions: Vec<InstructionForm>,
    /// Every motion error.
    errors: Vec<ErrorMeaning>,
    /// Every fault of an axis.
    faults: Vec<FaultMeaning>,
}

/// A motion error.
#[derive(Serialize, Debug)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
struct ErrorMeaning {
    /// ERR.
    err: i16,
    /// Name.
    name: &'static str,
    /// Meaning of EXERR.
    extended: &'static str,
    /// Its usual cause.
    cause: &'static str,
    /// Its remedy.
    remedy: &'static str,
}

/// A fault of an axis.
#[derive(Serialize, Debug)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
struct FaultMeaning {
    /// Its word in `faults` of an axis.
    word: &'static str,
    /// Its cause.
    meaning: &'static str,
}

/// An instruction and its form.
#[derive(Serialize, Debug)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
struct InstructionForm {
    /// Mnemonic.
    mnemonic: &'static str,
    /// Full name.
    title: &'static str,
    /// A description, as a sentence.
    summary: &'static str,
    /// Kind of its object: `Axis`, `CoordinateSystem` or `MotionGroup`.
    object: &'static str,
    /// Its operands in the order of the faceplate.
    operands: Vec<OperandForm>,
    /// Its target position dialog.
    target_position: Option<DialogForm>,
}

/// An operand of a form.
#[derive(Serialize, Debug)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
struct OperandForm {
    /// Name on the faceplate.
    name: &'static str,
    /// Member of an instruction tag, and key in `operands` of `line`.
    member: String,
    /// Kind.
    kind: OperandKind,
    /// Unit of its numbers.
    unit: Option<UnitForm>,
    /// Conditions under which the operand has an effect; null: always.
    shown_when: Option<Vec<OperandCondition>>,
    /// First value.
    default: FirstValue,
    /// A note.
    help: &'static str,
    /// Kind of the object that it names.
    #[serde(skip_serializing_if = "Option::is_none")]
    object: Option<&'static str>,
    /// Type of the structure that it names.
    #[serde(rename = "type", skip_serializing_if = "Option::is_none")]
    structure: Option<&'static str>,
    /// Words of an enumeration.
    #[serde(skip_serializing_if = "Option::is_none")]
    words: Option<Vec<WordForm>>,
    /// Range of a number; null or absent: every finite number.
    #[serde(skip_serializing_if = "Option::is_none")]
    range: Option<RangeForm>,
    /// Elements of an array.
    #[serde(skip_serializing_if = "Option::is_none")]
    elements: Option<Elements>,
    /// Condition under which one element is enough.
    #[serde(skip_serializing_if = "Option::is_none")]
    single_when: Option<OperandCondition>,
}

/// Kind of an operand.
#[derive(Serialize, Debug)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
enum OperandKind {
    /// The object that the instruction acts on.
    Target,
    /// A motion control tag.
    Control,
    /// Another object.
    Reference,
    /// A word of an enumeration.
    Word,
    /// A number.
    Number,
    /// A whole number.
    Integer,
    /// An array of numbers.
    Array,
    /// An array of numbers, or 0.
    ArrayOrNone,
    /// An array that the instruction writes, or 0.
    WrittenArray,
    /// A structure.
    Structure,
    /// A structure, or 0.
    StructureOrNone,
}

/// The unit of an operand.
#[derive(Serialize, Debug)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(untagged)]
enum UnitForm {
    /// The unit that another operand selects.
    Operand {
        /// Member of that operand.
        member: Option<String>,
    },
    /// A fixed unit.
    Text {
        /// The unit; `position` stands for position units.
        text: &'static str,
    },
}

/// The condition that an operand has one of these values.
#[derive(Serialize, Debug)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
struct OperandCondition {
    /// Member of the operand.
    member: Option<String>,
    /// Its values.
    #[serde(rename = "in")]
    values: Vec<i32>,
}

/// The first value of an operand.
#[derive(Serialize, Debug)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(untagged)]
enum FirstValue {
    /// A number or the value of a word.
    Number(f32),
    /// No elements.
    Elements([f32; 0]),
}

/// A word of an enumeration.
#[derive(Serialize, Debug)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
struct WordForm {
    /// The word in Structured Text.
    text: String,
    /// Its number.
    value: i32,
    /// The word on a faceplate.
    title: &'static str,
}

/// A range of numbers.
#[derive(Serialize, Debug)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
struct RangeForm {
    /// Least value.
    min: f64,
    /// Whether the least value itself is outside of the range.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    min_exclusive: bool,
    /// Greatest value; null: none.
    max: Option<f64>,
    /// A greatest value that holds under a condition.
    #[serde(skip_serializing_if = "Option::is_none")]
    max_when: Option<ConditionalMaximum>,
}

/// A greatest value that holds under a condition.
#[derive(Serialize, Debug)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
struct ConditionalMaximum {
    /// The condition.
    #[serde(flatten)]
    when: OperandCondition,
    /// Greatest value.
    max: f64,
}

/// The number of elements of an array.
#[derive(Serialize, Debug)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
enum Elements {
    /// One for each axis of the coordinate system.
    PerAxis,
    /// At least this number.
    AtLeast(u8),
}

/// A target position dialog.
#[derive(Serialize, Debug)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
struct DialogForm {
    /// Member of the end points.
    targets: &'static str,
    /// Member of the vias.
    vias: Option<&'static str>,
    /// Member of the move type.
    move_type: &'static str,
    /// Member of the circle type.
    circle_type: Option<&'static str>,
    /// Its headings for each combination of move type and circle type.
    rows: Vec<DialogRow>,
}

/// The headings of a target position dialog for a move type and circle type.
#[derive(Serialize, Debug)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
struct DialogRow {
    /// Value of Move Type.
    move_type: i32,
    /// Value of Circle Type.
    circle_type: Option<i32>,
    /// Heading of the end points.
    target: &'static str,
    /// Heading of the vias, centres or the radius.
    via: Option<&'static str>,
    /// Whether the dialog offers "Set Targets = Actuals".
    targets_from_actuals: bool,
    /// Whether the dialog offers "Set Vias = Actuals".
    vias_from_actuals: bool,
}

/// The whole catalogue.
pub(super) fn catalogue() -> Catalogue {
    let instructions = Mnemonic::ALL.iter().map(|mnemonic| instruction(mnemonic.instruction()));
    let faults = FAULTS.iter().map(|fault| FaultMeaning {
        word: fault.word,
        meaning: fault.meaning,
    });
    Catalogue {
        instructions: instructions.collect(),
        errors: ERRORS.iter().map(error).collect(),
        faults: faults.collect(),
    }
}

fn error(row: &ErrorText) -> ErrorMeaning {
    ErrorMeaning {
        err: row.err,
        name: row.name,
        extended: row.extended.meaning(),
        cause: row.cause,
        remedy: row.remedy,
    }
}

fn instruction(instruction: &'static Instruction) -> InstructionForm {
    let operands = (0..).zip(instruction.operands);
    InstructionForm {
        mnemonic: instruction.mnemonic.name(),
        title: instruction.title,
        summary: instruction.summary,
        object: instruction.object.member(),
        operands: operands
            .map(|(index, shown)| operand(instruction, index, shown))
            .collect(),
        target_position: instruction.target_dialog().map(dialog),
    }
}

fn operand(instruction: &Instruction, index: usize, operand: &'static Operand) -> OperandForm {
    let member = |index: usize| instruction.operands.get(index).map(Operand::member);
    let shown = instruction.shown_when(index).map(|(other, value)| OperandCondition {
        member: member(other),
        values: vec![value],
    });
    let mut form = OperandForm {
        name: operand.name,
        member: operand.member(),
        kind: kind(&operand.kind),
        unit: match instruction.unit(index) {
            Unit::Operand(units) => Some(UnitForm::Operand { member: member(units) }),
            Unit::Position => Some(UnitForm::Text { text: "position" }),
            Unit::Master => Some(UnitForm::Text { text: "master units" }),
            Unit::Degrees => Some(UnitForm::Text { text: "deg" }),
            Unit::None => None,
        },
        shown_when: shown.map(|shown| vec![shown]),
        default: FirstValue::Number(operand.initial),
        help: operand.note,
        object: None,
        structure: None,
        words: None,
        range: None,
        elements: None,
        single_when: None,
    };
    match &operand.kind {
        Kind::Target(object) | Kind::Object(object) => form.object = Some(object.member()),
        Kind::Structure(name) | Kind::StructureOrNone(name) => form.structure = Some(name),
        Kind::Word(words) => form.words = Some(choices(words)),
        Kind::Number(limits) | Kind::Integer(limits) => form.range = range(instruction, *limits),
        Kind::Array(rule) => {
            form.default = FirstValue::Elements([]);
            form.elements = Some(match rule {
                ArrayRule::PerAxis | ArrayRule::PerAxisUnless { .. } => Elements::PerAxis,
                ArrayRule::AtLeast(least) => Elements::AtLeast(*least),
            });
            if let ArrayRule::PerAxisUnless { operand, value } = rule {
                form.single_when = Some(OperandCondition {
                    member: member(usize::from(*operand)),
                    values: vec![*value],
                });
            }
        }
        Kind::ArrayOrNone => form.default = FirstValue::Elements([]),
        Kind::MotionControl | Kind::WrittenArray(_) => {}
    }
    form
}

fn kind(kind: &Kind) -> OperandKind {
    match kind {
        Kind::Target(_) => OperandKind::Target,
        Kind::MotionControl => OperandKind::Control,
        Kind::Object(_) => OperandKind::Reference,
        Kind::Word(_) => OperandKind::Word,
        Kind::Number(_) => OperandKind::Number,
        Kind::Integer(_) => OperandKind::Integer,
        Kind::Array(_) => OperandKind::Array,
        Kind::ArrayOrNone => OperandKind::ArrayOrNone,
        Kind::WrittenArray(_) => OperandKind::WrittenArray,
        Kind::Structure(_) => OperandKind::Structure,
        Kind::StructureOrNone(_) => OperandKind::StructureOrNone,
    }
}

fn choices(words: &Words) -> Vec<WordForm> {
    let words = words.words.iter().map(|word| WordForm {
        text: word.keyword(),
        value: word.value,
        title: word.title,
    });
    words.collect()
}

fn range(instruction: &Instruction, range: Range) -> Option<RangeForm> {
    let above = |min_exclusive, max_when| RangeForm {
        min: 0.0,
        min_exclusive,
        max: None,
        max_when,
    };
    match range {
        Range::Any => None,
        Range::NotNegative => Some(above(false, None)),
        Range::Positive => Some(above(true, None)),
        Range::Between(min, max) => Some(RangeForm {
            min,
            max: Some(max),
            ..above(false, None)
        }),
        Range::Jerk { units } => {
            let when = OperandCondition {
                member: instruction.operands.get(usize::from(units)).map(Operand::member),
                values: Range::PERCENT_OF_TIME.to_vec(),
            };
            Some(above(true, Some(ConditionalMaximum { when, max: 100.0 })))
        }
    }
}

fn dialog(dialog: &TargetDialog) -> DialogForm {
    let rows = dialog.rows.iter().map(|row| DialogRow {
        move_type: row.move_type as i32,
        circle_type: row.circle_type.map(|circle| circle as i32),
        target: row.target,
        via: row.via,
        targets_from_actuals: row.targets_from_actuals,
        vias_from_actuals: row.vias_from_actuals,
    });
    DialogForm {
        targets: dialog.targets,
        vias: dialog.vias,
        move_type: dialog.move_type,
        circle_type: dialog.circle_type,
        rows: rows.collect(),
    }
}
