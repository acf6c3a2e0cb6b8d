//! Every stop of a coordinated S-curve has a jerk limit and stays on the path: of superposed moves, of a planned contour, and of a merged
//! move before a contour, by time and led by a master (spec/coordinated-instructions.md §8.3, §15).

use arcline_instruction_set::{FaultKind, Flag};
use arcline_profile::{Jerk, KinematicState, Limits, Profile};
use arcline_tests::bench::{Bench, OK};
use arcline_tests::random::{is_long, one_or_all};

/// Master units/s that contours are planned for.
const NOMINAL: f64 = 50.0;
/// Seconds of an update.
const PERIOD: f64 = 1e-3;
/// Maximum Deceleration Jerk of an axis, units/s³: no stop of the rows has more.
const MOST_JERK: f64 = 200_000.0;

/// The planning of a coordinate system's moves.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    Superposed,
    Contour,
    /// A merged move, and a contour that waits behind it.
    Merged,
}

const KINDS: [Kind; 3] = [Kind::Superposed, Kind::Contour, Kind::Merged];

/// CS1 with moves of a kind.
fn bench(kind: Kind) -> Bench {
    let corner = if kind == Kind::Superposed { "logix" } else { "precise" };
    let keys = format!("command_tolerance = 0.5\nqueue_depth = 8\ncorner = \"{corner}\"");
    let config = arcline_config::DEFAULT.replacen("command_tolerance = 0.5", &keys, 1);
    // A fault of X brakes it.
    Bench::with(&config.replacen(
        "units = \"mm\"",
        "units = \"mm\"\nexception_actions = { drive = \"stop_planner\" }",
        1,
    ))
}

/// A line at 100 units/s with 2000 units/s² and 40000 units/s³, or the same by a master at the nominal speed.
fn line(driven: bool, tag: &str, [x, y]: [f64; 2], ending: &str) -> String {
    let dynamics = if driven {
        "2, 4, 0.8, 4, 0.8, 4, 1, 0.32, 0.32, 4"
    } else {
        "100, 0, 2000, 0, 2000, 0, 1, 40000, 40000, 0"
    };
    let lock = u8::from(driven);
    format!("MCLM(CS1, {tag}, 0, [{x}, {y}, 0], {dynamics}, {ending}, 1.0, 0, {lock})")
}

/// A machine on the way at a steady speed, at 40 units from the start of a side of 120.
fn under_way(kind: Kind, driven: bool, speed: f64) -> Bench {
    let mut bench = bench(kind);
    if driven {
        assert_eq!(bench.call(&format!("MDCC(CS1, A, D, Command, {NOMINAL})")), OK);
    }
    for (tag, to, ending) in [
        ("M1", [120.0, 0.0], "6, 0, 0"),
        ("M2", [120.0, 60.0], "6, 0, 0"),
        ("M3", [80.0, 60.0], "1, 0, 0"),
    ] {
        assert_eq!(bench.call(&line(driven, tag, to, ending)), OK, "{kind:?} {tag}");
    }
    if driven {
        let jog = format!("MAJ(A, J, 0, {speed}, 0, 9000, 0, 9000, 0, 0, 100, 100, 2)");
        assert_eq!(bench.call(&jog), OK);
    }
    until(&mut bench, "X", 40.0);
    if kind == Kind::Merged {
        let merged = line(driven, "M4", [300.0, 0.0], "1, 1, 1");
        assert_eq!(bench.call(&merged), OK, "{kind:?}");
        assert_eq!(
            bench.call(&line(driven, "M5", [300.0, 80.0], "1, 0, 0")),
            OK,
            "{kind:?}"
        );
        until(&mut bench, "X", 80.0);
    }
    bench
}

fn until(bench: &mut Bench, axis: &str, position: f64) {
    for _ in 0..20_000 {
        if bench.position(axis) >= position {
            return;
        }
        bench.tick();
    }
    panic!("{axis} does not come to {position}");
}

