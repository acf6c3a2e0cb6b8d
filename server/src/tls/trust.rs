//! The files of TLS as a configuration of rustls: the server's certificate and key, the authorities of clients, and revoked certificates.
//!
//! TLS 1.2 and 1.3 with the suites of rustls and ring (spec/security.md §3). No session is resumed, so a reload reaches every new
//! connection; there is no early data.

use std::fs;
use std::os::unix::fs::MetadataExt as _;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::SystemTime;

use arcline_config::Security;
use rustls::client::danger::HandshakeSignatureValid;
use rustls::crypto::{CryptoProvider, ring};
use rustls::pki_types::pem::PemObject as _;
use rustls::pki_types::{CertificateDer, CertificateRevocationListDer, PrivateKeyDer, UnixTime};
use rustls::server::danger::{ClientCertVerified, ClientCertVerifier};
use rustls::server::{NoServerSessionStorage, WebPkiClientVerifier};
use rustls::version::{TLS12, TLS13};
use rustls::{
    CertificateError, DigitallySignedStruct, DistinguishedName, Error, RootCertStore, ServerConfig, SignatureScheme,
};

use super::leaf::{self, Leaf};

/// The files.
#[derive(Clone, Debug)]
pub(crate) struct Files {
    certificate: PathBuf,
    key: PathBuf,
    /// `None`: EtherNet/IP does not use TLS.
    clients: Option<PathBuf>,
    revoked: Option<PathBuf>,
    check_expiration: bool,
}

/// The contents of the files at one time.
#[derive(Debug)]
pub(crate) struct Trust {
    /// The trust of EtherNet/IP; `None`: EtherNet/IP over TLS is off.
    pub(crate) eip: Option<Eip>,
    /// The configuration of the page, on which users log in.
    pub(crate) page: Arc<ServerConfig>,
    /// The names of the server in its own certificate.
    pub(crate) names: Vec<String>,
    /// The end of the server's own certificate, Unix time.
    pub(crate) ends: i64,
    /// When the first of the lists of revoked certificates is to be followed by another one, Unix time.
    pub(crate) next_list: Option<i64>,
}

/// The side of EtherNet/IP: a client needs a certificate.
#[derive(Clone, Debug)]
pub(crate) struct Eip {
    pub(crate) config: Arc<ServerConfig>,
    /// Judges the certificates of clients.
    pub(crate) verifier: Arc<dyn ClientCertVerifier>,
}

/// The reason for which the files cannot be used. It names files, never their content.
#[derive(Debug, thiserror::Error)]
pub(crate) enum TrustError {
    /// A file cannot be read, or holds nothing of its kind.
    #[error("{}: {reason}", file.display())]
    File {
        /// The file.
        file: PathBuf,
        /// The reason.
        reason: String,
    },
    /// Other users can read the key.
    #[error("{}: the private key is readable by other users; set its mode to 600", file.display())]
    OpenKey {
        /// The file.
        file: PathBuf,
    },
    /// rustls refuses them.
    #[error("the certificates cannot be used: {0}")]
    Refused(String),
}

impl Files {
    /// The files of `[security]`; relative names begin at the folder `base`.
    pub(crate) fn new(security: &Security, base: &Path) -> Self {
        let at = |name: &str| base.join(name);
        Self {
            certificate: at(&security.certificate),
            key: at(&security.key),
            clients: security.tls.map(|_| at(&security.clients)),
            revoked: security.tls.and(security.revoked.as_deref()).map(at),
            check_expiration: security.check_expiration,
        }
    }

    /// When they were changed last, each.
    pub(crate) fn changed(&self) -> Vec<Option<SystemTime>> {
        let files = [&self.certificate, &self.key].into_iter();
        let files = files.chain(&self.clients).chain(&self.revoked);
        files
            .map(|file| fs::metadata(file).and_then(|metadata| metadata.modified()).ok())
            .collect()
    }

    /// Reads all of them.
    pub(crate) fn read(&self) -> Result<Trust, TrustError> {
        let provider = Arc::new(ring::default_provider());
        let mode = fs::metadata(&self.key).map_err(|error| wrong(&self.key, error))?.mode();
        if mode & 0o077 != 0 {
            return Err(TrustError::OpenKey { file: self.key.clone() });
        }
        let chain = certificates(&self.certificate)?;
        let own = chain.first().and_then(|leaf| Leaf::read(leaf));
        let own = own.ok_or_else(|| wrong(&self.certificate, "it holds no certificate"))?;
        let key = PrivateKeyDer::from_pem_file(&self.key).map_err(|error| wrong(&self.key, error))?;
        let mut page = server_config(&provider, None, &chain, &key)?;
        page.alpn_protocols = vec![b"http/1.1".to_vec()];
        let lists = self.lists()?;
        let next_list = lists.iter().filter_map(|list| leaf::next_list(list)).min();
        let eip = match &self.clients {
            None => None,
            Some(clients) => {
                let verifier = self.verifier(clients, lists, &provider)?;
                let config = Arc::new(server_config(&provider, Some(&verifier), &chain, &key)?);
                Some(Eip { config, verifier })
            }
        };
        Ok(Trust {
            eip,
            page: Arc::new(page),
            names: own.names,
            ends: own.valid.1,
            next_list,
        })
    }

