//! The loop of a scenario: one virtual millisecond after another, each of them faults, the tick, the writer of the state, the tasks of the
//! server, those of the clients, and the invariants.

mod computer;
mod faults;
mod projects;

use std::cell::{Cell, RefCell};
use std::collections::VecDeque;
use std::net::{Ipv4Addr, SocketAddr};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicU8, Ordering};
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use arcline_proto::io::IO_PORT;
use arcline_server::eip::Settings;
use arcline_server::stepped::{Conditions, Held, Room, StartError, Stepped};
use arcline_state::recording::{Call, Recording};
use arcline_state::{Pace, Task};
use arcline_tag::TagPath;
use arcline_tests::random::Random;
use tokio::runtime::{Builder, Runtime};
use tokio::time::Instant;

use crate::actors::page::PROGRAM_TAG;
use crate::actors::tags::{PAIR, TAGS};
use crate::actors::{ACTORS, Common, Environment, Order, Port};
use crate::history::Wrote;
use crate::motion::Watch;
use crate::plan::{Fault, Scenario};
use crate::probe::{Probe, judge_pair};
use crate::record::{Record, lock};
use crate::told;
use computer::Computer;
use projects::Projects;

thread_local! {
    /// Session handles and connection ids of the server.
    static HANDLES: Cell<u64> = const { Cell::new(0) };
    /// The clock on the wall, ms since 1970.
    static WALL: Cell<u64> = const { Cell::new(0) };
    /// Messages of panics, which tasks swallow.
    static PANICS: RefCell<Vec<String>> = const { RefCell::new(Vec::new()) };
}

/// Notes a panic of this thread; the hook of panics calls it.
pub(crate) fn panicked(message: String) {
    PANICS.with_borrow_mut(|panics| panics.push(message));
}

fn handles() -> Option<u32> {
    HANDLES.with(|handles| {
        let mut random = Random(handles.get());
        let bits = random.bits();
        handles.set(random.0);
        Some((bits >> 32) as u32 | 1)
    })
}

/// The clock on the wall of this thread's scenario.
pub(crate) fn wall() -> SystemTime {
    UNIX_EPOCH + Duration::from_millis(WALL.get())
}

/// A server that runs.
struct Running {
    // Dropped before the runtime on which its tasks run.
    server: Stepped<Computer>,
    runtime: Runtime,
    began: Instant,
    /// ms of the scenario at its start.
    since: u64,
    /// A synchronisation under way: when it ends, and the clock of the history when it was begun.
    task: Option<(u64, Task<Computer>, u64)>,
    /// Which of the projects it has.
    configured: usize,
}

/// The end of a scenario.
pub(crate) struct Outcome {
    pub(crate) record: Record,
    pub(crate) motion: u64,
    pub(crate) memory: Memory,
}

/// The bytes that a scenario holds; of use where it runs alone.
#[derive(Default)]
pub(crate) struct Memory {
    /// The samples behind each millisecond.
    pub(crate) during: Vec<Sample>,
    /// When all clients have left.
    pub(crate) behind: usize,
    /// Held by the process before.
    before: usize,
}

impl Memory {
    fn now(&self) -> usize {
        crate::MEMORY.allocated().saturating_sub(self.before)
    }
}

/// The memory behind a millisecond.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sample {
    pub(crate) bytes: usize,
    /// Connections that the server serves.
    pub(crate) connections: usize,
}

struct World<'s> {
    scenario: &'s Scenario,
    projects: Projects,
    common: Common,
    now: u64,
    running: Option<Running>,
    start_at: u64,
    /// The disk is `computer`'s.
    disk: Recording,
    computer: Computer,
    conditions: Conditions,
    /// The next start is killed at this call of the disk; the one behind it comes after this time, ms.
    start_killed: Option<(u64, usize)>,
    failing: Arc<AtomicU8>,
    failing_until: u64,
    sync_takes: u64,
    pace: Pace,
    /// Writes that were answered by then are on the disk, even after a loss of power.
    durable: u64,
    beside: Option<u64>,
    late_until: u64,
    owed: u64,
    planner_until: u64,
    stalled_until: u64,
    watch: Watch,
    draw: Random,
    probe: Probe,
    clients_first: bool,
    memory: Memory,
}

