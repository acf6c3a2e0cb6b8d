//! The body of the real-time loop allocates no memory, with any instructions and at any load by clients.
//!
//! The tick runs as on its thread, but without its sleep, so 1,000 times as many of them; two client threads push every instruction through the
//! rings and take answers, events and snapshots out of them, allocating all the time. The global allocator ends
//! the process when the guarded thread asks it for memory.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};

use arcline_config::Project;
use arcline_controller::image::{Image, StagedWrites};
use arcline_controller::{Command, Controller, Ticket};
use arcline_instruction_set::{
    Call, ControlSlot, Directory, Flag, Mnemonic, MotionControl, Object, SystemId, TagAddress, UnboundOperand,
    WrittenArray, bind,
};
use arcline_realtime::{ServerRings, link, step};
use arcline_structured_text::{Answer, Interpreter, Program, Request};
use assert_no_alloc::{AllocDisabler, assert_no_alloc};

#[global_allocator]
static ALLOCATOR: AllocDisabler = AllocDisabler;

/// The executed calls, with both profiles, all circle types, merges, refusals and stops on the way.
const CALLS: &[&str] = &[
    "MCT(CS3, CS1, M20, [0, 0, 90], [0, 0, 0]);",
    "MCT(CS1, CS2, M21, [0, 0, 0], [0, 0, 0]);",
    "MCT(TOOL, ARM, M58, [0, 0, 0], [0, 0, 0]);",
    "MCLM(TOOL, M59, Incremental, [-9, 30, 4], 90, Unitspersec, 900, Unitspersec2, 900, Unitspersec2, S-curve, 100, 100, %ofTime, 1);",
    "MCPM(POSE, M62, Way, 1, Pace);",
    "MCPM(POSE, M63, Way, 1, Pace, 5, PositionForwardOnly);",
    "MCTP(TOOL, ARM, M60, [0, 0, 0], [0, 0, 0], InverseLeftArm, [100, 50, 60], Place);",
    "MCTO(TURN, WRIST, M62, Frame, Frame);",
    "MCLM(TURN, M63, Incremental, [-9, 30, 4], 90, Unitspersec, 900, Unitspersec2, 900, Unitspersec2, S-curve, 100, 100, %ofTime, 1);",
    "MCTPO(TURN, WRIST, M64, Frame, Frame, Inverse, [100, 0, 150, 0, 180, 0], Place, Bits, Turns);",
    "MAG(S, A, M22, Same, 0.5, 1, 1, Command, Real, Enabled, 1000, Unitspersec2);",
    "MAG(A, S, M23, Same, 0.5, 1, 1, Actual, Real, Disabled);",
    "MAM(A, M24, 1, 20, 100, Unitspersec, 1000, Unitspersec2, 1000, Unitspersec2, S-curve, 100, 100, %ofTime, Disabled, Programmed);",
    "MAM(X, M25, 1, 20, 100, Unitspersec, 1000, Unitspersec2, 1000, Unitspersec2, Trapezoidal, 100, 100, %ofTime, Enabled, Current);",
    "MAM(B, M29, Incremental, 20, 0.05, Seconds, 0.01, Seconds, 0.01, Seconds, S-curve, 0.002, 0.005, Seconds);",
    "MAJ(C, M30, Reverse, 100, Unitspersec, 1000, Unitspersec2, 1000, Unitspersec2, S-curve, 100, 100, %ofTime, Enabled);",
    "MCD(C, M31, Jog, Yes, 0);",
    "MCD(B, M32, Move, Yes, 10, No, 0, Yes, 100);",
    "MCS(CS3, M26, CoordinatedTransform, Yes, 3000, Unitspersec2, No, 0, %ofTime);",
    "MAS(S, M27, Gear, Yes, 3000, Unitspersec2, No, 0, %ofTime);",
    "MAS(X, M28, All, No, 0, Unitspersec2, No, 0, %ofTime);",
    "MDCC(CS1, A, M33, Command, 50);",
    "MDAC(B, A, M34, All, Actual);",
    "MCLM(CS1, M35, Absolute, [10, 5, 2], 2, Unitspermasterunit, 1, Unitspermasterunit2, 1, Unitspermasterunit2, S-curve, 100, 100, %ofTimeMasterDriven, 2, Disabled, Programmed, 0, 0, ImmediateForwardOnly, [0, 1, 2], Data);",
    "MCLM(CS1, M36, Absolute, [0, 0, 0], 2, Unitspermasterunit, 1, Unitspermasterunit2, 1, Unitspermasterunit2, Trapezoidal, 100, 100, %ofTimeMasterDriven, 1, CoordinatedMotion, Current, 0, 5, PositionForwardOnly, [0], Data);",
    "MAM(B, M37, Incremental, 2, 2, Unitspermasterunit, 1, Unitspermasterunit2, 1, Unitspermasterunit2, S-curve, 100, 100, %ofTimeMasterDriven, Disabled, Programmed, 0, ImmediateForwardOnly, [0, 1, 2, 3], Data);",
    "MAJ(B, M38, Forward, 2, Unitspermasterunit, 1, Unitspermasterunit2, 1, Unitspermasterunit2, Trapezoidal, 100, 100, %ofTimeMasterDriven, Disabled, Programmed, 0, ImmediateForwardOnly);",
    "MSO(X, M1);",
    "MSO(Y, M1);",
    "MSO(Z, M1);",
    "MCLM(CS1, M2, Absolute, [100, 50, 20], 200, Unitspersec, 2000, Unitspersec2, 2000, Unitspersec2, S-curve, 100, 100, %ofTime, 0);",
    "MCLM(CS1, M3, Incremental, [-3, 1, 2], 50, %ofMaximum, 50, %ofMaximum, 50, %ofMaximum, Trapezoidal, 100, 100, %ofTime, 1);",
    "MCLM(CS1, M4, Absolute, [0, 0, 0], -1, Unitspersec);",
    "MCCM(XY, M5, Incremental, [10, 0], Radius, [5], 0, 100, Unitspersec, 1000, Unitspersec2, 1000, Unitspersec2, S-curve, 100, 100, %ofTime, 1);",
    "MCCM(XY, M6, Incremental, [10, 0], CenterIncremental, [5, 0], 1, 100, Unitspersec, 1000, Unitspersec2, 1000, Unitspersec2, Trapezoidal, 100, 100, %ofTime, 0);",
    "MCCM(CS1, M7, Incremental, [10, 0, 0], Via, [5, 5, 1], 0, 100, Unitspersec, 1000, Unitspersec2, 1000, Unitspersec2, S-curve, 100, 100, %ofTime, 1);",
    "MCLM(CS3, M8, Absolute, [9, 9, 9], 500, Unitspersec, 5000, Unitspersec2, 5000, Unitspersec2, S-curve, 100000, 100000, Unitspersec3, 1);",
    "MCCD(CS1, M9, CoordinatedMove, Yes, 50, Unitspersec, No, 0, Unitspersec2, No, 0, Unitspersec2, No, 0, No, 0, %ofTime, ActiveMotion);",
    "MCS(CS1, M10, CoordinatedMove, Yes, 3000, Unitspersec2, Yes, 100, %ofTime);",
    "MSF(S, M11);",
    "MASD(S, M12);",
    "MAFR(S, M13);",
    "MASR(S, M14);",
    "MCSD(CS2, M15);",
    "MCSR(CS2, M16);",
    "MAH(X, M35);",
    "MRP(Y, M36, Relative, Command, 10);",
    "MGSP(Motion, M37);",
    "MGS(Motion, M38, FastStop);",
    "MAW(A, M48, Forward, 3);",
    "MDW(A, M49);",
    "MAR(A, M60, PositiveEdge, Enabled, 0, 500, 1);",
    "MDR(A, M61, 1);",
    "MCCP(M39, Cam, 3, 0, 0, Profile);",
    "MCSV(M41, Profile, 0.05);",
    "MAPC(Y, X, M42, Same, Profile, 1, 100, Continuous, Immediate, 0, 0, Command, Bidirectional);",
    "MAPC(Y, X, M43, Opposite, Profile, 1, 50, Once, Pending, 0, 0, Command, ForwardOnly);",
    "MAPC(B, A, M44, Same, Profile, 1, 90, Persistent, Bidirectional, 3, 0.1, Actual, ForwardOnly);",
    "MATC(C, M45, Same, Profile, 3, 1, Continuous, Immediate);",
    "MATC(C, M46, Reverse, Profile, 1, 1, Once, Pending);",
    "MAM(Y, M66, IncrementalMasterOffset, 5, 100, Unitspersec, 1000, Unitspersec2, 1000, Unitspersec2, S-curve, 100, 100, %ofTime);",
    "MDAC(B, A, M67, TimeCam, Command);",
    "MATC(B, M68, Same, Profile, 1, 50, Once, Immediate, 0, ImmediateForwardOnly, MasterDrivenMode);",
    "MAOC(A, 0, M62, Out, 0, Outs, 0, 30, 0, Continuous, Immediate, 0, 0, Command);",
    "MAOC(A, 0, M63, Out, 0, Outs, 0, 30, 0, Once, Pending, 0, 0, Command);",
    "MAOC(A, 1, M64, Out, Out, Outs, 0, 30, 0, Persistent, Bidirectional, 3, 0, Actual);",
    "MDOC(A, 1, M65, Specific);",
    "MAS(Y, M47, PositionCam, Yes, 3000, Unitspersec2, No, 0, %ofTime);",
    "MCS(XY, M17, CoordinatedMove, No, 0, Unitspersec2, No, 0, %ofTime);",
];

