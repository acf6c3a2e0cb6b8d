//! Template, class 0x6C: the structures (spec/ethernet-ip.md §11).

use std::sync::Arc;

use arcline_controller::image::Image;
use arcline_proto::cip::{CipStatus, Reply, class, service};
use arcline_proto::logix::{Definition, ReadTemplate};
use arcline_tag::Template;
use bytes::Bytes;

use super::object::{Access, Extent, Object, ObjectContext, On, OwnService};
use crate::eip::status::unknown;
use crate::plant::Right;

#[derive(Debug)]
pub(super) struct Templates;

fn find(image: &Image, instance: u32) -> Result<Arc<Template>, CipStatus> {
    u16::try_from(instance)
        .ok()
        .and_then(|instance| image.template(instance))
        .ok_or_else(unknown)
}

impl Object for Templates {
    fn class(&self) -> u16 {
        class::TEMPLATE
    }

    fn name(&self) -> &'static str {
        "Template"
    }

    fn services(&self) -> &'static [OwnService] {
        &[OwnService {
            code: service::READ_TAG,
            name: "Read Template",
            on: On::Any,
            access: Access::Read,
            right: Right::Look,
        }]
    }

    fn serve(&self, cx: &mut ObjectContext<'_, '_>, instance: u32) -> Result<Reply, CipStatus> {
        let read = ReadTemplate::decode(&cx.request.data)?;
        let (_, definition) = Definition::of(&*find(cx.image(), instance)?);
        Ok(read.reply(&definition.to_bytes(), cx.context.budget))
    }

    fn extent(&self, cx: &ObjectContext<'_, '_>) -> Result<Extent, CipStatus> {
        let image = cx.image();
        let highest = image.templates().last().map_or(0, |template| template.instance.into());
        Ok(Extent {
            highest,
            count: u32::try_from(image.templates().count()).unwrap_or(u32::MAX),
            last_attribute: 5,
        })
    }

    fn check(&self, cx: &ObjectContext<'_, '_>, instance: u32) -> Result<(), CipStatus> {
        find(cx.image(), instance).map(|_| ())
    }

    fn attribute(&self, cx: &ObjectContext<'_, '_>, instance: u32, id: u16) -> Result<Bytes, CipStatus> {
        Definition::of(&*find(cx.image(), instance)?).0.attribute(id)
    }
}
