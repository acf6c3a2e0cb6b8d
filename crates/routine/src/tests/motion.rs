//! Instructions of motion in rungs and Structured Text (spec/programs.md §11), on a machine that answers as a test says and moves nothing.

use arcline_instruction_set::{Argument, Call, ControlSlot, Flag, MotionControl, MotionError, Object, predefined};
use arcline_tag::TagType;

use super::projects::{add_on, parameter};
use super::{project, routine, tags};
use crate::Memory;
use crate::source::{Access, Datum, MemberSource, Project, TaskSource, Trigger, TypeSource, Usage};
use crate::{Cell, Directory, Fault, Host, load};

/// The axes X and Y and the coordinate system CS. It records the calls.
#[derive(Clone, Debug, Default)]
pub(super) struct Machine {
    /// The names of the motion control tags by slot.
    slots: Vec<String>,
    pub(super) calls: Vec<Call>,
    /// Slots whose rung was false.
    pub(super) falses: Vec<u32>,
    /// The answer to each call; none is EN, DN and IP.
    answer: Option<MotionControl>,
    /// The values that wires passed to inputs of axes.
    pub(super) inputs: Vec<(u32, bool)>,
    /// Bytes that are forced when inputs have been latched.
    pub(super) forced: Option<(usize, u8)>,
}

impl Directory for Machine {
    fn object_type(&self, name: &str) -> Option<TagType> {
        match name {
            "X" | "Y" => Some(TagType::scalar(predefined::axis_cip_drive())),
            "CS" => Some(TagType::scalar(predefined::coordinate_system())),
            _ => None,
        }
    }
    fn object(&self, object: Object, name: &str) -> Option<u16> {
        match (object, name) {
            (Object::Axis, "X") | (Object::CoordinateSystem, "CS") => Some(0),
            (Object::Axis, "Y") => Some(1),
            _ => None,
        }
    }
    fn control(&mut self, name: &str) -> Option<ControlSlot> {
        let known = self.slots.iter().position(|slot| slot == name);
        let place = known.unwrap_or_else(|| {
            self.slots.push(name.to_owned());
            self.slots.len() - 1
        });
        u32::try_from(place).ok().map(ControlSlot)
    }
    fn tag(&mut self, _: &str, _: &TagType) -> Option<u32> {
        None
    }
    fn axis_input(&mut self, text: &str) -> Option<u32> {
        let inputs = ["X.home_switch", "X.enable", "Y.registration_1"];
        let place = inputs.iter().position(|input| *input == text)?;
        u32::try_from(place).ok()
    }
    fn attribute(&mut self, _: Object, _: u16, _: &str) -> Option<(u32, usize)> {
        None
    }
}

impl Host for Machine {
    fn execute(&mut self, call: &Call, _: &mut Memory) -> MotionControl {
        self.calls.push(*call);
        let mut moving = MotionControl::default();
        [Flag::En, Flag::Dn, Flag::Ip]
            .into_iter()
            .for_each(|flag| moving.set(flag));
        self.answer.unwrap_or(moving)
    }
    fn rung_false(&mut self, slot: ControlSlot) {
        self.falses.push(slot.0);
    }
    fn attribute(&mut self, _: u32) -> f64 {
        0.0
    }
    fn set_attribute(&mut self, _: u32, _: f64) -> bool {
        false
    }
    fn date(&self, _: u64) -> [i32; 7] {
        [2026, 1, 1, 0, 0, 0, 0]
    }
    fn axis_input(&mut self, number: u32, on: bool) {
        self.inputs.push((number, on));
    }
    fn inputs_latched(&mut self, memory: &mut Memory) {
        if let Some((at, value)) = self.forced {
            memory.put_bits(at, 0xFF, value);
        }
    }
}

/// A project on a machine.
pub(super) struct Bench {
    of: Project,
    pub(super) cell: Cell,
    pub(super) machine: Machine,
    tick: u64,
}

impl Bench {
    pub(super) fn new(of: Project) -> Self {
        let mut machine = Machine::default();
        let loaded = load(&of, &mut machine);
        let findings: Vec<String> = loaded.findings.iter().map(ToString::to_string).collect();
        assert!(findings.is_empty(), "{findings:?}");
        let mut bench = Bench {
            of,
            cell: loaded.cell,
            machine,
            tick: 0,
        };
        bench.start();
        bench
    }