/// The calls that make the machine ready again, with the ticks that they take.
const READY: &[(&str, u32)] = &[
    ("MGSD(Motion, M33);", 1500),
    ("MGSR(Motion, M34);", 2),
    ("MSO(X, M1);", 0),
    ("MSO(Y, M1);", 0),
    ("MSO(Z, M1);", 0),
    ("MSO(S, M1);", 2),
];

struct Names<'p>(&'p Project);

impl Directory for Names<'_> {
    fn object(&self, object: Object, name: &str) -> Option<u16> {
        match object {
            Object::MotionGroup => self.0.machine.is_group(name).then_some(0),
            Object::Axis => self.0.machine.axis(name).map(|axis| axis.0),
            Object::CoordinateSystem => self.0.machine.system(name).map(|system| system.0),
        }
    }

    fn real_array(&self, name: &str) -> Option<WrittenArray> {
        let data = (name == "Data").then_some(WrittenArray {
            tag: TagAddress::default(),
            elements: 4,
        });
        data.or_else(|| image(self.0).real_array(name))
    }

    fn structure(&self, type_name: &str, name: &str) -> Option<TagAddress> {
        image(self.0).structure(type_name, name)
    }
}

/// The tags of a project.
fn image(project: &Project) -> Image {
    Image::new(&project.machine, &[], &project.tags)
}

