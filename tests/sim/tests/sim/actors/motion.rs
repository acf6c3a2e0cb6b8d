//! Clients that move the machine, and one that stops it.

use arcline_instruction_set::{Flag, Mnemonic, MotionControl};
use arcline_proto::arcline::machine::service as machine;
use arcline_proto::cip::Reply;

use super::{Environment, Order};
use crate::client::{Answer, BOOL, Client, DINT, REAL, instruction, machine_service, read, value, write};
use crate::ledger::Kind;
use crate::motion::Deadline;

/// Instances of axes: X, Y, Z, S, A, B and C.
const X: u32 = 1;
const A: u32 = 5;
const B: u32 = 6;
/// The instance of CS1.
const CS1: u32 = 1;

/// CommandPosition is a REAL.
const ROUNDING: f64 = 1e-4;

/// The motion control tag of a reply.
fn control_of(reply: &Reply) -> Option<MotionControl> {
    value(reply)?
        .first_chunk()
        .map(|bytes| MotionControl::from_bytes(*bytes))
}

/// Bits that never stand together (E2).
fn check_bits(control: MotionControl, env: &Environment, whose: &str) {
    let has = |flag| control.has(flag);
    let wrong = has(Flag::Dn) && has(Flag::Er)
        || has(Flag::Er) != (control.err != 0)
        || has(Flag::Pc) && (has(Flag::Ip) || has(Flag::Er))
        || has(Flag::Ip) && has(Flag::Er);
    if wrong && !env.has_lost() {
        let why = format!("{whose} shows {:08X}, ERR {}", control.flags, control.err);
        env.common.record.violated("E2", &why);
    }
}

fn real(reply: &Reply) -> Option<f64> {
    let bytes = value(reply)?;
    match bytes.len() {
        4 => Some(f32::from_le_bytes(bytes[..4].try_into().ok()?).into()),
        8 => Some(f64::from_le_bytes(bytes[..8].try_into().ok()?)),
        _ => None,
    }
}

/// Steps of axis A by the EnableIn of a tag: each is made exactly once.
pub(crate) async fn stepper(mut env: Environment) {
    while !env.is_over() {
        let asked = env.now();
        match env.client().await {
            Ok(mut client) => match step_for_a_while(&mut env, &mut client).await {
                Err(error) => env.judge(asked, &error),
                Ok(()) if env.chance(50) || env.is_over() => client.leave().await,
                Ok(()) => {}
            },
            Err(error) => env.judge(asked, &error),
        }
        env.pause(100).await;
    }
}

/// The motion control tag, and the position and velocity of its axis, of one tick.
async fn look(env: &Environment, client: &mut Client) -> Answer<Option<(MotionControl, f64, f64)>> {
    let tags = ["StepA.MotionControl", "A.CommandPosition", "A.CommandVelocity"];
    let replies = client.ask_all(&tags.map(|tag| read(tag, 1))).await?;
    let Some([control, position, velocity]) = replies.as_deref() else {
        return Ok(None);
    };
    env.common.record.saw(env.name, &control.to_bytes());
    env.common.record.saw(env.name, &position.to_bytes());
    let numbers = real(position).zip(real(velocity));
    let shown = control_of(control).zip(numbers);
    let shown = shown.map(|(control, (position, velocity))| (control, position, velocity));
    match shown {
        Some((control, position, _)) => {
            env.note(&format!("{:08X} ERR {} at {position}", control.flags, control.err));
            check_bits(control, env, "StepA");
        }
        None => env.common.record.violated("N1", "StepA cannot be read"),
    }
    Ok(shown)
}

async fn step_for_a_while(env: &mut Environment, client: &mut Client) -> Answer<()> {
    client.ask(&instruction(Mnemonic::Mafr, A, "", &[])).await?;
    client.ask(&instruction(Mnemonic::Mso, A, "", &[])).await?;
    for _ in 0..5 + env.random.below(10) {
        if env.is_over() {
            break;
        }
        step(env, client).await?;
        env.pause(100).await;
    }
    Ok(())
}

