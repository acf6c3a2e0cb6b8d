//! What instructions read of a call: its target, its verified operands, and the objects that these name.

use arcline_instruction_set::operands::{OperandValue, Operands};
use arcline_instruction_set::{AxisId, Call, MotionError, Object, SystemId};

use crate::instructions;
use crate::motion::Motion;

impl Motion {
    pub(crate) fn target_axis(&self, call: &Call) -> Result<AxisId, MotionError> {
        call.target
            .map(AxisId)
            .filter(|axis| self.axes.get(*axis).is_some())
            .ok_or(instructions::no_target())
    }

    /// There is one motion group.
    pub(crate) fn target_group(&self, call: &Call) -> Result<(), MotionError> {
        match call.target {
            Some(0) => Ok(()),
            _ => Err(instructions::no_target()),
        }
    }

    pub(crate) fn target_system(&self, call: &Call) -> Result<SystemId, MotionError> {
        call.target
            .map(SystemId)
            .filter(|system| self.systems.get(*system).is_some())
            .ok_or(instructions::no_target())
    }

    /// Step 5 of the verification: the operands, in faceplate order.
    pub(crate) fn verify_operands(&self, call: &Call) -> Result<(), MotionError> {
        let instruction = call.mnemonic.instruction();
        let axes = match instruction.object {
            Object::CoordinateSystem => {
                let index = self.target_system(call)?;
                self.systems[index].description.linear().len()
            }
            Object::Axis | Object::MotionGroup => 1,
        };
        instruction.verify(call, axes).map_err(MotionError::ParameterOutOfRange)
    }

    /// The verified operands of a call.
    pub(crate) fn operands<O: Operands>(&self, call: &Call) -> Result<O, MotionError> {
        self.verify_operands(call)?;
        Ok(O::of(call))
    }

    /// The axis that an operand names.
    pub(crate) fn axis_of(&self, operand: &OperandValue<Option<AxisId>>) -> Result<AxisId, MotionError> {
        operand
            .filter(|axis| self.axes.get(*axis).is_some())
            .ok_or(operand.out_of_range())
    }

    /// The coordinate system that an operand names.
    pub(crate) fn system_of(&self, operand: &OperandValue<Option<SystemId>>) -> Result<SystemId, MotionError> {
        operand
            .filter(|system| self.systems.get(*system).is_some())
            .ok_or(operand.out_of_range())
    }
}