/// A call from its text, with the control slot `M1` … say.
fn call(project: &Project, text: &str) -> Call {
    let program = Program::parse_call(text).unwrap_or_else(|error| panic!("{text}: {error}"));
    let request = Interpreter::new(program).resume(Answer::Start);
    let Ok(Request::Call(call)) = request else {
        panic!("{text}: {request:?}")
    };
    let names = Names(project);
    let target = names.object(call.mnemonic.instruction().object, &call.target);
    let slot = call
        .control
        .and_then(|name| name[1..].parse().ok())
        .expect("tags are M1, M2 …");
    bind(call.mnemonic, target, ControlSlot(slot), &call.operands, &names)
        .unwrap_or_else(|error| panic!("{text}: {error}"))
}

/// One call of every instruction in the catalogue that can be bound with zeros only.
fn zeros(project: &Project) -> Vec<Call> {
    let bound = Mnemonic::ALL.iter().filter_map(|mnemonic| {
        (0..=arcline_instruction_set::MAX_OPERANDS).rev().find_map(|count| {
            let given = vec![UnboundOperand::Number(0.0); count];
            bind(*mnemonic, Some(0), ControlSlot(40), &given, &Names(project)).ok()
        })
    });
    bound.collect()
}

/// The async side of the rings, shared by the clients.
struct Outer {
    link: ServerRings,
    image: Image,
    /// Writes of instructions to tags at their end, by ticket.
    staged: BTreeMap<u64, StagedWrites>,
    /// Mnemonic of every ticket so far.
    sent: Vec<Mnemonic>,
    /// Instructions that were accepted at least once.
    accepted: BTreeSet<Mnemonic>,
    events: usize,
}

impl Outer {
    fn new(project: &Project, link: ServerRings) -> Self {
        Outer {
            link,
            image: image(project),
            staged: BTreeMap::new(),
            sent: Vec::new(),
            accepted: BTreeSet::new(),
            events: 0,
        }
    }

