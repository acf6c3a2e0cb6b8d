//! `stop --hold` and `release`.

use serde_json::json;

use arcline_client::Client;

use super::{Failure, Output};

/// `stop --hold`.
pub(crate) async fn inhibit(client: &Client, output: &Output) -> Result<(), Failure> {
    client.inhibit_motion().await?;
    output.result(
        "motion is inhibited until `arcline release`",
        || json!({"motion_inhibited": true}),
    );
    Ok(())
}

/// `release`.
pub(crate) async fn release(client: &Client, output: &Output) -> Result<(), Failure> {
    client.release_motion().await?;
    output.result("motion is released", || json!({"motion_inhibited": false}));
    Ok(())
}
