//! Moves the coordinate system CS1 along a line and waits for its end: `cargo run -p arcline-client --example motion -- 127.0.0.1`.

use std::time::Duration;

use arcline_client::{Client, ClientError, Flag, Mnemonic, Operands};

#[tokio::main]
async fn main() -> Result<(), ClientError> {
    let server = std::env::args().nth(1).unwrap_or_else(|| "127.0.0.1".to_owned());
    run(&server).await?;
    Ok(())
}

/// Returns the position of the axis X after the move.
pub(crate) async fn run(server: &str) -> Result<f64, ClientError> {
    let client = Client::connect(server).await?;
    let operands = Operands::full_speed(Mnemonic::Mclm)
        .with("Position", vec![20.0, 10.0, 0.0])?
        .with("Speed", 100.0)?;
    let execution = client.execute(Mnemonic::Mclm, "CS1", "", operands.as_slice()).await?;
    // PC: the process is complete, the axes have their position.
    client.wait_for(&execution, Flag::Pc, Duration::from_secs(60)).await?;
    let position = client.read_numbers("X.CommandPosition").await?[0];
    println!("X is at {position}");
    client.close().await;
    Ok(position)
}