/// Commands of X and Y from the stop to rest.
fn stopped(bench: &mut Bench, row: &str) -> Vec<[[f64; 3]; 2]> {
    let commands = |bench: &Bench| ["X", "Y"].map(|axis| bench.axis(axis).command);
    let rests = |commands: &[[f64; 3]; 2]| commands.iter().all(|command| command[1..] == [0.0, 0.0]);
    let mut seen = vec![commands(bench)];
    for _ in 0..8000 {
        bench.tick();
        seen.push(commands(bench));
        if seen[seen.len() - 2..].iter().all(rests) {
            return seen;
        }
    }
    panic!("{row}: it does not come to rest");
}

/// No step of position or speed, and no more jerk than this on the way to rest.
fn verify(commands: &[[[f64; 3]; 2]], most_jerk: f64, row: &str) {
    for (tick, pair) in commands.windows(2).enumerate() {
        for ([p0, v0, a0], [p1, v1, a1]) in pair[0].into_iter().zip(pair[1]) {
            let step = (p1 - p0 - 0.5 * (v0 + v1) * PERIOD).abs();
            assert!(step < 0.02, "{row}, tick {tick}: a step of {step}");
            let jerk = (a1 - a0).abs() / PERIOD;
            assert!(jerk <= most_jerk * 1.001, "{row}, tick {tick}: jerk {jerk}");
        }
    }
}

#[test]
fn every_stop_of_an_s_curve_has_a_jerk_limit() {
    #[rustfmt::skip]
    let stops: [(&str, &[&str], bool); 10] = [
        // why,                             calls,                                                           needs a master
        ("MCS",                             &["MCS(CS1, S, CoordinatedMove)"],                               false),
        ("MCS beyond the next corner",      &["MCS(CS1, S, 2, 1, 50, 0, 1, 2000, 0)"],                       false),
        ("MCS All",                         &["MCS(CS1, S, All)"],                                           false),
        ("MCS again while it stops",        &["MCS(CS1, S, 2, 1, 1000, 0, 1, 20000, 0)", "MCS(CS1, S2, 2)"], false),
        ("MAS of an axis",                  &["MAS(X, S, All)"],                                             false),
        ("MGS",                             &["MGS(Motion, S, 1)"],                                          false),
        ("a fault of an axis",              &[],                                                             false),
        ("its master is shut down",         &["MASD(A, S)"],                                                 true),
        ("its master is the slave's break", &["MAS(X, S, Jog)", "MASD(A, S2)"],                              true),
        ("MCSD of its master's system",     &["MCSD(CS3, S)"],                                               true),
    ];
    let ways = KINDS.iter().flat_map(|kind| [(*kind, false), (*kind, true)]);
    let rows = ways.flat_map(|way| stops.iter().map(move |stop| (way, stop)));
    let rows = rows.filter(|((_, driven), (_, _, needs_master))| *driven || !needs_master);
    // Every stop of some way to travel, and every way with some stops; all of both where there is time.
    for (number, ((kind, driven), (why, calls, _))) in rows.enumerate() {
        if !is_long() && number % 7 != 0 {
            continue;
        }
        let row = format!("{why}, {kind:?}, driven {driven}");
        let mut bench = under_way(kind, driven, NOMINAL);
        for (place, call) in calls.iter().enumerate() {
            if place > 0 {
                bench.run(10);
            }
            bench.execute(call);
            assert_eq!(bench.control("S").err, 0, "{row}");
        }
        if calls.is_empty() {
            bench.inject("X", &[FaultKind::Drive]);
        }
        verify(&stopped(&mut bench, &row), MOST_JERK, &row);
        for tag in ["M1", "M2", "M3"] {
            assert!(!bench.control(tag).has(Flag::Ip), "{row}: {tag} {}", bench.bits(tag));
        }
    }
}

