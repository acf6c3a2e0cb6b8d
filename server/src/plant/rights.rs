//! Rights: the actions of a principal on the machine or the server, and the least role that may perform each (spec/security.md §6).
//!
//! One table: [`Right`] and its `match`es. Every command of the plant needs one right ([`Right::of_command`], exhaustive), and so does every
//! request of the page and every service of a CIP object that is not a command. The table of docs/SECURITY.md and the matrix of the
//! tests derive from it. `control` decides which viewer may move an axis at present.

use arcline_config::Role;
use arcline_controller::image::{Image, TagId, TagKind, Writers};
use arcline_instruction_set::Mnemonic;

use super::command::{Call, Command};

/// Makes [`Right`] with the least role and the description of each.
macro_rules! rights {
    ($( $name:ident: $least:ident, $code:literal, $may:literal; )*) => {
        /// An action that a role may or may not perform.
        #[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
        pub enum Right {
            $( #[doc = $may] $name, )*
        }

        impl Right {
            /// Every right, in the order of docs/SECURITY.md.
            pub const ALL: &[Right] = &[$( Right::$name, )*];

            /// The least role that has it.
            pub const fn least(self) -> Role {
                match self { $( Self::$name => Role::$least, )* }
            }

            /// Its name in logs, the audit and refusals.
            pub const fn name(self) -> &'static str {
                match self { $( Self::$name => $code, )* }
            }

            /// The actions that the right permits a client.
            pub const fn may(self) -> &'static str {
                match self { $( Self::$name => $may, )* }
            }
        }
    };
}

rights! {
    Look:              Viewer,        "look",                "read tags, attributes, traces and the page; open class 3, input-only and listen-only connections; identify the client; check and simulate programs";
    Stop:              Viewer,        "stop",                "STOP, hold, MAS, MCS and MGS (as services, by `EnableIn` of their tags, on the page); end a jog; pause and end a program";
    WriteTag:          Operator,      "write tags",          "write tags, in whole, in part, by masks or as members of structures, except those in other rows";
    Move:              Operator,      "move",                "execute all other instructions: moves, jogs, servo on and off, shutdown and reset, clearing of faults";
    EngineersTag:      Engineer,      "write tags of engineers", "write and delete tags whose `write_role` is `engineer`";
    AdministratorsTag: Administrator, "write tags of administrators", "write and delete tags whose `write_role` is `administrator`";
    Override:          Operator,      "override",            "set feed overrides up to 100 %; resume";
    StepClock:         Operator,      "step the clock",      "advance the step clock (`--clock step`)";
    ReleaseStop:       Operator,      "release STOP",        "release a STOP";
    OwnOutputs:        Operator,      "own the outputs",     "open the exclusive owner connection of implicit I/O; set the output assembly without a connection";
    TakeControl:       Operator,      "take control",        "take and release control of an axis or a coordinate system on the page";
    SetLoss:           Operator,      "set loss reaction",   "select the reaction of its own motion to the loss of its connection (attribute 100 of class 0x06)";
    TakeByForce:       Engineer,      "take by force",       "take control from another viewer";
    OverrideAbove:     Engineer,      "override above 100",  "set feed overrides above 100 %";
    RunProgram:        Engineer,      "run programs",        "run Structured Text and G-code on the page; step and continue";
    ChangeMode:        Engineer,      "change the mode",     "start and stop the program of the controller (Run and Program mode)";
    Force:             Engineer,      "force inputs",        "force inputs of modules for the program of the controller, and remove forces";
    ChangeTags:        Engineer,      "change tags",         "create and delete tags";
    SetAttribute:      Engineer,      "set attributes",      "set attributes of motion objects (`CommandPositionTolerance`, …)";
    InjectFaults:      Engineer,      "inject faults",       "inject faults";
    SetUpTrace:        Engineer,      "set up traces",       "create, start, stop and delete traces";
    SetClock:          Engineer,      "set the clock",       "set the wall clock that clients see";
    SetInactivity:     Engineer,      "set inactivity",      "set the inactivity time-out of all connections (attribute 13 of class 0xF5)";
    EndSessions:       Administrator, "end sessions",        "see the sessions of the page, of users and of scripts, and end them";
    Administer:        Administrator, "administer",          "request services of the security objects 0x5D, 0x5E and 0x5F, which are not implemented";
    Serve:             Administrator, "serve",               "reload the configuration and stop the motion of lost clients (the server itself only, not a client)";
}

impl Right {
    /// Whether a role has the right.
    pub fn is_of(self, role: Role) -> bool {
        role >= self.least()
    }

    /// Whether the right permits a change that is not a command of the plant: the interface that grants it records the change in the audit.
    pub(crate) const fn is_of_interface(self) -> bool {
        match self {
            Self::OwnOutputs
            | Self::TakeControl
            | Self::SetLoss
            | Self::TakeByForce
            | Self::RunProgram
            | Self::SetUpTrace
            | Self::SetClock
            | Self::SetInactivity
            | Self::EndSessions
            | Self::Administer => true,
            // Reading changes nothing.
            Self::Look => false,
            Self::Stop
            | Self::WriteTag
            | Self::Move
            | Self::EngineersTag
            | Self::AdministratorsTag
            | Self::Override
            | Self::StepClock
            | Self::ReleaseStop
            | Self::OverrideAbove
            | Self::ChangeMode
            | Self::Force
            | Self::ChangeTags
            | Self::SetAttribute
            | Self::InjectFaults
            | Self::Serve => false,
        }
    }

