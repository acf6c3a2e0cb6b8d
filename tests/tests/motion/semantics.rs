//! The effects of instructions, tick by tick, as in spec/coordinated-instructions.md and axis-and-data-types.md.

use arcline_instruction_set::Flag;
use arcline_instruction_set::predefined::{
    axis_status, coordinate_motion_status as cms, coordinate_system_status as css, motion_status,
};
use arcline_tests::bench::{Bench, OK};

/// A move of 100 along X on CS1 that takes 0.6 s: v 200, a = d = 2000, S-curve in 100 % of time.
const MOVE: &str = "MCLM(CS1, M1, 0, [100, 0, 0], 200, 0, 2000, 0, 2000, 0, 1, 100, 100, 2, 1);";
/// The same to X = 100, Y = 100.
const NEXT: &str = "MCLM(CS1, M2, 0, [100, 100, 0], 200, 0, 2000, 0, 2000, 0, 1, 100, 100, 2, 1);";

#[test]
fn operands_out_of_range_in_faceplate_order() {
    #[rustfmt::skip]
    let cases = [
        // why,                           call,                                                            ERR, EXERR
        ("a plain move",                  "MCLM(CS1,M,0,[9,0,0], 50,0,500,0,500,0)",                        OK),
        ("trailing operands left out",    "MCLM(CS1,M,0,[9,0,0], 50,0,500,0,500,0,1,100,100,2)",            OK),
        ("values given as words",         "MCLM(CS1,M,Incremental,[9,0,0], 50,%ofMaximum,500,unitspersec2,500,Unitspersec²,S-curve,100,100,%ofTime,1,disabled,programmed)", OK),
        ("a longer array",                "MCLM(CS1,M,0,[9,0,0,7,7], 50,0,500,0,500,0)",                    OK),
        ("move type",                     "MCLM(CS1,M,2,[9,0,0], 50,0,500,0,500,0)",                        (13, 2)),
        ("position too short",            "MCLM(CS1,M,0,[9,0], 50,0,500,0,500,0)",                          (13, 3)),
        ("speed below zero",              "MCLM(CS1,M,0,[9,0,0], -1,0,500,0,500,0)",                        (13, 4)),
        ("reserved speed units",          "MCLM(CS1,M,0,[9,0,0], 50,2,500,0,500,0)",                        (13, 5)),
        ("speed in seconds",              "MCLM(CS1,M,0,[9,0,0], 50,3,500,0,500,0)",                        (13, 5)),
        ("no acceleration",               "MCLM(CS1,M,0,[9,0,0], 50,0,0,0,500,0)",                          (13, 6)),
        ("acceleration units",            "MCLM(CS1,M,0,[9,0,0], 50,0,500,7,500,0)",                        (13, 7)),
        ("deceleration below zero",       "MCLM(CS1,M,0,[9,0,0], 50,0,500,0,-500,0)",                       (13, 8)),
        ("deceleration units",            "MCLM(CS1,M,0,[9,0,0], 50,0,500,0,500,3)",                        (13, 9)),
        ("profile",                       "MCLM(CS1,M,0,[9,0,0], 50,0,500,0,500,0,2)",                      (13, 10)),
        ("S-curve without accel jerk",    "MCLM(CS1,M,0,[9,0,0], 50,0,500,0,500,0,1,0,100,2)",              (13, 11)),
        ("decel jerk above 100 % of time","MCLM(CS1,M,0,[9,0,0], 50,0,500,0,500,0,1,100,101,2)",            (13, 12)),
        ("trapezoid: any jerk",           "MCLM(CS1,M,0,[9,0,0], 50,0,500,0,500,0,0,-7,0,2)",               OK),
        ("jerk units",                    "MCLM(CS1,M,0,[9,0,0], 50,0,500,0,500,0,1,100,100,3)",            (13, 13)),
        ("termination type",              "MCLM(CS1,M,0,[9,0,0], 50,0,500,0,500,0,1,100,100,2,7)",          (13, 14)),
        ("merge",                         "MCLM(CS1,M,0,[9,0,0], 50,0,500,0,500,0,1,100,100,2,1,3)",        (13, 15)),
        ("merge speed",                   "MCLM(CS1,M,0,[9,0,0], 50,0,500,0,500,0,1,100,100,2,1,0,2)",      (13, 16)),
        ("tolerance with type 6",         "MCLM(CS1,M,0,[9,0,0], 50,0,500,0,500,0,1,100,100,2,6,0,0,-1)",   (13, 17)),
        ("lock direction",                "MCLM(CS1,M,0,[9,0,0], 50,0,500,0,500,0,1,100,100,2,1,0,0,0,0,5)",(13, 19)),
        ("the first of two",              "MCLM(CS1,M,0,[9,0,0], -1,0,-1,0,500,0)",                         (13, 4)),
        ("mixed modes",                   "MCLM(CS1,M,0,[9,0,0], 50,0,500,4,500,0,1,100,100,2)",            (94, 0)),
        ("jerk of the other mode",        "MCLM(CS1,M,0,[9,0,0], 50,0,500,0,500,0,1,100,100,6)",            (94, 0)),
        ("lock direction in time",        "MCLM(CS1,M,0,[9,0,0], 50,0,500,0,500,0,1,100,100,2,1,0,0,0,0,1)",(95, 0)),
        ("master driven, no lock",        "MCLM(CS1,M,0,[9,0,0], 50,4,500,4,500,4,1,100,100,6)",            (95, 0)),
        ("master driven, no link",        "MCLM(CS1,M,0,[9,0,0], 50,4,500,4,500,4,1,100,100,6,1,0,0,0,0,1)",(93, 0)),
        ("a circle in one plane",         "MCCM(XY,M,0,[0,20],1,[0,10],0, 50,0,500,0,500,0)",               OK),
        ("circle type",                   "MCCM(XY,M,0,[0,20],4,[0,10],0, 50,0,500,0,500,0)",               (13, 4)),
        ("centre too short",              "MCCM(XY,M,0,[0,20],1,[0],0, 50,0,500,0,500,0)",                  (13, 5)),
        ("radius as a number",            "MCCM(XY,M,0,[0,20],2,10,0, 50,0,500,0,500,0)",                   OK),
        ("direction",                     "MCCM(XY,M,0,[0,20],1,[0,10],4, 50,0,500,0,500,0)",               (13, 6)),
        ("circle: speed",                 "MCCM(XY,M,0,[0,20],1,[0,10],0, -50,0,500,0,500,0)",              (13, 7)),
        ("circle: acceleration",          "MCCM(XY,M,0,[0,20],1,[0,10],0, 50,0,-500,0,500,0)",              (13, 9)),
        ("circle: deceleration",          "MCCM(XY,M,0,[0,20],1,[0,10],0, 50,0,500,0,0,0)",                 (13, 11)),
        ("circle: termination type",      "MCCM(XY,M,0,[0,20],1,[0,10],0, 50,0,500,0,500,0,1,100,100,2,7)", (13, 17)),
        ("stop type",                     "MCS(CS1,M,1,0,0,0,0,0,0)",                                       (13, 2)),
        ("stop: change decel",            "MCS(CS1,M,0,2,0,0,0,0,0)",                                       (13, 3)),
        ("stop: decel rate",              "MCS(CS1,M,0,1,0,0,0,0,0)",                                       (13, 4)),
        ("stop: decel rate not used",     "MCS(CS1,M,0,0,-9,0,0,0,0)",                                      OK),
        ("stop: decel units",             "MCS(CS1,M,0,1,10,4,0,0,0)",                                      (13, 5)),
        ("stop: change decel jerk",       "MCS(CS1,M,0,0,0,0,2,0,0)",                                       (13, 6)),
        ("stop: jerk units",              "MCS(CS1,M,0,0,0,0,1,100,6)",                                     (13, 8)),
        ("nothing to change",             "MCCD(CS1,M,1,1,50,0,0,0,0,0,0,0,0,0,0,0,0,0)",                   (23, 0)),
        ("change: motion type",           "MCCD(CS1,M,0,1,50,0,0,0,0,0,0,0,0,0,0,0,0,0)",                   (13, 2)),
        ("change: speed",                 "MCCD(CS1,M,1,1,-5,0,0,0,0,0,0,0,0,0,0,0,0,0)",                   (13, 4)),
        ("change: speed not changed",     "MCCD(CS1,M,1,0,-5,0,0,0,0,0,0,0,0,0,0,0,0,0)",                   (23, 0)),
        ("change: accel",                 "MCCD(CS1,M,1,0,0,0,1,0,0,0,0,0,0,0,0,0,0,0)",                    (13, 7)),
        ("change: decel",                 "MCCD(CS1,M,1,0,0,0,0,0,0,1,0,0,0,0,0,0,0,0)",                    (13, 10)),
        ("change: scope",                 "MCCD(CS1,M,1,0,0,0,0,0,0,0,0,0,0,0,0,0,0,2)",                    (13, 17)),
    ];
    for (why, call, expected) in cases {
        assert_eq!(Bench::new().call(call), expected, "{why}: {call}");
    }
}

