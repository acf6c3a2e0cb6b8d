//! A state and its file: appended to, written anew beside and renamed.
//!
//! Against the end of the process a record is safe when [`Store::append`] has returned: the system has it. Against the end of the system it is
//! safe when it has been synchronised; the [`Writer`](crate::Writer) decides when that happens, for it may take long.

use std::io;
use std::path::Path;

use crate::codec::MAX_RECORD;
use crate::disk::Disk;
use crate::format::{self, Chain};
use crate::{Damage, LockedFile, MAX_FILE, Record, RetainedState, horizon};

/// A state and its file, which agree except in writes that failed.
#[derive(Debug)]
pub(crate) struct Store<D: Disk> {
    locked: LockedFile<D>,
    state: RetainedState,
    /// `None` before the file is written for the first time and after a failure: nothing may stand behind half a record.
    log: Option<Log<D>>,
    /// The state written anew, until it takes the place of the file.
    beside: Option<Log<D>>,
    /// The growth after which the file is written anew, bytes; a file that is longer grows to the double.
    growth: usize,
    /// The length at which the file is written anew, bytes.
    rewrite_at: usize,
    buffer: Vec<u8>,
}

/// An open file whose last record is whole.
#[derive(Debug)]
struct Log<D: Disk> {
    file: D::File,
    length: usize,
    chain: Chain,
    /// Horizons that have been written to it.
    horizons: usize,
}

/// The length that a synchronisation will have covered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Synchronised(usize);

impl<D: Disk> Store<D> {
    pub(crate) fn new(locked: LockedFile<D>, state: RetainedState, growth: usize) -> Self {
        Store {
            locked,
            state,
            log: None,
            beside: None,
            growth,
            rewrite_at: 0,
            buffer: Vec::new(),
        }
    }

    pub(crate) fn disk(&self) -> &D {
        self.locked.disk()
    }

    pub(crate) fn path(&self) -> &Path {
        self.locked.file()
    }

    /// Takes a record over into the state. It is not written yet.
    pub(crate) fn apply(&mut self, record: &Record) -> Result<(), Damage> {
        self.state.apply(record)
    }

    /// Writes records that were applied, each whole or not at all. After a failure the file is given up, so that nothing is written behind half
    /// a record.
    pub(crate) fn append<'r>(&mut self, records: impl Iterator<Item = &'r Record> + Clone) -> io::Result<()> {
        let disk = self.locked.disk();
        // The file beside has no name yet: a failure to write it only ends it.
        if let Some(beside) = &mut self.beside
            && beside.append(disk, records.clone(), &mut self.buffer).is_err()
        {
            self.beside = None;
        }
        let log = self
            .log
            .as_mut()
            .ok_or_else(|| io::Error::other("an earlier record could not be written"))?;
        let written = log.append(disk, records, &mut self.buffer);
        if written.is_err() {
            self.log = None;
        }
        written
    }

    /// Gives the file up: nothing more is written to it until the state has been written anew.
    pub(crate) fn give_up(&mut self) {
        self.log = None;
    }

    /// Whether the file takes records.
    pub(crate) fn is_writable(&self) -> bool {
        self.log.is_some()
    }

    /// The file, and the length that its synchronisation covers; `None` after a failure.
    pub(crate) fn to_synchronise(&self) -> Option<(D::File, Synchronised)> {
        self.log
            .as_ref()
            .map(|log| (log.file.clone(), Synchronised(log.length)))
    }

    /// Notes in the file the length that is synchronised.
    pub(crate) fn synchronised(&mut self, covered: Synchronised) -> io::Result<()> {
        let disk = self.locked.disk();
        match &mut self.log {
            Some(log) => log.note(disk, covered),
            None => Ok(()),
        }
    }

    /// Whether the file has grown so much that it should be written anew.
    pub(crate) fn wants_rewrite(&self) -> bool {
        self.beside.is_none() && self.log.as_ref().is_some_and(|log| log.length >= self.rewrite_at)
    }

    /// Writes the state anew beside the file, and from now on every record to both. When the file that is returned has been synchronised,
    /// [`Store::finish_rewrite`] is next.
    pub(crate) fn begin_rewrite(&mut self) -> io::Result<D::File> {
        self.beside = None;
        if let Some(log) = &self.log {
            self.rewrite_at = log.length + self.growth;
        }
        let disk = self.locked.disk();
        let (bytes, chain) = format::fresh(&self.state);
        let file = disk.create(&self.locked.beside())?;
        disk.append(&file, &bytes)?;
        self.beside = Some(Log {
            file: file.clone(),
            length: bytes.len(),
            chain,
            horizons: 1,
        });
        Ok(file)
    }

    /// Whether the state that was written anew has every record since.
    pub(crate) fn is_rewritten(&self) -> bool {
        self.beside.is_some()
    }

    /// Drops the state that was written anew, so that a full disk has its room.
    pub(crate) fn end_rewrite(&mut self) {
        self.beside = None;
        // An empty file takes the name. Where that fails, the next rewrite does it.
        let _ = self.locked.disk().create(&self.locked.beside());
    }

    /// Puts the state that was written anew in the place of the file. The folder is to be synchronised next.
    pub(crate) fn finish_rewrite(&mut self) -> io::Result<()> {
        let beside = self.beside.take();
        let beside = beside.ok_or_else(|| io::Error::other("the new file could not be written"))?;
        self.locked.disk().rename(&self.locked.beside(), self.locked.file())?;
        self.rewrite_at = beside.length + beside.length.max(self.growth);
        self.log = Some(beside);
        Ok(())
    }

    /// Writes the state anew, synchronises it and puts it in the place of the file. As long as the disk takes.
    pub(crate) fn rewrite(&mut self) -> io::Result<()> {
        let file = self.begin_rewrite()?;
        self.disk().sync(&file)?;
        self.finish_rewrite()?;
        self.disk().sync_folder()
    }
}

impl<D: Disk> Log<D> {
    /// One write for all records.
    fn append<'r>(
        &mut self,
        disk: &D,
        records: impl Iterator<Item = &'r Record>,
        buffer: &mut Vec<u8>,
    ) -> io::Result<()> {
        buffer.clear();
        for record in records {
            let from = buffer.len();
            self.chain.push(record, buffer);
            // A reader would take it for damage.
            if buffer.len() - from > MAX_RECORD {
                return Err(io::ErrorKind::FileTooLarge.into());
            }
        }
        let length = self.length + buffer.len();
        if length > MAX_FILE {
            return Err(io::ErrorKind::FileTooLarge.into());
        }
        disk.append(&self.file, buffer)?;
        self.length = length;
        Ok(())
    }

    fn note(&mut self, disk: &D, covered: Synchronised) -> io::Result<()> {
        let at = horizon::offset(self.horizons);
        disk.overwrite(&self.file, at as u64, &horizon::page(covered.0))?;
        self.horizons += 1;
        Ok(())
    }
}
