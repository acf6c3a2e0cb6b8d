//! The data that all connections of the server share: the plant, the identity, limits and counters.

use std::collections::BTreeMap;
use std::net::SocketAddr;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, AtomicI64, AtomicU64, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, UNIX_EPOCH};

use arcline_config::{ConnectionLoss, PlainAccess, Security, ServerConfig};
use arcline_proto::connection::{Count, Counters};
use arcline_proto::encap::Service;
use arcline_proto::identity::Identity;
use arcline_proto::security::{CONFIDENTIALITY, CONFIGURED, SecurityInformation, port};
use arcline_proto::session::{self, Host};
use tracing::{error, warn};

use super::adapter::Adapters;
use super::io::{AssemblyData, Datagrams, Io};
use super::limiter::{ClientLimiter, ClientLimits};
use super::objects::Objects;
use super::turns::Turns;
use crate::guard::ClientInterface;
use crate::plant::{Plant, Principal};
use crate::tls::Tls;
use crate::watch;
use crate::work_threads::WorkThreads;

/// Settings of the EtherNet/IP interface (spec/ethernet-ip.md §18).
#[derive(Clone, Debug)]
pub struct Settings {
    /// The identity of the device.
    pub identity: Identity,
    /// The network side of the configuration.
    pub config: ServerConfig,
    /// The time within which a peer must read the written bytes.
    pub write_timeout: Duration,
    /// The root of the files in which the system shows its network.
    pub system: PathBuf,
    /// Limits of a session.
    pub session: session::Settings,
    /// The source of session handles and connection ids; `None` if there are no random numbers.
    pub random: fn() -> Option<u32>,
    /// The socket of implicit I/O and its address; `None`: one of the system's.
    pub datagrams: Option<(Arc<dyn Datagrams>, SocketAddr)>,
    /// The side of TLS, where EtherNet/IP over TLS listens.
    pub(crate) tls: Option<Arc<Tls>>,
}

impl Settings {
    /// The settings of a configuration. The serial number is a hash of the product name, so that it stays the same.
    pub fn new(config: &ServerConfig) -> Self {
        Self {
            identity: Identity::new(&config.name, serial_number(&config.name)),
            write_timeout: Duration::from_secs(30),
            system: PathBuf::from("/"),
            session: session::Settings {
                // The session executes each request before it reads the next frame: a Forward Close or the end of the session does
                // not overtake a request in front of it.
                max_pending: 1,
                inactivity: match config.inactivity_timeout {
                    0 => None,
                    seconds => Some(Duration::from_secs(seconds.into())),
                },
                ..session::Settings::default()
            },
            datagrams: None,
            tls: None,
            config: config.clone(),
            random: system_random,
        }
    }
}

/// A random number from the system's generator.
fn system_random() -> Option<u32> {
    getrandom::u32()
        .inspect_err(|error| error!(%error, "no random numbers: the server refuses sessions and connections"))
        .ok()
}

/// FNV-1a over the name.
fn serial_number(name: &str) -> u32 {
    name.bytes().fold(0x811C_9DC5, |hash, byte| {
        (hash ^ u32::from(byte)).wrapping_mul(0x0100_0193)
    })
}

/// The security information of a ListIdentity reply; `None`: TLS is off.
fn security_information(security: &Security, has_io: bool) -> Option<SecurityInformation> {
    security.tls?;
    let ports = [
        (security.plain != PlainAccess::Off, port::EXPLICIT_TCP),
        (true, port::EXPLICIT_UDP),
        (has_io, port::IMPLICIT_UDP),
        (true, port::TLS),
    ];
    Some(SecurityInformation {
        profiles: CONFIDENTIALITY,
        state: CONFIGURED,
        ethernet_ip_state: CONFIGURED,
        ports: ports.iter().filter(|(is_open, _)| *is_open).map(|(_, bit)| bit).sum(),
        profiles_configured: CONFIDENTIALITY,
    })
}

