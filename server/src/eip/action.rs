//! The action of a request, parsed once from the service and the path of the request.
//!
//! The router asks the action, not the service code, whether a request writes, waits, or may have its answer at once. A new kind of action
//! does not compile before it answers these questions here.

use arcline_proto::cip::{CipStatus, Request, class, service};
use arcline_proto::epath::Target;

use super::objects::{Access, Object, Objects};
use super::status::unknown;
use crate::plant::RequestKind;

/// A request that is no packet of requests, taken apart.
#[derive(Debug)]
pub(crate) struct ParsedRequest<'r> {
    /// The request.
    pub(crate) request: &'r Request,
    /// The meaning of its path.
    pub(crate) target: Target<'r>,
    /// The action.
    pub(crate) action: Action,
}

/// The action of a request.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Action {
    /// Reads a tag, by name or by its instance of class 0x6B.
    ReadTag(TagRead),
    /// Writes a tag.
    WriteTag(TagWrite),
    /// Executes an instruction, as a service of its motion object.
    Motion,
    /// A service of a CIP object.
    Object(&'static dyn Object, Access),
    /// A service of the motion object of a name, or else of its symbol.
    Named(Access),
    /// The service, object or tag does not exist.
    Refused(CipStatus),
}

/// The services that read a tag.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum TagRead {
    /// Read Tag.
    Whole,
    /// Read Tag Fragmented.
    Fragment,
}

/// The services that write a tag.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum TagWrite {
    /// Write Tag.
    Whole,
    /// Write Tag Fragmented.
    Fragment,
    /// Read-Modify-Write Tag.
    Modify,
}

/// The codes of motion services, of all motion classes.
const MOTION_SERVICES: std::ops::RangeInclusive<u8> = 0x32..=0x4A;

impl<'r> ParsedRequest<'r> {
    /// Parses a request to a device with these objects.
    pub(crate) fn new(request: &'r Request, objects: Objects) -> Self {
        let (target, action) = match Target::new(&request.path) {
            Ok(target) => {
                let action = Action::new(request.service, &target, objects);
                (target, action)
            }
            Err(error) => (Target::default(), Action::Refused(error.status())),
        };
        Self {
            request,
            target,
            action,
        }
    }
}

impl Action {
    fn new(code: u8, target: &Target<'_>, objects: Objects) -> Self {
        let is_motion = MOTION_SERVICES.contains(&code);
        let names_tag = matches!(target.class, None | Some(class::SYMBOL));
        if let Some(action) = Self::of_tag(code).filter(|_| names_tag) {
            return action;
        }
        match target.class {
            // Only a tag can have a name, that of its program, in front of its class.
            Some(class) if class != class::SYMBOL && !target.symbols.is_empty() => Self::Refused(unknown()),
            Some(class) => match objects.find(class) {
                Some(object) if is_motion && object.is_motion() => Self::Motion,
                Some(object) => Self::Object(object, object.access(code)),
                None => Self::Refused(unknown()),
            },
            None if is_motion && !target.symbols.is_empty() => Self::Motion,
            None => Self::Named(objects.access_by_name(code)),
        }
    }

    const fn of_tag(code: u8) -> Option<Self> {
        Some(match code {
            service::READ_TAG => Self::ReadTag(TagRead::Whole),
            service::READ_TAG_FRAGMENTED => Self::ReadTag(TagRead::Fragment),
            service::WRITE_TAG => Self::WriteTag(TagWrite::Whole),
            service::WRITE_TAG_FRAGMENTED => Self::WriteTag(TagWrite::Fragment),
            service::READ_MODIFY_WRITE_TAG => Self::WriteTag(TagWrite::Modify),
            _ => return None,
        })
    }

    /// The counter of requests that counts this action.
    pub(crate) const fn request_kind(&self) -> RequestKind {
        match self {
            Self::ReadTag(_) => RequestKind::TagReads,
            Self::WriteTag(_) => RequestKind::TagWrites,
            Self::Motion => RequestKind::Instructions,
            Self::Object(..) | Self::Named(_) => RequestKind::Objects,
            Self::Refused(_) => RequestKind::Unknown,
        }
    }

    /// Whether the server answers the request under the plant's lock, since the request may write to the tag memory.
    pub(crate) const fn writes(&self) -> bool {
        match self {
            Self::WriteTag(_) => true,
            Self::Object(_, access) | Self::Named(access) => match access {
                Access::Set | Access::Change => true,
                Access::Read | Access::Late | Access::Series => false,
            },
            Self::ReadTag(_) | Self::Motion | Self::Refused(_) => false,
        }
    }

    /// Whether the server answers the request after it has released the tag memory: the answer waits for the controller or for the plant's lock.
    pub(crate) const fn is_late(&self) -> bool {
        match self {
            Self::Motion => true,
            Self::Object(_, access) | Self::Named(access) => match access {
                Access::Late | Access::Series => true,
                Access::Read | Access::Set | Access::Change => false,
            },
            Self::ReadTag(_) | Self::WriteTag(_) | Self::Refused(_) => false,
        }
    }

    /// Whether the request succeeds only when its writes are in the file of the retained state.
    pub(crate) const fn must_be_kept(&self) -> bool {
        match self {
            Self::WriteTag(_) => true,
            Self::Object(_, access) | Self::Named(access) => match access {
                Access::Change => true,
                Access::Read | Access::Set | Access::Late | Access::Series => false,
            },
            Self::ReadTag(_) | Self::Motion | Self::Refused(_) => false,
        }
    }
}
