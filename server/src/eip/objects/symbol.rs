//! Symbol, class 0x6B: the list of tags (spec/ethernet-ip.md §10).
//!
//! Reading and writing a tag by its instance is [`tags`](crate::eip::tags)'s.

use arcline_controller::image::{Access, Image, PlainTag, TableError, Tag, TagId, TagKind};
use arcline_proto::cip::{self, CipStatus, Reply, Request, is_stray_route, service};
use arcline_proto::epath::Target;
use arcline_proto::logix::{CreateSymbol, Symbol, instance_list_reply};
use arcline_proto::session::Transport;
use arcline_tag::program_name;
use bytes::{BufMut, Bytes, BytesMut};

use super::{Class, Extent};
use crate::eip::router::{Context, Memory};
use crate::eip::tags::{refusal, unknown};
use crate::plant::{Command, Outcome, Transaction};

/// External access: read and write.
const READ_WRITE: u8 = 0;
/// External access: read only.
const READ_ONLY: u8 = 2;
/// The least that an entry takes in a reply: its instance.
const LEAST_ENTRY: usize = 4;

pub(super) struct Symbols<'a> {
    pub(super) image: &'a Image,
    /// The program whose tags are meant; `None`: the controller's.
    pub(super) scope: Option<u16>,
}

impl Symbols<'_> {
    /// The class's own service: Get Instance Attribute List. `None`: it is another one.
    pub(super) fn serve(&self, context: &Context<'_>, request: &Request, target: &Target<'_>) -> Option<Reply> {
        if request.service != service::GET_INSTANCE_ATTRIBUTE_LIST {
            return None;
        }
        let ids = match cip::decode_attribute_ids(&request.data) {
            Ok(ids) => ids,
            Err(status) => return Some(Reply::error(request.service, status)),
        };
        let start = target.instance.unwrap_or(0);
        let tags = self.image.tags();
        let first = tags.partition_point(|tag| tag.id.0 < start);
        // One more than can fit, so that the reply tells that more follow.
        let page = context.budget / LEAST_ENTRY + 1;
        let tags = tags.iter().skip(first).filter(|tag| tag.program == self.scope);
        let symbols: Vec<Symbol> = tags.take(page).map(symbol).collect();
        Some(instance_list_reply(&symbols, start, &ids, context.budget))
    }

    fn tag(&self, instance: u32) -> Result<&Tag, CipStatus> {
        let tag = self.image.tag(TagId(instance));
        tag.filter(|tag| tag.program == self.scope).ok_or_else(unknown)
    }
}

impl Class for Symbols<'_> {
    fn extent(&self) -> Extent {
        let in_scope = self.image.tags().iter().filter(|tag| tag.program == self.scope);
        Extent {
            highest: in_scope.clone().next_back().map_or(0, |tag| tag.id.0),
            count: u32::try_from(in_scope.count()).unwrap_or(u32::MAX),
            last_attribute: 11,
        }
    }

    fn check(&self, instance: u32) -> Result<(), CipStatus> {
        self.tag(instance).map(|_| ())
    }

    fn attribute(&self, instance: u32, id: u16) -> Result<Bytes, CipStatus> {
        let tag = self.tag(instance)?;
        let mut out = BytesMut::new();
        symbol(tag).encode_attribute(id, &mut out)?;
        Ok(out.freeze())
    }

    fn all(&self) -> &'static [u16] {
        &[1, 2, 7, 8]
    }
}

