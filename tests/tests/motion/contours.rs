//! Coordinate systems with `corner = "precise"` or `axis_limits = "enforce"`: their moves are planned as contours.

use arcline_instruction_set::Flag;
use arcline_instruction_set::predefined::coordinate_motion_status as cms;
use arcline_tests::bench::{Bench, OK};
use arcline_tests::random::{is_long, one_or_all};

/// XY with precise corners, enforced limits of its axes and a queue of 20.
fn precise() -> Bench {
    Bench::replacing(
        "name = \"XY\"",
        "name = \"XY\"\nqueue_depth = 20\ncorner = \"precise\"\naxis_limits = \"enforce\"",
    )
}

fn line(tag: &str, x: f64, y: f64, termination: &str) -> String {
    format!("MCLM(XY, {tag}, 0, [{x}, {y}], 200, 0, 5000, 0, 5000, 0, 1, 100000, 100000, 0, {termination})")
}

/// Three sides of a square, rounded within 0.1 at two corners.
fn three_sides(bench: &mut Bench) {
    bench.execute(&line("M1", 50.0, 0.0, "6, 0, 0, 0.1"));
    bench.execute(&line("M2", 50.0, 50.0, "6, 0, 0, 0.1"));
    bench.execute(&line("M3", 0.0, 50.0, "1"));
}

fn distance_to_path(x: f64, y: f64) -> f64 {
    let segment = |p: [f64; 2], q: [f64; 2]| {
        let (dx, dy) = (q[0] - p[0], q[1] - p[1]);
        let t = (((x - p[0]) * dx + (y - p[1]) * dy) / (dx * dx + dy * dy)).clamp(0.0, 1.0);
        (x - p[0] - t * dx).hypot(y - p[1] - t * dy)
    };
    let sides = [
        [[0.0, 0.0], [50.0, 0.0]],
        [[50.0, 0.0], [50.0, 50.0]],
        [[50.0, 50.0], [0.0, 50.0]],
    ];
    sides.iter().map(|[p, q]| segment(*p, *q)).fold(f64::INFINITY, f64::min)
}

#[test]
fn corners_are_rounded_within_the_tolerance_and_the_end_is_exact() {
    let mut bench = precise();
    three_sides(&mut bench);
    assert_eq!(bench.bits("M1"), "EN DN IP", "planned at the end of this update");
    bench.tick();
    assert_eq!(bench.bits("M1"), "EN DN IP AC ACCEL", "{:?}", bench.axis("X").command);
    assert_eq!(bench.bits("M2"), "EN DN IP");
    assert_ne!(bench.system("XY").motion_status & cms::MOVE_PENDING_STATUS, 0);
    let mut last = [bench.axis("X").command, bench.axis("Y").command];
    let mut order = Vec::new();
    while bench.system("XY").status & 4 != 0 {
        bench.tick();
        let now = [bench.axis("X").command, bench.axis("Y").command];
        assert!(distance_to_path(now[0][0], now[1][0]) <= 0.1 * 1.001, "{:?}", now);
        for (before, after) in last.iter().zip(&now) {
            let acceleration = (after[1] - before[1]) / 0.001;
            assert!(acceleration.abs() <= 10_000.0 * 1.001, "{acceleration}");
        }
        last = now;
        for tag in ["M1", "M2", "M3"] {
            if bench.control(tag).has(Flag::Pc) && !order.contains(&tag) {
                order.push(tag);
            }
        }
    }
    assert_eq!(order, ["M1", "M2", "M3"]);
    assert_eq!((bench.position("X"), bench.position("Y")), (0.0, 50.0));
    assert_eq!(last[0][1].hypot(last[1][1]), 0.0);
    // A stop at each corner would take 3 · (0.25 + 0.09) s.
    assert!(bench.now() < 970, "{} ms", bench.now());
    // The sides are long, so the motion reaches their speed except for a millisecond beside each corner; a curve may be faster.
    let mut anywhere = Bench::replacing(
        "name = \"XY\"",
        "name = \"XY\"\nqueue_depth = 20\ncorner = \"precise\"\naxis_limits = \"enforce\"\ndeviation = \"anywhere\"",
    );
    three_sides(&mut anywhere);
    while !anywhere.control("M3").has(Flag::Pc) {
        anywhere.tick();
    }
    assert!(anywhere.now() < 950, "{} ms", anywhere.now());
}

