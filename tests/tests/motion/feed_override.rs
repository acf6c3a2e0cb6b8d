//! The feed override of a coordinate system: speed without a step, never off the path, hold and resume.

use arcline_instruction_set::Flag;
use arcline_tests::bench::{Bench, OK};
use arcline_tests::random::seeds;

const PERIOD: f64 = 0.001;
/// Programmed dynamics of every move here: units/s, units/s², units/s³.
const SPEED: f64 = 100.0;
const RATE: f64 = 1000.0;
const JERK: f64 = 20_000.0;

/// XY with a queue of 20.
fn deep() -> Bench {
    Bench::replacing("name = \"XY\"", "name = \"XY\"\nqueue_depth = 20")
}

/// XY with precise corners and a queue of 20.
fn precise() -> Bench {
    Bench::replacing("name = \"XY\"", "name = \"XY\"\nqueue_depth = 20\ncorner = \"precise\"")
}

fn line(tag: &str, x: f64, y: f64, termination: &str) -> String {
    format!("MCLM(XY, {tag}, 0, [{x}, {y}], {SPEED}, 0, {RATE}, 0, {RATE}, 0, 1, {JERK}, {JERK}, 0, {termination})")
}

/// The half circle from (0, 0) over (50, 50) to (100, 0).
fn arc(tag: &str) -> String {
    format!("MCCM(XY, {tag}, 0, [100, 0], 0, [50, 50], 0, {SPEED}, 0, {RATE}, 0, {RATE}, 0, 1, {JERK}, {JERK}, 0, 1)")
}

fn state(bench: &Bench) -> [[f64; 3]; 2] {
    [bench.axis("X").command, bench.axis("Y").command]
}

/// Watches that nothing steps from tick to tick.
struct Watch {
    last: [[f64; 3]; 2],
    /// The greatest expected acceleration and jerk of an axis, with the part of the curvature.
    rate: f64,
    jerk: f64,
}

impl Watch {
    fn new(bench: &Bench, factor: f64) -> Self {
        Watch {
            last: state(bench),
            rate: factor * RATE,
            jerk: factor * JERK,
        }
    }

    fn tick(&mut self, bench: &mut Bench) -> (f64, f64) {
        bench.tick();
        let now = state(bench);
        for (before, after) in self.last.iter().zip(&now) {
            let acceleration = (after[1] - before[1]) / PERIOD;
            assert!(
                acceleration.abs() <= self.rate * 1.001,
                "tick {}: {acceleration}",
                bench.now()
            );
            let jerk = (after[2] - before[2]) / PERIOD;
            assert!(jerk.abs() <= self.jerk * 1.001, "tick {}: jerk {jerk}", bench.now());
            let moved = (after[0] - before[0]) - 0.5 * PERIOD * (before[1] + after[1]);
            assert!(
                moved.abs() <= self.jerk * PERIOD.powi(3),
                "tick {}: moved by {moved}",
                bench.now()
            );
        }
        self.last = now;
        (now[0][0], now[1][0])
    }
}

fn speed(bench: &Bench) -> f64 {
    let [x, y] = state(bench);
    x[1].hypot(y[1])
}

fn on_line(x: f64, y: f64) {
    assert!((y - 0.5 * x).abs() < 1e-9, "{x} {y}");
}

fn on_arc(x: f64, y: f64) {
    assert!(((x - 50.0).hypot(y) - 50.0).abs() < 1e-9, "{x} {y}");
    assert!(y > -1e-9, "{x} {y}");
}

/// Distance to the corner path (0, 0), (50, 0), (50, 50).
fn off_corner(x: f64, y: f64) -> f64 {
    let first = (x - x.clamp(0.0, 50.0)).hypot(y);
    let second = (x - 50.0).hypot(y - y.clamp(0.0, 50.0));
    first.min(second)
}

