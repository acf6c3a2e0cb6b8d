//! Wires between tags and axes (spec/programs.md §15): their ends become bits of the memory, or inputs that the host has.

use super::{Compiler, Owner};
use crate::code::{End, FixedBit, Select, Wire};
use crate::error::{Finding, FindingKind};
use crate::expression::Expression;

impl Compiler<'_> {
    /// All wires of the project; an end that leads nowhere is a finding.
    pub(crate) fn wires(&mut self) {
        self.owner = Owner::Program(usize::MAX);
        for wire in &self.project.wires {
            let from = self.fixed_bit(&wire.from).map_err(|reason| (&wire.from, reason));
            let to = match self.directory.axis_input(&wire.to) {
                Some(number) => Ok(End::Input(number)),
                None => self.wire_target(&wire.to).map_err(|reason| (&wire.to, reason)),
            };
            match (from, to) {
                (Ok(from), Ok(to)) => {
                    let delay = u64::from(wire.delay_ms) * 1_000_000;
                    self.code.wires.push(Wire { from, to, delay });
                }
                (Err((name, reason)), _) | (_, Err((name, reason))) => self.findings.push(Finding::new(
                    FindingKind::Error,
                    &format!("wire from {} to {}", wire.from, wire.to),
                    format!("{name}: {reason}"),
                )),
            }
        }
    }

    /// The bit of a tag that a wire writes, and the bit that says that the connection of its module is lost.
    fn wire_target(&mut self, text: &str) -> Result<End, String> {
        let bit = self.fixed_bit(text)?;
        let is_of_axis = self.objects.iter().any(|(at, ..)| {
            let tag = self.tags.list.iter().find(|tag| tag.at == *at);
            tag.is_some_and(|tag| (tag.at..tag.at + tag.tag_type.size() as u32).contains(&bit.at))
        });
        if is_of_axis {
            return Err("is the machine's, expected a tag or X.home_switch, X.enable, X.registration_1, X.registration_2 of an axis X".to_owned());
        }
        let tag = text.split(['.', '[']).next().unwrap_or_default();
        let lost = self.fixed_bit(&format!("{tag}.ConnectionFaulted")).ok();
        let lost = lost.filter(|lost| tag.contains(':') && *lost != bit);
        Ok(End::Bit(bit, lost))
    }

    /// A bit that always stands at the same place.
    fn fixed_bit(&mut self, text: &str) -> Result<FixedBit, String> {
        let text = crate::cell::program_scopes(text);
        // The switch of an axis as a source is a bit of the axis.
        let text = match text.rsplit_once('.') {
            Some((axis, input)) if input.eq_ignore_ascii_case("home_switch") => format!("{axis}.HomeInputStatus"),
            _ => text,
        };
        let reference = Expression::parse_reference(&text).map_err(|error| error.to_string())?;
        let bit = self.resolve(&reference)?.as_bit().ok_or("is no BOOL and no bit")?;
        match (bit.place.fixed(), bit.select) {
            (Some(at), Select::Mask(mask)) => Ok(FixedBit { at, mask }),
            _ => Err("has a subscript that is calculated".to_owned()),
        }
    }
}
