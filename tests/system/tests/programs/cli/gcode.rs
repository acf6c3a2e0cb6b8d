//! `arcline gcode` on a server, simulated and written to a file; `arcline plot` of the result.

use std::path::Path;

use arcline_system_tests::command_line::{arcline, read_numbers};
use arcline_system_tests::gcode::simulated;
use arcline_system_tests::server::Server;
use arcline_tests::random::is_long;

const POSITIONS: [&str; 3] = ["X.CommandPosition", "Y.CommandPosition", "Z.CommandPosition"];

fn written(folder: &Path, name: &str, text: &str) -> String {
    let path = folder.join(name);
    std::fs::write(&path, text).expect("the folder is writable");
    path.to_str().expect("UTF-8").to_owned()
}

/// A slot: a line down, along, and an arc at its end; a dwell; and back.
const SLOT: &str = "%\n(a slot)\nG21 G90 G17 G64 P0.5\nG0 X10 Y10 Z5\nG1 Z-2 F3000\nX60\nG3 X60 Y30 J10\nG1 X10\nG3 Y10 J-10\n\
                    G4 P0.05\nG61 G0 Z5\nX0 Y0\nM30\n%\n";

#[test]
fn a_program_runs_where_it_says() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = written(folder.path(), "slot.ngc", SLOT);
    let server = Server::start();
    let at = server.address();
    let told = arcline(at, &["gcode", &file, "CS1"]).expect(0);
    assert!(told.stdout.contains("slot.ngc: 8 moves"), "{told:?}");
    assert_eq!(read_numbers(at, &POSITIONS), [0.0, 0.0, 5.0]);
    // The program begins at the present position, and a plane has no Z.
    let file = written(folder.path(), "on.ngc", "G91 G0 X5 Y-5\n");
    let _ = arcline(at, &["gcode", &file, "XY"]).expect(0);
    assert_eq!(read_numbers(at, &POSITIONS), [5.0, -5.0, 5.0]);
    let file = written(folder.path(), "z.ngc", "G0 X5\nZ1\n");
    let refused = arcline(at, &["gcode", &file, "XY"]).expect(2);
    assert!(
        refused
            .stderr
            .contains("z.ngc: line 2, column 1: the coordinate system has 2 axes and no Z"),
        "{refused:?}"
    );
    // The refusal of the machine has the line of the program.
    let _ = arcline(at, &["servo", "off", "Y"]).expect(0);
    let file = written(folder.path(), "off.ngc", "(no drive)\n\nG0 X5 Y1\n");
    let refused = arcline(at, &["gcode", &file, "XY"]).expect(1);
    assert!(
        refused.stderr.contains("off.ngc: line 3: ") && refused.stderr.contains("ERR 5"),
        "{refused:?}"
    );
    let near = arcline(at, &["gcode", &file, "CS9"]).expect(2);
    assert!(near.stderr.contains("did you mean"), "{near:?}");
}

