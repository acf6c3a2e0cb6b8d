//! The variables of the FMU and its `modelDescription.xml`, from the machine (FMI 3.0.2, 2.4).

use std::fmt::Write as _;
use std::path::Path;

use arcline_config::Project;
use arcline_controller::image::Image;
use arcline_instruction_set::AxisId;
use arcline_simulation::{AXIS_SIGNALS, ImageNames};
use arcline_structured_text::Program;
use arcline_tag::{DataType, Elementary, TagPath};

/// The file of the configuration in the resources of the FMU.
pub const MACHINE: &str = "machine.toml";
/// The file of the program there.
pub const PROGRAM: &str = "program.st";
/// The file with the tags that are variables there: `input NAME` or `output NAME`, one a line.
pub const TAGS: &str = "tags.txt";

/// The parts of the FMU.
#[derive(Debug)]
pub struct Description {
    /// The machine.
    pub project: Project,
    /// The program, checked with the names of the machine.
    pub program: Program,
    /// The variables; the place of each is its value reference.
    pub variables: Vec<Variable>,
    /// The token by which the library recognises its own description.
    pub token: String,
}

/// A variable.
#[derive(Clone, Debug)]
pub struct Variable {
    /// Its name.
    pub name: String,
    /// Its kind.
    pub kind: Kind,
    /// Its type.
    pub of: Type,
}

/// The kind of a variable.
#[derive(Clone, Debug)]
pub enum Kind {
    /// Simulated time.
    Time,
    /// Parameter: the positions of the axes come from the inputs.
    Plant,
    /// Output: a column of [`AXIS_SIGNALS`] of an axis.
    Axis(usize, usize),
    /// Input: the position of an axis in the plant.
    Feedback(AxisId),
    /// Input: a tag that the program reads.
    Input(TagPath),
    /// Output: a tag.
    Output(TagPath),
    /// Output: the program and all motion have ended.
    Done,
    /// Output: ERR of the instruction that ended the program.
    Err,
    /// Output: its EXERR.
    Exerr,
}

/// The type of a variable.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Type {
    /// `Float64`.
    Float64,
    /// `Int32`.
    Int32,
    /// `Boolean`.
    Boolean,
}

impl Description {
    /// Reads the files of the resources.
    ///
    /// # Errors
    /// A file is missing or wrong; the text says which and why.
    pub fn read(resources: &Path) -> Result<Self, String> {
        let text = |name: &str| {
            let file = resources.join(name);
            std::fs::read_to_string(&file).map_err(|error| format!("{}: {error}", file.display()))
        };
        Self::new(&text(MACHINE)?, &text(PROGRAM)?, &text(TAGS)?)
    }

    /// The same from the texts of the files.
    ///
    /// # Errors
    /// A text is wrong; the error says which and why.
    pub fn new(machine: &str, program: &str, tags: &str) -> Result<Self, String> {
        let project = arcline_config::load(machine, MACHINE).map_err(|error| error.to_string())?;
        let image = project.image();
        let mut parsed = Program::parse(program).map_err(|error| format!("{PROGRAM}: {error}"))?;
        parsed
            .check(&ImageNames(&image))
            .map_err(|error| format!("{PROGRAM}: {error}"))?;
        Ok(Description {
            variables: variables(&project, &image, tags)?,
            token: token(&[machine, program, tags]),
            program: parsed,
            project,
        })
    }

    /// `modelDescription.xml`.
    pub fn xml(&self) -> String {
        let mut text = String::new();
        let period = self.project.machine.period();
        let _ = write!(
            text,
            "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<fmiModelDescription fmiVersion=\"3.0\" modelName=\"{}\" instantiationToken=\"{}\" \
             description=\"A machine of Arcline and its program\" generationTool=\"Arcline {}\" version=\"{}\">\n  \
             <CoSimulation modelIdentifier=\"arcline\" canHandleVariableCommunicationStepSize=\"true\" fixedInternalStepSize=\"{period}\"/>\n  \
             <DefaultExperiment startTime=\"0\" stepSize=\"{period}\"/>\n  <ModelVariables>\n",
            escaped(&self.project.server.name),
            self.token,
            env!("CARGO_PKG_VERSION"),
            env!("CARGO_PKG_VERSION"),
        );
        for (reference, variable) in self.variables.iter().enumerate() {
            let element = match variable.of {
                Type::Float64 => "Float64",
                Type::Int32 => "Int32",
                Type::Boolean => "Boolean",
            };
            let start = if variable.of == Type::Boolean { "false" } else { "0" };
            let rest = match &variable.kind {
                Kind::Time => "causality=\"independent\" variability=\"continuous\"".to_owned(),
                Kind::Plant => format!("causality=\"parameter\" variability=\"fixed\" start=\"{start}\""),
                Kind::Feedback(_) => format!("causality=\"input\" variability=\"continuous\" start=\"{start}\""),
                Kind::Input(_) => format!("causality=\"input\" variability=\"discrete\" start=\"{start}\""),
                Kind::Axis(..) => "causality=\"output\" variability=\"continuous\"".to_owned(),
                _ => "causality=\"output\" variability=\"discrete\"".to_owned(),
            };
            let _ = writeln!(
                text,
                "    <{element} name=\"{}\" valueReference=\"{reference}\" description=\"{}\" {rest}/>",
                escaped(&variable.name),
                variable.description()
            );
        }
        text.push_str("  </ModelVariables>\n  <ModelStructure>\n");
        for element in ["Output", "InitialUnknown"] {
            for (reference, variable) in self.variables.iter().enumerate() {
                if variable.is_output() {
                    let _ = writeln!(text, "    <{element} valueReference=\"{reference}\"/>");
                }
            }
        }
        text.push_str("  </ModelStructure>\n</fmiModelDescription>\n");
        text
    }
}

