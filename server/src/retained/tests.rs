//! The take-over of a state, the detection of changes, and the answer to a write that cannot be stored.

use arcline_controller::{AxisSnapshot, Snapshot};
use arcline_instruction_set::predefined::{axis_status, cip_axis_status, motion_status};
use arcline_instruction_set::{Mnemonic, UnboundOperand};
use arcline_realtime::Handle;
use arcline_state::{Change, Record};
use arcline_tag::{Elementary, TagType, Value};

use super::state_writer::{Job, JobQueue, RecordSender};
use super::*;
use crate::plant::{Call, Command, Outcome, Plant, Principal};

const TAGS: &str = r#"
[[tag]]
name = "Recipe"
type = "REAL[4]"
[[tag]]
name = "Count"
type = "DINT"
"#;

fn project() -> Project {
    let text = format!("{}{TAGS}", arcline_config::DEFAULT);
    arcline_config::load(&text, "test").expect("a valid configuration")
}

fn axis(name: &str, kind: &str, state: AxisState) -> Axis {
    let (name, kind) = (name.to_owned(), kind.to_owned());
    Axis { name, kind, state }
}

fn tag(name: &str, kind: &str, bytes: &[u8]) -> Tag {
    let (name, kind, bytes) = (name.to_owned(), kind.to_owned(), bytes.to_vec());
    Tag { name, kind, bytes }
}

fn at(position: f64, moving: bool) -> AxisState {
    AxisState {
        position,
        homed: true,
        moving,
        ..AxisState::default()
    }
}

#[test]
fn axes_and_tags_of_the_same_name_and_type_are_taken_over() {
    let state = RetainedState {
        axes: vec![
            axis(
                "x",
                "servo, mm",
                AxisState {
                    faults: 1 << 31 | 8,
                    redefined: 2.5,
                    ..at(12.5, false)
                },
            ),
            axis("Y", "servo, mm", at(-3.0, true)),
            axis("Z", "servo, in", at(1.0, false)),
            axis("A", "servo, mm", at(1.0, false)),
            axis("W", "servo, mm", at(1.0, false)),
        ],
        tags: vec![
            tag("COUNT", "DINT", &7_i32.to_le_bytes()),
            tag("Recipe", "REAL[3]", &[0; 12]),
            tag("X", "DINT", &[0; 4]),
            tag("Gone", "DINT", &[0; 4]),
        ],
    };
    let mut project = project();
    let configured = project.machine.clone();
    let mut image = project.image();
    assert!(!is_foreign(&state, &project, &image));
    let taken = take_over(&state, &mut project, &mut image);
    let left = [
        "axis Z (servo, in)",
        "axis A (servo, mm)",
        "axis W (servo, mm)",
        "tag Recipe (REAL[3])",
        "tag X (DINT)",
        "tag Gone (DINT)",
    ];
    assert_eq!(taken.left, left);
    assert_eq!(taken.moving, ["Y"]);
    let starts: Vec<machine::StartState> = project.machine.axes.iter().map(|axis| axis.start).collect();
    let off = |position, homed| machine::StartState {
        position,
        servo_on: false,
        homed,
        ..machine::StartState::default()
    };
    let first = machine::StartState {
        faults: FaultSet::from_bits(8),
        redefined: 2.5,
        ..off(12.5, true)
    };
    assert_eq!(starts[..2], [first, off(-3.0, false)]);
    for (start, axis) in starts.iter().zip(&configured.axes).skip(2) {
        assert_eq!(*start, axis.start, "{} is as configured", axis.name);
    }
    let count = image.read(&"Count".parse().expect("a path"));
    assert_eq!(count, Ok(Value::Dint(7)));
}

#[test]
fn states_of_other_machines_are_foreign() {
    let only = |axes, tags| is_foreign(&RetainedState { axes, tags }, &project(), &project().image());
    let elsewhere = || vec![axis("Arm", "servo, deg", at(0.0, false))];
    assert!(only(elsewhere(), vec![tag("Speed", "REAL", &[0; 4])]));
    assert!(
        only(vec![axis("X", "servo, in", at(0.0, false))], vec![]),
        "other units"
    );
    assert!(!only(elsewhere(), vec![tag("count", "DINT", &[0; 4])]));
    assert!(!only(vec![], vec![]), "nothing was kept: nothing to lose");
    let own = || vec![tag("Own", "created, DINT", &[0; 4])];
    assert!(only(elsewhere(), own()), "its axes are of another machine");
    assert!(!only(vec![], own()), "clients create tags on any machine");
}

