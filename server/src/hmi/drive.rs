//! Commands of a viewer that move the machine: instructions, stops and overrides. Jogs are in `jog`.

use std::sync::Arc;
use std::sync::atomic::Ordering;

use arcline_instruction_set::{AxisId, Directory as _, Flag, Mnemonic, SystemId, UnboundOperand};
use arcline_structured_text::{Answer, EvaluatedCall, Interpreter, ObjectAttribute, Program, Request, unmade_control};
use arcline_tag::{TagPath, Value};

use super::Shared;
use super::protocol::{Done, Executed, Refusal};
use super::workers::Workers;
use crate::plant::control::{MotionObject, ViewerId};
use crate::plant::{Call, CallRefused, Command, Outcome, Plant, Principal, Refused, Systems};
use arcline_simulation::ImageNames;

/// The longest text that is read by the threads that others share, bytes.
const SHORT: usize = 1024;
/// An instruction that was accepted.
#[derive(Clone, Copy, Debug)]
pub(super) struct Accepted {
    pub(super) mnemonic: Mnemonic,
    pub(super) instance: u32,
}

impl Shared {
    /// Stops one object, or everything. Every viewer may.
    pub(super) async fn stop(&self, viewer: ViewerId, object: Option<&str>) -> Result<Done, Refusal> {
        let machine = self.plant.machine();
        let Some(name) = object else {
            self.stop_everything();
            return Ok(Done {});
        };
        self.program.end();
        let mnemonic = match MotionObject::find(machine, name) {
            Some(MotionObject::Axis(_)) => Mnemonic::Mas,
            Some(MotionObject::System(_)) => Mnemonic::Mcs,
            Some(MotionObject::Group) => Mnemonic::Mgs,
            None => return Err(no_object(name)),
        };
        let stop = instruction(mnemonic, name, &[]);
        call(&self.plant, Principal::Viewer(viewer), &stop, None).await?;
        Ok(Done {})
    }

    /// STOP: waits for no lock and no other request. Requests that came before do not begin motion after it. Motion stays inhibited
    /// until it is released.
    pub(super) fn stop_everything(&self) {
        self.stops.fetch_add(1, Ordering::AcqRel);
        self.plant.inhibit();
        self.program.end();
    }

    /// Sets the override of a coordinate system, percent.
    pub(super) async fn set_override(&self, viewer: ViewerId, system: &str, percent: f64) -> Result<Done, Refusal> {
        let (system, percent) = (system_of(&self.plant, system)?, percent as f32);
        self.apply(Principal::Viewer(viewer), Command::SetFeedOverride { system, percent })
            .await
    }

    /// Executes a command that has no other answer than that it is done.
    pub(super) async fn apply(&self, principal: Principal, command: Command<'_>) -> Result<Done, Refusal> {
        apply(&self.plant, principal, command).await
    }

    /// Holds a coordinate system. Every viewer may.
    pub(super) async fn hold(&self, viewer: ViewerId, system: &str) -> Result<Done, Refusal> {
        let system = Systems::One(system_of(&self.plant, system)?);
        self.apply(Principal::Viewer(viewer), Command::Hold(system)).await
    }

    /// Goes on after a hold.
    pub(super) async fn resume(&self, viewer: ViewerId, system: &str) -> Result<Done, Refusal> {
        let system = Systems::One(system_of(&self.plant, system)?);
        self.apply(Principal::Viewer(viewer), Command::Resume(system)).await
    }
}

/// The interpreter of one instruction given as Structured Text, its names checked against the tags.
pub(super) fn interpreter_of(plant: &Plant, text: &str) -> Result<Interpreter, Refusal> {
    checked_call(plant, text).map(Interpreter::new)
}

/// One call given as Structured Text, its names checked against the tags.
pub(super) fn checked_call(plant: &Plant, text: &str) -> Result<Program, Refusal> {
    let mut program = Program::parse_call(text).map_err(|error| Refusal::syntax(&error))?;
    plant
        .with_image(|image| program.check(&ImageNames(image)))
        .map_err(|error| Refusal::syntax(&error))?;
    Ok(program)
}

/// Executes one instruction given as Structured Text.
pub(super) async fn execute(
    plant: &Plant,
    workers: &Workers,
    viewer: ViewerId,
    text: &str,
) -> Result<Executed, Refusal> {
    let (parsed, of) = (text.to_owned(), plant.clone());
    let mut interpreter = workers
        .compute_if(text.len() > SHORT, move || interpreter_of(&of, &parsed))
        .await??;
    let bound = first_call(plant, &mut interpreter)?.ok_or_else(|| Refusal::new("not an instruction"))?;
    let accepted = call(plant, Principal::Viewer(viewer), &bound, Some(text)).await?;
    Ok(Executed {
        instruction: accepted.mnemonic.name(),
        instance: accepted.instance,
    })
}

/// The first call, with the operands as they are now; `None`: a statement in front of it does more than to read.
pub(super) fn first_call(plant: &Plant, interpreter: &mut Interpreter) -> Result<Option<EvaluatedCall>, Refusal> {
    let mut answer = Answer::Start;
    loop {
        let request = interpreter
            .resume(answer)
            .map_err(|error| Refusal::new(error.to_string()))?;
        answer = match request {
            Request::Call(call) => return Ok(Some(call)),
            Request::Read(path) => Answer::Value(read_value(plant, &path)?),
            Request::ReadArray(path) => Answer::Array(read_numbers(plant, &path)?),
            Request::GetAttribute(of) => Answer::Value(Value::Lreal(attribute(plant, &of)?)),
            Request::SetAttribute(..) | Request::Write(..) | Request::NextTick | Request::Delay(_) | Request::End => {
                return Ok(None);
            }
        };
    }
}

