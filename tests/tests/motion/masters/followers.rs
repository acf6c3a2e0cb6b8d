//! Random gears and cams, and chains of two: the slave is where its master makes it be within the same update, to rounding, at every
//! update period (spec/axis-and-data-types.md §3.5, §3.9).
//!
//! `ARCLINE_CASES` sets the number of chains (20 by default).

use arcline_cam::{Point, Profile, SegmentType};
use arcline_instruction_set::predefined::motion_status::GEARING_LOCK_STATUS;
use arcline_tests::bench::{Bench, OK};
use arcline_tests::follow::machine;
use arcline_tests::random::Random;

/// The law by which a slave follows a master: the slave's displacement as a function of the master's, both from the beginning.
#[derive(Debug)]
enum Law {
    Gear {
        ratio: f64,
    },
    Cam {
        profile: Profile,
        entry: f64,
        scales: [f64; 2],
        endless: bool,
    },
}

/// A slave and its master.
#[derive(Debug)]
struct Chain {
    slave: &'static str,
    master: &'static str,
    /// The master is read where it really is.
    actual: bool,
    law: Law,
    /// Master and slave where the one began to be bound to the other.
    met: Option<[f64; 2]>,
}

impl Law {
    /// The displacement of the slave for one of the master.
    fn at(&self, way: f64) -> f64 {
        match self {
            Law::Gear { ratio } => ratio * way,
            Law::Cam {
                profile,
                entry,
                scales: [slave, master],
                endless,
            } => {
                let (start, length) = (profile.start().0, profile.length());
                let place = entry + way / master;
                let turn = if *endless {
                    ((place - start) / length).floor()
                } else {
                    0.0
                };
                slave * (turn * profile.rise() + profile.at(place - turn * length).y - profile.at(*entry).y)
            }
        }
    }

    /// The greatest effect of rounding of the master's position on the slave's.
    fn steepness(&self) -> f64 {
        match self {
            Law::Gear { ratio } => ratio.abs(),
            Law::Cam {
                profile,
                scales: [slave, master],
                ..
            } => {
                let steps = profile
                    .segments()
                    .windows(2)
                    .map(|pair| ((pair[1].y - pair[0].y) / (pair[1].x - pair[0].x)).abs());
                // A cubic may be some times as steep as the line between its points.
                10.0 * (slave / master).abs() * steps.fold(1.0, f64::max)
            }
        }
    }
}

fn cases() -> u64 {
    let set = std::env::var("ARCLINE_CASES").ok();
    set.and_then(|text| text.parse().ok()).unwrap_or(20)
}

fn bench(period: f64) -> Bench {
    let lagging = machine(period).replace(
        "start = { position = 0.0, servo_on = true, homed = true }\n",
        "start = { position = 0.0, servo_on = true, homed = true }\ndrive = { velocity_feedforward = 0.0, position_error_tolerance = 0.0 }\n",
    );
    Bench::with(&format!(
        "{lagging}[[tag]]\nname = \"Cam\"\ntype = \"CAM[8]\"\n[[tag]]\nname = \"P1\"\ntype = \"CAM_PROFILE[8]\"\n\
         [[tag]]\nname = \"P2\"\ntype = \"CAM_PROFILE[8]\"\n"
    ))
}

/// The command or actual position of an axis.
fn position(bench: &Bench, axis: &str, actual: bool) -> f64 {
    let axis = bench.axis(axis);
    if actual { axis.actual[0] } else { axis.command[0] }
}

