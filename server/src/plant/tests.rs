//! The plant on the real thread, and its records.

use arcline_controller::Ticket;
use arcline_controller::image::WriteError;
use arcline_instruction_set::Flag;

use super::records::{Executions, Origin, RECORDS};
use super::*;
use arcline_instruction_set::{Mnemonic, UnboundOperand};

pub(super) fn project() -> Project {
    arcline_config::load(arcline_config::DEFAULT, "default").expect("the default is valid")
}

fn number(plant: &Plant, path: &str) -> f64 {
    let path = path.parse().expect("a path");
    plant
        .with_image(|image| image.read(&path))
        .unwrap_or_else(|error| panic!("{path}: {error}"))
        .as_f64()
}

/// A client without connection.
const CLIENT: Principal = Principal::Client {
    session: 1,
    connection: 0,
};

fn write(plant: &Plant, values: &[(&str, f64)]) -> Pending {
    let (result, pending) = plant.transact(CLIENT, |transaction| {
        for (path, value) in values {
            let path = path.parse().expect("a path");
            transaction.write_value(&path, arcline_tag::Value::Lreal(*value))?;
        }
        Ok::<_, Refused>(())
    });
    result.expect("writable");
    pending
}

async fn call(
    plant: &Plant,
    mnemonic: Mnemonic,
    control: Option<&str>,
    operands: &[UnboundOperand],
) -> Result<Executed, Refused> {
    let call = Call {
        mnemonic,
        target: Some(0),
        control,
        operands,
        text: None,
    };
    match plant.apply(CLIENT, Command::Call(call)).await? {
        Outcome::Executed(executed) => Ok(executed),
        other => panic!("{other:?}"),
    }
}

async fn wait(plant: &Plant, path: &str) {
    wait_for(plant, path, |number| number != 0.0).await;
}

async fn wait_while(plant: &Plant, path: &str) {
    wait_for(plant, path, |number| number == 0.0).await;
}

