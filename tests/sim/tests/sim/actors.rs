//! The clients of a scenario. Each has a random generator of its own, so that a scenario can leave another one out without a change of its actions.

mod faults;
mod implicit;
mod listener;
mod motion;
mod onlooker;
mod owner;
pub(crate) mod page;
mod peers;
pub(crate) mod tags;

use std::collections::BTreeSet;
use std::future::Future;
use std::net::{Ipv4Addr, SocketAddr};
use std::pin::Pin;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use arcline_tests::random::Random;

use crate::client::{Answer, Client, NoAnswer, PATIENCE_MS};
use crate::datagrams::Post;
use crate::history::History;
use crate::ledger::{Kind, Ledger};
use crate::motion::Deadline;
use crate::network::{End, Network, Weather};
use crate::record::{Record, lock};

/// An actor: its name and its function.
pub(crate) struct Actor {
    pub(crate) name: &'static str,
    pub(crate) act: fn(Environment) -> Acting,
}

pub(crate) type Acting = Pin<Box<dyn Future<Output = ()> + Send>>;

macro_rules! actor {
    ($name:literal, $act:path) => {
        Actor {
            name: $name,
            act: |env| Box::pin($act(env)),
        }
    };
}

/// All actors. The first ones only load the network: without them the machine moves the same.
pub(crate) const ACTORS: &[Actor] = &[
    actor!("hostile", peers::hostile),
    actor!("crowd", peers::crowd),
    actor!("slow reader", peers::slow_reader),
    actor!("half-open", peers::half_open),
    actor!("browser", peers::browser),
    actor!("writer 1", tags::writer_1),
    actor!("writer 2", tags::writer_2),
    actor!("reader", tags::reader),
    actor!("polling connection", tags::polling),
    actor!("stepper", motion::stepper),
    actor!("lines", motion::lines),
    actor!("jogger", motion::jogger),
    actor!("stopper", motion::stopper),
    actor!("owner of outputs", owner::owner),
    actor!("listener", listener::listener),
    actor!("onlooker", onlooker::onlooker),
    actor!("axis faults", faults::faults),
    actor!("page jogger", page::page_jogger),
    actor!("page program", page::page_program_1),
    actor!("another page program", page::page_program_2),
    actor!("page reader", page::page_reader),
];

/// Actors whose absence no other one notices (N2, T2).
pub(crate) const LOAD: &[&str] = &["hostile", "crowd", "slow reader", "half-open", "browser"];

/// The state that the actors share with the world.
#[derive(Clone, Default)]
pub(crate) struct Common {
    pub(crate) record: Record,
    pub(crate) history: History,
    pub(crate) ledger: Ledger,
    pub(crate) network: Network,
    pub(crate) post: Post,
    pub(crate) incoming: Arc<Mutex<Vec<(Port, End, SocketAddr)>>>,
    pub(crate) deadlines: Arc<Mutex<Vec<Order>>>,
    /// The server's starts and ends so far.
    pub(crate) lives: Arc<AtomicU64>,
    /// Session handles and connection ids that clients use.
    pub(crate) alive: Arc<Mutex<BTreeSet<u32>>>,
    /// ms: from then on nothing fails.
    pub(crate) quiet_from: u64,
    /// The end of the present or last stall of the tasks beside the tick, ms.
    pub(crate) stalled_until: Arc<AtomicU64>,
    /// Changes of instructions that the server has lost since its start.
    pub(crate) lost: Arc<AtomicU64>,
    /// Counters of clients begin near their end.
    pub(crate) near_end: bool,
    /// ms: from then on actors leave.
    pub(crate) leave_from: u64,
}

impl Common {
    /// The least handle or id that a client uses, 0 where there is none.
    pub(crate) fn some_alive(&self) -> u32 {
        lock(&self.alive).first().copied().unwrap_or_default()
    }
}

/// The port at which a client comes in.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Port {
    /// EtherNet/IP.
    Eip,
    /// The page.
    Page,
}

/// A message to the watch of motion.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Order {
    /// An axis must stand at a time.
    Rest(Deadline),
    /// An axis is moved again on purpose.
    Moves(usize),
    /// A line of CS1 may begin, to this position of X, Y and Z.
    Line([f64; 3]),
    /// The line was refused.
    NoLine([f64; 3]),
}

/// A session or a connection that a client uses, until it is dropped.
pub(crate) struct Alive {
    id: u32,
    all: Arc<Mutex<BTreeSet<u32>>>,
}

impl Drop for Alive {
    fn drop(&mut self) {
        lock(&self.all).remove(&self.id);
    }
}

/// Holds that answers come in time (N1).
pub(crate) struct InTime {
    name: &'static str,
    record: Record,
    quiet_from: u64,
    weather: Weather,
}

impl InTime {
    pub(crate) fn now(&self) -> u64 {
        self.record.now()
    }

    /// Judges an answer to a request of a time, ms, with the bytes of both.
    pub(crate) fn judge(&self, asked: u64, bytes: usize) {
        let took = self.now() - asked;
        // Two ways of the network for each of two frames, the pieces of both, and a second.
        let pieces = bytes.checked_div(self.weather.piece).unwrap_or_default() as u64;
        if asked >= self.quiet_from && took > 1000 + 4 * (self.weather.delay + 1) + pieces {
            let why = format!("{}: an answer took {took} ms", self.name);
            self.record.violated("N1", &why);
        }
    }
}

/// The environment of an actor.
pub(crate) struct Environment {
    pub(crate) name: &'static str,
    pub(crate) common: Common,
    pub(crate) random: Random,
    pub(crate) weather: Weather,
    address: Ipv4Addr,
    port: u16,
}

