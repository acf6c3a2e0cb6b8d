//! Forward Open and Forward Close on the connections of one session (spec/ethernet-ip.md §7.2, §7.3). I/O connections
//! are the host's: they outlive the session.
//!
//! Not here: the other services of the Connection Manager, whose attributes are the application's. Intervals are in
//! microseconds, sizes in bytes.

use std::time::Duration;

use super::connections::{Connection, Connections};
use super::host::nonzero;
use super::route::is_connection_manager;
use super::{ConnectionEnd, Host, IoOpen, IoOpened, Settings};
use crate::cip::{CipStatus, Reply, Request, class, service};
use crate::connection::{
    ConnectionKey, ConnectionType, Count, ForwardClose, ForwardOpen, ForwardOpenReply, NetworkParameters, refusal,
};
use crate::cpf::ConnectionId;
use crate::epath::{Epath, Segment};
use crate::status::connection as extended;

/// The smallest connection size that is of any use: a sequence count, a reply's head and some data.
pub const MIN_CONNECTION_SIZE: u16 = 16;

impl Connections {
    /// Opens and closes connections. `Err` is the reply, of success too; other requests pass. `port` is the UDP port that
    /// the originator says it listens on.
    pub(super) fn manage(
        &mut self,
        request: Request,
        port: Option<u16>,
        settings: &Settings,
        now: Duration,
        host: &mut dyn Host,
    ) -> Result<Request, Managed> {
        if !is_connection_manager(&request.path) {
            return Ok(request);
        }
        match request.service {
            service::FORWARD_OPEN | service::LARGE_FORWARD_OPEN => {
                Err(self.forward_open(&request, port, settings, now, host))
            }
            service::FORWARD_CLOSE => Err(self.forward_close(&request, host).into()),
            _ => Ok(request),
        }
    }

    fn forward_open(
        &mut self,
        request: &Request,
        port: Option<u16>,
        settings: &Settings,
        now: Duration,
        host: &mut dyn Host,
    ) -> Managed {
        host.count(Count::OpenRequests);
        let large = request.service == service::LARGE_FORWARD_OPEN;
        let open = match ForwardOpen::decode(&request.data, large) {
            Ok(open) => open,
            Err(error) => {
                host.count(Count::OpenFormatRejects);
                return refusal(request.service, error.key, error.status, 0).into();
            }
        };
        match self.try_open(&open, port, settings, now, host) {
            Ok(Opened::Explicit(reply)) => Reply::success(request.service, reply.to_bytes()).into(),
            Ok(Opened::Io(opened)) => Managed {
                reply: Reply::success(request.service, opened.reply.to_bytes()),
                io: Some(opened),
            },
            Err((status, left)) => {
                let resource = status == CipStatus::connection(extended::OUT_OF_CONNECTIONS)
                    || status == CipStatus::RESOURCE_UNAVAILABLE;
                host.count(if resource {
                    Count::OpenResourceRejects
                } else {
                    Count::OpenOtherRejects
                });
                refusal(request.service, open.key, status, left).into()
            }
        }
    }

