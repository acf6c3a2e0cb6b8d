//! Sessions of the page: a user who has logged in, or a script that shows a token (spec/security.md §7).
//!
//! A session raises the role of its viewers above that of their address. Without input from a person it is locked: then its viewers look
//! and stop, and a program that runs goes on. The server keeps the hash of a session's secret only, and no session over a restart.

mod session;

use std::collections::BTreeMap;
use std::fs;
use std::net::IpAddr;
use std::os::unix::fs::MetadataExt as _;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use arc_swap::ArcSwap;
use arcline_config::{Role, Security};
use tokio::sync::Semaphore;
use tokio::time::Instant;
use tracing::{error, warn};

pub(super) use self::session::{End, State};
use self::session::{PageSession, Subject};
use super::protocol::SessionRow;
use crate::audit::{EventKind, sha256};
use crate::limits::Lockouts;
use crate::plant::control::ViewerId;
use crate::plant::{Plant, Principal};
use crate::users::command::random_text;
use crate::users::{Users, UsersError, password};
use crate::watch;

/// Sessions of one user, and of all users.
const MOST_OF_ONE: usize = 8;
const MOST: usize = 64;
/// Log-ins that may wait until those before them are checked.
const WAITING: usize = 16;
/// Time between two checks of the sessions and of the file of users.
const LOOK: Duration = Duration::from_secs(1);

/// The sessions, and the users who may begin one.
#[derive(Debug)]
pub(crate) struct Sessions {
    file: Option<PathBuf>,
    users: ArcSwap<Users>,
    idle: Duration,
    longest: Duration,
    lockouts: Lockouts,
    /// One password is checked at a time: a check takes 19 MiB.
    turn: Semaphore,
    waiting: AtomicUsize,
    known: Mutex<BTreeMap<Key, PageSession>>,
    /// Sessions that began since the start.
    begun: AtomicU64,
}

/// SHA-256 of the secret of a session, hexadecimal.
pub(super) type Key = String;

/// The session of a viewer.
#[derive(Clone, Debug)]
pub(super) struct Joined {
    pub(super) key: Key,
    /// As logs and the audit name its user.
    pub(super) subject: String,
    /// The user, as the page shows it.
    pub(super) user: String,
    pub(super) state: watch::Receiver<State>,
}

/// The reason for the refusal of a log-in.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum LoginRefused {
    /// The user or the password is wrong.
    Wrong,
    /// Too many failures, or too many at a time; again after this time.
    Later(Duration),
    /// The system has no random numbers left.
    NoRandom,
}

impl Default for Sessions {
    /// Makes the sessions of a page without users.
    fn default() -> Self {
        Self::of(None, Users::default(), &Security::default())
    }
}

impl Sessions {
    /// Reads the file of users, if there is to be one; a relative name is of the folder `base`.
    ///
    /// # Errors
    /// See [`UsersError`].
    pub(crate) fn open(security: &Security, base: &Path) -> Result<Self, UsersError> {
        let file = security.users.as_deref().map(|file| base.join(file));
        let users = file.as_deref().map_or_else(|| Ok(Users::default()), Users::read)?;
        if !users.users.is_empty() {
            password::prepare();
        }
        Ok(Self::of(file, users, security))
    }

    fn of(file: Option<PathBuf>, users: Users, security: &Security) -> Self {
        Self {
            file,
            users: ArcSwap::from_pointee(users),
            idle: Duration::from_secs(security.idle.into()),
            longest: Duration::from_secs(security.session.into()),
            lockouts: Lockouts::default(),
            turn: Semaphore::new(1),
            waiting: AtomicUsize::new(0),
            known: Mutex::default(),
            begun: AtomicU64::new(0),
        }
    }

    /// Whether a user exists who could log in.
    pub(super) fn has_users(&self) -> bool {
        self.users.load().users.iter().any(|user| !user.is_disabled)
    }

