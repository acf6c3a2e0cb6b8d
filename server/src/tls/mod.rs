//! TLS (spec/security.md §5): certificates of the server and its clients, the role of each certificate, and the connections that live by them.
//!
//! The protocol inside of TLS is unchanged EtherNet/IP. A reload takes new files over for new connections, and judges every open
//! connection again; those whose certificate does not hold any more are closed, the rest is not touched.

pub(crate) mod certs;
mod leaf;
#[cfg(test)]
mod tests;
mod trust;

use std::collections::HashMap;
use std::net::IpAddr;
use std::path::Path;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use arc_swap::ArcSwap;
use arcline_config::{CertificateRole, Role, Security};
use rustls::ServerConfig;
use rustls::pki_types::{CertificateDer, UnixTime};
use tokio::net::TcpStream;
use tokio::time::Instant;
use tokio_rustls::TlsAcceptor;
use tokio_rustls::server::TlsStream;
use tokio_util::sync::CancellationToken;
use tracing::{debug, error, warn};

use self::leaf::Leaf;
pub(crate) use self::leaf::hex;
pub(crate) use self::trust::TrustError;
use self::trust::{Files, Trust};
use crate::audit::EventKind;
use crate::limits::{Full, Lockouts, LogLimit, Place, Places};
use crate::plant::{Plant, Principal};

/// The longest handshake.
const HANDSHAKE: Duration = Duration::from_secs(5);
/// Handshakes at a time, and of them of one address.
const HANDSHAKES: usize = 64;
const HANDSHAKES_OF_ONE: usize = 8;
/// Time between two checks of the certificates of open connections for their end.
const LOOK: Duration = Duration::from_secs(1);
/// Number of these checks from one check of the files for a change to the next.
const FILES_EVERY: u32 = 60;
/// Number of these checks from one warning of certificates and lists that end to the next: once a day.
const WARN_EVERY: u32 = 86_400;
/// The server warns of its own certificate when it ends within this time.
const ENDS_SOON: i64 = 30 * 86_400;

/// The side of TLS of one server.
#[derive(Debug)]
pub(crate) struct Tls {
    files: Files,
    check_expiration: bool,
    roles: ArcSwap<Table>,
    trust: ArcSwap<Trust>,
    handshakes: Arc<Places>,
    page_handshakes: Arc<Places>,
    lockouts: Lockouts,
    live: Mutex<HashMap<u64, Live>>,
}

/// The role of each certificate.
#[derive(PartialEq, Eq, Debug)]
struct Table {
    rows: Vec<CertificateRole>,
    /// The role of a certificate without a row.
    default: Role,
}

impl Table {
    fn of(security: &Security) -> Self {
        Self {
            rows: security.certificates.clone(),
            default: security.default_role,
        }
    }
}

/// An open connection with a certificate.
#[derive(Debug)]
struct Live {
    client: TlsClient,
    close: CancellationToken,
}

impl Live {
    fn close(&self, reason: &rustls::Error) {
        let (client, Leaf { issuer, serial, .. }) = (self.client.name(), &self.client.leaf);
        warn!(%client, issuer, serial, %reason, "a connection was closed: its certificate does not hold any more");
        self.close.cancel();
    }
}

impl Trust {
    /// Checks that the certificate of a client is valid.
    fn judge(&self, client: &TlsClient, now: UnixTime) -> Result<(), rustls::Error> {
        let none = || rustls::Error::General("certificates of clients are not accepted".to_owned());
        let eip = self.eip.as_ref().ok_or_else(none)?;
        let (leaf, chain) = client.chain.split_first().ok_or_else(none)?;
        eip.verifier.verify_client_cert(leaf, chain, now).map(drop)
    }
}

/// A client that has shown a certificate.
#[derive(Clone, Debug)]
pub(crate) struct TlsClient {
    chain: Vec<CertificateDer<'static>>,
    leaf: Leaf,
}

impl TlsClient {
    /// Its name in logs.
    pub(crate) fn name(&self) -> String {
        format!("cn:{}", self.leaf.cn)
    }
}

