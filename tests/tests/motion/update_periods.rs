//! One program gives one trajectory at every update period (spec/motion-core.md §12.4).
//!
//! A waiting program checks its condition once a tick, so statements after a WAIT begin up to a tick later by definition.
//! These programs queue moves, or act at instants that every period has: their result does not depend on the instants of the checks.
//! Not here, as the period shows in them by their definition: corners of types 4 and 5 that are not tangent, and planned
//! contours whose pace is changed.

use arcline_tests::bench::{Bench, OK};
use arcline_tests::follow;
use arcline_tests::random::Random;

/// Update periods in ms; common instants are those of the last.
const PERIODS: [f64; 3] = [0.25, 1.0, 4.0];

/// An action at an instant, ms.
type Step = (u64, &'static str);

/// The operands from Speed on: S-curves and trapezoids.
macro_rules! dynamics {
    (s $speed:literal) => {
        concat!($speed, ", 0, 2000, 0, 1500, 0, 1, 30000, 20000, 0")
    };
    (t $speed:literal) => {
        concat!($speed, ", 0, 2000, 0, 1500, 0, 0, 100, 100, 2")
    };
}

/// A line of a coordinate system; `$end`: from Termination Type on.
macro_rules! line {
    ($system:literal, $tag:literal, $to:literal, $shape:ident $speed:literal, $end:literal) => {
        concat!("MCLM(", $system, ", ", $tag, ", 0, ", $to, ", ", dynamics!($shape $speed), ", ", $end, ")")
    };
}

/// An arc of XY about a centre, counterclockwise.
macro_rules! arc {
    ($tag:literal, $to:literal, $centre:literal, $shape:ident $speed:literal, $end:literal) => {
        concat!("MCCM(XY, ", $tag, ", 0, ", $to, ", 1, ", $centre, ", 1, ", dynamics!($shape $speed), ", ", $end, ")")
    };
}

/// The default machine with deep queues.
fn plain(period: f64) -> Bench {
    let config = arcline_config::DEFAULT.replace(
        "coarse_update_period_ms = 1.0",
        &format!("coarse_update_period_ms = {period}"),
    );
    let config = ["CS1", "XY"].iter().fold(config, |config, system| {
        let name = format!("name = \"{system}\"");
        config.replace(&name, &format!("{name}\nqueue_depth = 20"))
    });
    Bench::with(&config)
}

/// The machine of the following tests, with a cam.
fn followers(period: f64) -> Bench {
    let tags = "[[tag]]\nname = \"Cam\"\ntype = \"CAM[8]\"\n[[tag]]\nname = \"P1\"\ntype = \"CAM_PROFILE[8]\"\n";
    let mut bench = Bench::with(&format!("{}{tags}", follow::machine(period)));
    bench.cam(
        "Cam",
        &[(0.0, 0.0, 0), (20.0, 10.0, 1), (50.0, -5.0, 1), (80.0, 0.0, 1)],
    );
    assert_eq!(bench.call("MCCP(Calc, Cam, 4, 0, 0, P1)"), OK);
    bench
}

const OVERRIDE: &str = "override ";

/// The name, the machine, the steps.
type Sequence = (&'static str, fn(f64) -> Bench, &'static [Step]);

#[rustfmt::skip]
const SEQUENCES: &[Sequence] = &[
    ("types 1, 0, 2, 6 and 3 round corners", plain, &[
        (0, line!("CS1", "M1", "[30, 0, 0]", s 150, "1")),
        (0, line!("CS1", "M2", "[30, 30, 5]", s 100, "0")),
        (0, line!("CS1", "M3", "[0, 40, 0]", s 150, "2")),
        (0, line!("CS1", "M4", "[-30, 0, 10]", t 120, "6, 0, 0, 4")),
        (0, line!("CS1", "M5", "[0, -20, 0]", t 150, "3")),
        (0, line!("CS1", "M6", "[20, 0, 0]", t 150, "3")),
        (0, line!("CS1", "M7", "[0, 0, 0]", s 90, "1")),
    ]),
    ("types 2, 3, 4, 5 and 6 in line", plain, &[
        (0, line!("CS1", "M1", "[10, 0, 0]", s 150, "6, 0, 0, 3")),
        (0, line!("CS1", "M2", "[25, 0, 0]", s 80, "2")),
        (0, line!("CS1", "M3", "[45, 0, 0]", s 200, "3")),
        (0, line!("CS1", "M4", "[60, 0, 0]", s 60, "4")),
        (0, line!("CS1", "M5", "[90, 0, 0]", t 200, "5")),
        (0, line!("CS1", "M6", "[95, 0, 0]", t 100, "4")),
        (0, line!("CS1", "M7", "[120, 0, 0]", t 140, "1")),
    ]),
    ("lines and arcs, tangent with types 4 and 5, blended with 6", plain, &[
        (0, line!("XY", "M1", "[40, 0]", s 120, "4")),
        (0, arc!("M2", "[40, 40]", "[40, 20]", s 120, "4")),
        (0, line!("XY", "M3", "[0, 40]", s 160, "5")),
        (0, arc!("M4", "[0, 0]", "[0, 20]", t 100, "6, 0, 0, 5")),
        (0, line!("XY", "M5", "[0, -30]", t 100, "1")),
    ]),
    ("successors that come late", plain, &[
        (0, line!("CS1", "M1", "[60, 0, 0]", s 150, "3")),
        (392, line!("CS1", "M2", "[60, 60, 0]", s 150, "6, 0, 0, 10")),
        (900, line!("CS1", "M3", "[0, 60, 0]", s 150, "1")),
    ]),
    ("merges at the speed of each and of the other", plain, &[
        (0, line!("CS1", "M1", "[80, 0, 0]", s 150, "1")),
        (240, line!("CS1", "M2", "[50, 60, 0]", s 100, "1, 1, 0")),
        (400, line!("CS1", "M3", "[0, 0, 20]", t 100, "1, 2, 1")),
    ]),
    ("changes of dynamics, a pause, an overshoot", plain, &[
        (0, line!("CS1", "M1", "[60, 0, 0]", s 150, "3")),
        (0, line!("CS1", "M2", "[60, 60, 0]", s 150, "4")),
        (0, line!("CS1", "M3", "[60, 90, 0]", s 150, "1")),
        (200, "MCCD(CS1, C1, 1, Yes, 80, 0, Yes, 1000, 0, No, 0, 0, No, 0, No, 0, 0, 0)"),
        (400, "MCCD(CS1, C2, 1, Yes, 0, 0, No, 0, 0, No, 0, 0, No, 0, No, 0, 0, 1)"),
        (700, "MCCD(CS1, C3, 1, Yes, 120, 0, No, 0, 0, Yes, 3000, 0, No, 0, Yes, 80000, 0, 1)"),
        (1400, "MCCD(CS1, C4, 1, No, 0, 0, No, 0, 0, Yes, 300, 0, No, 0, No, 0, 0, 0)"),
    ]),
    ("overrides, a hold and a stop", plain, &[
        (0, line!("CS1", "M1", "[100, 0, 0]", s 150, "3")),
        (0, line!("CS1", "M2", "[100, 100, 0]", s 150, "1")),
        (160, "override 0.5"),
        (400, "override 0"),
        (800, "override 1.6"),
        (1100, "MCS(CS1, S, CoordinatedMove, Yes, 900, 0, Yes, 9000, 0)"),
    ]),
    ("moves and jogs of axes, with merges, changes and stops", plain, &[
        (0, concat!("MAM(X, M1, 0, 60, ", dynamics!(s 150), ")")),
        (0, concat!("MAJ(Y, J1, 0, ", dynamics!(s 90), ")")),
        (0, concat!("MAJ(A, J2, 1, ", dynamics!(t 90), ")")),
        (160, "MCD(X, C1, Move, Yes, 60)"),
        (160, "MCD(Y, C2, Jog, Yes, 30)"),
        (300, concat!("MAM(X, M2, 1, -30, ", dynamics!(t 100), ", 1, 0)")),
        (300, "MAS(Y, S1, Jog, Yes, 400, 0, No, 0, 0)"),
        (500, "MAS(A, S2, All, Yes, 700, 0, No, 0, 0)"),
        (600, "MGS(Motion, S3, 1)"),
    ]),
    ("a gear with and without a clutch", followers, &[
        (0, concat!("MAJ(B1, J, 0, ", dynamics!(s 100), ")")),
        (200, "MAG(A1, B1, G1, Same, 0.3, 1, 1, Command, Real, Enabled, 1000, Unitspersec2)"),
        (500, "MAG(A1, B1, G2, Opposite, 1.5, 1, 1, Command, Real, Disabled, 0, 0)"),
        (700, "MAS(A1, S, All, Yes, 900, 0)"),
        (800, "MAS(B1, S2, All, Yes, 900, 0)"),
    ]),
    ("a position cam and a time cam", followers, &[
        (0, "MAPC(A1, B1, C1, Same, P1, 1, 1, Once, Immediate, 0, 5, Command, Bidirectional)"),
        (0, "MATC(A2, C2, 0, P1, 0.02, 1.5, 0, 0)"),
        (100, concat!("MAM(B1, M, 0, 100, ", dynamics!(s 120), ")")),
    ]),
    ("a transform, and what it leads stops by itself", followers, &[
        (0, "MCT(L1, L2, T, [10, 20, 30], [1, 2, 3])"),
        (0, line!("L1", "M1", "[40, 30, 20]", s 120, "3")),
        (100, line!("L1", "M2", "[0, 30, 0]", s 120, "1")),
        (500, "MCS(L1, S, CoordinatedTransform, No, 0, 0, No, 0, 0)"),
    ]),
    ("a line that is driven by a master", plain, &[
        (0, "MDCC(CS1, A, D1, Command, 0)"),
        (0, "MCLM(CS1, M1, Absolute, [60, 0, 0], 2, Unitspermasterunit, 1, Unitspermasterunit2, 1, Unitspermasterunit2, \
             Trapezoidal, 100, 100, %ofTimeMasterDriven, 3, Disabled, Programmed, 0, 10, PositionForwardOnly, 0, 0)"),
        (0, concat!("MAM(A, J1, 0, 90, ", dynamics!(s 100), ")")),
    ]),
];

/// Command positions of every axis every 4 ms, and the answer to each step.
fn sampled(
    period: f64,
    machine: fn(f64) -> Bench,
    steps: &[(u64, impl AsRef<str>)],
) -> (Vec<Vec<f64>>, Vec<(i16, i8)>) {
    let mut bench = machine(period);
    let every = (PERIODS[2] / period).round() as u64;
    let (mut rows, mut answers) = (Vec::new(), Vec::new());
    for ms in (0..4000).step_by(PERIODS[2] as usize) {
        for (_, step) in steps.iter().filter(|(at, _)| *at == ms) {
            let step = step.as_ref();
            match step.strip_prefix(OVERRIDE) {
                Some(share) => bench.set_override("CS1", share.parse().expect("a share")),
                None => answers.push(bench.call(step)),
            }
        }
        let axes = bench.snapshot().axes;
        rows.push(axes.iter().map(|axis| axis.command[0]).collect());
        bench.run(every);
    }
    (rows, answers)
}

/// Runs steps at every period: the same answers, and the same positions at common instants. The answers.
fn compare(why: &str, machine: fn(f64) -> Bench, steps: &[(u64, impl AsRef<str>)]) -> Vec<(i16, i8)> {
    assert!(
        steps.iter().all(|(at, _)| at % 4 == 0),
        "{why}: every period has these instants"
    );
    let [fine, plain, coarse] = PERIODS.map(|period| sampled(period, machine, steps));
    assert!(fine.0.iter().any(|row| *row != fine.0[0]), "{why}: nothing moves");
    for (other, period) in [(&plain, PERIODS[1]), (&coarse, PERIODS[2])] {
        assert_eq!(fine.1, other.1, "{why}: every {} and {period} ms", PERIODS[0]);
        for (row, (a, b)) in fine.0.iter().zip(&other.0).enumerate() {
            let apart = a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            let at = row as f64 * PERIODS[2];
            assert!(
                apart < 1e-9,
                "{why}: {apart} apart at {at} ms, {} and {period} ms",
                PERIODS[0]
            );
        }
    }
    fine.1
}

#[test]
fn no_instruction_shows_the_update_period() {
    for (why, machine, steps) in SEQUENCES {
        let answers = compare(why, *machine, steps);
        assert!(answers.iter().all(|answer| *answer == OK), "{why}: {answers:?}");
    }
}

/// A random program: moves of every type, merges, changes of dynamics, pauses, stops, overrides, every few ms.
fn random_program(seed: u64) -> Vec<(u64, String)> {
    let mut random = Random(seed);
    // Corners of types 4 and 5 show the period by definition: these types are for lines in one direction.
    let in_line = random.below(3) == 0;
    let types: &[u8] = if in_line {
        &[0, 1, 2, 3, 4, 5, 6]
    } else {
        &[0, 1, 2, 3, 6]
    };
    let (mut steps, mut at, mut x, mut moves) = (Vec::new(), 0, 0.0, 0);
    while at < 2400 {
        let [speed, up, down] = [(20.0, 300.0), (500.0, 4000.0), (500.0, 4000.0)].map(|(a, b)| random.between(a, b));
        let step = match random.below(10) {
            0..=5 => {
                moves += 1;
                x += random.between(0.5, 30.0);
                let (profile, jerk) = (random.below(2), random.between(10.0, 100.0));
                let merge = if random.below(8) == 0 { 1 + random.below(2) } else { 0 };
                let (kind, tolerance) = (random.one_of(types), random.between(0.1, 10.0));
                let rest = format!(
                    "{speed}, 0, {up}, 0, {down}, 0, {profile}, {jerk}, {jerk}, 2, {kind}, {merge}, {}, {tolerance}",
                    random.below(2)
                );
                let [y, z] = [(); 2].map(|()| random.between(-40.0, 40.0));
                match (in_line, random.below(3)) {
                    (true, _) => format!("MCLM(CS1, M{moves}, 0, [{x}, 0, 0], {rest})"),
                    (_, 0) => format!("MCCM(CS1, M{moves}, 1, [10, {y}, 5], Via, [{z}, 30, 20], 0, {rest})"),
                    _ => format!("MCLM(CS1, M{moves}, 0, [{z}, {y}, {x}], {rest})"),
                }
            }
            6 | 7 => {
                let speed = if random.below(5) == 0 { 0.0 } else { speed };
                let change = |random: &mut Random| random.below(2);
                format!(
                    "MCCD(CS1, C{at}, 1, 1, {speed}, 0, {}, {up}, 0, {}, {down}, 0, {}, 40, {}, 70, 2, {})",
                    change(&mut random),
                    change(&mut random),
                    change(&mut random),
                    change(&mut random),
                    change(&mut random),
                )
            }
            8 => format!("{OVERRIDE}{}", random.between(0.0, 2.0)),
            _ if random.below(3) == 0 => format!("MCS(CS1, S{at}, CoordinatedMove, Yes, {down}, 0)"),
            _ => String::new(),
        };
        if !step.is_empty() {
            steps.push((at, step));
        }
        at += 4 * random.below(60);
    }
    steps.push((2600, format!("{OVERRIDE}1")));
    steps.push((
        2600,
        "MCCD(CS1, C, 1, 1, 200, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1)".into(),
    ));
    steps
}

#[test]
fn no_random_program_shows_the_update_period() {
    let cases = std::env::var("ARCLINE_CASES").map_or(10, |cases| cases.parse().expect("a number"));
    for seed in 0..cases {
        let steps = random_program(seed);
        let program: Vec<String> = steps.iter().map(|(at, step)| format!("{at} ms: {step}")).collect();
        compare(&format!("seed {seed}:\n{}\n", program.join("\n")), plain, &steps);
    }
}
