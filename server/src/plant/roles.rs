//! The role of each client, by its session. A changed role takes effect with the next command.

use std::collections::{HashMap, HashSet};
use std::net::IpAddr;
use std::sync::{Mutex, MutexGuard, PoisonError};

use arcline_config::{Role, Security};

use super::Principal;

/// The roles of the clients that are connected.
#[derive(Debug, Default)]
pub(crate) struct Roles(Mutex<Known>);

#[derive(Debug, Default)]
struct Known {
    sessions: HashMap<u64, Role>,
    /// Viewers whose session is locked.
    locked: HashSet<u64>,
    /// The role of the connection that owns the outputs of implicit I/O, or that set them last.
    io: Option<Role>,
}

impl Roles {
    /// A client has come in, or has another role.
    pub(crate) fn set(&self, session: u64, role: Role) {
        self.lock().sessions.insert(session, role);
    }

    /// A client has gone.
    pub(crate) fn forget(&self, session: u64) {
        let mut known = self.lock();
        known.sessions.remove(&session);
        known.locked.remove(&session);
    }

    /// A viewer's session is locked, or no more. While it is, the viewer has the least role; its program keeps the role that it began with.
    pub(crate) fn set_locked(&self, session: u64, is_locked: bool) {
        let mut known = self.lock();
        match is_locked {
            true => known.locked.insert(session),
            false => known.locked.remove(&session),
        };
    }

    /// The client that commands the outputs has this role.
    pub(crate) fn set_io(&self, role: Role) {
        self.lock().io = Some(role);
    }

    /// The role of a principal; of a client that is not known the least.
    pub(crate) fn of(&self, principal: Principal) -> Role {
        let known = self.lock();
        let role = match principal {
            Principal::Server => Some(Role::Administrator),
            Principal::Controller => Some(Role::Engineer),
            Principal::Io => known.io,
            Principal::Viewer(_) | Principal::Button(_)
                if principal
                    .session()
                    .is_some_and(|session| known.locked.contains(&session)) =>
            {
                None
            }
            Principal::Client { .. } | Principal::Viewer(_) | Principal::Button(_) | Principal::Program { .. } => {
                principal
                    .session()
                    .and_then(|session| known.sessions.get(&session).copied())
            }
        };
        role.unwrap_or(Role::Viewer)
    }

    fn lock(&self) -> MutexGuard<'_, Known> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// The role of a peer on a plain connection. A proxy, a tunnel's server side and a container's port map make all of their peers one
/// address, so the role of loopback can be lowered.
pub(crate) fn role_of_address(security: &Security, peer: IpAddr) -> Role {
    if is_local(peer) {
        security.loopback
    } else {
        security.remote_plain
    }
}

/// The role of a page over HTTPS before a user logs in.
pub(crate) fn role_of_page(security: &Security, peer: IpAddr) -> Role {
    if is_local(peer) {
        security.loopback
    } else {
        Role::Viewer
    }
}

/// Whether a peer is on this computer.
pub(crate) fn is_local(peer: IpAddr) -> bool {
    peer.to_canonical().is_loopback()
}
