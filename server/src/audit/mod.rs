//! The audit: a line for each action of a client on the machine and for each refusal, in files that reveal later changes (spec/security.md §9).
//!
//! No client waits for the audit: its interface puts each event into a bounded queue. A thread of its own merges plain writes of a second, chains the
//! lines by their hashes, and writes them. A full queue or a full disk costs lines; the audit and the log report their number.

mod chain;
mod file;
mod merge;
pub(crate) mod verify;

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, TrySendError, sync_channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, SystemTime};

use serde::Serialize;
use tokio::time::Instant;
use tracing::{error, info, warn};

use self::file::Files;
use self::merge::Merge;

/// Events that may wait for the thread.
const WAITING: usize = 65_536;
/// Plain writes of one client to one tag within this time become one line.
const MERGED: Duration = Duration::from_secs(1);
/// Time between two entries of the log with the hash of the newest line.
const HEAD_EVERY: Duration = Duration::from_secs(60);

/// The kind of an event.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Serialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum EventKind {
    /// The server began; the first line of a file.
    Open,
    /// The server began to serve.
    Start,
    /// The server ended.
    Stop,
    /// A client came.
    Connect,
    /// A client went.
    Disconnect,
    /// A user began a session of the page, or a script showed a token.
    Login,
    /// A session of the page ended.
    Logout,
    /// An administrator ended a session of the page.
    EndSession,
    /// A user or a password was wrong.
    LoginRefused,
    /// A session of the page was locked.
    Locked,
    /// A client was refused for its role.
    Denied,
    /// A tag was written.
    Write,
    /// An instruction, an override, or a fault.
    Motion,
    /// A STOP, or its release.
    Estop,
    /// The table of tags was changed.
    Config,
    /// A viewer took control, or gave it back.
    Take,
    /// A program began, or was continued.
    Program,
    /// The configuration or the certificates were read again.
    Reload,
    /// Lines were lost.
    AuditLost,
}

/// An event, as an interface records it.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct Event {
    /// The time of the event.
    pub(crate) at: SystemTime,
    /// The kind of the event.
    pub(crate) kind: EventKind,
    /// The kind of client.
    pub(crate) door: &'static str,
    /// The client: its address, and its certificate's name.
    pub(crate) from: Arc<str>,
    /// Its role.
    pub(crate) role: &'static str,
    /// The object: a tag, an instruction with its target, a file.
    pub(crate) object: String,
    /// The value before and after, as text; values that are not numbers are hexadecimal.
    pub(crate) values: Option<(String, String)>,
    /// `done`, or the reason for the refusal.
    pub(crate) result: &'static str,
    /// Whether the thread may merge the event with others of the same client and object.
    pub(crate) is_plain_write: bool,
}

/// The sender of events to the thread of the audit; clones share it.
#[derive(Clone, Debug)]
pub(crate) struct Audit(Arc<Shared>);

#[derive(Debug)]
struct Shared {
    /// `None` ends the thread.
    sender: SyncSender<Option<Event>>,
    lost: Arc<Lost>,
    /// The number of the newest line whose hash the log has.
    told: Arc<AtomicU64>,
    thread: Mutex<Option<JoinHandle<()>>>,
}

/// Events that are in no line.
#[derive(Debug, Default)]
struct Lost {
    /// Lost events that no line reports yet.
    untold: AtomicU64,
    /// All lost events since the start.
    total: AtomicU64,
}

impl Lost {
    fn add(&self) {
        self.untold.fetch_add(1, Ordering::Relaxed);
        self.total.fetch_add(1, Ordering::Relaxed);
    }
}

impl Audit {
    /// Opens the files of a folder, repairs a line that a crash cut, and starts the thread.
    ///
    /// # Errors
    /// The folder cannot be written, or the system has no thread left.
    pub(crate) fn open(folder: &Path) -> std::io::Result<Self> {
        let files = Files::open(folder)?;
        let (sender, events) = sync_channel(WAITING);
        let lost = Arc::new(Lost::default());
        let counted = lost.clone();
        let told = Arc::new(AtomicU64::new(0));
        tell_head(&files, &told);
        let newest = told.clone();
        let thread = std::thread::Builder::new()
            .name("arcline-audit".to_owned())
            .spawn(move || drop(write(files, &events, &counted, &newest)))?;
        Ok(Self(Arc::new(Shared {
            sender,
            lost,
            told,
            thread: Mutex::new(Some(thread)),
        })))
    }