#[test]
fn a_rotary_axis_is_kept_with_its_turn() {
    let mut project = project();
    let table = &mut project.machine.axes[0];
    assert_eq!(axis_kind(table), "servo, mm");
    (table.units, table.unwind, table.kind) = ("deg".to_owned(), Some(360.0), machine::AxisKind::Virtual);
    let kind = axis_kind(table);
    assert_eq!(kind, "virtual, deg, unwind 360");
    for (position, taken) in [(0.0, true), (359.9, true), (360.0, false), (-0.1, false)] {
        let axes = vec![axis("X", &kind, at(position, false))];
        let (state, mut project) = (RetainedState { axes, tags: vec![] }, project.clone());
        let mut image = project.image();
        let left = take_over(&state, &mut project, &mut image).left;
        assert_eq!(left.is_empty(), taken, "{position}");
        assert_eq!(
            project.machine.axes[0].start.position,
            if taken { position } else { 0.0 }
        );
    }
}

const ON: u32 = axis_status::SERVO_ACTION_STATUS | axis_status::DRIVE_ENABLE_STATUS;
const RESTS: u32 = cip_axis_status::VELOCITY_STANDSTILL_STATUS | cip_axis_status::POSITION_LOCK_STATUS;

/// An axis that is on and rests.
fn resting(position: f64) -> AxisSnapshot {
    AxisSnapshot {
        status: ON,
        motion_status: motion_status::AXIS_HOMED_STATUS,
        cip_status: RESTS,
        command: [position, 0.0, 0.0],
        actual: [position, 0.0, 0.0],
        ..AxisSnapshot::default()
    }
}

fn moving(position: f64) -> AxisSnapshot {
    AxisSnapshot {
        motion_status: motion_status::AXIS_HOMED_STATUS | motion_status::COORDINATED_MOTION_STATUS,
        cip_status: cip_axis_status::POSITION_LOCK_STATUS,
        command: [position + 0.01, 20.0, 0.0],
        actual: [position, 20.0, 0.0],
        ..resting(position)
    }
}

/// A tracker of one axis that rests at 0, and the messages that it sends.
fn watch() -> (ChangeTracker, JobQueue) {
    let (sender, queue) = RecordSender::channel();
    let axis = Axis {
        name: "X".to_owned(),
        kind: String::new(),
        state: at(0.0, false),
    };
    (
        ChangeTracker::new(sender, vec![axis], KeptTags::default(), 1_000_000),
        queue,
    )
}

fn show(watch: &mut ChangeTracker, tick: u64, axis: AxisSnapshot) {
    let (axes, snapshot) = (vec![axis], Snapshot::default());
    watch.axes(&Snapshot { tick, axes, ..snapshot });
}

/// The axis in the sent message; the disk has it at once.
fn sent(jobs: &JobQueue) -> Option<AxisState> {
    let Some(Job::Write(Record::Changes(changes), answer)) = jobs.try_next() else {
        return None;
    };
    let [Change::Axis { axis: 0, state }] = changes[..] else {
        panic!("{changes:?}")
    };
    answer.send(Ok(())).expect("the watch waits for it");
    Some(state)
}

#[test]
fn the_beginning_and_the_end_of_motion_are_sent_at_once_positions_now_and_then() {
    let (mut watch, jobs) = watch();
    let mut look = |tick, axis| {
        show(&mut watch, tick, axis);
        sent(&jobs)
    };
    assert_eq!(look(1, resting(0.0)), None, "nothing new");
    assert_eq!(look(50, moving(0.5)), Some(at(0.5, true)), "it began to move");
    assert_eq!(look(51, moving(0.6)), None);
    assert_eq!(look(100, moving(9.9)), None);
    assert_eq!(
        look(101, moving(10.0)),
        Some(at(10.0, true)),
        "100 ms after the last time"
    );
    assert_eq!(look(102, moving(10.1)), None);
    assert_eq!(look(103, resting(10.2)), Some(at(10.2, false)), "it came to rest");
    assert_eq!(look(104, resting(10.2)), None);
    assert_eq!(
        look(105, resting(0.0)),
        Some(at(0.0, false)),
        "its position was redefined"
    );
    let mut faulted = resting(0.0);
    faulted.faults = FaultSet::from_bits(8);
    faulted.redefined = -10.2;
    let expected = AxisState {
        faults: 8,
        redefined: -10.2,
        ..at(0.0, false)
    };
    assert_eq!(look(106, faulted), Some(expected));
}