#[test]
fn single_axis_and_group_operands_out_of_range_are_refused() {
    #[rustfmt::skip]
    let cases = [
        ("MAM(X,M,0,10,-1,0,500,0,500,0)", (13, 4)),
        ("MAS(X,M,11)", (13, 2)),
        ("MGS(Motion,M,3)", (13, 2)),
        ("MDAC(X,Y,M,5,0)", (13, 3)),
        ("MDCC(CS1,A,M,0,-50)", (13, 4)),
    ];
    for (call, expected) in cases {
        assert_eq!(Bench::new().call(call), expected, "{call}");
    }
}

#[test]
fn moves_of_a_whole_number_of_updates_end_at_the_last_of_them() {
    // Trapezoids: way / speed + speed / rate.
    for (way, speed, rate, ticks) in [
        (20.0, 100.0, 1000.0, 300),
        (7.0, 10.0, 100.0, 800),
        (0.9, 3.0, 10.0, 600),
        (1.3, 1.0, 10.0, 1400),
        (0.07, 0.1, 1.0, 800),
    ] {
        let mut bench = Bench::new();
        bench.execute(&format!("MCLM(XY, M, 0, [0, {way}], {speed}, 0, {rate}, 0, {rate}, 0)"));
        bench.execute(&format!("MAM(Z, A, 0, {way}, {speed}, 0, {rate}, 0, {rate}, 0)"));
        assert_eq!(bench.until("M", Flag::Pc), ticks, "{way} at {speed}");
        assert!(bench.control("A").has(Flag::Pc), "{way} at {speed}");
        assert_eq!(
            (bench.axis("Y").command, bench.axis("Z").command),
            ([way, 0.0, 0.0], [way, 0.0, 0.0])
        );
    }
}

