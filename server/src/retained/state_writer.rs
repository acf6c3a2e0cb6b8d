//! The threads of the retained state: one carries out the decisions of [`Writer`], one waits for the disk.
//!
//! The first thread writes everything that waits in one write, and never waits for the disk itself: synchronisations run on the
//! other. After a failure it answers everything with [`NotPersisted`], and tries to write the whole state to a new file every second.
//!
//! [`WriterWorker`] is one turn of the first thread; a simulation makes the turns itself (`stepped`).

use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

pub use arcline_state::NotPersisted;
use arcline_state::{
    Action, Disk, Ended, Failure, LockedFile, MAX_TOTAL, Pace, Record, Report, RetainedState, System, Task, Writer,
};
use tokio::sync::oneshot;

/// Carries the answer: the disk has the record, or it does not.
type PersistedSender = oneshot::Sender<Result<(), NotPersisted>>;

/// The channel of records to the thread that writes. A disk that hangs must not fill the memory with what waits for it.
#[derive(Clone, Debug)]
pub(crate) struct RecordSender {
    jobs: mpsc::Sender<Job>,
    /// Bytes of tags in the records that wait.
    waiting: Arc<AtomicUsize>,
}

impl RecordSender {
    /// The channel: its records, and the queue of the thread.
    pub(super) fn channel() -> (RecordSender, JobQueue) {
        let (jobs, next) = mpsc::channel();
        let waiting = Arc::<AtomicUsize>::default();
        let queue = JobQueue {
            jobs: next,
            waiting: waiting.clone(),
        };
        (RecordSender { jobs, waiting }, queue)
    }

    /// Sends a record; `None`: as much waits as may wait, and the record is lost.
    pub(super) fn send(&self, record: Record) -> Option<PersistedReceiver> {
        let bytes = record.tag_bytes();
        let before = self.waiting.fetch_add(bytes, Ordering::AcqRel);
        if before + bytes > MOST_WAITING {
            self.waiting.fetch_sub(bytes, Ordering::AcqRel);
            return None;
        }
        let (sender, receiver) = oneshot::channel();
        // A thread that has ended drops the sender, and so answers.
        let _ = self.jobs.send(Job::Write(record, sender));
        Some(receiver)
    }
}

/// The queue of the thread that writes.
#[derive(Debug)]
pub(crate) struct JobQueue {
    jobs: mpsc::Receiver<Job>,
    waiting: Arc<AtomicUsize>,
}

impl JobQueue {
    /// The next job, if one waits.
    pub(super) fn try_next(&self) -> Option<Job> {
        self.jobs.try_recv().ok().map(|job| self.taken(job))
    }

    /// Waits for the next job, at most this long.
    fn next(&self, within: Option<Duration>) -> Result<Job, RecvTimeoutError> {
        let job = match within {
            Some(within) => self.jobs.recv_timeout(within)?,
            None => self.jobs.recv().map_err(|_| RecvTimeoutError::Disconnected)?,
        };
        Ok(self.taken(job))
    }

    fn taken(&self, job: Job) -> Job {
        if let Job::Write(record, _) = &job {
            self.waiting.fetch_sub(record.tag_bytes(), Ordering::AcqRel);
        }
        job
    }
}

/// Reports that the disk has a change, or that it does not.
pub(crate) type PersistedReceiver = oneshot::Receiver<Result<(), NotPersisted>>;

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
    records: RecordSender,
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
        let (records, next) = RecordSender::channel();
        let done = records.jobs.clone();
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
        Ok(StateWriter { records, thread })
    }

    /// The channel of records.
    pub(super) fn records(&self) -> RecordSender {
        self.records.clone()
    }

    /// Writes everything that was sent, synchronises it, and ends.
    ///
    /// # Errors
    /// When the file could not be written.
    pub(crate) fn close(self) -> io::Result<()> {
        // A thread that is gone has said why.
        let _ = self.records.jobs.send(Job::Close);
        self.thread
            .join()
            .unwrap_or_else(|_| Err(io::Error::other("the thread that writes it has failed")))
    }
}

fn run(mut worker: WriterWorker<System>, begun: Instant, disk: &mpsc::SyncSender<Task<System>>) -> io::Result<()> {
    loop {
        let within = worker.due().map(|due| due.saturating_sub(begun.elapsed()));
        let first = match worker.queue.next(within) {
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
    queue: JobQueue,
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
        queue: JobQueue,
    ) -> Self {
        let mut writer = Writer::start(locked, state, pace, now);
        carry_out(&mut writer);
        WriterWorker { writer, queue }
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
            next = more.then(|| self.queue.try_next()).flatten();
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
        let first = self.queue.try_next();
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
/// Bytes of tags that wait for the thread at most: a whole state, and changes of another one.
const MOST_WAITING: usize = 2 * MAX_TOTAL;