/// Executes a call that a viewer may make.
pub(super) async fn call(
    plant: &Plant,
    principal: Principal,
    call: &EvaluatedCall,
    text: Option<&str>,
) -> Result<Accepted, Refusal> {
    let mnemonic = call.mnemonic;
    let command = Command::Call(command_of(plant, call, text));
    let executed = match plant.apply(principal, command).await {
        Ok(Outcome::Executed(executed)) => executed,
        Ok(_) => return Err(Refusal::call(&CallRefused::NoAnswer, mnemonic)),
        Err(refused) => return Err(refusal(refused, mnemonic)),
    };
    if executed.control.has(Flag::Er) {
        return Err(Refusal::motion(executed.control.err, executed.control.exerr, mnemonic));
    }
    Ok(Accepted {
        mnemonic,
        instance: executed.instance,
    })
}

/// A call as the plant takes it; `text`: its Structured Text, for the events.
pub(super) fn command_of<'c>(plant: &Plant, call: &'c EvaluatedCall, text: Option<&str>) -> Call<'c> {
    let object = call.mnemonic.instruction().object;
    Call {
        mnemonic: call.mnemonic,
        target: plant.with_published(|image| image.object(object, &call.target)),
        control: call.control.as_deref(),
        operands: &call.operands,
        text: text.map(Arc::from),
    }
}

/// A call that was refused.
pub(super) fn refusal(refused: Refused, mnemonic: Mnemonic) -> Refusal {
    match refused {
        Refused::Call(refused) => Refusal::call(&refused, mnemonic),
        refused => refused.into(),
    }
}

pub(super) fn read_value(plant: &Plant, path: &TagPath) -> Result<Value, Refusal> {
    let value = plant.with_image(|image| match image.read(path) {
        Err(error) => unmade_control(path)
            .filter(|_| path.tag().is_some_and(|tag| image.find(tag).is_none()))
            .ok_or(error),
        value => value,
    });
    value.map_err(|error| Refusal::new(error.to_string()))
}

pub(super) fn read_numbers(plant: &Plant, path: &TagPath) -> Result<Vec<f64>, Refusal> {
    let numbers = plant.with_image(|image| image.read_numbers(path));
    numbers.map_err(|error| Refusal::new(error.to_string()))
}

/// Executes a command that has no other answer than that it is done.
async fn apply(plant: &Plant, principal: Principal, command: Command<'_>) -> Result<Done, Refusal> {
    plant.apply(principal, command).await?;
    Ok(Done {})
}

/// The value of an attribute that GSV names.
pub(super) fn attribute(plant: &Plant, of: &ObjectAttribute) -> Result<f64, Refusal> {
    let machine = plant.machine();
    let value = plant.with_image(|image| {
        let index = image.object(of.attribute.object, &of.name)?;
        image.attribute(machine, of.attribute, index)
    });
    value.ok_or_else(|| no_object(&of.name))
}

/// Sets an attribute that SSV names.
pub(super) async fn set_attribute(
    plant: &Plant,
    principal: Principal,
    of: &ObjectAttribute,
    value: f64,
) -> Result<(), Refusal> {
    let attribute = of.attribute;
    let index = plant.with_image(|image| image.object(attribute.object, &of.name));
    let index = index.ok_or_else(|| no_object(&of.name))?;
    let command = Command::SetAttribute {
        attribute,
        index,
        value,
    };
    apply(plant, principal, command).await.map(drop)
}

pub(super) fn axis_of(plant: &Plant, name: &str) -> Result<AxisId, Refusal> {
    plant.machine().axis(name).ok_or_else(|| no_object(name))
}

fn system_of(plant: &Plant, name: &str) -> Result<SystemId, Refusal> {
    plant.machine().system(name).ok_or_else(|| no_object(name))
}

/// A call of an instruction on an object, by the names of operands that are not at their omitted value.
pub(super) fn instruction(mnemonic: Mnemonic, target: &str, operands: &[(&str, f64)]) -> EvaluatedCall {
    let instruction = mnemonic.instruction();
    let value = |place: usize| {
        let name = instruction.operands[place].name;
        let given = operands.iter().find(|(operand, _)| *operand == name);
        given.map_or(UnboundOperand::Missing, |(_, value)| UnboundOperand::Number(*value))
    };
    EvaluatedCall {
        mnemonic,
        target: target.to_owned(),
        control: None,
        operands: instruction.operands_behind_control().map(value).collect(),
        line: 1,
    }
}

/// Units and number of a rate: u/s², or all that the axis has.
pub(super) fn rate(rate: Option<f64>) -> (f64, f64) {
    match rate {
        Some(rate) => (0.0, rate),
        None => (1.0, 100.0),
    }
}

pub(super) fn no_object(name: &str) -> Refusal {
    let name: String = name.chars().take(60).collect();
    Refusal::new(format!("there is no axis, coordinate system or group {name:?}"))
}