async fn wait_for(plant: &Plant, path: &str, is: impl Fn(f64) -> bool) {
    let waits = async {
        while !is(number(plant, path)) {
            tokio::time::sleep(Duration::from_millis(1)).await;
        }
    };
    tokio::time::timeout(Duration::from_secs(30), waits)
        .await
        .unwrap_or_else(|_| panic!("{path} stays {}", number(plant, path)));
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_written_enable_in_moves_to_the_exact_end() {
    let (plant, handle) = Plant::start(&project()).expect("a thread");
    plant.roles().set(1, Role::Engineer);
    let edges = write(
        &plant,
        &[
            ("Move1.Position[0]", 20.0),
            ("Move1.Position[1]", 10.0),
            ("Move1.EnableIn", 1.0),
        ],
    );
    plant.complete(edges).await.expect("no tag is retained");
    assert_eq!(
        ["EN", "DN", "IP"].map(|bit| number(&plant, &format!("Move1.{bit}"))),
        [1.0; 3],
        "shown when it returns"
    );
    wait(&plant, "Move1.PC").await;
    assert_eq!(
        [number(&plant, "X.CommandPosition"), number(&plant, "Y.CommandPosition")],
        [20.0, 10.0]
    );
    assert_eq!(plant.newest_instance(), Some(1));
    let control = plant.instruction_instance(1).expect("it is kept");
    assert!(control.has(Flag::Pc) && !control.has(Flag::Ip));
    assert!(plant.health().ticks > 0);
    handle.stop();
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn refusals_are_shown() {
    let (plant, handle) = Plant::start(&project()).expect("a thread");
    plant.roles().set(1, Role::Engineer);
    let speed = write(&plant, &[("Move1.Speed", -1.0), ("Move1.EnableIn", 1.0)]);
    plant.complete(speed).await.expect("no tag is retained");
    assert_eq!(
        ["ER", "ERR", "EXERR"].map(|name| number(&plant, &format!("Move1.{name}"))),
        [1.0, 13.0, 4.0]
    );

    let target = write(&plant, &[("Move2.CoordinateSystem.LEN", 1.0), ("Move2.EnableIn", 1.0)]);
    plant.complete(target).await.expect("no tag is retained");
    assert_eq!(
        ["ER", "ERR", "EXERR"].map(|name| number(&plant, &format!("Move2.{name}"))),
        [1.0, 13.0, 0.0]
    );

    let executed = call(&plant, Mnemonic::Mso, Some("Servo"), &[]).await.expect("it binds");
    assert!(executed.control.has(Flag::Dn) && !executed.control.has(Flag::Er));
    assert_eq!((executed.instance, number(&plant, "Servo.DN")), (3, 1.0));

    let wrong = call(&plant, Mnemonic::Mso, Some("X"), &[]).await;
    assert!(
        matches!(wrong, Err(Refused::Call(CallRefused::Control(_)))),
        "{wrong:?}"
    );
    let many = call(&plant, Mnemonic::Mso, Some("Fresh"), &[UnboundOperand::Integer(1)]).await;
    assert!(matches!(many, Err(Refused::Call(CallRefused::Bind(_)))), "{many:?}");
    assert!(
        plant.with_image(|image| image.find("Fresh").is_none()),
        "a refused call makes no tag"
    );
    assert_eq!(plant.newest_instance(), Some(3), "and no instance");
    handle.stop();
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn every_execution_of_a_tag_begins_enabled() {
    let (plant, handle) = Plant::start(&project()).expect("a thread");
    plant.roles().set(1, Role::Engineer);
    for _ in 0..2 {
        let executed = call(&plant, Mnemonic::Mcs, Some("Again"), &[]).await.expect("a stop");
        assert!(executed.control.has(Flag::En) && executed.control.has(Flag::Dn));
    }
    handle.stop();
}

#[test]
fn the_newest_executions_are_kept() {
    let mut records = Executions::default();
    assert_eq!(
        (records.newest(), records.count(), records.by_instance(0)),
        (None, 0, None)
    );
    for ticket in 1..=RECORDS as u64 + 10 {
        let origin = Origin {
            principal: CLIENT,
            client: Arc::new(ClientIdentity::of_address("a client", None)),
            text: None,
        };
        records.begin(Ticket(ticket), None, origin);
        let updated = records.update(Ticket(ticket), |control| {
            control.set(Flag::Dn);
            control.err = (ticket % 100) as i16;
        });
        assert_eq!(updated, Some(()), "the newest");
    }
    assert_eq!(
        (records.count(), records.newest()),
        (RECORDS, Some(Ticket(RECORDS as u64 + 10)))
    );
    #[rustfmt::skip]
    let cases = [(0, None), (10, None), (11, Some(11)), (RECORDS as u32 + 10, Some(6)), (RECORDS as u32 + 11, None), (u32::MAX, None)];
    for (instance, err) in cases {
        assert_eq!(
            records.by_instance(instance).map(|control| control.err),
            err,
            "{instance}"
        );
    }
    assert!(records.get(Ticket(10)).is_none() && records.get(Ticket(5000)).is_none());
}

/// The record of an execution that runs outlasts the ring. Behind its end it stays until as many others have ended. After lost changes of status,
/// when no record can tell whether its execution runs, the ring alone keeps records.
#[test]
fn executions_that_run_are_kept() {
    let origin = Origin {
        principal: CLIENT,
        client: Arc::default(),
        text: Some("MAM".into()),
    };
    let mut records = Executions::default();
    let mut ticket = 0;
    let mut begin = |records: &mut Executions, flag| {
        ticket += 1;
        records.begin(Ticket(ticket), Some(3), origin.clone());
        records.update(Ticket(ticket), |control| {
            control.set(Flag::Dn);
            control.set(flag);
        });
        Ticket(ticket)
    };
    let end = |records: &mut Executions, ticket| records.update(ticket, |control| control.clear(Flag::Ip));
    let running: Vec<Ticket> = (0..RECORDS + 2).map(|_| begin(&mut records, Flag::Ip)).collect();
    let first = running[0];
    for _ in 0..2 * RECORDS {
        begin(&mut records, Flag::Pc);
    }
    assert_eq!(records.count(), 2 * RECORDS + 2);
    assert!(records.may_run(first) && records.get(first).is_some());
    assert_eq!(records.target(first), Some(3));
    assert_eq!(records.origin(first), Some(&origin));
    assert!(records.by_instance(instance_of(first)).is_some());
    assert_eq!(end(&mut records, first), Some(()));
    assert!(!records.may_run(first), "it has ended");
    assert!(records.get(first).is_some(), "its end is known");
    for ticket in &running[1..] {
        end(&mut records, *ticket);
    }
    assert!(records.get(first).is_none(), "dropped behind as many ends");
    assert!(!records.may_run(first));
    assert_eq!(records.count(), 2 * RECORDS);

    let lost = begin(&mut records, Flag::Ip);
    records.changes_lost();
    assert_eq!(records.count(), RECORDS);
    for _ in 0..RECORDS {
        begin(&mut records, Flag::Pc);
    }
    assert!(records.get(lost).is_none());
    assert!(records.may_run(lost), "as far as is known");
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn an_override_holds_and_resumes() {
    let (plant, handle) = Plant::start(&project()).expect("a thread");
    plant.roles().set(1, Role::Engineer);
    let held = write(
        &plant,
        &[
            ("FeedOverride[0]", 0.0),
            ("Move1.Position[0]", 20.0),
            ("Move1.EnableIn", 1.0),
        ],
    );
    plant.complete(held).await.expect("no tag is retained");
    assert_eq!(
        ["IP", "AC", "PC"].map(|bit| number(&plant, &format!("Move1.{bit}"))),
        [1.0, 1.0, 0.0]
    );
    let ticks = plant.health().ticks;
    while plant.health().ticks < ticks + 100 {
        tokio::task::yield_now().await;
    }
    assert_eq!(number(&plant, "X.CommandPosition"), 0.0, "held");
    let resumed = write(&plant, &[("FeedOverride[0]", 100.0)]);
    plant.complete(resumed).await.expect("no tag is retained");
    wait(&plant, "Move1.PC").await;
    assert_eq!(number(&plant, "X.CommandPosition"), 20.0);
    handle.stop();
}

/// The controller takes no command: the queue is bounded, and a full queue is an answer.
#[tokio::test(start_paused = true)]
async fn commands_without_room_are_refused_and_change_nothing() {
    let project = project();
    let (_rings, link) = arcline_realtime::link(&project.machine);
    let plant = Plant::new(&project, link);
    plant.roles().set(1, Role::Engineer);
    let path: arcline_tag::TagPath = "Move1.EnableIn".parse().expect("a path");
    let (mut accepted, mut refused) = (0, 0);
    for _ in 0..2000 {
        for on in [1.0, 0.0] {
            let (result, written) = plant.transact(CLIENT, |transaction| {
                transaction.write_value(&path, arcline_tag::Value::Lreal(on))
            });
            match result {
                Ok(_) => accepted += u32::from(on == 1.0),
                Err(Refused::Write(WriteError::NoRoom { .. })) => {
                    refused += 1;
                    assert_eq!(number(&plant, "Move1.EnableIn"), 0.0, "nothing has changed");
                }
                Err(error) => panic!("{error}"),
            }
            plant.complete(written).await.expect("no tag is retained");
        }
    }
    // False rungs stand in the same ring.
    assert!((256..=OUTSTANDING as u32).contains(&accepted), "{accepted}");
    assert_eq!(accepted + refused, 2000);
    let free = plant.0.lock().link.commands.stop_slots();
    assert_eq!(free, arcline_realtime::STOPS, "room for stops is left");
    assert_eq!(plant.count(Counter::Writes).refused, u64::from(refused));
    assert_eq!(
        call(&plant, Mnemonic::Mso, None, &[]).await,
        Err(CallRefused::Busy.into())
    );
    // The plant sends it, and the controller does not answer.
    assert_eq!(
        call(&plant, Mnemonic::Mgs, None, &[UnboundOperand::Number(0.0)]).await,
        Err(CallRefused::NoAnswer.into())
    );
    plant.stop_all();
}

/// Packets that toggle a stop fill no more of the ring than leaves single requests their stops.
#[tokio::test(start_paused = true)]
async fn packets_of_stops_leave_room_for_the_stops_of_others() {
    let project = project();
    let (_rings, link) = arcline_realtime::link(&project.machine);
    let plant = Plant::new(&project, link);
    plant.roles().set(1, Role::Engineer);
    let path: arcline_tag::TagPath = "Stop1.EnableIn".parse().expect("a path");
    let write = |transaction: &mut Transaction<'_>, on| transaction.write_value(&path, arcline_tag::Value::Lreal(on));
    let mut accepted = 0;
    for _ in 0..50 {
        let (taken, pending) = plant.transact(CLIENT, |transaction| {
            transaction.of_packet();
            (0..20)
                .filter(|_| write(transaction, 1.0).and(write(transaction, 0.0)).is_ok())
                .count()
        });
        accepted += taken;
        drop(pending);
    }
    assert_eq!(accepted, arcline_realtime::STOPS / 4);
    for _ in 0..arcline_realtime::STOPS / 8 {
        for on in [1.0, 0.0] {
            let (result, pending) = plant.transact(CLIENT, |transaction| write(transaction, on));
            assert!(result.is_ok(), "{result:?}");
            drop(pending);
        }
    }
}

/// Every kind of STOP: the controller refuses new motion with 53 until the release, and everything else goes on.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn stop_inhibits_motion_until_it_is_released() {
    let (plant, handle) = Plant::start(&project()).expect("a thread");
    plant.roles().set(1, Role::Engineer);
    let far = [
        ("Move1.Position[0]", 500.0),
        ("Move1.Position[1]", 0.0),
        ("Move1.EnableIn", 1.0),
    ];
    for way in ["the plant", "a command", "the tag"] {
        let began = write(&plant, &far);
        plant.complete(began).await.expect("no tag is retained");
        assert_eq!(
            ["ER", "ERR"].map(|bit| number(&plant, &format!("Move1.{bit}"))),
            [0.0, 0.0],
            "{way}"
        );
        match way {
            "the plant" => plant.inhibit(),
            "a command" => assert_eq!(plant.apply(CLIENT, Command::Inhibit).await, Ok(Outcome::Done)),
            _ => drop(write(&plant, &[("MotionInhibit", 1.0)])),
        }
        assert!(plant.is_inhibited(), "{way}");
        wait(&plant, "MotionInhibit").await;
        // The contour ends at once, and its axes stop, each on its own.
        for bit in ["Move1.IP", "X.StoppingStatus", "Y.StoppingStatus"] {
            wait_while(&plant, bit).await;
        }
        let again = write(&plant, &[("Move1.EnableIn", 0.0), ("Move1.EnableIn", 1.0)]);
        plant.complete(again).await.expect("no tag is retained");
        assert_eq!(
            ["ER", "ERR", "IP"].map(|bit| number(&plant, &format!("Move1.{bit}"))),
            [1.0, 53.0, 0.0],
            "{way}: EnableIn"
        );
        let jog = [0.0, 50.0, 0.0, 5000.0, 0.0, 5000.0, 0.0].map(UnboundOperand::Number);
        let jogged = call(&plant, Mnemonic::Maj, None, &jog).await.expect("it binds");
        assert_eq!(jogged.control.err, 53, "{way}: a service");
        let stopped = call(&plant, Mnemonic::Mcs, None, &[]).await.expect("it binds");
        assert_eq!(stopped.control.err, 0, "{way}: a stop is no motion");
        match way {
            "the tag" => drop(write(&plant, &[("MotionInhibit", 0.0)])),
            _ => assert_eq!(plant.apply(CLIENT, Command::Release).await, Ok(Outcome::Done)),
        }
        assert!(!plant.is_inhibited(), "{way}");
        drop(write(&plant, &[("Move1.EnableIn", 0.0)]));
        wait_while(&plant, "MotionInhibit").await;
    }
    // A stop of everything that is no STOP, as that of the outputs of I/O, inhibits nothing.
    plant.stop_all();
    assert!(!plant.is_inhibited());
    handle.stop();
}

/// A jog button moves no axis that another principal moves: refused under the lock under which it would begin, as its own tag or
/// another client's, and with the axis of a coordinate system too.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_jog_button_is_refused_on_an_axis_that_another_principal_moves() {
    let (plant, handle) = Plant::start(&project()).expect("a thread");
    plant.roles().set(1, Role::Engineer);
    plant.control().enter(7, "viewer".into());
    plant.roles().set(crate::guard::VIEWERS | 7, Role::Engineer);
    let taken = plant
        .control()
        .take(plant.machine(), 7, control::MotionObject::Group, false);
    assert_eq!(taken, Ok(()));
    let jog = [0.0, 1.0, 0.0, 5000.0, 0.0, 5000.0, 0.0].map(UnboundOperand::Number);
    let press = || {
        let call = Call {
            mnemonic: Mnemonic::Maj,
            target: Some(0),
            control: None,
            operands: &jog,
            text: None,
        };
        plant.apply(Principal::Button(7), Command::Call(call))
    };
    let far = [
        ("Move1.Position[0]", 500.0),
        ("Move1.Position[1]", 0.0),
        ("Move1.EnableIn", 1.0),
    ];
    plant.complete(write(&plant, &far)).await.expect("no tag is retained");
    let mover = Mover {
        principal: CLIENT,
        client: Arc::default(),
    };
    let refused = Refused::MovedByAnother {
        object: "X".into(),
        mover: mover.clone(),
    };
    assert_eq!(
        refused.to_string(),
        "X is moved by a client; it can be jogged when that motion has ended"
    );
    assert_eq!(press().await, Err(refused));
    let [x, system, other] = ["X", "CS1", "CS2"].map(|name| control::MotionObject::find(plant.machine(), name));
    for (object, expected) in [(x, Some(&mover)), (system, Some(&mover)), (other, None)] {
        let movers = plant.movers();
        let found = match object {
            Some(control::MotionObject::Axis(axis)) => movers.of_axis(axis),
            Some(control::MotionObject::System(system)) => movers.of_system(system),
            other => panic!("{other:?}"),
        };
        assert_eq!(found, expected, "{object:?}");
        assert_eq!(plant.view(|view| view.movers.clone()), movers);
    }
    let stopped = call(&plant, Mnemonic::Mcs, None, &[]).await.expect("it binds");
    assert_eq!(stopped.control.err, 0);
    wait_while(&plant, "CS1.MotionStatus").await;
    wait_while(&plant, "Move1.IP").await;
    let jogged = press().await;
    assert!(matches!(jogged, Ok(Outcome::Executed(_))), "{jogged:?}");
    assert!(
        matches!(press().await, Ok(Outcome::Executed(_))),
        "its own jog is no obstacle"
    );
    plant.stop_all();
    handle.stop();
}

/// Waits for a step with a tag; returns its changes.
async fn step_with(changes: &mut Changes, tag: arcline_controller::image::TagId) -> TagChanges {
    loop {
        let step = changes.next().await.expect("the plant is there");
        if step.has(tag) {
            return step;
        }
    }
}

#[tokio::test]
async fn changes_tell_the_tags_that_changed() {
    let project = project();
    let (_rings, link) = arcline_realtime::link(&project.machine);
    let plant = Plant::new(&project, link);
    plant.roles().set(1, Role::Engineer);
    let id = |name: &str| plant.with_image(|image| image.find(name).expect(name).id);
    let (speed, inhibit) = (id("Move1"), id("MotionInhibit"));
    drop(write(&plant, &[("Move1.Speed", 1.0)]));
    let mut quick = plant.changes();
    let mut slow = plant.changes();
    for round in 0..5 {
        drop(write(&plant, &[("Move1.Speed", f64::from(round) + 10.0)]));
        let step = quick.next().await.expect("the plant is there");
        assert_eq!((step.steps, &step.tags[..]), (1, &[speed][..]), "{round}");
    }
    drop(write(&plant, &[("MotionInhibit", 1.0)]));
    assert_eq!(step_with(&mut quick, inhibit).await.tags, [inhibit]);
    let missed = slow.next().await.expect("the plant is there");
    assert!(missed.has(speed) && missed.has(inhibit), "{missed:?}");
    assert!(missed.steps >= 6, "it learns that it was slow: {missed:?}");
    drop(write(&plant, &[("Move1.Speed", 14.0)]));
    let none = tokio::time::timeout(Duration::from_millis(1), slow.next()).await;
    assert!(
        none.map_or(true, |step| step.is_some_and(|step| step.tags.is_empty())),
        "as it was before"
    );
    drop(plant);
    while slow.next().await.is_some() {}
}
