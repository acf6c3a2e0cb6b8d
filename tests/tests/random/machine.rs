//! Random sequences of everything that moves, stops and switches axes, on coordinate systems that overlap: no jump, no
//! bit that stays behind, and every instruction ends in exactly one way (spec/axis-and-data-types.md §1.2).
//!
//! Each sequence is a Structured Text program that its seed reproduces and that is printed when it fails.
#![allow(missing_docs)]

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;

use arcline_instruction_set::predefined::{coordinate_motion_status, motion_status};
use arcline_instruction_set::{FaultKind, FaultSet, Flag};
use arcline_tests::bench::Bench;
use arcline_tests::random::{Random, seeds};

const PERIOD: f64 = 0.001;
/// Largest programmed rate, units/s².
const RATE: f64 = 1000.0;
/// Maximum Deceleration of every axis here, units/s²: the rate of stops.
const STOP_RATE: f64 = 2000.0;
/// Axes of the other side of a transform, which add up on an axis.
const SIDES: f64 = 3.0;
/// The generators that can act on an axis at once: two superposed moves, a residual, a move, a jog, a gear, two cams, and a brake
/// of each.
const GENERATORS: f64 = 8.0;

const AXES: [&str; 10] = ["X", "Y", "Z", "S", "A", "B", "C", "RX", "RY", "RZ"];
/// Axes where nothing turns.
const LINEAR: usize = 7;
/// Degrees of a turn where axes are rotary.
const UNWIND: f64 = 360.0;
/// An encoder, which others follow; it is written at every pause.
const ENCODER: &str = "E";
/// Axes with output cams.
const CAMMED: [&str; 3] = ["X", "A", "S"];
const SERVOS: [&str; 4] = ["X", "Y", "Z", "S"];
/// Coordinate systems, and how many axes a line of theirs has. The last one turns too.
const SYSTEMS: [(&str, usize); 5] = [("CS1", 3), ("CS2", 3), ("CS3", 3), ("XY", 2), (TURNING, 3)];
/// A system with orientation: X, Y, Z, RX, RY, RZ.
const TURNING: &str = "Turn";

/// A kind of machine. Each has its own sequences.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Kind {
    /// Linear axes; servos follow without limits.
    Linear,
    /// Rotary axes S, B and C.
    Rotary,
    /// Servos with limits of speed and torque, encoders, and position errors that fault.
    Limited,
    /// A machine with a system that has an orientation, and path moves of it.
    Paths,
}

impl Kind {
    fn configuration(self) -> String {
        let slow = arcline_config::DEFAULT.replace(
            "max_deceleration = 10000.0",
            &format!("max_deceleration = {STOP_RATE:?}"),
        );
        assert_ne!(slow, arcline_config::DEFAULT);
        let home = "home = { sequence = \"switch\", speed = 60.0, acceleration = 1000.0, deceleration = 1000.0, \
                    switch = { min = -20.0, max = 20.0 } }";
        let passive = "home = { mode = \"passive\", sequence = \"marker\", marker = { every = 30.0 } }";
        let mut keys = vec![("X", home), ("Y", passive)];
        match self {
            Kind::Linear | Kind::Paths => {}
            Kind::Rotary => keys.extend(["S", "B", "C"].map(|axis| (axis, "unwind = 360.0"))),
            Kind::Limited => {
                let drive = "drive = { speed_limit = 120.0, torque_limit = 1500.0, encoder_resolution = 100.0, \
                             position_error_tolerance = 20.0 }";
                keys.extend(["X", "Z", "S"].map(|axis| (axis, drive)));
            }
        }
        let tags = "\n[[tag]]\nname = \"Cam\"\ntype = \"CAM[2]\"\n[[tag]]\nname = \"Position\"\ntype = \"CAM_PROFILE[2]\"\n\
                    [[tag]]\nname = \"Time\"\ntype = \"CAM_PROFILE[2]\"\n\
                    [[tag]]\nname = \"Out\"\ntype = \"DINT\"\n[[tag]]\nname = \"In\"\ntype = \"DINT\"\n\
                    [[tag]]\nname = \"Outs\"\ntype = \"OUTPUT_CAM[3]\"\n\
                    value = [{ LatchType = 1, UnlatchType = 1, Left = 5.0, Right = 30.0 }, \
                    { OutputBit = 1, LatchType = 3, UnlatchType = 5, Left = 20.0, Right = 60.0, Duration = 0.05 }, \
                    { OutputBit = 2, LatchType = 2, UnlatchType = 4, Right = 40.0, EnableType = 2 }]\n\
                    [[tag]]\nname = \"Encoder\"\ntype = \"REAL\"\n";
        let encoder = "[[axis]]\nname = \"E\"\ntype = \"feedback\"\nmax_speed = 100.0\nmax_acceleration = 1000.0\n\
                    feed = { tag = \"Encoder\", interval_ms = 50.0, timeout_ms = 10000.0 }\n";
        let turning = if self == Kind::Paths { turning() } else { String::new() };
        keys.extend(CAMMED.map(|axis| (axis, "output_cam_execution_targets = 2")));
        keys.iter()
            .fold(slow + tags + &turning + encoder, |text, (axis, keys)| {
                let name = format!("name = \"{axis}\"\ntype = ");
                assert!(text.contains(&name), "{axis}");
                text.replacen(&name, &format!("{keys}\n{name}"), 1)
            })
    }

