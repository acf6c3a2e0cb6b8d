//! The guard of jogs: it stops those of clients that are lost, silent, or no longer hold the button.
//!
//! The guard has its own thread, `arcline-stop`, whose priority is below that of the tick and, where the system allows that, above all other
//! threads. It also has its own path to the tick ([`Stops`]), so that neither the work of the network's threads nor the plant's lock delays
//! a stop. The same thread reads the page's viewers, for their STOP. Tasks on this thread must be short.
//!
//! A stop of a jog is one at the axis's full deceleration, not at the programmed one; the guard requests it again until the axis stands.
//! Not here: the messages of a page that stop (`hmi`), and the reaction of motion other than jogs (`plant::Principal`).

mod table;
mod watch;

use std::collections::BTreeMap;
use std::os::fd::OwnedFd;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError, Weak};
use std::time::Duration;

use arcline_controller::Ticket;
use arcline_controller::machine::Machine;
use arcline_instruction_set::{AxisId, JogEnd};
use arcline_realtime::{Stops, prepare_beside_tick};
use tokio::runtime::{Builder, Handle};
use tokio::sync::Notify;
use tokio::time::Instant;
use tokio_util::sync::CancellationToken;
use tracing::{debug, warn};

use self::table::{Jog, JogState, Table};
use crate::plant::{ClientIdentity, Plant, Principal};
use arcline_state::planted::is_planted;

/// The guard stops a jog that a button holds after this time without a sign of life.
pub(crate) const KEEP_WITHIN: Duration = Duration::from_millis(150);
/// Time between two checks of the jogs.
const LOOK: Duration = Duration::from_millis(10);

/// Sessions from this number on are viewers of the page.
pub(crate) const VIEWERS: u64 = 1 << 63;

/// The guard. Clones are the same one.
#[derive(Clone, Debug)]
pub(crate) struct Guard(Arc<Shared>);

#[derive(Debug)]
struct Shared {
    stops: Stops,
    axes: Vec<String>,
    /// Silence after which the jogs of a client are stopped; `None`: never.
    silence: Option<Duration>,
    epoch: Instant,
    table: Mutex<Table>,
    clients: Mutex<BTreeMap<u64, Client>>,
    wake: Notify,
    closed: AtomicBool,
    runtime: OnceLock<Handle>,
}

#[derive(Debug)]
struct Client {
    signs: Signs,
    interface: Weak<dyn ClientInterface>,
    /// Ends the watch on its socket.
    watched: Option<CancellationToken>,
}

/// The interface by which a client came in, as the guard needs it.
pub(crate) trait ClientInterface: Send + Sync + std::fmt::Debug {
    /// Whether jogs go on when their owner is lost or silent.
    fn keeps_jogs(&self, owner: Principal) -> bool;
    /// The socket of a client has closed without a word; its jogs are stopped already.
    fn lost(&self, session: u64);
}

/// The signs of life of one client; clones are the same one.
#[derive(Clone, Debug)]
pub(crate) struct Signs(Arc<SignsOfLife>);

#[derive(Debug)]
struct SignsOfLife {
    epoch: Instant,
    /// The time of the last message, µs since the epoch.
    heard: AtomicU64,
    /// The time of the last message after a longer silence than the clients' jogs survive, µs since the epoch.
    broken: AtomicU64,
    /// That silence, µs.
    silence: u64,
    /// The guard wants to watch the client's socket.
    wanted: AtomicBool,
    /// Cancelled when the client has gone.
    left: CancellationToken,
}

impl Signs {
    /// A message came.
    pub(crate) fn heard(&self) {
        let now = micros(self.0.epoch.elapsed());
        let before = self.0.heard.swap(now, Ordering::AcqRel);
        // The guard may not have looked since: a computer that stood still for as long gets this message first.
        if now.saturating_sub(before) > self.0.silence {
            self.0.broken.store(now, Ordering::Release);
        }
    }

    /// Whether the guard wants to watch the socket; a call clears the wish.
    pub(crate) fn is_wanted(&self) -> bool {
        self.0.wanted.load(Ordering::Relaxed) && self.0.wanted.swap(false, Ordering::AcqRel)
    }

    /// The client has gone, also where its last request still runs: no ticks pass for it any more.
    pub(crate) fn leave(&self) {
        self.0.left.cancel();
    }

    /// Jogs that began before this moment are those of a silent client.
    fn silent_at(&self, now: Duration) -> Duration {
        let heard = self.0.heard.load(Ordering::Acquire);
        if micros(now).saturating_sub(heard) > self.0.silence {
            return Duration::MAX;
        }
        Duration::from_micros(self.0.broken.load(Ordering::Acquire))
    }
}