impl Environment {
    pub(crate) fn new(name: &'static str, number: u8, common: Common, mut random: Random) -> Self {
        let weather = Weather {
            delay: *random.one_of(&[0, 0, 0, 3, 30]),
            piece: *random.one_of(&[0, 0, 0, 1, 7]),
        };
        if weather.piece == 1 {
            common.record.sometimes("one byte at a time");
        }
        if weather.delay > 0 {
            common.record.sometimes("a slow network");
        }
        Environment {
            name,
            common,
            random,
            weather,
            address: match name {
                // An address with the least role.
                "onlooker" => Ipv4Addr::new(127, 0, 0, number),
                _ => Ipv4Addr::new(10, 0, 1, number),
            },
            port: 1024,
        }
    }

    /// Connects to the server's port of EtherNet/IP.
    pub(crate) fn connect(&mut self) -> End {
        self.connect_to(Port::Eip)
    }

    /// Connects to the server's port of the page.
    pub(crate) fn browse(&mut self) -> End {
        self.connect_to(Port::Page)
    }

    fn connect_to(&mut self, port: Port) -> End {
        let random = Random(self.random.bits());
        let (ours, theirs) = self.common.network.connect(self.weather, random);
        self.port += 1;
        let peer = SocketAddr::new(self.address.into(), self.port);
        lock(&self.common.incoming).push((port, theirs, peer));
        ours
    }

    /// A client with a session.
    pub(crate) async fn client(&mut self) -> Answer<Client> {
        let mut client = Client::register(self.connect(), self.in_time()).await?;
        client.alive.push(self.alive(client.session()));
        Ok(client)
    }

    /// Does something in a session of its own, and leaves in order; an end that comes before is judged.
    pub(crate) async fn session(&mut self, act: impl AsyncFnOnce(&mut Environment, &mut Client) -> Answer<()>) {
        let asked = self.now();
        let acted = match self.client().await {
            Ok(mut client) => act(self, &mut client).await.map(|()| client),
            Err(error) => Err(error),
        };
        match acted {
            Ok(client) => client.leave().await,
            Err(error) => self.judge(asked, &error),
        }
    }

    /// Records a handle or id of the server: it is not 0, and no other session has it (L4).
    pub(crate) fn alive(&self, id: u32) -> Alive {
        let is_new = lock(&self.common.alive).insert(id);
        if id == 0 || !is_new {
            let why = format!("{}: the handle or id {id:08X} is 0 or in use", self.name);
            self.common.record.violated("L4", &why);
        }
        Alive {
            id,
            all: self.common.alive.clone(),
        }
    }

    pub(crate) fn ip(&self) -> Ipv4Addr {
        self.address
    }

    pub(crate) fn now(&self) -> u64 {
        self.common.record.now()
    }

    pub(crate) fn is_over(&self) -> bool {
        self.now() >= self.common.leave_from
    }

    pub(crate) fn chance(&mut self, percent: u64) -> bool {
        self.random.below(100) < percent
    }

    pub(crate) async fn pause(&mut self, most: u64) {
        let ms = 1 + self.random.below(most.max(1));
        tokio::time::sleep(Duration::from_millis(ms)).await;
    }

    /// Judges why a session has ended that began at a time: a connection may end, but an answer is never wrong, and late only when something
    /// has failed.
    pub(crate) fn judge(&self, began: u64, error: &NoAnswer) {
        self.note(&format!("{error}"));
        // The client has waited this time for its last answer, unless the session is younger.
        let asked = began.max(self.now().saturating_sub(PATIENCE_MS));
        match error {
            NoAnswer::Ended => {}
            NoAnswer::Late if asked < self.common.quiet_from => {}
            NoAnswer::Late | NoAnswer::Wrong(_) | NoAnswer::Refused(_) => {
                self.common.record.violated("N1", &format!("{}: {error}", self.name));
            }
        }
    }

    /// The check of its answers.
    pub(crate) fn in_time(&self) -> InTime {
        InTime {
            name: self.name,
            record: self.common.record.clone(),
            quiet_from: self.common.quiet_from,
            weather: self.weather,
        }
    }

    /// Sends a request that the audit is to have an event of (U1).
    pub(crate) fn asks(&self, kind: Kind) {
        self.common.ledger.asks(self.address.into(), kind);
    }

    /// Records a request with the answer "done", or with "refused" for a request that must be refused.
    pub(crate) fn answered(&self, kind: Kind) {
        self.common.ledger.answered(self.address.into(), kind);
    }

    pub(crate) fn note(&self, event: &str) {
        self.common.record.note(self.name, event);
    }

    pub(crate) fn sometimes(&self, state: &'static str) {
        self.common.record.sometimes(state);
    }

    pub(crate) fn lives(&self) -> u64 {
        self.common.lives.load(Ordering::Relaxed)
    }

    /// The sequence count before the first one of a class 3 connection.
    pub(crate) fn first_count(&self) -> u16 {
        if !self.common.near_end {
            return 0;
        }
        self.sometimes("counters are near their end");
        u16::MAX - 5
    }

    /// Whether the server has lost changes of instructions: their tags may lag behind the instructions.
    pub(crate) fn has_lost(&self) -> bool {
        self.common.lost.load(Ordering::Relaxed) > 0
    }

    /// The end of the present or last stall of the tasks beside the tick, ms.
    pub(crate) fn stalled_until(&self) -> u64 {
        self.common.stalled_until.load(Ordering::Relaxed)
    }

    pub(crate) fn order(&self, order: Order) {
        lock(&self.common.deadlines).push(order);
    }
}
