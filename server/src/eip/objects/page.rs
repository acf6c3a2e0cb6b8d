//! The table of docs/OBJECTS.md: the CIP objects and their services.

use std::fmt::Write as _;

use arcline_instruction_set::Mnemonic;

use super::OBJECTS;
use super::object::{Object, On};

/// The objects, a row each.
pub fn objects() -> String {
    let mut out = String::from("| class | object | services of its own |\n|---|---|---|\n");
    for object in OBJECTS {
        // Writing to a String cannot fail.
        let _ = writeln!(
            out,
            "| 0x{:04X} | {} | {} |",
            object.class(),
            object.name(),
            services(object).join(", ")
        );
    }
    out
}

fn services(object: &dyn Object) -> Vec<String> {
    let own = object.services().iter().map(|own| {
        let on = match own.on {
            On::Class => " on the class",
            On::Instance => " on an instance",
            On::Any => "",
        };
        format!("0x{:02X} {}{on}", own.code, own.name)
    });
    let instructions = Mnemonic::ALL.iter().filter_map(|mnemonic| {
        let (class, code) = mnemonic.instruction().service();
        (class == object.class()).then(|| format!("0x{code:02X} {mnemonic}"))
    });
    own.chain(instructions).collect()
}