/// The data that all connections share.
#[derive(Debug)]
pub(crate) struct Device {
    pub(crate) plant: Plant,
    pub(crate) settings: Settings,
    pub(crate) session_settings: Arc<session::Settings>,
    /// The settings of sessions without TLS.
    pub(crate) plain_settings: Arc<session::Settings>,
    assembly_data: AssemblyData,
    /// The CIP objects that answer.
    pub(crate) objects: Objects,
    /// The adapters of the host.
    pub(crate) adapters: Adapters,
    io: Option<Arc<Io>>,
    /// The turns of connections whose work is long.
    pub(crate) turns: Turns,
    /// The clients that are connected.
    pub(crate) limiter: Arc<ClientLimiter>,
    open_connections: AtomicUsize,
    counters: Mutex<Counters>,
    /// Silence after which a socket is closed; `None`: never. Clients set it, connections watch it.
    inactivity: watch::Sender<Option<Duration>>,
    /// Sessions that there ever were.
    sessions: AtomicU64,
    /// The reactions to their loss that connections have set.
    losses: Mutex<BTreeMap<Principal, ConnectionLoss>>,
    /// µs that a client has moved the wall clock by; the host's own clock is never set.
    clock_offset: AtomicI64,
    /// Whether a client has set daylight saving.
    daylight_saving: AtomicBool,
}

impl Device {
    /// Binds the socket of I/O, if there is to be one; `threads` read the files that show the network.
    ///
    /// # Errors
    /// Its address cannot be bound.
    pub(crate) fn new(plant: Plant, mut settings: Settings, threads: WorkThreads) -> std::io::Result<Self> {
        let assembly_data = AssemblyData::new(plant.machine(), settings.config.io_loss);
        let assemblies = *assembly_data.assemblies();
        let io = match (settings.config.io.address(settings.config.listen), &settings.datagrams) {
            (Some(_), Some((socket, local))) => Some(Arc::new(Io::over(socket.clone(), *local, assemblies)?)),
            (Some(address), None) => Some(Arc::new(Io::bind(address, assemblies)?)),
            (None, _) => None,
        };
        if io.is_some() {
            settings.session.capability |= Service::UDP_IO;
        }
        settings.identity.security = security_information(&settings.config.security, io.is_some());
        Ok(Self {
            plant,
            assembly_data,
            objects: Objects::ALL,
            adapters: Adapters::new(&settings.system, threads),
            turns: Turns::new(
                tokio::runtime::Handle::try_current().map_or(1, |runtime| runtime.metrics().num_workers()),
            ),
            io,
            session_settings: Arc::new(settings.session.clone()),
            plain_settings: Arc::new(session::Settings {
                discovery_only: settings.config.security.plain == PlainAccess::Discovery,
                ..settings.session.clone()
            }),
            inactivity: watch::Sender::new(settings.session.inactivity),
            limiter: ClientLimiter::new(ClientLimits {
                clients: settings.config.max_clients.max(1),
                clients_of_one: settings.config.max_clients_per_address.max(1),
                connections_of_one: settings.config.max_connections_per_address,
            }),
            settings,
            open_connections: AtomicUsize::new(0),
            counters: Mutex::new(Counters::default()),
            sessions: AtomicU64::new(0),
            losses: Mutex::default(),
            clock_offset: AtomicI64::new(0),
            daylight_saving: AtomicBool::new(false),
        })
    }

    /// The assemblies and the newest outputs.
    pub(crate) fn assembly_data(&self) -> &AssemblyData {
        &self.assembly_data
    }

    /// Class 0 and 1 connections, where there may be some.
    pub(crate) fn io(&self) -> Option<&Arc<Io>> {
        self.io.as_ref()
    }

    /// Class 3 connections that are open.
    pub(crate) fn open_connections(&self) -> usize {
        self.open_connections.load(Ordering::Relaxed)
    }

    /// Attributes of the Connection Manager.
    pub(crate) fn counters(&self) -> Counters {
        *self.lock_counters()
    }

    /// Silence after which a socket is closed; `None`: never.
    pub(crate) fn inactivity(&self) -> Option<Duration> {
        *self.inactivity.borrow()
    }

    /// Sets it for every socket; 0: never.
    pub(crate) fn set_inactivity(&self, time: Duration) {
        self.inactivity.send_replace(Some(time).filter(|time| !time.is_zero()));
    }

    /// The silence after which a socket is closed, and its changes.
    pub(crate) fn watch_inactivity(&self) -> watch::Receiver<Option<Duration>> {
        self.inactivity.subscribe()
    }

