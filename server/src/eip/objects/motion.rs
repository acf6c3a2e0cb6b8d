//! Motion services: an instruction as a CIP service of its object (spec/contract.md §4).
//!
//! A request addresses the object by class and instance, or by its name as a symbolic segment. The catalogue gives the operands their
//! meaning; this module turns bytes into [`UnboundOperand`], and results into statuses.

use arcline_controller::image::{Image, TagKind};
use arcline_instruction_set::{Flag, Mnemonic, MotionControl, Object, UnboundOperand, by_service};
use arcline_proto::arcline::motion::Accepted;
use arcline_proto::cip::{CipStatus, Reply, Request, is_stray_route};
use arcline_proto::epath::Target;
use arcline_proto::logix::{Typed, TypedError, decode_operands};
use arcline_proto::session::Transport;
use arcline_tag::{PathSegment, Value};

use super::motion_objects::count;
use crate::eip::context::Context;
use crate::eip::status::{refusal, unknown};
use crate::plant::{Call, Command, Executed, Outcome, Plant, Principal, Refused};

/// Bytes behind the head of a reply to an instruction that was accepted.
pub(crate) const REPLY_DATA: usize = Accepted::LEN;

/// An instruction that a client asks to execute.
#[derive(Debug)]
pub(crate) struct MotionRequest {
    pub(super) service: u8,
    mnemonic: Mnemonic,
    target: u16,
    /// Empty: unnamed.
    control: String,
    operands: Vec<UnboundOperand>,
}

/// Reads a motion service's request.
///
/// # Errors
/// 0x05 for an object there is not, 0x08 for a service it does not have, 0x13, 0x15 and 0x20 for operands that are not
/// laid out as they must be.
pub(crate) fn parse(
    context: &Context<'_>,
    image: &Image,
    request: &Request,
    target: &Target<'_>,
) -> Result<MotionRequest, CipStatus> {
    let (object, index) = find(context, image, target)?;
    let mnemonic = by_service(object.class_code(), request.service).ok_or(CipStatus::SERVICE_NOT_SUPPORTED)?;
    let mut operands = operands(&request.data, context.transport)
        .map_err(TypedError::status)?
        .into_iter();
    let control = match operands.next() {
        Some(Typed::ShortString(name)) => name,
        Some(Typed::Numbers(..)) => return Err(CipStatus::INVALID_PARAMETER),
        None => return Err(CipStatus::NOT_ENOUGH_DATA),
    };
    let operands = operands.map(unbound).collect();
    Ok(MotionRequest {
        service: request.service,
        mnemonic,
        target: index,
        control,
        operands,
    })
}

/// Whether a motion service is an instruction that stops or switches off.
pub(crate) fn is_stop(context: &Context<'_>, image: &Image, request: &Request, target: &Target<'_>) -> bool {
    let object = find(context, image, target).ok();
    let mnemonic = object.and_then(|(object, _)| by_service(object.class_code(), request.service));
    mnemonic.is_some_and(Mnemonic::is_stop)
}

impl MotionRequest {
    /// Executes the instruction and waits until it is verified.
    pub(crate) async fn execute(&self, plant: &Plant, principal: Principal) -> Reply {
        match plant.apply(principal, Command::Call(self.call())).await {
            Ok(Outcome::Executed(executed)) if executed.control.has(Flag::Er) => self.erred(&executed.control),
            Ok(Outcome::Executed(executed)) => Reply::success(self.service, accepted(&executed).to_bytes()),
            Ok(_) => Reply::success(self.service, &[][..]),
            Err(refused) => self.refused(&refused),
        }
    }

    /// The call.
    pub(super) fn call(&self) -> Call<'_> {
        Call {
            mnemonic: self.mnemonic,
            target: Some(self.target),
            control: (!self.control.is_empty()).then_some(self.control.as_str()),
            operands: &self.operands,
            text: None,
        }
    }

    /// The reply to an instruction that has erred.
    pub(super) fn erred(&self, control: &MotionControl) -> Reply {
        Reply::error(self.service, CipStatus::vendor(control.err, control.exerr.into()))
    }

    /// The reply to an instruction that was refused.
    pub(super) fn refused(&self, refused: &Refused) -> Reply {
        tracing::debug!(%refused, "not executed");
        Reply::error(self.service, refusal(refused))
    }
}

/// An instruction that was accepted, as replies show it.
pub(super) fn accepted(executed: &Executed) -> Accepted {
    Accepted {
        instance: executed.instance,
        control: executed.control.to_bytes(),
    }
}

/// The object a path means, and its index.
fn find(context: &Context<'_>, image: &Image, target: &Target<'_>) -> Result<(Object, u16), CipStatus> {
    let Some(class) = target.class else {
        let [PathSegment::Symbol(name)] = target.symbols.as_slice() else {
            return Err(CipStatus::SERVICE_NOT_SUPPORTED);
        };
        return match image.find(name).ok_or_else(unknown)?.kind {
            TagKind::MotionGroup => Ok((Object::MotionGroup, 0)),
            TagKind::Axis(axis) => Ok((Object::Axis, axis.0)),
            TagKind::CoordinateSystem(system) => Ok((Object::CoordinateSystem, system.0)),
            _ => Err(CipStatus::SERVICE_NOT_SUPPORTED),
        };
    };
    let object = Object::from_class_code(class).ok_or_else(unknown)?;
    // Instance 0 is the class, which executes nothing.
    let index = target
        .instance
        .unwrap_or(0)
        .checked_sub(1)
        .ok_or(CipStatus::SERVICE_NOT_SUPPORTED)?;
    let index = u16::try_from(index).map_err(|_| unknown())?;
    if usize::from(index) < count(context.device.plant.machine(), object) {
        Ok((object, index))
    } else {
        Err(unknown())
    }
}

/// Operands; a route that a stock client leaves behind an unconnected message is not one of them.
fn operands(data: &[u8], transport: Transport) -> Result<Vec<Typed>, TypedError> {
    let whole = decode_operands(data);
    if whole.is_ok() || transport != Transport::Unconnected {
        return whole;
    }
    let stripped = [2, 4].into_iter().find_map(|length| {
        let (operands, route) = data.split_at_checked(data.len().checked_sub(length)?)?;
        if is_stray_route(route) {
            decode_operands(operands).ok()
        } else {
            None
        }
    });
    stripped.map_or(whole, Ok)
}

fn unbound(operand: Typed) -> UnboundOperand {
    match operand {
        Typed::ShortString(name) => UnboundOperand::Name(name),
        Typed::Numbers(kind, values) => match values.as_slice() {
            [value] if kind.is_real() => UnboundOperand::Number(value.as_f64()),
            [value] => value
                .to_integer()
                .map_or(UnboundOperand::Number(value.as_f64()), UnboundOperand::Integer),
            values => UnboundOperand::Array(values.iter().copied().map(Value::as_f64).collect()),
        },
    }
}
