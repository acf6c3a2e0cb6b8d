//! The examples of the client library (`client/examples`), run against a server.

use arcline_client::Client;
use arcline_system_tests::server::Server;

#[allow(dead_code, reason = "an example has a main function")]
#[path = "../../../../client/examples/motion.rs"]
mod motion;
#[allow(dead_code, reason = "an example has a main function")]
#[path = "../../../../client/examples/program.rs"]
mod program;
#[allow(dead_code, reason = "an example has a main function")]
#[path = "../../../../client/examples/tags.rs"]
mod tags;

#[tokio::test]
async fn tags_are_listed_read_and_written() {
    let server = Server::start();
    let count = tags::run(&server.address().to_string()).await.expect("a server");
    assert!(count > 10, "{count} tags");
}

#[tokio::test]
async fn a_move_ends_at_its_position() {
    let server = Server::start();
    let position = motion::run(&server.address().to_string()).await.expect("a server");
    assert!((position - 20.0).abs() < 1e-9, "{position}");
}

#[tokio::test]
async fn a_program_executes_its_instructions() {
    let server = Server::start();
    let address = server.address().to_string();
    let client = Client::connect(&address).await.expect("a server");
    assert_eq!(program::run(&client).await.expect("a program that runs"), 2);
    let position = client.read_numbers("X.CommandPosition").await.expect("a tag")[0];
    assert!((position - 20.0).abs() < 1e-9, "{position}");
}