    /// The axes, in the order of the configuration.
    fn axes(self) -> &'static [&'static str] {
        if self == Kind::Paths { &AXES } else { &AXES[..LINEAR] }
    }

    /// The coordinate systems, in the order of the configuration.
    fn systems(self) -> &'static [(&'static str, usize)] {
        if self == Kind::Paths {
            &SYSTEMS
        } else {
            &SYSTEMS[..SYSTEMS.len() - 1]
        }
    }
}

/// The system with orientation, its axes, and the tags of its moves.
fn turning() -> String {
    let mut text = "[[tag]]\nname = \"Way\"\ntype = \"PATH_DATA\"\nvalue = { InterpolationType = 1 }\n\
                    [[tag]]\nname = \"Pace\"\ntype = \"DYNAMICS_DATA\"\nvalue = { UnitsMode = 1 }\n"
        .to_owned();
    for axis in &AXES[LINEAR..] {
        let _ = writeln!(
            text,
            "[[axis]]\nname = \"{axis}\"\ntype = \"virtual\"\nmax_speed = 1000.0\nmax_acceleration = 10000.0\ncommand_limits = {{ enabled = true }}\n\
             max_deceleration = {STOP_RATE:?}"
        );
    }
    let axes = ["X", "Y", "Z", "RX", "RY", "RZ"];
    text + &format!(
        "[[coordinate_system]]\nname = \"{TURNING}\"\ndefinition = \"XYZRxRyRz\"\naxes = {axes:?}\nmax_speed = 1000.0\n\
         max_acceleration = 10000.0\nmax_deceleration = {STOP_RATE:?}\nactual_tolerance = 0.01\ncommand_tolerance = 1.0\n"
    )
}

/// Bits of an axis that must be off when nothing moves.
const MOVING: u32 = motion_status::ACCEL_STATUS
    | motion_status::DECEL_STATUS
    | motion_status::MOVE_STATUS
    | motion_status::JOG_STATUS
    | motion_status::GEARING_STATUS
    | motion_status::HOMING_STATUS
    | motion_status::POSITION_CAM_STATUS
    | motion_status::TIME_CAM_STATUS
    | motion_status::POSITION_CAM_PENDING_STATUS
    | motion_status::TIME_CAM_PENDING_STATUS
    | motion_status::MASTER_OFFSET_MOVE_STATUS
    | motion_status::STOPPING_STATUS
    | motion_status::COORDINATED_MOTION_STATUS;