#[test]
fn an_axis_at_rest_is_where_its_drive_holds_it() {
    let lagging = |position: f64, actual: f64| AxisSnapshot {
        actual: [actual, 0.0, 0.0],
        ..resting(position)
    };
    let off = |actual: f64| AxisSnapshot {
        status: 0,
        ..lagging(1.0, actual)
    };
    let stuck = AxisSnapshot {
        cip_status: cip_axis_status::VELOCITY_STANDSTILL_STATUS,
        ..lagging(1.0, 0.5)
    };
    let settling = AxisSnapshot {
        cip_status: 0,
        ..lagging(1.0, 0.9)
    };
    let cases = [
        ("on and locked", lagging(1.0, 0.999), at(1.0, false)),
        ("off", off(0.999), at(0.999, false)),
        ("on and far from its command", stuck, at(0.5, false)),
        ("on its way to its command", settling, at(0.9, true)),
    ];
    for (why, shown, expected) in cases {
        let (mut watch, jobs) = watch();
        show(&mut watch, 1, shown);
        assert_eq!(sent(&jobs), Some(expected), "{why}");
    }
    let (mut watch, jobs) = watch();
    let (axes, snapshot) = (vec![settling], Snapshot::default());
    watch.axes_at_the_end(&Snapshot { axes, ..snapshot });
    assert_eq!(sent(&jobs), Some(at(1.0, false)), "after a controlled stop it settles");
}

#[test]
fn a_slow_disk_makes_axes_come_less_often() {
    let (mut watch, jobs) = watch();
    show(&mut watch, 1, moving(0.5));
    let Some(Job::Write(_, slow)) = jobs.try_next() else {
        panic!("nothing was sent")
    };
    for tick in 2..1000 {
        show(&mut watch, tick, moving(tick as f64));
        assert!(jobs.try_next().is_none(), "one is on its way");
    }
    show(&mut watch, 1000, resting(7.0));
    slow.send(Err(NotPersisted)).expect("the watch waits for it");
    show(&mut watch, 1001, resting(7.0));
    assert_eq!(sent(&jobs), Some(at(7.0, false)), "what it has become meanwhile");
}

/// A disk that hangs does not fill the memory: what finds no room is refused, and the whole state follows when there is room again.
#[test]
fn what_waits_for_the_disk_is_bounded() {
    let mut image = project().image();
    image.remember_written();
    let large = image::PlainTag::new("Large", TagType::array(Elementary::Sint, 8_000_000));
    let large = image.create(&large).expect("room");
    let (sender, queue) = RecordSender::channel();
    let mut watch = ChangeTracker::new(sender, Vec::new(), KeptTags::default(), 1_000_000);
    let mut write = |image: &mut Image, value: u8| {
        image.write(large, 0, &vec![value; 8_000_000]).expect("a plain tag");
        watch.tags(image).expect("there is a change")
    };
    let waiting: Vec<PersistedReceiver> = (0..40).map(|value| write(&mut image, value)).collect();
    let is_refused = |mut answer: PersistedReceiver| answer.try_recv() == Ok(Err(NotPersisted));
    let refused = waiting.into_iter().map(is_refused).collect::<Vec<_>>();
    let found_room = refused.iter().take_while(|refused| !**refused).count();
    assert!((8..=16).contains(&found_room), "{refused:?}");
    assert!(refused[found_room..].iter().all(|refused| *refused), "{refused:?}");
    while queue.try_next().is_some() {}
    drop(write(&mut image, 77));
    let Some(Job::Write(Record::State(state), _)) = queue.try_next() else {
        panic!("changes were lost")
    };
    let kept = state.tags.iter().find(|tag| tag.name == "Large").expect("it is kept");
    assert!(kept.bytes.iter().all(|byte| *byte == 77));
    drop(write(&mut image, 78));
    assert!(matches!(queue.try_next(), Some(Job::Write(Record::Changes(_), _))));
}

/// A plant whose state never reaches the disk.
pub(crate) fn plant_that_cannot_keep(project: &Project) -> (Plant, Handle) {
    let (plant, handle, _) = plant(project);
    (plant, handle)
}

