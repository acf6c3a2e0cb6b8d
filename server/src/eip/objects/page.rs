//! docs/OBJECTS.md: the CIP objects, written from their table.

use std::fmt::Write as _;

use arcline_instruction_set::Mnemonic;

use super::object::{Object, On};
use super::{OBJECTS, Objects};

/// docs/OBJECTS.md.
pub fn objects_page() -> String {
    let mut out = String::from(INTRODUCTION);
    for object in Objects(&OBJECTS).0 {
        // Writing to a String cannot fail.
        let _ = writeln!(
            out,
            "| 0x{:04X} | {} | {} |",
            object.class(),
            object.name(),
            services(*object).join(", ")
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

const INTRODUCTION: &str = "# CIP objects

These classes answer explicit messages: over a class 3 connection, without a connection, and in Multiple Service Packets. Each has
the services Get Attributes All (0x01), Get Attribute List (0x03), Set Attribute List (0x04), Get Attribute Single (0x0E) and
Set Attribute Single (0x10), and the class attributes 1 to 7. The Multiple Service Packet (0x0A) is a service of the Message Router;
Forward Open (0x54, 0x5B), Forward Close (0x4E) and Unconnected Send (0x52) are services of the Connection Manager. A class that does not exist is refused with 0x05. This page is written by a
test from the code; attributes stand in [the network](spec/ethernet-ip.md), [motion objects](spec/contract.md), [cyclic I/O](IO.md)
and [the trace](TRACE.md).

| class | object | services of its own |
|---|---|---|
";