impl Guard {
    /// Makes the guard of a machine; `silence` in ms, 0: never. It watches nothing before [`Guard::spawn`].
    pub(crate) fn new(stops: Stops, machine: &Machine, silence: u16) -> Self {
        Guard(Arc::new(Shared {
            stops,
            axes: machine.axes.iter().map(|axis| axis.name.clone()).collect(),
            silence: (silence > 0).then(|| Duration::from_millis(silence.into())),
            epoch: Instant::now(),
            table: Mutex::default(),
            clients: Mutex::default(),
            wake: Notify::new(),
            closed: AtomicBool::new(false),
            runtime: OnceLock::new(),
        }))
    }

    /// Starts the thread. It ends with the plant.
    ///
    /// # Errors
    /// When the system has no thread left.
    pub(crate) fn spawn(&self, plant: Weak<crate::plant::Shared>) -> std::io::Result<()> {
        // After every task the runtime polls the ready sockets.
        let runtime = Builder::new_current_thread().enable_all().event_interval(1).build()?;
        let _ = self.0.runtime.set(runtime.handle().clone());
        let guard = self.clone();
        std::thread::Builder::new()
            .name("arcline-stop".to_owned())
            .spawn(move || {
                for shortfall in prepare_beside_tick().shortfalls {
                    debug!(%shortfall, "stops may be late");
                }
                runtime.block_on(guard.run(&plant));
            })
            .map(drop)
    }

    /// The runtime of the thread, if it runs.
    pub(crate) fn runtime(&self) -> Option<Handle> {
        self.0.runtime.get().cloned()
    }

    /// Ends the thread.
    pub(crate) fn close(&self) {
        self.0.closed.store(true, Ordering::Release);
        self.0.wake.notify_one();
    }

    /// A client has come in.
    pub(crate) fn enter(&self, session: u64, identity: ClientIdentity, interface: Weak<dyn ClientInterface>) -> Signs {
        let signs = Signs(Arc::new(SignsOfLife {
            epoch: self.0.epoch,
            heard: AtomicU64::new(micros(self.now())),
            broken: AtomicU64::new(0),
            silence: self.0.silence.map_or(u64::MAX, micros),
            wanted: AtomicBool::new(false),
            left: CancellationToken::new(),
        }));
        self.table().identify(session, |known| *known = identity);
        let client = Client {
            signs: signs.clone(),
            interface,
            watched: None,
        };
        self.clients().insert(session, client);
        signs
    }

    /// A client has gone; its jogs have been ended or released before.
    pub(crate) fn leave(&self, session: u64) {
        let client = self.clients().remove(&session);
        if let Some(client) = client {
            client.signs.leave();
            if let Some(watched) = client.watched {
                watched.cancel();
            }
        }
        self.table().leave(session);
    }

    /// Is cancelled when a client has gone; `None`: it was never here, or has gone in order.
    pub(crate) fn left(&self, session: u64) -> Option<CancellationToken> {
        let clients = self.clients();
        clients.get(&session).map(|client| client.signs.0.left.clone())
    }

    /// Clients that are here: of EtherNet/IP, and viewers of the page.
    pub(crate) fn count(&self) -> [usize; 2] {
        let clients = self.clients();
        let viewers = clients.range(VIEWERS..).count();
        [clients.len() - viewers, viewers]
    }

    /// A client has sent its identification.
    pub(crate) fn identify(&self, session: u64, change: impl FnOnce(&mut ClientIdentity)) {
        if self.clients().contains_key(&session) {
            self.table().identify(session, change);
        }
    }

    /// The identity of a client.
    pub(crate) fn identity_of(&self, session: u64) -> Arc<ClientIdentity> {
        self.table().identity_of(session)
    }

    /// A MAJ of an owner was sent. `runs`: whether a ticket may still run.
    pub(crate) fn begin(&self, owner: Principal, axis: AxisId, ticket: Ticket, runs: impl Fn(Ticket) -> bool) {
        let Some(session) = owner.session() else { return };
        let now = self.now();
        let jog = Jog {
            owner,
            axis,
            ticket,
            since: now,
            until: is_button(owner).then(|| now + KEEP_WITHIN),
        };
        self.table().begin(session, jog, runs);
        if let Some(client) = self.clients().get(&session)
            && client.watched.is_none()
        {
            client.signs.0.wanted.store(true, Ordering::Release);
        }
        self.0.wake.notify_one();
    }

