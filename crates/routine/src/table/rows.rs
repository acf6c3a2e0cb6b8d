//! The rows of the table.

use super::Form::{self, Control, Edge, Input, Output, Text};
use super::Kind::{
    self, Bit, Compared, Data, Expression, Filling, Label, Mode, MoveTarget, Name, Number, OutBit, Routine, Shown,
    Structure, Target, Task, TextTarget, Unsigned, Word,
};
use super::{Op, Row};
use crate::code::Compare;

const TIMER: Kind = Structure(&["TIMER"]);
const COUNTER: Kind = Structure(&["COUNTER"]);
const CONTROL: Kind = Structure(&["CONTROL"]);
const STRING: Kind = Kind::Text;

/// Operands of instructions with a structure, as ladder shows them.
const PRESET: [(&str, Kind); 2] = [("Preset", Shown), ("Accum", Shown)];
const SOURCES: &[(&str, Kind)] = &[("Source A", Number), ("Source B", Number), ("Dest", Target)];
const LOGICAL: &[(&str, Kind)] = &[("Source A", Unsigned), ("Source B", Unsigned), ("Dest", Target)];
const ONE: &[(&str, Kind)] = &[("Source", Number), ("Dest", Target)];
const COMPARED: &[(&str, Kind)] = &[("Source A", Compared), ("Source B", Compared)];
const QUEUE_IN: &[(&str, Kind)] = &[
    ("Source", Data),
    ("Array", Data),
    ("Control", CONTROL),
    ("Length", Shown),
    ("Position", Shown),
];
const QUEUE_OUT: &[(&str, Kind)] = &[
    ("Array", Data),
    ("Dest", Data),
    ("Control", CONTROL),
    ("Length", Shown),
    ("Position", Shown),
];
const SHIFT: &[(&str, Kind)] = &[
    ("Array", Data),
    ("Control", CONTROL),
    ("Source Bit", Bit),
    ("Length", Shown),
];
const STATISTICS: &[(&str, Kind)] = &[
    ("Array", Data),
    ("Dim. To Vary", Number),
    ("Dest", Target),
    ("Control", CONTROL),
    ("Length", Shown),
    ("Position", Shown),
];

type Effects = [&'static str; 3];

const fn row(
    names: &'static [&'static str],
    title: &'static str,
    op: Op,
    operands: &'static [(&'static str, Kind)],
    form: Form,
    effects: Effects,
) -> Row {
    let [prescan, off, on] = effects;
    Row {
        names,
        title,
        op,
        operands,
        form,
        prescan,
        off,
        on,
    }
}

const fn compared(names: &'static [&'static str], title: &'static str, relation: Compare, on: &'static str) -> Row {
    row(names, title, Op::Compare(relation), COMPARED, Input, ["", "out 0", on])
}

const fn computed(names: &'static [&'static str], title: &'static str, on: &'static str) -> Row {
    row(names, title, Op::Compute, SOURCES, Output, ["", "", on])
}

const fn logical(names: &'static [&'static str], title: &'static str, on: &'static str) -> Row {
    row(names, title, Op::Compute, LOGICAL, Output, ["", "", on])
}

const fn function(names: &'static [&'static str], title: &'static str, on: &'static str) -> Row {
    row(names, title, Op::Compute, ONE, Output, ["", "", on])
}

