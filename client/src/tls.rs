//! TLS of a connection: the authority of the server, and the certificate that this client shows.

use std::fmt;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use rustls::crypto::ring;
use rustls::pki_types::pem::PemObject as _;
use rustls::pki_types::{CertificateDer, PrivateKeyDer, ServerName};
use rustls::version::{TLS12, TLS13};
use rustls::{ClientConfig, RootCertStore};
use tokio::io::{AsyncRead, AsyncWrite};
use tokio::net::TcpStream;
use tokio_rustls::TlsConnector;

use crate::ClientError;

/// The port of EtherNet/IP over TLS.
pub const TLS_PORT: u16 = 2221;

/// The TLS of connections to a server; clones are the same one.
#[derive(Clone)]
pub struct Tls {
    config: Arc<ClientConfig>,
    /// The name that the server's certificate must have; `None`: that of the address.
    server_name: Option<ServerName<'static>>,
}

/// The files of [`Tls`], PEM.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct TlsFiles {
    /// The authority whose certificate the server shows.
    pub ca: PathBuf,
    /// The certificate of this client, and those between it and its authority.
    pub certificate: PathBuf,
    /// The private key of that certificate.
    pub key: PathBuf,
    /// The name that the server's certificate must have; `None`: that of the address.
    pub server_name: Option<String>,
}

impl Tls {
    /// Reads the files.
    ///
    /// # Errors
    /// [`ClientError::Credentials`].
    pub fn new(files: &TlsFiles) -> Result<Self, ClientError> {
        let mut roots = RootCertStore::empty();
        for authority in certificates(&files.ca)? {
            roots.add(authority).map_err(|error| wrong(&files.ca, error))?;
        }
        let chain = certificates(&files.certificate)?;
        let key = PrivateKeyDer::from_pem_file(&files.key).map_err(|error| wrong(&files.key, error))?;
        let config = ClientConfig::builder_with_provider(Arc::new(ring::default_provider()))
            .with_protocol_versions(&[&TLS13, &TLS12])
            .map_err(|error| wrong(&files.ca, error))?
            .with_root_certificates(roots)
            .with_client_auth_cert(chain, key)
            .map_err(|error| wrong(&files.certificate, error))?;
        let server_name = files.server_name.clone().map(ServerName::try_from).transpose();
        Ok(Self {
            config: Arc::new(config),
            server_name: server_name.map_err(|error| wrong(Path::new("the name of the server"), error))?,
        })
    }

    /// The handshake on a TCP connection to `address`, `HOST:PORT`.
    ///
    /// # Errors
    /// The server's certificate does not hold, or the server refuses this client's.
    pub async fn connect(
        &self,
        stream: TcpStream,
        address: &str,
    ) -> std::io::Result<impl AsyncRead + AsyncWrite + Unpin + Send + use<>> {
        let host = address.rsplit_once(':').map_or(address, |(host, _)| host);
        let host = host.trim_start_matches('[').trim_end_matches(']').to_owned();
        let name = match &self.server_name {
            Some(name) => name.clone(),
            None => ServerName::try_from(host).map_err(std::io::Error::other)?,
        };
        TlsConnector::from(self.config.clone()).connect(name, stream).await
    }
}

impl fmt::Debug for Tls {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Tls")
            .field("server_name", &self.server_name)
            .finish_non_exhaustive()
    }
}

fn certificates(file: &Path) -> Result<Vec<CertificateDer<'static>>, ClientError> {
    let all = CertificateDer::pem_file_iter(file).map_err(|error| wrong(file, error))?;
    let all = all.collect::<Result<Vec<_>, _>>().map_err(|error| wrong(file, error))?;
    if all.is_empty() {
        return Err(wrong(file, "it holds no certificate"));
    }
    Ok(all)
}

fn wrong(file: &Path, reason: impl ToString) -> ClientError {
    ClientError::Credentials {
        file: file.display().to_string(),
        reason: reason.to_string(),
    }
}
