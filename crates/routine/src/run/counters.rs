//! Timers and counters (spec/programs.md §10.2).
//!
//! The low 22 bits of a timer's control word hold the time of its last scan, ms, as a controller does it: so the state travels
//! with the tag, and a timer must be scanned within 69 minutes. They are all 1 at the end of a timer, so that its rung
//! changes nothing then and settles. The rung of a running timer is timing ([`super::Memory`]).

use super::{Run, Scan, Timing};
use crate::code::{ACC, Area, PRE, RungTimer};
use crate::table::Op;

const EN: u8 = 0x80;
const TT: u8 = 0x40;
const DN: u8 = 0x20;
/// The same bits in the control word, and those of the time of the last scan.
const EN_WORD: u32 = (EN as u32) << 24;
const TT_WORD: u32 = (TT as u32) << 24;
const DN_WORD: u32 = (DN as u32) << 24;
const OV_WORD: u32 = 1 << 28;
const UN_WORD: u32 = 1 << 27;
const LAST: u32 = (1 << 22) - 1;
/// The time of a timer at its end, which counts as that of the scan before this one.
const AT_END: u32 = LAST;

impl Scan<'_> {
    pub(crate) fn timer(&mut self, op: Op, area: &Area, power: bool) -> Run<()> {
        let at = self.address(&area.place)?;
        if matches!(op, Op::Tonr | Op::Tofr | Op::Rtor) {
            self.timer_with_reset(op, area, at);
            return Ok(());
        }
        let (preset, accumulated) = (self.dint(at + 4), self.dint(at + 8));
        let bits = at + 3;
        if self.s.prescan {
            match op {
                Op::Ton => {
                    self.set(bits, EN | TT | DN, false);
                    self.put_dint(at + 8, 0);
                }
                Op::Tof => {
                    self.set(bits, EN | TT | DN, false);
                    self.put_dint(at + 8, preset);
                }
                _ => self.set(bits, EN | TT, false),
            }
            return Ok(());
        }
        if preset < 0 || accumulated < 0 {
            let operand = if preset < 0 {
                (PRE, preset.into())
            } else {
                (ACC, accumulated.into())
            };
            return Err(self.fault(4, 34, Some(operand)));
        }
        let now = self.time_of_scan();
        let stamped = |word: u32, time: u32| word & !LAST | time;
        let is_off_delay = op == Op::Tof;
        let (word, changes) = (self.dint(at) as u32, self.s.memory.changes());
        let mut next = word;
        // `None`: it is idle, and does not time.
        let is_at_end = match (is_off_delay, power) {
            (false, false) => {
                next &= !(EN_WORD | TT_WORD);
                if op == Op::Ton {
                    next &= !DN_WORD;
                    self.put_dint(at + 8, 0);
                }
                None
            }
            (true, true) => {
                next = next & !TT_WORD | EN_WORD | DN_WORD;
                self.put_dint(at + 8, 0);
                None
            }
            (false, true) => {
                if next & EN_WORD == 0 {
                    next = stamped(next | EN_WORD, now);
                }
                Some(next & DN_WORD != 0)
            }
            (true, false) => {
                if next & EN_WORD != 0 {
                    next = stamped(next & !EN_WORD, now);
                }
                Some(next & DN_WORD == 0)
            }
        };
        match is_at_end {
            Some(false) => {
                let last = next & LAST;
                let last = if last == AT_END { self.s.before_ms as u32 } else { last };
                let passed = now.wrapping_sub(last) & LAST;
                let sum = self.dint(at + 8).saturating_add(passed as i32);
                self.put_dint(at + 8, sum);
                let is_over = sum >= preset;
                next &= !(TT_WORD | DN_WORD);
                if is_over != is_off_delay {
                    next |= DN_WORD;
                }
                if !is_over {
                    next |= TT_WORD;
                }
                next = stamped(next, if is_over { AT_END } else { now });
                self.put_dint(at, next as i32);
                if !is_over {
                    let only_time = (word ^ next) & !LAST == 0 && self.s.timing.is_none();
                    let changes = self.s.memory.changes() - changes;
                    self.s.timing = Some(Timing { at, changes });
                    self.s.is_restless |= !only_time;
                }
                return Ok(());
            }
            Some(true) => next = stamped(next, AT_END),
            None => {}
        }
        self.put_dint(at, next as i32);
        Ok(())
    }

    /// The time of this scan as timers hold it.
    fn time_of_scan(&self) -> u32 {
        (self.s.now_ms as u32 & LAST).min(AT_END - 1)
    }

    /// The control word and ACC of a running timer after this scan, if it then still runs.
    pub(crate) fn running(&self, at: u32) -> Option<(u32, i32)> {
        let (word, preset, accumulated) = (self.dint(at) as u32, self.dint(at + 4), self.dint(at + 8));
        let (last, now) = (word & LAST, self.time_of_scan());
        if word & TT_WORD == 0 || last == AT_END || preset < 0 || accumulated < 0 {
            return None;
        }
        let sum = accumulated.saturating_add((now.wrapping_sub(last) & LAST) as i32);
        (sum < preset).then_some((word & !LAST | now, sum))
    }

    /// Brings the timer of a timing step forward; false: its time may be over.
    pub(crate) fn bring_forward(&mut self, timer: RungTimer, step: u32) -> bool {
        let RungTimer { at, is_read } = timer;
        let Some((word, sum)) = self.running(at) else {
            return false;
        };
        for (at, new) in [(at, word.to_le_bytes()), (at + 8, sum.to_le_bytes())] {
            if is_read {
                self.s.memory.put_except(at as usize, new, step);
            } else {
                self.s.memory.replace(at as usize, new);
            }
        }
        true
    }

    fn timer_with_reset(&mut self, op: Op, area: &Area, at: u32) {
        let Some(l) = Layout::of(area, at) else { return };
        let clear = |scan: &mut Self, keep: bool| {
            for bit in [l.en, l.tt, l.dn] {
                scan.set(bit.0, bit.1, false);
            }
            if !keep {
                scan.put_dint(l.acc, 0);
            }
        };
        let now = self.s.now_ms as i32;
        if self.s.prescan {
            if op == Op::Rtor {
                self.set(l.en.0, l.en.1, false);
                self.set(l.tt.0, l.tt.1, false);
            } else {
                clear(self, false);
            }
            return;
        }
        let preset = self.dint(l.pre);
        self.put_dint(l.status, if preset < 0 { 2 } else { 0 });
        if preset < 0 {
            return;
        }
        if self.has(l.reset.0, l.reset.1) {
            clear(self, false);
            self.put_dint(l.last, now);
            return;
        }
        let enable = self.has(l.enable.0, l.enable.1);
        let was = self.has(l.en.0, l.en.1);
        self.set(l.en.0, l.en.1, enable);
        let on = enable == (op != Op::Tofr);
        if op == Op::Tofr && enable {
            self.set(l.dn.0, l.dn.1, true);
            self.set(l.tt.0, l.tt.1, false);
            self.put_dint(l.acc, 0);
            return;
        }
        if !on {
            if op == Op::Tonr {
                clear(self, false);
            } else {
                self.set(l.tt.0, l.tt.1, false);
            }
            return;
        }
        if enable != was {
            self.put_dint(l.last, now);
        }
        let timing = if op == Op::Tofr {
            self.has(l.dn.0, l.dn.1)
        } else {
            !self.has(l.dn.0, l.dn.1)
        };
        if timing {
            let sum = self
                .dint(l.acc)
                .saturating_add(now.wrapping_sub(self.dint(l.last)).max(0));
            let done = sum >= preset;
            self.put_dint(l.acc, if done { preset } else { sum });
            self.set(l.dn.0, l.dn.1, done == (op != Op::Tofr));
            self.set(l.tt.0, l.tt.1, !done);
        }
        self.put_dint(l.last, now);
    }

    pub(crate) fn counter(&mut self, op: Op, area: &Area, power: bool) -> Run<()> {
        let at = self.address(&area.place)?;
        if op == Op::Ctud {
            self.counter_up_down(area, at);
        } else {
            self.count(op, at, power);
        }
        Ok(())
    }

    /// CTU and CTD.
    pub(crate) fn count(&mut self, op: Op, at: u32, power: bool) {
        // CU is bit 31, CD bit 30.
        let edge = if op == Op::Ctu { EN_WORD } else { TT_WORD };
        let (word, preset, mut accumulated) = (self.dint(at) as u32, self.dint(at + 4), self.dint(at + 8));
        if self.s.prescan {
            self.put_dint(at, (word | edge) as i32);
            return;
        }
        let mut next = if power { word | edge } else { word & !edge };
        if power && word & edge == 0 {
            let (last, over, under, step) = if op == Op::Ctu {
                (i32::MAX, OV_WORD, UN_WORD, 1)
            } else {
                (i32::MIN, UN_WORD, OV_WORD, -1)
            };
            if accumulated == last && next & under != 0 {
                next &= !under;
            } else if accumulated == last {
                next |= over;
            }
            accumulated = accumulated.wrapping_add(step);
            self.put_dint(at + 8, accumulated);
        }
        if next & (OV_WORD | UN_WORD) == 0 {
            next = if accumulated >= preset {
                next | DN_WORD
            } else {
                next & !DN_WORD
            };
        }
        self.put_dint(at, next as i32);
    }

    fn counter_up_down(&mut self, area: &Area, at: u32) {
        let bit = |name: &str| member_bit(area, at, name);
        let number = |name: &str| member(area, at, name);
        let (Some(up), Some(down), Some(cu), Some(cd), Some(dn)) =
            (bit("CUEnable"), bit("CDEnable"), bit("CU"), bit("CD"), bit("DN"))
        else {
            return;
        };
        let (Some(pre), Some(acc), Some(reset)) = (number("PRE"), number("ACC"), bit("Reset")) else {
            return;
        };
        if self.s.prescan {
            self.set(cu.0, cu.1, true);
            self.set(cd.0, cd.1, true);
            return;
        }
        if self.has(reset.0, reset.1) {
            self.put_dint(acc, 0);
            self.set(dn.0, dn.1, false);
        }
        for (enable, last, step) in [(up, cu, 1), (down, cd, -1)] {
            let on = self.has(enable.0, enable.1);
            if on && !self.has(last.0, last.1) && !self.has(reset.0, reset.1) {
                let next = self.dint(acc).wrapping_add(step);
                self.put_dint(acc, next);
            }
            self.set(last.0, last.1, on);
        }
        let done = self.dint(acc) >= self.dint(pre);
        self.set(dn.0, dn.1, done);
    }

    /// RES
    pub(crate) fn reset(&mut self, area: &Area) -> Run<()> {
        let at = self.address(&area.place)?;
        self.put_dint(at, 0);
        self.put_dint(at + 8, 0);
        Ok(())
    }
}