    /// Begins a session of a user in place of the one before; its secret. A user who does not exist takes the same time.
    ///
    /// # Errors
    /// See [`LoginRefused`].
    pub(super) async fn log_in(
        &self,
        plant: &Plant,
        peer: IpAddr,
        name: &str,
        password: &str,
        before: Option<&Key>,
    ) -> Result<String, LoginRefused> {
        let locked = || match self.lockouts.locked(peer, Some(name), tokio::time::Instant::now()) {
            Some(left) => Err(LoginRefused::Later(left)),
            None => Ok(()),
        };
        locked()?;
        let _waiting = Waiting::enter(&self.waiting)?;
        let turn = self.turn.acquire().await;
        // Many at once are not more guesses than one after the other.
        locked()?;
        let users = self.users.load_full();
        let user = users.user(name);
        let enabled = user.filter(|user| !user.is_disabled).cloned();
        let (stored, given) = (enabled.as_ref().map(|user| user.password.clone()), password.to_owned());
        let checked = tokio::task::spawn_blocking(move || match stored {
            Some(stored) => stored.is_of(&given),
            None => {
                password::check_unknown_user(&given);
                false
            }
        });
        let is_right = checked.await.unwrap_or(false);
        drop(turn);
        match enabled.filter(|_| is_right) {
            Some(user) => {
                let secret = random_text().ok_or(LoginRefused::NoRandom)?;
                if let Some(before) = before {
                    self.end(plant, before, End::Replaced);
                }
                let credential = user.credential();
                self.begin(
                    plant,
                    peer,
                    sha256(&secret),
                    Subject::User(user.name),
                    user.role,
                    credential,
                );
                Ok(secret)
            }
            None => {
                let locks = self.lockouts.failed(peer, Some(name), tokio::time::Instant::now());
                // People type passwords where names belong: only names of users are written down.
                let known = user.map_or("a user who does not exist", |user| user.name.as_str());
                let text = || {
                    format!(
                        "a log-in of {known} was refused{}",
                        if locks { "; locked for a while" } else { "" }
                    )
                };
                plant.log_limit().warn("login", Some(peer), text);
                plant.record_session(
                    peer.to_string(),
                    Role::Viewer,
                    EventKind::LoginRefused,
                    known.to_owned(),
                    "refused",
                );
                Err(LoginRefused::Wrong)
            }
        }
    }

    /// The session of a script that shows a token; `None`: the token does not hold.
    pub(super) fn of_token(&self, plant: &Plant, peer: IpAddr, token: &str) -> Option<Key> {
        let key = sha256(token);
        let users = self.users.load();
        let token = users.token(&key)?;
        if !self.known().contains_key(&key) {
            let subject = Subject::Token(token.name.clone());
            self.begin(plant, peer, key.clone(), subject, token.role, token.sha256.clone());
        }
        Some(key)
    }

    /// The session of a secret.
    pub(super) fn of_secret(&self, secret: &str) -> Option<Key> {
        let key = sha256(secret);
        let is_users = |session: &PageSession| matches!(session.subject, Subject::User(_));
        self.known().get(&key).is_some_and(is_users).then_some(key)
    }

    fn begin(&self, plant: &Plant, peer: IpAddr, key: Key, subject: Subject, role: Role, credential: String) {
        let mut known = self.known();
        let is_own = |session: &PageSession| session.subject == subject;
        while known.values().filter(|session| is_own(session)).count() >= MOST_OF_ONE {
            end_oldest(plant, &mut known, is_own);
        }
        while known.len() >= MOST {
            end_oldest(plant, &mut known, |_| true);
        }
        let now = Instant::now();
        let from = format!("{peer} {}", subject.name());
        plant.record_session(from.clone(), role, EventKind::Login, String::new(), "done");
        let session = PageSession {
            number: self.begun.fetch_add(1, Ordering::Relaxed) + 1,
            subject,
            role,
            credential,
            peer,
            from,
            began: now,
            active: now,
            state: watch::Sender::new(State::Open(role)),
            viewers: BTreeMap::new(),
        };
        known.insert(key, session);
    }

    /// A viewer came with a session; `None`: the session has ended meanwhile. The viewer has its role from now on.
    pub(super) fn join(&self, plant: &Plant, key: &Key, viewer: ViewerId, address: Role) -> Option<()> {
        let mut known = self.known();
        let session = known.get_mut(key)?;
        session.viewers.insert(viewer, address);
        session.apply(plant);
        Some(())
    }

    /// The session of a key, as its viewer sees it.
    pub(super) fn find(&self, key: Key) -> Option<Joined> {
        let known = self.known();
        let session = known.get(&key)?;
        let (Subject::User(user) | Subject::Token(user)) = &session.subject;
        Some(Joined {
            key,
            subject: session.subject.name(),
            user: user.clone(),
            state: session.state.subscribe(),
        })
    }

    /// A viewer has gone.
    pub(super) fn leave(&self, key: &Key, viewer: ViewerId) {
        let mut known = self.known();
        if let Some(session) = known.get_mut(key) {
            session.viewers.remove(&viewer);
            // A script begins it again when it comes again.
            if session.viewers.is_empty() && matches!(session.subject, Subject::Token(_)) {
                known.remove(key);
            }
        }
    }

    /// A person is at the page.
    pub(super) fn active(&self, key: &Key) {
        if let Some(session) = self.known().get_mut(key) {
            session.active = Instant::now();
        }
    }

    /// Locks a session, for a person.
    pub(super) fn lock(&self, plant: &Plant, key: &Key) {
        if let Some(session) = self.known().get_mut(key) {
            session.lock(plant);
        }
    }

    /// Ends a session, for a person.
    pub(super) fn log_out(&self, plant: &Plant, key: &Key) {
        self.end(plant, key, End::LoggedOut);
    }

    fn end(&self, plant: &Plant, key: &Key, why: End) {
        let session = self.known().remove(key);
        if let Some(session) = session {
            session.end(plant, why);
        }
    }

