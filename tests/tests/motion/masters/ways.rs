//! Random sequences over random masters: where the slave is hangs on where its master is, and a sequence is complete where it
//! was calculated to be (spec/coordinated-instructions.md §8.1, §8.6, §8.10, §9).
//!
//! `ARCLINE_CASES` sets the number of sequences of each kind (8 by default; half as many over random masters).

use arcline_instruction_set::BlendedSequence;
use arcline_instruction_set::Flag;
use arcline_instruction_set::predefined::coordinate_motion_status::MOVE_PENDING_QUEUE_FULL_STATUS;
use arcline_tests::bench::{Bench, OK};
use arcline_tests::follow::without_command_limits;
use arcline_tests::random::Random;

/// The axes of the slave.
const SLAVE: [&str; 3] = ["A1", "B1", "C1"];
/// Update periods, ms.
const PERIODS: [f64; 3] = [0.25, 1.0, 4.0];
/// The greatest difference of the slave's values, units.
const SAME: f64 = 1e-9;

fn cases() -> u64 {
    let set = std::env::var("ARCLINE_CASES").ok();
    set.and_then(|text| text.parse().ok()).unwrap_or(8)
}

/// The machine for gears with queues of a depth, and `E`, which an update later is where the tag `Encoder` says.
fn bench(period: f64, depth: usize) -> Bench {
    let deep = format!("command_tolerance = 4.0\nqueue_depth = {depth}");
    let own = without_command_limits(period).replace("command_tolerance = 0.5", &deep);
    Bench::with(&format!(
        "{own}[[axis]]\nname = \"E\"\ntype = \"feedback\"\nmax_speed = 1000.0\nmax_acceleration = 5000.0\n\
         feed = {{ tag = \"Encoder\", interval_ms = {period:?}, timeout_ms = 50.0 }}\n\
         [[tag]]\nname = \"Encoder\"\ntype = \"LREAL\"\n"
    ))
}

/// A master driven move of `L1`.
#[derive(Clone, Debug)]
struct Programmed {
    tag: String,
    /// The tag of its Calculated Data: one element.
    data: String,
    call: String,
    /// Termination Type, and the greatest part of the move that a blend may take: the tolerance is at least its length.
    ending: u8,
    is_full: bool,
}

/// Lines and arcs from where `L1` is at the start. The first move is locked as `lock` says (position and direction), the others
/// at once.
fn sequence(random: &mut Random, endings: &[&[u8]], lock: (f64, u8)) -> Vec<Programmed> {
    let mut here = [0.0; 3];
    let mut moves = Vec::new();
    for (place, choices) in endings.iter().enumerate() {
        let (tag, data) = (format!("M{place}"), format!("Of{}1", char::from(b'a' + place as u8)));
        let point = |random: &mut Random| [0; 3].map(|_| random.between(-40.0, 40.0));
        let (end, via) = (point(random), point(random));
        let chord = |to: [f64; 3]| (0..3).map(|axis| (to[axis] - here[axis]).powi(2)).sum::<f64>().sqrt();
        let length = chord(end);
        let ending = *random.one_of(choices);
        let tolerance = if random.below(4) == 0 {
            1000.0
        } else {
            random.between(0.5, 20.0)
        };
        let rates = [0; 2].map(|_| random.between(0.2, 12.0));
        let (shape, jerk, units) = match random.below(3) {
            0 => ("0", "100, 100".to_owned(), "6"),
            1 => (
                "1",
                format!("{}, {}", random.between(1.0, 100.0), random.between(1.0, 100.0)),
                "6",
            ),
            _ => (
                "1",
                format!("{}, {}", random.between(0.2, 40.0), random.between(0.2, 40.0)),
                "4",
            ),
        };
        let (position, direction) = match (place, lock.1) {
            (0, _) => lock,
            (_, 1 | 3) => (0.0, 1),
            _ => (0.0, 2),
        };
        let dynamics = format!(
            "{}, 4, {}, 4, {}, 4, {shape}, {jerk}, {units}, {ending}, Disabled, Programmed, {tolerance}, {position}, {direction}, [0], {data}",
            random.between(0.3, 5.0),
            rates[0],
            rates[1],
        );
        let call = if random.below(3) == 0 && chord(via) > 5.0 && length > 5.0 {
            format!("MCCM(L1, {tag}, 0, {end:?}, 0, {via:?}, 0, {dynamics});")
        } else {
            format!("MCLM(L1, {tag}, 0, {end:?}, {dynamics});")
        };
        moves.push(Programmed {
            tag,
            data,
            call,
            ending,
            is_full: tolerance >= length,
        });
        here = end;
    }
    moves
}

