//! The command line from outside: exit codes, messages, the ready line, signals.

use std::io::{BufRead as _, BufReader, Read as _, Write as _};
use std::net::TcpStream;
use std::path::PathBuf;
use std::process::{Child, Command, Output, Stdio};

fn server() -> Command {
    Command::new(env!("CARGO_BIN_EXE_arcline-server"))
}

struct Files(tempfile::TempDir);

impl Files {
    fn new() -> Self {
        Files(tempfile::tempdir().expect("a temporary directory"))
    }

    fn write(&self, name: &str, text: &str) -> PathBuf {
        let path = self.0.path().join(name);
        std::fs::write(&path, text).expect("a temporary file");
        path
    }
}

fn simulate(program: &str, args: &[&str]) -> Output {
    let files = Files::new();
    let program = files.write("program.st", program);
    server()
        .arg("simulate")
        .arg(program)
        .args(args)
        .output()
        .expect("the server runs")
}

const MOVE: &str = "MCLM(CS1, M, 0, [50, 0, 0], 100, 0, 2000, 0, 2000, 0, 0, 100, 100, 2, 1, 0, 0, 0, 0, 0, 0, 0);";
const REFUSED: &str = "MCLM(CS1, Bad, 0, [50, 0, 0], -1, 0, 2000, 0, 2000, 0, 0, 100, 100, 2, 1, 0, 0, 0, 0, 0, 0, 0);";

#[test]
fn simulate_tells_how_it_ended() {
    let four = format!("{MOVE}{MOVE}{MOVE}{MOVE}");
    let goes_on = format!("{REFUSED}\n{MOVE} WAIT(M.PC);");
    let stops = format!("{MOVE}\n{REFUSED}\nWAIT(FALSE);");
    let stopped = format!("{MOVE} DELAY(0.05); MCS(CS1, Halt, All);\nWAIT(M.PC);");
    let at_once = format!("{MOVE} DELAY(0.05);\nMCS(CS1, Halt, All); WAIT(M.PC);");
    let stands = format!("{MOVE}\nWAIT(X.CommandPosition > 51);");
    let no_speed =
        "MCLM(CS1, M, Absolute, [9, 0, 0], 0, Unitspersec, 1000, Unitspersec2, 1000, Unitspersec2);\nWAIT(M.PC);";
    let jogs = "MSO(X, On); WAIT(On.DN); MAJ(X, Jog, Forward, 1, Unitspersec, 1000, Unitspersec2, 1000, Unitspersec2);\nWAIT(X.CommandPosition > 65); MAS(X, Halt);";
    let goes_wrong = format!("{REFUSED}\nWAIT(Bad.PC);");
    let either = format!("{MOVE} DELAY(0.05); MCS(CS1, Halt, All); WAIT(M.PC OR X.CommandVelocity = 0);");
    let faulted = format!("{MOVE} DELAY(0.05); FaultInject[0] := 16;");
    let waits = format!("{faulted}\nWAIT(M.PC AND X.MoveStatus = 0);");
    #[rustfmt::skip]
    let cases: &[(&str, &str, &[&str], i32, &str)] = &[
        // why,                           program,                 arguments,                    exit, message
        ("ran to its end",                MOVE,                    &[],                          0, "s, 1 instruction; X at 50 mm\n"),
        ("nothing at all",                "",                      &[],                          0, "program.st: ended after 0 s, 0 instructions\n"),
        ("an error stops it",             &stops,                  &[],                          1, "line 2: MCLM (Bad): ERR 13"),
        ("an error is passed over",       &goes_on,                &["--keep-going"],            0, "2 instructions"),
        ("does not parse",                "MCLM(",                 &[],                          2, "line 1"),
        ("an unknown coordinate system",  "MCSD(CS9, M);",         &[],                          2, "CS9"),
        ("an unknown tag",                "WAIT(Nothing.PC);",     &[],                          2, "Nothing"),
        ("a read-only tag",               "X.CommandPosition := 1;", &[],                        2, "read-only"),
        ("waits for ever",                "WAIT(FALSE);",          &["--until", "1"],            3, "after 1 s"),
        ("waits for a stopped move",      &stopped,                &[],                          1, "line 2: WAIT can no longer come true: M (MCLM, line 1) was stopped by MCS Halt"),
        ("waits while nothing moves",     &stands,                 &[],                          1, "line 2: WAIT can no longer come true: every axis is at rest"),
        ("waits without a speed",         no_speed,                &[],                          1, "line 2: WAIT can no longer come true: every axis is at rest"),
        ("waits while an axis jogs",      jogs,                    &[],                          0, "s, 3 instructions"),
        ("stops in the tick of the wait", &at_once,                &[],                          1, "M (MCLM, line 1) was stopped by MCS Halt"),
        ("waits for an error",            &goes_wrong,             &["--keep-going"],            1, "Bad (MCLM, line 1) erred: ERR 13"),
        ("waits for what never was",      "WAIT(M.PC); MSO(X, M);", &[],                         1, "M was never executed"),
        ("waits for either",              &either,                 &[],                          0, "2 instructions"),
        ("a fault ends the move",         &faulted,                &[],                          0, "X faulted: overcurrent"),
        ("waits for a faulted move",      &waits,                  &[],                          1, "M (MCLM, line 1) was stopped by a fault: X overcurrent"),
        ("an operand is left out",        "MAJ(X, J, Forward, 20);", &[],                       1, "(Accel Rate): Accel Rate was not given"),
        ("delays beyond",                 "DELAY(10);",            &["--until", "1"],            3, "after 1 s"),
        ("loops for ever",                "WHILE TRUE DO END_WHILE;", &["--until", "0.005"],     3, "after 0.005 s"),
        ("a full queue waits",            &four,                   &[],                          0, "4 instructions"),
        ("a full queue errs",             &four,                   &["--queue-full", "error"],   1, "ERR 13"),
        ("a wrong flag",                  "",                      &["--untill", "1"],           2, "--until"),
    ];
    for (why, program, args, exit, message) in cases {
        // ERR of a full queue has its own number; only that it erred counts here.
        let message = if *why == "a full queue errs" { "ERR" } else { message };
        let out = simulate(program, args);
        let stderr = String::from_utf8_lossy(&out.stderr);
        assert_eq!(out.status.code(), Some(*exit), "{why}: {stderr}");
        assert!(stderr.contains(message), "{why}: {stderr}");
        assert_eq!(stderr.is_empty(), message.is_empty(), "{why}: {stderr}");
    }
}

