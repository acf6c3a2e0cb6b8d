//! A server with TLS, with its own authority and the certificate of one client, in a folder.

use std::fs;
use std::path::Path;
use std::process::Command;

use arcline_client::{Tls, TlsFiles};
use tempfile::TempDir;

use crate::server::Server;

/// The name of the client's certificate: `panel.pem` and `panel.key`.
pub const CLIENT: &str = "panel";

/// A server with EtherNet/IP over TLS, and the folder of its certificates.
pub struct Secured {
    /// The server; its client's role is engineer.
    pub server: Server,
    folder: TempDir,
}

impl Secured {
    /// Starts a server on a configuration, to which `[security]` with TLS and these rows is added, with these arguments besides.
    ///
    /// # Panics
    /// When it does not start.
    #[must_use]
    pub fn start(configuration: &str, rows: &str, arguments: &[&str]) -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        let at = folder.path().to_str().expect("UTF-8");
        for arguments in [&["init", at][..], &["client", at, CLIENT]] {
            let made = Command::new(crate::programs::arcline_server())
                .arg("certs")
                .args(arguments)
                .output();
            assert!(made.is_ok_and(|output| output.status.success()), "certs {arguments:?}");
        }
        let security = format!("\n[security]\ntls = \"127.0.0.1:0\"\ndefault_role = \"engineer\"\n{rows}");
        let file = folder.path().join("machine.toml");
        fs::write(&file, configuration.to_owned() + &security).expect("a writable folder");
        let config = ["--config", file.to_str().expect("UTF-8")];
        let server = Server::start_with(&[&config, arguments].concat());
        Self { server, folder }
    }

    /// The folder with `ca.pem`, `panel.pem` and `panel.key`.
    #[must_use]
    pub fn folder(&self) -> &Path {
        self.folder.path()
    }

    /// The certificate of the client.
    ///
    /// # Panics
    /// When the certificates cannot be read.
    #[must_use]
    pub fn tls(&self) -> Tls {
        let file = |name: String| self.folder.path().join(name);
        Tls::new(&TlsFiles {
            ca: file("ca.pem".to_owned()),
            certificate: file(format!("{CLIENT}.pem")),
            key: file(format!("{CLIENT}.key")),
            server_name: None,
        })
        .expect("the server has just made them")
    }
}
