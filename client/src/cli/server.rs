//! The server that the commands ask: its address, and the TLS of the connection.

use std::path::PathBuf;

use arcline_client::{Client, ClientError, Options, Tls, TlsFiles};

use super::args::TlsArguments;

/// A server.
#[derive(Debug)]
pub(crate) struct Server {
    address: String,
    tls: Option<Tls>,
}

impl Server {
    /// The server at an address; with TLS if the options or the variables say so.
    ///
    /// # Errors
    /// [`ClientError::Credentials`].
    pub(crate) fn new(address: String, options: &TlsArguments) -> Result<Self, ClientError> {
        let variable = |name: &str| std::env::var_os(name).filter(|value| !value.is_empty());
        let is_wanted = options.tls || variable("ARCLINE_TLS").is_some_and(|value| value != "0");
        if !is_wanted {
            return Ok(Self { address, tls: None });
        }
        let file = |option: &Option<PathBuf>, name: &str, default: &str| {
            let of_variable = || variable(name).map(PathBuf::from);
            option
                .clone()
                .or_else(of_variable)
                .unwrap_or_else(|| folder().join(default))
        };
        let files = TlsFiles {
            ca: file(&options.ca, "ARCLINE_CA", "ca.pem"),
            certificate: file(&options.certificate, "ARCLINE_CERTIFICATE", "client.pem"),
            key: file(&options.key, "ARCLINE_KEY", "client.key"),
            server_name: options.server_name.clone(),
        };
        let tls = Some(Tls::new(&files)?);
        Ok(Self { address, tls })
    }

    /// Connects.
    ///
    /// # Errors
    /// As [`Client::connect`].
    pub(crate) async fn connect(&self) -> Result<Client, ClientError> {
        match &self.tls {
            None => Client::connect(&self.address).await,
            Some(tls) => Client::connect_tls(&self.address, tls, &Options::default()).await,
        }
    }
}

/// The folder of the files by default.
fn folder() -> PathBuf {
    let of = |name| std::env::var_os(name).map(PathBuf::from);
    let config = of("XDG_CONFIG_HOME").or_else(|| of("HOME").map(|home| home.join(".config")));
    config.unwrap_or_default().join("arcline")
}
