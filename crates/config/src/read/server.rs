//! The `[server]` table.

use std::net::{Ipv4Addr, SocketAddr};

use crate::error::{ConfigError, Problem};
use crate::section::Section;
use crate::{ConnectionLoss, IoListen, IoLoss, ServerConfig};

pub(super) fn server(root: &Section<'_>) -> Result<ServerConfig, ConfigError> {
    let (section, _) = root.table("server", SERVER, "a table, [server]")?;
    let mut config = ServerConfig::default();
    if let Some(name) = section.string("name", PRODUCT_NAME)? {
        let printable = name.value.chars().all(|c| c == ' ' || c.is_ascii_graphic());
        if name.value.trim().is_empty() || name.value.len() > MAX_PRODUCT_NAME || !printable {
            return Err(section.refuse(&name, PRODUCT_NAME, None));
        }
        config.name = name.value;
    }
    let mut listen = Vec::new();
    for given in section.one_or_more("listen", LISTEN, 1..=MAX_LISTEN)? {
        let address: SocketAddr = given.value.parse().map_err(|_| section.refuse(&given, LISTEN, None))?;
        if address.port() > 0 && listen.contains(&address) {
            return Err(section.refuse(&given, "an address that stands there once", None));
        }
        listen.push(address);
    }
    if let Some((first, also)) = listen.split_first() {
        config.listen = *first;
        config.listen_also = also.to_vec();
    }
    let most = |key| section.integer(key, 1..=MAX_CLIENTS, CLIENTS);
    config.max_clients = most("max_clients")?.unwrap_or(config.max_clients);
    config.max_clients_per_address = most("max_clients_per_address")?.unwrap_or(config.max_clients);
    config.max_connections = most("max_connections")?.unwrap_or(config.max_connections);
    config.max_connections_per_address = most("max_connections_per_address")?.unwrap_or(config.max_connections);
    if let Some(seconds) = section.integer("inactivity_timeout_s", 0..=3600, INACTIVITY)? {
        // At most 3600.
        config.inactivity_timeout = seconds as u16;
    }
    if let Some(hmi) = section.string("hmi", HMI)? {
        config.hmi = if hmi.value.eq_ignore_ascii_case("off") {
            None
        } else {
            Some(hmi.value.parse().map_err(|_| section.refuse(&hmi, HMI, None))?)
        };
    }
    if let Some(io) = section.string("io", IO)? {
        config.io = if io.value.eq_ignore_ascii_case("off") {
            IoListen::Off
        } else {
            IoListen::At(io.value.parse().map_err(|_| section.refuse(&io, IO, None))?)
        };
    }
    let words = IoLoss::WORDS.map(|(word, _)| word);
    if let Some((_, loss)) = section
        .word("io_loss", &words, IO_LOSS)?
        .and_then(|place| IoLoss::WORDS.get(place))
    {
        config.io_loss = *loss;
    }
    let words = ConnectionLoss::WORDS.map(|(word, _)| word);
    if let Some((_, loss)) = section
        .word("connection_loss", &words, CONNECTION_LOSS)?
        .and_then(|place| ConnectionLoss::WORDS.get(place))
    {
        config.connection_loss = *loss;
    }
    if let Some(silence) = section.integer("jog_silence_ms", 0..=60_000, JOG_SILENCE)? {
        if (1..MIN_JOG_SILENCE).contains(&silence) {
            let problem = Problem::Value {
                found: section.found("jog_silence_ms"),
                expected: JOG_SILENCE,
                suggestion: None,
            };
            return Err(section.refuse_key("jog_silence_ms", problem));
        }
        // At most 60,000.
        config.jog_silence = silence as u16;
    }
    Ok(config)
}

/// EtherNet/IP's own port.
pub(crate) const DEFAULT_LISTEN: SocketAddr = SocketAddr::new(std::net::IpAddr::V4(Ipv4Addr::LOCALHOST), 44_818);
/// The pages' port.
pub(crate) const DEFAULT_HMI: SocketAddr = SocketAddr::new(std::net::IpAddr::V4(Ipv4Addr::LOCALHOST), 8080);

/// The Identity object's Product Name is a SHORT_STRING of up to 32 characters.
const MAX_PRODUCT_NAME: usize = 32;

pub(super) const SERVER: &[&str] = &[
    "name",
    "listen",
    "hmi",
    "io",
    "io_loss",
    "connection_loss",
    "max_clients",
    "max_clients_per_address",
    "max_connections",
    "max_connections_per_address",
    "inactivity_timeout_s",
    "jog_silence_ms",
];

const MAX_LISTEN: usize = 16;
const MAX_CLIENTS: usize = 65_535;
const CLIENTS: &str = "a whole number from 1 to 65535";
const JOG_SILENCE: &str = "0, or a whole number from 100 to 60000 (ms)";
const MIN_JOG_SILENCE: usize = 100;
const INACTIVITY: &str = "a whole number from 0 to 3600 (s)";

const PRODUCT_NAME: &str = "1 to 32 printable ASCII characters";
const LISTEN: &str = "an address and port such as \"127.0.0.1:44818\", or a list of up to 16";
const IO: &str = "an address and port such as \"127.0.0.1:2222\", or \"off\"";
const IO_LOSS: &str = "\"stop\", \"hold\" or \"finish\"";
const CONNECTION_LOSS: &str = "\"jogs\", \"stop\", \"hold\" or \"finish\"";
const HMI: &str = "an address and port such as \"127.0.0.1:8080\", or \"off\"";
