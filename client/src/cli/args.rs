//! The arguments of every command, as data; what they mean is up to the commands.

mod axis;
mod help;
mod margin;
mod values;

use std::str::FromStr;

use clap::{Args, Parser, Subcommand, ValueEnum};

use arcline_client::{FaultKind, Input, QueueFull};
use arcline_instruction_set::enumerations;

pub(crate) use axis::{AxisMotion, Jog, MoveAxis};
pub(crate) use help::command;
pub(crate) use margin::Margin;
pub(crate) use values::{Percent, Point, Rate};

use values::{fault_parser, word_parser};

/// Commands a coordinated-motion server over EtherNet/IP.
#[derive(Parser, Debug)]
#[command(name = "arcline", version, max_term_width = 110)]
#[command(
    after_help = "Exit codes: 0 done, 1 an instruction erred, 2 usage, 3 no connection or lost, 130 interrupted.\n\
    Example: arcline move CS1 100,50,0 --speed 50%"
)]
pub(crate) struct Arguments {
    /// The server, port 44818 unless given
    #[arg(
        long,
        global = true,
        value_name = "HOST[:PORT]",
        env = "ARCLINE_SERVER",
        default_value = "127.0.0.1:44818"
    )]
    pub(crate) server: String,
    /// Print one JSON object for each result
    #[arg(long, global = true)]
    pub(crate) json: bool,
    #[command(subcommand)]
    pub(crate) command: Command,
}

#[derive(Subcommand, Debug)]
pub(crate) enum Command {
    /// Execute one instruction, written as a Structured Text call
    #[command(
        after_help = "Moves and stops are waited for. `exec --help` lists the instructions and their operands.\n\
        Example: arcline exec 'MCLM(CS1, Move1, Absolute, [100, 50, 0], 200, Unitspersec, 2000, Unitspersec2, 2000, \
        Unitspersec2, S-curve, 100, 100, %ofTime)'"
    )]
    Exec(Exec),
    /// Run a Structured Text program
    #[command(
        after_help = "Ends when the last statement has run and all motion has come to its end.\n\
        Example: arcline run square.st"
    )]
    Run(Run),
    /// Move along a straight line (MCLM)
    #[command(
        after_help = "Full-speed S-curve unless told otherwise; a number with % is a part of the maximum.\n\
        Example: arcline move CS1 100,50,0 --speed 50%\n         arcline move CS1 -10,0,0 --relative"
    )]
    Move(Move),
    /// Move along an arc or a circle (MCCM)
    #[command(after_help = "Example: arcline arc XY 100,0 --center 50,0 --cw\n         \
        arcline arc XY 0,0 --center 50,0 --ccw --full --speed 80")]
    Arc(Arc),
    /// Move one axis (MAM)
    #[command(
        after_help = "Full-speed S-curve unless told otherwise; adds to what else moves the axis.
\
        Example: arcline move-axis X 100 --speed 50%\n         arcline move-axis R 90 --shortest"
    )]
    MoveAxis(MoveAxis),
    /// Jog one axis (MAJ) until Ctrl-C stops it
    #[command(
        after_help = "--no-wait leaves it running; `arcline exec 'MAS(X, M1, Jog)'` stops it then.
