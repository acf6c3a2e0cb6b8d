//! The parts of a CIP object: its class, instances, attributes and services.

use std::fmt::Debug;

use arcline_controller::image::Image;
use arcline_proto::cip::{CipStatus, Reply, Request, is_stray_route, service};
use arcline_proto::epath::Target;
use arcline_proto::session::Transport;
use bytes::Bytes;

use super::values::no_attribute;
use crate::eip::context::{Context, Memory};
use crate::eip::device::Device;
use crate::eip::status::{refusal, unknown};
use crate::plant::{Command, Outcome, Right};

/// A CIP object: a class and its instances.
///
/// The attribute services are the same for all objects and not here.
pub(crate) trait Object: Debug + Sync {
    /// The class code.
    fn class(&self) -> u16;

    /// The name of the class.
    fn name(&self) -> &'static str;

    /// Whether the object must not be read under the plant's lock, since it takes that lock itself or reads files of the host.
    fn is_late(&self) -> bool {
        false
    }

    /// Whether the instances execute instructions as services.
    fn is_motion(&self) -> bool {
        false
    }

    /// The services that only this class has, or that it answers in a way of its own.
    fn services(&self) -> &'static [OwnService] {
        &[]
    }

    /// Answers one of [`Self::services`] for an instance, 0: the class.
    fn serve(&self, _cx: &mut ObjectContext<'_, '_>, _instance: u32) -> Result<Reply, CipStatus> {
        Err(CipStatus::SERVICE_NOT_SUPPORTED)
    }

    /// Instances and attributes.
    fn extent(&self, cx: &ObjectContext<'_, '_>) -> Result<Extent, CipStatus>;

    /// Class attribute 1.
    fn revision(&self) -> u16 {
        1
    }

    /// The value of a class attribute beyond those that all classes have: 0x14 if there is no such attribute.
    fn class_attribute(&self, _cx: &ObjectContext<'_, '_>, _id: u16) -> Result<Bytes, CipStatus> {
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

    /// Checks that an instance (1 or more) exists.
    fn check(&self, cx: &ObjectContext<'_, '_>, instance: u32) -> Result<(), CipStatus> {
        if instance <= self.extent(cx)?.highest {
            Ok(())
        } else {
            Err(unknown())
        }
    }

    /// The value of an attribute of an instance that exists: 0x14 if there is no such attribute.
    fn attribute(&self, cx: &ObjectContext<'_, '_>, instance: u32, id: u16) -> Result<Bytes, CipStatus>;

    /// The attributes of Get Attributes All, in order; empty: the service is not supported.
    fn all(&self) -> &'static [u16] {
        &[]
    }

    /// Bytes of an attribute of an instance that can be set.
    fn settable(&self, _cx: &ObjectContext<'_, '_>, _instance: u32, _id: u16) -> Option<usize> {
        None
    }

    /// The right that setting an attribute needs. The plant checks its own commands too.
    fn right_to_set(&self) -> Right {
        Right::Administer
    }

    /// Sets an attribute that [`Self::settable`] named, from as many bytes.
    fn set(&self, _cx: &mut ObjectContext<'_, '_>, _instance: u32, _id: u16, _value: &[u8]) -> Result<(), CipStatus> {
        Err(CipStatus::ATTRIBUTE_NOT_SETTABLE)
    }
}

impl dyn Object {
    /// The row of a service that only this class has.
    pub(crate) fn own_service(&self, code: u8) -> Option<&'static OwnService> {
        self.services().iter().find(|own| own.code == code)
    }

    /// The access of a service.
    pub(crate) fn access(&self, code: u8) -> Access {
        match (self.is_late(), self.own_service(code)) {
            (true, _) => Access::Late,
            (false, Some(own)) => own.access,
            (false, None) if matches!(code, service::SET_ATTRIBUTE_SINGLE | service::SET_ATTRIBUTE_LIST) => Access::Set,
            (false, None) => Access::Read,
        }
    }
}