#[test]
fn moves_that_come_one_by_one_become_one_contour() {
    let mut bench = precise();
    for (place, (x, y)) in [(20.0, 0.0), (20.0, 20.0), (0.0, 20.0), (0.0, 0.0)]
        .into_iter()
        .enumerate()
    {
        bench.execute(&line(&format!("M{place}"), x, y, "6, 0, 0, 0.1"));
        bench.run(2);
    }
    assert_eq!((bench.bits("M0").as_str(), bench.position("X")), ("EN DN IP", 0.0));
    bench.run(8);
    assert!(bench.control("M0").has(Flag::Ac));
    bench.until("M0", Flag::Pc);
    assert!(bench.system("XY").path_speed > 1.0, "no stop at the corner");
    bench.until("M3", Flag::Pc);
    assert_eq!((bench.position("X"), bench.position("Y")), (0.0, 0.0));
}

#[test]
fn a_stop_stays_on_the_path_and_ends_every_move() {
    let mut bench = precise();
    three_sides(&mut bench);
    bench.run(260);
    bench.execute("MCS(XY, S1, CoordinatedMove, Yes, 2000, 0, Yes, 20000, Unitspersec3)");
    for tag in ["M1", "M2", "M3"] {
        assert!(!bench.control(tag).has(Flag::Ip), "{tag}: {}", bench.bits(tag));
    }
    assert_eq!(bench.bits("S1"), "EN DN IP");
    while !bench.control("S1").has(Flag::Pc) {
        bench.tick();
        assert!(distance_to_path(bench.position("X"), bench.position("Y")) <= 0.1 * 1.001);
    }
    assert_eq!((bench.axis("X").command[1], bench.axis("Y").command[1]), (0.0, 0.0));
    assert_eq!(bench.call(&line("M4", 0.0, 0.0, "1")), OK);
    bench.until("M4", Flag::Pc);
    assert_eq!((bench.position("X"), bench.position("Y")), (0.0, 0.0));
}

#[test]
fn cancelled_before_they_are_planned() {
    let mut bench = precise();
    three_sides(&mut bench);
    bench.execute("MCS(XY, S1, CoordinatedMove)");
    bench.until("S1", Flag::Pc);
    assert_eq!((bench.bits("M1").as_str(), bench.position("X")), ("EN DN", 0.0));
    assert_eq!(bench.call("MCSD(XY, D1)"), OK);
}

#[test]
fn shutdown_ends_a_contour_at_once() {
    let mut bench = precise();
    three_sides(&mut bench);
    bench.run(200);
    assert_eq!(bench.call("MCSD(XY, D1)"), OK);
    assert_eq!(
        (bench.bits("M1").as_str(), bench.bits("M3").as_str()),
        ("EN DN", "EN DN")
    );
    assert_eq!(bench.axis("X").command[1], 0.0);
    bench.until_rest();
}

#[test]
fn a_queue_that_is_full_says_so_and_goes_on() {
    let keys = "name = \"XY\"\nqueue_depth = 6\ncorner = \"precise\"\naxis_limits = \"enforce\"";
    let mut bench = Bench::replacing("name = \"XY\"", keys);
    for place in 0..7 {
        let (x, y) = if place % 2 == 0 {
            (10.0, f64::from(place))
        } else {
            (0.0, f64::from(place))
        };
        assert_eq!(bench.call(&line(&format!("M{place}"), x, y, "6, 0, 0, 0.05")), OK);
    }
    assert_eq!(bench.call(&line("Last", 0.0, 0.0, "1")), (43, 0));
    bench.until("M0", Flag::Pc);
    assert_eq!(bench.call(&line("Last", 0.0, 0.0, "1")), OK);
    bench.until("Last", Flag::Pc);
    assert_eq!((bench.position("X"), bench.position("Y")), (0.0, 0.0));
}

