//! Runs cases one after the other, and keeps the machines and programs that come again.

use std::collections::HashMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use arcline_controller::Controller;
use arcline_controller::FaultChange;
use arcline_controller::drive::simulated::MechanicalModel;
use arcline_controller::image::Image;
use arcline_controller::machine::Machine;
use arcline_instruction_set::AxisId;
use arcline_simulation::{ImageNames, Observer, Options, Runner, Simulation};
use arcline_structured_text::{Interpreter, OnError, Policy, Program, QueueFull};
use arcline_tag::WriteValue;

use crate::batch::CASE;
use crate::case::{Case, Invalid};
use crate::measures::Measures;
use crate::outcome::{Outcome, VERSION, text_hash};
use crate::trace::TraceFile;

/// Files, machines, and programs of each machine, that a worker keeps; when there are more, it drops all, so that memory has a bound.
const KEPT: usize = 32;

/// The values of keys that cases leave out.
#[derive(Clone, Debug)]
pub struct Defaults {
    /// The file of the program.
    pub program: Option<String>,
    /// The file of the configuration; `None`: the embedded one.
    pub config: Option<String>,
    /// Tags and keys of the configuration.
    pub set: Vec<(String, WriteValue)>,
    /// The seed of case 0; each case has the next one.
    pub seed: u64,
    /// Longest simulated time, s.
    pub until: f64,
    /// The program's reactions.
    pub policy: Policy,
    /// The file of traces.
    pub trace: Option<String>,
    /// Signals of traces; none: all of all axes.
    pub signals: Vec<String>,
    /// Every nth tick is in a trace.
    pub every: u64,
}

impl Default for Defaults {
    fn default() -> Self {
        Defaults {
            program: None,
            config: None,
            set: Vec::new(),
            seed: 0,
            until: 3600.0,
            policy: Policy {
                queue_full: QueueFull::Wait,
                on_error: OnError::Stop,
            },
            trace: None,
            signals: Vec::new(),
            every: 1,
        }
    }
}

/// A machine before its first tick, ready to be copied.
#[derive(Debug)]
pub struct Prepared {
    /// The machine.
    pub machine: Arc<Machine>,
    /// Its tags, with what was set.
    pub image: Image,
    /// By what the configuration is known.
    pub hash: String,
    /// Tags to be set.
    tags: Vec<(String, WriteValue)>,
}

impl Prepared {
    /// The simulation before tick 0, its tags set.
    ///
    /// # Errors
    /// A tag cannot be set.
    pub fn simulation(&self) -> Result<Simulation, Invalid> {
        self.set(Simulation::new(self.machine.clone(), self.image.clone()))
    }

    /// A simulation with a model of the mechanics, which moves these axes.
    ///
    /// # Errors
    /// A tag cannot be set.
    pub fn simulation_with(&self, model: Box<dyn MechanicalModel>, axes: &[AxisId]) -> Result<Simulation, Invalid> {
        let simulation = Simulation::with_model(self.machine.clone(), self.image.clone(), model, axes);
        self.set(simulation)
    }

    fn set(&self, mut simulation: Simulation) -> Result<Simulation, Invalid> {
        for (name, value) in &self.tags {
            simulation
                .write_tag(name, value)
                .map_err(|error| Invalid(format!("set {name}: {error}")))?;
        }
        Ok(simulation)
    }
}

/// The machine of a configuration's text with tags and keys set: a name that is of no tag and begins with a table of configurations is the path of a key.
///
/// # Errors
/// The configuration is not valid, or a name is neither.
pub fn prepared(text: &str, file: &str, set: &[(String, WriteValue)]) -> Result<Prepared, Invalid> {
    let load = |text: &str| arcline_config::load(text, file).map_err(|error| Invalid(error.to_string()));
    let mut project = load(text)?;
    let mut image = project.image();
    let first = |name: &str| name.split(['.', '[']).next().unwrap_or_default().to_owned();
    let is_key = |name: &str| image.find(&first(name)).is_none() && arcline_config::is_key(name);
    let (keys, tags): (Vec<_>, Vec<_>) = set.iter().cloned().partition(|(name, _)| is_key(name));
    let mut hash = text_hash(text);
    if !keys.is_empty() {
        let changed = arcline_config::with_keys(text, &keys).map_err(|why| Invalid(format!("set {why}")))?;
        project = load(&changed)?;
        image = project.image();
        hash = text_hash(&changed);
    }
    Ok(Prepared {
        machine: Arc::new(project.machine.clone()),
        image,
        hash,
        tags,
    })
}

