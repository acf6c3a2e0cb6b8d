//! Reads, writes and lists tags: `cargo run -p arcline-client --example tags -- 127.0.0.1`.

use arcline_client::{Client, ClientError};

#[tokio::main]
async fn main() -> Result<(), ClientError> {
    let server = std::env::args().nth(1).unwrap_or_else(|| "127.0.0.1".to_owned());
    run(&server).await?;
    Ok(())
}

/// Returns how many tags the server has.
pub(crate) async fn run(server: &str) -> Result<usize, ClientError> {
    let client = Client::connect(server).await?;
    let tags = client.browse().await?;
    for tag in tags.iter().take(10) {
        println!("{}: {}", tag.name, tag.type_name());
    }
    // One value, several in one request, and an array.
    println!("X is at {}", client.read("X.ActualPosition").await?);
    for value in client.read_many(&["Y.ActualPosition", "CS1.MoveStatus"]).await? {
        println!("{}", value?);
    }
    client.write("Move1.Speed", 50.0).await?;
    client.write("Move1.Position", vec![100.0, 50.0, 0.0]).await?;
    println!("Move1.Position: {:?}", client.read_numbers("Move1.Position").await?);
    client.close().await;
    Ok(tags.len())
}
