//! Values of the specification, errors, and both directions against each other over the workspace.

use proptest::prelude::*;

use arcline_profile::KinematicState;

use crate::{Arm, Elbow, Geometry, GeometryError, KinematicsError, Number, Parameters, Robot};

const EVERY: [Geometry; 8] = [
    Geometry::ArticulatedIndependent2,
    Geometry::ArticulatedIndependent3,
    Geometry::ArticulatedDependent2,
    Geometry::ArticulatedDependent3,
    Geometry::ScaraIndependent,
    Geometry::ScaraDelta,
    Geometry::Delta2,
    Geometry::Delta3,
];

fn robot(geometry: Geometry, l1: f64, l2: f64, base: [f64; 3], end: [f64; 3], zero: [f64; 3]) -> Robot {
    let mut parameters = Parameters {
        link_lengths: [l1, l2],
        base_offsets: base,
        end_effector_offsets: end,
        ..Parameters::default()
    };
    parameters.zero_angles[..3].copy_from_slice(&zero);
    Robot::new(geometry, &parameters).expect("the parameters make a robot")
}

/// One of each geometry with every offset that it has.
fn offset(geometry: Geometry) -> Robot {
    use Geometry::*;
    match geometry {
        ArticulatedIndependent2 => robot(
            geometry,
            300.0,
            250.0,
            [20.0, 40.0, 0.0],
            [30.0, -15.0, 0.0],
            [5.0, -7.0, 0.0],
        ),
        ArticulatedIndependent3 => robot(
            geometry,
            300.0,
            250.0,
            [20.0, 0.0, 40.0],
            [30.0, 0.0, -15.0],
            [5.0, -7.0, 9.0],
        ),
        ArticulatedDependent2 => robot(
            geometry,
            300.0,
            250.0,
            [20.0, 40.0, 0.0],
            [30.0, -15.0, 0.0],
            [5.0, -7.0, 0.0],
        ),
        ArticulatedDependent3 => robot(
            geometry,
            300.0,
            250.0,
            [20.0, 0.0, 40.0],
            [30.0, 0.0, -1.5],
            [5.0, -7.0, 9.0],
        ),
        ScaraIndependent => robot(geometry, 250.0, 200.0, [0.0; 3], [0.0; 3], [3.0, -4.0, 12.5]),
        ScaraDelta => robot(
            geometry,
            120.0,
            260.0,
            [60.0, 0.0, 0.0],
            [20.0, 0.0, 0.0],
            [3.0, -4.0, 12.5],
        ),
        Delta2 => robot(
            geometry,
            120.0,
            260.0,
            [60.0, 0.0, 0.0],
            [20.0, -30.0, 0.0],
            [3.0, -4.0, 0.0],
        ),
        Delta3 => robot(
            geometry,
            120.0,
            260.0,
            [60.0, 0.0, 0.0],
            [20.0, 0.0, -30.0],
            [3.0, -4.0, 2.0],
        ),
    }
}

fn near(is: [f64; 3], expected: [f64; 3], by: f64) -> bool {
    is.iter()
        .zip(expected)
        .all(|(is, expected)| (is - expected).abs() <= by)
}

