//! The order and the times of writes: a state machine without threads or clocks, which a thread carries out.
//!
//! Each [`Writer::turn`] writes all waiting records in one write. The writer never waits for the disk: at most once in a
//! [`Pace::pause`] it hands out a [`Task`], a synchronisation that another thread runs and whose end comes back as [`Writer::ended`]. When the
//! file has grown, the writer writes it anew beside the old one, synchronises the new file while records go on, and renames it.
//!
//! After a failed write, synchronisation or rename the writer gives the file up: the system may report data as written that the disk never
//! gets, and a later success proves nothing. From then on the writer answers every record with [`NotPersisted`], and after each pause it tries
//! to write the whole state to a new file.

use std::io;
use std::path::Path;
use std::time::Duration;

use crate::disk::Disk;
use crate::planted::is_planted;
use crate::store::{Store, Synchronised};
use crate::{Damage, LockedFile, Record, RetainedState};

/// The change is not in the file, at least not yet.
#[derive(Clone, Copy, PartialEq, Eq, Debug, thiserror::Error)]
#[error("it could not be written to the file of the retained state")]
pub struct NotPersisted;

/// The pace of the disk's work.
#[derive(Clone, Copy, Debug)]
pub struct Pace {
    /// Time between two synchronisations, and between two attempts after a failure.
    pub pause: Duration,
    /// Growth of the file after which it is written anew, bytes; a file that is longer than that grows to the double.
    pub growth: usize,
}

impl Default for Pace {
    /// A second, and a mebibyte.
    fn default() -> Self {
        Pace {
            pause: Duration::from_secs(1),
            growth: 1024 * 1024,
        }
    }
}

/// Keeps a state in a file. `A` addresses an answer.
#[derive(Debug)]
pub struct Writer<D: Disk, A> {
    store: Store<D>,
    pace: Pace,
    waiting: Vec<(Record, A)>,
    actions: Vec<Action<A>>,
    /// Whether a task is under way.
    busy: bool,
    /// The folder is to be synchronised next.
    renamed: bool,
    /// Records were written since the newest synchronisation was begun.
    unsynchronised: bool,
    /// The file was given up, and every record is answered with [`NotPersisted`].
    failed: bool,
    /// A new table of tags was refused: places of tags in later changes are not those of the state.
    refused: bool,
    /// When to synchronise, or to try again, since the start.
    due: Duration,
}

/// The actions that the owner of a writer carries out.
#[derive(Debug)]
pub enum Action<A> {
    /// Answer whether the file has a record.
    Answer(A, Result<(), NotPersisted>),
    /// Write this to the log.
    Report(Report),
}

/// The reports to the operator.
#[derive(Debug)]
pub enum Report {
    /// From now on the file has no new records.
    Failed(Failure, io::Error),
    /// From now on the file has all records again.
    Recovered,
    /// The file could not be written anew and goes on growing.
    Grows(io::Error),
    /// A new table of tags is more than a state can hold: until there is another one, no tag is kept.
    Refused(Damage),
}

/// The operation that has failed.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Failure {
    /// A write.
    Write,
    /// A synchronisation.
    Synchronisation,
    /// The new file did not get the name of the file.
    Rename,
}

/// A synchronisation, which takes as long as the disk takes.
#[derive(Debug)]
pub struct Task<D: Disk> {
    disk: D,
    target: Target<D::File>,
}

#[derive(Debug)]
enum Target<F> {
    /// The records in the file.
    Records(F, Synchronised),
    /// The file beside, before it takes the place of the file.
    Beside(F),
    /// The folder, after that.
    Folder,
}

/// The end of a task.
#[derive(Debug)]
pub struct Ended {
    target: Target<()>,
    result: io::Result<()>,
}

impl<D: Disk> Task<D> {
    /// Synchronises the file or folder.
    pub fn run(self) -> Ended {
        let (target, result) = match self.target {
            Target::Records(file, covered) => (Target::Records((), covered), self.disk.sync(&file)),
            Target::Beside(file) => (Target::Beside(()), self.disk.sync(&file)),
            Target::Folder => (Target::Folder, self.disk.sync_folder()),
        };
        Ended { target, result }
    }
}

impl<D: Disk, A> Writer<D, A> {
    /// Begins to keep a state: writes it anew and synchronises it, as long as the disk takes. When that fails the writer
    /// reports it and tries again after each pause.
    pub fn start(locked: LockedFile<D>, state: RetainedState, pace: Pace, now: Duration) -> Self {
        let mut writer = Writer {
            store: Store::new(locked, state, pace.growth),
            pace,
            waiting: Vec::new(),
            actions: Vec::new(),
            busy: false,
            renamed: false,
            unsynchronised: false,
            failed: false,
            refused: false,
            due: now,
        };
        if let Err(error) = writer.store.rewrite() {
            writer.fail(Failure::Write, error, now);
        }
        writer
    }

    /// The file.
    pub fn path(&self) -> &Path {
        self.store.path()
    }

    /// Takes a record. The next [`Writer::turn`] writes it.
    pub fn keep(&mut self, record: Record, answer: A) {
        self.waiting.push((record, answer));
    }

    /// The number of records that the next turn writes.
    pub fn waiting(&self) -> usize {
        self.waiting.len()
    }