#[test]
fn every_update_period_gives_one_contour() {
    let run = |period_ms: &str, every: u64| {
        let config = arcline_config::DEFAULT
            .replacen(
                "name = \"XY\"",
                "name = \"XY\"\nqueue_depth = 20\ncorner = \"precise\"",
                1,
            )
            .replacen(
                "coarse_update_period_ms = 1.0",
                &format!("coarse_update_period_ms = {period_ms}"),
                1,
            );
        let mut bench = Bench::with(&config);
        three_sides(&mut bench);
        (0..200)
            .map(|_| {
                bench.run(every);
                [bench.position("X"), bench.position("Y")]
            })
            .collect::<Vec<_>>()
    };
    let reference = run("1.0", 4);
    for (period, every) in [("0.25", 16), ("4.0", 1)] {
        for (a, b) in reference.iter().zip(run(period, every)) {
            assert!(
                (a[0] - b[0]).abs() < 1e-9 && (a[1] - b[1]).abs() < 1e-9,
                "{period} ms: {a:?} {b:?}"
            );
        }
    }
}

/// Position, velocity and acceleration of X and Y, with a check against their limits.
pub(crate) struct Watch {
    last: [[f64; 3]; 2],
    limits: [[f64; 3]; 2],
}

impl Watch {
    pub(crate) fn new(bench: &Bench) -> Self {
        let limits = ["X", "Y"].map(|name| {
            let index = bench.machine().axis(name).expect("it exists");
            let axis = &bench.machine().axes[usize::from(index)];
            [
                axis.max_speed,
                axis.max_acceleration.min(axis.max_deceleration),
                axis.max_acceleration_jerk.min(axis.max_deceleration_jerk),
            ]
        });
        Watch {
            last: ["X", "Y"].map(|axis| bench.axis(axis).command),
            limits,
        }
    }

    /// Trapezoids: the acceleration may step.
    pub(crate) fn without_jerk(mut self) -> Self {
        self.limits.iter_mut().for_each(|[_, _, jerk]| *jerk = f64::INFINITY);
        self
    }

    pub(crate) fn tick(&mut self, bench: &mut Bench) {
        bench.tick();
        let now = ["X", "Y"].map(|axis| bench.axis(axis).command);
        for ((now, last), limits) in now.iter().zip(&self.last).zip(&self.limits) {
            let ([_, v, a], [_, last_v, last_a]) = (now, last);
            let [speed, rate, jerk] = limits;
            let tick = bench.now();
            assert!(v.abs() <= speed * 1.000_001, "tick {tick}: velocity {v}");
            assert!(a.abs() <= rate * 1.000_001, "tick {tick}: acceleration {a}");
            assert!(
                (v - last_v).abs() <= rate * 0.001_000_001,
                "tick {tick}: velocity {last_v}, {v}"
            );
            assert!(
                (a - last_a).abs() <= jerk * 0.001_000_001 + 1e-6,
                "tick {tick}: acceleration {last_a}, {a}"
            );
        }
        self.last = now;
    }
}

