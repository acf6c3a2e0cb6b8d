//! The CIP objects: classes, instances, attributes (CIP Vol. 1, chapter 5; spec/ethernet-ip.md §13).
//!
//! A class says what its attributes are ([`Class`]); the attribute services are the same for all and stand here. What a
//! class can do besides (paging symbols, reading templates) is in its own file. Tag services and motion services are not
//! here but in [`tags`](super::tags) and [`motion`].

mod assembly;
mod change_detection;
mod connection_manager;
mod ethernet_link;
mod identity;
mod message_router;
pub(crate) mod motion;
mod motion_attributes;
mod motion_instruction;
mod port;
mod program_name;
mod qos;
pub(crate) mod symbol;
mod tcp_ip_interface;
mod template;
mod trace;
mod wall_clock;

use std::cell::RefCell;

use arcline_controller::image::TagKind;
use arcline_instruction_set::Object;
use arcline_proto::arcline::{execution, trace as trace_wire};
use arcline_proto::cip::{
    self, AttributeListReader, AttributeListReply, CipStatus, Reply, Request, class, is_stray_route, service,
};
use arcline_proto::epath::Target;
use arcline_proto::session::Transport;
use bytes::{BufMut, Bytes, BytesMut};

use super::router::{Context, Memory};
use super::tags::unknown;

/// Every class that answers, ascending: the Message Router's object list.
const CLASSES: [u16; 18] = [
    class::IDENTITY,
    class::MESSAGE_ROUTER,
    class::ASSEMBLY,
    class::CONNECTION_MANAGER,
    class::QOS,
    class::PROGRAM_NAME,
    class::SYMBOL,
    class::TEMPLATE,
    class::WALL_CLOCK,
    class::CHANGE_DETECTION,
    class::PORT,
    class::TCP_IP,
    class::ETHERNET_LINK,
    Object::MotionGroup.class_code(),
    Object::Axis.class_code(),
    Object::CoordinateSystem.class_code(),
    EXECUTION,
    trace_wire::CLASS,
];

/// The class of executed instructions.
const EXECUTION: u16 = execution::CLASS;

/// The classes that are answered after the tag memory has been let go: assemblies and executions are behind the plant's
/// lock, and what the system shows of its network stands in files.
pub(crate) const LATE: [u16; 5] = [
    class::ASSEMBLY,
    class::TCP_IP,
    class::ETHERNET_LINK,
    EXECUTION,
    trace_wire::CLASS,
];

/// What the class attributes tell (CIP Vol. 1, 4-4).
struct Extent {
    /// Attribute 2: the highest instance.
    highest: u32,
    /// Attribute 3: how many there are.
    count: u32,
    /// Attribute 7: the highest instance attribute.
    last_attribute: u16,
}

impl Extent {
    /// Instances 1 to `count`.
    fn dense(count: usize, last_attribute: u16) -> Self {
        let count = u32::try_from(count).unwrap_or(u32::MAX);
        Self {
            highest: count,
            count,
            last_attribute,
        }
    }
}

/// A class of objects, as far as its attributes go.
trait Class {
    /// Instances and attributes.
    fn extent(&self) -> Extent;

    /// Class attribute 1.
    fn revision(&self) -> u16 {
        1
    }

    /// The value of a class attribute beyond those that all classes have: 0x14 if there is no such attribute.
    fn class_attribute(&self, _id: u16) -> Result<Bytes, CipStatus> {
        no_attribute()
    }

    /// Class attribute 6: the highest class attribute.
    fn last_class_attribute(&self) -> u16 {
        7
    }

    /// The class attributes of Get Attributes All, in order.
    fn class_all(&self) -> &'static [u16] {
        &[1, 2, 3, 6, 7]
    }

    /// Answers a service that only this class has, or answers in a way of its own.
    fn service(&self, _instance: u32, _request: &Request) -> Option<CipStatus> {
        None
    }

    /// Why there is no such instance (1 or more), if there is none.
    fn check(&self, instance: u32) -> Result<(), CipStatus> {
        if instance <= self.extent().highest {
            Ok(())
        } else {
            Err(unknown())
        }
    }

    /// The value of an attribute of an instance that exists: 0x14 if there is no such attribute.
    fn attribute(&self, instance: u32, id: u16) -> Result<Bytes, CipStatus>;

    /// The attributes of Get Attributes All, in order; empty: the service is not supported.
    fn all(&self) -> &'static [u16] {
        &[]
    }

    /// Bytes of an attribute of an instance that can be set.
    fn settable(&self, _instance: u32, _id: u16) -> Option<usize> {
        None
    }

    /// Sets an attribute that [`Self::settable`] named, from as many bytes.
    fn set(&self, _instance: u32, _id: u16, _value: &[u8]) -> Result<(), CipStatus> {
        Err(CipStatus::ATTRIBUTE_NOT_SETTABLE)
    }
}

