//! The owner of the outputs of implicit I/O: it moves an axis, and is lost in each way in which an owner can be.

use std::time::Duration;

use arcline_instruction_set::Mnemonic;
use arcline_proto::connection::ConnectionKey;

use super::implicit::{Implicit, Kind};
use super::{Environment, Order};
use crate::client::{Answer, Client, instruction};
use crate::motion::Deadline;

/// The instance of axis C.
const C: u32 = 7;

/// Owns the outputs again and again.
pub(crate) async fn owner(mut env: Environment) {
    let mut serial = 0;
    while !env.is_over() {
        env.session(async |env, client| {
            serial += 1;
            own(env, client, serial).await
        })
        .await;
        env.pause(600).await;
    }
}

async fn own(env: &mut Environment, client: &mut Client, serial: u16) -> Answer<()> {
    let lives = env.lives();
    let key = ConnectionKey {
        serial,
        vendor: 0x1337,
        originator: 43,
    };
    // Send it before the connection is open: its time-out does not wait for many answers.
    client.ask(&instruction(Mnemonic::Mafr, C, "", &[])).await?;
    let Some(mut owned) = Implicit::open(env, client, Kind::Owner, key).await? else {
        env.note("the outputs have another owner still");
        return Ok(());
    };
    env.sometimes("the outputs have an owner");
    owned.produce();
    client.ask(&instruction(Mnemonic::Mso, C, "", &[])).await?;
    env.order(Order::Moves(C as usize - 1));
    // 200 units at 20 units/s: longer than the owner lives.
    let far = [1.0, 200.0, 20.0, 0.0, 1000.0, 0.0, 1000.0, 0.0];
    client.ask(&instruction(Mnemonic::Mam, C, "FarC", &far)).await?;
    let intervals = env.random.below(80);
    owned.run(env, intervals).await;
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
    } else if let Some(ends) = owned.ends() {
        env.sometimes("the owner of the outputs falls silent");
        let at = ends + owned.interval + super::motion::LATE;
        env.order(rest(at, "the owner of the outputs is lost"));
        owned.fall_silent(env, lives).await;
    }
    Ok(())
}

fn rest(at: u64, why: &'static str) -> Order {
    Order::Rest(Deadline {
        axis: C as usize - 1,
        at,
        why,
    })
}
