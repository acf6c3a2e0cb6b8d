//! Toolpaths as CAM systems post them, and how they fare on planned contours: thousands of tiny moves through a queue, planned while they
//! are travelled. Position units (mm) and seconds.

use std::sync::Arc;

use crate::random::Random;
use arcline_contour::{AxisLimits, ContourMove};
use arcline_planner::geometry::{Arc as Circle, CirclePoint, Dimension, Direction, Path, Point};
use arcline_planner::profile::{Jerk, Limits};
use arcline_planner::{Clock, ContourEvent, ContourQueue, Ending, InstalledPlan, Move, Parameter, Sample};
use arcline_realtime::thread_time;

/// One toolpath.
pub struct Stream {
    /// Its name.
    pub name: &'static str,
    /// Length of a chord, as far as it has chords.
    pub chord: f64,
    /// Programmed speed.
    pub speed: f64,
    /// Command tolerance of every corner.
    pub tolerance: f64,
    /// The end of its moves, one by one: after the length of the curve so far and the number of the move.
    toolpath: fn(&mut Toolpath),
}

/// The streams of the benchmark and of the tests.
#[rustfmt::skip]
pub const STREAMS: &[Stream] = &[
    Stream { name: "surface", chord: 0.25, speed: 200.0, tolerance: 0.01,  toolpath: |c| c.chord(surface) },
    Stream { name: "raster",  chord: 0.10, speed: 150.0, tolerance: 0.01,  toolpath: |c| c.chord(raster) },
    Stream { name: "fine",    chord: 0.05, speed: 400.0, tolerance: 0.02,  toolpath: |c| c.chord(surface) },
    Stream { name: "coarse",  chord: 0.50, speed: 300.0, tolerance: 0.005, toolpath: |c| c.chord(surface) },
    Stream { name: "corners", chord: 0.20, speed: 200.0, tolerance: 0.01,  toolpath: |c| c.chord(stairs) },
    Stream { name: "wavy",    chord: 0.15, speed: 250.0, tolerance: 0.008, toolpath: |c| c.chord(waves) },
    Stream { name: "slots",   chord: 8.0,  speed: 250.0, tolerance: 0.01,  toolpath: Toolpath::slot },
    Stream { name: "islands", chord: 0.08, speed: 300.0, tolerance: 0.02,  toolpath: Toolpath::island },
    Stream { name: "rows",    chord: 0.50, speed: 100.0, tolerance: 0.01,  toolpath: |c| c.chord(rows) },
    Stream { name: "rough",   chord: 0.50, speed: 300.0, tolerance: 0.01,  toolpath: Toolpath::rough },
];

fn surface(u: f64) -> Point {
    let x = 60.0 * (u / 60.0).sin() + 8.0 * (u / 7.0).sin();
    let y = 40.0 * (u / 47.0).sin() + 5.0 * (u / 9.0).cos();
    Point::new(x, y, 6.0 * (u / 13.0).sin())
}

/// To and fro over a dome.
fn raster(u: f64) -> Point {
    let row = (u / 80.0).floor();
    let on = u - row * 80.0;
    let x = if row % 2.0 == 0.0 { on } else { 80.0 - on };
    let dome = 1.0 - ((x - 40.0) / 60.0).powi(2);
    Point::new(x, 0.4 * row + 0.2 * (x / 5.0).sin(), 12.0 * dome.max(0.0).sqrt())
}

/// Short rows to and fro.
fn rows(u: f64) -> Point {
    let row = (u / 15.0).floor();
    let on = u - row * 15.0;
    let x = if row % 2.0 == 0.0 { on } else { 15.0 - on };
    Point::new(x, 0.2 * row, 2.0 * (x / 3.0).sin())
}

/// A sudden corner every 7 mm.
fn stairs(u: f64) -> Point {
    let row = (u / 7.0).floor();
    let (on, begin) = (u - row * 7.0, (row / 2.0).floor() * 7.0);
    if row % 2.0 == 0.0 {
        Point::new(begin + on, begin, 0.0)
    } else {
        Point::new(begin + 7.0, begin + on, 0.5 * (on / 3.0).sin())
    }
}

fn waves(u: f64) -> Point {
    let x = 50.0 * (u / 53.0).sin() + 2.0 * (u / 2.1).sin();
    let y = 50.0 * (u / 71.0).cos() + 1.5 * (u / 1.3).cos();
    Point::new(x, y, 0.4 * (u / 3.0).sin())
}

/// A toolpath that grows.
struct Toolpath {
    paths: Vec<Path>,
    at: Point,
    heading: f64,
    chord: f64,
    /// Chords so far, those that were too short to be a move among them.
    chords: f64,
}

