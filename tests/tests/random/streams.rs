//! Random toolpaths through a full queue of 1,000 moves: chords, islands of tiny moves, lines, arcs between lines and sudden corners. Plans come
//! 20 ms after their request. None rests on the way, and all are within their limits at every tick, also with overrides, changes and stops meanwhile.
#![allow(missing_docs)]

use arcline_contour::AxisLimits;
use arcline_planner::geometry::{Path, Point};
use arcline_planner::{ContourQueue, Move, Sample};
use arcline_tests::random::{Random, is_long, seeds};
use arcline_tests::streams::{Feed, Latency, STREAMS, Travelled, Wild, limits, travel};

const MOVES: usize = 200;
const FEED: Feed = Feed {
    depth: 1000,
    per_tick: 16.0,
    latency: Latency::Seconds(0.02),
};
/// Seeds that rested: a curve that was left for evenly rounded corners, too coarse in those that it passed first, or never left as it was too fast for
/// them, or left so late that it was a smooth one; extensions that were given up too early (149, 343); searches that took the time of those behind
/// them in a short rest, or had too little of it (202, 261, 302, 321, 340, 446, 456); extensions that only a gentle plan of fewer moves is found for (128).
const FOUND: [u64; 18] = [
    111, 128, 133, 149, 202, 228, 261, 293, 302, 321, 340, 343, 445, 446, 456, 460, 735, 804,
];

#[test]
fn a_stream_that_is_sent_fast_enough_never_rests() {
    for seed in seeds(120).chain(FOUND) {
        let wild = Wild::new(seed, MOVES);
        let mut within = Within::new(&wild, seed);
        let told = travel(&wild.moves, wild.jerk, FEED, |_, _, sample| within.look(sample));
        assert_eq!(told.unplanned, 0, "seed {seed}: {wild}");
    }
}

/// Plans that come 120 ms late: the pace is lower meanwhile, within all limits. These streams rested without that.
#[test]
fn a_late_plan_slows_a_stream_down_before_it_rests() {
    const LATE: [u64; 4] = [8, 18, 22, 29];
    let late = Feed {
        latency: Latency::Seconds(0.12),
        ..FEED
    };
    for seed in seeds(100).chain(LATE) {
        let wild = Wild::new(seed, MOVES);
        let mut within = Within::new(&wild, seed);
        let told = travel(&wild.moves, wild.jerk, late, |_, _, sample| within.look(sample));
        let rests = (told.starved, told.unplanned);
        assert!(rests == (0, 0) || !LATE.contains(&seed), "seed {seed}: {wild}");
    }
}

/// Extensions that are not found in time: the pace is lower until one from it is found, or the motion continues from its end.
#[test]
fn a_stream_goes_on_when_its_extension_is_not_found() {
    for (seed, latency) in [(128, Latency::None), (81, FEED.latency)] {
        let feed = Feed { latency, ..FEED };
        let wild = Wild::new(seed, MOVES);
        let mut within = Within::new(&wild, seed);
        let told = travel(&wild.moves, wild.jerk, feed, |_, _, sample| within.look(sample));
        assert!(told.not_found > 0, "seed {seed}: each extension is found");
        assert_eq!(told.unplanned, 0, "seed {seed}: {wild}");
    }
}

/// Chords that are so short that the motion is nearly as fast as they are sent: its rest stays short, and each new corner comes late.
#[test]
fn dense_s_curves_that_are_sent_just_fast_enough_never_rest() {
    let fine = STREAMS
        .iter()
        .find(|stream| stream.name == "fine")
        .expect("a stream of the table");
    let jerk = Some(100_000.0);
    let moves = fine.moves(if is_long() { 4000 } else { 1000 }, jerk);
    for per_tick in [5.0, 5.4, 5.8, 6.2, 6.6] {
        let feed = Feed {
            per_tick,
            latency: Latency::Seconds(0.05),
            ..FEED
        };
        let told = travel(&moves, jerk, feed, |_, _, _| {});
        assert_eq!(told.unplanned, 0, "{per_tick} moves in a tick");
    }
}