#[test]
fn a_single_move_from_edge_to_completion() {
    let mut bench = Bench::new();
    bench.run(5);
    bench.execute(MOVE);
    assert_eq!(bench.bits("M1"), "EN DN IP AC");
    assert_ne!(bench.system("CS1").status & css::MOTION_STATUS, 0);
    assert_ne!(bench.system("CS1").motion_status & cms::MOVE_STATUS, 0);
    assert_ne!(
        bench.axis("Z").motion_status & motion_status::COORDINATED_MOTION_STATUS,
        0
    );
    assert_eq!(
        bench.axis("S").motion_status & motion_status::COORDINATED_MOTION_STATUS,
        0
    );
    bench.tick();
    assert_eq!(bench.bits("M1"), "EN DN IP AC ACCEL");
    bench.run(204);
    assert_eq!(bench.bits("M1"), "EN DN IP AC", "0.205 s: the ramp of 0.2 s is over");
    assert_eq!(bench.axis("X").command[1], 200.0);
    bench.run(300);
    assert_eq!(
        bench.bits("M1"),
        "EN DN IP AC DECEL",
        "0.505 s: 0.5 s is where braking begins"
    );
    // 100 units at 200 units/s and two ramps of 0.2 s: 0.7 s.
    assert_eq!(bench.until("M1", Flag::Pc), 195);
    assert_eq!(bench.bits("M1"), "EN DN PC");
    assert_eq!(bench.axis("X").command, [100.0, 0.0, 0.0]);
    assert_eq!(bench.system("CS1").status & css::MOTION_STATUS, 0);
    bench.tick();
    assert_eq!(bench.axis("X").motion_status, motion_status::AXIS_HOMED_STATUS);
    let changes: Vec<_> = bench
        .events
        .iter()
        .map(|(_, event)| (event.tick, event.set, event.clear))
        .collect();
    let (en, dn, ip, ac, pc) = (
        Flag::En.mask(),
        Flag::Dn.mask(),
        Flag::Ip.mask(),
        Flag::Ac.mask(),
        Flag::Pc.mask(),
    );
    let (accel, decel) = (Flag::Accel.mask(), Flag::Decel.mask());
    assert_eq!(
        changes,
        [
            (5, en | dn | ip | ac | accel, 0),
            (205, 0, accel),
            (505, decel, 0),
            (705, pc, ip | ac | decel),
        ]
    );
}

