//! Random sequences of lines and arcs with random termination types, merges, changes and stops: every one is a
//! Structured Text program that its seed reproduces and that is printed when it fails.
#![allow(missing_docs)]

use std::collections::BTreeMap;
use std::fmt::Write;

use arcline_instruction_set::{ATTRIBUTES, Attribute, Flag, Object, Quantity};
use arcline_tests::bench::{Bench, OK};
use arcline_tests::random::{Random, seeds};

/// Largest rates of a sequence, units/s²: the bound of the change of velocity from tick to tick.
const RATE: f64 = 4000.0;
const PERIOD: f64 = 0.001;
/// Largest jerk of a smooth sequence, units/s³: 2500² / 100 · (200 / 70 - 1).
const JERK: f64 = 116_100.0;

struct Sequence {
    bench: Bench,
    random: Random,
    program: String,
    s_curve: bool,
    moves: u32,
    /// Termination types 4 and 5 make a declared step of the velocity in a corner.
    corners: bool,
    arcs: bool,
    /// S-curves on lines with rates that keep every jerk below [`JERK`]: the acceleration must not step.
    smooth: bool,
    /// Changes of the override at any tick, from a generator of its own.
    overrides: Option<Random>,
    /// Attributes of the coordinate system that are set at any tick, from a generator of its own.
    settings: Option<Random>,
}

impl Sequence {
    fn new(seed: u64) -> Self {
        let mut random = Random(seed);
        let (s_curve, corners, arcs) = (random.below(2) == 0, random.below(4) == 0, random.below(2) == 0);
        let smooth = s_curve && !corners && !arcs;
        Sequence {
            bench: Bench::new(),
            random,
            program: String::new(),
            s_curve,
            moves: 0,
            corners,
            arcs,
            smooth,
            overrides: None,
            settings: None,
        }
    }

    fn under_overrides(seed: u64) -> Self {
        Sequence {
            overrides: Some(Random(!seed)),
            ..Sequence::new(seed)
        }
    }

    fn under_settings(seed: u64) -> Self {
        Sequence {
            settings: Some(Random(!seed)),
            ..Sequence::under_overrides(seed)
        }
    }

    fn execute(&mut self, call: &str) -> (i16, i8) {
        let _ = writeln!(self.program, "{call};");
        self.bench.call(call)
    }

    /// Speed, acceleration and deceleration.
    fn rates(&mut self) -> [f64; 3] {
        let (speed, rate) = if self.smooth { (100.0, 2500.0) } else { (20.0, RATE) };
        [
            self.random.between(speed, 400.0),
            self.random.between(500.0, rate),
            self.random.between(500.0, rate),
        ]
    }

    fn dynamics(&mut self) -> String {
        let [speed, up, down] = self.rates();
        let least = if self.smooth { 70.0 } else { 10.0 };
        let (profile, jerk) = (u8::from(self.s_curve), self.random.between(least, 100.0));
        format!("{speed}, 0, {up}, 0, {down}, 0, {profile}, {jerk}, {jerk}, 2")
    }

    fn a_move(&mut self) {
        self.moves += 1;
        let tag = format!("M{}", self.moves);
        let types: &[&str] = if self.corners {
            &["0", "1", "2", "3", "4", "5", "6"]
        } else {
            &["0", "1", "2", "3", "6"]
        };
        let termination = types[self.random.below(types.len() as u64) as usize];
        let merge = if self.random.below(8) == 0 {
            1 + self.random.below(2)
        } else {
            0
        };
        let tolerance = self.random.between(0.1, 20.0);
        let (x, y) = (self.random.between(-100.0, 100.0), self.random.between(-100.0, 100.0));
        let dynamics = self.dynamics();
        let rest = format!("{dynamics}, {termination}, {merge}, 0, {tolerance}");
        let call = if self.arcs && self.random.below(3) == 0 {
            // A full circle, or half of one, about a centre that is given from the start point.
            let (cx, cy) = (self.random.between(5.0, 60.0), self.random.between(-60.0, -5.0));
            let (x, y) = if self.random.below(2) == 0 {
                (0.0, 0.0)
            } else {
                (2.0 * cx, 2.0 * cy)
            };
            let direction = self.random.below(2);
            format!("MCCM(XY, {tag}, 1, [{x}, {y}], 3, [{cx}, {cy}], {direction}, {rest})")
        } else {
            format!("MCLM(XY, {tag}, 0, [{x}, {y}], {rest})")
        };
        let result = self.execute(&call);
        // A full queue and a stop under way are errors of the sequence, not of the planner.
        assert!([0, 43, 78].contains(&result.0), "{result:?} of {call}");
    }

