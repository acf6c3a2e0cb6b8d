//! The clocks of a server (spec/contract.md §10): a multiple of real time, and steps beside time-outs that stay real.

use std::io::{ErrorKind, Read as _, Write as _};
use std::net::TcpStream;
use std::time::{Duration, Instant};

use arcline_client::Client;
use arcline_proto::cip::{Request, service};
use arcline_proto::epath::Epath;
use arcline_system_tests::programs::arcline_server;
use arcline_testing::Server;

fn server(clock: &str) -> Server {
    let server = Server::builder().program(arcline_server()).clock(clock).spawn();
    server.unwrap_or_else(|error| panic!("{error}"))
}

async fn client(server: &Server) -> Client {
    Client::connect(&server.eip().to_string())
        .await
        .expect("it accepts connections")
}

#[tokio::test]
async fn on_a_fast_clock_a_move_takes_its_part_of_real_time() {
    let server = server("fast:10");
    let client = client(&server).await;
    for (tag, value) in [("Move1.Position[0]", 100.0), ("Move1.Speed", 0.8)] {
        client.write(tag, value).await.expect(tag);
    }
    let began = Instant::now();
    client.write("Move1.EnableIn", true).await.expect("it executes");
    while client.read_numbers("Move1.PC").await.expect("a bit") != [1.0] {
        assert!(began.elapsed() < Duration::from_secs(60), "{}", server.log());
        tokio::time::sleep(Duration::from_millis(20)).await;
    }
    // 25 s at 0.8 % of 500 units/s, and the ramps.
    let took = began.elapsed().as_secs_f64();
    assert!((2.4..20.0).contains(&took), "25 s at ten times real time took {took} s");
    assert_eq!(
        client.read_numbers("X.CommandPosition").await.expect("a number"),
        [100.0]
    );
    client.close().await;
}

/// A session of EtherNet/IP that asks nothing.
fn silent_session(server: &Server) -> TcpStream {
    let mut stream = TcpStream::connect(server.eip()).expect("it accepts connections");
    let register = [&[0x65, 0, 4, 0][..], &[0; 20], &[1, 0, 0, 0]].concat();
    stream.write_all(&register).expect("it is sent");
    let mut answer = [0; 28];
    stream.read_exact(&mut answer).expect("a session");
    assert_eq!(answer[8..12], [0; 4], "registered");
    stream
}

#[tokio::test]
async fn on_the_step_clock_the_time_outs_of_connections_are_real() {
    const INACTIVITY: Duration = Duration::from_secs(6);
    let server = server("step");
    let client = client(&server).await;
    let request = Request {
        service: service::SET_ATTRIBUTE_SINGLE,
        path: Epath::attribute(0xF5, 1, 13),
        data: vec![6, 0].into(),
    };
    let reply = client.request(request).await.expect("an answer");
    assert!(reply.status.is_success(), "{reply:?}");
    let mut silent = silent_session(&server);
    let began = Instant::now();
    // Longer than that, but of simulated time.
    client.write("ClockStep", 9000).await.expect("ticks pass");
    silent
        .set_read_timeout(Some(Duration::from_millis(50)))
        .expect("a socket");
    let open = silent.read(&mut [0]);
    assert!(
        began.elapsed() < INACTIVITY,
        "the computer is too slow for this test: {:?}",
        began.elapsed()
    );
    let open = open.expect_err("no answer, and no end");
    assert!(
        matches!(open.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut),
        "{open}"
    );
    // And now of real time, in which no tick passes.
    silent
        .set_read_timeout(Some(Duration::from_secs(60)))
        .expect("a socket");
    assert_eq!(silent.read(&mut [0]).expect("its end"), 0, "closed");
    assert!(began.elapsed() > INACTIVITY.mul_f64(0.9), "{:?}", began.elapsed());
}
