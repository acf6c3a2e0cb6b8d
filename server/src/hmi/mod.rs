//! The web HMI: a page that the server carries with it, and one WebSocket for each viewer.
//!
//! The HMI runs on tokio beside the rest of the server. It reads the plant as any client does, and sends through bounded queues: a slow
//! viewer loses frames or its connection, and the tick never waits for it. Not here: the meaning of an instruction (the catalogue),
//! motion (the controller), the page itself (`web/`).

mod access;
mod assets;
mod controller;
mod drive;
mod events;
mod frames;
mod instructions;
mod jog;
mod line;
mod login;
mod machine;
mod paths;
mod peaks;
mod preview;
mod program;
mod protocol;
mod serve;
mod sessions;
mod socket;
mod status;
pub(crate) mod stepped;
mod tags;
#[cfg(test)]
pub(crate) mod tests;
mod viewer;
mod workers;

use std::io;
use std::net::SocketAddr;
use std::sync::Arc;
use std::sync::atomic::AtomicU64;

use axum::extract::ws::Utf8Bytes;
use tokio::net::TcpListener;
use tokio::sync::broadcast;

use crate::limits::{Full, Places};
use crate::plant::Plant;
use crate::tls::Tls;
use crate::watch;
use crate::work_threads::WorkThreads;
use assets::Assets;
use jog::Jogs;
use preview::Previews;
use program::Programs;
use protocol::text_of;
use serve::Acceptor;
pub(crate) use sessions::Sessions;
use status::Status;
use workers::Workers;

/// The bound HMI.
#[derive(Debug)]
pub struct Hmi {
    listeners: Vec<Listener>,
    shared: Arc<Shared>,
}

/// A socket that listens.
#[derive(Debug)]
struct Listener {
    acceptor: Acceptor,
    /// Its address.
    listen: SocketAddr,
    /// `None`: the listener has no encryption.
    tls: Option<Arc<Tls>>,
}

/// The listeners of the page, and the users who log in there.
#[derive(Clone, Debug, Default)]
pub(crate) struct ListenSettings {
    /// The address without encryption; `None`: there is no such listener.
    pub(crate) plain: Option<SocketAddr>,
    /// The address and the side of TLS for HTTPS.
    pub(crate) tls: Option<(SocketAddr, Arc<Tls>)>,
    /// `None`: there are no log-ins.
    pub(crate) sessions: Option<Arc<Sessions>>,
}

/// An address of the page that cannot be bound.
#[derive(Debug)]
pub(crate) struct BindError {
    /// The address.
    pub(crate) address: SocketAddr,
    /// The error of the system.
    pub(crate) error: io::Error,
}

/// The data that all viewers share: the plant, and each subject with its own state.
#[derive(Debug)]
struct Shared {
    plant: Plant,
    assets: Assets,
    /// The side of TLS, for the names of the server's certificate.
    tls: Option<Arc<Tls>>,
    sessions: Arc<Sessions>,
    /// `/api/machine` and `/api/instructions`, which do not change.
    machine: String,
    instructions: String,
    /// One for each TCP connection that may still come.
    connections: Arc<Places>,
    /// One for each viewer that may still come.
    places: Arc<Places>,
    /// Viewers so far.
    viewers: AtomicU64,
    status: watch::Sender<Status>,
    /// Frames of samples.
    frames: broadcast::Sender<bytes::Bytes>,
    jogs: Jogs,
    /// The number of presses of STOP.
    stops: AtomicU64,
    workers: Workers,
    program: Arc<Programs>,
    previews: Previews,
    /// Changes of instructions.
    events: broadcast::Sender<Utf8Bytes>,
}

impl Hmi {
    /// Binds `address` for a page without encryption and users; port 0 picks a free one.
    ///
    /// # Errors
    /// The address cannot be bound.
    pub async fn bind(address: SocketAddr, plant: Plant) -> io::Result<Self> {
        let settings = ListenSettings {
            plain: Some(address),
            ..ListenSettings::default()
        };
        Self::bind_all(settings, plant)
            .await
            .map_err(|BindError { error, .. }| error)
    }

    /// Binds all listeners.
    pub(crate) async fn bind_all(settings: ListenSettings, plant: Plant) -> Result<Self, BindError> {
        let mut bound = Vec::new();
        let plain = settings.plain.map(|address| (address, None));
        let tls = settings
            .tls
            .as_ref()
            .map(|(address, tls)| (*address, Some(tls.clone())));
        for (address, tls) in plain.into_iter().chain(tls) {
            let failed = |error| BindError { address, error };
            let listener = TcpListener::bind(address).await.map_err(failed)?;
            let listen = listener.local_addr().map_err(failed)?;
            let acceptor = Acceptor::System(listener);
            bound.push(Listener { acceptor, listen, tls });
        }
        Ok(Self::of(bound, settings, plant, WorkThreads::Pool))
    }

    /// Makes the page with bound listeners.
    fn of(bound: Vec<Listener>, settings: ListenSettings, plant: Plant, threads: WorkThreads) -> Self {
        let shared = Shared {
            assets: Assets::from_environment(),
            tls: settings.tls.map(|(_, tls)| tls),
            sessions: settings.sessions.unwrap_or_default(),
            machine: text_of(&machine::description(&plant)),
            instructions: text_of(&instructions::catalogue()),
            connections: Places::new(CONNECTIONS, Full::ClosesOldest),
            places: Places::new(VIEWERS, Full::ClosesOldestOfLargerShare),
            viewers: AtomicU64::new(0),
            status: watch::Sender::new(Status::default()),
            frames: broadcast::Sender::new(frames::WAITING),
            jogs: Jogs::default(),
            stops: AtomicU64::new(0),
            workers: Workers::new(threads),
            program: Arc::new(Programs::new(threads)),
            previews: Previews::default(),
            events: broadcast::Sender::new(events::WAITING),
            plant,
        };
        Self {
            listeners: bound,
            shared: Arc::new(shared),
        }
    }

    /// The address without encryption that was really bound, if there is one.
    pub fn local_addr(&self) -> Option<SocketAddr> {
        self.address(|listener| listener.tls.is_none())
    }

    /// The address of HTTPS that was really bound, if there is one.
    pub fn tls_addr(&self) -> Option<SocketAddr> {
        self.address(|listener| listener.tls.is_some())
    }

    fn address(&self, is_one: impl Fn(&Listener) -> bool) -> Option<SocketAddr> {
        self.listeners
            .iter()
            .find(|listener| is_one(listener))
            .map(|listener| listener.listen)
    }

    /// Serves until the future is dropped; that closes every viewer.
    pub async fn serve(self) {
        let statuses = status::produce(self.shared.clone());
        let samples = frames::produce(self.shared.clone());
        let rights = jog::watch(self.shared.clone());
        let events = events::produce(self.shared.clone());
        let sessions = self.shared.sessions.watch(&self.shared.plant);
        let accepting = self
            .listeners
            .into_iter()
            .map(|listener| serve::accept(listener, self.shared.clone()));
        let connections = futures_util::future::join_all(accepting);
        tokio::join!(rights, statuses, samples, events, sessions, connections);
    }
}

impl Shared {
    /// The names of this server, beside addresses.
    fn names(&self) -> Vec<String> {
        let of_certificate = self.tls.iter().flat_map(|tls| tls.names());
        let configured = self.plant.server().security.hmi_names.iter().cloned();
        of_certificate.chain(configured).collect()
    }
}

/// TCP connections at a time.
const CONNECTIONS: usize = 256;
/// Viewers at a time.
const VIEWERS: usize = 32;
