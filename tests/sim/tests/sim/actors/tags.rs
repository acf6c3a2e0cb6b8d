//! Clients that read and write plain tags.

use std::time::{SystemTime, UNIX_EPOCH};

use arcline_proto::cip::{Reply, Request, service};
use arcline_proto::epath::{Epath, Segment};

use super::Environment;
use crate::client::{Answer, Client, Connected, DINT, REAL, dint, packet, read, value, write};
use crate::history::WriteAnswer;
use crate::ledger::Kind;
use crate::world::wall;

/// The tags that are written with unique values.
pub(crate) const TAGS: [&str; 4] = ["D0", "D1", "D2", "D3"];
/// Two tags that are always written in one message, with the same value.
pub(crate) const PAIR: [&str; 2] = ["P0", "P1"];
/// The longest time until the file has the state again after the disk works again, ms: the writer tries after a second, and synchronises twice.
const RECOVERY: u64 = 1_200;

pub(crate) async fn writer_1(env: Environment) {
    writer(env, 1_000_000).await;
}

pub(crate) async fn writer_2(env: Environment) {
    writer(env, 2_000_000).await;
}

async fn writer(mut env: Environment, first: i32) {
    let mut next = first;
    while !env.is_over() {
        let asked = env.now();
        match env.client().await {
            Ok(mut client) => {
                if let Err(error) = write_for_a_while(&mut env, &mut client, &mut next).await {
                    env.judge(asked, &error);
                } else if env.chance(50) || env.is_over() {
                    client.leave().await;
                }
            }
            Err(error) => env.judge(asked, &error),
        }
        env.pause(200).await;
    }
}

async fn write_for_a_while(env: &mut Environment, client: &mut Client, next: &mut i32) -> Answer<()> {
    for _ in 0..20 + env.random.below(100) {
        if env.is_over() {
            break;
        }
        match env.random.below(10) {
            0..=3 => write_one(env, client, next).await?,
            4..=5 => write_pair(env, client, next).await?,
            6 => write_refused(env, client, next).await?,
            7 => read_pair(env, client).await?,
            _ => read_one(env, client).await?,
        }
        env.pause(12).await;
    }
    Ok(())
}

/// The outcome of a write that was asked for at a time.
fn written(env: &Environment, asked: u64, reply: &Reply) -> WriteAnswer {
    match reply.status.general() {
        0 => WriteAnswer::Persistent,
        0x19 => {
            env.sometimes("a write that is not kept");
            if asked >= env.common.quiet_from + RECOVERY {
                let why = format!("{}: a write is not kept though the disk works again", env.name);
                env.common.record.violated("W2", &why);
            }
            WriteAnswer::NotPersistent
        }
        _ => WriteAnswer::Refused,
    }
}

async fn write_one(env: &mut Environment, client: &mut Client, next: &mut i32) -> Answer<()> {
    let tag = *env.random.one_of(&TAGS);
    *next += 1;
    let value = *next;
    let asked = env.now();
    env.common.history.asks(tag, value);
    env.asks(Kind::Write(tag));
    let reply = client.ask(&write(tag, DINT, 1, &value.to_le_bytes())).await?;
    let answer = written(env, asked, &reply);
    if answer == WriteAnswer::Refused {
        let why = format!("{}: a write of {tag} was refused: {}", env.name, reply.status);
        env.common.record.violated("N1", &why);
    }
    env.common.history.has(tag, value, answer);
    if answer != WriteAnswer::Refused {
        env.answered(Kind::Write(tag));
    }
    env.common.record.saw(env.name, &reply.to_bytes());
    Ok(())
}

async fn write_pair(env: &mut Environment, client: &mut Client, next: &mut i32) -> Answer<()> {
    *next += 1;
    let value = *next;
    // Both orders: the message is one action.
    let order = if env.chance(50) { [0, 1] } else { [1, 0] };
    let requests = order.map(|index| write(PAIR[index], DINT, 1, &value.to_le_bytes()));
    for tag in PAIR {
        env.asks(Kind::Write(tag));
        env.common.history.asks(tag, value);
    }
    let asked = env.now();
    let replies = client.ask_all(&requests).await?;
    let Some(replies) = replies else {
        env.common.record.violated("N1", "a packet of writes was refused");
        return Ok(());
    };
    for (index, reply) in order.into_iter().zip(&replies) {
        let answer = written(env, asked, reply);
        env.common.history.has(PAIR[index], value, answer);
        if answer != WriteAnswer::Refused {
            env.answered(Kind::Write(PAIR[index]));
        }
        env.common.record.saw(env.name, &reply.to_bytes());
    }
    Ok(())
}