/// Create (0x08) on the class, in a program's scope behind its name, and Delete (0x09) on an instance: a plain tag appears
/// or vanishes, as after a download (spec/ethernet-ip.md §10).
pub(super) fn change(
    context: &Context<'_>,
    memory: &mut Memory<'_, '_>,
    request: &Request,
    target: &Target<'_>,
) -> Reply {
    let Memory::Write(transaction) = memory else {
        return Reply::error(request.service, CipStatus::SERVICE_NOT_SUPPORTED);
    };
    let instance = target.instance.unwrap_or(0);
    let done = match (request.service, instance) {
        (service::CREATE, 0) => create(context, transaction, request, target),
        (service::DELETE, 1..) => delete(transaction, instance, target),
        _ => Err(CipStatus::SERVICE_NOT_SUPPORTED),
    };
    match done {
        Ok(data) => Reply::success(request.service, data),
        Err(status) => Reply::error(request.service, status),
    }
}

fn create(
    context: &Context<'_>,
    transaction: &mut Transaction<'_>,
    request: &Request,
    target: &Target<'_>,
) -> Result<Bytes, CipStatus> {
    let (wanted, surplus) = CreateSymbol::decode(&request.data)?;
    let stray = context.transport == Transport::Unconnected && is_stray_route(surplus);
    if !surplus.is_empty() && !stray {
        return Err(CipStatus::TOO_MUCH_DATA);
    }
    // The program need not be there yet.
    let program = match target.first_symbol() {
        None => None,
        Some(name) if target.symbols.len() == 1 => Some(program_name(name).ok_or_else(unknown)?.to_owned()),
        Some(_) => return Err(unknown()),
    };
    let access = match wanted.access {
        READ_WRITE => Access::ReadWrite,
        READ_ONLY => Access::ReadOnly,
        _ => return Err(CipStatus::INVALID_PARAMETER),
    };
    let tag_type = arcline_config::tag_type(&wanted.data_type, |name| transaction.image().declared(name))
        .ok_or(CipStatus::INVALID_PARAMETER)?;
    let tag = PlainTag {
        program,
        access,
        ..PlainTag::new(wanted.name, tag_type)
    };
    let created = transaction.apply(Command::CreateTag(&tag));
    let Outcome::Created(id) = created.map_err(|refused| refusal(&refused))? else {
        return Err(CipStatus::RESOURCE_UNAVAILABLE);
    };
    let mut out = BytesMut::with_capacity(6);
    out.put_u32_le(id.0);
    out.put_u16_le(tag.tag_type.symbol_type());
    Ok(out.freeze())
}

fn delete(transaction: &mut Transaction<'_>, instance: u32, target: &Target<'_>) -> Result<Bytes, CipStatus> {
    let image = transaction.image();
    let scope = scope(image, target)?;
    let tag = image.tag(TagId(instance)).filter(|tag| tag.program == scope);
    let id = tag.ok_or_else(unknown)?.id;
    let deleted = transaction.apply(Command::DeleteTag(id));
    deleted.map_err(|refused| refusal(&refused))?;
    Ok(Bytes::new())
}

pub(crate) fn table_status(error: &TableError) -> CipStatus {
    match error {
        TableError::NotAName { .. } => CipStatus::INVALID_PARAMETER,
        TableError::Taken { .. } => CipStatus::OBJECT_ALREADY_EXISTS,
        TableError::NoRoom => CipStatus::RESOURCE_UNAVAILABLE,
        TableError::NoSuchTag => unknown(),
        TableError::NotPlain { .. } => CipStatus::PRIVILEGE_VIOLATION,
        TableError::InUse { .. } => CipStatus::OBJECT_STATE_CONFLICT,
    }
}

/// The program in whose scope an instance of this class is meant: `Program:Main` in front of the class.
pub(crate) fn scope(image: &Image, target: &Target<'_>) -> Result<Option<u16>, CipStatus> {
    let Some(name) = target.first_symbol() else {
        return Ok(None);
    };
    match image.find(name).map(|tag| tag.kind) {
        Some(TagKind::Program(place)) if target.symbols.len() == 1 => Ok(Some(place)),
        _ => Err(unknown()),
    }
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
            Access::ReadWrite => READ_WRITE,
            Access::ReadOnly => READ_ONLY,
        },
        usage: 0,
    }
}
