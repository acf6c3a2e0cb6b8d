//! The `[server]` table.

use std::net::SocketAddr;

use super::security;
use crate::section::Section;
use crate::{ControllerConfig, IoListen, MessageAnswer, ServerConfig, WireConfig, words};

pub(super) fn server(root: &Section<'_>) -> ServerConfig {
    let (section, _) = root.table("server");
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
    if listen.is_empty() {
        listen.extend(section.default_address("listen"));
    }
    let mut listen = listen.into_iter();
    let max_clients = section.whole("max_clients");
    let max_connections = section.whole("max_connections");
    ServerConfig {
        name: section.text_or_default("name"),
        listen: listen.next().expect("its default is an address"),
        listen_also: listen.collect(),
        max_clients,
        max_clients_per_address: section.integer("max_clients_per_address").unwrap_or(max_clients),
        max_connections,
        max_connections_per_address: section
            .integer("max_connections_per_address")
            .unwrap_or(max_connections),
        inactivity_timeout: section.whole("inactivity_timeout_s"),
        hmi: section.address("hmi"),
        io: match section.text("io").map(|io| io.value.parse()) {
            None => IoListen::BesideListen,
            Some(Ok(address)) => IoListen::At(address),
            Some(Err(_)) => IoListen::Off,
        },
        io_loss: section.one_of("io_loss", words::IO_LOSS),
        connection_loss: section.one_of("connection_loss", words::CONNECTION_LOSS),
        jog_silence: section.whole("jog_silence_ms"),
        security: security(root),
        controller: controller(root),
    }
}

fn controller(root: &Section<'_>) -> ControllerConfig {
    let (section, _) = root.table("controller");
    ControllerConfig {
        program: section.text("program").map(|file| file.value),
        begins_stopped: section.one_of("mode", words::CONTROLLER_MODES),
        allow_missing: section.flag("allow_missing"),
        messages: section.tables("messages").iter().map(message).collect(),
        wires: section.tables("wire").iter().map(wire).collect(),
    }
}

fn wire(row: &Section<'_>) -> WireConfig {
    WireConfig {
        from: row.text_or_default("from"),
        to: row.text_or_default("to"),
        delay_ms: row.whole("delay_ms"),
    }
}

fn message(row: &Section<'_>) -> MessageAnswer {
    let answer = row.text("answer").and_then(|text| hex_bytes(&text.value));
    MessageAnswer {
        service: row.whole("service"),
        class: row.whole("class"),
        instance: row.integer("instance").and_then(|number| u32::try_from(number).ok()),
        attribute: row.integer("attribute").and_then(|number| u16::try_from(number).ok()),
        answer: answer.unwrap_or_default(),
        delay_ms: row.whole("delay_ms"),
        error: (row.whole("err"), row.whole("exerr")),
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