#[test]
fn it_scales_the_speed_of_active_pending_and_later_moves() {
    let mut bench = deep();
    bench.execute(&line("M1", 100.0, 50.0, "1"));
    bench.execute(&line("M2", 0.0, 0.0, "1"));
    assert_eq!(bench.system("XY").feed_override, 1.0);
    for (tag, share) in [("M1", 2.0), ("M2", 0.5)] {
        bench.set_override("XY", share);
        let mut watch = Watch::new(&bench, 1.0);
        let mut top = 0.0_f64;
        let from = bench.now();
        while !bench.control(tag).has(Flag::Pc) {
            let (x, y) = watch.tick(&mut bench);
            on_line(x, y);
            top = top.max(speed(&bench));
            assert!(bench.now() - from < 10_000);
        }
        assert!((top - share * SPEED).abs() < 1e-9, "{top}");
        assert_eq!(bench.system("XY").feed_override, share);
    }
    assert_eq!(bench.call(&line("M3", 100.0, 50.0, "1")), OK);
    bench.run(400);
    assert!((speed(&bench) - 0.5 * SPEED).abs() < 1e-9, "a later move has it too");
}

#[test]
fn a_hold_rests_on_the_path_and_goes_on_to_the_exact_end() {
    for (call, on_path, end) in [
        (line("M", 100.0, 50.0, "1"), on_line as fn(f64, f64), (100.0, 50.0)),
        (arc("M"), on_arc, (100.0, 0.0)),
    ] {
        // The arc's curvature adds to the acceleration of the axes.
        let factor = 2.0;
        for at in [1, 40, 120, 700, 1000] {
            let mut bench = Bench::new();
            assert_eq!(bench.call(&call), OK, "{call}");
            let mut watch = Watch::new(&bench, factor);
            for _ in 0..at {
                let (x, y) = watch.tick(&mut bench);
                on_path(x, y);
            }
            bench.set_override("XY", 0.0);
            for _ in 0..300 {
                let (x, y) = watch.tick(&mut bench);
                on_path(x, y);
            }
            assert_eq!(bench.bits("M"), "EN DN IP AC", "held at {at}");
            assert_eq!(speed(&bench), 0.0);
            let held = (bench.position("X"), bench.position("Y"));
            bench.run(1000);
            assert_eq!((bench.position("X"), bench.position("Y")), held);
            bench.set_override("XY", 1.0);
            while !bench.control("M").has(Flag::Pc) {
                let (x, y) = watch.tick(&mut bench);
                on_path(x, y);
                assert!(bench.now() < 20_000);
            }
            assert_eq!((bench.position("X"), bench.position("Y")), end, "held at {at}");
        }
    }
}

#[test]
fn a_move_begun_under_a_hold_waits_for_its_end() {
    let mut bench = Bench::new();
    bench.set_override("XY", 0.0);
    bench.execute(&line("M", 100.0, 50.0, "1"));
    bench.run(100);
    assert_eq!((bench.bits("M").as_str(), bench.position("X")), ("EN DN IP AC", 0.0));
    bench.set_override("XY", 1.0);
    bench.until("M", Flag::Pc);
    assert_eq!(bench.position("X"), 100.0);
}

#[test]
fn a_change_inside_a_blend_stays_within_its_tolerance() {
    for termination in ["2", "3", "6, 0, 0, 5"] {
        // No Decel rounds by the way that braking takes.
        let tolerance = if termination == "3" { 8.0 } else { 5.0 };
        for share in [0.0, 0.3, 2.0] {
            for delay in [1, 20, 40, 80] {
                let mut bench = deep();
                bench.execute(&line("M1", 50.0, 0.0, termination));
                bench.execute(&line("M2", 50.0, 50.0, "1"));
                let mut watch = Watch::new(&bench, 1.001);
                while !bench.control("M1").has(Flag::Pc) {
                    watch.tick(&mut bench);
                }
                for _ in 0..delay {
                    watch.tick(&mut bench);
                }
                bench.set_override("XY", share);
                for _ in 0..400 {
                    let (x, y) = watch.tick(&mut bench);
                    assert!(off_corner(x, y) <= tolerance, "{x} {y}");
                }
                bench.set_override("XY", 1.0);
                while !bench.control("M2").has(Flag::Pc) {
                    let (x, y) = watch.tick(&mut bench);
                    assert!(off_corner(x, y) <= tolerance, "{x} {y}");
                }
                assert_eq!((bench.position("X"), bench.position("Y")), (50.0, 50.0));
            }
        }
    }
}