impl Toolpath {
    /// A line to a point whose coordinates are rounded to a thousandth.
    fn line(&mut self, to: Point) {
        let to = to.map(|part| (part * 1000.0).round() / 1000.0);
        if to != self.at {
            self.paths.push(Path::line(self.at, to));
            self.at = to;
        }
    }

    fn chord(&mut self, curve: fn(f64) -> Point) {
        if self.chords == 0.0 {
            self.at = curve(0.0).map(|part| (part * 1000.0).round() / 1000.0);
        }
        self.chords += 1.0;
        self.line(curve(self.chord * self.chords));
    }

    fn ahead(&self, length: f64) -> Point {
        self.at + Point::new(self.heading.cos(), self.heading.sin(), 0.0) * length
    }

    /// Arcs between lines: round the rounded corners of a slot that wanders.
    fn slot(&mut self) {
        let along = if self.paths.len().is_multiple_of(4) {
            self.chord
        } else {
            0.3 * self.chord
        };
        self.line(self.ahead(along));
        self.arc(1.5, core::f64::consts::FRAC_PI_2);
    }

    /// An arc that goes on in the direction of travel, to the left by an angle above 0, else to the right.
    fn arc(&mut self, radius: f64, turn: f64) {
        let radius = radius * turn.signum();
        let side = Point::new(-self.heading.sin(), self.heading.cos(), 0.0);
        let centre = self.at + side * radius;
        let round = |angle: f64| {
            let heading = self.heading + angle;
            centre - Point::new(-heading.sin(), heading.cos(), 0.0) * radius
        };
        let via = CirclePoint::Via(round(0.5 * turn));
        // With a point on the way the direction does not count.
        let direction = Direction::from_word(0).expect("a direction");
        let arc = Circle::new(Dimension::Two, self.at, round(turn), via, direction).expect("an arc");
        self.at = round(turn);
        self.heading += turn;
        self.paths.push(Path::Arc(arc));
    }

    fn part(&mut self, part: Part) {
        match part {
            Part::Chords(count, length, turn, change) => {
                for k in 0..count {
                    self.heading += turn + change * (k as f64 - 0.5 * count as f64);
                    self.line(self.ahead(length));
                }
            }
            Part::Line(length) => self.line(self.ahead(length)),
            Part::Arc(radius, turn) => self.arc(radius, turn),
            Part::Corner(turn) => self.heading += turn,
            Part::Slot(count, length, radius) => {
                for k in 0..count {
                    self.line(self.ahead(if k % 2 == 0 { length } else { 0.3 * length }));
                    self.arc(radius.abs(), radius.signum() * core::f64::consts::FRAC_PI_2);
                }
            }
        }
    }

    /// Chords of a curve that was measured: each turns by an angle of its own. Now and then a long line.
    fn rough(&mut self) {
        let on = self.paths.len() % 257;
        if on == 256 {
            self.line(self.ahead(20.0));
        } else {
            let noise = (self.chords * 12.9898).sin() * 43_758.547;
            self.chords += 1.0;
            self.heading += 0.015 + 0.065 * (2.0 * (noise - noise.floor()) - 1.0);
            self.line(self.ahead(self.chord));
        }
    }

    /// A small ring of tiny moves, then a long line with a sudden corner at its end.
    fn island(&mut self) {
        let on = self.paths.len() % 61;
        if on == 60 {
            self.heading += 0.9;
            self.line(self.ahead(15.0));
        } else {
            self.heading += 0.1 + 0.02 * (on as f64 * 0.7).sin();
            self.line(self.ahead(self.chord));
        }
    }
}

/// A part of a random toolpath.
#[derive(Clone, Copy, Debug)]
enum Part {
    /// A number of chords: their length, the turn at each (rad), and the change of the turn from chord to chord.
    Chords(usize, f64, f64, f64),
    /// A line.
    Line(f64),
    /// An arc that goes on in the direction of travel: its radius and the angle by which it turns, to the left or right.
    Arc(f64, f64),
    /// A sudden corner.
    Corner(f64),
    /// A slot: a number of times a line and an arc that goes on in its direction.
    Slot(usize, f64, f64),
}

/// A random toolpath, as its seed reproduces it: dense chords of curves, islands of tiny moves, lines, arcs between lines and sudden corners, at any speed
/// and tolerance that CAM systems use.
#[derive(Debug)]
pub struct Wild {
    /// Its moves, numbered; the last one ends in a stop.
    pub moves: Vec<Move<usize>>,
    /// Jerk of the axes; `None`: trapezoids.
    pub jerk: Option<f64>,
    /// Programmed speed and command tolerance.
    pub speed: f64,
    /// Command tolerance.
    pub tolerance: f64,
    parts: Vec<Part>,
}

