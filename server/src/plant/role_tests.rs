//! The plant decides by roles: every command × every role × every principal.

use arcline_config::{ConnectionLoss, Role};
use arcline_controller::image::PlainTag;
use arcline_instruction_set::{Attribute, AxisId, Mnemonic, Object as MotionObject, SystemId, UnboundOperand};

use super::*;
use crate::guard::VIEWERS;
use crate::pages::compare_or_write_part;
use crate::{eip, hmi};

/// The command that writes the part of a tag at a path.
fn write<'a>(plant: &Plant, path: &str, data: &'a [u8]) -> Command<'a> {
    let path = path.parse().expect("a path");
    let located = plant.with_image(|image| image.locate(&path).map(|(tag, place)| (tag, place.offset, place.bit)));
    match located.expect("it is there") {
        (tag, offset, Some(bit)) => Command::WriteBit {
            tag,
            offset,
            bit,
            on: data.first().is_some_and(|byte| *byte != 0),
        },
        (tag, offset, None) => Command::WriteTag { tag, offset, data },
    }
}

fn call(mnemonic: Mnemonic, operands: &[UnboundOperand]) -> Command<'_> {
    Command::Call(Call {
        mnemonic,
        target: Some(0),
        control: None,
        operands,
        text: None,
    })
}

/// Sets the Dynamics Configuration Bits of the first object of a kind.
fn attribute(object: MotionObject) -> Command<'static> {
    let attribute = Attribute::named(object, "DynamicsConfigurationBits").expect("it is there");
    Command::SetAttribute {
        attribute,
        index: 0,
        value: 0.0,
    }
}

