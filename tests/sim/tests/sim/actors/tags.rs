//! Clients that read and write plain tags.

use std::time::{SystemTime, UNIX_EPOCH};

use arcline_proto::cip::{Reply, Request, service};
use arcline_proto::epath::{Epath, Segment};

use super::Stage;
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

pub(crate) async fn writer_1(stage: Stage) {
    writer(stage, 1_000_000).await;
}

pub(crate) async fn writer_2(stage: Stage) {
    writer(stage, 2_000_000).await;
}

async fn writer(mut stage: Stage, first: i32) {
    let mut next = first;
    while !stage.is_over() {
        let asked = stage.now();
        match stage.client().await {
            Ok(mut client) => {
                if let Err(error) = write_for_a_while(&mut stage, &mut client, &mut next).await {
                    stage.judge(asked, &error);
                } else if stage.chance(50) || stage.is_over() {
                    client.leave().await;
                }
            }
            Err(error) => stage.judge(asked, &error),
        }
        stage.pause(200).await;
    }
}

async fn write_for_a_while(stage: &mut Stage, client: &mut Client, next: &mut i32) -> Answer<()> {
    for _ in 0..20 + stage.random.below(100) {
        if stage.is_over() {
            break;
        }
        match stage.random.below(10) {
            0..=3 => write_one(stage, client, next).await?,
            4..=5 => write_pair(stage, client, next).await?,
            6 => write_refused(stage, client, next).await?,
            7 => read_pair(stage, client).await?,
            _ => read_one(stage, client).await?,
        }
        stage.pause(12).await;
    }
    Ok(())
}

/// The outcome of a write that was asked for at a time.
fn written(stage: &Stage, asked: u64, reply: &Reply) -> WriteAnswer {
    match reply.status.general() {
        0 => WriteAnswer::Persistent,
        0x19 => {
            stage.sometimes("a write that is not kept");
            if asked >= stage.common.quiet_from + RECOVERY {
                let why = format!("{}: a write is not kept though the disk works again", stage.name);
                stage.common.record.violated("W2", &why);
            }
            WriteAnswer::NotPersistent
        }
        _ => WriteAnswer::Refused,
    }
}

async fn write_one(stage: &mut Stage, client: &mut Client, next: &mut i32) -> Answer<()> {
    let tag = *stage.random.one_of(&TAGS);
    *next += 1;
    let value = *next;
    let asked = stage.now();
    stage.common.history.asks(tag, value);
    stage.asks(Kind::Write(tag));
    let reply = client.ask(&write(tag, DINT, 1, &value.to_le_bytes())).await?;
    stage.in_time(asked);
    let answer = written(stage, asked, &reply);
    if answer == WriteAnswer::Refused {
        let why = format!("{}: a write of {tag} was refused: {}", stage.name, reply.status);
        stage.common.record.violated("N1", &why);
    }
    stage.common.history.has(tag, value, answer);
    if answer != WriteAnswer::Refused {
        stage.answered(Kind::Write(tag));
    }
    stage.common.record.saw(stage.name, &reply.to_bytes());
    Ok(())
}

async fn write_pair(stage: &mut Stage, client: &mut Client, next: &mut i32) -> Answer<()> {
    *next += 1;
    let value = *next;
    // Both orders: the message is one action.
    let order = if stage.chance(50) { [0, 1] } else { [1, 0] };
    let requests = order.map(|index| write(PAIR[index], DINT, 1, &value.to_le_bytes()));
    for tag in PAIR {
        stage.asks(Kind::Write(tag));
        stage.common.history.asks(tag, value);
    }
    let asked = stage.now();
    let replies = client.ask_all(&requests).await?;
    stage.in_time(asked);
    let Some(replies) = replies else {
        stage.common.record.violated("N1", "a packet of writes was refused");
        return Ok(());
    };
    for (index, reply) in order.into_iter().zip(&replies) {
        let answer = written(stage, asked, reply);
        stage.common.history.has(PAIR[index], value, answer);
        if answer != WriteAnswer::Refused {
            stage.answered(Kind::Write(PAIR[index]));
        }
        stage.common.record.saw(stage.name, &reply.to_bytes());
    }
    Ok(())
}

