//! Random lines, arcs, merges, changes of dynamics and stops of both profiles, at any instant, with moves and jogs of single axes
//! among them, or of one axis alone: no speed exceeds 1.5 times the programmed one, no velocity steps by more than the rates of the
//! program, a stop, a merge or a change goes no further than the dynamics before it would need to rest, and all motion ends
//! (spec/coordinated-instructions.md §5.4, §6.3).
#![allow(missing_docs)]

mod bounds;
mod found;

use std::fmt::Write;

use arcline_instruction_set::Flag;
use arcline_profile::KinematicState;

use arcline_tests::bench::Bench;
use arcline_tests::random::{Random, seeds};
use bounds::{Beside, Coasting, Dynamics, PERIOD, at_most};

const FASTEST: f64 = 200.0;
/// A move that is slower continues at a present speed, units/s: programmed are 10 and more.
const SLOWEST: f64 = 1.0;

/// The contents of a program.
#[derive(Clone, Copy, PartialEq)]
enum Kind {
    /// Coordinated moves.
    Moves,
    /// The same, all with equal dynamics.
    Equal,
    /// Instructions of single axes among them: their speeds add up.
    Superposed,
    /// Instructions of one axis alone, each in place of the one before it.
    OneAxis,
    /// Coordinated moves on planned contours.
    Contours,
}

struct Program {
    bench: Bench,
    random: Random,
    text: String,
    kind: Kind,
    /// Dynamics of all moves where they are equal.
    equal: Option<Dynamics>,
    tags: u32,
    /// The largest programmed speeds: of coordinated moves, of moves and of jogs of an axis.
    largest: [f64; 3],
    /// The hardest rates of them, and of stops.
    hardest: [f64; 3],
    /// The largest centripetal acceleration of an arc per square of its speed: the curvature.
    curvature: f64,
    /// Coordinated moves, with their present dynamics.
    moves: Vec<(String, Dynamics)>,
    /// The motion of one axis alone: the Motion Type of MCD, and its dynamics.
    alone: Option<(u64, Dynamics)>,
    coasting: Option<Coasting>,
    beside: Option<Beside>,
}

/// The default machine with planned contours.
fn on_contours() -> Bench {
    Bench::replacing("name = \"XY\"", "name = \"XY\"\ncorner = \"precise\"")
}

impl Program {
    fn new(seed: u64) -> Self {
        let kind = match seed % 8 {
            0 | 4 => Kind::Equal,
            3 => Kind::Superposed,
            7 => Kind::OneAxis,
            _ => Kind::Moves,
        };
        Self::of(kind, Bench::new(), seed)
    }

    fn on_contours(seed: u64) -> Self {
        Self::of(Kind::Contours, on_contours(), seed)
    }

    fn of(kind: Kind, bench: Bench, seed: u64) -> Self {
        let mut program = Program {
            bench,
            random: Random(seed),
            text: String::new(),
            kind,
            equal: None,
            tags: 0,
            largest: [0.0; 3],
            hardest: [0.0; 3],
            curvature: 0.0,
            moves: Vec::new(),
            alone: None,
            coasting: None,
            beside: None,
        };
        if kind == Kind::Equal {
            let profile = program.random.below(2);
            program.equal = Some(program.dynamics(0, profile));
        }
        program
    }

    /// Executes a call; returns whether it was accepted.
    fn execute(&mut self, call: &str) -> bool {
        let _ = writeln!(self.text, "{call};");
        let (error, _) = self.bench.call(call);
        assert!([0, 23, 43, 52, 78].contains(&error), "{error} of {call}");
        error == 0
    }

    fn rate(&mut self) -> f64 {
        50.0 * 80.0_f64.powf(self.random.between(0.0, 1.0))
    }

    /// Speed, rates and jerks of a kind of motion.
    fn dynamics(&mut self, kind: usize, profile: u64) -> Dynamics {
        let speed = self.random.between(10.0, FASTEST);
        let jerk = 2.0 * 50.0_f64.powf(self.random.between(0.0, 1.0));
        let (up, down) = (self.rate(), self.rate());
        self.largest[kind] = self.largest[kind].max(speed);
        self.harder(kind, up.max(down));
        Dynamics {
            speed,
            acceleration: up,
            deceleration: down,
            jerk: (profile == 1).then_some(jerk),
        }
    }

