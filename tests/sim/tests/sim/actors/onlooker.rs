//! A client whose role may look and stop, and that tries to do more (U1).

use arcline_instruction_set::Mnemonic;
use arcline_proto::arcline::machine::service as machine;
use arcline_proto::cip::CipStatus;

use super::Environment;
use super::tags::TAGS;
use crate::client::{Answer, BOOL, Client, DINT, REAL, instruction, machine_service, read, value, write};
use crate::history::WriteAnswer;
use crate::ledger::Kind;

/// Values that no other client writes.
const FIRST: i32 = 3_000_000;

pub(crate) async fn onlooker(mut env: Environment) {
    let mut next = FIRST;
    while !env.is_over() {
        env.session(async |env, client| try_all(env, client, &mut next).await)
            .await;
        env.pause(800).await;
    }
}

async fn try_all(env: &mut Environment, client: &mut Client, next: &mut i32) -> Answer<()> {
    for _ in 0..1 + env.random.below(8) {
        let tag = *env.random.one_of(&TAGS);
        let shown = client.ask(&read(tag, 1)).await?;
        if value(&shown).is_none() {
            let why = format!("a client that may look cannot read {tag}: {}", shown.status);
            env.common.record.violated("U1", &why);
        }
        *next += 1;
        let (what, request) = match env.random.below(6) {
            0 => ("a write of a bit", write("StepA.EnableIn", BOOL, 1, &[1])),
            1 => (
                "a write of an operand",
                write("StepA.Position", REAL, 1, &1_f32.to_le_bytes()),
            ),
            2 => ("MSO", instruction(Mnemonic::Mso, 5, "", &[])),
            3 => ("the release of STOP", machine_service(machine::RELEASE)),
            4 => ("the release of STOP", write("MotionInhibit", BOOL, 1, &[0])),
            _ => {
                env.common.history.asks(tag, *next);
                ("a write", write(tag, DINT, 1, &next.to_le_bytes()))
            }
        };
        env.asks(Kind::Denied);
        let reply = client.ask(&request).await?;
        env.answered(Kind::Denied);
        if what == "a write" {
            env.common.history.has(tag, *next, WriteAnswer::Refused);
        }
        if reply.status != CipStatus::PRIVILEGE_VIOLATION {
            let why = format!("{what} of a client that may only look: {}", reply.status);
            env.common.record.violated("U1", &why);
        }
        env.sometimes("a client without the right is refused");
        env.common.record.saw(env.name, &reply.to_bytes());
        env.pause(60).await;
    }
    Ok(())
}
