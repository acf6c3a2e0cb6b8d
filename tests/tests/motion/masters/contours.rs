//! Planned contours (`corner = "precise"`): Event Distance and Calculated Data, and contours that a master drives
//! (spec/coordinated-instructions.md §8, §9).

use arcline_instruction_set::Flag;
use arcline_instruction_set::predefined::coordinate_motion_status::COORDINATE_SYSTEM_LOCK_STATUS;
use arcline_tests::bench::{Bench, OK};
use arcline_tests::random::{Random, is_long, one_or_all};

/// Speed of the master that contours are planned for, master units/s.
const NOMINAL: f64 = 50.0;

/// The default machine with planned corners and room for eight moves; the encoder `E` is an update later where the tag
/// `Encoder` says. Its axes may be led faster than they could follow.
fn bench(limits: &str) -> Bench {
    let planned = format!("command_tolerance = 0.5\nqueue_depth = 8\ncorner = \"precise\"\n{limits}");
    let own = arcline_config::DEFAULT.replace("command_tolerance = 0.5", &planned);
    let own = own.replace(
        "type = \"servo\"",
        "type = \"servo\"\ncommand_limits = { enabled = false }",
    );
    Bench::with(&format!(
        "{own}\n[[axis]]\nname = \"E\"\ntype = \"feedback\"\nmax_speed = 1000.0\nmax_acceleration = 5000.0\n\
         feed = {{ tag = \"Encoder\", interval_ms = 1.0, timeout_ms = 50.0 }}\n\
         [[tag]]\nname = \"Encoder\"\ntype = \"LREAL\"\n"
    ))
}

#[track_caller]
fn execute(bench: &mut Bench, call: &str) {
    assert_eq!(bench.call(call), OK, "{call}");
}

/// 100 units/s with 2000 units/s² and a jerk; the same by the way of a master at the nominal speed.
fn dynamics(driven: bool) -> &'static str {
    if driven {
        "2, 4, 0.8, 4, 0.8, 4, 1, 0.32, 0.32, 4"
    } else {
        "100, 0, 2000, 0, 2000, 0, 1, 40000, 40000, 0"
    }
}

/// A line to a corner, rounded within a tolerance.
fn line(driven: bool, tag: &str, [x, y]: [f64; 2], ending: u8, data: &str) -> String {
    let (dynamics, lock) = (dynamics(driven), u8::from(driven));
    format!("MCLM(CS1, {tag}, 0, [{x}, {y}, 0], {dynamics}, {ending}, 0, 0, 2.0, 0, {lock}, [0, 10, 999], {data});")
}

/// Three sides of a rectangle.
fn three_sides(bench: &mut Bench, driven: bool) {
    for (tag, to, ending, data) in [
        ("M1", [60.0, 0.0], 6, "Of1data3"),
        ("M2", [60.0, 40.0], 6, "Of2data3"),
        ("M3", [0.0, 40.0], 1, "Of3data3"),
    ] {
        execute(bench, &line(driven, tag, to, ending, data));
    }
}

fn place(bench: &Bench) -> [f64; 2] {
    ["X", "Y"].map(|axis| bench.position(axis))
}

fn apart(one: [f64; 2], other: [f64; 2]) -> f64 {
    (one[0] - other[0]).hypot(one[1] - other[1])
}

/// Places at every tick from where the first move became active to the end of the last, and the ticks at which moves were
/// complete, from there on.
fn timed(bench: &mut Bench) -> (Vec<[f64; 2]>, Vec<usize>) {
    three_sides(bench, false);
    bench.until("M1", Flag::Ac);
    let begun = bench.events.iter().find(|(_, event)| event.set & Flag::Ac.mask() != 0);
    let begun = begun.expect("a move is active").1.tick;
    let mut places = vec![[0.0, 0.0]; (bench.now() - begun) as usize];
    places.push(place(bench));
    let mut complete = Vec::new();
    while !bench.control("M3").has(Flag::Pc) {
        bench.tick();
        places.push(place(bench));
        let ended = ["M1", "M2", "M3"]
            .iter()
            .filter(|tag| bench.control(tag).has(Flag::Pc))
            .count();
        complete.resize(ended, places.len() - 1);
    }
    (places, complete)
}

