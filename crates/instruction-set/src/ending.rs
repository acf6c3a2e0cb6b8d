//! The cause that ended an instruction before its end, in words: for people, and for the wire.
//!
//! Not here: the controller's decision to end an instruction, and its time.

use std::fmt;

use crate::{FAULTS, FaultSet, Mnemonic};

/// The cause that ended an instruction before its end.
#[derive(Clone, PartialEq, Eq, Debug)]
pub enum Ending {
    /// Another instruction: one that stops, or one that takes its place.
    Instruction {
        /// The other instruction.
        mnemonic: Mnemonic,
        /// Its motion control tag; empty: none.
        tag: String,
    },
    /// Faults of an axis.
    Fault {
        /// The axis.
        axis: String,
        /// The faults.
        faults: FaultSet,
    },
    /// A stop of the whole machine, by no instruction.
    StopAll,
    /// The end of a jog, by no instruction.
    Jog(JogEnd),
}

/// The reason for which the server ends a jog by itself, at full deceleration.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum JogEnd {
    /// The dead-man switch: the page no longer confirms that the button is pressed.
    Released,
    /// The client that began it was silent for longer than `jog_silence_ms`.
    Silent,
    /// The connection of the client that began it is lost.
    Lost,
}

impl JogEnd {
    /// All of them.
    pub const ALL: [JogEnd; 3] = [JogEnd::Released, JogEnd::Silent, JogEnd::Lost];

    /// The word of it on the wire.
    #[must_use]
    pub const fn word(self) -> &'static str {
        match self {
            JogEnd::Released => "released",
            JogEnd::Silent => "silent",
            JogEnd::Lost => "lost",
        }
    }

    /// A sentence about it, after "a jog is stopped: ".
    #[must_use]
    pub const fn reason(self) -> &'static str {
        match self {
            JogEnd::Released => "its button was not kept pressed",
            JogEnd::Silent => "its client was silent for too long",
            JogEnd::Lost => "its client is lost",
        }
    }
}

impl Ending {
    /// The words of faults, in the order of [`FAULTS`].
    pub fn words(faults: FaultSet) -> Vec<&'static str> {
        faults.kinds().map(|kind| kind.fault().word).collect()
    }

    /// The parts for the wire: a code, the name of the motion control tag or of the axis, and the mnemonic or the faults.
    pub fn to_parts(&self) -> (u8, &str, String) {
        match self {
            Ending::Instruction { mnemonic, tag } => (INSTRUCTION, tag, mnemonic.name().to_owned()),
            Ending::Fault { axis, faults } => (FAULT, axis, Ending::words(*faults).join(" ")),
            Ending::StopAll => (STOP_ALL, "", String::new()),
            Ending::Jog(end) => (JOG, "", end.word().to_owned()),
        }
    }

    /// The cause of parts from the wire; `None` for an unknown code, and for no cause.
    pub fn from_parts(code: u8, name: &str, what: &str) -> Option<Ending> {
        match code {
            INSTRUCTION => Some(Ending::Instruction {
                mnemonic: what.parse().ok()?,
                tag: name.to_owned(),
            }),
            FAULT => {
                let known = |word: &str| FAULTS.iter().find(|fault| fault.word == word).map(|fault| fault.kind);
                let faults = what.split_whitespace().filter_map(known);
                Some(Ending::Fault {
                    axis: name.to_owned(),
                    faults: faults.fold(FaultSet::default(), FaultSet::with),
                })
            }
            STOP_ALL => Some(Ending::StopAll),
            JOG => {
                let end = JogEnd::ALL.into_iter().find(|end| end.word() == what);
                end.map(Ending::Jog)
            }
            _ => None,
        }
    }
}

/// `stopped by MCS Stop1`, `superseded by MCLM Move2`, `stopped by a fault: X soft_travel_positive`, `stopped by the dead-man switch: its
/// button was not kept pressed`.
impl fmt::Display for Ending {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Ending::Instruction { mnemonic, tag } => {
                let blank = if tag.is_empty() { "" } else { " " };
                write!(f, "{} by {mnemonic}{blank}{tag}", verb(*mnemonic))
            }
            Ending::Fault { axis, faults } => {
                write!(f, "stopped by a fault: {axis} {}", Ending::words(*faults).join(", "))
            }
            Ending::StopAll => f.write_str("stopped by a stop of the whole machine"),
            Ending::Jog(JogEnd::Lost) => f.write_str("stopped by the loss of its client"),
            Ending::Jog(end) => write!(f, "stopped by the dead-man switch: {}", end.reason()),
        }
    }
}

/// The effect of an instruction on another one that it ends, as a verb.
fn verb(mnemonic: Mnemonic) -> &'static str {
    use Mnemonic::{Mas, Masd, Mcs, Mcsd, Mgs, Mgsd, Mgsp, Msf};
    match mnemonic {
        Mcs | Mas | Mgs | Mgsp | Mcsd | Masd | Mgsd | Msf => "stopped",
        mnemonic if mnemonic.instruction().bits.contains(&crate::Flag::Ip) => "superseded",
        _ => "ended",
    }
}

const INSTRUCTION: u8 = 1;
const FAULT: u8 = 2;
const STOP_ALL: u8 = 3;
const JOG: u8 = 4;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::FaultKind;

    #[test]
    fn endings_are_told_and_travel() {
        let by = |mnemonic, tag: &str| Ending::Instruction {
            mnemonic,
            tag: tag.to_owned(),
        };
        let fault = Ending::Fault {
            axis: "X".to_owned(),
            faults: FaultSet::default()
                .with(FaultKind::Overcurrent)
                .with(FaultKind::SoftTravelPositive),
        };
        #[rustfmt::skip]
        let cases = [
            (by(Mnemonic::Mcs, "Stop1"),  "stopped by MCS Stop1"),
            (by(Mnemonic::Mas, ""),       "stopped by MAS"),
            (by(Mnemonic::Mclm, "Move2"), "superseded by MCLM Move2"),
            (by(Mnemonic::Mrp, "R"),      "ended by MRP R"),
            (fault,                       "stopped by a fault: X soft_travel_positive, overcurrent"),
            (Ending::StopAll,             "stopped by a stop of the whole machine"),
            (Ending::Jog(JogEnd::Released), "stopped by the dead-man switch: its button was not kept pressed"),
            (Ending::Jog(JogEnd::Silent), "stopped by the dead-man switch: its client was silent for too long"),
            (Ending::Jog(JogEnd::Lost),   "stopped by the loss of its client"),
        ];
        for (ending, text) in cases {
            assert_eq!(ending.to_string(), text);
            let (code, name, what) = ending.to_parts();
            assert_eq!(Ending::from_parts(code, name, &what), Some(ending.clone()));
        }
        assert_eq!(Ending::from_parts(4, "", "none"), None, "no such end of a jog");
        assert_eq!(Ending::from_parts(0, "", ""), None, "it has not ended this way");
    }
}
