//! A machine on the virtual clock, driven a tick at a time, for tests of the semantics of instructions.
//!
//! [`Bench::call`] takes one Structured Text call with literal operands and executes it at the present tick.

use std::collections::BTreeMap;
use std::sync::Arc;

use arcline_config::Project;
use arcline_controller::drive::Drives;
use arcline_controller::image::{Image, WriteEffect};
use arcline_controller::machine::{CoordinateSystem, Machine, StartState};
use arcline_controller::{Event, FaultChange, InstructionWrite, Snapshot, WrittenValues};
use arcline_instruction_set::predefined::motion_status;
use arcline_instruction_set::{
    ControlSlot, Directory, FaultKind, FaultSet, Flag, MotionControl, Object, Quantity, Setting, TagAddress,
    UnboundOperand, WrittenArray, bind,
};
use arcline_simulation::{Observer, Origin, Simulation};
use arcline_structured_text::{Answer, Interpreter, Program, Request};
use arcline_tag::Value;

use crate::trace::Trace;

/// A controller between the beginning and the end of a tick, and everything it has reported so far.
pub struct Bench {
    project: Project,
    /// The simulation. Only its plain tags count: the controller has motion and motion controls.
    simulation: Simulation,
    /// The same simulation, which passes over uneventful ticks.
    twin: Option<Twin>,
    controls: BTreeMap<String, ControlSlot>,
    arrays: Vec<String>,
    written: BTreeMap<String, Vec<f64>>,
    trace: Option<Trace>,
    /// Every event so far, with the name of its tag.
    pub events: Vec<(String, Event)>,
    /// A command limit may act: no assertion that none does.
    pub refusals_expected: bool,
    /// Every change of the faults of an axis so far.
    pub fault_changes: Vec<FaultChange>,
}

/// DN without an error.
pub const OK: (i16, i8) = (0, 0);

impl Bench {
    /// The embedded default machine at tick 0.
    pub fn new() -> Self {
        Self::with(arcline_config::DEFAULT)
    }

    /// A machine of a configuration at tick 0.
    pub fn with(config: &str) -> Self {
        Self::of(arcline_config::load(config, "bench.toml").expect("the configuration is valid"))
    }

    /// A machine of a configuration with other drives than the simulated ones, at tick 0.
    pub fn with_drives(config: &str, drives: Box<dyn Drives>) -> Self {
        let project = arcline_config::load(config, "bench.toml").expect("the configuration is valid");
        let machine = Arc::new(project.machine.clone());
        let simulation = Simulation::with_drives(machine, image_of(&project), drives);
        Self::at_tick_0(project, simulation, None)
    }

    /// A project's machine at tick 0.
    pub fn of(project: Project) -> Self {
        let simulation = || Simulation::new(Arc::new(project.machine.clone()), image_of(&project));
        let (own, twin) = (simulation(), Twin::of(&project.machine, simulation));
        Self::at_tick_0(project, own, twin)
    }

    fn at_tick_0(project: Project, mut simulation: Simulation, twin: Option<Twin>) -> Self {
        simulation.begin();
        Bench {
            project,
            simulation,
            twin,
            controls: BTreeMap::new(),
            arrays: Vec::new(),
            written: BTreeMap::new(),
            trace: Trace::asked(),
            events: Vec::new(),
            refusals_expected: false,
            fault_changes: Vec::new(),
        }
    }

    /// The default machine with one text of its configuration replaced by another.
    pub fn replacing(from: &str, to: &str) -> Self {
        assert!(
            arcline_config::DEFAULT.contains(from),
            "the default configuration has no {from:?}"
        );
        Self::with(&arcline_config::DEFAULT.replacen(from, to, 1))
    }

    /// Executes one instruction now. Returns ERR and EXERR.
    pub fn call(&mut self, text: &str) -> (i16, i8) {
        let shown = self.execute(text);
        (shown.err, shown.exerr)
    }

    /// Executes one instruction now. Returns its motion control tag right after.
    pub fn execute(&mut self, text: &str) -> MotionControl {
        let program = Program::parse_call(text).unwrap_or_else(|error| panic!("{error}"));
        let mut interpreter = Interpreter::new(program);
        let request = interpreter
            .resume(Answer::Start)
            .unwrap_or_else(|error| panic!("{text}: {error}"));
        let Request::Call(call) = request else {
            panic!("{text}: operands of a bench are literals, not {request:?}");
        };
        let name = call.control.unwrap_or_default();
        for operand in &call.operands {
            if let UnboundOperand::Name(name) | UnboundOperand::Word(name) = operand
                && !self.arrays.contains(name)
            {
                self.arrays.push(name.clone());
            }
        }
        let free = ControlSlot(self.controls.len() as u32);
        let control = *self.controls.entry(name).or_insert(free);
        let object = call.mnemonic.instruction().object;
        let target = self.object(object, &call.target);
        let bound =
            bind(call.mnemonic, target, control, &call.operands, self).unwrap_or_else(|error| panic!("{error}"));
        self.both(|simulation| simulation.execute(&bound, Origin::default()).1)
    }