impl Variable {
    fn description(&self) -> &'static str {
        match &self.kind {
            Kind::Time => "simulated time, s",
            Kind::Plant => "true: the inputs Feedback say where the axes are, instead of the simulated drives",
            Kind::Axis(_, 0) => "command, position units",
            Kind::Axis(_, 1) => "command, position units per second",
            Kind::Axis(_, 2) => "command, position units per second squared",
            Kind::Axis(..) => "feedback, position units",
            Kind::Feedback(_) => "where the axis is, of the machine, position units",
            Kind::Input(_) => "a tag that is written before each step",
            Kind::Output(_) => "a tag",
            Kind::Done => "the program and all motion have ended",
            Kind::Err => "ERR of the instruction that ended the program",
            Kind::Exerr => "its EXERR",
        }
    }

    fn is_output(&self) -> bool {
        !matches!(self.kind, Kind::Time | Kind::Plant | Kind::Feedback(_) | Kind::Input(_))
    }
}

fn variables(project: &Project, image: &Image, tags: &str) -> Result<Vec<Variable>, String> {
    let variable = |name: String, kind, of| Variable { name, kind, of };
    let mut variables = vec![
        variable("time".to_owned(), Kind::Time, Type::Float64),
        variable("external_plant".to_owned(), Kind::Plant, Type::Boolean),
        variable("done".to_owned(), Kind::Done, Type::Boolean),
        variable("err".to_owned(), Kind::Err, Type::Int32),
        variable("exerr".to_owned(), Kind::Exerr, Type::Int32),
    ];
    for (axis, settings) in project.machine.axes.iter().enumerate() {
        for (column, signal) in AXIS_SIGNALS.iter().enumerate() {
            let name = format!("{}.{signal}", settings.name);
            variables.push(variable(name, Kind::Axis(axis, column), Type::Float64));
        }
        if !settings.is_virtual() {
            let name = format!("{}.Feedback", settings.name);
            variables.push(variable(name, Kind::Feedback(AxisId::from_index(axis)), Type::Float64));
        }
    }
    for line in tags.lines().map(str::trim).filter(|line| !line.is_empty()) {
        let wrong = |why: String| format!("{TAGS}: {line}: {why}");
        let (word, name) = line
            .split_once(' ')
            .ok_or_else(|| wrong("expected input NAME or output NAME".to_owned()))?;
        let path: TagPath = name.parse().map_err(|error| wrong(format!("{error}")))?;
        let (_, place) = image.locate(&path).map_err(|error| wrong(error.to_string()))?;
        let of = match (place.bit, &place.data_type) {
            (Some(_), _) | (None, DataType::Elementary(Elementary::Bool)) => Type::Boolean,
            (None, DataType::Elementary(Elementary::Real | Elementary::Lreal)) => Type::Float64,
            (None, DataType::Elementary(Elementary::Sint | Elementary::Int | Elementary::Dint)) => Type::Int32,
            _ => return Err(wrong("expected a BOOL, SINT, INT, DINT, REAL or LREAL".to_owned())),
        };
        let kind = match word {
            "input" => Kind::Input(path),
            "output" => Kind::Output(path),
            _ => return Err(wrong("expected input NAME or output NAME".to_owned())),
        };
        variables.push(variable(name.to_owned(), kind, of));
    }
    Ok(variables)
}

/// FNV-1a of all texts, in hexadecimal.
fn token(texts: &[&str]) -> String {
    let mut hash = 0xcbf2_9ce4_8422_2325_u64;
    for byte in texts.iter().flat_map(|text| text.bytes().chain([0])) {
        hash = (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
    }
    format!("{{arcline-{}-{hash:016x}}}", env!("CARGO_PKG_VERSION"))
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('"', "&quot;")
}