/// Runs cases one after the other, in one thread.
#[derive(Debug)]
pub struct Worker {
    defaults: Arc<Defaults>,
    over: Arc<AtomicBool>,
    files: HashMap<String, Arc<str>>,
    machines: HashMap<String, Known>,
}

/// A machine and programs that were checked with its names.
#[derive(Debug)]
struct Known {
    prepared: Arc<Prepared>,
    programs: HashMap<Arc<str>, Checked>,
}

/// A program, and by what it is known.
#[derive(Clone, Debug)]
struct Checked {
    program: Program,
    hash: Arc<str>,
}

/// By what the result of a case is known. A member that is missing is not known before the case runs.
#[derive(Debug)]
pub(crate) struct Identity {
    pub(crate) id: Option<serde_json::Value>,
    pub(crate) version: &'static str,
    pub(crate) seed: Option<u64>,
    pub(crate) program: Option<String>,
    pub(crate) config: Option<String>,
}

impl Worker {
    /// One that keeps nothing yet.
    pub fn new(defaults: Arc<Defaults>) -> Self {
        Self::until(defaults, Arc::default())
    }

    /// The same; when `over` becomes true, the case that runs ends at its present tick.
    pub(crate) fn until(defaults: Arc<Defaults>, over: Arc<AtomicBool>) -> Self {
        Worker {
            defaults,
            over,
            files: HashMap::new(),
            machines: HashMap::new(),
        }
    }

    /// Runs the case of a line; its number, from 0, and its line in the file, from 1.
    pub fn run_line(&mut self, number: u64, line_number: u64, line: &str) -> Outcome {
        let case = Case::parse(line);
        let ran = case.clone().and_then(|case| self.run(number, &case));
        match ran {
            Ok(outcome) => outcome,
            Err(why) => Outcome {
                id: case.ok().and_then(|case| case.id),
                ..Outcome::invalid(number, line_number, &why)
            },
        }
    }

    /// Runs a case.
    ///
    /// # Errors
    /// It cannot be run.
    pub fn run(&mut self, number: u64, case: &Case) -> Result<Outcome, Invalid> {
        let began = Instant::now();
        let defaults = self.defaults.clone();
        let text = self.text(case)?;
        let known = self.machine(case, &defaults)?;
        let prepared = known.prepared.clone();
        let Checked { program, hash } = known.program(&text)?;
        let seed = self.seed(number, case);
        let until = case.until.unwrap_or(defaults.until);
        if !(0.0..=1e9).contains(&until) {
            return Err(Invalid(format!("until is {until}, expected 0 to 1e9 s")));
        }
        let machine = prepared.machine.clone();
        let faults = case.faults(&machine, seed)?;
        let simulation = prepared.simulation()?;
        let trace = case.trace.as_ref().or(defaults.trace.as_ref());
        if trace.is_some_and(|file| file == "-") {
            return Err(Invalid(
                "trace is -, expected a file: standard output has the results".to_owned(),
            ));
        }
        let trace = trace.map(|pattern| {
            let path = pattern.replace(CASE, &number.to_string());
            TraceFile::create(path.as_ref(), &machine, &defaults.signals, defaults.every)
        });
        let mut seen = Seen {
            measures: Measures::with_faults(faults),
            trace: trace.transpose()?,
            over: self.over.clone(),
        };
        let options = Options {
            until,
            policy: Policy {
                queue_full: case.queue_full.map_or(defaults.policy.queue_full, QueueFull::from),
                on_error: match case.keep_going {
                    None => defaults.policy.on_error,
                    Some(true) => OnError::KeepGoing,
                    Some(false) => OnError::Stop,
                },
            },
        };
        let mut runner = Runner::of(simulation);
        let end = runner.run(Interpreter::new(program), options, &mut seen);
        let written = seen.trace.map_or(Ok(()), TraceFile::finish);
        Ok(Outcome {
            case: Some(number),
            id: case.id.clone(),
            trace_error: written.err().map(|error| format!("cannot be written: {error}")),
            program: Some(hash.to_string()),
            instructions: Some(runner.simulation().executed()),
            seed: Some(seed),
            config: Some(prepared.hash.clone()),
            wall_s: Some(began.elapsed().as_secs_f64()),
            ..Outcome::of(&end, &seen.measures, &machine)
        })
    }