    fn start(&mut self) {
        self.cell.start(0, &mut self.machine).expect("it starts");
    }

    pub(super) fn tick(&mut self) -> Result<(), Fault> {
        let ran = self.cell.tick(self.tick, 10_000_000, &mut self.machine);
        self.tick += 1;
        ran
    }

    /// Sets tags, scans once, and checks the conditions: `Go, M.PC=0 : M.EN; M.IP=0`.
    pub(super) fn scan(&mut self, line: &str) {
        let (sets, _) = line.split_once(':').unwrap_or((line, ""));
        for text in sets.split(',').map(str::trim).filter(|text| !text.is_empty()) {
            let (tag, value) = text.split_once('=').unwrap_or((text, "1"));
            let writes = self
                .cell
                .writes(&self.of, &mut self.machine, &[(tag.trim(), value.trim())]);
            let writes = writes.unwrap_or_else(|(_, reason)| panic!("{line}: {text}: {reason}"));
            self.cell.write(&writes, &mut self.machine).expect("it is written");
        }
        self.tick().unwrap_or_else(|fault| panic!("{line}: {fault}"));
        self.holds(line);
    }

    pub(super) fn holds(&mut self, line: &str) {
        let (_, expected) = line.split_once(':').unwrap_or(("", line));
        for text in expected.split(';').map(str::trim).filter(|text| !text.is_empty()) {
            let condition = self.cell.condition(&self.of, &mut self.machine, text);
            let condition = condition.unwrap_or_else(|reason| panic!("{line}: {text}: {reason}"));
            assert!(
                self.cell.holds(&condition, &mut self.machine),
                "{line}: {text} does not hold"
            );
        }
    }

    /// A move is over.
    fn ends(&mut self, slot: u32) {
        self.cell.change_control(ControlSlot(slot), |control| {
            control.set(Flag::Pc);
            control.clear(Flag::Ip);
        });
    }
}

const TAGS: &str = "X AXIS_CIP_DRIVE, Y AXIS_CIP_DRIVE, CS COORDINATE_SYSTEM, M MOTION_INSTRUCTION, Go BOOL, Back BOOL, N DINT, K DINT";

fn bench(tag_text: &str, main: &str) -> Bench {
    Bench::new(project(&format!("{TAGS}, {tag_text}"), &[("Main", main)]))
}

fn answered(flags: &[Flag]) -> MotionControl {
    let mut control = MotionControl::default();
    flags.iter().for_each(|flag| control.set(*flag));
    control
}

#[test]
fn prescan_clears_the_bits_of_an_execution() {
    let mut bench = bench("", "XIC(Go)MAM(X,M,0,5,10,Unitspersec);");
    bench.scan("M.EN, M.DN, M.ER, M.IP, M.PC : M.PC");
    bench.start();
    bench.holds(": M.EN=0; M.DN=0; M.ER=0; M.IP=0; M.PC");
    assert!(bench.machine.calls.is_empty(), "prescan executes nothing");
}

#[test]
fn a_rung_executes_at_its_edge_and_passes_its_condition_on() {
    let mut bench = bench(
        "",
        "XIC(Go)MAM(X,M,0,5,10,Unitspersec)[XIC(M.IP)ADD(N,1,N) ,XIC(M.PC)ADD(K,1,K) ];",
    );
    bench.scan(": N=0; M.EN=0");
    // The same rung sees the acceptance.
    bench.scan("Go : M.EN; M.DN; M.IP; N=1; K=0");
    bench.scan(": N=2");
    assert_eq!(bench.machine.calls.len(), 1, "a rung that stays true");
    bench.ends(0);
    bench.scan(": N=2; K=1; M.PC; M.EN");
    bench.scan("Go=0 : M.EN=0; M.DN; M.PC");
    assert_eq!(bench.machine.falses, [0]);
    bench.scan(": M.EN=0");
    assert_eq!(bench.machine.falses, [0], "without EN there is no execution to tell");
    bench.scan("Go : M.EN; M.PC=0; N=3");
    assert_eq!(bench.machine.calls.len(), 2);
    let [
        Argument::Number(kind),
        Argument::Number(position),
        Argument::Number(speed),
    ] = bench.machine.calls[1].arguments[2..5]
    else {
        panic!("{:?}", bench.machine.calls[1])
    };
    assert_eq!(
        (bench.machine.calls[1].target, kind, position, speed),
        (Some(0), 0.0, 5.0, 10.0)
    );
}