/// All instructions but those of motion, which the catalogue of `arcline-instruction-set` defines, and add-on instructions.
#[rustfmt::skip]
pub(crate) const ROWS: &[Row] = &[
    // Bits.
    row(&["XIC"], "Examine If Closed", Op::Xic, &[("Data Bit", Bit)], Input, ["", "out 0", "out = bit"]),
    row(&["XIO"], "Examine If Open", Op::Xio, &[("Data Bit", Bit)], Input, ["", "out 0", "out = NOT bit"]),
    row(&["OTE"], "Output Energize", Op::Ote, &[("Data Bit", OutBit)], Output, ["bit := 0", "bit := 0", "bit := 1"]),
    row(&["OTL"], "Output Latch", Op::Otl, &[("Data Bit", OutBit)], Output, ["", "", "bit := 1"]),
    row(&["OTU"], "Output Unlatch", Op::Otu, &[("Data Bit", OutBit)], Output, ["", "", "bit := 0"]),
    row(&["ONS"], "One Shot", Op::Ons, &[("Storage Bit", OutBit)], Edge, ["storage := 1", "storage := 0, out 0", "out = NOT storage, storage := 1"]),
    row(&["OSR"], "One Shot Rising", Op::Osr, &[("Storage Bit", OutBit), ("Output Bit", OutBit)], Edge, ["storage := 1, output := 0", "storage := 0, output := 0", "output := NOT storage, storage := 1"]),
    row(&["OSF"], "One Shot Falling", Op::Osf, &[("Storage Bit", OutBit), ("Output Bit", OutBit)], Edge, ["storage := 0, output := 0", "output := storage, storage := 0", "storage := 1, output := 0"]),
    row(&["OSRI"], "One Shot Rising with Input", Op::Osri, &[("OSRI tag", Structure(&["FBD_ONESHOT"]))], Text, ["no edge follows", "", "OutputBit := edge of InputBit"]),
    row(&["OSFI"], "One Shot Falling with Input", Op::Osfi, &[("OSFI tag", Structure(&["FBD_ONESHOT"]))], Text, ["no edge follows", "", "OutputBit := falling edge of InputBit"]),
    // Timers and counters.
    row(&["TON"], "Timer On Delay", Op::Ton, &[("Timer", TIMER), PRESET[0], PRESET[1]], Output, ["EN TT DN ACC := 0", "EN TT DN ACC := 0", "EN := 1; until DN, ACC counts ms; ACC >= PRE: DN := 1, TT := 0. PRE or ACC < 0: 4/34"]),
    row(&["TOF"], "Timer Off Delay", Op::Tof, &[("Timer", TIMER), PRESET[0], PRESET[1]], Output, ["EN TT DN := 0, ACC := PRE", "EN := 0; while DN, ACC counts ms; ACC >= PRE: DN TT := 0", "EN DN := 1, TT := 0, ACC := 0. PRE or ACC < 0: 4/34"]),
    row(&["RTO"], "Retentive Timer On", Op::Rto, &[("Timer", TIMER), PRESET[0], PRESET[1]], Output, ["EN TT := 0", "EN TT := 0", "as TON"]),
    row(&["CTU"], "Count Up", Op::Ctu, &[("Counter", COUNTER), PRESET[0], PRESET[1]], Edge, ["CU := 1", "CU := 0", "edge: ACC + 1; past 2,147,483,647 OV := 1; DN := ACC >= PRE"]),
    row(&["CTD"], "Count Down", Op::Ctd, &[("Counter", COUNTER), PRESET[0], PRESET[1]], Edge, ["CD := 1", "CD := 0", "edge: ACC - 1; below -2,147,483,648 UN := 1; DN := ACC >= PRE"]),
    row(&["RES"], "Reset", Op::Res, &[("Structure", Structure(&["TIMER", "COUNTER", "CONTROL"]))], Output, ["", "", "ACC (CONTROL: POS) and all bits := 0"]),
    row(&["TONR"], "Timer On Delay with Reset", Op::Tonr, &[("TONR tag", Structure(&["FBD_TIMER"]))], Text, ["all outputs := 0", "", "while TimerEnable, ACC counts ms to PRE; Reset clears"]),
    row(&["TOFR"], "Timer Off Delay with Reset", Op::Tofr, &[("TOFR tag", Structure(&["FBD_TIMER"]))], Text, ["all outputs := 0", "", "DN with TimerEnable and PRE ms longer; Reset clears"]),
    row(&["RTOR"], "Retentive Timer On with Reset", Op::Rtor, &[("RTOR tag", Structure(&["FBD_TIMER"]))], Text, ["EN TT := 0", "", "as TONR, ACC stays without TimerEnable"]),
    row(&["CTUD"], "Count Up/Down", Op::Ctud, &[("CTUD tag", Structure(&["FBD_COUNTER"]))], Text, ["no edge follows", "", "edge of CUEnable: ACC + 1; of CDEnable: ACC - 1; Reset clears"]),
    // Compare.
    compared(&["EQU", "EQ"], "Equal To", Compare::Equal, "out = A = B"),
    compared(&["NEQ", "NE"], "Not Equal To", Compare::NotEqual, "out = A <> B"),
    compared(&["GRT", "GT"], "Greater Than", Compare::Greater, "out = A > B"),
    compared(&["GEQ", "GE"], "Greater Than or Equal To", Compare::GreaterEqual, "out = A >= B"),
    compared(&["LES", "LT"], "Less Than", Compare::Less, "out = A < B"),
    compared(&["LEQ", "LE"], "Less Than or Equal To", Compare::LessEqual, "out = A <= B"),
    row(&["LIM", "LIMIT"], "Limit Test", Op::Lim, &[("Low Limit", Number), ("Test", Number), ("High Limit", Number)], Input, ["", "out 0", "low <= high: out = low <= test <= high; else out = test >= low OR test <= high"]),
    row(&["MEQ"], "Masked Equal To", Op::Meq, &[("Source", Unsigned), ("Mask", Unsigned), ("Compare", Unsigned)], Input, ["", "out 0", "out = (source AND mask) = (compare AND mask)"]),
    row(&["CMP"], "Compare Expression", Op::Cmp, &[("Expression", Expression)], Input, ["", "out 0", "out = expression <> 0"]),
    // Compute.
    row(&["CPT"], "Compute", Op::Cpt, &[("Dest", Target), ("Expression", Number)], Output, ["", "", "dest := expression"]),
    computed(&["ADD"], "Add", "dest := A + B; S:C"),
    computed(&["SUB"], "Subtract", "dest := A - B; S:C"),
    computed(&["MUL"], "Multiply", "dest := A * B"),
    computed(&["DIV"], "Divide", "dest := A / B; by 0: minor 4/4, dest := A"),
    computed(&["MOD"], "Modulo", "dest := A - TRN(A / B) * B; by 0: minor 4/4, dest := 0"),
    computed(&["XPY", "EXPT"], "X to the Power of Y", "dest := A ** B"),
    logical(&["AND"], "Bitwise And", "dest := A AND B, zero-extended"),
    logical(&["OR"], "Bitwise Or", "dest := A OR B, zero-extended"),
    logical(&["XOR"], "Bitwise Exclusive Or", "dest := A XOR B, zero-extended"),
    row(&["NOT"], "Bitwise Not", Op::Compute, &[("Source", Unsigned), ("Dest", Target)], Output, ["", "", "dest := NOT source"]),
    function(&["NEG"], "Negate", "dest := 0 - source"),
    function(&["ABS"], "Absolute Value", "dest := |source|"),
    function(&["SQR", "SQRT"], "Square Root", "dest := root of |source|"),
    function(&["SIN"], "Sine", "dest := sine, source in radians"),
    function(&["COS"], "Cosine", "dest := cosine, source in radians"),
    function(&["TAN"], "Tangent", "dest := tangent, source in radians"),
    function(&["ASN", "ASIN"], "Arc Sine", "dest := arc sine in radians; outside of -1 to 1 not a number"),
    function(&["ACS", "ACOS"], "Arc Cosine", "dest := arc cosine in radians; outside of -1 to 1 not a number"),
    function(&["ATN", "ATAN"], "Arc Tangent", "dest := arc tangent in radians"),
    function(&["LN"], "Natural Log", "dest := natural logarithm"),
    function(&["LOG"], "Log Base 10", "dest := logarithm to the base 10"),
    function(&["DEG"], "Degrees", "dest := source * 180 / pi"),
    function(&["RAD"], "Radians", "dest := source * pi / 180"),
    function(&["TRN", "TRUNC"], "Truncate", "dest := source without its fraction"),
    function(&["TOD"], "Convert to BCD", "dest := BCD of source; negative or above 99,999,999: S:V, minor 4/4"),
    function(&["FRD"], "Convert from BCD", "dest := number of BCD"),
    row(&["CLR"], "Clear", Op::Clr, &[("Dest", Target)], Output, ["", "", "dest := 0"]),
    row(&["MOV", "MOVE"], "Move", Op::Mov, &[("Source", Compared), ("Dest", MoveTarget)], Output, ["", "", "dest := source, converted; texts too"]),
    row(&["MVM"], "Masked Move", Op::Mvm, &[("Source", Unsigned), ("Mask", Unsigned), ("Dest", Target)], Output, ["", "", "dest := (source AND mask) OR (dest AND NOT mask)"]),
    row(&["BTD"], "Bit Field Distribute", Op::Btd, &[("Source", Unsigned), ("Source Bit", Number), ("Dest", Target), ("Dest Bit", Number), ("Length", Number)], Output, ["", "", "copies bits; those beyond dest are lost; no flags"]),
    row(&["MVMT"], "Masked Move with Target", Op::Mvmt, &[("MVMT tag", Structure(&["FBD_MASKED_MOVE"]))], Text, ["", "", "Dest := (Source AND Mask) OR (Target AND NOT Mask)"]),
    row(&["BTDT"], "Bit Field Distribute with Target", Op::Btdt, &[("BTDT tag", Structure(&["FBD_BIT_FIELD_DISTRIBUTE"]))], Text, ["", "", "Dest := Target with the field of Source"]),
    row(&["SWPB"], "Swap Byte", Op::Swpb, &[("Source", Number), ("Order Mode", Word(&["REVERSE", "WORD", "HIGH/LOW"])), ("Dest", Target)], Output, ["", "", "dest := source with other order of bytes"]),
    row(&["COP", "CPS"], "Copy File", Op::Cop, &[("Source", Data), ("Dest", Data), ("Length", Number)], Output, ["", "", "length elements of dest := bytes of source; ends at the end of either; of BOOLs words of 32"]),
    row(&["FLL"], "Fill File", Op::Fll, &[("Source", Filling), ("Dest", Data), ("Length", Number)], Output, ["", "", "length elements of dest := source"]),
    // Program control.
    row(&["JSR"], "Jump to Subroutine", Op::Jsr, &[("Routine", Routine)], Control, ["prescans the routine", "", "runs the routine with parameters by value; too few: 4/31; too deep: 4/84"]),
    row(&["SBR"], "Subroutine", Op::Sbr, &[], Control, ["", "", "takes the parameters of the call"]),
    row(&["RET"], "Return", Op::Ret, &[], Control, ["", "", "leaves the routine and gives values back"]),
    row(&["JMP"], "Jump to Label", Op::Jmp, &[("Label", Label)], Control, ["", "", "goes on at the rung of the label"]),
    row(&["LBL"], "Label", Op::Lbl, &[("Label", Name)], Control, ["", "", ""]),
    row(&["TND"], "Temporary End", Op::Tnd, &[], Control, ["", "", "ends the routine"]),
    row(&["AFI"], "Always False", Op::Afi, &[], Input, ["", "out 0", "out 0"]),
    row(&["NOP"], "No Operation", Op::Nop, &[], Output, ["", "", ""]),
    row(&["MCR"], "Master Control Reset", Op::Mcr, &[], Control, ["", "begins or ends a zone whose rungs are false", ""]),
    row(&["FOR"], "For", Op::For, &[("Routine", Routine), ("Index", Target), ("Initial Value", Number), ("Terminal Value", Number), ("Step Size", Number)], Control, ["prescans the routine", "", "runs the routine for each index"]),
    row(&["BRK"], "Break", Op::Brk, &[], Control, ["", "", "leaves the routine and its FOR"]),
    row(&["UID", "UIE"], "User Interrupt Disable, Enable", Op::Uid, &[], Output, ["", "", "no effect: tasks run whole"]),
    row(&["EVENT"], "Trigger Event Task", Op::Event, &[("Task", Task)], Output, ["", "", "triggers the task"]),
    // Files and shifts.
    row(&["FAL"], "File Arithmetic", Op::Fal, &[("Control", CONTROL), ("Length", Shown), ("Position", Shown), ("Mode", Mode), ("Dest", Target), ("Expression", Number)], Edge, ["EN := 0", "EN := 0 when DN; mode n goes on", "edge: dest := expression for POS 0 to LEN - 1. LEN <= 0 or POS < 0: 4/21"]),
    row(&["FSC"], "File Search and Compare", Op::Fsc, &[("Control", CONTROL), ("Length", Shown), ("Position", Shown), ("Mode", Mode), ("Expression", Expression)], Edge, ["EN := 0", "EN := 0 when DN; mode n goes on", "edge: stops at the first POS whose expression is true, with FD and IN"]),
    row(&["AVE"], "File Average", Op::Ave, STATISTICS, Edge, ["EN DN ER := 0", "EN DN ER := 0", "edge: dest := average of one dimension"]),
    row(&["STD"], "File Standard Deviation", Op::Std, STATISTICS, Edge, ["EN DN ER := 0", "EN DN ER := 0", "edge: dest := standard deviation (N - 1) of one dimension"]),
    row(&["SRT"], "File Sort", Op::Srt, &[("Array", Data), ("Dim. To Vary", Number), ("Control", CONTROL), ("Length", Shown), ("Position", Shown)], Edge, ["EN DN ER := 0", "EN DN ER := 0", "edge: sorts one dimension ascending"]),
    row(&["SIZE"], "Size In Elements", Op::Size, &[("Source", Data), ("Dim. To Vary", Number), ("Size", Target)], Output, ["", "", "dest := elements of the dimension"]),
    row(&["BSL"], "Bit Shift Left", Op::Bsl, SHIFT, Edge, ["EN DN ER UL := 0, POS := 0", "EN DN ER UL := 0, POS := 0", "edge: bits move up by one, the last is UL"]),
    row(&["BSR"], "Bit Shift Right", Op::Bsr, SHIFT, Edge, ["EN DN ER UL := 0, POS := 0", "EN DN ER UL := 0, POS := 0", "edge: bits move down by one, the first is UL"]),
    row(&["FFL"], "FIFO Load", Op::Ffl, QUEUE_IN, Edge, ["EN := 1", "EN := 0", "edge: array[POS] := source, POS + 1; DN full, EM empty"]),
    row(&["FFU"], "FIFO Unload", Op::Ffu, QUEUE_OUT, Edge, ["EU := 1", "EU := 0", "edge: dest := array[0], the others move down, POS - 1"]),
    row(&["LFL"], "LIFO Load", Op::Lfl, QUEUE_IN, Edge, ["EN := 1", "EN := 0", "as FFL"]),
    row(&["LFU"], "LIFO Unload", Op::Lfu, QUEUE_OUT, Edge, ["EU := 1", "EU := 0", "edge: POS - 1, dest := array[POS]"]),
    row(&["SQI"], "Sequencer Input", Op::Sqi, &[("Array", Data), ("Mask", Unsigned), ("Source", Unsigned), ("Control", CONTROL), ("Length", Shown), ("Position", Shown)], Input, ["", "out 0", "out = (array[POS] AND mask) = (source AND mask)"]),
    row(&["SQO"], "Sequencer Output", Op::Sqo, &[("Array", Data), ("Mask", Unsigned), ("Dest", Target), ("Control", CONTROL), ("Length", Shown), ("Position", Shown)], Edge, ["EN := 1", "EN := 0", "edge: POS + 1, behind LEN 1; dest := array[POS] by mask"]),
    row(&["SQL"], "Sequencer Load", Op::Sql, &[("Array", Data), ("Source", Number), ("Control", CONTROL), ("Length", Shown), ("Position", Shown)], Edge, ["EN := 1", "EN := 0", "edge: POS + 1, behind LEN 1; array[POS] := source"]),
    // Texts.
    row(&["CONCAT"], "String Concatenate", Op::Concat, &[("Source A", STRING), ("Source B", STRING), ("Dest", TextTarget)], Output, ["", "", "dest := A and B; cut: minor 4/51"]),
    row(&["MID"], "Middle String", Op::Mid, &[("Source", STRING), ("Qty", Number), ("Start", Number), ("Dest", TextTarget)], Output, ["", "", "dest := qty characters from start on; outside: minor 4/56"]),
    row(&["DELETE"], "String Delete", Op::Delete, &[("Source", STRING), ("Qty", Number), ("Start", Number), ("Dest", TextTarget)], Output, ["", "", "dest := source without qty characters from start on; outside: minor 4/56"]),
    row(&["INSERT"], "Insert String", Op::Insert, &[("Source A", STRING), ("Source B", STRING), ("Start", Number), ("Dest", TextTarget)], Output, ["", "", "dest := A with B before start; outside: minor 4/56"]),
    row(&["FIND"], "Find String", Op::Find, &[("Source", STRING), ("Search", STRING), ("Start", Number), ("Result", Target)], Output, ["", "", "result := position from 1 on, or 0"]),
    row(&["DTOS"], "DINT to String", Op::Dtos, &[("Source", Number), ("Dest", TextTarget)], Output, ["", "", "dest := decimal digits; too long: minor 4/52"]),
    row(&["STOD"], "String to DINT", Op::Stod, &[("Source", STRING), ("Dest", Target)], Output, ["", "", "dest := first group of digits"]),
    row(&["RTOS"], "REAL to String", Op::Rtos, &[("Source", Number), ("Dest", TextTarget)], Output, ["", "", "dest := up to nine digits"]),
    row(&["STOR"], "String to REAL", Op::Stor, &[("Source", STRING), ("Dest", Target)], Output, ["", "", "dest := first number"]),
    row(&["UPPER"], "Upper Case", Op::Upper, &[("Source", STRING), ("Dest", TextTarget)], Output, ["", "", "dest := source with capitals"]),
    row(&["LOWER"], "Lower Case", Op::Lower, &[("Source", STRING), ("Dest", TextTarget)], Output, ["", "", "dest := source with small letters"]),
    // System.
    row(&["GSV"], "Get System Value", Op::Gsv, &[("Class Name", Name), ("Instance Name", Name), ("Attribute Name", Name), ("Dest", Data)], Output, ["", "", "dest := attribute, as many bytes as it has"]),
    row(&["SSV"], "Set System Value", Op::Ssv, &[("Class Name", Name), ("Instance Name", Name), ("Attribute Name", Name), ("Source", Data)], Output, ["", "", "attribute := source"]),
    row(&["ALMD"], "Digital Alarm", Op::Almd, &[("ALMD tag", Structure(&["ALARM_DIGITAL"])), ("ProgAck", Bit), ("ProgReset", Bit), ("ProgDisable", Bit), ("ProgEnable", Bit), ("MinDurationPRE", Shown), ("MinDurationACC", Shown)], Output, ["InAlarm MinDurationACC := 0, Acked := 1, requests of the operator := 0", "In := 0, then as a true rung", "In := 1; In = Condition for MinDurationPRE ms: InAlarm := 1, Acked := NOT AckRequired; otherwise InAlarm := 0, a latched one at an edge of ProgReset; edge of ProgAck: Acked := 1; not while Disabled"]),
    row(&["MSG"], "Message", Op::Msg, &[("Message Control", Structure(&["MESSAGE"]))], Edge, ["EN := 0", "EN := 0 when DN or ER", "edge: sends the message; DN or ER follow"]),
];