    /// Sends all instructions. A full ring is an answer: an instruction that finds it so is not sent.
    fn burst(&mut self, calls: &[Call]) {
        for call in calls {
            let ticket = Ticket(self.sent.len() as u64);
            let (data, staged) = self.image.prepare(call);
            let command = match data {
                None => Command::Call(ticket, *call),
                Some(data) => Command::CallWith(ticket, *call, data),
            };
            if self.link.commands.push(command).is_ok() {
                self.sent.push(call.mnemonic);
                self.staged.extend(staged.map(|staged| (ticket.0, staged)));
                let _ = self.link.commands.push(Command::RungFalse(call.control));
            } else if let Some(staged) = staged {
                self.image.settle(staged, &MotionControl::default());
            }
        }
    }

    /// Takes everything out; returns the tick of the newest snapshot.
    fn drain(&mut self) -> u64 {
        while let Ok(answer) = self.link.answers.pop() {
            if let Some(staged) = self.staged.remove(&answer.ticket.0) {
                self.image.settle(staged, &answer.control);
            }
            if !answer.control.has(Flag::Er) {
                self.accepted.insert(self.sent[answer.ticket.0 as usize]);
            }
        }
        while self.link.events.pop().is_ok() {
            self.events += 1;
        }
        self.image.show_uses();
        self.link.snapshots.read().tick
    }
}

const BURSTS: u64 = 60;

/// Ticks between a burst and the next one: from none to enough for every move to end.
fn pause(burst: u64) -> u64 {
    const LONGEST: u64 = 900;
    burst * 37 % LONGEST
}

/// One client: bursts of all instructions, with a different number of ticks between any two bursts.
fn press(outer: &Mutex<Outer>, calls: &[Call]) {
    for burst in 0..BURSTS {
        let resume_at = {
            let mut outer = outer.lock().expect("the other client is well");
            outer.burst(calls);
            outer.drain() + pause(burst)
        };
        while outer.lock().expect("the other client is well").drain() < resume_at {
            std::hint::black_box(vec![0_u8; 1000]);
            std::thread::yield_now();
        }
    }
}

/// The path and speed of MCPM.
const PATHS: &str = "[[tag]]\nname = \"Way\"\ntype = \"PATH_DATA\"\nvalue = { InterpolationType = 1, TerminationType = 6, \
    CommandToleranceLinear = 2.0, Position = [9.0, 3.0, 4.0, 20.0, 30.0, 40.0, 0.0, 0.0, 0.0] }\n\
    [[tag]]\nname = \"Pace\"\ntype = \"DYNAMICS_DATA\"\nvalue = { Speed = 50.0, Profile = 1, Acceleration = 50.0, \
    Deceleration = 50.0, AccelerationJerk = 50.0, DecelerationJerk = 50.0, OrientationSpeed = 50.0, \
    OrientationAcceleration = 50.0, OrientationDeceleration = 50.0 }\n";