#[test]
fn a_message_that_is_under_way_keeps_en_with_a_false_rung() {
    let mut bench = bench("", "XIC(Go)MSO(X,M);");
    bench.machine.answer = Some(answered(&[Flag::En]));
    bench.scan("Go : M.EN; M.DN=0");
    // Neither DN nor ER: EN stays, and a true rung behind it is no edge.
    bench.scan("Go=0 : M.EN; M.DN=0");
    assert_eq!(bench.machine.falses, [0], "the machine knows that the rung is false");
    bench.scan("Go : M.EN");
    assert_eq!(bench.machine.calls.len(), 1);
    bench
        .cell
        .change_control(ControlSlot(0), |control| control.set(Flag::Dn));
    bench.scan("Go=0 : M.EN=0; M.DN");
    bench.scan("Go : M.EN");
    assert_eq!(bench.machine.calls.len(), 2);
}

#[test]
fn a_refused_instruction_shows_its_error_and_executes_again_at_the_next_edge() {
    let mut bench = bench("", "XIC(Go)MAM(X,M,0,5,10,Unitspersec)XIC(M.ER)MOV(M.ERR,N);");
    bench.machine.answer = Some(MotionControl::refused(MotionError::ExecutionCollision));
    bench.scan(&format!(
        "Go : M.ER; M.EN; M.DN=0; M.IP=0; N={}",
        MotionError::ExecutionCollision.err()
    ));
    bench.scan("Go=0 : M.EN=0; M.ER");
    bench.machine.answer = None;
    bench.scan("Go : M.ER=0; M.DN; M.IP");
}

#[test]
fn structured_text_executes_in_every_scan_once_it_is_answered() {
    let mut bench = bench("", "ST\nIF Go THEN MAM(X, M, 0, 5, 10, Unitspersec); END_IF;");
    bench.scan(": M.EN=0");
    for count in 1..=3 {
        bench.scan("Go : M.EN; M.DN");
        assert_eq!(
            bench.machine.calls.len(),
            count,
            "a false rung goes before each true one"
        );
    }
    bench.machine.answer = Some(answered(&[Flag::En]));
    bench.scan(": M.EN; M.DN=0");
    bench.scan(": M.EN");
    assert_eq!(bench.machine.calls.len(), 4, "neither DN nor ER: it is under way");
}

#[test]
fn programs_write_to_the_bits_of_an_instruction() {
    let mut bench = bench(
        "",
        "XIC(Go)MAM(X,M,0,5,10,Unitspersec);\nXIC(Back)MOV(0,M.FLAGS);\nXIC(M.PC)OTU(M.PC)ADD(N,1,N);",
    );
    bench.scan("Go : M.IP");
    bench.ends(0);
    // The program has seen it, and holds the bit down until the instruction sets it anew.
    bench.scan(": M.PC=0; N=1");
    bench.scan(": M.PC=0; N=1");
    // Without EN the next scan of the true rung is an edge.
    bench.scan("Back : M.FLAGS=0");
    bench.scan("Back=0 : M.EN; M.IP");
    assert_eq!(bench.machine.calls.len(), 2);
}

#[test]
fn a_tag_of_two_instructions_belongs_to_the_newer_execution() {
    let mut bench = bench(
        "",
        "XIC(Go)MAM(X,M,0,5,10,Unitspersec);\nXIC(Back)MAM(Y,M,0,7,10,Unitspersec);",
    );
    let targets = |bench: &Bench| bench.machine.calls.iter().map(|call| call.target).collect::<Vec<_>>();
    bench.scan("Go : M.EN=0; M.DN");
    // The false rung of the second one takes EN away, so that the first one has an edge in every scan.
    bench.scan(": M.EN=0");
    assert_eq!(targets(&bench), [Some(0), Some(0)]);
    bench.scan("Go=0, Back : M.EN; M.DN");
    assert_eq!(targets(&bench), [Some(0), Some(0), Some(1)]);
    assert_eq!(bench.machine.calls[2].control, ControlSlot(0), "one tag, one slot");
}

