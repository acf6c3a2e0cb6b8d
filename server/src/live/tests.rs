//! Programs on a machine whose ticks the test makes.

use std::sync::{Arc, Mutex};

use arcline_config::Role;
use arcline_controller::Controller;
use arcline_instruction_set::{Mnemonic, UnboundOperand};
use arcline_realtime::Rings;
use arcline_tag::Value;

use super::*;
use crate::plant::{Command, Force, ForceError, Principal, ProgramState, Refused, Right};

/// A machine, a program on it, and a client with the role of an engineer.
struct Bench {
    plant: Plant,
    machine: Arc<Mutex<(Controller, Rings)>>,
    scanner: Scanner,
}

const CLIENT: Principal = Principal::Client {
    session: 1,
    connection: 0,
};

/// An L5X of the default machine: tags as `NAME TYPE`, add-on instructions, and the lines of the program Main, which has local tags too.
fn cell(of_controller: &[&str], local: &[&str], add_ons: &str, rungs: &[&str]) -> String {
    let default = arcline_config::load(arcline_config::DEFAULT, "default").expect("it is valid");
    let tags = |all: &[&str]| -> String {
        let words = all.iter().map(|tag| tag.split_once(' ').expect("NAME TYPE"));
        words
            .map(|(name, kind)| {
                let (kind, dimensions) = kind.split_once('[').map_or((kind, ""), |(kind, sizes)| {
                    (kind, sizes.trim_end_matches(']'))
                });
                let dimensions = match dimensions {
                    "" => String::new(),
                    sizes => format!(" Dimensions=\"{sizes}\""),
                };
                format!("<Tag Name=\"{name}\" TagType=\"Base\" DataType=\"{kind}\"{dimensions} ExternalAccess=\"Read/Write\"/>")
            })
            .collect()
    };
    let rows = (0..).zip(rungs);
    let rows: String = rows
        .map(|(number, text)| format!("<Rung Number=\"{number}\" Type=\"N\"><Text><![CDATA[{text}]]></Text></Rung>"))
        .collect();
    let programs = format!(
        "<Programs><Program Name=\"Main\" MainRoutineName=\"Go\"><Tags>{}</Tags><Routines><Routine Name=\"Go\" Type=\"RLL\"><RLLContent>{rows}\
         </RLLContent></Routine></Routines></Program></Programs><Tasks><Task Name=\"T\" Type=\"PERIODIC\" Rate=\"4\" Priority=\"5\" \
         Watchdog=\"500\"><ScheduledPrograms><ScheduledProgram Name=\"Main\"/></ScheduledPrograms></Task></Tasks>",
        tags(local)
    );
    let text = arcline_l5x::export(&default);
    let text = text.replacen("</Tags>", &format!("{}</Tags>", tags(of_controller)), 1);
    let add_ons = format!("</DataTypes><AddOnInstructionDefinitions>{add_ons}</AddOnInstructionDefinitions>");
    let text = text.replacen("</DataTypes>", &add_ons, 1);
    let begin = text.find("<Programs>").expect("an export has programs");
    let end = text.find("</Programs>").expect("an end") + "</Programs>".len();
    format!("{}{programs}{}", &text[..begin], &text[end..])
}

fn source(text: &str) -> Project {
    arcline_l5x::logic(text, "Cell.L5X").expect("it is read")
}

impl Bench {
    fn new(text: &str, mode: Mode) -> Self {
        let mut project = arcline_l5x::import(text, "Cell.L5X").expect("it is read").project;
        project.tags.clear();
        Bench::on(project, text, mode)
    }

    /// The program on the machine of a configuration.
    fn on(project: Configuration, text: &str, mode: Mode) -> Self {
        let mut image = project.image();
        let mut source = source(text);
        Surroundings::of(&project.server.controller).surround(&mut source);
        let bound = bind(&project.machine, &mut image, &source, UnknownParts::Refused);
        let Bound { cell, places, listing } = bound.unwrap_or_else(|error| panic!("{error}"));
        let (rings, link) = arcline_realtime::link(&project.machine);
        let machine = Arc::new(Mutex::new((Controller::new(&project.machine), rings)));
        let plant = Plant::with(&project, link, image, None);
        plant.roles().set(1, Role::Engineer);
        let program = Arc::new(Program::new("Cell.L5X".to_owned(), mode, listing));
        plant.set_program(program.clone());
        plant.exchange(false, Image::follow_for_program);
        let other = machine.clone();
        let pause = Box::new(move || step(&other));
        let scanner = Scanner::new(plant.clone(), program, cell, places, pause);
        Bench {
            plant,
            machine,
            scanner,
        }
    }