struct Sequence {
    bench: Bench,
    random: Random,
    program: String,
    executed: u32,
    /// Servos are switched and axes fault, so that axes lose their speed and their command at once.
    switching: bool,
    kind: Kind,
    /// The newest value of the encoder's tag.
    encoder: f64,
}

impl Sequence {
    fn new(seed: u64, kind: Kind) -> Self {
        let mut random = Random(seed);
        let switching = random.below(2) == 0;
        let mut sequence = Sequence {
            bench: Bench::with(&kind.configuration()),
            random,
            program: String::new(),
            executed: 0,
            switching,
            kind,
            encoder: 0.0,
        };
        // Motion from rest to rest, so that no axis jumps: at most 0.75 units a unit, and 60 units/s.
        sequence.calculate("Position", 40.0, 20.0);
        sequence.calculate("Time", 0.25, 10.0);
        sequence
    }

    /// A cubic cam from 0 to 0.
    fn calculate(&mut self, profile: &str, length: f64, rise: f64) {
        self.bench.cam("Cam", &[(0.0, 0.0, 1), (length, rise, 1)]);
        let _ = writeln!(
            self.program,
            "Cam[0].SegmentType := 1; Cam[1].SegmentType := 1; Cam[1].Master := {length}; Cam[1].Slave := {rise};"
        );
        self.execute(&format!("MCCP({{tag}}, Cam, 2, 0, 0, {profile})"));
    }

    fn cam(&mut self) {
        let axis = self.axis();
        let (direction, scale) = (self.random.below(4), self.random.between(0.5, 1.0));
        let pending = u64::from(self.random.below(3) == 0);
        let call = if self.random.below(3) == 0 {
            let mode = self.random.below(2);
            format!(
                "MATC({axis}, {{tag}}, {direction}, Time, {scale}, {}, {mode}, {pending})",
                1.0 / scale
            )
        } else {
            let master = self.master();
            let (mode, schedule) = (self.random.below(3), *self.random.one_of(&[0, pending, 2, 3, 4]));
            let (lock, entry) = (self.random.between(0.0, 60.0), *self.random.one_of(&[0, 40]));
            let (reference, way) = (self.random.below(2), self.random.below(3));
            format!(
                "MAPC({axis}, {master}, {{tag}}, {direction}, Position, {scale}, {}, {mode}, {schedule}, {lock}, {entry}, \
                 {reference}, {way})",
                1.0 / scale
            )
        };
        self.execute(&call);
    }

    /// A master offset, if there is a position cam.
    fn offset(&mut self) {
        let (axis, kind, dynamics) = (self.axis(), 5 + self.random.below(2), self.dynamics());
        let position = self.random.between(-30.0, 30.0);
        self.execute(&format!("MAM({axis}, {{tag}}, {kind}, {position}, {dynamics})"));
    }

    /// Arms an output cam, or disarms some.
    fn output(&mut self) {
        let (axis, target) = (*self.random.one_of(&CAMMED), self.random.below(2));
        let call = if self.random.below(4) == 0 {
            format!("MDOC({axis}, {target}, {{tag}}, {})", self.random.below(2))
        } else {
            let (mode, schedule) = (self.random.below(3), self.random.below(5));
            let (at, entry) = (self.random.between(0.0, 60.0), *self.random.one_of(&[0, 25]));
            let reference = self.random.below(2);
            format!(
                "MAOC({axis}, {target}, {{tag}}, Out, In, Outs, 0, 60, 0, {mode}, {schedule}, {at}, {entry}, {reference})"
            )
        };
        self.execute(&call);
        self.write("In", self.executed.into());
    }

    /// Writes a number to a tag.
    fn write(&mut self, tag: &str, number: f64) {
        let _ = writeln!(self.program, "{tag} := {number};");
        self.bench.write(tag, number);
    }