#[test]
fn a_simulation_can_write_to_standard_output() {
    let program = format!("{MOVE} DELAY(0.05); FaultInject[0] := 16; DELAY(0.1); MAFR(X, R); DELAY(0.1);");
    let lines = |args: &[&str]| -> Vec<String> {
        let out = simulate(&program, args);
        assert_eq!(out.status.code(), Some(0), "{args:?}: {out:?}");
        let text = String::from_utf8(out.stdout).expect("UTF-8");
        text.lines().map(str::to_owned).collect()
    };
    assert!(lines(&["--trace", "-"])[0].starts_with("tick,time_s,X.CommandPosition"));
    assert!(lines(&["--events", "-"])[0].starts_with("{\"time_s\":0,\"tick\":0,\"tag\":\"M\""));
    let faults = lines(&["--faults", "-"]);
    #[rustfmt::skip]
    let expected = [
        "\"axis\":\"X\",\"set\":[\"overcurrent\"],\"again\":[],\"clear\":[]}",
        "\"axis\":\"X\",\"set\":[],\"again\":[],\"clear\":[\"overcurrent\"]}",
        "\"axis\":\"X\",\"set\":[\"overcurrent\"],\"again\":[\"overcurrent\"],\"clear\":[]}",
    ];
    assert_eq!(faults.len(), expected.len(), "{faults:?}");
    for (line, expected) in faults.iter().zip(expected) {
        assert!(line.ends_with(expected), "{line}, expected {expected}");
    }
    let both = simulate(MOVE, &["--trace", "-", "--events", "-"]);
    assert_eq!(both.status.code(), Some(2), "{both:?}");
}

