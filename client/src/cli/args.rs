//! The arguments. Words of operands come from the instruction catalogue.

use std::str::FromStr;

use clap::{Args, CommandFactory, Parser, Subcommand, ValueEnum};

use arcline_client::{Input, Mnemonic, QueueFull};
use arcline_instruction_set::{Kind, Words, enumerations};

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
    /// Show axes, coordinate systems, the group, and the health of the real-time thread
    #[command(after_help = "Example: arcline status X CS1")]
    Status(Status),
    /// List tags
    #[command(
        after_help = "A pattern with * or ? must match the whole name, another one a part of it; case is ignored.\n\
        Example: arcline tags 'Move*'"
    )]
    Tags(Tags),
    /// Read tags
    #[command(after_help = "Example: arcline read X.ActualPosition Move1.Position")]
    Read(Read),
    /// Write a tag
    #[command(after_help = "Example: arcline write Move1.Position [100,50,0]")]
    Write(Write),
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

#[derive(Args, Debug)]
pub(crate) struct System {
    /// The coordinate system
    #[arg(value_name = "CS")]
    pub(crate) system: String,
}

/// A percentage of the programmed speeds.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(crate) struct Percent(pub(crate) f64);

impl FromStr for Percent {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let digits = text.trim();
        let digits = digits.strip_suffix('%').unwrap_or(digits);
        number(digits)
            .filter(|percent| (0.0..=200.0).contains(percent))
            .map(Self)
            .ok_or_else(|| format!("{text:?} is not a percentage from 0 to 200, expected such as 50 or 50%"))
    }
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
pub(crate) struct Tags {
    /// Part of the name, or a pattern with * and ?
    pub(crate) pattern: Option<String>,
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

/// A magnitude in units or in percent of the maximum.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(crate) enum Rate {
    Units(f64),
    Percent(f64),
}

impl FromStr for Rate {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (digits, make): (_, fn(f64) -> Self) = match text.trim().strip_suffix('%') {
            Some(digits) => (digits, Self::Percent),
            None => (text, Self::Units),
        };
        number(digits)
            .map(make)
            .ok_or_else(|| format!("{text:?} is not a number, expected such as 50 or 50%"))
    }
}

/// Coordinates.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct Point(pub(crate) Vec<f64>);

impl FromStr for Point {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let list = text.trim();
        let list = list
            .strip_prefix('[')
            .and_then(|rest| rest.strip_suffix(']'))
            .unwrap_or(list);
        let numbers: Option<Vec<f64>> = list.split(',').map(number).collect();
        numbers
            .map(Self)
            .ok_or_else(|| format!("{text:?} is not a point, expected numbers such as 100,50,0"))
    }
}

/// Finite numbers only.
fn number(text: &str) -> Option<f64> {
    text.trim().parse().ok().filter(|number: &f64| number.is_finite())
}