fn project() -> Project {
    let drive =
        "drive = { velocity_feedforward = 0.0, speed_limit = 150.0, torque_limit = 1500.0, encoder_resolution = 1e3 }";
    let limited = format!("type = \"servo\"\n{drive}");
    let cam = "value = [{ Master = 0.0 }, { Master = 0.1, Slave = 1.0, SegmentType = 1 }, { Master = 0.2 }]";
    let axis = |name: &str| {
        format!("[[axis]]\nname = \"{name}\"\ntype = \"virtual\"\nmax_speed = 90.0\nmax_acceleration = 900.0\n")
    };
    let robot: String = ["K1", "K2", "K3", "J1", "J2", "J3", "E1", "E2", "E3"]
        .iter()
        .map(|name| axis(name))
        .collect();
    let system = |name: &str, axes: &str, more: &str| {
        format!(
            "[[coordinate_system]]\nname = \"{name}\"\naxes = [{axes}]\nmax_speed = 100.0\nmax_acceleration = 1000.0\n{more}"
        )
    };
    let robot = robot
        + &system("TOOL", "\"K1\", \"K2\", \"K3\"", "")
        + &system(
            "POSE",
            "\"K1\", \"K2\", \"K3\", \"E1\", \"E2\", \"E3\"",
            "definition = \"XYZRxRyRz\"\n",
        )
        + &system(
            "ARM",
            "\"J1\", \"J2\", \"J3\"",
            "type = \"articulated_independent\"\nlink_lengths = [100.0, 100.0]\nzero_angles = [0.0, -90.0, 90.0]\n",
        );
    let six = |letter: char| -> String { (1..=6).map(|place| axis(&format!("{letter}{place}"))).collect() };
    let robot = robot
        + &six('O')
        + &six('W')
        + &system(
            "TURN",
            "\"O1\", \"O2\", \"O3\", \"O4\", \"O5\", \"O6\"",
            "definition = \"XYZRxRyRz\"\n",
        )
        + &system(
            "WRIST",
            "\"W1\", \"W2\", \"W3\", \"W4\", \"W5\", \"W6\"",
            "type = \"articulated_independent\"\ndefinition = \"J1J2J3J4J5J6\"\nlink_lengths = [100.0, 100.0]\n\
             end_effector_offsets = [30.0, 0.0, 0.0]\nzero_angles = [0.0, -90.0, 90.0, 0.0, 60.0, 0.0]\n",
        )
        + "[[tag]]\nname = \"Frame\"\ntype = \"POSITION_DATA\"\n[[tag]]\nname = \"Bits\"\ntype = \"DINT\"\n\
           [[tag]]\nname = \"Turns\"\ntype = \"INT[4]\"\n";
    let config = format!(
        "{}\n{robot}[[tag]]\nname = \"Place\"\ntype = \"REAL[6]\"\n[[tag]]\nname = \"Cam\"\ntype = \"CAM[3]\"\n{cam}\n[[tag]]\nname = \"Profile\"\ntype = \"CAM_PROFILE[3]\"\n{PATHS}",
        arcline_config::DEFAULT
            .replacen("type = \"servo\"", &limited, 1)
            .replacen(
                "name = \"A\"\n",
                "name = \"A\"\noutput_cam_execution_targets = 2\nregistration = { input_1 = \"Mark\" }\n",
                1
            )
            + "\n[[tag]]\nname = \"Mark\"\ntype = \"BOOL\"\n[[tag]]\nname = \"Out\"\ntype = \"DINT\"\n[[tag]]\nname = \"Outs\"\n\
               type = \"OUTPUT_CAM[2]\"\nvalue = [{ LatchType = 1, UnlatchType = 1, Left = 5.0, Right = 30.0 }, \
               { OutputBit = 1, LatchType = 3, UnlatchType = 5, Right = 20.0, Duration = 0.05 }]\n"
    );
    arcline_config::load(&config, "default.toml").expect("the default with a limited drive is valid")
}

fn all_calls(project: &Project) -> Vec<Call> {
    let mut calls: Vec<Call> = CALLS.iter().map(|text| call(project, text)).collect();
    calls.extend(zeros(project));
    calls
}