#[test]
fn vectors() {
    use Geometry::*;
    let none = [0.0; 3];
    // spec/coordinated-instructions.md §27.9 and §22.3, and simple poses from the definitions of §22.
    #[rustfmt::skip]
    let cases = [
        ("articulated independent", robot(ArticulatedIndependent3, 10.0, 10.0, none, none, none), [0.0, 90.0, -90.0], [10.0, 0.0, 10.0]),
        ("articulated dependent",   robot(ArticulatedDependent3, 10.0, 10.0, none, none, none),   [0.0, 90.0, 0.0],   [10.0, 0.0, 10.0]),
        ("SCARA",                   robot(ScaraIndependent, 10.0, 10.0, none, none, none),        [0.0, 90.0, 5.0],   [10.0, 10.0, 5.0]),
        ("delta",                   robot(Delta3, 100.0, 200.0, [30.0, 0.0, 0.0], [30.0, 0.0, 0.0], none), [0.0; 3], [0.0, 0.0, -173.205_080_756_887_72]),
        ("two 10-inch links reach 20",    robot(ArticulatedIndependent3, 10.0, 10.0, none, none, none), [0.0; 3],           [20.0, 0.0, 0.0]),
        ("the base turns to the left",    robot(ArticulatedIndependent3, 10.0, 10.0, none, none, none), [90.0, 90.0, -90.0], [0.0, 10.0, 10.0]),
        ("an upright tool",               robot(ArticulatedIndependent3, 10.0, 10.0, none, [0.0, 0.0, 2.0], none), [0.0, 90.0, -90.0], [10.0, 0.0, 12.0]),
        ("a tool that keeps its direction", robot(ArticulatedDependent3, 10.0, 10.0, none, [1.0, 0.0, -1.5], none), [0.0, 90.0, 0.0], [11.0, 0.0, 8.5]),
        ("a base that is off its axis",   robot(ArticulatedDependent3, 10.0, 10.0, [2.0, 0.0, 3.0], none, none), [180.0, 90.0, 0.0], [-12.0, 0.0, 13.0]),
        ("zero shown at 10 degrees",      robot(ScaraIndependent, 10.0, 10.0, none, none, [-10.0, 0.0, 0.0]), [-10.0, 90.0, 0.0], [10.0, 10.0, 0.0]),
        ("two axes",                      robot(ArticulatedIndependent2, 10.0, 10.0, [1.0, 2.0, 0.0], none, none), [90.0, -90.0, 0.0], [11.0, 12.0, 0.0]),
        ("two axes, dependent",           robot(ArticulatedDependent2, 10.0, 10.0, [1.0, 2.0, 0.0], none, none), [90.0, 0.0, 0.0], [11.0, 12.0, 0.0]),
        ("two arms",                      robot(Delta2, 100.0, 200.0, [30.0, 0.0, 0.0], [30.0, -10.0, 0.0], none), [0.0; 3], [0.0, -183.205_080_756_887_72, 0.0]),
        ("two arms lie, forwards",        robot(ScaraDelta, 100.0, 200.0, [30.0, 0.0, 0.0], [30.0, 0.0, 0.0], none), [0.0, 0.0, 7.0], [0.0, 173.205_080_756_887_72, 7.0]),
    ];
    for (why, robot, joints, point) in cases {
        let forward = robot.forward(joints).expect(why);
        assert!(near(forward, point, 1e-9), "{why}: {forward:?}");
        let inverse = robot.inverse(point, robot.arm(joints)).expect(why);
        assert!(near(inverse, joints, 1e-6), "{why}: {inverse:?}");
    }
}

#[test]
fn limits_of_a_delta() {
    // spec/coordinated-instructions.md §27.9.
    let robot = robot(
        Geometry::Delta3,
        50.0,
        80.0,
        [20.0, 0.0, 0.0],
        [3.0, 0.0, 0.0],
        [0.0; 3],
    );
    let [least, most] = robot.range(0).expect("an arm has a range");
    assert!(
        (most - 97.514).abs() < 5e-4 && (least + 55.482).abs() < 5e-4,
        "{least} {most}"
    );
    for beyond in [98.0, -56.0] {
        assert_eq!(
            robot.forward([0.0, beyond, 0.0]),
            Err(KinematicsError::Reach { joint: 1 })
        );
    }
}

#[test]
fn every_solution_of_an_arm() {
    let robot = offset(Geometry::ArticulatedIndependent3);
    let point = [180.0, -220.0, 95.0];
    let mut seen: Vec<[f64; 3]> = Vec::new();
    for elbow in [Elbow::Left, Elbow::Right] {
        for mirrored in [false, true] {
            let arm = Arm { elbow, mirrored };
            let joints = robot.inverse(point, arm).expect("within reach");
            assert_eq!(robot.arm(joints), arm);
            assert!(near(robot.forward(joints).expect("joints"), point, 1e-9), "{arm:?}");
            assert!(
                seen.iter().all(|other| !near(*other, joints, 1.0)),
                "{arm:?} is another one's"
            );
            seen.push(joints);
        }
    }
    // Straight ahead the mirrored solution is half a turn to the left, whatever the sign of a zero.
    for zero in [0.0, -0.0] {
        let mirrored = Arm {
            mirrored: true,
            ..Arm::default()
        };
        let [turn, ..] = robot.inverse([200.0, zero, 95.0], mirrored).expect("within reach");
        assert!((turn - 185.0).abs() < 1e-9, "{turn}");
    }
    // The mirrored solution is half a turn away in the opposite direction.
    assert!((seen[0][0] - seen[1][0]).abs() - 180.0 < 1e-9);
}