    fn try_open(
        &mut self,
        open: &ForwardOpen,
        port: Option<u16>,
        settings: &Settings,
        now: Duration,
        host: &mut dyn Host,
    ) -> Result<Opened, (CipStatus, u8)> {
        let fail = |code: u16| (CipStatus::connection(code), 0);
        if let Some((id, known)) = self.find(open.key) {
            if !open.is_null() {
                return Err(fail(extended::DUPLICATE));
            }
            known.heard(now);
            return Ok(Opened::Explicit(known.reply(id)));
        }
        if open.is_null() || matches!(open.transport_class(), 0 | 1) {
            let application = application_path(&open.path, settings, host)?;
            let open = IoOpen {
                open,
                application: &application,
                port,
            };
            return host.open_io(&open).map(Opened::Io).map_err(|status| (status, 0));
        }
        if open.transport_class() != 3 {
            return Err(fail(extended::CLASS_UNSUPPORTED));
        }
        if open.multiplier > 7 {
            return Err(fail(extended::TIMEOUT_MULTIPLIER));
        }
        let application = application_path(&open.path, settings, host)?;
        if !Epath(application).is_object(class::MESSAGE_ROUTER, 1) {
            return Err(fail(extended::INVALID_SEGMENT));
        }
        let types = [
            (open.o_to_t, extended::TYPE_O_TO_T),
            (open.t_to_o, extended::TYPE_T_TO_O),
        ];
        for (parameters, code) in types {
            if parameters.connection_type != ConnectionType::PointToPoint {
                return Err(fail(code));
            }
            check_size(parameters, settings.max_connection_size)?;
        }
        if self.len() >= settings.max_connections {
            return Err(fail(extended::OUT_OF_CONNECTIONS));
        }
        let id = nonzero(host, |id| !self.contains(ConnectionId(id)))
            .map(ConnectionId)
            .ok_or((CipStatus::RESOURCE_UNAVAILABLE, 0))?;
        if !host.acquire_connection() {
            return Err(fail(extended::OUT_OF_CONNECTIONS));
        }
        let connection = Connection::new(open, now);
        let reply = connection.reply(id);
        self.insert(id, connection);
        host.connection_opened(id, open.key);
        Ok(Opened::Explicit(reply))
    }

    fn forward_close(&mut self, request: &Request, host: &mut dyn Host) -> Reply {
        host.count(Count::CloseRequests);
        let close = match ForwardClose::decode(&request.data) {
            Ok(close) => close,
            Err(status) => {
                host.count(Count::CloseFormatRejects);
                return refusal(request.service, ConnectionKey::default(), status, 0);
            }
        };
        let id = self.find(close.key).map(|(id, _)| id);
        if let Some(id) = id.filter(|id| self.remove(*id)) {
            host.release_connections(1);
            host.connection_ended(id, ConnectionEnd::Closed);
            ForwardClose::reply(close.key)
        } else if host.close_io(close.key) {
            ForwardClose::reply(close.key)
        } else {
            host.count(Count::CloseOtherRejects);
            let status = CipStatus::connection(extended::NOT_FOUND);
            refusal(request.service, close.key, status, 0)
        }
    }
}

fn check_size(parameters: NetworkParameters, most: u16) -> Result<(), (CipStatus, u8)> {
    if (MIN_CONNECTION_SIZE..=most).contains(&parameters.size) {
        Ok(())
    } else {
        Err((CipStatus::connection(extended::INVALID_SIZE).with(most), 0))
    }
}

/// A connection that was opened, or was open already.
enum Opened {
    Explicit(ForwardOpenReply),
    Io(IoOpened),
}

/// The reply of the Connection Manager, and the I/O connection that it is about.
pub(super) struct Managed {
    pub(super) reply: Reply,
    pub(super) io: Option<IoOpened>,
}

impl From<Reply> for Managed {
    fn from(reply: Reply) -> Self {
        Self { reply, io: None }
    }
}

/// The rest of a connection path without ports, electronic key and network segments, which are in order.
fn application_path(path: &Epath, settings: &Settings, host: &dyn Host) -> Result<Vec<Segment>, (CipStatus, u8)> {
    let (mut route, mut application) = (Vec::new(), Vec::new());
    for segment in &path.0 {
        match segment {
            Segment::Key(key) => {
                host.identity()
                    .check_key(key)
                    .map_err(|code| (CipStatus::connection(code), 0))?;
            }
            Segment::Network { .. } => {}
            Segment::Port(_) if application.is_empty() => route.push(segment.clone()),
            other => application.push(other.clone()),
        }
    }
    settings
        .slots
        .check_route(&route)
        .map_err(|(code, left)| (CipStatus::connection(code), left))?;
    Ok(application)
}
