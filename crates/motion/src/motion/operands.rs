//! The parts of a call that instructions read: its target, its verified operands, and the objects that these refer to.

use arcline_instruction_set::operands::{OperandValue, Operands};
use arcline_instruction_set::{Argument, AxisId, Call, Mnemonic, MotionError, Object, OperandIndex, SystemId};

use super::Motion;
use crate::stop::AxisSet;

impl Motion {
    pub(crate) fn target_axis(&self, call: &Call) -> Result<AxisId, MotionError> {
        call.target
            .map(AxisId)
            .filter(|axis| self.axes.get(*axis).is_some())
            .ok_or(no_target())
    }

    /// Checks the target of a group instruction: there is one motion group.
    pub(crate) fn target_group(&self, call: &Call) -> Result<(), MotionError> {
        match call.target {
            Some(0) => Ok(()),
            _ => Err(no_target()),
        }
    }

    pub(crate) fn target_system(&self, call: &Call) -> Result<SystemId, MotionError> {
        call.target
            .map(SystemId)
            .filter(|system| self.systems.get(*system).is_some())
            .ok_or(no_target())
    }

    /// The axes of the object that an instruction acts on, and of the other coordinate system of a transform. Real-time.
    pub fn axes_of(&self, call: &Call) -> AxisSet {
        let mut axes = AxisSet::default();
        let mut of_system = |system: SystemId| {
            let system = self.systems.get(system);
            for axis in system.iter().flat_map(|system| &system.description.axes) {
                axes.insert(*axis);
            }
        };
        match (call.mnemonic.instruction().object, call.target) {
            (Object::CoordinateSystem, Some(target)) => {
                of_system(SystemId(target));
                if matches!(call.mnemonic, Mnemonic::Mct | Mnemonic::Mcto) {
                    for argument in &call.arguments {
                        if let Argument::Object(other) = argument {
                            of_system(SystemId(*other));
                        }
                    }
                }
            }
            (Object::Axis, Some(target)) => axes.insert(AxisId(target)),
            (Object::MotionGroup, _) => self.axes.ids().for_each(|axis| axes.insert(axis)),
            (_, None) => {}
        }
        axes
    }

    /// Step 5 of the verification: checks the operands in faceplate order.
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

    /// The axis that an operand refers to.
    pub(crate) fn axis_of(&self, operand: &OperandValue<Option<AxisId>>) -> Result<AxisId, MotionError> {
        operand
            .filter(|axis| self.axes.get(*axis).is_some())
            .ok_or(operand.out_of_range())
    }

    /// The coordinate system that an operand refers to.
    pub(crate) fn system_of(&self, operand: &OperandValue<Option<SystemId>>) -> Result<SystemId, MotionError> {
        operand
            .filter(|system| self.systems.get(*system).is_some())
            .ok_or(operand.out_of_range())
    }
}

/// The error of an instruction whose target does not exist: it refers to the first operand.
pub(crate) fn no_target() -> MotionError {
    MotionError::ParameterOutOfRange(OperandIndex(0))
}
