//! The way from a filled form to its line of Structured Text.

use arcline_instruction_set::{BindError, Instruction, Kind, Mnemonic, MotionError, Object, Operand, bind};
use arcline_structured_text::EvaluatedCall;
use serde_json::{Map, Value};

use super::drive::{first_call, interpreter_of};
use super::protocol::{CallLine, Refusal};
use crate::plant::Plant;

/// Makes the line of a filled form and checks it as far as possible without an execution. An operand that the form leaves out has its
/// first value; the line omits optional values at its end.
pub(super) fn line(plant: &Plant, mnemonic: &str, values: &Map<String, Value>) -> Result<CallLine, Refusal> {
    let mnemonic: Mnemonic = mnemonic
        .parse()
        .map_err(|_| Refusal::new(format!("there is no instruction {mnemonic:?}")))?;
    let instruction = mnemonic.instruction();
    if let Some(name) = values.keys().find(|name| instruction.operand(name).is_none()) {
        return Err(Refusal::new(format!("{mnemonic} has no operand {name:?}")));
    }
    let mut operands = Vec::with_capacity(instruction.operands.len());
    let mut needed = 0;
    for operand in instruction.operands {
        let given = values
            .iter()
            .find(|(name, _)| name.eq_ignore_ascii_case(&operand.member()))
            .map(|(_, value)| value)
            .filter(|value| !value.is_null());
        let OperandText { text, may_be_left_out } = write(instruction, operand, given).map_err(|text| Refusal {
            member: Some(operand.member().into()),
            ..Refusal::new(text)
        })?;
        operands.push(text);
        if !may_be_left_out {
            needed = operands.len();
        }
    }
    operands.truncate(needed);
    let text = format!("{mnemonic}({});", operands.join(", "));
    verify(plant, &text)?;
    Ok(CallLine { text })
}

/// Checks the names, types and ranges of a line.
fn verify(plant: &Plant, text: &str) -> Result<(), Refusal> {
    let mut interpreter = interpreter_of(plant, text)?;
    match first_call(plant, &mut interpreter)? {
        Some(call) => verify_call(plant, &call),
        None => Ok(()),
    }
}

fn verify_call(plant: &Plant, call: &EvaluatedCall) -> Result<(), Refusal> {
    let mnemonic = call.mnemonic;
    let instruction = mnemonic.instruction();
    let target =
        plant.with_image(|image| arcline_instruction_set::Directory::object(image, instruction.object, &call.target));
    let bound = plant
        .with_image(|image| bind(mnemonic, target, arcline_controller::UNNAMED, &call.operands, image))
        .map_err(|error| not_bound(&error, mnemonic))?;
    let systems = &plant.machine().systems;
    let axes = match (instruction.object, target) {
        (Object::CoordinateSystem, Some(place)) => systems
            .get(usize::from(place))
            .map_or(0, |system| system.linear().len()),
        _ => 1,
    };
    instruction.verify(&bound, axes).map_err(|operand| {
        let error = MotionError::ParameterOutOfRange(operand);
        Refusal::motion(error.err(), error.exerr(), mnemonic)
    })
}

fn not_bound(error: &BindError, mnemonic: Mnemonic) -> Refusal {
    Refusal::call(&crate::plant::CallRefused::Bind(error.clone()), mnemonic)
}

/// An operand as it stands in a line.
struct OperandText {
    text: String,
    /// The text is the value of an omitted operand.
    may_be_left_out: bool,
}

fn write(instruction: &Instruction, operand: &Operand, given: Option<&Value>) -> Result<OperandText, String> {
    let needed = |text: String| OperandText {
        text,
        may_be_left_out: false,
    };
    match (&operand.kind, given) {
        (Kind::MotionControl, None) => Ok(needed(format!("HMI_{}", instruction.mnemonic))),
        (Kind::Target(_) | Kind::MotionControl | Kind::Object(_) | Kind::Structure(_), Some(Value::String(name)))
            if !name.trim().is_empty() =>
        {
            Ok(needed(name.trim().to_owned()))
        }
        (Kind::Target(_) | Kind::MotionControl | Kind::Object(_) | Kind::Structure(_), _) => {
            Err("expected a name".to_owned())
        }
        (Kind::Word(words), given) => {
            let value = match given {
                None => Some(operand.initial as i32),
                Some(Value::Number(number)) => number.as_i64().and_then(|number| i32::try_from(number).ok()),
                Some(Value::String(text)) => words.parse_word(text),
                Some(_) => None,
            };
            let word = value.and_then(|value| words.word(value));
            let word = word.ok_or_else(|| format!("expected one of {}", words.choices()))?;
            Ok(OperandText {
                text: word.keyword(),
                may_be_left_out: f64::from(word.value) == Operand::OMITTED,
            })
        }
        (Kind::Number(_) | Kind::Integer(_), given) => {
            let text = match given {
                None => operand.initial.to_string(),
                Some(value) => number(value)?,
            };
            Ok(OperandText {
                may_be_left_out: text.parse() == Ok(Operand::OMITTED),
                text,
            })
        }
        (Kind::Array(_), given) => Ok(needed(array(given)?.ok_or("expected numbers")?)),
        (Kind::ArrayOrNone, given) => Ok(or_none(array(given)?)),
        (Kind::WrittenArray(_) | Kind::StructureOrNone(_), given) => match given {
            None => Ok(or_none(None)),
            Some(Value::String(name)) => Ok(or_none(Some(name.trim().to_owned()).filter(|name| !name.is_empty()))),
            Some(Value::Number(zero)) if zero.as_f64() == Some(0.0) => Ok(or_none(None)),
            Some(Value::Array(none)) if none.is_empty() => Ok(or_none(None)),
            Some(_) => Err("expected the name of a tag, or 0".to_owned()),
        },
    }
}

fn or_none(text: Option<String>) -> OperandText {
    OperandText {
        may_be_left_out: text.is_none(),
        text: text.unwrap_or_else(|| "0".to_owned()),
    }
}

/// The text of a number, or of a tag or an expression in place of a number.
fn number(value: &Value) -> Result<String, String> {
    match value {
        Value::Number(number) => Ok(number.as_f64().unwrap_or_default().to_string()),
        Value::String(text) if !text.trim().is_empty() => Ok(text.trim().to_owned()),
        _ => Err("expected a number".to_owned()),
    }
}

/// `[a, b]`, or the name of a tag; `None`: nothing was given.
fn array(given: Option<&Value>) -> Result<Option<String>, String> {
    match given {
        None => Ok(None),
        Some(Value::Array(values)) if values.is_empty() => Ok(None),
        Some(Value::Array(values)) => {
            let numbers: Vec<String> = values.iter().map(number).collect::<Result<_, _>>()?;
            Ok(Some(format!("[{}]", numbers.join(", "))))
        }
        Some(value) => number(value).map(Some),
    }
}