#[test]
fn a_merge_takes_over_a_contour_and_keeps_the_limits_of_the_axes() {
    for (merge, speed) in [(1, 0), (1, 1), (2, 0), (2, 1_u64)] {
        // The current speed of the beginning would take for ever. Each combination of operands at one instant, and at all of them where there is time.
        let all = [1 + 28 * speed, 120, 262, 400];
        let one = (2 * merge + speed) as usize % all.len();
        for at in one_or_all(&all, one).iter().copied() {
            let mut bench = precise();
            three_sides(&mut bench);
            bench.run(at);
            // A merge of all motion ends the other motion of an axis too.
            if merge == 2 {
                bench.execute("MAM(X, A, 0, 200, 5, 0, 5000, 0, 5000, 0, 1, 100000, 100000)");
            }
            bench.run(2);
            let current = bench.axis("X").command[1].hypot(bench.axis("Y").command[1]);
            let mut watch = Watch::new(&bench);
            let call = line("M4", -30.0, 20.0, &format!("1, {merge}, {speed}"));
            assert_eq!(bench.call(&call), OK, "at {at}");
            assert_eq!(bench.bits("M4"), "EN DN IP AC", "at {at}");
            for tag in ["M1", "M2", "M3"] {
                assert!(!bench.control(tag).has(Flag::Ip), "{tag} at {at}: {}", bench.bits(tag));
            }
            assert!(!bench.control("A").has(Flag::Ip), "at {at}");
            assert_eq!(bench.call(&line("M5", -30.0, 60.0, "6, 0, 0, 0.1")), OK);
            assert_eq!(bench.call(&line("M6", 0.0, 60.0, "1")), OK);
            assert_ne!(bench.system("XY").motion_status & cms::MOVE_PENDING_STATUS, 0);
            // Together with the residual it has the earlier programmed speed; then its own.
            let programmed = if merge == 2 { 205.0 } else { 200.0 };
            let (mut together, mut top, begin) = (0.0_f64, 0.0_f64, bench.now());
            while !bench.control("M4").has(Flag::Pc) {
                watch.tick(&mut bench);
                let fast = bench.system("XY").path_speed;
                together = together.max(fast);
                if bench.now() > begin + 150 {
                    top = top.max(fast);
                }
            }
            let most = if speed == 1 { current } else { 200.0 };
            assert!(
                together <= programmed * 1.000_001,
                "at {at}: {together} of {programmed}"
            );
            assert!(top <= most * 1.000_001, "at {at}: {top} of {most}");
            assert_eq!(bench.bits("M4"), "EN DN PC");
            while !bench.control("M6").has(Flag::Pc) {
                watch.tick(&mut bench);
                assert!(bench.now() < 20_000);
            }
            assert_eq!((bench.position("X"), bench.position("Y")), (0.0, 60.0), "at {at}");
        }
    }
}

#[test]
fn a_merged_move_is_held_changed_stopped_and_merged_again() {
    let merged = || {
        let mut bench = precise();
        three_sides(&mut bench);
        bench.run(200);
        assert_eq!(bench.call(&line("M4", -30.0, 20.0, "1, 1, 0")), OK);
        bench.run(60);
        let watch = Watch::new(&bench);
        (bench, watch)
    };
    let (mut bench, mut watch) = merged();
    bench.set_override("XY", 0.0);
    for _ in 0..400 {
        watch.tick(&mut bench);
    }
    assert_eq!(
        (bench.bits("M4").as_str(), bench.axis("X").command[1]),
        ("EN DN IP AC", 0.0)
    );
    bench.set_override("XY", 2.0);
    while !bench.control("M4").has(Flag::Pc) {
        watch.tick(&mut bench);
    }
    assert_eq!((bench.position("X"), bench.position("Y")), (-30.0, 20.0));

    let (mut bench, mut watch) = merged();
    assert_eq!(
        bench.call("MCCD(XY, C, CoordinatedMove, Yes, 40, 0, Yes, 90000, 0, Yes, 90000, 0)"),
        OK
    );
    for _ in 0..200 {
        watch.tick(&mut bench);
    }
    // The planner takes the distance of the motion that has ramped out back along the path, so the path speed is a little lower.
    let speed = bench.system("XY").path_speed;
    assert!(speed <= 40.0 + 1e-9 && speed > 0.85 * 40.0, "{speed}");
    assert_eq!(bench.call(&line("M5", 10.0, 10.0, "1, 2, 0")), OK);
    assert_eq!(bench.bits("M4"), "EN DN");
    while !bench.control("M5").has(Flag::Pc) {
        watch.tick(&mut bench);
    }
    assert_eq!((bench.position("X"), bench.position("Y")), (10.0, 10.0));

    let (mut bench, mut watch) = merged();
    assert_eq!(bench.call(&line("M5", 10.0, 10.0, "1")), OK);
    bench.execute("MCS(XY, S, CoordinatedMove, Yes, 90000, 0, Yes, 9000000, Unitspersec3)");
    assert_eq!(
        (bench.bits("M4").as_str(), bench.bits("M5").as_str()),
        ("EN DN", "EN DN")
    );
    while !bench.control("S").has(Flag::Pc) {
        watch.tick(&mut bench);
    }
    assert_eq!((bench.axis("X").command[1], bench.axis("Y").command[1]), (0.0, 0.0));
    three_sides(&mut bench);
    bench.until("M3", Flag::Pc);
}

