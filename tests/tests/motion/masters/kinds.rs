//! Masters of coordinated moves that are not virtual, linear axes: encoders that are fed from tags, and rotary axes
//! (spec/coordinated-instructions.md §8.2, §8.5, §18.2).

use arcline_instruction_set::Flag;
use arcline_instruction_set::predefined::axis_fault;
use arcline_tests::bench::{Bench, OK};
use arcline_tests::follow::without_command_limits;

use super::axes::planned;

/// The machine for gears, with an encoder `E` that is written every 8 ms.
fn bench() -> Bench {
    Bench::with(&format!(
        "{}[[axis]]\nname = \"E\"\ntype = \"feedback\"\nmax_speed = 1000.0\nmax_acceleration = 5000.0\n\
         feed = {{ tag = \"Encoder\", interval_ms = 8.0, timeout_ms = 50.0 }}\n\
         [[tag]]\nname = \"Encoder\"\ntype = \"LREAL\"\n",
        without_command_limits(1.0)
    ))
}

/// A line of 100 units, 52 of its master.
fn line(lock: &str) -> String {
    format!("MCLM(L1, M1, 0, [100, 0, 0], 2, 4, 1, 4, 1, 4, 0, 100, 100, 6, 1, 0, 0, 0, {lock}, 0, 0);")
}

#[track_caller]
fn execute(bench: &mut Bench, call: &str) {
    assert_eq!(bench.call(call), OK, "{call}");
}

#[track_caller]
fn stands_at(bench: &Bench, way: f64, why: &str) {
    let [expected, ..] = planned(way);
    let is = bench.position("A1");
    assert!((is - expected).abs() < 1e-9, "{why}: {is} is not {expected}");
}

#[test]
fn an_encoder_that_is_not_written_leaves_its_slave_where_it_is() {
    // An encoder has an actual position only; either reference means that.
    for reference in ["Actual", "Command"] {
        let mut bench = bench();
        bench.write("Encoder", 100.0);
        execute(&mut bench, &format!("MDCC(L1, E, D, {reference}, 0);"));
        execute(&mut bench, &line("0, 1"));
        bench.run(8);
        let go = |bench: &mut Bench, from: f64, to: f64, before: f64| {
            bench.write("Encoder", to);
            for tick in 1..=8 {
                bench.tick();
                let share = f64::from(tick) / 8.0;
                stands_at(bench, before + share * (to - from), "between two positions");
            }
        };
        go(&mut bench, 100.0, 104.0, 0.0);
        go(&mut bench, 104.0, 110.0, 4.0);
        go(&mut bench, 110.0, 126.0, 10.0);
        bench.run(60);
        assert_eq!(bench.axis("E").fault, axis_fault::PHYSICAL_AXIS_FAULT);
        stands_at(&bench, 26.0, "stale");
        assert_eq!(
            (bench.bits("M1").as_str(), bench.bits("D").as_str()),
            ("EN DN IP AC TrackingMaster", "EN DN IP AC")
        );
        // The axis does not make up for the missed displacement.
        bench.write("Encoder", 900.0);
        execute(&mut bench, "MAFR(E, F);");
        bench.run(10);
        assert_eq!(bench.axis("E").fault, 0);
        stands_at(&bench, 26.0, "placed anew");
        go(&mut bench, 900.0, 910.0, 26.0);
        go(&mut bench, 910.0, 926.0, 36.0);
        assert_eq!(bench.bits("M1"), "EN DN PC");
    }
}

#[test]
fn a_rotary_master_comes_to_its_lock_position_once_a_turn() {
    #[rustfmt::skip]
    let cases = [
        // why,                         lock,     the master goes by, the way then
        ("on the next turn",            "10, 3",  80.0,               10.0),
        ("not yet",                     "10, 3",  70.0,               0.0),
        ("not the other way",           "10, 3",  -320.0,             0.0),
        ("in reverse",                  "280, 4", -30.0,              10.0),
        ("in reverse on the next turn", "310, 4", -370.0,             20.0),
        ("on this turn",                "310, 3", 30.0,               20.0),
    ];
    let dynamics = "500, 0, 5000, 0, 4000, 0, 0, 100, 100, 2";
    for (why, lock, by, way) in cases {
        let mut bench = bench();
        execute(&mut bench, "MDCC(L1, TURN, D, Command, 0);");
        execute(&mut bench, &format!("MAM(TURN, G, 1, 300, {dynamics});"));
        bench.until("G", Flag::Pc);
        for beyond in ["360, 3", "-1, 4"] {
            assert_eq!(bench.call(&line(beyond)), (13, 18), "{beyond}");
        }
        execute(&mut bench, &line(lock));
        execute(&mut bench, &format!("MAM(TURN, G, 1, {by}, {dynamics});"));
        bench.until("G", Flag::Pc);
        stands_at(&bench, way, why);
        assert!(bench.control("M1").has(Flag::Ac), "{why}");
    }
}

#[test]
fn a_link_asks_nothing_of_its_slave_or_its_master() {
    let mut bench = bench();
    execute(&mut bench, "MSF(P, S);");
    bench.run(2);
    execute(&mut bench, "MDCC(SERVO, A1, D1, Command, 0);");
    assert_eq!(bench.bits("D1"), "EN DN IP", "a slave without torque");
    execute(&mut bench, "MDCC(L2, P, D2, Actual, 0);");
    assert_eq!(bench.bits("D2"), "EN DN IP", "a master without torque");
}
