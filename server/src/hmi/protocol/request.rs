//! The requests of a page: one struct for each, with the type of its answer.

use serde::Deserialize;
use serde_json::{Map, Value};

use super::Asks;
use super::answer::{
    CallLine, Checked, Done, EventPage, Executed, HistoryPiece, RoutineList, RoutinePage, Signals, Simulated, TagPage,
    UseList, Values,
};

/// Makes [`Request`], a struct for each of its variants, and the answer type of each.
macro_rules! requests {
    ($(
        $(#[$about:meta])*
        $name:ident { $( $(#[$about_field:meta])* $field:ident: $kind:ty, )* } -> $answer:ty;
    )*) => {
        /// A request, by its `do`.
        #[derive(Deserialize, Debug)]
        #[serde(tag = "do", rename_all = "snake_case")]
        pub(crate) enum Request {
            $( $(#[$about])* $name($name), )*
        }

        $(
            $(#[$about])*
            #[derive(Deserialize, Debug)]
            #[cfg_attr(test, derive(schemars::JsonSchema))]
            pub(crate) struct $name {
                $( $(#[$about_field])* pub(crate) $field: $kind, )*
            }

            impl Asks for $name {
                type Answer = $answer;
            }
        )*

        /// Name, request and answer of each request, in the order above.
        #[cfg(test)]
        pub(super) fn rows(schemas: &mut super::typescript::Schemas) -> Vec<super::typescript::Row> {
            vec![$( schemas.row::<$name, $answer>(stringify!($name)), )*]
        }
    };
}

requests! {
    /// Asks for a sign of life.
    Ping {} -> Done;
    /// Says that a person is at the page: without that its session is locked after a time.
    Active {} -> Done;
    /// Takes control of a coordinate system and its axes, of one axis, or of the group.
    Take {
        /// Name of the coordinate system, axis or group.
        object: String,
        /// Takes control even if another viewer has it.
        #[serde(default)]
        force: bool,
    } -> Done;
    /// Gives control back.
    Release {
        /// Name of the object as it was taken.
        object: String,
    } -> Done;
    /// Executes one instruction. Stops need no control.
    Execute {
        /// One call as Structured Text.
        text: String,
    } -> Executed;
    /// Makes the line of Structured Text of a filled form and checks it.
    Line {
        /// Mnemonic.
        instruction: String,
        /// Values by the members of the operands; an operand that is left out has its first value.
        #[serde(default)]
        operands: Map<String, Value>,
    } -> CallLine;
    /// Jogs an axis while `keep` comes at least every 150 ms, until `jog_end`.
    Jog {
        /// Name of the axis.
        axis: String,
        /// Speed with its sign, position units/s.
        speed: f64,
        /// Acceleration, position units/s²; without it the axis's maximum.
        accel: Option<f64>,
        /// Deceleration, position units/s²; without it the axis's maximum.
        decel: Option<f64>,
    } -> Done;
    /// Confirms a jog: the button is still pressed.
    Keep {
        /// Name of the axis.
        axis: String,
    } -> Done;
    /// Ends a jog: the button is released.
    JogEnd {
        /// Name of the axis.
        axis: String,
    } -> Done;
    /// Stops one object; without an object it stops everything, the program included, and inhibits motion until `release_stop`. Needs no
    /// control.
    Stop {
        /// Name of the coordinate system, axis or group.
        object: Option<String>,
    } -> Done;
    /// Releases a STOP of everything: instructions may begin motion again. Needs no control.
    ReleaseStop {} -> Done;
    /// Sets the feed override of a coordinate system.
    Override {
        /// Name of the coordinate system.
        coordinate_system: String,
        /// Percent of the programmed speeds.
        percent: f64,
    } -> Done;
    /// Sets the feed override to 0. Needs no control.
    Hold {
        /// Name of the coordinate system.
        coordinate_system: String,
    } -> Done;
    /// Sets the feed override that was in force before a hold.
    Resume {
        /// Name of the coordinate system.
        coordinate_system: String,
    } -> Done;
    /// Simulates one instruction from the present state. Nothing moves.
    Preview {
        /// One call as Structured Text.
        text: String,
    } -> Simulated;
    /// Simulates a program from the present state. Nothing moves.
    DryRun {
        /// A program as Structured Text.
        text: String,
    } -> Simulated;
    /// Checks a program.
    Check {
        /// A program as Structured Text.
        text: String,
    } -> Checked;
    /// Runs a program. The server runs one program at a time.
    Run {
        /// A program as Structured Text.
        text: String,
        /// Pauses in front of the first statement.
        #[serde(default, alias = "paused")]
        step: bool,
    } -> Done;
    /// Executes one statement of the program.
    Step {} -> Done;
    /// Pauses the program in front of the next statement.
    Pause {} -> Done;
    /// Continues the program.
    Continue {} -> Done;
    /// Ends the program; motion that it began goes on.
    End {} -> Done;
    /// Lists tags, 200 at a time, in the order of their names.
    Tags {
        /// Part of the name in any case, at most 100 bytes; `*` stands for any text, at most 8 times.
        #[serde(default)]
        pattern: String,
        /// The name behind which the list begins.
        after: Option<String>,
    } -> TagPage;
    /// Reads tags once.
    Read {
        /// At most 200 names.
        names: Vec<String>,
    } -> Values;
    /// Reads tags now, and pushes as `values` those that have changed, at most ten times a second; instead of those watched before.
    Watch {
        /// At most 200 names.
        names: Vec<String>,
    } -> Values;
    /// Writes a tag.
    Write {
        /// Name of the tag, of its member or of one element.
        tag: String,
        /// A number, boolean or text; a whole number beyond 2⁵³ as text.
        value: Value,
    } -> Done;
    /// Lists the tasks, programs and routines of the controller's own program.
    Routines {} -> RoutineList;
    /// Reads rungs or lines of a routine as they are written, at most 100.
    Rungs {
        /// Number of the routine.
        routine: u32,
        /// Index of the first one, from 0.
        from: usize,
        /// Number of rungs or lines.
        count: usize,
    } -> RoutinePage;
    /// Watches rungs or lines of a routine, at most 100: their power flow and values are pushed as `look` when they have changed, at most
    /// five times a second, in place of those watched before. Without a routine it ends.
    Look {
        /// Number of the routine.
        routine: Option<u32>,
        /// Index of the first rung or line, from 0.
        #[serde(default)]
        from: usize,
        /// Number of rungs or lines.
        #[serde(default)]
        count: usize,
        /// Version of the program that the numbers are of.
        #[serde(default)]
        version: u64,
        /// Instance of the add-on instruction whose values are shown.
        instance: Option<String>,
    } -> Done;
    /// Lists where a tag of the controller's own program, a part of it, or the whole that it is a part of is used.
    Uses {
        /// Name of the tag or of its part.
        tag: String,
        /// Program in whose scope it is named; without one it is that of the controller.
        program: Option<String>,
    } -> UseList;
    /// Lets the controller's own program run, or stops it and all motion.
    Mode {
        /// `true` lets the program run, `false` stops it.
        run: bool,
    } -> Done;
    /// Forces an input of a module: the controller's own program sees this value.
    Force {
        /// Name of the input, such as `Local:1:I.Data.0`.
        tag: String,
        /// A number or boolean; null removes the force.
        value: Value,
    } -> Done;
    /// Removes all forces.
    RemoveForces {} -> Done;
    /// Begins or ends the binary frames of samples.
    Trace {
        /// `true` begins the frames, `false` ends them.
        on: bool,
    } -> Signals;
    /// Asks for the newest samples before a tick: a binary frame comes, then the answer. At most two may wait to be read.
    History {
        /// The tick.
        before: u64,
    } -> HistoryPiece;
    /// Lists the newest 1,000 events.
    Events {
        /// The `seq` behind which the list begins.
        since: Option<u64>,
    } -> EventPage;
}