#[test]
fn a_wrong_configuration_is_one_message_and_exit_2() {
    let files = Files::new();
    let bad = files.write("bad.toml", "[server]\nlisten = \"nowhere\"\n");
    let program = files.write("empty.st", "");
    let commands: Vec<Vec<&std::ffi::OsStr>> = vec![
        vec!["check".as_ref(), "--config".as_ref(), bad.as_os_str()],
        vec!["--config".as_ref(), bad.as_os_str()],
        vec!["run".as_ref(), "--config".as_ref(), bad.as_os_str()],
        vec![
            "simulate".as_ref(),
            program.as_os_str(),
            "--config".as_ref(),
            bad.as_os_str(),
        ],
    ];
    for args in commands {
        let out = server().args(&args).output().expect("the server runs");
        let stderr = String::from_utf8_lossy(&out.stderr);
        assert_eq!(out.status.code(), Some(2), "{args:?}: {stderr}");
        assert!(
            stderr.contains("bad.toml:2:") && stderr.contains("server.listen"),
            "{args:?}: {stderr}"
        );
        assert!(out.stdout.is_empty(), "{args:?}");
    }
}

#[test]
fn a_check_prints_all_errors_as_text_or_json() {
    let files = Files::new();
    let bad = files.write(
        "bad.toml",
        "[server]\nlisten = \"nowhere\"\nnam = 1\n[[axis]]\nname = \"X\"\ntype = \"servo\"\n",
    );
    let run = |args: &[&str]| {
        let out = server()
            .args(args)
            .arg("--config")
            .arg(&bad)
            .output()
            .expect("the server runs");
        assert_eq!(out.status.code(), Some(2));
        [out.stdout, out.stderr].map(|text| String::from_utf8(text).expect("UTF-8"))
    };
    let [out, text] = run(&["check"]);
    assert!(out.is_empty());
    for (line, part) in text.lines().zip([
        "bad.toml:2:10: server.listen:",
        "bad.toml:3:1: server.nam: unknown key",
        "bad.toml:4:1: axis[1].max_speed: missing",
    ]) {
        assert!(line.contains(part), "{line}");
    }
    assert_eq!(text.lines().count(), 4, "{text}");
    let [out, text] = run(&["check", "--json"]);
    assert!(text.is_empty(), "{text}");
    let json: serde_json::Value = serde_json::from_str(&out).expect("JSON");
    assert_eq!(
        (&json["valid"], json["errors"].as_array().map(Vec::len)),
        (&false.into(), Some(4))
    );
    assert_eq!(json["errors"][2]["key"], "axis[1].max_speed");
    assert_eq!(json["errors"][2]["expected"], "a number above 0 (units/s)");
    let schema = server()
        .args(["config", "schema"])
        .output()
        .expect("the server runs")
        .stdout;
    let schema: serde_json::Value = serde_json::from_slice(&schema).expect("JSON");
    assert_eq!(
        schema["properties"]["axis"]["items"]["properties"]["max_speed"]["exclusiveMinimum"],
        0.0
    );
}

#[test]
fn a_check_warns_of_files_that_a_server_could_not_use() {
    let files = Files::new();
    let config = files.write("machine.toml", "[security]\nusers = \"people.toml\"\n");
    let check = |args: &[&str]| {
        let out = server()
            .arg("check")
            .args(args)
            .arg("--config")
            .arg(&config)
            .output()
            .expect("the server runs");
        assert_eq!(out.status.code(), Some(0), "{out:?}");
        [out.stdout, out.stderr].map(|text| String::from_utf8(text).expect("UTF-8"))
    };
    let [_, text] = check(&[]);
    assert!(text.starts_with("arcline-server: warning: users: "), "{text}");
    assert!(text.contains("people.toml"), "{text}");
    let [out, text] = check(&["--json"]);
    assert!(text.is_empty(), "{text}");
    let json: serde_json::Value = serde_json::from_str(&out).expect("JSON");
    assert_eq!(
        (&json["valid"], json["warnings"].as_array().map(Vec::len)),
        (&true.into(), Some(1)),
        "{json}"
    );
}

