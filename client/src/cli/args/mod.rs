//! The arguments of every command, as data; the commands interpret them.

mod axis;
mod common;
mod faults;
mod help;
mod look;
mod margin;
mod moves;
mod pictures;
mod programs;
mod tags;
mod tools;
mod trace;
mod values;

use std::path::PathBuf;

use clap::{Parser, Subcommand};

pub(crate) use axis::{AxisMotion, Jog, MoveAxis};
#[cfg(test)]
pub(crate) use common::{Axis, Speed};
pub(crate) use common::{Motion, Ramps, System, Waiting};
pub(crate) use faults::{FaultClear, FaultCommand, FaultInject, FaultList};
pub(crate) use help::command;
pub(crate) use look::{Identify, Mode, ModeWord, Shell, Status, Watch};
pub(crate) use margin::Margin;
pub(crate) use moves::{Arc, Change, Circle, Direction, Dynamics, Home, Move, OnOff, Override, Servo, Stop, StopType};
pub(crate) use pictures::{Diff, Gcode, Plot, Unit};
pub(crate) use programs::{Exec, Run};
pub(crate) use tags::{CreateTag, DeleteTag, Read, TagAccess, Tags, TagsChange, Write};
pub(crate) use tools::{Completions, Doctor, Explain, Man, Subject};
pub(crate) use trace::Trace;
pub(crate) use values::{Point, Rate};

/// Commands a coordinated-motion server over EtherNet/IP.
#[derive(Parser, Debug)]
#[command(name = "arcline", version, max_term_width = 110)]
#[command(
    after_help = "Exit codes: 0 done, 1 an instruction erred, 2 usage, 3 no connection or lost, 130 interrupted.\n\
    Example: arcline move CS1 100,50,0 --speed 50%"
)]
pub(crate) struct Arguments {
    /// The server; its port is 44818 by default. The variable ARCLINE_SERVER sets another default server
    #[arg(long, global = true, value_name = "HOST[:PORT]", default_value = "127.0.0.1", help_heading = CONNECTION)]
    pub(crate) server: String,
    #[command(flatten)]
    pub(crate) tls: TlsArguments,
    /// Print one JSON object for each result
    #[arg(long, global = true)]
    pub(crate) json: bool,
    #[command(subcommand)]
    pub(crate) command: Command,
}

/// The heading of the options that every command has, in its help.
const CONNECTION: &str = "Connection";

/// The TLS of the connection.
#[derive(clap::Args, Clone, Default, Debug)]
pub(crate) struct TlsArguments {
    /// Connect over TLS; the port is 2221 by default. The files are ca.pem, client.pem and client.key in ~/.config/arcline, or those of the
    /// other options, or of the variables ARCLINE_CA, ARCLINE_CERTIFICATE and ARCLINE_KEY. ARCLINE_TLS=1 is the same as --tls
    #[arg(long, global = true, help_heading = CONNECTION)]
    pub(crate) tls: bool,
    /// The authority of the server's certificate
    #[arg(long, global = true, value_name = "FILE.pem", hide_short_help = true, help_heading = CONNECTION)]
    pub(crate) ca: Option<PathBuf>,
    /// The certificate of this client
    #[arg(long, global = true, value_name = "FILE.pem", hide_short_help = true, help_heading = CONNECTION)]
    pub(crate) certificate: Option<PathBuf>,
    /// The private key of that certificate
    #[arg(long, global = true, value_name = "FILE.key", hide_short_help = true, help_heading = CONNECTION)]
    pub(crate) key: Option<PathBuf>,
    /// The name in the server's certificate, where it is not that of --server
    #[arg(long, global = true, value_name = "NAME", hide_short_help = true, help_heading = CONNECTION)]
    pub(crate) server_name: Option<String>,
}

#[derive(Subcommand, Debug)]
pub(crate) enum Command {
    #[command(flatten)]
    Machine(MachineCommand),
    /// Take commands line by line, with history and completion
    #[command(
        after_help = "Tab completes commands, options, tags, instructions, operands and words. A line that is an instruction, such \
        as\nMSO(X, M1), is executed. Lines from a pipe run one after the other.\n\
        Example: arcline shell\n         arcline shell --history off"
    )]
    Shell(Shell),
    #[command(flatten)]
    Local(LocalCommand),
}

