//! Robots with a wrist: the examples of the specification, and both directions against each other.

use proptest::prelude::*;

use arcline_profile::KinematicState;

use crate::{Configuration, KinematicsError, OrientedRobot, Parameters, Pose, Wrist, end_of_arm, tool_centre};

const EVERY: [Wrist; 5] = [
    Wrist::DeltaJ1J2J6,
    Wrist::DeltaJ1J2J3J6,
    Wrist::DeltaJ1J2J3J4J5,
    Wrist::ScaraJ1J2J3J6,
    Wrist::ArticulatedJ1J2J3J4J5J6,
];

fn robot(wrist: Wrist) -> OrientedRobot {
    let parameters = match wrist {
        Wrist::ScaraJ1J2J3J6 => Parameters {
            link_lengths: [250.0, 200.0],
            zero_angles: [3.0, -4.0, 12.5, 7.0, 0.0, 0.0],
            ..Parameters::default()
        },
        Wrist::ArticulatedJ1J2J3J4J5J6 => Parameters {
            link_lengths: [300.0, 250.0],
            base_offsets: [40.0, 0.0, 300.0],
            end_effector_offsets: [80.0, 0.0, 30.0],
            zero_angles: [1.0, 2.0, 3.0, 4.0, 5.0, 6.0],
        },
        _ => Parameters {
            link_lengths: [120.0, 260.0],
            base_offsets: [60.0, 0.0, 0.0],
            end_effector_offsets: [20.0, 0.0, -30.0],
            zero_angles: [3.0, -4.0, 2.0, 5.0, -6.0, 0.0],
        },
    };
    OrientedRobot::new(wrist, &parameters).expect("the parameters make a robot")
}

fn apart(a: &Pose, b: &Pose) -> f64 {
    let turned = (a.rotation - b.rotation).abs().max();
    (a.position - b.position).abs().max().max(turned)
}

#[test]
fn angles_of_a_pose() {
    // spec/coordinated-instructions.md §22.8: fixed X-Y-Z angles in their ranges.
    let cases = [
        ([1.0, 2.0, 3.0, 10.0, 20.0, 30.0], [1.0, 2.0, 3.0, 10.0, 20.0, 30.0]),
        ([0.0, 0.0, 0.0, 180.0, 0.0, -180.0], [0.0, 0.0, 0.0, 180.0, 0.0, 180.0]),
        ([0.0, 0.0, 0.0, 180.0, 120.0, 10.0], [0.0, 0.0, 0.0, 0.0, 60.0, -170.0]),
        ([0.0, 0.0, 0.0, 20.0, 90.0, 50.0], [0.0, 0.0, 0.0, 0.0, 90.0, 30.0]),
        ([0.0, 0.0, 0.0, 20.0, -90.0, 50.0], [0.0, 0.0, 0.0, 0.0, -90.0, 70.0]),
    ];
    for (given, expected) in cases {
        let shown = Pose::new(given).coordinates();
        for (shown, expected) in shown.iter().zip(expected) {
            assert!((shown - expected).abs() < 1e-9, "{given:?}: {shown} is not {expected}");
        }
    }
}

#[test]
fn turns_of_a_joint() {
    // spec/coordinated-instructions.md §22.8: Rz = 45 with counter 0, 1, -1 is joint 45, 405, -315.
    let parameters = Parameters {
        link_lengths: [120.0, 260.0],
        ..Parameters::default()
    };
    let robot = OrientedRobot::new(Wrist::DeltaJ1J2J3J6, &parameters).expect("a robot");
    let pose = Pose::new([10.0, 20.0, -280.0, 180.0, 0.0, 45.0]);
    for (turns, expected) in [(0, 45.0), (1, 405.0), (-1, -315.0)] {
        let joints = robot
            .inverse(&pose, Configuration::default(), [0, 0, turns])
            .expect("within reach");
        assert!((joints[3] - expected).abs() < 1e-9, "{joints:?}");
        assert_eq!(robot.forward(&joints).expect("joints").turns, [0, 0, turns]);
    }
}