/// Answers a request for a class that is not [`LATE`].
pub(crate) fn serve(
    context: &Context<'_>,
    memory: &mut Memory<'_, '_>,
    request: &Request,
    code: u16,
    target: &Target<'_>,
) -> Reply {
    if code == class::SYMBOL && is_table_change(request.service) {
        return symbol::change(context, memory, request, target);
    }
    let image = memory.image();
    let device = context.device;
    let with = |object: &dyn Class| attributes(context, object, request, target);
    match code {
        class::IDENTITY => with(&identity::Identity(&device.settings.identity)),
        class::MESSAGE_ROUTER => with(&message_router::MessageRouter(device)),
        class::CONNECTION_MANAGER => with(&connection_manager::ConnectionManager {
            device,
            principal: context.principal,
        }),
        class::PROGRAM_NAME => with(&program_name::ProgramName(device.settings.identity.name())),
        class::SYMBOL => {
            let scope = match symbol::scope(image, target) {
                Ok(scope) => scope,
                Err(status) => return Reply::error(request.service, status),
            };
            let symbols = symbol::Symbols { image, scope };
            symbols
                .serve(context, request, target)
                .unwrap_or_else(|| with(&symbols))
        }
        class::TEMPLATE => {
            let templates = template::Templates(image);
            templates
                .serve(context, request, target)
                .unwrap_or_else(|| with(&templates))
        }
        class::WALL_CLOCK => with(&wall_clock::WallClock(device)),
        class::CHANGE_DETECTION => with(&change_detection::ChangeDetection(image)),
        class::QOS => with(&qos::Qos),
        class::PORT => with(&port::Port {
            address: *context.local.ip(),
        }),
        code => match Object::from_class_code(code) {
            Some(object) => {
                let objects = motion_attributes::MotionObjects {
                    object,
                    machine: device.plant.machine(),
                    image,
                    settings: RefCell::default(),
                };
                let reply = with(&objects);
                let settings = objects.settings.take();
                write_settings(memory, &settings);
                reply
            }
            None => Reply::error(request.service, unknown()),
        },
    }
}

/// Whether a request may set an attribute.
pub(crate) const fn is_set(code: u8) -> bool {
    matches!(code, service::SET_ATTRIBUTE_SINGLE | service::SET_ATTRIBUTE_LIST)
}

/// Whether a request may change the table of tags.
pub(crate) const fn is_table_change(code: u8) -> bool {
    matches!(code, service::CREATE | service::DELETE)
}

/// Writes attributes that were set, in order.
fn write_settings(memory: &mut Memory<'_, '_>, settings: &[motion_attributes::Setting]) {
    let Memory::Write(transaction) = memory else { return };
    for setting in settings {
        if let Err(error) = transaction.apply(setting.command()) {
            tracing::warn!(%error, "an attribute was not written");
        }
    }
}

/// Answers a request for a class that is [`LATE`]. The plant must not be held.
pub(crate) fn serve_late(context: &Context<'_>, request: &Request, target: &Target<'_>) -> Reply {
    let device = context.device;
    let with = |object: &dyn Class| attributes(context, object, request, target);
    match target.class {
        Some(class::TCP_IP) => with(&tcp_ip_interface::TcpIpInterface {
            adapter: context.adapter(),
            device,
        }),
        Some(class::ASSEMBLY) => with(&assembly::Assemblies(device)),
        Some(trace_wire::CLASS) => trace::serve(context, request, target),
        Some(class::ETHERNET_LINK) => with(&ethernet_link::EthernetLink(context.adapter())),
        _ => with(&motion_instruction::MotionInstructions(&device.plant)),
    }
}

