//! A table of tags that changes while clients look: created, deleted, and taken over from another configuration.

use arcline_config::Project;
use arcline_instruction_set::Mnemonic;
use arcline_proto::cip::{Reply, Request, class, service};
use arcline_proto::epath::{Epath, Segment};
use arcline_proto::logix::CreateSymbol;
use arcline_tag::Elementary;
use bytes::Bytes;

use super::{Bench, Client, codes, read, settings_of, write};
use crate::plant::{Call, Command, Outcome, Principal, ReloadError};

fn scoped(program: Option<&str>, instance: u32) -> Epath {
    let mut path = Epath::object(class::SYMBOL, instance);
    if let Some(program) = program {
        path.0.insert(0, Segment::Symbol(format!("Program:{program}").into()));
    }
    path
}

async fn create(client: &mut Client, program: Option<&str>, name: &str, data_type: &str, access: u8) -> Reply {
    let create = CreateSymbol {
        name: name.to_owned(),
        data_type: data_type.to_owned(),
        access,
    };
    let request = Request::new(service::CREATE, scoped(program, 0), create.to_bytes());
    client.ask(&request).await
}

async fn delete(client: &mut Client, program: Option<&str>, instance: u32) -> Reply {
    let request = Request::new(service::DELETE, scoped(program, instance), Bytes::new());
    client.ask(&request).await
}

/// The attributes that clients poll for changes: 3, 4 and 10 of class 0xAC.
async fn changes(client: &mut Client) -> [u32; 3] {
    let request = Request::new(
        service::GET_ATTRIBUTE_LIST,
        Epath::object(0xAC, 1),
        Bytes::from_static(&[3, 0, 3, 0, 4, 0, 10, 0]),
    );
    let data = client.ask(&request).await.data;
    [6, 14, 22].map(|at| u32::from_le_bytes(data[at..at + 4].try_into().expect("four bytes")))
}

fn instance(reply: &Reply) -> u32 {
    assert!(reply.status.is_success(), "{}", reply.status);
    u32::from_le_bytes(reply.data[..4].try_into().expect("an instance"))
}

#[tokio::test]
async fn a_created_tag_exists_for_all_clients_and_a_deleted_one_for_none() {
    let bench = Bench::new();
    let (mut one, mut other) = (bench.client().await, bench.client().await);
    let before = changes(&mut other).await;
    let reply = create(&mut one, None, "Fresh", "DINT[2,3]", 0).await;
    let fresh = instance(&reply);
    assert_eq!(&reply.data[4..], [0xC4, 0x40], "its type: DINT, two dimensions");
    let after = changes(&mut other).await;
    assert_ne!(before, after);
    assert_eq!(
        other
            .write("fresh[1,2]", Elementary::Dint.into(), &[7, 0, 0, 0])
            .await
            .general(),
        0
    );
    assert_eq!(one.read("Fresh[1,2]").await.data[..], [7, 0, 0, 0]);
    // In a program that there was not, of a structure of the configuration, and not for writing.
    let route = instance(&create(&mut one, Some("Other"), "R", "Route[2]", 2).await);
    assert_eq!(other.read("Program:Other.R[1].Points[1].Id").await.data[..], [0]);
    let refused = other
        .write("Program:Other.R[1].Points[1].Id", Elementary::Sint.into(), &[1])
        .await;
    assert_eq!(codes(refused), (0x0F, 0));
    // Gone again: 0x05 by name and by instance, and the rest is as it was.
    assert_eq!(
        codes(delete(&mut one, None, route).await.status),
        (0x05, 0),
        "in another scope"
    );
    assert!(delete(&mut one, Some("other"), route).await.status.is_success());
    assert!(delete(&mut one, None, fresh).await.status.is_success());
    assert_ne!(changes(&mut other).await, after);
    assert_eq!(codes(other.ask(&read("Fresh", 1)).await.status), (0x05, 0));
    let by_instance = Request::new(
        service::READ_TAG,
        Epath::object(class::SYMBOL, fresh),
        Bytes::from_static(&[1, 0]),
    );
    assert_eq!(codes(other.ask(&by_instance).await.status), (0x05, 0));
    assert_eq!(codes(delete(&mut one, None, fresh).await.status), (0x05, 0));
    assert_eq!(codes(other.ask(&read("Program:Other.R", 1)).await.status), (0x05, 0));
    assert_eq!(other.read("aDint").await.data.len(), 4);
    // No other tag has its id.
    assert_ne!(instance(&create(&mut one, None, "Fresh", "DINT", 0).await), fresh);
}