/// The end of an S-curve just behind a tick would move the axes by less than a tenth of a nanometre: who records the axes would see a rest before it.
#[test]
fn extensions_of_s_curves_end_apart_from_ticks() {
    let jerk = Some(100_000.0);
    for stream in STREAMS
        .iter()
        .filter(|stream| ["surface", "raster"].contains(&stream.name))
    {
        let moves = stream.moves(900, jerk);
        for latency in [0.0, 0.004, 0.008, 0.015, 0.025] {
            let feed = Feed {
                per_tick: 6.0,
                latency: Latency::Seconds(latency),
                ..FEED
            };
            let told = travel(&moves, jerk, feed, |_, _, _| {});
            let ends = told.fronts.iter().skip(1).map(|[_, _, end]| end.rem_euclid(1e-3));
            let near: Vec<f64> = ends.filter(|end| (1e-5..4.9e-4).contains(end)).collect();
            assert!(near.is_empty(), "{}, {latency} s: {near:?}", stream.name);
        }
    }
}

/// The last extension of a stream is found from another instant where the end cannot come later within all limits: each of these had one that moves the
/// axes by nearly nothing.
#[test]
fn a_stream_of_s_curves_ends_apart_from_ticks() {
    let jerk = Some(100_000.0);
    let coarse = STREAMS
        .iter()
        .find(|stream| stream.name == "coarse")
        .expect("a stream of the table");
    for (count, latency) in [
        (1200, 0.007),
        (1200, 0.009),
        (1400, 0.0),
        (1400, 0.009),
        (1500, 0.011),
        (1800, 0.012),
    ] {
        let feed = Feed {
            per_tick: 6.0,
            latency: Latency::Seconds(latency),
            ..FEED
        };
        let told = travel(&coarse.moves(count, jerk), jerk, feed, |_, _, _| {});
        let end = told.fronts.last().map_or(0.0, |[_, _, end]| end.rem_euclid(1e-3));
        assert!(
            !(1e-5..4.9e-4).contains(&end),
            "{count} moves, {latency} s: {end} s behind a tick"
        );
    }
}

/// At random instants of a stream: overrides, holds, other speeds of all moves (MCCD) and stops (MCS). After a stop, the rest of the stream
/// begins at the position of rest.
#[test]
fn whatever_is_asked_of_a_stream_keeps_it_within_its_limits_and_it_goes_on() {
    // Each change plans anew, so that one stream takes a minute of a processor.
    let moves = if is_long() { MOVES } else { MOVES / 4 };
    for seed in seeds(6) {
        let wild = Wild::new(seed, moves);
        let mut random = Random(seed ^ 0x5EED);
        let mut within = Within::new(&wild, seed);
        let mut on_path = OnPath::new(&wild);
        let (mut rate, mut stops, mut until) = (1.0, 0, 100 + random.below(300));
        // Stops that were not at the end of the whole.
        let mut inside = 0;
        let mut stopping: Option<u64> = None;
        let told = travel(&wild.moves, wild.jerk, FEED, |queue, clock, sample| {
            within.look(sample);
            if let Some(sample) = sample {
                on_path.look(queue, &sample, seed);
            }
            if let Some(since) = stopping {
                if queue.is_running() {
                    assert!(clock.tick - since <= LONGEST_STOP, "seed {seed}: a stop takes too long");
                    return;
                }
                stopping = None;
                inside += usize::from(queue.moves().next().is_some());
                on_path.go_on(queue, clock);
            }
            if clock.tick < until || !queue.is_running() {
                return;
            }
            until = clock.tick + 30 + random.below(400);
            match random.below(if stops < 2 { 5 } else { 4 }) {
                // A hold, and the motion goes on after some time.
                0 if rate > 0.0 => rate = 0.0,
                0 | 1 => rate = random.between(0.1, 1.0),
                2 => rate = 1.0,
                3 => {
                    let speed = wild.speed * random.between(0.3, 1.0);
                    queue.moves_mut().for_each(|one| one.limits.speed = speed);
                    queue.change(clock);
                }
                _ => {
                    stops += 1;
                    stopping = Some(clock.tick);
                    let own = queue.moves().next().expect("an active move").limits;
                    queue.stop(&own, clock);
                    assert!(queue.is_paused(), "seed {seed}: no stop");
                }
            }
            queue.set_rate(rate, clock);
        });
        let Travelled { unplanned, starved, .. } = told;
        assert_eq!((unplanned, starved), (inside, 0), "seed {seed}: {wild}");
    }
}

