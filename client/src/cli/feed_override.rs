//! `override`, `hold`, `resume`.

use serde_json::json;

use arcline_client::Client;

use super::args::{Override, System};
use super::{Failure, Output};

/// `override`.
pub(crate) async fn set(client: &Client, command: &Override, output: &Output) -> Result<(), Failure> {
    take(client, &command.system.name, command.percent.0, output).await
}

/// `hold`.
pub(crate) async fn hold(client: &Client, command: &System, output: &Output) -> Result<(), Failure> {
    take(client, &command.name, 0.0, output).await
}

/// `resume`: as it was before the hold.
pub(crate) async fn resume(client: &Client, command: &System, output: &Output) -> Result<(), Failure> {
    let percent = client.feed_override_before_hold(&command.name).await?;
    take(client, &command.name, percent, output).await
}

async fn take(client: &Client, system: &str, percent: f64, output: &Output) -> Result<(), Failure> {
    client.set_feed_override(system, percent).await?;
    let text = if percent == 0.0 {
        format!("{system} held")
    } else {
        format!("{system} at {percent}% of the programmed speed")
    };
    output.result(text, || json!({"name": system, "override": percent}));
    Ok(())
}