/// Writes that must change nothing: of another type, of more elements than there are, and a packet with data that is cut.
async fn write_refused(stage: &mut Stage, client: &mut Client, next: &mut i32) -> Answer<()> {
    let tag = *stage.random.one_of(&TAGS);
    *next += 1;
    let value = *next;
    let bytes = value.to_le_bytes();
    let request = match stage.random.below(3) {
        0 => write(tag, REAL, 1, &bytes),
        1 => write(tag, DINT, 2, &[bytes, bytes].concat()),
        _ => write(tag, DINT, 1, &bytes[..3]),
    };
    stage.common.history.asks(tag, value);
    let reply = client.ask(&request).await?;
    if reply.status.is_success() {
        stage
            .common
            .record
            .violated("W3", "a write that does not fit its tag succeeded");
    }
    stage.sometimes("a refused write");
    stage.common.history.has(tag, value, WriteAnswer::Refused);
    stage.common.record.saw(stage.name, &reply.to_bytes());
    Ok(())
}

async fn read_one(stage: &mut Stage, client: &mut Client) -> Answer<()> {
    let tag = *stage.random.one_of(&TAGS);
    let (asked, sent) = (stage.common.history.clock(), stage.now());
    let reply = client.ask(&read(tag, 1)).await?;
    stage.in_time(sent);
    took_value(stage, tag, &reply, asked);
    Ok(())
}

fn took_value(stage: &Stage, tag: &'static str, reply: &Reply, asked: u64) {
    match dint(reply) {
        Some(value) => stage.common.history.read(tag, value, asked),
        None => stage
            .common
            .record
            .violated("N1", &format!("{tag} cannot be read: {}", reply.status)),
    }
    stage.common.record.saw(stage.name, &reply.to_bytes());
}

async fn read_pair(stage: &mut Stage, client: &mut Client) -> Answer<()> {
    let asked = stage.common.history.clock();
    let replies = client.ask_all(&PAIR.map(|tag| read(tag, 1))).await?;
    let Some([first, second]) = replies.as_deref() else {
        stage.common.record.violated("N1", "a packet of reads was refused");
        return Ok(());
    };
    took_value(stage, PAIR[0], first, asked);
    took_value(stage, PAIR[1], second, asked);
    if dint(first) != dint(second) {
        let why = format!(
            "a message that writes two tags was seen half: {:?} {:?}",
            dint(first),
            dint(second)
        );
        stage.common.record.violated("W1", &why);
    }
    Ok(())
}

/// Reads over a class 3 connection, and the tags that a reload adds.
pub(crate) async fn reader(mut stage: Stage) {
    let mut serial = 0;
    while !stage.is_over() {
        let asked = stage.now();
        match stage.client().await {
            Ok(mut client) => {
                serial += 1;
                if let Err(error) = read_connected(&mut stage, &mut client, serial).await {
                    stage.judge(asked, &error);
                } else {
                    client.leave().await;
                }
            }
            Err(error) => stage.judge(asked, &error),
        }
        stage.pause(100).await;
    }
}