/// Clients upload the templates that are there: one that nothing uses any more is not.
#[tokio::test]
async fn a_template_goes_with_the_last_tag_that_needs_it() {
    let bench = Bench::of(
        crate::plant::Plant::start(&load(TYPES)).expect("a thread"),
        settings_of("Bench"),
    );
    let mut client = bench.client().await;
    let known = || {
        bench.device.plant.with_image(|image| {
            let own = |name: &str| ["Inner", "Outer"].contains(&name);
            let all = image.templates().filter(|template| own(&template.name));
            all.map(|template| (template.name.clone(), template.instance))
                .collect::<Vec<_>>()
        })
    };
    assert_eq!(known(), []);
    let one = instance(&create(&mut client, None, "One", "Outer", 0).await);
    let other = instance(&create(&mut client, None, "Other", "Outer[2]", 0).await);
    let names: Vec<String> = known().into_iter().map(|(name, _)| name).collect();
    assert_eq!(names, ["Inner", "Outer"]);
    let attributes = |template: u16| {
        let data = Bytes::from_static(&[4, 0, 4, 0, 5, 0, 2, 0, 1, 0]);
        Request::new(
            service::GET_ATTRIBUTE_LIST,
            Epath::object(class::TEMPLATE, template.into()),
            data,
        )
    };
    let instances: Vec<u16> = known().into_iter().map(|(_, instance)| instance).collect();
    assert!(delete(&mut client, None, one).await.status.is_success());
    for template in &instances {
        assert!(client.ask(&attributes(*template)).await.status.is_success());
    }
    assert!(delete(&mut client, None, other).await.status.is_success());
    assert_eq!(known(), []);
    for template in &instances {
        assert_eq!(codes(client.ask(&attributes(*template)).await.status), (0x05, 0));
    }
    // The same type has the same instance again, so the templates in the caches of clients remain valid.
    instance(&create(&mut client, None, "One", "Outer", 0).await);
    assert_eq!(
        known().into_iter().map(|(_, instance)| instance).collect::<Vec<_>>(),
        instances
    );
}

const TYPES: &str = r#"
[[data_type]]
name = "Inner"
members = [{ name = "A", type = "DINT" }]
[[data_type]]
name = "Outer"
members = [{ name = "In", type = "Inner[2]" }, { name = "B", type = "REAL" }]
"#;