/// Every instruction is accepted at least once in these, each of which begins with a machine that is ready. Ticks after
/// each instruction.
const SCENES: &[&[(&str, u32)]] = &[
    &[
        (
            "MCLM(CS1, M2, Absolute, [100, 50, 20], 200, Unitspersec, 2000, Unitspersec2, 2000, Unitspersec2, S-curve, 100, 100, %ofTime, 3);",
            50,
        ),
        (
            "MCLM(CS1, M3, Incremental, [-3, 1, 2], 50, %ofMaximum, 50, %ofMaximum, 50, %ofMaximum, Trapezoidal, 100, 100, %ofTime, 1);",
            10,
        ),
        (
            "MCCD(CS1, M9, CoordinatedMove, Yes, 50, Unitspersec, No, 0, Unitspersec2, No, 0, Unitspersec2, No, 0, No, 0, %ofTime, ActiveMotion);",
            50,
        ),
        (
            "MCS(CS1, M10, CoordinatedMove, Yes, 3000, Unitspersec2, Yes, 100, %ofTime);",
            500,
        ),
        (
            "MCCM(XY, M5, Incremental, [10, 0], Radius, [5], 0, 100, Unitspersec, 1000, Unitspersec2, 1000, Unitspersec2, S-curve, 100, 100, %ofTime, 1);",
            30,
        ),
        (
            "MCCM(XY, M6, Incremental, [10, 0], CenterIncremental, [5, 0], 1, 100, Unitspersec, 1000, Unitspersec2, 1000, Unitspersec2, Trapezoidal, 100, 100, %ofTime, 0);",
            900,
        ),
        ("MCSD(CS2, M15);", 5),
        ("MCSR(CS2, M16);", 5),
    ],
    &[
        ("MDW(A, M49);", 2),
        ("MDR(A, M61, 1);", 2),
        ("MAW(A, M48, Forward, 3);", 1),
        ("MAR(A, M60, PositiveEdge, Enabled, 0, 500, 1);", 1),
        ("MCCP(M39, Cam, 3, 0, 0, Profile);", 1),
        ("MCSV(M41, Profile, 0.05);", 1),
        (
            "MAPC(Y, X, M42, Same, Profile, 1, 100, Continuous, Immediate, 0, 0, Command, Bidirectional);",
            1,
        ),
        (
            "MAPC(Y, X, M43, Opposite, Profile, 1, 50, Once, Pending, 0, 0, Command, ForwardOnly);",
            1,
        ),
        (
            "MAPC(B, A, M44, Same, Profile, 1, 90, Persistent, Bidirectional, 3, 0.1, Actual, ForwardOnly);",
            1,
        ),
        ("MATC(C, M45, Same, Profile, 3, 1, Continuous, Immediate);", 30),
        ("MATC(C, M46, Reverse, Profile, 1, 1, Once, Pending);", 30),
        (
            "MAM(Y, M66, IncrementalMasterOffset, 5, 100, Unitspersec, 1000, Unitspersec2, 1000, Unitspersec2, S-curve, 100, 100, %ofTime);",
            30,
        ),
        ("MDAC(B, A, M67, TimeCam, Command);", 1),
        (
            "MATC(B, M68, Same, Profile, 1, 50, Once, Immediate, 0, ImmediateForwardOnly, MasterDrivenMode);",
            1,
        ),
        (
            "MAOC(A, 0, M62, Out, 0, Outs, 0, 30, 0, Continuous, Immediate, 0, 0, Command);",
            1,
        ),
        (
            "MAOC(A, 0, M63, Out, 0, Outs, 0, 30, 0, Once, Pending, 0, 0, Command);",
            1,
        ),
        (
            "MAOC(A, 1, M64, Out, Out, Outs, 0, 30, 0, Persistent, Bidirectional, 3, 0, Actual);",
            1,
        ),
        (
            "MAM(X, M24, 1, 40, 100, Unitspersec, 1000, Unitspersec2, 1000, Unitspersec2, S-curve, 100, 100, %ofTime, Disabled, Programmed);",
            900,
        ),
        (
            "MAM(A, M24, 1, 40, 100, Unitspersec, 1000, Unitspersec2, 1000, Unitspersec2, S-curve, 100, 100, %ofTime, Disabled, Programmed);",
            900,
        ),
        ("MDOC(A, 1, M65, Specific);", 5),
        ("MGSD(Motion, M33);", 5),
    ],
    &[
        // Position and orientation, blended and stopped.
        ("MCPM(POSE, M62, Way, 1, Pace);", 20),
        (
            "MCLM(POSE, M59, Incremental, [-9, 30, 4], 90, Unitspersec, 900, Unitspersec2, 900, Unitspersec2, S-curve, 100, 100, %ofTime, 1);",
            150,
        ),
        (
            "MCS(POSE, M17, CoordinatedMove, No, 0, Unitspersec2, No, 0, %ofTime);",
            300,
        ),
    ],
    &[
        // A robot with a wrist, the same.
        ("MCTO(TURN, WRIST, M62, Frame, Frame);", 5),
        (
            "MCTPO(TURN, WRIST, M64, Frame, Frame, Forward, [0, 0, 0, 0, 0, 0], Place, Bits, Turns);",
            2,
        ),
        (
            "MCLM(TURN, M63, Incremental, [-9, 20, 4], 90, Unitspersec, 900, Unitspersec2, 900, Unitspersec2, S-curve, 100, 100, %ofTime, 1);",
            100,
        ),
        (
            "MAM(W6, M24, 1, 5, 50, Unitspersec, 500, Unitspersec2, 500, Unitspersec2, S-curve, 100, 100, %ofTime, Disabled, Programmed);",
            900,
        ),
        (
            "MAM(O4, M24, 1, 60, 90, Unitspersec, 900, Unitspersec2, 900, Unitspersec2, S-curve, 100, 100, %ofTime, Disabled, Programmed);",
            900,
        ),
    ],
    &[
        // A robot that follows its path, is taken along by a joint, and is stopped where it would be too fast.
        ("MCT(TOOL, ARM, M58, [0, 0, 0], [0, 0, 0]);", 5),
        (
            "MCTP(TOOL, ARM, M60, [0, 0, 0], [0, 0, 0], InverseLeftArm, [100, 50, 60], Place);",
            2,
        ),
        (
            "MCLM(TOOL, M59, Absolute, [60, 30, 90], 90, Unitspersec, 900, Unitspersec2, 900, Unitspersec2, S-curve, 100, 100, %ofTime, 1);",
            100,
        ),
        (
            "MAM(J2, M24, 1, 5, 50, Unitspersec, 500, Unitspersec2, 500, Unitspersec2, S-curve, 100, 100, %ofTime, Disabled, Programmed);",
            1500,
        ),
        (
            "MCLM(TOOL, M59, Absolute, [-60, 3, 90], 90, Unitspersec, 900, Unitspersec2, 900, Unitspersec2, S-curve, 100, 100, %ofTime, 1);",
            2500,
        ),
    ],
    &[
        ("MCT(CS3, CS1, M20, [0, 0, 90], [0, 0, 0]);", 5),
        ("MCT(CS1, CS2, M21, [0, 0, 0], [0, 0, 0]);", 5),
        (
            "MAM(A, M24, 1, 20, 100, Unitspersec, 1000, Unitspersec2, 1000, Unitspersec2, S-curve, 100, 100, %ofTime, Disabled, Programmed);",
            100,
        ),
        (
            "MCS(CS3, M26, CoordinatedTransform, Yes, 3000, Unitspersec2, No, 0, %ofTime);",
            500,
        ),
    ],
    &[
        (
            "MAJ(C, M30, Reverse, 100, Unitspersec, 1000, Unitspersec2, 1000, Unitspersec2, S-curve, 100, 100, %ofTime, Enabled);",
            20,
        ),
        ("MCD(C, M31, Jog, Yes, 0);", 20),
        (
            "MAM(B, M29, Incremental, 20, 0.05, Seconds, 0.01, Seconds, 0.01, Seconds, S-curve, 0.002, 0.005, Seconds);",
            5,
        ),
        (
            "MAG(S, A, M22, Same, 0.5, 1, 1, Command, Real, Enabled, 1000, Unitspersec2);",
            50,
        ),
        ("MAS(S, M27, Gear, Yes, 3000, Unitspersec2, No, 0, %ofTime);", 50),
        ("MRP(Y, M36, Relative, Command, 10);", 5),
        ("MAH(X, M35);", 5),
        ("MGSP(Motion, M37);", 5),
        ("MGS(Motion, M38, FastStop);", 300),
        ("MSF(S, M11);", 5),
        ("MASD(S, M12);", 5),
        ("MAFR(S, M13);", 5),
        ("MASR(S, M14);", 5),
    ],
];