    /// The same, and Merge Speed. With Current, the motion continues at its present speed; only jerks in percent of time depend on the Speed.
    fn merging_dynamics(&mut self, kind: usize, profile: u64, moves: bool) -> (Dynamics, u32) {
        let largest = self.largest;
        let dynamics = self.dynamics(kind, profile);
        if !moves || self.random.below(2) == 0 {
            return (dynamics, 0);
        }
        self.largest = largest;
        (
            Dynamics {
                speed: 10.0,
                ..dynamics
            },
            1,
        )
    }

    fn harder(&mut self, kind: usize, rate: f64) {
        self.hardest[kind] = self.hardest[kind].max(rate);
    }

    /// The motion of the coordinate system along its path, or of X alone.
    fn state(&self) -> KinematicState {
        let [x, y] = ["X", "Y"].map(|axis| self.bench.axis(axis).command);
        let speed = x[1].hypot(y[1]);
        let change = if speed > 0.0 {
            (x[1] * x[2] + y[1] * y[2]) / speed
        } else {
            0.0
        };
        KinematicState {
            position: 0.0,
            velocity: speed,
            acceleration: change,
        }
    }

    /// The dynamics of the coordinated move that is under way alone: not in a blend, and not behind a merge that ramps out.
    fn active(&self) -> Option<Dynamics> {
        if self.kind == Kind::Superposed
            || self.beside.is_some()
            || self.bench.system("XY").motion_status & (1 << 7) != 0
        {
            return None;
        }
        let mut active = self
            .moves
            .iter()
            .filter(|(tag, _)| self.bench.control(tag).has(Flag::Ac));
        let only = active.next().map(|(_, dynamics)| *dynamics);
        only.filter(|_| active.next().is_none())
    }

    fn tag(&mut self, kind: &str) -> String {
        self.tags += 1;
        format!("{kind}{}", self.tags)
    }