/// The commands that ask one server over one connection.
#[derive(Subcommand, Debug)]
pub(crate) enum MachineCommand {
    /// Execute one instruction, written as a Structured Text call
    #[command(
        after_help = "Waits for the end of a move or stop. `exec --help` lists the instructions and their operands.\n\
        Example: arcline exec 'MCLM(CS1, Move1, Absolute, [100, 50, 0], 200, Unitspersec, 2000, Unitspersec2, 2000, \
        Unitspersec2, S-curve, 100, 100, %ofTime)'"
    )]
    Exec(Exec),
    /// Run a Structured Text program
    #[command(
        after_help = "Ends when the last statement has run and all its motion has ended. docs/STRUCTURED_TEXT.md describes the language.\n\
        Example: arcline run square.st"
    )]
    Run(Run),
    /// Move along a straight line (MCLM)
    #[command(
        after_help = "The default is an S-curve at full speed; a number with % is a share of the maximum.\n\
        Example: arcline move CS1 100,50,0 --speed 50%\n         arcline move CS1 -10,0,0 --relative"
    )]
    Move(Move),
    /// Move along an arc or a circle (MCCM)
    #[command(after_help = "Example: arcline arc XY 100,0 --center 50,0 --cw\n         \
        arcline arc XY 0,0 --center 50,0 --ccw --full --speed 80")]
    Arc(Arc),
    /// Move one axis (MAM)
    #[command(
        after_help = "The default is an S-curve at full speed. The move adds to other motion of the axis, unless --merge ends that motion.\n\
        Example: arcline move-axis X 100 --speed 50%\n         arcline move-axis R 90 --shortest"
    )]
    MoveAxis(MoveAxis),
    /// Jog one axis (MAJ) until Ctrl-C, or until another instruction or a fault stops it
    #[command(
        after_help = "The exit code is 0 when another instruction stopped the jog, and 1 when a fault or the server did.\n\
        With --no-wait the command ends at once; `arcline stop X` stops the jog then.\n\
        Example: arcline jog X 50\n         arcline jog X -10% --no-wait"
    )]
    Jog(Jog),
    /// Change the dynamics of the active move (MCCD)
    #[command(after_help = "Example: arcline change CS1 --speed 20%")]
    Change(Change),
    /// Set the feed override of a coordinate system: percent of the programmed speeds, 0 to 200
    #[command(
        after_help = "Applies to active, pending and later moves until the next change; 0 holds them on their path.\n\
        Example: arcline override CS1 50%"
    )]
    Override(Override),
    /// Hold the moves of a coordinate system: they stop on their path and stay active (override 0)
    #[command(after_help = "Example: arcline hold CS1")]
    Hold(System),
    /// Resume after a hold, with the override from before the hold
    #[command(after_help = "Example: arcline resume CS1")]
    Resume(System),
    /// Stop a coordinate system (MCS), an axis (MAS), or everything when none is named
    #[command(
        after_help = "With --hold the server refuses all motion, of every client and program, until `arcline release`.\n\
        Example: arcline stop\n         arcline stop CS1 --type move\n         arcline stop Conveyor\n         arcline stop --hold"
    )]
    Stop(Stop),
    /// Release a STOP that holds: motion may begin again
    #[command(
        after_help = "It releases `arcline stop --hold`, the STOP of the page and the tag MotionInhibit.\n\
        Example: arcline release"
    )]
    Release,
    /// Show the mode of the controller's program, or let it run or stop it
    #[command(
        after_help = "In the mode `program` the tasks do not run, and the change stops all motion. A major fault is cleared by it.\n\
        Example: arcline mode\n         arcline mode run"
    )]
    Mode(Mode),
    /// Switch the servo of axes on (MSO) or off (MSF)
    #[command(
        after_help = "--all means every axis that has a drive; virtual axes have none.\nExample: arcline servo on X Y Z"
    )]
    Servo(Servo),
    /// Inject faults into axes, clear and list them
    #[command(
        subcommand,
        after_help = "An injected cause stays until `arcline fault clear`.\nExample: arcline fault inject X overcurrent"
    )]
    Fault(FaultCommand),
    /// Home axes (MAH), all at the same time, by the sequence of the server's configuration
    #[command(
        after_help = "A passive sequence ends when another motion moves the axis to its home event.\n\
        Example: arcline home X Y"
    )]
    Home(Home),
    /// Show axes, coordinate systems, the group, and the health of the real-time thread
    #[command(after_help = "Example: arcline status X CS1")]
    Status(Status),
    /// Watch axes and coordinate systems: a live view on a terminal, lines when piped
    #[command(
        after_help = "Keys: q ends, s stops all motion, p pauses, c clears the trail, Tab shows the next coordinate system.\n\
        Example: arcline watch X Y CS1\n         arcline watch X --for 2 --interval 0.5"
    )]
    Watch(Watch),
    /// List tags; create and delete plain tags
    #[command(
        after_help = "A pattern with * or ? matches whole names, any other text a part of a name; case is ignored.\n\
        Example: arcline tags 'Move*'\n         arcline tags create Recipe REAL[16]"
    )]
    Tags(Tags),
    /// Read tags
    #[command(after_help = "Example: arcline read X.ActualPosition Move1.Position")]
    Read(Read),
    /// Write a tag
    #[command(after_help = "Example: arcline write Move1.Position [100,50,0]")]
    Write(Write),
    /// Run a G-code program, or simulate it, or write it as Structured Text
    #[command(
        after_help = "Known: G0 to G3, G4 P, G17 to G19, G20, G21, G61, G61.1, G64 [P], G90, G91, G90.1, G91.1, F, X Y Z, I J K, R, M2, \
        M30.\nAny other word is an error with its line and column, unless --skip names it. See docs/GCODE.md.\n\
        Example: arcline gcode part.ngc CS1 --simulate\n         arcline gcode part.ngc XY --skip M3,M5,S\n         \
        arcline gcode part.ngc CS1 --emit part.st"
    )]
    Gcode(Gcode),
    /// Record every tick of axes, coordinate systems or single signals into a file
    #[command(
        after_help = "The file is CSV or, for Foxglove and PlotJuggler, MCAP, by its ending. See docs/TRACE.md.\n\
        Example: arcline trace X Y --for 10 -o trace.csv\n         \
        arcline trace CS1 X.PositionError --for 2 --trigger Move1:AC --before 0.5 -o trace.mcap"
    )]
    Trace(Trace),
    /// Show the identity of the server, or of all devices that answer a broadcast
    #[command(after_help = "Example: arcline identify --broadcast 192.168.1.255")]
    Identify(Identify),
}