#[test]
fn a_hold_too_late_for_the_end_of_a_move_brakes_on_along_the_next_ones() {
    // Tangent pieces, passed at full speed, some of them shorter than the way to stop.
    for dynamics in ["100", "90"] {
        for at in (300..900).step_by(37) {
            let mut bench = deep();
            for (place, x) in [20.0, 22.0, 24.0, 25.0, 26.0, 60.0, 62.0, 64.0, 100.0]
                .iter()
                .enumerate()
            {
                let speed = if place % 2 == 0 { "100" } else { dynamics };
                let call = format!(
                    "MCLM(XY, M{place}, 0, [{x}, {}], {speed}, 0, {RATE}, 0, {RATE}, 0, 1, {JERK}, {JERK}, 0, 4)",
                    0.5 * x
                );
                assert_eq!(bench.call(&call), OK);
            }
            let mut watch = Watch::new(&bench, 1.0);
            for _ in 0..at {
                let (x, y) = watch.tick(&mut bench);
                on_line(x, y);
            }
            bench.set_override("XY", 0.0);
            let mut last = 0.0;
            for _ in 0..300 {
                let (x, y) = watch.tick(&mut bench);
                on_line(x, y);
                assert!(x >= last - 1e-9, "it never goes back: {x} after {last}");
                last = x;
            }
            assert_eq!(speed(&bench), 0.0, "held at {at}");
            bench.set_override("XY", 1.0);
            while !bench.control("M8").has(Flag::Pc) {
                let (x, y) = watch.tick(&mut bench);
                on_line(x, y);
                assert!(x >= last - 1e-9, "it never goes back: {x} after {last}");
                last = x;
                assert!(bench.now() < 20_000, "held at {at}: {x}");
            }
            assert_eq!((bench.position("X"), bench.position("Y")), (100.0, 50.0));
        }
    }
}

#[test]
fn storms_of_overrides_stay_on_the_path_and_end_exactly() {
    let mut random = generator(7);
    for round in 0..40 {
        let mut bench = Bench::new();
        let (call, on_path, end) = match round % 2 {
            0 => (line("M", 100.0, 50.0, "1"), on_line as fn(f64, f64), (100.0, 50.0)),
            _ => (arc("M"), on_arc as fn(f64, f64), (100.0, 0.0)),
        };
        assert_eq!(bench.call(&call), OK);
        // An arc of radius 50 at twice the speed: 800 units/s² across it, and the part of its turning in the jerk.
        let mut watch = Watch::new(&bench, 2.0);
        while !bench.control("M").has(Flag::Pc) {
            if random() < 0.2 {
                let share = if random() < 0.2 { 0.0 } else { 2.0 * random() };
                bench.set_override("XY", share);
            }
            let (x, y) = watch.tick(&mut bench);
            on_path(x, y);
            assert!(bench.now() < 100_000, "round {round}");
        }
        assert_eq!((bench.position("X"), bench.position("Y")), end, "round {round}");
    }
}

