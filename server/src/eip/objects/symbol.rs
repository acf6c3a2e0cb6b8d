//! Symbol, class 0x6B: the list of tags, and the plain tags that clients create and delete (spec/ethernet-ip.md §10).
//!
//! Reading and writing a tag by its instance is [`tags`](crate::eip::tags)'s.

use arcline_controller::image::{Access as ExternalAccess, PlainTag, Tag, TagId, TagKind};
use arcline_proto::cip::{self, CipStatus, Reply, class, service};
use arcline_proto::logix::{CreateSymbol, Symbol, instance_list_reply};
use arcline_tag::program_name;
use bytes::{BufMut, Bytes, BytesMut};

use super::object::{Access, Extent, Object, ObjectContext, On, OwnService};
use crate::eip::status::unknown;
use crate::eip::tags::scope;
use crate::plant::{Command, Outcome, Right};

/// External access: read and write.
const READ_WRITE: u8 = 0;
/// External access: read only.
const READ_ONLY: u8 = 2;
/// The least that an entry takes in a reply: its instance.
const LEAST_ENTRY: usize = 4;

#[derive(Debug)]
pub(super) struct Symbols;

impl Object for Symbols {
    fn class(&self) -> u16 {
        class::SYMBOL
    }

    fn name(&self) -> &'static str {
        "Symbol"
    }

    fn services(&self) -> &'static [OwnService] {
        &[
            OwnService {
                code: service::GET_INSTANCE_ATTRIBUTE_LIST,
                name: "Get Instance Attribute List",
                on: On::Any,
                access: Access::Read,
                right: Right::Look,
            },
            OwnService {
                code: service::CREATE,
                name: "Create",
                on: On::Class,
                access: Access::Change,
                right: Right::ChangeTags,
            },
            OwnService {
                code: service::DELETE,
                name: "Delete",
                on: On::Instance,
                access: Access::Change,
                right: Right::ChangeTags,
            },
        ]
    }

    fn serve(&self, cx: &mut ObjectContext<'_, '_>, instance: u32) -> Result<Reply, CipStatus> {
        match cx.request.service {
            service::CREATE => create(cx).map(|data| Reply::success(service::CREATE, data)),
            service::DELETE => cx
                .apply(Command::DeleteTag(TagId(instance)))
                .map(|_| Reply::success(service::DELETE, &[][..])),
            _ => list(cx, instance),
        }
    }

    fn extent(&self, cx: &ObjectContext<'_, '_>) -> Result<Extent, CipStatus> {
        let scope = scope(cx.image(), cx.target)?;
        let in_scope = cx.image().tags().iter().filter(|tag| tag.program == scope);
        Ok(Extent {
            highest: in_scope.clone().next_back().map_or(0, |tag| tag.id.0),
            count: u32::try_from(in_scope.count()).unwrap_or(u32::MAX),
            last_attribute: 11,
        })
    }

    fn check(&self, cx: &ObjectContext<'_, '_>, instance: u32) -> Result<(), CipStatus> {
        tag(cx, instance).map(drop)
    }

    fn attribute(&self, cx: &ObjectContext<'_, '_>, instance: u32, id: u16) -> Result<Bytes, CipStatus> {
        let mut out = BytesMut::new();
        symbol(tag(cx, instance)?).encode_attribute(id, &mut out)?;
        Ok(out.freeze())
    }

    fn all(&self) -> &'static [u16] {
        &[1, 2, 7, 8]
    }
}

/// The tag of an instance, in the scope that the path names.
fn tag<'c>(cx: &'c ObjectContext<'_, '_>, instance: u32) -> Result<&'c Tag, CipStatus> {
    let scope = scope(cx.image(), cx.target)?;
    let tag = cx.image().tag(TagId(instance));
    tag.filter(|tag| tag.program == scope).ok_or_else(unknown)
}

/// Get Instance Attribute List: tags from an instance on, whether there is such a tag or not.
fn list(cx: &ObjectContext<'_, '_>, start: u32) -> Result<Reply, CipStatus> {
    let budget = cx.context.budget;
    let scope = scope(cx.image(), cx.target)?;
    let ids = cip::decode_attribute_ids(&cx.request.data)?;
    let tags = cx.image().tags();
    let first = tags.partition_point(|tag| tag.id.0 < start);
    // One more than can fit, so that the reply shows that more follow.
    let page = budget / LEAST_ENTRY + 1;
    let tags = tags.iter().skip(first).filter(|tag| tag.program == scope);
    let symbols: Vec<Symbol> = tags.take(page).map(symbol).collect();
    Ok(instance_list_reply(&symbols, start, &ids, budget))
}

/// Create on the class, in a program's scope behind its name: a plain tag appears as after a download (spec/ethernet-ip.md §10).
fn create(cx: &mut ObjectContext<'_, '_>) -> Result<Bytes, CipStatus> {
    let (wanted, surplus) = CreateSymbol::decode(&cx.request.data)?;
    cx.no_surplus(surplus)?;
    // The program need not be there yet.
    let program = match cx.target.first_symbol() {
        None => None,
        Some(name) if cx.target.symbols.len() == 1 => Some(program_name(name).ok_or_else(unknown)?.to_owned()),
        Some(_) => return Err(unknown()),
    };
    let access = match wanted.access {
        READ_WRITE => ExternalAccess::ReadWrite,
        READ_ONLY => ExternalAccess::ReadOnly,
        _ => return Err(CipStatus::INVALID_PARAMETER),
    };
    let tag_type = arcline_config::tag_type(&wanted.data_type, |name| cx.image().declared(name))
        .ok_or(CipStatus::INVALID_PARAMETER)?;
    let tag = PlainTag {
        program,
        access,
        ..PlainTag::new(wanted.name, tag_type)
    };
    let Outcome::Created(id) = cx.apply(Command::CreateTag(&tag))? else {
        return Err(CipStatus::RESOURCE_UNAVAILABLE);
    };
    let mut out = BytesMut::with_capacity(6);
    out.put_u32_le(id.0);
    out.put_u16_le(tag.tag_type.symbol_type());
    Ok(out.freeze())
}

fn symbol(tag: &Tag) -> Symbol {
    Symbol {
        instance: tag.id.0,
        name: tag.name.clone(),
        symbol_type: tag.symbol_type(),
        address: tag.id.0,
        object_address: tag.id.0,
        software_control: match tag.kind {
            TagKind::Alias(_) => 0,
            _ => Symbol::BASE_TAG,
        },
        element_size: u16::try_from(tag.tag_type.data_type.size()).unwrap_or(u16::MAX),
        dimensions: tag.tag_type.dimensions,
        safety: 0,
        access: match tag.access {
            ExternalAccess::ReadWrite => READ_WRITE,
            ExternalAccess::ReadOnly => READ_ONLY,
        },
        usage: 0,
    }
}
