//! Golden programs: `tests/programs/*.st` in, events and every tenth row of the trace out.
//! `UPDATE_EXPECT=1 cargo test -p arcline-server --test programs` rewrites them; review the difference.

use std::path::Path;
use std::process::Command;

use expect_test::expect_file;

/// Rows of the trace between two stored ones.
const EVERY: usize = 10;

#[test]
fn programs_have_their_recorded_results() {
    let programs = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/programs");
    let mut files: Vec<_> = std::fs::read_dir(&programs)
        .expect("the programs are part of the repository")
        .filter_map(|entry| Some(entry.ok()?.path()))
        .filter(|path| path.extension().is_some_and(|extension| extension == "st"))
        .collect();
    files.sort();
    assert!(!files.is_empty());
    for file in files {
        let first = simulate(&file);
        assert_eq!(
            first,
            simulate(&file),
            "{}: two runs give the same bytes",
            file.display()
        );
        let file = file.canonicalize().expect("it was just run");
        expect_file![file.with_extension("expected")].assert_eq(&first);
    }
}

/// Exit code, message, events and thinned trace as one text.
fn simulate(program: &Path) -> String {
    let out = tempfile::tempdir().expect("a temporary directory");
    let (trace, events) = (out.path().join("trace.csv"), out.path().join("events.jsonl"));
    let run = Command::new(env!("CARGO_BIN_EXE_arcline-server"))
        .arg("simulate")
        .arg(program)
        .arg("--trace")
        .arg(&trace)
        .arg("--events")
        .arg(&events)
        .output()
        .expect("the server runs");
    let read = |path: &Path| std::fs::read_to_string(path).expect("the file was written");
    let message = String::from_utf8_lossy(&run.stderr);
    let message = message.rsplit('/').next().unwrap_or_default();
    let trace: String = read(&trace)
        .lines()
        .enumerate()
        .filter(|(row, _)| *row == 0 || (*row - 1) % EVERY == 0)
        .map(|(_, line)| format!("{line}\n"))
        .collect();
    format!(
        "exit {}\n{message}\n{}\n{trace}",
        run.status.code().unwrap_or(-1),
        read(&events)
    )
}