#[test]
fn a_stop_is_not_held_and_a_change_of_dynamics_is_overridden() {
    let mut bench = Bench::new();
    bench.execute(&line("M", 100.0, 50.0, "1"));
    bench.set_override("XY", 0.5);
    bench.run(300);
    bench.execute("MCCD(XY, C, CoordinatedMove, Yes, 60, Unitspersec)");
    bench.run(200);
    assert!((speed(&bench) - 30.0).abs() < 1e-9, "{}", speed(&bench));
    bench.execute("MCS(XY, S, CoordinatedMove, Yes, 100, Unitspersec2)");
    bench.set_override("XY", 0.0);
    bench.until("S", Flag::Pc);
    assert_eq!(speed(&bench), 0.0);
    bench.execute(&line("N", 0.0, 0.0, "1"));
    bench.run(100);
    assert_eq!(
        (bench.bits("N").as_str(), speed(&bench)),
        ("EN DN IP AC", 0.0),
        "it was kept"
    );
    bench.set_override("XY", 1.0);
    bench.until("N", Flag::Pc);
}

/// Two sides of a square, rounded within 0.5.
fn contour(bench: &mut Bench) {
    assert_eq!(bench.call(&line("M1", 50.0, 0.0, "6, 0, 0, 0.5")), OK);
    assert_eq!(bench.call(&line("M2", 50.0, 50.0, "1")), OK);
}

#[test]
fn planned_contours_are_held_slowed_and_planned_faster() {
    let mut plain = precise();
    contour(&mut plain);
    let whole = plain.until("M2", Flag::Pc);

    for at in [1, 100, 300, 560, 700, 1000] {
        let mut bench = precise();
        contour(&mut bench);
        let mut watch = Watch::new(&bench, 1.6);
        for _ in 0..at {
            watch.tick(&mut bench);
        }
        bench.set_override("XY", 0.0);
        for _ in 0..500 {
            let (x, y) = watch.tick(&mut bench);
            assert!(off_corner(x, y) <= 0.5, "{x} {y}");
        }
        assert_eq!(speed(&bench), 0.0, "held at {at}");
        let shown = ["M1", "M2"].map(|tag| bench.bits(tag));
        assert!(shown.contains(&"EN DN IP AC".to_owned()), "held at {at}: {shown:?}");
        bench.set_override("XY", 1.0);
        while !bench.control("M2").has(Flag::Pc) {
            let (x, y) = watch.tick(&mut bench);
            assert!(off_corner(x, y) <= 0.5, "{x} {y}");
            assert!(bench.now() < 20_000);
        }
        assert_eq!((bench.position("X"), bench.position("Y")), (50.0, 50.0));
    }

    // The legs take long enough to be planned with all of their speed: the pace is half of it.
    for (share, least, most) in [(0.5, 1.95, 2.05), (2.0, 0.5, 0.85)] {
        let mut bench = precise();
        bench.set_override("XY", share);
        contour(&mut bench);
        let mut top = 0.0_f64;
        let from = bench.now();
        while !bench.control("M2").has(Flag::Pc) {
            bench.tick();
            top = top.max(speed(&bench));
        }
        let ticks = (bench.now() - from) as f64 / whole as f64;
        assert!(least < ticks && ticks < most, "at {share}: {ticks} of the time");
        assert!(
            top <= share * SPEED * 1.001 && top > 0.97 * share * SPEED,
            "at {share}: {top}"
        );
    }
}

#[test]
fn an_override_rises_again_on_a_long_move_of_a_contour() {
    let mut bench = precise();
    bench.set_override("XY", 0.5);
    assert_eq!(
        bench.call("MCLM(XY, L, 0, [400, 0], 100, 0, 2000, 0, 2000, 0, 1, 20000, 20000, 0, 1)"),
        OK
    );
    for (share, ticks) in [(0.5, 700), (0.25, 700), (1.0, 700), (0.7, 700)] {
        bench.set_override("XY", share);
        bench.run(ticks);
        assert!(
            (speed(&bench) - 100.0 * share).abs() < 0.1,
            "{share}: {}",
            speed(&bench)
        );
    }
    bench.until_rest();
    assert_eq!((bench.position("X"), bench.position("Y")), (400.0, 0.0));
}

