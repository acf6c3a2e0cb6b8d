//! The device as one session sees it: random numbers, shared limits and counters, I/O connections, and the end of a connection.

use std::net::{IpAddr, SocketAddrV4};
use std::sync::Arc;

use arcline_proto::cip::CipStatus;
use arcline_proto::connection::{ConnectionKey, Count};
use arcline_proto::cpf::ConnectionId;
use arcline_proto::identity::Identity;
use arcline_proto::io::Application;
use arcline_proto::session::{ConnectionEnd, Host, IoOpen, IoOpened};
use arcline_state::planted::is_planted;

use super::device::Device;
use super::originator;
use super::status::refusal;
use crate::audit::EventKind;
use crate::plant::{Principal, Right};

/// The device, for the session of one TCP connection.
#[derive(Clone, Debug)]
pub(crate) struct SessionHost {
    /// The device.
    pub(crate) device: Arc<Device>,
    /// The near end.
    pub(crate) local: SocketAddrV4,
    /// The far end.
    pub(crate) peer: IpAddr,
    /// The session's number.
    pub(crate) session: u64,
    /// Whether the session is encrypted.
    pub(crate) is_encrypted: bool,
}

impl Host for SessionHost {
    fn random(&mut self) -> Option<u32> {
        let drawn = (&*self.device).random();
        if is_planted("handles of few values") {
            return drawn.map(|drawn| drawn & 0xFF);
        }
        drawn
    }

    fn acquire_connection(&mut self) -> bool {
        let is_free = self.device.limiter.acquire_connection(self.peer);
        let acquired = is_free && (&*self.device).acquire_connection();
        if is_free && !acquired {
            self.device.limiter.release_connections(self.peer, 1);
        }
        acquired
    }

    fn release_connections(&mut self, count: usize) {
        if is_planted("connection not released") {
            return;
        }
        self.device.limiter.release_connections(self.peer, count);
        (&*self.device).release_connections(count);
    }

    fn connection_opened(&mut self, _id: ConnectionId, key: ConnectionKey) {
        self.device.plant.guard().identify(self.session, |identity| {
            if identity.identification.product.is_empty() {
                identity.identification.product = originator::product(key);
            }
        });
    }

    fn connection_ended(&mut self, id: ConnectionId, how: ConnectionEnd) {
        let owner = Principal::Client {
            session: self.session,
            connection: id.0,
        };
        match how {
            ConnectionEnd::Closed => self.device.release(owner),
            ConnectionEnd::TimedOut => self.device.lose(owner),
        }
    }

    fn count(&mut self, count: Count) {
        (&*self.device).count(count);
    }

    fn identity(&self) -> &Identity {
        &self.device.settings.identity
    }

    fn open_io(&mut self, open: &IoOpen<'_>) -> Result<IoOpened, CipStatus> {
        let mut device = &*self.device;
        if self.is_encrypted && device.settings.config.security.refuses_io_over_tls {
            let text =
                || "class 0 and 1 through TLS need DTLS, which this server does not have (`io_over_tls`)".to_owned();
            device.plant.log_limit().warn("io over tls", Some(self.peer), text);
            return Err(CipStatus::PRIVILEGE_VIOLATION);
        }
        match device.io() {
            Some(io) => {
                let assemblies = device.assembly_data().assemblies();
                // The connections themselves report the error of an opening: they know the open connections.
                let owns = Application::of(open.open, open.application, assemblies) == Ok(Application::ExclusiveOwner);
                let principal = Principal::Client {
                    session: self.session,
                    connection: 0,
                };
                if owns {
                    let checked = device.plant.check(principal, Right::OwnOutputs);
                    checked.map_err(|refused| refusal(&refused))?;
                }
                let local = *self.local.ip();
                let group = device.adapters.of(local).first_multicast();
                let opened = io.open(open, self.peer, local, group, device, || device.random())?;
                if owns {
                    // The owner sends nothing before it has the reply.
                    device.plant.roles().set_io(device.plant.roles().of(principal));
                    let what = "the outputs of implicit I/O".to_owned();
                    device.plant.record(principal, EventKind::Take, what, "done");
                }
                Ok(opened)
            }
            None => device.open_io(open),
        }
    }

    fn close_io(&mut self, key: ConnectionKey) -> bool {
        let io = self.device.io();
        io.is_some_and(|io| io.close(key, self.peer, &self.device))
    }
}
