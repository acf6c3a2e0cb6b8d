//! ALMD in ladder (spec/programs.md §10.9): the alarm's input is the rung condition.

use super::counters::{member, member_bit};
use super::{Run, Scan};
use crate::code::{Area, Argument};

/// Requests of an operator, which the instruction takes.
const OPERATOR: [&str; 6] = [
    "OperAck",
    "OperReset",
    "OperDisable",
    "OperEnable",
    "OperSuppress",
    "OperUnsuppress",
];
/// Members that follow the operands ProgAck, ProgReset, ProgDisable and ProgEnable.
const PROGRAM: [&str; 4] = ["ProgAck", "ProgReset", "ProgDisable", "ProgEnable"];

/// An instance in the memory.
struct Alarm<'a> {
    area: &'a Area,
    at: u32,
}

impl Scan<'_> {
    pub(crate) fn alarm(&mut self, area: &Area, operands: &[Argument], power: bool) -> Run<()> {
        let of = Alarm {
            area,
            at: self.address(&area.place)?,
        };
        if self.s.prescan {
            OPERATOR.iter().for_each(|name| self.put_bit(&of, name, false));
            self.set_alarm(&of, false, true);
            self.put_number(&of, "MinDurationACC", 0);
            self.put_bit(&of, "(Timing)", false);
            return Ok(());
        }
        let mut risen = [false; PROGRAM.len()];
        for ((name, operand), risen) in PROGRAM.into_iter().zip(operands).zip(&mut risen) {
            let on = self.argument_whole(operand)? != 0;
            *risen = on && !self.bit_of(&of, name);
            self.put_bit(&of, name, on);
        }
        let [acknowledged, reset, ..] = risen;
        self.put_bit(&of, "In", power);
        let [ack, reset_by_hand, disable, enable, suppress, unsuppress] = OPERATOR.map(|name| self.take_bit(&of, name));
        if enable || self.bit_of(&of, "ProgEnable") {
            self.put_bit(&of, "Disabled", false);
        } else if disable || self.bit_of(&of, "ProgDisable") {
            self.put_bit(&of, "Disabled", true);
        }
        if unsuppress || self.bit_of(&of, "ProgUnsuppress") {
            self.put_bit(&of, "Suppressed", false);
        } else if suppress || self.bit_of(&of, "ProgSuppress") {
            self.put_bit(&of, "Suppressed", true);
        }
        let is_disabled = self.bit_of(&of, "Disabled");
        let is_present = !is_disabled && power == self.bit_of(&of, "Condition");
        let held = self.held(&of, is_present);
        if is_disabled {
            self.set_alarm(&of, false, true);
            return Ok(());
        }
        let (was_in, mut acked) = (self.bit_of(&of, "InAlarm"), self.bit_of(&of, "Acked"));
        let mut is_in = was_in;
        if is_present && held >= self.number_of(&of, "MinDurationPRE") {
            is_in = true;
        } else if !is_present {
            is_in = was_in && self.bit_of(&of, "Latched") && !reset && !reset_by_hand;
        }
        if is_in && !was_in {
            acked = !self.bit_of(&of, "AckRequired");
            let count = self.number_of(&of, "AlarmCount").wrapping_add(1);
            self.put_number(&of, "AlarmCount", count);
            self.put_time(&of, "InAlarmTime");
        } else if was_in && !is_in {
            self.put_time(&of, "RetToNormalTime");
        }
        if !acked && (acknowledged || ack) {
            acked = true;
            self.put_time(&of, "AckTime");
        }
        self.set_alarm(&of, is_in, acked);
        Ok(())
    }

    /// The time for which the condition has been present, ms.
    fn held(&mut self, of: &Alarm<'_>, is_present: bool) -> i32 {
        let now = self.s.now_ms as i32;
        let mut held = 0;
        if is_present && self.bit_of(of, "(Timing)") {
            let passed = now.wrapping_sub(self.number_of(of, "(Last)")).max(0);
            held = self.number_of(of, "MinDurationACC").saturating_add(passed);
        }
        self.put_bit(of, "(Timing)", is_present);
        self.put_number(of, "(Last)", now);
        self.put_number(of, "MinDurationACC", held);
        held
    }

    fn set_alarm(&mut self, of: &Alarm<'_>, is_in: bool, is_acked: bool) {
        self.put_bit(of, "InAlarm", is_in);
        self.put_bit(of, "Acked", is_acked);
        self.put_bit(of, "InAlarmUnack", is_in && !is_acked);
    }

    fn bit_of(&self, of: &Alarm<'_>, name: &str) -> bool {
        member_bit(of.area, of.at, name).is_some_and(|(at, mask)| self.has(at, mask))
    }

    fn put_bit(&mut self, of: &Alarm<'_>, name: &str, on: bool) {
        if let Some((at, mask)) = member_bit(of.area, of.at, name) {
            self.set(at, mask, on);
        }
    }

    fn take_bit(&mut self, of: &Alarm<'_>, name: &str) -> bool {
        let on = self.bit_of(of, name);
        self.put_bit(of, name, false);
        on
    }

    fn number_of(&self, of: &Alarm<'_>, name: &str) -> i32 {
        member(of.area, of.at, name).map_or(0, |at| self.dint(at))
    }

    fn put_number(&mut self, of: &Alarm<'_>, name: &str, value: i32) {
        if let Some(at) = member(of.area, of.at, name) {
            self.put_dint(at, value);
        }
    }

    /// The time of the scan, µs.
    fn put_time(&mut self, of: &Alarm<'_>, name: &str) {
        if let Some(at) = member(of.area, of.at, name) {
            self.put(at, (self.s.now / 1000).to_le_bytes());
        }
    }
}
