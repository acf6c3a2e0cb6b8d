//! The program of a controller that the server runs: `arcline-server run Cell.L5X`, its tags, its mode, and a file that changes.

use std::fs;
use std::path::Path;
use std::process::Command;
use std::time::Duration;

use arcline_system_tests::command_line::{arcline, read_numbers};
use arcline_system_tests::programs::arcline_server;
use arcline_system_tests::server::Server;
use arcline_system_tests::{eventually, fixture};

/// Far more than the program takes.
const SOON: Duration = Duration::from_secs(30);

fn cell() -> String {
    fs::read_to_string(fixture("config/Cell.L5X")).expect("the fixture")
}

fn start(file: &Path) -> Server {
    Server::start_with(&[file.to_str().expect("UTF-8")])
}

#[test]
fn clients_read_and_write_the_tags_of_the_program() {
    let server = start(&fixture("config/Cell.L5X"));
    let at = server.address();
    let list = arcline(at, &["tags", "*"]).expect(0).stdout;
    for name in ["Program:Main.Sum", "Program:Main.Settle", "Batch", "Middle"] {
        assert!(list.contains(name), "{name}\n{list}");
    }
    assert!(!list.contains("Secret"), "ExternalAccess None");
    eventually("scans", SOON, || {
        (read_numbers(at, &["Program:Main.Scans"])[0] > 5.0).then_some(())
    });
    assert_eq!(
        read_numbers(at, &["Batch.Steps[1]", "Middle", "Program:Main.Sum.Total"]),
        [5.0, 5.0, 0.0]
    );
    let _ = arcline(at, &["write", "Middle", "7"]).expect(0);
    assert_eq!(read_numbers(at, &["Batch.Steps[1]"]), [7.0]);
    assert_eq!(arcline(at, &["write", "Fixed", "1"]).code, Some(1), "a constant");
    let _ = arcline(at, &["write", "Target", "10"]).expect(0);
    let _ = arcline(at, &["write", "Start", "1"]).expect(0);
    eventually("the sum", SOON, || {
        (read_numbers(at, &["Program:Main.Sum.Total"])[0] == 7.0).then_some(())
    });
    assert_eq!(
        read_numbers(at, &["Done", "X.CommandPosition", "Program:Main.Move.PC"]),
        [1.0, 10.0, 1.0]
    );
}

#[test]
fn the_same_project_ends_with_the_same_tags_live_and_simulated() {
    let folder = tempfile::tempdir().expect("a folder");
    let tags = folder.path().join("tags.json");
    let simulated = Command::new(arcline_server())
        .args(["simulate"])
        .arg(fixture("config/Cell.L5X"))
        .args(["--set", "Start=1", "--until", "Program:Main.Scans > 300", "--tags"])
        .arg(&tags)
        .output()
        .expect("it can be run");
    assert!(
        simulated.status.success(),
        "{}",
        String::from_utf8_lossy(&simulated.stderr)
    );
    let simulated: serde_json::Value =
        serde_json::from_str(&fs::read_to_string(&tags).expect("it was written")).expect("JSON");

    let server = start(&fixture("config/Cell.L5X"));
    let at = server.address();
    let _ = arcline(at, &["write", "Start", "1"]).expect(0);
    eventually("the end", SOON, || {
        (read_numbers(at, &["Program:Main.Twice"])[0] > 0.0).then_some(())
    });
    // The scan behind the one that added.
    let scans = read_numbers(at, &["Program:Main.Scans"])[0];
    eventually("a further scan", SOON, || {
        (read_numbers(at, &["Program:Main.Scans"])[0] > scans + 1.0).then_some(())
    });
    // All but the number of scans and the time.
    for name in [
        "Start",
        "Done",
        "Target",
        "Batch",
        "Fixed",
        "Program:Main.On",
        "Program:Main.Move",
        "Program:Main.Sum",
        "Program:Main.Once",
        "Program:Main.Twice",
    ] {
        let live = arcline(at, &["read", "--json", name]).expect(0).stdout;
        let live: serde_json::Value = serde_json::from_str(&live).expect("JSON");
        assert_eq!(number_leaves(&live), number_leaves(&simulated[name]), "{name}: {live}");
    }
}

