//! `simulate --cases` as users start it: the same results as single runs, torn batches that go on, and how many runs a second.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};
use std::time::Instant;

use arcline_system_tests::programs;
use serde_json::Value;

const PART: &str = "MCLM(CS1, Out, Absolute, [100, 50, 25], 100, Unitspersec, 1000, Unitspersec2, 1000, Unitspersec2);
WAIT(Out.PC);
MCLM(CS1, Back, Absolute, [0, 0, 0], 200, Unitspersec, 1000, Unitspersec2, 1000, Unitspersec2);
";

fn simulate(folder: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(programs::arcline_server());
    command.arg("simulate").args(arguments).current_dir(folder);
    command.output().expect("the server was just built")
}

fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a temporary folder");
    fs::write(folder.path().join("part.st"), PART).expect("the folder is writable");
    folder
}

fn results(text: &[u8]) -> Vec<Value> {
    let text = String::from_utf8_lossy(text);
    let result = |line| {
        let mut result: Value = serde_json::from_str(line).expect("a result is JSON");
        result.as_object_mut().expect("an object").remove("wall_s");
        result
    };
    text.lines().map(result).collect()
}

#[test]
fn a_case_is_the_same_run_as_alone() {
    let folder = folder();
    let at = folder.path();
    let cases = "{\"set\":{\"axis.Y.max_speed\":40}}\n{\"until\":0.5}\n{\"nothing\":1}\n";
    fs::write(at.join("cases.jsonl"), cases).expect("writable");
    let batch = simulate(at, &["part.st", "--cases", "cases.jsonl", "--trace", "{case}.csv"]);
    let told = String::from_utf8_lossy(&batch.stderr).into_owned();
    assert_eq!(batch.status.code(), Some(2), "{told}");
    assert!(
        told.contains("cases.jsonl: line 3: unknown field `nothing`") && told.contains("1 of 3 cases could not be run"),
        "{told}"
    );
    let batch = results(&batch.stdout);
    for (number, more) in [["--set", "axis.Y.max_speed=40"], ["--until", "0.5"]]
        .iter()
        .enumerate()
    {
        let one = simulate(at, &[&["part.st", "--json", "--trace", "one.csv"], &more[..]].concat());
        let one = &results(&one.stdout)[0];
        for member in ["end", "hash", "peaks", "positions", "config", "ticks", "error"] {
            assert_eq!(one[member], batch[number][member], "{member}");
        }
        let read = |name: &str| fs::read(at.join(name)).expect("a trace");
        assert!(
            read("one.csv") == read(&format!("{number}.csv")),
            "the traces of {number} differ"
        );
    }
    assert_eq!(
        (&batch[0]["end"], &batch[1]["end"]),
        (&"finished".into(), &"timeout".into())
    );
}

#[test]
fn a_batch_that_was_ended_goes_on() {
    let folder = folder();
    let at = folder.path();
    let cases: String = (0..20)
        .map(|id| format!("{{\"id\":{id},\"text\":\"DELAY(0.{id});\"}}\n"))
        .collect();
    fs::write(at.join("cases.jsonl"), cases).expect("writable");
    let whole = results(&simulate(at, &["--cases", "cases.jsonl"]).stdout);
    assert_eq!(whole.len(), 20);
    let resume = [
        "--cases",
        "cases.jsonl",
        "--output",
        "out.jsonl",
        "--resume",
        "--jobs",
        "2",
    ];
    assert!(simulate(at, &[&resume[..], &["--to", "12"]].concat()).status.success());
    let text = fs::read(at.join("out.jsonl")).expect("results");
    assert_eq!(results(&text), whole[..12]);
    fs::write(at.join("out.jsonl"), &text[..text.len() - 9]).expect("writable");
    assert!(simulate(at, &resume).status.success());
    assert_eq!(results(&fs::read(at.join("out.jsonl")).expect("results")), whole);
    let other = simulate(at, &[&resume[..], &["--from", "3"]].concat());
    assert_eq!(other.status.code(), Some(2), "results of other cases are not touched");
    assert_eq!(results(&fs::read(at.join("out.jsonl")).expect("results")), whole);
}

#[test]
fn options_that_exclude_each_other_are_refused() {
    let folder = folder();
    #[rustfmt::skip]
    let cases: [(&[&str], &str); 6] = [
        (&[],                                                          "required"),
        (&["part.st", "--cases", "no.jsonl"],                          "no.jsonl: cannot be read"),
        (&["part.st", "--cases", "part.st", "--trace", "a.csv"],       "{case}"),
        (&["part.st", "--set", "axis.X.max_sped=5"],                   "max_sped"),
        (&["part.st", "--set", "Move1.Speed"],                         "expected KEY=VALUE"),
        (&["part.st", "--json", "--trace", "-"],                       "standard output"),
    ];
    for (arguments, expected) in cases {
        let output = simulate(folder.path(), arguments);
        let told = String::from_utf8_lossy(&output.stderr);
        assert!(
            output.status.code() == Some(2) && told.contains(expected),
            "{arguments:?}: {told}"
        );
    }
}

/// The goal is 1,667 runs of two seconds a second on two processors; the floor of the release build leaves room for a machine that is busy with something
/// else.
#[test]
fn simulate_many_runs_a_second() {
    const FLOOR: f64 = if cfg!(debug_assertions) { 0.0 } else { 300.0 };
    let folder = folder();
    let at = folder.path();
    let count = if cfg!(debug_assertions) { 50 } else { 5_000 };
    fs::write(at.join("cases.jsonl"), "{}\n".repeat(count)).expect("writable");
    let began = Instant::now();
    let output = simulate(at, &["part.st", "--cases", "cases.jsonl"]);
    let rate = count as f64 / began.elapsed().as_secs_f64();
    assert!(output.status.success(), "{output:?}");
    let results = results(&output.stdout);
    assert!(results.len() == count && results.iter().all(|result| result["hash"] == results[0]["hash"]));
    println!("{rate:.0} runs a second of {} s", results[0]["time_s"]);
    assert!(rate >= FLOOR, "{rate:.0} runs a second, {FLOOR} at least");
}