    /// Runs ticks, with the scans that are due in each.
    fn ticks(&mut self, count: usize) {
        for _ in 0..count {
            step(&self.machine);
            self.scanner.step();
        }
    }

    fn until(&mut self, path: &str) {
        for _ in 0..5000 {
            if self.number(path) != 0.0 {
                return;
            }
            self.ticks(1);
        }
        panic!("{path} stays 0: {:?}", self.state());
    }

    fn number(&self, path: &str) -> f64 {
        let parsed = path.parse().expect("a path");
        let value = self.plant.with_image(|image| image.read(&parsed));
        value.unwrap_or_else(|error| panic!("{path}: {error}")).as_f64()
    }

    fn write(&self, path: &str, value: f64) {
        let path = path.parse().expect("a path");
        let (done, _) = self.plant.transact(CLIENT, |transaction| {
            transaction.write_value(&path, Value::Lreal(value))
        });
        done.unwrap_or_else(|error| panic!("{path}: {error}"));
    }

    fn apply(&self, principal: Principal, command: Command<'_>) -> Result<(), Refused> {
        let apply = |transaction: &mut crate::plant::Transaction<'_>| transaction.apply(command);
        self.plant.transact(principal, apply).0.map(drop)
    }

    fn state(&self) -> ProgramState {
        self.plant.program_status().expect("it has a program").state
    }
}

/// A tick of the machine.
fn step(machine: &Mutex<(Controller, Rings)>) {
    let mut machine = machine.lock().expect("no test panics with it");
    let (controller, rings) = &mut *machine;
    arcline_realtime::step(controller, rings);
}

/// An add-on instruction that adds its input to a total.
const ADDER: &str = r#"<AddOnInstructionDefinition Name="Adder" Revision="1.0" ExecutePrescan="false" ExecutePostscan="false" ExecuteEnableInFalse="false">
<Parameters><Parameter Name="EnableIn" TagType="Base" DataType="BOOL" Usage="Input" Required="false" Visible="false"/>
<Parameter Name="EnableOut" TagType="Base" DataType="BOOL" Usage="Output" Required="false" Visible="false"/>
<Parameter Name="Step" TagType="Base" DataType="DINT" Usage="Input" Required="true" Visible="true"/>
<Parameter Name="Total" TagType="Base" DataType="DINT" Usage="Output" Required="false" Visible="true"/></Parameters>
<LocalTags/><Routines><Routine Name="Logic" Type="RLL"><RLLContent><Rung Number="0" Type="N"><Text><![CDATA[ADD(Total,Step,Total);]]></Text></Rung>
</RLLContent></Routine></Routines></AddOnInstructionDefinition>"#;

#[test]
fn clients_see_the_tags_of_programs_and_instances_and_write_them() {
    let rungs = ["XIC(Go)Adder(Sum,Step);", "ADD(Count,1,Count);", "XIC(Ask)OTE(Answer);"];
    let tags = ["Go BOOL", "Step DINT", "Ask BOOL", "Answer BOOL"];
    let mut bench = Bench::new(&cell(&tags, &["Count DINT", "Sum Adder"], ADDER, &rungs), Mode::Run);
    bench.ticks(10);
    let before = bench.number("Program:Main.Count");
    assert!(before >= 2.0, "{before} scans");
    assert_eq!(bench.number("Program:Main.Sum.Total"), 0.0);
    bench.write("Step", 5.0);
    bench.write("Go", 1.0);
    assert_eq!(bench.number("Step"), 5.0, "a client reads what it wrote");
    bench.ticks(8);
    let total = bench.number("Program:Main.Sum.Total");
    assert!(total >= 5.0 && total % 5.0 == 0.0, "{total}");
    assert_eq!(bench.number("Program:Main.Sum.EnableIn"), 1.0);
    bench.write("Program:Main.Sum.Total", -1000.0);
    bench.write("Program:Main.Count", 7.0);
    bench.ticks(4);
    assert!(bench.number("Program:Main.Sum.Total") < -900.0);
    assert!((8.0..12.0).contains(&bench.number("Program:Main.Count")));
    bench.write("Ask", 1.0);
    bench.ticks(4);
    assert_eq!(bench.number("Answer"), 1.0);
    let listed = bench.plant.with_image(|image| image.programs().to_vec());
    assert_eq!(listed, ["Main"]);
}