    /// Acts on the simulation, and on its twin.
    fn both<T>(&mut self, mut act: impl FnMut(&mut Simulation) -> T) -> T {
        self.catch_up();
        if let Some(twin) = &mut self.twin {
            act(&mut twin.simulation);
        }
        act(&mut self.simulation)
    }

    /// The twin catches up with the present tick.
    ///
    /// # Panics
    /// If it is not in the same state to the last bit, or has reported other events.
    fn catch_up(&mut self) {
        let Some(twin) = &mut self.twin else { return };
        if twin.behind == 0 {
            return;
        }
        twin.catch_up(&self.arrays);
        let events = self.events.iter().map(|(_, event)| event).skip(twin.compared);
        assert!(
            events.eq(&twin.events),
            "events differ if uneventful ticks are passed over"
        );
        twin.compared += twin.events.len();
        twin.events.clear();
        let trace = |simulation: &Simulation| {
            let values = simulation.controller().trace().flatten();
            values.map(f64::to_bits).collect::<Vec<_>>()
        };
        if self.simulation.snapshot() == twin.simulation.snapshot()
            && trace(&self.simulation) == trace(&twin.simulation)
        {
            return;
        }
        // As text: a number that is none equals itself.
        let text = |simulation: &Simulation| format!("{:#?}", simulation.snapshot());
        let (own, other) = (text(&self.simulation), text(&twin.simulation));
        let differ = own.lines().zip(other.lines()).filter(|(own, other)| own != other);
        let differ: Vec<_> = differ.take(10).collect();
        assert!(
            own == other,
            "tick {}: the state differs if uneventful ticks are passed over: {differ:?}",
            self.now()
        );
    }

    /// Writes a value to a plain tag.
    pub fn write(&mut self, path: &str, value: f64) {
        let path = path.parse().unwrap_or_else(|error| panic!("{path}: {error:?}"));
        let write = |image: &mut Image| {
            let edge = image.write_value(&path, Value::Lreal(value))?;
            assert!(
                matches!(edge, None | Some(WriteEffect::Input)),
                "{path} does more than a plain tag"
            );
            Ok(edge)
        };
        let written = self.both(|simulation| simulation.write(Origin::default(), write));
        written.unwrap_or_else(|error| panic!("{error}"));
    }

    /// The value of a plain tag.
    pub fn read(&mut self, path: &str) -> f64 {
        let image = self.simulation.image_mut();
        image.show_uses();
        let path = path.parse().unwrap_or_else(|error| panic!("{path}: {error:?}"));
        image.read(&path).unwrap_or_else(|error| panic!("{error}")).as_f64()
    }

    /// Writes the points of a cam, each with master, slave and segment type, into a CAM array.
    pub fn cam(&mut self, tag: &str, points: &[(f64, f64, u8)]) {
        for (place, (master, slave, kind)) in points.iter().enumerate() {
            self.write(&format!("{tag}[{place}].Master"), *master);
            self.write(&format!("{tag}[{place}].Slave"), *slave);
            self.write(&format!("{tag}[{place}].SegmentType"), f64::from(*kind));
        }
    }

    /// The rung of the instruction with this tag is false.
    pub fn rung_false(&mut self, tag: &str) {
        let control = self.controls[tag];
        self.both(|simulation| simulation.rung_false(control));
    }

    /// Takes a share of the programmed speeds of a coordinate system's moves now; 0 holds.
    pub fn set_override(&mut self, system: &str, share: f64) {
        let index = self.project.machine.system(system);
        let index = index.expect("the machine has the coordinate system");
        self.both(|simulation| simulation.controller_mut().set_override(index, share));
    }

    /// Sets the Dynamics Configuration Bits of an axis or a coordinate system now.
    pub fn set_dynamics_bits(&mut self, object: Object, name: &str, bits: u32) {
        self.set_attribute(object, name, Quantity::DynamicsConfigurationBits, bits.into());
    }

    /// Sets an attribute of an axis or a coordinate system now.
    pub fn set_attribute(&mut self, object: Object, name: &str, quantity: Quantity, value: f64) {
        let index = self.object(object, name).expect("the machine has the object");
        let setting = Setting {
            object,
            index,
            quantity,
            value,
        };
        self.both(|simulation| simulation.controller_mut().set(setting));
    }

    /// Puts causes of faults on an axis now, in place of those that were put there; they are found at the next tick.
    pub fn inject(&mut self, axis: &str, causes: &[FaultKind]) {
        let index = self.project.machine.axis(axis);
        let index = index.expect("the machine has the axis");
        let causes = causes.iter().fold(FaultSet::default(), |set, kind| set.with(*kind));
        self.both(|simulation| simulation.controller_mut().inject(index, causes));
    }