#[test]
fn a_program_is_simulated_and_drawn_without_a_server() {
    let folder = tempfile::tempdir().expect("a folder");
    let nobody = "127.0.0.1:1".parse().expect("an address");
    let file = written(folder.path(), "slot.ngc", SLOT);
    let at = |name: &str| folder.path().join(name).to_str().expect("UTF-8").to_owned();
    let (trace, events) = (at("t.csv"), at("e.jsonl"));
    let arguments = [
        "--json",
        "gcode",
        &file,
        "CS1",
        "--simulate",
        "--trace",
        &trace,
        "--events",
        &events,
    ];
    let told = arcline(nobody, &arguments).expect(0).objects();
    assert_eq!(
        (&told[0]["lines"], &told[0]["arcs"]),
        (&6.into(), &2.into()),
        "{told:?}"
    );
    let seconds = told[0]["seconds"].as_f64().expect("a time");
    // 163 mm at 50 mm/s, the dwell, and the ramps.
    assert!((3.3..6.0).contains(&seconds), "{seconds}");
    // Every position is inside the tolerance of the slot: Y within 10 to 30, the depth no deeper than programmed.
    let rows = std::fs::read_to_string(&trace).expect("a trace");
    let column = |name: &str| {
        let titles: Vec<&str> = rows.lines().next().expect("a header").split(',').collect();
        titles.iter().position(|title| *title == name).expect("the column")
    };
    let (y, z) = (column("Y.CommandPosition"), column("Z.CommandPosition"));
    for row in rows.lines().skip(1) {
        let cells: Vec<f64> = row.split(',').map(|cell| cell.parse().expect("a number")).collect();
        assert!(
            (-1e-9..=30.0 + 1e-9).contains(&cells[y]) && cells[z] >= -2.0 - 1e-9,
            "{row}"
        );
    }

    for (picture, begins) in [("p.svg", &b"<svg "[..]), ("p.png", b"\x89PNG")] {
        let path = at(picture);
        let told = arcline(
            nobody,
            &["plot", &trace, "-o", &path, "--events", &events, "--scale", "0.5"],
        )
        .expect(0);
        assert!(told.stdout.contains("rows drawn"), "{told:?}");
        assert!(
            std::fs::read(&path).expect("a picture").starts_with(begins),
            "{picture}"
        );
    }
    let _ = arcline(nobody, &["plot", &trace, "-o", &at("p.jpg")]).expect(2);
    let _ = arcline(nobody, &["plot", &at("none.csv"), "-o", &at("p.svg")]).expect(2);
    let _ = arcline(nobody, &["plot", &trace, "-o", &at("p.svg"), "--axes", "W"]).expect(2);

    // The written file is the same program.
    let text = at("slot.st");
    let _ = arcline(nobody, &["gcode", &file, "CS1", "--emit", &text]).expect(0);
    let shown = arcline(nobody, &["gcode", &file, "CS1", "--emit", "-"]).expect(0);
    assert_eq!(
        std::fs::read_to_string(&text).expect("a program").trim_end(),
        shown.stdout.trim_end()
    );
    assert_eq!(shown.stdout.lines().count(), 9, "{}", shown.stdout);
    // Errors of the simulation have the lines of the G-code.
    let wrong = written(folder.path(), "wrong.ngc", "G0 X1\n\n\nG1 Y1 F60\n");
    let refused = arcline(nobody, &["gcode", &wrong, "CS9", "--simulate"]).expect(2);
    assert!(
        refused.stderr.contains("wrong.ngc: line 1") && refused.stderr.contains("CS9"),
        "{refused:?}"
    );
    let unknown = written(folder.path(), "unknown.ngc", "G0 X1\nM3 S100\n");
    let refused = arcline(nobody, &["gcode", &unknown, "CS1", "--simulate"]).expect(2);
    assert!(
        refused
            .stderr
            .contains("unknown.ngc: line 2, column 1: the word `M3` is not known"),
        "{refused:?}"
    );
    let _ = arcline(nobody, &["gcode", &unknown, "CS1", "--simulate", "--skip", "M3,S"]).expect(0);
}

#[test]
fn a_long_program_streams_in_pieces() {
    let folder = tempfile::tempdir().expect("a folder");
    let lines = if is_long() { 20_000 } else { 6_000 };
    let (short, long) = (simulated(folder.path(), 2_000), simulated(folder.path(), lines));
    assert_eq!((short.moves, long.moves), (1_999, lines as u64 - 1));
    assert!(long.peak < short.peak + (8 << 20), "{short:?}, {long:?}");
    let (per_short, per_long) = (short.seconds / 1_999.0, long.seconds / long.moves as f64);
    assert!(
        (per_long / per_short - 1.0).abs() < 0.01,
        "{per_short} s and {per_long} s a move"
    );
    // More statements than a piece has, on a live machine.
    let text = format!("G91 G61\n{}", "G0 X0.001\n".repeat(1_100));
    let file = written(folder.path(), "live.ngc", &text);
    let server = Server::start();
    let told = arcline(server.address(), &["gcode", &file, "CS1"]).expect(0);
    assert!(told.stdout.contains("live.ngc: 1100 moves"), "{told:?}");
    let x = read_numbers(server.address(), &POSITIONS)[0];
    assert!((x - 1.1).abs() < 1e-9, "{x}");
    // No axis moves when the last line cannot be read, and errors behind the first piece have the lines of the file.
    let file = written(folder.path(), "wrong.ngc", &format!("{text}G5 X1\n"));
    let refused = arcline(server.address(), &["gcode", &file, "CS1"]).expect(2);
    assert!(refused.stderr.contains("wrong.ngc: line 1102, column 1"), "{refused:?}");
    assert_eq!(read_numbers(server.address(), &POSITIONS)[0], x);
    let file = written(
        folder.path(),
        "dwell.ngc",
        &format!("{text}\nG4 P9\nG1 X1 F60000\nG4 P9\nG4 P9\n"),
    );
    let shown = arcline(server.address(), &["gcode", &file, "CS1", "--emit", "-"]).expect(0);
    assert_eq!(shown.stdout.lines().count(), 1_104);
}