/// The maxima of the coordinate system are those of both stops.
#[test]
fn a_shutdown_of_the_master_stops_like_mcs() {
    for (place, kind) in KINDS.into_iter().enumerate() {
        // Each kind at one speed, and at both where there is time.
        for speed in one_or_all(&[20.0, 120.0], place % 2).iter().copied() {
            let traces = ["MCS(CS1, S, CoordinatedMove)", "MASD(A, S)"].map(|call| {
                let row = format!("{call}, {kind:?}, master at {speed}");
                let mut bench = under_way(kind, true, speed);
                assert_eq!(bench.call(call), OK, "{row}");
                let commands = stopped(&mut bench, &row);
                verify(&commands, MOST_JERK, &row);
                commands
            });
            assert_eq!(traces[0], traces[1], "{kind:?}, master at {speed}");
        }
    }
}

/// Speed falls along the path, at the place where the motion is: at the programmed rate the way to rest is that of the profile.
#[test]
fn a_driven_contour_needs_as_much_way_to_rest_as_a_superposed_move() {
    for speed in one_or_all(&[120.0, 20.0], 0).iter().copied() {
        let ways = KINDS.map(|kind| {
            let row = format!("{kind:?}, master at {speed}");
            let mut bench = under_way(kind, true, speed);
            assert_eq!(bench.call("MCS(CS1, S, 2, 1, 1000, 0, 1, 20000, 0)"), OK, "{row}");
            let commands = stopped(&mut bench, &row);
            verify(&commands, MOST_JERK, &row);
            commands[commands.len() - 1][0][0] - commands[0][0][0]
        });
        let spread = ways.iter().fold(0.0_f64, |most, way| most.max((way - ways[0]).abs()));
        assert!(spread < 1e-3 * ways[0], "master at {speed}: {ways:?}");
    }
}

/// A planned contour that accelerates has no jerk to spare: its stop follows the curve as the stop of a single move does.
#[test]
fn a_contour_that_accelerates_needs_as_much_way_to_rest_as_a_superposed_move() {
    let own = Limits {
        speed: 100.0,
        acceleration: 2000.0,
        deceleration: 2000.0,
        jerk: Some(Jerk {
            acceleration: 40_000.0,
            deceleration: 40_000.0,
        }),
    };
    let mcs = Limits {
        deceleration: 1000.0,
        ..own
    };
    for (call, limits) in [
        ("", own),
        ("MCCD(CS1, C, CoordinatedMove, Yes, 0, Unitspersec)", own),
        ("MCS(CS1, S, 2, 1, 1000, 0, 1, 40000, 0)", mcs),
    ] {
        for speed in [5.0, 16.0, 50.0, 84.0] {
            let row = format!("{call} from {speed}");
            let mut bench = bench(Kind::Contour);
            assert_eq!(bench.call(&line(false, "M1", [120.0, 0.0], "1, 0, 0")), OK);
            while bench.axis("X").command[1] < speed {
                bench.tick();
            }
            let [_, velocity, acceleration] = bench.axis("X").command;
            assert!(acceleration > 500.0, "{row}: it accelerates");
            if call.is_empty() {
                bench.set_override("CS1", 0.0);
            } else {
                assert_eq!(bench.call(call), OK, "{row}");
            }
            let commands = stopped(&mut bench, &row);
            verify(&commands, 40_000.0, &row);
            let way = commands[commands.len() - 1][0][0] - commands[0][0][0];
            let from = KinematicState {
                position: 0.0,
                velocity,
                acceleration,
            };
            // It begins with the next update.
            let first = PERIOD * (velocity + PERIOD * acceleration);
            let later = KinematicState {
                velocity: velocity + PERIOD * acceleration,
                ..from
            };
            let most = first + Profile::stop(later, &limits).reach();
            let least = Profile::stop(from, &limits).reach();
            assert!(
                (0.999 * least..=1.001 * most).contains(&way),
                "{row}: {way}, not {least} to {most}"
            );
        }
    }
}