#[test]
fn the_rung_and_the_enable_bit() {
    let mut bench = Bench::new();
    bench.execute(MOVE);
    bench.rung_false("M1");
    assert_eq!(
        bench.bits("M1"),
        "DN IP AC",
        "DN is set: a false rung clears EN, motion goes on"
    );
    bench.until("M1", Flag::Pc);
    assert_eq!(bench.bits("M1"), "DN PC");
    assert_eq!(bench.call("MCLM(CS1,M1,2,[9,0,0], 50,0,500,0,500,0)"), (13, 2));
    assert_eq!(bench.bits("M1"), "EN ER");
    bench.rung_false("M1");
    assert_eq!((bench.bits("M1"), bench.control("M1").err), ("ER".to_owned(), 13));

    bench.execute("MSF(X, F1)");
    bench.rung_false("F1");
    assert_eq!(bench.bits("F1"), "EN", "neither DN nor ER: EN stays");
    assert_eq!(bench.call("MSF(X, F1)"), (3, 0), "a new edge before DN or ER");
    bench.tick();
    assert_eq!(
        bench.bits("F1"),
        "EN ER",
        "the first execution no longer writes to the tag"
    );
}

#[test]
fn a_queued_move_takes_over_at_the_exact_end() {
    let mut bench = Bench::new();
    bench.execute(MOVE);
    bench.execute(NEXT);
    assert_eq!(
        (bench.bits("M1").as_str(), bench.bits("M2").as_str()),
        ("EN DN IP AC", "EN DN IP")
    );
    let pending = cms::MOVE_PENDING_STATUS | cms::MOVE_PENDING_QUEUE_FULL_STATUS;
    assert_eq!(bench.system("CS1").motion_status & pending, pending);
    assert_eq!(
        bench.call("MCLM(CS1, M3, 0, [0, 0, 0], 200, 0, 2000, 0, 2000, 0)"),
        (43, 0)
    );
    bench.until("M1", Flag::Pc);
    assert_eq!(bench.now(), 700);
    assert_eq!(
        (bench.bits("M1").as_str(), bench.bits("M2").as_str()),
        ("EN DN PC", "EN DN IP AC ACCEL")
    );
    assert_eq!(bench.system("CS1").motion_status & pending, 0);
    bench.until("M2", Flag::Pc);
    assert_eq!(
        (bench.now(), bench.position("X"), bench.position("Y")),
        (1400, 100.0, 100.0)
    );
}

