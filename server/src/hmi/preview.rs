//! The simulation of a call or a program from the present state: the same controller on a virtual clock, and nothing moves.
//! It gives paths, duration, peaks of every axis, and the first limit that would be exceeded.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::{Duration, Instant};

use arcline_controller::image::Image;
use arcline_controller::machine::{Machine, StartState};
use arcline_controller::{AcceptedMove, Controller, Event, Ticket};
use arcline_instruction_set::predefined::{axis_status, motion_status};
use arcline_instruction_set::{AxisId, Call, Flag, MotionError, Object};
use arcline_simulation::{End, Observer, Options, Runner};
use arcline_structured_text::{Interpreter, Policy, Program};
use tokio::sync::Semaphore;

use super::paths;
use super::peaks::{Exceeded, Peaks, Shape};
use super::protocol::{AxisPeaks, LimitText, Refusal, Simulated, SimulatedEvent, SimulatedPath};
use crate::plant::{Plant, View};

/// Longest simulated time, s.
const LONGEST: f64 = 3600.0;
/// Longest real time of a simulation; the computing time of its last tick may exceed it.
const PATIENCE: Duration = Duration::from_secs(10);
/// Points of a path, at most.
const POINTS: usize = 2000;
/// The most events in a result.
const EVENTS: usize = 1000;
/// The most programmed paths whose blends are in a result.
const MOVES: usize = 1000;
/// Simulations at a time.
const SIMULATIONS: usize = 1;

/// The simulations of viewers, one at a time.
#[derive(Debug)]
pub(super) struct Previews(Arc<Semaphore>);

impl Default for Previews {
    fn default() -> Self {
        Previews(Arc::new(Semaphore::new(SIMULATIONS)))
    }
}

impl Previews {
    /// Simulates a program on a thread of its own, when those before have ended.
    pub(super) async fn simulate(&self, plant: &Plant, program: Program) -> Result<Simulated, Refusal> {
        let turn = self.turns().acquire_owned().await;
        let plant = plant.clone();
        let simulated = tokio::task::spawn_blocking(move || {
            let simulated = simulate_here(&plant, program, PATIENCE);
            drop(turn);
            simulated
        });
        simulated.await.map_err(|_| Refusal::new("the simulation failed"))?
    }

    /// One permit for each simulation that may run.
    pub(super) fn turns(&self) -> Arc<Semaphore> {
        self.0.clone()
    }
}

/// Simulates a program on this thread, for at most about `patience` of real time.
pub(super) fn simulate_here(plant: &Plant, program: Program, patience: Duration) -> Result<Simulated, Refusal> {
    let (machine, image) = plant.view(|view| (present(plant.machine(), view), view.image.clone()));
    let options = Options {
        until: LONGEST,
        policy: Policy::default(),
    };
    let mut observations = Observations::new(&machine, patience);
    let machine = Arc::new(machine);
    let mut runner = Runner::new(machine.clone(), image);
    runner.simulation().take_overrides();
    match runner.run(Interpreter::new(program), options, &mut observations) {
        End::Finished => Ok(observations.into_simulated(&machine, None)),
        End::Erred(erred) => Err(Refusal::motion(erred.err, erred.exerr, erred.mnemonic).at(erred.line)),
        End::Wrong(wrong) => Err(Refusal::new(wrong.to_string())),
        End::TooLong(seconds) => {
            Ok(observations.into_simulated(&machine, Some(format!("not at its end after {seconds} s"))))
        }
        End::Left => Ok(observations.into_simulated(
            &machine,
            Some(format!("not at its end after {} s of computing", patience.as_secs())),
        )),
    }
}

/// The machine with its axes as they are now, or as they will be where moves under way end.
fn present(machine: &Machine, view: &View<'_>) -> Machine {
    let mut machine = machine.clone();
    let motion = &mut machine.motion;
    for (axis, now) in motion.axes.iter_mut().zip(&view.snapshot.axes) {
        axis.start = StartState {
            position: now.command[0],
            servo_on: now.status & axis_status::SERVO_ACTION_STATUS != 0,
            homed: now.motion_status & motion_status::AXIS_HOMED_STATUS != 0,
            faults: now.faults,
            redefined: now.redefined,
        };
    }
    for (place, system) in motion.systems.iter().enumerate() {
        let Some(last) = view.moves.of(place).last() else {
            continue;
        };
        let end = last.accepted.path.end();
        for (axis, position) in system.linear().iter().zip(end.iter()) {
            let axis = motion.axes.get_mut(usize::from(*axis));
            if let Some(axis) = axis.filter(|axis| !axis.is_rotary()) {
                axis.start.position = *position;
            }
        }
    }
    machine
}

