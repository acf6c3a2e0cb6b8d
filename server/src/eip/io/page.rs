//! The tables of docs/IO.md that come from [`layout`](super::layout).

use std::fmt::Write as _;

use super::layout::{AXIS, CONFIGURATION, FIELD, Field, HEAD, INPUT, INPUT_ONLY, LISTEN_ONLY, OUTPUT, SYSTEM};

/// The kinds of connections with their paths.
pub fn connections() -> String {
    let mut out = String::from("| connection | path | O→T size | T→O size | how many |\n|---|---|---|---|---|\n");
    let rows = [
        ("exclusive owner", OUTPUT, "output + 6", "one"),
        ("input only", INPUT_ONLY, "2, or 6 with a run/idle header", "any"),
        (
            "listen only",
            LISTEN_ONLY,
            "2, or 6 with a run/idle header",
            "any, while one of the others is open",
        ),
    ];
    for (name, point, size, count) in rows {
        // Writing to a String cannot fail.
        let _ = writeln!(
            out,
            "| {name} | `20 04 24 {CONFIGURATION:02X} 2C {point:02X} 2C {INPUT:02X}` | {size} | input + 2 | {count} |"
        );
    }
    out
}

/// The input assembly.
pub fn input_assembly() -> String {
    let mut out = format!(
        "## Input assembly, instance {INPUT} (0x{INPUT:02X})\n\n\
         With s coordinate systems and a axes it has {} + {} s + {} a bytes. Numbers are little-endian, four bytes each.\n",
        HEAD.len() * FIELD,
        SYSTEM.len() * FIELD,
        AXIS.len() * FIELD
    );
    table(&mut out, "At the beginning", &HEAD);
    table(
        &mut out,
        "Then for each coordinate system, in configuration order",
        &SYSTEM,
    );
    table(&mut out, "Then for each axis, in configuration order", &AXIS);
    out
}

fn table<T>(out: &mut String, title: &str, fields: &[Field<T>]) {
    out.push_str(&format!(
        "\n{title}:\n\n| offset | type | name | meaning |\n|---|---|---|---|\n"
    ));
    for (index, field) in fields.iter().enumerate() {
        let (offset, kind) = (index * FIELD, field.type_name());
        out.push_str(&format!(
            "| {offset} | {kind} | `{}` | {} |\n",
            field.name, field.meaning
        ));
    }
}