    fn coordinated(&mut self) {
        let (tag, profile) = (self.tag("M"), self.random.below(2));
        let dynamics = match self.equal {
            Some(equal) => equal,
            None => self.dynamics(0, profile),
        };
        let merge = [0, 0, 1, 1, 2][self.random.below(5) as usize];
        let termination = [0, 1, 2, 3, 6][self.random.below(5) as usize];
        let current = self.random.below(2);
        let rest = format!("{}, {termination}, {merge}, {current}, 5", text(&dynamics));
        let (x, y) = (self.random.between(-60.0, 60.0), self.random.between(-60.0, 60.0));
        let before = self.active();
        let from = self.state();
        let at = ["X", "Y"].map(|axis| self.bench.position(axis));
        let arc = self.random.below(4) == 0;
        let (call, to) = if arc {
            let direction = self.random.below(2);
            let ends = format!("[{:.3}, {:.3}], 3, [{x:.3}, {y:.3}]", 2.0 * x, 2.0 * y);
            (format!("MCCM(XY, {tag}, 1, {ends}, {direction}, {rest})"), [0.0; 2])
        } else {
            let incremental = self.random.below(2);
            let origin = if incremental == 1 { at } else { [0.0; 2] };
            let to = [origin[0] + x, origin[1] + y];
            (format!("MCLM(XY, {tag}, {incremental}, [{x:.3}, {y:.3}], {rest})"), to)
        };
        if !self.execute(&call) {
            return;
        }
        if arc {
            self.curvature = self.curvature.max(1.0 / x.hypot(y));
        }
        if merge != 0 && from.velocity > 0.0 {
            self.coasting = None;
            let most = match before {
                Some(before) if !arc => at_most(before.distance_to_rest(from), from),
                // An arc bulges, and residuals behind another merge add up.
                _ => f64::INFINITY,
            };
            self.beside = Some(Beside {
                tag: tag.clone(),
                why: format!("{call} out of {before:?} at {from:?}"),
                from: at,
                to,
                most,
            });
        }
        self.moves.push((tag, dynamics));
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
        self.harder(kind, if a == 1 { up } else { 0.0 });
        self.harder(kind, if d == 1 { down } else { 0.0 });
        let rest = match scope {
            Some(scope) => format!("0, {a}, {up:.3}, 0, {d}, {down:.3}, 0, 0, 0, 0, 0, 0, {scope}"),
            None => format!("{a}, {up:.3}, {d}, {down:.3}, 0, 0, 0, 0, 0, 0, 0, 0"),
        };
        let from = self.state();
        let before = match scope {
            Some(_) => self.active(),
            None => self.alone.map(|(_, dynamics)| dynamics),
        };
        let whole = format!("{call}, 1, {speed:.3}, {rest})");
        let accepted = self.execute(&whole);
        if accepted {
            self.coasting = None;
            // A gentler path overshoots its end, and with it the compensation.
            if let Some(beside) = &mut self.beside {
                beside.most = f64::INFINITY;
            }
            let change = |dynamics: &mut Dynamics| {
                dynamics.changed(speed, (a == 1).then_some(up), (d == 1).then_some(down));
            };
            match scope {
                Some(scope) => {
                    for (tag, dynamics) in &mut self.moves {
                        if is_changed(&self.bench, tag, scope) {
                            change(dynamics);
                        }
                    }
                }
                None => {
                    if let Some((kind, dynamics)) = &mut self.alone {
                        change(dynamics);
                        of_the_whole_change(*kind, dynamics, from);
                    }
                }
            }
            if let (Some(before), true) = (before, speed == 0.0) {
                let active = self.moves.iter().find(|(tag, _)| self.bench.control(tag).has(Flag::Ac));
                self.coasting = Some(Coasting {
                    why: format!("{whole} of {before:?} at {from:?}"),
                    paused: active.map(|(tag, _)| tag.clone()),
                    gone: 0.0,
                    most: self.most_to_rest(from, |from| before.distance_to_rest(from)),
                });
            }
        }
        if speed == 0.0 {
            let ticks = self.random.below(300);
            self.run(ticks);
            let rest = match scope {
                Some(scope) => format!("0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, {scope}"),
                None => "0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0".to_owned(),
            };
            let resumed = self.execute(&format!("{call}, 1, 60, {rest})"));
            self.coasting = None;
            self.largest[kind] = self.largest[kind].max(60.0);
            for (tag, dynamics) in &mut self.moves {
                if resumed && scope.is_some_and(|scope| is_changed(&self.bench, tag, scope)) {
                    dynamics.changed(60.0, None, None);
                }
            }
            let from = self.state();
            if let (None, Some((kind, dynamics))) = (scope, &mut self.alone) {
                dynamics.changed(60.0, None, None);
                of_the_whole_change(*kind, dynamics, from);
            }
        }
    }

    fn axis(&mut self) {
        let axis = ["X", "Y"][self.random.below(2) as usize];
        let (profile, merge) = (self.random.below(2), self.random.below(3) / 2);
        // A move that continued at a present speed of nearly 0 beside others would take hours.
        let current = u64::from(self.bench.axis(axis).command[1].abs() > 5.0) * self.random.below(2);
        match self.random.below(5) {
            0 | 1 => {
                let (tag, dynamics) = (self.tag("A"), self.dynamics(1, profile));
                let to = self.random.between(-60.0, 60.0);
                self.execute(&format!(
                    "MAM({axis}, {tag}, 0, {to:.3}, {}, {merge}, {current})",
                    text(&dynamics)
                ));
            }
            2 => {
                let (tag, dynamics) = (self.tag("J"), self.dynamics(2, profile));
                let direction = self.random.below(2);
                self.execute(&format!(
                    "MAJ({axis}, {tag}, {direction}, {}, {merge}, {current})",
                    text(&dynamics)
                ));
            }
            3 => {
                let tag = self.tag("D");
                let kind = self.random.below(2);
                self.change(&format!("MCD({axis}, {tag}, {kind}"), 2 - kind as usize, None);
            }
            _ => {
                let (tag, rate) = (self.tag("B"), self.rate());
                let kind = self.random.below(3);
                self.harder(1, rate);
                if kind == 0 {
                    // The axes that moved with it stop at their own maxima.
                    self.harder(1, AXIS_MAXIMUM);
                }
                self.execute(&format!("MAS({axis}, {tag}, {kind}, 1, {rate:.3}, 0, 1, 100, 2)"));
            }
        }
    }