#[test]
fn events_lie_on_the_curve_that_is_travelled() {
    let mut bench = bench("");
    let (places, complete) = timed(&mut bench);
    let mut begun = 0.0;
    for (place, ended) in complete.iter().enumerate() {
        let data = bench.array(&format!("Of{}data3", place + 1));
        let [whole, ten, beyond] = [data[0], data[1], data[2]].map(|seconds| seconds * 1e3);
        let end = begun + whole;
        assert!(
            end <= *ended as f64 + 1e-6 && end > *ended as f64 - 1.0,
            "move {place}: {end} ms, complete at {ended}"
        );
        assert_eq!(beyond, 0.0, "before the move");
        // The distance to go from there on, by the positions at ticks.
        let from = (begun + ten).round() as usize;
        let left: f64 = places[from..=*ended]
            .windows(2)
            .map(|pair| apart(pair[0], pair[1]))
            .sum();
        assert!((left - 10.0).abs() < 0.2, "move {place}: {left}");
        begun = end;
    }
}

#[test]
fn a_contour_is_a_function_of_its_masters_way() {
    let (places, complete) = timed(&mut bench(""));
    let mut reference = bench("");
    timed(&mut reference);
    for case in 0..if is_long() { 8 } else { 2 } {
        let mut random = Random(3_000_000 + case);
        let mut bench = bench("");
        bench.write("Encoder", 0.0);
        execute(&mut bench, &format!("MDCC(CS1, E, D, Actual, {NOMINAL});"));
        three_sides(&mut bench, true);
        bench.until("M1", Flag::Ac);
        bench.run(3);
        assert_eq!(place(&bench), [0.0, 0.0], "its master stands");
        // A master unit is a fixed number of ticks of the timed one.
        let ticks = |way: f64| way / NOMINAL * 1e3;
        let (mut at, mut furthest) = (0_i64, 0_i64);
        while furthest < places.len() as i64 - 1 {
            at = match random.below(6) {
                0 => (at - random.below(80) as i64).max(0),
                1 => at,
                _ => at + 1 + random.below(60) as i64,
            };
            at = at.min(places.len() as i64 - 1);
            let again = at == furthest;
            furthest = furthest.max(at);
            bench.write("Encoder", at as f64 * NOMINAL * 1e-3);
            bench.tick();
            let (is, expected) = (place(&bench), places[furthest as usize]);
            assert!(
                apart(is, expected) < 1e-9,
                "case {case} at {furthest}: {is:?} is not {expected:?}"
            );
            let ended = ["M1", "M2", "M3"]
                .iter()
                .filter(|tag| bench.control(tag).has(Flag::Pc))
                .count();
            let expected = complete.iter().filter(|&&end| end as i64 <= furthest).count();
            assert_eq!(ended, expected, "case {case} at {furthest}");
            let locked = bench.system("CS1").motion_status & COORDINATE_SYSTEM_LOCK_STATUS != 0;
            // Back where it turned it is followed only when it goes on.
            let expected = at == furthest && ended < 3;
            assert!(again || locked == expected, "case {case} at {at} of {furthest}");
        }
        for array in ["Of1data3", "Of2data3", "Of3data3"] {
            for (way, seconds) in bench.array(array).iter().zip(reference.array(array)) {
                assert!(
                    (ticks(*way) - 1e3 * seconds).abs() < 1e-6,
                    "{array}: {way} and {seconds} s"
                );
            }
        }
        assert_eq!(bench.bits("D"), "EN DN IP");
    }
}

#[test]
fn a_driven_contour_is_stopped_on_its_path_by_time_however_fast_its_master_is() {
    for speed in one_or_all(&[20.0, 50.0, 200.0], 2).iter().copied() {
        let (places, _) = timed(&mut bench(""));
        let mut bench = bench("");
        execute(&mut bench, &format!("MDCC(CS1, A, D, Command, {NOMINAL});"));
        three_sides(&mut bench, true);
        execute(
            &mut bench,
            &format!("MAJ(A, J, 0, {speed}, 0, 9000, 0, 9000, 0, 0, 100, 100, 2, Disabled, Programmed);"),
        );
        while bench.position("X") < 30.0 {
            bench.tick();
        }
        let velocity = bench.axis("X").command[1];
        assert!((velocity / speed - 2.0).abs() < 0.01, "{velocity} at {speed}");
        execute(&mut bench, "MCS(CS1, S, CoordinatedMove, Yes, 4000, 0, No, 0, 0);");
        assert_eq!(bench.bits("M1"), "EN DN");
        let mut before = velocity;
        while !bench.control("S").has(Flag::Pc) {
            bench.tick();
            let near = places.windows(2).map(|pair| {
                let [is, from, to] = [place(&bench), pair[0], pair[1]];
                apart(is, from) + apart(is, to) - apart(from, to)
            });
            assert!(
                near.fold(f64::INFINITY, f64::min) < 1e-3,
                "on its path: {:?}",
                place(&bench)
            );
            let now = bench.axis("X").command[1].hypot(bench.axis("Y").command[1]);
            assert!(now <= before * 1.001 + 1e-6, "it slows down: {before} to {now}");
            before = now;
        }
        let at = place(&bench);
        bench.run(50);
        assert_eq!(place(&bench), at, "it stands");
        assert_eq!(bench.bits("D"), "EN DN IP");
    }
}

