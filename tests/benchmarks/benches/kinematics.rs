//! Both directions of the transforms, over random points of the workspace: `cargo bench -p arcline-benchmarks --bench kinematics`.
//!
//! The tick calls the functions with velocity and acceleration. Goals: the inverse of a delta of three arms and of a SCARA
//! within 200 ns, of six axes within 2 µs.
#![allow(missing_docs)]

use std::hint::black_box;

use arcline_kinematics::{
    Arm, Geometry, Number, OrientedRobot, Parameters, Pose, Robot, Turns, Wrist, end_of_arm, tool_centre,
};
use arcline_profile::KinematicState;
use criterion::{Criterion, criterion_group, criterion_main};

const POINTS: usize = 1024;

fn robot(geometry: Geometry) -> Robot {
    let parameters = Parameters {
        link_lengths: [120.0, 260.0],
        base_offsets: [60.0, 0.0, 0.0],
        end_effector_offsets: [20.0, 0.0, -30.0],
        ..Parameters::default()
    };
    Robot::new(geometry, &parameters).expect("the parameters make a robot")
}

fn points(robot: &Robot) -> Vec<[f64; 3]> {
    let mut seed = 1_u64;
    let mut random = move || {
        seed = seed
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (seed >> 11) as f64 / (1_u64 << 53) as f64
    };
    let point = || {
        [
            300.0 * random() - 150.0,
            300.0 * random() - 150.0,
            -340.0 + 160.0 * random(),
        ]
    };
    let reached = |point: &[f64; 3]| robot.inverse(*point, Arm::default()).is_ok();
    std::iter::repeat_with(point).filter(reached).take(POINTS).collect()
}

fn bench(c: &mut Criterion) {
    for (name, geometry) in [
        ("delta 3", Geometry::Delta3),
        ("scara", Geometry::ScaraIndependent),
        ("articulated 3", Geometry::ArticulatedIndependent3),
    ] {
        let robot = robot(geometry);
        let points = points(&robot);
        let mut next = (0..POINTS).cycle();
        c.bench_function(&format!("{name} inverse"), |b| {
            b.iter(|| robot.inverse(black_box(points[next.next().unwrap_or(0)]), Arm::default()));
        });
        c.bench_function(&format!("{name} inverse with velocity and acceleration"), |b| {
            b.iter(|| {
                let point = points[next.next().unwrap_or(0)].map(|at| KinematicState {
                    velocity: 10.0,
                    ..KinematicState::constant(at)
                });
                robot.inverse(black_box(point), Arm::default())
            });
        });
        let joints: Vec<_> = points
            .iter()
            .filter_map(|point| robot.inverse(*point, Arm::default()).ok())
            .collect();
        c.bench_function(&format!("{name} forward"), |b| {
            b.iter(|| robot.forward(black_box(joints[next.next().unwrap_or(0)])));
        });
    }
}

fn six_axes(c: &mut Criterion) {
    let parameters = Parameters {
        link_lengths: [300.0, 250.0],
        base_offsets: [40.0, 0.0, 300.0],
        end_effector_offsets: [80.0, 0.0, 30.0],
        ..Parameters::default()
    };
    let robot = OrientedRobot::new(Wrist::ArticulatedJ1J2J3J4J5J6, &parameters).expect("the parameters make a robot");
    let joints: Vec<[f64; 6]> = (0..POINTS)
        .map(|k| std::array::from_fn(|joint| (k * (37 + 11 * joint) % 300) as f64 - 149.5))
        .collect();
    let taken: Vec<_> = joints.iter().filter_map(|joints| robot.forward(joints).ok()).collect();
    let mut next = (0..taken.len()).cycle();
    c.bench_function("six axes inverse", |b| {
        b.iter(|| {
            let taken = black_box(&taken[next.next().unwrap_or(0)]);
            robot.inverse(&taken.pose, taken.configuration, taken.turns)
        });
    });
    c.bench_function("six axes inverse with velocity and acceleration", |b| {
        b.iter(|| {
            let taken = black_box(&taken[next.next().unwrap_or(0)]);
            let point = taken.pose.coordinates().map(|at| KinematicState {
                velocity: 10.0,
                ..KinematicState::constant(at)
            });
            robot.inverse(&Pose::new(point), taken.configuration, taken.turns)
        });
    });
    // The work of a transform (MCTO) in every update: from the moving tool centre in the work frame to the joints and their rates.
    let [work, tool] = [[20.0, -10.0, 5.0, 3.0, 8.0, -12.0], [5.0, 0.0, 85.0, 0.0, 10.0, 15.0]].map(Pose::new);
    let centres: Vec<_> = taken
        .iter()
        .map(|taken| {
            let centre = tool_centre(&work, &taken.pose, &tool).coordinates();
            (centre, taken.configuration)
        })
        .collect();
    c.bench_function("six axes inverse behind frames, moving", |b| {
        b.iter(|| {
            let (centre, configuration) = black_box(&centres[next.next().unwrap_or(0)]);
            let centre = Pose::new(centre.map(|at| KinematicState {
                velocity: 10.0,
                acceleration: -20.0,
                ..KinematicState::constant(at)
            }));
            robot.inverse(&end_of_arm(&work, &centre, &tool), *configuration, Turns::default())
        });
    });
    c.bench_function("six axes forward", |b| {
        b.iter(|| robot.forward(black_box(&joints[next.next().unwrap_or(0)])));
    });
}

criterion_group!(benches, bench, six_axes);
criterion_main!(benches);