#[test]
fn a_certificate_of_a_client_is_replaced_only_on_demand() {
    let files = Files::new();
    let certs = |arguments: &[&str]| {
        let out = server()
            .args(["certs", arguments[0]])
            .arg(files.0.path())
            .args(&arguments[1..])
            .output()
            .expect("the server runs");
        (out.status.code(), String::from_utf8(out.stderr).expect("UTF-8"))
    };
    let key = || std::fs::read(files.0.path().join("hmi.key")).expect("the key");
    assert_eq!(certs(&["init"]).0, Some(0));
    assert_eq!(certs(&["client", "hmi"]).0, Some(0));
    let first = key();
    let (code, text) = certs(&["client", "hmi"]);
    assert_eq!(code, Some(2));
    assert!(text.contains("hmi.pem exists; `--replace`"), "{text}");
    assert_eq!(key(), first);
    assert_eq!(certs(&["client", "hmi", "--replace"]).0, Some(0));
    assert_ne!(key(), first);
}

#[test]
fn the_default_configuration_checks() {
    let text = server().arg("default-config").output().expect("the server runs").stdout;
    let files = Files::new();
    let file = files.write("default.toml", &String::from_utf8(text).expect("text"));
    let out = server()
        .args(["check", "--config"])
        .arg(file)
        .output()
        .expect("the server runs");
    assert!(out.status.success());
    assert!(String::from_utf8_lossy(&out.stdout).contains("coordinate system CS1: X Y Z"));
}

#[test]
fn retained_state_needs_a_folder_that_is_there() {
    let out = server()
        .args(["--listen", "127.0.0.1:0", "--state", "nowhere/machine.state"])
        .output()
        .expect("the server runs");
    assert_eq!(out.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&out.stderr).contains("--state nowhere/machine.state"));
}

/// A running server that is ended when the test ends.
struct Running {
    child: Child,
    address: String,
}