#[test]
fn a_change_of_the_speed_on_a_contour_pauses_it_and_makes_it_faster() {
    let mut bench = precise();
    contour(&mut bench);
    bench.run(200);
    assert_eq!(bench.call("MCCD(XY, C, CoordinatedMove, Yes, 50, Unitspersec)"), OK);
    bench.run(150);
    // A contour has its speed to some thousandths.
    assert!((speed(&bench) - 50.0).abs() < 0.1, "{}", speed(&bench));
    assert_eq!(bench.call("MCCD(XY, C2, CoordinatedMove, Yes, 0, Unitspersec)"), OK);
    bench.run(300);
    assert_eq!((bench.bits("M1").as_str(), speed(&bench)), ("EN DN IP AC", 0.0));
    assert_eq!(bench.call("MCCD(XY, C3, CoordinatedMove, Yes, 500, Unitspersec)"), OK);
    let mut top = 0.0_f64;
    while !bench.control("M2").has(Flag::Pc) {
        bench.tick();
        top = top.max(speed(&bench));
        assert!(off_corner(bench.position("X"), bench.position("Y")) <= 0.5);
    }
    // Planned anew, the active move is as fast as its way lets it be.
    assert!(top > 1.1 * SPEED && top <= 500.0, "{top}");
    assert_eq!((bench.position("X"), bench.position("Y")), (50.0, 50.0));
}

#[test]
fn a_short_move_that_is_faster_than_the_one_before_it_is_passed_at_speed() {
    let mut bench = deep();
    for (tag, x, speed) in [("M0", 20.0, 90), ("M1", 22.0, 100), ("M2", 60.0, 90)] {
        let call = format!(
            "MCLM(XY, {tag}, 0, [{x}, {}], {speed}, 0, {RATE}, 0, {RATE}, 0, 1, {JERK}, {JERK}, 0, 4)",
            0.5 * x
        );
        assert_eq!(bench.call(&call), OK);
    }
    bench.until("M0", Flag::Pc);
    while !bench.control("M1").has(Flag::Pc) {
        bench.tick();
        assert!(speed(&bench) > 89.0, "{}", speed(&bench));
    }
}

#[test]
fn a_held_move_can_be_stopped() {
    for mut bench in [Bench::new(), precise()] {
        bench.execute(&line("M", 100.0, 50.0, "1"));
        bench.run(300);
        bench.set_override("XY", 0.0);
        bench.run(300);
        bench.execute("MCS(XY, S, CoordinatedMove)");
        bench.run(2);
        assert_eq!(
            (bench.bits("S").as_str(), bench.bits("M").as_str()),
            ("EN DN PC", "EN DN")
        );
        bench.until_rest();
    }
}

/// A generator of its own, so that a seed means the same storm for ever.
fn generator(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed;
    move || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as f64 / (1_u64 << 31) as f64
    }
}

#[test]
fn storms_over_queues_of_every_junction_end_exactly_and_in_order() {
    for seed in seeds(50) {
        let mut random = generator(seed);
        let contours = seed % 4 == 1;
        let mut bench = if contours { precise() } else { deep() };
        let (mut x, mut y) = (0.0, 0.0);
        let mut calls = Vec::new();
        for place in 0..8 {
            // Straight on for the types that pass corners, anywhere for the others.
            let straight = random() < 0.5;
            if straight {
                let way = 1.0 + (20.0 * random()).round();
                (x, y) = (x + way, y);
            } else {
                (x, y) = (
                    (100.0 * random()).round() + 0.25 * f64::from(place),
                    (100.0 * random()).round(),
                );
            }
            let kinds = ["1", "2", "3", "6, 0, 0, 0.5"];
            let termination = kinds[((kinds.len() as f64) * random()) as usize % kinds.len()];
            let speed = 20.0 + (80.0 * random()).round();
            calls.push(format!(
                "MCLM(XY, M{place}, 0, [{x}, {y}], {speed}, 0, {RATE}, 0, {RATE}, 0, 1, {JERK}, {JERK}, 0, {termination})"
            ));
        }
        for call in &calls {
            assert_eq!(bench.call(call), OK, "seed {seed}: {call}");
        }
        let mut last = state(&bench);
        let mut order = Vec::new();
        while order.len() < calls.len() {
            if random() < 0.02 {
                let share = if random() < 0.3 { 0.0 } else { 2.0 * random() };
                bench.set_override("XY", share);
            }
            bench.tick();
            assert!(bench.now() < 200_000, "seed {seed}: {order:?} {calls:#?}");
            let now = state(&bench);
            for (before, after) in last.iter().zip(&now) {
                let acceleration = (after[1] - before[1]) / PERIOD;
                assert!(
                    acceleration.abs() <= 2.0 * RATE * 1.001,
                    "seed {seed}, tick {}: {acceleration} {calls:#?}",
                    bench.now()
                );
            }
            last = now;
            for place in 0..calls.len() {
                if !order.contains(&place) && bench.control(&format!("M{place}")).has(Flag::Pc) {
                    order.push(place);
                }
            }
        }
        assert!(order.is_sorted(), "seed {seed}: {order:?}");
        bench.set_override("XY", 1.0);
        bench.until_rest();
        assert_eq!((bench.position("X"), bench.position("Y")), (x, y), "seed {seed}");
    }
}

