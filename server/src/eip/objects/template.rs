//! Template, class 0x6C: the structures (spec/ethernet-ip.md §11).

use std::sync::Arc;

use arcline_controller::image::Image;
use arcline_proto::cip::{CipStatus, Reply, Request, service};
use arcline_proto::epath::Target;
use arcline_proto::logix::ReadTemplate;
use arcline_tag::Template;
use bytes::Bytes;

use super::{Class, Extent, no_attribute, u16_value, u32_value};
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
            Ok(read.reply(&template.definition(), context.budget))
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

    /// Attribute 3 means nothing, but a stock client needs it.
    fn attribute(&self, instance: u32, id: u16) -> Result<Bytes, CipStatus> {
        let template = self.find(instance)?;
        match id {
            1 => u16_value(template.handle),
            2 => u16_value(u16::try_from(template.members.len()).unwrap_or(u16::MAX)),
            3 => u16_value(0),
            4 => u32_value(template.definition_words()),
            5 => u32_value(template.size),
            _ => no_attribute(),
        }
    }
}
