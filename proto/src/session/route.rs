//! Routes to this controller, and Unconnected Sends that take one (spec/ethernet-ip.md §7.1).
//!
//! Nothing is forwarded: a route that leads elsewhere is refused. Remaining paths are counted in 16-bit words.

use crate::cip::{CipStatus, Reply, Request, class, service};
use crate::connection::{UnconnectedSend, route_refusal};
use crate::epath::{Epath, Segment};
use crate::status::connection as extended;

/// Which routes lead to this controller, besides the empty one.
#[derive(Clone, PartialEq, Eq, Debug)]
pub enum Slots {
    /// Any slot of the backplane.
    Any,
    /// These slots of the backplane.
    Only(Vec<u8>),
}

impl Slots {
    /// Whether a route leads to this controller; otherwise the additional status and the words that remain.
    pub(super) fn check_route(&self, route: &[Segment]) -> Result<(), (u16, u8)> {
        let words = || u8::try_from(Epath(route.to_vec()).to_bytes().len() / 2).unwrap_or(u8::MAX);
        match route {
            [] => Ok(()),
            [Segment::Port(port)] => match port.backplane_slot() {
                Some(slot) if self.contains(slot) => Ok(()),
                Some(_) => Err((extended::LINK_ADDRESS_INVALID, words())),
                None => Err((extended::PORT_UNAVAILABLE, words())),
            },
            [Segment::Port(port), ..] if port.backplane_slot().is_some() => {
                Err((extended::LINK_ADDRESS_INVALID, words()))
            }
            _ => Err((extended::PORT_UNAVAILABLE, words())),
        }
    }

    fn contains(&self, slot: u8) -> bool {
        match self {
            Self::Any => true,
            Self::Only(slots) => slots.contains(&slot),
        }
    }
}

/// Takes a request out of its Unconnected Send, if the route leads here. `Err` is the reply.
pub(super) fn unwrap_route(request: Request, slots: &Slots) -> Result<Request, Reply> {
    if request.service != service::UNCONNECTED_SEND || !is_connection_manager(&request.path) {
        return Ok(request);
    }
    let send = UnconnectedSend::decode(&request.data).map_err(|status| Reply::error(request.service, status))?;
    slots
        .check_route(&send.route.0)
        .map_err(|(code, left)| route_refusal(code, left))?;
    let inner = Request::decode(&send.message).map_err(|error| error.reply())?;
    if inner.service == service::UNCONNECTED_SEND && is_connection_manager(&inner.path) {
        return Err(Reply::error(inner.service, CipStatus::SERVICE_NOT_SUPPORTED));
    }
    Ok(inner)
}

/// Whether a request is for the Connection Manager itself.
pub(super) fn is_connection_manager(path: &Epath) -> bool {
    path.is_object(class::CONNECTION_MANAGER, 1)
}
