//! The `[server]` table.

use std::net::{Ipv4Addr, SocketAddr};

use super::security;
use crate::section::Section;
use crate::{ConnectionLoss, ControllerConfig, IoListen, IoLoss, MessageAnswer, ServerConfig, WireConfig};

pub(super) fn server(root: &Section<'_>) -> ServerConfig {
    let (section, _) = root.table("server");
    let default = ServerConfig::default();
    let mut listen = Vec::new();
    for given in section.texts("listen") {
        let Ok(address) = given.value.parse::<SocketAddr>() else {
            continue;
        };
        if address.port() > 0 && listen.contains(&address) {
            section.refuse_as(&given, "an address that stands there once", None);
        }
        listen.push(address);
    }
    let (first, also) = listen.split_first().unwrap_or((&default.listen, &[]));
    let max_clients = section.integer("max_clients").unwrap_or(default.max_clients);
    let max_connections = section.integer("max_connections").unwrap_or(default.max_connections);
    let io_loss = section.word("io_loss");
    let connection_loss = section.word("connection_loss");
    // Both fit: the table of keys bounds them.
    let short = |key| section.integer(key).unwrap_or_default() as u16;
    ServerConfig {
        name: section.text_or_default("name"),
        listen: *first,
        listen_also: also.to_vec(),
        max_clients,
        max_clients_per_address: section.integer("max_clients_per_address").unwrap_or(max_clients),
        max_connections,
        max_connections_per_address: section
            .integer("max_connections_per_address")
            .unwrap_or(max_connections),
        inactivity_timeout: short("inactivity_timeout_s"),
        hmi: section.text_or_default("hmi").parse().ok(),
        io: match section.text("io").map(|io| io.value.parse()) {
            None => IoListen::BesideListen,
            Some(Ok(address)) => IoListen::At(address),
            Some(Err(_)) => IoListen::Off,
        },
        io_loss: IoLoss::of_word(io_loss.unwrap_or_default()),
        connection_loss: ConnectionLoss::of_word(connection_loss.unwrap_or_default()),
        jog_silence: short("jog_silence_ms"),
        security: security(root),
        controller: controller(root),
    }
}

fn controller(root: &Section<'_>) -> ControllerConfig {
    let (section, _) = root.table("controller");
    ControllerConfig {
        program: section.text("program").map(|file| file.value),
        begins_stopped: section.word("mode") == Some("program"),
        allow_missing: section.boolean("allow_missing").unwrap_or_default(),
        messages: section.tables("messages").iter().map(message).collect(),
        wires: section.tables("wire").iter().map(wire).collect(),
    }
}

fn wire(row: &Section<'_>) -> WireConfig {
    let delay = row.integer("delay_ms").and_then(|number| u32::try_from(number).ok());
    WireConfig {
        from: row.text_or_default("from"),
        to: row.text_or_default("to"),
        delay_ms: delay.unwrap_or_default(),
    }
}

fn message(row: &Section<'_>) -> MessageAnswer {
    let small = |key| row.integer(key).and_then(|number| u16::try_from(number).ok());
    let large = |key| row.integer(key).and_then(|number| u32::try_from(number).ok());
    let answer = row.text("answer").and_then(|text| hex_bytes(&text.value));
    MessageAnswer {
        service: row
            .integer("service")
            .and_then(|code| u8::try_from(code).ok())
            .unwrap_or_default(),
        class: small("class").unwrap_or_default(),
        instance: large("instance"),
        attribute: small("attribute"),
        answer: answer.unwrap_or_default(),
        delay_ms: large("delay_ms").unwrap_or_default(),
        error: (small("err").unwrap_or_default(), large("exerr").unwrap_or_default()),
    }
}

/// Bytes in hexadecimal, with blanks between them or without.
pub(crate) fn hex_bytes(text: &str) -> Option<Vec<u8>> {
    let digits: Vec<u8> = text.bytes().filter(|byte| *byte != b' ').collect();
    let pairs = digits.chunks(2).map(|pair| {
        let pair = std::str::from_utf8(pair).ok().filter(|pair| pair.len() == 2)?;
        pair.bytes().all(|digit| digit.is_ascii_hexdigit()).then_some(())?;
        u8::from_str_radix(pair, 16).ok()
    });
    pairs.collect()
}

/// EtherNet/IP's own port.
pub(crate) const DEFAULT_LISTEN: SocketAddr = SocketAddr::new(std::net::IpAddr::V4(Ipv4Addr::LOCALHOST), 44_818);
/// The pages' port.
pub(crate) const DEFAULT_HMI: SocketAddr = SocketAddr::new(std::net::IpAddr::V4(Ipv4Addr::LOCALHOST), 8080);
