//! The threads of the retained state: one carries out what [`Writer`] decides, one waits for the disk.
//!
//! Everything that waits when the first gets to it is one write, and it never waits for the disk itself: synchronisations run on the
//! other. After a failure everything is answered with [`NotPersisted`], and every second the whole state is tried in a new file.

use std::io;
use std::sync::mpsc::{self, RecvTimeoutError};
use std::thread::{self, JoinHandle};
use std::time::Instant;

pub use arcline_state::NotPersisted;
use arcline_state::{Action, Ended, Failure, Pace, Place, Record, Report, State, System, Task, Writer};
use tokio::sync::oneshot;

/// Carries the answer: the record is kept, or it is not.
type WhenPersisted = oneshot::Sender<Result<(), NotPersisted>>;

/// A message to the thread that writes.
#[derive(Debug)]
pub(super) enum Job {
    /// Keep this record and answer.
    Keep(Record, WhenPersisted),
    /// A synchronisation has ended.
    Ended(Ended),
    /// Write everything once more and end.
    Close,
}

/// The thread that writes.
#[derive(Debug)]
pub(crate) struct StateWriter {
    jobs: mpsc::Sender<Job>,
    thread: JoinHandle<io::Result<()>>,
}

impl StateWriter {
    /// Writes a state to its file, and starts to keep it. When the file cannot be written the log says so, and every write of a plain tag is
    /// refused until it can.
    ///
    /// # Errors
    /// When the system has no thread left.
    pub(super) fn start(place: Place, state: State) -> io::Result<Self> {
        let (jobs, next) = mpsc::channel();
        // One task at a time, so none ever waits in there.
        let (disk, tasks) = mpsc::sync_channel::<Task<System>>(1);
        let done = jobs.clone();
        thread::Builder::new().name("arcline-sync".to_owned()).spawn(move || {
            for task in tasks {
                if done.send(Job::Ended(task.run())).is_err() {
                    return;
                }
            }
        })?;
        let begun = Instant::now();
        let mut writer = Writer::start(place, state, Pace::default(), begun.elapsed());
        carry_out(&mut writer);
        let thread = thread::Builder::new()
            .name("arcline-state".to_owned())
            .spawn(move || run(writer, begun, &next, &disk))?;
        Ok(StateWriter { jobs, thread })
    }

    /// Where records are sent.
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

fn run(
    mut writer: Writer<System, WhenPersisted>,
    begun: Instant,
    jobs: &mpsc::Receiver<Job>,
    disk: &mpsc::SyncSender<Task<System>>,
) -> io::Result<()> {
    loop {
        let first = match writer.due() {
            Some(due) => jobs.recv_timeout(due.saturating_sub(begun.elapsed())),
            None => jobs.recv().map_err(|_| RecvTimeoutError::Disconnected),
        };
        let mut next = match first {
            Ok(job) => Some(job),
            Err(RecvTimeoutError::Timeout) => None,
            // The state writer was dropped, not closed.
            Err(RecvTimeoutError::Disconnected) => Some(Job::Close),
        };
        let mut close = false;
        while let Some(job) = next {
            match job {
                Job::Keep(record, kept) => writer.keep(record, kept),
                Job::Ended(ended) => writer.ended(ended, begun.elapsed()),
                Job::Close => close = true,
            }
            let more = !close && writer.waiting() < MAX_BATCH;
            next = more.then(|| jobs.try_recv().ok()).flatten();
        }
        if close {
            let closed = writer.close(begun.elapsed());
            carry_out(&mut writer);
            return closed;
        }
        if let Some(task) = writer.turn(begun.elapsed()) {
            // The thread that runs it is idle, so there is room.
            let _ = disk.try_send(task);
        }
        carry_out(&mut writer);
    }
}

fn carry_out(writer: &mut Writer<System, WhenPersisted>) {
    let file = writer.path().to_owned();
    let file = file.display();
    for action in writer.actions() {
        match action {
            // The client that waited may have gone.
            Action::Answer(kept, answer) => drop(kept.send(answer)),
            Action::Report(Report::Failed(failure, error)) => {
                let what = match failure {
                    Failure::Write => "cannot be written",
                    Failure::Synchronisation => "cannot be synchronised with the disk",
                };
                tracing::error!(
                    %error,
                    "{file}: {what}; writes of plain tags are refused until it can be written again"
                );
            }
            Action::Report(Report::Recovered) => tracing::warn!("{file}: is written again"),
            Action::Report(Report::Grows(error)) => {
                tracing::warn!(%error, "{file}: cannot be written anew, so it goes on growing");
            }
        }
    }
}

/// Records that one write takes.
const MAX_BATCH: usize = 1024;