/// Runs a scenario to its end or to its first violation.
pub(crate) fn run(scenario: &Scenario, record: Record) -> Outcome {
    let before = crate::MEMORY.allocated();
    PANICS.with_borrow_mut(Vec::clear);
    HANDLES.set(scenario.seed);
    WALL.set(WALL_AT_BEGIN);
    told::begin();
    let projects = Projects::new();
    let common = Common {
        record: record.clone(),
        quiet_from: scenario.quiet_from(),
        leave_from: scenario.ticks.saturating_sub(LEAVING),
        near_end: scenario.is_near_end(),
        ..Common::default()
    };
    let mut draw = scenario.random("world");
    let clients_first = draw.below(2) == 0;
    // Often so little that the file is written anew some times.
    let pace = Pace {
        growth: *draw.one_of(&[8 * 1024, 64 * 1024, 1024 * 1024]),
        ..Pace::default()
    };
    let disk = Recording::default();
    let mut world = World {
        computer: Computer::new(disk.clone()),
        disk,
        conditions: scenario.conditions(),
        start_killed: None,
        stalled_until: 0,
        watch: Watch::new(&projects.0[0].machine),
        scenario,
        projects,
        common,
        now: 0,
        running: None,
        start_at: 0,
        failing: Arc::default(),
        failing_until: 0,
        sync_takes: 2,
        pace,
        durable: 0,
        beside: None,
        late_until: 0,
        owed: 0,
        planner_until: 0,
        draw,
        probe: Probe::new(scenario.random("probe")),
        clients_first,
        memory: Memory {
            during: Vec::with_capacity(scenario.ticks as usize),
            behind: 0,
            before,
        },
    };
    world.run();
    Outcome {
        record,
        motion: world.watch.hash.0,
        memory: world.memory,
    }
}