#[test]
fn clients_write_the_members_and_parameters_that_their_access_permits() {
    let adder = [
        ("\"EnableIn\"", "Read Only"),
        ("\"EnableOut\"", "Read Only"),
        ("\"Total\"", "Read Only"),
        ("\"Step\"", "Read/Write"),
    ]
    .iter()
    .fold(ADDER.to_owned(), |text, (name, access)| {
        text.replacen(name, &format!("{name} ExternalAccess=\"{access}\""), 1)
    });
    let local = "<LocalTags><LocalTag Name=\"Own\" DataType=\"DINT\" ExternalAccess=\"None\"/></LocalTags>";
    let adder = adder.replacen("<LocalTags/>", local, 1);
    let recipe = "<DataType Name=\"Recipe\" Family=\"NoFamily\" Class=\"User\"><Members>\
                  <Member Name=\"Speed\" DataType=\"REAL\" Dimension=\"0\" Hidden=\"false\" ExternalAccess=\"Read/Write\"/>\
                  <Member Name=\"Made\" DataType=\"DINT\" Dimension=\"0\" Hidden=\"false\" ExternalAccess=\"Read Only\"/>\
                  <Member Name=\"Key\" DataType=\"DINT\" Dimension=\"0\" Hidden=\"false\" ExternalAccess=\"None\"/></Members></DataType></DataTypes>";
    let rungs = ["Adder(Sum,1);", "ADD(R[1].Made,1,R[1].Made);"];
    let text = cell(&["R Recipe[2]"], &["Sum Adder"], &adder, &rungs);
    let mut bench = Bench::new(&text.replacen("</DataTypes>", recipe, 1), Mode::Run);
    bench.ticks(8);
    #[rustfmt::skip]
    let cases = [
        ("R[1].Speed", true), ("R[1].Made", false), ("R[0].Key", false), ("R[1].Made.3", false), ("Program:Main.Sum.Step", true),
        ("Program:Main.Sum.Total", false), ("Program:Main.Sum.Own", false), ("Program:Main.Sum.EnableOut", false),
    ];
    for (path, is_writable) in cases {
        let parsed = path.parse().expect("a path");
        let write = |transaction: &mut crate::plant::Transaction<'_>| transaction.write_value(&parsed, Value::Dint(5));
        assert_eq!(bench.plant.transact(CLIENT, write).0.is_ok(), is_writable, "{path}");
    }
    bench.ticks(8);
    assert_eq!(bench.number("R[1].Speed"), 5.0);
    assert!(bench.number("R[1].Made") >= 2.0, "the program writes it");
}

#[test]
fn instructions_of_motion_go_through_the_plant_and_stop_holds_for_them() {
    let rungs = [
        "XIC(Go)MSO(X,On);",
        "XIC(On.DN)MAM(X,Move,0,Target,Speed,Units per sec,100,% of Maximum,100,% of Maximum,Trapezoidal,100,100,% of Time,Disabled,0,0,None,0,0);",
        "XIC(Move.IP)OTL(Seen);",
        "XIC(Move.PC)OTE(Done);",
    ];
    let tags = [
        "Go BOOL",
        "Target REAL",
        "Speed REAL",
        "Seen BOOL",
        "Done BOOL",
        "On MOTION_INSTRUCTION",
    ];
    let text = cell(&tags, &["Move MOTION_INSTRUCTION"], "", &rungs);
    let mut bench = Bench::new(&text, Mode::Run);
    bench.write("Target", 3.0);
    bench.write("Speed", 50.0);
    bench.write("Go", 1.0);
    bench.until("Done");
    assert_eq!(bench.number("Seen"), 1.0, "IP in the scan that executed it");
    assert_eq!(bench.number("X.CommandPosition"), 3.0);
    let mover = bench.plant.movers();
    assert!(
        mover.of_axis(arcline_instruction_set::AxisId(0)).is_none(),
        "it stands still"
    );
    assert_eq!(
        ["EN", "DN", "IP", "PC"].map(|bit| bench.number(&format!("Program:Main.Move.{bit}"))),
        [1.0, 1.0, 0.0, 1.0]
    );
    bench.plant.inhibit();
    bench.write("Go", 0.0);
    bench.ticks(10);
    bench.write("Target", 9.0);
    bench.write("Program:Main.Move.EN", 0.0);
    bench.ticks(10);
    assert_eq!(
        ["ER", "ERR"].map(|member| bench.number(&format!("Program:Main.Move.{member}"))),
        [1.0, 53.0],
        "STOP refuses what would begin motion"
    );
    assert_eq!(bench.number("X.CommandPosition"), 3.0);
}