/// Writes that must change nothing: of another type, of more elements than there are, and a packet with data that is cut.
async fn write_refused(env: &mut Environment, client: &mut Client, next: &mut i32) -> Answer<()> {
    let tag = *env.random.one_of(&TAGS);
    *next += 1;
    let value = *next;
    let bytes = value.to_le_bytes();
    let request = match env.random.below(3) {
        0 => write(tag, REAL, 1, &bytes),
        1 => write(tag, DINT, 2, &[bytes, bytes].concat()),
        _ => write(tag, DINT, 1, &bytes[..3]),
    };
    env.common.history.asks(tag, value);
    let reply = client.ask(&request).await?;
    if reply.status.is_success() {
        env.common
            .record
            .violated("W3", "a write that does not fit its tag succeeded");
    }
    env.sometimes("a refused write");
    env.common.history.has(tag, value, WriteAnswer::Refused);
    env.common.record.saw(env.name, &reply.to_bytes());
    Ok(())
}

async fn read_one(env: &mut Environment, client: &mut Client) -> Answer<()> {
    let tag = *env.random.one_of(&TAGS);
    let asked = env.common.history.clock();
    let reply = client.ask(&read(tag, 1)).await?;
    took_value(env, tag, &reply, asked);
    Ok(())
}

fn took_value(env: &Environment, tag: &'static str, reply: &Reply, asked: u64) {
    match dint(reply) {
        Some(value) => env.common.history.read(tag, value, asked),
        None => env
            .common
            .record
            .violated("N1", &format!("{tag} cannot be read: {}", reply.status)),
    }
    env.common.record.saw(env.name, &reply.to_bytes());
}

async fn read_pair(env: &mut Environment, client: &mut Client) -> Answer<()> {
    let asked = env.common.history.clock();
    let replies = client.ask_all(&PAIR.map(|tag| read(tag, 1))).await?;
    let Some([first, second]) = replies.as_deref() else {
        env.common.record.violated("N1", "a packet of reads was refused");
        return Ok(());
    };
    took_value(env, PAIR[0], first, asked);
    took_value(env, PAIR[1], second, asked);
    if dint(first) != dint(second) {
        let why = format!(
            "a message that writes two tags was seen half: {:?} {:?}",
            dint(first),
            dint(second)
        );
        env.common.record.violated("W1", &why);
    }
    Ok(())
}

/// Reads over a class 3 connection, and the tags that a reload adds.
pub(crate) async fn reader(mut env: Environment) {
    let mut serial = 0;
    while !env.is_over() {
        env.session(async |env, client| {
            serial += 1;
            read_connected(env, client, serial).await
        })
        .await;
        env.pause(100).await;
    }
}

async fn read_connected(env: &mut Environment, client: &mut Client, serial: u16) -> Answer<()> {
    let Some(mut connected) = client.open(serial, env.first_count()).await? else {
        env.note("Forward Open was refused");
        return Ok(());
    };
    client.alive.push(env.alive(connected.id()));
    env.sometimes("a class 3 connection");
    for _ in 0..20 + env.random.below(60) {
        if env.is_over() {
            break;
        }
        if env.chance(5) {
            read_clock(env, client, &mut connected).await?;
        } else if env.chance(70) {
            let tag = *env.random.one_of(&TAGS);
            let asked = env.common.history.clock();
            let reply = client.ask_connected(&mut connected, &read(tag, 1)).await?;
            took_value(env, tag, &reply, asked);
        } else {
            // A reload adds both or none.
            let request = packet(&["Extra1", "Extra2"].map(|tag| read(tag, 1)));
            let reply = client.ask_connected(&mut connected, &request).await?;
            let parts = arcline_proto::cip::split_multiple_replies(&reply.data).unwrap_or_default();
            let known: Vec<bool> = parts.iter().map(|part| value(part).is_some()).collect();
            match known[..] {
                [true, true] => env.sometimes("the tags of a reload"),
                [false, false] => {}
                _ => env
                    .common
                    .record
                    .violated("R1", &format!("a table between two: {known:?}")),
            }
            env.common.record.saw(env.name, &reply.to_bytes());
        }
        env.pause(40).await;
    }
    if env.chance(50) {
        client.close(connected).await?;
    }
    Ok(())
}

