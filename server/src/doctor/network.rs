//! Checks that a server can open its ports on this computer.

use std::io::ErrorKind;
use std::net::{SocketAddr, TcpListener, UdpSocket};

use arcline_config::ServerConfig;

use super::{Finding, Grade};

/// Opens each port for a moment.
pub(super) fn ports(server: &ServerConfig) -> Vec<Finding> {
    let mut findings = Vec::new();
    for listen in [server.listen].into_iter().chain(server.listen_also.iter().copied()) {
        findings.push(port("EtherNet/IP", listen, &[Kind::Tcp, Kind::Udp]));
    }
    if let Some(io) = server.io.address(server.listen) {
        findings.push(port("cyclic I/O", io, &[Kind::Udp]));
    }
    if let Some(hmi) = server.hmi {
        findings.push(port("page", hmi, &[Kind::Tcp]));
    }
    findings
}

/// The transport protocol of a port.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Kind {
    Tcp,
    Udp,
}

pub(super) fn port(check: &'static str, at: SocketAddr, kinds: &[Kind]) -> Finding {
    for kind in kinds {
        let (word, opened) = match kind {
            Kind::Tcp => ("TCP", TcpListener::bind(at).map(drop)),
            Kind::Udp => ("UDP", UdpSocket::bind(at).map(drop)),
        };
        let Err(error) = opened else { continue };
        let remedy = match error.kind() {
            ErrorKind::AddrInUse => {
                "Another program has this port, perhaps a server that runs: `ss -lntup` names it. Or choose another address (--listen, --hmi)."
            }
            ErrorKind::AddrNotAvailable => {
                "This computer does not have the address: `ip address` lists those that it has."
            }
            ErrorKind::PermissionDenied => {
                "Ports below 1024 need a right: AmbientCapabilities=CAP_NET_BIND_SERVICE in the unit, or a higher port."
            }
            _ => "Choose another address (--listen, --hmi).",
        };
        return Finding::new(check, Grade::Failed, format!("{at} {word}: {error}"), remedy);
    }
    let words: Vec<&str> = kinds
        .iter()
        .map(|kind| if *kind == Kind::Tcp { "TCP" } else { "UDP" })
        .collect();
    Finding::ok(check, format!("{at} {} is free", words.join(" and ")))
}
