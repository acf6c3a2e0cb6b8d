//! The requests of a page: one struct for each, with the type of its answer.

use serde::Deserialize;
use serde_json::{Map, Value};

use super::Asks;
use super::answer::{
    CallLine, Checked, Done, EventPage, Executed, HistoryPiece, RoutineList, RoutinePage, SessionList, Signals,
    Simulated, TagPage, UseList, Values,
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
    /// Tests the connection: the answer is empty.
    Ping {} -> Done;
    /// Reports the input of a person. Without such reports the server locks the session after a time.
    Active {} -> Done;
    /// Lists the sessions of the page: users who have logged in, and scripts that show a token.
    Sessions {} -> SessionList;
    /// Ends a session, at once. A script may begin another one until its token is removed.
    EndSession {
        /// Number of the session.
        session: u64,
    } -> Done;
    /// Takes control of a coordinate system and its axes, of one axis, or of the group.
    Take {
        /// Name of the coordinate system, axis or group.
        object: String,
        /// Takes control even if another viewer has it.
        #[serde(default)]
        force: bool,
    } -> Done;
    /// Releases control of an object.
    Release {
        /// Name of the object, as in `take`.
        object: String,
    } -> Done;
    /// Executes one instruction. Stops need no control.
    Execute {
        /// One call as Structured Text.
        text: String,
    } -> Executed;
    /// Writes the values of a form as one line of Structured Text and checks it.
    Line {
        /// Mnemonic.
        instruction: String,
        /// Values by the member names of the operands; an omitted operand has its first value.
        #[serde(default)]
        operands: Map<String, Value>,
    } -> CallLine;
    /// Jogs an axis until `jog_end`. The page must send `keep` at least every 150 ms.
    Jog {
        /// Name of the axis.
        axis: String,
        /// Speed with its sign, position units/s.
        speed: f64,
        /// Acceleration, position units/s²; default: the maximum of the axis.
        accel: Option<f64>,
        /// Deceleration, position units/s²; default: the maximum of the axis.
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
    /// Stops one object. Without an object it stops all motion and the program, and inhibits motion until `release_stop`. Needs no control.
    Stop {
        /// Name of the coordinate system, axis or group.
        object: Option<String>,
    } -> Done;
    /// Releases the STOP of all motion: instructions can begin motion again. Needs no control.
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
    /// Restores the feed override from before the hold.
    Resume {
        /// Name of the coordinate system.
        coordinate_system: String,
    } -> Done;
    /// Simulates one instruction from the present state. The machine does not move.
    Preview {
        /// One call as Structured Text.
        text: String,
    } -> Simulated;
    /// Simulates a program from the present state. The machine does not move.
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
        /// Whether the program pauses before its first statement.
        #[serde(default, alias = "paused")]
        step: bool,
    } -> Done;
    /// Executes one statement of the program.
    Step {} -> Done;
    /// Pauses the program before the next statement.
    Pause {} -> Done;
    /// Continues the program.
    Continue {} -> Done;
    /// Ends the program. Motion that it began continues.
    End {} -> Done;
    /// Lists tags, 200 at a time, in the order of their names.
    Tags {
        /// Part of the name in any case, at most 100 bytes; `*` stands for any text, at most 8 times.
        #[serde(default)]
        pattern: String,
        /// The list begins after this name.
        after: Option<String>,
    } -> TagPage;
    /// Reads tags once.
    Read {
        /// At most 200 names.
        names: Vec<String>,
    } -> Values;
    /// Reads tags and watches them in place of those watched before: the push `values` has those that have changed, at most ten times a
    /// second.
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
    /// Reads the source of at most 100 rungs or lines of a routine.
    Rungs {
        /// Number of the routine.
        routine: u32,
        /// Index of the first one, from 0.
        from: usize,
        /// Number of rungs or lines.
        count: usize,
    } -> RoutinePage;
    /// Watches at most 100 rungs or lines of a routine in place of those watched before: the push `look` has the power flow and values of
    /// those that have changed, at most five times a second. Without a routine the viewer watches none.
    Look {
        /// Number of the routine.
        routine: Option<u32>,
        /// Index of the first rung or line, from 0.
        #[serde(default)]
        from: usize,
        /// Number of rungs or lines.
        #[serde(default)]
        count: usize,
        /// Version of the program to which the numbers belong.
        #[serde(default)]
        version: u64,
        /// Instance of the add-on instruction whose values are shown.
        instance: Option<String>,
    } -> Done;
    /// Lists the uses of a tag of the controller's own program, of its parts, and of the tags that it is a part of.
    Uses {
        /// Name of the tag or of its part.
        tag: String,
        /// Program whose scope has the tag; default: the scope of the controller.
        program: Option<String>,
    } -> UseList;
    /// Starts the controller's own program (Run mode), or stops it and all motion (Program mode).
    Mode {
        /// `true` starts the program, `false` stops it.
        run: bool,
    } -> Done;
    /// Forces an input of a module: the controller's own program reads the forced value.
    Force {
        /// Name of the input, such as `Local:1:I.Data.0`.
        tag: String,
        /// A number or boolean; null removes the force.
        value: Value,
    } -> Done;
    /// Removes all forces.
    RemoveForces {} -> Done;
    /// Starts or ends the binary frames of samples.
    Trace {
        /// `true` starts the frames, `false` ends them.
        on: bool,
    } -> Signals;
    /// Requests the newest samples before a tick. The server sends a binary frame, then the answer. At most two frames of a viewer may wait.
    History {
        /// The tick.
        before: u64,
    } -> HistoryPiece;
    /// Lists the newest 1,000 events.
    Events {
        /// The list begins after this `seq`.
        since: Option<u64>,
    } -> EventPage;
}
