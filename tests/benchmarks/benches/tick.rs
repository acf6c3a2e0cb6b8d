//! The cost of a tick: one coordinate system in a blend, and a large machine in which everything moves.
#![allow(missing_docs)]

use std::fmt::Write;
use std::hint::black_box;
use std::time::Instant;

use arcline_tests::bench::Bench;
use criterion::{BatchSize, Criterion, criterion_group, criterion_main};

/// Two moves on CS1, sampled where they are superposed.
fn in_a_blend() -> Bench {
    let mut bench = Bench::new();
    let dynamics = "10, 0, 1, 0, 1, 0, 1, 100, 100, 2, 3";
    bench.execute(&format!("MCLM(CS1, M1, 0, [1000, 500, 200], {dynamics})"));
    bench.execute(&format!("MCLM(CS1, M2, 0, [1000, 1500, 700], {dynamics})"));
    while bench.system("CS1").motion_status & (1 << 7) == 0 {
        bench.run(100);
    }
    bench
}

/// A thousand short pieces on CS1, travelled so slowly that hardly one is done; every one binds the look-ahead, since its
/// rates differ from its neighbour's; its acceleration still does behind a change of the deceleration.
fn deep() -> Bench {
    let mut bench = Bench::replacing("name = \"CS1\"", "name = \"CS1\"\nqueue_depth = 1000");
    bench.set_override("CS1", 0.0);
    for place in 0..1000 {
        let (x, accel, decel) = (f64::from(place + 1) * 0.1, 1000 + place % 5, 1000 + place % 7);
        let call =
            format!("MCLM(CS1, M{place}, 0, [{x}, 0, 0], 200, 0, {accel}, 0, {decel}, 0, 1, 20000, 20000, 0, 4)");
        assert_eq!(bench.call(&call), (0, 0));
    }
    bench.set_override("CS1", 0.001);
    bench.run(1000);
    bench
}

/// The same with one MCCD over all of it, `ticks` ticks ago.
fn changed(ticks: u64) -> Bench {
    let mut bench = deep();
    change(&mut bench, 150);
    bench.run(ticks);
    bench
}

/// MCCD of the active and all pending moves: their speed, and their deceleration, which every place between two of them
/// depends on.
fn change(bench: &mut Bench, speed: u32) {
    change_of(bench, speed, "ActiveandPendingMotion");
}

fn change_of(bench: &mut Bench, speed: u32, scope: &str) {
    let call = format!(
        "MCCD(CS1, C, CoordinatedMove, Yes, {speed}, Unitspersec, No, 0, Unitspersec2, Yes, {}, Unitspersec2, No, 0, No, 0, \
         Unitspersec3, {scope})",
        10 * speed
    );
    assert_eq!(bench.call(&call), (0, 0));
}

/// Microseconds of each of the same steps, sorted: the least of [`RUNS`] runs each, so that other load of the machine is left
/// out.
fn steps(count: usize, start: fn() -> Bench, mut step: impl FnMut(&mut Bench, usize)) -> Vec<f64> {
    let mut best = vec![f64::INFINITY; count];
    for _ in 0..RUNS {
        let mut bench = start();
        for (place, best) in best.iter_mut().enumerate() {
            let from = Instant::now();
            step(black_box(&mut bench), place);
            *best = best.min(from.elapsed().as_secs_f64() * 1e6);
        }
    }
    best.sort_by(f64::total_cmp);
    best
}

const RUNS: usize = 12;

/// Single ticks and single changes, since criterion's means do not show the worst.
fn singles() {
    let ticks = steps(8000, in_a_blend, |bench, _| bench.tick());
    let mean = ticks.iter().sum::<f64>() / ticks.len() as f64;
    println!(
        "single ticks, three axes in a blend: mean {mean:.3} us, p99.9 {:.3}, most {:.3}",
        ticks[ticks.len() * 999 / 1000],
        ticks[ticks.len() - 1]
    );
    for scope in ["ActiveMotion", "ActiveandPendingMotion"] {
        let speed = |place: usize| if place.is_multiple_of(2) { 100 } else { 150 };
        let changes = steps(20, deep, |bench, place| change_of(bench, speed(place), scope));
        println!(
            "MCCD, {scope}, 1000 moves in the queue: median {:.1} us, most {:.1}",
            changes[10], changes[19]
        );
    }
    let behind = steps(250, || changed(0), |bench, _| bench.tick());
    println!(
        "the 250 ticks behind MCCD of 1000 moves: median {:.2} us, most {:.2}",
        behind[125], behind[249]
    );
    let stop = steps(1, deep, |bench, _| {
        assert_eq!(bench.call("MCS(CS1, S, CoordinatedMove)"), (0, 0))
    });
    println!("MCS, 1000 moves in the queue: {:.1} us", stop[0]);
}

