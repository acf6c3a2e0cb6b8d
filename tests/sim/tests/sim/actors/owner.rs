//! The owner of the outputs of implicit I/O: it moves an axis, and is lost in each way in which an owner can be.

use std::net::SocketAddr;
use std::time::Duration;

use arcline_instruction_set::Mnemonic;
use arcline_proto::connection::{ConnectionKey, ForwardOpen, ForwardOpenReply, NetworkParameters, TickTime};
use arcline_proto::cpf::ConnectionId;
use arcline_proto::epath::{Epath, Segment};
use arcline_proto::io::{Datagram, IO_PORT};
use bytes::BytesMut;

use super::{Environment, Order};
use crate::client::{Answer, Client, instruction};
use crate::datagrams::Mailbox;
use crate::motion::Deadline;

/// The instance of axis C.
const C: u32 = 7;
/// Bytes of the assemblies of the machine: four coordinate systems and eight axes.
const INPUT_SIZE: u16 = 12 + 4 * 24 + 8 * 20;
const OUTPUT_SIZE: u16 = 4 + 4 * 4;
/// The connection points of the outputs and inputs, and the configuration (docs/IO.md).
const OUTPUT: u32 = 150;
const INPUT: u32 = 100;
const CONFIGURATION: u32 = 151;
/// Run, in the header of the outputs.
const RUN: u32 = 1;

/// Owns the outputs again and again.
pub(crate) async fn owner(mut env: Environment) {
    let mut serial = 0;
    while !env.is_over() {
        let asked = env.now();
        match env.client().await {
            Ok(mut client) => {
                serial += 1;
                match own(&mut env, &mut client, serial).await {
                    Err(error) => env.judge(asked, &error),
                    Ok(()) => client.leave().await,
                }
            }
            Err(error) => env.judge(asked, &error),
        }
        env.pause(600).await;
    }
}

/// An owner's connection.
struct Owned {
    id: ConnectionId,
    mailbox: Mailbox,
    sequence: u32,
    /// Between two datagrams, ms.
    interval: u64,
    /// Silence after which the connection ends, ms.
    timeout: u64,
    /// When the newest datagram arrives at the server, ms.
    heard: Option<u64>,
    /// When the server sent its newest datagram, ms.
    sent: u64,
    /// Its datagrams once arrived further apart than the time-out: the slow answers of its instructions were between them.
    paused: bool,
}

impl Owned {
    /// Sends outputs that command nothing, in run.
    fn produce(&mut self) {
        self.sequence = self.sequence.wrapping_add(1);
        let mut data = (self.sequence as u16).to_le_bytes().to_vec();
        data.extend(RUN.to_le_bytes());
        data.resize(2 + 4 + usize::from(OUTPUT_SIZE), 0);
        let mut bytes = BytesMut::new();
        let datagram = Datagram {
            id: self.id,
            sequence: self.sequence,
            data: &data,
        };
        datagram.encode(&mut bytes);
        if let Some(arrives) = self.mailbox.send(&bytes) {
            self.paused |= self.heard.is_some_and(|heard| arrives > heard + self.timeout);
            self.heard = Some(arrives);
        }
    }

    /// Whether the server still sends inputs, and has received outputs.
    fn is_open(&self, now: u64) -> bool {
        self.heard.is_some() && now <= self.sent + 3 * self.interval
    }

    /// Takes the arrived datagrams.
    fn consume(&mut self, env: &Environment) {
        while let Some((sent, bytes)) = self.mailbox.receive() {
            self.sent = sent;
            env.common.record.saw(env.name, &bytes[..12]);
        }
    }
}