#[test]
fn points_out_of_reach_are_errors() {
    use Geometry::*;
    let none = [0.0; 3];
    let far = |joint| Err(KinematicsError::Reach { joint });
    let origin = Err(KinematicsError::Origin);
    let arm = Arm::default();
    #[rustfmt::skip]
    let cases = [
        ("too far",                   robot(ArticulatedIndependent3, 10.0, 8.0, none, none, none), [18.1, 0.0, 0.0], far(2)),
        ("too near",                  robot(ArticulatedIndependent3, 10.0, 8.0, none, none, none), [1.0, 1.0, 0.0],  far(2)),
        ("on the axis of the base",   robot(ArticulatedIndependent3, 10.0, 8.0, none, none, none), [0.0, 0.0, 12.0], origin),
        ("at the shoulder of equals", robot(ScaraIndependent, 10.0, 10.0, none, none, none),       [0.0, 0.0, 3.0],  origin),
        ("too far in the plane",      robot(ScaraIndependent, 10.0, 10.0, none, none, none),       [15.0, 15.0, 0.0], far(1)),
        ("beyond the second arm",     robot(Delta3, 100.0, 200.0, none, none, none),               [250.0, 0.0, -50.0], far(1)),
        ("below all arms",            robot(Delta3, 100.0, 200.0, none, none, none),               [0.0, 0.0, -301.0], far(0)),
        ("beside two arms",           robot(Delta2, 100.0, 200.0, none, none, none),               [280.0, -100.0, 0.0], far(1)),
    ];
    for (why, robot, point, expected) in cases {
        assert_eq!(robot.inverse(point, arm).map(drop), expected, "{why}");
    }
    // The robot can stay at the end of its reach, but not move through it.
    let robot = robot(ScaraIndependent, 10.0, 10.0, none, none, none);
    assert!(robot.inverse([20.0, 0.0, 0.0], arm).is_ok());
    let moving = [20.0, 0.0, 0.0].map(KinematicState::constant);
    assert_eq!(robot.inverse(moving, arm).map(drop), far(1));
}

#[test]
fn geometries_that_make_no_robot_are_errors() {
    let offsets = |apart| [apart, 0.0, 0.0];
    #[rustfmt::skip]
    let cases = [
        (Geometry::ScaraIndependent, 0.0, 10.0, 0.0,  Err(GeometryError::LinkLengths)),
        (Geometry::Delta3, 10.0, -1.0, 0.0,           Err(GeometryError::LinkLengths)),
        (Geometry::Delta2, 10.0, 10.0, 0.0,           Err(GeometryError::LinkLengths)),
        (Geometry::Delta3, 100.0, 200.0, 101.0,       Err(GeometryError::Offsets)),
        (Geometry::ScaraDelta, 100.0, 200.0, -101.0,  Err(GeometryError::Offsets)),
        (Geometry::Delta3, 100.0, 200.0, 100.0,       Ok(())),
        (Geometry::ScaraIndependent, 10.0, f64::NAN, 0.0, Err(GeometryError::LinkLengths)),
    ];
    for (geometry, l1, l2, apart, expected) in cases {
        let parameters = Parameters {
            link_lengths: [l1, l2],
            base_offsets: offsets(apart),
            ..Parameters::default()
        };
        assert_eq!(
            Robot::new(geometry, &parameters).map(drop),
            expected,
            "{geometry:?} {l1} {l2} {apart}"
        );
    }
}

/// Random points of every workspace, each in every solution of the arm; ARCLINE_CASES sets their number instead of a million.
#[test]
fn forward_is_the_inverse_of_inverse() {
    let cases = std::env::var("ARCLINE_CASES")
        .ok()
        .and_then(|text| text.parse().ok())
        .unwrap_or(1_000_000);
    for geometry in EVERY {
        let robot = offset(geometry);
        let arms = arms(geometry);
        let mut random = Random(geometry as u64 + 1);
        let mut solutions = vec![0_usize; arms.len()];
        let (mut worst, mut found, mut tried) = (0.0_f64, 0, 0);
        while found < cases {
            tried += 1;
            assert!(
                tried < 20 * cases,
                "{geometry:?}: {found} of {tried} points can be reached"
            );
            let point = random_point(&robot, &mut random);
            let before: usize = solutions.iter().sum();
            for (arm, solutions) in arms.iter().zip(&mut solutions) {
                let Ok(joints) = robot.inverse(point, *arm) else {
                    continue;
                };
                *solutions += 1;
                let back = robot.forward(joints).expect("joints of a point");
                let off = (0..3).map(|k| (back[k] - point[k]).abs()).fold(0.0, f64::max);
                assert!(
                    off <= 1e-9,
                    "{geometry:?} {arm:?}: {point:?} becomes {joints:?}, {back:?}"
                );
                if geometry.is_arm() && robot.arm(joints) != *arm {
                    let bent = robot.inverse(point.map(KinematicState::constant), *arm).is_ok();
                    assert!(!bent, "{geometry:?} {arm:?}: {point:?}");
                }
                worst = worst.max(off);
            }
            found += usize::from(solutions.iter().sum::<usize>() > before);
        }
        for (arm, solutions) in arms.iter().zip(&solutions) {
            assert!(
                4 * solutions > cases,
                "{geometry:?} {arm:?}: {solutions} of {cases} points"
            );
        }
        println!("{geometry:?}: {found} points, {solutions:?} solutions, worst {worst:.1e}");
    }
}