/// The result is the same in every run: calls come between two ticks of the same thread.
#[test]
fn no_instruction_allocates() {
    let project = project();
    let (mut rings, link) = link(&project.machine);
    let mut controller = Controller::new(&project.machine);
    let mut outer = Outer::new(&project, link);
    let mut play = |outer: &mut Outer, call: Call, ticks: u32| {
        outer.burst(&[call]);
        for _ in 0..=ticks {
            assert_no_alloc(|| step(&mut controller, &mut rings));
            outer.drain();
        }
    };
    for scene in SCENES {
        for (text, ticks) in READY.iter().chain(*scene) {
            play(&mut outer, call(&project, text), *ticks);
        }
    }
    let executed = SCENES.iter().copied().flatten().chain(READY);
    for mnemonic in executed.map(|(text, _)| call(&project, text).mnemonic) {
        assert!(
            outer.accepted.contains(&mnemonic),
            "{mnemonic} was never accepted: {:?}",
            outer.accepted
        );
    }
    // Calls in any order, at any stage of the ones before.
    let calls = all_calls(&project);
    for turn in 0..8 {
        for (text, ticks) in READY {
            play(&mut outer, call(&project, text), *ticks);
        }
        for (place, call) in calls.iter().cycle().skip(7 * turn).take(calls.len()).enumerate() {
            play(&mut outer, *call, (37 * (turn + 5 * place) % 120) as u32);
        }
    }
}