#[test]
fn the_mode_decides_whether_tasks_run_and_needs_its_right() {
    let text = cell(
        &["Count DINT", "First DINT"],
        &[],
        "",
        &["ADD(Count,1,Count);", "XIC(S:FS)ADD(First,1,First);"],
    );
    let mut bench = Bench::new(&text, Mode::Program);
    bench.ticks(10);
    assert_eq!((bench.number("Count"), bench.state()), (0.0, ProgramState::Stopped));
    bench.plant.roles().set(1, Role::Operator);
    let refused = bench.apply(CLIENT, Command::SetMode(Mode::Run));
    assert!(
        matches!(
            refused,
            Err(Refused::Role {
                right: Right::ChangeMode,
                ..
            })
        ),
        "{refused:?}"
    );
    bench.plant.roles().set(1, Role::Engineer);
    bench
        .apply(CLIENT, Command::SetMode(Mode::Run))
        .expect("an engineer may");
    bench.ticks(10);
    assert_eq!(bench.state(), ProgramState::Running);
    let counted = bench.number("Count");
    assert!(counted >= 2.0, "{counted}");
    bench
        .apply(CLIENT, Command::SetMode(Mode::Program))
        .expect("an engineer may");
    bench.ticks(10);
    let stopped = bench.number("Count");
    bench.write("Count", 100.0);
    bench.ticks(10);
    assert!(stopped <= counted + 1.0);
    assert_eq!(bench.number("Count"), 100.0, "tags stay, and clients write them");
    bench
        .apply(CLIENT, Command::SetMode(Mode::Run))
        .expect("an engineer may");
    bench.ticks(10);
    assert!(bench.number("Count") > 100.0);
    assert_eq!(bench.number("First"), 2.0, "a first scan each time");
}

#[test]
fn a_major_fault_stops_the_tasks_and_says_where() {
    let rungs = ["XIC(Go)MOV(1,List[Index]);", "ADD(Count,1,Count);"];
    let mut bench = Bench::new(
        &cell(
            &["Go BOOL", "List DINT[4]", "Index DINT", "Count DINT"],
            &[],
            "",
            &rungs,
        ),
        Mode::Run,
    );
    bench.write("Index", 4.0);
    bench.write("Go", 1.0);
    bench.ticks(10);
    let ProgramState::Faulted(words) = bench.state() else {
        panic!("{:?}", bench.state());
    };
    assert_eq!(
        words,
        "major fault 4/20 (subscript out of range) in Main/Go rung 0, MOV: Index is 4"
    );
    let count = bench.number("Count");
    bench.ticks(10);
    assert_eq!(bench.number("Count"), count);
    bench
        .apply(CLIENT, Command::SetMode(Mode::Program))
        .expect("an engineer may");
    bench.write("Index", 0.0);
    bench.ticks(2);
    bench
        .apply(CLIENT, Command::SetMode(Mode::Run))
        .expect("an engineer may");
    bench.ticks(10);
    assert_eq!((bench.state(), bench.number("List[0]")), (ProgramState::Running, 1.0));
}