/// Reads a word of an enumeration, or its number.
fn word_parser(words: &'static Words) -> impl Fn(&str) -> Result<i32, String> + Clone + Send + Sync + 'static {
    move |text| {
        let value = text.parse().ok().or_else(|| words.parse_word(text));
        value
            .filter(|value| words.contains(*value))
            .ok_or_else(|| format!("expected {}", choices(words)))
    }
}

/// `ActualTolerance (0), NoSettle (1)`.
fn choices(words: &Words) -> String {
    let one = |word: &arcline_instruction_set::Word| format!("{} ({})", word.keyword(), word.value);
    words.words.iter().map(one).collect::<Vec<_>>().join(", ")
}

/// The command with what the catalogue adds to its help.
pub(crate) fn command() -> clap::Command {
    let described = |command: clap::Command| {
        let termination = format!("Termination type: {}", choices(&enumerations::TERMINATION_TYPE));
        let merge = format!("Merge: {}", choices(&enumerations::MERGE));
        command
            .mut_arg("termination", |arg| arg.help(termination))
            .mut_arg("merge", |arg| arg.help(merge))
    };
    Arguments::command()
        .mut_subcommand("move", described)
        .mut_subcommand("arc", described)
        .mut_subcommand("exec", |exec| {
            let example = exec.get_after_help().map(ToString::to_string).unwrap_or_default();
            exec.after_long_help(format!("{example}\n\nInstructions:\n{}", instructions()))
        })
}

/// Every instruction with its operands.
fn instructions() -> String {
    let mut text = String::new();
    for mnemonic in Mnemonic::ALL {
        let instruction = mnemonic.instruction();
        let operands: Vec<String> = instruction.operands.iter().map(|operand| operand.member()).collect();
        text.push_str(&format!(
            "  {mnemonic}({})\n      {}\n",
            operands.join(", "),
            instruction.summary
        ));
        for operand in instruction.operands {
            if let Kind::Word(words) = &operand.kind {
                text.push_str(&format!("      {}: {}\n", operand.member(), choices(words)));
            }
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(line: &str) -> Result<Command, clap::Error> {
        let words = line.split_whitespace();
        let matches = command().try_get_matches_from(std::iter::once("arcline").chain(words))?;
        <Arguments as clap::FromArgMatches>::from_arg_matches(&matches).map(|arguments| arguments.command)
    }

    #[test]
    fn the_command_is_consistent_and_every_help_has_an_example() {
        command().debug_assert();
        for sub in command().get_subcommands() {
            let help = sub.get_after_help().map(ToString::to_string).unwrap_or_default();
            assert!(help.contains("Example: arcline "), "{}", sub.get_name());
        }
    }

    #[test]
    fn moves_parse() {
        #[rustfmt::skip]
        let cases = [
            // why,                        arguments,                           position,                speed
            ("a plain move",               "move CS1 100,50,0",                 vec![100.0, 50.0, 0.0],  None),
            ("negative first",             "move CS1 -10,0,-5 --relative",      vec![-10.0, 0.0, -5.0],  None),
            ("flags in front",             "move CS1 --relative -10,0",         vec![-10.0, 0.0],        None),
            ("free of flags behind --",    "move --speed 50% -- CS1 -1,-2",     vec![-1.0, -2.0],        Some(Rate::Percent(50.0))),
            ("units",                      "move CS1 1,2 --speed 12.5",         vec![1.0, 2.0],          Some(Rate::Units(12.5))),
            ("a speed that will err",      "move CS1 1,2 --speed -5",           vec![1.0, 2.0],          Some(Rate::Units(-5.0))),
            ("one axis",                   "move L 7",                          vec![7.0],               None),
            ("brackets",                   "move L [7,8]",                      vec![7.0, 8.0],          None),
        ];
        for (why, line, position, speed) in cases {
            let Ok(Command::Move(command)) = parse(line) else {
                panic!("{why}: {line}: {:?}", parse(line))
            };
            assert_eq!(
                (command.position.0, command.dynamics.speed),
                (position, speed),
                "{why}: {line}"
            );
        }
    }

    #[test]
    fn words_or_numbers_for_termination_and_merge() {
        for (line, termination, merge) in [
            ("move CS1 1,2 --termination NoSettle", Some(1), None),
            (
                "move CS1 1,2 --termination no-settle --merge allmotion",
                Some(1),
                Some(2),
            ),
            ("move CS1 1,2 --termination 6 --merge 1", Some(6), Some(1)),
        ] {
            let Ok(Command::Move(command)) = parse(line) else {
                panic!("{line}")
            };
            assert_eq!(
                (command.dynamics.termination, command.dynamics.merge),
                (termination, merge),
                "{line}"
            );
        }
    }

    #[test]
    fn what_makes_no_sense_is_refused() {
        #[rustfmt::skip]
        let cases = [
            ("no position",           "move CS1"),
            ("not a number",          "move CS1 a,b"),
            ("not finite",            "move CS1 inf,0"),
            ("an unknown word",       "move CS1 1,2 --termination Smooth"),
            ("no such number",        "move CS1 1,2 --termination 9"),
            ("an unknown flag",       "move CS1 1,2 --fast"),
            ("an arc without circle", "arc XY 1,2"),
            ("two circles",           "arc XY 1,2 --via 1,1 --radius 3"),
            ("two directions",        "arc XY 1,2 --radius 3 --cw --ccw"),
            ("nothing to change",     "change CS1"),
            ("no axis",               "servo on"),
            ("axes and all",          "servo on X --all"),
            ("neither on nor off",    "servo X"),
            ("nothing to read",       "read"),
            ("a later command",       "jog X 5"),
            ("no command",            ""),
        ];
        for (why, line) in cases {
            let error = parse(line).expect_err(why);
            assert_eq!(error.exit_code(), 2, "{why}: {line}");
        }
    }

    #[test]
    fn the_others_parse() {
        for line in [
            "exec MSO(X,M1)",
            "exec --no-wait MSO(X,M1)",
            "run a.st --queue-full error --keep-going",
            "arc XY 100,0 --center -50,0 --ccw --full",
            "arc CS1 1,2,3 --via -1,-2,-3 --longest",
            "arc XY 1,0 --radius -5",
            "arc XY 0,0 --center-offset 5,0",
            "change CS1 --speed 20% --pending",
            "stop",
            "stop CS1 --type move",
            "servo on X Y",
            "servo off --all",
            "status",
            "status X CS1 --json",
            "tags",
            "tags Move*",
            "read A B[1]",
            "write A -5",
            "write A [1,-2]",
            "identify",
            "identify --broadcast 10.0.0.255",
            "--server h:1 status",
        ] {
            assert!(parse(line).is_ok(), "{line}: {:?}", parse(line).err());
        }
    }

    #[test]
    fn values_to_write_are_read_as_what_they_are() {
        for (line, expected) in [
            ("write A -5", Input::Integer(-5)),
            ("write A 1.5", Input::Number(1.5)),
            ("write A [1,2]", vec![1_i64, 2].into()),
            ("write A true", Input::Bool(true)),
            ("write A CS1", "CS1".into()),
        ] {
            let Ok(Command::Write(command)) = parse(line) else {
                panic!("{line}")
            };
            assert_eq!(command.value, expected, "{line}");
        }
    }

    #[test]
    fn the_help_of_exec_comes_from_the_catalogue() {
        let text = instructions();
        for mnemonic in Mnemonic::ALL {
            assert!(text.contains(&format!("  {mnemonic}(")), "{mnemonic}");
        }
        assert!(
            text.contains("TerminationType: ActualTolerance (0), NoSettle (1)"),
            "{text}"
        );
    }
}