/// Overrides, holds, pauses and their ends at any tick of a deep queue, of blends and of a planned contour.
#[test]
fn no_override_allocates() {
    let config = arcline_config::DEFAULT
        .replacen("name = \"CS1\"", "name = \"CS1\"\nqueue_depth = 200", 1)
        .replacen(
            "name = \"CS3\"",
            "name = \"CS3\"\nqueue_depth = 200\ncorner = \"precise\"",
            1,
        );
    let project = arcline_config::load(&config, "deep.toml").expect("the default with deep queues is valid");
    let (mut rings, mut link) = link(&project.machine);
    let mut planning = link.planning.take();
    let mut controller = Controller::new(&project.machine);
    let mut outer = Outer::new(&project, link);
    let [deep, contours] = ["CS1", "CS3"].map(|name| {
        Names(&project)
            .object(Object::CoordinateSystem, name)
            .expect("it exists")
    });
    let dynamics = "200, 0, 1000, 0, 1000, 0, 1, 20000, 20000, 0";
    for place in 0..180_u32 {
        let (x, y) = (f64::from(place + 1), f64::from(place % 2));
        let kind = ["4", "4", "2", "3", "6, 0, 0, 0.3", "5"][place as usize % 6];
        for (system, kind) in [("CS1", kind), ("CS3", "6, 0, 0, 0.1")] {
            let text = format!("MCLM({system}, M{}, 0, [{x}, {y}, 0], {dynamics}, {kind});", 50 + place);
            outer.burst(&[call(&project, &text)]);
        }
        assert_no_alloc(|| step(&mut controller, &mut rings));
        outer.drain();
    }
    let pause = |speed: u32| format!("MCCD(CS1, M1, 1, 1, {speed}, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1);");
    let changes = [pause(0), pause(150)].map(|text| call(&project, &text));
    let mut moved = false;
    for tick in 0..6000_u32 {
        if let Some(planning) = &mut planning {
            planning.step();
        }
        if tick % 13 == 0 {
            // A hold brakes at once, so the storm pauses for both to come to speed.
            let calm = tick % 1000 >= 700;
            let rate = if calm {
                1.0
            } else {
                [0.0, 1.0, 0.3, 2.0, 0.0, 0.7][(tick / 13) as usize % 6]
            };
            for system in [deep, contours].map(SystemId) {
                let _ = outer.link.commands.push(Command::Override { system, rate });
            }
        }
        if tick % 101 < 2 {
            outer.burst(&changes[tick as usize % 101..][..1]);
        }
        assert_no_alloc(|| step(&mut controller, &mut rings));
        outer.drain();
        moved |= [deep, contours]
            .iter()
            .all(|system| outer.link.snapshots.read().systems[usize::from(*system)].path_speed > 10.0);
    }
    assert!(moved, "both systems were on their way at once");
}

/// Two clients that press at any instant, as many ticks as the machine can make.
#[test]
fn no_tick_allocates_while_clients_press() {
    let project = project();
    let calls = all_calls(&project);
    let (mut rings, link) = link(&project.machine);
    let mut controller = Controller::new(&project.machine);
    let outer = Mutex::new(Outer::new(&project, link));
    let over = AtomicBool::new(false);
    let ticks = std::thread::scope(|scope| {
        let tick = scope.spawn(|| {
            let mut ticks = 0_u64;
            while !over.load(Ordering::Acquire) {
                assert_no_alloc(|| step(&mut controller, &mut rings));
                ticks += 1;
            }
            ticks
        });
        let clients = [(); 2].map(|()| scope.spawn(|| press(&outer, &calls)));
        let ends = clients.map(|client| client.join());
        over.store(true, Ordering::Release);
        assert!(ends.iter().all(Result::is_ok), "a client panicked");
        tick.join().expect("the tick does not panic")
    });
    let outer = outer.into_inner().expect("no client panicked");
    println!("{ticks} ticks, {} commands, {} events", outer.sent.len(), outer.events);
    assert!(outer.events > 0 && !outer.accepted.is_empty());
}