#[test]
fn another_project_is_checked_whole_and_keeps_equal_tags() {
    let first = cell(
        &["Count DINT", "Gone REAL", "Other DINT"],
        &["Mine DINT"],
        "",
        &["ADD(Count,1,Count);", "MOV(7,Mine);"],
    );
    let mut bench = Bench::new(&first, Mode::Run);
    bench.ticks(10);
    bench.write("Other", 3.0);
    let count = bench.number("Count");
    let replacement = |text: &str| Replacement {
        source: source(text),
        unknown_parts: UnknownParts::Refused,
    };
    let wrong = cell(
        &["Count DINT", "New DINT"],
        &[],
        "",
        &["ADD(Count,1,Count);", "NOSUCH(New);"],
    );
    let refused = bench
        .scanner
        .replace(&replacement(&wrong))
        .expect_err("it does not run");
    assert!(
        refused
            .to_string()
            .starts_with("Main/Go rung 1: instruction NOSUCH is not supported"),
        "{refused}"
    );
    assert!(
        bench
            .plant
            .with_image(|image| image.find("New").is_none() && image.find("Gone").is_some())
    );
    bench.ticks(8);
    assert!(bench.number("Count") > count, "it runs on");
    let second = cell(
        &["Count DINT", "Other REAL", "New DINT"],
        &["Mine DINT"],
        "",
        &["ADD(Count,10,Count);", "MOV(Mine,New);"],
    );
    bench.scanner.replace(&replacement(&second)).expect("it runs");
    let count = bench.number("Count");
    assert!(count > 1.0, "its value is kept");
    bench.ticks(8);
    assert!(bench.number("Count") >= count + 10.0);
    assert_eq!(
        (bench.number("New"), bench.number("Other")),
        (7.0, 0.0),
        "another type begins anew"
    );
    assert!(bench.plant.with_image(|image| image.find("Gone").is_none()));
}

#[test]
fn a_loop_without_end_ends_by_the_watchdog() {
    let mut bench = Bench::new(
        &cell(
            &["Count DINT"],
            &[],
            "",
            &["LBL(Again)ADD(Count,1,Count);", "JMP(Again);"],
        ),
        Mode::Run,
    );
    bench.ticks(2);
    assert!(matches!(bench.state(), ProgramState::Faulted(words) if words.starts_with("major fault 6/1")));
}

/// A module with inputs in slot 1.
const INPUTS: &str = r#"<Modules><Module Name="Inputs" CatalogNumber="1756-IB16" ParentModule="Local"><Ports><Port Id="1" Address="1" Type="ICP" Upstream="true"/></Ports>
<Communications><Connections><Connection Name="Input"><InputTag ExternalAccess="Read/Write"><Data Format="Decorated"><Structure DataType="AB:1756_DI:I:0">
<DataValueMember Name="Fault" DataType="DINT" Value="0"/><DataValueMember Name="Data" DataType="DINT" Value="0"/></Structure></Data></InputTag></Connection></Connections>
</Communications></Module></Modules>"#;

#[test]
fn an_input_is_forced_by_right_and_gets_its_own_value_back() {
    let text = cell(
        &["Seen BOOL", "Plain BOOL"],
        &[],
        "",
        &["XIC(Local:1:I.Data.3)OTE(Seen);"],
    );
    let text = text.replacen("</DataTypes>", &format!("</DataTypes>{INPUTS}"), 1);
    let mut bench = Bench::new(&text, Mode::Run);
    bench.ticks(8);
    let force =
        |bench: &Bench, name: &str, on| bench.plant.with_image(|image| Force::new(image, name, Value::Bool(on)));
    let on = force(&bench, "Local:1:I.Data.3", true).expect("an input");
    bench.plant.roles().set(1, Role::Operator);
    let refused = bench.apply(CLIENT, Command::Force(&on));
    assert!(
        matches!(
            refused,
            Err(Refused::Role {
                right: Right::Force,
                ..
            })
        ),
        "{refused:?}"
    );
    bench.plant.roles().set(1, Role::Engineer);
    bench.apply(CLIENT, Command::Force(&on)).expect("an engineer may");
    bench.ticks(8);
    assert_eq!(bench.number("Seen"), 1.0);
    assert_eq!(bench.number("Local:1:I.Data"), 8.0, "clients see the forced value");
    // The value that a client writes waits under the force; the client may write the other bits.
    bench.write("Local:1:I.Data", 5.0);
    bench.ticks(8);
    assert_eq!(bench.number("Local:1:I.Data"), 13.0);
    bench
        .apply(CLIENT, Command::RemoveForce(Some("local:1:i.data.3")))
        .expect("it is forced");
    bench.ticks(8);
    assert_eq!((bench.number("Seen"), bench.number("Local:1:I.Data")), (0.0, 5.0));
    let none = bench.apply(CLIENT, Command::RemoveForce(Some("Local:1:I.Data.3")));
    assert!(
        matches!(none, Err(Refused::Force(ForceError::NotForced { .. }))),
        "{none:?}"
    );
    bench.apply(CLIENT, Command::RemoveForce(None)).expect("none is left");
    #[rustfmt::skip]
    let wrong = [
        ("a plain tag",  "Plain",          "Plain is not an input of a module, expected a tag such as Local:1:I.Data.0; other tags can be written"),
        ("a structure",  "Local:1:I",      "Local:1:I is AB:1756_DI:I:0, expected a BOOL, a bit or a number"),
        ("no tag",       "Local:2:I.Data", "Local:2:I.Data: there is no tag \"Local:2:I\""),
    ];
    for (why, name, words) in wrong {
        let error = force(&bench, name, true).expect_err(why);
        assert_eq!(error.to_string(), words, "{why}");
    }
}