#[tokio::test]
async fn tags_that_cannot_be_created_or_deleted_have_their_status_and_change_nothing() {
    let bench = Bench::new();
    let mut client = bench.client().await;
    let long = "x".repeat(41);
    let before = changes(&mut client).await;
    #[rustfmt::skip]
    let cases: [(Option<&str>, &str, &str, u8, u8); 15] = [
        (None, "aDint", "DINT", 0, 0x0D), (None, "ADINT", "REAL", 0, 0x0D), (None, "X", "DINT", 0, 0x0D),
        (Some("Main"), "Count", "DINT", 0, 0x0D),
        (None, "", "DINT", 0, 0x20), (None, "1st", "DINT", 0, 0x20), (None, &long, "DINT", 0, 0x20),
        (None, "a.b", "DINT", 0, 0x20), (Some("a b"), "New", "DINT", 0, 0x20),
        (None, "New", "NOTHING", 0, 0x20), (None, "New", "DINT[0]", 0, 0x20), (None, "New", "DINT[1,2,3,4]", 0, 0x20),
        (None, "New", "LREAL[65535,65535]", 0, 0x20), (None, "New", "AXIS_VIRTUAL", 0, 0x20),
        (None, "New", "DINT", 3, 0x20),
    ];
    for (program, name, data_type, access, expected) in cases {
        let reply = create(&mut client, program, name, data_type, access).await;
        assert_eq!(codes(reply.status), (expected, 0), "{name} {data_type} {access}");
    }
    // The group, an axis and an instruction tag stay, as do the base tag of an alias and a read-only tag.
    let (mut axis, mut based, mut read_only) = (0, 0, 0);
    bench.device.plant.with_image(|image| {
        let id = |name: &str| image.find(name).map_or(0, |tag| tag.id.0);
        (axis, based, read_only) = (id("X"), id("Routes"), id("Program:Main.aDint"));
    });
    assert_eq!(codes(delete(&mut client, None, 1).await.status), (0x0F, 0));
    assert_eq!(codes(delete(&mut client, None, axis).await.status), (0x0F, 0));
    assert_eq!(codes(delete(&mut client, None, based).await.status), (0x0C, 0));
    assert_eq!(
        codes(delete(&mut client, Some("Main"), read_only).await.status),
        (0x0F, 0)
    );
    assert_eq!(codes(delete(&mut client, None, 0).await.status), (0x08, 0));
    assert_eq!(codes(delete(&mut client, None, u32::MAX).await.status), (0x05, 0));
    // Cut at every byte, and with a byte behind it.
    let whole = CreateSymbol {
        name: "New".to_owned(),
        data_type: "DINT".to_owned(),
        access: 0,
    }
    .to_bytes();
    for cut in 0..whole.len() {
        let request = Request::new(service::CREATE, scoped(None, 0), whole.slice(..cut));
        assert_eq!(codes(client.ask(&request).await.status), (0x13, 0), "cut at {cut}");
    }
    let longer = Bytes::from([&whole[..], &[9]].concat());
    let reply = client
        .ask(&Request::new(service::CREATE, scoped(None, 0), longer))
        .await;
    assert_eq!(codes(reply.status), (0x15, 0));
    assert_eq!(changes(&mut client).await, before);
}

#[tokio::test]
async fn the_number_and_the_size_of_tags_are_bounded() {
    let bench = Bench::new();
    let mut client = bench.client().await;
    // 64 MiB at 512 KiB each.
    let mut made = Vec::new();
    let full = loop {
        let reply = create(&mut client, None, &format!("Big{}", made.len()), "DINT[65535,2]", 0).await;
        if !reply.status.is_success() {
            break reply.status;
        }
        made.push(instance(&reply));
        assert!(made.len() < 200, "no bound");
    };
    assert_eq!((codes(full), made.len()), ((0x02, 0), 127));
    for id in made {
        assert!(delete(&mut client, None, id).await.status.is_success());
    }
    let mut count = 0;
    let full = loop {
        let reply = create(&mut client, None, &format!("Small{count}"), "BOOL", 0).await;
        if !reply.status.is_success() {
            break reply.status;
        }
        count += 1;
        assert!(count <= 4096, "no bound");
    };
    assert_eq!(codes(full), (0x02, 0));
}

fn load(tags: &str) -> Project {
    arcline_config::load(&format!("{}{tags}", arcline_config::DEFAULT), "test").expect("a valid configuration")
}

const BEFORE: &str = r#"
[[data_type]]
name = "Pair"
members = [{ name = "A", type = "DINT" }, { name = "B", type = "DINT" }]
[[tag]]
name = "Stays"
type = "Pair"
[[tag]]
name = "Goes"
type = "DINT"
[[tag]]
name = "Wider"
type = "INT"
[[tag]]
name = "Locked"
type = "DINT"
[[instruction]]
tag = "MoveOld"
type = "MCLM"
target = "CS1"
"#;

const AFTER: &str = r#"
[[data_type]]
name = "First"
members = [{ name = "A", type = "REAL" }]
[[data_type]]
name = "Pair"
members = [{ name = "A", type = "DINT" }, { name = "B", type = "DINT" }]
[[tag]]
name = "New"
type = "First[3]"
[[tag]]
name = "Wider"
type = "DINT"
[[tag]]
name = "Stays"
type = "Pair"
[[tag]]
name = "Locked"
type = "DINT"
access = "read_only"
value = 5
[[instruction]]
tag = "MoveNew"
type = "MCLM"
target = "XY"
"#;