/// A point of a box about the workspace; for parallel arms below their elbows, as the tool.
fn random_point(robot: &Robot, random: &mut Random) -> [f64; 3] {
    use Geometry::*;
    let mut within = |least: f64, most: f64| least + (most - least) * random.next();
    match robot.geometry() {
        ArticulatedIndependent2 | ArticulatedDependent2 => [within(-600.0, 650.0), within(-550.0, 600.0), 0.0],
        ArticulatedIndependent3 | ArticulatedDependent3 => {
            [within(-650.0, 650.0), within(-650.0, 650.0), within(-550.0, 600.0)]
        }
        ScaraIndependent => [within(-450.0, 450.0), within(-450.0, 450.0), within(-100.0, 100.0)],
        ScaraDelta => [within(-120.0, 120.0), within(150.0, 320.0), within(-100.0, 100.0)],
        Delta2 => [within(-120.0, 120.0), within(-350.0, -180.0), 0.0],
        Delta3 => [within(-150.0, 150.0), within(-150.0, 150.0), within(-340.0, -180.0)],
    }
}

fn arms(geometry: Geometry) -> Vec<Arm> {
    let elbows: &[Elbow] = if geometry.is_arm() {
        &[Elbow::Left, Elbow::Right]
    } else {
        &[Elbow::Right]
    };
    let mirrors: &[bool] = if geometry.has_mirror() {
        &[false, true]
    } else {
        &[false]
    };
    let with = |elbow: &Elbow| {
        mirrors
            .iter()
            .map(move |mirrored| (*elbow, *mirrored))
            .collect::<Vec<_>>()
    };
    let pairs = elbows.iter().flat_map(with);
    pairs.map(|(elbow, mirrored)| Arm { elbow, mirrored }).collect()
}

struct Random(u64);

impl Random {
    /// 0 up to 1.
    fn next(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// A motion of three coordinates at time `t`: position, velocity, acceleration.
fn motion(at: [f64; 3], velocity: [f64; 3], acceleration: [f64; 3], t: f64) -> [KinematicState; 3] {
    [0, 1, 2].map(|k| KinematicState {
        position: at[k] + velocity[k] * t + 0.5 * acceleration[k] * t * t,
        velocity: velocity[k] + acceleration[k] * t,
        acceleration: acceleration[k],
    })
}

proptest! {
    /// Velocity and acceleration agree with the differences of positions shortly before and after.
    #[test]
    fn velocities_and_accelerations_are_derivatives_of_the_positions(
        which in 0..EVERY.len(),
        seed in any::<u64>(),
        velocity in prop::array::uniform3(-100.0..100.0_f64),
        acceleration in prop::array::uniform3(-500.0..500.0_f64),
    ) {
        let robot = offset(EVERY[which]);
        let mut random = Random(seed);
        let point = random_point(&robot, &mut random);
        for arm in arms(EVERY[which]) {
            let h = 1e-4;
            let at = |t: f64| robot.inverse(motion(point, velocity, acceleration, t), arm);
            let (Ok(before), Ok(now), Ok(after)) = (at(-h), at(0.0), at(h)) else { continue };
            // Differences are inaccurate where the speeds of the joints are nearly infinite.
            if now.iter().any(|joint| joint.velocity.abs() > 1e3 || joint.acceleration.abs() > 1e5) { continue }
            for k in 0..3 {
                let slope = (after[k].position - before[k].position) / (2.0 * h);
                let bend = (after[k].velocity - before[k].velocity) / (2.0 * h);
                prop_assert!((slope - now[k].velocity).abs() < 1e-3 * (1.0 + now[k].velocity.abs()), "{slope} {:?}", now[k]);
                prop_assert!((bend - now[k].acceleration).abs() < 1e-2 * (10.0 + now[k].acceleration.abs()), "{bend} {:?}", now[k]);
            }
            // And back again.
            let back = robot.forward(now).expect("joints of a point");
            let there = motion(point, velocity, acceleration, 0.0);
            for k in 0..EVERY[which].joints() {
                prop_assert!((back[k].position - there[k].position).abs() < 1e-9);
                prop_assert!((back[k].velocity - there[k].velocity).abs() < 1e-5);
                prop_assert!((back[k].acceleration - there[k].acceleration).abs() < 1e-2);
            }
        }
    }

    /// No input causes a panic or a NaN.
    #[test]
    fn every_input_has_an_answer(
        which in 0..EVERY.len(),
        numbers in prop::array::uniform3(any::<f64>()),
        near in prop::array::uniform3(-1.0..1.0_f64),
    ) {
        let robot = offset(EVERY[which]);
        for given in [numbers, near] {
            for arm in arms(EVERY[which]) {
                if let Ok(joints) = robot.inverse(given, arm) {
                    prop_assert!(joints.iter().all(|joint| Number::is_finite(*joint)));
                }
            }
            if let Ok(point) = robot.forward(given) {
                prop_assert!(point.iter().all(|part| Number::is_finite(*part)));
            }
            let _ = robot.arm(given);
        }
    }
}
