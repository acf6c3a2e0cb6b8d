//! The mover of each object in every state of its motion, and the jog button of the page, which moves no axis that another principal moves.

use arcline_config::Role;
use arcline_instruction_set::{Flag, Mnemonic};

use super::*;
use crate::hmi::drive;
use crate::plant::control::MotionObject;
use crate::plant::{Executed, Mover, Outcome, Principal};

/// Clients that the guard does not know: it stops none of their motion.
const CLIENTS: [Principal; 3] = [client(1), client(2), client(3)];
/// Executions of class 0x0303 in the ring, and some.
const MANY: usize = 4500;
/// Commands that the controller takes in one tick.
const AT_ONCE: usize = 50;

const fn client(session: u64) -> Principal {
    Principal::Client { session, connection: 0 }
}

async fn bench() -> Bench {
    let bench = Bench::start().await;
    for session in 1..=3 {
        bench.plant.roles().set(session, Role::Engineer);
    }
    bench
}

impl Bench {
    async fn run(&self, client: Principal, text: &str) -> Executed {
        let mut interpreter = drive::interpreter_of(&self.plant, text).expect(text);
        let call = drive::first_call(&self.plant, &mut interpreter).expect(text);
        let call = call.expect("a call");
        let command = crate::plant::Command::Call(drive::command_of(&self.plant, &call, Some(text)));
        match self.plant.apply(client, command).await {
            Ok(Outcome::Executed(executed)) => executed,
            other => panic!("{text}: {other:?}"),
        }
    }

    /// An instruction that the controller takes.
    async fn begin(&self, client: Principal, text: &str) -> u32 {
        let executed = self.run(client, text).await;
        assert_eq!((executed.control.err, executed.control.exerr), (0, 0), "{text}");
        executed.instance
    }

    /// Waits until a condition is true on the running machine.
    async fn until(&self, is_true: impl Fn() -> bool) {
        let came = async {
            while !is_true() {
                tokio::time::sleep(Duration::from_millis(2)).await;
            }
        };
        timeout(SOON, came).await.expect("the condition comes true");
    }

    async fn end_of(&self, instance: u32) {
        let runs = || {
            self.plant
                .instruction_instance(instance)
                .is_some_and(|control| control.has(Flag::Ip))
        };
        self.until(|| !runs()).await;
    }

    fn mover(&self, name: &str) -> Option<Principal> {
        let movers = self.plant.view(|view| view.movers.clone());
        let mover = match MotionObject::find(self.plant.machine(), name) {
            Some(MotionObject::Axis(axis)) => movers.of_axis(axis),
            Some(MotionObject::System(system)) => movers.of_system(system),
            other => panic!("{name}: {other:?}"),
        };
        mover.map(|mover: &Mover| mover.principal)
    }

    #[track_caller]
    fn assert_mover(&self, names: &[&str], mover: Option<Principal>, why: &str) {
        for name in names {
            assert_eq!(self.mover(name), mover, "{name}: {why}");
        }
    }

    /// The speed of an axis, u/s.
    fn speed(&self, axis: &str) -> f64 {
        let Some(MotionObject::Axis(axis)) = MotionObject::find(self.plant.machine(), axis) else {
            panic!("{axis}");
        };
        self.plant
            .with_snapshot(|snapshot| snapshot.axes[axis.index()].command[1].abs())
    }

    async fn rest(&self, axis: &str) {
        self.until(|| self.speed(axis) == 0.0).await;
    }

    /// Waits until an axis is faster than a speed.
    async fn moves(&self, axis: &str, speed: f64) {
        self.until(|| self.speed(axis) > speed).await;
    }
}

impl Viewer {
    /// Jogs an axis that another principal moves.
    async fn is_refused(&mut self, axis: &str, why: &str) {
        let taken = self.ask(json!({"do": "take", "object": axis, "force": true})).await;
        assert_eq!(taken, Ok(json!({})));
        let jogged = self.ask(json!({"do": "jog", "axis": axis, "speed": 1.0})).await;
        let refused = jogged.expect_err(why);
        let text = refused["text"].as_str().unwrap_or_default();
        assert!(text.starts_with(&format!("{axis} is moved by ")), "{why}: {text}");
    }
}