#[test]
fn the_mirror_rule_of_a_swing_arm() {
    // spec/coordinated-instructions.md §22.8: J5 within a quarter turn is Rx = 180, Ry = -J5; beyond it Rx = 0 and Ry runs back.
    let parameters = Parameters {
        link_lengths: [120.0, 260.0],
        ..Parameters::default()
    };
    let robot = OrientedRobot::new(Wrist::DeltaJ1J2J3J4J5, &parameters).expect("a robot");
    #[rustfmt::skip]
    let cases = [
        (0.0,   10.0, [180.0, 0.0, -10.0]),
        (30.0,  10.0, [180.0, -30.0, -10.0]),
        (-60.0, 10.0, [180.0, 60.0, -10.0]),
        (120.0, 10.0, [0.0, -60.0, 170.0]),
        (-100.0, 10.0, [0.0, 80.0, 170.0]),
    ];
    for (j5, j4, expected) in cases {
        let joints = [20.0, 20.0, 20.0, j4, j5, 0.0];
        let taken = robot.forward(&joints).expect("joints");
        let [.., rx, ry, rz] = taken.pose.coordinates();
        for (shown, expected) in [rx, ry, rz].iter().zip(expected) {
            assert!((shown - expected).abs() < 1e-9, "J5 {j5}: {rx} {ry} {rz}");
        }
        let back = robot
            .inverse(&taken.pose, taken.configuration, taken.turns)
            .expect("a pose of it");
        assert!((back[4] - j5).abs() < 1e-9 && (back[3] - j4).abs() < 1e-9, "{back:?}");
    }
}

#[test]
fn angles_go_on_near_others() {
    #[rustfmt::skip]
    let cases = [
        // why,                                     an orientation,        near,                    is
        ("a turn on",                               [10.0, 20.0, -170.0],  [10.0, 20.0, 200.0],     [10.0, 20.0, 190.0]),
        ("two turns back",                          [10.0, 20.0, 30.0],    [10.0, 20.0, -700.0],    [10.0, 20.0, -690.0]),
        ("on through the mirror",                   [0.0, 80.0, 170.0],    [180.0, 95.0, -5.0],     [180.0, 100.0, -10.0]),
        ("what can be anything is what it was",     [0.0, 90.0, 30.0],     [20.0, 90.0, 50.0],      [20.0, 90.0, 50.0]),
        ("the other way round",                     [0.0, -90.0, 70.0],    [20.0, -90.0, 50.0],     [20.0, -90.0, 50.0]),
    ];
    for (why, [rx, ry, rz], near, expected) in cases {
        let [.., rx, ry, rz] = Pose::new([1.0, 2.0, 3.0, rx, ry, rz]).coordinates_near(near);
        for (shown, expected) in [rx, ry, rz].iter().zip(expected) {
            assert!((shown - expected).abs() < 1e-9, "{why}: {rx} {ry} {rz}");
        }
    }
}

/// Both directions of every robot with motion, against differences of positions at rest.
#[test]
fn velocities_and_accelerations_are_derivatives_of_the_positions() {
    const STEP: f64 = 1e-4;
    let speeds = [3.0, -2.0, 4.0, 5.0, -6.0, 7.0];
    let joints = [20.0, 25.0, 35.0, 40.0, -50.0, 60.0];
    for wrist in EVERY {
        let robot = robot(wrist);
        let at = |seconds: f64| -> [f64; 6] { std::array::from_fn(|k| joints[k] + speeds[k] * seconds) };
        let moving: [KinematicState; 6] = std::array::from_fn(|k| KinematicState {
            position: joints[k],
            velocity: speeds[k],
            acceleration: 0.0,
        });
        let taken = robot.forward(&moving).expect("joints of the robot");
        let coordinates = taken.pose.coordinates();
        let now = |seconds: f64| robot.forward(&at(seconds)).expect("joints").pose.coordinates();
        let (before, here, after) = (now(-STEP), now(0.0), now(STEP));
        for index in 0..6 {
            let velocity = (after[index] - before[index]) / (2.0 * STEP);
            let acceleration = (after[index] - 2.0 * here[index] + before[index]) / (STEP * STEP);
            let found = coordinates[index];
            assert!((found.position - here[index]).abs() < 1e-9, "{wrist:?} {index}");
            assert!(
                (found.velocity - velocity).abs() < 1e-4,
                "{wrist:?} {index}: {found:?}, {velocity}"
            );
            assert!(
                (found.acceleration - acceleration).abs() < 1e-3,
                "{wrist:?} {index}: {found:?}, {acceleration}"
            );
        }
        // And the inverse: the motion of the pose yields the motion of the joints.
        let back = robot
            .inverse(&Pose::new(coordinates), taken.configuration, taken.turns)
            .expect("a pose of the robot");
        for (index, back) in back.iter().enumerate().take(wrist.joints()) {
            let expected = moving[index];
            assert!(
                (back.position - expected.position).abs() < 1e-6,
                "{wrist:?} {index}: {back:?}"
            );
            assert!(
                (back.velocity - expected.velocity).abs() < 1e-6,
                "{wrist:?} {index}: {back:?}"
            );
            assert!(back.acceleration.abs() < 1e-6, "{wrist:?} {index}: {back:?}");
        }
    }
}