/// A module of outputs in slot 2, behind the inputs of slot 1.
fn with_modules(text: &str) -> String {
    let outputs = INPUTS
        .replacen("<Modules>", "", 1)
        .replace("Address=\"1\"", "Address=\"2\"")
        .replace("Name=\"Inputs\"", "Name=\"Outputs\"")
        .replace("InputTag", "OutputTag")
        .replace("AB:1756_DI:I:0", "AB:1756_DO:O:0");
    let inputs = INPUTS.replacen("</Modules>", "", 1);
    text.replacen("</DataTypes>", &format!("</DataTypes>{inputs}{outputs}"), 1)
}

/// The default machine with an axis X that is homed to its switch, and wires.
fn wired(wires: &[(&str, &str)]) -> Configuration {
    let homed = "name = \"X\"\ntype = \"servo\"\nhome = { sequence = \"switch\", direction = \"unidirectional-forward\", speed = 40.0 }";
    let mut text = arcline_config::DEFAULT.replacen("name = \"X\"\ntype = \"servo\"", homed, 1);
    for (from, to) in wires {
        text.push_str(&format!("\n[[controller.wire]]\nfrom = \"{from}\"\nto = \"{to}\"\n"));
    }
    arcline_config::load(&text, "machine.toml").unwrap_or_else(|errors| panic!("{errors:?}"))
}

#[test]
fn an_axis_is_homed_to_a_switch_that_is_wired_to_an_output_and_shown_at_an_input() {
    let rungs = [
        "GEQ(X.ActualPosition,20)OTE(Local:2:O.Data.3);",
        "XIC(Go)MAH(X,M);",
        "XIC(Local:1:I.Data.7)ONS(Was)ADD(Seen,1,Seen);",
    ];
    let tags = ["Go BOOL", "M MOTION_INSTRUCTION", "Was BOOL", "Seen DINT"];
    let text = with_modules(&cell(&tags, &[], "", &rungs));
    let wires = [
        ("Local:2:O.Data.3", "X.home_switch"),
        ("X.home_switch", "Local:1:I.Data.7"),
    ];
    let mut bench = Bench::on(wired(&wires), &text, Mode::Run);
    bench.ticks(8);
    assert_eq!(bench.number("X.HomeInputStatus"), 0.0);
    bench.write("Go", 1.0);
    bench.until("M.PC");
    assert_eq!((bench.number("M.ER"), bench.number("X.AxisHomedStatus")), (0.0, 1.0));
    bench.ticks(8);
    assert_eq!(bench.number("Seen"), 1.0, "the input shows the switch");
    // The home point is where the switch became active; the axis has braked behind it.
    let behind = bench.number("X.ActualPosition");
    assert!((0.0..2.0).contains(&behind), "{behind}");
    // Without the wire there is no switch.
    let mut bench = Bench::on(wired(&wires[1..]), &text, Mode::Run);
    bench.write("Go", 1.0);
    bench.until("M.ER");
    assert_eq!(bench.number("M.ERR"), 84.0, "Drive Digital Input Not Assigned");
}