impl Running {
    fn start(args: &[&str]) -> Self {
        let mut child = server()
            .args(["--listen", "127.0.0.1:0", "--hmi", "off", "--state", "off"])
            .args(args)
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the server runs");
        let mut line = String::new();
        let stdout = child.stdout.take().expect("it was piped");
        BufReader::new(stdout).read_line(&mut line).expect("a ready line");
        let address = line
            .strip_prefix("ready eip=")
            .and_then(|rest| rest.strip_suffix(" hmi=off\n"));
        Running {
            address: address
                .unwrap_or_else(|| panic!("not a ready line: {line:?}"))
                .to_owned(),
            child,
        }
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        // The process may have ended by itself.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

#[test]
fn it_is_ready_when_it_says_so_and_ends_when_it_is_told() {
    for signal in ["-TERM", "-INT"] {
        let mut running = Running::start(&[]);
        let mut stream = TcpStream::connect(&running.address).expect("it accepts");
        let mut list_identity = [0; 24];
        list_identity[0] = 0x63;
        stream.write_all(&list_identity).expect("it reads");
        let mut reply = [0; 24];
        stream.read_exact(&mut reply).expect("it answers");
        assert_eq!(reply[0], 0x63);
        let told = Command::new("kill")
            .args([signal, &running.child.id().to_string()])
            .status()
            .expect("kill");
        assert!(told.success());
        assert_eq!(running.child.wait().expect("it ends").code(), Some(0), "{signal}");
    }
}

#[test]
fn the_hmi_is_where_the_ready_line_says() {
    let mut child = server()
        .args(["--listen", "127.0.0.1:0", "--hmi", "127.0.0.1:0"])
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .expect("the server runs");
    let mut line = String::new();
    let stdout = child.stdout.take().expect("it was piped");
    BufReader::new(stdout).read_line(&mut line).expect("a ready line");
    let address = line
        .trim_end()
        .rsplit_once(" hmi=")
        .map(|(_, address)| address.to_owned());
    let page = address.as_deref().and_then(|address| {
        let mut stream = TcpStream::connect(address).ok()?;
        let request = "GET / HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n";
        stream.write_all(request.as_bytes()).ok()?;
        std::io::read_to_string(&mut stream).ok()
    });
    // The process is no longer needed, with or without success.
    let _ = child.kill();
    let _ = child.wait();
    let page = page.unwrap_or_else(|| panic!("no HMI where {line:?} says"));
    assert!(page.starts_with("HTTP/1.1 200"), "{page}");
}

#[test]
fn a_port_in_use_is_said() {
    let running = Running::start(&[]);
    let out = server()
        .args(["--listen", &running.address])
        .output()
        .expect("the server runs");
    assert_eq!(out.status.code(), Some(1));
    let stderr = String::from_utf8_lossy(&out.stderr);
    assert!(
        stderr.contains(&running.address) && stderr.contains("--listen"),
        "{stderr}"
    );
    assert!(out.stdout.is_empty());
}

/// A project with the default machine, `Pos` and a continuous task that runs one routine.
fn project(kind: &str, content: &str) -> String {
    let export = server().arg("export").output().expect("the server runs").stdout;
    let export = String::from_utf8(export).expect("XML");
    let (before, rest) = export.split_once("<CustomProperties>").expect("settings of Arcline");
    let (_, after) = rest.split_once("</CustomProperties>").expect("their end");
    let tags = "<Tag Name=\"Pos\" TagType=\"Base\" DataType=\"REAL\" Dimensions=\"3\"><Data Format=\"Decorated\"><Array DataType=\"REAL\"
        Dimensions=\"3\"><Element Index=\"[0]\" Value=\"50.0\"/><Element Index=\"[1]\" Value=\"25.0\"/><Element Index=\"[2]\" Value=\"0.0\"/>
        </Array></Data></Tag><Tag Name=\"M\" TagType=\"Base\" DataType=\"MOTION_INSTRUCTION\"/>
        <Tag Name=\"Was\" TagType=\"Base\" DataType=\"BOOL\"/></Tags>";
    let programs = format!(
        "<Programs><Program Name=\"Main\" MainRoutineName=\"Main\"><Tags/><Routines><Routine Name=\"Main\" Type=\"{kind}\">{content}</Routine>
        </Routines></Program></Programs><Tasks><Task Name=\"Free\" Type=\"CONTINUOUS\" Priority=\"10\" Watchdog=\"500\"><ScheduledPrograms>
        <ScheduledProgram Name=\"Main\"/></ScheduledPrograms></Task></Tasks>"
    );
    let text = format!("{before}{after}").replacen("</Tags>", tags, 1);
    let (before, rest) = text.split_once("<Programs>").expect("the list of programs");
    let (_, after) = rest.split_once("</Programs>").expect("its end");
    format!("{before}{programs}{after}")
}

#[test]
fn a_move_is_the_same_by_ladder_structured_text_and_tag_write() {
    const OPERANDS: &str = "80, Unitspersec, 1500, Unitspersec2, 1200, Unitspersec2, S-curve, 100, 100, %ofTime, 1, Disabled, Programmed, 0, 0,
        None, 0, 0";
    let files = Files::new();
    let operands = OPERANDS.replace("Unitspersec", "Units per sec").replace("%of", "% of ");
    let ladder = format!(
        "<RLLContent><Rung Number=\"0\" Type=\"N\"><Text><![CDATA[MCLM(CS1,M,0,Pos[0],{operands});]]></Text></Rung></RLLContent>"
    );
    let text = format!(
        "<STContent><Line Number=\"0\"><![CDATA[IF NOT Was THEN MCLM(CS1, M, 0, Pos[0], {OPERANDS}); END_IF; Was := 1;]]></Line></STContent>"
    );
    let by_tag = "Move1.Position[0] := 50; Move1.Position[1] := 25; Move1.Speed := 80; Move1.SpeedUnits := 0;
        Move1.AccelRate := 1500; Move1.AccelUnits := 0; Move1.DecelRate := 1200; Move1.DecelUnits := 0; Move1.Profile := 1;
        Move1.TerminationType := 1; Move1.EnableIn := 1; WAIT(Move1.PC);";
    let cell = files.write("Ladder.L5X", &project("RLL", &ladder));
    let config = files.0.path().join("machine.toml");
    let imported = server()
        .arg("import")
        .arg(&cell)
        .arg("-o")
        .arg(&config)
        .output()
        .expect("the server runs");
    assert!(
        imported.status.success(),
        "{}",
        String::from_utf8_lossy(&imported.stderr)
    );
    let mut with_tag = std::fs::read_to_string(&config).expect("the configuration");
    if !with_tag.contains("Move1") {
        with_tag.push_str("\n[[instruction]]\ntag = \"Move1\"\ntype = \"MCLM\"\ntarget = \"CS1\"\n");
    }
    let config = files.write("tagged.toml", &with_tag);
    let runs: [(&str, PathBuf, &[&str]); 4] = [
        ("ladder", cell, &["--until", "M.PC", "--max", "5"]),
        (
            "text of a routine",
            files.write("Text.L5X", &project("ST", &text)),
            &["--until", "M.PC", "--max", "5"],
        ),
        (
            "program",
            files.write("program.st", &format!("MCLM(CS1, M, 0, [50, 25, 0], {OPERANDS});")),
            &[],
        ),
        ("tag write", files.write("tags.st", by_tag), &[]),
    ];
    let traces = runs.map(|(interface, file, args)| {
        let trace = files.0.path().join("trace.csv");
        let mut run = server();
        run.arg("simulate").arg(&file).args(args).arg("--trace").arg(&trace);
        if file.extension().is_some_and(|extension| extension == "st") {
            run.arg("--config").arg(&config);
        }
        let run = run.output().expect("the server runs");
        assert!(
            run.status.success(),
            "{interface}: {}",
            String::from_utf8_lossy(&run.stderr)
        );
        (interface, std::fs::read_to_string(trace).expect("a trace"))
    });
    let (_, first) = &traces[0];
    for (interface, trace) in &traces[1..] {
        let rows = first.lines().zip(trace.lines()).take_while(|(a, b)| a == b).count();
        let shorter = first.lines().count().min(trace.lines().count());
        assert!(
            rows > 500 && rows == shorter,
            "{interface}: row {rows} of {shorter} differs"
        );
    }
}

#[test]
fn a_project_runs_again_to_the_same_bytes() {
    let files = Files::new();
    let rungs = "<RLLContent><Rung Number=\"0\" Type=\"N\"><Text><![CDATA[XIO(M.PC)MAM(X,M,1,5,50,Units per sec,1000,Units per sec2,1000,Units per sec2,
        Trapezoidal,100,100,% of Time,Disabled,Programmed,0,None);]]></Text></Rung></RLLContent>";
    let cell = files.write("Cell.L5X", &project("RLL", rungs));
    let run = || {
        let args = ["--max", "1", "--scan-phase", "7", "--tags", "-"];
        let run = server()
            .arg("simulate")
            .arg(&cell)
            .args(args)
            .output()
            .expect("the server runs");
        assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
        run.stdout
    };
    let first = run();
    assert!(!first.is_empty());
    assert_eq!(first, run());
}

