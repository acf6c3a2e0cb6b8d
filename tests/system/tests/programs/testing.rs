//! The server that tests of users start (`arcline-testing`).

use std::collections::BTreeSet;
use std::net::TcpStream;

use arcline_system_tests::programs::arcline_server;
use arcline_testing::{Server, SpawnError};
use arcline_tests::random::is_long;

/// 50 of them in a long run.
#[test]
fn many_servers_run_beside_each_other_and_end_in_order() {
    let spawn = || Server::builder().program(arcline_server()).spawn();
    let count = if is_long() { 50 } else { 12 };
    let servers: Vec<Server> = std::thread::scope(|scope| {
        let threads: Vec<_> = (0..count).map(|_| scope.spawn(spawn)).collect();
        let joined = threads
            .into_iter()
            .map(|thread| thread.join().expect("no thread panics"));
        joined
            .map(|server| server.unwrap_or_else(|error| panic!("{error}")))
            .collect()
    });
    let addresses: BTreeSet<_> = servers.iter().map(Server::eip).collect();
    assert_eq!(addresses.len(), count);
    for server in &servers {
        TcpStream::connect(server.eip()).expect("a server that is ready accepts connections");
        TcpStream::connect(server.hmi().expect("it has a page")).expect("its page too");
    }
    for server in servers {
        let address = server.eip();
        let ended = server.stop().expect("it ends by itself");
        assert!(ended.success(), "{ended}");
        assert!(
            TcpStream::connect(address).is_err(),
            "nobody listens at {address} any more"
        );
    }
}

#[test]
fn a_server_that_does_not_start_says_why() {
    let folder = tempfile::tempdir().expect("a folder");
    let config = folder.path().join("wrong.toml");
    std::fs::write(&config, "[[axis]]\nname = 5\n").expect("a file");
    let wrong = Server::builder().program(arcline_server()).config(&config).spawn();
    let Err(SpawnError::NotReady { said }) = wrong else {
        panic!("{wrong:?}");
    };
    assert!(said.contains("wrong.toml:1:1"), "{said}");
    let nowhere = Server::builder().program(folder.path().join("nowhere")).spawn();
    assert!(matches!(nowhere, Err(SpawnError::Start { .. })), "{nowhere:?}");
    let clock = Server::builder().program(arcline_server()).clock("sideways").spawn();
    let Err(SpawnError::NotReady { said }) = clock else {
        panic!("{clock:?}");
    };
    assert!(said.contains("expected real, step, fast"), "{said}");
    let program = Server::builder()
        .program(arcline_server())
        .clock("step")
        .argument(arcline_system_tests::fixture("config/Cell.L5X"))
        .spawn();
    let Err(SpawnError::NotReady { said }) = program else {
        panic!("{program:?}");
    };
    assert!(
        said.contains("--clock step: the tasks of a project follow real time"),
        "{said}"
    );
}