    /// Watches a client's socket as long as the client jogs, for arriving data and for its close.
    pub(crate) fn watch(&self, session: u64, socket: OwnedFd) {
        let mut clients = self.clients();
        let (Some(runtime), Some(client)) = (self.runtime(), clients.get_mut(&session)) else {
            return;
        };
        let token = CancellationToken::new();
        if let Some(before) = client.watched.replace(token.clone()) {
            before.cancel();
        }
        runtime.spawn(watch::socket(
            self.clone(),
            session,
            socket,
            client.signs.clone(),
            token,
        ));
    }

    /// The viewer has confirmed that the button of a jog is still held. `false`: there is no such jog, or it has ended.
    pub(crate) fn keep(&self, session: u64, axis: AxisId) -> bool {
        let now = self.now();
        self.table().keep(session, axis, now, now + KEEP_WITHIN)
    }

    /// The jogs that are held by a button: session and axis.
    pub(crate) fn held(&self) -> Vec<(u64, AxisId)> {
        self.table().held()
    }

    /// The button of a jog was released: the caller stops it, and the guard does so at full deceleration if it still moves after
    /// `grace`. `false`: there is no such jog.
    pub(crate) fn release(&self, session: u64, axis: AxisId, grace: Duration) -> bool {
        let from = self.now() + grace;
        let is_held = |jog: &Jog| is_of(jog, session) && is_button(jog.owner) && jog.axis == axis;
        let ended = self.table().end(from, JogEnd::Released, is_held);
        if grace.is_zero() {
            self.stop(&ended, JogEnd::Released);
        }
        self.0.wake.notify_one();
        !ended.is_empty()
    }

    /// Ends the jogs of an owner that is lost. Returns their axes.
    pub(crate) fn end(&self, owner: Principal) -> Vec<AxisId> {
        let ended = self.table().end(self.now(), JogEnd::Lost, |jog| jog.owner == owner);
        self.stop(&ended, JogEnd::Lost);
        self.tell(&ended, JogEnd::Lost);
        self.0.wake.notify_one();
        let mut axes: Vec<AxisId> = ended.iter().map(|jog| jog.axis).collect();
        axes.dedup();
        axes
    }

    /// The motion of an owner goes on without it, except for jogs that its silence has ended before.
    pub(crate) fn forget(&self, owner: Principal) {
        if let Some(session) = owner.session() {
            let silent = self.end_silent(session, self.now());
            self.stop(&silent, JogEnd::Silent);
            self.tell(&silent, JogEnd::Silent);
        }
        self.table().forget(owner);
        self.0.wake.notify_one();
    }

    /// The socket of a client has closed without a word.
    pub(crate) fn lose(&self, session: u64) {
        let interface = self
            .clients()
            .get(&session)
            .and_then(|client| client.interface.upgrade());
        let keeps = |owner| interface.as_ref().is_some_and(|interface| interface.keeps_jogs(owner));
        let ended = self
            .table()
            .end(self.now(), JogEnd::Lost, |jog| is_of(jog, session) && !keeps(jog.owner));
        self.stop(&ended, JogEnd::Lost);
        self.tell(&ended, JogEnd::Lost);
        if let Some(interface) = interface {
            interface.lost(session);
        }
        self.0.wake.notify_one();
    }

    /// Checks the jogs until the plant has gone.
    pub(crate) async fn run(&self, plant: &Weak<crate::plant::Shared>) {
        while !self.0.closed.load(Ordering::Acquire) {
            let idle = self.table().is_idle();
            if idle {
                self.0.wake.notified().await;
            } else {
                tokio::time::sleep(LOOK).await;
            }
            let Some(plant) = Plant::upgrade(plant) else { return };
            self.stop_due(&plant);
        }
    }

    /// Stops the jogs that are due, and checks the stopped ones again.
    fn stop_due(&self, plant: &Plant) {
        let now = self.now();
        // Without the lock, which another thread may hold for long, the guard assumes that a jog still runs.
        plant.try_with_executions(|runs| self.table().prune(runs));
        let released = self.table().overdue(now);
        self.stop(&released, JogEnd::Released);
        let silent = self.silent(now);
        self.stop(&silent, JogEnd::Silent);
        let again = plant
            .try_with_executions(|runs| {
                self.table().due_endings(now, |ending| {
                    if runs(ending.axis, ending.ticket) {
                        JogState::Moves
                    } else {
                        JogState::Over
                    }
                })
            })
            .unwrap_or_else(|| self.table().due_endings(now, |_| JogState::Moves));
        for ending in again {
            if is_planted("jog of a lost client") || is_planted("jog of a silent client") {
                continue;
            }
            self.0.stops.end_jog(ending.axis, ending.ticket, ending.why);
        }
        self.tell(&released, JogEnd::Released);
        self.tell(&silent, JogEnd::Silent);
    }