    /// An axis that others follow.
    fn master(&mut self) -> &'static str {
        if self.random.below(5) == 0 {
            ENCODER
        } else {
            self.axis()
        }
    }

    /// Executes an instruction with a motion control tag of its own: `{tag}` stands for it.
    fn execute(&mut self, call: &str) -> (i16, i8) {
        self.executed += 1;
        let call = call.replace("{tag}", &format!("I{}", self.executed));
        let _ = writeln!(self.program, "{call};");
        self.bench.call(&call)
    }

    fn axis(&mut self) -> &'static str {
        // RX and RY only turn along paths, so that RY stays where RX and RZ are unambiguous.
        match self.random.below(self.kind.axes().len().min(LINEAR + 1) as u64) as usize {
            LINEAR => "RZ",
            place => AXES[place],
        }
    }

    /// Speed, rates, profile, jerks and their units, from MCLM's Speed on.
    fn dynamics(&mut self) -> String {
        let speed = self.random.between(10.0, 150.0);
        let [up, down] = [(); 2].map(|()| self.random.between(200.0, RATE));
        let (profile, jerk) = (self.random.below(2), self.random.between(20.0, 100.0));
        format!("{speed}, 0, {up}, 0, {down}, 0, {profile}, {jerk}, {jerk}, 2")
    }

    fn point(&mut self, axes: usize) -> String {
        let values: Vec<String> = (0..axes)
            .map(|_| self.random.between(-60.0, 60.0).to_string())
            .collect();
        format!("[{}]", values.join(", "))
    }

    /// Moves along a path and turns on it.
    fn path(&mut self) {
        let incremental = self.random.below(3) == 0;
        let tilt = if incremental { 0.0 } else { 20.0 };
        for (place, most) in [60.0, 60.0, 60.0, tilt, tilt, 170.0].into_iter().enumerate() {
            let position = self.random.between(-most, most);
            self.write(&format!("Way.Position[{place}]"), position);
        }
        self.write("Way.MoveType", f64::from(u8::from(incremental)));
        let turns = *self.random.one_of(&[0.0, 0.0, 0.0, 1.0, -1.0]);
        self.write("Way.TurnsCounters[2]", turns);
        let (termination, tolerance) = (*self.random.one_of(&[0.0, 1.0, 6.0]), self.random.between(0.0, 20.0));
        self.write("Way.TerminationType", termination);
        self.write("Way.CommandToleranceLinear", tolerance);
        let profile = self.random.below(2) as f64;
        self.write("Pace.Profile", profile);
        for part in ["", "Orientation"] {
            let speed = self.random.between(10.0, 150.0);
            self.write(&format!("Pace.{part}Speed"), speed);
            for rate in ["Acceleration", "Deceleration"] {
                let rate_of = self.random.between(200.0, RATE);
                self.write(&format!("Pace.{part}{rate}"), rate_of);
            }
        }
        let jerk = self.random.between(20.0, 100.0);
        for jerk_of in ["AccelerationJerk", "DecelerationJerk"] {
            self.write(&format!("Pace.{jerk_of}"), jerk);
        }
        self.execute(&format!("MCPM({TURNING}, {{tag}}, Way, 1, Pace)"));
    }

    fn coordinated(&mut self) {
        if self.kind == Kind::Paths && self.random.below(2) == 0 {
            return self.path();
        }
        let (system, axes) = *self.random.one_of(self.kind.systems());
        let (kind, to, dynamics) = (self.random.below(2), self.point(axes), self.dynamics());
        let termination = *self.random.one_of(&[0, 1, 2, 3, 6]);
        let merge = if self.random.below(6) == 0 {
            1 + self.random.below(2)
        } else {
            0
        };
        let rest = format!("{dynamics}, {termination}, {merge}, 0, 5");
        let call = if axes == 2 && self.random.below(2) == 0 {
            let center = self.point(2);
            let direction = self.random.below(4);
            format!("MCCM({system}, {{tag}}, 1, [10, 0], 1, {center}, {direction}, {rest})")
        } else {
            format!("MCLM({system}, {{tag}}, {kind}, {to}, {rest})")
        };
        self.execute(&call);
    }

    fn single_axis(&mut self) {
        let (axis, dynamics) = (self.axis(), self.dynamics());
        let merge = u64::from(self.random.below(4) == 0);
        let call = match self.random.below(8) {
            0..=3 => {
                let (kind, position) = (self.random.below(2), self.random.between(-60.0, 60.0));
                format!("MAM({axis}, {{tag}}, {kind}, {position}, {dynamics}, {merge}, 0)")
            }
            4 | 5 => format!("MAJ({axis}, {{tag}}, {}, {dynamics}, {merge}, 0)", self.random.below(2)),
            6 => {
                let (master, ratio) = (self.master(), self.random.between(0.1, 1.0));
                let (direction, reference) = (self.random.below(4), self.random.below(2));
                format!("MAG({axis}, {master}, {{tag}}, {direction}, {ratio}, 1, 1, {reference}, 0, 0, {RATE}, 0)")
            }
            _ => {
                let (kind, speed) = (self.random.below(2), self.random.between(0.0, 150.0));
                format!("MCD({axis}, {{tag}}, {kind}, 1, {speed}, 0, 0, 1, {RATE}, 0, 0, 0, 0, 0, 0, 0, 0)")
            }
        };
        self.execute(&call);
    }

    fn stop(&mut self) {
        let call = match self.random.below(8) {
            0..=3 => {
                let (axis, kind) = (self.axis(), *self.random.one_of(&[0, 1, 2, 3, 4, 7, 8, 9]));
                format!("MAS({axis}, {{tag}}, {kind}, 1, {RATE}, 0, 0, 0, 2)")
            }
            4..=6 => {
                let (system, _) = *self.random.one_of(self.kind.systems());
                let kind = *self.random.one_of(&[0, 2, 3]);
                // A system with orientation has rates in percent only: of twice the rate.
                let (rate, units) = if system == TURNING { (50.0, 1) } else { (RATE, 0) };
                format!("MCS({system}, {{tag}}, {kind}, 1, {rate}, {units}, 0, 0, 2)")
            }
            _ => "MGS(Motion, {tag}, 1)".to_owned(),
        };
        self.execute(&call);
    }

    fn switch(&mut self) {
        let servo = *self.random.one_of(&SERVOS);
        let (system, _) = *self.random.one_of(self.kind.systems());
        let call = match self.random.below(12) {
            0 => format!("MSF({servo}, {{tag}})"),
            1..=3 => format!("MSO({servo}, {{tag}})"),
            4 => format!("MASD({servo}, {{tag}})"),
            5 | 6 => format!("MASR({servo}, {{tag}})"),
            7 => format!("MCSD({system}, {{tag}})"),
            8 | 9 => format!("MCSR({system}, {{tag}})"),
            10 => "MGS(Motion, {tag}, 2)".to_owned(),
            _ => "MGSR(Motion, {tag})".to_owned(),
        };
        self.execute(&call);
    }

    /// Changes the dynamics of a coordinate system.
    fn change(&mut self) {
        let (system, _) = *self.random.one_of(self.kind.systems());
        let (speed, scope) = (self.random.between(0.0, 150.0), self.random.below(2));
        self.execute(&format!(
            "MCCD({system}, {{tag}}, 1, 1, {speed}, 0, 1, {RATE}, 0, 0, 0, 0, 0, 0, 0, 0, 0, {scope})"
        ));
    }

    /// Homes an axis, or redefines its position.
    fn reference(&mut self) {
        let axis = self.axis();
        let call = match self.random.below(3) {
            0 => format!("MAH({axis}, {{tag}})"),
            _ => {
                let (kind, select) = (self.random.below(2), self.random.below(2));
                let position = self.random.between(0.0, 90.0);
                format!("MRP({axis}, {{tag}}, {kind}, {select}, {position})")
            }
        };
        self.execute(&call);
    }

    /// Puts the cause of a fault on an axis, or removes it and resets the fault.
    fn fault(&mut self) {
        let place = self.random.below(self.kind.axes().len() as u64) as usize;
        let axis = AXES[place];
        let bits = if self.random.below(3) == 0 {
            1u32 << self.random.below(FaultKind::COUNT as u64)
        } else {
            0
        };
        let _ = writeln!(self.program, "FaultInject[{place}] := {bits};");
        let causes: Vec<FaultKind> = FaultSet::from_bits(bits).kinds().collect();
        self.bench.inject(axis, &causes);
        if bits == 0 {
            let reset = *self.random.one_of(&["MAFR", "MASR"]);
            self.execute(&format!("{reset}({axis}, {{tag}})"));
        }
    }

    fn transform(&mut self) {
        let angle = *self.random.one_of(&[0, 30, 90]);
        // A source of servos has to stand where its target says; the other one is put there.
        let pair = *self.random.one_of(&["CS2, CS3", "CS3, CS2", "CS3, CS1"]);
        self.execute(&format!("MCT({pair}, {{tag}}, [0, 0, {angle}], [0, 0, 0])"));
    }

    fn run(&mut self, ticks: u64) {
        // At most 5 units/s, since the encoder's speed steps.
        self.encoder += self.random.between(-0.25, 0.25);
        self.write("Encoder", self.encoder);
        let _ = writeln!(self.program, "DELAY({});", ticks as f64 * PERIOD);
        for _ in 0..ticks {
            self.tick();
        }
    }

    /// Makes one tick: no axis jumps, unless its servo may have been switched.
    fn tick(&mut self) {
        let before = self.bench.snapshot();
        self.bench.tick();
        let after = self.bench.snapshot();
        // A position error has switched a servo off: its command goes to where it is.
        self.switching |= after.axes.iter().any(|axis| axis.faults != FaultSet::default());
        for (name, (before, after)) in self.kind.axes().iter().zip(before.axes.iter().zip(&after.axes)) {
            let (b, a) = (before.command, after.command);
            assert!(
                a.iter().chain(&after.actual).all(|value| value.is_finite()),
                "{name}: {a:?}"
            );
            if self.kind == Kind::Limited && SERVOS.contains(name) && *name != "Y" {
                assert!(
                    after.actual[1].abs() <= 120.0 + 1e-6,
                    "{name}: {} units/s with a limit of 120",
                    after.actual[1]
                );
            }
            if self.switching {
                continue;
            }
            // Each generator of the axis is programmed with at most 150 units/s; home speeds are less.
            let fastest = SIDES * GENERATORS * 150.0;
            assert!(a[1].abs() <= fastest, "{name}: {} units/s", a[1]);
            // An axis of a transform adds up the motion of three axes of the other side.
            let most = SIDES * GENERATORS * STOP_RATE * PERIOD;
            assert!(
                (a[1] - b[1]).abs() <= most,
                "{name}: velocity from {} to {}",
                b[1],
                a[1]
            );
            let mean = 0.5 * (a[1] + b[1]) * PERIOD;
            // Redefinitions are no motion; a rotary axis shows a whole turn less or more.
            let mut travelled = (a[0] - b[0]) - (after.redefined - before.redefined);
            if self.kind == Kind::Rotary && ["S", "B", "C"].contains(name) {
                travelled -= UNWIND * ((travelled - mean) / UNWIND).round();
            }
            assert!(
                (travelled - mean).abs() <= most * PERIOD,
                "{name}: position from {} to {} at {} units/s",
                b[0],
                a[0],
                a[1]
            );
        }
    }

    /// Stops the group; then nothing moves and nothing is left behind.
    fn finish(&mut self) {
        for (place, axis) in self.kind.axes().iter().enumerate() {
            let _ = writeln!(self.program, "FaultInject[{place}] := 0;");
            self.bench.inject(axis, &[]);
        }
        for axis in CAMMED {
            self.execute(&format!("MDOC({axis}, 0, {{tag}}, All)"));
        }
        self.execute("MGS(Motion, {tag}, 1)");
        self.bench.until_rest();
        self.run(3);
        let snapshot = self.bench.snapshot();
        for (name, axis) in self.kind.axes().iter().zip(&snapshot.axes) {
            assert_eq!(axis.motion_status & MOVING, 0, "{name} shows {:#x}", axis.motion_status);
            assert_eq!(axis.command[1..], [0.0, 0.0], "{name}");
            assert_eq!(axis.output_cams, [0; 4], "{name}");
        }
        for ((name, _), system) in self.kind.systems().iter().zip(&snapshot.systems) {
            let moving = system.motion_status
                & !(coordinate_motion_status::ACTUAL_POS_TOLERANCE_STATUS
                    | coordinate_motion_status::COMMAND_POS_TOLERANCE_STATUS);
            assert_eq!(moving, 0, "{name} shows {moving:#x}");
        }
    }

    /// Every instruction ended in exactly one way: with ER, with PC, with DN where that is all there is, or in that IP
    /// was cleared.
    fn check_ends(&self) {
        let mut ends: BTreeMap<u64, Vec<String>> = BTreeMap::new();
        // An armed instruction may be done an update later.
        let mut under_way = BTreeSet::new();
        for (name, event) in &self.bench.events {
            let ended = event.set & (Flag::Er.mask() | Flag::Pc.mask()) != 0
                || event.clear & Flag::Ip.mask() != 0
                || (event.set & Flag::Dn.mask() != 0
                    && event.set & Flag::Ip.mask() == 0
                    && !under_way.contains(&event.ticket.0));
            if event.set & Flag::Ip.mask() != 0 {
                under_way.insert(event.ticket.0);
            }
            let list = ends.entry(event.ticket.0).or_default();
            if ended {
                list.push(format!(
                    "{name} {:?}: +{:#x} -{:#x}",
                    event.mnemonic, event.set, event.clear
                ));
            }
        }
        for (ticket, ends) in ends {
            assert_eq!(ends.len(), 1, "execution {ticket} ended {} times: {ends:?}", ends.len());
        }
        for tag in (1..=self.executed).map(|place| format!("I{place}")) {
            let shown = self.bench.control(&tag);
            let left = [Flag::Ip, Flag::Ac, Flag::Accel, Flag::Decel];
            assert!(
                !left.iter().any(|flag| shown.has(*flag)),
                "{tag} shows {}",
                self.bench.bits(&tag)
            );
        }
    }
}