#[tokio::test]
async fn refused_calls_of_others_do_not_hide_the_mover() {
    let bench = bench().await;
    let mut viewer = bench.viewer().await;
    let [mover, other, _] = CLIENTS;
    bench
        .begin(mover, "MCLM(CS1, M1, 0, [400, 0, 0], 5, 0, 500, 0, 500, 0);")
        .await;
    viewer.is_refused("X", "before").await;
    for _ in 0..20 {
        let refused = bench.run(other, "MCLM(CS1, BadN, 0, [0, 0, 0], -5, 0);").await;
        assert_eq!(refused.control.err, 13);
        bench.assert_mover(&["CS1", "X", "Y"], Some(mover), "behind a refused call");
    }
    viewer.is_refused("X", "behind the refused calls").await;
}

#[tokio::test]
async fn superposed_moves_do_not_hide_the_mover() {
    let bench = bench().await;
    let mut viewer = bench.viewer().await;
    let [mover, other, _] = CLIENTS;
    bench.begin(mover, "MAG(B, A, Gear, 0, 1, 1, 1, 0, 0, 1);").await;
    for _ in 0..20 {
        let instance = bench
            .begin(other, "MAM(B, Trim, 1, 0.01, 50, 0, 5000, 0, 5000, 0);")
            .await;
        bench.end_of(instance).await;
    }
    bench.assert_mover(&["B"], Some(mover), "it is geared");
    viewer.is_refused("B", "it is geared").await;
}

#[tokio::test]
async fn the_mover_of_an_axis_with_a_move_of_a_viewers_own_is_another() {
    let bench = bench().await;
    let mut viewer = bench.viewer().await;
    viewer.take("X").await;
    bench
        .begin(CLIENTS[0], "MCLM(CS1, M1, 0, [400, 0, 0], 5, 0, 500, 0, 500, 0);")
        .await;
    let own = viewer.execute("MAM(X, Own, 1, 100, 1, 0, 500, 0, 500, 0)").await;
    own.expect("the viewer has control of X");
    viewer
        .is_refused("X", "a client's coordinate system moves it too")
        .await;
}

/// The record of an instruction that runs stays, with its origin; so does that of its end.
#[tokio::test]
async fn thousands_of_later_executions_do_not_hide_an_instruction_that_runs() {
    let bench = bench().await;
    let mut viewer = bench.viewer().await;
    let [mover, other, _] = CLIENTS;
    let text = "MAM(S, Far, 1, 300, 2, 0, 500, 0, 500, 0);";
    let instance = bench.begin(mover, text).await;
    let disarm = "MDW(X, Disarm);";
    let mut interpreter = drive::interpreter_of(&bench.plant, disarm).expect(disarm);
    let call = drive::first_call(&bench.plant, &mut interpreter).expect(disarm);
    let call = call.expect("a call");
    for _ in 0..MANY / AT_ONCE {
        let (sent, pending) = bench.plant.transact(other, |transaction| {
            let command = || crate::plant::Command::Call(drive::command_of(&bench.plant, &call, None));
            (0..AT_ONCE).filter(|_| transaction.apply(command()).is_ok()).count()
        });
        assert_eq!(sent, AT_ONCE);
        bench.plant.complete(pending).await.expect("nothing is retained");
    }
    let newest = bench.plant.newest_instance().expect("an execution");
    assert!(newest as usize >= MANY);
    let control = bench.plant.instruction_instance(instance);
    assert!(control.is_some_and(|control| control.has(Flag::Ip)), "{control:?}");
    assert!(
        bench.plant.instruction_instance(instance + 1).is_none(),
        "one that has ended is dropped"
    );
    bench.assert_mover(&["S"], Some(mover), "it moves");
    viewer.is_refused("S", "it moves").await;
    bench.begin(other, "MAS(S, Stop, 0);").await;
    bench.end_of(instance).await;
    let control = bench.plant.instruction_instance(instance).expect("its end is known");
    assert!(!control.has(Flag::Ip) && !control.has(Flag::Pc), "{control:?}");
    assert!(bench.plant.instruction_ending(instance).is_some());
    let events = viewer.ask(json!({"do": "events", "since": 0})).await.expect("events");
    let events = events["events"].as_array().expect("a list").clone();
    let its = events
        .iter()
        .rfind(|event| event["ticket"] == json!(instance))
        .expect("its end is an event");
    assert_eq!((&its["object"], &its["text"]), (&json!("S"), &json!(text)), "{its}");
}

