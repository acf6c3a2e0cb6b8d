//! The handle of a structure, as Logix computes it and as clients do that write structures without asking for the template
//! first (gologix): CRC-16 over a text that names the types of the members in order, not their names.
//!
//! Not here: the offsets that clients read from the template. Lengths are bytes.

use std::fmt::{self, Write};

use crate::{DataType, STRING_HANDLE, Template};

/// As much of a type's text counts. Types that nest in types make texts that grow without bound; the handle of a structure of ten thousand
/// members is not worth its time.
const TEXT: usize = 64 << 10;

/// The handle of a structure type (Rockwell, "Type Encoding of Logix Structures in CIP Data Table R/W").
pub(crate) fn handle(template: &Template) -> u16 {
    let mut text = Checksum { crc: 0, room: TEXT };
    // An error says that there is no more room.
    let _ = describe(template, &template.name, &mut text);
    // 0 reads as "no handle" and 0x0FCE makes clients take the structure for a STRING.
    match text.crc {
        0 | STRING_HANDLE => text.crc ^ 0x8000,
        crc => crc,
    }
}

/// Writes the text of a type: its name, then a comma and the type of each member, a structure's with all that is in it.
/// BOOLs stand in their host, which is a member of its own.
fn describe(template: &Template, name: &str, text: &mut impl Write) -> fmt::Result {
    text.write_str(name)?;
    for member in template.members.iter().filter(|member| member.bit.is_none()) {
        text.write_char(',')?;
        match &member.data_type {
            DataType::Structure(inner) => describe(inner, member.data_type.name(), text)?,
            DataType::Elementary(kind) => text.write_str(kind.name())?,
        }
        if member.dimension != 0 {
            write!(text, "[{}]", member.dimension)?;
        }
    }
    Ok(())
}

/// CRC-16 (reflected 0xA001, from 0) of the written text.
struct Checksum {
    crc: u16,
    room: usize,
}

impl Write for Checksum {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        self.room = self.room.checked_sub(text.len()).ok_or(fmt::Error)?;
        self.crc = text.bytes().fold(self.crc, |crc, byte| {
            (crc >> 8) ^ TABLE[usize::from(crc.to_le_bytes()[0] ^ byte)]
        });
        Ok(())
    }
}

/// The remainder of each byte.
const TABLE: [u16; 256] = {
    let mut table = [0; 256];
    let mut byte = 0;
    while byte < table.len() {
        let mut crc = byte as u16;
        let mut bit = 0;
        while bit < 8 {
            crc = if crc & 1 == 0 { crc >> 1 } else { (crc >> 1) ^ 0xA001 };
            bit += 1;
        }
        table[byte] = crc;
        byte += 1;
    }
    table
};

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::{Elementary, TemplateBuilder, string_template};

    fn text(template: &Template) -> String {
        let mut text = String::new();
        describe(template, &template.name, &mut text).expect("a String takes everything");
        text
    }

    /// The example of the vendor's paper.
    fn udt1() -> Arc<Template> {
        let udt3 = TemplateBuilder::new("UDT3", 0x103)
            .member("U3A", Elementary::Sint)
            .array("U3B", Elementary::Sint, 4)
            .build();
        let udt2 = TemplateBuilder::new("UDT2", 0x102)
            .member("U2A", Elementary::Dint)
            .array("U2B", Elementary::Sint, 3)
            .member("U2C", udt3.clone())
            .array("U2D", udt3.clone(), 2)
            .build();
        TemplateBuilder::new("UDT1", 0x101)
            .member("U1A", Elementary::Sint)
            .array("U1B", Elementary::Sint, 2)
            .member("U1C", udt2)
            .array("U1D", udt3, 4)
            .build()
    }

    #[test]
    fn handles_are_those_that_a_controller_has_and_gologix_computes() {
        let flags = TemplateBuilder::new("TestUDT2", 0x100)
            .member("Field1", Elementary::Dint)
            .member("Flag1", Elementary::Bool)
            .member("Flag2", Elementary::Bool)
            .member("Field2", Elementary::Dint)
            .build();
        let timer = TemplateBuilder::new("TIMER", 0xF83)
            .member_at("CTL", Elementary::Dint, 0, 0)
            .bit_at("EN", 0, 31)
            .bit_at("TT", 0, 30)
            .bit_at("DN", 0, 29)
            .member_at("PRE", Elementary::Dint, 0, 4)
            .member_at("ACC", Elementary::Dint, 0, 8)
            .build();
        let with_timer = TemplateBuilder::new("TimerWrapper", 0x100).member("TON", timer).build();
        let with_string = TemplateBuilder::new("StringWrapper", 0x100)
            .member("String", string_template())
            .build();
        #[rustfmt::skip]
        let cases = [
            (udt1(), 0x5F58, "UDT1,SINT,SINT[2],UDT2,DINT,SINT[3],UDT3,SINT,SINT[4],UDT3,SINT,SINT[4][2],UDT3,SINT,SINT[4][4]"),
            (with_timer, 0xC23B, "TimerWrapper,TIMER,DINT,DINT,DINT"),
            (with_string, 0x45FD, "StringWrapper,STRING,DINT,SINT[82]"),
            (flags, 0xFC31, "TestUDT2,DINT,SINT,DINT"),
        ];
        for (template, handle, expected) in cases {
            assert_eq!(text(&template), expected);
            assert_eq!(template.handle, handle, "{:04X} of {expected}", template.handle);
        }
    }

    #[test]
    fn a_text_that_doubles_with_each_level_is_cut() {
        let doubled = (0..14).fold(udt1(), |template, level| {
            TemplateBuilder::new(format!("Level{level}"), 0x200)
                .member("A", template.clone())
                .member("B", template)
                .build()
        });
        let mut sum = Checksum { crc: 0, room: TEXT };
        assert!(
            describe(&doubled, &doubled.name, &mut sum).is_err(),
            "{} left",
            sum.room
        );
        assert_ne!(doubled.handle, 0);
    }
}
