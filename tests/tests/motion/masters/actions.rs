//! The effect of actions on a slave or its master on the links and on the driven motion, row by row
//! (spec/coordinated-instructions.md §8.9; spec/axis-and-data-types.md §3.8).

use arcline_instruction_set::{FaultKind, Flag};
use arcline_tests::bench::{Bench, OK};

/// The longest time until all stopped motion stands, ticks.
const SETTLED: u64 = 600;

/// The default machine, with a coordinate system `M` of the servo S alone, which can be a master of CS1, and with the action of an axis's
/// faults.
fn bench(action: &str) -> Bench {
    let faulting = |text: &str, axis: &str| {
        let head = format!("[[axis]]\nname = \"{axis}\"\n");
        assert!(text.contains(&head));
        text.replace(
            &head,
            &format!("{head}exception_actions = {{ drive = \"{action}\" }}\n"),
        )
    };
    let mut text = ["X", "S"]
        .into_iter()
        .fold(arcline_config::DEFAULT.to_owned(), |text, axis| faulting(&text, axis));
    text += "[[coordinate_system]]\nname = \"M\"\ntype = \"cartesian\"\naxes = [\"S\"]\nmax_speed = 500.0\n\
             max_acceleration = 5000.0\nmax_deceleration = 5000.0\nactual_tolerance = 0.01\ncommand_tolerance = 0.5\n";
    Bench::with(&text)
}

#[track_caller]
fn execute(bench: &mut Bench, call: &str) {
    assert_eq!(bench.call(call), OK, "{call}");
}

/// CS1 is driven by S and linked to A besides, Z jogs, and X is linked to B for moves.
fn driven(action: &str) -> Bench {
    let mut bench = bench(action);
    execute(&mut bench, "MDCC(CS1, S, D1, Command, 0);");
    execute(&mut bench, "MDAC(X, B, D3, Move, Command);");
    execute(
        &mut bench,
        "MAJ(S, J1, Forward, 50, 0, 10000, 0, 10000, 0, 0, 100, 100, 2, Disabled, Programmed);",
    );
    execute(
        &mut bench,
        "MAJ(Z, J2, Forward, 5, 0, 10000, 0, 10000, 0, 0, 100, 100, 2, Disabled, Programmed);",
    );
    bench.run(20);
    execute(
        &mut bench,
        "MCLM(CS1, M1, 0, [900, 900, 0], 2, 4, 1, 4, 1, 4, 0, 100, 100, 6, 1, Disabled, Programmed, 0, 0, ImmediateForwardOnly, 0, 0);",
    );
    execute(&mut bench, "MDCC(CS1, A, D2, Command, 0);");
    bench.run(200);
    assert_eq!(bench.bits("D1"), "EN DN IP AC");
    assert_eq!(bench.bits("D2"), "EN DN IP");
    assert_eq!(bench.bits("D3"), "EN DN IP");
    assert_eq!(bench.bits("M1"), "EN DN IP AC TrackingMaster");
    bench
}

/// An action on the machine.
#[derive(Clone, Copy, Debug)]
enum Action {
    Call(&'static str),
    Fault { axis: &'static str, action: &'static str },
}

/// The remaining links and the move when all axes stand.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Left {
    /// IP of the active and of the waiting MDCC, and of the MDAC of a slave's axis.
    links: [bool; 3],
    /// AC of the active MDCC, and the move goes on.
    active: bool,
}

const ALL: Left = Left {
    links: [true; 3],
    active: true,
};
const LINKS: Left = Left {
    links: [true; 3],
    active: false,
};
const NONE: Left = Left {
    links: [false; 3],
    active: false,
};
/// The links of the master's slaves, and others of these slaves.
const MDAC_TOO: Left = NONE;

