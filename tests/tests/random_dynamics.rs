//! Random lines, arcs, merges, changes of dynamics and stops of both profiles, at any instant, with moves and jogs of single axes
//! among them: no speed exceeds 1.5 times what is programmed, nothing steps, everything ends.
//!
//! `ARCLINE_CASES` sets how many programs are run (2,000 unless told; 100,000 in a nightly run), `ARCLINE_SEED` the first (0).
#![allow(missing_docs)]

use std::fmt::Write;

use arcline_tests::bench::Bench;
use arcline_tests::random::Random;

const PERIOD: f64 = 0.001;
const FASTEST: f64 = 200.0;

struct Program {
    bench: Bench,
    random: Random,
    text: String,
    /// Dynamics of all moves; `None`: of each its own.
    equal: Option<String>,
    /// Instructions of single axes among them: their speeds add up.
    single: bool,
    tags: u32,
    /// The largest programmed speeds: of coordinated moves, of moves and of jogs of an axis.
    largest: [f64; 3],
}

impl Program {
    fn new(seed: u64) -> Self {
        let mut program = Program {
            bench: Bench::new(),
            random: Random(seed),
            text: String::new(),
            equal: None,
            single: seed % 4 == 3,
            tags: 0,
            largest: [0.0; 3],
        };
        if seed.is_multiple_of(4) {
            let profile = program.random.below(2);
            program.equal = Some(program.dynamics(0, profile));
        }
        program
    }

    fn execute(&mut self, call: &str) {
        let _ = writeln!(self.text, "{call};");
        let (error, _) = self.bench.call(call);
        assert!([0, 23, 43, 52, 78].contains(&error), "{error} of {call}");
    }

    fn rate(&mut self) -> f64 {
        50.0 * 80.0_f64.powf(self.random.between(0.0, 1.0))
    }

    /// Speed, rates and jerks of a kind of motion.
    fn dynamics(&mut self, kind: usize, profile: u64) -> String {
        let speed = self.random.between(10.0, FASTEST);
        self.largest[kind] = self.largest[kind].max(speed);
        let (up, down, jerk) = (self.rate(), self.rate(), self.random.between(20.0, 100.0));
        format!("{speed:.3}, 0, {up:.3}, 0, {down:.3}, 0, {profile}, {jerk:.3}, {jerk:.3}, 2")
    }

    fn tag(&mut self, kind: &str) -> String {
        self.tags += 1;
        format!("{kind}{}", self.tags)
    }

    fn coordinated(&mut self) {
        let (tag, profile) = (self.tag("M"), self.random.below(2));
        let dynamics = match &self.equal {
            Some(equal) => equal.clone(),
            None => self.dynamics(0, profile),
        };
        let merge = [0, 0, 1, 1, 2][self.random.below(5) as usize];
        let termination = [0, 1, 2, 3, 6][self.random.below(5) as usize];
        let rest = format!("{dynamics}, {termination}, {merge}, {}, 5", self.random.below(2));
        let (x, y) = (self.random.between(-60.0, 60.0), self.random.between(-60.0, 60.0));
        let call = if self.random.below(4) == 0 {
            format!(
                "MCCM(XY, {tag}, 1, [{:.3}, {:.3}], 3, [{x:.3}, {y:.3}], {}, {rest})",
                2.0 * x,
                2.0 * y,
                self.random.below(2)
            )
        } else {
            format!("MCLM(XY, {tag}, {}, [{x:.3}, {y:.3}], {rest})", self.random.below(2))
        };
        self.execute(&call);
    }

    /// `call`: up to Motion Type; `scope`: of a MCCD, whose units stand behind each value; those of a MCD stand at its end.
    fn change(&mut self, call: &str, kind: usize, scope: Option<u64>) {
        let speed = if self.random.below(4) == 0 {
            0.0
        } else {
            self.random.between(10.0, FASTEST)
        };
        self.largest[kind] = self.largest[kind].max(speed);
        let (up, down) = (self.rate(), self.rate());
        let (a, d) = (self.random.below(2), self.random.below(2));
        let rest = match scope {
            Some(scope) => format!("0, {a}, {up:.3}, 0, {d}, {down:.3}, 0, 0, 0, 0, 0, 0, {scope}"),
            None => format!("{a}, {up:.3}, {d}, {down:.3}, 0, 0, 0, 0, 0, 0, 0, 0"),
        };
        self.execute(&format!("{call}, 1, {speed:.3}, {rest})"));
        if speed == 0.0 {
            let ticks = self.random.below(300);
            self.run(ticks);
            let rest = match scope {
                Some(scope) => format!("0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, {scope}"),
                None => "0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0".to_owned(),
            };
            self.execute(&format!("{call}, 1, 60, {rest})"));
            self.largest[kind] = self.largest[kind].max(60.0);
        }
    }