fn plain_tag() -> PlainTag {
    let text = format!(
        "{}\n[[tag]]\nname = \"Fresh\"\ntype = \"DINT\"\n",
        arcline_config::DEFAULT
    );
    let project = arcline_config::load(&text, "test").expect("it is valid");
    project
        .tags
        .into_iter()
        .find(|tag| tag.name == "Fresh")
        .expect("it is there")
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn every_command_for_every_role_of_every_principal() {
    let ruled = "[[tag]]\nname = \"Recipe\"\ntype = \"DINT\"\nwrite_role = \"engineer\"\n[[tag]]\nname = \"Serial\"\ntype = \"DINT\"\nwrite_role = \"administrator\"\n";
    let text = format!("{}\n{ruled}", arcline_config::DEFAULT);
    let ruled = arcline_config::load(&text, "test").expect("it is valid");
    let (plant, handle) = Plant::start(&ruled).expect("a thread");
    let fresh = plain_tag();
    let (half, double, zero) = (50_f32.to_le_bytes(), 150_f32.to_le_bytes(), [0; 4]);
    let stop_all = [UnboundOperand::Word("All".into())];
    #[rustfmt::skip]
    let mut cases = vec![
        ("a plain tag",              Right::WriteTag,      write(&plant, "Move1.Speed", &half)),
        ("a tag of engineers",       Right::EngineersTag,  write(&plant, "Recipe", &half)),
        ("a bit of it",              Right::EngineersTag,  write(&plant, "Recipe.3", &[1])),
        ("a tag of administrators",  Right::AdministratorsTag, write(&plant, "Serial", &half)),
        ("EnableIn of a move",       Right::Move,          write(&plant, "Move1.EnableIn", &[1])),
        ("an override",              Right::Override,      write(&plant, "FeedOverride[0]", &half)),
        ("an override above 100 %",  Right::OverrideAbove, write(&plant, "FeedOverride[0]", &double)),
        ("a bit of an override",     Right::OverrideAbove, Command::WriteBit { tag: tag_of(&plant, "FeedOverride"), offset: 0, bit: 1, on: true }),
        ("a fault",                  Right::InjectFaults,  write(&plant, "FaultInject[0]", &zero)),
        ("STOP as a tag",            Right::Stop,          write(&plant, "MotionInhibit", &[1])),
        ("its release as a tag",     Right::ReleaseStop,   write(&plant, "MotionInhibit", &[0])),
        ("a fault as a command",     Right::InjectFaults,  Command::InjectFaults { axis: AxisId(0), bits: 0 }),
        ("SetFeedOverride",          Right::Override,      Command::SetFeedOverride { system: SystemId(0), percent: 100.0 }),
        ("SetFeedOverride above",    Right::OverrideAbove, Command::SetFeedOverride { system: SystemId(0), percent: 100.1 }),
        ("Hold",                     Right::Stop,          Command::Hold(Systems::All)),
        ("Resume",                   Right::Override,      Command::Resume(Systems::All)),
        ("an attribute of an axis",  Right::SetAttribute,  attribute(MotionObject::Axis)),
        ("an attribute of a system", Right::SetAttribute,  attribute(MotionObject::CoordinateSystem)),
        ("MCS",                      Right::Stop,          call(Mnemonic::Mcs, &stop_all)),
        ("MAS",                      Right::Stop,          call(Mnemonic::Mas, &stop_all)),
        ("a mode",                   Right::ChangeMode,    Command::SetMode(Mode::Run)),
        ("a force that goes",        Right::Force,         Command::RemoveForce(Some("Local:1:I.Data.0"))),
        ("all forces",               Right::Force,         Command::RemoveForce(None)),
        ("a new tag",                Right::ChangeTags,    Command::CreateTag(&fresh)),
        ("an administrators' tag that goes", Right::AdministratorsTag, Command::DeleteTag(tag_of(&plant, "Serial"))),
        ("a tag that goes",          Right::ChangeTags,    Command::DeleteTag(tag_of(&plant, "Move1"))),
        ("Lose",                     Right::Serve,         Command::Lose { lost: Principal::Viewer(99), reaction: ConnectionLoss::Finish }),
        ("Disown",                   Right::Serve,         Command::Disown(Principal::Viewer(99))),
        ("StopAll",                  Right::Stop,          Command::StopAll),
        ("Inhibit",                  Right::Stop,          Command::Inhibit),
        ("Release",                  Right::ReleaseStop,   Command::Release),
        ("Step",                     Right::StepClock,     Command::Step { ticks: 0, until: None }),
    ];
    for mnemonic in Mnemonic::ALL {
        let right = match mnemonic {
            Mnemonic::Mas | Mnemonic::Mcs | Mnemonic::Mgs => Right::Stop,
            _ => Right::Move,
        };
        cases.push((mnemonic.name(), right, call(*mnemonic, &[])));
    }
    let client = Principal::Client {
        session: 1,
        connection: 0,
    };
    let principals = [
        Principal::Controller,
        client,
        Principal::Viewer(1),
        Principal::Button(1),
        Principal::Program { viewer: 1, line: 1 },
        Principal::Io,
    ];
    let mut checked = 0;
    for role in Role::ALL {
        plant.roles().set(1, role);
        plant.roles().set(VIEWERS | 1, role);
        plant.roles().set_io(role);
        for principal in principals {
            for (why, right, command) in &cases {
                let is_program = matches!(principal, Principal::Program { .. });
                // The controller's own program is an engineer's, whatever the roles of clients.
                let role = match principal {
                    Principal::Controller => Role::Engineer,
                    _ => role,
                };
                let may = right.is_of(role) && (!is_program || Right::RunProgram.is_of(role));
                let done = plant
                    .transact(principal, |transaction| transaction.apply(command.clone()))
                    .0;
                let refused = matches!(done, Err(Refused::Role { .. }));
                assert_eq!(refused, !may, "{why} by {principal:?} as {}: {done:?}", role.word());
                checked += 1;
            }
        }
    }
    assert_eq!(checked, 4 * 6 * cases.len());
    // A client that the plant does not know, or that has gone, only looks.
    let unknown = Principal::Client {
        session: 2,
        connection: 0,
    };
    assert_eq!(plant.roles().of(unknown), Role::Viewer);
    plant.leave(1);
    assert_eq!(plant.roles().of(client), Role::Viewer);
    // At least one of the three matrices covers every right.
    let page = hmi::tests::roles::cases();
    let mut judged: Vec<Right> = cases.iter().map(|(_, right, _)| *right).collect();
    judged.extend(page.iter().map(|(right, _)| *right));
    judged.extend(eip::tests::roles::rights());
    for right in Right::ALL {
        assert!(judged.contains(right), "{right:?} is in no matrix");
        let is_here = cases.iter().any(|(_, of, _)| of == right);
        let is_command = !right.is_of_interface() && *right != Right::Look;
        assert_eq!(is_here, is_command, "{right:?} is a command's right, or an interface's");
    }
    handle.stop();
}

fn tag_of(plant: &Plant, name: &str) -> arcline_controller::image::TagId {
    plant.with_image(|image| image.find(name).expect("it is there").id)
}

#[test]
fn the_table_of_rights() {
    compare_or_write_part("docs/SECURITY.md", "rights", &rights_page());
}

/// The order in which roles are compared, which every right rests on.
#[test]
fn each_role_may_all_that_those_before_may() {
    for right in Right::ALL {
        let has = Role::ALL.map(|role| right.is_of(role));
        assert!(has.is_sorted() && has[3], "{right:?}: {has:?}");
    }
    assert!(Right::Stop.is_of(Role::Viewer), "STOP is everybody's");
}
