//! One program gives one trajectory at every update period (spec/motion-core.md §12.4): queued moves in `simulate`.

use std::fs;
use std::path::Path;
use std::process::Command;

use arcline_system_tests::{programs, workspace};

/// Update periods in ms; common instants are those of the last.
const PERIODS: [f64; 3] = [0.25, 1.0, 4.0];

/// Command positions of every axis at the multiples of the longest period.
fn positions(program: &Path, config: &str, period: f64, folder: &Path) -> Vec<Vec<f64>> {
    let (machine, trace) = (folder.join("machine.toml"), folder.join("trace.csv"));
    let text = if config.contains("coarse_update_period_ms = 1.0") {
        config.replace(
            "coarse_update_period_ms = 1.0",
            &format!("coarse_update_period_ms = {period}"),
        )
    } else {
        format!("[motion_group]\ncoarse_update_period_ms = {period}\n{config}")
    };
    fs::write(&machine, text).expect("the folder is writable");
    let run = Command::new(programs::arcline_server())
        .args(["simulate".as_ref(), program, "--config".as_ref(), &machine])
        .args(["--trace".as_ref(), trace.as_path()])
        .output()
        .expect("the server was just built");
    assert!(run.status.success(), "{run:?}");
    let text = fs::read_to_string(&trace).expect("simulate has written it");
    let mut rows = text.lines();
    let head: Vec<&str> = rows.next().expect("a header").split(',').collect();
    let every = (PERIODS[2] / period).round() as usize;
    let commanded = |row: &str| {
        let cells = head.iter().zip(row.split(','));
        let positions = cells.filter(|(name, _)| name.ends_with("CommandPosition"));
        positions.map(|(_, cell)| cell.parse().expect("a number")).collect()
    };
    rows.step_by(every).map(commanded).collect()
}

#[test]
fn queued_programs_do_not_show_the_update_period() {
    let images = workspace().join("docs/images");
    let contour = fs::read_to_string(images.join("contour.toml")).expect("a file of this repository");
    for (name, config) in [("blends.st", arcline_config::DEFAULT), ("contour.st", contour.as_str())] {
        let program = images.join(name);
        let folder = tempfile::tempdir().expect("a temporary folder");
        let [fine, plain, coarse] = PERIODS.map(|period| positions(&program, config, period, folder.path()));
        assert!(coarse.len() > 100, "{name} moves");
        for other in [&plain, &coarse] {
            for (tick, (a, b)) in fine.iter().zip(other).enumerate() {
                let apart = a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
                assert!(apart < 1e-9, "{name}: {apart} apart at {} ms", tick as f64 * PERIODS[2]);
            }
        }
    }
}