#[test]
fn the_action_table() {
    use Action::{Call, Fault};
    #[rustfmt::skip]
    let rows = [
        // action                                                  on the slave,                                             left
        ("MGS",                        Call("MGS(Motion, T, FastStop);"),                                 NONE),
        ("MGSD",                       Call("MGSD(Motion, T);"),                                          NONE),
        ("MCS Coordinated Move",       Call("MCS(CS1, T, CoordinatedMove, No, 0, 0, No, 0, 0);"),         LINKS),
        ("MCS Coordinated Transform",  Call("MCS(CS1, T, CoordinatedTransform, No, 0, 0, No, 0, 0);"),    ALL),
        ("MCS All",                    Call("MCS(CS1, T, All, No, 0, 0, No, 0, 0);"),                     NONE),
        ("MCSD",                       Call("MCSD(CS1, T);"),                                             NONE),
        ("MAS Jog",                    Call("MAS(Z, T, Jog, No, 0, 0, No, 0, 0);"),                       ALL),
        ("MAS Move",                   Call("MAS(X, T, Move, No, 0, 0, No, 0, 0);"),                      ALL),
        ("MAS Time Cam",               Call("MAS(X, T, TimeCam, No, 0, 0, No, 0, 0);"),                   ALL),
        ("MAS All",                    Call("MAS(X, T, All, No, 0, 0, No, 0, 0);"),                       NONE),
        ("MASD",                       Call("MASD(X, T);"),                                               NONE),
        ("MSF",                        Call("MSF(X, T);"),                                                LINKS),
        ("status only",                Fault { axis: "X", action: "fault_status_only" },                  ALL),
        ("stop motion",                Fault { axis: "X", action: "stop_planner" },                       NONE),
        ("disable drive",              Fault { axis: "X", action: "stop_drive" },                         NONE),
        ("shutdown",                   Fault { axis: "X", action: "shutdown" },                           NONE),
        // on the master
        ("MCSD of the master",         Call("MCSD(M, T);"),                                               MDAC_TOO),
        ("MASD of the master",         Call("MASD(S, T);"),                                               MDAC_TOO),
        ("shutdown of the master",     Fault { axis: "S", action: "shutdown" },                           MDAC_TOO),
        ("MCS Coordinated Move of the master", Call("MCS(M, T, CoordinatedMove, No, 0, 0, No, 0, 0);"),   ALL),
        ("MCS All of the master",      Call("MCS(M, T, All, No, 0, 0, No, 0, 0);"),                       ALL),
        ("MAS Jog of the master",      Call("MAS(S, T, Jog, No, 0, 0, No, 0, 0);"),                       ALL),
        ("MAS All of the master",      Call("MAS(S, T, All, No, 0, 0, No, 0, 0);"),                       ALL),
        ("MSF of the master",          Call("MSF(S, T);"),                                                ALL),
        ("status only of the master",  Fault { axis: "S", action: "fault_status_only" },                  ALL),
        ("stop motion of the master",  Fault { axis: "S", action: "stop_planner" },                       ALL),
        ("disable drive of the master", Fault { axis: "S", action: "stop_drive" },                        ALL),
        // of the waiting master
        ("MASD of the waiting master", Call("MASD(A, T);"),                                               NONE),
        ("MAS All of the waiting master", Call("MAS(A, T, All, No, 0, 0, No, 0, 0);"),                    ALL),
    ];
    for (why, action, expected) in rows {
        let mut bench = match action {
            Call(_) => driven("ignore"),
            Fault { action, .. } => driven(action),
        };
        match action {
            Call(call) => execute(&mut bench, call),
            Fault { axis, .. } => bench.inject(axis, &[FaultKind::Drive]),
        }
        bench.run(SETTLED);
        let ip = |tag: &str| bench.control(tag).has(Flag::Ip);
        let left = Left {
            links: ["D1", "D2", "D3"].map(ip),
            active: bench.control("D1").has(Flag::Ac),
        };
        assert_eq!(left, expected, "{why}");
        assert_eq!(bench.control("M1").has(Flag::Ac), expected.active, "{why}: the move");
        assert!(!bench.control("M1").has(Flag::Pc), "{why}: it did not come to its end");
        if !expected.active {
            let [_, velocity, _] = bench.axis("Y").command;
            assert_eq!(velocity, 0.0, "{why}: the slave stands");
        }
    }
}

#[test]
fn a_stopped_move_is_shown_by_its_link_until_it_stands() {
    // The MCS seed: AC of the MDCC is reset when the axis is stopped, IP at once by a stop of all.
    for (stop, during, after, least) in [
        ("CoordinatedMove", "EN DN IP AC", "EN DN IP", 150),
        ("All", "EN DN AC", "EN DN", 5),
    ] {
        let mut bench = driven("ignore");
        let call = format!("MCS(CS1, T, {stop}, Yes, 500, 0, No, 0, 0);");
        execute(&mut bench, &call);
        bench.tick();
        assert_eq!(bench.bits("M1"), "EN DN", "{stop}");
        let mut ticks = 0;
        while !bench.control("T").has(Flag::Pc) {
            assert_eq!(bench.bits("D1"), during, "{stop}");
            bench.tick();
            ticks += 1;
        }
        // From 100 units/s, at 500 units/s² along the path; a stop of all is at the axes' own maxima.
        assert!(ticks > least, "{stop}: {ticks}");
        assert_eq!(bench.bits("D1"), after, "{stop}");
    }
}

#[test]
fn breaking_one_link_of_a_slave_breaks_all_and_so_for_all_slaves_of_a_master() {
    // X has two kinds of links, CS1 and CS2 both have X; A is master of CS1 and of C.
    for (why, call, left) in [
        ("of the slave", "MASD(X, T);", [false, false, false, false, true]),
        ("of the master", "MASD(A, T);", [false, false, false, false, false]),
        (
            "of another axis of a slave",
            "MASD(Y, T);",
            [false, false, true, true, true],
        ),
    ] {
        let mut bench = bench("ignore");
        for call in [
            "MDCC(CS1, A, D1, Command, 0);",
            "MDCC(CS2, B, D2, Command, 0);",
            "MDAC(X, B, D3, Move, Command);",
            "MDAC(X, B, D4, Jog, Command);",
            "MDAC(C, A, D5, All, Command);",
        ] {
            execute(&mut bench, call);
        }
        execute(&mut bench, call);
        bench.run(2);
        assert_eq!(
            ["D1", "D2", "D3", "D4", "D5"].map(|tag| bench.control(tag).has(Flag::Ip)),
            left,
            "{why}"
        );
    }
}