/// The access of a service to the tag memory.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Access {
    /// Reads it, without a lock.
    Read,
    /// May set an attribute that is in it, under the plant's lock.
    Set,
    /// Changes the table of tags, under the plant's lock; it succeeds only when the file of the retained state has the change.
    Change,
    /// Is answered when the plant's lock is free.
    Late,
    /// Executes a series of moves, and is answered when they are verified.
    Series,
}

/// A service of one class.
#[derive(Clone, Copy, Debug)]
pub(crate) struct OwnService {
    /// The service code.
    pub(crate) code: u8,
    /// The name of the service.
    pub(crate) name: &'static str,
    /// The instances to which the service applies.
    pub(crate) on: On,
    /// The access to the tag memory; of an object that answers late, always late.
    pub(crate) access: Access,
    /// The right that the service needs. The plant checks its own commands too.
    pub(crate) right: Right,
}

/// The instances to which a service applies; for the others the status is 0x08.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum On {
    /// On the class: instance 0 or none.
    Class,
    /// On an instance that exists.
    Instance,
    /// On any instance number, which the service ignores.
    Any,
}

/// The values of the class attributes (CIP Vol. 1, 4-4).
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) struct Extent {
    /// Attribute 2: the highest instance.
    pub(crate) highest: u32,
    /// Attribute 3: the number of instances.
    pub(crate) count: u32,
    /// Attribute 7: the highest instance attribute.
    pub(crate) last_attribute: u16,
}

impl Extent {
    /// Instances 1 to `count`.
    pub(crate) fn dense(count: usize, last_attribute: u16) -> Result<Self, CipStatus> {
        let count = u32::try_from(count).unwrap_or(u32::MAX);
        Ok(Self {
            highest: count,
            count,
            last_attribute,
        })
    }
}

/// One request to an object, and the resources for its answer.
pub(crate) struct ObjectContext<'a, 't> {
    /// The device and the connection.
    pub(crate) context: &'a Context<'a>,
    /// The tag memory.
    pub(crate) memory: Memory<'a, 't>,
    /// The request.
    pub(crate) request: &'a Request,
    /// The meaning of its path.
    pub(crate) target: &'a Target<'a>,
}

impl<'a> ObjectContext<'a, '_> {
    /// The device.
    pub(crate) fn device(&self) -> &'a Device {
        self.context.device
    }

    /// The tag memory, to read.
    pub(crate) fn image(&self) -> &Image {
        self.memory.image()
    }

    /// The instance that is asked, 0: the class.
    pub(crate) fn instance(&self) -> u32 {
        self.target.instance.unwrap_or(0)
    }

    /// Refuses a client whose role does not have a right: 0x0F.
    pub(crate) fn check(&self, right: Right) -> Result<(), CipStatus> {
        let checked = self.device().plant.check(self.context.principal, right);
        checked.map_err(|refused| refusal(&refused))
    }

    /// Refuses data: 0x15.
    pub(crate) fn no_data(&self) -> Result<(), CipStatus> {
        self.no_surplus(&self.request.data)
    }

    /// Refuses bytes behind the data: 0x15. Behind an unconnected request may stand the route of a message that a client sent without its
    /// wrapping.
    pub(crate) fn no_surplus(&self, surplus: &[u8]) -> Result<(), CipStatus> {
        let is_stray = self.context.transport == Transport::Unconnected && is_stray_route(surplus);
        if surplus.is_empty() || is_stray {
            Ok(())
        } else {
            Err(CipStatus::TOO_MUCH_DATA)
        }
    }

    /// Executes a command of the client; its row says that it needs the tag memory for writing.
    pub(crate) fn apply(&mut self, command: Command<'_>) -> Result<Outcome, CipStatus> {
        match &mut self.memory {
            Memory::Write(transaction) => transaction.apply(command).map_err(|refused| refusal(&refused)),
            Memory::Read(_) => Err(CipStatus::RESOURCE_UNAVAILABLE),
        }
    }
}
