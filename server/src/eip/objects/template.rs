//! Template, class 0x6C: the structures (spec/ethernet-ip.md §11).

use std::sync::Arc;

use arcline_controller::image::Image;
use arcline_proto::cip::{CipStatus, Reply, Request, service};
use arcline_proto::epath::Target;
use arcline_proto::logix::{Definition, ReadTemplate};
use arcline_tag::Template;
use bytes::Bytes;

use super::{Class, Extent};
use crate::eip::router::Context;
use crate::eip::tags::unknown;

pub(super) struct Templates<'a>(pub(super) &'a Image);

impl Templates<'_> {
    /// The class's own service: Read Template. `None`: it is another one.
    pub(super) fn serve(&self, context: &Context<'_>, request: &Request, target: &Target<'_>) -> Option<Reply> {
        if request.service != service::READ_TAG {
            return None;
        }
        let read = ReadTemplate::decode(&request.data);
        let reply = read.and_then(|read| {
            let template = self.find(target.instance.unwrap_or(0))?;
            let (_, definition) = Definition::of(&template);
            Ok(read.reply(&definition.to_bytes(), context.budget))
        });
        Some(reply.unwrap_or_else(|status| Reply::error(request.service, status)))
    }

    fn find(&self, instance: u32) -> Result<Arc<Template>, CipStatus> {
        u16::try_from(instance)
            .ok()
            .and_then(|instance| self.0.template(instance))
            .ok_or_else(unknown)
    }
}

impl Class for Templates<'_> {
    fn extent(&self) -> Extent {
        let highest = self.0.templates().last().map_or(0, |template| template.instance.into());
        Extent {
            highest,
            count: u32::try_from(self.0.templates().count()).unwrap_or(u32::MAX),
            last_attribute: 5,
        }
    }

    fn check(&self, instance: u32) -> Result<(), CipStatus> {
        self.find(instance).map(|_| ())
    }

    fn attribute(&self, instance: u32, id: u16) -> Result<Bytes, CipStatus> {
        Definition::of(&*self.find(instance)?).0.attribute(id)
    }
}