/// The reason for which a connection failed its handshake.
#[derive(Debug, thiserror::Error)]
pub(crate) enum Failed {
    /// Too many handshakes, or a lock.
    #[error("too many handshakes or failures")]
    Limited,
    /// The handshake took too long.
    #[error("the handshake took longer than {} s", HANDSHAKE.as_secs())]
    Late,
    /// rustls refused it.
    #[error("{0}")]
    Refused(#[from] std::io::Error),
}

impl Tls {
    /// Reads the files of `[security]`; relative names are those of the folder `base`.
    ///
    /// # Errors
    /// See [`TrustError`].
    pub(crate) fn new(security: &Security, base: &Path) -> Result<Arc<Self>, TrustError> {
        let places = || Places::with_share(HANDSHAKES, HANDSHAKES_OF_ONE, Full::ClosesOldestOfLargerShare);
        let files = Files::new(security, base);
        let trust = files.read()?;
        let this = Self {
            files,
            check_expiration: security.check_expiration,
            roles: ArcSwap::from_pointee(Table::of(security)),
            trust: ArcSwap::from_pointee(trust),
            handshakes: places(),
            page_handshakes: places(),
            lockouts: Lockouts::default(),
            live: Mutex::default(),
        };
        this.warn_of_end();
        Ok(Arc::new(this))
    }

    /// Checks that the files can be used.
    ///
    /// # Errors
    /// See [`TrustError`].
    pub(crate) fn check(security: &Security, base: &Path) -> Result<(), TrustError> {
        Files::new(security, base).read().map(drop)
    }

    /// Makes a TLS connection of a TCP connection of an EtherNet/IP client.
    ///
    /// # Errors
    /// See [`Failed`]; the socket is closed then.
    pub(crate) async fn accept(
        &self,
        stream: TcpStream,
        peer: IpAddr,
    ) -> Result<(TlsStream<TcpStream>, TlsClient), Failed> {
        let config = self.trust.load().eip.as_ref().map(|eip| eip.config.clone());
        let config = config.ok_or(Failed::Limited)?;
        if !peer.is_loopback() && self.lockouts.locked(peer, None, Instant::now()).is_some() {
            return Err(Failed::Limited);
        }
        let done = handshake(config, &self.handshakes, stream, peer).await;
        if matches!(done, Err(Failed::Late | Failed::Refused(_))) {
            self.lockouts.failed(peer, None, Instant::now());
        }
        let stream = done?;
        let chain = stream.get_ref().1.peer_certificates().unwrap_or_default();
        let chain: Vec<_> = chain.iter().map(|one| one.clone().into_owned()).collect();
        let leaf = chain.first().and_then(|leaf| Leaf::read(leaf));
        let leaf = leaf.ok_or_else(|| std::io::Error::other("its certificate cannot be read"))?;
        Ok((stream, TlsClient { chain, leaf }))
    }

    /// Makes a TLS connection of a TCP connection of a browser. A failure is no guess of a secret, so it locks no address: browsers fail while
    /// a person examines a certificate that they do not trust.
    ///
    /// # Errors
    /// See [`Failed`]; the socket is closed then.
    pub(crate) async fn accept_page(&self, stream: TcpStream, peer: IpAddr) -> Result<TlsStream<TcpStream>, Failed> {
        let config = self.trust.load().page.clone();
        handshake(config, &self.page_handshakes, stream, peer).await
    }

    /// The names of the server in its own certificate.
    pub(crate) fn names(&self) -> Vec<String> {
        self.trust.load().names.clone()
    }

    /// Logs a failed handshake.
    pub(crate) fn log_failed(&self, log: &LogLimit, peer: IpAddr, failed: &Failed) {
        log.warn("tls", Some(peer), || format!("a TLS handshake failed: {failed}"));
    }

    /// The role of a certificate: that of its row, by the key or by subject and issuer, else `default_role`.
    pub(crate) fn role_of(&self, client: &TlsClient) -> Role {
        let table = self.roles.load();
        let row = table.rows.iter().find(|row| {
            let by_key = row
                .sha256
                .as_ref()
                .map(|hash| hash.eq_ignore_ascii_case(&client.leaf.sha256));
            by_key.unwrap_or_else(|| {
                row.cn.as_deref() == Some(client.leaf.cn.as_str())
                    && row.issuer.as_deref() == Some(client.leaf.issuer.as_str())
            })
        });
        row.map_or(table.default, |row| row.role)
    }

    /// Takes over the rows of certificates and `default_role` of a configuration that was read again. [`Tls::reload`] gives open connections
    /// their roles by them.
    pub(crate) fn set_roles(&self, security: &Security, plant: &Plant) {
        let table = Table::of(security);
        if *self.roles.load_full() != table {
            self.roles.store(Arc::new(table));
            warn!("the roles of certificates were read again");
            let what = "the roles of certificates".to_owned();
            plant.record(Principal::Server, EventKind::Reload, what, "done");
        }
    }

