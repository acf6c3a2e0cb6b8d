//! What moves the machine: instructions, jogs with a dead-man, stops and overrides, each with the right that it needs.

use std::collections::{BTreeMap, VecDeque};
use std::sync::{Arc, PoisonError};
use std::time::Duration;

use arcline_controller::image::Image;
use arcline_instruction_set::{Directory as _, Flag, Given, Mnemonic, Object};
use arcline_structured_text::{Answer, BoundCall, Interpreter, Program, Request, unmade_control};
use arcline_tag::{TagPath, Value};
use serde_json::{Value as Json, json};
use tokio::time::{Instant, MissedTickBehavior, interval};

use super::Shared;
use super::message::Refusal;
use super::rights::{Held, Thing, ViewerId};
use crate::names::ImageNames;

/// Without a sign of life for so long, a jog is stopped.
const KEEP_WITHIN: Duration = Duration::from_millis(150);
/// How often jogs are looked at.
const LOOK: Duration = Duration::from_millis(10);
/// Instructions of which it is known who executed them.
const ORIGINS: usize = 4096;

/// Axes that move as long as somebody holds a button, by their place.
#[derive(Debug, Default)]
pub(super) struct Jogs(BTreeMap<u16, Jog>);

#[derive(Debug)]
struct Jog {
    viewer: ViewerId,
    until: Instant,
    /// Deceleration of its stop, u/s²; `None`: the axis's own.
    decel: Option<f64>,
}

