//! Checks that a server can open its ports on this computer.

use std::io::ErrorKind;
use std::net::{SocketAddr, TcpListener, UdpSocket};

use arcline_config::{PlainAccess, ServerConfig};

use super::{Finding, Grade};
use crate::run::open_without_security;

/// Opens all ports for a moment, at the same time, so that two listeners on one port are found too.
pub(super) fn ports(server: &ServerConfig) -> Vec<Finding> {
    let mut ports = Ports::default();
    let eip: &[Kind] = match server.security.plain {
        PlainAccess::Off => &[Kind::Udp],
        _ => &[Kind::Tcp, Kind::Udp],
    };
    let mut findings = Vec::new();
    for listen in [server.listen].into_iter().chain(server.listen_also.iter().copied()) {
        findings.push(ports.open("EtherNet/IP", listen, eip));
    }
    let security = &server.security;
    let tls = security
        .tls
        .map(|tls| ports.open("EtherNet/IP over TLS", tls, &[Kind::Tcp]));
    findings.extend(tls);
    if let Some(io) = server.io.address(server.listen) {
        findings.push(ports.open("cyclic I/O", io, &[Kind::Udp]));
    }
    if let Some(hmi) = server.hmi {
        findings.push(ports.open("page", hmi, &[Kind::Tcp]));
    }
    let page = security
        .hmi_tls
        .map(|tls| ports.open("page over TLS", tls, &[Kind::Tcp]));
    findings.extend(page);
    if let Some(open) = open_without_security(server, server.hmi) {
        findings.push(Finding::new(
            "network",
            Grade::Warning,
            format!("{open} is reachable from other computers, and there is no [security]"),
            "The server starts with --open-to-network only: clients elsewhere may then view and stop. For more add [security] (docs/SECURITY.md).",
        ));
    }
    findings
}

/// The ports that have been opened; they are open until this is dropped.
#[derive(Debug, Default)]
pub(super) struct Ports {
    tcp: Vec<TcpListener>,
    udp: Vec<UdpSocket>,
}

/// The transport protocol of a port.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Kind {
    Tcp,
    Udp,
}

impl Ports {
    /// Opens a port.
    pub(super) fn open(&mut self, check: &'static str, at: SocketAddr, kinds: &[Kind]) -> Finding {
        for kind in kinds {
            let (word, opened) = match kind {
                Kind::Tcp => ("TCP", TcpListener::bind(at).map(|socket| self.tcp.push(socket))),
                Kind::Udp => ("UDP", UdpSocket::bind(at).map(|socket| self.udp.push(socket))),
            };
            let Err(error) = opened else { continue };
            let remedy = match error.kind() {
                ErrorKind::AddrInUse => {
                    "Another program has this port, perhaps a server that runs: `ss -lntup` names it; or the configuration has the port twice. Choose \
                     another address (--listen, --hmi, tls, hmi_tls)."
                }
                ErrorKind::AddrNotAvailable => {
                    "This computer does not have the address: `ip address` lists those that it has."
                }
                ErrorKind::PermissionDenied => {
                    "Ports below 1024 need a right: AmbientCapabilities=CAP_NET_BIND_SERVICE in the unit, or a higher port."
                }
                _ => "Choose another address (--listen, --hmi, tls, hmi_tls).",
            };
            return Finding::new(check, Grade::Failed, format!("{at} {word}: {error}"), remedy);
        }
        let words: Vec<&str> = kinds
            .iter()
            .map(|kind| if *kind == Kind::Tcp { "TCP" } else { "UDP" })
            .collect();
        Finding::ok(check, format!("{at} {} is free", words.join(" and ")))
    }
}