    /// Stops everything that moves now, by no instruction.
    pub fn stop_all(&mut self) {
        self.both(|simulation| simulation.controller_mut().stop_all());
    }

    /// Ends the present tick and begins the next one.
    pub fn tick(&mut self) {
        self.tick_seen(|_| ());
    }

    /// The same; between the two, `look` reads the state of the ended tick as clients see it.
    pub fn tick_seen<T>(&mut self, look: impl FnOnce(&Self) -> T) -> T {
        let mut trace = self.trace.take();
        self.simulation.end(&mut Seen {
            controls: &self.controls,
            arrays: &self.arrays,
            events: &mut self.events,
            fault_changes: &mut self.fault_changes,
            written: &mut self.written,
            trace: trace.as_mut(),
        });
        if let Some(trace) = &mut trace {
            trace.snapshot(&self.snapshot());
        }
        self.trace = trace;
        self.assert_no_command_was_refused();
        let seen = look(self);
        self.simulation.begin();
        if let Some(twin) = &mut self.twin {
            twin.behind += 1;
        }
        seen
    }

    /// Only programs that test refused commands command an axis beyond its limits.
    fn assert_no_command_was_refused(&self) {
        if self.refusals_expected {
            return;
        }
        let refused = |change: &&FaultChange| change.refused.is_some();
        if let Some(change) = self.fault_changes.iter().rev().take(8).find(refused) {
            panic!("a command of a legal program did not go out: {change:?}");
        }
    }

    /// Runs a number of ticks.
    pub fn run(&mut self, ticks: u64) {
        for _ in 0..ticks {
            self.tick();
        }
    }

    /// Runs until a bit of a tag is set; returns the ticks that took.
    ///
    /// # Panics
    /// When that takes more than 100,000 ticks.
    pub fn until(&mut self, tag: &str, flag: Flag) -> u64 {
        let from = self.now();
        while !self.control(tag).has(flag) {
            assert!(self.now() - from < 100_000, "{tag}.{flag:?} is never set");
            self.tick();
        }
        self.now() - from
    }

    /// Runs until nothing moves.
    pub fn until_rest(&mut self) {
        let from = self.now();
        while !self.simulation.controller().at_rest() {
            assert!(self.now() - from < 100_000, "it never comes to rest");
            self.tick();
        }
    }

    /// The present tick.
    pub fn now(&self) -> u64 {
        self.simulation.tick()
    }

    /// The state of a motion control tag.
    pub fn control(&self, tag: &str) -> MotionControl {
        self.controls.get(tag).map_or_else(MotionControl::default, |slot| {
            self.simulation.controller().control(*slot)
        })
    }

    /// The names of the bits that a tag shows, in the order EN DN ER IP AC PC ….
    pub fn bits(&self, tag: &str) -> String {
        let control = self.control(tag);
        let shown = Flag::ALL
            .iter()
            .filter(|flag| control.has(**flag))
            .map(|flag| flag.name());
        shown.collect::<Vec<_>>().join(" ")
    }

    /// The values that an instruction has written to an array so far; empty at first.
    pub fn array(&self, name: &str) -> Vec<f64> {
        self.written.get(name).cloned().unwrap_or_default()
    }

    /// The machine after a restart: axes as the present tick shows them, their drives off, all else as configured.
    pub fn restarted(&self) -> Self {
        let mut project = self.project.clone();
        for (axis, shown) in project.machine.axes.iter_mut().zip(self.snapshot().axes) {
            axis.start = StartState {
                position: shown.command[0],
                servo_on: false,
                homed: shown.motion_status & motion_status::AXIS_HOMED_STATUS != 0,
                faults: shown.faults,
                redefined: shown.redefined,
            };
        }
        Self::of(project)
    }

    /// The machine as configured.
    pub fn machine(&self) -> &Machine {
        &self.project.machine
    }

    /// The state of the machine at the present tick.
    pub fn snapshot(&self) -> Snapshot {
        self.simulation.snapshot()
    }

    /// Command position of an axis.
    pub fn position(&self, axis: &str) -> f64 {
        self.axis(axis).command[0]
    }

    /// An axis at the present tick.
    pub fn axis(&self, axis: &str) -> arcline_controller::AxisSnapshot {
        let index = self.project.machine.axis(axis).expect("the machine has the axis");
        self.snapshot().axes[usize::from(index)]
    }

    /// A coordinate system at the present tick.
    pub fn system(&self, system: &str) -> arcline_controller::SystemSnapshot {
        let index = self
            .project
            .machine
            .system(system)
            .expect("the machine has the coordinate system");
        self.snapshot().systems[usize::from(index)]
    }
}

