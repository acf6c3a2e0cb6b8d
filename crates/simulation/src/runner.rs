//! A simulation with programs: the runner executes ticks, and programs continue in those in which they have work.

use std::collections::BTreeMap;
use std::ops::{Deref, DerefMut};
use std::sync::{Arc, MutexGuard};

use arcline_controller::Ticket;
use arcline_controller::image::Image;
use arcline_controller::machine::Machine;
use arcline_structured_text::{Interpreter, OnError, Policy, ProgramRun, RunError};

use crate::end::{End, Erred, Refused};
use crate::observer::Observer;
use crate::program::{Ended, ProgramId, SharedSimulation, SimulationWithWaits, Task, Wait};
use crate::simulation::Simulation;

/// The options for running a program to its end.
#[derive(Clone, Copy, Debug)]
pub struct Options {
    /// Longest simulated time, s.
    pub until: f64,
    /// The program's reactions.
    pub policy: Policy,
}

/// A piece of a program.
#[derive(Debug)]
pub struct Piece {
    /// Its statements.
    pub interpreter: Interpreter,
    /// Number of lines in the pieces before it.
    pub lines_before: usize,
}

/// The limits for executing ticks.
#[derive(Clone, Copy, Debug)]
pub struct RunLimits {
    /// Most ticks that may begin.
    pub ticks: u64,
    /// The simulated time after which no tick begins, seconds.
    pub until: f64,
}

/// The reason why the execution of ticks ended.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Passed {
    /// A program has work.
    Due,
    /// The number of ticks is reached; the present tick is open.
    Ticks,
    /// The simulated time is over; the present tick is closed.
    Time,
    /// The observer ended the run; the present tick is closed.
    Left,
}

/// A machine on a virtual clock, and its programs.
#[derive(Debug)]
pub struct Runner {
    shared: SharedSimulation,
    tasks: BTreeMap<ProgramId, Program>,
    programs: u32,
}

/// A program under way, or its end.
#[derive(Debug)]
enum Program {
    Runs(Task),
    Ended(Result<(), RunError<Refused>>),
}

/// Access to the simulation of a [`Runner`]. Not held while ticks are executed.
#[derive(Debug)]
pub struct Locked<'r>(MutexGuard<'r, SimulationWithWaits>);

impl Deref for Locked<'_> {
    type Target = Simulation;

    fn deref(&self) -> &Simulation {
        &self.0.simulation
    }
}

impl DerefMut for Locked<'_> {
    fn deref_mut(&mut self) -> &mut Simulation {
        &mut self.0.simulation
    }
}

impl Runner {
    /// A machine with simulated drives and these tags, before tick 0.
    pub fn new(machine: Arc<Machine>, image: Image) -> Self {
        Self::of(Simulation::new(machine, image))
    }

    /// A simulation without programs.
    pub fn of(simulation: Simulation) -> Self {
        Runner {
            shared: SharedSimulation::new(simulation),
            tasks: BTreeMap::new(),
            programs: 0,
        }
    }