/// Reads the clock on the wall: it shows the server's, however that is set.
async fn read_clock(env: &Environment, client: &mut Client, connected: &mut Connected) -> Answer<()> {
    // UTC, µs since 1970, of the class Wall Clock Time.
    let mut clock = Epath::object(0x8B, 1);
    clock.0.push(Segment::Attribute(6));
    let micros = || micros_since_1970(wall());
    let (asked, since) = (micros(), env.now());
    let reply = client
        .ask_connected(
            connected,
            &Request::new(service::GET_ATTRIBUTE_SINGLE, clock, Vec::new()),
        )
        .await?;
    let (answered, took) = (micros(), env.now() - since);
    let shown = reply
        .data
        .get(..8)
        .and_then(|bytes| bytes.try_into().ok())
        .map(u64::from_le_bytes);
    // Otherwise another client has set it meanwhile.
    let goes_on = answered == asked + 1000 * took;
    if goes_on && !shown.is_some_and(|shown| (asked..=answered).contains(&shown)) {
        let why = format!("the clock shows {shown:?}, between {asked} and {answered}");
        env.common.record.violated("N1", &why);
    }
    env.common.record.saw(env.name, &reply.to_bytes());
    Ok(())
}

fn micros_since_1970(at: SystemTime) -> u64 {
    let since = at.duration_since(UNIX_EPOCH).unwrap_or_default();
    since.as_micros() as u64
}

/// Opens connections and falls silent, so that their watchdogs end them.
pub(crate) async fn polling(mut env: Environment) {
    let mut serial = 100;
    while !env.is_over() {
        let asked = env.now();
        match env.client().await {
            Ok(mut client) => {
                serial += 1;
                if let Err(error) = fall_silent(&mut env, &mut client, serial).await {
                    env.judge(asked, &error);
                }
            }
            Err(error) => env.judge(asked, &error),
        }
        env.pause(500).await;
    }
}

/// Repeats a sequence count, opens a connection a second time, or closes one that is not open: nothing is executed (L4).
async fn be_wrong(
    env: &mut Environment,
    client: &mut Client,
    connected: &Connected,
    serial: u16,
    last: &Reply,
) -> Answer<()> {
    let asked = env.now();
    let (what, is_refused) = match env.random.below(3) {
        // The value is no writer's: W1 is broken if it is written.
        0 => {
            let request = write("D0", DINT, 1, &667_i32.to_le_bytes());
            let again = client.ask_with_last_count(connected, &request).await?;
            ("a repeated sequence count", again.to_bytes() == last.to_bytes())
        }
        1 => {
            let second = client.open(serial, 0).await?;
            ("a second connection of one serial number", second.is_none())
        }
        _ => {
            let is_refused = client.is_close_refused(connected, !serial).await?;
            ("an end of no connection", is_refused)
        }
    };
    env.sometimes(what);
    // Behind a partition the connection itself has timed out.
    if !is_refused && env.now() < asked + 1000 {
        env.common.record.violated("L4", &format!("{what} was executed"));
    }
    Ok(())
}

async fn fall_silent(env: &mut Environment, client: &mut Client, serial: u16) -> Answer<()> {
    let Some(mut connected) = client.open(serial, env.first_count()).await? else {
        return Ok(());
    };
    client.alive.push(env.alive(connected.id()));
    for _ in 0..env.random.below(10) {
        let reply = client.ask_connected(&mut connected, &read("D0", 1)).await?;
        env.common.record.saw(env.name, &reply.to_bytes());
        if env.chance(20) {
            be_wrong(env, client, &connected, serial, &reply).await?;
        }
        env.pause(20).await;
    }
    // Its time-out is 2 s.
    if !env.is_over() {
        env.pause(3500).await;
        env.sometimes("a silent connection");
    }
    // The session lives longer than its connection.
    let reply = client.ask(&read("D1", 1)).await?;
    env.common.record.saw(env.name, &reply.to_bytes());
    Ok(())
}