\
        Example: arcline jog X 50\n         arcline jog X -10% --no-wait"
    )]
    Jog(Jog),
    /// Change the dynamics of the running move (MCCD)
    #[command(after_help = "Example: arcline change CS1 --speed 20%")]
    Change(Change),
    /// Set the feed override of a coordinate system: percent of the programmed speeds, 0 to 200
    #[command(
        after_help = "Holds for its active, pending and later moves until it is changed; 0 holds them on their path.\n\
        Example: arcline override CS1 50%"
    )]
    Override(Override),
    /// Hold the moves of a coordinate system: at rest on their path, still active (override 0)
    #[command(after_help = "Example: arcline hold CS1")]
    Hold(System),
    /// Go on after a hold, with the override that there was before it
    #[command(after_help = "Example: arcline resume CS1")]
    Resume(System),
    /// Stop coordinate systems (MCS); all of them when none is named
    #[command(after_help = "Example: arcline stop CS1 --type move")]
    Stop(Stop),
    /// Switch the servo of axes on (MSO) or off (MSF)
    #[command(after_help = "--all leaves virtual axes out, which have no drive.\nExample: arcline servo on X Y Z")]
    Servo(Servo),
    /// Inject faults into axes, clear and list them
    #[command(
        subcommand,
        after_help = "An injected cause is there until it is cleared.\nExample: arcline fault inject X overcurrent"
    )]
    Fault(FaultCommand),
    /// Home axes (MAH), all at the same time, by the sequence of the server's configuration
    #[command(
        after_help = "Without an end of its own when the sequence is passive: others must move the axis.\n\
        Example: arcline home X Y"
    )]
    Home(Home),
    /// Show axes, coordinate systems, the group, and the health of the real-time thread
    #[command(after_help = "Example: arcline status X CS1")]
    Status(Status),
    /// List tags, create and delete plain ones
    #[command(
        after_help = "A pattern with * or ? must match the whole name, another one a part of it; case is ignored.\n\
        Example: arcline tags 'Move*'\n         arcline tags create Recipe REAL[16]"
    )]
    Tags(Tags),
    /// Read tags
    #[command(after_help = "Example: arcline read X.ActualPosition Move1.Position")]
    Read(Read),
    /// Write a tag
    #[command(after_help = "Example: arcline write Move1.Position [100,50,0]")]
    Write(Write),
    /// Tell how much further a master must go than the Calculated Data of blended, master driven moves say
    #[command(
        after_help = "To be added to their sum, so that the last move reaches its end. Asks no server.\n\
        Example: arcline margin 5 --master-speed 500 --update-period 2"
    )]
    Margin(Margin),
    /// Ask who the server is, or who is there
    #[command(after_help = "Example: arcline identify --broadcast 192.168.1.255")]
    Identify(Identify),
}

#[derive(Args, Debug)]
pub(crate) struct Exec {
    /// Such as 'MSO(X, M1)'
    pub(crate) call: String,
    /// Do not wait for the end of the motion
    #[arg(long)]
    pub(crate) no_wait: bool,
}

#[derive(Args, Debug)]
pub(crate) struct Run {
    /// The program
    pub(crate) file: String,
    /// What a coordinated move does when the queue is full
    #[arg(long, value_enum, default_value = "wait")]
    pub(crate) queue_full: QueueFullWord,
    /// Go on when an instruction errs
    #[arg(long)]
    pub(crate) keep_going: bool,
    /// Do not wait for the end of the motion
    #[arg(long)]
    pub(crate) no_wait: bool,
}

#[derive(ValueEnum, Clone, Copy, PartialEq, Debug)]
pub(crate) enum QueueFullWord {
    /// Waits for room
    Wait,
    /// Errs with 43
    Error,
}

impl From<QueueFullWord> for QueueFull {
    fn from(word: QueueFullWord) -> Self {
        match word {
            QueueFullWord::Wait => Self::Wait,
            QueueFullWord::Error => Self::Error,
        }
    }
}

/// What lines and arcs have in common.
#[derive(Args, Debug, Default)]
pub(crate) struct Dynamics {
    /// Take positions relative to where the move begins
    #[arg(long)]
    pub(crate) relative: bool,
    /// Speed: units/s, or % of the maximum
    #[arg(long, value_name = "V[%]", allow_hyphen_values = true)]
    pub(crate) speed: Option<Rate>,
    /// Acceleration: units/s², or % of the maximum
    #[arg(long, value_name = "A[%]", allow_hyphen_values = true)]
    pub(crate) accel: Option<Rate>,
    /// Deceleration: units/s², or % of the maximum
    #[arg(long, value_name = "D[%]", allow_hyphen_values = true)]
    pub(crate) decel: Option<Rate>,
    /// Trapezoidal profile instead of an S-curve
    #[arg(long)]
    pub(crate) trapezoid: bool,
    /// Termination type, by word or number
    #[arg(long, value_name = "T", value_parser = word_parser(&enumerations::TERMINATION_TYPE))]
    pub(crate) termination: Option<i32>,
    /// Merge, by word or number
    #[arg(long, value_name = "M", value_parser = word_parser(&enumerations::MERGE))]
    pub(crate) merge: Option<i32>,
    /// Name of the motion control tag, made on first use
    #[arg(long, value_name = "NAME")]
    pub(crate) tag: Option<String>,
    /// Do not wait for the end of the motion
    #[arg(long)]
    pub(crate) no_wait: bool,
}

#[derive(Args, Debug)]
pub(crate) struct Move {
    /// Coordinate system
    #[arg(value_name = "CS")]
    pub(crate) system: String,
    /// End point, or increments
    #[arg(value_name = "X,Y[,Z]", allow_hyphen_values = true)]
    pub(crate) position: Point,
    #[command(flatten)]
    pub(crate) dynamics: Dynamics,
}