#[test]
fn an_output_enables_a_drive_and_a_force_stays_above_a_wire() {
    let rungs = ["XIC(Run)OTE(Local:2:O.Data.0);", "XIC(Local:1:I.Data.7)OTE(Seen);"];
    let text = with_modules(&cell(&["Run BOOL", "Seen BOOL", "Plain BOOL"], &[], "", &rungs));
    let wires = [("Local:2:O.Data.0", "X.enable"), ("Plain", "Local:1:I.Data.7")];
    let mut bench = Bench::on(wired(&wires), &text, Mode::Program);
    bench.ticks(8);
    assert_eq!(
        bench.number("X.ServoActionStatus"),
        1.0,
        "in Program mode no wire says anything"
    );
    bench.write("Run", 1.0);
    bench
        .apply(CLIENT, Command::SetMode(Mode::Run))
        .expect("an engineer may");
    bench.ticks(8);
    assert_eq!(bench.number("X.ServoActionStatus"), 1.0);
    bench.write("Run", 0.0);
    bench.ticks(16);
    let [servo, fault, other] =
        ["X.ServoActionStatus", "X.PhysicalAxisFault", "Y.ServoActionStatus"].map(|path| bench.number(path));
    assert_eq!(
        (servo, fault, other),
        (0.0, 1.0, 1.0),
        "a drive that is switched off faults its axis"
    );

    let on = bench
        .plant
        .with_image(|image| Force::new(image, "Local:1:I.Data.7", Value::Bool(true)));
    bench
        .apply(CLIENT, Command::Force(&on.expect("an input")))
        .expect("an engineer may");
    bench.ticks(8);
    assert_eq!(bench.number("Seen"), 1.0);
    bench.apply(CLIENT, Command::RemoveForce(None)).expect("it is forced");
    bench.ticks(8);
    assert_eq!(bench.number("Seen"), 0.0, "the wire gives it again");
    bench.write("Plain", 1.0);
    bench.ticks(8);
    assert_eq!(bench.number("Seen"), 1.0);
}

#[test]
fn a_wire_that_leads_nowhere_keeps_the_program_from_running() {
    let text = cell(&["Plain BOOL"], &[], "", &["NOP();"]);
    for (from, to, why) in [
        ("Plain", "Nowhere", "Nowhere: there is no tag Nowhere"),
        ("Q.home_switch", "Plain", "Q.home_switch: there is no tag Q"),
        ("Plain", "V.enable", "V.enable: "),
    ] {
        let project = wired(&[(from, to)]);
        let mut source = source(&text);
        Surroundings::of(&project.server.controller).surround(&mut source);
        let bound = bind(&project.machine, &mut project.image(), &source, UnknownParts::Allowed);
        let error = bound.err().expect(why).to_string();
        assert!(
            error.starts_with(&format!("wire from {from} to {to}: {why}")),
            "{error}"
        );
    }
}