/// The observations of a simulation.
struct Observations {
    began: Instant,
    /// Real time that it may take.
    patience: Duration,
    tick: u64,
    period: f64,
    axes: Vec<Peaks>,
    /// The axes of each coordinate system.
    systems: Vec<Vec<AxisId>>,
    /// The tool position of each coordinate system at the previous tick; empty if the system is not a robot.
    tools: Vec<Option<[f64; 3]>>,
    /// The instructions that the controller has accepted in this tick, and those in process.
    accepted: Vec<(Ticket, Moving)>,
    moving: BTreeMap<Ticket, Moving>,
    /// Positions of the axes of each system that has moved, or those of its tool where it is a robot.
    trails: BTreeMap<usize, Trail>,
    moves: Vec<AcceptedMove>,
    limit: Option<String>,
    /// The first soft travel limit.
    travel: Option<String>,
    events: Vec<SimulatedEvent>,
}

/// The axes that an instruction with a profile moves.
struct Moving {
    shape: Shape,
    axes: Vec<usize>,
}

/// Points of a path, every nth tick: n doubles when there are too many.
struct Trail {
    points: Vec<Vec<f64>>,
    every: u64,
}

impl Observations {
    fn new(machine: &Machine, patience: Duration) -> Self {
        Observations {
            began: Instant::now(),
            patience,
            tick: 0,
            period: machine.period(),
            axes: machine.axes.iter().map(|_| Peaks::default()).collect(),
            accepted: Vec::new(),
            moving: BTreeMap::new(),
            systems: machine.systems.iter().map(|system| system.axes.clone()).collect(),
            tools: Vec::new(),
            trails: BTreeMap::new(),
            moves: Vec::new(),
            limit: None,
            travel: None,
            events: Vec::new(),
        }
    }

    fn into_simulated(self, machine: &Machine, unfinished: Option<String>) -> Simulated {
        let coordinated = |system: &usize| self.moves.iter().any(|one| usize::from(one.system) == *system);
        let any = self.trails.keys().any(coordinated);
        let shown = self.trails.iter().filter(|(system, _)| !any || coordinated(system));
        let paths = shown.map(|(place, trail)| {
            let system = &machine.systems[*place];
            let moves = self.moves.iter().filter(|one| usize::from(one.system) == *place);
            let blends = moves.filter(|one| one.tolerance > 0.0 && one.tolerance.is_finite() && system.robot.is_none());
            let blends = blends.map(|one| paths::circle(&one.path.end(), one.tolerance, system.linear().len()));
            SimulatedPath {
                coordinate_system: system.name.clone(),
                points: trail.points.clone(),
                blends: blends.collect(),
            }
        });
        let peaks = machine.axes.iter().zip(&self.axes).map(|(axis, peaks)| AxisPeaks {
            axis: axis.name.clone(),
            velocity: peaks.velocity(),
            acceleration: peaks.acceleration(),
            jerk: peaks.jerk(),
        });
        let ends = unfinished.is_none();
        Simulated {
            paths: paths.collect(),
            duration_s: ends.then_some(self.tick as f64 * self.period),
            ticks: self.tick,
            peaks: peaks.collect(),
            limit: self.limit.or(unfinished).map(|text| LimitText { text }),
            travel: self.travel.map(|text| LimitText { text }),
            events: self.events,
        }
    }
}

impl Observer for Observations {
    fn accepted(&mut self, ticket: Ticket, call: &Call) {
        let Some(shape) = Shape::of(call) else { return };
        let target = call.target.map(usize::from);
        let axes = match (call.instruction().object, target) {
            (Object::CoordinateSystem, Some(place)) => {
                let axes = self.systems.get(place).into_iter().flatten();
                axes.map(|axis| usize::from(*axis)).collect()
            }
            (Object::Axis, Some(place)) => vec![place],
            _ => Vec::new(),
        };
        self.accepted.push((ticket, Moving { shape, axes }));
    }