/// A rung in a routine of ladder.
fn rungs(all: &[&str]) -> String {
    let rows = (0..)
        .zip(all)
        .map(|(number, text)| format!("<Rung Number=\"{number}\" Type=\"N\"><Text><![CDATA[{text}]]></Text></Rung>"));
    format!("<RLLContent>{}</RLLContent>", rows.collect::<String>())
}

fn run(arguments: &[&std::ffi::OsStr]) -> (Option<i32>, String, String) {
    let output = server().args(arguments).output().expect("the server runs");
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    (output.status.code(), text(&output.stdout), text(&output.stderr))
}

#[test]
fn parts_of_a_project_that_do_not_run_are_named_and_passed_over_on_demand() {
    let files = Files::new();
    let more = "<Routine Name=\"Flow\" Type=\"FBD\"><FBDContent/></Routine><Routine Name=\"Chart\" Type=\"SFC\"><SFCContent/></Routine>\
        <EncodedData EncodedType=\"Routine\" Name=\"Locked\">AAAA</EncodedData></Routines>";
    let modules = "<Modules><Module Name=\"Raw\" ParentModule=\"Local\"><Ports><Port Id=\"1\" Address=\"2\" Type=\"ICP\" Upstream=\"true\"/></Ports>\
        <Communications><Connections><Connection Name=\"C\"><InputTag><Data Format=\"L5K\">[0]</Data></InputTag></Connection></Connections>\
        </Communications></Module></Modules></Controller>";
    let text = project(
        "RLL",
        &rungs(&["PID(Pos[0]);", "JSR(Flow,0);", "JSR(Locked,0);", "MOV(7.0,Pos[2]);"]),
    )
    .replacen("</Routines>", more, 1)
    .replacen("</Controller>", modules, 1);
    let cell = files.write("Cell.L5X", &text);
    let (code, out, _) = run(&["import".as_ref(), cell.as_os_str(), "--report".as_ref()]);
    assert_eq!(code, Some(0));
    for line in [
        "Main/Main rung 0: instruction PID is not supported",
        "Main/Flow: routine Flow: FBD is not supported",
        "Main/Chart: routine Chart: SFC is not supported",
        "Main/Locked: routine Locked: encoded content is not supported",
        "module Local:2:I: has no data of the format Decorated, which name its members: there is no such tag",
    ] {
        assert!(out.lines().any(|one| one == line), "{line}\n{out}");
    }
    let simulate = ["simulate".as_ref(), cell.as_os_str(), "--max".as_ref(), "0.1".as_ref()];
    let (code, _, said) = run(&simulate);
    assert_eq!(code, Some(2), "{said}");
    assert!(said.contains("4 parts of the project do not run"), "{said}");
    let until = ["--allow-missing".as_ref(), "--until".as_ref(), "Pos[2] = 7".as_ref()];
    let (code, _, said) = run(&[simulate.as_slice(), &until].concat());
    assert_eq!(code, Some(0), "the rest runs: {said}");
    // The use of a tag of the module stops it; passed over on demand, its contact is false.
    let used = files.write(
        "Used.L5X",
        &text.replace("PID(Pos[0]);", "XIC(Local:2:I.Data.0)MOV(5.0,Pos[1]);"),
    );
    let simulate = ["simulate".as_ref(), used.as_os_str(), "--max".as_ref(), "0.1".as_ref()];
    let (code, _, said) = run(&simulate);
    assert_eq!(code, Some(2), "{said}");
    assert!(said.contains("there is no tag Local:2:I"), "{said}");
    let until = [
        "--allow-missing".as_ref(),
        "--until".as_ref(),
        "Pos[2] = 7 AND Pos[1] <> 5".as_ref(),
    ];
    let (code, _, said) = run(&[simulate.as_slice(), &until].concat());
    assert_eq!(code, Some(0), "{said}");
    assert!(
        said.contains("Main/Main rung 0: XIC(Local:2:I.Data.0): Data Bit Local:2:I.Data.0: there is no tag Local:2:I"),
        "{said}"
    );
}