/// The numbers and bits of a value in their order, bits as numbers; names of tags and types are no part of it.
fn number_leaves(value: &serde_json::Value) -> Vec<f64> {
    match value {
        serde_json::Value::Bool(on) => vec![f64::from(u8::from(*on))],
        serde_json::Value::Number(number) => number.as_f64().into_iter().collect(),
        serde_json::Value::Array(items) => items.iter().flat_map(number_leaves).collect(),
        serde_json::Value::Object(members) => members.values().flat_map(number_leaves).collect(),
        _ => Vec::new(),
    }
}

#[test]
fn the_mode_stops_the_tasks_and_lets_them_run() {
    let server = start(&fixture("config/Cell.L5X"));
    let at = server.address();
    eventually("scans", SOON, || {
        (read_numbers(at, &["Program:Main.Scans"])[0] > 0.0).then_some(())
    });
    assert_eq!(arcline(at, &["mode"]).expect(0).stdout, "run\n");
    assert_eq!(arcline(at, &["mode", "program"]).expect(0).stdout, "program\n");
    let _ = arcline(at, &["write", "Program:Main.Scans", "-5"]).expect(0);
    assert_eq!(read_numbers(at, &["Program:Main.Scans"]), [-5.0]);
    assert_eq!(arcline(at, &["mode", "run"]).expect(0).stdout, "run\n");
    eventually("scans", SOON, || {
        (read_numbers(at, &["Program:Main.Scans"])[0] > 0.0).then_some(())
    });
    let without = Server::start();
    assert_eq!(arcline(without.address(), &["mode"]).expect(0).stdout, "no program\n");
    let refused = arcline(without.address(), &["mode", "run"]).expect(1);
    assert!(refused.stderr.contains("the server runs no program"), "{refused:?}");
}

#[test]
fn a_changed_file_is_checked_whole_before_it_replaces_anything() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("Cell.L5X");
    fs::write(&file, cell()).expect("a file");
    let server = start(&file);
    let at = server.address();
    let _ = arcline(at, &["write", "Target", "3"]).expect(0);
    let count = "Scans := Scans + 1;";
    for (wrong, told) in [
        (
            cell().replace(count, "Scans := Nowhere + 1;"),
            "there is no tag Nowhere",
        ),
        (
            cell().replace("CoarseUpdatePeriod=\"4000\"", "CoarseUpdatePeriod=\"8000\""),
            "which needs a restart",
        ),
    ] {
        fs::write(&file, wrong).expect("a file");
        server.hang_up();
        eventually(told, SOON, || server.log().contains(told).then_some(()));
    }
    fs::write(&file, cell().replace(count, "Scans := -1;")).expect("a file");
    server.hang_up();
    eventually("the new program", SOON, || {
        (read_numbers(at, &["Program:Main.Scans"]) == [-1.0]).then_some(())
    });
    assert_eq!(read_numbers(at, &["Target"]), [3.0], "what is the same keeps its value");
}

#[test]
fn a_project_that_does_not_run_is_refused_and_a_configuration_names_one() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("Cell.L5X");
    fs::write(&file, cell().replace("JSR(Count,0);", "NOSUCH(1);")).expect("a file");
    let output = Command::new(arcline_server()).arg("run").arg(&file).output();
    let output = output.expect("it can be run");
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{said}");
    assert!(
        said.contains("Main/Go rung 5: instruction NOSUCH is not supported"),
        "{said}"
    );

    fs::write(&file, cell()).expect("a file");
    let machine = Command::new(arcline_server()).arg("import").arg(&file).output();
    let machine = String::from_utf8(machine.expect("it can be run").stdout).expect("UTF-8");
    let tags = machine.find("[[tag]]").unwrap_or(machine.len());
    let types = machine.find("[[data_type]]").unwrap_or(tags).min(tags);
    let toml = folder.path().join("machine.toml");
    let controller = "[controller]\nprogram = \"Cell.L5X\"\nmode = \"program\"\n";
    fs::write(&toml, format!("{}\n{controller}", &machine[..types])).expect("a file");
    let server = Server::start_on(&toml);
    let at = server.address();
    assert_eq!(arcline(at, &["mode"]).expect(0).stdout, "program\n");
    assert_eq!(read_numbers(at, &["Program:Main.Scans", "Target"]), [0.0, 25.0]);
}
