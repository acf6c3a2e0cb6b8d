//! `arcline-server import` and `export` through the built program: files, exit codes, messages.

use std::process::{Command, Output};

use arcline_system_tests::programs::arcline_server;

fn run(arguments: &[&str]) -> Output {
    let mut command = Command::new(arcline_server());
    command.args(arguments).output().expect("arcline-server can be run")
}

fn check(output: &Output, code: i32) -> (String, String) {
    let text = |bytes: &[u8]| String::from_utf8(bytes.to_vec()).expect("UTF-8");
    let (out, err) = (text(&output.stdout), text(&output.stderr));
    assert_eq!(output.status.code(), Some(code), "{out}\n{err}");
    (out, err)
}

const CELL: &str = r#"<?xml version="1.0" encoding="UTF-8" standalone="yes"?>
<RSLogix5000Content SchemaRevision="1.0" SoftwareRevision="35.00" TargetName="Cell" TargetType="Controller">
<Controller Use="Target" Name="Cell">
<Modules><Module Name="Local"/></Modules>
<Tags>
<Tag Name="Motion1" TagType="Base" DataType="MOTION_GROUP"><Data Format="MotionGroup"><MotionGroupParameters CoarseUpdatePeriod="4000"/></Data></Tag>
<Tag Name="X" TagType="Base" DataType="AXIS_CIP_DRIVE"><Data Format="Axis">
<AxisParameters MotionModule="Drive1:Ch1" MaximumSpeed="100.0" MaximumAcceleration="1000.0" MaximumDeceleration="1000.0"
 MaximumAccelerationJerk="10000.0" MaximumDecelerationJerk="10000.0"/></Data></Tag>
<Tag Name="Count" TagType="Base" DataType="DINT" Radix="Decimal"><Data Format="Decorated"><DataValue DataType="DINT" Radix="Decimal" Value="7"/></Data></Tag>
</Tags>
</Controller>
</RSLogix5000Content>
"#;

#[test]
fn a_file_becomes_a_configuration_that_the_server_takes() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name).display().to_string();
    let (l5x, toml) = (path("Cell.L5X"), path("cell.toml"));
    std::fs::write(&l5x, CELL).expect("a file");

    let (out, err) = check(&run(&["import", &l5x, "-o", &toml]), 0);
    assert_eq!(out, "");
    assert_eq!(
        err,
        format!(
            "{l5x}: 2 items were left out or changed\n\
             no counterpart in a configuration (2):\n\
             \x20 1 × Controller/Modules/Module, line 4\n\
             \x20 1 × Controller/Tags/Tag[AXIS_CIP_DRIVE]/Data/AxisParameters/@MotionModule, line 8\n"
        )
    );
    let (out, _) = check(&run(&["check", "--config", &toml]), 0);
    for line in [
        "motion group Motion1, coarse update period 4 ms",
        "axis X: servo, up to 100",
        "tag Count: DINT",
    ] {
        assert!(out.contains(line), "{line}\n{out}");
    }
    // Without -o the output is standard output; --strict changes the exit code only.
    let (out, strict) = check(&run(&["import", "--strict", &l5x]), 1);
    assert_eq!(out, std::fs::read_to_string(&toml).expect("the configuration"));
    assert_eq!(strict, err);
}

#[test]
fn an_export_imports_as_the_same_project() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name).display().to_string();
    let (first, second, toml) = (path("First.L5X"), path("Second.L5X"), path("again.toml"));
    let _ = check(&run(&["export", "-o", &first]), 0);
    let (_, err) = check(&run(&["import", "--strict", &first, "-o", &toml]), 0);
    assert_eq!(err, "");
    let _ = check(&run(&["export", "--config", &toml, "-o", &second]), 0);
    let read = |path: &str| std::fs::read_to_string(path).expect("a file");
    assert_eq!(read(&first), read(&second));
}

#[test]
fn wrong_files_exit_with_2() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name).display().to_string();
    let (missing, broken, latin) = (path("missing.L5X"), path("broken.L5X"), path("latin.L5X"));
    std::fs::write(&broken, CELL.replace("4000", "4 ms")).expect("a file");
    std::fs::write(&latin, b"<a>\n\xE4</a>").expect("a file");
    for (file, message) in [
        (&missing, ": cannot be read: "),
        (
            &broken,
            ":6:110: Controller/Tags/Tag[MOTION_GROUP]/Data/MotionGroupParameters/@CoarseUpdatePeriod: found \"4 ms\", \
             expected a finite number",
        ),
        (&latin, ":2: not UTF-8, expected XML in UTF-8"),
    ] {
        let (out, err) = check(&run(&["import", file]), 2);
        assert_eq!(out, "");
        assert!(err.contains(&format!("arcline-server: {file}{message}")), "{err}");
    }
}