#[test]
fn a_tick_executes_so_many_instructions() {
    for (count, faults) in [(1024, false), (1025, true)] {
        let mut bench = bench("", "ST\nFOR K := 1 TO N DO MAM(X, M, 0, 5, 10, Unitspersec); END_FOR;");
        let writes = bench
            .cell
            .writes(&bench.of, &mut bench.machine, &[("N", &count.to_string())]);
        bench
            .cell
            .write(&writes.expect("a tag"), &mut bench.machine)
            .expect("it is written");
        let ran = bench.tick().map_err(|fault| (fault.kind, fault.code));
        assert_eq!(ran, if faults { Err((6, 1)) } else { Ok(()) }, "{count}");
        assert_eq!(bench.machine.calls.len(), 1024);
    }
}

#[test]
fn add_on_instructions_get_axes_and_coordinate_systems_by_reference() {
    let in_out = |name: &str, kind: &str| parameter(name, kind, Usage::InOut, None);
    let mut of = project(&format!("{TAGS}, P Put, Q Put"), &[("Main", "XIC(Go)Put(P,Y,CS,M);")]);
    of.instructions.push(add_on(
        "Put",
        vec![
            in_out("Ax", "AXIS_CIP_DRIVE"),
            in_out("Sys", "COORDINATE_SYSTEM"),
            in_out("Mc", "MOTION_INSTRUCTION"),
            parameter("Seen", "REAL", Usage::Output, Some("0")),
        ],
        vec![routine(
            "Logic",
            "XIO(Own.EN)MAM(Ax,Mc,0,5,10,Unitspersec);\nXIC(Mc.IP)MCS(Sys,Own,All,No,10,Unitspersec2);\nMOV(Ax.ActualPosition,Seen);",
        )],
    ));
    let own = MemberSource {
        name: "Own".to_owned(),
        data_type: "MOTION_INSTRUCTION".to_owned(),
        dimensions: Vec::new(),
        access: Access::ReadWrite,
    };
    of.instructions[0].locals.push((own, None));
    let mut bench = Bench::new(of);
    bench.scan("Y.ActualPosition=2.5, Go : M.IP; P.Own.EN; P.Seen=2.5; Q.Own.EN=0");
    let calls: Vec<_> = bench
        .machine
        .calls
        .iter()
        .map(|call| (call.mnemonic.to_string(), call.target, call.control.0))
        .collect();
    let slot = |name: &str| bench.machine.slots.iter().position(|slot| slot == name).expect(name) as u32;
    assert_eq!(
        calls,
        [
            ("MAM".to_owned(), Some(1), slot("M")),
            ("MCS".to_owned(), Some(0), slot("P.Own"))
        ]
    );
}

#[test]
fn add_on_instructions_get_positions_by_reference() {
    for (defined, position) in [(3, "Pos"), (3, "Pos[0]"), (1, "Pos"), (1, "Pos[0]")] {
        let mut of = project(
            &format!("{TAGS}, P Put, To REAL[3] 1;2;3"),
            &[("Main", "XIC(Go)Put(P,CS,M,To);")],
        );
        let mut to = parameter("Pos", "REAL", Usage::InOut, None);
        to.member.dimensions = vec![defined];
        of.instructions.push(add_on(
            "Put",
            vec![
                parameter("Sys", "COORDINATE_SYSTEM", Usage::InOut, None),
                parameter("Mc", "MOTION_INSTRUCTION", Usage::InOut, None),
                to,
            ],
            vec![routine(
                "Logic",
                &format!("MCLM(Sys,Mc,0,{position},10,Unitspersec,10,Unitspersec2,10,Unitspersec2);"),
            )],
        ));
        let mut bench = Bench::new(of);
        bench.scan("Go : M.IP");
        let expected = Argument::Array(arcline_instruction_set::RealArray::from_slice(&[1.0, 2.0, 3.0]));
        let read: Vec<_> = bench.machine.calls.iter().map(|call| call.arguments[3]).collect();
        assert_eq!(read, [expected], "{position} of {defined}");
    }
}