impl Wild {
    /// The toolpath of a seed, of about this number of moves.
    #[must_use]
    pub fn new(seed: u64, about: usize) -> Wild {
        let mut random = Random(seed);
        let jerk = (random.below(2) == 0).then_some(100_000.0);
        let (speed, tolerance) = (random.between(50.0, 400.0), random.between(0.005, 0.02));
        // Most toolpaths are of one kind, with others in between.
        let usual = random.below(6);
        let mut toolpath = Toolpath {
            paths: Vec::with_capacity(about + 300),
            at: Point::zeros(),
            heading: 0.3,
            chord: random.between(0.05, 0.5),
            chords: 0.0,
        };
        let mut parts = Vec::new();
        while toolpath.paths.len() < about {
            let kind = if random.below(3) == 0 { random.below(6) } else { usual };
            let side = if random.below(2) == 0 { -1.0 } else { 1.0 };
            let part = match kind {
                0 | 1 => Part::Chords(
                    40 + random.below(200) as usize,
                    if kind == 0 {
                        toolpath.chord
                    } else {
                        random.between(0.05, 0.5)
                    },
                    random.between(-0.03, 0.03),
                    0.01 * random.between(-0.03, 0.03),
                ),
                2 => Part::Chords(
                    5 + random.below(60) as usize,
                    random.between(0.01, 0.1),
                    random.between(-0.2, 0.2),
                    random.between(-0.01, 0.01),
                ),
                3 => Part::Line(random.between(0.5, 30.0)),
                4 => Part::Slot(
                    1 + random.below(6) as usize,
                    random.between(0.6, 12.0),
                    side * random.between(0.5, 12.0),
                ),
                _ => Part::Arc(random.between(0.5, 20.0), side * random.between(0.1, 3.0)),
            };
            parts.push(part);
            toolpath.part(part);
            if random.below(3) == 0 {
                let corner = Part::Corner(random.between(-2.8, 2.8));
                parts.push(corner);
                toolpath.part(corner);
            }
        }
        Wild {
            moves: numbered(toolpath.paths, speed, tolerance, jerk),
            jerk,
            speed,
            tolerance,
            parts,
        }
    }
}

impl core::fmt::Display for Wild {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let Wild {
            moves,
            jerk,
            speed,
            tolerance,
            parts,
        } = self;
        write!(
            f,
            "{} moves at {speed} mm/s, tolerance {tolerance} mm, jerk {jerk:?}: {parts:?}",
            moves.len()
        )
    }
}

impl Stream {
    /// Its first moves, numbered; the last one ends in a stop. `jerk`: of the axes; `None`: trapezoids.
    #[must_use]
    pub fn moves(&self, count: usize, jerk: Option<f64>) -> Vec<Move<usize>> {
        let mut toolpath = Toolpath {
            paths: Vec::with_capacity(count + 1),
            at: Point::zeros(),
            heading: 0.3,
            chord: self.chord,
            chords: 0.0,
        };
        while toolpath.paths.len() < count {
            (self.toolpath)(&mut toolpath);
        }
        toolpath.paths.truncate(count);
        numbered(toolpath.paths, self.speed, self.tolerance, jerk)
    }
}

/// Moves along paths; the last one ends in a stop.
fn numbered(paths: Vec<Path>, speed: f64, tolerance: f64, jerk: Option<f64>) -> Vec<Move<usize>> {
    let limits = Limits {
        speed,
        acceleration: 2.0 * ACCELERATION,
        deceleration: 2.0 * ACCELERATION,
        jerk: jerk.map(|jerk| Jerk {
            acceleration: 10.0 * jerk,
            deceleration: 10.0 * jerk,
        }),
    };
    let count = paths.len();
    let numbered = paths.into_iter().enumerate();
    numbered
        .map(|(data, path)| Move {
            path,
            rotation: None,
            corner: f64::INFINITY,
            limits,
            last_speed: limits.speed,
            ending: if data + 1 == count {
                Ending::Stop
            } else {
                Ending::Blend { tolerance }
            },
            parameter: Parameter::TIME,
            data,
        })
        .collect()
}

/// The time from the request for a plan to its arrival.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Latency {
    /// The plan comes in the tick of its request, as in `simulate`.
    None,
    /// A number of seconds.
    Seconds(f64),
    /// The processor time of the planning.
    Measured,
}

/// The sending of a stream.
#[derive(Clone, Copy, Debug)]
pub struct Feed {
    /// Pending moves that the queue has room for.
    pub depth: usize,
    /// Moves that come in a tick, on average, where there is room; infinite: the queue is always full.
    pub per_tick: f64,
    /// The latency of plans.
    pub latency: Latency,
}

