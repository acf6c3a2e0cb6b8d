//! The CIP status of missing objects and of commands that the plant refuses (spec/ethernet-ip.md §6).

use arcline_controller::image::{ControlError, TableError, WriteError};
use arcline_instruction_set::BindError;
use arcline_proto::cip::CipStatus;
use arcline_proto::status::general_error;
use arcline_tag::PathError;

use crate::plant::{CallRefused, Refused};

/// 0x05 with the word 0x0000: every client reads it as "no such tag".
pub(crate) fn unknown() -> CipStatus {
    CipStatus::PATH_DESTINATION_UNKNOWN.with(0)
}

/// The status for a path that does not exist within a tag.
pub(crate) fn path_status(error: &PathError) -> CipStatus {
    match error {
        PathError::IndexOutOfRange { .. } => CipStatus::GENERAL_ERROR.with(general_error::ELEMENTS_BEYOND_TAG),
        _ => unknown(),
    }
}

/// The status for a command that is refused.
pub(crate) fn refusal(refused: &Refused) -> CipStatus {
    match refused {
        Refused::Write(error) => write_status(error),
        Refused::Table(error) => table_status(error),
        Refused::Call(error) => call_status(error),
        Refused::Role { .. } | Refused::NoControl { .. } => CipStatus::PRIVILEGE_VIOLATION,
        // Only jog buttons of the page have these refusals.
        Refused::MovedByAnother { .. } | Refused::NoProgram | Refused::Force(_) | Refused::NotStepped => {
            CipStatus::OBJECT_STATE_CONFLICT
        }
        Refused::NotPersisted(_) => CipStatus::STORE_FAILURE,
    }
}

/// The status for a write that the image refuses.
fn write_status(error: &WriteError) -> CipStatus {
    match error {
        WriteError::NoRoom { .. } => CipStatus::RESOURCE_UNAVAILABLE,
        WriteError::ReadOnly { .. } => CipStatus::PRIVILEGE_VIOLATION,
        WriteError::OutsideRange { .. } | WriteError::NotInRange { .. } => CipStatus::INVALID_ATTRIBUTE_VALUE,
        WriteError::NotSettable { .. } => CipStatus::ATTRIBUTE_NOT_SETTABLE,
        WriteError::OutOfRange { .. } | WriteError::NoSuchFault { .. } => CipStatus::INVALID_PARAMETER,
        _ => unknown(),
    }
}

fn table_status(error: &TableError) -> CipStatus {
    match error {
        TableError::NotAName { .. } => CipStatus::INVALID_PARAMETER,
        TableError::Taken { .. } => CipStatus::OBJECT_ALREADY_EXISTS,
        TableError::NoRoom => CipStatus::RESOURCE_UNAVAILABLE,
        TableError::NoSuchTag => unknown(),
        TableError::NotPlain { .. } => CipStatus::PRIVILEGE_VIOLATION,
        TableError::InUse { .. } => CipStatus::OBJECT_STATE_CONFLICT,
    }
}

fn call_status(refused: &CallRefused) -> CipStatus {
    match refused {
        CallRefused::Bind(BindError::TooFew { .. }) => CipStatus::NOT_ENOUGH_DATA,
        CallRefused::Bind(BindError::TooMany { .. }) => CipStatus::TOO_MUCH_DATA,
        CallRefused::Bind(error) => match error.operand() {
            Some(operand) => CipStatus::INVALID_PARAMETER.with(operand.0.into()),
            None => CipStatus::INVALID_PARAMETER,
        },
        CallRefused::NotOfSeries { .. } => CipStatus::INVALID_PARAMETER,
        CallRefused::Control(ControlError::NotAMotionControl { .. } | ControlError::NotAName { .. }) => {
            CipStatus::INVALID_PARAMETER
        }
        CallRefused::Control(ControlError::NoRoom) | CallRefused::Busy | CallRefused::NoAnswer => {
            CipStatus::RESOURCE_UNAVAILABLE
        }
    }
}