/// Command positions of the slave's axes, and of one more.
fn positions(bench: &Bench, master: &str) -> ([f64; 3], f64) {
    let axes = bench.snapshot().axes;
    let command = |name: &str| {
        let place = bench.machine().axis(name).expect("the machine has the axis");
        axes[usize::from(place)].command[0]
    };
    (SLAVE.map(command), command(master))
}

#[track_caller]
fn execute(bench: &mut Bench, call: &str) {
    assert_eq!(bench.call(call), OK, "{call}");
}

fn jog(bench: &mut Bench, speed: f64, more: &str) {
    let direction = u8::from(speed < 0.0);
    let call = format!(
        "MAJ(A2, J, {direction}, {}, 0, 2000, 0, 2000, 0, {more}, Disabled, Programmed);",
        speed.abs()
    );
    execute(bench, &call);
}

/// The number of complete moves.
fn complete(bench: &Bench, moves: &[Programmed]) -> usize {
    moves.iter().filter(|one| bench.control(&one.tag).has(Flag::Pc)).count()
}

/// The next move is executed when the queue has room for it.
fn send(bench: &mut Bench, moves: &[Programmed], sent: &mut usize) {
    while *sent < moves.len() && bench.system("L1").motion_status & MOVE_PENDING_QUEUE_FULL_STATUS == 0 {
        execute(bench, &moves[*sent].call);
        *sent += 1;
    }
}

#[test]
fn blended_sequences_are_complete_at_the_calculated_distance() {
    for case in 0..cases() {
        let mut random = Random(case);
        let period = *random.one_of(&PERIODS);
        let depth = *random.one_of(&[1, 8]);
        let speed = random.between(20.0, 150.0);
        let lock = if random.below(2) == 0 {
            (0.0, 1)
        } else {
            (random.between(0.5, 30.0), 3)
        };
        let blended: &[u8] = &[2, 3, 6];
        let moves = sequence(
            &mut random,
            &[blended, blended, blended, blended, &[0, 1, 2, 3, 6]],
            lock,
        );
        let mut bench = bench(period, depth);
        execute(&mut bench, "MDCC(L1, A2, D, Command, 100);");
        let mut sent = 0;
        send(&mut bench, &moves, &mut sent);
        jog(&mut bench, speed, "0, 100, 100, 2");
        let last = &moves[4];
        while !bench.control(&last.tag).has(Flag::CalculatedDataAvailable) {
            bench.tick();
            send(&mut bench, &moves, &mut sent);
            assert!(bench.now() < 200_000, "case {case}: {moves:#?}");
        }
        // Arrays are written when the tick ends.
        bench.tick();
        let whole: f64 = moves.iter().map(|one| bench.array(&one.data)[0]).sum();
        let margin = BlendedSequence {
            moves: 5,
            update_period: period / 1000.0,
            master_speed: speed,
            first_is_full: moves[0].is_full && moves[0].ending != 3,
            last_is_full: last.is_full && last.ending != 3,
        }
        .safety_margin();
        let begun = if lock.1 == 3 { lock.0 } else { 0.0 };
        let go = format!(
            "MAM(A2, Go, 0, {}, {speed}, 0, 2000, 0, 2000, 0, 0, 100, 100, 2, Enabled, Programmed);",
            begun + whole + margin
        );
        execute(&mut bench, &go);
        let mut before = bench.position("A2") - begun;
        while !bench.control(&last.tag).has(Flag::Pc) {
            assert!(
                !bench.control("Go").has(Flag::Pc),
                "case {case}: the master has gone {before}, calculated were {whole}: {moves:#?}"
            );
            before = bench.position("A2") - begun;
            bench.tick();
        }
        let way = bench.position("A2") - begun;
        assert!(
            before < whole + SAME && way > whole - SAME,
            "case {case}: complete between {before} and {way}, not at {whole}: {moves:#?}"
        );
        assert_eq!(complete(&bench, &moves), 5, "case {case}");
    }
}