/// The commands that need no server; `explain` asks one for the error of a tag.
#[derive(Subcommand, Debug)]
pub(crate) enum LocalCommand {
    /// Explain an error: its cause, the meaning of EXERR, and the remedy
    #[command(
        after_help = "With a tag, the command explains the newest error of its instruction. Codes and faults need no server.\n\
        Example: arcline explain 13/4 MCLM\n         arcline explain overcurrent\n         arcline explain Move1"
    )]
    Explain(Explain),
    /// Compute the safety margin to add to the Calculated Data of blended, master driven moves
    #[command(
        after_help = "The master must move by the sum of the Calculated Data and this margin, so that the last move reaches its end. Needs \
        no server.\n\
        Example: arcline margin 5 --master-speed 500 --update-period 2"
    )]
    Margin(Margin),
    /// Draw a trace: the path by speed, and position, velocity, acceleration and jerk over time
    #[command(after_help = "The picture is SVG or PNG, by its ending.\n\
        Example: arcline plot trace.csv -o trace.svg --events events.jsonl\n         arcline plot trace.csv -o trace.png --axes X,Y,Z")]
    Plot(Plot),
    /// Compare two traces: rows by their place, columns by their names
    #[command(
        after_help = "The exit code is 0 for traces that are the same within the tolerance, 1 for others. Needs no server.\n\
        Example: arcline diff expected.csv trace.csv --tolerance 1e-6"
    )]
    Diff(Diff),
    /// Check the ports, rights and real-time settings of this computer, and name each defect and its remedy
    #[command(
        after_help = "Runs `arcline-server doctor` with the same options. The exit code is 0 when nothing is amiss, 1 when something warns, 2 when a server \
        would not start.\n\
        Example: arcline doctor\n         arcline doctor --config machine.toml --measure 10"
    )]
    Doctor(Doctor),
    /// Print completions for a shell
    #[command(after_help = "Example: arcline completions bash > ~/.local/share/bash-completion/completions/arcline")]
    Completions(Completions),
    /// Print the manual page, or write a page for each command
    #[command(after_help = "Example: arcline man -o ~/.local/share/man/man1\n         arcline man")]
    Man(Man),
}

#[cfg(test)]
mod tests;
