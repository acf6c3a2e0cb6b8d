//! Motion services: an instruction as a CIP service of its object (spec/contract.md §4).
//!
//! The object is addressed by class and instance, or by its name as a symbolic segment. What the operands mean is the
//! catalogue's; here bytes become [`Given`] and results become statuses.

use arcline_controller::image::{ControlError, Image, TagKind};
use arcline_instruction_set::{BindError, Flag, Given, Mnemonic, Object, by_service};
use arcline_proto::arcline::motion::Accepted;
use arcline_proto::cip::{CipStatus, Reply, Request, is_stray_route};
use arcline_proto::epath::{Segment, Target};
use arcline_proto::logix::{Typed, TypedError, decode_operands};
use arcline_proto::session::Transport;
use arcline_tag::{PathSegment, Value};

use super::motion_attributes::count;
use crate::eip::router::Context;
use crate::eip::tags::{self, unknown};
use crate::plant::{Call, CallRefused, Command, Outcome, Plant, Principal};

/// Bytes behind the head of a reply to an instruction that was accepted.
pub(crate) const REPLY_DATA: usize = Accepted::LEN;

/// The services of the motion classes, whatever their object.
const SERVICES: std::ops::RangeInclusive<u8> = 0x32..=0x4A;

/// An instruction that a client wants executed.
#[derive(Debug)]
pub(crate) struct MotionRequest {
    service: u8,
    mnemonic: Mnemonic,
    target: u16,
    /// Empty: unnamed.
    control: String,
    given: Vec<Given>,
}

/// Whether a request is for a motion service: its code, on a motion class or a name.
pub(crate) fn is_motion(request: &Request) -> bool {
    SERVICES.contains(&request.service)
        && match request.path.0.first() {
            Some(Segment::Class(class)) => u16::try_from(*class).is_ok_and(|c| Object::from_class_code(c).is_some()),
            Some(Segment::Symbol(_)) => !tags::is_tag_service(request.service),
            _ => false,
        }
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
    let (object, place) = find(context, image, target)?;
    let mnemonic = by_service(object.class_code(), request.service).ok_or(CipStatus::SERVICE_NOT_SUPPORTED)?;
    let mut operands = operands(&request.data, context.transport)
        .map_err(TypedError::status)?
        .into_iter();
    let control = match operands.next() {
        Some(Typed::ShortString(name)) => name,
        Some(Typed::Numbers(..)) => return Err(CipStatus::INVALID_PARAMETER),
        None => return Err(CipStatus::NOT_ENOUGH_DATA),
    };
    let given = operands.map(given).collect();
    Ok(MotionRequest {
        service: request.service,
        mnemonic,
        target: place,
        control,
        given,
    })
}

impl MotionRequest {
    /// Executes the instruction and waits until it is verified.
    pub(crate) async fn execute(&self, plant: &Plant, principal: Principal) -> Reply {
        let call = Call {
            mnemonic: self.mnemonic,
            target: Some(self.target),
            control: (!self.control.is_empty()).then_some(self.control.as_str()),
            given: &self.given,
            text: None,
        };
        match plant.apply(principal, Command::Call(call)).await {
            Ok(Outcome::Executed(executed)) if executed.control.has(Flag::Er) => {
                let status = CipStatus::vendor(executed.control.err, executed.control.exerr.into());
                Reply::error(self.service, status)
            }
            Ok(Outcome::Executed(executed)) => {
                let accepted = Accepted {
                    instance: executed.instance,
                    control: executed.control.to_bytes(),
                };
                Reply::success(self.service, accepted.to_bytes())
            }
            Ok(_) => Reply::success(self.service, &[][..]),
            Err(refused) => {
                tracing::debug!(%refused, "not executed");
                Reply::error(self.service, tags::refusal(&refused))
            }
        }
    }
}

/// The object a path means, and its place (from 0).
fn find(context: &Context<'_>, image: &Image, target: &Target<'_>) -> Result<(Object, u16), CipStatus> {
    let Some(class) = target.class else {
        let [PathSegment::Symbol(name)] = target.symbols.as_slice() else {
            return Err(CipStatus::SERVICE_NOT_SUPPORTED);
        };
        return match image.find(name).ok_or_else(unknown)?.kind {
            TagKind::MotionGroup => Ok((Object::MotionGroup, 0)),
            TagKind::Axis(place) => Ok((Object::Axis, place)),
            TagKind::CoordinateSystem(place) => Ok((Object::CoordinateSystem, place)),
            _ => Err(CipStatus::SERVICE_NOT_SUPPORTED),
        };
    };
    let object = Object::from_class_code(class).ok_or_else(unknown)?;
    // Instance 0 is the class, which executes nothing.
    let place = target
        .instance
        .unwrap_or(0)
        .checked_sub(1)
        .ok_or(CipStatus::SERVICE_NOT_SUPPORTED)?;
    let place = u16::try_from(place).map_err(|_| unknown())?;
    if usize::from(place) < count(context.device.plant.machine(), object) {
        Ok((object, place))
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

fn given(operand: Typed) -> Given {
    match operand {
        Typed::ShortString(name) => Given::Name(name),
        Typed::Numbers(kind, values) => match values.as_slice() {
            [value] if kind.is_real() => Given::Number(value.as_f64()),
            [value] => value.to_integer().map_or(Given::Number(value.as_f64()), Given::Integer),
            values => Given::Array(values.iter().copied().map(Value::as_f64).collect()),
        },
    }
}

/// The status of a call that was not executed.
pub(crate) fn refusal(refused: &CallRefused) -> CipStatus {
    match refused {
        CallRefused::Bind(BindError::TooFew { .. }) => CipStatus::NOT_ENOUGH_DATA,
        CallRefused::Bind(BindError::TooMany { .. }) => CipStatus::TOO_MUCH_DATA,
        CallRefused::Bind(error) => match error.operand() {
            Some(operand) => CipStatus::INVALID_PARAMETER.with(operand.0.into()),
            None => CipStatus::INVALID_PARAMETER,
        },
        CallRefused::Control(ControlError::NotAMotionControl { .. } | ControlError::NotAName { .. }) => {
            CipStatus::INVALID_PARAMETER
        }
        CallRefused::Control(ControlError::NoRoom) | CallRefused::Busy | CallRefused::NoAnswer => {
            CipStatus::RESOURCE_UNAVAILABLE
        }
    }
}