#[test]
fn storms_along_a_line_never_turn_back() {
    for seed in 0..40 {
        let mut random = generator(1000 + seed);
        let mut bench = deep();
        let mut x = 0.0;
        let mut calls = Vec::new();
        for place in 0..12 {
            x += 1.0 + (15.0 * random()).round();
            // Types that keep to the path; type 5 enters a move at a speed that it may not be able to stop from.
            let kinds = ["3", "4", "4"];
            let termination = kinds[((kinds.len() as f64) * random()) as usize % kinds.len()];
            let speed = 40.0 + 20.0 * (4.0 * random()).floor();
            calls.push(format!(
                "MCLM(XY, M{place}, 0, [{x}, {}], {speed}, 0, {RATE}, 0, {RATE}, 0, 1, {JERK}, {JERK}, 0, {termination})",
                0.5 * x
            ));
        }
        for call in &calls {
            assert_eq!(bench.call(call), OK, "seed {seed}: {call}");
        }
        let mut watch = Watch::new(&bench, 1.0);
        let mut last = 0.0;
        while !bench.control("M11").has(Flag::Pc) {
            if random() < 0.03 {
                let share = if random() < 0.4 { 0.0 } else { 2.0 * random() };
                bench.set_override("XY", share);
            }
            let (now, y) = watch.tick(&mut bench);
            on_line(now, y);
            assert!(
                now >= last - 1e-9,
                "seed {seed}, tick {}: {now} after {last} {calls:#?}",
                bench.now()
            );
            last = now;
            assert!(bench.now() < 100_000, "seed {seed}: {calls:#?}");
        }
        assert_eq!((bench.position("X"), bench.position("Y")), (x, 0.5 * x), "seed {seed}");
    }
}

#[test]
fn a_slower_move_behind_joined_ones_begins_where_they_end() {
    for (third, termination) in [(40, "4"), (40, "6, 0, 0, 0.5"), (100, "6, 0, 0, 0.5")] {
        let mut bench = deep();
        for (tag, x, speed, termination) in [
            ("M0", 20.0, 60, "4"),
            ("M1", 40.0, 60, termination),
            ("M2", 60.0, third, "1"),
        ] {
            let call = format!(
                "MCLM(XY, {tag}, 0, [{x}, {}], {speed}, 0, {RATE}, 0, {RATE}, 0, 1, {JERK}, {JERK}, 0, {termination})",
                0.5 * x
            );
            assert_eq!(bench.call(&call), OK);
        }
        let mut watch = Watch::new(&bench, 1.0);
        while !bench.control("M2").has(Flag::Pc) {
            let (x, y) = watch.tick(&mut bench);
            on_line(x, y);
        }
        assert_eq!(bench.position("X"), 60.0);
    }
}