async fn step(env: &mut Environment, client: &mut Client) -> Answer<()> {
    // An instruction of a connection before may still run, and a STOP ends an instruction before the axis stands.
    let mut from = None;
    for _ in 0..100 {
        if let Some((control, at, velocity)) = look(env, client).await?
            && !control.has(Flag::Ip)
            && velocity == 0.0
        {
            from = Some(at);
            break;
        }
        env.pause(20).await;
    }
    let Some(from) = from else { return Ok(()) };
    let distance = env.random.between(0.5, 4.0) as f32;
    let operands = [
        write("StepA.EnableIn", BOOL, 1, &[0]),
        write("StepA.MoveType", DINT, 1, &1_i32.to_le_bytes()),
        write("StepA.Position", REAL, 1, &distance.to_le_bytes()),
        write("StepA.SpeedUnits", DINT, 1, &0_i32.to_le_bytes()),
        write("StepA.Speed", REAL, 1, &100_f32.to_le_bytes()),
    ];
    client.ask_all(&operands).await?;
    env.asks(Kind::Edge);
    let reply = client.ask(&write("StepA.EnableIn", BOOL, 1, &[1])).await?;
    env.common.record.saw(env.name, &reply.to_bytes());
    if !reply.status.is_success() {
        env.note(&format!("EnableIn was refused: {}", reply.status));
        env.sometimes("a command finds no room");
        return Ok(());
    }
    env.answered(Kind::Edge);
    env.sometimes("an edge of EnableIn");
    for _ in 0..400 {
        let Some((control, at, _)) = look(env, client).await? else {
            return Ok(());
        };
        let moved = at - from;
        if env.has_lost() {
            env.sometimes("a step whose end may be lost");
            return Ok(());
        }
        // A STOP at the axis's jerk may take longer than the end of the move.
        let runs = control.has(Flag::Ip) || control.has(Flag::Pc);
        if runs && (moved > f64::from(distance) + ROUNDING || moved < -ROUNDING) {
            let why = format!("a step of {distance} has moved by {moved}");
            env.common.record.violated("E1", &why);
            return Ok(());
        }
        if control.has(Flag::Pc) {
            env.sometimes("a step is complete");
            if (moved - f64::from(distance)).abs() > ROUNDING {
                let why = format!("PC of a step of {distance}, and the axis has moved by {moved}");
                env.common.record.violated("E3", &why);
            }
            return Ok(());
        }
        if control.has(Flag::Er) {
            env.sometimes("a step is refused by the machine");
            if control.err == 53 {
                env.sometimes("motion is inhibited");
            }
            return Ok(());
        }
        if !control.has(Flag::Dn) {
            let why = format!("an answered edge shows {:08X}", control.flags);
            env.common.record.violated("E1", &why);
            return Ok(());
        }
        if !control.has(Flag::Ip) {
            env.sometimes("a step is stopped");
            return Ok(());
        }
        env.pause(10).await;
    }
    if !env.has_lost() {
        env.common.record.violated("E1", "a step has no end");
    }
    Ok(())
}

/// Lines of CS1 by services, two at a time.
pub(crate) async fn lines(mut env: Environment) {
    let mut newest = (0, 0);
    while !env.is_over() {
        env.session(async |env, client| draw_for_a_while(env, client, &mut newest).await)
            .await;
        env.pause(100).await;
    }
}