/// Answers a request for a name that is neither a tag service nor a motion service: attributes of the motion object of
/// that name, or of the symbol.
pub(crate) fn serve_named(
    context: &Context<'_>,
    memory: &mut Memory<'_, '_>,
    request: &Request,
    target: &Target<'_>,
) -> Reply {
    let refuse = |status| Reply::error(request.service, status);
    let Some(name) = target.first_symbol() else {
        return refuse(CipStatus::PATH_SEGMENT_ERROR.with(0));
    };
    let Some(tag) = memory.image().find(name) else {
        return refuse(unknown());
    };
    let (class, instance) = match tag.kind {
        TagKind::MotionGroup => (Object::MotionGroup.class_code(), 1),
        TagKind::Axis(place) => (Object::Axis.class_code(), u32::from(place) + 1),
        TagKind::CoordinateSystem(place) => (Object::CoordinateSystem.class_code(), u32::from(place) + 1),
        // As a controller does: rust-ethernet-ip takes an answer for a layout that no controller has, and browses after a refusal.
        _ if request.service == service::GET_ATTRIBUTE_LIST => return refuse(CipStatus::PATH_SEGMENT_ERROR.with(0)),
        _ => (class::SYMBOL, tag.id.0),
    };
    if target.symbols.len() > 1 {
        return refuse(CipStatus::SERVICE_NOT_SUPPORTED);
    }
    let target = Target {
        class: Some(class),
        instance: Some(instance),
        attribute: target.attribute,
        ..Target::default()
    };
    serve(context, memory, request, class, &target)
}

/// The attribute services (CIP Vol. 1, appendix A), for the class itself (instance 0 or none) and its instances.
fn attributes(context: &Context<'_>, object: &dyn Class, request: &Request, target: &Target<'_>) -> Reply {
    let code = request.service;
    let instance = target.instance.unwrap_or(0);
    let access = Attributes { object, instance };
    if instance > 0
        && let Err(status) = object.check(instance)
    {
        return Reply::error(code, status);
    }
    if let Some(status) = object.service(instance, request) {
        return Reply::error(code, status);
    }
    let done = match code {
        service::GET_ATTRIBUTES_ALL => access.all(),
        service::GET_ATTRIBUTE_SINGLE => match target.attribute {
            Some(id) => access.value(id),
            None => Err(CipStatus::PATH_SEGMENT_ERROR.with(0)),
        },
        service::GET_ATTRIBUTE_LIST => return access.list(request, context.budget),
        service::SET_ATTRIBUTE_SINGLE => match target.attribute {
            Some(id) => access
                .set_single(id, &request.data, context.transport)
                .map(|()| Bytes::new()),
            None => Err(CipStatus::PATH_SEGMENT_ERROR.with(0)),
        },
        service::SET_ATTRIBUTE_LIST => return access.set_list(request, context.budget),
        _ => Err(CipStatus::SERVICE_NOT_SUPPORTED),
    };
    match done {
        Ok(data) => bounded(Reply::success(code, data), context.budget),
        Err(status) => Reply::error(code, status),
    }
}

fn bounded(reply: Reply, budget: usize) -> Reply {
    if reply.len() > budget {
        Reply::error(reply.service, CipStatus::REPLY_TOO_LARGE)
    } else {
        reply
    }
}

/// Attributes of one instance, or of the class (instance 0).
struct Attributes<'a> {
    object: &'a dyn Class,
    instance: u32,
}

