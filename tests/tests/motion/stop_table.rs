//! The result table of the stop's reference: the motion that each stop leaves running, of coordinated moves, single-axis moves and a
//! transform (the reference page MCS, spec/coordinated-instructions.md §15.5).
//!
//! CS1 = X, Y, Z; CS2 = X, Y, S; CS3 = A, B, C; transform T1 from CS2 to CS3. An MCLM on CS2 and MAMs on Y, Z and S run.

use arcline_instruction_set::Flag;
use arcline_instruction_set::predefined::{coordinate_motion_status, motion_status};
use arcline_tests::bench::{Bench, OK};

/// instruction, coordinate system or axis, stop type; the states of the MCLM on CS2, the MAMs on Y, Z and S, T1, and
/// the axes A, B and C.
const TABLE: &str = "
    MCS,CS1,All,stop,stop,stop,cont,cancel,stop
    MCS,CS2,All,stop,stop,cont,stop,cancel,stop
    MCS,CS3,All,cont,cont,cont,cont,cancel,stop
    MCS,CS1,CoordinatedMove,cont,cont,cont,cont,active,follow
    MCS,CS2,CoordinatedMove,stop,cont,cont,cont,active,follow
    MCS,CS3,CoordinatedMove,cont,cont,cont,cont,active,follow
    MAS,Y,All,stop,stop,cont,cont,cancel,stop
    MAS,Y,Move,cont,stop,cont,cont,active,follow
    MAS,Z,All,cont,cont,stop,cont,active,follow
    MAS,Z,Move,cont,cont,stop,cont,active,follow
    MCS,CS1,CoordinatedTransform,cont,cont,cont,cont,active,follow
    MCS,CS2,CoordinatedTransform,cont,cont,cont,cont,cancel,stop
    MCS,CS3,CoordinatedTransform,cont,cont,cont,cont,cancel,stop
";

/// The profiles of the moves and of their stops: trapezoids and S-curves.
const SHAPES: [&str; 2] = ["Trapezoidal", "S-curve"];

/// Speed of the MCLM along X, Y and S: 150 units/s over the direction 2, 2, 1.
const COORDINATED: [f64; 3] = [100.0, 100.0, 50.0];
/// Speed of each MAM, units/s.
const SINGLE: f64 = 80.0;
/// No stop here takes longer, ms: 100 + 80 units/s at 1000 units/s² and a limited jerk.
const STOPPED: u64 = 600;

fn running(shape: &str) -> Bench {
    let mut bench = Bench::new();
    let rates = format!("1000, Unitspersec2, 1000, Unitspersec2, {shape}, 100, 100, %ofTime");
    assert_eq!(bench.call("MCT(CS2, CS3, T1c, [0, 0, 0], [0, 0, 0])"), OK);
    let line = format!("MCLM(CS2, L1, 0, [2000, 2000, 1000], 150, Unitspersec, {rates}, 1)");
    assert_eq!(bench.call(&line), OK);
    for axis in ["Y", "Z", "S"] {
        let call = format!("MAM({axis}, M{axis}, 1, 1500, {SINGLE}, Unitspersec, {rates}, Disabled, Programmed)");
        assert_eq!(bench.call(&call), OK);
    }
    bench.run(1000);
    bench
}

fn velocity(bench: &Bench, axis: &str) -> f64 {
    bench.axis(axis).command[1]
}

