//! The instructions, one file each; here, their execution, and the check for room in the queue of coordinated moves.

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
use arcline_instruction_set::{AxisIndex, Call, Enumeration, Mnemonic, MotionControl, MotionError, SystemId};

use crate::call_data::{CallData, ReceivedData};
use crate::cause::Cause;
use crate::execution::{Execution, Ticket};
use crate::motion::Motion;

impl Motion {
    /// Executes an instruction at the present tick and returns the resulting status of its motion control tag.
    /// Real-time: bounded by the instruction and the coordinate systems that share its axes.
    pub fn execute(&mut self, ticket: Ticket, call: &Call) -> MotionControl {
        self.execute_with(ticket, call, None)
    }

    /// As [`Motion::execute`], with the data of the instruction that stand in tags. Real-time.
    pub fn execute_with(&mut self, ticket: Ticket, call: &Call, data: Option<CallData>) -> MotionControl {
        let execution = Execution {
            ticket,
            control: call.control,
            mnemonic: call.mnemonic,
        };
        let refused = self.is_inhibited && call.mnemonic.begins_motion();
        let data = ReceivedData(data);
        self.controls.because(execution.into());
        let result = self.controls.begin(execution).and_then(|()| match refused {
            // Every axis is inhibited: EXERR names the first one.
            true => Err(MotionError::AxisIsInhibited(AxisIndex(0))),
            false => execute(self, execution, call, &data),
        });
        if let Err(error) = result {
            self.controls.fail(execution, error);
            if data.verdict() == Err(error) {
                self.controls.set_segment(execution, data.element() as i32);
            }
        }
        self.controls.because(Cause::Itself);
        self.controls.word(call.control)
    }

    /// The queue of its coordinate system has room for a coordinated move, or the move merges and needs none.
    pub fn has_room(&self, call: &Call) -> bool {
        !is_queued(call.mnemonic) || merges(call) || self.has_place(call.target)
    }

    /// The queue of a coordinate system has room for another move.
    pub fn has_place(&self, system: Option<u16>) -> bool {
        let system = system.and_then(|index| self.systems.get(SystemId(index)));
        system.is_none_or(|system| system.room() > 0)
    }
}

/// A call is of a coordinated move that merges: it ends the motion under way and needs no room in the queue.
fn merges(call: &Call) -> bool {
    let merge = match call.mnemonic {
        Mnemonic::Mclm => Mclm::of(call).merge.index,
        Mnemonic::Mccm => Mccm::of(call).merge.index,
        _ => return false,
    };
    Merge::from_number(call.word(usize::from(merge.0))) != Some(Merge::Disabled)
}

/// Verifies an instruction and executes it. Real-time.
///
/// # Errors
/// The first error in the order of spec/coordinated-instructions.md §11.1. The instruction has changed nothing then.
fn execute(motion: &mut Motion, execution: Execution, call: &Call, data: &ReceivedData) -> Result<(), MotionError> {
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

/// The instruction is queued in its coordinate system.
fn is_queued(mnemonic: Mnemonic) -> bool {
    matches!(mnemonic, Mnemonic::Mclm | Mnemonic::Mccm | Mnemonic::Mcpm)
}
