//! What moves the machine: instructions, stops and overrides, each with the right that it needs. Jogs are `jog`'s.

use std::collections::VecDeque;
use std::sync::atomic::Ordering;
use std::sync::{Arc, PoisonError};

use arcline_controller::image::Image;
use arcline_instruction_set::{Directory as _, Flag, Given, Mnemonic, Object};
use arcline_structured_text::{Answer, BoundCall, Interpreter, ObjectAttribute, Program, Request, unmade_control};
use arcline_tag::{TagPath, Value};

use super::Shared;
use super::protocol::{Done, Executed, Refusal};
use super::rights::{Held, Thing, ViewerId};
use crate::guard::VIEWERS;
use crate::names::ImageNames;
use crate::plant::Owner;

/// The longest text that is read by the threads that others share, bytes.
const SHORT: usize = 1024;
/// Instructions of which it is known who executed them.
const ORIGINS: usize = 4096;

/// Who executed what, by the instance of class 0x0303.
#[derive(Debug, Default)]
pub(super) struct Origins(VecDeque<(u32, Origin)>);

/// Who executed an instruction, and as what.
#[derive(Clone, Debug)]
pub(super) struct Origin {
    pub(super) viewer: String,
    pub(super) text: Option<String>,
}

impl Origins {
    fn note(&mut self, instance: u32, origin: Origin) {
        if self.0.len() == ORIGINS {
            self.0.pop_front();
        }
        self.0.push_back((instance, origin));
    }

    pub(super) fn of(&self, instance: u32) -> Option<&Origin> {
        let newest = self.0.iter().rev();
        newest
            .clone()
            .find(|(known, _)| *known == instance)
            .map(|(_, origin)| origin)
    }
}

/// An instruction that was accepted.
#[derive(Clone, Copy, Debug)]
pub(super) struct Accepted {
    pub(super) mnemonic: Mnemonic,
    pub(super) instance: u32,
}

impl Shared {
    /// Whether a viewer may drive something.
    pub(super) fn check_right(&self, viewer: ViewerId, thing: Thing) -> Result<(), Refusal> {
        let machine = self.plant.machine();
        let name = thing.name(machine);
        self.rights().check(machine, viewer, thing).map_err(|held| match held {
            Some(Held { by, .. }) => Refusal::control(name, Some(&by)),
            None => Refusal::control(name, None),
        })
    }

    /// What runs one instruction given as Structured Text, its names checked against the tags.
    pub(super) fn interpreter_of(&self, text: &str) -> Result<Interpreter, Refusal> {
        self.checked_call(text).map(Interpreter::new)
    }

    /// One call given as Structured Text, its names checked against the tags.
    pub(super) fn checked_call(&self, text: &str) -> Result<Program, Refusal> {
        let mut program = Program::parse_call(text).map_err(|error| Refusal::syntax(&error))?;
        self.plant
            .with_image(|image| program.check(&ImageNames(image)))
            .map_err(|error| Refusal::syntax(&error))?;
        Ok(program)
    }

    /// Executes one instruction given as Structured Text.
    pub(super) async fn execute(self: &Arc<Self>, viewer: ViewerId, text: &str) -> Result<Executed, Refusal> {
        let parsed = text.to_owned();
        let mut interpreter = self
            .compute_if(text.len() > SHORT, move |shared| shared.interpreter_of(&parsed))
            .await??;
        let mut answer = Answer::Start;
        loop {
            let request = interpreter
                .resume(answer)
                .map_err(|error| Refusal::new(error.to_string()))?;
            answer = match request {
                Request::Call(call) => {
                    let accepted = self.call(viewer, &call, Some(text)).await?;
                    return Ok(Executed {
                        instruction: accepted.mnemonic.name(),
                        instance: accepted.instance,
                    });
                }
                Request::Read(path) => Answer::Value(self.read_value(&path)?),
                Request::ReadArray(path) => Answer::Array(self.read_numbers(&path)?),
                Request::GetAttribute(of) => Answer::Value(Value::Lreal(self.attribute(&of)?)),
                Request::SetAttribute(..)
                | Request::Write(..)
                | Request::NextTick
                | Request::Delay(_)
                | Request::End => {
                    return Err(Refusal::new("not an instruction"));
                }
            };
        }
    }