    /// Takes the end of a task.
    pub fn ended(&mut self, ended: Ended, now: Duration) {
        self.busy = false;
        match (ended.target, ended.result) {
            (Target::Records((), covered), Ok(())) => {
                if let Err(error) = self.store.synchronised(covered) {
                    self.fail(Failure::Write, error, now);
                }
            }
            (Target::Beside(()), Ok(())) if self.store.is_rewritten() => match self.store.finish_rewrite() {
                Ok(()) => self.renamed = !is_planted("folder not synchronised"),
                // Either file may have the name now.
                Err(error) => self.fail(Failure::Rename, error, now),
            },
            (Target::Beside(()), result) => {
                self.store.end_rewrite();
                let error = result
                    .err()
                    .unwrap_or_else(|| io::Error::other("a record could not be written to the new file"));
                self.not_rewritten(error, now);
            }
            (Target::Folder, Ok(())) if self.failed && self.store.is_writable() => {
                self.failed = false;
                self.actions.push(Action::Report(Report::Recovered));
                self.wrote(now);
            }
            // A write to the new file has failed meanwhile.
            (Target::Folder, Ok(())) if self.failed => self.due = now + self.pace.pause,
            (Target::Folder, Ok(())) => {}
            (Target::Records(..), Err(_)) if is_planted("failed synchronisation ignored") => {}
            (Target::Records(..) | Target::Folder, Err(error)) => self.fail(Failure::Synchronisation, error, now),
        }
    }

    /// Writes the waiting records, and returns the next task of the disk, if the disk is idle and a task is due.
    pub fn turn(&mut self, now: Duration) -> Option<Task<D>> {
        self.write(now);
        if self.busy {
            return None;
        }
        let target = self.next(now)?;
        self.busy = true;
        let disk = self.store.disk().clone();
        Some(Task { disk, target })
    }

    /// The actions to carry out, in order.
    pub fn actions(&mut self) -> impl Iterator<Item = Action<A>> {
        self.actions.drain(..)
    }

    /// When the next turn is due without a record, since the start; `None`: not before the next record or the end of a task.
    pub fn due(&self) -> Option<Duration> {
        (!self.busy && (self.unsynchronised || self.failed)).then_some(self.due)
    }

    /// Writes the waiting records and the state anew, and synchronises the file; the call takes as long as the disk takes.
    ///
    /// # Errors
    /// The system's.
    pub fn close(&mut self, now: Duration) -> io::Result<()> {
        self.write(now);
        let rewritten = self.store.rewrite();
        // Without room for a new file, the old one is as good.
        if rewritten.is_err()
            && let Some((file, _)) = self.store.to_synchronise()
        {
            self.store.disk().sync(&file)?;
        }
        rewritten
    }

    fn write(&mut self, now: Duration) {
        let mut records = Vec::with_capacity(self.waiting.len());
        let mut answers = Vec::with_capacity(self.waiting.len());
        if is_planted("record dropped") && self.waiting.len() > 1 {
            let (_, answer) = self.waiting.remove(0);
            self.actions.push(Action::Answer(answer, Ok(())));
        }
        for (record, answer) in std::mem::take(&mut self.waiting) {
            if self.take_over(&record) {
                records.push(record);
                answers.push(answer);
            } else {
                self.actions.push(Action::Answer(answer, Err(NotPersisted)));
            }
        }
        if records.is_empty() {
            return;
        }
        if let Err(error) = self.store.append(records.iter())
            && !self.failed
        {
            self.fail(Failure::Write, error, now);
        }
        let kept = if self.failed && !is_planted("failed write answered") {
            Err(NotPersisted)
        } else {
            self.wrote(now);
            Ok(())
        };
        let answers = answers.into_iter().map(|answer| Action::Answer(answer, kept));
        self.actions.extend(answers);
    }

    /// There is something to synchronise.
    fn wrote(&mut self, now: Duration) {
        if !std::mem::replace(&mut self.unsynchronised, true) {
            self.due = now + self.pace.pause;
        }
    }

    /// Takes a record over into the state, if it fits.
    fn take_over(&mut self, record: &Record) -> bool {
        let table = matches!(record, Record::State(_));
        if self.refused && !table && !record.is_of_axes() {
            return false;
        }
        match self.store.apply(record) {
            Ok(()) => {
                self.refused &= !table;
                true
            }
            Err(damage) => {
                if table && !std::mem::replace(&mut self.refused, true) {
                    self.actions.push(Action::Report(Report::Refused(damage)));
                }
                false
            }
        }
    }

    fn next(&mut self, now: Duration) -> Option<Target<D::File>> {
        if std::mem::take(&mut self.renamed) {
            return Some(Target::Folder);
        }
        let due = now >= self.due;
        let rewrite = if self.failed { due } else { self.store.wants_rewrite() };
        if rewrite {
            return match self.store.begin_rewrite() {
                Ok(file) => Some(Target::Beside(file)),
                Err(error) => {
                    self.store.end_rewrite();
                    self.not_rewritten(error, now);
                    None
                }
            };
        }
        if !self.unsynchronised || !due {
            return None;
        }
        self.unsynchronised = false;
        let (file, covered) = self.store.to_synchronise()?;
        if is_planted("horizon before synchronisation") {
            let _ = self.store.synchronised(covered);
        }
        Some(Target::Records(file, covered))
    }

    /// The file could not be written anew. Unless it was given up, it is still good.
    fn not_rewritten(&mut self, error: io::Error, now: Duration) {
        if self.failed {
            self.due = now + self.pace.pause;
        } else {
            self.actions.push(Action::Report(Report::Grows(error)));
        }
    }

    fn fail(&mut self, failure: Failure, error: io::Error, now: Duration) {
        self.store.give_up();
        self.due = now + self.pace.pause;
        if !std::mem::replace(&mut self.failed, true) {
            self.actions.push(Action::Report(Report::Failed(failure, error)));
        }
    }
}