    /// The right that a command needs, on the tags as they are.
    pub(super) fn of_command(command: &Command<'_>, image: &Image) -> Right {
        match command {
            Command::WriteTag { tag, offset, data } => written(image, *tag, *offset, data),
            Command::WriteBit { tag, offset, bit, on } => match image.tag(*tag).map(|tag| tag.kind) {
                Some(TagKind::Instruction(kind)) if image.is_enable_in(*tag, *offset, *bit) => executed(kind.mnemonic),
                Some(TagKind::MotionInhibit) if *on => Right::Stop,
                Some(TagKind::MotionInhibit) => Right::ReleaseStop,
                Some(TagKind::FaultInject) => Right::InjectFaults,
                // A bit of a number may make it any number.
                Some(TagKind::FeedOverride) => Right::OverrideAbove,
                _ => of_tag(image, *tag),
            },
            Command::SetAttribute { .. } => Right::SetAttribute,
            Command::InjectFaults { .. } => Right::InjectFaults,
            Command::SetFeedOverride { percent, .. } => overridden(*percent),
            Command::Hold(_) | Command::StopAll | Command::Inhibit => Right::Stop,
            Command::Resume(_) => Right::Override,
            Command::Release => Right::ReleaseStop,
            Command::Step { .. } => Right::StepClock,
            Command::Call(Call { mnemonic, .. }) => executed(*mnemonic),
            Command::Execute(call) => executed(call.mnemonic),
            // The instruction was executed before.
            Command::RungFalse(..) => Right::Stop,
            Command::SetMode(_) => Right::ChangeMode,
            Command::Force(_) | Command::RemoveForce(_) => Right::Force,
            Command::DeleteTag(tag) if of_tag(image, *tag) == Right::AdministratorsTag => Right::AdministratorsTag,
            Command::CreateTag(_) | Command::DeleteTag(_) => Right::ChangeTags,
            Command::Reload { .. } | Command::Lose { .. } | Command::Disown(_) => Right::Serve,
        }
    }
}

/// The right that a write of a plain tag needs.
fn of_tag(image: &Image, tag: TagId) -> Right {
    match image.tag(tag).map(|tag| tag.rule.writers) {
        Some(Writers::Engineers) => Right::EngineersTag,
        Some(Writers::Administrators) => Right::AdministratorsTag,
        _ => Right::WriteTag,
    }
}

/// The right that an instruction needs, as a service or by the `EnableIn` of its tag.
fn executed(mnemonic: Mnemonic) -> Right {
    match mnemonic {
        // These instructions only stop. MSF and the shutdowns, by contrast, let go of hanging axes.
        Mnemonic::Mas | Mnemonic::Mcs | Mnemonic::Mgs => Right::Stop,
        _ => Right::Move,
    }
}

/// The right that a feed override needs; another check refuses values that are not numbers.
fn overridden(percent: f32) -> Right {
    if percent > 100.0 {
        Right::OverrideAbove
    } else {
        Right::Override
    }
}

/// The right that a write of bytes to a tag needs.
fn written(image: &Image, tag: TagId, offset: usize, data: &[u8]) -> Right {
    match image.tag(tag).map(|tag| tag.kind) {
        Some(TagKind::MotionInhibit) if data.iter().any(|byte| *byte != 0) => Right::Stop,
        Some(TagKind::MotionInhibit) => Right::ReleaseStop,
        Some(TagKind::FaultInject) => Right::InjectFaults,
        Some(TagKind::ClockStep) => Right::StepClock,
        Some(TagKind::FeedOverride) => {
            let mut bytes = image.bytes(tag).to_vec();
            if let Some(part) = bytes.get_mut(offset..).and_then(|rest| rest.get_mut(..data.len())) {
                part.copy_from_slice(data);
            }
            let first = offset / size_of::<f32>();
            let end = offset.saturating_add(data.len()).div_ceil(size_of::<f32>());
            let (elements, _) = bytes.as_chunks();
            let elements = elements.get(first..end.min(elements.len())).unwrap_or_default();
            let rights = elements.iter().map(|bytes| overridden(f32::from_le_bytes(*bytes)));
            rights.max_by_key(|right| right.least()).unwrap_or(Right::WriteTag)
        }
        // An instruction's tag with all of its operands executes it; alone its EnableIn does.
        _ => of_tag(image, tag),
    }
}

/// The table of docs/SECURITY.md.
#[cfg(test)]
pub(crate) fn page() -> String {
    use std::fmt::Write as _;

    let mut out = String::from("| may | viewer | operator | engineer | administrator |\n|---|---|---|---|---|\n");
    for right in Right::ALL {
        let marks = Role::ALL.map(|role| if right.is_of(role) { " ● |" } else { " |" });
        // Writing to a String cannot fail.
        let _ = writeln!(out, "| {} |{}", right.may(), marks.concat());
    }
    out
}