impl World<'_> {
    fn run(&mut self) {
        let clients = runtime();
        let clients_began = clients.block_on(async { Instant::now() });
        let names = self.scenario.actors();
        for (number, actor) in (1..).zip(ACTORS) {
            if names.contains(&actor.name) {
                let random = self.scenario.random(actor.name);
                let env = Environment::new(actor.name, number, self.common.clone(), random);
                let _guard = clients.enter();
                let last = Duration::from_millis(self.common.leave_from + BREAK_OFF);
                drop(clients.spawn(tokio::time::timeout_at(clients_began + last, (actor.act)(env))));
            }
        }
        let mut faults: VecDeque<(u64, Fault)> = self.scenario.faults().into();
        self.fail_disk();
        for now in 1..=self.scenario.ticks {
            self.now = now;
            WALL.set(WALL.get() + 1);
            self.common.record.begin(now);
            self.common.network.begin(now);
            self.common.post.begin(now);
            while faults.front().is_some_and(|(at, _)| *at <= now) {
                if let Some((_, fault)) = faults.pop_front() {
                    self.strike(fault);
                }
            }
            if now == self.failing_until {
                self.failing.store(0, Ordering::Relaxed);
            }
            if now == self.scenario.quiet_from() {
                self.calm();
            }
            if self.clients_first {
                turn(&clients, clients_began, now);
            }
            self.serve();
            if !self.clients_first {
                turn(&clients, clients_began, now);
            }
            self.check();
            self.measure();
            if self.common.record.is_violated() {
                break;
            }
        }
        if !self.common.record.is_violated() {
            self.finish();
            self.memory.behind = self.memory.now();
        }
        drop(clients);
        self.end_server();
    }

    /// Notes the memory that is held.
    fn measure(&mut self) {
        let held = self.running.as_ref().map(|running| running.server.held());
        self.memory.during.push(Sample {
            bytes: self.memory.now(),
            connections: held.map_or(0, |held| held.clients + held.browsers),
        });
    }

    /// A millisecond of the server.
    fn serve(&mut self) {
        if self.running.is_none() && self.now >= self.start_at {
            self.start();
        }
        let incoming = std::mem::take(&mut *lock(&self.common.incoming));
        let Some(running) = &mut self.running else {
            // There is no listener: close them.
            drop(incoming);
            return;
        };
        for (port, end, peer) in incoming {
            match port {
                Port::Eip => running.server.connect(Box::new(end), peer),
                Port::Page => running.server.browse(Box::new(end), peer),
            }
        }
        self.owed += 1;
        if self.now >= self.late_until {
            if self.owed > CATCH_UP {
                self.common.record.sometimes("the time base moves");
                self.owed = 1;
            } else if self.owed > 1 {
                self.common.record.sometimes("late ticks are caught up");
            }
            for _ in 0..std::mem::take(&mut self.owed) {
                let is_inhibited = running.server.plant().is_inhibited();
                let (watch, record) = (&mut self.watch, &self.common.record);
                running
                    .server
                    .tick(&mut |snapshot| watch.see(snapshot, is_inhibited, record));
            }
        }
        self.look_at_rings();
        if self.now >= self.stalled_until {
            self.serve_beside();
        }
    }

    /// Records the rings without room, and the losses.
    fn look_at_rings(&self) {
        let Some(running) = &self.running else { return };
        if self.conditions.room == Room::default() {
            return;
        }
        let (full, record) = (running.server.full_rings(), &self.common.record);
        if full.commands {
            record.sometimes("the ring of commands is full");
        }
        if full.events {
            record.sometimes("the ring of events is full");
        }
        if full.samples {
            record.sometimes("the ring of samples is full");
        }
        let lost = running.server.plant().health().lost_events;
        if lost > 0 {
            record.sometimes("events are lost");
        }
        self.common.lost.store(lost, Ordering::Relaxed);
    }

    /// One millisecond of the tasks beside the tick.
    fn serve_beside(&mut self) {
        let Some(running) = &mut self.running else { return };
        if self.now >= self.planner_until {
            running.server.plan();
        }
        if self.now.is_multiple_of(10) {
            running.server.trace();
        }
        self.keep();
        if let Some(running) = &self.running {
            turn(&running.runtime, running.began, self.now - running.since);
        }
        if let Some(running) = &mut self.running {
            let _guard = running.runtime.enter();
            running.server.exchange();
            for event in running.server.audited() {
                self.common.ledger.event(&event, &self.common.record);
            }
        }
    }

    /// A turn of the writer of the state.
    fn keep(&mut self) {
        let ends = |running: &Running| running.task.as_ref().is_some_and(|(due, _, _)| *due <= self.now);
        if self.running.as_ref().is_some_and(ends) && self.probe.is_due() {
            self.probe();
        }
        let Some(running) = &mut self.running else { return };
        let now = Duration::from_millis(self.now - running.since);
        let mut ended = None;
        if let Some((_, task, begun)) = running.task.take_if(|(due, _, _)| *due <= self.now) {
            ended = Some(task.run());
            match self.disk.last() {
                Some(Call::Sync(inode)) if self.disk.is_named(inode, &file()) => self.durable = begun,
                Some(Call::Sync(_)) => self.beside = Some(begun),
                Some(Call::SyncFolder) => {
                    if let Some(begun) = self.beside.take() {
                        self.durable = begun;
                        self.common.record.sometimes("the file is written anew");
                    }
                }
                _ => self.common.record.sometimes("a synchronisation fails"),
            }
        }
        if let Some(task) = running.server.step_writer(ended, now) {
            let due = self.now + 1 + self.draw.below(self.sync_takes + 1);
            running.task = Some((due, task, self.common.history.clock()));
        }
    }

    /// A server of the first project on the computer.
    fn server(&self, runtime: &Runtime) -> Result<Stepped<Computer>, StartError> {
        let mut settings = Settings::new(&self.projects.0[0].server);
        let post = Arc::new(self.common.post.clone());
        settings.datagrams = Some((post, SocketAddr::from((Ipv4Addr::new(10, 0, 0, 1), IO_PORT))));
        settings.write_timeout = Duration::from_secs(2);
        settings.system = PathBuf::from("/nonexistent");
        settings.random = handles;
        let project = self.projects.0[0].clone();
        let disk = (self.computer.clone(), file(), self.pace);
        let _guard = runtime.enter();
        Stepped::start(project, Some(disk), settings, self.conditions)
    }

    fn start(&mut self) {
        let runtime = runtime();
        if let Some((again, call)) = self.start_killed.take() {
            return self.kill_start(&runtime, again, call);
        }
        let started = self.server(&runtime);
        let server = match started {
            Ok(server) => server,
            Err(error) => {
                self.common.record.violated("W2", &format!("{error}"));
                return;
            }
        };
        // With any bytes of a crash behind the horizon, the file is never set aside.
        if self.disk.has(|name| name.to_string_lossy().contains("set-aside")) {
            self.common.record.violated("W2", "the file was set aside");
        }
        let values = server.plant().with_image(|image| {
            let value = |tag: &'static str| {
                let path: TagPath = tag.parse().expect("a name");
                (tag, image.read(&path).expect("it exists").as_f64() as i32)
            };
            TAGS.iter()
                .chain(&PAIR)
                .chain(&[PROGRAM_TAG])
                .map(|tag| value(tag))
                .collect::<Vec<_>>()
        });
        let wrote = match self.failing.load(Ordering::Relaxed) {
            0 => Wrote::Anew,
            _ => Wrote::Nothing,
        };
        for wrong in self.common.history.start(&values, self.durable, wrote) {
            self.common.record.broken(wrong);
        }
        judge_pair(&values, &self.common.record);
        if self.common.lives.fetch_add(1, Ordering::Relaxed) > 0 {
            self.common.record.sometimes("a restart");
        }
        self.common.record.note("world", &format!("starts with {values:?}"));
        self.durable = match wrote {
            Wrote::Anew => self.common.history.clock(),
            Wrote::Nothing => {
                self.common.record.sometimes("a start on a failing disk");
                0
            }
        };
        self.beside = None;
        self.owed = 0;
        told::begin();
        self.common.lost.store(0, Ordering::Relaxed);
        let began = runtime.block_on(async { Instant::now() });
        self.running = Some(Running {
            server,
            runtime,
            began,
            since: self.now - 1,
            task: None,
            configured: 0,
        });
    }

    /// Checks the effect of a loss of power at this instant.
    fn probe(&mut self) {
        let (history, record) = (&self.common.history, &self.common.record);
        self.probe.look(&self.disk, &file(), history, self.durable, record);
    }

    fn end_server(&mut self) {
        self.running = None;
        self.common.lives.fetch_add(1, Ordering::Relaxed);
        self.common.post.lose_server();
        self.watch.restart();
        lock(&self.common.deadlines).clear();
    }

    fn check(&mut self) {
        for order in std::mem::take(&mut *lock(&self.common.deadlines)) {
            match order {
                Order::Rest(deadline) => self.watch.expect_rest(deadline),
                Order::Moves(axis) => self.watch.forget(axis),
                Order::Line(target) => self.watch.expect_line(target),
                Order::NoLine(target) => self.watch.forget_line(target),
            }
        }
        if self.now < self.stalled_until {
            self.watch.postpone();
        }
        // Late ticks are made up before the check.
        if self.now >= self.late_until.max(self.stalled_until) + 100 {
            self.watch.due(self.now, &self.common.record);
        }
        let panics = PANICS.take();
        for panic in panics {
            self.common.record.violated("N1", &panic);
        }
        self.common.record.mix(&self.watch.hash.0.to_le_bytes());
    }

    /// The invariants after all clients have left.
    fn finish(&mut self) {
        let record = self.common.record.clone();
        for wrong in self.common.history.check() {
            record.broken(wrong);
        }
        for wrong in self.common.ledger.check() {
            record.broken(wrong);
        }
        self.probe();
        // An owner that never got the answer to its Forward Open has this time for its first datagram.
        for _ in 0..FIRST_DATAGRAM {
            if self
                .running
                .as_ref()
                .is_none_or(|running| running.server.held().io == 0)
            {
                break;
            }
            self.now += 1;
            self.common.network.begin(self.now);
            self.serve();
        }
        let Some(running) = &self.running else {
            record.violated("N1", "the server does not run at the end");
            return;
        };
        let held = running.server.held();
        if held != Held::default() {
            record.violated("L3", &format!("{held:?} are held for clients that have left"));
        }
        let health = running.server.plant().health();
        if health.lost_answers != 0 {
            record.violated("D3", &format!("{} answers were lost", health.lost_answers));
        }
        // Each reported change is logged or counted as lost, and each loss is logged once.
        let changes = running.server.changes();
        if changes.logged + health.lost_events != changes.reported {
            let why = format!("{changes:?}, and {} are counted as lost", health.lost_events);
            record.violated("T3", &why);
        }
        let (told, lost) = (told::lost(), health.lost_events + health.lost_answers);
        if told != lost {
            record.violated("T3", &format!("{lost} changes are lost, and {told} were told"));
        }
    }
}