    fn tick(&mut self, tick: u64, machine: &Machine, controller: &mut Controller) -> bool {
        self.tick = tick;
        self.accepted.clear();
        for moving in self.moving.values() {
            for axis in &moving.axes {
                self.axes[*axis].follows(moving.shape);
            }
        }
        let room = &mut self.moves;
        controller.accepted_moves(|accepted| {
            if room.len() < MOVES {
                room.push(*accepted);
            }
        });
        let rows: Vec<[f64; 4]> = controller.trace().collect();
        let was: Vec<Option<f64>> = self.axes.iter().map(Peaks::position).collect();
        for ((axis, peaks), row) in machine.axes.iter().zip(&mut self.axes).zip(&rows) {
            let Some(exceeded) = peaks.exceeded(axis, *row, self.period) else {
                continue;
            };
            let is_travel = matches!(exceeded, Exceeded::Travel { .. });
            let is_first_travel = is_travel && self.travel.is_none();
            if self.limit.is_none() || is_first_travel {
                let time = self.tick as f64 * self.period;
                let text = format!("{}: {}, at {time:.3} s", axis.name, exceeded.text(&axis.units));
                if is_first_travel {
                    self.travel = Some(text.clone());
                }
                self.limit.get_or_insert(text);
            }
        }
        let moved = |axis: &AxisId| {
            let place = usize::from(*axis);
            was[place].is_some_and(|before| before != rows[place][0])
        };
        let has_robots = machine.systems.iter().any(|system| system.robot.is_some());
        let tools: Vec<Option<[f64; 3]>> = if has_robots {
            controller.tools().collect()
        } else {
            Vec::new()
        };
        let tools_before = std::mem::replace(&mut self.tools, tools);
        for (place, system) in machine.systems.iter().enumerate() {
            let drawn = if system.robot.is_some() {
                system.axes.as_slice()
            } else {
                system.linear()
            };
            if !drawn.iter().any(moved) {
                continue;
            }
            let position = |tools: &[Option<[f64; 3]>], row: &dyn Fn(usize) -> f64| match tools.get(place) {
                Some(Some(tool)) => tool.to_vec(),
                _ => system.linear().iter().map(|axis| row(usize::from(*axis))).collect(),
            };
            let now: Vec<f64> = position(&self.tools, &|axis| rows[axis][0]);
            // Where the arms of a delta do not meet, there is no tool position.
            if !is_finite(&now) {
                continue;
            }
            let trail = self.trails.entry(place).or_insert_with(|| {
                let before = position(&tools_before, &|axis| was[axis].unwrap_or(rows[axis][0]));
                Trail {
                    points: vec![if is_finite(&before) { before } else { now.clone() }],
                    every: 1,
                }
            });
            trail.add(tick, now);
        }
        // In each tick, since the program may compute for many milliseconds of real time within one.
        self.began.elapsed() < self.patience
    }

    fn event(&mut self, event: &Event, time: f64, image: &Image) {
        let begun = self.accepted.iter().position(|(ticket, _)| *ticket == event.ticket);
        if let Some(place) = begun.filter(|_| event.set & Flag::Ip.mask() != 0) {
            let (ticket, moving) = self.accepted.swap_remove(place);
            self.moving.insert(ticket, moving);
        }
        if event.clear & Flag::Ip.mask() != 0 {
            self.moving.remove(&event.ticket);
        }
        if self.events.len() == EVENTS {
            return;
        }
        let flags = |word| -> Vec<&'static str> { Flag::in_word(word).map(Flag::name).collect() };
        let error = MotionError::from_codes(event.err, event.exerr).filter(|_| event.set & Flag::Er.mask() != 0);
        self.events.push(SimulatedEvent {
            time_s: time,
            tick: event.tick,
            tag: image.control_name(event.control).to_owned(),
            instruction: event.mnemonic.name(),
            set: flags(event.set),
            clear: flags(event.clear),
            err: event.err,
            exerr: event.exerr,
            error: error.map(|_| Refusal::motion(event.err, event.exerr, event.mnemonic)),
        });
    }
}

fn is_finite(point: &[f64]) -> bool {
    point.iter().all(|coordinate| coordinate.is_finite())
}

impl Trail {
    /// The newest point stays the last, so that a path ends where it ends.
    fn add(&mut self, tick: u64, point: Vec<f64>) {
        let last = self.points.len() - 1;
        if last > 0 && !tick.is_multiple_of(self.every) {
            self.points[last] = point;
            return;
        }
        self.points.push(point);
        if self.points.len() > POINTS {
            self.every *= 2;
            let newest = self.points.len() - 1;
            let mut place = 0;
            self.points.retain(|_| {
                place += 1;
                (place - 1) % 2 == 0 || place - 1 == newest
            });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_trail_has_its_ends_and_not_too_many_points() {
        let mut trail = Trail {
            points: vec![vec![0.0]],
            every: 1,
        };
        for tick in 1..=100_000u64 {
            trail.add(tick, vec![tick as f64]);
        }
        assert!(trail.points.len() <= POINTS, "{}", trail.points.len());
        assert!(trail.points.len() > POINTS / 4, "{}", trail.points.len());
        assert_eq!(
            (trail.points.first(), trail.points.last()),
            (Some(&vec![0.0]), Some(&vec![100_000.0]))
        );
        assert!(trail.points.is_sorted_by(|a, b| a[0] < b[0]));
    }
}