#[test]
fn actual_tolerance_waits_for_the_axis() {
    let slow = "max_deceleration_jerk = 200000.0\ndrive = { position_bandwidth_hz = 5.0, velocity_feedforward = 0.0, \
                position_error_tolerance = 0 }";
    let config = arcline_config::DEFAULT.replace("max_deceleration_jerk = 200000.0", slow);
    let mut bench = Bench::with(&config.replace("type = \"virtual\"", "type = \"servo\""));
    bench.execute(&MOVE.replace("2, 1);", "2, 0);"));
    while bench.position("X") < 100.0 {
        bench.tick();
    }
    bench.tick();
    assert_eq!(bench.bits("M1"), "EN DN IP AC", "the command is there, the axis is not");
    bench.until("M1", Flag::Pc);
    let left = 100.0 - bench.axis("X").actual[0];
    assert!(left > 0.0 && left <= 0.01, "completed {left} before the end");
    assert_ne!(bench.system("CS1").motion_status & cms::ACTUAL_POS_TOLERANCE_STATUS, 0);
    let mut strict = Bench::replacing("actual_tolerance = 0.01", "actual_tolerance = 0.0");
    assert_eq!(strict.call(&MOVE.replace("2, 1);", "2, 0);")), (51, 0));
    assert_eq!(strict.call(MOVE), OK);
}

#[test]
fn a_move_of_no_length_completes_at_the_next_update() {
    let mut bench = Bench::new();
    bench.execute("MCLM(CS1, M1, 1, [0, 0, 0], 200, 0, 2000, 0, 2000, 0, 1, 100, 100, 2, 1)");
    assert_eq!(bench.bits("M1"), "EN DN IP AC");
    bench.tick();
    assert_eq!(bench.bits("M1"), "EN DN PC");
}

#[test]
fn speed_zero_waits_for_a_change_of_speed() {
    let mut bench = Bench::new();
    bench.execute(&MOVE.replace("200, 0", "0, 0"));
    bench.run(100);
    assert_eq!((bench.bits("M1").as_str(), bench.position("X")), ("EN DN IP AC", 0.0));
    assert_eq!(bench.call("MCCD(CS1, D1, CoordinatedMove, Yes, 200, 0, No)"), OK);
    assert_eq!(bench.bits("D1"), "EN DN");
    bench.until("M1", Flag::Pc);
    assert_eq!(bench.position("X"), 100.0);
}

#[test]
fn a_change_of_speed_pauses_and_resumes() {
    let mut bench = Bench::new();
    bench.execute(MOVE);
    bench.run(300);
    assert_eq!(bench.call("MCCD(CS1, D1, 1, 1, 0, 0)"), OK);
    bench.run(300);
    let paused = bench.position("X");
    assert_eq!(
        (bench.axis("X").command[1], bench.bits("M1").as_str()),
        (0.0, "EN DN IP AC")
    );
    bench.run(100);
    assert_eq!(bench.position("X"), paused);
    assert_eq!(bench.call("MCCD(CS1, D1, 1, 1, 100, 0)"), OK);
    bench.run(250);
    assert_eq!(bench.axis("X").command[1], 100.0);
    bench.until("M1", Flag::Pc);
    assert_eq!(bench.position("X"), 100.0);
}

#[test]
fn changing_dynamics_of_the_pending_move_too() {
    let mut bench = Bench::new();
    bench.execute(MOVE);
    bench.execute(NEXT);
    assert_eq!(
        bench.call("MCCD(CS1, D1, 1, Yes, 50, 0, No, 0, 0, No, 0, 0, No, 0, No, 0, 0, ActiveAndPendingMotion)"),
        OK
    );
    bench.until("M1", Flag::Pc);
    bench.run(1000);
    assert_eq!(bench.axis("Y").command[1], 50.0);
}