#[tokio::test]
async fn another_configuration_changes_its_differences_and_nothing_else() {
    let (before, after) = (load(BEFORE), load(AFTER));
    let bench = Bench::of(
        crate::plant::Plant::start(&before).expect("a thread"),
        settings_of("Bench"),
    );
    let plant = bench.device.plant.clone();
    let mut client = bench.client().await;
    assert_eq!(
        client
            .write("Stays.B", Elementary::Dint.into(), &[9, 0, 0, 0])
            .await
            .general(),
        0
    );
    instance(&create(&mut client, None, "Mine", "DINT", 0).await);
    let look = |name: &str| plant.with_image(|image| image.find(name).map(|tag| (tag.id, tag.symbol_type())));
    let (stays, wider, mine) = (look("Stays"), look("Wider"), look("Mine"));
    let seen = changes(&mut client).await;
    plant.reload(&before, &after).await.expect("the same machine");
    let now = changes(&mut client).await;
    assert!(seen.iter().zip(&now).all(|(seen, now)| seen != now), "{seen:?} {now:?}");
    // The same id, the same template, the same bytes.
    assert_eq!((look("Stays"), look("Mine")), (stays, mine));
    assert_eq!(client.read("Stays.B").await.data[..], [9, 0, 0, 0]);
    assert_ne!(look("Wider"), wider, "of another type: another tag");
    assert_eq!((look("Goes"), look("MoveOld")), (None, None));
    assert_eq!(codes(client.ask(&read("Goes", 1)).await.status), (0x05, 0));
    assert_eq!(client.read("New[2].A").await.data[..], [0; 4]);
    assert_eq!(client.read("Locked").await.data[..], [5, 0, 0, 0]);
    assert_eq!(
        codes(client.write("Locked", Elementary::Dint.into(), &[1, 0, 0, 0]).await),
        (0x0F, 0)
    );
    // The new instruction tag moves.
    let position = write(
        "MoveNew.Position[0]",
        Elementary::Real.into(),
        1,
        &2.5_f32.to_le_bytes(),
    );
    assert!(client.ask(&position).await.status.is_success());
    assert_eq!(
        client
            .write("MoveNew.EnableIn", Elementary::Bool.into(), &[1])
            .await
            .general(),
        0
    );
    assert_eq!(client.read("MoveNew.DN").await.data[..], [1]);
    // The same configuration again: nothing changes, and no client needs to browse again.
    plant.reload(&after, &after).await.expect("the same");
    assert_eq!(changes(&mut client).await, now);
    // And back.
    plant.reload(&after, &before).await.expect("the same machine");
    assert_eq!(look("Stays"), stays);
    assert!(look("Goes").is_some() && look("New").is_none() && look("MoveOld").is_some());
}

#[tokio::test]
async fn keys_that_need_a_restart_are_named_and_change_nothing() {
    let before = load(BEFORE);
    let bench = Bench::of(
        crate::plant::Plant::start(&before).expect("a thread"),
        settings_of("Bench"),
    );
    let plant = bench.device.plant.clone();
    let mut client = bench.client().await;
    let seen = changes(&mut client).await;
    let mut other = load(AFTER);
    other.machine.axes[1].max_speed += 1.0;
    other.machine.systems[0].queue_depth += 1;
    other.machine.period_ns *= 2;
    other.server.name = "Other".to_owned();
    let refused = plant.reload(&before, &other).await.expect_err("it needs a restart");
    assert_eq!(
        refused.to_string(),
        "Reload refused: [server], [motion_group], axis Y, coordinate system CS1 changed, which needs a restart"
    );
    assert!(matches!(refused, ReloadError::NeedsRestart { .. }));
    // A name that another object has.
    let taken = load("[[tag]]\nname = \"M1\"\ntype = \"DINT\"\n");
    let call = Call {
        mnemonic: Mnemonic::Mcs,
        target: Some(0),
        control: Some("M1"),
        operands: &[],
        text: None,
    };
    let called = plant.apply(Principal::Server, Command::Call(call)).await;
    assert!(matches!(called, Ok(Outcome::Executed(_))), "{called:?}");
    let seen_then = changes(&mut client).await;
    assert_ne!(seen, seen_then);
    let refused = plant.reload(&before, &taken).await.expect_err("a motion control tag");
    assert_eq!(refused.to_string(), "Reload refused: there is a tag M1 already");
    assert_eq!(changes(&mut client).await, seen_then);
    assert_eq!(client.read("Stays.B").await.data.len(), 4);
}