    /// Executes a call that a viewer may make.
    pub(super) async fn call(
        &self,
        viewer: ViewerId,
        call: &BoundCall,
        text: Option<&str>,
    ) -> Result<Accepted, Refusal> {
        self.call_on(viewer, 0, call, text).await
    }

    /// The same on a connection of the viewer, by which it owns what it begins.
    pub(super) async fn call_on(
        &self,
        viewer: ViewerId,
        connection: u32,
        call: &BoundCall,
        text: Option<&str>,
    ) -> Result<Accepted, Refusal> {
        let mnemonic = call.mnemonic;
        let object = mnemonic.instruction().object;
        let target = self.plant.with_image(|image| image.object(object, &call.target));
        if let Some(place) = target.filter(|_| !stops(mnemonic)) {
            self.check_right(viewer, Thing::of(object, place))?;
        }
        // Other objects that it moves or whose motion it reads: only systems can be moved by it.
        for name in call.given.iter().filter_map(name_of) {
            let other = self.plant.with_image(|image| referenced(image, mnemonic, name));
            if let Some(place) = other.filter(|_| !stops(mnemonic)) {
                self.check_right(viewer, Thing::System(place))?;
            }
        }
        let origin = Origin {
            viewer: self.rights().name(viewer).to_owned(),
            text: text.map(str::to_owned),
        };
        let owner = Owner {
            session: VIEWERS | viewer,
            connection,
        };
        let executed = self
            .plant
            .call_told(
                owner,
                mnemonic,
                target,
                call.control.as_deref(),
                &call.given,
                |instance| {
                    self.origins().note(instance, origin);
                },
            )
            .await
            .map_err(|refused| Refusal::call(&refused, mnemonic))?;
        if executed.control.has(Flag::Er) {
            return Err(Refusal::motion(executed.control.err, executed.control.exerr, mnemonic));
        }
        Ok(Accepted {
            mnemonic,
            instance: executed.instance,
        })
    }

    pub(super) fn read_value(&self, path: &TagPath) -> Result<Value, Refusal> {
        let value = self.plant.with_image(|image| match image.read(path) {
            Err(error) => unmade_control(path)
                .filter(|_| path.tag().is_some_and(|tag| image.find(tag).is_none()))
                .ok_or(error),
            value => value,
        });
        value.map_err(|error| Refusal::new(error.to_string()))
    }

    pub(super) fn read_numbers(&self, path: &TagPath) -> Result<Vec<f64>, Refusal> {
        let numbers = self.plant.with_image(|image| image.read_numbers(path));
        numbers.map_err(|error| Refusal::new(error.to_string()))
    }

    /// Stops one object, or everything. Anybody may.
    pub(super) async fn stop(&self, viewer: ViewerId, object: Option<&str>) -> Result<Done, Refusal> {
        let machine = self.plant.machine();
        let Some(name) = object else {
            self.stop_everything();
            return Ok(Done {});
        };
        self.program.end();
        let mnemonic = match Thing::find(machine, name) {
            Some(Thing::Axis(_)) => Mnemonic::Mas,
            Some(Thing::System(_)) => Mnemonic::Mcs,
            Some(Thing::Group) => Mnemonic::Mgs,
            None => return Err(no_object(name)),
        };
        self.call(viewer, &instruction(mnemonic, name, &[]), None).await?;
        Ok(Done {})
    }

    /// Stops everything, now: neither a lock nor the work of others is ahead of it. What was asked before is not begun after it.
    pub(super) fn stop_everything(&self) {
        self.stops.fetch_add(1, Ordering::AcqRel);
        self.plant.stop_all();
        self.program.end();
        // Of the program, one more instruction may have been on its way.
        self.plant.stop_all();
    }

    /// Sets the override of a coordinate system, percent.
    pub(super) async fn set_override(&self, viewer: ViewerId, system: &str, percent: f64) -> Result<Done, Refusal> {
        let place = self.system(system)?;
        self.check_right(viewer, Thing::System(place))?;
        self.write_override(place, percent as f32).await
    }