    /// The sessions in the order in which they began; `own` is that of the viewer who asks.
    pub(super) fn list(&self, own: Option<&Key>, now: Instant) -> Vec<SessionRow> {
        let known = self.known();
        let mut rows: Vec<SessionRow> = known
            .iter()
            .map(|(key, session)| {
                let (Subject::User(user) | Subject::Token(user)) = &session.subject;
                SessionRow {
                    session: session.number,
                    user: user.clone(),
                    script: matches!(session.subject, Subject::Token(_)),
                    role: session.role.word(),
                    locked: session.is_locked(),
                    address: session.peer.to_string(),
                    pages: session.viewers.len(),
                    age_s: now.duration_since(session.began).as_secs(),
                    idle_s: now.duration_since(session.active).as_secs(),
                    own: own == Some(key),
                }
            })
            .collect();
        rows.sort_by_key(|row| row.session);
        rows
    }

    /// Ends a session by its number, for an administrator: its address and its user; `None`: no session has the number.
    pub(super) fn end_numbered(&self, plant: &Plant, number: u64) -> Option<String> {
        let mut known = self.known();
        let key = known.iter().find(|(_, session)| session.number == number)?.0.clone();
        let session = known.remove(&key)?;
        drop(known);
        let from = session.from.clone();
        session.end(plant, End::ByAdministrator);
        Some(from)
    }

    /// Looks after sessions and the file of users, for ever.
    pub(super) async fn watch(&self, plant: &Plant) {
        let mut changed = self.changed();
        loop {
            tokio::time::sleep(LOOK).await;
            let now = self.changed();
            if std::mem::replace(&mut changed, now) != now {
                self.reload(plant);
            }
            self.judge(plant, Instant::now());
        }
    }

    /// When the file was changed.
    fn changed(&self) -> Option<(u64, i64, i64, u64)> {
        let metadata = fs::metadata(self.file.as_deref()?).ok()?;
        Some((metadata.ino(), metadata.mtime(), metadata.mtime_nsec(), metadata.size()))
    }

    fn reload(&self, plant: &Plant) {
        let Some(file) = &self.file else { return };
        let read = Users::read(file);
        let result = if read.is_ok() { "done" } else { "refused" };
        let what = "the users of the page".to_owned();
        plant.record(Principal::Server, EventKind::Reload, what, result);
        match read {
            Ok(users) => {
                warn!("the users of the page were read again");
                self.users.store(Arc::new(users));
            }
            Err(error) => error!(%error, "the users of the page stay as they were"),
        }
    }

    /// Ends the sessions that are no longer valid, and locks those without input of a person.
    pub(super) fn judge(&self, plant: &Plant, now: Instant) {
        let users = self.users.load_full();
        let mut ended = Vec::new();
        let mut known = self.known();
        for (key, session) in known.iter_mut() {
            let holds = match &session.subject {
                Subject::User(name) => users
                    .user(name)
                    .filter(|user| !user.is_disabled && user.credential() == session.credential)
                    .map(|user| user.role),
                Subject::Token(_) => users.token(&session.credential).map(|token| token.role),
            };
            let is_user = matches!(session.subject, Subject::User(_));
            match holds {
                None => ended.push((key.clone(), End::Revoked)),
                Some(_) if is_user && now.duration_since(session.began) >= self.longest => {
                    ended.push((key.clone(), End::Expired));
                }
                Some(role) => {
                    if role != session.role {
                        session.role = role;
                        session.apply(plant);
                    }
                    if is_user && now.duration_since(session.active) >= self.idle {
                        session.lock(plant);
                    }
                }
            }
        }
        for (key, why) in ended {
            if let Some(session) = known.remove(&key) {
                session.end(plant, why);
            }
        }
    }

    fn known(&self) -> MutexGuard<'_, BTreeMap<Key, PageSession>> {
        self.known.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Ends the session with the longest idle time among those that meet a condition.
fn end_oldest(plant: &Plant, known: &mut BTreeMap<Key, PageSession>, is_one: impl Fn(&PageSession) -> bool) {
    let sessions = known.iter().filter(|(_, session)| is_one(session));
    let oldest = sessions
        .min_by_key(|(_, session)| session.active)
        .map(|(key, _)| key.clone());
    if let Some(session) = oldest.and_then(|key| known.remove(&key)) {
        session.end(plant, End::TooMany);
    }
}

/// A log-in that waits.
struct Waiting<'s>(&'s AtomicUsize);

impl<'s> Waiting<'s> {
    fn enter(waiting: &'s AtomicUsize) -> Result<Self, LoginRefused> {
        let before = waiting.fetch_add(1, Ordering::AcqRel);
        let this = Self(waiting);
        // The one that is checked does not wait.
        match before > WAITING {
            true => Err(LoginRefused::Later(LOOK)),
            false => Ok(this),
        }
    }
}

impl Drop for Waiting<'_> {
    fn drop(&mut self) {
        self.0.fetch_sub(1, Ordering::AcqRel);
    }
}