#[test]
fn motion_stays_off_a_straight_wrist() {
    let robot = robot(Wrist::ArticulatedJ1J2J3J4J5J6);
    // J5 is 5 at its internal 0.
    let joints = [10.0, 50.0, -40.0, 20.0, 5.0, 30.0];
    let taken = robot.forward(&joints).expect("joints");
    let at_rest = robot
        .inverse(&taken.pose, taken.configuration, taken.turns)
        .expect("it stands");
    assert!(apart(&robot.forward(&at_rest).expect("joints").pose, &taken.pose) < 1e-9);
    let moving = robot.inverse(
        &taken.pose.constant::<KinematicState>(),
        taken.configuration,
        taken.turns,
    );
    assert_eq!(moving.expect_err("J4 and J6 are one"), KinematicsError::Origin);
}

#[test]
fn poses_that_cannot_be_taken() {
    use KinematicsError::Orientation;
    #[rustfmt::skip]
    let cases = [
        ("off the plane",      Wrist::DeltaJ1J2J6,     [0.0, 5.0, -280.0, 180.0, 0.0, 0.0], Orientation { angle: 1 }),
        ("tilted",             Wrist::DeltaJ1J2J3J6,   [0.0, 5.0, -280.0, 180.0, 5.0, 0.0], Orientation { angle: 4 }),
        ("rolled",             Wrist::ScaraJ1J2J3J6,   [200.0, 150.0, 0.0, 170.0, 0.0, 0.0], Orientation { angle: 3 }),
        ("upside down",        Wrist::DeltaJ1J2J3J6,   [0.0, 5.0, -280.0, 0.0, 0.0, 0.0],   Orientation { angle: 3 }),
        ("rolled on a swing",  Wrist::DeltaJ1J2J3J4J5, [0.0, 5.0, -280.0, 170.0, 5.0, 0.0], Orientation { angle: 3 }),
        ("too far",            Wrist::ArticulatedJ1J2J3J4J5J6, [900.0, 0.0, 300.0, 0.0, 90.0, 0.0], KinematicsError::Reach { joint: 2 }),
    ];
    for (why, wrist, pose, expected) in cases {
        let refused = robot(wrist).inverse(&Pose::new(pose), Configuration::default(), [0; 3]);
        assert_eq!(refused, Err(expected), "{why}");
    }
}

#[test]
fn an_arm_of_six_axes_lies_along_x_and_reaches_down() {
    let parameters = Parameters {
        link_lengths: [300.0, 250.0],
        base_offsets: [0.0, 0.0, 400.0],
        end_effector_offsets: [100.0, 0.0, 0.0],
        ..Parameters::default()
    };
    let robot = OrientedRobot::new(Wrist::ArticulatedJ1J2J3J4J5J6, &parameters).expect("a robot");
    let flat = robot.forward(&[0.0; 6]).expect("joints");
    assert!(
        (flat.pose.position - nalgebra::Vector3::new(650.0, 0.0, 400.0))
            .abs()
            .max()
            < 1e-9
    );
    // Upper arm upright, forearm level, the hand bent down: the tool points down.
    let bent = robot.forward(&[0.0, 90.0, -90.0, 0.0, -90.0, 0.0]).expect("joints");
    let [x, y, z, rx, ry, _] = bent.pose.coordinates();
    assert!(
        (x - 250.0).abs() < 1e-9 && y.abs() < 1e-9 && (z - 600.0).abs() < 1e-9,
        "{:?}",
        bent.pose
    );
    assert!((rx.abs() - 180.0).abs() < 1e-9 && ry.abs() < 1e-9, "{rx} {ry}");
}