#[test]
fn a_stop_of_the_move_stays_on_the_path() {
    let mut bench = Bench::new();
    bench.execute(&MOVE.replace("[100, 0, 0]", "[60, 80, 0]"));
    bench.execute(NEXT);
    bench.run(300);
    bench.execute("MCS(CS1, S1, CoordinatedMove, Yes, 1000, 0, Yes, 100, %ofTime)");
    assert_eq!(
        (
            bench.bits("S1").as_str(),
            bench.bits("M1").as_str(),
            bench.bits("M2").as_str()
        ),
        ("EN DN IP", "EN DN", "EN DN")
    );
    let stopping = bench.system("CS1");
    assert_ne!(stopping.motion_status & cms::STOPPING_STATUS, 0);
    assert_eq!(
        stopping.motion_status & (cms::MOVE_STATUS | cms::MOVE_PENDING_STATUS),
        0
    );
    assert_eq!(
        bench.call("MCLM(CS1, M3, 0, [0, 0, 0], 200, 0, 2000, 0, 2000, 0)").0,
        78
    );
    let from = bench.position("X");
    let ticks = bench.until("S1", Flag::Pc);
    assert_eq!(
        ticks, 400,
        "200 units/s at 1000 units/s², 100 % of time: twice the trapezoid's 0.2 s"
    );
    assert_eq!(bench.bits("S1"), "EN DN PC");
    let (x, y) = (bench.position("X"), bench.position("Y"));
    assert!((x / 60.0 - y / 80.0).abs() < 1e-12, "{x}, {y} is on the line");
    let ramp = (x - from) / 0.6;
    assert!((ramp - 40.0).abs() < 1e-9, "the ramp is 40 units long, not {ramp}");
    assert_eq!(bench.system("CS1").status & css::MOTION_STATUS, 0);
    assert_eq!(bench.call(&MOVE.replace("M1", "M4")), OK);
}

#[test]
fn a_stop_of_all_brakes_every_axis_and_whole_moves_that_share_one() {
    let mut bench = Bench::new();
    bench.execute("MCLM(CS2, M1, 0, [100, 50, 25], 200, 0, 2000, 0, 2000, 0, 1, 100, 100, 2, 1)");
    bench.run(300);
    bench.execute("MCS(CS1, S1, All)");
    assert_eq!(
        (bench.bits("S1").as_str(), bench.bits("M1").as_str()),
        ("EN DN IP", "EN DN")
    );
    assert_ne!(bench.axis("S").motion_status & motion_status::STOPPING_STATUS, 0);
    assert_eq!(
        bench.call("MCLM(CS2, M2, 1, [1, 1, 1], 200, 0, 2000, 0, 2000, 0)"),
        (78, 0)
    );
    bench.until("S1", Flag::Pc);
    for axis in ["X", "Y", "Z", "S"] {
        assert_eq!(bench.axis(axis).command[1], 0.0);
        assert_eq!(
            bench.axis(axis).motion_status,
            motion_status::AXIS_HOMED_STATUS,
            "{axis}"
        );
    }
    assert_eq!(bench.call("MCLM(CS2, M2, 1, [1, 1, 1], 200, 0, 2000, 0, 2000, 0)"), OK);
}

#[test]
fn a_stop_supersedes_a_stop_and_an_idle_one_is_complete_at_the_next_update() {
    let mut bench = Bench::new();
    bench.execute("MCS(CS1, S1, All)");
    assert_eq!(bench.bits("S1"), "EN DN IP");
    bench.tick();
    assert_eq!(bench.bits("S1"), "EN DN PC");
    bench.execute(MOVE);
    bench.run(300);
    bench.execute("MCS(CS1, S1, 2)");
    bench.run(5);
    bench.execute("MCS(CS1, S2, 2, 1, 100, 0)");
    assert_eq!(
        (bench.bits("S1").as_str(), bench.bits("S2").as_str()),
        ("EN DN", "EN DN IP")
    );
    bench.until("S2", Flag::Pc);
}

#[test]
fn coordinate_systems_that_share_an_axis_exclude_each_other() {
    let mut bench = Bench::new();
    bench.execute(MOVE);
    assert_eq!(
        bench.call("MCLM(CS2, M2, 0, [1, 1, 1], 200, 0, 2000, 0, 2000, 0)"),
        (52, 0)
    );
    assert_eq!(bench.call("MCLM(CS3, M3, 0, [1, 1, 1], 200, 0, 2000, 0, 2000, 0)"), OK);
}

