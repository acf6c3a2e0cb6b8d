//! The threads of the retained state: one carries out the decisions of [`Writer`], one waits for the disk.
//!
//! The first thread writes everything that waits in one write, and never waits for the disk itself: synchronisations run on the
//! other. After a failure it answers everything with [`NotPersisted`], and tries to write the whole state to a new file every second.
//!
//! [`WriterWorker`] is one turn of the first thread; a simulation makes the turns itself (`stepped`).

use std::io;
use std::sync::mpsc::{self, RecvTimeoutError};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

pub use arcline_state::NotPersisted;
use arcline_state::{
    Action, Disk, Ended, Failure, LockedFile, Pace, Record, Report, RetainedState, System, Task, Writer,
};
use tokio::sync::oneshot;

/// Carries the answer: the disk has the record, or it does not.
type PersistedSender = oneshot::Sender<Result<(), NotPersisted>>;

/// A message to the thread that writes.
#[derive(Debug)]
pub(crate) enum Job {
    /// Write this record and answer.
    Write(Record, PersistedSender),
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
    pub(super) fn start(locked: LockedFile, state: RetainedState) -> io::Result<Self> {
        // The channel has one task at a time, so a send never waits.
        let (disk, tasks) = mpsc::sync_channel::<Task<System>>(1);
        let (jobs, next) = mpsc::channel();
        let done = jobs.clone();
        thread::Builder::new().name("arcline-sync".to_owned()).spawn(move || {
            for task in tasks {
                if done.send(Job::Ended(task.run())).is_err() {
                    return;
                }
            }
        })?;
        let begun = Instant::now();
        let worker = WriterWorker::start(locked, state, Pace::default(), begun.elapsed(), next);
        let thread = thread::Builder::new()
            .name("arcline-state".to_owned())
            .spawn(move || run(worker, begun, &disk))?;
        Ok(StateWriter { jobs, thread })
    }

    /// The channel for records.
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

fn run(mut worker: WriterWorker<System>, begun: Instant, disk: &mpsc::SyncSender<Task<System>>) -> io::Result<()> {
    loop {
        let first = match worker.due() {
            Some(due) => worker.jobs.recv_timeout(due.saturating_sub(begun.elapsed())),
            None => worker.jobs.recv().map_err(|_| RecvTimeoutError::Disconnected),
        };
        let first = match first {
            Ok(job) => Some(job),
            Err(RecvTimeoutError::Timeout) => None,
            // The state writer was dropped, not closed.
            Err(RecvTimeoutError::Disconnected) => Some(Job::Close),
        };
        match worker.turn(first, begun.elapsed()) {
            Turn::Idle => {}
            // The thread that runs it is idle, so there is room.
            Turn::Synchronise(task) => drop(disk.try_send(task)),
            Turn::Closed(closed) => return closed,
        }
    }
}

/// The writer and the jobs that wait for it.
#[derive(Debug)]
pub(crate) struct WriterWorker<D: Disk> {
    writer: Writer<D, PersistedSender>,
    jobs: mpsc::Receiver<Job>,
}

/// The end of a turn.
#[derive(Debug)]
pub(crate) enum Turn<D: Disk> {
    /// There is nothing to synchronise.
    Idle,
    /// A synchronisation; its end comes back as [`Job::Ended`].
    Synchronise(Task<D>),
    /// The state was written once more, and the writer has ended.
    Closed(io::Result<()>),
}

impl<D: Disk> WriterWorker<D> {
    /// Writes a state to its file.
    pub(crate) fn start(
        locked: LockedFile<D>,
        state: RetainedState,
        pace: Pace,
        now: Duration,
        jobs: mpsc::Receiver<Job>,
    ) -> Self {
        let mut writer = Writer::start(locked, state, pace, now);
        carry_out(&mut writer);
        WriterWorker { writer, jobs }
    }

    /// When the next turn is due without a job.
    pub(crate) fn due(&self) -> Option<Duration> {
        self.writer.due()
    }

    /// Takes `first` and the jobs that wait behind it, writes their records in one piece and answers them.
    pub(crate) fn turn(&mut self, first: Option<Job>, now: Duration) -> Turn<D> {
        let mut next = first;
        let mut close = false;
        while let Some(job) = next {
            match job {
                Job::Write(record, answer) => self.writer.keep(record, answer),
                Job::Ended(ended) => self.writer.ended(ended, now),
                Job::Close => close = true,
            }
            let more = !close && self.writer.waiting() < MAX_BATCH;
            next = more.then(|| self.jobs.try_recv().ok()).flatten();
        }
        if close {
            let closed = self.writer.close(now);
            carry_out(&mut self.writer);
            return Turn::Closed(closed);
        }
        let task = self.writer.turn(now);
        carry_out(&mut self.writer);
        task.map_or(Turn::Idle, Turn::Synchronise)
    }

    /// As [`WriterWorker::turn`] with the first job that waits, if one does.
    pub(crate) fn step(&mut self, now: Duration) -> Turn<D> {
        let first = self.jobs.try_recv().ok();
        self.turn(first, now)
    }
}

fn carry_out<D: Disk>(writer: &mut Writer<D, PersistedSender>) {
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
                    Failure::Rename => "cannot be replaced by a new file",
                };
                tracing::error!(
                    %error,
                    "{file}: {what}; writes of plain tags are refused until it can be written again"
                );
            }
            Action::Report(Report::Recovered) => tracing::warn!("{file}: is written again"),
            Action::Report(Report::Refused(damage)) => tracing::error!(
                "{file}: the tags are more than it can hold: {damage}; writes of plain tags are refused until there are fewer"
            ),
            Action::Report(Report::Grows(error)) => {
                tracing::warn!(%error, "{file}: cannot be written anew, so it goes on growing");
            }
        }
    }
}

/// Records that one write takes.
const MAX_BATCH: usize = 1024;
