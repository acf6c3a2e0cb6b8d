//! The table of instructions (spec/programs.md §10): names in both spellings, operands, and the effect of each in prescan, with a
//! false and with a true rung. The compiler checks calls by it, the scan executes its [`Op`]s, the report names the missing ones, and a
//! test writes docs/LADDER.md from it.

mod rows;

use std::collections::BTreeMap;
use std::sync::LazyLock;

use crate::code::Compare;

pub(crate) use rows::ROWS;

/// The operation of an instruction.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Op {
    Xic,
    Xio,
    Ote,
    Otl,
    Otu,
    Ons,
    Osr,
    Osf,
    Osri,
    Osfi,
    Ton,
    Tof,
    Rto,
    Ctu,
    Ctd,
    Res,
    Tonr,
    Tofr,
    Rtor,
    Ctud,
    Compare(Compare),
    Lim,
    Meq,
    Cmp,
    Compute,
    Cpt,
    Mov,
    Mvm,
    Btd,
    Mvmt,
    Btdt,
    Clr,
    Swpb,
    Cop,
    Fll,
    Jsr,
    Sbr,
    Ret,
    Jmp,
    Lbl,
    Tnd,
    Afi,
    Nop,
    Mcr,
    For,
    Brk,
    Uid,
    Event,
    Fal,
    Fsc,
    Ave,
    Std,
    Srt,
    Size,
    Bsl,
    Bsr,
    Ffl,
    Ffu,
    Lfl,
    Lfu,
    Sqi,
    Sqo,
    Sql,
    Concat,
    Mid,
    Delete,
    Insert,
    Find,
    Dtos,
    Stod,
    Rtos,
    Stor,
    Upper,
    Lower,
    Gsv,
    Ssv,
    Msg,
    Almd,
    /// An instruction of motion.
    Motion,
    /// An add-on instruction.
    AddOn,
    /// An unknown instruction that the scan passes over.
    Missing,
}

impl Op {
    /// Its operands are texts, or numbers that become texts or come from them.
    pub(crate) fn is_of_texts(self) -> bool {
        matches!(
            self,
            Op::Concat
                | Op::Mid
                | Op::Delete
                | Op::Insert
                | Op::Find
                | Op::Dtos
                | Op::Stod
                | Op::Rtos
                | Op::Stor
                | Op::Upper
                | Op::Lower
        )
    }
}

/// The kind of an operand.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Kind {
    /// A BOOL or a bit that the instruction reads.
    Bit,
    /// A BOOL or a bit that the instruction writes.
    OutBit,
    /// A number or an expression.
    Number,
    /// A whole number, zero-extended.
    Unsigned,
    /// A number or a text.
    Compared,
    /// A number or data that fill other data.
    Filling,
    /// A condition or a number.
    Expression,
    /// A number that is written.
    Target,
    /// A number or a text that is written.
    MoveTarget,
    /// Data of any type.
    Data,
    /// A structure of one of these types.
    Structure(&'static [&'static str]),
    /// A text that is read.
    Text,
    /// A text that is written.
    TextTarget,
    /// The value that a structure holds: `?`, or its first value.
    Shown,
    /// The mode of FAL and FSC: a number, or one of its words.
    Mode,
    /// One of these words, by its place.
    Word(&'static [&'static str]),
    Routine,
    Label,
    Task,
    /// Class, instance and attribute of GSV, by their names.
    Name,
}

impl Kind {
    /// The member that an operand of this name shows, if it shows one.
    pub(crate) fn shown_member(self, name: &'static str) -> Option<&'static str> {
        (self == Kind::Shown).then_some(match name {
            "Preset" => "PRE",
            "Accum" => "ACC",
            "Length" => "LEN",
            "Position" => "POS",
            member => member,
        })
    }
}

/// The dependence of an instruction on its rung.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Form {
    /// Gives a condition.
    Input,
    /// Acts with its rung.
    Output,
    /// Acts when its rung becomes true, and evaluates its operands with a false rung too.
    Edge,
    /// Controls the order of execution.
    Control,
    /// In Structured Text alone.
    Text,
}

/// A row of the table.
#[derive(Debug)]
pub(crate) struct Row {
    /// The classic spelling, then others.
    pub(crate) names: &'static [&'static str],
    pub(crate) title: &'static str,
    pub(crate) op: Op,
    pub(crate) operands: &'static [(&'static str, Kind)],
    pub(crate) form: Form,
    /// Effects in prescan, with a false and with a true rung.
    pub(crate) prescan: &'static str,
    pub(crate) off: &'static str,
    pub(crate) on: &'static str,
}

impl Row {
    pub(crate) fn name(&self) -> &'static str {
        self.names.first().copied().unwrap_or_default()
    }

    /// Whether more operands may follow.
    pub(crate) fn takes_more(&self) -> bool {
        matches!(self.op, Op::Jsr | Op::Sbr | Op::Ret)
    }
}

/// The row of an instruction, in either spelling, case ignored.
pub(crate) fn row(name: &str) -> Option<&'static Row> {
    static BY_NAME: LazyLock<BTreeMap<&'static str, &'static Row>> = LazyLock::new(|| {
        ROWS.iter()
            .flat_map(|row| row.names.iter().map(move |name| (*name, row)))
            .collect()
    });
    BY_NAME.get(name.to_ascii_uppercase().as_str()).copied()
}