    /// Merges at the present speed again and again, each from the acceleration that the one before it left.
    fn again(&mut self, call: &str, tag: &str, current: u32) {
        if current == 0 || self.random.below(2) == 0 {
            return;
        }
        for number in 0..self.random.below(10) {
            let ticks = 10 + self.random.below(150);
            self.run(ticks);
            self.coasting = None;
            self.execute(&call.replacen(tag, &format!("{tag}N{number}"), 1));
        }
    }

    /// An instruction of X in place of the one before it.
    fn alone(&mut self) {
        let profile = self.random.below(2);
        let from = self.state();
        let velocity = self.bench.axis("X").command[1];
        match (self.random.below(6), self.alone) {
            (0..=2, before) => {
                let tag = self.tag("A");
                let (dynamics, current) = self.merging_dynamics(1, profile, velocity != 0.0);
                let to = self.random.between(-60.0, 60.0);
                let call = format!("MAM(X, {tag}, 0, {to:.3}, {}, 1, {current})", text(&dynamics));
                let turns = (to - self.bench.position("X")) * velocity < 0.0;
                if self.execute(&call) {
                    self.alone = Some((1, dynamics));
                    self.turning(&call, before, from, turns);
                    self.again(&call, &tag, current);
                }
            }
            (3, before) => {
                let tag = self.tag("J");
                let (dynamics, current) = self.merging_dynamics(1, profile, velocity != 0.0);
                let backwards = self.random.below(2) == 1;
                let direction = u32::from(backwards);
                let call = format!("MAJ(X, {tag}, {direction}, {}, 1, {current})", text(&dynamics));
                if self.execute(&call) {
                    let mut whole = dynamics;
                    // The call takes effect within a tick or two.
                    let present = KinematicState {
                        velocity: from.velocity + 2.0 * PERIOD * from.acceleration.max(0.0),
                        ..from
                    };
                    if current == 1 {
                        // The jerk of the acceleration is that of the instruction's own speed.
                        whole.speed = whole.speed.max(present.velocity);
                    }
                    if current == 0 || backwards == (velocity > 0.0) {
                        of_the_whole_change(JOG, &mut whole, present);
                    }
                    self.alone = Some((JOG, whole));
                    self.turning(&call, before, from, backwards == (velocity > 0.0));
                    self.again(&call, &tag, current);
                }
            }
            (4, Some((kind, _))) => {
                let tag = self.tag("D");
                self.change(&format!("MCD(X, {tag}, {kind}"), 1, None);
            }
            (_, Some((_, before))) => {
                let (tag, rate) = (self.tag("B"), self.rate());
                self.harder(1, rate);
                let kind = self.random.below(3);
                let call = format!("MAS(X, {tag}, {kind}, 1, {rate:.3}, 0, 1, 100, 2)");
                let stops = kind == 0 || self.alone.is_some_and(|(moves, _)| kind == 1 + moves);
                if self.execute(&call) && stops {
                    self.stopping(&call, before, from, rate);
                    self.alone = None;
                }
            }
            _ => {}
        }
    }

    /// A motion that turns goes no further before it does than a stop with the dynamics before it or its own would.
    fn turning(&mut self, call: &str, before: Option<(u64, Dynamics)>, from: KinematicState, turns: bool) {
        let own = self.alone.map_or(0.0, |(_, own)| own.distance_to_rest(from));
        self.coasting = before
            .filter(|_| turns && from.velocity > 0.0)
            .map(|(_, before)| Coasting {
                why: format!("{call} of {before:?} at {from:?}"),
                paused: None,
                gone: 0.0,
                most: at_most(before.distance_to_rest(from).max(own), from),
            });
    }

    /// The greatest distance to rest. A planned contour begins to brake within three further updates, and in a curve it has the part of its rates that the
    /// curve leaves (docs/MOTION.md).
    fn most_to_rest(&self, from: KinematicState, distance: impl Fn(KinematicState) -> f64) -> f64 {
        if self.kind != Kind::Contours {
            return at_most(distance(from), from);
        }
        let later = KinematicState {
            velocity: from.velocity + 3.0 * PERIOD * from.acceleration.max(0.0),
            ..from
        };
        at_most(1.05 * distance(later) + 3.0 * PERIOD * later.velocity, from)
    }