    /// A number that no other session has or had.
    pub(crate) fn number_session(&self) -> u64 {
        self.sessions.fetch_add(1, Ordering::Relaxed)
    }

    /// The reaction of the motion of an owner when it is lost.
    pub(crate) fn loss(&self, owner: Principal) -> ConnectionLoss {
        let own = self.lock_losses().get(&owner).copied();
        own.unwrap_or(self.settings.config.connection_loss)
    }

    /// An owner sets the reaction of its motion; `None`: as it is configured.
    pub(crate) fn set_loss(&self, owner: Principal, loss: Option<ConnectionLoss>) {
        match loss {
            Some(loss) => self.lock_losses().insert(owner, loss),
            None => self.lock_losses().remove(&owner),
        };
    }

    /// A connection, or a session with all of its, is lost: its motion is stopped, held or goes on.
    pub(crate) fn lose(&self, owner: Principal) {
        let loss = self.loss(owner);
        self.set_loss(owner, None);
        let lost = self.plant.lose(owner, loss);
        if !lost.is_empty() {
            let client = owner.session().map(|session| self.plant.guard().identity_of(session));
            let client = client.unwrap_or_default();
            let motion = lost.names(self.plant.machine());
            warn!(%client, reaction = loss.word(), %motion, "a connection is lost; it began motion");
        }
    }

    /// A connection was closed in order.
    pub(crate) fn release(&self, owner: Principal) {
        self.set_loss(owner, None);
        self.plant.disown(owner);
    }

    /// A session has ended, in order or not.
    pub(crate) fn end_session(&self, session: u64, in_order: bool) {
        for owner in self.plant.owners(session) {
            if in_order {
                self.release(owner);
            } else {
                self.lose(owner);
            }
        }
        self.lock_losses().retain(|owner, _| owner.session() != Some(session));
    }

    /// µs since 1970-01-01 UTC, as clients have set it.
    pub(crate) fn clock(&self) -> u64 {
        let offset = self.clock_offset.load(Ordering::Relaxed);
        self.host_clock().checked_add_signed(offset).unwrap_or_default()
    }

    /// Sets the clock that clients see.
    pub(crate) fn set_clock(&self, micros: u64) {
        let offset = micros.wrapping_sub(self.host_clock()).cast_signed();
        self.clock_offset.store(offset, Ordering::Relaxed);
    }

    fn host_clock(&self) -> u64 {
        let since = self.plant.wall().now().duration_since(UNIX_EPOCH).unwrap_or_default();
        u64::try_from(since.as_micros()).unwrap_or(u64::MAX)
    }

    /// Daylight saving, as a client has set it; nothing depends on it.
    pub(crate) fn daylight_saving(&self) -> bool {
        self.daylight_saving.load(Ordering::Relaxed)
    }

    /// Remembers daylight saving.
    pub(crate) fn set_daylight_saving(&self, on: bool) {
        self.daylight_saving.store(on, Ordering::Relaxed);
    }

    fn lock_losses(&self) -> MutexGuard<'_, BTreeMap<Principal, ConnectionLoss>> {
        self.losses.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn lock_counters(&self) -> MutexGuard<'_, Counters> {
        self.counters.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl ClientInterface for Device {
    fn keeps_jogs(&self, owner: Principal) -> bool {
        self.loss(owner) == ConnectionLoss::Finish
    }

    fn lost(&self, session: u64) {
        self.end_session(session, false);
    }
}

/// The device as a session sees it.
impl Host for &Device {
    fn random(&mut self) -> Option<u32> {
        (self.settings.random)()
    }

    fn acquire_connection(&mut self) -> bool {
        let most = self.settings.config.max_connections;
        let more = |open: usize| (open < most).then_some(open + 1);
        self.open_connections
            .fetch_update(Ordering::Relaxed, Ordering::Relaxed, more)
            .is_ok()
    }

    fn release_connections(&mut self, count: usize) {
        self.open_connections.fetch_sub(count, Ordering::Relaxed);
    }

    fn count(&mut self, count: Count) {
        self.lock_counters().add(count);
    }

    fn identity(&self) -> &Identity {
        &self.settings.identity
    }
}