#[test]
fn modes_do_not_go_over_into_each_other_on_contours() {
    for (ending, second, err) in [(1, "EN DN PC CalculatedDataAvailable", 0), (6, "EN DN ER", 105)] {
        let mut bench = bench("");
        execute(&mut bench, &format!("MDCC(CS1, A, D, Command, {NOMINAL});"));
        execute(
            &mut bench,
            "MAJ(A, J, 0, 50, 0, 9000, 0, 9000, 0, 0, 100, 100, 2, Disabled, Programmed);",
        );
        execute(&mut bench, &line(false, "M1", [60.0, 0.0], ending, "Of1data3"));
        execute(&mut bench, &line(true, "M2", [60.0, 40.0], 1, "Of2data3"));
        bench.run(2500);
        assert_eq!(bench.bits("M1"), "EN DN PC CalculatedDataAvailable", "{ending}");
        assert_eq!(
            (bench.bits("M2").as_str(), bench.control("M2").err),
            (second, err),
            "{ending}"
        );
        assert_eq!(
            place(&bench),
            if err == 0 { [60.0, 40.0] } else { [60.0, 0.0] },
            "{ending}"
        );
        // A link that is gone when its contour is to begin.
        execute(&mut bench, &line(false, "M1", [0.0, 0.0], 1, "Of1data3"));
        execute(&mut bench, &line(true, "M2", [60.0, 40.0], 1, "Of2data3"));
        execute(&mut bench, &line(false, "M3", [5.0, 0.0], 1, "Of3data3"));
        execute(&mut bench, "MASD(A, T);");
        bench.run(2500);
        assert_eq!(
            (bench.bits("M2").as_str(), bench.control("M2").err),
            ("EN DN ER", 93),
            "{ending}"
        );
        assert_eq!(bench.bits("M3"), "EN DN", "{ending}: it would begin elsewhere");
        assert_eq!(place(&bench), [0.0, 0.0], "{ending}");
    }
}

#[test]
fn limits_of_axes_are_not_a_masters_to_keep() {
    let mut bench = bench("axis_limits = \"enforce\"\n");
    execute(&mut bench, "MDCC(CS1, A, D, Command, 50);");
    assert_eq!(bench.call(&line(true, "M1", [60.0, 0.0], 1, "Of1data3")), (99, 0));
    let (_, complete) = timed(&mut bench);
    let whole: f64 = (1..=3).map(|place| bench.array(&format!("Of{place}data3"))[0]).sum();
    assert!(
        (whole * 1e3 - complete[2] as f64).abs() <= 1.0,
        "events in time: {whole}"
    );
}

#[test]
fn each_move_of_a_driven_contour_shows_its_master_and_the_positions_that_it_began_at() {
    let mut bench = bench("");
    execute(&mut bench, &format!("MDCC(CS1, A, D, Command, {NOMINAL});"));
    three_sides(&mut bench, true);
    execute(
        &mut bench,
        "MAJ(A, J, 0, 50, 0, 9000, 0, 9000, 0, 0, 100, 100, 2, Disabled, Programmed);",
    );
    for (tag, began) in [("M1", [0.0, 0.0]), ("M2", [60.0, 0.0]), ("M3", [60.0, 40.0])] {
        bench.until(tag, Flag::Ac);
        bench.until(tag, Flag::TrackingMaster);
        let shown = ["X", "Y"].map(|axis| bench.axis(axis).started_at[0]);
        assert!(apart(shown, began) < 4.0, "{tag} began at {shown:?}");
    }
    bench.until("M3", Flag::Pc);
    assert_eq!(place(&bench), [0.0, 40.0]);
}
