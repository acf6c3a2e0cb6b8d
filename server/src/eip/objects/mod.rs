//! The CIP objects, in one table (CIP Vol. 1, chapter 5; spec/ethernet-ip.md §13).
//!
//! A new object is a file with an [`Object`] and a row in [`OBJECTS`]. The classes that answer, the list of the Message Router,
//! whether a request holds the plant's lock or waits, and docs/OBJECTS.md derive from the table. Tag services are not here but in
//! [`tags`](super::tags), instructions as services in [`motion`].

mod assembly;
mod attributes;
mod change_detection;
mod connection_manager;
mod ethernet_link;
mod identity;
mod machine;
mod message_router;
pub(crate) mod motion;

mod motion_instruction;
mod motion_objects;
mod object;
pub(crate) mod page;
mod port;
mod program_name;
mod qos;
mod security;
pub(crate) mod series;
mod symbol;
mod tcp_ip_interface;
mod template;
mod trace;
mod values;
mod wall_clock;

use arcline_controller::image::TagKind;
use arcline_instruction_set::Object as MotionObject;
use arcline_proto::cip::{CipStatus, Reply, Request, class, service};
use arcline_proto::epath::Target;

use self::motion_objects::MotionObjects;
use super::context::{Context, Memory};
use super::status::unknown;

pub(crate) use attributes::serve;
pub(crate) use object::{Access, Object, ObjectContext};
#[cfg(test)]
pub(crate) use object::{Extent, On, OwnService};

/// Every class that answers, ascending.
static OBJECTS: [&dyn Object; 22] = [
    &identity::Identity,
    &message_router::MessageRouter,
    &assembly::Assemblies,
    &connection_manager::ConnectionManager,
    &qos::Qos,
    &security::CipSecurity,
    &security::EthernetIpSecurity,
    &security::CertificateManagement,
    &program_name::ProgramName,
    &symbol::Symbols,
    &template::Templates,
    &wall_clock::WallClock,
    &change_detection::ChangeDetection,
    &port::Port,
    &tcp_ip_interface::TcpIpInterface,
    &ethernet_link::EthernetLink,
    &MotionObjects(MotionObject::MotionGroup),
    &MotionObjects(MotionObject::Axis),
    &MotionObjects(MotionObject::CoordinateSystem),
    &motion_instruction::MotionInstructions,
    &trace::Traces,
    &machine::MachineObject,
];

/// A table of objects.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Objects(pub(crate) &'static [&'static dyn Object]);

impl Objects {
    /// The objects of a controller.
    pub(crate) const ALL: Objects = Objects(&OBJECTS);

    /// The object of a class code.
    pub(crate) fn find(self, class: u16) -> Option<&'static dyn Object> {
        self.0.iter().copied().find(|object| object.class() == class)
    }

    /// The access of a service that addresses a tag by name. A motion object has the services of the symbol only.
    pub(crate) fn access_by_name(self, code: u8) -> Access {
        self.find(class::SYMBOL)
            .map_or(Access::Read, |symbol| symbol.access(code))
    }
}

/// Answers a request for a name that is neither a tag service nor a motion service: attributes of the motion object of
/// that name, or of the symbol.
pub(crate) fn serve_named(
    context: &Context<'_>,
    memory: Memory<'_, '_>,
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
        TagKind::MotionGroup => (MotionObject::MotionGroup.class_code(), 1),
        TagKind::Axis(axis) => (MotionObject::Axis.class_code(), u32::from(axis.0) + 1),
        TagKind::CoordinateSystem(system) => (MotionObject::CoordinateSystem.class_code(), u32::from(system.0) + 1),
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
    match context.device.objects.find(class) {
        Some(object) => serve(
            object,
            ObjectContext {
                context,
                memory,
                request,
                target: &target,
            },
        ),
        None => refuse(unknown()),
    }
}