async fn draw_for_a_while(env: &mut Environment, client: &mut Client, newest: &mut (u64, u32)) -> Answer<()> {
    for axis in X..X + 3 {
        client.ask(&instruction(Mnemonic::Mso, axis, "", &[])).await?;
    }
    for _ in 0..3 + env.random.below(8) {
        if env.is_over() {
            break;
        }
        for control in ["Line1", "Line2"] {
            let lives = env.lives();
            let reply = draw_line(env, client, control).await?;
            env.common.record.saw(env.name, &reply.to_bytes());
            if let Some(instance) = reply.status.is_success().then(|| reply.data.get(..4)).flatten() {
                let instance = u32::from_le_bytes([instance[0], instance[1], instance[2], instance[3]]);
                if *newest >= (lives, instance) && lives == env.lives() {
                    let why = format!("instance {instance} behind {}", newest.1);
                    env.common.record.violated("E1", &why);
                }
                *newest = (lives, instance);
                if let Some(control) = reply.data.get(4..).and_then(<[u8]>::first_chunk) {
                    check_bits(MotionControl::from_bytes(*control), env, "the answer of MCLM");
                }
            }
        }
        until_complete(env, client).await?;
        if env.chance(20) {
            env.sometimes("a line is stopped by MCS");
            draw_line(env, client, "Line1").await?;
            env.pause(60).await;
            // All, at the programmed deceleration.
            client
                .ask(&instruction(
                    Mnemonic::Mcs,
                    CS1,
                    "Halt",
                    &[0.0, 0.0, 5000.0, 0.0, 0.0, 0.0],
                ))
                .await?;
        }
    }
    Ok(())
}

/// Asks for a line to a drawn position.
async fn draw_line(env: &mut Environment, client: &mut Client, control: &str) -> Answer<Reply> {
    let position = [0; 3].map(|_| env.random.between(-30.0, 30.0));
    env.order(Order::Line(position));
    env.asks(Kind::Line);
    let reply = client.ask(&line(control, position)).await?;
    if reply.status.is_success() {
        env.answered(Kind::Line);
    } else {
        env.order(Order::NoLine(position));
    }
    Ok(reply)
}

/// An absolute MCLM, trapezoidal.
fn line(control: &str, position: [f64; 3]) -> arcline_proto::cip::Request {
    use arcline_proto::logix::{Typed, encode_operands};
    use arcline_tag::{Elementary, Value};
    let numbers = |numbers: &[f64]| {
        let values = numbers.iter().map(|number| Value::from_f64(Elementary::Lreal, *number));
        Typed::Numbers(Elementary::Lreal, values.collect())
    };
    let mut operands = vec![
        Typed::ShortString(control.to_owned()),
        numbers(&[0.0]),
        numbers(&position),
    ];
    operands.extend([400.0, 0.0, 5000.0, 0.0, 5000.0, 0.0, 0.0].map(|number| numbers(&[number])));
    let mut data = bytes::BytesMut::new();
    encode_operands(&operands, &mut data);
    arcline_proto::cip::Request {
        data: data.freeze(),
        ..instruction(Mnemonic::Mclm, CS1, control, &[])
    }
}

async fn until_complete(env: &mut Environment, client: &mut Client) -> Answer<()> {
    for _ in 0..300 {
        let replies = client.ask_all(&[read("Line1", 1), read("Line2", 1)]).await?;
        for reply in replies.iter().flatten() {
            env.common.record.saw(env.name, &reply.to_bytes());
        }
        let controls: Vec<MotionControl> = replies.iter().flatten().filter_map(control_of).collect();
        for control in &controls {
            check_bits(*control, env, "a line");
        }
        if let [first, second] = controls[..] {
            // They end in their order, unless the tags are of an earlier pair.
            if second.has(Flag::Pc) && first.has(Flag::Ip) && !env.has_lost() {
                env.common
                    .record
                    .violated("E2", "the second line is complete before the first");
            }
            if first.has(Flag::Pc) && second.has(Flag::Pc) {
                env.sometimes("two lines are complete");
                return Ok(());
            }
        }
        // The end of a line may be lost.
        if env.has_lost() || controls.iter().all(|control| !control.has(Flag::Ip)) {
            return Ok(());
        }
        env.pause(20).await;
    }
    if !env.has_lost() {
        env.common.record.violated("E2", "a line has no end");
    }
    Ok(())
}