    /// A connection whose session the plant knows lives by a certificate from now on; `close` closes it. It is cancelled at once when the
    /// certificate was revoked while the handshake ran. A certificate and a role that a reload has not checked are checked here, both under
    /// one lock.
    pub(crate) fn enter(&self, session: u64, client: TlsClient, plant: &Plant, close: CancellationToken) {
        let live = Live { client, close };
        let mut all = self.live();
        match self.trust.load().judge(&live.client, now()) {
            Ok(()) => {
                plant.roles().set(session, self.role_of(&live.client));
                all.insert(session, live);
            }
            Err(reason) => live.close(&reason),
        }
    }

    /// A connection has ended. Returns whether its certificate still held.
    pub(crate) fn leave(&self, session: u64) -> bool {
        self.live().remove(&session).is_some()
    }

    /// Takes the files over as they are now, and judges every open connection by them.
    pub(crate) fn reload(&self, plant: &Plant) {
        let read = self.files.read();
        let result = if read.is_ok() { "done" } else { "refused" };
        plant.record(
            Principal::Server,
            EventKind::Reload,
            "the certificates of TLS".to_owned(),
            result,
        );
        match read {
            Ok(trust) => {
                self.trust.store(Arc::new(trust));
                warn!("the certificates of TLS were read again");
                self.warn_of_end();
                plant.set_certificate_end(self.trust.load().ends);
                self.judge(plant);
            }
            Err(error) => {
                error!(%error, "the certificates of TLS stay as they were");
                // The rows may be others.
                self.judge(plant);
            }
        }
    }

    /// Checks the files and the certificates of open connections, forever.
    pub(crate) async fn watch(&self, plant: &Plant) {
        let mut changed = self.files.changed();
        plant.set_certificate_end(self.trust.load().ends);
        for look in 1_u32.. {
            tokio::time::sleep(LOOK).await;
            if look % FILES_EVERY == 0 {
                let now = self.files.changed();
                if std::mem::replace(&mut changed, now.clone()) != now {
                    self.reload(plant);
                }
            }
            if look % WARN_EVERY == 0 {
                self.warn_of_end();
            }
            self.end_expired(plant);
        }
    }

    fn end_expired(&self, plant: &Plant) {
        let now = unix_seconds();
        let expired = self.check_expiration && self.live().values().any(|live| live.client.leaf.valid.1 < now);
        if expired {
            self.judge(plant);
        }
    }

    /// Closes the connections whose certificate does not hold any more.
    fn judge(&self, plant: &Plant) {
        let trust = self.trust.load_full();
        let now = now();
        self.live()
            .retain(|session, live| match trust.judge(&live.client, now) {
                Ok(()) => {
                    plant.roles().set(*session, self.role_of(&live.client));
                    true
                }
                Err(reason) => {
                    live.close(&reason);
                    false
                }
            });
    }

    fn warn_of_end(&self) {
        let trust = self.trust.load();
        let left = trust.ends - unix_seconds();
        if left < ENDS_SOON {
            warn!(days = left / 86_400, "the certificate of the server ends soon");
        } else {
            debug!(days = left / 86_400, "the certificate of the server holds");
        }
        if let Some(next) = trust.next_list
            && next < unix_seconds()
        {
            let days = (unix_seconds() - next) / 86_400;
            warn!(
                days,
                "the list of revoked certificates is old: its authority has made another one, which `revoked` is to have"
            );
        }
    }

    fn live(&self) -> MutexGuard<'_, HashMap<u64, Live>> {
        self.live.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

async fn handshake(
    config: Arc<ServerConfig>,
    places: &Arc<Places>,
    stream: TcpStream,
    peer: IpAddr,
) -> Result<TlsStream<TcpStream>, Failed> {
    let place: Place = places.enter(peer).ok_or(Failed::Limited)?;
    let handshake = tokio::time::timeout(HANDSHAKE, TlsAcceptor::from(config).accept(stream));
    match place.close().run_until_cancelled(handshake).await {
        None => Err(Failed::Limited),
        Some(Err(_)) => Err(Failed::Late),
        Some(Ok(done)) => done.map_err(Failed::from),
    }
}

fn now() -> UnixTime {
    UnixTime::since_unix_epoch(Duration::from_secs(unix_seconds().unsigned_abs()))
}

fn unix_seconds() -> i64 {
    let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    i64::try_from(since.as_secs()).unwrap_or(i64::MAX)
}