#[test]
fn servo_off_and_on() {
    let mut bench = Bench::new();
    let on = axis_status::SERVO_ACTION_STATUS | axis_status::DRIVE_ENABLE_STATUS;
    assert_eq!(bench.axis("Y").status & on, on);
    bench.execute("MSF(Y, F1)");
    assert_eq!(bench.bits("F1"), "EN");
    bench.tick();
    assert_eq!((bench.bits("F1").as_str(), bench.axis("Y").status & on), ("EN DN", 0));
    assert_eq!(bench.system("CS1").axes_servo_on, 0b101);
    assert_eq!(bench.call(MOVE), (5, 1));
    assert_eq!(bench.call("MCCD(CS1, D1, 1, 1, 50, 0)"), (5, 1));
    assert_eq!(bench.call("MCS(CS1, S1, 0)"), (5, 1));
    bench.execute("MSO(Y, O1)");
    assert_eq!(bench.bits("O1"), "EN");
    bench.tick();
    assert_eq!((bench.bits("O1").as_str(), bench.axis("Y").status & on), ("EN DN", on));
    assert_eq!(bench.call(MOVE), OK);
    assert_eq!(bench.call("MSO(A, O2)"), (8, 0), "a virtual axis has no drive");
    assert_eq!(bench.call("MSF(A, F2)"), (8, 0));
}

#[test]
fn servo_off_in_motion_ends_the_move_for_the_whole_system() {
    let mut bench = Bench::new();
    bench.execute(&MOVE.replace("[100, 0, 0]", "[60, 80, 0]"));
    bench.execute(NEXT);
    bench.run(300);
    bench.execute("MSF(Y, F1)");
    assert_eq!(
        (bench.bits("M1").as_str(), bench.bits("M2").as_str()),
        ("EN DN", "EN DN")
    );
    assert_ne!(bench.axis("X").motion_status & motion_status::STOPPING_STATUS, 0);
    assert_eq!(bench.call("MSO(Y, O1)"), (22, 0), "the axis coasts");
    bench.run(5000);
    assert_eq!((bench.axis("X").command[1], bench.axis("Y").actual[1]), (0.0, 0.0));
    assert_eq!(bench.call("MSO(Y, O1)"), OK);
    bench.tick();
    assert_eq!(bench.axis("Y").command[0], bench.axis("Y").actual[0]);
    assert_eq!(bench.call(MOVE), OK);
}

#[test]
fn shutdown_and_its_reset() {
    let mut bench = Bench::new();
    bench.execute(MOVE);
    bench.run(300);
    bench.execute("MASD(Y, D1)");
    assert_eq!(bench.bits("M1"), "EN DN");
    bench.tick();
    assert_eq!(bench.bits("D1"), "EN DN");
    assert_eq!(
        bench.axis("Y").status & axis_status::SHUTDOWN_STATUS,
        axis_status::SHUTDOWN_STATUS
    );
    assert_eq!(
        (bench.system("CS1").axes_shutdown, bench.system("CS1").status),
        (0b010, css::MOTION_STATUS),
        "X brakes"
    );
    bench.until_rest();
    bench.tick();
    assert_eq!(bench.system("CS1").status, 0);
    assert_eq!(bench.call(MOVE), (7, 1));
    assert_eq!(bench.call("MSO(Y, O1)"), (7, 0));
    bench.execute("MASR(Y, R1)");
    bench.tick();
    assert_eq!(bench.bits("R1"), "EN DN");
    assert_eq!(bench.call(MOVE), (5, 1), "ready, but the servo is off");
    bench.execute("MAFR(Y, R2)");
    bench.tick();
    assert_eq!(bench.bits("R2"), "EN DN");
    bench.execute("MSO(Y, O1)");
    bench.tick();
    assert_eq!(bench.call(MOVE), OK);

    bench.run(100);
    assert_eq!(bench.call("MCSD(CS1, D2)"), OK);
    assert_eq!(
        (bench.bits("D2").as_str(), bench.bits("M1").as_str()),
        ("EN DN", "EN DN")
    );
    assert_eq!(bench.axis("X").command[1], 0.0, "the command stops in the same update");
    assert_eq!(bench.system("CS1").status, css::SHUTDOWN_STATUS);
    bench.run(2000);
    assert_eq!(bench.call(MOVE), (7, 0));
    assert_eq!(bench.call("MCSR(CS1, R3)"), OK);
    assert_eq!(bench.system("CS1").status, css::READY_STATUS);
    assert_eq!(bench.call(MOVE), (5, 0));
    for axis in ["X", "Y", "Z"] {
        bench.execute(&format!("MSO({axis}, O{axis})"));
    }
    bench.tick();
    assert_eq!(bench.call(MOVE), OK);
}

