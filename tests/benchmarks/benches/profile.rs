//! Planning and sampling beside an independent time-optimal solver, in one process and one thread.
//!
//! The same thousand random states for both; equal limits both ways, since the other cannot take four.
//! `cargo bench -p arcline-benchmarks --bench profile` prints means, and quantiles of the single plans.

#![allow(missing_docs)]
use std::hint::black_box;
use std::time::Instant;

use arcline_profile::{Jerk, KinematicState, Limits, Profile, entry_speed, exit_speed};
use criterion::{Criterion, criterion_group, criterion_main};
use rsruckig::prelude::*;

struct Case {
    from: KinematicState,
    target: f64,
    limits: Limits,
    input: InputParameter<1>,
}

fn random(seed: &mut u64) -> f64 {
    *seed = seed
        .wrapping_mul(6_364_136_223_846_793_005)
        .wrapping_add(1_442_695_040_888_963_407);
    (*seed >> 11) as f64 / (1u64 << 53) as f64
}

fn cases(count: usize) -> Vec<Case> {
    let mut seed = 1;
    (0..count)
        .map(|_| {
            let decade = |seed: &mut u64| 10f64.powi((random(seed) * 3.0) as i32 - 1) * (0.3 + random(seed));
            let (speed, acceleration, jerk) = (decade(&mut seed), decade(&mut seed), decade(&mut seed));
            let from = KinematicState {
                position: 0.0,
                velocity: speed * (2.0 * random(&mut seed) - 1.0),
                acceleration: acceleration * (2.0 * random(&mut seed) - 1.0),
            };
            let target = speed * speed / acceleration * 20.0 * (random(&mut seed) - 0.5);
            let limits = Limits {
                speed,
                acceleration,
                deceleration: acceleration,
                jerk: Some(Jerk {
                    acceleration: jerk,
                    deceleration: jerk,
                }),
            };
            let mut input = InputParameter::<1>::new(None);
            input.current_velocity[0] = from.velocity;
            input.current_acceleration[0] = from.acceleration;
            input.target_position[0] = target;
            input.max_velocity[0] = speed;
            input.max_acceleration[0] = acceleration;
            input.max_jerk[0] = jerk;
            Case {
                from,
                target,
                limits,
                input,
            }
        })
        .collect()
}

fn plan(c: &mut Criterion) {
    let cases = cases(1000);
    let mut solver = Ruckig::<1, ThrowErrorHandler>::new(None, 0.001);
    let mut trajectory = Trajectory::<1>::new(None);
    let mut group = c.benchmark_group("random state to rest, 1000 plans");
    group.bench_function("S-curve", |b| {
        b.iter(|| {
            for case in &cases {
                black_box(&Profile::to_position(case.from, case.target, 0.0, &case.limits));
            }
        });
    });
    group.bench_function("trapezoid", |b| {
        b.iter(|| {
            for case in &cases {
                let limits = Limits {
                    jerk: None,
                    ..case.limits
                };
                black_box(&Profile::to_position(case.from, case.target, 0.0, &limits));
            }
        });
    });
    group.bench_function("rsruckig", |b| {
        b.iter(|| {
            for case in &cases {
                let _ = black_box(solver.calculate(&case.input, &mut trajectory));
            }
        });
    });
    group.finish();
    let profile = Profile::to_position(cases[0].from, cases[0].target, 0.0, &cases[0].limits);
    let step = profile.duration() / 1000.0;
    c.bench_function("1000 samples of a profile", |b| {
        b.iter(|| {
            for index in 0..1000 {
                black_box(profile.at(black_box(f64::from(index) * step)));
            }
        });
    });
    c.bench_function("1000 entry and exit speeds", |b| {
        b.iter(|| {
            for case in &cases {
                black_box(entry_speed(case.target.abs(), case.from.velocity.abs(), &case.limits));
                black_box(exit_speed(case.from, case.target.abs(), &case.limits));
            }
        });
    });
    quantiles(&cases, &mut solver, &mut trajectory);
}

/// The best of several runs of each single plan, so that interrupts do not count; the three planners
/// take turns, so that the clock's frequency is the same for all.
fn quantiles(cases: &[Case], solver: &mut Ruckig<1, ThrowErrorHandler>, trajectory: &mut Trajectory<1>) {
    let mut best = vec![[f64::INFINITY; 3]; cases.len()];
    for _ in 0..40 {
        for (case, best) in cases.iter().zip(&mut best) {
            let trapezoid = Limits {
                jerk: None,
                ..case.limits
            };
            let times = [
                time(|| {
                    black_box(&Profile::to_position(case.from, case.target, 0.0, &case.limits));
                }),
                time(|| {
                    black_box(&Profile::to_position(case.from, case.target, 0.0, &trapezoid));
                }),
                time(|| {
                    let _ = black_box(solver.calculate(&case.input, trajectory));
                }),
            ];
            for (best, time) in best.iter_mut().zip(times) {
                *best = best.min(time);
            }
        }
    }
    let sorted = |which: usize| {
        let mut times: Vec<f64> = best.iter().map(|best| best[which]).collect();
        times.sort_by(f64::total_cmp);
        times
    };
    let mean = |times: &[f64]| times.iter().sum::<f64>() / times.len() as f64;
    let theirs = sorted(2);
    println!("single plans, and their share of rsruckig's:");
    for (name, which) in [("S-curve", 0), ("trapezoid", 1), ("rsruckig", 2)] {
        let times = sorted(which);
        println!(
            "{name:10} mean {:4.0} ns ({:.2}), median {:4.0}, p99 {:4.0} ({:.2}), most {:4.0}",
            mean(&times),
            mean(&times) / mean(&theirs),
            times[500],
            times[990],
            times[990] / theirs[990],
            times[999]
        );
    }
}

/// Nanoseconds for one run, as the mean of ten.
fn time(mut run: impl FnMut()) -> f64 {
    let start = Instant::now();
    for _ in 0..10 {
        run();
    }
    start.elapsed().as_nanos() as f64 / 10.0
}

criterion_group!(benches, plan);
criterion_main!(benches);