#[derive(Args, Debug)]
pub(crate) struct Arc {
    /// Coordinate system
    #[arg(value_name = "CS")]
    pub(crate) system: String,
    /// End point, or increments
    #[arg(value_name = "X,Y[,Z]", allow_hyphen_values = true)]
    pub(crate) position: Point,
    #[command(flatten)]
    pub(crate) circle: Circle,
    #[command(flatten)]
    pub(crate) direction: Direction,
    /// A full circle
    #[arg(long)]
    pub(crate) full: bool,
    #[command(flatten)]
    pub(crate) dynamics: Dynamics,
}

#[derive(Args, Debug, Default)]
#[group(required = true, multiple = false)]
pub(crate) struct Circle {
    /// A point on the arc
    #[arg(long, value_name = "P", allow_hyphen_values = true)]
    pub(crate) via: Option<Point>,
    /// The centre
    #[arg(long, value_name = "P", allow_hyphen_values = true)]
    pub(crate) center: Option<Point>,
    /// The radius; negative for the longer arc
    #[arg(long, value_name = "R", allow_hyphen_values = true)]
    pub(crate) radius: Option<f64>,
    /// The centre, relative to the start
    #[arg(long, value_name = "P", allow_hyphen_values = true)]
    pub(crate) center_offset: Option<Point>,
}

#[derive(Args, Debug, Default)]
#[group(multiple = false)]
pub(crate) struct Direction {
    /// Clockwise (the default in two dimensions)
    #[arg(long)]
    pub(crate) cw: bool,
    /// Counterclockwise
    #[arg(long)]
    pub(crate) ccw: bool,
    /// The shorter way (the default in three dimensions)
    #[arg(long)]
    pub(crate) shortest: bool,
    /// The longer way
    #[arg(long)]
    pub(crate) longest: bool,
}

#[derive(Args, Debug)]
#[command(group = clap::ArgGroup::new("changes").args(["speed", "accel", "decel"]).required(true).multiple(true))]
pub(crate) struct Change {
    /// Coordinate system
    #[arg(value_name = "CS")]
    pub(crate) system: String,
    /// New speed: units/s, or % of the maximum
    #[arg(long, value_name = "V[%]", allow_hyphen_values = true)]
    pub(crate) speed: Option<Rate>,
    /// New acceleration: units/s², or % of the maximum
    #[arg(long, value_name = "A[%]", allow_hyphen_values = true)]
    pub(crate) accel: Option<Rate>,
    /// New deceleration: units/s², or % of the maximum
    #[arg(long, value_name = "D[%]", allow_hyphen_values = true)]
    pub(crate) decel: Option<Rate>,
    /// Change the pending move too
    #[arg(long)]
    pub(crate) pending: bool,
}

#[derive(Args, Debug)]
pub(crate) struct Stop {
    /// Coordinate system
    #[arg(value_name = "CS")]
    pub(crate) system: Option<String>,
    /// What to stop
    #[arg(long = "type", value_enum, default_value = "all")]
    pub(crate) kind: StopType,
}

#[derive(Args, Debug)]
pub(crate) struct Override {
    /// The coordinate system
    #[arg(value_name = "CS")]
    pub(crate) system: String,
    /// Percent of the programmed speeds, 0 to 200
    #[arg(value_name = "PERCENT[%]", allow_hyphen_values = true)]
    pub(crate) percent: Percent,
}

#[derive(Subcommand, Debug)]
pub(crate) enum FaultCommand {
    /// Put the cause of a fault on an axis; it is there until it is cleared
    #[command(after_help = "Example: arcline fault inject X overcurrent")]
    Inject(FaultInject),
    /// Take injected causes away and clear the faults of an axis (MAFR)
    #[command(
        after_help = "A faulted axis is then stopped: servo on. One that is shut down stays so: MASR.\n\
        Example: arcline fault clear X"
    )]
    Clear(FaultClear),
    /// Show the faults of axes
    #[command(after_help = "Example: arcline fault list")]
    List(FaultList),
}

#[derive(Args, Debug)]
pub(crate) struct FaultInject {
    /// The axis
    #[arg(value_name = "AXIS")]
    pub(crate) axis: String,
    /// Which fault
    #[arg(value_name = "KIND", value_parser = fault_parser())]
    pub(crate) kind: FaultKind,
}

#[derive(Args, Debug)]
pub(crate) struct FaultClear {
    /// The axis
    #[arg(value_name = "AXIS")]
    pub(crate) axis: String,
    /// The cause that is taken away; all of them unless given
    #[arg(value_name = "KIND", value_parser = fault_parser())]
    pub(crate) kind: Option<FaultKind>,
}

