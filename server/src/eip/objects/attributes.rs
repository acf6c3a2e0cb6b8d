//! The attribute services, which are the same for all objects (CIP Vol. 1, appendix A), and the way to the services of one class.

use arcline_proto::cip::{self, AttributeListReader, AttributeListReply, CipStatus, Reply, service};
use bytes::{BufMut, Bytes, BytesMut};

use super::object::{Object, ObjectContext, On};
use crate::audit::EventKind;

/// Answers a request for a class (instance 0 or none) or for one of its instances.
pub(crate) fn serve(object: &dyn Object, mut cx: ObjectContext<'_, '_>) -> Reply {
    let (code, budget) = (cx.request.service, cx.context.budget);
    let reply = answer(object, &mut cx).unwrap_or_else(|status| Reply::error(code, status));
    if reply.len() > budget {
        Reply::error(code, CipStatus::REPLY_TOO_LARGE)
    } else {
        reply
    }
}

fn answer(object: &dyn Object, cx: &mut ObjectContext<'_, '_>) -> Result<Reply, CipStatus> {
    let (code, instance) = (cx.request.service, cx.instance());
    let own = object.services().iter().find(|own| own.code == code);
    match (own.map(|own| own.on), instance) {
        (Some(On::Class), 1..) | (Some(On::Instance), 0) => return Err(CipStatus::SERVICE_NOT_SUPPORTED),
        (Some(On::Any | On::Class), _) | (None, 0) => {}
        (Some(On::Instance) | None, 1..) => object.check(cx, instance)?,
    }
    if let Some(own) = own {
        cx.check(own.right)?;
        let reply = object.serve(cx, instance)?;
        if own.right.is_of_interface() && reply.status.is_success() {
            let what = match instance {
                0 => format!("{} of {}", own.name, object.name()),
                instance => format!("{} of {} {instance}", own.name, object.name()),
            };
            let plant = &cx.device().plant;
            plant.record(cx.context.principal, EventKind::Config, what, "done");
        }
        return Ok(reply);
    }
    let mut attributes = Attributes { object, instance, cx };
    let data = match code {
        service::GET_ATTRIBUTES_ALL => attributes.all()?,
        service::GET_ATTRIBUTE_SINGLE => attributes.value(attributes.id()?)?,
        service::GET_ATTRIBUTE_LIST => return attributes.list(),
        service::SET_ATTRIBUTE_SINGLE => attributes.set_single().map(|()| Bytes::new())?,
        service::SET_ATTRIBUTE_LIST => return attributes.set_list(),
        _ => return Err(CipStatus::SERVICE_NOT_SUPPORTED),
    };
    Ok(Reply::success(code, data))
}

/// Attributes of one instance, or of the class (instance 0).
struct Attributes<'c, 'a, 't> {
    object: &'c dyn Object,
    instance: u32,
    cx: &'c mut ObjectContext<'a, 't>,
}

impl Attributes<'_, '_, '_> {
    /// The attribute that the path names.
    fn id(&self) -> Result<u16, CipStatus> {
        self.cx.target.attribute.ok_or(CipStatus::PATH_SEGMENT_ERROR.with(0))
    }

    fn value(&self, id: u16) -> Result<Bytes, CipStatus> {
        if self.instance > 0 {
            self.object.attribute(self.cx, self.instance, id)
        } else {
            self.class_value(id)
        }
    }

    /// Revision, highest instance, number of instances, no optional attributes and services, highest attributes.
    fn class_value(&self, id: u16) -> Result<Bytes, CipStatus> {
        let extent = self.object.extent(self.cx)?;
        let narrow = |wide: u32| u16::try_from(wide).unwrap_or(u16::MAX);
        let value = match id {
            1 => self.object.revision(),
            2 => narrow(extent.highest),
            3 => narrow(extent.count),
            // Lists that are empty.
            4 | 5 => 0,
            6 => self.object.last_class_attribute(),
            7 => extent.last_attribute,
            id => return self.object.class_attribute(self.cx, id),
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

    fn list(&self) -> Result<Reply, CipStatus> {
        let request = self.cx.request;
        let mut list = AttributeListReply::new(request.service);
        for id in cip::decode_attribute_ids(&request.data)? {
            match self.value(id) {
                Ok(value) => list.push(id, Ok(&value)),
                Err(status) => list.push(id, Err(status)),
            }
        }
        Ok(list.finish(self.cx.context.budget))
    }

    fn set(&mut self, id: u16, value: &[u8]) -> Result<(), CipStatus> {
        let right = self.object.right_to_set();
        self.cx.check(right)?;
        if !right.is_of_interface() {
            return self.object.set(self.cx, self.instance, id, value);
        }
        let before = self.value(id).unwrap_or_default();
        self.object.set(self.cx, self.instance, id, value)?;
        let what = format!("attribute {id} of {} {}", self.object.name(), self.instance);
        let plant = &self.cx.device().plant;
        plant.record_set(self.cx.context.principal, right, what, &before, value);
        Ok(())
    }

    /// Bytes of an attribute, if it can be set.
    fn width(&self, id: u16) -> Result<usize, CipStatus> {
        match self.object.settable(self.cx, self.instance, id) {
            Some(width) if self.instance > 0 => Ok(width),
            _ => Err(self
                .value(id)
                .map_or_else(|status| status, |_| CipStatus::ATTRIBUTE_NOT_SETTABLE)),
        }
    }

    fn set_single(&mut self) -> Result<(), CipStatus> {
        let (id, request) = (self.id()?, self.cx.request);
        let width = self.width(id)?;
        let (value, surplus) = request.data.split_at_checked(width).ok_or(CipStatus::NOT_ENOUGH_DATA)?;
        self.cx.no_surplus(surplus)?;
        self.set(id, value)
    }

    /// The first attribute of unknown width ends the list: the server cannot read the bytes behind it.
    fn set_list(&mut self) -> Result<Reply, CipStatus> {
        let request = self.cx.request;
        let mut values = AttributeListReader::new(&request.data)?;
        let mut list = AttributeListReply::new(request.service);
        while values.left() > 0 {
            let id = values.next_id().ok_or(CipStatus::NOT_ENOUGH_DATA)?;
            let width = match self.width(id) {
                Ok(width) => width,
                Err(status) => {
                    list.push(id, Err(status));
                    break;
                }
            };
            let value = values.value(width).ok_or(CipStatus::NOT_ENOUGH_DATA)?;
            list.push(id, self.set(id, value).map(|()| &[][..]));
        }
        Ok(list.finish(self.cx.context.budget))
    }
}
