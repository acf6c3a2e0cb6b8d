//! The parts of the help that come from the instruction catalogue.

use clap::CommandFactory;

use arcline_instruction_set::{Kind, Mnemonic, enumerations};

use super::Arguments;

/// The command, with the parts of its help that come from the catalogue.
pub(crate) fn command() -> clap::Command {
    let described = |command: clap::Command| {
        let termination = format!("Termination type: {}", enumerations::TERMINATION_TYPE.choices());
        let merge = format!("Merge: {}", enumerations::MERGE.choices());
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
pub(super) fn instructions() -> String {
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
                text.push_str(&format!("      {}: {}\n", operand.member(), words.choices()));
            }
        }
    }
    text
}
