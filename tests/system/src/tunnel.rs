//! A tunnel of stunnel or socat, by which a client without TLS reaches a server with it, as docs/SECURITY.md describes it.

use std::fs;
use std::net::{Ipv4Addr, SocketAddr, TcpListener, TcpStream};
use std::os::unix::process::CommandExt as _;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

/// The program of a tunnel.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Kind {
    /// stunnel in client mode.
    Stunnel,
    /// socat, a process for each connection.
    Socat,
}

/// A tunnel that runs, ended when this is dropped.
pub struct Tunnel {
    child: Child,
    address: SocketAddr,
}

impl Tunnel {
    /// Starts a tunnel to a server, with `NAME.pem`, `NAME.key` and `ca.pem` of a folder.
    ///
    /// # Errors
    /// The program is not installed.
    ///
    /// # Panics
    /// When it does not listen in time.
    pub fn start(kind: Kind, server: SocketAddr, folder: &Path, name: &str) -> Result<Self, String> {
        // Free a moment ago; another program that takes it now makes the tunnel fail.
        let free = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).and_then(|listener| listener.local_addr());
        Self::start_at(kind, free.expect("a free port"), server, folder, name)
    }

    /// The same, at an address of this computer.
    ///
    /// # Errors
    /// As [`Tunnel::start`].
    ///
    /// # Panics
    /// As [`Tunnel::start`].
    pub fn start_at(
        kind: Kind,
        address: SocketAddr,
        server: SocketAddr,
        folder: &Path,
        name: &str,
    ) -> Result<Self, String> {
        let file = |name: &str| folder.join(name).display().to_string();
        let (certificate, key, ca) = (
            file(&format!("{name}.pem")),
            file(&format!("{name}.key")),
            file("ca.pem"),
        );
        let mut command = match kind {
            Kind::Stunnel => {
                let config = file("stunnel.conf");
                let text = format!(
                    "foreground = yes\npid =\nsyslog = no\n[arcline]\nclient = yes\naccept = {address}\nconnect = {server}\ncert = {certificate}\n\
                     key = {key}\nCAfile = {ca}\nverifyChain = yes\ncheckHost = localhost\n"
                );
                fs::write(&config, text).expect("a writable folder");
                let mut command = Command::new("stunnel");
                command.arg(config);
                command
            }
            Kind::Socat => {
                let mut command = Command::new("socat");
                command.arg(format!(
                    "TCP-LISTEN:{},bind={},fork,reuseaddr",
                    address.port(),
                    address.ip()
                ));
                command.arg(format!(
                    "OPENSSL:localhost:{},cert={certificate},key={key},cafile={ca},pf=ip4",
                    server.port()
                ));
                command
            }
        };
        let child = command
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .process_group(0)
            .spawn()
            .map_err(|error| format!("{kind:?} cannot be started ({error}); Debian: apt-get install stunnel4 socat"))?;
        let tunnel = Self { child, address };
        crate::eventually("the tunnel listens", Duration::from_secs(30), || {
            TcpStream::connect(address).ok().map(drop)
        });
        Ok(tunnel)
    }

    /// The address for a client without TLS.
    #[must_use]
    pub fn address(&self) -> SocketAddr {
        self.address
    }
}

impl Drop for Tunnel {
    fn drop(&mut self) {
        // End it with the processes that it started for its connections.
        let group = format!("-{}", self.child.id());
        let _ = Command::new("kill").args(["-KILL", "--", &group]).status();
        let _ = self.child.wait();
    }
}