#[test]
fn operands_are_read_at_the_edge_from_the_element_on() {
    let mut of = project(
        &format!("{TAGS}, Path Point[3]"),
        &[(
            "Main",
            "XIC(Go)MCLM(CS,M,0,Path[K].Position[0],Path[K].Speed,Unitspersec);",
        )],
    );
    let member = |name: &str, dimensions: &[u32]| MemberSource {
        name: name.to_owned(),
        data_type: "REAL".to_owned(),
        dimensions: dimensions.to_vec(),
        access: Access::ReadWrite,
    };
    of.types.push(TypeSource {
        name: "Point".to_owned(),
        is_string: false,
        members: vec![member("Speed", &[]), member("Position", &[3])],
    });
    let number = |value: &str| Datum::Number(value.to_owned());
    let point = |speed: &str, position: [&str; 3]| {
        let position = Datum::Array(position.into_iter().map(number).collect());
        let members = vec![("Speed".to_owned(), number(speed)), ("Position".to_owned(), position)];
        Datum::Structure("Point".to_owned(), members)
    };
    let path = [
        point("10", ["1", "2", "3"]),
        point("20", ["4", "5", "6"]),
        point("30", ["7", "8", "9"]),
    ];
    if let Some(tag) = of.tags.last_mut() {
        tag.value = Some(Datum::Array(path.into()));
    }
    let mut bench = Bench::new(of);
    bench.scan("K=1, Go : M.IP");
    // Written while the rung is true: no edge, so the instruction does not read it.
    bench.scan("K=2 : M.IP");
    bench.scan("Go=0 :");
    bench.scan("Go :");
    let read: Vec<_> = bench
        .machine
        .calls
        .iter()
        .map(|call| (call.arguments[3], call.arguments[4]))
        .collect();
    let of = |position: [f64; 3], speed| {
        let position = arcline_instruction_set::RealArray::from_slice(&position);
        (Argument::Array(position), Argument::Number(speed))
    };
    assert_eq!(read, [of([4.0, 5.0, 6.0], 20.0), of([7.0, 8.0, 9.0], 30.0)]);
}

#[test]
fn a_subscript_of_a_false_rung_is_looked_at() {
    let mut bench = bench("Ms MOTION_INSTRUCTION[2]", "XIC(Go)MAM(X,Ms[K],0,5,10,Unitspersec);");
    bench.scan(": Ms[0].EN=0");
    let writes = bench.cell.writes(&bench.of, &mut bench.machine, &[("K", "2")]);
    bench
        .cell
        .write(&writes.expect("a tag"), &mut bench.machine)
        .expect("it is written");
    let fault = bench.tick().expect_err("motion is transitional");
    assert_eq!((fault.kind, fault.code), (4, 20));
}

#[test]
fn a_task_of_the_motion_group_runs_in_each_update_before_the_others() {
    let mut of = project(&format!("{TAGS}, Seen DINT"), &[("Main", "MOV(N,Seen);")]);
    let mut fast = of.programs[0].clone();
    fast.name = "Fast".to_owned();
    fast.tags = tags("");
    fast.routines = vec![routine("Main", "ADD(N,1,N);\nXIC(Go)MAM(X,M,0,5,10,Unitspersec);")];
    of.programs.push(fast);
    of.tasks[0].trigger = Trigger::Periodic(30.0);
    let trigger = Trigger::Event("Motion Group Execution".to_owned(), None);
    of.tasks.push(TaskSource::new("Planner", trigger, &["Fast"]));
    let mut bench = Bench::new(of);
    // Ticks of 10 ms: the periodic task runs in the first and the fourth, behind the motion group's.
    bench.scan(": N=1; Seen=1");
    bench.scan(": N=2; Seen=1");
    bench.scan("Go : N=3; Seen=1; M.IP");
    bench.scan(": N=4; Seen=4");
}
