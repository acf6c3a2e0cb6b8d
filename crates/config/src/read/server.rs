//! The `[server]` table.

use std::net::{Ipv4Addr, SocketAddr};

use crate::error::ConfigError;
use crate::section::Section;
use crate::{IoListen, IoLoss, ServerConfig};

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
    if let Some(listen) = section.string("listen", LISTEN)? {
        config.listen = listen
            .value
            .parse()
            .map_err(|_| section.refuse(&listen, LISTEN, None))?;
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
    Ok(config)
}

/// EtherNet/IP's own port.
pub(crate) const DEFAULT_LISTEN: SocketAddr = SocketAddr::new(std::net::IpAddr::V4(Ipv4Addr::LOCALHOST), 44_818);
/// The pages' port.
pub(crate) const DEFAULT_HMI: SocketAddr = SocketAddr::new(std::net::IpAddr::V4(Ipv4Addr::LOCALHOST), 8080);

/// The Identity object's Product Name is a SHORT_STRING of up to 32 characters.
const MAX_PRODUCT_NAME: usize = 32;

pub(super) const SERVER: &[&str] = &["name", "listen", "hmi", "io", "io_loss"];

const PRODUCT_NAME: &str = "1 to 32 printable ASCII characters";
const LISTEN: &str = "an address and port such as \"127.0.0.1:44818\"";
const IO: &str = "an address and port such as \"127.0.0.1:2222\", or \"off\"";
const IO_LOSS: &str = "\"stop\", \"hold\" or \"finish\"";
const HMI: &str = "an address and port such as \"127.0.0.1:8080\", or \"off\"";