    /// The simulation.
    pub fn simulation(&self) -> Locked<'_> {
        Locked(self.shared.lock())
    }

    /// Starts a program: it runs until it waits. The present tick must be open.
    pub fn start(&mut self, program: Interpreter, policy: Policy) -> ProgramId {
        self.programs += 1;
        let id = ProgramId(self.programs);
        self.continue_with(id, ProgramRun::new(program, policy), policy);
        id
    }

    /// The program is under way, including its waits.
    pub fn runs(&self, program: ProgramId) -> bool {
        matches!(self.tasks.get(&program), Some(Program::Runs(_)))
    }

    /// The end of a program; `None` while it is under way. Errors of its instructions after its end count, too.
    pub fn end_of(&self, program: ProgramId) -> Option<Result<(), End>> {
        let Program::Ended(ended) = self.tasks.get(&program)? else {
            return None;
        };
        let erred = self.error_of(program);
        Some(match (ended, erred) {
            (
                Ok(())
                | Err(RunError::Driver {
                    error: Refused::Erred { .. },
                    ..
                }),
                Some(erred),
            ) => Err(End::Erred(erred)),
            (Ok(()), None) => Ok(()),
            (Err(wrong), _) => Err(End::Wrong(wrong.clone())),
        })
    }

    /// Ends a program and removes it. Motion that it began continues.
    pub fn remove(&mut self, program: ProgramId) {
        self.tasks.remove(&program);
        let mut shared = self.shared.lock();
        shared.waits.remove(&program);
        shared.simulation.calls_mut().take_erred(program);
    }

    /// Runs a program from tick 0 until it and all motion have ended.
    pub fn run(&mut self, program: Interpreter, options: Options, observer: &mut impl Observer) -> End {
        let ran = self.run_pieces(program, options, observer, |_| Ok::<_, std::convert::Infallible>(None));
        match ran {
            Ok(end) => end,
            Err(never) => match never {},
        }
    }

    /// Runs a program with further pieces; `next` is called after each piece has run.
    ///
    /// # Errors
    /// Those of `next`.
    pub fn run_pieces<E>(
        &mut self,
        first: Interpreter,
        options: Options,
        observer: &mut impl Observer,
        mut next: impl FnMut(&Image) -> Result<Option<Piece>, E>,
    ) -> Result<End, E> {
        let Options { until, policy } = options;
        {
            let mut simulation = self.simulation();
            observer.begin(simulation.machine());
            simulation.begin();
        }
        self.programs += 1;
        let id = ProgramId(self.programs);
        let mut run = ProgramRun::new(first, policy);
        let ended = loop {
            let (rest, ended) = match self.run_piece(id, run, options, observer) {
                Ok(ended) => ended,
                Err(end) => return Ok(end),
            };
            run = rest;
            if ended.is_err() {
                break ended;
            }
            let piece = next(self.simulation().image())?;
            let Some(piece) = piece else { break ended };
            run.load(piece.interpreter, piece.lines_before);
        };
        let wrong = match ended {
            Ok(())
            | Err(RunError::Driver {
                error: Refused::Erred { .. },
                ..
            }) => None,
            Err(
                wrong @ RunError::Driver {
                    error: Refused::Still, ..
                },
            ) => return Ok(End::Wrong(wrong)),
            Err(wrong) => Some(wrong),
        };
        if let Err(end) = self.come_to_rest(until, observer) {
            return Ok(end);
        }
        let erred = self.simulation().calls_mut().take_erred(id);
        Ok(match (wrong, erred) {
            (Some(wrong), _) => End::Wrong(wrong),
            (None, Some(erred)) if policy.on_error == OnError::Stop => End::Erred(erred),
            (None, _) => End::Finished,
        })
    }

    /// Executes ticks, and the programs in them, up to the limits.
    pub fn step(&mut self, limits: RunLimits, observer: &mut impl Observer) -> Passed {
        let last = self.simulation().tick().saturating_add(limits.ticks);
        loop {
            let left = last.saturating_sub(self.simulation().tick());
            let passed = self.pass(RunLimits { ticks: left, ..limits }, observer);
            if passed != Passed::Due {
                return passed;
            }
            self.poll();
            let simulation = self.simulation();
            if simulation.is_open() && simulation.tick() >= last {
                return Passed::Ticks;
            }
        }
    }

    /// Executes ticks until a program has work, all motion has ended or the time is up.
    fn pass(&self, limits: RunLimits, observer: &mut impl Observer) -> Passed {
        let mut shared = self.shared.lock();
        let mut left = limits.ticks;
        while left > 0 {
            if shared.simulation.is_open() && !shared.simulation.end(observer) {
                return Passed::Left;
            }
            let SimulationWithWaits { simulation, waits } = &mut *shared;
            if wake(waits, |id, wait| wait.error(id, simulation).map(Err)) {
                return Passed::Due;
            }
            if simulation.time() >= limits.until {
                return Passed::Time;
            }
            if wake(waits, |_, wait| wait.is_vain(simulation).then_some(Err(Refused::Still))) {
                return Passed::Due;
            }
            let most = simulation.unseen_ticks(limits.until, observer).min(left - 1);
            let idle = waits.values().map(|wait| wait.idle_ticks(simulation));
            left -= 1 + simulation.begin_after(idle.fold(most, u64::min));
            if wake(waits, |_, wait| wait.is_due(simulation).then_some(Ok(()))) {
                return Passed::Due;
            }
        }
        Passed::Ticks
    }

    /// Executes ticks until all motion has ended.
    fn come_to_rest(&self, until: f64, observer: &mut impl Observer) -> Result<(), End> {
        let mut shared = self.shared.lock();
        let simulation = &mut shared.simulation;
        loop {
            if simulation.is_open() && !simulation.end(observer) {
                return Err(End::Left);
            }
            if simulation.controller().at_rest() {
                return Ok(());
            }
            if simulation.time() >= until {
                return Err(End::TooLong(until));
            }
            simulation.begin_after(simulation.unseen_ticks(until, observer));
        }
    }

    /// Runs a piece of a program to its end.
    fn run_piece(
        &self,
        id: ProgramId,
        run: ProgramRun<Ticket>,
        options: Options,
        observer: &mut impl Observer,
    ) -> Result<Ended, End> {
        self.shared.lock().waits.insert(id, Wait::new(options.policy));
        let mut task = Task::new(self.shared.clone(), id, run);
        let limits = RunLimits {
            ticks: u64::MAX,
            until: options.until,
        };
        let ended = loop {
            if let Some(ended) = task.poll() {
                break Ok(ended);
            }
            match self.pass(limits, observer) {
                Passed::Due | Passed::Ticks => {}
                Passed::Time => break Err(End::TooLong(options.until)),
                Passed::Left => break Err(End::Left),
            }
        };
        self.shared.lock().waits.remove(&id);
        ended
    }

    /// Runs a program until it waits.
    fn continue_with(&mut self, id: ProgramId, run: ProgramRun<Ticket>, policy: Policy) {
        self.shared.lock().waits.insert(id, Wait::new(policy));
        let task = Task::new(self.shared.clone(), id, run);
        self.tasks.insert(id, Program::Runs(task));
        self.poll_one(id);
    }

    /// Runs the programs whose pauses have ended, in the order of their starts.
    fn poll(&mut self) {
        let running: Vec<ProgramId> = self.tasks.keys().copied().collect();
        for id in running {
            self.poll_one(id);
        }
    }

    fn poll_one(&mut self, id: ProgramId) {
        let Some(program) = self.tasks.get_mut(&id) else { return };
        let Program::Runs(task) = program else { return };
        if let Some((_, ended)) = task.poll() {
            *program = Program::Ended(ended);
            self.shared.lock().waits.remove(&id);
        }
    }

    /// The first error of a program so far.
    pub fn error_of(&self, program: ProgramId) -> Option<Erred> {
        self.simulation().calls().erred(program).cloned()
    }
}

/// Ends the pauses for which `look` has a result. Returns true if there were any.
fn wake(
    waits: &mut BTreeMap<ProgramId, Wait>,
    mut look: impl FnMut(ProgramId, &mut Wait) -> Option<Result<(), Refused>>,
) -> bool {
    let mut any = false;
    for (id, wait) in waits {
        if let Some(result) = look(*id, wait) {
            wait.end(result);
            any = true;
        }
    }
    any
}
