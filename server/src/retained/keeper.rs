//! The threads that write: one appends what comes and answers when the system has it, one waits for the disk.
//!
//! Everything that waits when the first gets to it is one write. It never waits for the disk itself: once a second
//! the other synchronises what was written, and when the file has grown it is written anew beside and synchronised
//! there while changes go on. After a failure everything is answered with [`NotKept`], and every second the whole
//! file is tried anew.

use std::fs::File;
use std::io;
use std::sync::mpsc::{self, RecvTimeoutError};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use arcline_state::{Change, State, Store};
use tokio::sync::oneshot;

/// What was changed is not in the file, at least not yet.
#[derive(Clone, Copy, PartialEq, Eq, Debug, thiserror::Error)]
#[error("it could not be written to the file of the retained state")]
pub struct NotKept;

/// Is told that changes are kept, or that they are not.
type WhenKept = oneshot::Sender<Result<(), NotKept>>;

/// What the writing thread is told.
#[derive(Debug)]
pub(super) enum Job {
    /// Keep these changes, all or none, and say so.
    Keep(Vec<Change>, WhenKept),
    /// Keep this state in place of the one there was, and say so.
    Replace(State, WhenKept),
    /// The disk has what it was to synchronise.
    Synchronised(What, io::Result<()>),
    /// Write everything once more and end.
    Close,
}

/// What is synchronised.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum What {
    /// What was appended.
    Appended,
    /// A file that was written anew, before it takes its place.
    Anew,
    /// The folder, after that.
    Folder,
}

/// The thread that writes.
#[derive(Debug)]
pub(crate) struct Keeper {
    jobs: mpsc::Sender<Job>,
    thread: JoinHandle<io::Result<()>>,
}

impl Keeper {
    /// Starts to keep a state.
    ///
    /// # Errors
    /// When the system has no thread left.
    pub(super) fn start(store: Store) -> io::Result<Self> {
        let (jobs, next) = mpsc::channel();
        // One file at a time, so nothing ever waits in there.
        let (disk, files) = mpsc::sync_channel::<(What, File)>(1);
        let done = jobs.clone();
        thread::Builder::new().name("arcline-sync".to_owned()).spawn(move || {
            for (what, file) in files {
                let result = match what {
                    What::Appended => file.sync_data(),
                    What::Anew | What::Folder => file.sync_all(),
                };
                if done.send(Job::Synchronised(what, result)).is_err() {
                    return;
                }
            }
        })?;
        let writer = Writer {
            store,
            disk,
            busy: false,
            outdated: false,
            unsynchronised: false,
            failed: false,
            due: Instant::now(),
        };
        let thread = thread::Builder::new()
            .name("arcline-state".to_owned())
            .spawn(move || writer.run(&next))?;
        Ok(Keeper { jobs, thread })
    }

    /// Where changes are sent.
    pub(super) fn jobs(&self) -> mpsc::Sender<Job> {
        self.jobs.clone()
    }

    /// Writes everything that was sent, synchronises it, and ends.
    ///
    /// # Errors
    /// When the file could not be written.
    pub(crate) fn close(self) -> io::Result<()> {
        // A thread that is gone has said why.
        let _ = self.jobs.send(Job::Close);
        self.thread
            .join()
            .unwrap_or_else(|_| Err(io::Error::other("the thread that writes it has failed")))
    }
}

struct Writer {
    store: Store,
    disk: mpsc::SyncSender<(What, File)>,
    /// Whether something is being synchronised.
    busy: bool,
    /// Whether what is being synchronised has been replaced meanwhile.
    outdated: bool,
    /// Whether something was appended since.
    unsynchronised: bool,
    /// Whether the last attempt to write has failed.
    failed: bool,
    /// When to synchronise, or to try again.
    due: Instant,
}