/// Binds a slave to a master.
fn bind(random: &mut Random, bench: &mut Bench, place: usize, slave: &'static str, master: &'static str) -> Chain {
    let actual = random.below(2) == 0;
    let reference = u8::from(!actual);
    let direction = random.below(2);
    let sign = if direction == 0 { 1.0 } else { -1.0 };
    let law = match random.below(3) {
        0 => {
            let (clutch, rate) = (random.below(2), random.between(20_000.0, 80_000.0));
            let [own, other] = [0; 2].map(|_| 1 + random.below(40));
            let (ratio, format) = match random.below(2) {
                0 => (random.between(0.05, 3.0), 0),
                _ => (own as f64 / other as f64, 1),
            };
            let call = format!(
                "MAG({slave}, {master}, G{place}, {direction}, {ratio}, {own}, {other}, {reference}, {format}, {clutch}, {rate}, 0)"
            );
            assert_eq!(bench.call(&call), OK, "{call}");
            Law::Gear { ratio: sign * ratio }
        }
        kind => {
            let mut points = Vec::new();
            let mut at = random.between(-20.0, 20.0);
            for _ in 0..3 + random.below(5) {
                let linear = kind == 1 || random.below(4) == 0;
                // A CAM has REAL members.
                let single = |value: f64| f64::from(value as f32);
                points.push((single(at), single(random.between(-10.0, 10.0)), u8::from(!linear)));
                at += random.between(3.0, 40.0);
            }
            let entry = random.between(points[0].0, points[points.len() - 1].0);
            let endless = random.below(2) == 0;
            let scales = [random.between(0.2, 3.0), random.between(0.3, 4.0)];
            bench.cam("Cam", &points);
            let made = format!("MCCP(Calc{place}, Cam, {}, 0.25, -0.5, P{place})", points.len());
            assert_eq!(bench.call(&made), OK, "{made}");
            let schedule = if endless { "Continuous" } else { "Persistent" };
            let call = format!(
                "MAPC({slave}, {master}, C{place}, {direction}, P{place}, {}, {}, {schedule}, Immediate, 0, {entry}, {reference}, Bidirectional)",
                scales[0], scales[1]
            );
            assert_eq!(bench.call(&call), OK, "{call}");
            let kinds = points.iter().map(|(x, y, kind)| Point {
                x: *x,
                y: *y,
                kind: if *kind == 0 {
                    SegmentType::Linear
                } else {
                    SegmentType::Cubic
                },
            });
            let profile =
                Profile::calculate(&kinds.collect::<Vec<_>>(), 0.25, -0.5).expect("the instruction made it too");
            Law::Cam {
                profile,
                entry,
                scales: [sign * scales[0], scales[1]],
                endless,
            }
        }
    };
    // A cam is entered where the master is now, a gear when it has locked.
    let met = matches!(law, Law::Cam { .. }).then(|| [position(bench, master, actual), position(bench, slave, false)]);
    Chain {
        slave,
        master,
        actual,
        law,
        met,
    }
}

#[test]
fn a_slave_is_where_its_master_makes_it_be_at_every_period() {
    for case in 0..cases() {
        let mut random = Random(2_000_000 + case);
        let period = *random.one_of(&[0.25, 1.0, 4.0]);
        let mut bench = bench(period);
        let first = *random.one_of(&["A2", "P"]);
        let (second, third) = *random.one_of(&[("A1", "B1"), ("Q", "C1"), ("A1", "R"), ("Q", "R")]);
        let jog = |random: &mut Random, bench: &mut Bench| {
            let speed = random.between(-300.0, 300.0);
            let shape = *random.one_of(&["0, 100, 100, 2", "1, 50, 80, 2"]);
            let call = format!(
                "MAJ({first}, J, {}, {}, 0, 3000, 0, 3000, 0, {shape}, Disabled, Programmed);",
                u8::from(speed < 0.0),
                speed.abs()
            );
            assert_eq!(bench.call(&call), OK, "{call}");
        };
        if random.below(2) == 0 {
            jog(&mut random, &mut bench);
            bench.run(1 + random.below(200));
        }
        let mut chains = vec![bind(&mut random, &mut bench, 1, second, first)];
        bench.run(random.below(30));
        chains.push(bind(&mut random, &mut bench, 2, third, second));
        for _ in 0..20 {
            jog(&mut random, &mut bench);
            for _ in 0..1 + random.below(60) {
                // Before its feedback comes, a master is expected as far behind its command as at the last update.
                let lag = |chain: &Chain| {
                    let axis = bench.axis(chain.master);
                    if chain.actual {
                        axis.command[0] - axis.actual[0]
                    } else {
                        0.0
                    }
                };
                let lags: Vec<f64> = chains.iter().map(lag).collect();
                bench.tick();
                for (chain, lag) in chains.iter_mut().zip(lags) {
                    let now = [
                        position(&bench, chain.master, false) - lag,
                        position(&bench, chain.slave, false),
                    ];
                    let locked = match chain.law {
                        Law::Gear { .. } => bench.axis(chain.slave).motion_status & GEARING_LOCK_STATUS != 0,
                        Law::Cam { .. } => true,
                    };
                    if !locked {
                        continue;
                    }
                    let [master, slave] = *chain.met.get_or_insert(now);
                    let expected = slave + chain.law.at(now[0] - master);
                    let size =
                        now[0].abs().max(master.abs()) * chain.law.steepness() + now[1].abs() + slave.abs() + 100.0;
                    assert!(
                        (now[1] - expected).abs() <= 32.0 * f64::EPSILON * size,
                        "case {case} at {period} ms: {} is not {expected}: {chain:?}",
                        now[1]
                    );
                }
            }
        }
        assert!(
            chains.iter().all(|chain| chain.met.is_some()),
            "case {case}: {chains:?}"
        );
    }
}
