//! What each instruction does, one file an instruction; here, how they are found and what they share.

mod axis_moves;
mod camming;
mod mafr;
mod mag;
mod mah;
mod maj;
mod mam;
mod maoc;
mod mapc;
mod mar;
mod mas;
mod masd;
mod masr;
mod matc;
mod maw;
mod mccd;
mod mccm;
mod mccp;
mod mcd;
mod mclm;
mod mcpm;
mod mcs;
mod mcsd;
mod mcsr;
mod mcsv;
mod mct;
mod mcto;
mod mctp;
mod mctpo;
mod mdac;
mod mdcc;
mod mdoc;
mod mdr;
mod mdw;
mod merging;
mod mgs;
mod mgsd;
mod mgsp;
mod mgsr;
mod moves;
mod mrp;
mod msf;
mod mso;
mod points;
mod programmed;
mod seconds;

use arcline_instruction_set::enumerations::Merge;
use arcline_instruction_set::operands::{Mccm, Mclm, Operands};
use arcline_instruction_set::{Call, Enumeration, Mnemonic, MotionError, OperandIndex};

use crate::call_data::ReceivedData;
use crate::control::Execution;
use crate::motion::Motion;
pub(crate) use masd::shut_down;

/// Whether a call is of a coordinated move that merges: it ends what is under way and takes no place in the queue.
pub(crate) fn merges(call: &Call) -> bool {
    let merge = match call.mnemonic {
        Mnemonic::Mclm => Mclm::of(call).merge.index,
        Mnemonic::Mccm => Mccm::of(call).merge.index,
        _ => return false,
    };
    Merge::from_number(call.word(usize::from(merge.0))) != Some(Merge::Disabled)
}

/// Verifies an instruction and does it. Real-time.
///
/// # Errors
/// The first reason, in the order of spec/coordinated-instructions.md §11.1. Nothing has moved or changed then.
pub(crate) fn execute(
    motion: &mut Motion,
    execution: Execution,
    call: &Call,
    data: &ReceivedData,
) -> Result<(), MotionError> {
    match call.mnemonic {
        Mnemonic::Mclm => mclm::execute(motion, execution, call),
        Mnemonic::Mccm => mccm::execute(motion, execution, call),
        Mnemonic::Mccd => mccd::execute(motion, execution, call),
        Mnemonic::Mcs => mcs::execute(motion, execution, call),
        Mnemonic::Mcsd => mcsd::execute(motion, execution, call),
        Mnemonic::Mcsr => mcsr::execute(motion, execution, call),
        Mnemonic::Mso => mso::execute(motion, execution, call),
        Mnemonic::Msf => msf::execute(motion, execution, call),
        Mnemonic::Masd => masd::execute(motion, execution, call),
        Mnemonic::Masr => masr::execute(motion, execution, call),
        Mnemonic::Mgs => mgs::execute(motion, execution, call),
        Mnemonic::Mgsd => mgsd::execute(motion, execution, call),
        Mnemonic::Mgsr => mgsr::execute(motion, execution, call),
        Mnemonic::Mgsp => mgsp::execute(motion, execution, call),
        Mnemonic::Mas => mas::execute(motion, execution, call),
        Mnemonic::Mam => mam::execute(motion, execution, call),
        Mnemonic::Maj => maj::execute(motion, execution, call),
        Mnemonic::Mcd => mcd::execute(motion, execution, call),
        Mnemonic::Mag => mag::execute(motion, execution, call),
        Mnemonic::Mapc => mapc::execute(motion, execution, call, data),
        Mnemonic::Matc => matc::execute(motion, execution, call, data),
        Mnemonic::Mct => mct::execute(motion, execution, call),
        Mnemonic::Mdcc => mdcc::execute(motion, execution, call),
        Mnemonic::Mdac => mdac::execute(motion, execution, call),
        Mnemonic::Mcpm => mcpm::execute(motion, execution, call, data),
        Mnemonic::Mctp => mctp::execute(motion, execution, call, data),
        Mnemonic::Mcto => mcto::execute(motion, execution, call, data),
        Mnemonic::Mctpo => mctpo::execute(motion, execution, call, data),
        Mnemonic::Mah => mah::execute(motion, execution, call),
        Mnemonic::Mrp => mrp::execute(motion, execution, call),
        Mnemonic::Mccp => mccp::execute(motion, execution, call, data),
        Mnemonic::Mcsv => mcsv::execute(motion, execution, call, data),
        Mnemonic::Maoc => maoc::execute(motion, execution, call, data),
        Mnemonic::Mdoc => mdoc::execute(motion, execution, call),
        Mnemonic::Maw => maw::execute(motion, execution, call),
        Mnemonic::Mdw => mdw::execute(motion, execution, call),
        Mnemonic::Mar => mar::execute(motion, execution, call),
        Mnemonic::Mdr => mdr::execute(motion, execution, call),
        Mnemonic::Mafr => mafr::execute(motion, execution, call),
    }
}

/// Whether the instruction takes a place in its coordinate system's queue.
pub(crate) fn is_queued(mnemonic: Mnemonic) -> bool {
    matches!(mnemonic, Mnemonic::Mclm | Mnemonic::Mccm | Mnemonic::Mcpm)
}

/// The error of an instruction whose target does not exist: its first operand.
pub(crate) fn no_target() -> MotionError {
    MotionError::ParameterOutOfRange(OperandIndex(0))
}