async fn own(env: &mut Environment, client: &mut Client, serial: u16) -> Answer<()> {
    let interval = *env.random.one_of(&[5, 10, 20]);
    let multiplier = *env.random.one_of(&[2, 3]);
    let lives = env.lives();
    let key = ConnectionKey {
        serial,
        vendor: 0x1337,
        originator: 43,
    };
    let open = forward_open(key, interval, multiplier);
    let address = SocketAddr::new(env.ip().into(), IO_PORT);
    let random = arcline_tests::random::Random(env.random.bits());
    let mailbox = env.common.post.open(address, env.weather, random);
    // Send it before the connection is open: its time-out does not wait for many answers.
    client.ask(&instruction(Mnemonic::Mafr, C, "", &[])).await?;
    let Some(opened) = client.open_io(&open, IO_PORT).await? else {
        env.note("the outputs have another owner still");
        return Ok(());
    };
    let ForwardOpenReply {
        o_to_t_id, o_to_t_api, ..
    } = opened;
    let _io = env.alive(o_to_t_id.0);
    let mut owned = Owned {
        id: o_to_t_id,
        mailbox,
        // The 16 bits of the data and the 32 bits of the datagram are over soon.
        sequence: if env.common.near_end { u32::MAX - 20 } else { 0 },
        interval,
        timeout: u64::from(o_to_t_api) / 1000 * (4 << multiplier),
        heard: None,
        sent: 0,
        paused: false,
    };
    env.sometimes("the outputs have an owner");
    owned.produce();
    client.ask(&instruction(Mnemonic::Mso, C, "", &[])).await?;
    env.order(Order::Moves(C as usize - 1));
    // 200 units at 20 units/s: longer than the owner lives.
    let far = [1.0, 200.0, 20.0, 0.0, 1000.0, 0.0, 1000.0, 0.0];
    client.ask(&instruction(Mnemonic::Mam, C, "FarC", &far)).await?;
    for _ in 0..env.random.below(80) {
        owned.produce();
        tokio::time::sleep(Duration::from_millis(owned.interval)).await;
        owned.consume(env);
    }
    // A partition may have ended it before the move began.
    if !owned.is_open(env.now()) {
        env.note("the connection of the outputs has ended");
        // Or no datagram has arrived: then the server waits for the first one.
        return client.forward_close(key).await;
    }
    if env.chance(30) || env.is_over() {
        env.sometimes("the owner of the outputs closes its connection");
        // The newest outputs arrive first.
        tokio::time::sleep(Duration::from_millis(env.weather.delay + 2)).await;
        client.forward_close(key).await?;
        let at = env.now() + owned.interval + super::motion::LATE;
        env.order(rest(at, "the owner of the outputs has closed its connection"));
    } else {
        fall_silent(env, &mut owned, lives).await;
    }
    Ok(())
}

/// The server ends the connection after its time-out, never before, and stops its motion (L2).
async fn fall_silent(env: &mut Environment, owned: &mut Owned, lives: u64) {
    let Some(heard) = owned.heard else { return };
    env.sometimes("the owner of the outputs falls silent");
    let ends = heard + owned.timeout;
    env.order(rest(
        ends + owned.interval + super::motion::LATE,
        "the owner of the outputs is lost",
    ));
    while env.now() < ends + 3 * owned.interval {
        tokio::time::sleep(Duration::from_millis(1)).await;
        owned.consume(env);
    }
    // The connection may have ended with the server, or the datagrams of either were lost on the way.
    let disturbed_until = env.common.post.held_until().max(env.stalled_until());
    let is_disturbed = env.lives() != lives || disturbed_until + owned.timeout >= heard;
    if is_disturbed || owned.paused || owned.sent == 0 {
        return;
    }
    env.sometimes("a silent owner is judged");
    let (first, last) = (ends.saturating_sub(owned.interval + 2), ends + owned.interval + 2);
    if !(first..=last).contains(&owned.sent) {
        let why = format!(
            "its connection, heard last at {heard} with a time-out of {} ms, was last sent inputs at {}",
            owned.timeout, owned.sent
        );
        env.common.record.violated("L2", &why);
    }
}

fn rest(at: u64, why: &'static str) -> Order {
    Order::Rest(Deadline {
        axis: C as usize - 1,
        at,
        why,
    })
}

/// The Forward Open of an exclusive owner; the interval in ms.
fn forward_open(key: ConnectionKey, interval: u64, multiplier: u8) -> ForwardOpen {
    let parameters = |size| NetworkParameters {
        variable: false,
        priority: 2,
        ..NetworkParameters::explicit(size)
    };
    ForwardOpen {
        time: TickTime::DEFAULT,
        o_to_t_id: ConnectionId(0),
        t_to_o_id: ConnectionId(u32::from(key.serial)),
        key,
        multiplier,
        o_to_t_rpi: interval as u32 * 1000,
        o_to_t: parameters(OUTPUT_SIZE + 6),
        t_to_o_rpi: interval as u32 * 1000,
        t_to_o: parameters(INPUT_SIZE + 2),
        transport: 1,
        path: Epath(vec![
            Segment::Class(4),
            Segment::Instance(CONFIGURATION),
            Segment::ConnectionPoint(OUTPUT),
            Segment::ConnectionPoint(INPUT),
        ]),
    }
}