/// Runs the ready tasks of a runtime, and its clock to a time since it began, ms. Tasks that were stalled see the end of the stall.
fn turn(runtime: &Runtime, began: Instant, ms: u64) {
    let time = began + Duration::from_millis(ms);
    runtime.block_on(async {
        let stalled = time.saturating_duration_since(Instant::now() + MILLISECOND);
        if !stalled.is_zero() {
            tokio::time::advance(stalled).await;
        }
        // The clock goes on when no task is ready.
        tokio::time::sleep_until(time).await;
    });
}

/// Of the tasks that are ready, those that another one woke come before those that the network woke, whatever their number: so the order of
/// all tasks is the same with more clients (N2).
fn runtime() -> Runtime {
    Builder::new_current_thread()
        .enable_time()
        .start_paused(true)
        .global_queue_interval(u32::MAX)
        .event_interval(u32::MAX)
        .build()
        .expect("a runtime without threads")
}

fn file() -> PathBuf {
    PathBuf::from("machine.state")
}

const MILLISECOND: Duration = Duration::from_millis(1);
/// The time before the end at which actors leave, ms. The server needs it to detect a client that has vanished, and for the last answers of a
/// controller that does not answer.
const LEAVING: u64 = 7_000;
/// The time after which an actor that still waits for an answer breaks off, ms.
const BREAK_OFF: u64 = 1_800;
/// The longest silence before the first datagram of an I/O connection, ms (docs/IO.md).
const FIRST_DATAGRAM: u64 = 10_100;
/// The clock on the wall at the beginning, ms since 1970: late in 2026.
const WALL_AT_BEGIN: u64 = 1_795_000_000_000;
/// As the thread of the tick has it.
const CATCH_UP: u64 = 1000;