    fn stopping(&mut self, call: &str, before: Dynamics, from: KinematicState, rate: f64) {
        let own = |from| before.distance_of_a_stop(from, rate, 100.0);
        let most = self.most_to_rest(from, |from| before.distance_to_rest(from).max(own(from)));
        self.coasting = Some(Coasting {
            why: format!("{call} of {before:?} at {from:?}"),
            paused: None,
            gone: 0.0,
            most,
        });
    }

    fn stop(&mut self) {
        let (tag, rate, before, from) = (self.tag("S"), self.rate(), self.active(), self.state());
        let kind = [0, 2, 2, 3][self.random.below(4) as usize];
        self.harder(0, rate);
        if kind == 0 && self.kind == Kind::Superposed {
            // Motion of single axes stops at the axis's own maximum.
            self.harder(1, AXIS_MAXIMUM);
        }
        let call = format!("MCS(XY, {tag}, {kind}, 1, {rate:.3}, 0, 1, 100, 2)");
        if self.execute(&call) && kind != 3 {
            self.coasting = None;
            if let Some(before) = before {
                self.stopping(&call, before, from, rate);
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
        let axes = match self.kind {
            Kind::Superposed => (moves + jogs) * 2.0_f64.sqrt(),
            _ => moves,
        };
        let most = share * (path + axes);
        let speed = after[0][1].hypot(after[1][1]);
        assert!(
            speed <= most + 1e-9,
            "{speed} units/s, programmed are {path}, {moves}, {jogs}"
        );
        let [path, moves, jogs] = self.hardest;
        let rate = OVERLAP * (path + moves + jogs) + 2.0 * self.curvature * (share * self.largest[0]).powi(2);
        for (b, a) in before.iter().zip(&after) {
            assert!(a.iter().all(|value| value.is_finite()));
            let mean = 0.5 * (a[1] + b[1]) * PERIOD;
            assert!(
                ((a[0] - b[0]) - mean).abs() <= 0.5 * rate * PERIOD * PERIOD + 1e-9,
                "position from {} to {}: more than {rate} units/s²",
                b[0],
                a[0]
            );
            assert!(
                (a[1] - b[1]).abs() <= rate * PERIOD + 1e-9,
                "velocity from {} to {}: more than {rate} units/s²",
                b[1],
                a[1]
            );
        }
        self.check_distances(&before, &after);
    }

    fn check_distances(&mut self, before: &[[f64; 3]; 2], after: &[[f64; 3]; 2]) {
        let rests = after.iter().all(|now| now[1] == 0.0);
        let turns = self.kind == Kind::OneAxis && after[0][1] * before[0][1] <= 0.0;
        if let Some(coasting) = &mut self.coasting {
            let ended = coasting
                .paused
                .as_ref()
                .is_some_and(|tag| self.bench.control(tag).has(Flag::Pc));
            coasting.gone += (after[0][0] - before[0][0]).hypot(after[1][0] - before[1][0]);
            assert!(
                ended || coasting.gone <= coasting.most,
                "{} units since {}, not {}",
                coasting.gone,
                coasting.why,
                coasting.most
            );
            if rests || turns || ended {
                self.coasting = None;
            }
        }
        let active = |beside: &Beside| self.bench.control(&beside.tag).has(Flag::Ac);
        self.beside = self.beside.take().filter(active);
        if let Some(beside) = &self.beside {
            let off = beside.distance([after[0][0], after[1][0]]);
            assert!(
                off <= beside.most,
                "{off} units beside {}, not {}",
                beside.why,
                beside.most
            );
            if rests {
                self.beside = None;
            }
        }
    }

    fn finish(&mut self) {
        for axis in ["X", "Y"] {
            let tag = self.tag("E");
            if matches!(self.kind, Kind::Superposed | Kind::OneAxis) {
                self.execute(&format!("MAS({axis}, {tag}, 1, 1, 500, 0, 1, 100, 2)"));
                self.harder(1, 500.0);
            }
            // A move that continues at a present speed of nearly 0 would take hours.
            if self.kind == Kind::OneAxis {
                self.execute(&format!("MAS({axis}, {tag}M, 2, 1, 500, 0, 1, 100, 2)"));
            }
        }
        let tag = self.tag("C");
        self.execute(&format!(
            "MCCD(XY, {tag}, 1, 1, 100, 0, 1, 2000, 0, 1, 2000, 0, 0, 0, 0, 0, 0, 1)"
        ));
        self.largest[0] = self.largest[0].max(100.0);
        self.harder(0, 2000.0);
        (self.equal, self.coasting, self.beside) = (None, None, None);
        for tick in 0..120_000 {
            // So does one that continues at the present speed of the moves of its axis beside coordinated motion that was faster.
            for axis in ["X", "Y"].into_iter().filter(|_| tick == 60_000) {
                let speed = self.bench.axis(axis).command[1].abs();
                if self.kind == Kind::Superposed && speed > 0.0 && speed < SLOWEST {
                    self.execute(&format!("MAS({axis}, {tag}M, 2, 1, 500, 0, 1, 100, 2)"));
                }
            }
            let still = ["X", "Y"].iter().all(|axis| self.bench.axis(axis).command[1] == 0.0);
            if still && self.bench.system("XY").status & 4 == 0 {
                return;
            }
            self.tick();
        }
        panic!("it does not end");
    }
}

/// MCCD with a scope changes the move of a tag.
fn is_changed(bench: &Bench, tag: &str, scope: u64) -> bool {
    let control = bench.control(tag);
    control.has(Flag::Ip) && (scope == 1 || control.has(Flag::Ac))
}

/// Jerks in percent of time of a jog are of the whole change of its velocity (spec/axis-and-data-types.md §10.3).
fn of_the_whole_change(kind: u64, dynamics: &mut Dynamics, from: KinematicState) {
    if kind == JOG {
        dynamics.speed += from.velocity;
    }
}

/// Operands of a call.
fn text(dynamics: &Dynamics) -> String {
    let Dynamics {
        speed,
        acceleration,
        deceleration,
        jerk,
    } = dynamics;
    let (profile, jerk) = (u32::from(jerk.is_some()), jerk.unwrap_or(100.0));
    format!("{speed:.3}, 0, {acceleration:.3}, 0, {deceleration:.3}, 0, {profile}, {jerk:.3}, {jerk:.3}, 2")
}

fn program(program: &mut Program) {
    for _ in 0..3 + program.random.below(8) {
        match program.random.below(10) {
            _ if program.kind == Kind::OneAxis => program.alone(),
            0..=4 => program.coordinated(),
            5 if program.equal.is_none() => {
                let (tag, scope) = (program.tag("C"), program.random.below(2));
                program.change(&format!("MCCD(XY, {tag}, 1"), 0, Some(scope));
            }
            6 if program.random.below(2) == 0 => program.stop(),
            7 | 8 if program.kind == Kind::Superposed => program.axis(),
            _ => {}
        }
        let ticks = program.random.below(250);
        program.run(ticks);
    }
    program.finish();
}

/// The Motion Type of a MCD of a jog.
const JOG: u64 = 0;
/// Maximum Acceleration and Deceleration of X and Y, units/s².
const AXIS_MAXIMUM: f64 = 10_000.0;
/// The greatest number of programmed rates that act at once: two moves of a blend; or a path and its residual, which is faster
/// if a limited jerk has to stop within the distance of a trapezoid (spec/coordinated-instructions.md §6.3).
const OVERLAP: f64 = 2.5;

#[test]
fn no_program_runs_away() {
    run(Program::new, 2000);
}

#[test]
fn no_program_on_planned_contours_runs_away() {
    // Each plans about ten contours.
    run(Program::on_contours, 200);
}

fn run(start: impl Fn(u64) -> Program, long: u64) {
    let mut failed = Vec::new();
    for seed in seeds(long) {
        let mut one = start(seed);
        let result = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| program(&mut one)));
        if result.is_err() {
            println!("seed {seed}:\n{}", one.text);
            failed.push(seed);
        }
    }
    assert!(failed.is_empty(), "seeds {failed:?}");
}