#[test]
fn an_axis_is_homed_to_a_wired_switch() {
    let files = Files::new();
    let module = |slot: u32, tag: &str| {
        format!(
            "<Module Name=\"M{slot}\" ParentModule=\"Local\"><Ports><Port Id=\"1\" Address=\"{slot}\" Type=\"ICP\" Upstream=\"true\"/></Ports>\
             <Communications><Connections><Connection Name=\"C\"><{tag}><Data Format=\"Decorated\"><Structure DataType=\"AB:D{slot}\">\
             <DataValueMember Name=\"Data\" DataType=\"DINT\" Value=\"0\"/></Structure></Data></{tag}></Connection></Connections></Communications></Module>"
        )
    };
    let modules = format!(
        "<Modules>{}{}</Modules></Controller>",
        module(1, "InputTag"),
        module(2, "OutputTag")
    );
    let program = [
        "GEQ(X.ActualPosition,20)OTE(Local:2:O.Data.3);",
        "MAH(X,M);",
        "XIC(Local:1:I.Data.0)OTE(Was);",
    ];
    let text = project("RLL", &rungs(&program)).replacen("</Controller>", &modules, 1);
    let cell = files.write("Cell.L5X", &text);
    let homed = "name = \"X\"\ntype = \"servo\"\nhome = { sequence = \"switch\", direction = \"unidirectional-forward\", speed = 40.0 }";
    let machine =
        include_str!("../../crates/config/src/default.toml").replacen("name = \"X\"\ntype = \"servo\"", homed, 1);
    let wires = "\n[[controller.wire]]\nfrom = \"Local:2:O.Data.3\"\nto = \"X.home_switch\"\n\
        [[controller.wire]]\nfrom = \"X.home_switch\"\nto = \"Local:1:I.Data.0\"\ndelay_ms = 3\n";
    let simulate = |machine: &str, until: &str| {
        let machine = files.write("machine.toml", machine);
        let arguments = [
            "simulate".as_ref(),
            cell.as_os_str(),
            "--config".as_ref(),
            machine.as_os_str(),
            "--max".as_ref(),
            "5".as_ref(),
        ];
        run(&[arguments.as_slice(), &["--until".as_ref(), until.as_ref()]].concat())
    };
    let wired = format!("{machine}{wires}");
    let (code, _, said) = simulate(
        &wired,
        "M.PC AND Was AND X.AxisHomedStatus AND X.ActualPosition >= 0 AND X.ActualPosition < 2",
    );
    assert_eq!(code, Some(0), "{said}");
    let (code, _, said) = simulate(&machine, "M.ER AND M.ERR = 84");
    assert_eq!(code, Some(0), "without the wire there is no switch: {said}");
    let (code, _, said) = simulate(&wired.replace("Local:1:I.Data.0", "Local:7:I.Data.0"), "M.PC");
    assert_eq!(code, Some(2), "{said}");
    assert!(
        said.contains("wire from X.home_switch to Local:7:I.Data.0: Local:7:I.Data.0: there is no tag Local:7:I"),
        "{said}"
    );
}

