//! docs/IO.md: the assemblies, written from the tables of [`layout`](super::layout).

use std::fmt::Write as _;

use super::layout::{AXIS, CONFIGURATION, FIELD, Field, HEAD, INPUT, INPUT_ONLY, LISTEN_ONLY, OUTPUT, SYSTEM};

/// docs/IO.md: what a scanner needs to know.
pub fn io_page() -> String {
    let mut out = String::new();
    // Writing to a String cannot fail.
    let _ = write(&mut out);
    out
}

fn write(out: &mut String) -> std::fmt::Result {
    out.push_str(INTRODUCTION);
    writeln!(
        out,
        "| connection | path | O→T size | T→O size | how many |\n|---|---|---|---|---|"
    )?;
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
        writeln!(
            out,
            "| {name} | `20 04 24 {CONFIGURATION:02X} 2C {point:02X} 2C {INPUT:02X}` | {size} | input + 2 | {count} |"
        )?;
    }
    out.push_str(CONNECTIONS);
    writeln!(
        out,
        "\n## Input assembly, instance {INPUT} (0x{INPUT:02X})\n\n\
         With s coordinate systems and a axes it has {} + {} s + {} a bytes. Numbers are little-endian, four bytes each.\n",
        HEAD.len() * FIELD,
        SYSTEM.len() * FIELD,
        AXIS.len() * FIELD
    )?;
    table(out, "At the beginning", &HEAD)?;
    table(out, "Then for each coordinate system, in configuration order", &SYSTEM)?;
    table(out, "Then for each axis, in configuration order", &AXIS)?;
    writeln!(
        out,
        "\n## Output assembly, instance {OUTPUT} (0x{OUTPUT:02X})\n\nWith s coordinate systems it has {FIELD} + {FIELD} s bytes.\n"
    )?;
    out.push_str(OUTPUTS);
    Ok(())
}

fn table<T>(out: &mut String, title: &str, fields: &[Field<T>]) -> std::fmt::Result {
    writeln!(out, "{title}:\n\n| offset | type | name | meaning |\n|---|---|---|---|")?;
    for (index, field) in fields.iter().enumerate() {
        writeln!(
            out,
            "| {} | {} | `{}` | {} |",
            index * FIELD,
            field.type_name(),
            field.name,
            field.meaning
        )?;
    }
    out.push('\n');
    Ok(())
}

const INTRODUCTION: &str = "# Implicit I/O

A scanner (a controller with a generic Ethernet module, a test program) exchanges data with Arcline in cycles: it opens a class 1
connection with a Forward Open over TCP, and both send a UDP datagram every requested packet interval (RPI). This page is
written by a test from the code.

## Connections

";

const CONNECTIONS: &str = "
Sizes are those of the Forward Open, in bytes: class 1 adds 2 to the data for the sequence count, the run/idle header of the
owner adds 4. Class 0 does without the sequence count. A wrong size is refused with 0x0127 or 0x0128 and the right size as
second word. An electronic key, a port segment `01 00` and a configuration of no bytes may be there or not.

- Datagrams go to UDP port 2222 (`[server] io`), and leave from there; item 0x8000 of the reply tells the port. Inputs go to the
  originator's address and port 2222, or to the port in item 0x8001 of its request. On one host with the server, where the
  server has port 2222 of the address, they go to the port that its first datagram came from.
- T→O may be multicast, O→T is point-to-point (otherwise 0x0123). The reply then has the group in item 0x8001 and a T→O id that
  Arcline chose: the first address of attribute 9 of class 0xF5, UDP port 2222. Connections with the same interval, class and
  trigger are sent one datagram together.
- The trigger is cyclic or change of state. A change of state leaves within a millisecond, but not sooner after the one before
  than the production inhibit time (`43 nn`, ms, in front of the path; a quarter of the RPI where it is left out); without one
  the RPI sends, with the sequence count of before. `Tick` is no change. The application trigger is refused with 0x011D.
- The RPI is 1 ms or more, and kept as it is confirmed, on an absolute schedule; a shorter one is refused with 0x0111. Where more than
  one datagram of a hundred leaves late, because the machine grants no priority or is too busy, the shortest RPI that is
  confirmed doubles each second until they are in time, up to 32 ms. The first
  datagram leaves right after the reply of the Forward Open. Data is of the newest tick, so that an RPI below the coarse
  update period repeats some.
- The RPI is at most 10 s (otherwise 0x0111), and RPI times multiplier at most 60 s (otherwise 0x0133). The server ends a connection
  whose originator sends nothing for RPI times multiplier, or sends no first datagram within 10 s; it sends no Forward Close. The
  connection outlives the TCP connection that opened it. Only the address that opened it may close it and send on it.
- There are at most 64 connections.

An owner is *in run* while bit 0 of its run/idle header is 1. When it goes idle, is silent for too long, or closes its connection,
having been in run, its outputs are lost, and motion does what `[server] io_loss` says:

| `io_loss` | motion |
|---|---|
| `\"stop\"` (the default) | everything that moves is stopped, every axis by itself at its maximum deceleration |
| `\"hold\"` | the feed override of every coordinate system becomes 0; moves go on when it is raised. Axes that move by themselves have no override and go on |
| `\"finish\"` | goes on to its end |
";

const OUTPUTS: &str = "| offset | type | name | meaning |
|---|---|---|---|
| 0 | UDINT | `Command` | bits, see below |
| 4 + 4 n | REAL | `FeedOverride[n]` | percent, 0 to 200, of the coordinate system n in configuration order |

| bit of `Command` | name | when |
|---|---|---|
| 0 | Hold | rises: the feed override of every coordinate system becomes 0. While it is 1, `FeedOverride` is not taken; when it falls, it is |
| 1 | Resume | rises: every coordinate system that is held gets the override it had before |
| 2 | Stop | rises: everything that moves is stopped, every axis by itself at its maximum deceleration. It comes last |
| 3 | Override | while it is 1: `FeedOverride` is taken when the bit rises and when one of its values changes |

Bits are compared with those before; of a new owner, with 0. Attribute 3 of class 0x04 reads both assemblies; it sets the
output, as an owner in run would, as long as nobody owns it (otherwise 0x0C). Attribute 4 is the size.
";