impl Attributes<'_> {
    fn value(&self, id: u16) -> Result<Bytes, CipStatus> {
        if self.instance > 0 {
            self.object.attribute(self.instance, id)
        } else {
            self.class_value(id)
        }
    }

    /// Revision, highest instance, number of instances, no optional attributes and services, highest attributes.
    fn class_value(&self, id: u16) -> Result<Bytes, CipStatus> {
        let extent = self.object.extent();
        let narrow = |wide: u32| u16::try_from(wide).unwrap_or(u16::MAX);
        let value = match id {
            1 => self.object.revision(),
            2 => narrow(extent.highest),
            3 => narrow(extent.count),
            // Lists that are empty.
            4 | 5 => 0,
            6 => self.object.last_class_attribute(),
            7 => extent.last_attribute,
            id => return self.object.class_attribute(id),
        };
        Ok(Bytes::copy_from_slice(&u16::to_le_bytes(value)))
    }

    fn all(&self) -> Result<Bytes, CipStatus> {
        let ids = if self.instance > 0 {
            self.object.all()
        } else {
            self.object.class_all()
        };
        if ids.is_empty() {
            return Err(CipStatus::SERVICE_NOT_SUPPORTED);
        }
        let mut out = BytesMut::new();
        for id in ids {
            out.put_slice(&self.value(*id)?);
        }
        Ok(out.freeze())
    }

    fn list(&self, request: &Request, budget: usize) -> Reply {
        let ids = match cip::decode_attribute_ids(&request.data) {
            Ok(ids) => ids,
            Err(status) => return Reply::error(request.service, status),
        };
        let mut list = AttributeListReply::new(request.service);
        for id in ids {
            match self.value(id) {
                Ok(value) => list.push(id, Ok(&value)),
                Err(status) => list.push(id, Err(status)),
            }
        }
        list.finish(budget)
    }

    fn set(&self, id: u16, value: &[u8]) -> Result<(), CipStatus> {
        self.width(id)?;
        self.object.set(self.instance, id, value)
    }

    /// Bytes of an attribute, if it can be set.
    fn width(&self, id: u16) -> Result<usize, CipStatus> {
        match self.object.settable(self.instance, id) {
            Some(width) if self.instance > 0 => Ok(width),
            _ => Err(self
                .value(id)
                .map_or_else(|status| status, |_| CipStatus::ATTRIBUTE_NOT_SETTABLE)),
        }
    }

    fn set_single(&self, id: u16, data: &[u8], transport: Transport) -> Result<(), CipStatus> {
        let width = self.width(id)?;
        let (value, surplus) = data.split_at_checked(width).ok_or(CipStatus::NOT_ENOUGH_DATA)?;
        let stray = transport == Transport::Unconnected && is_stray_route(surplus);
        if !surplus.is_empty() && !stray {
            return Err(CipStatus::TOO_MUCH_DATA);
        }
        self.set(id, value)
    }

    /// The first attribute whose width nobody knows ends the list: what follows cannot be read.
    fn set_list(&self, request: &Request, budget: usize) -> Reply {
        let refuse = |status| Reply::error(request.service, status);
        let mut values = match AttributeListReader::new(&request.data) {
            Ok(values) => values,
            Err(status) => return refuse(status),
        };
        let mut list = AttributeListReply::new(request.service);
        while values.left() > 0 {
            let Some(id) = values.next_id() else {
                return refuse(CipStatus::NOT_ENOUGH_DATA);
            };
            let width = match self.width(id) {
                Ok(width) => width,
                Err(status) => {
                    list.push(id, Err(status));
                    break;
                }
            };
            let Some(value) = values.value(width) else {
                return refuse(CipStatus::NOT_ENOUGH_DATA);
            };
            list.push(id, self.set(id, value).map(|()| &[][..]));
        }
        list.finish(budget)
    }
}

/// `length u8, bytes`.
fn short_string(text: &str) -> Bytes {
    let length = u8::try_from(text.len()).unwrap_or(u8::MAX);
    let mut out = BytesMut::with_capacity(1 + text.len());
    out.put_u8(length);
    out.put_slice(text.as_bytes().get(..usize::from(length)).unwrap_or_default());
    out.freeze()
}

/// `length u16, bytes`, at most 65,535.
fn long_string(text: &str) -> Bytes {
    let length = u16::try_from(text.len()).unwrap_or(u16::MAX);
    let mut out = BytesMut::with_capacity(2 + text.len());
    out.put_u16_le(length);
    out.put_slice(text.as_bytes().get(..usize::from(length)).unwrap_or_default());
    out.freeze()
}

fn u8_value(value: u8) -> Result<Bytes, CipStatus> {
    Ok(Bytes::copy_from_slice(&[value]))
}

fn u16_value(value: u16) -> Result<Bytes, CipStatus> {
    Ok(Bytes::copy_from_slice(&value.to_le_bytes()))
}

fn u32_value(value: u32) -> Result<Bytes, CipStatus> {
    Ok(Bytes::copy_from_slice(&value.to_le_bytes()))
}

fn u64_value(value: u64) -> Result<Bytes, CipStatus> {
    Ok(Bytes::copy_from_slice(&value.to_le_bytes()))
}

fn f64_value(value: f64) -> Result<Bytes, CipStatus> {
    Ok(Bytes::copy_from_slice(&value.to_le_bytes()))
}

/// 0x14.
fn no_attribute() -> Result<Bytes, CipStatus> {
    Err(CipStatus::ATTRIBUTE_NOT_SUPPORTED)
}