impl Drop for Bench {
    fn drop(&mut self) {
        if !std::thread::panicking() {
            self.catch_up();
        }
    }
}

/// A simulation that gets the same calls and writes in the same ticks, and passes over the uneventful ones between them.
struct Twin {
    simulation: Simulation,
    /// Ticks that it has not begun yet.
    behind: u64,
    /// Its events that were not compared yet, and the number of those that were.
    events: Vec<Event>,
    compared: usize,
}

impl Twin {
    /// The twin of a simulation at tick 0. `None` for machines that plan contours: that would take twice the time, and ticks with contours are
    /// never passed over.
    fn of(machine: &Machine, simulation: impl FnOnce() -> Simulation) -> Option<Self> {
        if machine.systems.iter().any(CoordinateSystem::plans_contours) {
            return None;
        }
        let mut simulation = simulation();
        simulation.begin();
        Some(Twin {
            simulation,
            behind: 0,
            events: Vec::new(),
            compared: 0,
        })
    }

    fn catch_up(&mut self, arrays: &[String]) {
        let events = &mut self.events;
        let mut reports = Reports { arrays, events };
        while self.behind > 0 {
            self.simulation.end(&mut reports);
            self.behind -= 1 + self.simulation.begin_after(self.behind - 1);
        }
    }
}

/// The reports of a twin.
struct Reports<'t> {
    arrays: &'t [String],
    events: &'t mut Vec<Event>,
}

impl Observer for Reports<'_> {
    fn instruction_written(&mut self, write: &InstructionWrite, image: &mut Image) {
        if own_array(self.arrays, write).is_none() {
            image.apply_instruction_write(write);
        }
    }

    fn event(&mut self, event: &Event, _time: f64, _image: &Image) {
        self.events.push(*event);
    }
}

/// The array of a bench that an instruction has written.
fn own_array<'a>(arrays: &'a [String], write: &InstructionWrite) -> Option<&'a String> {
    let own = arrays.get(write.tag.offset() / 4).filter(|_| write.tag.tag() == 0);
    own.filter(|_| matches!(write.values, WrittenValues::Numbers(_)))
}

/// The records of a tick.
struct Seen<'b> {
    controls: &'b BTreeMap<String, ControlSlot>,
    arrays: &'b [String],
    events: &'b mut Vec<(String, Event)>,
    fault_changes: &'b mut Vec<FaultChange>,
    written: &'b mut BTreeMap<String, Vec<f64>>,
    trace: Option<&'b mut Trace>,
}

impl Observer for Seen<'_> {
    fn fault(&mut self, change: &FaultChange, _time: f64, _machine: &Machine) {
        self.fault_changes.push(*change);
        if let Some(trace) = &mut self.trace {
            trace.fault_change(change);
        }
    }

    fn instruction_written(&mut self, write: &InstructionWrite, image: &mut Image) {
        match (&write.values, own_array(self.arrays, write)) {
            (WrittenValues::Numbers(numbers), Some(name)) => {
                drop(self.written.insert(name.clone(), numbers.as_slice().to_vec()));
            }
            _ => image.apply_instruction_write(write),
        }
    }

    fn event(&mut self, event: &Event, _time: f64, _image: &Image) {
        if let Some(trace) = &mut self.trace {
            trace.event(event);
        }
        let name = self.controls.iter().find(|(_, slot)| **slot == event.control);
        self.events
            .push((name.map(|(name, _)| name.clone()).unwrap_or_default(), *event));
    }
}

/// The plain tags of a project: a bench gives names to motion controls itself.
fn image_of(project: &Project) -> Image {
    Image::new(&project.machine, &[], &project.tags)
}

impl Default for Bench {
    fn default() -> Self {
        Self::new()
    }
}

impl Directory for Bench {
    fn object(&self, object: Object, name: &str) -> Option<u16> {
        let machine = &self.project.machine;
        match object {
            Object::MotionGroup => machine.is_group(name).then_some(0),
            Object::Axis => machine.axis(name).map(|axis| axis.0),
            Object::CoordinateSystem => machine.system(name).map(|system| system.0),
        }
    }

    /// An array of the configuration, or any name: a name that ends in a number is an array of that length, others have 4 elements.
    fn real_array(&self, name: &str) -> Option<WrittenArray> {
        self.simulation.image().real_array(name).or_else(|| {
            let elements = name.trim_start_matches(|letter: char| !letter.is_ascii_digit()).parse();
            let place = self.arrays.iter().position(|known| known == name)?;
            Some(WrittenArray {
                tag: TagAddress::new(0, 4 * place)?,
                elements: elements.unwrap_or(4),
            })
        })
    }

    fn structure(&self, type_name: &str, name: &str) -> Option<TagAddress> {
        self.simulation.image().structure(type_name, name)
    }
}