    /// By what the result of a line's case will be known.
    pub(crate) fn identify(&mut self, number: u64, line: &str) -> Identity {
        let case = Case::parse(line).ok();
        let defaults = self.defaults.clone();
        let program = case.as_ref().and_then(|case| self.text(case).ok());
        let known = case.as_ref().and_then(|case| self.machine(case, &defaults).ok());
        let config = known.map(|known| known.prepared.hash.clone());
        Identity {
            version: VERSION,
            seed: case.as_ref().map(|case| self.seed(number, case)),
            program: program.map(|text| text_hash(&text)),
            config,
            id: case.and_then(|case| case.id),
        }
    }

    fn seed(&self, number: u64, case: &Case) -> u64 {
        let seed = || self.defaults.seed.wrapping_add(number);
        case.seed.unwrap_or_else(seed)
    }

    /// The text of a case's program.
    fn text(&mut self, case: &Case) -> Result<Arc<str>, Invalid> {
        let defaults = self.defaults.clone();
        match (&case.text, case.program.as_ref().or(defaults.program.as_ref())) {
            (Some(text), _) => Ok(Arc::from(text.as_str())),
            (None, Some(file)) => self.file(file),
            (None, None) => Err(Invalid(
                "expected a program, as file (program) or text (text)".to_owned(),
            )),
        }
    }

    /// The text of a file, read once.
    fn file(&mut self, file: &str) -> Result<Arc<str>, Invalid> {
        if let Some(text) = self.files.get(file) {
            return Ok(text.clone());
        }
        let text =
            std::fs::read_to_string(file).map_err(|error| Invalid(format!("{file}: cannot be read: {error}")))?;
        let text: Arc<str> = Arc::from(text);
        if self.files.len() == KEPT {
            self.files.clear();
        }
        self.files.insert(file.to_owned(), text.clone());
        Ok(text)
    }

    /// The machine of a case.
    fn machine(&mut self, case: &Case, defaults: &Defaults) -> Result<&mut Known, Invalid> {
        let config = case.config.as_ref().or(defaults.config.as_ref());
        let set: Vec<_> = defaults.set.iter().chain(&case.set.0).cloned().collect();
        let key = format!("{config:?} {set:?}");
        if !self.machines.contains_key(&key) {
            let (text, name) = match config {
                None => (Arc::from(arcline_config::DEFAULT), "the embedded configuration"),
                Some(file) => (self.file(file)?, file.as_str()),
            };
            let prepared = Arc::new(prepared(&text, name, &set)?);
            if self.machines.len() == KEPT {
                self.machines.clear();
            }
            let programs = HashMap::new();
            self.machines.insert(key.clone(), Known { prepared, programs });
        }
        Ok(self.machines.get_mut(&key).expect("it was just made"))
    }
}

impl Known {
    fn program(&mut self, text: &Arc<str>) -> Result<Checked, Invalid> {
        if let Some(checked) = self.programs.get(text) {
            return Ok(checked.clone());
        }
        let names = ImageNames(&self.prepared.image);
        let checked = Program::parse(text).and_then(|mut program| program.check(&names).map(|()| program));
        let program = checked.map_err(|error| Invalid(format!("the program: {error}")))?;
        if self.programs.len() == KEPT {
            self.programs.clear();
        }
        let hash = Arc::from(text_hash(text));
        let checked = Checked { program, hash };
        self.programs.insert(text.clone(), checked.clone());
        Ok(checked)
    }
}

/// The observers of a run.
struct Seen {
    measures: Measures,
    trace: Option<TraceFile>,
    over: Arc<AtomicBool>,
}

impl Observer for Seen {
    fn fault(&mut self, change: &FaultChange, time: f64, machine: &Machine) {
        self.measures.fault(change, time, machine);
    }

    fn tick(&mut self, tick: u64, machine: &Machine, controller: &mut Controller) -> bool {
        self.measures.tick(tick, controller);
        if let Some(trace) = &mut self.trace {
            trace.tick(tick, machine, controller);
        }
        !self.over.load(Ordering::Relaxed)
    }
}