/// The results of a stream.
#[derive(Clone, Debug, Default)]
pub struct Travelled {
    /// Seconds from the first move in the queue to the first motion, and to the end.
    pub began: f64,
    /// Seconds of motion.
    pub motion: f64,
    /// Rests on the way although moves waited.
    pub unplanned: usize,
    /// Rests on the way as the queue was empty.
    pub starved: usize,
    /// Plans that were asked for.
    pub plans: usize,
    /// Extensions that were not found.
    pub not_found: usize,
    /// Plans that came too late.
    pub late: usize,
    /// Processor time of the planning, s: the sum and the longest.
    pub planning: f64,
    /// The longest plan, seconds.
    pub longest: f64,
    /// After each plan: the time, the travelled and the planned part of the motion, seconds from its beginning.
    pub fronts: Vec<[f64; 3]>,
}

/// The limits of the axes for a stream.
#[must_use]
pub fn limits(jerk: Option<f64>) -> AxisLimits {
    AxisLimits {
        speed: Point::repeat(500.0),
        acceleration: Point::repeat(ACCELERATION),
        jerk: jerk.map(Point::repeat),
    }
}

/// Travels moves on the virtual clock, a tick a millisecond. `look` gets the queue and the position of the motion at every tick, and may change
/// them.
///
/// # Panics
/// When the motion has not ended after an hour.
pub fn travel(
    moves: &[Move<usize>],
    jerk: Option<f64>,
    feed: Feed,
    mut look: impl FnMut(&mut ContourQueue<usize>, &Clock, Option<Sample>),
) -> Travelled {
    // Ticks of 1 ms within which every toolpath is travelled.
    let longest = 1_000 * (moves.len() as u64 + 100);
    let limits = limits(jerk);
    let mut clock = Clock::at(0, 1_000_000);
    let mut queue = ContourQueue::new(feed.depth);
    let mut told = Travelled::default();
    let (mut sent, mut sendable, mut done) = (0, 0.0_f64, 0);
    let mut began = None;
    let mut coming = None;
    let mut asked: Vec<ContourMove> = Vec::new();
    while done < moves.len() {
        clock.tick += 1;
        queue.steer(&clock);
        while let Some(event) = queue.event(&clock) {
            done += usize::from(queue.pass(&clock).is_some());
            if event == ContourEvent::End {
                queue.finish();
                if queue.moves().next().is_some() {
                    told.unplanned += 1;
                } else if done < moves.len() {
                    told.starved += 1;
                }
                break;
            }
        }
        sendable += feed.per_tick;
        while let Some(next) = moves.get(sent).filter(|_| sent as f64 + 1.0 <= sendable)
            && queue.push(*next, &clock).is_ok()
        {
            sent += 1;
        }
        // A sender that waits for room does not hurry afterwards.
        sendable = sendable.min(sent as f64 + feed.per_tick);
        asked.clear();
        if let Some(batch) = queue.batch(&clock, &clock, |motion| asked.push(motion)) {
            let from = thread_time();
            let planned = match &batch.extends {
                Some(extension) => extension.plan(&asked, &limits),
                None => Some(arcline_contour::begin(&asked, &limits)),
            };
            let took = (thread_time() - from).as_secs_f64();
            told.plans += 1;
            told.not_found += usize::from(planned.is_none());
            told.planning += took;
            told.longest = told.longest.max(took);
            let late = match feed.latency {
                Latency::None => 0.0,
                Latency::Seconds(seconds) => seconds,
                Latency::Measured => took,
            };
            let due = clock.tick + (late / 1e-3).ceil() as u64;
            coming = Some((due, batch.generation, planned.map(Arc::new)));
        }
        if let Some((_, generation, planned)) = coming.take_if(|(due, ..)| *due <= clock.tick) {
            let (found, planned_to) = (planned.is_some(), planned.as_ref().map(|plan| plan.duration()));
            match queue.install(generation, planned, &clock) {
                Ok(installed) => {
                    let start = *began.get_or_insert(clock.tick);
                    let wall = (clock.tick - start) as f64 * 1e-3;
                    if matches!(installed, InstalledPlan::Started | InstalledPlan::Extended(_)) {
                        told.fronts.push([wall, wall, planned_to.unwrap_or(wall)]);
                    }
                }
                Err(_) => told.late += usize::from(found),
            }
        }
        let sample = queue.sample(&clock);
        look(&mut queue, &clock, sample);
        assert!(clock.tick < longest, "the motion does not end");
    }
    told.began = began.unwrap_or(0) as f64 * 1e-3;
    told.motion = clock.tick as f64 * 1e-3 - told.began;
    told
}

/// The greatest acceleration of each axis, mm/s².
const ACCELERATION: f64 = 5000.0;