/// The controller plans a contour some updates after it has executed the first of its moves. Another motion of one of its axes goes on: the
/// axis does not step, and both motions come to their ends.
#[test]
fn a_contour_begins_where_another_motion_has_brought_its_axis() {
    for chords in [1, 20] {
        let mut bench = precise();
        bench.execute("MAM(X, A, 1, 200, 50, 0, 500, 0, 500, 0, 0, 100, 100, 2)");
        bench.run(300);
        let mut watch = Watch::new(&bench).without_jerk();
        for chord in 1..=chords {
            // A single move is planned after a while without another move.
            let termination = if chord == 20 { "1" } else { "6, 0, 0, 0.1" };
            let y = f64::from(chord);
            assert_eq!(bench.call(&line("M", 12.0, y, termination)), OK);
        }
        while bench.control("A").has(Flag::Ip) {
            watch.tick(&mut bench);
        }
        // From 12.5, to which MAM had moved it, to 12, and on as far as MAM still led.
        let end = [12.0 + 200.0 - 12.5, f64::from(chords)];
        let [x, y] = [bench.position("X"), bench.position("Y")];
        assert!(
            (x - end[0]).abs() < 1e-9 && (y - end[1]).abs() < 1e-9,
            "{chords}: {x}, {y}"
        );
    }
}

/// Along chords of a circle, and through the wide roundings of a square, the speed is constant once it is up.
#[test]
fn accel_and_decel_status_do_not_flicker_along_chords() {
    const SPEED: f64 = 20.0;
    const RADIUS: f64 = 50.0;
    for (profile, count) in [0, 1]
        .into_iter()
        .flat_map(|profile| [4, 60, 120, 240].map(|count| (profile, count)))
        .filter(|(_, count)| *count <= 60 || is_long())
    {
        let mut bench = Bench::replacing(
            "name = \"XY\"",
            "name = \"XY\"\ncorner = \"precise\"\nqueue_depth = 300",
        );
        for number in 0..count {
            let angle = std::f64::consts::TAU * f64::from(number + 1) / f64::from(count);
            let (x, y) = (RADIUS * angle.sin(), RADIUS * (1.0 - angle.cos()));
            let dynamics = format!("{SPEED}, 0, 500, 0, 500, 0, {profile}, 100, 100, 2");
            let call = format!("MCLM(XY, M{number}, 0, [{x}, {y}], {dynamics}, 2, 0, 0, 0)");
            assert_eq!(bench.call(&call), OK, "{call}");
        }
        let last = format!("M{}", count - 1);
        let mut shown = vec![0];
        while !bench.control(&last).has(Flag::Pc) {
            bench.tick();
            let now = bench.system("XY").motion_status & (cms::ACCEL_STATUS | cms::DECEL_STATUS);
            if shown.last() != Some(&now) {
                shown.push(now);
            }
        }
        let expected = [0, cms::ACCEL_STATUS, 0, cms::DECEL_STATUS, 0];
        assert_eq!(shown, expected, "{count} chords, profile {profile}");
    }
}
