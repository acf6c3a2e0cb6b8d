//! `identify`: the identity of the server, or of all devices that answer a broadcast.

use std::time::Duration;

use serde_json::json;

use arcline_client::{Client, Identity as Server, discover as ask_everybody};

use super::args::Identify;
use super::{Failure, Output};

/// `identify`: all devices at a broadcast address, or the connected server.
pub(crate) async fn run(client: Option<&Client>, command: &Identify, output: &Output) -> Result<(), Failure> {
    if let Some(address) = &command.broadcast {
        return discover(address, command.wait, output).await;
    }
    if let Some(client) = client {
        let (address, identity) = client.identify().await?;
        show(&address.to_string(), &identity, output);
    }
    Ok(())
}

async fn discover(address: &str, seconds: f64, output: &Output) -> Result<(), Failure> {
    let wait = Duration::try_from_secs_f64(seconds).unwrap_or(Duration::from_secs(1));
    let port = arcline_client::DEFAULT_PORT;
    let address = if address.contains(':') {
        address.to_owned()
    } else {
        format!("{address}:{port}")
    };
    let found = ask_everybody(&address, wait).await?;
    for one in &found {
        show(&one.from.to_string(), &one.identity, output);
    }
    if found.is_empty() {
        output.note(&format!("no device answered at {address} within {seconds} s"));
    }
    Ok(())
}

fn show(address: &str, identity: &Server, output: &Output) {
    let Server {
        vendor,
        device_type,
        product_code,
        major,
        minor,
        serial,
        state,
        ..
    } = identity;
    let text = format!(
        "{address}  {}  revision {major}.{minor}  serial {serial:08X}  vendor 0x{vendor:04X}  type 0x{device_type:02X}  \
         product {product_code}  state {state}",
        identity.name()
    );
    output.result(text, || {
        json!({
            "address": address, "name": identity.name(), "revision": format!("{major}.{minor}"), "serial": serial,
            "vendor": vendor, "device_type": device_type, "product_code": product_code, "state": state,
        })
    });
}