/// Members of FBD_TIMER in the memory.
struct Layout {
    enable: (u32, u8),
    reset: (u32, u8),
    en: (u32, u8),
    tt: (u32, u8),
    dn: (u32, u8),
    pre: u32,
    acc: u32,
    status: u32,
    last: u32,
}

impl Layout {
    fn of(area: &Area, at: u32) -> Option<Self> {
        Some(Layout {
            enable: member_bit(area, at, "TimerEnable")?,
            reset: member_bit(area, at, "Reset")?,
            en: member_bit(area, at, "EN")?,
            tt: member_bit(area, at, "TT")?,
            dn: member_bit(area, at, "DN")?,
            pre: member(area, at, "PRE")?,
            acc: member(area, at, "ACC")?,
            status: member(area, at, "Status")?,
            last: member(area, at, "__Last")?,
        })
    }
}

/// Byte and mask of a BOOL of a structure.
pub(crate) fn member_bit(area: &Area, at: u32, name: &str) -> Option<(u32, u8)> {
    let arcline_tag::DataType::Structure(template) = &area.data_type else {
        return None;
    };
    let member = template.member(name)?;
    Some((at + member.offset, 1 << member.bit?))
}

/// Byte of a member of a structure.
pub(crate) fn member(area: &Area, at: u32, name: &str) -> Option<u32> {
    let arcline_tag::DataType::Structure(template) = &area.data_type else {
        return None;
    };
    Some(at + template.member(name)?.offset)
}