    fn change(&mut self) {
        let [mut speed, up, down] = self.rates();
        if self.random.below(6) == 0 {
            speed = 0.0;
        }
        let scope = self.random.below(2);
        let (accel, decel) = (self.random.below(2), self.random.below(2));
        let call =
            format!("MCCD(XY, C1, 1, 1, {speed}, 0, {accel}, {up}, 0, {decel}, {down}, 0, 0, 0, 0, 0, 0, {scope})");
        let result = self.execute(&call);
        assert!([0, 23, 78].contains(&result.0), "{result:?} of {call}");
        if speed == 0.0 && result == OK {
            self.run(100);
            self.execute("MCCD(XY, C2, 1, 1, 150, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1)");
        }
    }

    fn run(&mut self, ticks: u64) {
        let _ = writeln!(self.program, "DELAY({});", ticks as f64 * PERIOD);
        for _ in 0..ticks {
            self.tick();
        }
    }

    /// Makes one tick: no axis jumps, and the commanded velocity is that of the commanded positions.
    fn tick(&mut self) {
        let before = ["X", "Y"].map(|axis| self.bench.axis(axis).command);
        if let Some(random) = &mut self.overrides
            && random.below(30) == 0
        {
            let share = if random.below(3) == 0 {
                0.0
            } else {
                random.between(0.0, 1.0)
            };
            self.bench.set_override("XY", share);
        }
        if let Some(random) = &mut self.settings
            && random.below(30) == 0
        {
            let (quantity, value) = setting(random);
            self.bench
                .set_attribute(Object::CoordinateSystem, "XY", quantity, value);
        }
        self.bench.tick();
        let after = ["X", "Y"].map(|axis| self.bench.axis(axis).command);
        for (b, a) in before.iter().zip(&after) {
            assert!(a.iter().all(|value| value.is_finite()));
            if self.corners {
                continue;
            }
            if self.smooth {
                let step = (a[2] - b[2]).abs();
                assert!(step <= 3.0 * JERK * PERIOD, "acceleration from {} to {}", b[2], a[2]);
            }
            // Two moves and a residual can be superposed, and an arc adds its centripetal acceleration.
            let centripetal = if self.arcs { 400.0 * 400.0 / 7.0 } else { 0.0 };
            let most = (3.0 * RATE + centripetal) * PERIOD;
            assert!((a[1] - b[1]).abs() <= most, "velocity from {} to {}", b[1], a[1]);
            let mean = 0.5 * (a[1] + b[1]) * PERIOD;
            assert!(
                ((a[0] - b[0]) - mean).abs() <= most * PERIOD,
                "position from {} to {}",
                b[0],
                a[0]
            );
        }
    }

    fn finish(&mut self) {
        for _ in 0..if self.overrides.is_some() { 300 } else { 0 } {
            self.tick();
        }
        self.overrides = None;
        self.bench.set_override("XY", 1.0);
        for _ in 0..200_000 {
            if self.bench.system("XY").status & 4 == 0 {
                break;
            }
            self.tick();
        }
        self.bench.until_rest();
        self.bench.tick();
    }

    /// Every instruction that was executed ended in exactly one way.
    fn check_ends(&self) {
        let mut ends: BTreeMap<u64, u32> = BTreeMap::new();
        for (_, event) in &self.bench.events {
            let count = ends.entry(event.ticket.0).or_default();
            let ended = event.set & (Flag::Er.mask() | Flag::Pc.mask()) != 0
                || event.clear & Flag::Ip.mask() != 0
                || (event.set & Flag::Dn.mask() != 0 && event.set & Flag::Ip.mask() == 0);
            *count += u32::from(ended);
        }
        for (ticket, ends) in ends {
            assert_eq!(ends, 1, "execution {ticket} ended {ends} times");
        }
        for tag in (1..=self.moves).map(|place| format!("M{place}")) {
            let shown = self.bench.control(&tag);
            assert!(
                !shown.has(Flag::Ip) && !shown.has(Flag::Ac),
                "{tag} shows {}",
                self.bench.bits(&tag)
            );
        }
    }
}