    /// Takes out the jogs of silent clients.
    fn silent(&self, now: Duration) -> Vec<Jog> {
        if self.0.silence.is_none() {
            return Vec::new();
        }
        let jogging: Vec<u64> = self.table().jogging().collect();
        let ended = jogging.into_iter().flat_map(|session| self.end_silent(session, now));
        ended.collect()
    }

    /// Takes out the jogs of a client that it began before its silence.
    fn end_silent(&self, session: u64, now: Duration) -> Vec<Jog> {
        let (at, interface) = match self.clients().get(&session) {
            Some(client) => (client.signs.silent_at(now), client.interface.upgrade()),
            None => return Vec::new(),
        };
        let keeps = |owner| interface.as_ref().is_some_and(|interface| interface.keeps_jogs(owner));
        let ends = |jog: &Jog| is_of(jog, session) && jog.since < at && !keeps(jog.owner);
        self.table().end(now, JogEnd::Silent, ends)
    }

    fn stop(&self, jogs: &[Jog], why: JogEnd) {
        let ignored = match why {
            JogEnd::Lost => "jog of a lost client",
            JogEnd::Silent => "jog of a silent client",
            JogEnd::Released => "jog of a released button",
        };
        if is_planted(ignored) {
            return;
        }
        for jog in jogs {
            self.0.stops.end_jog(jog.axis, jog.ticket, why);
        }
    }

    fn tell(&self, jogs: &[Jog], why: JogEnd) {
        for jog in jogs {
            let axis = self.0.axes.get(usize::from(jog.axis)).map_or("?", String::as_str);
            let client = jog
                .owner
                .session()
                .map(|session| self.identity_of(session))
                .unwrap_or_default();
            warn!(axis, %client, "a jog is stopped: {}", why.reason());
        }
    }

    fn now(&self) -> Duration {
        self.0.epoch.elapsed()
    }

    /// Taken behind the plant's lock, never before it. Of the two locks here only one is held at a time.
    fn table(&self) -> MutexGuard<'_, Table> {
        self.0.table.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn clients(&self) -> MutexGuard<'_, BTreeMap<u64, Client>> {
        self.0.clients.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

fn micros(time: Duration) -> u64 {
    u64::try_from(time.as_micros()).unwrap_or(u64::MAX)
}

fn is_of(jog: &Jog, session: u64) -> bool {
    jog.owner.session() == Some(session)
}

/// Whether a button holds the jogs of an owner.
fn is_button(owner: Principal) -> bool {
    matches!(owner, Principal::Button(_))
}

#[cfg(test)]
mod tests {
    use super::*;

    const CLIENT: Principal = Principal::Client {
        session: 1,
        connection: 0,
    };

    /// A client whose jogs end when it is silent.
    #[derive(Debug)]
    struct Interface;

    impl ClientInterface for Interface {
        fn keeps_jogs(&self, _: Principal) -> bool {
            false
        }

        fn lost(&self, _: u64) {}
    }

    /// The computer stood still while the client was silent, and the client's orderly end is read before the guard looks again.
    #[tokio::test(start_paused = true)]
    async fn a_close_in_order_behind_a_silence_ends_the_jogs_before_it() {
        const SILENCE: u16 = 500;
        let project = arcline_config::load(arcline_config::DEFAULT, "default").expect("the default is valid");
        for (silence, silent, ended) in [
            (500, SILENCE, Vec::new()),
            (501, SILENCE, vec![1]),
            (60_000, SILENCE, vec![1]),
            (60_000, 0, Vec::new()),
        ] {
            let (_rings, link) = arcline_realtime::link(&project.machine);
            let guard = Guard::new(link.stops, &project.machine, silent);
            let interface: Arc<dyn ClientInterface> = Arc::new(Interface);
            let signs = guard.enter(1, ClientIdentity::default(), Arc::downgrade(&interface));
            // A pause before its first jog is no silence of a jogging client.
            tokio::time::advance(Duration::from_secs(9)).await;
            signs.heard();
            guard.begin(CLIENT, AxisId(0), Ticket(1), |_| true);
            tokio::time::advance(Duration::from_millis(silence)).await;
            signs.heard();
            guard.begin(CLIENT, AxisId(1), Ticket(2), |_| true);
            guard.forget(CLIENT);
            let endings = guard.table().due_endings(guard.now(), |_| JogState::Moves);
            let tickets: Vec<u64> = endings.iter().map(|ending| ending.ticket.0).collect();
            assert_eq!(tickets, ended, "{silence} ms, {silent}");
            assert!(endings.iter().all(|ending| ending.why == JogEnd::Silent));
            assert_eq!(guard.table().jogging().count(), 0, "the rest goes on without an owner");
        }
    }
}