impl Jogs {
    /// Takes out what a condition holds for.
    fn drain(&mut self, condition: impl Fn(u16, &Jog) -> bool) -> BTreeMap<u16, Jog> {
        let (out, rest) = std::mem::take(&mut self.0)
            .into_iter()
            .partition(|(axis, jog)| condition(*axis, jog));
        self.0 = rest;
        out
    }
}

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
            Some(Held { by, .. }) => Refusal {
                holder: Some(by.as_str().into()),
                ..Refusal::new(format!("{by} drives {name}: take it first"))
            },
            None => Refusal::new(format!("nobody drives {name}: take it first")),
        })
    }

    /// What runs one instruction given as Structured Text, its names checked against the tags.
    pub(super) fn interpreter_of(&self, text: &str) -> Result<Interpreter, Refusal> {
        let mut program = Program::parse_call(text).map_err(|error| Refusal::syntax(&error))?;
        self.plant
            .with_image(|image| program.check(&ImageNames(image)))
            .map_err(|error| Refusal::syntax(&error))?;
        Ok(Interpreter::new(program))
    }

    /// Executes one instruction given as Structured Text.
    pub(super) async fn execute(&self, viewer: ViewerId, text: &str) -> Result<Json, Refusal> {
        let mut interpreter = self.interpreter_of(text)?;
        let mut answer = Answer::Start;
        loop {
            let request = interpreter
                .resume(answer)
                .map_err(|error| Refusal::new(error.to_string()))?;
            answer = match request {
                Request::Call(call) => {
                    let accepted = self.call(viewer, &call, Some(text)).await?;
                    return Ok(json!({
                        "instruction": accepted.mnemonic.to_string(),
                        "instance": accepted.instance,
                    }));
                }
                Request::Read(path) => Answer::Value(self.read_value(&path)?),
                Request::ReadArray(path) => Answer::Array(self.read_numbers(&path)?),
                Request::Write(..) | Request::NextTick | Request::Delay(_) | Request::End => {
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
        let executed = self
            .plant
            .call_told(mnemonic, target, call.control.as_deref(), &call.given, |instance| {
                self.origins().note(instance, origin);
            })
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

    /// Moves an axis until [`Shared::keep`] does not come any more.
    pub(super) async fn jog(
        &self,
        viewer: ViewerId,
        axis: &str,
        speed: f64,
        accel: Option<f64>,
        decel: Option<f64>,
    ) -> Result<Json, Refusal> {
        let machine = self.plant.machine();
        let place = self.axis(axis)?;
        self.check_right(viewer, Thing::Axis(place))?;
        let limit = machine.axes[usize::from(place)].max_speed;
        if !speed.is_finite() || speed.abs() > limit {
            return Err(Refusal::new(format!(
                "the speed is {speed}, expected -{limit} to {limit}"
            )));
        }
        let (accel_units, accel) = rate(accel);
        let (decel_units, decel_rate) = rate(decel);
        #[rustfmt::skip]
        let operands = [
            ("Direction", if speed < 0.0 { 1.0 } else { 0.0 }),
            ("Speed", speed.abs()), ("Speed Units", 0.0),
            ("Accel Rate", accel), ("Accel Units", accel_units),
            ("Decel Rate", decel_rate), ("Decel Units", decel_units),
            ("Profile", 0.0),
        ];
        // Watched before it moves.
        let jog = Jog {
            viewer,
            until: Instant::now() + KEEP_WITHIN,
            decel,
        };
        self.jogs().0.insert(place, jog);
        let done = self
            .call(viewer, &instruction(Mnemonic::Maj, axis, &operands), None)
            .await;
        if done.is_err() {
            self.jogs().0.remove(&place);
        }
        done.map(|_| json!({}))
    }

    /// A sign of life for a jog.
    pub(super) fn keep(&self, viewer: ViewerId, axis: &str) -> Result<Json, Refusal> {
        let place = self.axis(axis)?;
        let now = Instant::now();
        match self.jogs().0.get_mut(&place) {
            Some(jog) if jog.viewer == viewer && jog.until > now => {
                jog.until = now + KEEP_WITHIN;
                Ok(json!({}))
            }
            _ => Err(Refusal::new(format!("{axis} is not jogged by you any more"))),
        }
    }

    /// The end of a jog.
    pub(super) async fn jog_end(&self, viewer: ViewerId, axis: &str) -> Result<Json, Refusal> {
        let place = self.axis(axis)?;
        let ended = {
            let mut jogs = self.jogs();
            let own = jogs.0.get(&place).is_some_and(|jog| jog.viewer == viewer);
            if own { jogs.0.remove(&place) } else { None }
        };
        if let Some(jog) = ended {
            self.stop_jog(place, jog.decel).await;
        }
        Ok(json!({}))
    }

    /// A viewer has gone: what it jogged stops.
    pub(super) async fn leave(&self, viewer: ViewerId) {
        let gone = self.jogs().drain(|_, jog| jog.viewer == viewer);
        self.stop_jogs(gone).await;
        self.rights().leave(viewer);
    }

    /// Stops one object, or everything. Anybody may.
    pub(super) async fn stop(&self, viewer: ViewerId, object: Option<&str>) -> Result<Json, Refusal> {
        self.program.end();
        let machine = self.plant.machine();
        let Some(name) = object else {
            self.plant.stop_all();
            return Ok(json!({}));
        };
        let mnemonic = match Thing::find(machine, name) {
            Some(Thing::Axis(_)) => Mnemonic::Mas,
            Some(Thing::System(_)) => Mnemonic::Mcs,
            Some(Thing::Group) => Mnemonic::Mgs,
            None => return Err(no_object(name)),
        };
        self.call(viewer, &instruction(mnemonic, name, &[]), None).await?;
        Ok(json!({}))
    }

    /// Sets the override of a coordinate system, percent.
    pub(super) async fn set_override(&self, viewer: ViewerId, system: &str, percent: f64) -> Result<Json, Refusal> {
        let place = self.system(system)?;
        self.check_right(viewer, Thing::System(place))?;
        self.write_override(place, percent as f32).await
    }

    /// Holds a coordinate system. Anybody may.
    pub(super) async fn hold(&self, system: &str) -> Result<Json, Refusal> {
        let place = self.system(system)?;
        self.write_override(place, 0.0).await
    }

    /// Goes on after a hold.
    pub(super) async fn resume(&self, viewer: ViewerId, system: &str) -> Result<Json, Refusal> {
        let place = self.system(system)?;
        self.check_right(viewer, Thing::System(place))?;
        let before = self.plant.with_image(|image| image.feed_override_before_hold(place));
        self.write_override(place, before.unwrap_or(100.0)).await
    }

    async fn write_override(&self, system: u16, percent: f32) -> Result<Json, Refusal> {
        let (done, written) = self.plant.write(|image, edges| {
            let edge = image.set_feed_override(system, percent)?;
            edges.extend(edge);
            Ok::<_, arcline_controller::image::WriteError>(())
        });
        let kept = self.plant.fire(written).await;
        done.map_err(|error| Refusal::new(error.to_string()))?;
        kept.map_err(|error| Refusal::new(error.to_string()))?;
        Ok(json!({}))
    }

    async fn stop_jogs(&self, jogs: BTreeMap<u16, Jog>) {
        let stops = jogs.iter().map(|(axis, jog)| self.stop_jog(*axis, jog.decel));
        futures_util::future::join_all(stops).await;
    }

    async fn stop_jog(&self, axis: u16, decel: Option<f64>) {
        let machine = self.plant.machine();
        let name = Thing::Axis(axis).name(machine);
        let change = if decel.is_some() { 1.0 } else { 0.0 };
        let (units, rate) = rate(decel);
        #[rustfmt::skip]
        let operands = [
            ("Stop Type", JOG), ("Change Decel", change), ("Decel Rate", rate), ("Decel Units", units),
        ];
        let given = instruction(Mnemonic::Mas, name, &operands).given;
        let stopped = self.plant.call(Mnemonic::Mas, Some(axis), None, &given).await;
        match stopped {
            Ok(executed) if !executed.control.has(Flag::Er) => {}
            // Without motion there is nothing to stop; with a stop under way neither.
            Ok(executed) => tracing::debug!(axis = name, err = executed.control.err, "a jog was not stopped"),
            Err(error) => {
                tracing::error!(axis = name, %error, "a jog was not stopped: everything is");
                self.plant.stop_all();
            }
        }
    }

    fn axis(&self, name: &str) -> Result<u16, Refusal> {
        self.plant.machine().axis(name).ok_or_else(|| no_object(name))
    }

    fn system(&self, name: &str) -> Result<u16, Refusal> {
        self.plant.machine().system(name).ok_or_else(|| no_object(name))
    }

    fn jogs(&self) -> std::sync::MutexGuard<'_, Jogs> {
        self.jogs.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(super) fn origins(&self) -> std::sync::MutexGuard<'_, Origins> {
        self.origins.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Stops jogs that nobody keeps, and those of viewers that lost the right, until the future is dropped.
pub(super) async fn watch(shared: Arc<Shared>) {
    let mut due = interval(LOOK);
    due.set_missed_tick_behavior(MissedTickBehavior::Delay);
    loop {
        due.tick().await;
        let dead = {
            let rights = shared.rights();
            let now = Instant::now();
            let machine = shared.plant.machine();
            shared
                .jogs()
                .drain(|axis, jog| jog.until <= now || rights.check(machine, jog.viewer, Thing::Axis(axis)).is_err())
        };
        shared.stop_jogs(dead).await;
    }
}

/// Stops are everyone's.
fn stops(mnemonic: Mnemonic) -> bool {
    matches!(mnemonic, Mnemonic::Mcs | Mnemonic::Mas | Mnemonic::Mgs)
}

/// A call of an instruction on an object, by the names of operands that are not at their omitted value.
fn instruction(mnemonic: Mnemonic, target: &str, operands: &[(&str, f64)]) -> BoundCall {
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
fn rate(rate: Option<f64>) -> (f64, f64) {
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
    Refusal::new(format!("there is no {name:?} to drive"))
}

/// Stop Type of MAS: Jog.
const JOG: f64 = 1.0;