#[test]
fn an_add_on_instruction_moves_the_axis_that_it_gets_by_reference() {
    let files = Files::new();
    let parameter = |name: &str, kind: &str, usage: &str| {
        format!(
            "<Parameter Name=\"{name}\" TagType=\"Base\" DataType=\"{kind}\" Usage=\"{usage}\" Required=\"true\" Visible=\"true\"/>"
        )
    };
    let logic = rungs(&[
        "MAM(Ax,Mc,0,To,100,Units per sec,1000,Units per sec2,1000,Units per sec2,Trapezoidal,100,100,% of Time,Disabled,Programmed,0,None);",
        "XIC(Mc.PC)OTE(Done);",
    ]);
    let add_on = format!(
        "</DataTypes><AddOnInstructionDefinitions><AddOnInstructionDefinition Name=\"Goto\" Revision=\"1.0\"><Parameters>\
         <Parameter Name=\"EnableIn\" DataType=\"BOOL\" Usage=\"Input\" Required=\"false\"/><Parameter Name=\"EnableOut\" DataType=\"BOOL\" Usage=\"Output\" Required=\"false\"/>\
         {}{}{}{}</Parameters><LocalTags/><Routines><Routine Name=\"Logic\" Type=\"RLL\">{logic}</Routine></Routines>\
         </AddOnInstructionDefinition></AddOnInstructionDefinitions>",
        parameter("Ax", "AXIS_CIP_DRIVE", "InOut"),
        parameter("Mc", "MOTION_INSTRUCTION", "InOut"),
        parameter("To", "REAL", "Input"),
        parameter("Done", "BOOL", "Output"),
    );
    let tags = "<Tag Name=\"G1\" TagType=\"Base\" DataType=\"Goto\"/><Tag Name=\"G2\" TagType=\"Base\" DataType=\"Goto\"/>\
        <Tag Name=\"M2\" TagType=\"Base\" DataType=\"MOTION_INSTRUCTION\"/><Tag Name=\"D2\" TagType=\"Base\" DataType=\"BOOL\"/></Tags>";
    let program = ["Goto(G1,X,M,30.0,Was);", "XIC(G1.Done)Goto(G2,Y,M2,-20.0,D2);"];
    let text = project("RLL", &rungs(&program))
        .replacen("</Tags>", tags, 1)
        .replacen("</DataTypes>", &add_on, 1);
    let cell = files.write("Cell.L5X", &text);
    let until = "D2 AND X.CommandPosition = 30 AND Y.CommandPosition = -20";
    let (code, _, said) = run(&[
        "simulate".as_ref(),
        cell.as_os_str(),
        "--until".as_ref(),
        until.as_ref(),
        "--max".as_ref(),
        "5".as_ref(),
    ]);
    assert_eq!(code, Some(0), "{said}");
}
