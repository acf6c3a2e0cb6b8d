//! A client that injects faults of axes, and takes them away again (docs/FAULTS.md).

use super::Environment;
use crate::client::{Answer, Client, DINT, dint, read, write};

/// The axes whose faults are injected: S and P, which are servos, and A, B and C, which are virtual. Lines of X, Y and Z are held to their path.
const AXES: [u32; 5] = [3, 4, 5, 6, 7];
/// Bits of causes: soft travel, position error, the drive, overcurrent, a limit switch, feedback, a command limit, communication.
const CAUSES: [i32; 8] = [0, 2, 3, 4, 6, 8, 9, 10];

pub(crate) async fn faults(mut env: Environment) {
    // The cause that the server may still have, by axis.
    let mut there = None;
    while !env.is_over() {
        env.session(async |env, client| inject(env, client, &mut there).await)
            .await;
        env.pause(2000).await;
    }
}

async fn inject(env: &mut Environment, client: &mut Client, there: &mut Option<u32>) -> Answer<()> {
    if let Some(axis) = *there {
        set(client, axis, 0).await?;
        *there = None;
    }
    if env.now() >= env.common.quiet_from {
        return Ok(());
    }
    let (axis, cause) = (*env.random.one_of(&AXES), *env.random.one_of(&CAUSES));
    *there = Some(axis);
    let (lives, bits) = (env.lives(), 1 << cause);
    if !set(client, axis, bits).await? {
        // A virtual axis has but some of them.
        env.note(&format!("bit {cause} of axis {axis} is refused"));
        *there = None;
        return Ok(());
    }
    env.sometimes("a fault is injected");
    env.pause(300).await;
    let shown = client.ask(&read(&format!("FaultInject[{axis}]"), 1)).await?;
    env.common.record.saw(env.name, &shown.to_bytes());
    if dint(&shown) != Some(bits) && env.lives() == lives {
        let why = format!("FaultInject[{axis}] was set to {bits} and shows {:?}", dint(&shown));
        env.common.record.violated("W1", &why);
    }
    set(client, axis, 0).await?;
    *there = None;
    Ok(())
}

/// Sets the causes of an axis's faults; returns whether the server accepts them.
async fn set(client: &mut Client, axis: u32, bits: i32) -> Answer<bool> {
    let reply = client
        .ask(&write(&format!("FaultInject[{axis}]"), DINT, 1, &bits.to_le_bytes()))
        .await?;
    Ok(reply.status.is_success())
}