/// Random joints of every robot: the joints of their pose have the same pose, in the same solution and in another one, each one in turn.
/// ARCLINE_CASES sets the number of cases instead of a million.
#[test]
fn forward_is_the_inverse_of_inverse() {
    let cases = std::env::var("ARCLINE_CASES")
        .ok()
        .and_then(|text| text.parse().ok())
        .unwrap_or(1_000_000);
    let mut seed = 7_u64;
    let mut random = move |least: f64, most: f64| {
        seed = seed
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        least + (most - least) * (seed >> 11) as f64 / (1_u64 << 53) as f64
    };
    for wrist in EVERY {
        let robot = robot(wrist);
        // The number of solutions of the robot.
        let solutions = match wrist {
            Wrist::ScaraJ1J2J3J6 => 2,
            Wrist::ArticulatedJ1J2J3J4J5J6 => 8,
            _ => 1,
        };
        let mut found = vec![0_usize; solutions];
        let (mut worst, mut taken_again, mut tried) = (0.0_f64, 0, 0);
        while taken_again < cases {
            tried += 1;
            assert!(
                tried < 20 * cases,
                "{wrist:?}: {taken_again} of {tried} joints take a pose"
            );
            let joints: [f64; 6] = match wrist {
                Wrist::ScaraJ1J2J3J6 | Wrist::ArticulatedJ1J2J3J4J5J6 => std::array::from_fn(|_| random(-500.0, 500.0)),
                _ => [
                    random(-10.0, 50.0),
                    random(-10.0, 50.0),
                    if wrist == Wrist::DeltaJ1J2J6 {
                        random(-900.0, 900.0)
                    } else {
                        random(-10.0, 50.0)
                    },
                    random(-900.0, 900.0),
                    random(-170.0, 170.0),
                    0.0,
                ],
            };
            let Ok(taken) = robot.forward(&joints) else { continue };
            let index = tried % solutions;
            let other = Configuration::from_bits((index as i32) << 1);
            if let Ok(other) = robot.inverse(&taken.pose, other, taken.turns) {
                let again = robot.forward(&other).expect("joints of a pose");
                worst = worst.max(apart(&again.pose, &taken.pose));
                assert!(apart(&again.pose, &taken.pose) < 1e-9, "{wrist:?} {joints:?} {other:?}");
                found[index] += 1;
            }
            if let Ok(same) = robot.inverse(&taken.pose, taken.configuration, taken.turns) {
                let again = robot.forward(&same).expect("joints of a pose");
                taken_again += 1;
                worst = worst.max(apart(&again.pose, &taken.pose));
                assert!(apart(&again.pose, &taken.pose) < 1e-9, "{wrist:?} {joints:?} {same:?}");
                assert_eq!(again.turns, taken.turns, "{wrist:?} {joints:?} {same:?}");
                assert_eq!(
                    again.configuration, taken.configuration,
                    "{wrist:?} {joints:?} {same:?}"
                );
                let counted = match wrist {
                    Wrist::DeltaJ1J2J6 => &joints[2..3],
                    Wrist::DeltaJ1J2J3J4J5 | Wrist::DeltaJ1J2J3J6 => &joints[3..4],
                    _ => &joints[..1],
                };
                assert!(
                    counted
                        .iter()
                        .all(|joint| same.iter().any(|other| (joint - other).abs() < 1e-6)),
                    "{joints:?} {same:?}"
                );
            }
        }
        for (bits, found) in found.iter().enumerate() {
            assert!(4 * solutions * found > cases, "{wrist:?} {bits}: {found} of {tried}");
        }
        println!("{wrist:?}: {tried} tried, {found:?} other solutions, worst {worst:.1e}");
    }
}

proptest! {
    #[test]
    fn frames_there_and_back(
        work in prop::array::uniform6(-170.0..170.0_f64),
        tool in prop::array::uniform6(-170.0..170.0_f64),
        point in prop::array::uniform6(-170.0..170.0_f64),
    ) {
        let [work, tool, point] = [work, tool, point].map(Pose::new);
        let end = end_of_arm(&work, &point, &tool);
        prop_assert!(apart(&tool_centre(&work, &end, &tool), &point) < 1e-9);
        // The angles determine the orientation.
        prop_assert!(apart(&Pose::new(end.coordinates()), &end) < 1e-9);
    }

    #[test]
    fn every_input_has_an_answer(which in 0..EVERY.len(), numbers in prop::array::uniform6(any::<f64>()), bits in any::<i32>()) {
        let robot = robot(EVERY[which]);
        let _ = robot.forward(&numbers);
        let _ = robot.inverse(&Pose::new(numbers), Configuration::from_bits(bits), [i16::MAX, 0, i16::MIN]);
    }
}