    /// The lists of revoked certificates.
    fn lists(&self) -> Result<Vec<CertificateRevocationListDer<'static>>, TrustError> {
        let Some(file) = &self.revoked else {
            return Ok(Vec::new());
        };
        let lists = CertificateRevocationListDer::pem_file_iter(file).map_err(|error| wrong(file, error))?;
        lists.collect::<Result<Vec<_>, _>>().map_err(|error| wrong(file, error))
    }

    /// Judges the certificates of clients by the authorities of a file.
    fn verifier(
        &self,
        clients: &Path,
        lists: Vec<CertificateRevocationListDer<'static>>,
        provider: &Arc<CryptoProvider>,
    ) -> Result<Arc<dyn ClientCertVerifier>, TrustError> {
        let mut roots = RootCertStore::empty();
        for authority in certificates(clients)? {
            roots.add(authority).map_err(|error| wrong(clients, error))?;
        }
        let mut builder = WebPkiClientVerifier::builder_with_provider(Arc::new(roots), provider.clone());
        if !lists.is_empty() {
            // An authority without a list, and a list that is old, do not stop the plant.
            builder = builder
                .with_crls(lists)
                .only_check_end_entity_revocation()
                .allow_unknown_revocation_status();
        }
        let verifier = builder.build().map_err(|error| wrong(clients, error))?;
        Ok(match self.check_expiration {
            true => verifier,
            false => Arc::new(WithoutClock(verifier)),
        })
    }
}

fn certificates(file: &Path) -> Result<Vec<CertificateDer<'static>>, TrustError> {
    let all = CertificateDer::pem_file_iter(file).map_err(|error| wrong(file, error))?;
    let all = all.collect::<Result<Vec<_>, _>>().map_err(|error| wrong(file, error))?;
    if all.is_empty() {
        return Err(wrong(file, "it holds no certificate"));
    }
    Ok(all)
}

fn wrong(file: &Path, reason: impl ToString) -> TrustError {
    TrustError::File {
        file: file.to_owned(),
        reason: reason.to_string(),
    }
}

/// The configuration of the server's side. With `verifier`, a client needs a certificate that it accepts.
fn server_config(
    provider: &Arc<CryptoProvider>,
    verifier: Option<&Arc<dyn ClientCertVerifier>>,
    chain: &[CertificateDer<'static>],
    key: &PrivateKeyDer<'static>,
) -> Result<ServerConfig, TrustError> {
    let refused = |error: Error| TrustError::Refused(error.to_string());
    let builder = ServerConfig::builder_with_provider(provider.clone())
        .with_protocol_versions(&[&TLS13, &TLS12])
        .map_err(refused)?;
    let builder = match verifier {
        Some(verifier) => builder.with_client_cert_verifier(verifier.clone()),
        None => builder.with_no_client_auth(),
    };
    let mut config = builder
        .with_single_cert(chain.to_vec(), key.clone_key())
        .map_err(refused)?;
    config.session_storage = Arc::new(NoServerSessionStorage {});
    config.send_tls13_tickets = 0;
    Ok(config)
}

/// The verifier of a plant without a clock: it checks a certificate at the last second of its validity when it is not valid now.
#[derive(Debug)]
struct WithoutClock(Arc<dyn ClientCertVerifier>);

impl ClientCertVerifier for WithoutClock {
    fn offer_client_auth(&self) -> bool {
        self.0.offer_client_auth()
    }

    fn client_auth_mandatory(&self) -> bool {
        self.0.client_auth_mandatory()
    }

    fn root_hint_subjects(&self) -> &[DistinguishedName] {
        self.0.root_hint_subjects()
    }

    fn verify_client_cert(
        &self,
        leaf: &CertificateDer<'_>,
        chain: &[CertificateDer<'_>],
        now: UnixTime,
    ) -> Result<ClientCertVerified, Error> {
        let judged = self.0.verify_client_cert(leaf, chain, now);
        let is_time = matches!(
            &judged,
            Err(Error::InvalidCertificate(
                CertificateError::Expired
                    | CertificateError::ExpiredContext { .. }
                    | CertificateError::NotValidYet
                    | CertificateError::NotValidYetContext { .. }
            ))
        );
        match Leaf::read(leaf).and_then(|leaf| u64::try_from(leaf.valid.1).ok()) {
            Some(last) if is_time => {
                let last = UnixTime::since_unix_epoch(std::time::Duration::from_secs(last));
                self.0.verify_client_cert(leaf, chain, last)
            }
            _ => judged,
        }
    }

    fn verify_tls12_signature(
        &self,
        message: &[u8],
        leaf: &CertificateDer<'_>,
        signature: &DigitallySignedStruct,
    ) -> Result<HandshakeSignatureValid, Error> {
        self.0.verify_tls12_signature(message, leaf, signature)
    }

    fn verify_tls13_signature(
        &self,
        message: &[u8],
        leaf: &CertificateDer<'_>,
        signature: &DigitallySignedStruct,
    ) -> Result<HandshakeSignatureValid, Error> {
        self.0.verify_tls13_signature(message, leaf, signature)
    }

    fn supported_verify_schemes(&self) -> Vec<SignatureScheme> {
        self.0.supported_verify_schemes()
    }
}
