//! Steps of the clock whose client goes.

use std::net::SocketAddr;
use std::time::Instant;

use arcline_realtime::Clock;
use tokio::net::TcpStream;

use super::super::listener::Listener;
use super::*;

/// A client of a real socket with a session.
async fn registered(address: SocketAddr) -> (TcpStream, SessionHandle) {
    let mut stream = TcpStream::connect(address).await.expect("a connection");
    let data = RegisterSession::CURRENT.to_bytes();
    let register = EncapFrame::request(Command::REGISTER_SESSION, SessionHandle(0), CONTEXT, data);
    stream.write_all(&register.to_bytes()).await.expect("sent");
    let mut reply = [0; 28];
    stream.read_exact(&mut reply).await.expect("a session");
    (
        stream,
        SessionHandle(u32::from_le_bytes([reply[4], reply[5], reply[6], reply[7]])),
    )
}

/// Asks for steps, and does not wait for the answer.
async fn ask_for_steps((stream, session): &mut (TcpStream, SessionHandle), ticks: i32) {
    let request = write("ClockStep", WireType::Atomic(0xC4), 1, &ticks.to_le_bytes());
    let message = request.to_bytes().expect("a short path");
    let packet = Packet::unconnected(message).to_bytes();
    let frame = EncapFrame::request(Command::SEND_RR_DATA, *session, CONTEXT, packet);
    stream.write_all(&frame.to_bytes()).await.expect("sent");
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn steps_end_when_their_client_goes() {
    const LONG: i32 = 1_000_000;
    let project = project();
    let mut image = project.image();
    image.add_clock_step();
    let (plant, thread) = Plant::start_with(&project, image, None, Clock::Step).expect("a thread");
    let any = SocketAddr::from(([127, 0, 0, 1], 0));
    let listener = Listener::bind(any, plant.clone(), settings_of("Stepped"))
        .await
        .expect("a port");
    let address = listener.local_addr();
    let server = tokio::spawn(listener.serve());

    let mut stepping = registered(address).await;
    ask_for_steps(&mut stepping, LONG).await;
    let began = Instant::now();
    while plant.health().ticks == 0 {
        assert!(began.elapsed() < PATIENCE, "no tick passes");
        tokio::time::sleep(Duration::from_millis(1)).await;
    }
    // One waits for its turn, with more requests behind than the server reads meanwhile, and goes first.
    let mut waiting = registered(address).await;
    for _ in 0..200 {
        ask_for_steps(&mut waiting, LONG).await;
    }
    drop(waiting);
    drop(stepping);

    let mut other = registered(address).await;
    ask_for_steps(&mut other, 1).await;
    let answer = tokio::time::timeout(PATIENCE, other.0.read_u8()).await;
    assert!(matches!(answer, Ok(Ok(_))), "{answer:?}");
    let passed = plant.health().ticks;
    assert!(passed < LONG as u64, "{passed} ticks");
    tokio::time::sleep(Duration::from_millis(50)).await;
    assert_eq!(plant.health().ticks, passed, "no further ticks");
    server.abort();
    thread.stop();
}