/// 256 axes, four to each of 64 machines of which three move together.
fn large() -> Bench {
    let mut bench = large_at_rest();
    start(&mut bench);
    bench
}

fn large_at_rest() -> Bench {
    let mut config = String::from("[motion_group]\nname = \"Motion\"\n");
    let limits = "max_speed = 1000.0\nmax_acceleration = 10000.0";
    for axis in 0..256 {
        let _ = writeln!(
            config,
            "[[axis]]\nname = \"A{axis}\"\ntype = \"servo\"\nunits = \"mm\"\n{limits}"
        );
        config.push_str("drive = { velocity_feedforward = 0.5 }\n");
    }
    for system in 0..64 {
        let [x, y, z] = [0, 1, 2].map(|axis| format!("\"A{}\"", 4 * system + axis));
        let _ = writeln!(
            config,
            "[[coordinate_system]]\nname = \"CS{system}\"\ntype = \"cartesian\""
        );
        let _ = writeln!(config, "axes = [{x}, {y}, {z}]\n{limits}\nactual_tolerance = 0.01");
    }
    Bench::with(&config)
}

fn start(bench: &mut Bench) {
    for system in 0..64 {
        let call =
            format!("MCLM(CS{system}, M{system}, 0, [1e9, 5e8, 2e8], 500, 0, 100, 0, 100, 0, 1, 100, 100, 2, 1)");
        assert_eq!(bench.call(&call), (0, 0));
    }
}

/// The same, and half of its systems lead the other half; the fourth axis of each is geared to its first.
fn following() -> Bench {
    let mut bench = large_at_rest();
    for system in 0..32 {
        let (source, target) = (2 * system, 2 * system + 1);
        let call = format!("MCT(CS{source}, CS{target}, T{target}, [10, 20, 30], [0, 0, 0])");
        assert_eq!(bench.call(&call), (0, 0));
    }
    for system in 0..64 {
        let (slave, master) = (4 * system + 3, 4 * system);
        let call = format!("MAG(A{slave}, A{master}, G{system}, 0, 0.5, 1, 1, 1, 0, 1)");
        assert_eq!(bench.call(&call), (0, 0));
    }
    start(&mut bench);
    bench
}

fn tick(criterion: &mut Criterion) {
    singles();
    criterion.bench_function("tick, three axes in a blend", |bencher| {
        bencher.iter_batched_ref(in_a_blend, |bench| black_box(bench).run(100), BatchSize::LargeInput);
    });
    let mut bench = deep();
    let mut share = 0.001;
    criterion.bench_function(
        "tick with a change of the override, 1000 moves in the queue",
        |bencher| {
            bencher.iter(|| {
                share = if share == 0.001 { 0.002 } else { 0.001 };
                bench.set_override("CS1", share);
                black_box(&mut bench).tick();
            });
        },
    );
    let mut bench = changed(10_000);
    let mut speed = 150;
    criterion.bench_function("MCCD of 1000 moves in the queue, and the tick", |bencher| {
        bencher.iter(|| {
            speed = if speed == 150 { 100 } else { 150 };
            change(black_box(&mut bench), speed);
            bench.tick();
        });
    });
    // The look-ahead over all of them takes the first seven.
    criterion.bench_function("one of the ticks behind MCCD of 1000 moves", |bencher| {
        bencher.iter_batched_ref(|| changed(8), |bench| black_box(bench).tick(), BatchSize::LargeInput);
    });
    let mut bench = large();
    criterion.bench_function("tick, 256 axes in 64 moving systems", |bencher| {
        bencher.iter(|| black_box(&mut bench).tick());
    });
    let mut bench = following();
    criterion.bench_function(
        "tick, 256 axes in 64 moving systems, 32 transforms, 64 gears",
        |bencher| {
            bencher.iter(|| black_box(&mut bench).tick());
        },
    );
}

criterion_group!(benches, tick);
criterion_main!(benches);