/// A plant whose state the test keeps.
fn plant(project: &Project) -> (Plant, Handle, JobQueue) {
    let mut image = project.image();
    image.remember_written();
    let (sender, queue) = RecordSender::channel();
    let (state, tags) = state_of(project, &image);
    let watch = ChangeTracker::new(sender, state.axes, tags, project.machine.period_ns);
    let (plant, handle) =
        Plant::start_with(project, image, Some(watch), arcline_realtime::Clock::Real).expect("a thread");
    (plant, handle, queue)
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_write_is_answered_when_it_is_kept() {
    let (plant, handle, jobs) = plant(&project());
    let write = |path: &str| {
        let path = path.parse().expect("a path");
        let (written, pending) = plant.transact(Principal::Server, |transaction| {
            transaction.write_value(&path, Value::Real(2.0))
        });
        written.expect("writable");
        pending
    };
    plant
        .complete(write("Move1.Speed"))
        .await
        .expect("an operand is not retained");
    assert!(jobs.try_next().is_none(), "operands of instructions are not retained");
    for answer in [Ok(()), Err(NotPersisted)] {
        let written = write("Recipe[1]");
        let Some(Job::Write(Record::Changes(changes), sender)) = jobs.try_next() else {
            panic!("nothing was sent")
        };
        let expected = Change::Tag {
            tag: 0,
            offset: 4,
            bytes: 2.0_f32.to_le_bytes().to_vec(),
        };
        assert_eq!(changes, [expected]);
        let answered = plant.complete(written);
        tokio::pin!(answered);
        let early = tokio::time::timeout(std::time::Duration::from_millis(1), &mut answered).await;
        assert!(early.is_err(), "not before the disk has it");
        sender.send(answer).expect("it is waited for");
        assert_eq!(answered.await, answer);
    }
    drop(jobs);
    assert_eq!(
        plant.complete(write("Count")).await,
        Err(NotPersisted),
        "the state writer has ended"
    );
    handle.stop();
}

/// The results of MCCP are tags, and tags are retained.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn an_instruction_is_answered_when_its_results_are_kept() {
    let tags = "[[tag]]\nname = \"Cam\"\ntype = \"CAM[2]\"\n[[tag]]\nname = \"Profile\"\ntype = \"CAM_PROFILE[2]\"\n";
    let text = format!("{}{tags}", arcline_config::DEFAULT);
    let project = arcline_config::load(&text, "test").expect("a valid configuration");
    let (plant, handle, jobs) = plant(&project);
    let (profile, pending) = plant.transact(Principal::Server, |transaction| {
        let path = "Cam[1].Master".parse().expect("a path");
        transaction.write_value(&path, Value::Real(10.0)).expect("writable");
        transaction.image().find("Profile").expect("it is there").id
    });
    drop(pending);
    assert!(jobs.try_next().is_some());
    let named = |name: &str| UnboundOperand::Name(name.to_owned());
    let number = UnboundOperand::Number;
    let operands = [named("Cam"), number(2.0), number(0.0), number(0.0), named("Profile")];
    let call = Call {
        mnemonic: Mnemonic::Mccp,
        target: Some(0),
        control: Some("Calc"),
        operands: &operands,
        text: None,
    };
    let answered = plant.apply(Principal::Server, Command::Call(call));
    tokio::pin!(answered);
    let job = loop {
        let early = tokio::time::timeout(std::time::Duration::from_millis(1), &mut answered).await;
        assert!(early.is_err(), "not before the disk has the results: {early:?}");
        if let Some(job) = jobs.try_next() {
            break job;
        }
    };
    let Job::Write(Record::Changes(changes), sender) = job else {
        panic!("{job:?}")
    };
    let is_kept = plant.with_image(|image| {
        let bytes = image.bytes(profile);
        changes
            .iter()
            .any(|change| matches!(change, Change::Tag { offset: 0, bytes: kept, .. } if kept == bytes))
    });
    assert!(is_kept, "{changes:?}");
    sender.send(Ok(())).expect("it is waited for");
    let Ok(Outcome::Executed(executed)) = answered.await else {
        panic!("it is done")
    };
    assert_eq!(executed.control.err, 0);
    assert!(plant.with_image(|image| image.bytes(profile).iter().any(|byte| *byte != 0)));
    handle.stop();
}

#[test]
fn created_tags_are_there_again_after_a_restart_and_deleted_ones_are_not() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = folder.path().join("state");
    let create = |name: &str, program: Option<&str>, access| image::PlainTag {
        program: program.map(str::to_owned),
        access,
        ..image::PlainTag::new(name, arcline_config::tag_type("DINT[2]", |_| None).expect("a type"))
    };
    {
        let mut project = project();
        let mut retained = Retained::open(&file, &mut project).expect("a new file");
        let image = &mut retained.image;
        let fresh = image.create(&create("Fresh", None, Access::ReadWrite)).expect("room");
        let gone = image.create(&create("Gone", None, Access::ReadWrite)).expect("room");
        image
            .create(&create("Fixed", Some("Main"), Access::ReadOnly))
            .expect("room");
        assert!(retained.watch.tags(image).is_some(), "other tags are news");
        image.write(fresh, 4, &7_i32.to_le_bytes()).expect("a plain tag");
        assert!(retained.watch.tags(image).is_some());
        image.delete(gone).expect("a created tag");
        assert!(retained.watch.tags(image).is_some());
        assert!(retained.watch.tags(image).is_none(), "nothing is new");
        retained.writer.close().expect("it is written");
    }
    let mut again = project();
    let retained = Retained::open(&file, &mut again).expect("the same machine");
    let image = &retained.image;
    let tag = image.find("fresh").expect("it was created");
    assert_eq!(image.bytes(tag.id), [0, 0, 0, 0, 7, 0, 0, 0]);
    assert!(image.is_created(tag.id));
    let fixed = image.find("Program:Main.Fixed").expect("it was created");
    assert_eq!(fixed.access, Access::ReadOnly);
    assert_eq!(image.find("Gone"), None);
    retained.writer.close().expect("it is written");
}