    /// Makes an audit without files and thread: the events come out of the receiver.
    pub(crate) fn stepped() -> (Self, Receiver<Option<Event>>) {
        let (sender, events) = sync_channel(WAITING);
        let audit = Self(Arc::new(Shared {
            sender,
            lost: Arc::default(),
            told: Arc::default(),
            thread: Mutex::default(),
        }));
        (audit, events)
    }

    /// Records an event, if there is room for it.
    pub(crate) fn record(&self, event: Event) {
        if let Err(TrySendError::Full(_)) = self.0.sender.try_send(Some(event)) {
            self.0.lost.add();
        }
    }

    /// Events since the start that are in no line, since there was no room for them or the disk failed.
    pub(crate) fn lost(&self) -> u64 {
        self.0.lost.total.load(Ordering::Relaxed)
    }

    /// The number of the newest line whose hash the log has: that of the last minute, before that of the first line of this run.
    pub(crate) fn told_line(&self) -> u64 {
        self.0.told.load(Ordering::Relaxed)
    }

    /// Writes the waiting events, and ends.
    pub(crate) fn close(&self) {
        // The thread may have failed already.
        let _ = self.0.sender.send(None);
        let thread = self.0.thread.lock().unwrap_or_else(PoisonError::into_inner).take();
        if thread.is_some_and(|thread| thread.join().is_err()) {
            error!("the thread of the audit failed");
        }
    }
}

/// SHA-256 of a text, hexadecimal: of a program, whose text may be long.
pub(crate) fn sha256(text: &str) -> String {
    chain::hash(text.as_bytes())
}

/// The folder of the audit: that of the state's file, with `.audit` behind its name.
pub(crate) fn folder_of(state: &Path) -> PathBuf {
    let mut name = state.as_os_str().to_owned();
    name.push(".audit");
    PathBuf::from(name)
}

/// The time that the thread may wait for an event: until it merges writes, synchronises lines, or logs the hash.
fn wait(merge: &Merge, files: &Files, head_told: Instant) -> Duration {
    let merged = merge.due(MERGED).min(files.due());
    merged.min(HEAD_EVERY.saturating_sub(head_told.elapsed()))
}

/// Runs on the thread: writes until the last sender has gone.
fn write(mut files: Files, events: &Receiver<Option<Event>>, lost: &Lost, told: &AtomicU64) -> Files {
    let mut merge = Merge::default();
    let mut head_told = Instant::now();
    let mut is_failing = false;
    loop {
        let next = events.recv_timeout(wait(&merge, &files, head_told));
        let mut lines = match &next {
            Ok(Some(event)) => merge.take(event.clone()),
            Ok(None) | Err(_) => Vec::new(),
        };
        let is_over = matches!(next, Ok(None) | Err(RecvTimeoutError::Disconnected));
        lines.extend(merge.ready(if is_over { Duration::ZERO } else { MERGED }));
        let missed = lost.untold.swap(0, Ordering::Relaxed);
        if missed > 0 {
            if !is_failing {
                warn!(missed, "the audit has lost events");
            }
            lines.push((lost_event(missed), 1));
        }
        for (event, count) in &lines {
            if let Err(error) = files.append(event, *count) {
                match event.kind {
                    // A later line reports that its events were lost.
                    EventKind::AuditLost => {
                        lost.untold.fetch_add(missed, Ordering::Relaxed);
                    }
                    _ => lost.add(),
                }
                if !std::mem::replace(&mut is_failing, true) {
                    error!(%error, "the audit cannot be written; the machine goes on");
                }
            } else if std::mem::replace(&mut is_failing, false) {
                warn!("the audit is written again");
            }
        }
        if is_over {
            files.sync();
        } else {
            files.sync_at(Instant::now());
        }
        if head_told.elapsed() >= HEAD_EVERY || is_over {
            tell_head(&files, told);
            head_told = Instant::now();
        }
        if is_over {
            return files;
        }
    }
}

/// Logs the hash of the newest line.
fn tell_head(files: &Files, told: &AtomicU64) {
    let line = files.newest();
    info!(line, head = files.head(), "the newest line of the audit");
    told.store(line, Ordering::Relaxed);
}

fn lost_event(missed: u64) -> Event {
    Event {
        at: SystemTime::now(),
        kind: EventKind::AuditLost,
        door: "server",
        from: "".into(),
        role: "",
        object: format!("{missed} events"),
        values: None,
        result: "lost",
        is_plain_write: false,
    }
}

#[cfg(test)]
mod tests;