async fn read_connected(stage: &mut Stage, client: &mut Client, serial: u16) -> Answer<()> {
    let Some(mut connected) = client.open(serial, stage.first_count()).await? else {
        stage.note("Forward Open was refused");
        return Ok(());
    };
    client.alive.push(stage.alive(connected.id()));
    stage.sometimes("a class 3 connection");
    for _ in 0..20 + stage.random.below(60) {
        if stage.is_over() {
            break;
        }
        let sent = stage.now();
        if stage.chance(5) {
            read_clock(stage, client, &mut connected).await?;
        } else if stage.chance(70) {
            let tag = *stage.random.one_of(&TAGS);
            let asked = stage.common.history.clock();
            let reply = client.ask_connected(&mut connected, &read(tag, 1)).await?;
            took_value(stage, tag, &reply, asked);
        } else {
            // A reload adds both or none.
            let request = packet(&["Extra1", "Extra2"].map(|tag| read(tag, 1)));
            let reply = client.ask_connected(&mut connected, &request).await?;
            let parts = arcline_proto::cip::split_multiple_replies(&reply.data).unwrap_or_default();
            let known: Vec<bool> = parts.iter().map(|part| value(part).is_some()).collect();
            match known[..] {
                [true, true] => stage.sometimes("the tags of a reload"),
                [false, false] => {}
                _ => stage
                    .common
                    .record
                    .violated("R1", &format!("a table between two: {known:?}")),
            }
            stage.common.record.saw(stage.name, &reply.to_bytes());
        }
        stage.in_time(sent);
        stage.pause(40).await;
    }
    if stage.chance(50) {
        client.close(connected).await?;
    }
    Ok(())
}

/// Reads the clock on the wall: it shows the server's, however that is set.
async fn read_clock(stage: &Stage, client: &mut Client, connected: &mut Connected) -> Answer<()> {
    // UTC, µs since 1970, of the class Wall Clock Time.
    let mut clock = Epath::object(0x8B, 1);
    clock.0.push(Segment::Attribute(6));
    let micros = || micros_since_1970(wall());
    let (asked, since) = (micros(), stage.now());
    let reply = client
        .ask_connected(
            connected,
            &Request::new(service::GET_ATTRIBUTE_SINGLE, clock, Vec::new()),
        )
        .await?;
    let (answered, took) = (micros(), stage.now() - since);
    let shown = reply
        .data
        .get(..8)
        .and_then(|bytes| bytes.try_into().ok())
        .map(u64::from_le_bytes);
    // Otherwise another client has set it meanwhile.
    let goes_on = answered == asked + 1000 * took;
    if goes_on && !shown.is_some_and(|shown| (asked..=answered).contains(&shown)) {
        let why = format!("the clock shows {shown:?}, between {asked} and {answered}");
        stage.common.record.violated("N1", &why);
    }
    stage.common.record.saw(stage.name, &reply.to_bytes());
    Ok(())
}

fn micros_since_1970(at: SystemTime) -> u64 {
    let since = at.duration_since(UNIX_EPOCH).unwrap_or_default();
    since.as_micros() as u64
}

/// Opens connections and falls silent, so that their watchdogs end them.
pub(crate) async fn polling(mut stage: Stage) {
    let mut serial = 100;
    while !stage.is_over() {
        let asked = stage.now();
        match stage.client().await {
            Ok(mut client) => {
                serial += 1;
                if let Err(error) = fall_silent(&mut stage, &mut client, serial).await {
                    stage.judge(asked, &error);
                }
            }
            Err(error) => stage.judge(asked, &error),
        }
        stage.pause(500).await;
    }
}

async fn fall_silent(stage: &mut Stage, client: &mut Client, serial: u16) -> Answer<()> {
    let Some(mut connected) = client.open(serial, stage.first_count()).await? else {
        return Ok(());
    };
    client.alive.push(stage.alive(connected.id()));
    for _ in 0..stage.random.below(10) {
        let reply = client.ask_connected(&mut connected, &read("D0", 1)).await?;
        stage.common.record.saw(stage.name, &reply.to_bytes());
        stage.pause(20).await;
    }
    // Its time-out is 2 s.
    if !stage.is_over() {
        stage.pause(3500).await;
        stage.sometimes("a silent connection");
    }
    // The session lives longer than its connection.
    let reply = client.ask(&read("D1", 1)).await?;
    stage.common.record.saw(stage.name, &reply.to_bytes());
    Ok(())
}