    /// The value of an attribute that GSV names.
    pub(super) fn attribute(&self, of: &ObjectAttribute) -> Result<f64, Refusal> {
        let machine = self.plant.machine();
        let value = self.plant.with_image(|image| {
            let index = image.object(of.attribute.object, &of.name)?;
            image.attribute(machine, of.attribute, index)
        });
        value.ok_or_else(|| no_object(&of.name))
    }

    /// Sets an attribute that SSV names.
    pub(super) async fn set_attribute(
        &self,
        viewer: ViewerId,
        of: &ObjectAttribute,
        value: f64,
    ) -> Result<(), Refusal> {
        let object = of.attribute.object;
        let index = self.plant.with_image(|image| image.object(object, &of.name));
        let index = index.ok_or_else(|| no_object(&of.name))?;
        self.check_right(viewer, Thing::of(object, index))?;
        let (done, written) = self.plant.write(|image, edges| {
            edges.push(image.set_attribute(of.attribute, index, value)?);
            Ok::<_, arcline_controller::image::WriteError>(())
        });
        let kept = self.plant.fire(written).await;
        done.map_err(|error| Refusal::new(error.to_string()))?;
        kept.map_err(|error| Refusal::new(error.to_string()))
    }

    /// Holds a coordinate system. Anybody may.
    pub(super) async fn hold(&self, system: &str) -> Result<Done, Refusal> {
        let place = self.system(system)?;
        self.write_override(place, 0.0).await
    }

    /// Goes on after a hold.
    pub(super) async fn resume(&self, viewer: ViewerId, system: &str) -> Result<Done, Refusal> {
        let place = self.system(system)?;
        self.check_right(viewer, Thing::System(place))?;
        let before = self.plant.with_image(|image| image.feed_override_before_hold(place));
        self.write_override(place, before.unwrap_or(100.0)).await
    }

    async fn write_override(&self, system: u16, percent: f32) -> Result<Done, Refusal> {
        let (done, written) = self.plant.write(|image, edges| {
            let edge = image.set_feed_override(system, percent)?;
            edges.extend(edge);
            Ok::<_, arcline_controller::image::WriteError>(())
        });
        let kept = self.plant.fire(written).await;
        done.map_err(|error| Refusal::new(error.to_string()))?;
        kept.map_err(|error| Refusal::new(error.to_string()))?;
        Ok(Done {})
    }

    pub(super) fn axis(&self, name: &str) -> Result<u16, Refusal> {
        self.plant.machine().axis(name).ok_or_else(|| no_object(name))
    }

    fn system(&self, name: &str) -> Result<u16, Refusal> {
        self.plant.machine().system(name).ok_or_else(|| no_object(name))
    }

    pub(super) fn origins(&self) -> std::sync::MutexGuard<'_, Origins> {
        self.origins.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Stops are everyone's.
fn stops(mnemonic: Mnemonic) -> bool {
    matches!(mnemonic, Mnemonic::Mcs | Mnemonic::Mas | Mnemonic::Mgs)
}

/// A call of an instruction on an object, by the names of operands that are not at their omitted value.
pub(super) fn instruction(mnemonic: Mnemonic, target: &str, operands: &[(&str, f64)]) -> BoundCall {
    let instruction = mnemonic.instruction();
    let value = |place: usize| {
        let name = instruction.operands[place].name;
        let given = operands.iter().find(|(operand, _)| *operand == name);
        given.map_or(Given::Missing, |(_, value)| Given::Number(*value))
    };
    BoundCall {
        mnemonic,
        target: target.to_owned(),
        control: None,
        given: instruction.given_operands().map(value).collect(),
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

fn name_of(given: &Given) -> Option<&str> {
    match given {
        Given::Name(name) | Given::Word(name) => Some(name),
        _ => None,
    }
}

/// A coordinate system that an instruction moves besides its own.
fn referenced(image: &Image, mnemonic: Mnemonic, name: &str) -> Option<u16> {
    let moves = matches!(mnemonic, Mnemonic::Mct | Mnemonic::Mcto);
    moves.then(|| image.object(Object::CoordinateSystem, name)).flatten()
}

fn no_object(name: &str) -> Refusal {
    let name: String = name.chars().take(60).collect();
    Refusal::new(format!("there is no axis, coordinate system or group {name:?}"))
}