impl Writer {
    fn run(mut self, jobs: &mpsc::Receiver<Job>) -> io::Result<()> {
        let mut batch = Vec::new();
        loop {
            let first = if self.unsynchronised || self.failed {
                jobs.recv_timeout(self.due.saturating_duration_since(Instant::now()))
            } else {
                jobs.recv().map_err(|_| RecvTimeoutError::Disconnected)
            };
            let mut next = match first {
                Ok(job) => Some(job),
                Err(RecvTimeoutError::Timeout) => None,
                // Dropped, not closed: nobody would hear of it.
                Err(RecvTimeoutError::Disconnected) => return self.store.rewrite(),
            };
            let mut close = false;
            while let Some(job) = next {
                match job {
                    Job::Keep(changes, kept) => batch.push((changes, kept)),
                    Job::Replace(state, kept) => {
                        // In the order in which it came.
                        if !batch.is_empty() {
                            self.append(&mut batch);
                        }
                        self.replace(state, kept);
                    }
                    Job::Synchronised(what, result) => self.synchronised(what, result),
                    Job::Close => close = true,
                }
                next = (!close && batch.len() < MAX_BATCH)
                    .then(|| jobs.try_recv().ok())
                    .flatten();
            }
            if !batch.is_empty() {
                self.append(&mut batch);
            }
            if close {
                return self.store.rewrite();
            }
            self.look_after_the_disk();
        }
    }

    fn append(&mut self, batch: &mut Vec<(Vec<Change>, WhenKept)>) {
        let written = self.store.append(batch.iter().map(|(changes, _)| changes.as_slice()));
        if let Err(error) = &written
            && !self.failed
        {
            self.fail("cannot be written", error);
        }
        if written.is_ok() && !self.unsynchronised {
            self.unsynchronised = true;
            self.due = Instant::now() + PAUSE;
        }
        for (_, kept) in batch.drain(..) {
            // Whoever waited may have given up.
            let _ = kept.send(written.as_ref().map_err(|_| NotKept).copied());
        }
    }

    fn replace(&mut self, state: State, kept: WhenKept) {
        self.outdated = self.busy;
        let written = self.store.replace(state);
        match &written {
            Ok(()) => {
                self.failed = false;
                self.unsynchronised = false;
            }
            Err(error) if !self.failed => self.fail("cannot be written", error),
            Err(_) => {}
        }
        // Whoever waited may have given up.
        let _ = kept.send(written.map_err(|_| NotKept));
    }

    fn look_after_the_disk(&mut self) {
        let due = Instant::now() >= self.due;
        if self.failed {
            if due {
                self.try_again();
            }
        } else if self.busy {
            // One after the other.
            if due {
                self.due = Instant::now() + PAUSE;
            }
        } else if self.store.wants_rewrite() {
            match self.store.begin_rewrite() {
                Ok(file) => self.synchronise(What::Anew, file),
                Err(error) => self.warn("cannot be written anew", &error),
            }
        } else if self.unsynchronised && due {
            self.unsynchronised = false;
            match self.store.file() {
                Ok(Some(file)) => self.synchronise(What::Appended, file),
                Ok(None) => {}
                Err(error) => self.warn("cannot be synchronised", &error),
            }
        }
    }

    fn synchronise(&mut self, what: What, file: File) {
        self.busy = self.disk.try_send((what, file)).is_ok();
    }

    fn synchronised(&mut self, what: What, result: io::Result<()>) {
        self.busy = false;
        if std::mem::take(&mut self.outdated) {
            return;
        }
        let result = match (what, result) {
            (What::Anew, Ok(())) => self
                .store
                .finish_rewrite()
                .map(|folder| self.synchronise(What::Folder, folder)),
            (_, result) => result,
        };
        if let Err(error) = result {
            self.warn("was not synchronised", &error);
        }
    }

    fn try_again(&mut self) {
        match self.store.rewrite() {
            Ok(()) => {
                self.failed = false;
                self.unsynchronised = false;
                tracing::warn!("{}: is written again", self.store.path().display());
            }
            Err(_) => self.due = Instant::now() + PAUSE,
        }
    }

    fn fail(&mut self, what: &str, error: &io::Error) {
        self.failed = true;
        self.due = Instant::now() + PAUSE;
        tracing::error!(
            %error,
            "{}: {what}; writes of plain tags are refused until it can be written again",
            self.store.path().display()
        );
    }

    fn warn(&self, what: &str, error: &io::Error) {
        tracing::warn!(%error, "{}: {what}", self.store.path().display());
    }
}

/// Between two synchronisations, and two attempts after a failure.
const PAUSE: Duration = Duration::from_secs(1);
/// Messages that one write takes.
const MAX_BATCH: usize = 1024;
