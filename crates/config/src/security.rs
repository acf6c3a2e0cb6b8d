//! The `[security]` table: roles, certificates and access (spec/security.md §6).

use std::net::{IpAddr, SocketAddr};

use ipnet::IpNet;

use crate::ServerConfig;
use crate::words::{self, word_of};

/// A role. Each may do all that those before it may.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub enum Role {
    /// Looks and stops.
    Viewer,
    /// Moves the machine and writes tags.
    Operator,
    /// Runs programs and sets up the machine.
    Engineer,
    /// Decides about users and certificates.
    Administrator,
}

impl Role {
    /// Every role, the least first.
    pub const ALL: [Role; 4] = [Role::Viewer, Role::Operator, Role::Engineer, Role::Administrator];

    /// The word in a configuration.
    pub const fn word(self) -> &'static str {
        match self {
            Self::Viewer => "viewer",
            Self::Operator => "operator",
            Self::Engineer => "engineer",
            Self::Administrator => "administrator",
        }
    }

    /// The role of a word, case ignored.
    pub fn of_word(word: &str) -> Option<Self> {
        Self::ALL
            .into_iter()
            .find(|role| role.word().eq_ignore_ascii_case(word))
    }
}

/// EtherNet/IP without TLS.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum PlainAccess {
    /// As with TLS.
    On,
    /// Answers the List commands, and refuses sessions.
    Discovery,
    /// Does not listen on TCP.
    Off,
}

impl PlainAccess {
    /// The word of each in a configuration.
    pub const WORDS: [(&'static str, Self); 3] = [("on", Self::On), ("discovery", Self::Discovery), ("off", Self::Off)];

    /// The word in a configuration.
    pub fn word(self) -> &'static str {
        word_of(words::PLAIN, &self)
    }
}

/// The role of a certificate: by the hash of its key, or else by subject and issuer.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct CertificateRole {
    /// The Common Name of its subject.
    pub cn: Option<String>,
    /// The name of its issuer.
    pub issuer: Option<String>,
    /// SHA-256 over its SubjectPublicKeyInfo, hexadecimal.
    pub sha256: Option<String>,
    /// Its role.
    pub role: Role,
}

/// The addresses that a listener answers.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct AllowList(pub Vec<IpNet>);

impl AllowList {
    /// The most networks of a list.
    pub const MOST: usize = 64;

    /// A network such as `10.1.2.0/24`, or one address. IPv4 inside of IPv6 is IPv4.
    pub fn network(text: &str) -> Option<IpNet> {
        let network = match text.parse::<IpAddr>() {
            Ok(address) => IpNet::from(address.to_canonical()),
            Err(_) => text.parse().ok()?,
        };
        Some(network.trunc())
    }

    /// Whether the listener answers an address. Without networks it answers all; it always answers this computer's own loopback addresses.
    pub fn allows(&self, address: IpAddr) -> bool {
        let address = address.to_canonical();
        self.0.is_empty() || address.is_loopback() || self.0.iter().any(|network| network.contains(&address))
    }
}

/// The `[security]` table.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Security {
    /// Whether the file has the table.
    pub is_given: bool,
    /// The address of EtherNet/IP over TLS; `None`: off.
    pub tls: Option<SocketAddr>,
    /// The file with the certificates of the server.
    pub certificate: String,
    /// The file with the private key.
    pub key: String,
    /// The file with the authorities of clients.
    pub clients: String,
    /// The file with the lists of revoked certificates.
    pub revoked: Option<String>,
    /// Whether the server checks the days of a certificate's validity.
    pub check_expiration: bool,
    /// EtherNet/IP without TLS.
    pub plain: PlainAccess,
    /// Whether the server refuses class 0 and 1 connections that are opened through TLS, and whose data is not encrypted.
    pub refuses_io_over_tls: bool,
    /// The role of a certificate that has no row.
    pub default_role: Role,
    /// The roles of certificates.
    pub certificates: Vec<CertificateRole>,
    /// The role of clients on this computer.
    pub loopback: Role,
    /// The role of clients elsewhere, without TLS.
    pub remote_plain: Role,
    /// The address of the web page over HTTPS; `None`: off.
    pub hmi_tls: Option<SocketAddr>,
    /// Names of the host by which browsers reach the page, beside those of the certificate.
    pub hmi_names: Vec<String>,
    /// The notice of the page beside its log-in.
    pub login_notice: Option<String>,
    /// The file with the users of the page and the tokens of scripts; `None`: there are no log-ins.
    pub users: Option<String>,
    /// Time without a person at the page after which its session is locked, s.
    pub idle: u32,
    /// The longest session of the page, s.
    pub session: u32,
    /// The addresses that may reach EtherNet/IP without TLS.
    pub plain_allow: AllowList,
    /// The addresses that may reach EtherNet/IP over TLS.
    pub tls_allow: AllowList,
    /// The addresses that may reach the web page.
    pub hmi_allow: AllowList,
    /// The most requests a second of one EtherNet/IP client, by its role; 0: any number.
    pub max_requests: [u32; 4],
}

impl Security {
    /// The most requests a second of an EtherNet/IP client; 0: any number.
    pub fn max_requests_of(&self, role: Role) -> u32 {
        let [viewer, operator, engineer, administrator] = self.max_requests;
        match role {
            Role::Viewer => viewer,
            Role::Operator => operator,
            Role::Engineer => engineer,
            Role::Administrator => administrator,
        }
    }
}

impl Default for Security {
    /// The security of a file without the table.
    fn default() -> Self {
        ServerConfig::default().security
    }
}