/// A client that waits for an instruction that the server has dropped learns that the motion may go on, and whether it does.
#[tokio::test]
async fn a_client_sees_motion_that_the_server_no_longer_knows() {
    let bench = bench().await;
    let (client, serving) = bench.client().await;
    let dropped = |target: &str, mnemonic| arcline_client::Execution {
        mnemonic,
        target: target.to_owned(),
        tag: String::new(),
        instance: 4_000_000,
        control: Default::default(),
    };
    for (target, axis, mnemonic, text) in [
        (
            "CS1",
            "X",
            Mnemonic::Mclm,
            "MCLM(CS1, M1, 0, [400, 0, 0], 20, 0, 5000, 0, 5000, 0);",
        ),
        ("S", "S", Mnemonic::Maj, "MAJ(S, J, 0, 20, 0, 5000, 0, 5000, 0);"),
    ] {
        assert_eq!(client.is_moving(target).await.ok(), Some(false), "{target}");
        bench.begin(CLIENTS[0], text).await;
        bench.moves(axis, 0.0).await;
        let waited = client.wait_for(&dropped(target, mnemonic), Flag::Pc, SOON).await;
        let error = waited.expect_err("it never was").to_string();
        assert_eq!(
            error,
            format!("the server no longer knows {mnemonic} {target}; the motion may go on")
        );
        assert_eq!(client.is_moving(target).await.ok(), Some(true), "{target}");
    }
    serving.abort();
}

/// A stop with a low deceleration ends the instruction, and the object still moves.
#[tokio::test]
async fn a_mover_lasts_until_its_object_rests() {
    let bench = bench().await;
    let mut viewer = bench.viewer().await;
    let [mover, other, _] = CLIENTS;
    let far = bench
        .begin(mover, "MAM(S, Far, 1, 300, 20, 0, 5000, 0, 5000, 0);")
        .await;
    bench.moves("S", 19.9).await;
    bench.begin(other, "MAS(S, Weak, All, Yes, 2, 0);").await;
    bench.end_of(far).await;
    assert!(bench.speed("S") > 10.0, "{}", bench.speed("S"));
    bench.assert_mover(&["S"], Some(mover), "it brakes");
    viewer.is_refused("S", "it brakes").await;
    bench.begin(other, "MAS(S, Hard, All, Yes, 5000, 0);").await;
    bench.rest("S").await;
    bench.assert_mover(&["S"], None, "it rests");

    let far = bench
        .begin(mover, "MCLM(CS1, M1, 0, [400, 0, 0], 20, 0, 5000, 0, 5000, 0);")
        .await;
    bench.moves("X", 19.9).await;
    bench.begin(other, "MCS(CS1, Weak, 2, Yes, 2, 0);").await;
    bench.end_of(far).await;
    assert!(bench.speed("X") > 10.0, "{}", bench.speed("X"));
    bench.assert_mover(&["CS1", "X"], Some(mover), "it brakes");
    viewer.is_refused("X", "it brakes").await;
    bench.begin(other, "MCS(CS1, Hard, 0, Yes, 5000, 0);").await;
    bench.rest("X").await;
    bench.assert_mover(&["CS1", "X"], None, "it rests");
}

/// A transform: its target has the mover of its source, and its source that of its target.
#[tokio::test]
async fn coupled_coordinate_systems_have_one_mover() {
    let bench = bench().await;
    let mut viewer = bench.viewer().await;
    let [by, mover, other] = CLIENTS;
    bench.begin(by, "MCT(CS2, CS3, T, [0, 0, 0], [0, 0, 0]);").await;
    bench.assert_mover(&["CS2", "CS3", "A", "B"], Some(by), "at rest, the transform's");
    let far = bench
        .begin(mover, "MCLM(CS2, M, 1, [100, 50, 0], 5, 0, 500, 0, 500, 0);")
        .await;
    bench.moves("A", 0.1).await;
    bench.assert_mover(&["CS2", "CS3", "X", "A", "B", "C"], Some(mover), "the source moves");
    for axis in ["A", "B"] {
        viewer.is_refused(axis, "the source moves").await;
    }
    bench.begin(other, "MCS(CS2, Halt, 2, No);").await;
    bench.end_of(far).await;
    bench.rest("X").await;
    let jog = bench.begin(other, "MAM(A, Joint, 1, 10, 2, 0, 500, 0, 500, 0);").await;
    bench.assert_mover(&["CS2", "X", "A"], Some(other), "an axis of the target moves");
    bench.begin(other, "MAS(A, Stop, 0);").await;
    bench.end_of(jog).await;
    bench.rest("A").await;
    bench.begin(other, "MCS(CS2, Off, 3, No);").await;
    bench.until(|| bench.mover("CS2").is_none()).await;
    bench.assert_mover(&["CS2", "CS3", "X", "A"], None, "nothing couples them");
}