/// A tick of a run: where the master was, where the slave, and how many moves were complete.
#[derive(Clone, Copy, Debug)]
struct Look {
    master: f64,
    slave: [f64; 3],
    complete: usize,
}

/// The moves over a master that speeds up, slows down, stands, turns round and comes back as it likes.
fn over_a_random_master(random: &mut Random, bench: &mut Bench, moves: &[Programmed], sense: f64) -> Vec<Look> {
    let look = |bench: &Bench| {
        let (slave, master) = positions(bench, "A2");
        Look {
            master,
            slave,
            complete: complete(bench, moves),
        }
    };
    let mut looks = vec![look(bench)];
    let mut first = true;
    while looks[looks.len() - 1].complete < moves.len() {
        let speed = match random.below(8) {
            _ if first => 200.0,
            0 => 0.0,
            1 | 2 => -random.between(1.0, 200.0),
            _ => random.between(1.0, 400.0),
        };
        let shape = *random.one_of(&["0, 100, 100, 2", "1, 50, 80, 2"]);
        jog(bench, sense * speed, shape);
        let ticks = if first { 400 } else { 1 + random.below(150) };
        for _ in 0..ticks {
            bench.tick();
            looks.push(look(bench));
        }
        first = false;
        assert!(looks.len() < 400_000, "it never ends: {moves:#?}");
    }
    looks
}

#[test]
fn the_path_is_a_function_of_the_masters_position() {
    for case in 0..cases().div_ceil(2) {
        let mut random = Random(1_000_000 + case);
        let period = *random.one_of(&PERIODS);
        let (lock, sense) = match random.below(4) {
            0 => ((0.0, 1), 1.0),
            1 => ((0.0, 2), -1.0),
            2 => ((random.between(0.1, 20.0), 3), 1.0),
            _ => ((random.between(-20.0, -0.1), 4), -1.0),
        };
        let any: &[u8] = &[0, 1, 2, 3, 4, 5, 6];
        let moves = sequence(&mut random, &[any; 5], lock);
        let mut driven = bench(period, 8);
        execute(&mut driven, "MDCC(L1, A2, D, Command, 50);");
        for one in &moves {
            execute(&mut driven, &one.call);
        }
        let looks = over_a_random_master(&mut random, &mut driven, &moves, sense);

        // The same over an encoder that goes from one of these positions to another, in steps of its own.
        for stride in [1, 2 + random.below(60) as usize] {
            // The behaviour in a corner depends on the period (spec/coordinated-instructions.md §7.5).
            let mut fed = bench(period, 8);
            fed.write("Encoder", 0.0);
            execute(&mut fed, "MDCC(L1, E, D, Actual, 50);");
            for one in &moves {
                execute(&mut fed, &one.call);
            }
            fed.tick();
            let mut furthest = 0.0_f64;
            for (tick, look) in looks.iter().enumerate() {
                furthest = furthest.max(sense * look.master);
                if tick % stride != 0 && tick + 1 < looks.len() {
                    continue;
                }
                fed.write("Encoder", sense * furthest);
                fed.tick();
                let (expected, _) = positions(&fed, "E");
                let apart = (0..3)
                    .map(|axis| (expected[axis] - look.slave[axis]).abs())
                    .fold(0.0, f64::max);
                assert!(
                    apart < SAME,
                    "case {case}, {stride} ticks of {period} ms at a time: {apart} apart at {} (tick {tick}): {moves:#?}",
                    look.master
                );
                assert_eq!(
                    complete(&fed, &moves),
                    look.complete,
                    "case {case} at {}: {moves:#?}",
                    look.master
                );
            }
            // Arrays are written when a tick ends.
            fed.tick();
            for one in &moves {
                let (here, there) = (driven.array(&one.data)[0], fed.array(&one.data)[0]);
                assert!(
                    (here - there).abs() < SAME,
                    "case {case}, {}: {here} or {there}: {moves:#?}",
                    one.tag
                );
            }
        }
    }
}