/// Jogs axis B, and then releases it, hangs, vanishes, or has its connection cut.
pub(crate) async fn jogger(mut env: Environment) {
    while !env.is_over() {
        let asked = env.now();
        match env.client().await {
            Ok(client) => {
                if let Err(error) = jog(&mut env, client).await {
                    env.judge(asked, &error);
                }
            }
            Err(error) => env.judge(asked, &error),
        }
        // Longer than any of its stops takes.
        tokio::time::sleep(std::time::Duration::from_millis(2500)).await;
    }
}

async fn jog(env: &mut Environment, mut client: Client) -> Answer<()> {
    client.ask(&instruction(Mnemonic::Mafr, B, "", &[])).await?;
    client.ask(&instruction(Mnemonic::Mso, B, "", &[])).await?;
    env.order(Order::Moves(B as usize - 1));
    let operands = [0.0, 50.0, 0.0, 1000.0, 0.0, 1000.0, 0.0];
    let reply = client.ask(&instruction(Mnemonic::Maj, B, "JogB", &operands)).await?;
    if !reply.status.is_success() {
        return Ok(());
    }
    env.sometimes("a jog");
    for _ in 0..env.random.below(12) {
        client.ask(&read("B.CommandVelocity", 1)).await?;
        env.pause(40).await;
    }
    // Silence of 500 ms, a look every 10 ms, 50 units/s at 10,000 units/s², and ticks that are late.
    let rest = |at, why| {
        Order::Rest(Deadline {
            axis: B as usize - 1,
            at,
            why,
        })
    };
    let heard = client.end.arrives_by();
    match env.random.below(4) {
        0 => {
            env.sometimes("a jog is released");
            client
                .ask(&instruction(
                    Mnemonic::Mas,
                    B,
                    "HaltB",
                    &[0.0, 1.0, 1000.0, 0.0, 0.0, 0.0],
                ))
                .await?;
            client.leave().await;
        }
        1 => {
            env.sometimes("a jogging client hangs");
            env.order(rest(heard + 500 + LATE, "its client hangs"));
            tokio::time::sleep(std::time::Duration::from_millis(2000)).await;
            client.leave().await;
        }
        2 => {
            env.sometimes("a jogging client vanishes");
            env.order(rest(heard + 500 + LATE, "its client has vanished"));
            client.end.vanish(env.now() + 4000);
        }
        _ => {
            env.sometimes("a jogging client is cut off");
            env.order(rest(env.now() + 250 + LATE, "its client was cut off"));
            client.end.cut();
        }
    }
    Ok(())
}

/// The stop itself, and the latest tick.
pub(super) const LATE: u64 = 150;

/// Stops everything and releases it.
pub(crate) async fn stopper(mut env: Environment) {
    while !env.is_over() {
        env.pause(3000).await;
        env.session(async |env, client| stop(env, client).await).await;
    }
}

async fn stop(env: &mut Environment, client: &mut Client) -> Answer<()> {
    let by_tag = env.chance(50);
    let stop = match by_tag {
        true => write("MotionInhibit", BOOL, 1, &[1]),
        false => machine_service(machine::STOP),
    };
    let reply = client.ask(&stop).await?;
    env.common.record.saw(env.name, &reply.to_bytes());
    if !reply.status.is_success() {
        env.common
            .record
            .violated("M3", &format!("STOP was refused: {}", reply.status));
    }
    env.sometimes("STOP");
    let shown = client.ask(&read("MotionInhibit", 1)).await?;
    let lives = env.lives();
    if value(&shown).is_some_and(|value| value[0] == 0) && lives == env.lives() {
        env.common
            .record
            .violated("M3", "an answered STOP does not show in MotionInhibit");
    }
    env.pause(600).await;
    let release = match env.chance(50) {
        true => write("MotionInhibit", BOOL, 1, &[0]),
        false => machine_service(machine::RELEASE),
    };
    client.ask(&release).await?;
    Ok(())
}
