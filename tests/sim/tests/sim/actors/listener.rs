//! Connections that have only the inputs of implicit I/O: their own, or those of another connection, with which they end.

use arcline_proto::connection::ConnectionKey;

use super::Environment;
use super::implicit::{Implicit, Kind};
use crate::client::{Answer, Client};

/// Listens again and again.
pub(crate) async fn listener(mut env: Environment) {
    let mut serial = 0;
    while !env.is_over() {
        env.session(async |env, client| {
            serial += 1;
            listen(env, client, serial).await
        })
        .await;
        env.pause(400).await;
    }
}

async fn listen(env: &mut Environment, client: &mut Client, serial: u16) -> Answer<()> {
    let lives = env.lives();
    let kind = *env
        .random
        .one_of(&[Kind::InputOnly, Kind::ListenOnly, Kind::ListenOnly]);
    let key = ConnectionKey {
        serial,
        vendor: 0x1337,
        originator: 44,
    };
    let Some(mut inputs) = Implicit::open(env, client, kind, key).await? else {
        // Every connection may have the inputs, but one that only listens needs another one.
        if kind == Kind::ListenOnly {
            env.sometimes("there is nothing to listen to");
        } else {
            env.common.record.violated("N1", "a connection of inputs is refused");
        }
        return Ok(());
    };
    env.sometimes(match kind {
        Kind::ListenOnly => "a connection only listens",
        _ => "a connection has only inputs",
    });
    let intervals = 1 + env.random.below(100);
    inputs.run(env, intervals).await;
    if env.chance(50) || env.is_over() {
        return client.forward_close(key).await;
    }
    if kind == Kind::ListenOnly && !inputs.is_open(env.now()) {
        env.sometimes("a listener ends with what it listens to");
    }
    inputs.fall_silent(env, lives).await;
    Ok(())
}
