//! Clients that only load the network: hostile ones, silent ones, ones that do not read.

use std::net::SocketAddr;
use std::time::Duration;

use arcline_proto::cip::Request;
use arcline_proto::cpf::ConnectionId;
use arcline_proto::epath::Epath;
use arcline_proto::io::{Datagram, IO_PORT};
use arcline_tests::random::Random;
use bytes::BytesMut;

use super::Environment;
use crate::client::{Answer, Client, DINT, NoAnswer, read, write};
use crate::network::Window;

/// Sends bytes that are no frames, frames of other sessions, and messages that no client sends.
pub(crate) async fn hostile(mut env: Environment) {
    let address = SocketAddr::new(env.ip().into(), IO_PORT);
    let random = Random(env.random.bits());
    let mut mailbox = env.common.post.open(address, env.weather, random);
    while !env.is_over() {
        // Datagrams of no connection, and forged ones of another client's.
        let mut bytes = BytesMut::new();
        let data: Vec<u8> = (0..env.random.below(40)).map(|_| env.random.bits() as u8).collect();
        let id = ConnectionId(env.common.some_alive());
        let sequence = env.random.bits() as u32;
        Datagram {
            id,
            sequence,
            data: &data,
        }
        .encode(&mut bytes);
        bytes.truncate(env.random.below(80) as usize);
        mailbox.send(&bytes);
        env.sometimes("a forged datagram");
        if env.chance(50) {
            let mut end = env.connect();
            let count = 1 + env.random.below(200);
            let bytes: Vec<u8> = (0..count).map(|_| env.random.bits() as u8).collect();
            let _ = tokio::io::AsyncWriteExt::write_all(&mut end, &bytes).await;
            env.pause(50).await;
            env.sometimes("bytes that are no frames");
            if env.chance(50) {
                end.cut();
            }
        } else if let Ok(mut client) = env.client().await {
            let _ = attack(&mut env, &mut client).await;
        }
        env.pause(100).await;
    }
}

async fn attack(env: &mut Environment, client: &mut Client) -> Answer<()> {
    for _ in 0..env.random.below(20) {
        match env.random.below(3) {
            0 => {
                let foreign = client.session() ^ (1 + env.random.below(1000) as u32);
                let answer = client
                    .ask_as(foreign, &write("D0", DINT, 1, &666_i32.to_le_bytes()))
                    .await;
                match answer {
                    Ok(reply) if reply.status.is_success() => {
                        env.common
                            .record
                            .violated("L4", "a frame with a foreign session handle was executed");
                    }
                    Ok(_) | Err(NoAnswer::Refused(_)) => env.sometimes("a foreign session handle"),
                    Err(error) => return Err(error),
                }
            }
            1 => {
                let data: Vec<u8> = (0..env.random.below(60)).map(|_| env.random.bits() as u8).collect();
                let class = *env.random.one_of(&[0x01, 0x02, 0x06, 0x6B, 0x301, 0x302, 0x303, 0x304]);
                // Such data reaches a service that changes the machine only in the whole layout of its request.
                let request = Request::new(env.random.below(0x30) as u8, Epath::object(class, 1), data);
                client.ask(&request).await?;
            }
            _ => {
                client.ask(&read("NoSuchTag", 1)).await?;
            }
        }
        env.pause(20).await;
    }
    Ok(())
}

/// Many that connect and say nothing.
pub(crate) async fn crowd(mut env: Environment) {
    let mut ends = Vec::new();
    while !env.is_over() {
        for _ in 0..env.random.below(6) {
            ends.push(env.connect());
        }
        if ends.len() > 10 {
            env.sometimes("a crowd of silent clients");
            match env.random.below(3) {
                0 => ends.clear(),
                1 => ends.drain(..).for_each(crate::network::End::cut),
                _ => {
                    let noticed = env.now() + 4000;
                    ends.drain(..).for_each(|end| end.vanish(noticed));
                }
            }
        }
        env.pause(700).await;
    }
}

/// Asks much and reads nothing.
pub(crate) async fn slow_reader(mut env: Environment) {
    while !env.is_over() {
        if let Ok(mut client) = env.client().await {
            client.end.stall(Window::Closed);
            for _ in 0..env.random.below(400) {
                if client.send_request(&read("Big", 100)).await.is_err() {
                    break;
                }
            }
            env.sometimes("a client that does not read");
            let ms = env.random.below(3000);
            tokio::time::sleep(Duration::from_millis(ms)).await;
            if env.chance(50) {
                client.end.stall(Window::Open);
            }
        }
        env.pause(1000).await;
    }
}

/// A connection that loses its bytes one way: the server receives no more, and learns of the loss late.
pub(crate) async fn half_open(mut env: Environment) {
    while !env.is_over() {
        if let Ok(mut client) = env.client().await {
            let _ = client.ask(&read("D0", 1)).await;
            client.end.mute(env.now() + 3000);
            let _ = client.ask(&read("D0", 1)).await;
            env.sometimes("a half-open connection");
        }
        env.pause(2000).await;
    }
}

/// Reads the table of tags.
pub(crate) async fn browser(mut env: Environment) {
    while !env.is_over() {
        if let Ok(mut client) = env.client().await {
            let mut from = 0;
            for _ in 0..5 {
                // Get Instance Attribute List of class 0x6B: names and types.
                let request = Request::new(0x55, Epath::object(0x6B, from), vec![2, 0, 1, 0, 2, 0]);
                match client.ask(&request).await {
                    Ok(reply) if !reply.data.is_empty() => from += 20,
                    Ok(_) | Err(_) => break,
                }
            }
            env.sometimes("the table of tags is read");
            client.leave().await;
        }
        env.pause(1500).await;
    }
}