#[test]
fn a_shut_down_virtual_axis_is_ready_after_its_reset() {
    let mut bench = Bench::new();
    bench.execute("MASD(A, D1)");
    bench.tick();
    assert_eq!(
        bench.call("MCLM(CS3, M1, 0, [1, 1, 1], 200, 0, 2000, 0, 2000, 0)"),
        (7, 0)
    );
    bench.execute("MASR(A, R1)");
    bench.tick();
    assert_eq!(bench.call("MCLM(CS3, M1, 0, [1, 1, 1], 200, 0, 2000, 0, 2000, 0)"), OK);
}

#[test]
fn everything_that_moves_must_be_stoppable() {
    for (from, to, call, expected) in [
        ("max_deceleration = 5000.0", "max_deceleration = 0.0", MOVE, (54, -1)),
        (
            "max_deceleration_jerk = 100000.0",
            "max_deceleration_jerk = 0.0",
            MOVE,
            (76, -1),
        ),
        ("max_deceleration = 10000.0", "max_deceleration = 0.0", MOVE, (54, 0)),
        (
            "max_deceleration_jerk = 200000.0",
            "max_deceleration_jerk = 0.0",
            MOVE,
            (76, 0),
        ),
        (
            "max_deceleration_jerk = 100000.0",
            "max_deceleration_jerk = 0.0",
            "MCLM(CS1,M,0,[9,0,0], 50,0,500,0,500,0)",
            OK,
        ),
    ] {
        assert_eq!(Bench::replacing(from, to).call(call), expected, "{to}: {call}");
    }
}

#[test]
fn a_tag_used_again_shows_the_new_execution_only() {
    let mut bench = Bench::new();
    bench.execute(MOVE);
    bench.run(10);
    bench.execute(&NEXT.replace("M2", "M1"));
    assert_eq!(bench.bits("M1"), "EN DN IP", "the second waits behind the first");
    bench.run(690);
    assert_eq!(
        bench.bits("M1"),
        "EN DN IP AC ACCEL",
        "the end of the first did not write PC"
    );
    bench.until("M1", Flag::Pc);
    assert_eq!(bench.position("Y"), 100.0);
    let detached: Vec<_> = bench.events.iter().filter(|(_, event)| !event.owner).collect();
    assert!(
        detached.iter().any(|(_, event)| event.set == Flag::Pc.mask()),
        "its instance still reports"
    );
}

#[test]
fn command_tolerance_status() {
    let mut bench = Bench::new();
    bench.execute(MOVE);
    bench.execute(NEXT);
    while bench.position("X") < 99.4 {
        bench.tick();
    }
    assert_eq!(bench.system("CS1").motion_status & cms::COMMAND_POS_TOLERANCE_STATUS, 0);
    while bench.position("X") < 99.6 {
        bench.tick();
    }
    assert_ne!(
        bench.system("CS1").motion_status & cms::COMMAND_POS_TOLERANCE_STATUS,
        0,
        "within 0.5 of the end"
    );
    bench.until("M1", Flag::Pc);
    assert_eq!(
        bench.system("CS1").motion_status & cms::COMMAND_POS_TOLERANCE_STATUS,
        0,
        "the next one has begun"
    );
    bench.until("M2", Flag::Pc);
    bench.run(10);
    assert_ne!(
        bench.system("CS1").motion_status & cms::COMMAND_POS_TOLERANCE_STATUS,
        0,
        "it stays after the last"
    );
}