    fn axis(&mut self) {
        let axis = ["X", "Y"][self.random.below(2) as usize];
        let (profile, merge) = (self.random.below(2), self.random.below(3) / 2);
        match self.random.below(5) {
            0 | 1 => {
                let (tag, dynamics) = (self.tag("A"), self.dynamics(1, profile));
                let to = self.random.between(-60.0, 60.0);
                self.execute(&format!("MAM({axis}, {tag}, 0, {to:.3}, {dynamics}, {merge}, 0)"));
            }
            2 => {
                let (tag, dynamics) = (self.tag("J"), self.dynamics(2, profile));
                let way = self.random.below(2);
                self.execute(&format!("MAJ({axis}, {tag}, {way}, {dynamics}, {merge}, 0)"));
            }
            3 => {
                let tag = self.tag("D");
                let kind = self.random.below(2);
                self.change(&format!("MCD({axis}, {tag}, {kind}"), 2 - kind as usize, None);
            }
            _ => {
                let (tag, rate) = (self.tag("B"), self.rate());
                let kind = self.random.below(3);
                self.execute(&format!("MAS({axis}, {tag}, {kind}, 1, {rate:.3}, 0, 1, 100, 2)"));
            }
        }
    }

    fn run(&mut self, ticks: u64) {
        let _ = writeln!(self.text, "DELAY({});", ticks as f64 * PERIOD);
        for _ in 0..ticks {
            self.tick();
        }
    }

    fn tick(&mut self) {
        let before = ["X", "Y"].map(|axis| self.bench.axis(axis).command);
        self.bench.tick();
        let after = ["X", "Y"].map(|axis| self.bench.axis(axis).command);
        let [path, moves, jogs] = self.largest;
        let share = if self.equal.is_some() {
            1.0 + 1e-5
        } else {
            1.5 * (1.0 + 1e-9)
        };
        let axes = if self.single {
            (moves + jogs) * 2.0_f64.sqrt()
        } else {
            0.0
        };
        let most = share * (path + axes);
        let speed = after[0][1].hypot(after[1][1]);
        assert!(
            speed <= most + 1e-9,
            "{speed} units/s, programmed are {path}, {moves}, {jogs}"
        );
        for (b, a) in before.iter().zip(&after) {
            assert!(a.iter().all(|value| value.is_finite()));
            let mean = 0.5 * (a[1] + b[1]) * PERIOD;
            assert!(
                ((a[0] - b[0]) - mean).abs() <= 0.04,
                "position from {} to {}",
                b[0],
                a[0]
            );
            // Twice the hardest rates, for each of what is superposed, and what an arc asks across.
            let step = (a[1] - b[1]).abs();
            assert!(step <= 50.0, "velocity from {} to {}", b[1], a[1]);
        }
    }

    fn finish(&mut self) {
        for axis in ["X", "Y"] {
            let tag = self.tag("E");
            if self.single {
                self.execute(&format!("MAS({axis}, {tag}, 1, 1, 500, 0, 1, 100, 2)"));
            }
        }
        let tag = self.tag("C");
        self.execute(&format!(
            "MCCD(XY, {tag}, 1, 1, 100, 0, 1, 2000, 0, 1, 2000, 0, 0, 0, 0, 0, 0, 1)"
        ));
        self.largest[0] = self.largest[0].max(100.0);
        self.equal = None;
        for _ in 0..120_000 {
            let still = ["X", "Y"].iter().all(|axis| self.bench.axis(axis).command[1] == 0.0);
            if still && self.bench.system("XY").status & 4 == 0 {
                return;
            }
            self.tick();
        }
        panic!("it does not end");
    }
}

fn program(program: &mut Program) {
    for _ in 0..3 + program.random.below(8) {
        match program.random.below(10) {
            0..=4 => program.coordinated(),
            5 if program.equal.is_none() => {
                let (tag, scope) = (program.tag("C"), program.random.below(2));
                program.change(&format!("MCCD(XY, {tag}, 1"), 0, Some(scope));
            }
            6 if program.random.below(2) == 0 => {
                let (tag, rate) = (program.tag("S"), program.rate());
                program.execute(&format!("MCS(XY, {tag}, 2, 1, {rate:.3}, 0, 1, 100, 2)"));
            }
            7 | 8 if program.single => program.axis(),
            _ => {}
        }
        let ticks = program.random.below(250);
        program.run(ticks);
    }
    program.finish();
}

#[test]
fn no_program_runs_away() {
    let number = |name: &str, usual: u64| std::env::var(name).map_or(usual, |set| set.parse().expect("a number"));
    let first = number("ARCLINE_SEED", 0);
    for seed in first..first + number("ARCLINE_CASES", 2000) {
        let mut one = Program::new(seed);
        let result = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| program(&mut one)));
        assert!(result.is_ok(), "seed {seed}:\n{}", one.text);
    }
}