/// The longest stop, ticks: from 400 mm/s while the motion needs its axes.
const LONGEST_STOP: u64 = 500;

/// Speed, acceleration and jerk from tick to tick.
struct Within<'w> {
    wild: &'w Wild,
    seed: u64,
    kept: AxisLimits,
    last: Option<Sample>,
}

impl<'w> Within<'w> {
    fn new(wild: &'w Wild, seed: u64) -> Self {
        let kept = limits(wild.jerk);
        Within {
            wild,
            seed,
            kept,
            last: None,
        }
    }

    fn look(&mut self, sample: Option<Sample>) {
        let Within { wild, seed, kept, .. } = self;
        if let Some(sample) = sample {
            let speed = sample.velocity.norm();
            assert!(speed <= wild.speed * (1.0 + 1e-9), "seed {seed}: {speed}, {wild}");
            for axis in 0..3 {
                let (acceleration, most) = (sample.acceleration[axis].abs(), kept.acceleration[axis]);
                assert!(
                    acceleration <= most * (1.0 + 1e-9),
                    "seed {seed}: {acceleration}, {wild}"
                );
                if let (Some(last), Some(most)) = (self.last, kept.jerk) {
                    let jerk = (sample.acceleration[axis] - last.acceleration[axis]).abs() * 1000.0;
                    assert!(jerk <= most[axis] * (1.0 + 1e-6), "seed {seed}: jerk {jerk}, {wild}");
                }
            }
        }
        self.last = sample;
    }
}

/// The distance from the programmed path.
struct OnPath {
    paths: Vec<Path>,
    tolerance: f64,
    at: Point,
}

impl OnPath {
    fn new(wild: &Wild) -> Self {
        OnPath {
            paths: wild.moves.iter().map(|one| one.path).collect(),
            tolerance: wild.tolerance,
            at: Point::zeros(),
        }
    }

    fn look(&mut self, queue: &ContourQueue<usize>, sample: &Sample, seed: u64) {
        self.at = sample.position;
        let Some(active) = queue.moves().next().map(|one| one.data) else {
            return;
        };
        let most = self.tolerance * (1.0 + 1e-6) + 1e-9;
        // The nearest first, so that the search can skip most.
        let mut near: Vec<usize> = (active.saturating_sub(BESIDE)..(active + BESIDE).min(self.paths.len())).collect();
        near.sort_by_key(|place| place.abs_diff(active));
        let mut least = f64::INFINITY;
        let is_near = near.into_iter().any(|place| {
            least = least.min(distance(&self.paths[place], &self.at));
            least <= most
        });
        assert!(
            is_near,
            "seed {seed}: {least} off move {active}, tolerance {}",
            self.tolerance
        );
    }

    /// Sends the moves that are left again, the first of them from where the motion is.
    fn go_on(&mut self, queue: &mut ContourQueue<usize>, clock: &arcline_planner::Clock) {
        let mut left: Vec<Move<usize>> = queue.moves().copied().collect();
        queue.clear();
        if let Some(first) = left.first_mut() {
            first.path = Path::line(self.at, first.path.end());
            self.paths[first.data] = first.path;
        }
        for one in left {
            queue.push(one, clock).expect("room, as before");
        }
    }
}

/// Moves beside the active one that may be the nearest.
const BESIDE: usize = 16;

/// The distance from a path, by the nearest of some of its points and a search about it.
fn distance(path: &Path, from: &Point) -> f64 {
    let length = path.length();
    let off = |s: f64| (path.at(s.clamp(0.0, length)).position - from).norm();
    if let Path::Line(_) = path {
        let (start, end) = (path.start(), path.end());
        let along = (from - start).dot(&(end - start)) / length;
        return off(along);
    }
    let step = length / f64::from(POINTS);
    let best = (0..=POINTS).map(|k| step * f64::from(k));
    let best = best.min_by(|a, b| off(*a).total_cmp(&off(*b))).unwrap_or(0.0);
    let (mut low, mut high) = ((best - step).max(0.0), (best + step).min(length));
    for _ in 0..SEARCH {
        let [one, other] = [low + (high - low) / 3.0, high - (high - low) / 3.0];
        if off(one) < off(other) {
            high = other;
        } else {
            low = one;
        }
    }
    off(0.5 * (low + high))
}

const POINTS: u32 = 24;
const SEARCH: u32 = 60;