#[derive(Args, Debug)]
pub(crate) struct FaultList {
    /// Axes; all of them unless given
    #[arg(value_name = "AXIS")]
    pub(crate) axes: Vec<String>,
}

#[derive(Args, Debug)]
pub(crate) struct System {
    /// The coordinate system
    #[arg(value_name = "CS")]
    pub(crate) system: String,
}

#[derive(ValueEnum, Clone, Copy, PartialEq, Debug)]
pub(crate) enum StopType {
    /// Moves and transforms
    All,
    /// Moves
    Move,
    /// Transforms
    Transform,
}

#[derive(Args, Debug)]
#[command(group = clap::ArgGroup::new("which").args(["axes", "all"]).required(true))]
pub(crate) struct Servo {
    /// On or off
    #[arg(value_enum)]
    pub(crate) state: OnOff,
    /// Axes
    #[arg(value_name = "AXIS")]
    pub(crate) axes: Vec<String>,
    /// Every axis that has a drive
    #[arg(long)]
    pub(crate) all: bool,
}

#[derive(Args, Debug)]
pub(crate) struct Home {
    /// Axes
    #[arg(value_name = "AXIS", required = true)]
    pub(crate) axes: Vec<String>,
    /// Do not wait until they are homed
    #[arg(long)]
    pub(crate) no_wait: bool,
}

#[derive(ValueEnum, Clone, Copy, PartialEq, Debug)]
pub(crate) enum OnOff {
    On,
    Off,
}

#[derive(Args, Debug)]
pub(crate) struct Status {
    /// Axes, coordinate systems, groups; all of them when none is named
    #[arg(value_name = "NAME")]
    pub(crate) names: Vec<String>,
}

#[derive(Args, Debug)]
#[command(args_conflicts_with_subcommands = true)]
pub(crate) struct Tags {
    #[command(subcommand)]
    pub(crate) change: Option<TagsChange>,
    /// Part of the name, or a pattern with * and ?
    pub(crate) pattern: Option<String>,
}

/// A change of the server's tags.
#[derive(Subcommand, Debug)]
pub(crate) enum TagsChange {
    /// Create a plain tag; clients see it as after a download
    #[command(after_help = "Example: arcline tags create Recipe REAL[16] --program Main")]
    Create(CreateTag),
    /// Delete a plain tag
    #[command(after_help = "Example: arcline tags delete Recipe")]
    Delete(DeleteTag),
}

/// What is created.
#[derive(Args, Debug)]
pub(crate) struct CreateTag {
    /// 1 to 40 letters, digits and underscores, no digit first
    pub(crate) name: String,
    /// Such as DINT, `REAL[16]`, `DINT[2,3]`, or a structure of the server's configuration
    #[arg(value_name = "TYPE")]
    pub(crate) data_type: String,
    /// The program in whose scope it is
    #[arg(long)]
    pub(crate) program: Option<String>,
    /// Who may write it
    #[arg(long, value_enum, default_value = "read_write")]
    pub(crate) access: TagAccess,
}

/// What is deleted.
#[derive(Args, Debug)]
pub(crate) struct DeleteTag {
    /// The tag
    pub(crate) name: String,
    /// The program in whose scope it is
    #[arg(long)]
    pub(crate) program: Option<String>,
}

/// Who may write a tag.
#[derive(ValueEnum, Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum TagAccess {
    /// Clients too
    #[value(name = "read_write")]
    ReadWrite,
    /// Nobody
    #[value(name = "read_only")]
    ReadOnly,
}

#[derive(Args, Debug)]
pub(crate) struct Read {
    /// Such as `X.ActualPosition`, `Move1.Position[0]`, `Word.5`
    #[arg(value_name = "TAG", required = true)]
    pub(crate) tags: Vec<String>,
}

#[derive(Args, Debug)]
pub(crate) struct Write {
    /// Such as Move1.Speed
    pub(crate) tag: String,
    /// A number, true or false, a text, or `[1,2,3]`
    #[arg(allow_hyphen_values = true, value_parser = Input::from_str)]
    pub(crate) value: Input,
}

#[derive(Args, Debug)]
pub(crate) struct Identify {
    /// Ask everybody at a broadcast address
    #[arg(long, value_name = "ADDR[:PORT]")]
    pub(crate) broadcast: Option<String>,
    /// Seconds to listen for answers to a broadcast
    #[arg(long, value_name = "SECONDS", default_value = "1")]
    pub(crate) wait: f64,
}

#[cfg(test)]
mod tests;