/// A settable attribute of the coordinate system XY and a value for it: a maximum is at most that of the configuration.
fn setting(random: &mut Random) -> (Quantity, f64) {
    let settable: Vec<&Attribute> = ATTRIBUTES
        .iter()
        .filter(|one| one.object == Object::CoordinateSystem && one.is_settable())
        .collect();
    let quantity = random.one_of(&settable).quantity;
    let value = match quantity {
        Quantity::MaximumSpeed => random.between(50.0, 500.0),
        Quantity::MaximumAcceleration | Quantity::MaximumDeceleration => random.between(500.0, 5000.0),
        Quantity::MaximumAccelerationJerk | Quantity::MaximumDecelerationJerk => random.between(1e4, 1e5),
        Quantity::ActualPositionTolerance => random.between(0.001, 1.0),
        Quantity::CommandPositionTolerance => random.between(0.0, 20.0),
        Quantity::DynamicsConfigurationBits => random.below(8) as f64,
        Quantity::HomePosition | Quantity::HomeOffset | Quantity::HomeSpeed | Quantity::HomeReturnSpeed => {
            unreachable!("an attribute of axes")
        }
    };
    (quantity, value)
}

fn sequence(sequence: &mut Sequence) {
    for _ in 0..4 + sequence.random.below(10) {
        match sequence.random.below(12) {
            0..=6 => sequence.a_move(),
            7 | 8 => sequence.change(),
            9 if sequence.random.below(3) == 0 => {
                let stop = sequence.random.below(2) * 2;
                let result = sequence.execute(&format!("MCS(XY, S1, {stop})"));
                assert_eq!(result, OK);
            }
            _ => {
                let ticks = 1 + sequence.random.below(400);
                sequence.run(ticks);
            }
        }
    }
    sequence.finish();
    sequence.check_ends();
}

#[test]
fn random_sequences_are_continuous_and_every_instruction_ends_once() {
    for seed in seeds(300) {
        let mut one = Sequence::new(seed);
        let result = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| sequence(&mut one)));
        assert!(result.is_ok(), "seed {seed}:\n{}", one.program);
    }
}

#[test]
fn overrides_at_any_tick_leave_random_sequences_continuous() {
    for seed in seeds(60) {
        let mut one = Sequence::under_overrides(seed);
        let result = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| sequence(&mut one)));
        assert!(result.is_ok(), "seed {seed}:\n{}", one.program);
    }
}

#[test]
fn attributes_that_are_set_at_any_tick_leave_random_sequences_continuous() {
    for seed in seeds(60) {
        let mut one = Sequence::under_settings(seed);
        let result = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| sequence(&mut one)));
        assert!(result.is_ok(), "seed {seed}:\n{}", one.program);
    }
}

#[test]
fn a_storm_of_changes_stays_continuous_and_ends_on_the_target() {
    let mut bench = Bench::replacing("coarse_update_period_ms = 1.0", "coarse_update_period_ms = 0.25");
    let mut random = Random(7);
    bench.execute("MCLM(CS1, M1, 0, [5000, 0, 0], 200, 0, 2000, 0, 2000, 0, 1, 100000, 100000, 0, 1)");
    let ticks = std::env::var("ARCLINE_STORM").map_or(20_000, |ticks| ticks.parse().expect("a number"));
    let mut before = bench.axis("X").command;
    for _ in 0..ticks {
        let (v, a, d) = (
            random.between(1.0, 50.0),
            random.between(100.0, 3000.0),
            random.between(100.0, 3000.0),
        );
        let (ja, jd) = (random.between(1e4, 1e5), random.between(1e4, 1e5));
        bench.execute(&format!(
            "MCCD(CS1, C, 1, 1, {v}, 0, 1, {a}, 0, 1, {d}, 0, 1, {ja}, 1, {jd}, 0, 0)"
        ));
        bench.tick();
        let now = bench.axis("X").command;
        assert!(
            (now[1] - before[1]).abs() <= 3000.0 * 0.000_25 * 1.01,
            "velocity {} {}",
            before[1],
            now[1]
        );
        assert!(
            (now[2] - before[2]).abs() <= 1e5 * 0.000_25 * 1.01,
            "acceleration {} {}",
            before[2],
            now[2]
        );
        before = now;
        if bench.control("M1").has(Flag::Pc) {
            break;
        }
    }
    bench.execute("MCCD(CS1, C, 1, 1, 500, 0, 1, 5000, 0, 1, 5000, 0)");
    bench.until("M1", Flag::Pc);
    assert_eq!(bench.axis("X").command, [5000.0, 0.0, 0.0]);
}
