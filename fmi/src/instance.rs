//! A machine that another simulator steps.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use arcline_controller::drive::SetPoint;
use arcline_controller::drive::simulated::{MechanicalModel, ModelFailed, ModelledAxis};
use arcline_instruction_set::AxisId;
use arcline_simulation::{Blind, End, ProgramId, RunLimits, Runner, Signal, Simulation, sample};
use arcline_structured_text::{Interpreter, Policy};
use arcline_tag::WriteValue;

use crate::description::{Description, Kind, Type};

/// A machine with its program.
#[derive(Debug)]
pub struct Instance {
    description: Description,
    runner: Runner,
    /// `None`: the initialization is not over.
    program: Option<ProgramId>,
    input_model: InputModel,
    /// Time at tick 0, s.
    start: f64,
}

/// The positions of axes from the inputs.
#[derive(Clone, Debug, Default)]
struct InputModel(Arc<Mutex<Inputs>>);

#[derive(Debug, Default)]
struct Inputs {
    /// Whether the inputs are in use.
    used: bool,
    /// Axes and positions.
    positions: Vec<(AxisId, f64)>,
}

impl InputModel {
    fn inputs(&self) -> MutexGuard<'_, Inputs> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl MechanicalModel for InputModel {
    fn tick(&mut self, _: &[SetPoint], axes: &mut [ModelledAxis]) -> Result<(), ModelFailed> {
        let inputs = self.inputs();
        for (axis, position) in inputs.positions.iter().filter(|_| inputs.used) {
            if let Some(answer) = axes.get_mut(usize::from(*axis)) {
                answer.position = *position;
            }
        }
        Ok(())
    }
}

impl Instance {
    /// A machine before its first tick.
    pub fn new(description: Description) -> Self {
        let input_model = InputModel::default();
        let mut axes = Vec::new();
        for variable in &description.variables {
            if let Kind::Feedback(axis) = variable.kind {
                axes.push(axis);
            }
        }
        input_model.inputs().positions = axes.iter().map(|axis| (*axis, 0.0)).collect();
        let machine = Arc::new(description.project.machine.clone());
        let model = Box::new(input_model.clone());
        let simulation = Simulation::with_model(machine, description.project.image(), model, &axes);
        Instance {
            description,
            runner: Runner::of(simulation),
            program: None,
            input_model,
            start: 0.0,
        }
    }

    /// The same machine before its first tick.
    ///
    /// # Errors
    /// None: its description was read before.
    pub fn reset(&mut self) -> Result<(), String> {
        let Description {
            project,
            program,
            variables,
            token,
        } = &self.description;
        *self = Instance::new(Description {
            project: project.clone(),
            program: program.clone(),
            variables: variables.clone(),
            token: token.clone(),
        });
        Ok(())
    }

    /// Time at tick 0, s.
    pub fn set_start(&mut self, seconds: f64) {
        self.start = seconds;
    }

    /// Tick 0 begins, and the program runs until it waits.
    pub fn begin(&mut self) {
        self.runner.simulation().begin();
        let program = Interpreter::new(self.description.program.clone());
        self.program = Some(self.runner.start(program, Policy::default()));
    }

    /// Lets ticks pass up to the one that is nearest to a time.
    ///
    /// # Errors
    /// The initialization is not over, the time is none or has passed, or the program cannot go on.
    pub fn step_to(&mut self, time: f64) -> Result<(), String> {
        let Some(program) = self.program else {
            return Err("a step before the end of the initialization".to_owned());
        };
        let now = self.runner.simulation().tick();
        let tick = ((time - self.start) / self.description.project.machine.period()).round();
        if !(tick >= now as f64 && tick < 1e15) {
            return Err(format!("a step to {time} s, behind tick {now}"));
        }
        let limits = RunLimits {
            ticks: tick as u64 - now,
            until: f64::INFINITY,
        };
        self.runner.step(limits, &mut Blind);
        match self.runner.end_of(program) {
            Some(Err(End::Wrong(wrong))) => Err(format!("{}: {wrong}", crate::description::PROGRAM)),
            _ => Ok(()),
        }
    }

    /// The time of the present tick, s.
    pub fn time(&self) -> f64 {
        self.start + self.runner.simulation().time()
    }

    /// The value of a variable of a type.
    ///
    /// # Errors
    /// There is no such variable of that type.
    pub fn get(&mut self, reference: u32, of: Type) -> Result<f64, String> {
        let variable = self.description.variables.get(reference as usize);
        let variable = variable.filter(|variable| variable.of == of);
        let kind = variable.map(|variable| variable.kind.clone());
        let signal = match kind.ok_or_else(|| format!("{reference} is no variable of type {of:?}"))? {
            Kind::Time => return Ok(self.time()),
            Kind::Plant => return Ok(f64::from(u8::from(self.input_model.inputs().used))),
            Kind::Feedback(axis) => {
                let inputs = self.input_model.inputs();
                let found = inputs.positions.iter().find(|(known, _)| *known == axis);
                return Ok(found.map_or(0.0, |(_, position)| *position));
            }
            Kind::Done => {
                let is_over = self.program.is_some_and(|program| !self.runner.runs(program));
                let is_done = is_over && self.runner.simulation().controller().at_rest();
                return Ok(f64::from(u8::from(is_done)));
            }
            Kind::Err => return Ok(self.erred().map_or(0.0, |(err, _)| f64::from(err))),
            Kind::Exerr => return Ok(self.erred().map_or(0.0, |(_, exerr)| f64::from(exerr))),
            Kind::Axis(axis, column) => Signal::Axis { axis, column },
            Kind::Input(path) | Kind::Output(path) => Signal::Tag(path),
        };
        let mut row = [0.0];
        sample(&mut self.runner.simulation(), &[signal], &mut row);
        Ok(row[0])
    }

    fn erred(&self) -> Option<(i16, i8)> {
        match self.runner.end_of(self.program?)? {
            Err(End::Erred(erred)) => Some((erred.err, erred.exerr)),
            _ => None,
        }
    }

    /// Gives an input or a parameter its value.
    ///
    /// # Errors
    /// There is no such variable of that type, it is no input, or it cannot have the value.
    pub fn set(&mut self, reference: u32, of: Type, value: f64) -> Result<(), String> {
        let variable = self.description.variables.get(reference as usize);
        let Some(variable) = variable.filter(|variable| variable.of == of) else {
            return Err(format!("{reference} is no variable of type {of:?}"));
        };
        match variable.kind {
            Kind::Plant if self.program.is_none() => self.input_model.inputs().used = value != 0.0,
            Kind::Plant => return Err("external_plant is fixed behind the initialization".to_owned()),
            Kind::Feedback(axis) => {
                if !value.is_finite() {
                    return Err(format!("{} is {value}", variable.name));
                }
                let mut inputs = self.input_model.inputs();
                let found = inputs.positions.iter_mut().find(|(known, _)| *known == axis);
                if let Some((_, position)) = found {
                    *position = value;
                }
            }
            Kind::Input(_) => {
                let value = match of {
                    Type::Boolean => WriteValue::Bool(value != 0.0),
                    Type::Int32 => WriteValue::Integer(value as i128),
                    Type::Float64 => WriteValue::Number(value),
                };
                let written = self.runner.simulation().write_tag(&variable.name, &value);
                written.map_err(|error| format!("{}: {error}", variable.name))?;
            }
            _ => return Err(format!("{} is no input", variable.name)),
        }
        Ok(())
    }
}