#[test]
fn every_row_of_the_result_table() {
    for shape in SHAPES {
        for row in TABLE.lines().map(str::trim).filter(|row| !row.is_empty()) {
            let why = format!("{shape}: {row}");
            let cells: Vec<&str> = row.split(',').collect();
            let [instruction, target, stop_type, line, y, z, s, transform, abc] = cells[..] else {
                panic!("{row} has nine cells");
            };
            let mut bench = running(shape);
            let stop =
                format!("{instruction}({target}, Stop, {stop_type}, No, 100, Unitspersec2, No, 100, Unitspersec3)");
            assert_eq!(bench.call(&stop), OK, "{why}");
            bench.run(STOPPED);
            assert_eq!(bench.bits("Stop"), "EN DN PC", "{why}");

            // The instructions: one that goes on is in process, a stopped one never completes.
            let goes_on = |cell: &str| cell == "cont" || cell == "active";
            for (tag, cell) in [("L1", line), ("MY", y), ("MZ", z), ("MS", s), ("T1c", transform)] {
                assert_eq!(bench.control(tag).has(Flag::Ip), goes_on(cell), "{why}: {tag}");
                assert!(!bench.control(tag).has(Flag::Pc), "{why}: {tag}");
            }

            // The motion: each generator that goes on adds its speed, each that was stopped adds nothing.
            let part = |cell: &str, speed: f64| if goes_on(cell) { speed } else { 0.0 };
            let expected = [
                ("X", part(line, COORDINATED[0])),
                ("Y", part(line, COORDINATED[1]) + part(y, SINGLE)),
                ("Z", part(z, SINGLE)),
                ("S", part(line, COORDINATED[2]) + part(s, SINGLE)),
            ];
            for (axis, speed) in expected {
                let is = velocity(&bench, axis);
                assert!((is - speed).abs() < 1e-9, "{why}: {axis} runs at {is}, not {speed}");
            }
            for (source, driven) in [("X", "A"), ("Y", "B"), ("S", "C")] {
                let lead = if abc == "follow" { velocity(&bench, source) } else { 0.0 };
                assert_eq!(velocity(&bench, driven), lead, "{why}: {driven}");
                let apart = bench.position(source) - bench.position(driven);
                assert_eq!(apart == 0.0, abc == "follow", "{why}: {driven} is {apart} behind");
            }

            // The bits of axes and coordinate systems.
            let active = u32::from(transform == "active");
            for axis in ["X", "Y", "S", "A", "B", "C"] {
                let word = bench.axis(axis).motion_status;
                let state = word & motion_status::TRANSFORM_STATE_STATUS != 0;
                assert_eq!(u32::from(state), active, "{why}: {axis}");
            }
            for axis in ["A", "B", "C"] {
                let word = bench.axis(axis).motion_status;
                let controlled = word & motion_status::CONTROLLED_BY_TRANSFORM_STATUS != 0;
                assert_eq!(controlled, abc == "follow", "{why}: {axis}");
            }
            let shows = |system: &str, bit: u32| u32::from(bench.system(system).motion_status & bit != 0);
            assert_eq!(
                shows("CS2", coordinate_motion_status::TRANSFORM_SOURCE_STATUS),
                active,
                "{why}"
            );
            assert_eq!(
                shows("CS3", coordinate_motion_status::TRANSFORM_TARGET_STATUS),
                active,
                "{why}"
            );
        }
    }
}

#[test]
fn the_motion_that_a_stop_covers_is_at_rest_when_its_bit_sets() {
    for shape in SHAPES {
        for row in TABLE.lines().map(str::trim).filter(|row| !row.is_empty()) {
            let cells: Vec<&str> = row.split(',').collect();
            let mut bench = running(shape);
            let (instruction, target, stop_type) = (cells[0], cells[1], cells[2]);
            bench.call(&format!(
                "{instruction}({target}, Stop, {stop_type}, No, 100, Unitspersec2, No, 100, Unitspersec3)"
            ));
            let took = bench.until("Stop", Flag::Pc);
            let stands = |axis: &str| velocity(&bench, axis) == 0.0;
            let at_rest: &[&str] = match (instruction, target, stop_type) {
                ("MCS", "CS1", "All") => &["X", "A", "B", "C"],
                ("MCS", "CS2", "All") => &["X", "Y", "S", "A", "B", "C"],
                ("MCS", "CS3", _) if stop_type != "CoordinatedMove" => &["A", "B", "C"],
                ("MCS", "CS2", "CoordinatedTransform") => &["A", "B", "C"],
                ("MCS", "CS2", "CoordinatedMove") => &["X", "A"],
                ("MAS", "Y", "All") => &["Y"],
                ("MAS", "Z", _) => &["Z"],
                // The rest stops nothing as a whole axis.
                _ => &[],
            };
            assert!(at_rest.iter().all(|axis| stands(axis)), "{shape}: {row}");
            // A stop of motion takes time; a stop without any motion is done at the next update.
            let idle = matches!(
                (instruction, target, stop_type),
                ("MCS", "CS1" | "CS3", "CoordinatedMove") | ("MCS", "CS1", "CoordinatedTransform")
            );
            assert_eq!(took <= 1, idle, "{shape}: {row} took {took} updates");
        }
    }
}