#[test]
fn a_move_is_the_same_by_ladder_structured_text_tag_write_and_service() {
    const OPERANDS: &str = "Unitspersec, 1500, Unitspersec2, 1200, Unitspersec2, S-curve, 100, 100, %ofTime, 1";
    let tags = ["Go BOOL", "M MOTION_INSTRUCTION", "Pos REAL[3]"];
    let position = ["Pos[0]", "Pos[1]"].map(|path| (path, if path == "Pos[0]" { 50.0 } else { 25.0 }));
    let ladder = format!("XIC(Go)MCLM(CS1,M,0,Pos[0],80,{OPERANDS});");
    let idle = cell(&tags, &[], "", &["NOP();"]);
    let text = cell(&tags, &[], "", &["NOP();"]).replace(
        "<Routine Name=\"Go\" Type=\"RLL\"><RLLContent><Rung Number=\"0\" Type=\"N\"><Text><![CDATA[NOP();]]></Text></Rung></RLLContent>",
        &format!("<Routine Name=\"Go\" Type=\"ST\"><STContent><Line Number=\"0\"><![CDATA[IF Go AND NOT M.EN THEN MCLM(CS1, M, 0, Pos[0], 80, {OPERANDS}); END_IF;]]></Line></STContent>"),
    );
    assert_ne!(text, idle, "a routine of Structured Text");
    let interfaces = [
        ("ladder", cell(&tags, &[], "", &[&ladder])),
        ("structured text", text),
        ("tag write", idle.clone()),
        ("service", idle),
    ];
    let mut first: Vec<[u64; 4]> = Vec::new();
    for (interface, text) in interfaces {
        let mut bench = Bench::new(&text, Mode::Run);
        bench.ticks(8);
        position.iter().for_each(|(path, value)| bench.write(path, *value));
        match interface {
            "tag write" => {
                let operands = [
                    ("Position[0]", 50.0),
                    ("Position[1]", 25.0),
                    ("Speed", 80.0),
                    ("SpeedUnits", 0.0),
                    ("AccelRate", 1500.0),
                    ("AccelUnits", 0.0),
                    ("DecelRate", 1200.0),
                    ("DecelUnits", 0.0),
                    ("Profile", 1.0),
                    ("TerminationType", 1.0),
                ];
                for (member, value) in operands {
                    bench.write(&format!("Move1.{member}"), value);
                }
                bench.write("Move1.EnableIn", 1.0);
            }
            "service" => {
                let operands = [
                    UnboundOperand::Number(0.0),
                    UnboundOperand::Array(vec![50.0, 25.0, 0.0]),
                    UnboundOperand::Number(80.0),
                    UnboundOperand::Number(0.0),
                    UnboundOperand::Number(1500.0),
                    UnboundOperand::Number(0.0),
                    UnboundOperand::Number(1200.0),
                    UnboundOperand::Number(0.0),
                    UnboundOperand::Number(1.0),
                    UnboundOperand::Number(100.0),
                    UnboundOperand::Number(100.0),
                    UnboundOperand::Number(2.0),
                    UnboundOperand::Number(1.0),
                ];
                let call = crate::plant::Call {
                    mnemonic: Mnemonic::Mclm,
                    target: Some(0),
                    control: Some("M"),
                    operands: &operands,
                    text: None,
                };
                bench.apply(CLIENT, Command::Call(call)).expect("it is accepted");
            }
            _ => bench.write("Go", 1.0),
        }
        // From the first tick that moves on: principals differ in the tick that takes the command, and in no other respect.
        let mut rows = Vec::new();
        let paths = [
            "X.CommandPosition",
            "X.ActualPosition",
            "Y.CommandPosition",
            "CS1.ActualPosition[0]",
        ];
        for _ in 0..3000 {
            let row = paths.map(|path| bench.number(path).to_bits());
            if !rows.is_empty() || row[0] != 0 {
                rows.push(row);
            }
            bench.ticks(1);
        }
        assert!(
            rows.len() > 500 && bench.number("X.CommandPosition") == 50.0,
            "{interface}: {} rows",
            rows.len()
        );
        if first.is_empty() {
            first = rows;
            continue;
        }
        let same = first.iter().zip(&rows).take_while(|(a, b)| a == b).count();
        assert_eq!(
            same,
            first.len().min(rows.len()),
            "{interface}: from this row on it differs"
        );
    }
}

#[test]
fn a_monitor_is_sampled_until_its_viewer_goes() {
    let text = cell(
        &["Go BOOL", "Count DINT"],
        &[],
        "",
        &["XIC(Go)ADD(Count,1,Count);", "NOP();"],
    );
    let mut bench = Bench::new(&text, Mode::Run);
    let program = bench.plant.program().expect("it has one").clone();
    let (version, listing) = program.listing();
    let routine = listing.routine("Main", "Go").expect("there is one");
    let mut samples = program.monitors.begin(7, version, listing.monitor(routine, 0, 2, None));
    let old = program
        .monitors
        .begin(8, version + 1, listing.monitor(routine, 0, 2, None));
    bench.write("Go", 1.0);
    // Samples come with the clock of the system.
    let deadline = std::time::Instant::now() + Duration::from_secs(20);
    loop {
        bench.ticks(4);
        let rows = samples.borrow_and_update().clone();
        if rows.first().is_some_and(|row| row.power == "111") {
            assert_eq!((rows.len(), rows[1].power.as_str()), (2, "11"));
            assert_eq!(rows[0].values[0], arcline_routine::MonitoredValue::Bool(true));
            break;
        }
        assert!(std::time::Instant::now() < deadline, "{rows:?}");
    }
    assert!(old.borrow().is_empty(), "numbers of another program mean nothing");
    drop((samples, old));
    program.monitors.end(9);
    let deadline = std::time::Instant::now() + Duration::from_secs(20);
    while !program.monitors.lock().is_empty() {
        bench.ticks(4);
        assert!(
            std::time::Instant::now() < deadline,
            "monitors of viewers that have gone stay"
        );
    }
}
