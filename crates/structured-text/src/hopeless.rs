//! A WAIT that cannot go on: the end of the instruction that it waits for, as one message for all drivers.

use arcline_instruction_set::{Ending, Flag, Mnemonic, MotionControl, describe};

/// A WAIT whose condition cannot hold any more, since the instructions that it waits for have ended
/// ([`crate::Interpreter::is_hopeless`]).
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
#[error("line {line}: {}", self.problem())]
pub struct Hopeless {
    /// Line of the WAIT, from 1.
    pub line: usize,
    /// The motion control tag that it reads.
    pub tag: String,
    /// The end of its instruction, in words.
    pub how: Box<str>,
}

impl Hopeless {
    /// The message without the line.
    pub fn problem(&self) -> String {
        format!("WAIT can no longer come true: {} {}", self.tag, self.how)
    }

    /// `call`: the execution that the tag shows and the line of its call; `ending`: why it ended before its end.
    pub fn new(
        line: usize,
        tag: &str,
        call: Option<(Mnemonic, usize)>,
        control: &MotionControl,
        ending: Option<&Ending>,
    ) -> Self {
        let what = match call {
            Some((mnemonic, line)) => format!("({mnemonic}, line {line}) "),
            None => String::new(),
        };
        let how = if control.has(Flag::Er) {
            let mnemonic = call.map(|(mnemonic, _)| mnemonic);
            format!("{what}erred: {}", describe(control.err, control.exerr, mnemonic))
        } else if let Some(ending) = ending {
            format!("{what}was {ending}")
        } else if *control == MotionControl::default() {
            "was never executed".to_owned()
        } else if !control.has(Flag::Pc) {
            format!("{what}has ended without PC")
        } else {
            format!("{what}has ended")
        };
        Hopeless {
            line,
            tag: tag.to_owned(),
            how: how.into(),
        }
    }
}