fn sequence(sequence: &mut Sequence) {
    if sequence.random.below(2) == 0 {
        sequence.transform();
    }
    for _ in 0..8 + sequence.random.below(25) {
        match sequence.random.below(16) {
            0..=3 => sequence.coordinated(),
            4 | 5 => sequence.single_axis(),
            6 => match sequence.random.below(4) {
                0 => sequence.offset(),
                1 => sequence.output(),
                _ => sequence.cam(),
            },
            7 => match sequence.random.below(3) {
                0 => sequence.change(),
                1 => sequence.reference(),
                _ => sequence.single_axis(),
            },
            8 | 9 => sequence.stop(),
            10 if sequence.switching => {
                if sequence.random.below(3) == 0 {
                    sequence.fault();
                } else {
                    sequence.switch();
                }
            }
            11 => sequence.transform(),
            _ => {
                let ticks = 1 + sequence.random.below(300);
                sequence.run(ticks);
            }
        }
    }
    sequence.finish();
    sequence.check_ends();
}

fn run(kind: Kind, share: u64) {
    for seed in seeds(150 / share) {
        let mut one = Sequence::new(seed, kind);
        let result = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| sequence(&mut one)));
        assert!(result.is_ok(), "{kind:?}, seed {seed}:\n{}", one.program);
    }
}

#[test]
fn random_sequences_leave_nothing_behind_and_every_instruction_ends_once() {
    run(Kind::Linear, 1);
}

#[test]
fn random_sequences_of_rotary_axes() {
    run(Kind::Rotary, 3);
}

#[test]
fn random_sequences_of_servos_with_limits() {
    run(Kind::Limited, 3);
}

#[test]
fn random_sequences_of_path_moves() {
    run(Kind::Paths, 3);
}
